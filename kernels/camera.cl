// Camera: the ray through a pixel, and what it meets first.
//
// Camera space: the origin is the camera, x points right, y up and -z ahead. The host moves and
// turns the scene into it before it rounds, so that float32 rounds distances from the camera and
// not from the world's origin. Lengths are scaled by a power of two, see Space of clrt/renderer/pack/arguments.py.
//
// With LONG_LENS what is seen may be far away against its size: the origin is then a point ahead of the camera, just before what is seen, and rays start on the plane through it. A
// ray from the camera knows a sphere of radius r at distance D to 2^-24 D / r, and turns its
// normals by that.
//
// With ORTHOGRAPHIC the screen is as wide as what it shows, and all rays go straight through it, from before everything. The origin is then on the camera's axis, just
// before what is seen of the spheres that are no larger than the picture.

// 76 bytes as float32, 144 as float64. The screen stands one unit ahead (ORTHOGRAPHIC: where the
// origin is).
typedef struct {
    real step[2];   // half the distance of two neighbouring pixels of a row, of a column
    real eye[3];    // where the camera stands: 0 but for LITERAL, LONG_LENS and ORTHOGRAPHIC
    int last[2];    // width - 1, height - 1, but at least 1
    real right[3];  // the camera's axes in the world, and with TREE in the scene's space
    real up[3];
    real back[3];
    real unit;       // of length here, in the world's
    real aperture;   // LENS: its radius
    real inv_focus;  // 1 / how far away what is sharp is
} Camera;

// A packet of camera rays: through (x, y, -1), x of each lane.
typedef struct {
    reals x, y;
    real left, right, bottom, top;  // of all lanes; REFINE: of the pixel
} Pixels;

// Whether a rectangle of the screen, see Sphere, shows in the packet.
static bool shows(Pixels at, __global const real *bounds) {
    return (at.right >= bounds[0]) & (at.left <= bounds[1]) & (at.top >= bounds[2]) &
           (at.bottom <= bounds[3]);
}

// Pixel (row i, column j) lies at x = linspace(-w, w, width)[j], y = linspace(h, -h, height)[i]
// (paper, section 11.1). 2 j - last is exact up to 2^24 pixels, so x and y are off by 2^-23 of
// themselves and the picture is symmetric to the last bit; linspace of one number is its start,
// here as well.
static Pixels pixels_at(__global const Camera *camera, int column, int row) {
    int first = 2 * column - camera->last[0];
    Pixels at;
    at.x = TO_REALS(2 * (LANE % ROW) + (ints)(first)) * camera->step[0];
    at.y = TO_REALS((ints)(camera->last[1] - 2 * row) - 2 * (LANE / ROW)) * camera->step[1];
    at.left = first * camera->step[0];
    at.right = (first + 2 * (ROW - 1)) * camera->step[0];
    at.top = (camera->last[1] - 2 * row) * camera->step[1];
    at.bottom = (camera->last[1] - 2 * (row + ROWS - 1)) * camera->step[1];
    if (ROWS == 1) at.y = at.top;
    return at;
}

// GATHER: pixels moved by parts of half a pixel.
static Pixels moved(Pixels at, __global const Camera *camera, real right, real up) {
    at.x += right * camera->step[0];
    at.y += up * camera->step[1];
    at.left += right * camera->step[0];
    at.right += right * camera->step[0];
    at.bottom += up * camera->step[1];
    at.top += up * camera->step[1];
    if (ROWS == 1) at.y = at.top;
    return at;
}

// REFINE: points of one pixel, parts of half a pixel from its middle.
static Pixels points_of(__global const Camera *camera, int column, int row, reals right, reals up) {
    int x = 2 * column - camera->last[0], y = camera->last[1] - 2 * row;
    Pixels at;
    at.x = (right + x) * camera->step[0];
    at.y = (up + y) * camera->step[1];
    at.left = (x - 1) * camera->step[0];
    at.right = (x + 1) * camera->step[0];
    at.bottom = (y - 1) * camera->step[1];
    at.top = (y + 1) * camera->step[1];
    return at;
}

// ORTHOGRAPHIC: where a line enters a sphere: smaller_root() of either sign.
static reals entry(Quadratic q) {
    if (LITERAL) return smaller_root(q);
    reals half_chord = sqrt(q.delta);
    return PICK(q.b < 0, q.c / (half_chord - q.b), -q.b - half_chord);
}

// ORTHOGRAPHIC: nearest() for lines that have no start. OPACITY: these are of no packet.
static Hit visible_along(Pixels at, Ray line, __global const Sphere *spheres, int sphere_count) {
    Hit hit = no_hit();
    for (int s = 0; s < sphere_count; s++) {
        if (!LITERAL && !OPACITY && !shows(at, spheres[s].screen_bounds)) continue;
        Quadratic q = quadratic(line, spheres + s);
        ints met = q.delta > 0;
        if (!ANY(met)) continue;
        reals root = entry(q);
        if (OPACITY) met &= behind(line, root, s);
        hit = closer(hit, met, root, s);
    }
    return hit;
}

// nearest() for rays from the camera. Their common origin is 0, so the direction D = (x, y, -1)
// need not be of unit length: with a = |D|^2 and b = D.C the roots are those of
// a t^2 - 2 b t + camera_c = 0, and b^2 - a camera_c = a r^2 - |D x C|^2 (Lagrange's identity),
// whose right side is Haines' form again. Spheres that cannot show in this packet are passed over.
static Hit visible(Pixels at, reals a, __global const Sphere *spheres, int sphere_count) {
    Hit hit = no_hit();
    for (int s = 0; s < sphere_count; s++) {
        __global const Sphere *sphere = spheres + s;
        // The camera is not inside it, and it can show.
        if (!((sphere->camera_c > 0) & shows(at, sphere->screen_bounds))) continue;
        real x = sphere->anchor[0], y = sphere->anchor[1], z = sphere->anchor[2];
        reals b, delta;
        if (sphere->giant) {
            x -= sphere->offset[0], y -= sphere->offset[1], z -= sphere->offset[2];
            b = at.x * x + (at.y * y - z);
            delta = b * b - a * sphere->camera_c;
        } else {
            b = at.x * x + (at.y * y - z);
            Vector l = vector(at.y * z + y, at.x * z + x, at.x * y - at.y * x);
            delta = -sphere->c0 * a - dot3(l, l);
        }
        ints candidates = (delta > 0) & (b > 0);
        if (ANY(candidates)) {
            hit = closer(hit, candidates, sphere->camera_c / (b + sqrt(delta)), s);
        }
    }
    return hit;
}

// From camera space, where x points right, y up and z back, to the world's axes.
static Vector in_world(__global const Camera *camera, reals x, reals y, reals z) {
    Vector v = scaled(splat(camera->back), z);
    v = along(v, x, splat(camera->right));
    return along(v, y, splat(camera->up));
}

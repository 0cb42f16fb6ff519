// Spheres: nearest and occluded, both from one quadratic.
//
// A ray o + t d, |d| = 1, meets the sphere |p - C| = r where t^2 + 2 b t + c = 0, with f = o - C,
// b = f.d and c = |f|^2 - r^2 (the paper, section 11.4, has 2 b). It is hit iff
// delta = b^2 - c > 0 and both roots are positive, that is b < 0 and c > 0: a sphere cannot be seen
// from inside.
//
// The host defines LITERAL for the paper's formula as it stands, in this precision: the baseline
// that the rest is measured against. It makes no sphere a giant then.

// 64 bytes as float32, one cache line; 120 as float64. Written by clrt/pack.py. Camera space, world
// units: see camera.cl.
typedef struct {
    real anchor[3];   // a giant's surface point nearest the camera; else the centre
    real c0;          // |offset|^2 - radius^2, from float64
    real offset[3];   // anchor - centre
    real camera_c;    // |centre|^2 - radius^2, from float64: c of a ray from the camera
    real view[4];     // where it can show on the screen: left, right, bottom, top
    real inv_radius;  // 1 / radius
    real horizon;     // a light with N.L below this is hidden by the sphere that N stands on
    int giant;        // 1: radius > 30 x the camera's distance from the surface
    int material;     // index
} Sphere;

typedef struct {
    Vector origin;     // camera space
    Vector direction;  // unit length
    ints leaves;       // the index of the sphere that the origin lies on. It is never hit: a ray
                       // that leaves a convex body does not come back, so no epsilon is needed.
    int all_leave;     // that index if it is the same in all lanes that count, else -1
} Ray;

typedef struct {
    reals b, c, delta;
} Quadratic;

// The split. Both branches guard against cancellation, each where the other would suffer from it:
// - |f|^2 - r^2 of a giant loses the digits of a distance to its surface that is small against r:
//   float32 leaves an error of r 2^-24 in it, 5e-4 for r = 9000. So a giant is measured from its
//   surface point A nearest the camera, with g = o - A and m = A - C: c = |g|^2 + 2 g.m + c0. What
//   is left is the rounding of g and m, which moves the surface by 2^-24 |g|.
// - b^2 - c of a small far sphere loses the digits of r^2 against |f|^2. So the others take
//   delta = r^2 - |f - (f.d) d|^2 (Haines et al., Ray Tracing Gems, 2019, chapter 7): a silhouette
//   is off by 4 * 2^-24 (r + |f|) at most, which is the rounding of f and d themselves.
static Quadratic quadratic(Ray ray, __global const Sphere *sphere) {
    Quadratic q;
    Vector g = minus(ray.origin, splat(sphere->anchor));
    q.b = dot3(g, ray.direction);
    q.c = dot3(g, g) + sphere->c0;
#ifdef LITERAL
    q.delta = q.b * q.b - q.c;
#else
    if (sphere->giant) {
        Vector m = splat(sphere->offset);
        q.b += dot3(m, ray.direction);
        q.c += 2 * dot3(g, m);
        q.delta = q.b * q.b - q.c;
    } else {
        Vector l = along(g, -q.b, ray.direction);
        q.delta = -sphere->c0 - dot3(l, l);
    }
#endif
    return q;
}

static ints ahead(Quadratic q, Ray ray, int s) {
    ints hit = (q.delta > 0) & (q.b < 0) & (q.c > 0);
#ifndef LITERAL
    hit &= ray.leaves != s;
#endif
    return hit;
}

// What nearest() and visible() find in each lane.
typedef struct {
    ints sphere;     // the index of the sphere hit first; -1: none
    reals distance;  // in units of the ray's direction
    int some;        // if any lane hits, the index of a sphere that a lane may have hit
} Hit;

static Hit no_hit(void) {
    Hit none = {-1, INFINITY, 0};
    return none;
}

// Of equal distances the first sphere of the list counts.
static Hit closer(Hit hit, ints candidates, reals distance, int s) {
    ints mask = candidates & (distance < hit.distance);
    hit.sphere = PICK_INT(mask, s, hit.sphere);
    hit.distance = PICK(mask, distance, hit.distance);
    hit.some = s;
    return hit;
}

static Hit nearest(Ray ray, __global const Sphere *spheres, int sphere_count) {
    Hit hit = no_hit();
    for (int s = 0; s < sphere_count; s++) {
        if (s == ray.all_leave) continue;
        Quadratic q = quadratic(ray, spheres + s);
        ints candidates = ahead(q, ray, s);
        if (ANY(candidates)) {  // the other lanes have NaN for a root
            // Not -b - sqrt(delta), which cancels near a surface.
            hit = closer(hit, candidates, q.c / (sqrt(q.delta) - q.b), s);
        }
    }
    return hit;
}

// Whether some sphere is hit nearer than `distance`: the smaller root, -b - sqrt(delta), is less
// than it iff e < sqrt(delta) with e = -b - distance, that is iff e |e| < delta. No root is needed.
static ints occluded(Ray ray, reals distance, __global const Sphere *spheres, int sphere_count) {
    ints hidden = 0;
    for (int s = 0; s < sphere_count; s++) {
        if (s == ray.all_leave) continue;
        Quadratic q = quadratic(ray, spheres + s);
        reals e = -q.b - distance;
        hidden |= ahead(q, ray, s) & (e * fabs(e) < q.delta);
    }
    return hidden;
}

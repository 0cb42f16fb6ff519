// Mesh: how the faces of meshes look where paths meet them, each lane its own.
//
// H. Gouraud, "Continuous Shading of Curved Surfaces", 1971: light is worked out at a face's corners and
// interpolated. B. T. Phong, "Illumination for Computer Generated Pictures", 1975: the normal is interpolated.
// Where a ray goes on, and what is lit at all, is the face's own normal's to say.

// How a face is lit, as clrt/scene/mesh.py counts its shadings.
enum { AS_IT_IS, AT_CORNERS, BETWEEN_CORNERS };

// By how much rays start off a face of a mesh that is not closed, in units of the largest coordinate of it
// and of where the ray came from: more than a hit is off the face.
#define FACE_LIFT (8 * UNIT_ROUNDOFF)

// What paths have met of meshes.
typedef struct {
    ints there;     // the lanes that have met a face
    Vector normal;  // of the face; of a mesh that is not closed towards where the ray came from
    reals lift;     // how far off it rays start
    ints turned;    // its back is seen
    ints shading;   // SMOOTH or GOURAUD
    ints token;     // PATHS
} Facing;

// FACES: how the faces with these ids stand to the rays that have met them.
static Facing facing_of(const Scene *scene, Ray ray, ints ids) {
    __private reals normals[3] = {0, 0, 0}, reaches[1] = {0};
    __private ints shadings[1] = {AS_IT_IS}, tokens[1] = {0};
    for (int i = 0; i < LANES; i++) {
        int face = EACH_INT(ids)[i] - scene->faces->first;
        if (face < 0) continue;
        __global const FaceLook *look = scene->faces->looks + face;
        for (int a = 0; a < 3; a++) EACH_REAL(normals)[a * LANES + i] = look->normal[a];
        if (!look->closed) EACH_REAL(reaches)[i] = scene->faces->each[face].reach;
        if (SMOOTH || GOURAUD) EACH_INT(shadings)[i] = look->shading;
        if (PATHS) EACH_INT(tokens)[i] = look->token;
    }
    Facing facing;
    Vector normal = vector(normals[0], normals[1], normals[2]);
    reals reach = reaches[0];
    facing.there = ids >= scene->faces->first;
    facing.turned = facing.there & (reach > 0) & (dot3(normal, ray.direction) > 0);
    facing.normal = pick3(facing.turned, scaled(normal, -1), normal);
    facing.lift = PICK(reach > 0, FACE_LIFT * larger(reach, largest_of(ray.origin)), 0);
    facing.shading = shadings[0];
    facing.token = tokens[0];
    return facing;
}

// SMOOTH or GOURAUD or CORNER_COLORS: the corners of each lane's face.
typedef struct {
    Vector point[3], normal[3], color[3];
    reals weight[3];  // how near to each corner the lane's point is; their sum is 1
} FaceCorners;

// SMOOTH or GOURAUD or CORNER_COLORS: puts one corner of one lane's face into vectors.
static void put_corner(const Scene *scene, int face, int c, int lane, __private reals *points,
                       __private reals *normals, __private reals *colors) {
    size_t vertex = scene->faces->corners[3 * (size_t)face + c];
    for (int a = 0; a < 3; a++) {
        int at = (3 * c + a) * LANES + lane;
        ((__private real *)points)[at] = scene->faces->each[face].corner[c][a];
        if (SMOOTH || GOURAUD)
            ((__private real *)normals)[at] = scene->faces->vertex_normals[3 * vertex + a];
        if (CORNER_COLORS)
            ((__private real *)colors)[at] = scene->faces->vertex_colors[3 * vertex + a];
    }
}

// SMOOTH or GOURAUD or CORNER_COLORS: twice the area, as seen along a normal, of the triangle of a point and two corners,
// which are given from it.
static reals area_of(Vector b, Vector c, Vector n) {
    return n.x * (b.y * c.z - b.z * c.y) +
           (n.y * (b.z * c.x - b.x * c.z) + n.z * (b.x * c.y - b.y * c.x));
}

// SMOOTH or GOURAUD or CORNER_COLORS: the corners of faces around points; `a` counts corners here. Weights are
// barycentric, by the areas of the triangles that the point makes with two corners. They are off by u |point| /
// (the face's size): as the point itself is.
static FaceCorners face_corners(const Scene *scene, const Facing *facing, Vector point, ints ids) {
    __private reals points[9] = {0}, normals[9] = {0}, colors[9] = {0};
    for (int i = 0; i < LANES; i++) {
        int face = EACH_INT(ids)[i] - scene->faces->first;
        if (face < 0) continue;
        for (int c = 0; c < 3; c++) put_corner(scene, face, c, i, points, normals, colors);
    }
    FaceCorners corners;
    FOR_EACH_AXIS(corners.point[a] = vector(points[3 * a], points[3 * a + 1], points[3 * a + 2]);
                  Vector n = vector(normals[3 * a], normals[3 * a + 1], normals[3 * a + 2]);
                  n = pick3(facing->turned, scaled(n, -1), n);
                  corners.normal[a] = pick3(dot3(n, n) > 0, n, facing->normal);
                  corners.color[a] = vector(colors[3 * a], colors[3 * a + 1], colors[3 * a + 2]))
    Vector p = minus(corners.point[0], point), q = minus(corners.point[1], point);
    Vector r = minus(corners.point[2], point), n = facing->normal;
    reals u = area_of(q, r, n), v = area_of(r, p, n), w = area_of(p, q, n);
    reals sign = PICK(facing->turned, -1, 1);
    u = larger(sign * u, 0), v = larger(sign * v, 0), w = larger(sign * w, 0);
    reals sum = u + v + w;
    ints some = sum > 0;
    reals whole = 1 / PICK(some, sum, 1);
    corners.weight[0] = PICK(some, u * whole, 1);
    corners.weight[1] = PICK(some, v * whole, 0);
    corners.weight[2] = PICK(some, w * whole, 0);
    return corners;
}

// SMOOTH or GOURAUD or CORNER_COLORS: what is between three vectors, by weights.
static Vector between(const Vector *of, const reals *weight) {
    return along(along(scaled(of[0], weight[0]), weight[1], of[1]), weight[2], of[2]);
}

// SMOOTH: the normals that faces are shaded with.
static Vector normal_between(const Facing *facing, const FaceCorners *corners) {
    Vector sum = between(corners->normal, corners->weight);
    ints smooth = (facing->shading == BETWEEN_CORNERS) & (dot3(sum, sum) > 0);
    return pick3(smooth, unit(sum), facing->normal);
}

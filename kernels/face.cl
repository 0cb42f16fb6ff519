// Face: triangles of meshes in the leaves of a tree, by a test that has no gaps.
//
// S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2 (2013): corners are moved to the
// ray's origin and sheared so that it points along one axis, kz, the largest of its direction. There each edge's
// function is a difference of products. DIFFERENCE_OF_PRODUCTS has the sign of the exact value, so two faces with
// a common edge never both say that a ray passes on the other side, and neither an epsilon nor float64 is needed.
//
// With f the corners from the origin a verdict is wrong only for rays within 2 u max |f| of an edge, and a hit lies within 8 u max |f|
// of the plane. Both are of the rounded corners, which are rounded once a vertex: a common edge stays common. Of a million rays of
// each of eight families none was off by more than 1.4 and 4.6, in float32 and float64 (tests/test_face_rays.py). Roundings that are all
// the worst, to one side: 6, as each coordinate of a sheared corner has one of f, three of the shear times f and its own; and 20, as
// weights are off by 3 u and the sums and quotients of the distance by 8 u.
//
// A closed mesh is seen from its front only, so a ray that leaves it meets none of its faces by rounding. Of other
// meshes rays start as much off a face as its hits are.

// What the scene's list says of a triangle. 40 bytes as float32, 80 as float64.
typedef struct {
    real corner[3][3];  // corners, their coordinates
    real reach;         // its largest coordinate; 0: of a closed mesh
} Face;

// How it looks, see mesh.cl. 24 bytes as float32, 40 as float64.
typedef struct {
    real normal[3];  // of unit length, towards where its corners are counter-clockwise
    int shading;
    int token;   // PATHS: what a path's hash has of it
    int closed;  // 1: of a closed mesh, so its reach, which is elsewhere in memory, is 0
} FaceLook;

// 16 triangles. 704 bytes as float32, 1280 as float64. One that is not there has NaN, and id -1.
typedef struct {
    real corner[3][3][WIDE];  // corners, their coordinates
    int closed[WIDE];         // -1: of a closed mesh, else 0
    int id[WIDE];             // in the scene
} FaceLeaf;

// All of a scene.
typedef struct {
    int first;  // the id of the first one: what comes before are spheres and capsules
    __global const Face *each;
    __global const FaceLook *looks;
    __global const int *corners;          // of each face three vertices
    __global const real *vertex_normals;  // SMOOTH or GOURAUD
    __global const real *vertex_colors;   // CORNER_COLORS
    Tree tree;
} FaceList;

// FACES: along which axis a ray goes most.
#define MAIN_AXIS(x, y, z) ((x) >= (y) ? ((x) >= (z) ? 0 : 2) : ((y) >= (z) ? 1 : 2))

// The axes of a shear: kz as above, the others follow it in turn.
#define NEXT_AXIS(k) ((k) == 2 ? 0 : (k) + 1)
#define LAST_AXIS(k) ((k) == 0 ? 2 : (k) - 1)

// How a ray is sheared, and where it begins.
typedef struct {
    int kx, ky, kz;
    real sx, sy, sz, ox, oy, oz;
} Shear;

// FACES: one of three numbers. Not indexed, which would keep a ray in memory.
static real one_of(const real *v, int k) { return k == 0 ? v[0] : k == 1 ? v[1] : v[2]; }

// FACES: of one ray.
static Shear shear_of(const Single *ray) {
    Shear s;
    s.kz = MAIN_AXIS(fabs(ray->d[0]), fabs(ray->d[1]), fabs(ray->d[2]));
    s.kx = NEXT_AXIS(s.kz), s.ky = LAST_AXIS(s.kz);
    s.sz = 1 / one_of(ray->d, s.kz);
    s.sx = one_of(ray->d, s.kx) * s.sz, s.sy = one_of(ray->d, s.ky) * s.sz;
    s.ox = one_of(ray->o, s.kx), s.oy = one_of(ray->o, s.ky), s.oz = one_of(ray->o, s.kz);
    return s;
}

// Rays and triangles, either of which can be the wide one. at(c, k): coordinate k of corner c; masks: the type of a mask.
// met: those that are met on the rays' lines; det: its sign times sz's is 1 for a front; FACE_DISTANCE: where.
#define FACE_TEST(type, masks, s, at)                                                \
    type az = at(0, (s).kz) - (s).oz, bz = at(1, (s).kz) - (s).oz;                   \
    type cz = at(2, (s).kz) - (s).oz;                                                \
    type ax = FMA(-(s).sx, az, at(0, (s).kx) - (s).ox);                              \
    type ay = FMA(-(s).sy, az, at(0, (s).ky) - (s).oy);                              \
    type bx = FMA(-(s).sx, bz, at(1, (s).kx) - (s).ox);                              \
    type by = FMA(-(s).sy, bz, at(1, (s).ky) - (s).oy);                              \
    type cx = FMA(-(s).sx, cz, at(2, (s).kx) - (s).ox);                              \
    type cy = FMA(-(s).sy, cz, at(2, (s).ky) - (s).oy);                              \
    DIFFERENCE_OF_PRODUCTS(type, u, cx, by, cy, bx)                                  \
    DIFFERENCE_OF_PRODUCTS(type, v, ax, cy, ay, cx)                                  \
    DIFFERENCE_OF_PRODUCTS(type, w, bx, ay, by, ax)                                  \
    masks met = ((u >= 0) & (v >= 0) & (w >= 0)) | ((u <= 0) & (v <= 0) & (w <= 0)); \
    type det = u + v + w;
// A mean of the corners' distances with weights of one sign: within their range whatever the rounding. NaN where the
// ray is in the triangle's plane: it meets the edges of the next.
#define FACE_DISTANCE(s) (FMA(u, az, FMA(v, bz, w * cz)) * (s).sz / det)

// One ray and a leaf.
#define LEAF_CORNER(c, k) corners_[3 * (c) + (k)]
#define LEAF_FACES(ray, leaf)                                                             \
    __global const wides *corners_ = (__global const wides *)(leaf)->corner;              \
    Shear shear = shear_of(ray);                                                          \
    FACE_TEST(wides, wide_ints, shear, LEAF_CORNER)                                       \
    wide_ints ids = TO_WIDE_INTS(*(__global const int16 *)(leaf)->id);                    \
    met &= (det * shear.sz > 0) | !TO_WIDE_INTS(*(__global const int16 *)(leaf)->closed); \
    met &= ids != ray->leaves;

// FACES: the triangle of a leaf that a ray meets before `distance`, if there is one.
static void nearest_face(const Tree *tree, __global const FaceLeaf *leaf, const Single *ray,
                         real *distance, INTEGER *id) {
    LEAF_FACES(ray, leaf)
    if (!wide_bits(met)) return;
    __private wides all[1] = {FACE_DISTANCE(shear)};
    met &= (all[0] > 0) & (all[0] <= distance[(HITS - 1) * LANES]);
    if (OPACITY) met &= behind_single(ray, all[0], ids);
    __private const real *at = (__private const real *)all;
    for (uint bits = wide_bits(met); bits; bits &= bits - 1) {
        int k = LOWEST_BIT(bits);
        TAKE_NEARER(tree, distance, id, at[k], leaf->id[k])
    }
}

// FACES: what a leaf's triangles take of a shadow ray beside what is taken, see taken_by_spheres().
static INTEGER taken_by_faces(const Tree *tree, __global const FaceLeaf *leaf, const Single *ray,
                              real limit, bool near, INTEGER taken) {
    LEAF_FACES(ray, leaf)
    if (!wide_bits(met)) return taken;
    wides distance = FACE_DISTANCE(shear);
    uint bits = wide_bits(met & (distance > 0) & (distance < limit));
    return taken_by_some(tree, leaf->id, bits, near, taken);
}

// FACES: the triangles of a leaf that the beam meets before `end`, as bits: where not all corners are on the other
// side of one of its planes.
static uint faces_in_beam(const Beam *beam, __global const FaceLeaf *leaf, real end) {
    __global const wides *v = (__global const wides *)leaf->corner;
    wides m0 = v[beam->m], m1 = v[3 + beam->m], m2 = v[6 + beam->m];
    wide_ints in = -1;
    for (int k = 0; k < 2; k++) {
        int a = beam->a[k];
        real lq = beam->low_q[k], hq = beam->high_q[k];
        real low = beam->low_c[k], high = beam->high_c[k];
        in &= (v[a] - lq * m0 >= low) | (v[3 + a] - lq * m1 >= low) | (v[6 + a] - lq * m2 >= low);
        in &=
            (v[a] - hq * m0 <= high) | (v[3 + a] - hq * m1 <= high) | (v[6 + a] - hq * m2 <= high);
    }
    m0 *= beam->sign, m1 *= beam->sign, m2 *= beam->sign;
    in &= (m0 >= beam->behind) | (m1 >= beam->behind) | (m2 >= beam->behind);
    return wide_bits(in & ((m0 <= end) | (m1 <= end) | (m2 <= end)));
}

// FACES: whether a beam's rays are sheared along one axis, the beam's own. Else each is traced alone, with its own: so
// both ways give the same bits.
static bool has_one_shear(const Beam *beam, Vector d, ints on) {
    reals x = absolute(d.x), y = absolute(d.y), z = absolute(d.z);
    ints axis = PICK_INT(x >= y, PICK_INT(x >= z, 0, 2), PICK_INT(y >= z, 1, 2));
    return !ANY(on & (axis != beam->m));
}

// As Shear, of a packet.
typedef struct {
    int kx, ky, kz;
    reals sx, sy, sz, ox, oy, oz;
} Shears;

// FACES: of rays that have one axis.
static Shears shears_of(Ray ray, int kz) {
    Shears s;
    s.kz = kz, s.kx = NEXT_AXIS(kz), s.ky = LAST_AXIS(kz);
    s.sz = 1 / axis_of(ray.direction, kz);
    s.sx = axis_of(ray.direction, s.kx) * s.sz, s.sy = axis_of(ray.direction, s.ky) * s.sz;
    s.ox = axis_of(ray.origin, s.kx), s.oy = axis_of(ray.origin, s.ky);
    s.oz = axis_of(ray.origin, kz);
    return s;
}

// A packet and triangle j of a leaf.
#define PACKET_CORNER(c, k) leaf->corner[c][k][j]
#define PACKET_FACE(ray, leaf, j)                 \
    FACE_TEST(reals, ints, shears, PACKET_CORNER) \
    met &= (ray).leaves != (leaf)->id[j];         \
    if ((leaf)->closed[j]) met &= det * shears.sz > 0;

// FACES: tests those triangles of a leaf. Returns whether one is nearer than what was hit before.
static bool nearer_faces(const Tree *tree, __global const FaceLeaf *leaf, uint bits,
                         const Beam *beam, Hit *hit, Ray ray, ints on) {
    bool found = false;
    Shears shears = shears_of(ray, beam->m);
    for (; bits; bits &= bits - 1) {
        int j = LOWEST_BIT(bits);
        PACKET_FACE(ray, leaf, j)
        met &= on;
        if (!ANY(met)) continue;
        reals distance = FACE_DISTANCE(shears);
        met &= distance > 0;
        if (OPACITY) {
            met &= behind(ray, distance, leaf->id[j]) & (distance <= END_OF(*hit));
            if (!ANY(met)) continue;
        }
        MEET(*hit, met, distance, leaf->id[j], tree->glass)
        found = true;
    }
    return found;
}

// FACES: tests those triangles of a leaf against shadow rays that end at `limit`, see taken_in_tree().
static Left left_by_faces(const Tree *tree, __global const FaceLeaf *leaf, uint bits,
                          const Beam *beam, Left left, Ray ray, reals limit, ints on, bool near) {
    Shears shears = shears_of(ray, beam->m);
    for (; bits; bits &= bits - 1) {
        int j = LOWEST_BIT(bits);
        PACKET_FACE(ray, leaf, j)
        met &= on;
        if (!ANY(met)) continue;
        reals distance = FACE_DISTANCE(shears);
        met &= (distance > 0) & (distance < limit);
        left = left_after(tree, left, leaf->id[j], met, near);
    }
    if (VEILED) left.clear = on & (left.veil < OPAQUE);
    return left;
}

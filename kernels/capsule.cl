// Capsules: balls that are moved along a line, in a tree of their own.
//
// A ray o + t d meets the tube of radius r around the line A + y u, |u| = 1, where with f = o - A,
// m = d x u and g = f x u, the parts of d and f across the axis turned by 90 degrees,
//   |m|^2 t^2 + 2 b t + c = 0,  b = g.m,  c = |g|^2 - r^2.
// - The discriminant is not b^2 - |m|^2 c, which loses the digits of r^2, but Lagrange's identity
//   makes it |m|^2 r^2 - (f.m)^2: that of r^2 and the squared distance of the two lines. A silhouette
//   is off by at most 5 * 2^-24 (|f| + r), f to the farther end, and a hit lies at most 8 * 2^-24
//   (|f| + r) off the surface (tests/test_capsule_rays.py, six families of a million rays).
// - m is a difference of products, each of which is nearly the other where a ray is along the axis:
//   Kahan's way has all digits of it (DIFFERENCE_OF_PRODUCTS).
// - The ray enters the capsule by the tube, or by the ball of that end which it enters the tube
//   beyond. The ball is a sphere by the same formula, so a capsule of no length (u = 0) is one to the
//   last bit.
// - Where |m| is so small that a ray stays as far from the axis as it is, it enters by the end that it
//   comes from. The square of such an m would lose digits by underflow.

// What the scene's list says of a capsule. 32 bytes as float32, 64 as float64.
typedef struct {
    real start[3];
    real radius;
    real axis[3];  // of unit length; 0 if it has no length
    real length;
} Capsule;

// 16 capsules. 576 bytes as float32, 1088 as float64. One that is not there has NaN, and id -1.
typedef struct {
    real start[3][WIDE];
    real axis[3][WIDE];
    real length[WIDE];
    real radius[WIDE];
    int id[WIDE];  // of all that is in the scene
} CapsuleLeaf;

// All of a scene.
typedef struct {
    int first;  // the id of the first one: what comes before are spheres
    __global const Capsule *each;
    Tree tree;
} CapsuleList;

// Rays and capsules, either of which can be the wide one, and which of them may meet: the lines do, or
// they are parallel.
#define CAPSULE(type, mask, ox, oy, oz, dx_, dy_, dz_, ax, ay, az, ux_, uy_, uz_, length_, \
                radius_)                                                                   \
    type fx = (ox) - (ax), fy = (oy) - (ay), fz = (oz) - (az);                             \
    type dx = dx_, dy = dy_, dz = dz_, ux = ux_, uy = uy_, uz = uz_;                       \
    type radius = radius_, length = length_;                                               \
    DIFFERENCE_OF_PRODUCTS(type, mx, dy, uz, dz, uy)                                       \
    DIFFERENCE_OF_PRODUCTS(type, my, dz, ux, dx, uz)                                       \
    DIFFERENCE_OF_PRODUCTS(type, mz, dx, uy, dy, ux)                                       \
    type m2 = FMA(mx, mx, FMA(my, my, mz * mz));                                           \
    type fm = FMA(fx, mx, FMA(fy, my, fz * mz));                                           \
    type lines = FMA(m2 * radius, radius, -(fm * fm));                                     \
    mask parallel = m2 < (real)1e-4 * UNIT_ROUNDOFF * UNIT_ROUNDOFF;                       \
    mask met = (lines > 0) | parallel;

// Of those that may meet: where, in `t`, and which do, in `met`. A ray nearly along the axis can meet the
// tube beyond an end by rounding, and pass the ball there: it meets the ball if it passes it by no more
// than that rounding, 4 u (|f| + r).
#define CAPSULE_HIT(type, mask)                                                                    \
    type gx = FMA(fy, uz, -(fz * uy)), gy = FMA(fz, ux, -(fx * uz)), gz = FMA(fx, uy, -(fy * ux)); \
    type tube_b = FMA(gx, mx, FMA(gy, my, gz * mz));                                               \
    type tube_c = FMA(-radius, radius, FMA(gx, gx, FMA(gy, gy, gz * gz)));                         \
    type fu = FMA(fx, ux, FMA(fy, uy, fz * uz)), du = FMA(dx, ux, FMA(dy, uy, dz * uz));           \
    type root = sqrt(lines);                                                                       \
    mask inwards = tube_b <= 0; /* else the other form does not cancel */                          \
    type t = (inwards ? tube_c : -(root + tube_b)) / (inwards ? root - tube_b : m2);               \
    type y = FMA(t, du, fu);                                                                       \
    mask between = !parallel & (y >= 0) & (y <= length);                                           \
    mask beyond = (parallel & (du < 0)) | (!parallel & (y > length));                              \
    type end = beyond ? length : (type)(0);                                                        \
    type hx = FMA(-end, ux, fx), hy = FMA(-end, uy, fy), hz = FMA(-end, uz, fz);                   \
    mask by_tube = met & !parallel & (tube_b < 0) & (tube_c > 0), by_ball;                         \
    {                                                                                              \
        QUADRATIC(type, hx, hy, hz, dx, dy, dz, 0, 0, 0, radius)                                   \
        type near = 8 * UNIT_ROUNDOFF * radius * (radius - b);                                     \
        mask passes = by_tube & (delta <= 0) & (delta > -near);                                    \
        delta = passes ? (type)(0) : delta;                                                        \
        by_ball = met & !between & ((delta > 0) | passes) & (b < 0) & (c > 0);                     \
        t = between ? t : FIRST_ROOT;                                                              \
    }                                                                                              \
    met = (by_tube & between) | by_ball;

// CAPSULE for one ray and a leaf.
#define LEAF_CAPSULES(ray, leaf)                                                               \
    __global const wides *of_ = (__global const wides *)(leaf)->start;                         \
    CAPSULE(wides, wide_ints, (ray)->o[0], (ray)->o[1], (ray)->o[2], (ray)->d[0], (ray)->d[1], \
            (ray)->d[2], of_[0], of_[1], of_[2], of_[3], of_[4], of_[5], of_[6], of_[7])       \
    wide_ints ids_ = TO_WIDE_INTS(*(__global const int16 *)(leaf)->id);                        \
    met &= ids_ != (ray)->leaves;

// CAPSULE for a packet and capsule k of a leaf.
#define PACKET_CAPSULE(ray, leaf, k)                                                         \
    CAPSULE(reals, ints, (ray).origin.x, (ray).origin.y, (ray).origin.z, (ray).direction.x,  \
            (ray).direction.y, (ray).direction.z, (leaf)->start[0][k], (leaf)->start[1][k],  \
            (leaf)->start[2][k], (leaf)->axis[0][k], (leaf)->axis[1][k], (leaf)->axis[2][k], \
            (leaf)->length[k], (leaf)->radius[k])                                            \
    met &= (ray).leaves != (leaf)->id[k];

// CAPSULES: the capsule of a leaf that a ray meets before `distance`, if there is one.
static void nearest_capsule(const Tree *tree, __global const CapsuleLeaf *leaf, const Single *ray,
                            real *distance, INTEGER *id) {
    LEAF_CAPSULES(ray, leaf)
    if (!wide_bits(met)) return;
    CAPSULE_HIT(wides, wide_ints)
    if (OPACITY) met &= behind_single(ray, t, ids_);
    __private wides all[1] = {t};
    __private const real *first = (__private const real *)all;
    for (uint bits = wide_bits(met); bits; bits &= bits - 1) {
        int k = LOWEST_BIT(bits);
        TAKE_NEARER(tree, distance, id, first[k], leaf->id[k])
    }
}

// CAPSULES: what a leaf's capsules take of a shadow ray beside what is taken: those that it meets before
// `limit`. near: all, if it meets one.
static INTEGER taken_by_capsules(const Tree *tree, __global const CapsuleLeaf *leaf,
                                 const Single *ray, real limit, bool near, INTEGER taken) {
    LEAF_CAPSULES(ray, leaf)
    if (!wide_bits(met)) return taken;
    CAPSULE_HIT(wides, wide_ints)
    uint bits = wide_bits(met & (t < limit));
    return taken_by_some(tree, leaf->id, bits, near, taken);
}

// CAPSULES: the capsules of a leaf that the beam meets before `end`, as bits: those that have a part on the
// inner side of each of its planes. Along a capsule the distance to a plane is linear, so one of its ends
// has the part that is farthest inside.
static uint capsules_in_beam(const Beam *beam, __global const CapsuleLeaf *leaf, real end) {
    __global const wides *of = (__global const wides *)leaf->start;
    wides length = of[6], radius = of[7];
    wides m0 = of[beam->m], m1 = m0 + length * of[3 + beam->m];
    wide_ints in = -1;
    for (int k = 0; k < 2; k++) {
        wides a0 = of[beam->a[k]], a1 = a0 + length * of[3 + beam->a[k]];
        real lq = beam->low_q[k], hq = beam->high_q[k];
        wides low0 = a0 - lq * m0, low1 = a1 - lq * m1, high0 = a0 - hq * m0, high1 = a1 - hq * m1;
        in &= (low0 > low1 ? low0 : low1) + radius * sqrt(1 + lq * lq) >= beam->low_c[k];
        in &= (high0 < high1 ? high0 : high1) - radius * sqrt(1 + hq * hq) <= beam->high_c[k];
    }
    m0 *= beam->sign, m1 *= beam->sign;
    wides last = m0 > m1 ? m0 : m1, first = m0 < m1 ? m0 : m1;
    return wide_bits(in & (last + radius >= beam->behind) & (first - radius <= end));
}

// CAPSULES: tests those capsules of a leaf. Returns whether one is nearer than what was hit before.
static bool nearer_capsules(const Tree *tree, __global const CapsuleLeaf *leaf, uint bits, Hit *hit,
                            Ray ray, ints on) {
    bool found = false;
    for (; bits; bits &= bits - 1) {
        int k = LOWEST_BIT(bits);
        PACKET_CAPSULE(ray, leaf, k)
        met &= on;
        if (!ANY(met)) continue;
        CAPSULE_HIT(reals, ints)
        if (OPACITY) {
            met &= behind(ray, t, leaf->id[k]) & (t <= END_OF(*hit));
            if (!ANY(met)) continue;
        }
        MEET(*hit, met, t, leaf->id[k], tree->glass)
        found = true;
    }
    return found;
}

// CAPSULES: tests those capsules of a leaf against shadow rays that end at `distance`, see
// left_by_spheres().
static Left left_by_capsules(const Tree *tree, __global const CapsuleLeaf *leaf, uint bits,
                             Left left, Ray ray, reals distance, ints on, bool near) {
    for (; bits; bits &= bits - 1) {
        int k = LOWEST_BIT(bits);
        PACKET_CAPSULE(ray, leaf, k)
        met &= on;
        if (!ANY(met)) continue;
        CAPSULE_HIT(reals, ints)
        met &= t < distance;
        left = left_after(tree, left, leaf->id[k], met, near);
    }
    if (VEILED) left.clear = on & (left.veil < OPAQUE);
    return left;
}

// CAPSULES: puts the point of a capsule's axis that is nearest to where a lane has hit it, and its
// radius, where put_bead() puts a sphere's.
static void put_capsule(__private reals *own, int lane, __global const Capsule *capsule,
                        const Vector *at) {
    __private real *each = (__private real *)own;
    __private const real *point = (__private const real *)at;
    real y = 0;
    for (int a = 0; a < 3; a++)
        y = FMA(point[a * LANES + lane] - capsule->start[a], capsule->axis[a], y);
    y = y > 0 ? y : 0;
    y = y < capsule->length ? y : capsule->length;
    for (int a = 0; a < 3; a++)
        each[a * LANES + lane] = FMA(y, capsule->axis[a], capsule->start[a]);
    each[3 * LANES + lane] = capsule->radius;
}

// Tree: many spheres, in boxes of boxes (a bounding volume hierarchy): how it is laid out, and how one
// goes down it. Capsules and faces have trees of their own of the same shape.
//
// A tree over the list of all spheres, 16 children a node, 16 spheres a leaf. It is complete, so
// that no pointer is stored: nodes are numbered level by level from the root, then leaves. It is
// built and fitted by build.cl. Spheres that it cannot hold, giants and those that a light is inside
// of, stand in a list of Sphere (sphere.cl) beside it, which is tested first (beads.cl).
//
// A packet is traced as a beam, four planes around its rays (beam.cl), for as long as that pays, and
// then ray by ray, 16 boxes or spheres at a time (single.cl); walk.cl does both. Every way gives the
// same bits: a sphere is tested by one formula with explicit fma, and of equal distances the first
// sphere of the list counts.
//
// Space: world axes, the origin at the camera (LONG_LENS: at a point ahead of it), scaled so that
// the spheres reach about 1. So the order of a tree holds for every camera.

#define WIDE 16
typedef JOIN(FLOATING, WIDE) wides;  // a number of each child, or of each sphere of a leaf
typedef JOIN(INTEGER, WIDE) wide_ints;
#if DOUBLE
#define TO_WIDE_INTS(n) convert_long16(n)
#else
#define TO_WIDE_INTS(n) (n)
#endif

// The boxes of 16 children, low and high. 384 bytes as float32, 768 as float64. A child that is not
// there has lo = INFINITY, hi = -INFINITY.
typedef struct {
    real lo[3][WIDE];
    real hi[3][WIDE];
} Node;

// 16 spheres. 320 bytes as float32, 576 as float64. One that is not there has NaN, and id -1.
typedef struct {
    real center[3][WIDE];
    real radius[WIDE];
    int id[WIDE];  // in the scene's list
} Leaf;

// What the scene's list says of a sphere. 16 bytes as float32, 32 as float64. In the list beside the
// tree: radius NaN.
typedef struct {
    real center[3];
    real radius;
} Bead;

// The shape of a complete tree, from clrt/opencl/tree.py. Node e has the children 16 e + inner, and
// from node `lowest` on the leaves per_node e + outer.
typedef struct {
    int node_count, lowest, per_node, inner, outer;
    real wide;   // a packet as wide as this, or wider, is traced ray by ray
    int budget;  // boxes and spheres that a beam may test before it is given up
} Shape;

// What stands in a tree's leaves. Each kind has a leaf of its own, and in a scene a tree of its own.
// Functions are given it as a constant, so that the compiler makes a walk for each.
enum { OF_SPHERES, OF_CAPSULES, OF_FACES };

// What the functions of a tree are given of it.
typedef struct {
    __global const Node *nodes;
    __global const void *leaves;  // of its kind
    Shape shape;
    __global const Glass *glass;  // VEILED: of each thing of the scene
} Tree;

#if DOUBLE
#define UNIT_ROUNDOFF 1.1102230246251565e-16
#else
#define UNIT_ROUNDOFF 5.9604645e-8f
#endif
// By how much a box, a plane or a limit is widened, in units of the largest coordinate of the rays'
// origins and the spheres, so that none hides a sphere from the test that would find it. The test
// accepts rays up to 4 u (|o - C| + r) < 14 u outside a sphere, the sides of a box are rounded by u,
// a slab's arithmetic errs by 4 u, a beam's plane by 2 u (1 + |q|), a shadow ray and the beam from
// the light differ by 4 u: 23 u in all.
#define SLACK (32 * UNIT_ROUNDOFF)
#define STACK 128  // 15 for each level of nodes, and there are at most 8: 2^36 spheres

// Explicit where the device has it, lest each way to trace contracts its own sums; without it none
// is contracted.
#if defined(__FMA__) || defined(FP_FAST_FMAF) || defined(__FMA4__)
#define HAS_FMA
#define FMA(a, b, c) fma(a, b, c)
#else
#define FMA(a, b, c) ((a) * (b) + (c))
#endif

// x = a b - c d, off by 3 u of itself at most, however near the products are (Kahan; Jeannerod, Louvet
// and Muller, "Further analysis of Kahan's algorithm", 2013, have 1.5). Where there is no fma each
// product is split into halves, whose products are exact (Dekker, "A floating-point technique", 1971).
#ifdef HAS_FMA
#define DIFFERENCE_OF_PRODUCTS(type, x, a, b, c, d) \
    type x;                                         \
    {                                               \
        type p_ = (c) * (d);                        \
        type e_ = FMA(-(c), d, p_);                 \
        x = FMA(a, b, -p_) + e_;                    \
    }
#else
#define HALVES_OF(type, high, low, a)                             \
    type low = (a) * (DOUBLE ? REAL(134217729.0) : REAL(4097.0)); \
    type high = low - (low - (a));                                \
    low = (a) - high;
#define PRODUCT_OF(type, p, e, a, b) \
    type p = (a) * (b), e;           \
    {                                \
        HALVES_OF(type, ah_, al_, a) \
        HALVES_OF(type, bh_, bl_, b) \
        e = ah_ * bh_ - p;           \
        e += ah_ * bl_;              \
        e += al_ * bh_;              \
        e += al_ * bl_;              \
    }
#define DIFFERENCE_OF_PRODUCTS(type, x, a, b, c, d) \
    type x;                                         \
    {                                               \
        PRODUCT_OF(type, p_, pe_, a, b)             \
        PRODUCT_OF(type, q_, qe_, c, d)             \
        x = p_ - q_;                                \
        x += pe_ - qe_;                             \
    }
#endif

// TREE: the rays that can meet the near side of sphere s: not of one that they leave or are inside of.
static ints near_side(Ray ray, int s) { return (ray.leaves != s) & !is_inside(ray, s); }

// Rays and spheres, either of which can be the wide one: f = o - C, l is the part of f across d.
// Hit iff delta > 0, b < 0, c > 0, as in sphere.cl.
#define QUADRATIC(type, ox, oy, oz, dx, dy, dz, cx, cy, cz, radius)        \
    type fx = (ox) - (cx), fy = (oy) - (cy), fz = (oz) - (cz);             \
    type b = FMA(fx, dx, FMA(fy, dy, fz * (dz)));                          \
    type lx = FMA(-b, dx, fx), ly = FMA(-b, dy, fy), lz = FMA(-b, dz, fz); \
    type r_ = radius;                                                      \
    type delta = FMA(r_, r_, -FMA(lx, lx, FMA(ly, ly, lz * lz)));          \
    type c = FMA(-r_, r_, FMA(fx, fx, FMA(fy, fy, fz * fz)));

// TREE: the largest coordinate of a vector.
static reals largest_of(Vector v) {
    return larger(absolute(v.x), larger(absolute(v.y), absolute(v.z)));
}

// The least and the greatest number of those lanes.
#define LEAST(on, v) JOIN(least, LANES)(PICK(on, v, INFINITY))
#define MOST(on, v) JOIN(most, LANES)(PICK(on, v, -INFINITY))

#if defined(__AVX512DQ__) && __has_builtin(__builtin_ia32_cvtd2mask512)
// TREE: a mask's elements as bits.
static uint wide_bits(wide_ints mask) {
    return (ushort)__builtin_ia32_cvtd2mask512(convert_int16(mask));
}
#elif defined(REDUCES)
// TREE: a mask's elements as bits.
static uint wide_bits(wide_ints mask) {
    return __builtin_reduce_or(convert_int16(mask) & (int16)(BITS_16));
}
#else
// TREE: a mask's elements as bits, joined by halves.
static uint wide_bits(wide_ints mask) {
    int16 m = convert_int16(mask) & (int16)(BITS_16);
    int8 a = m.lo | m.hi;
    int4 b = a.lo | a.hi;
    int2 c = b.lo | b.hi;
    return c.x | c.y;
}
#endif

#if LANES == 16
// TREE: a mask's lanes as bits.
static uint lane_bits(ints mask) { return wide_bits(mask); }
#else
// TREE: a mask's lanes as bits.
static uint lane_bits(ints mask) {
    __private const INTEGER *each = EACH_INT(mask);
    uint bits = 0;
    for (int i = 0; i < LANES; i++) bits |= (uint)(each[i] != 0) << i;
    return bits;
}
#endif

#if __has_builtin(__builtin_ctz) && !defined(PYOPENCL_USING_OCLGRIND)
#define LOWEST_BIT(bits) __builtin_ctz(bits)
#else
// Oclgrind has no such instruction, but OpenCL's functions.
#define LOWEST_BIT(bits) ((int)popcount(~(bits) & ((bits) - 1)))
#endif

// TREE: thing `id` of the scene where it is met nearer than what was hit before. Of equal distances
// the smaller id counts: spheres are before capsules, these before faces.
static Hit closer_of(Hit hit, ints met, reals distance, ints id) {
    ints mask = met & ((distance < hit.distance) | ((distance == hit.distance) & (id < hit.id)));
    hit.distance = PICK(mask, distance, hit.distance);
    hit.id = PICK_INT(mask, id, hit.id);
    return hit;
}

// TREE: how many things a walk finds.
#define HITS (OPACITY ? LATER + 1 : 1)

// The distance from which on nothing is looked for.
#define END_OF(hit) (OPACITY ? (hit).later[0].distance[LATER - 1] : (hit).distance)

// OPACITY and TREE: in those lanes nothing is seen behind that distance.
static Hit hidden_behind(Hit hit, ints mask, reals distance) {
    Later *later = hit.later;
    FOR_EACH_LATER(ints hidden = mask & (later->distance[a] > distance);
                   later->distance[a] = PICK(hidden, distance, later->distance[a]);
                   later->id[a] = PICK_INT(hidden, NO_MORE, later->id[a]))
    return hit;
}

// OPACITY and TREE: the nearer of two things takes the first place, in lanes of a mask.
static void order_two(reals *first, ints *first_id, reals *second, ints *second_id, ints mask) {
    reals distance = *first;
    ints id = *first_id;
    mask &= (*second < distance) | ((*second == distance) & (*second_id < id));
    *first = PICK(mask, *second, distance);
    *first_id = PICK_INT(mask, *second_id, id);
    *second = PICK(mask, distance, *second);
    *second_id = PICK_INT(mask, id, *second_id);
}

// OPACITY and TREE: thing `id` of a scene where it is met nearer than what was hit before, or than what is
// behind that.
static Hit placed(Hit hit, ints met, reals distance, int id, __global const Glass *glass) {
    reals further = distance;
    ints further_id = id;
    order_two(&hit.distance, &hit.id, &further, &further_id, met);
    FOR_EACH_LATER(
        order_two(hit.later[0].distance + a, hit.later[0].id + a, &further, &further_id, met))
    return OPACITY_OF(glass[id]) < 1 ? hit : hidden_behind(hit, met, distance);
}

// Thing `id` where it is met nearer than what was hit before.
#define MEET(hit, met, distance, id, glass)          \
    if (OPACITY) {                                   \
        hit = placed(hit, met, distance, id, glass); \
    } else {                                         \
        hit = closer_of(hit, met, distance, id);     \
    }

// TREE: child k of node e: a node, or from node_count on a leaf.
static int child_of(const Shape *shape, int e, int k) {
    if (e >= shape->lowest) return shape->per_node * e + shape->outer + k;
    return 16 * e + (e > 0 ? shape->inner : 1) + k;
}

// TREE: goes on with the child of node e that begins first, and leaves the others on the stack, the
// first on top. bits: the children that are met, at least one.
static int descend(const Shape *shape, int e, uint bits, wides begins, int *stack, real *starts,
                   int *top) {
    if (!(bits & (bits - 1))) return child_of(shape, e, LOWEST_BIT(bits));
    __private wides all[1] = {begins};
    __private const real *begin = (__private const real *)all;
    int base = *top, count = base;
    for (; bits; bits &= bits - 1) {
        int k = LOWEST_BIT(bits), j = count++;
        real start = begin[k];
        for (; j > base && starts[j - 1] < start; j--) {
            starts[j] = starts[j - 1];
            stack[j] = stack[j - 1];
        }
        starts[j] = start;
        stack[j] = child_of(shape, e, k);
    }
    *top = count - 1;
    return stack[count - 1];
}

// TREE: as descend(), for a ray that any hit ends: in no order.
static int descend_anyhow(const Shape *shape, int e, uint bits, int *stack, int *top) {
    for (; bits & (bits - 1); bits &= bits - 1) {
        stack[*top] = child_of(shape, e, LOWEST_BIT(bits));
        *top += 1;
    }
    return child_of(shape, e, LOWEST_BIT(bits));
}

// TREE: the next of the stack that begins before `end`; -1 if there is none.
static int next_of(const int *stack, const real *starts, int *top, real end) {
    while (*top > 0) {
        *top -= 1;
        if (starts[*top] <= end) return stack[*top];
    }
    return -1;
}

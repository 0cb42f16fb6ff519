// Tree: many spheres, in boxes of boxes. The host defines TREE where a scene has enough of them.
//
// A tree over the list of all spheres, 16 children a node, 16 spheres a leaf. It is complete, so
// that no pointer is stored: nodes are numbered level by level from the root, then leaves. It is
// built and fitted by build.cl. Spheres that it cannot hold, giants and those that a light is inside
// of, stand in a list of Sphere (sphere.cl) beside it, which is tested first.
//
// A packet is traced as a beam, four planes around its rays, for as long as that pays, and then ray
// by ray, 16 boxes or spheres at a time. Every way gives the same bits: a sphere is tested by one
// formula with explicit fma, and of equal distances the first sphere of the list counts.
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

typedef struct {
    __global const Node *nodes;
    __global const Leaf *leaves;
    Shape shape;
    __global const Glass *glass;  // NEST: of each sphere
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
#define FMA(a, b, c) fma(a, b, c)
#else
#define FMA(a, b, c) ((a) * (b) + (c))
#endif

// Of a sphere that a ray leaves, or is inside of (NEST), it does not meet the near side.
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

static reals largest_of(Vector v) {
    return larger(absolute(v.x), larger(absolute(v.y), absolute(v.z)));
}

// The least and the greatest number of those lanes.
#define LEAST(on, v) JOIN(least, LANES)(PICK(on, v, INFINITY))
#define MOST(on, v) JOIN(most, LANES)(PICK(on, v, -INFINITY))

// A mask's lanes as bits.
static uint wide_bits(wide_ints mask) {
    int16 m = convert_int16(mask);
#if defined(__AVX512DQ__) && __has_builtin(__builtin_ia32_cvtd2mask512)
    return (ushort)__builtin_ia32_cvtd2mask512(m);
#else
    m &= (int16)(1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768);
#ifdef REDUCES
    return __builtin_reduce_or(m);
#else
    int8 a = m.lo | m.hi;
    int4 b = a.lo | a.hi;
    int2 d = b.lo | b.hi;
    return d.x | d.y;
#endif
#endif
}
static uint lane_bits(ints mask) {
#if LANES == 16
    return wide_bits(mask);
#else
    __private ints all[1] = {mask};
    __private const INTEGER *each = (__private const INTEGER *)all;
    uint bits = 0;
    for (int i = 0; i < LANES; i++) bits |= (uint)(each[i] != 0) << i;
    return bits;
#endif
}
#if __has_builtin(__builtin_ctz)
#define LOWEST_BIT(bits) __builtin_ctz(bits)
#else
#define LOWEST_BIT(bits) (31 - (int)clz((bits) & -(bits)))
#endif

static Hit closer_of(Hit hit, ints met, reals distance, ints id) {
    ints mask =
        met & ((distance < hit.distance) | ((distance == hit.distance) & (id < hit.sphere)));
    hit.distance = PICK(mask, distance, hit.distance);
    hit.sphere = PICK_INT(mask, id, hit.sphere);
    return hit;
}

// The list beside the tree: `ids` has the place of each in the scene's list.
static Hit nearest_listed(Ray ray, ints on, __global const Sphere *spheres, __global const int *ids,
                          int sphere_count) {
    Hit hit = no_hit();
    for (int s = 0; s < sphere_count; s++) {
        Quadratic q = quadratic(ray, spheres + s);
        ints met = on & ahead(q, ray, ids[s]);
        if (ANY(met)) hit = closer_of(hit, met, smaller_root(q), ids[s]);
    }
    return hit;
}

// For lines that have no start. Those to the tree have one: it has no sphere that they meet before.
static Hit visible_listed(Ray line, __global const Sphere *spheres, __global const int *ids,
                          int sphere_count) {
    Hit hit = no_hit();
    for (int s = 0; s < sphere_count; s++) {
        Quadratic q = quadratic(line, spheres + s);
        ints met = q.delta > 0;
        if (ANY(met)) hit = closer_of(hit, met, entry(q), ids[s]);
    }
    return hit;
}

static ints occluded_by_listed(Ray ray, reals distance, __global const uchar *encloses,
                               __global const Sphere *spheres, __global const int *ids,
                               __global const Glass *glass, int sphere_count) {
    ints hidden = 0;
    for (int s = 0; s < sphere_count; s++) {
        Quadratic q = quadratic(ray, spheres + s);
        ints met = ahead(q, ray, ids[s]);
        if (!encloses[s]) met &= -q.b < distance;
        hidden = taken_with(hidden, met, NEST ? glass[ids[s]].veil : 0);
    }
    return hidden;
}

// As far_sides(), of all spheres of a scene with a tree.
static Hit far_sides_of_beads(Hit hit, Ray ray, __global const Bead *beads,
                              __global const Sphere *spheres, __global const int *ids,
                              int sphere_count) {
    for (int i = 0; i < NEST; i++) {
        ints sphere = ray.inside.sphere[i] - 1;
        if (!ANY(sphere >= 0)) break;
        __private ints numbers[1] = {sphere};
        __private const INTEGER *number = (__private const INTEGER *)numbers;
        __private reals gathered[4] = {0, 0, 0, NAN};
        __private real *each = (__private real *)gathered;
        for (int lane = 0; lane < LANES; lane++) {
            if (number[lane] < 0) continue;
            __global const Bead *bead = beads + number[lane];
            each[lane] = bead->center[0], each[LANES + lane] = bead->center[1];
            each[2 * LANES + lane] = bead->center[2], each[3 * LANES + lane] = bead->radius;
        }
        QUADRATIC(reals, ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x, ray.direction.y,
                  ray.direction.z, gathered[0], gathered[1], gathered[2], gathered[3])
        Quadratic q = {b, c, delta};
        // Of those in the list beside the tree the radius is NaN.
        ints in = (sphere >= 0) & (gathered[3] > 0);
        hit = closer_of(hit, in, way_out(q, ray.leaves == sphere), sphere);
    }
    for (int s = 0; s < sphere_count; s++) {
        ints in = is_inside(ray, ids[s]);
        if (!ANY(in)) continue;
        Quadratic q = quadratic(ray, spheres + s);
        hit = closer_of(hit, in, way_out(q, ray.leaves == ids[s]), ids[s]);
    }
    return hit;
}

// What the packet's lanes have hit, each a bead of its own. shading.cl says what a Surface is.
static Surface surface_of_bead(Vector point, ints hit, __global const Bead *beads,
                               __global const int *materials_of, __global const Material *materials,
                               __global const Glass *glass, real shadow_bias, ints *material) {
    __private ints hits[1] = {hit}, found[1] = {-1};
    __private const INTEGER *sphere = (__private const INTEGER *)hits;
    __private INTEGER *index = (__private INTEGER *)found;
    __private reals gathered[4] = {0, 0, 0, 1};
    __private real *each = (__private real *)gathered;
    __private reals exponents[1] = {0}, reflections[1] = {0};
    __private reals transmissions[1] = {0}, iors[1] = {1}, fresnels[1] = {0};
    __private ints orders[1] = {0};
    __private reals spreads[1] = {0}, diffuses[3] = {0, 0, 0};
    for (int i = 0; i < LANES; i++) {
        if (sphere[i] < 0) continue;
        __global const Bead *bead = beads + sphere[i];
        each[i] = bead->center[0], each[LANES + i] = bead->center[1];
        each[2 * LANES + i] = bead->center[2], each[3 * LANES + i] = bead->radius;
        index[i] = materials_of[sphere[i]];
        ((__private real *)exponents)[i] = materials[index[i]].exponent;
        ((__private real *)reflections)[i] = materials[index[i]].reflection;
        if (NEST) {
            ((__private real *)transmissions)[i] = materials[index[i]].transmission;
            ((__private real *)iors)[i] = materials[index[i]].ior;
            ((__private real *)fresnels)[i] = materials[index[i]].fresnel;
            ((__private INTEGER *)orders)[i] = glass[sphere[i]].order;
        }
        if (GLOSS) ((__private real *)spreads)[i] = materials[index[i]].spread;
        for (int a = 0; INDIRECT && a < 3; a++)
            ((__private real *)diffuses)[a * LANES + i] = materials[index[i]].diffuse[a];
    }
    *material = found[0];
    reals radius = gathered[3];
    Vector normal = minus(point, vector(gathered[0], gathered[1], gathered[2]));
    Surface surface = {scaled(normal, 1 / radius), 0, exponents[0], reflections[0]};
    surface.transmission = transmissions[0];
    surface.ior = iors[0];
    surface.fresnel = fresnels[0];
    surface.order = orders[0];
    surface.spread = spreads[0];
    surface.diffuse = vector(diffuses[0], diffuses[1], diffuses[2]);
    // As clrt/pack.py works it out for a Sphere.
    if (shadow_bias > 0)
        surface.horizon = -sqrt(shadow_bias * (2 * radius + shadow_bias)) / (radius + shadow_bias);
    return surface;
}

static int child_of(Shape shape, int e, int k) {
    if (e >= shape.lowest) return shape.per_node * e + shape.outer + k;
    return 16 * e + (e > 0 ? shape.inner : 1) + k;
}

#ifdef BRUTE  // for tests: all spheres, one after the other
static int leaves_of(Shape shape) { return (shape.node_count - shape.lowest) * shape.per_node; }
#endif

#if LANES > 1

// The beam: along the axis `m` with `sign` all its rays go forward; four planes p_a - q p_m >= c or
// <= c hold them, two for each of the axes a[0] and a[1].
typedef struct {
    int m, a[2];
    real sign, low_q[2], high_q[2], low_c[2], high_c[2], behind, width;
} Beam;

static reals axis_of(Vector v, int m) { return m == 0 ? v.x : m == 1 ? v.y : v.z; }

// The beam around those rays that are on; `width` is INFINITY if they have no axis in common.
// common: they have one origin, which is more exact and quicker.
static Beam beam_of(Vector o, Vector d, ints on, real slack, bool common) {
    Beam beam;
    __private reals all[3] = {d.x, d.y, d.z};
    __private const real *each = (__private const real *)all;
    int first = LOWEST_BIT(lane_bits(on));
    real x = each[first], y = each[LANES + first], z = each[2 * LANES + first];
    beam.m = fabs(x) > fabs(y) ? (fabs(x) > fabs(z) ? 0 : 2) : (fabs(y) > fabs(z) ? 1 : 2);
    beam.sign = (beam.m == 0 ? x : beam.m == 1 ? y : z) > 0 ? 1 : -1;
    beam.a[0] = beam.m == 0 ? 1 : 0;
    beam.a[1] = beam.m == 2 ? 1 : 2;
    beam.width = INFINITY;
    reals dm = axis_of(d, beam.m), om = axis_of(o, beam.m);
    if (ANY(on & !(dm * beam.sign > REAL(0.05)))) return beam;
    reals inverse = 1 / dm;
    beam.width = 1;
    for (int k = 0; k < 2; k++) {
        reals slope = axis_of(d, beam.a[k]) * inverse, oa = axis_of(o, beam.a[k]);
        real low = LEAST(on, slope), high = MOST(on, slope);
        beam.width *= high - low;
        low -= 16 * UNIT_ROUNDOFF * (1 + fabs(low));
        high += 16 * UNIT_ROUNDOFF * (1 + fabs(high));
        // Backwards along m the order turns.
        real lq = beam.sign > 0 ? low : high, hq = beam.sign > 0 ? high : low;
        real lc, hc;
        if (common) {
            __private reals origins[2] = {oa, om};
            __private const real *origin = (__private const real *)origins;
            lc = origin[first] - lq * origin[LANES + first];
            hc = origin[first] - hq * origin[LANES + first];
        } else {
            lc = LEAST(on, oa - lq * om);
            hc = MOST(on, oa - hq * om);
        }
        beam.low_q[k] = lq;
        beam.high_q[k] = hq;
        beam.low_c[k] = lc - slack * (1 + fabs(lq));
        beam.high_c[k] = hc + slack * (1 + fabs(hq));
    }
    beam.behind = LEAST(on, om * beam.sign) - slack;
    return beam;
}

// How far along the beam's axis the rays that are on have come at distance t.
static real beam_end(Beam beam, Vector o, Vector d, reals t, ints on, real slack) {
    return MOST(on, (axis_of(o, beam.m) + t * axis_of(d, beam.m)) * beam.sign) + 2 * slack;
}

// Which boxes the beam meets before `end`, as bits, and where along it they begin.
static uint boxes_in_beam(Beam beam, __global const Node *node, real end, wides *begins) {
    __global const wides *lo = (__global const wides *)node->lo;
    __global const wides *hi = (__global const wides *)node->hi;
    wide_ints in = -1;
    for (int k = 0; k < 2; k++) {
        int a = beam.a[k];
        real lq = beam.low_q[k], hq = beam.high_q[k];
        in &= hi[a] - lq * (lq > 0 ? lo : hi)[beam.m] >= beam.low_c[k];
        in &= lo[a] - hq * (hq > 0 ? hi : lo)[beam.m] <= beam.high_c[k];
    }
    wides from = (beam.sign > 0 ? lo : hi)[beam.m] * beam.sign;
    wides to = (beam.sign > 0 ? hi : lo)[beam.m] * beam.sign;
    *begins = from;
    return wide_bits(in & (to >= beam.behind) & (from <= end));
}

static uint spheres_in_beam(Beam beam, __global const Leaf *leaf, real end) {
    __global const wides *center = (__global const wides *)leaf->center;
    wides radius = *(__global const wides *)leaf->radius, along_m = center[beam.m];
    wide_ints in = -1;
    for (int k = 0; k < 2; k++) {
        wides across = center[beam.a[k]];
        real lq = beam.low_q[k], hq = beam.high_q[k];
        in &= across - lq * along_m + radius * sqrt(1 + lq * lq) >= beam.low_c[k];
        in &= across - hq * along_m - radius * sqrt(1 + hq * hq) <= beam.high_c[k];
    }
    along_m *= beam.sign;
    return wide_bits(in & (along_m + radius >= beam.behind) & (along_m - radius <= end));
}

#endif

// Goes on with the child of node e that begins first, and leaves the others on the stack, the first
// on top. bits: the children that are met, at least one.
static int descend(Shape shape, int e, uint bits, wides begins, int *stack, real *starts,
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

// As descend(), for a ray that any hit ends: in no order.
static int descend_anyhow(Shape shape, int e, uint bits, int *stack, int *top) {
    for (; bits & (bits - 1); bits &= bits - 1) {
        stack[*top] = child_of(shape, e, LOWEST_BIT(bits));
        *top += 1;
    }
    return child_of(shape, e, LOWEST_BIT(bits));
}

// The next of the stack that begins before `end`; -1 if there is none.
static int next_of(const int *stack, const real *starts, int *top, real end) {
    while (*top > 0) {
        *top -= 1;
        if (starts[*top] <= end) return stack[*top];
    }
    return -1;
}

// One ray against 16 boxes or spheres at a time.
typedef struct {
    real o[3], d[3];
    INTEGER leaves;
    INTEGER inside[MAX_INSIDE];  // index + 1
} Single;

static wide_ints near_sides(Single ray, wide_ints ids) {
    wide_ints near = ids != ray.leaves;
    for (int i = 0; i < NEST; i++) near &= ids + 1 != ray.inside[i];
    return near;
}

// The planes of a box that a ray enters by and leaves by; a box begins at the largest
// plane * inverse + enter of the three axes.
typedef struct {
    real inverse[3], enter[3], leave[3];
    bool forward[3];
} Slabs;

static Slabs slabs_of(Single ray) {
    real largest = 1;
    for (int a = 0; a < 3; a++) largest = fmax(largest, fabs(ray.o[a]));
    Slabs slabs;
    for (int a = 0; a < 3; a++) {
        real d = fabs(ray.d[a]) > REAL(1e-18) ? ray.d[a] : REAL(1e-18);
        slabs.inverse[a] = 1 / d;
        slabs.forward[a] = d > 0;
        real at = -ray.o[a] * slabs.inverse[a], slack = SLACK * largest * fabs(slabs.inverse[a]);
        slabs.enter[a] = at - slack;
        slabs.leave[a] = at + slack;
    }
    return slabs;
}

static uint boxes_on_ray(Slabs slabs, __global const Node *node, real end, wides *begins) {
    __global const wides *lo = (__global const wides *)node->lo;
    __global const wides *hi = (__global const wides *)node->hi;
    wides from = 0, to = end;
    for (int a = 0; a < 3; a++) {
        wides enter = (slabs.forward[a] ? lo : hi)[a] * slabs.inverse[a] + slabs.enter[a];
        wides leave = (slabs.forward[a] ? hi : lo)[a] * slabs.inverse[a] + slabs.leave[a];
        from = enter > from ? enter : from;
        to = leave < to ? leave : to;
    }
    *begins = from;
    // The ends are rounded in proportion to themselves.
    return wide_bits(from <= to * (1 + 16 * UNIT_ROUNDOFF));
}

#define FIRST_ROOT (c / (sqrt(delta) - b))

#define LEAF_QUADRATIC(ray, leaf)                                                            \
    __global const wides *center_ = (__global const wides *)(leaf)->center;                  \
    QUADRATIC(wides, (ray).o[0], (ray).o[1], (ray).o[2], (ray).d[0], (ray).d[1], (ray).d[2], \
              center_[0], center_[1], center_[2], *(__global const wides *)(leaf)->radius)   \
    int16 id_ = *(__global const int16 *)(leaf)->id;                                         \
    wide_ints met = (delta > 0) & (b < 0) & (c > 0) & near_sides(ray, TO_WIDE_INTS(id_));

static void nearest_single(Tree tree, Single ray, real *distance, INTEGER *sphere) {
    Slabs slabs = slabs_of(ray);
    int stack[STACK], top = 0;
    real starts[STACK];
    for (int e = 0; e >= 0;) {
        if (e < tree.shape.node_count) {
            wides begins;
            uint bits = boxes_on_ray(slabs, tree.nodes + e, *distance, &begins);
            if (bits) {
                e = descend(tree.shape, e, bits, begins, stack, starts, &top);
                continue;
            }
        } else {
            __global const Leaf *leaf = tree.leaves + (e - tree.shape.node_count);
            LEAF_QUADRATIC(ray, leaf)
            uint bits = wide_bits(met);
            if (bits) {
                __private wides all[1] = {c / (sqrt(delta) - b)};
                __private const real *root = (__private const real *)all;
                for (; bits; bits &= bits - 1) {
                    int k = LOWEST_BIT(bits);
                    if (root[k] < *distance || (root[k] == *distance && leaf->id[k] < *sphere)) {
                        *distance = root[k];
                        *sphere = leaf->id[k];
                    }
                }
            }
        }
        e = next_of(stack, starts, &top, *distance);
    }
}

// What the spheres in between take, see taken_with().
#define ALL (NEST ? OPAQUE : (INTEGER) - 1)
static INTEGER occluded_single(Tree tree, Single ray, real limit, bool near) {
    INTEGER taken = 0;
    Slabs slabs = slabs_of(ray);
    int stack[STACK], top = 0;
    for (int e = 0; e >= 0;) {
        if (e < tree.shape.node_count) {
            wides begins;
            uint bits = boxes_on_ray(slabs, tree.nodes + e, limit, &begins);
            if (bits) {
                e = descend_anyhow(tree.shape, e, bits, stack, &top);
                continue;
            }
        } else {
            LEAF_QUADRATIC(ray, tree.leaves + (e - tree.shape.node_count))
            uint bits = wide_bits(met & ((near ? FIRST_ROOT : -b) < limit));
            if (bits && (near || !NEST)) return ALL;
            for (; NEST && bits; bits &= bits - 1) {
                int id = tree.leaves[e - tree.shape.node_count].id[LOWEST_BIT(bits)];
                taken = min(taken + tree.glass[id].veil, OPAQUE);
            }
            if (NEST && taken == OPAQUE) return ALL;
        }
        e = top > 0 ? stack[--top] : -1;
    }
    return taken;
}

// What the rays of lanes are inside of, as a Single's.
#define INSIDE_OF(ray)                  \
    __private ints inside_[MAX_INSIDE]; \
    for (int n = 0; n < NEST; n++) inside_[n] = (ray).inside.sphere[n];
#define SINGLE_INSIDE(i) \
    for (int n = 0; n < NEST; n++) single.inside[n] = ((__private INTEGER *)(inside_ + n))[i];

// Runs its body for each ray that is on: `i` is its lane, `single` the ray.
#define FOR_EACH_RAY(ray, on)                                                                    \
    __private reals coordinates_[6] = {(ray).origin.x,    (ray).origin.y,    (ray).origin.z,     \
                                       (ray).direction.x, (ray).direction.y, (ray).direction.z}; \
    __private ints leaves_[1] = {(ray).leaves};                                                  \
    __private const real *r_ = (__private const real *)coordinates_;                             \
    __private const INTEGER *l_ = (__private const INTEGER *)leaves_;                            \
    for (uint bits_ = lane_bits(on); bits_; bits_ &= bits_ - 1)                                  \
        for (int i = LOWEST_BIT(bits_), once_ = 1; once_; once_ = 0)                             \
            for (Single single = {{r_[i], r_[LANES + i], r_[2 * LANES + i]},                     \
                                  {r_[3 * LANES + i], r_[4 * LANES + i], r_[5 * LANES + i]},     \
                                  l_[i]};                                                        \
                 once_; once_ = 0)

static real largest_coordinate(Vector o, ints on) { return fmax((real)1, MOST(on, largest_of(o))); }

// What the tree has before `hit`, for the rays that are on.
// common: all rays have one origin.
static Hit nearest_in_tree(Tree tree, Hit hit, Ray ray, ints on, bool common) {
#ifdef BRUTE
    for (int e = 0; e < leaves_of(tree.shape); e++)
        for (int k = 0; k < WIDE; k++) {
            __global const Leaf *leaf = tree.leaves + e;
            QUADRATIC(reals, ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x,
                      ray.direction.y, ray.direction.z, leaf->center[0][k], leaf->center[1][k],
                      leaf->center[2][k], leaf->radius[k])
            ints met = on & (delta > 0) & (b < 0) & (c > 0) & near_side(ray, leaf->id[k]);
            if (ANY(met)) hit = closer_of(hit, met, c / (sqrt(delta) - b), leaf->id[k]);
        }
    return hit;
#endif
#if LANES > 1
    real slack = SLACK * largest_coordinate(ray.origin, on);
    Beam beam = beam_of(ray.origin, ray.direction, on, slack, common);
    if (beam.width < tree.shape.wide) {
        int stack[STACK], top = 0, left = tree.shape.budget, e = 0;
        real starts[STACK];
        real end = beam_end(beam, ray.origin, ray.direction, hit.distance, on, slack);
        while (e >= 0 && left > 0) {
            if (e < tree.shape.node_count) {
                wides begins;
                left--;
                uint bits = boxes_in_beam(beam, tree.nodes + e, end, &begins);
                if (bits) {
                    e = descend(tree.shape, e, bits, begins, stack, starts, &top);
                    continue;
                }
            } else {
                __global const Leaf *leaf = tree.leaves + (e - tree.shape.node_count);
                bool found = false;
                for (uint bits = spheres_in_beam(beam, leaf, end); bits; bits &= bits - 1) {
                    int k = LOWEST_BIT(bits);
                    left--;
                    QUADRATIC(reals, ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x,
                              ray.direction.y, ray.direction.z, leaf->center[0][k],
                              leaf->center[1][k], leaf->center[2][k], leaf->radius[k])
                    ints met = on & (delta > 0) & (b < 0) & (c > 0) & near_side(ray, leaf->id[k]);
                    if (ANY(met)) {
                        hit = closer_of(hit, met, c / (sqrt(delta) - b), leaf->id[k]);
                        found = true;
                    }
                }
                if (found) end = beam_end(beam, ray.origin, ray.direction, hit.distance, on, slack);
            }
            e = next_of(stack, starts, &top, end);
        }
        if (e < 0) return hit;
    }
#endif
    __private reals distances[1] = {hit.distance};
    __private ints spheres[1] = {hit.sphere};
    INSIDE_OF(ray)
    FOR_EACH_RAY(ray, on) {
        SINGLE_INSIDE(i)
        nearest_single(tree, single, (__private real *)distances + i,
                       (__private INTEGER *)spheres + i);
    }
    hit.distance = distances[0];
    hit.sphere = spheres[0];
    return hit;
}

// Which of the rays that are on a sphere of the tree keeps from the light, which is outside of all
// of them; `near`: which of them meet one before that distance, glass as well.
static ints occluded_in_tree(Tree tree, Ray ray, reals distance, Vector light, ints on, bool near) {
#ifdef BRUTE
    ints dark = 0;
    for (int e = 0; e < leaves_of(tree.shape); e++)
        for (int k = 0; k < WIDE; k++) {
            __global const Leaf *leaf = tree.leaves + e;
            QUADRATIC(reals, ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x,
                      ray.direction.y, ray.direction.z, leaf->center[0][k], leaf->center[1][k],
                      leaf->center[2][k], leaf->radius[k])
            ints met = on & (delta > 0) & (b < 0) & (c > 0) & near_side(ray, leaf->id[k]) &
                       ((near ? FIRST_ROOT : -b) < distance);
            if (leaf->id[k] >= 0)
                dark = taken_with(dark, met, NEST && !near ? tree.glass[leaf->id[k]].veil : OPAQUE);
        }
    return dark;
#endif
    ints clear = on, taken = 0;
#if LANES > 1
    // From the light to the points, for it is common; not from a far one, whose rounding is large.
    real away = near ? 8 : MOST(on, largest_of(light));
    real slack = SLACK * fmax(largest_coordinate(ray.origin, on), away <= 4 ? away : (real)0);
    Vector back = scaled(ray.direction, -1);
    Beam beam = away <= 4 ? beam_of(light, back, on, slack, true)
                          : beam_of(ray.origin, ray.direction, on, slack, false);
    if (beam.width < tree.shape.wide) {
        int stack[STACK], top = 0, left = tree.shape.budget, e = 0;
        real starts[STACK];
        real end = away <= 4 ? beam_end(beam, ray.origin, back, 0, on, slack) : INFINITY;
        if (near) end = beam_end(beam, ray.origin, ray.direction, distance, on, slack);
        while (e >= 0 && left > 0) {
            if (e < tree.shape.node_count) {
                wides begins;
                left--;
                uint bits = boxes_in_beam(beam, tree.nodes + e, end, &begins);
                if (bits) {
                    e = descend(tree.shape, e, bits, begins, stack, starts, &top);
                    continue;
                }
            } else {
                __global const Leaf *leaf = tree.leaves + (e - tree.shape.node_count);
                for (uint bits = spheres_in_beam(beam, leaf, end); bits; bits &= bits - 1) {
                    int k = LOWEST_BIT(bits);
                    left--;
                    QUADRATIC(reals, ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x,
                              ray.direction.y, ray.direction.z, leaf->center[0][k],
                              leaf->center[1][k], leaf->center[2][k], leaf->radius[k])
                    ints met = on & (delta > 0) & (b < 0) & (c > 0) & near_side(ray, leaf->id[k]) &
                               ((near ? FIRST_ROOT : -b) < distance);
                    if (NEST && !ANY(met)) continue;
                    INTEGER all = NEST && !near ? tree.glass[leaf->id[k]].veil : OPAQUE;
                    taken = taken_with(taken, met, all);
                }
                clear = on & !takes_all(taken);
                if (!ANY(clear)) return taken;
            }
            e = next_of(stack, starts, &top, INFINITY);
        }
        if (e < 0) return taken;
    }
#endif
    __private reals limits[1] = {distance};
    // From the start: what the beam has met would count twice.
    __private ints each[1] = {PICK_INT(clear, 0, taken)};
    INSIDE_OF(ray)
    FOR_EACH_RAY(ray, clear) {
        SINGLE_INSIDE(i)
        ((__private INTEGER *)each)[i] =
            occluded_single(tree, single, ((__private const real *)limits)[i], near);
    }
    return each[0];
}

// Where a light is seen from: a cone, from a ball around the points to the light's.
typedef struct {
    Single line;  // from the middle of the points to that of the light
    Slabs slabs;
    real begin;    // the radius of the ball around the points
    real opening;  // by how much the cone is wider, for each unit along the line
    real steep;    // 1 / the cosine of the angle between its side and the line
    real end;      // on the line
} Cone;

// The boxes that a cone meets: those around which there is a point of the line as near as the cone is
// wide where they end.
static uint boxes_in_cone(Cone view, __global const Node *node) {
    __global const wides *lo = (__global const wides *)node->lo;
    __global const wides *hi = (__global const wides *)node->hi;
    wides far = -(view.line.o[0] * view.line.d[0] +
                  (view.line.o[1] * view.line.d[1] + view.line.o[2] * view.line.d[2]));
    for (int a = 0; a < 3; a++) far += (view.slabs.forward[a] ? hi : lo)[a] * view.line.d[a];
    far = far < view.end ? far : view.end;
    wides width = (view.begin + view.opening * (far > 0 ? far : 0)) * view.steep,
          from = -view.begin, to = view.end;
    for (int a = 0; a < 3; a++) {
        wides wider = view.slabs.forward[a] ? -width : width;
        wides near_ = (view.slabs.forward[a] ? lo : hi)[a] + wider;
        wides far_side = (view.slabs.forward[a] ? hi : lo)[a] - wider;
        wides enter = near_ * view.slabs.inverse[a] + view.slabs.enter[a];
        wides leave = far_side * view.slabs.inverse[a] + view.slabs.leave[a];
        from = enter > from ? enter : from;
        to = leave < to ? leave : to;
    }
    // The ends are rounded in proportion to themselves.
    wides slack = (from > 0 ? from : -from) * (16 * UNIT_ROUNDOFF);
    return wide_bits((far > -view.begin) & (from - slack <= to + slack));
}

// Adds the spheres of a leaf, as many at a time as there are lanes.
static Cover covered_by_leaf(Tree tree, Cover cover, Single ray, Cap cap,
                             __global const Leaf *leaf) {
    for (int i = 0; i < WIDE; i += LANES) {
        ints id = TO_INTS(*(__global const LANES_OF(int) *)(leaf->id + i));
        Vector f = vector(*(__global const reals *)(leaf->center[0] + i) - ray.o[0],
                          *(__global const reals *)(leaf->center[1] + i) - ray.o[1],
                          *(__global const reals *)(leaf->center[2] + i) - ray.o[2]);
        reals radius = *(__global const reals *)(leaf->radius + i);
        reals c = FMA(-radius, radius, FMA(f.x, f.x, FMA(f.y, f.y, f.z * f.z)));
        ints met = id != ray.leaves;
        for (int n = 0; n < NEST; n++) met &= id + 1 != ray.inside[n];
        __private ints takes[1] = {0};
        for (int k = 0; NEST && k < LANES; k++)
            if (leaf->id[i + k] >= 0)
                ((__private INTEGER *)takes)[k] = tree.glass[leaf->id[i + k]].veil;
        cover = covered(cover, cap, met, f, radius, c, 0, takes[0]);
    }
    return cover;
}

#if LANES == 1
#define SUM_OF(n) (n)
#else
// Not more than what is OPAQUE.
static INTEGER sum_of_ints(ints n) {
    __private ints all[1] = {n};
    __private const INTEGER *each = (__private const INTEGER *)all;
    long sum = 0;
    for (int i = 0; i < LANES; i++) sum += each[i];
    return (INTEGER)min(sum, (long)(128 * VEIL) - 1);
}
#define SUM_OF(n) sum_of_ints(n)
#endif

static Cone cone_of(Single line, real begin, real radius, real distance) {
    Cone view;
    view.line = line;
    view.slabs = slabs_of(line);
    view.begin = begin;
    real slope = (radius - begin) / distance;
    // Towards 90 degrees a cone meets whatever is ahead.
    view.steep = 1 / sqrt(fmax(1 - slope * slope, REAL(1e-6)));
    view.opening = fmax(slope, (real)0) * (1 + 16 * UNIT_ROUNDOFF);
    view.end = distance + radius;
    return view;
}

#if LANES > 1
// Of a leaf, the spheres that a cone meets.
static uint spheres_in_cone(Cone view, __global const Leaf *leaf) {
    __global const wides *center = (__global const wides *)leaf->center;
    wides radius = *(__global const wides *)leaf->radius;
    wides x = center[0] - view.line.o[0], y = center[1] - view.line.o[1],
          z = center[2] - view.line.o[2];
    wides t = x * view.line.d[0] + (y * view.line.d[1] + z * view.line.d[2]);
    x -= t * view.line.d[0], y -= t * view.line.d[1], z -= t * view.line.d[2];
    wides far = t + radius < view.end ? t + radius : view.end;
    wides reach = (view.begin + view.opening * (far > 0 ? far : 0)) * view.steep + radius + SLACK;
    return wide_bits((far > -view.begin - SLACK) & (t - radius < view.end * (1 + SLACK)) &
                     (x * x + (y * y + z * z) <= reach * reach));
}
#endif

// What the tree's spheres cover of a light, a ball around `light` of that radius, beside what others
// do, for the rays that are on: sphere by sphere for all lanes while that pays, then ray by ray. Sums
// of whole numbers are the same either way.
static Cover covered_in_tree(Tree tree, Cover cover, Ray ray, Cap cap, ints on,
                             __global const real *light, real radius) {
    if (!ANY(on)) return cover;
    int stack[STACK], top = 0;
#if LANES > 1
    {
        Single line;
        __private real *o = line.o, *d = line.d;
        o[0] = (LEAST(on, ray.origin.x) + MOST(on, ray.origin.x)) / 2;
        o[1] = (LEAST(on, ray.origin.y) + MOST(on, ray.origin.y)) / 2;
        o[2] = (LEAST(on, ray.origin.z) + MOST(on, ray.origin.z)) / 2;
        Vector apart = minus(ray.origin, vector(o[0], o[1], o[2]));
        real begin = sqrt(MOST(on, dot3(apart, apart))), length2 = 0;
        for (int a = 0; a < 3; a++) {
            d[a] = light[a] - o[a];
            length2 += d[a] * d[a];
        }
        real distance = sqrt(length2);
        for (int a = 0; a < 3; a++) d[a] /= distance;
        Cone view = cone_of(line, begin + SLACK, radius, distance);
        Cover sum = cover;
        int left = tree.shape.budget, e = distance > begin + radius ? 0 : -2;
        while (e >= 0 && left > 0) {
            if (e < tree.shape.node_count) {
                left--;
                uint bits = boxes_in_cone(view, tree.nodes + e);
                if (bits) {
                    e = descend_anyhow(tree.shape, e, bits, stack, &top);
                    continue;
                }
            } else {
                __global const Leaf *leaf = tree.leaves + (e - tree.shape.node_count);
                for (uint bits = spheres_in_cone(view, leaf); bits; bits &= bits - 1) {
                    int k = LOWEST_BIT(bits), id = leaf->id[k];
                    left--;
                    Vector f =
                        vector(leaf->center[0][k] - ray.origin.x, leaf->center[1][k] - ray.origin.y,
                               leaf->center[2][k] - ray.origin.z);
                    reals r = leaf->radius[k];
                    reals c = FMA(-r, r, FMA(f.x, f.x, FMA(f.y, f.y, f.z * f.z)));
                    INTEGER takes = NEST ? tree.glass[id].veil : 0;
                    sum = covered(sum, cap, on & near_side(ray, id), f, r, c, 0, takes);
                }
                if (!ANY(on & (sum.hidden < (INTEGER)VEIL))) return sum;
            }
            e = top > 0 ? stack[--top] : -1;
        }
        if (e == -1) return sum;
        top = 0;
    }
#endif
    __private Cover covers[1] = {cover};
    __private INTEGER *hidden = (__private INTEGER *)&covers[0].hidden;
    __private Cap caps[1] = {cap};
    __private const real *sine = (__private const real *)&caps[0].sine;
    __private const real *cosine = (__private const real *)&caps[0].cosine;
    __private const real *angle = (__private const real *)&caps[0].angle;
    __private const real *versine = (__private const real *)&caps[0].versine;
    __private const real *distance = (__private const real *)&caps[0].distance;
    __private INTEGER *veil = (__private INTEGER *)&covers[0].veil;
    INSIDE_OF(ray)
    FOR_EACH_RAY(ray, on) {
        SINGLE_INSIDE(i)
        Cap own;
        own.to = vector(single.d[0], single.d[1], single.d[2]);
        own.angle = angle[i], own.sine = sine[i], own.cosine = cosine[i];
        own.versine = versine[i], own.distance = distance[i];
        Cone view = cone_of(single, SLACK, sine[i] * distance[i], distance[i]);
        Cover sum = {0};
        for (int e = 0; e >= 0;) {
            if (e < tree.shape.node_count) {
                uint bits = boxes_in_cone(view, tree.nodes + e);
                if (bits) {
                    e = descend_anyhow(tree.shape, e, bits, stack, &top);
                    continue;
                }
            } else {
                __global const Leaf *leaf = tree.leaves + (e - tree.shape.node_count);
                sum = covered_by_leaf(tree, sum, single, own, leaf);
                if (SUM_OF(sum.hidden) >= (INTEGER)VEIL) top = 0;
            }
            e = top > 0 ? stack[--top] : -1;
        }
        hidden[i] = min(hidden[i] + SUM_OF(sum.hidden), (INTEGER)VEIL);
        if (NEST) veil[i] = min(veil[i] + SUM_OF(sum.veil), OPAQUE);
    }
    return covers[0];
}

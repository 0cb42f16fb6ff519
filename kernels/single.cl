// Single: one ray against 16 boxes of a tree, or 16 of its spheres.

// OPACITY: as Passed.
typedef struct {
    real distance;
    INTEGER id;
} PassedSingle;

// A packet's ray, alone.
typedef struct {
    real o[3], d[3];             // origin and direction
    INTEGER leaves;              // as in Ray
    INTEGER inside[MAX_INSIDE];  // NEST: index + 1
    PassedSingle passed[ROOM(OPACITY)];
} Single;

// A packet's rays in memory, where a lane can be chosen at run time.
typedef struct {
    reals coordinates[6];
    ints leaves[1];
    ints inside[MAX_INSIDE];
    Passed passed[ROOM(OPACITY)];
} Rays;

// TREE: a packet's rays, to be taken one by one.
static Rays rays_of(Ray ray) {
    Rays rays = {{ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x, ray.direction.y,
                  ray.direction.z},
                 {ray.leaves}};
    FOR_EACH_LAYER(rays.inside[i] = ray.inside.layers[i].sphere)
    if (OPACITY) rays.passed[0] = ray.passed[0];
    return rays;
}

// TREE: the ray of one lane.
static Single single_of(const Rays *rays, int lane) {
    __private const real *r = EACH_REAL(rays->coordinates);
    Single single = {{r[lane], r[LANES + lane], r[2 * LANES + lane]},
                     {r[3 * LANES + lane], r[4 * LANES + lane], r[5 * LANES + lane]},
                     EACH_INT(rays->leaves)[lane]};
    FOR_EACH_LAYER(single.inside[i] = EACH_INT(rays->inside[i])[lane])
    if (OPACITY) {
        single.passed[0].distance = EACH_REAL(rays->passed[0].distance)[lane];
        single.passed[0].id = EACH_INT(rays->passed[0].id)[lane];
    }
    return single;
}

// OPACITY and TREE: behind() for one ray and 16 places.
static wide_ints behind_single(const Single *ray, wides distance, wide_ints ids) {
    real last = ray->passed[0].distance;
    return (distance > last) | ((distance == last) & (ids > ray->passed[0].id));
}

// TREE: near_side() for one ray and 16 spheres.
static wide_ints near_sides(const Single *ray, wide_ints ids) {
    wide_ints near = ids != ray->leaves;
    FOR_EACH_LAYER(near &= ids + 1 != ray->inside[i])
    return near;
}

// The planes of a box that a ray enters by and leaves by; a box begins at the largest
// plane * inverse + enter of the three axes.
typedef struct {
    real inverse[3], enter[3], leave[3];
    bool forward[3];
} Slabs;

// TREE: those of one axis, widened by a slack.
static void add_slab(Slabs *slabs, const Single *ray, int a, real slack) {
    real d = fabs(ray->d[a]) > REAL(1e-18) ? ray->d[a] : REAL(1e-18);
    slabs->inverse[a] = 1 / d;
    slabs->forward[a] = d > 0;
    real at = -ray->o[a] * slabs->inverse[a], wider = slack * fabs(slabs->inverse[a]);
    slabs->enter[a] = at - wider;
    slabs->leave[a] = at + wider;
}

// TREE: the planes of boxes as a ray meets them.
static Slabs slabs_of(const Single *ray) {
    real largest = 1;
    Slabs slabs;
    FOR_EACH_AXIS(largest = fmax(largest, fabs(ray->o[a])))
    FOR_EACH_AXIS(add_slab(&slabs, ray, a, SLACK * largest))
    return slabs;
}

// TREE: cuts a ray's pieces in 16 boxes to those between their planes of one axis.
static void cut(const Slabs *slabs, int a, wides lo, wides hi, wides *from, wides *to) {
    wides enter = (slabs->forward[a] ? lo : hi) * slabs->inverse[a] + slabs->enter[a];
    wides leave = (slabs->forward[a] ? hi : lo) * slabs->inverse[a] + slabs->leave[a];
    *from = enter > *from ? enter : *from;
    *to = leave < *to ? leave : *to;
}

// TREE: the boxes of a node that a ray meets from `start` to `end`, as bits, and where on it they begin.
static uint boxes_on_ray(const Slabs *slabs, __global const Node *node, real start, real end,
                         wides *begins) {
    __global const wides *lo = (__global const wides *)node->lo;
    __global const wides *hi = (__global const wides *)node->hi;
    wides from = start, to = end;
    FOR_EACH_AXIS(cut(slabs, a, lo[a], hi[a], &from, &to))
    *begins = from;
    // The ends are rounded in proportion to themselves.
    return wide_bits(from <= to * (1 + 16 * UNIT_ROUNDOFF));
}

// Of a QUADRATIC that is hit: where the ray enters the sphere.
#define FIRST_ROOT (c / (sqrt(delta) - b))

// QUADRATIC for one ray and a leaf, and the spheres that are met.
#define LEAF_QUADRATIC(ray, leaf)                                                                  \
    __global const wides *center_ = (__global const wides *)(leaf)->center;                        \
    QUADRATIC(wides, (ray)->o[0], (ray)->o[1], (ray)->o[2], (ray)->d[0], (ray)->d[1], (ray)->d[2], \
              center_[0], center_[1], center_[2], *(__global const wides *)(leaf)->radius)         \
    int16 id_ = *(__global const int16 *)(leaf)->id;                                               \
    wide_ints met = (delta > 0) & (b < 0) & (c > 0) & near_sides(ray, TO_WIDE_INTS(id_));

// OPACITY and TREE: puts thing `id` of a scene among the HITS nearest of a ray, each of which is as many
// numbers from the last as there are lanes. What is opaque hides those behind it.
static void take_its_place(const Tree *tree, real *distance, INTEGER *ids, real at, INTEGER id) {
    int k = HITS - 1;
    if (!(at < distance[k * LANES] || (at == distance[k * LANES] && id < ids[k * LANES]))) return;
    for (; k > 0; k--) {
        real before = distance[(k - 1) * LANES];
        if (!(at < before || (at == before && id < ids[(k - 1) * LANES]))) break;
        distance[k * LANES] = before;
        ids[k * LANES] = ids[(k - 1) * LANES];
    }
    distance[k * LANES] = at;
    ids[k * LANES] = id;
    if (OPACITY_OF(tree->glass[id]) < 1) return;
    for (k++; k < HITS; k++) {
        distance[k * LANES] = at;
        ids[k * LANES] = NO_MORE;
    }
}

// Thing `number` of a leaf where it is nearer than what a ray has met.
#define TAKE_NEARER(tree, distance, ids, at, number)                           \
    if (OPACITY) {                                                             \
        take_its_place(tree, distance, ids, at, number);                       \
    } else if (at < *(distance) || (at == *(distance) && (number) < *(ids))) { \
        *(distance) = at;                                                      \
        *(ids) = number;                                                       \
    }

// TREE: the sphere of a leaf that a ray meets before `distance`, if there is one.
static void nearest_sphere(const Tree *tree, __global const Leaf *leaf, const Single *ray,
                           real *distance, INTEGER *sphere) {
    LEAF_QUADRATIC(ray, leaf)
    uint bits = wide_bits(met);
    if (!bits) return;
    __private wides all[1] = {FIRST_ROOT};
    if (OPACITY) {
        met &= behind_single(ray, all[0], TO_WIDE_INTS(id_));
        bits = wide_bits(met & (all[0] <= distance[(HITS - 1) * LANES]));
    }
    __private const real *root = (__private const real *)all;
    for (; bits; bits &= bits - 1) {
        int k = LOWEST_BIT(bits);
        TAKE_NEARER(tree, distance, sphere, root[k], leaf->id[k])
    }
}

// Of taken_with(): all that there is.
#define ALL (VEILED ? OPAQUE : (INTEGER) - 1)

// TREE: what those things of a leaf, as bits, take of a shadow ray that meets them, beside what is taken.
// ids: of the leaf's things. near: see taken_in_tree().
static INTEGER taken_by_some(const Tree *tree, __global const int *ids, uint bits, bool near,
                             INTEGER taken) {
    if (bits && ((near && !OPACITY) || !VEILED)) return ALL;
    if (!VEILED) return taken;
    for (; bits; bits &= bits - 1)
        taken = veiled_single(taken, tree->glass[ids[LOWEST_BIT(bits)]].veil);
    return taken;
}

// TREE: what a leaf's spheres take of a shadow ray beside what is taken. near: all (OPACITY: their
// part), if it meets one before `limit`; else if their middles are before it.
static INTEGER taken_by_spheres(const Tree *tree, __global const Leaf *leaf, const Single *ray,
                                real limit, bool near, INTEGER taken) {
    LEAF_QUADRATIC(ray, leaf)
    if (near && !wide_bits(met)) return taken;  // a root costs as much as all before
    uint bits = wide_bits(met & ((near ? FIRST_ROOT : -b) < limit));
    return taken_by_some(tree, leaf->id, bits, near, taken);
}

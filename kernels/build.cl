// Build: the tree's order, by halving the spheres, and its nodes and leaves, fitted to them.
//
// clrt/opencl/tree.py runs these: `split` once for a list of spheres, in
// world units; `fit_leaves` and `fit_nodes` for each place of the camera.
#if TREE

// The shape's numbers that a build needs. The root has `root` children, the nodes below it 16 each,
// down `levels` levels; the lowest nodes have `leaves` leaves each. So leaves are equally full.
typedef struct {
    int root, levels, leaves;
} Plan;

// TREE: how many leaves a tree of that plan has.
static long all_leaves(Plan plan) { return ((long)plan.root << (4 * plan.levels)) * plan.leaves; }

// TREE: a list is halved level by level: into the root's children (4 levels), their children and so on (4
// each), and the leaves of a lowest node (4). The first leaf of segment s of level k; segments can be
// empty where there are fewer than 16.
static long first_leaf(Plan plan, long s, int k) {
    long below = (1L << (4 * plan.levels)) * plan.leaves;  // leaves of a child of the root
    if (k <= 4) return (s * plan.root >> k) * below;
    int rest = k - 4;
    long top = s >> rest, child = top * plan.root >> 4;
    long within = s & ((1L << rest) - 1);
    if (child == (top + 1) * plan.root >> 4) return child * below;  // none
    if (rest <= 4 * plan.levels) return child * below + within * (below >> rest);
    int last = rest - 4 * plan.levels;
    long node = within >> last, part = within & ((1L << last) - 1);
    return child * below + node * plan.leaves + (part * plan.leaves >> last);
}

// TREE: where a leaf's spheres begin in a list of n.
static long first_sphere(Plan plan, long n, long leaf) {
    long count = all_leaves(plan);
    // leaf * n can be beyond 2^63 only from 2^33 spheres on.
    return leaf * n / count;
}

// A list is halved along the longest side of what is in it. The radius is a fourth side: so large
// spheres do not make the boxes of small ones large.
//
// Halves by the radius lie in one another's place, so a ray meets both. That pays where many large
// spheres stand among small ones, and not for the sake of a few: a thousand spheres with one large
// one would be halved by their radii, time and again, until it is alone. So the fourth side is no
// longer than DEVIATIONS standard deviations, which one of 10^5 hardly moves. Of 8 to 24 the number
// 16 loses least in forty distributions (benchmarks/NOTES.md).
#define DEVIATIONS 16

// So many keys at most are sorted to find one of about some rank.
#define SAMPLE 63

// TREE: key i along a side, x, y, z or twice the radius.
static float key_of(__global const float4 *keys, long i, int side) {
    return ((__global const float *)(keys + i))[side];
}

// TREE: puts those of [a, b) before the others whose key is below the pivot, or up to it; where the
// others begin. `keys`, x y z and twice the radius, is permuted with `order`, the place in the
// scene's list. Each is stored in two places, whatever it is: a branch here would be guessed wrong
// every other time (Lomuto's loop without one).
static long part_(__global float4 *keys, __global int *order, long a, long b, int side, float pivot,
                  bool up_to) {
    long j = a;
    for (long i = a; i < b; i++) {
        float x = key_of(keys, i, side);
        float4 key = keys[i];
        int place = order[i];
        keys[i] = keys[j], order[i] = order[j];
        keys[j] = key, order[j] = place;
        j += up_to ? x <= pivot : x < pivot;
    }
    return j;
}

// TREE: a key of [a, b) of about rank k, of few that are sorted: on that side of it where most are,
// so that most are then left out.
static float pivot_of(__global const float4 *keys, long a, long b, long k, int side) {
    float some[SAMPLE];
    int n = max(min((b - a) / 32 | 1, (long)SAMPLE), 3L);
    for (int i = 0; i < n; i++) {
        float x = key_of(keys, a + (b - a) * (2 * i + 1) / (2 * n), side);
        int j = i;
        for (; j > 0 && some[j - 1] > x; j--) some[j] = some[j - 1];
        some[j] = x;
    }
    float part = (k - a + 0.5f) / (b - a);
    int place = part * n + (0.5f - part) * sqrt((float)n);
    return some[max(min(place, n - 1), 0)];
}

// TREE: puts the element of rank k of [a, b) in its place, with none greater before it and none smaller
// after it (Hoare, "Algorithm 65: find", 1961; Floyd and Rivest, "Algorithm 489", 1975).
static void select_(__global float4 *keys, __global int *order, long a, long b, long k, int side) {
    while (b - a > 1) {
        float pivot = pivot_of(keys, a, b, k, side);
        long middle = part_(keys, order, a, b, side, pivot, false);
        if (k < middle) {
            b = middle;
        } else if (middle > a) {
            a = middle;
        } else {  // none is below the pivot: those that are equal go first
            a = part_(keys, order, a, b, side, pivot, true);
            if (k < a) return;
        }
    }
}

// TREE: the standard deviation of twice the radius. In two passes: the mean square less the square of
// the mean would lose it where the mean is large against it.
static float deviation_of_radius(__global const float4 *keys, long a, long b) {
    float mean = 0, square = 0;
    for (long i = a; i < b; i++) mean += keys[i].w;
    mean /= b - a;
    for (long i = a; i < b; i++) square += (keys[i].w - mean) * (keys[i].w - mean);
    return sqrt(square / (b - a));
}

// TREE: along which side to halve [a, b).
static int longest_side(__global const float4 *keys, long a, long b) {
    float4 low[4], high[4];  // so one need not wait for the one before
    for (int j = 0; j < 4; j++) low[j] = high[j] = keys[a];
    for (long i = a; i + 3 < b; i += 4)
        for (int j = 0; j < 4; j++) {
            float4 key = keys[i + j];
            low[j] = key < low[j] ? key : low[j];
            high[j] = key > high[j] ? key : high[j];
        }
    for (int j = 0; j < 4; j++) {
        float4 key = keys[max(b - 1 - j, a)];
        low[0] = fmin(fmin(low[0], low[j]), key), high[0] = fmax(fmax(high[0], high[j]), key);
    }
    float4 size = high[0] - low[0];
    int side = size.x >= size.y ? 0 : 1;
    if (size.z > (side == 0 ? size.x : size.y)) side = 2;
    float longest = fmax(fmax(size.x, size.y), size.z);
    bool by_radius = size.w > longest && DEVIATIONS * deviation_of_radius(keys, a, b) > longest;
    return by_radius ? 3 : side;
}

// TREE: halves the segments of the levels [from, to) below each segment of level `from`.
__kernel void split(__global float4 *keys, __global int *order, long n, int root, int levels,
                    int leaf_count, int from, int to) {
    Plan plan = {root, levels, leaf_count};
    for (long top = get_global_id(0); top < 1L << from; top += get_global_size(0))
        for (int k = from; k < to; k++)
            for (long s = top << (k - from); s < (top + 1) << (k - from); s++) {
                long a = first_sphere(plan, n, first_leaf(plan, s, k));
                long b = first_sphere(plan, n, first_leaf(plan, s + 1, k));
                long middle = first_sphere(plan, n, first_leaf(plan, 2 * s + 1, k + 1));
                if (middle <= a || middle >= b) continue;
                int side = longest_side(keys, a, b);
                select_(keys, order, a, b, middle, side);
                if (side != 3) continue;
                // Of those with that radius near ones stay together.
                float radius = key_of(keys, middle, 3);
                a = part_(keys, order, a, middle, 3, radius, false);
                b = part_(keys, order, middle, b, 3, radius, true);
                select_(keys, order, a, b, middle, longest_side(keys, a, b));
            }
}

// The box around what is in a leaf.
typedef struct {
    real lo[3], hi[3];
} Box;

// TREE: a box that holds a ball as well.
static void hold(Box *box, const real *center, real radius) {
    for (int a = 0; a < 3; a++) {
        box->lo[a] = fmin(box->lo[a], center[a] - radius);
        box->hi[a] = fmax(box->hi[a], center[a] + radius);
    }
}

// TREE: puts a bead into place j of a leaf; 0: there is none.
static void put_bead_into(__global Leaf *leaf, int j, int id, __global const Bead *bead, Box *box) {
    real center[3] = {NAN, NAN, NAN}, radius = NAN;
    if (bead) {
        for (int a = 0; a < 3; a++) center[a] = bead->center[a];
        radius = bead->radius;
        hold(box, center, radius);
    }
    leaf->id[j] = bead ? id : -1;
    leaf->radius[j] = radius;
    for (int a = 0; a < 3; a++) leaf->center[a][j] = center[a];
}

// CAPSULES: puts a capsule into place j of a leaf; 0: there is none.
static void put_capsule_into(__global CapsuleLeaf *leaf, int j, int id,
                             __global const Capsule *capsule, Box *box) {
    real start[3] = {NAN, NAN, NAN}, axis[3] = {NAN, NAN, NAN}, end[3];
    if (capsule) {
        for (int a = 0; a < 3; a++) {
            start[a] = capsule->start[a], axis[a] = capsule->axis[a];
            end[a] = start[a] + capsule->length * axis[a];
        }
        hold(box, start, capsule->radius);
        hold(box, end, capsule->radius);
    }
    leaf->id[j] = capsule ? id : -1;
    leaf->radius[j] = capsule ? capsule->radius : (real)NAN;
    leaf->length[j] = capsule ? capsule->length : (real)NAN;
    for (int a = 0; a < 3; a++) leaf->start[a][j] = start[a], leaf->axis[a][j] = axis[a];
}

// FACES: puts a triangle into place j of a leaf; 0: there is none.
static void put_face_into(__global FaceLeaf *leaf, int j, int id, __global const Face *face,
                          Box *box) {
    leaf->id[j] = face ? id : -1;
    leaf->closed[j] = face && face->reach == 0 ? -1 : 0;
    for (int c = 0; c < 3; c++) {
        real corner[3] = {NAN, NAN, NAN};
        if (face) {
            for (int a = 0; a < 3; a++) corner[a] = face->corner[c][a];
            hold(box, corner, 0);
        }
        for (int a = 0; a < 3; a++) leaf->corner[c][a][j] = corner[a];
    }
}

// TREE: the leaves of the lowest nodes and the boxes around them. things: of a kind, camera space. One
// whose radius, or reach, is NaN is left out: such a bead is in the list beside the tree. first_id: the
// id of the first of them.
__kernel void fit_leaves(__global const int *order, int kind, __global const void *things, long n,
                         int root, int levels, int leaf_count, __global void *leaves,
                         __global Node *nodes, int lowest, int first_id) {
    Plan plan = {root, levels, leaf_count};
    long count = (long)plan.root << (4 * plan.levels);
    for (long i = get_global_id(0); i < count; i += get_global_size(0)) {
        __global Node *node = nodes + lowest + i;
        for (int k = 0; k < WIDE; k++) {
            Box box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
            if (k < plan.leaves) {
                long l = i * plan.leaves + k, first = first_sphere(plan, n, l);
                long end = first_sphere(plan, n, l + 1);
                for (int j = 0; j < WIDE; j++) {
                    long place = first + j < end ? order[first + j] : -1;
                    int id = first_id + place;
                    if (CAPSULES && kind == OF_CAPSULES) {
                        __global const Capsule *one = (__global const Capsule *)things + place;
                        put_capsule_into((__global CapsuleLeaf *)leaves + l, j, id,
                                         place >= 0 && one->radius > 0 ? one : 0, &box);
                    } else if (FACES && kind == OF_FACES) {
                        __global const Face *one = (__global const Face *)things + place;
                        put_face_into((__global FaceLeaf *)leaves + l, j, id,
                                      place >= 0 && one->reach >= 0 ? one : 0, &box);
                    } else {
                        __global const Bead *one = (__global const Bead *)things + place;
                        put_bead_into((__global Leaf *)leaves + l, j, id,
                                      place >= 0 && one->radius > 0 ? one : 0, &box);
                    }
                }
            }
            for (int a = 0; a < 3; a++) node->lo[a][k] = box.lo[a], node->hi[a][k] = box.hi[a];
        }
    }
}

// TREE: the boxes around the nodes of one level, in the nodes above it.
__kernel void fit_nodes(__global Node *nodes, int first, int first_above, int above, int children) {
    for (int i = get_global_id(0); i < above; i += get_global_size(0)) {
        __global Node *node = nodes + first_above + i;
        for (int k = 0; k < WIDE; k++)
            for (int a = 0; a < 3; a++) {
                real lo = INFINITY, hi = -INFINITY;
                if (k < children) {
                    __global const Node *child = nodes + first + i * children + k;
                    for (int j = 0; j < WIDE; j++) {
                        lo = fmin(lo, child->lo[a][j]);
                        hi = fmax(hi, child->hi[a][j]);
                    }
                }
                node->lo[a][k] = lo, node->hi[a][k] = hi;
            }
    }
}

#endif

// Near: what near spheres hide of the sky, in closed form: a preview without noise of what is drawn at
// random else.
//
// A sphere that is above the horizon of a point hides F = (r / D)^2 cos of its light, of which D is the
// distance of its middle and cos that direction's; of one that the horizon cuts a part is hidden. What
// several hide together is not known: what the four largest leave is multiplied, and what all others
// leave, whose parts count OTHERS times: a fit (benchmarks/NOTES.md). What is farther than the reach hides
// nothing, and towards it less and less, so no edge shows where it ends.

#define OTHERS REAL(0.35)

// NEAR: the four largest parts that spheres hide, the largest first.
typedef struct {
    reals a, b, c, d;
    reals rest;  // what all others leave
} Hiders;

// NEAR: adds a sphere: f is the way to its middle, r its radius. opacity: of it.
static Hiders with_hider(Hiders most, Vector f, reals r, Vector normal, real reach, ints mine,
                         reals opacity) {
    reals distance2 = dot3(f, f), per = inverse_sqrt(distance2);
    reals cosine = dot3(normal, f) * per, sine = r * per;
    sine = PICK(sine < 1, sine, 1);
    reals above = cosine + sine;
    reals cut = PICK(above > 0, above * above / (4 * sine), 0);
    reals part = PICK(cosine > sine, cosine, cut) * (sine * sine) * opacity;
    reals off = (distance2 * per - r) / reach, off2 = PICK(off > 0, off * off, 0);
    part = PICK(mine & (off < 1), part * (1 - off2 * off2), 0);
    reals low = PICK(most.a < part, most.a, part);
    most.a = larger(most.a, part);
    part = PICK(most.b < low, most.b, low);
    most.b = larger(most.b, low);
    low = PICK(most.c < part, most.c, part);
    most.c = larger(most.c, part);
    part = PICK(most.d < low, most.d, low);
    most.d = larger(most.d, low);
    most.rest *= 1 - OTHERS * part;
    return most;
}

// NEAR and TREE: the boxes of a node, or (of a leaf) the spheres, that a ball reaches, as bits.
static uint boxes_in_reach(__global const Node *node, const real *middle, real reach) {
    __global const wides *lo = (__global const wides *)node->lo;
    __global const wides *hi = (__global const wides *)node->hi;
    wides distance2 = 0;
    for (int a = 0; a < 3; a++) {
        wides below = lo[a] - middle[a], above = middle[a] - hi[a];
        wides off = below > above ? below : above;
        off = off > 0 ? off : 0;
        distance2 += off * off;
    }
    return wide_bits(distance2 < reach * reach);
}

// NEAR and TREE: likewise.
static uint spheres_in_reach(__global const Leaf *leaf, const real *middle, real reach) {
    __global const wides *center = (__global const wides *)leaf->center;
    wides x = center[0] - middle[0], y = center[1] - middle[1], z = center[2] - middle[2];
    wides end = *(__global const wides *)leaf->radius + reach;
    return wide_bits(x * x + (y * y + z * z) < end * end);
}

// NEAR and TREE: adds the tree's spheres, for the points that are on.
static Hiders with_tree(const Tree *tree, Hiders most, Ray ray, Vector normal, real reach,
                        ints on) {
    real middle[3] = {(LEAST(on, ray.origin.x) + MOST(on, ray.origin.x)) / 2,
                      (LEAST(on, ray.origin.y) + MOST(on, ray.origin.y)) / 2,
                      (LEAST(on, ray.origin.z) + MOST(on, ray.origin.z)) / 2};
    Vector apart = minus(ray.origin, vector(middle[0], middle[1], middle[2]));
    real wide = reach + sqrt(MOST(on, dot3(apart, apart))) + SLACK;
    int stack[STACK], top = 0;
    for (int e = 0; e >= 0;) {
        if (e < tree->shape.node_count) {
            uint bits = boxes_in_reach(tree->nodes + e, middle, wide);
            if (bits) {
                e = descend_anyhow(&tree->shape, e, bits, stack, &top);
                continue;
            }
        } else {
            __global const Leaf *leaf = leaf_of(tree, OF_SPHERES, e);
            for (uint bits = spheres_in_reach(leaf, middle, wide); bits; bits &= bits - 1) {
                int k = LOWEST_BIT(bits), id = leaf->id[k];
                Vector center = vector(leaf->center[0][k], leaf->center[1][k], leaf->center[2][k]);
                reals opacity = OPACITY ? 1 - unveiled((ints)(tree->glass[id].veil)) : (reals)1;
                most = with_hider(most, minus(center, ray.origin), leaf->radius[k], normal, reach,
                                  on & (ray.leaves != id), opacity);
            }
        }
        e = top > 0 ? stack[--top] : -1;
    }
    return most;
}

// NEAR: the part of a sky that is open.
static reals left_by_hiders(Hiders most) {
    return (1 - most.a) * (1 - most.b) * ((1 - most.c) * (1 - most.d)) * most.rest;
}

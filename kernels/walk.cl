// Walk: through the tree of any kind, as a beam for as long as that pays and then ray by ray.
//
// A kind tells here how its leaves are tested: by one ray, and by a beam and then a packet.

// TREE: leaf e of a tree, which follows the nodes.
static __global const void *leaf_of(const Tree *tree, int kind, int e) {
    if (CAPSULES && kind == OF_CAPSULES)
        return (__global const CapsuleLeaf *)tree->leaves + (e - tree->shape.node_count);
    if (FACES && kind == OF_FACES)
        return (__global const FaceLeaf *)tree->leaves + (e - tree->shape.node_count);
    return (__global const Leaf *)tree->leaves + (e - tree->shape.node_count);
}

// TREE: what of a leaf a ray meets before `distance`, if there is something.
static void nearest_of_leaf(const Tree *tree, int kind, __global const void *leaf,
                            const Single *ray, real *distance, INTEGER *id) {
    if (CAPSULES && kind == OF_CAPSULES) {
        nearest_capsule(tree, leaf, ray, distance, id);
    } else if (FACES && kind == OF_FACES) {
        nearest_face(tree, leaf, ray, distance, id);
    } else {
        nearest_sphere(tree, leaf, ray, distance, id);
    }
}

// TREE: what a leaf takes of a shadow ray beside what is taken, see taken_by_spheres().
static INTEGER taken_by_leaf(const Tree *tree, int kind, __global const void *leaf,
                             const Single *ray, real limit, bool near, INTEGER taken) {
    if (CAPSULES && kind == OF_CAPSULES)
        return taken_by_capsules(tree, leaf, ray, limit, near, taken);
    if (FACES && kind == OF_FACES) return taken_by_faces(tree, leaf, ray, limit, near, taken);
    return taken_by_spheres(tree, leaf, ray, limit, near, taken);
}

// TREE: what of a leaf the beam meets before `end`, as bits.
static uint leaf_in_beam(const Tree *tree, int kind, __global const void *leaf, const Beam *beam,
                         real end) {
    if (CAPSULES && kind == OF_CAPSULES) return capsules_in_beam(beam, leaf, end);
    if (FACES && kind == OF_FACES) return faces_in_beam(beam, leaf, end);
    return spheres_in_beam(beam, leaf, end);
}

// TREE: tests those things of a leaf that `bits` has. Returns whether one is nearer than what was hit before.
static bool nearer_in_leaf(const Tree *tree, int kind, __global const void *leaf, uint bits,
                           const Beam *beam, Hit *hit, Ray ray, ints on) {
    if (FACES && kind == OF_FACES) return nearer_faces(tree, leaf, bits, beam, hit, ray, on);
    if (CAPSULES && kind == OF_CAPSULES) return nearer_capsules(tree, leaf, bits, hit, ray, on);
    return nearer_spheres(tree, leaf, bits, hit, ray, on);
}

// TREE: tests those things of a leaf that `bits` has against shadow rays, see left_by_spheres().
static Left left_by_leaf(const Tree *tree, int kind, __global const void *leaf, uint bits,
                         const Beam *beam, Left left, Ray ray, reals distance, ints on, bool near) {
    if (FACES && kind == OF_FACES)
        return left_by_faces(tree, leaf, bits, beam, left, ray, distance, on, near);
    if (CAPSULES && kind == OF_CAPSULES)
        return left_by_capsules(tree, leaf, bits, left, ray, distance, on, near);
    return left_by_spheres(tree, leaf, bits, left, ray, distance, on, near);
}

// TREE: what a ray meets before `distance`, if there is something. OPACITY: the nearest, see Later.
static void nearest_single(const Tree *tree, int kind, const Single *ray, real *distance,
                           INTEGER *id) {
    Slabs slabs = slabs_of(ray);
    real start = 0;
    if (OPACITY) start = fmax(ray->passed[0].distance, start);
    int stack[STACK], top = 0;
    real starts[STACK];
    for (int e = 0; e >= 0;) {
        if (e < tree->shape.node_count) {
            wides begins;
            uint bits =
                boxes_on_ray(&slabs, tree->nodes + e, start, distance[(HITS - 1) * LANES], &begins);
            if (bits) {
                e = descend(&tree->shape, e, bits, begins, stack, starts, &top);
                continue;
            }
        } else {
            nearest_of_leaf(tree, kind, leaf_of(tree, kind, e), ray, distance, id);
        }
        e = next_of(stack, starts, &top, distance[(HITS - 1) * LANES]);
    }
}

// What a beam that was given up leaves of a tree to its rays: node or leaf e, then those of the stack,
// the last first.
typedef struct {
    int e, top, stack[STACK];
} Rest;

// TREE: what the rest of the tree takes of one shadow ray that ends at `limit`, beside what is taken. See
// taken_in_tree().
static INTEGER taken_single(const Tree *tree, int kind, const Single *ray, real limit, bool near,
                            const Rest *rest, INTEGER taken) {
    Slabs slabs = slabs_of(ray);
    int stack[STACK], top = rest->top;
    for (int i = 0; i < top; i++) stack[i] = rest->stack[i];
    for (int e = rest->e; e >= 0;) {
        if (e < tree->shape.node_count) {
            wides begins;
            uint bits = boxes_on_ray(&slabs, tree->nodes + e, 0, limit, &begins);
            if (bits) {
                e = descend_anyhow(&tree->shape, e, bits, stack, &top);
                continue;
            }
        } else {
            taken = taken_by_leaf(tree, kind, leaf_of(tree, kind, e), ray, limit, near, taken);
            if (taken == ALL) return ALL;
        }
        e = top > 0 ? stack[--top] : -1;
    }
    return taken;
}

// TREE: what the tree has before `found`, as long as a beam pays. Returns whether that is all of it.
static bool nearest_in_beam(const Tree *tree, int kind, Hit *found, Ray ray, ints on, bool common) {
    real slack = SLACK * largest_coordinate(ray.origin, on);
    Beam beam = beam_of(ray.origin, ray.direction, on, slack, common);
    if (!(beam.width < tree->shape.wide)) return false;
    if (FACES && kind == OF_FACES && !has_one_shear(&beam, ray.direction, on)) return false;
    if (OPACITY) beam.behind = beam_begin(&beam, ray, on, slack);
    Hit hit = *found;
    int stack[STACK], top = 0, budget = tree->shape.budget * HITS, e = 0;
    real starts[STACK];
    real end = beam_end(&beam, ray.origin, ray.direction, END_OF(hit), on, slack);
    while (e >= 0 && budget > 0) {
        if (e < tree->shape.node_count) {
            wides begins;
            budget--;
            uint bits = boxes_in_beam(&beam, tree->nodes + e, end, &begins);
            if (bits) {
                e = descend(&tree->shape, e, bits, begins, stack, starts, &top);
                continue;
            }
        } else {
            __global const void *leaf = leaf_of(tree, kind, e);
            uint bits = leaf_in_beam(tree, kind, leaf, &beam, end);
            budget -= popcount(bits);
            if (nearer_in_leaf(tree, kind, leaf, bits, &beam, &hit, ray, on))
                end = beam_end(&beam, ray.origin, ray.direction, END_OF(hit), on, slack);
        }
        e = next_of(stack, starts, &top, end);
    }
    *found = hit;
    return e < 0;
}

// TREE: what the tree has before `hit`, for the rays that are on. common: they have one origin.
static Hit nearest_in_tree(const Tree *tree, int kind, Hit hit, Ray ray, ints on, bool common) {
    if (LANES > 1 && nearest_in_beam(tree, kind, &hit, ray, on, common)) return hit;
    __private reals distances[HITS] = {hit.distance};
    __private ints ids[HITS] = {hit.id};
    if (OPACITY) {
        FOR_EACH_LATER(distances[(a + 1) % HITS] = hit.later[0].distance[a];
                       ids[(a + 1) % HITS] = hit.later[0].id[a])
    }
    Rays rays = rays_of(ray);
    for (uint bits = lane_bits(on); bits; bits &= bits - 1) {
        int i = LOWEST_BIT(bits);
        Single single = single_of(&rays, i);
        nearest_single(tree, kind, &single, EACH_REAL(distances) + i, EACH_INT(ids) + i);
    }
    hit.distance = distances[0];
    hit.id = ids[0];
    if (OPACITY) {
        FOR_EACH_LATER(hit.later[0].distance[a] = distances[(a + 1) % HITS];
                       hit.later[0].id[a] = ids[(a + 1) % HITS])
    }
    return hit;
}

// What can be seen through ends no shadow ray, so all is tested in any case: a beam pays for longer.
// Measured for 10^5 atoms of opacity 0.2 (benchmarks/NOTES.md).
#define WIDER (OPACITY ? 4 : 1)
#define LONGER (OPACITY ? 16 : 1)

// TREE: what the tree leaves of shadow rays, as long as a beam pays, and the rest of it. end: along the
// beam, nothing beyond it counts.
static Left left_by_beam(const Tree *tree, int kind, const Beam *beam, real end, Rest *rest,
                         Ray ray, reals distance, ints on, bool near) {
    Left left = {on, 0};
    if (FACES && kind == OF_FACES && !has_one_shear(beam, ray.direction, on)) return left;
    int *stack = rest->stack, top = 0, e = 0;
    // Rays about a surface are wide apart: what a beam has not found soon, it does not.
    int budget = near ? tree->shape.budget / 2 : tree->shape.budget * LONGER;
    real starts[STACK];
    while (e >= 0 && budget > 0) {
        if (e < tree->shape.node_count) {
            wides begins;
            budget--;
            uint bits = boxes_in_beam(beam, tree->nodes + e, end, &begins);
            if (bits) {
                e = descend(&tree->shape, e, bits, begins, stack, starts, &top);
                continue;
            }
        } else {
            __global const void *leaf = leaf_of(tree, kind, e);
            uint bits = leaf_in_beam(tree, kind, leaf, beam, end);
            budget -= popcount(bits);
            left = left_by_leaf(tree, kind, leaf, bits, beam, left, ray, distance, on, near);
            if (!ANY(left.clear)) top = 0;
        }
        e = next_of(stack, starts, &top, INFINITY);
    }
    rest->e = e;
    rest->top = top;
    return left;
}

// TREE: what is in the tree takes of the light of rays that are on, see taken_with(); it comes from
// `light`, which is outside of all of them and at the end of the rays. near: they are rays of occlusion:
// instead all of those that meet something before that distance, glass as well; OPACITY: their part.
static ints taken_in_tree(const Tree *tree, int kind, Ray ray, reals distance, Vector light,
                          ints on, bool near) {
    Left left = {on, 0};
    Rest rest;
    rest.e = rest.top = 0;
    if (LANES > 1) {
        // From the light to the points, for it is common; not from a far one, whose rounding is large.
        real away = near ? 8 : MOST(on, largest_of(light));
        real slack = SLACK * fmax(largest_coordinate(ray.origin, on), away <= 4 ? away : (real)0);
        Vector back = scaled(ray.direction, -1);
        Beam beam = away <= 4 ? beam_of(light, back, on, slack, true)
                              : beam_of(ray.origin, ray.direction, on, slack, false);
        // Rays about a surface, and to points of a light, are wide apart: the budget says what pays.
        bool apart = near || (ROUND && RANDOM);
        if (beam.width < (apart ? INFINITY : tree->shape.wide * WIDER)) {
            real end = away <= 4 ? beam_end(&beam, ray.origin, back, 0, on, slack) : INFINITY;
            if (near) end = beam_end(&beam, ray.origin, ray.direction, distance, on, slack);
            left = left_by_beam(tree, kind, &beam, end, &rest, ray, distance, on, near);
            if (rest.e < 0) return VEILED ? left.veil : on & !left.clear;
        }
    }
    __private reals limits[1] = {distance};
    __private ints taken[1] = {VEILED ? left.veil : on & !left.clear};
    Rays rays = rays_of(ray);
    for (uint bits = lane_bits(left.clear); bits; bits &= bits - 1) {
        int i = LOWEST_BIT(bits);
        Single single = single_of(&rays, i);
        INTEGER *each = EACH_INT(taken) + i;
        *each = taken_single(tree, kind, &single, EACH_REAL(limits)[i], near, &rest, *each);
    }
    return taken[0];
}

// Beam: a packet through the tree, at first as one: four planes around its rays.

// Along the axis `m` with `sign` all its rays go forward; four planes p_a - q p_m >= c or <= c hold
// them, two for each of the axes a[0] and a[1].
typedef struct {
    int m, a[2];
    real sign, low_q[2], high_q[2], low_c[2], high_c[2];
    real behind;  // before this, along the axis, there is no ray
    real width;   // how much of a square of side 1, one unit away, it fills
} Beam;

// TREE: coordinate m of a vector.
static reals axis_of(Vector v, int m) { return m == 0 ? v.x : m == 1 ? v.y : v.z; }

// TREE: the largest coordinate of the origins of rays that are on, at least 1.
static real largest_coordinate(Vector o, ints on) { return fmax((real)1, MOST(on, largest_of(o))); }

// TREE: the beam around those rays that are on; `width` is INFINITY if they have no axis in common.
// slack: by how much it is widened. common: they have one origin, which is more exact and quicker.
static Beam beam_of(Vector o, Vector d, ints on, real slack, bool common) {
    Beam beam;
    __private reals all[3] = {d.x, d.y, d.z};
    __private const real *each = EACH_REAL(all);
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
            __private const real *origin = EACH_REAL(origins);
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

// TREE: how far along the beam's axis the rays that are on have come at distance t.
static real beam_end(const Beam *beam, Vector o, Vector d, reals t, ints on, real slack) {
    return MOST(on, (axis_of(o, beam->m) + t * axis_of(d, beam->m)) * beam->sign) + 2 * slack;
}

// OPACITY and TREE: how far along the beam's axis the rays that are on have gone straight through.
static real beam_begin(const Beam *beam, Ray ray, ints on, real slack) {
    reals from = PICK(ray.after > 0, ray.after, 0);
    reals at = axis_of(ray.origin, beam->m) + from * axis_of(ray.direction, beam->m);
    return LEAST(on, at * beam->sign) - 2 * slack;
}

// TREE: the boxes of a node that the beam meets before `end`, as bits, and where along it they begin.
static uint boxes_in_beam(const Beam *beam, __global const Node *node, real end, wides *begins) {
    __global const wides *lo = (__global const wides *)node->lo;
    __global const wides *hi = (__global const wides *)node->hi;
    wide_ints in = -1;
    for (int k = 0; k < 2; k++) {
        int a = beam->a[k];
        real lq = beam->low_q[k], hq = beam->high_q[k];
        in &= hi[a] - lq * (lq > 0 ? lo : hi)[beam->m] >= beam->low_c[k];
        in &= lo[a] - hq * (hq > 0 ? hi : lo)[beam->m] <= beam->high_c[k];
    }
    wides from = (beam->sign > 0 ? lo : hi)[beam->m] * beam->sign;
    wides to = (beam->sign > 0 ? hi : lo)[beam->m] * beam->sign;
    *begins = from;
    return wide_bits(in & (to >= beam->behind) & (from <= end));
}

// TREE: the spheres of a leaf that the beam meets before `end`, as bits.
static uint spheres_in_beam(const Beam *beam, __global const Leaf *leaf, real end) {
    __global const wides *center = (__global const wides *)leaf->center;
    wides radius = *(__global const wides *)leaf->radius, along_m = center[beam->m];
    wide_ints in = -1;
    for (int k = 0; k < 2; k++) {
        wides across = center[beam->a[k]];
        real lq = beam->low_q[k], hq = beam->high_q[k];
        in &= across - lq * along_m + radius * sqrt(1 + lq * lq) >= beam->low_c[k];
        in &= across - hq * along_m - radius * sqrt(1 + hq * hq) <= beam->high_c[k];
    }
    along_m *= beam->sign;
    return wide_bits(in & (along_m + radius >= beam->behind) & (along_m - radius <= end));
}

// QUADRATIC for a packet and sphere k of a leaf.
#define PACKET_QUADRATIC(ray, leaf, k)                                                          \
    QUADRATIC(reals, (ray).origin.x, (ray).origin.y, (ray).origin.z, (ray).direction.x,         \
              (ray).direction.y, (ray).direction.z, (leaf)->center[0][k], (leaf)->center[1][k], \
              (leaf)->center[2][k], (leaf)->radius[k])

// TREE: tests those spheres of a leaf. Returns whether one is nearer than what was hit before.
static bool nearer_in_leaf(__global const Leaf *leaf, uint bits, Hit *hit, Ray ray, ints on) {
    bool found = false;
    for (; bits; bits &= bits - 1) {
        int k = LOWEST_BIT(bits);
        PACKET_QUADRATIC(ray, leaf, k)
        ints met = on & (delta > 0) & (b < 0) & (c > 0) & near_side(ray, leaf->id[k]);
        if (!ANY(met)) continue;
        reals root = FIRST_ROOT;
        if (OPACITY) {
            met &= behind(ray, root, leaf->id[k]);
            if (!ANY(met)) continue;
        }
        *hit = closer_of(*hit, met, root, leaf->id[k]);
        found = true;
    }
    return found;
}

// TREE: what the tree has before `found`, as long as a beam pays. Returns whether that is all of it.
static bool nearest_in_beam(const Tree *tree, Hit *found, Ray ray, ints on, bool common) {
    real slack = SLACK * largest_coordinate(ray.origin, on);
    Beam beam = beam_of(ray.origin, ray.direction, on, slack, common);
    if (!(beam.width < tree->shape.wide)) return false;
    if (OPACITY) beam.behind = beam_begin(&beam, ray, on, slack);
    Hit hit = *found;
    int stack[STACK], top = 0, left = tree->shape.budget, e = 0;
    real starts[STACK];
    real end = beam_end(&beam, ray.origin, ray.direction, hit.distance, on, slack);
    while (e >= 0 && left > 0) {
        if (e < tree->shape.node_count) {
            wides begins;
            left--;
            uint bits = boxes_in_beam(&beam, tree->nodes + e, end, &begins);
            if (bits) {
                e = descend(&tree->shape, e, bits, begins, stack, starts, &top);
                continue;
            }
        } else {
            __global const Leaf *leaf = tree->leaves + (e - tree->shape.node_count);
            uint bits = spheres_in_beam(&beam, leaf, end);
            left -= popcount(bits);
            if (nearer_in_leaf(leaf, bits, &hit, ray, on))
                end = beam_end(&beam, ray.origin, ray.direction, hit.distance, on, slack);
        }
        e = next_of(stack, starts, &top, end);
    }
    *found = hit;
    return e < 0;
}

// TREE: what the tree has before `hit`, for the rays that are on. common: they have one origin.
static Hit nearest_in_tree(const Tree *tree, Hit hit, Ray ray, ints on, bool common) {
    if (LANES > 1 && nearest_in_beam(tree, &hit, ray, on, common)) return hit;
    __private reals distances[1] = {hit.distance};
    __private ints spheres[1] = {hit.id};
    Rays rays = rays_of(ray);
    for (uint bits = lane_bits(on); bits; bits &= bits - 1) {
        int i = LOWEST_BIT(bits);
        Single single = single_of(&rays, i);
        nearest_single(tree, &single, EACH_REAL(distances) + i, EACH_INT(spheres) + i);
    }
    hit.distance = distances[0];
    hit.id = spheres[0];
    return hit;
}

// What is left of shadow rays on their way.
typedef struct {
    ints clear;  // the lanes that something is left of
    ints veil;   // VEILED: what has been taken, see veiled()
} Left;

// TREE: tests those spheres of a leaf against shadow rays that end at `distance`, see taken_in_tree().
static Left left_by_leaf(const Tree *tree, __global const Leaf *leaf, uint bits, Left left, Ray ray,
                         reals distance, ints on, bool near) {
    for (; bits; bits &= bits - 1) {
        int k = LOWEST_BIT(bits);
        PACKET_QUADRATIC(ray, leaf, k)
        ints met = (delta > 0) & (b < 0) & (c > 0) & near_side(ray, leaf->id[k]) &
                   ((near ? FIRST_ROOT : -b) < distance);
        if (VEILED) {
            met &= on;
            if (!ANY(met)) continue;
            bool all = near && !OPACITY;
            left.veil = veiled(left.veil, met, all ? OPAQUE : tree->glass[leaf->id[k]].veil);
        } else {
            left.clear &= !met;
        }
    }
    if (VEILED) left.clear = on & (left.veil < OPAQUE);
    return left;
}

// TREE: what the tree leaves of shadow rays, as long as a beam pays. end: along the beam, no sphere
// beyond it counts. Returns whether that is all of it.
static bool left_by_beam(const Tree *tree, const Beam *beam, real end, Left *found, Ray ray,
                         reals distance, ints on, bool near) {
    Left left = *found;
    int stack[STACK], top = 0, budget = tree->shape.budget, e = 0;
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
            __global const Leaf *leaf = tree->leaves + (e - tree->shape.node_count);
            uint bits = spheres_in_beam(beam, leaf, end);
            budget -= popcount(bits);
            left = left_by_leaf(tree, leaf, bits, left, ray, distance, on, near);
            if (!ANY(left.clear)) top = 0;
        }
        e = next_of(stack, starts, &top, INFINITY);
    }
    *found = left;
    return e < 0;
}

// TREE: what spheres of the tree take of the light of rays that are on, see taken_with(); it comes from
// `light`, which is outside of all of them and at the end of the rays. near: instead all of those that
// meet a sphere before that distance, glass as well; OPACITY: their part.
static ints taken_in_tree(const Tree *tree, Ray ray, reals distance, Vector light, ints on,
                          bool near) {
    Left left = {on, 0};
    if (LANES > 1) {
        // From the light to the points, for it is common; not from a far one, whose rounding is large.
        real away = near ? 8 : MOST(on, largest_of(light));
        real slack = SLACK * fmax(largest_coordinate(ray.origin, on), away <= 4 ? away : (real)0);
        Vector back = scaled(ray.direction, -1);
        Beam beam = away <= 4 ? beam_of(light, back, on, slack, true)
                              : beam_of(ray.origin, ray.direction, on, slack, false);
        // Rays about a surface are wide apart, but most end near by: the budget says what pays.
        if (beam.width < (near ? INFINITY : tree->shape.wide)) {
            real end = away <= 4 ? beam_end(&beam, ray.origin, back, 0, on, slack) : INFINITY;
            if (near) end = beam_end(&beam, ray.origin, ray.direction, distance, on, slack);
            if (left_by_beam(tree, &beam, end, &left, ray, distance, on, near))
                return VEILED ? left.veil : on & !left.clear;
        }
    }
    __private reals limits[1] = {distance};
    // From the start: what the beam has met would count twice.
    __private ints taken[1] = {VEILED ? PICK_INT(left.clear, 0, left.veil) : on & !left.clear};
    Rays rays = rays_of(ray);
    for (uint bits = lane_bits(left.clear); bits; bits &= bits - 1) {
        int i = LOWEST_BIT(bits);
        Single single = single_of(&rays, i);
        EACH_INT(taken)[i] = taken_single(tree, &single, EACH_REAL(limits)[i], near);
    }
    return taken[0];
}

// Beam: a packet as one, four planes around its rays, against boxes and spheres of a tree.

// Along the axis `m` with `sign` all its rays go forward; four planes p_a - q p_m >= c or <= c hold
// them, two for each of the axes a[0] and a[1].
typedef struct {
    int m, a[2];
    real sign, low_q[2], high_q[2], low_c[2], high_c[2];
    real behind;  // before this, along the axis, there is no ray
    real width;   // how much of a square of side 1, one unit away, it fills
} Beam;

// Does one thing for each of those two axes, a[k], where k is a constant: a loop would choose a beam's numbers
// anew at each box.
#define FOR_BOTH_AXES(thing) \
    {                        \
        enum { k = 0 };      \
        thing;               \
    }                        \
    {                        \
        enum { k = 1 };      \
        thing;               \
    }

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
    if (!common) {
        // They may be far apart: their mean goes forward with more of them than the first one does.
        x = JOIN(total, LANES)(PICK(on, d.x, 0));
        y = JOIN(total, LANES)(PICK(on, d.y, 0));
        z = JOIN(total, LANES)(PICK(on, d.z, 0));
    }
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
    reals from = larger(ray.passed[0].distance, 0);
    reals at = axis_of(ray.origin, beam->m) + from * axis_of(ray.direction, beam->m);
    return LEAST(on, at * beam->sign) - 2 * slack;
}

// TREE: the boxes of a node that the beam meets before `end`, as bits, and where along it they begin.
static uint boxes_in_beam(const Beam *beam, __global const Node *node, real end, wides *begins) {
    __global const wides *lo = (__global const wides *)node->lo;
    __global const wides *hi = (__global const wides *)node->hi;
    wide_ints in = -1;
    FOR_BOTH_AXES(int across = beam->a[k]; real lq = beam->low_q[k]; real hq = beam->high_q[k];
                  in &= hi[across] - lq * (lq > 0 ? lo : hi)[beam->m] >= beam->low_c[k];
                  in &= lo[across] - hq * (hq > 0 ? hi : lo)[beam->m] <= beam->high_c[k])
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
    FOR_BOTH_AXES(wides across = center[beam->a[k]]; real lq = beam->low_q[k];
                  real hq = beam->high_q[k];
                  in &= across - lq * along_m + radius * sqrt(1 + lq * lq) >= beam->low_c[k];
                  in &= across - hq * along_m - radius * sqrt(1 + hq * hq) <= beam->high_c[k])
    along_m *= beam->sign;
    return wide_bits(in & (along_m + radius >= beam->behind) & (along_m - radius <= end));
}

// QUADRATIC for a packet and sphere k of a leaf.
#define PACKET_QUADRATIC(ray, leaf, k)                                                          \
    QUADRATIC(reals, (ray).origin.x, (ray).origin.y, (ray).origin.z, (ray).direction.x,         \
              (ray).direction.y, (ray).direction.z, (leaf)->center[0][k], (leaf)->center[1][k], \
              (leaf)->center[2][k], (leaf)->radius[k])

// TREE: tests those spheres of a leaf. Returns whether one is nearer than what was hit before.
static bool nearer_spheres(const Tree *tree, __global const Leaf *leaf, uint bits, Hit *hit,
                           Ray ray, ints on) {
    bool found = false;
    for (; bits; bits &= bits - 1) {
        int k = LOWEST_BIT(bits);
        PACKET_QUADRATIC(ray, leaf, k)
        ints met = on & (delta > 0) & (b < 0) & (c > 0) & near_side(ray, leaf->id[k]);
        if (!ANY(met)) continue;
        reals root = FIRST_ROOT;
        if (OPACITY) {
            met &= behind(ray, root, leaf->id[k]) & (root <= END_OF(*hit));
            if (!ANY(met)) continue;
        }
        MEET(*hit, met, root, leaf->id[k], tree->glass)
        found = true;
    }
    return found;
}

// What is left of shadow rays on their way.
typedef struct {
    ints clear;  // the lanes that something is left of
    ints veil;   // VEILED: what has been taken, see veiled()
} Left;

// TREE: what is left of shadow rays after thing `id` of a leaf, which some of them meet. near: see
// taken_in_tree().
static Left left_after(const Tree *tree, Left left, int id, ints met, bool near) {
    if (VEILED) {
        bool all = near && !OPACITY;
        left.veil = veiled(left.veil, met, all ? OPAQUE : tree->glass[id].veil);
    } else {
        left.clear &= !met;
    }
    return left;
}

// TREE: tests those spheres of a leaf against shadow rays that end at `distance`, see taken_in_tree().
static Left left_by_spheres(const Tree *tree, __global const Leaf *leaf, uint bits, Left left,
                            Ray ray, reals distance, ints on, bool near) {
    for (; bits; bits &= bits - 1) {
        int k = LOWEST_BIT(bits);
        PACKET_QUADRATIC(ray, leaf, k)
        ints met = (delta > 0) & (b < 0) & (c > 0) & near_side(ray, leaf->id[k]);
        if (near && !ANY(met)) continue;  // a root costs as much as all before
        met &= (near ? FIRST_ROOT : -b) < distance;
        if (VEILED) {
            met &= on;
            if (!ANY(met)) continue;
        }
        left = left_after(tree, left, leaf->id[k], met, near);
    }
    if (VEILED) left.clear = on & (left.veil < OPAQUE);
    return left;
}

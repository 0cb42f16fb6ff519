// Cone: what spheres of the tree cover of a round light, sphere by sphere for all lanes while that pays,
// then ray by ray. Sums of whole numbers are the same either way.

// Where a light is seen from: a cone, from a ball around the points to the light's.
typedef struct {
    Single line;  // from the middle of the points to that of the light
    Slabs slabs;
    real begin;    // the radius of the ball around the points
    real opening;  // by how much the cone is wider, for each unit along the line
    real steep;    // 1 / the cosine of the angle between its side and the line
    real end;      // on the line
} Cone;

// ROUND and TREE: the cone of a line from a ball of radius `begin` to one of that radius, so far away.
static Cone cone_of(const Single *line, real begin, real radius, real distance) {
    Cone view;
    view.line = *line;
    view.slabs = slabs_of(line);
    view.begin = begin;
    real slope = (radius - begin) / distance;
    // Towards 90 degrees a cone meets whatever is ahead.
    view.steep = 1 / sqrt(fmax(1 - slope * slope, REAL(1e-6)));
    view.opening = fmax(slope, (real)0) * (1 + 16 * UNIT_ROUNDOFF);
    view.end = distance + radius;
    return view;
}

// ROUND and TREE: the boxes of a node that a cone meets, as bits: those around which there is a point of
// the line as near as the cone is wide where they end.
static uint boxes_in_cone(const Cone *view, __global const Node *node) {
    __global const wides *lo = (__global const wides *)node->lo;
    __global const wides *hi = (__global const wides *)node->hi;
    wides far = -(view->line.o[0] * view->line.d[0] +
                  (view->line.o[1] * view->line.d[1] + view->line.o[2] * view->line.d[2]));
    for (int a = 0; a < 3; a++) far += (view->slabs.forward[a] ? hi : lo)[a] * view->line.d[a];
    far = far < view->end ? far : view->end;
    wides width = (view->begin + view->opening * (far > 0 ? far : 0)) * view->steep,
          from = -view->begin, to = view->end;
    for (int a = 0; a < 3; a++) {
        wides wider = view->slabs.forward[a] ? -width : width;
        wides near_ = (view->slabs.forward[a] ? lo : hi)[a] + wider;
        wides far_side = (view->slabs.forward[a] ? hi : lo)[a] - wider;
        wides enter = near_ * view->slabs.inverse[a] + view->slabs.enter[a];
        wides leave = far_side * view->slabs.inverse[a] + view->slabs.leave[a];
        from = enter > from ? enter : from;
        to = leave < to ? leave : to;
    }
    // The ends are rounded in proportion to themselves.
    wides slack = (from > 0 ? from : -from) * (16 * UNIT_ROUNDOFF);
    return wide_bits((far > -view->begin) & (from - slack <= to + slack));
}

// ROUND and TREE: the spheres of a leaf that a cone meets, as bits.
static uint spheres_in_cone(const Cone *view, __global const Leaf *leaf) {
    __global const wides *center = (__global const wides *)leaf->center;
    wides radius = *(__global const wides *)leaf->radius;
    wides x = center[0] - view->line.o[0], y = center[1] - view->line.o[1],
          z = center[2] - view->line.o[2];
    wides t = x * view->line.d[0] + (y * view->line.d[1] + z * view->line.d[2]);
    x -= t * view->line.d[0], y -= t * view->line.d[1], z -= t * view->line.d[2];
    wides far = t + radius < view->end ? t + radius : view->end;
    wides reach =
        (view->begin + view->opening * (far > 0 ? far : 0)) * view->steep + radius + SLACK;
    return wide_bits((far > -view->begin - SLACK) & (t - radius < view->end * (1 + SLACK)) &
                     (x * x + (y * y + z * z) <= reach * reach));
}
// ROUND and TREE: adds sphere k of a leaf, for the rays that are on.
static Cover covered_by_sphere(const Tree *tree, Cover cover, Ray ray, Cap cap, ints on,
                               __global const Leaf *leaf, int k) {
    Vector f = vector(leaf->center[0][k] - ray.origin.x, leaf->center[1][k] - ray.origin.y,
                      leaf->center[2][k] - ray.origin.z);
    reals r = leaf->radius[k];
    reals c = FMA(-r, r, FMA(f.x, f.x, FMA(f.y, f.y, f.z * f.z)));
    int id = leaf->id[k];
    return covered(cover, cap, on & near_side(ray, id), f, r, c, 0,
                   VEILED ? tree->glass[id].veil : 0);
}

// ROUND and TREE: the line from the middle of the rays' origins to that of the light, and how far they
// are from there at most, `begin`, and how long it is.
static Single middle_line(Ray ray, ints on, __global const real *light, real *begin,
                          real *distance) {
    Single line;
    __private real *o = line.o, *d = line.d;
    o[0] = (LEAST(on, ray.origin.x) + MOST(on, ray.origin.x)) / 2;
    o[1] = (LEAST(on, ray.origin.y) + MOST(on, ray.origin.y)) / 2;
    o[2] = (LEAST(on, ray.origin.z) + MOST(on, ray.origin.z)) / 2;
    Vector apart = minus(ray.origin, vector(o[0], o[1], o[2]));
    real length2 = 0;
    *begin = sqrt(MOST(on, dot3(apart, apart)));
    for (int a = 0; a < 3; a++) {
        d[a] = light[a] - o[a];
        length2 += d[a] * d[a];
    }
    *distance = sqrt(length2);
    for (int a = 0; a < 3; a++) d[a] /= *distance;
    return line;
}

// ROUND and TREE: what the tree's spheres cover of a light, a ball around `light` of that radius, beside
// what others do, as long as one cone around all rays pays. Returns whether that is all of it; else
// nothing is added.
static bool covered_in_cone(const Tree *tree, Cover *cover, Ray ray, Cap cap, ints on,
                            __global const real *light, real radius) {
    real begin, distance;
    Single line = middle_line(ray, on, light, &begin, &distance);
    if (!(distance > begin + radius)) return false;
    Cone view = cone_of(&line, begin + SLACK, radius, distance);
    Cover sum = *cover;
    int stack[STACK], top = 0, left = tree->shape.budget, e = 0;
    while (e >= 0 && left > 0) {
        if (e < tree->shape.node_count) {
            left--;
            uint bits = boxes_in_cone(&view, tree->nodes + e);
            if (bits) {
                e = descend_anyhow(&tree->shape, e, bits, stack, &top);
                continue;
            }
        } else {
            __global const Leaf *leaf = leaf_of(tree, OF_SPHERES, e);
            uint bits = spheres_in_cone(&view, leaf);
            left -= popcount(bits);
            for (; bits; bits &= bits - 1)
                sum = covered_by_sphere(tree, sum, ray, cap, on, leaf, LOWEST_BIT(bits));
            if (!ANY(on & (sum.hidden < (INTEGER)VEIL))) top = 0;
        }
        e = top > 0 ? stack[--top] : -1;
    }
    if (e >= 0) return false;
    *cover = sum;
    return true;
}

// ROUND and TREE: adds the spheres of a leaf for one ray, as many at a time as there are lanes.
static Cover covered_by_leaf(const Tree *tree, Cover cover, const Single *ray, Cap cap,
                             __global const Leaf *leaf) {
    for (int first = 0; first < WIDE; first += LANES) {
        ints id = TO_INTS(*(__global const LANES_OF(int) *)(leaf->id + first));
        Vector f = vector(*(__global const reals *)(leaf->center[0] + first) - ray->o[0],
                          *(__global const reals *)(leaf->center[1] + first) - ray->o[1],
                          *(__global const reals *)(leaf->center[2] + first) - ray->o[2]);
        reals radius = *(__global const reals *)(leaf->radius + first);
        reals c = FMA(-radius, radius, FMA(f.x, f.x, FMA(f.y, f.y, f.z * f.z)));
        ints met = id != ray->leaves;
        FOR_EACH_LAYER(met &= id + 1 != ray->inside[i])
        __private ints takes[1] = {0};
        for (int k = 0; VEILED && k < LANES; k++)
            if (leaf->id[first + k] >= 0)
                EACH_INT(takes)[k] = tree->glass[leaf->id[first + k]].veil;
        cover = covered(cover, cap, met, f, radius, c, 0, takes[0]);
    }
    return cover;
}

// ROUND and TREE: the sum of the lanes, at most OPAQUE.
static INTEGER sum_of_ints(ints n) {
    __private const INTEGER *each = EACH_INT(n);
    long sum = 0;
    for (int i = 0; i < LANES; i++) sum += each[i];
    return (INTEGER)min(sum, (long)OPAQUE);
}

// ROUND and TREE: what the tree's spheres cover of a light as one ray sees it.
static Cover covered_single(const Tree *tree, const Single *ray, Cap cap, const Cone *view) {
    Cover sum = {0};
    int stack[STACK], top = 0;
    for (int e = 0; e >= 0;) {
        if (e < tree->shape.node_count) {
            uint bits = boxes_in_cone(view, tree->nodes + e);
            if (bits) {
                e = descend_anyhow(&tree->shape, e, bits, stack, &top);
                continue;
            }
        } else {
            __global const Leaf *leaf = leaf_of(tree, OF_SPHERES, e);
            sum = covered_by_leaf(tree, sum, ray, cap, leaf);
            if (sum_of_ints(sum.hidden) >= (INTEGER)VEIL) top = 0;
        }
        e = top > 0 ? stack[--top] : -1;
    }
    return sum;
}

// ROUND and TREE: what the tree's spheres cover of a light, a ball around `light` of that radius, beside
// what others do, for the rays that are on.
static Cover covered_in_tree(const Tree *tree, Cover cover, Ray ray, Cap cap, ints on,
                             __global const real *light, real radius) {
    if (!ANY(on)) return cover;
    if (LANES > 1 && covered_in_cone(tree, &cover, ray, cap, on, light, radius)) return cover;
    __private Cover covers[1] = {cover};
    __private INTEGER *hidden = EACH_INT(covers[0].hidden), *veil = EACH_INT(covers[0].veil);
    __private Cap caps[1] = {cap};
    Rays rays = rays_of(ray);
    for (uint bits = lane_bits(on); bits; bits &= bits - 1) {
        int i = LOWEST_BIT(bits);
        Single single = single_of(&rays, i);
        Cap own;
        own.to = vector(single.d[0], single.d[1], single.d[2]);
        own.angle = EACH_REAL(caps[0].angle)[i];
        own.sine = EACH_REAL(caps[0].sine)[i], own.cosine = EACH_REAL(caps[0].cosine)[i];
        own.versine = EACH_REAL(caps[0].versine)[i];
        own.distance = EACH_REAL(caps[0].distance)[i];
        real far = EACH_REAL(caps[0].distance)[i];
        Cone view = cone_of(&single, SLACK, EACH_REAL(caps[0].sine)[i] * far, far);
        Cover sum = covered_single(tree, &single, own, &view);
        hidden[i] = min(hidden[i] + sum_of_ints(sum.hidden), (INTEGER)VEIL);
        if (VEILED) veil[i] = min(veil[i] + sum_of_ints(sum.veil), OPAQUE);
    }
    return covers[0];
}

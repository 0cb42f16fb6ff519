// Spheres: nearest and occluded, both from one quadratic.
//
// A ray o + t d, |d| = 1, meets the sphere |p - C| = r where t^2 + 2 b t + c = 0, with f = o - C,
// b = f.d and c = |f|^2 - r^2 (the paper, section 11.4, has 2 b). It is hit iff
// delta = b^2 - c > 0 and both roots are positive, that is b < 0 and c > 0: a sphere cannot be seen
// from inside.
//
// LITERAL is the baseline that the rest is measured against. The host makes no sphere a giant then.

// NEST or OPACITY: of each sphere of the scene's list. 8 bytes as float32, 16 as float64; with OPACITY 12
// and 24.
#if OPACITY
typedef struct {
    INTEGER order;  // of transparent spheres: the larger, the smaller the sphere; 0: opaque
    INTEGER veil;   // what it takes of a shadow ray that enters it, see veiled()
    real opacity;
} Glass;
#define OPACITY_OF(glass) ((glass).opacity)
#else
typedef struct {
    INTEGER order;
    INTEGER veil;
} Glass;
#define OPACITY_OF(glass) 1
#endif

// 64 bytes as float32, one cache line; 120 as float64. Written by clrt/renderer/pack/spheres.py. In camera space,
// see camera.cl.
typedef struct {
    real anchor[3];         // a giant's surface point nearest the camera; else the centre
    real c0;                // |offset|^2 - radius^2, from float64
    real offset[3];         // anchor - centre
    real camera_c;          // |centre|^2 - radius^2, from float64: c of a ray from the camera
    real screen_bounds[4];  // where it can show on the screen: left, right, bottom, top
    real inv_radius;        // 1 / radius
    real horizon;           // a light with N.L below this is hidden by the sphere that N stands on
    int giant;              // 1: radius > 4 x the camera's distance from the surface
    int material;           // index
} Sphere;

// NEST: a transparent sphere that a ray is inside of, each lane its own.
typedef struct {
    ints sphere;  // index + 1; 0: none
    ints order;   // as in Glass
    reals ior;    // index of refraction
} Layer;

// NEST: all of them, the smallest first, see glass.cl.
#define MAX_INSIDE (NEST > 0 ? NEST : 1)  // an array has an element
typedef struct {
    Layer layers[MAX_INSIDE];
} Inside;

// Does one thing for each `i` of these layers, which are four at most (MOST of clrt/renderer/glass.py). No loop:
// what is indexed by no constant stays in memory until loops are unrolled, which is late, and all else
// of a path with it.
#define FOR_EACH_LAYER(thing) LAYER(0, thing) LAYER(1, thing) LAYER(2, thing) LAYER(3, thing)
#define LAYER(number, thing) \
    if (NEST > number) {     \
        enum { i = number }; \
        thing;               \
    }

// OPACITY: the last surface that a ray went straight through. Nothing is met before it.
typedef struct {
    reals distance;  // along the ray; -INFINITY: none yet
    ints id;
} Passed;

// A ray of each lane, in the spheres' space. Without OPACITY there is none of `passed`, not even room.
typedef struct {
    Vector origin;
    Vector direction;  // unit length
    ints leaves;       // the index of the sphere that the origin lies on. It is never hit: a ray
                       // that leaves a convex body does not come back, so no epsilon is needed.
    int all_leave;     // that index if it is the same in all lanes that count, else -1
    Inside inside;
    Passed passed[ROOM(OPACITY)];
} Ray;

// OPACITY: of rays that have gone through nothing yet.
static Passed nothing_passed(void) {
    Passed none = {-INFINITY, -1};
    return none;
}

// OPACITY: whether what a ray meets at a distance is behind the last that it went straight through. Of
// equal distances the spheres come in the order of the list: so none is met twice, and none is missed.
static ints behind(Ray ray, reals distance, ints id) {
    reals last = ray.passed[0].distance;
    return (distance > last) | ((distance == last) & (id > ray.passed[0].id));
}

// The lanes whose ray is inside of sphere s: none without NEST.
static ints is_inside(Ray ray, ints s) {
    ints in = 0;
    FOR_EACH_LAYER(in |= ray.inside.layers[i].sphere == s + 1)
    return in;
}

// Parts of a light as whole numbers, see veiled() and Cover.
#define VEIL ((real)(DOUBLE ? 1099511627776 : 8388608))

// Glass that a shadow ray enters multiplies its light, as does what is seen through. The product is kept
// as a sum of -log2(T), in whole units of 2^-23 (DOUBLE: 2^-40), so that it is the same in any order to the last bit; each
// factor is off by up to 4e-8. What is opaque adds OPAQUE, which is also the most that there is. OPACITY:
// of what is not opaque the most is one less, for some of the light is left.
#define OPAQUE ((INTEGER)(128 * VEIL) - 1)

// NEST or OPACITY: a veil, and in the lanes that have met it what one more sphere takes.
static ints veiled(ints veil, ints met, ints more) {
    ints sum = veil + PICK_INT(met, more, 0), most = OPAQUE;
    if (OPACITY) most -= PICK_INT((veil < OPAQUE) & (!met | (more < OPAQUE)), 1, 0);
    return PICK_INT(sum < most, sum, most);
}

// NEST or OPACITY: the same for one ray.
static INTEGER veiled_single(INTEGER veil, INTEGER more) {
    INTEGER sum = veil + more, most = OPAQUE;
    if (OPACITY && veil < OPAQUE && more < OPAQUE) most -= 1;
    return min(sum, most);
}

// What spheres take of shadow rays is a veil, or without VEILED the mask of those that are hidden. This
// adds a sphere that is met.
static ints taken_with(ints taken, ints met, ints more) {
    return VEILED ? veiled(taken, met, more) : taken | met;
}

// The shadow rays that nothing is left of.
static ints takes_all(ints taken) { return VEILED ? taken >= OPAQUE : taken; }

// Of a ray and a sphere, see above.
typedef struct {
    reals b, c, delta;
} Quadratic;

// The split. A sphere is measured from its anchor A, with m = A - C, c0 = |m|^2 - r^2 and
// g = o - A = f - m. Let l = g - (g.d) d be the part of g across the ray, and
// e = l.(l + 2 m) + c0; then
//   b = g.d + m.d,   c = (g.d)(g.d + 2 m.d) + e,   delta = (m.d)^2 - e.
// - delta is not b^2 - c, which loses the digits of r^2 against |f|^2 where a sphere is far against
//   its radius. e does not: a silhouette is off by at most 4 * 2^-24 (|f| + r).
// - Of a giant, whose radius is large against its distance from the camera, A is the surface point
//   nearest the camera. |f|^2 - r^2 would be off by 2^-24 r of a distance to its surface, 5e-4 for
//   r = 9000; with a small g a hit is off by at most 4 * 2^-24 (|g| + t).
// - Of the others A = C, m = 0: delta = r^2 - |l|^2 (Haines et al., Ray Tracing Gems, 2019,
//   chapter 7).
//   c = |f|^2 - r^2 is as good as (f.d)^2 - delta there, and does not need |d| = 1 to the last bit.
// tests/test_rays.py holds these bounds against a million rays each.
static Quadratic quadratic(Ray ray, __global const Sphere *sphere) {
    Quadratic q;
    Vector g = minus(ray.origin, splat(sphere->anchor));
    q.b = dot3(g, ray.direction);
    if (LITERAL) {
        q.c = dot3(g, g) + sphere->c0;
        q.delta = q.b * q.b - q.c;
        return q;
    }
    Vector l = along(g, -q.b, ray.direction);
    if (sphere->giant) {
        Vector m = splat(sphere->offset);
        reals md = dot3(m, ray.direction);
        reals e = dot3(l, along(l, 2, m)) + sphere->c0;
        q.c = q.b * (q.b + 2 * md) + e;
        q.delta = md * md - e;
        q.b += md;
    } else {
        q.c = dot3(g, g) + sphere->c0;
        q.delta = -sphere->c0 - dot3(l, l);
    }
    return q;
}

// The rays that meet sphere s from outside, ahead of their origin.
static ints ahead(Quadratic q, Ray ray, int s) {
    ints hit = (q.delta > 0) & (q.b < 0) & (q.c > 0);
    if (!LITERAL) hit &= ray.leaves != s;
    if (NEST && ANY(ray.inside.layers[0].sphere != 0)) hit &= !is_inside(ray, s);
    return hit;
}

// Where a ray enters a sphere: not -b - sqrt(delta), which cancels near a surface. NaN where it misses.
static reals smaller_root(Quadratic q) {
    if (LITERAL) return -q.b - sqrt(q.delta);
    return q.c / (sqrt(q.delta) - q.b);
}

// Does one thing for each axis `a`, which is a constant: see FOR_EACH_LAYER.
#define FOR_EACH_AXIS(thing) AXIS(0, thing) AXIS(1, thing) AXIS(2, thing)
#define AXIS(number, thing)  \
    {                        \
        enum { a = number }; \
        thing;               \
    }

// OPACITY and TREE: what stands behind a hit, nearer things first: one walk through the trees finds all of
// them (Amstutz et al., "An evaluation of multi-hit ray traversal in a BVH", 2015; how many:
// benchmarks/NOTES.md). Behind what is opaque is nothing: its distance stands there, with the number
// NO_MORE.
#define LATER 3
#define NO_MORE 0x7fffffff
typedef struct {
    reals distance[LATER];
    ints id[LATER];
    int left;  // of them, in all lanes, until rays must walk again
} Later;

// Does one thing for each `i` of those, see FOR_EACH_LAYER.
#define FOR_EACH_LATER(thing) FOR_EACH_AXIS(thing)

// What nearest() and visible() find in each lane.
typedef struct {
    ints id;         // of what is hit first; -1: nothing
    reals distance;  // in units of the ray's direction
    Later later[ROOM(OPACITY && TREE)];
    int common;  // if any lane hits, the sphere that was last found closer in any of them
} Hit;

// Of lanes that have hit nothing yet.
static Hit no_hit(void) {
    Hit none = {.id = -1, .distance = INFINITY};
    if (OPACITY && TREE) {
        FOR_EACH_LATER(none.later[0].distance[a] = INFINITY; none.later[0].id[a] = -1)
    }
    return none;
}

// Sphere s of a list where it is nearer than what was hit before. Of equal distances the first of the
// list counts.
static Hit closer(Hit hit, ints candidates, reals distance, int s) {
    ints mask = candidates & (distance < hit.distance);
    hit.id = PICK_INT(mask, s, hit.id);
    hit.distance = PICK(mask, distance, hit.distance);
    if (ANY(mask)) hit.common = s;
    return hit;
}

// The spheres of the scene's list that rays meet first.
static Hit nearest(Ray ray, __global const Sphere *spheres, int sphere_count) {
    Hit hit = no_hit();
    for (int s = 0; s < sphere_count; s++) {
        if (s == ray.all_leave) continue;
        Quadratic q = quadratic(ray, spheres + s);
        ints candidates = ahead(q, ray, s);
        if (!ANY(candidates)) continue;
        reals root = smaller_root(q);
        if (OPACITY) candidates &= behind(ray, root, s);
        hit = closer(hit, candidates, root, s);
    }
    return hit;
}

// OCCLUSION: the rays that meet a sphere of a list before that distance, glass as well; OPACITY: what
// those take of them. ids: their places in the scene's list, 0 if they are that list.
static ints met_before(Ray ray, reals distance, __global const Sphere *spheres,
                       __global const int *ids, __global const Glass *glass, int sphere_count) {
    ints found = 0;
    for (int i = 0; i < sphere_count; i++) {
        int s = ids ? ids[i] : i;
        if (s == ray.all_leave) continue;
        Quadratic q = quadratic(ray, spheres + i);
        ints met = ahead(q, ray, s);
        if (!ANY(met)) continue;
        met &= smaller_root(q) < distance;
        found = OPACITY ? veiled(found, met, glass[s].veil) : found | met;
    }
    return found;
}

// What the spheres of the scene's list take of a light that is `distance` away, see taken_with().
// A light outside a sphere that the ray meets lies before both roots or beyond both: it is hidden iff
// it is beyond their middle, -b, half a chord from either. The host knows the spheres that the light is
// inside of, `encloses`: here the sign of t^2 + 2 b t + c at the light is off by 2^-24 distance^2.
static ints occluded(Ray ray, reals distance, __global const uchar *encloses,
                     __global const Sphere *spheres, __global const Glass *glass,
                     int sphere_count) {
    ints hidden = 0;
    for (int s = 0; s < sphere_count; s++) {
        if (s == ray.all_leave) continue;
        Quadratic q = quadratic(ray, spheres + s);
        ints met = ahead(q, ray, s);
        if (LITERAL) {
            met &= smaller_root(q) < distance;
        } else if (!LIGHT_INSIDE || !encloses[s]) {
            met &= -q.b < distance;
        }
        hidden = taken_with(hidden, met, VEILED ? glass[s].veil : 0);
    }
    return hidden;
}

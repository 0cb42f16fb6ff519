// Spheres: nearest and occluded, both from one quadratic.
//
// A ray o + t d, |d| = 1, meets the sphere |p - C| = r where t^2 + 2 b t + c = 0, with f = o - C,
// b = f.d, c = |f|^2 - r^2 (half of the paper's b, section 11.4; Glassner, An Introduction to Ray
// Tracing, 1989). It is hit iff delta = b^2 - c > 0 and both roots are positive, that is b < 0 and
// c > 0: a sphere cannot be seen from inside.

// 64 bytes as float32, one cache line; 120 as float64. Written by clrt/pack.py.
typedef struct {
    real anchor[3];    // camera space, world units: the centre; of a giant, see below
    real c0;           // giant: |offset|^2 - radius^2, from float64; else 0
    real offset[3];    // giant: anchor - centre; else 0
    real inv_radius;   // 1 / radius
    real radius2;      // radius^2
    real horizon;      // a light with N.L below this is hidden by the sphere that N stands on
    int giant;         // 1: radius > 30 x the camera's distance from the surface
    int material;      // index
} Sphere;

typedef struct {
    Vector origin;     // camera space
    Vector direction;  // unit length
    ints leaves;       // the index of the sphere that the origin lies on, or -1. It is never hit:
                       // a ray that leaves a convex body does not come back, so no epsilon.
} Ray;

typedef struct {
    reals b, c, delta;
} Quadratic;

// The split. Both branches guard against cancellation, each where the other would suffer from it:
// - |f|^2 - r^2 of a giant would lose all digits of a distance to its surface that is small against
//   r: float32 leaves an error of r 2^-24, 5e-4 for r = 9000. So a giant is measured from its
//   surface point A nearest the camera, with g = o - A and m = A - C: c = |g|^2 + 2 g.m + c0, whose
//   error is of the order of 2^-24 |g| r in c, which moves the surface by 2^-24 |g|.
// - b^2 - c of a small far sphere would lose the digits of r^2 against |f|^2. So the others take
//   delta = r^2 - |f - (f.d) d|^2 (Haines et al., Ray Tracing Gems, 2019, chapter 7): a silhouette
//   is off by at most 4 * 2^-24 |f|, which is the rounding of f and d themselves.
static Quadratic quadratic(Ray ray, __global const Sphere *sphere) {
    Quadratic q;
    Vector g = minus(ray.origin, splat(sphere->anchor));
    if (sphere->giant) {
        Vector m = splat(sphere->offset);
        q.b = dot3(g, ray.direction) + dot3(m, ray.direction);
        q.c = dot3(g, g) + (2 * dot3(g, m) + sphere->c0);
        q.delta = q.b * q.b - q.c;
    } else {
        q.b = dot3(g, ray.direction);
        q.c = dot3(g, g) - sphere->radius2;
        Vector l = along(g, -q.b, ray.direction);
        q.delta = sphere->radius2 - dot3(l, l);
    }
    return q;
}

static ints ahead(Quadratic q) { return (q.delta > 0) & (q.b < 0) & (q.c > 0); }

// The index of the sphere hit first and its distance; -1 and infinity where there is none. Of equal
// distances the first sphere of the list counts.
static ints nearest(Ray ray, __global const Sphere *spheres, int sphere_count, reals *distance) {
    ints hit = -1;
    *distance = INFINITY;
    for (int s = 0; s < sphere_count; s++) {
        Quadratic q = quadratic(ray, spheres + s);
        ints closer = ahead(q) & (ray.leaves != s);
        if (ANY(closer)) {
            // Not -b - sqrt(delta), which cancels near a surface. Lanes that miss hold NaN here.
            reals t = q.c / (sqrt(q.delta) - q.b);
            closer &= t < *distance;
            *distance = PICK(closer, t, *distance);
            hit = PICK_INT(closer, s, hit);
        }
    }
    return hit;
}

// Whether some sphere is hit nearer than `distance`. The roots of t^2 + 2 b t + c are positive, so
// the smaller one is less than `distance` iff the polynomial's vertex -b is, or its value at
// `distance` is negative (the light is inside the sphere): no square root is needed.
static ints occluded(Ray ray, reals distance, __global const Sphere *spheres, int sphere_count) {
    ints hidden = 0;
    for (int s = 0; s < sphere_count; s++) {
        Quadratic q = quadratic(ray, spheres + s);
        reals at_light = distance * (distance + 2 * q.b) + q.c;
        hidden |= ahead(q) & (ray.leaves != s) & ((-q.b < distance) | (at_light < 0));
    }
    return hidden;
}

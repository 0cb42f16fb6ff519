// Glass: rays that go through spheres (paper, section 8: transmitted rays).
//
// A ray knows which spheres it is inside of. Of those it meets the far side, of the others the near
// side. The medium of a point is the smallest transparent sphere around it, whichever way a ray came
// there.

// NEST: a transparent sphere that the camera is inside of. 12 bytes as float32, 16 as float64.
typedef struct {
    int sphere;  // index + 1; 0: none
    int order;   // see Glass
    real ior;
} Medium;

// NEST: PICK for a layer.
static Layer pick_layer(ints mask, Layer yes, Layer no) {
    Layer layer = {PICK_INT(mask, yes.sphere, no.sphere), PICK_INT(mask, yes.order, no.order),
                   PICK(mask, yes.ior, no.ior)};
    return layer;
}

// NEST: the layer of a medium, the same in all lanes.
static Layer layer_of(__global const Medium *medium) {
    Layer layer = {medium->sphere, medium->order, medium->ior};
    return layer;
}

// NEST: the spheres that rays are inside of where they leave the camera.
static Inside inside_of(__global const Medium *around) {
    Inside inside;
    FOR_EACH_LAYER(inside.layers[i] = layer_of(around + i))
    return inside;
}

// NEST: the index of refraction where a ray is, 1 outside of all spheres.
static reals medium_of(Inside inside) {
    return PICK(inside.layers[0].sphere != 0, inside.layers[0].ior, 1);
}

// NEST: where a layer is smaller than another it takes its place.
static void settle(Layer *there, Layer *moving) {
    ints smaller = moving->order > there->order;
    Layer before = *there;
    *there = pick_layer(smaller, *moving, before);
    *moving = pick_layer(smaller, before, *moving);
}

// NEST: adds a sphere in the lanes of a mask. The list is sorted, the smallest sphere first.
// Returns the lanes where there was no room: of the largest sphere the far side will not be seen.
static ints enter(Inside *inside, ints mask, ints sphere, ints order, reals ior) {
    Layer moving = {PICK_INT(mask, sphere + 1, 0), PICK_INT(mask, order, 0), ior};
    FOR_EACH_LAYER(settle(inside->layers + i, &moving))
    return moving.sphere != 0;
}

// NEST: in the lanes of a mask a layer gives way to the next, if there is one.
static void give_way(Inside *inside, ints mask, int i) {
    Layer none = {0, 0, 1}, next = i + 1 < NEST ? inside->layers[(i + 1) % MAX_INSIDE] : none;
    inside->layers[i] = pick_layer(mask, next, inside->layers[i]);
}

// NEST: takes a sphere out in the lanes of a mask.
static void leave(Inside *inside, ints mask, ints sphere) {
    ints found = 0;
    FOR_EACH_LAYER(found |= mask & (inside->layers[i].sphere == sphere + 1);
                   give_way(inside, found, i))
}

// NEST: PICK for all layers.
static Inside pick_inside(ints mask, Inside yes, Inside no) {
    FOR_EACH_LAYER(yes.layers[i] = pick_layer(mask, yes.layers[i], no.layers[i]))
    return yes;
}

// NEST: where a ray leaves a sphere that it is inside of. From the sphere itself that is a whole chord:
// t = -2 b, with no root and no epsilon, off the surface by at most 4 * 2^-24 (|P| + t). From
// elsewhere it is the larger root, in the form that does not cancel.
static reals way_out(Quadratic q, ints from_itself) {
    reals half_chord = sqrt(PICK(q.delta > 0, q.delta, 0));
    reals larger = PICK(q.b > 0, -q.c / (half_chord + q.b), half_chord - q.b);
    return PICK(from_itself, -2 * q.b, larger);
}

// NEST: the far sides of the spheres of a list that rays are inside of, if they come before `hit`.
static Hit far_sides(Hit hit, Ray ray, __global const Sphere *spheres, int sphere_count) {
    for (int s = 0; s < sphere_count; s++) {
        ints in = is_inside(ray, s);
        if (!ANY(in)) continue;
        hit = closer(hit, in, way_out(quadratic(ray, spheres + s), ray.leaves == s), s);
    }
    return hit;
}

// NEST: how rays go on at a surface of glass.
typedef struct {
    Vector direction;  // of the ray that goes on
    ints total;        // where it is mirrored: it stays in its medium
    reals mirrored;    // SPLIT: Fresnel's part of unpolarised light that is
} Refraction;

// NEST: a ray of direction d that meets a surface between two media, m its normal towards the ray.
// Snell's law: with c = -d.m, eta = n1 / n2 and k = (eta c)^2 - (n1^2 - n2^2) / n2^2 the direction is
// eta d + (eta c - sqrt(k)) m. That bracket cancels where eta is near 1.
// (n1^2 - n2^2) / n2^2 / (eta c + sqrt(k)) is the same number and does not: into a denser medium the
// direction is right to 5 * 2^-24, and of equal media it stays as it is, bit for bit
// (tests/test_glass.py). k < 0: total reflection.
static Refraction refracted(Vector d, Vector m, reals n1, reals n2) {
    reals c = -dot3(d, m), eta = n1 / n2, bend = (n1 - n2) * (n1 + n2) / (n2 * n2);
    reals k = (eta * c) * (eta * c) - bend;
    Refraction found;
    found.total = k < 0;
    reals root = sqrt(PICK(found.total, 0, k)), sum = eta * c + root;
    Vector through = along(scaled(d, eta), PICK(sum > 0, bend / sum, 0), m);
    found.direction = pick3(found.total, along(d, 2 * c, m), through);
    if (SPLIT) {
        reals across = (eta * c - root) / sum, aligned = (c - eta * root) / (c + eta * root);
        reals part = (across * across + aligned * aligned) / 2;
        found.mirrored = PICK(part < 1, part, 1);
    }
    return found;
}

// Beads: the spheres of a scene with a tree, one by one, and the list beside it.
//
// ids: the place in the scene's list of each sphere of the list beside the tree.

// TREE: the spheres of the list beside the tree that the rays that are on meet first.
static Hit nearest_listed(Ray ray, ints on, __global const Sphere *spheres, __global const int *ids,
                          int sphere_count) {
    Hit hit = no_hit();
    for (int s = 0; s < sphere_count; s++) {
        Quadratic q = quadratic(ray, spheres + s);
        ints met = on & ahead(q, ray, ids[s]);
        if (ANY(met)) hit = closer_of(hit, met, smaller_root(q), ids[s]);
    }
    return hit;
}

// ORTHOGRAPHIC and TREE: that for lines that have no start. Those to the tree have one: it has no sphere
// that they meet before.
static Hit visible_listed(Ray line, __global const Sphere *spheres, __global const int *ids,
                          int sphere_count) {
    Hit hit = no_hit();
    for (int s = 0; s < sphere_count; s++) {
        Quadratic q = quadratic(line, spheres + s);
        ints met = q.delta > 0;
        if (ANY(met)) hit = closer_of(hit, met, entry(q), ids[s]);
    }
    return hit;
}

// TREE: what the spheres of that list take of a light that is `distance` away, see occluded().
static ints occluded_by_listed(Ray ray, reals distance, __global const uchar *encloses,
                               __global const Sphere *spheres, __global const int *ids,
                               __global const Glass *glass, int sphere_count) {
    ints hidden = 0;
    for (int s = 0; s < sphere_count; s++) {
        Quadratic q = quadratic(ray, spheres + s);
        ints met = ahead(q, ray, ids[s]);
        if (!encloses[s]) met &= -q.b < distance;
        hidden = taken_with(hidden, met, NEST ? glass[ids[s]].veil : 0);
    }
    return hidden;
}

// TREE: the spheres of lanes, centre and radius: lane i's are [i], [LANES + i] and so on.
static void gather_beads(__private reals *own, ints spheres, __global const Bead *beads) {
    __private const INTEGER *sphere = EACH_INT(spheres);
    __private real *each = (__private real *)own;
    for (int i = 0; i < LANES; i++) {
        if (sphere[i] < 0) continue;
        __global const Bead *bead = beads + sphere[i];
        each[i] = bead->center[0], each[LANES + i] = bead->center[1];
        each[2 * LANES + i] = bead->center[2], each[3 * LANES + i] = bead->radius;
    }
}

// NEST and TREE: the far side of one sphere of each lane, index + 1, if it comes before `hit`.
static Hit far_side_of_bead(Hit hit, Ray ray, ints number, __global const Bead *beads) {
    if (!ANY(number > 0)) return hit;
    ints sphere = number - 1;
    __private reals own[4] = {0, 0, 0, NAN};
    gather_beads(own, sphere, beads);
    QUADRATIC(reals, ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x, ray.direction.y,
              ray.direction.z, own[0], own[1], own[2], own[3])
    Quadratic q = {b, c, delta};
    // Of those in the list beside the tree the radius is NaN.
    ints in = (sphere >= 0) & (own[3] > 0);
    return closer_of(hit, in, way_out(q, ray.leaves == sphere), sphere);
}

// NEST and TREE: as far_sides(), of all spheres of a scene with a tree.
static Hit far_sides_of_beads(Hit hit, Ray ray, __global const Bead *beads,
                              __global const Sphere *spheres, __global const int *ids,
                              int sphere_count) {
    FOR_EACH_LAYER(hit = far_side_of_bead(hit, ray, ray.inside.layers[i].sphere, beads))
    for (int s = 0; s < sphere_count; s++) {
        ints in = is_inside(ray, ids[s]);
        if (!ANY(in)) continue;
        Quadratic q = quadratic(ray, spheres + s);
        hit = closer_of(hit, in, way_out(q, ray.leaves == ids[s]), ids[s]);
    }
    return hit;
}

// TREE: the materials of lanes' spheres. Returns their indices, -1 where a lane has no sphere.
static ints gather_materials(Surface *surface, ints hit, __global const int *materials_of,
                             __global const Material *materials, __global const Glass *glass) {
    __private ints found[1] = {-1}, orders[1] = {0};
    __private reals exponents[1] = {0}, reflections[1] = {0};
    __private reals transmissions[1] = {0}, iors[1] = {1}, fresnels[1] = {0};
    __private reals spreads[1] = {0}, diffuses[3] = {0, 0, 0};
    __private const INTEGER *sphere = EACH_INT(hit);
    for (int i = 0; i < LANES; i++) {
        if (sphere[i] < 0) continue;
        int index = materials_of[sphere[i]];
        __global const Material *material = materials + index;
        EACH_INT(found)[i] = index;
        EACH_REAL(exponents)[i] = material->exponent;
        EACH_REAL(reflections)[i] = material->reflection;
        if (NEST) {
            EACH_REAL(transmissions)[i] = material->transmission;
            EACH_REAL(iors)[i] = material->ior;
            EACH_REAL(fresnels)[i] = material->fresnel;
            EACH_INT(orders)[i] = glass[sphere[i]].order;
        }
        if (GLOSS) EACH_REAL(spreads)[i] = material->spread;
        for (int a = 0; INDIRECT && a < 3; a++)
            EACH_REAL(diffuses)[a * LANES + i] = material->diffuse[a];
    }
    surface->exponent = exponents[0];
    surface->reflection = reflections[0];
    surface->transmission = transmissions[0];
    surface->ior = iors[0];
    surface->fresnel = fresnels[0];
    surface->order = orders[0];
    surface->spread = spreads[0];
    surface->diffuse = vector(diffuses[0], diffuses[1], diffuses[2]);
    return found[0];
}

// TREE: the surfaces that the packet's lanes have hit, each a bead of its own. material: their indices.
static Surface surface_of_beads(Vector point, ints hit, __global const Bead *beads,
                                __global const int *materials_of,
                                __global const Material *materials, __global const Glass *glass,
                                real shadow_bias, ints *material) {
    __private reals own[4] = {0, 0, 0, 1};
    gather_beads(own, hit, beads);
    reals radius = own[3];
    Vector normal = minus(point, vector(own[0], own[1], own[2]));
    Surface surface = {scaled(normal, 1 / radius), 0};
    *material = gather_materials(&surface, hit, materials_of, materials, glass);
    // As clrt/pack.py works it out for a Sphere.
    if (shadow_bias > 0)
        surface.horizon = -sqrt(shadow_bias * (2 * radius + shadow_bias)) / (radius + shadow_bias);
    return surface;
}

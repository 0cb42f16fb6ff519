// Beads: the spheres of a scene with a tree, one by one, and the list beside it.
//
// ids: the place in the scene's list of each sphere of the list beside the tree.

// TREE: the spheres of the list beside the tree that the rays that are on meet first.
static Hit nearest_listed(Ray ray, ints on, __global const Sphere *spheres, __global const int *ids,
                          __global const Glass *glass, int sphere_count) {
    Hit hit = no_hit();
    for (int s = 0; s < sphere_count; s++) {
        Quadratic q = quadratic(ray, spheres + s);
        ints met = on & ahead(q, ray, ids[s]);
        if (!ANY(met)) continue;
        reals root = smaller_root(q);
        if (OPACITY) met &= behind(ray, root, ids[s]);
        MEET(hit, met, root, ids[s], glass)
    }
    return hit;
}

// ORTHOGRAPHIC and TREE: that for lines that have no start. Those to the tree have one: it has no sphere
// that they meet before.
static Hit visible_listed(Ray line, ints on, __global const Sphere *spheres,
                          __global const int *ids, __global const Glass *glass, int sphere_count) {
    Hit hit = no_hit();
    for (int s = 0; s < sphere_count; s++) {
        Quadratic q = quadratic(line, spheres + s);
        ints met = on & (q.delta > 0);
        if (!ANY(met)) continue;
        reals root = entry(q);
        if (OPACITY) met &= behind(line, root, ids[s]);
        MEET(hit, met, root, ids[s], glass)
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
        hidden = taken_with(hidden, met, VEILED ? glass[ids[s]].veil : 0);
    }
    return hidden;
}

// TREE: puts a lane's sphere into four vectors: its centre and radius.
static void put_bead(__private reals *own, int lane, __global const Bead *bead) {
    __private real *each = (__private real *)own;
    each[lane] = bead->center[0], each[LANES + lane] = bead->center[1];
    each[2 * LANES + lane] = bead->center[2], each[3 * LANES + lane] = bead->radius;
}

// NEST and TREE: the far side of one sphere of each lane, index + 1, if it comes before `hit`.
static Hit far_side_of_bead(Hit hit, Ray ray, ints number, __global const Bead *beads) {
    if (!ANY(number > 0)) return hit;
    ints sphere = number - 1;
    __private reals own[4] = {0, 0, 0, NAN};
    for (int lane = 0; lane < LANES; lane++)
        if (EACH_INT(sphere)[lane] >= 0) put_bead(own, lane, beads + EACH_INT(sphere)[lane]);
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

// TREE: the surfaces that the packet's lanes have hit, each a bead of its own, or a
// capsule, where it is as a bead at its axis, or a face, whose normal mesh.cl finds. material: their
// indices, -1 where a lane has hit none.
static Surface surface_of_beads(Vector point, ints hit, __global const Bead *beads,
                                __global const int *materials_of,
                                __global const Material *materials, __global const Glass *glass,
                                real shadow_bias, const CapsuleList *capsules,
                                const FaceList *faces, ints *material) {
    __private const INTEGER *sphere = EACH_INT(hit);
    __private reals own[4] = {0, 0, 0, 1}, exponents[1] = {0}, reflections[1] = {0};
    __private reals transmissions[1] = {0}, iors[1] = {1}, fresnels[1] = {0};
    __private reals spreads[1] = {0}, diffuses[3] = {0, 0, 0};
    __private ints indices[1] = {-1}, orders[1] = {0};
    for (int i = 0; i < LANES; i++) {
        if (sphere[i] < 0) continue;
        if (FACES && sphere[i] >= faces->first) {
            EACH_REAL(own[3])[i] = 1;  // see mesh.cl
        } else if (CAPSULES && sphere[i] >= capsules->first) {
            put_capsule(own, i, capsules->each + (sphere[i] - capsules->first), &point);
        } else {
            put_bead(own, i, beads + sphere[i]);
        }
        int index = materials_of[sphere[i]];
        __global const Material *its = materials + index;
        EACH_INT(indices)[i] = index;
        EACH_REAL(exponents)[i] = its->exponent;
        EACH_REAL(reflections)[i] = its->reflection;
        if (NEST) {
            EACH_REAL(transmissions)[i] = its->transmission;
            EACH_REAL(iors)[i] = its->ior;
            EACH_REAL(fresnels)[i] = its->fresnel;
            EACH_INT(orders)[i] = glass[sphere[i]].order;
        }
        if (GLOSS) EACH_REAL(spreads)[i] = its->spread;
        for (int a = 0; (INDIRECT || FILM_GUIDES) && a < 3; a++)
            EACH_REAL(diffuses)[a * LANES + i] = its->diffuse[a];
    }
    *material = indices[0];
    reals radius = own[3];
    Vector normal = minus(point, vector(own[0], own[1], own[2]));
    Surface surface = {scaled(normal, 1 / radius),
                       0,
                       exponents[0],
                       reflections[0],
                       transmissions[0],
                       iors[0],
                       fresnels[0],
                       orders[0],
                       spreads[0]};
    surface.diffuse = vector(diffuses[0], diffuses[1], diffuses[2]);
    // As clrt/renderer/pack works it out for a Sphere.
    if (shadow_bias > 0)
        surface.horizon = -sqrt(shadow_bias * (2 * radius + shadow_bias)) / (radius + shadow_bias);
    return surface;
}

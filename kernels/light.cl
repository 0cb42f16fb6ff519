// Light: what lights the places where a packet's paths are.

// SPHERE_COLORS and TREE: each lane's own colour, linear RGB.
static Vector own_colors(const Scene *scene, const Path *path, const Place *place) {
    Vector own = colors_of(scene->sphere_colors, path->hit.id);
    if (CORNER_COLORS) {
        Vector color = between(place->corners.color, place->corners.weight);
        own = pick3(place->facing.there, times(own, color), own);
    }
    return own;
}

// The light of a row of shades, one of each material, that goes to the camera from the lanes that are on.
static Vector shaded(const Scene *scene, const Path *path, const Place *place, ints on,
                     __global const Shade *row, reals diffuse, reals specular) {
    int s;
    Vector light = vector(0, 0, 0), own = vector(1, 1, 1);
    if (TREE) {
        if (SPHERE_COLORS) own = own_colors(scene, path, place);
        FOR_EACH_OF(s, mine, PICK_INT(on, place->material, -1)) {
            Vector one = blinn_phong(row + s, diffuse, specular, own);
            if (GOURAUD && CORNER_COLORS)
                one = along(one, diffuse, times(splat(row[s].diffuse), place->tint));
            light = pick3(mine, one, light);
        }
    } else {
        int material = scene->spheres[place->common].material;
        if (SPHERE_COLORS) own = color_of(scene->sphere_colors, place->common);
        light = blinn_phong(row + material, diffuse, specular, own);
        ints lit_sphere = PICK_INT(on, path->hit.id, -1);
        FOR_OTHER_HITS(s, mine, lit_sphere, place->common) {
            if (SPHERE_COLORS) own = color_of(scene->sphere_colors, s);
            Vector other = blinn_phong(row + scene->spheres[s].material, diffuse, specular, own);
            light = pick3(mine, other, light);
        }
    }
    return INDIRECT ? times(light, path->tint) : light;
}

// OCCLUSION: the part of a sky that is open over some points: the mean of SKY_RAYS rays,
// the likelier the larger their cosine. ray: from the points, its direction does not count.
static reals open_sky(const Scene *scene, Ray ray, Vector normal, ints on, Draw draw, int k) {
    reals hidden = 0;
    if (!ANY(on)) return 1;
    for (int i = 0; i < SKY_RAYS; i++) {
        Pair pair = drawn(draw, SKY, k, i);
        ray.direction = above_surface(normal, pair);
        ints met = met_by(scene, ray, scene->skies[k], on);
        if (OPACITY) {
            hidden += 1 - unveiled(met);
        } else {
            hidden += PICK(met, 1, 0);
        }
    }
    return 1 - hidden / SKY_RAYS;
}

// NEAR: the part of a sky that is open over some points, as far as near spheres tell.
static reals open_by_near(const Scene *scene, Ray ray, Vector normal, ints on, int k) {
    Hiders most = {0, 0, 0, 0, 1};
    if (!ANY(on)) return 1;
    real reach = scene->skies[k];
    for (int s = 0; s < scene->sphere_count; s++) {
        __global const Sphere *sphere = scene->spheres + s;
        int id = TREE ? scene->ids[s] : s;
        Vector center = minus(splat(sphere->anchor), splat(sphere->offset));
        most = with_hider(most, minus(center, ray.origin), 1 / sphere->inv_radius, normal, reach,
                          on & (ray.leaves != id), 1);
    }
    if (TREE) most = with_tree(&scene->tree, most, ray, normal, reach, on);
    return left_by_hiders(most);
}

// OCCLUSION or NEAR: adds light from all sides, where it is not hidden. row: of the first sky's shades.
static void add_skies(const Scene *scene, Path *path, const Place *place,
                      __global const Shade *row) {
    ints on = place->shown;
    for (int k = 0; k < scene->sky_count; k++, row += scene->material_count) {
        reals open = 1;
        if (OCCLUSION) open = open_sky(scene, path->ray, place->surface.normal, on, path->draw, k);
        if (NEAR) open = open_by_near(scene, path->ray, place->surface.normal, on, k);
        reals share = path->weight * open;
        Vector light = shaded(scene, path, place, on, row, 0, 0);
        path->color = pick3(on, along(path->color, share, light), path->color);
    }
}

// AMBIENT or OCCLUSION or NEAR: adds light from all sides. Its shades stand behind those of the lights.
static void add_ambient(const Scene *scene, Path *path, Place *place) {
    ints on = place->reached = place->shown;
    place->missed = 0;
    __global const Shade *row = scene->shades + scene->light_count * scene->material_count;
    if (AMBIENT) {
        Vector light = shaded(scene, path, place, on, row, 0, 0);
        path->color = pick3(on, along(path->color, path->weight, light), path->color);
        row += scene->material_count;
    }
    if (OCCLUSION || NEAR) add_skies(scene, path, place, row);
}

// How a light is seen from the places of paths.
typedef struct {
    Ray ray;         // to its middle, or (RANDOM) to a point of a round one
    reals distance;  // of its middle
    Cap cap;         // ROUND
    reals diffuse;   // the cosine at the surface, or the mean of it
    reals share;     // of the colour that it has here: what it weighs in the picture's
    ints lit;        // the lanes that it reaches
    ints veil;       // VEILED: what is taken of it
} Seen;

// ROUND: the part of a round light that spheres leave, by round.cl's closed form.
static void see_round(const Scene *scene, Path *path, Place *place, int k, Seen *seen) {
    Cap cap = seen->cap;
    Cover cover = cover_of_light(scene, k, seen->ray, cap, seen->lit);
    reals above = 1;
    if (ANY(seen->lit & (seen->diffuse < cap.sine)))
        above = 1 - part_covered(cap, scaled(place->surface.normal, -1), HALF_PI, 1);
    reals visible = visible_part(cover, above);
    seen->lit &= visible > 0;
    seen->share *= visible;
    seen->diffuse = mean_cosine(cap, seen->diffuse) / PICK(above > 0, above, 1);
    place->missed *= PICK(seen->lit, 1 - visible, 1);
    seen->veil = cover.veil;
    if (NEST) seen->lit &= seen->veil < OPAQUE;
}

// How paths see light k.
static Seen see(const Scene *scene, Path *path, Place *place, int k) {
    __global const Light *light = scene->lights + k;
    bool is_round = light->radius > 0;
    Seen seen;
    Vector to_light = minus(splat(light->position), path->ray.origin);
    reals distance2 = dot3(to_light, to_light), inv_distance = inverse_sqrt(distance2);
    to_light = scaled(to_light, inv_distance);
    Vector to_middle = to_light, end_of_rays = splat(light->position);
    seen.distance = distance2 * inv_distance;
    reals length = seen.distance;
    if (ROUND && is_round) seen.cap = cap_of(to_light, seen.distance, light->radius);
    if (ROUND && RANDOM && is_round) {
        Pair pair = drawn(path->draw, LIGHT_POINT, k, 0);
        to_light = tilted(to_light, pair.u * seen.cap.versine, pair.v);
        length *= 1 - pair.u * seen.cap.versine;
        end_of_rays = FAR_AWAY;
    }
    seen.diffuse = dot3(place->surface.normal, to_light);
    seen.ray = path->ray;
    seen.ray.direction = to_light;
    seen.share = path->weight;
    seen.lit = place->shown & (seen.diffuse >= place->surface.horizon);
    if (ROUND && !RANDOM && is_round) seen.lit = place->shown & (seen.diffuse > -seen.cap.sine);
    if (SPOT) {
        reals part = cone(light, to_middle);
        seen.lit &= part > 0;
        seen.share *= part;
    }
    if (ROUND && !RANDOM && is_round) {
        see_round(scene, path, place, k, &seen);
    } else {
        seen.veil = taken_of_light(scene, k, seen.ray, length, end_of_rays, seen.lit);
        seen.lit &= !takes_all(seen.veil);
        place->missed = PICK(seen.lit, 0, place->missed);
    }
    return seen;
}

// The highlight of a light in that direction: the specular term's cosine with its exponent.
static reals highlight_of(const Path *path, const Place *place, Vector to_light) {
    Vector half_way = plus(to_light, path->to_camera), about = place->surface.normal;
    if (SMOOTH) about = place->normal;
    if (PHONG) {
        about = pick3(place->phong, place->mirrored, about);
        half_way = pick3(place->phong, to_light, half_way);
    }
    reals specular = highlight(about, half_way, place->surface.exponent);
    return INDIRECT ? PICK(path->scattered, 0, specular) : specular;
}

// GOURAUD: adds what a light brings to one corner, by weight.
static void light_corner(const Path *path, const Place *place, Vector point, Vector normal,
                         Vector color, reals weight, Vector light, reals *diffuse, reals *specular,
                         Vector *tinted) {
    Vector to_light = unit(minus(light, point)), to_camera = path->to_camera;
    if (!ORTHOGRAPHIC) to_camera = unit(minus(path->eye, point));
    reals cosine = dot3(normal, to_light);
    Vector half_way = plus(to_light, to_camera), about = normal;
    if (PHONG) {
        Vector mirrored = along(scaled(to_camera, -1), 2 * dot3(normal, to_camera), normal);
        about = pick3(place->phong, mirrored, about);
        half_way = pick3(place->phong, to_light, half_way);
    }
    reals shine = highlight(about, half_way, place->surface.exponent);
    if (INDIRECT) shine = PICK(path->scattered, 0, shine);
    reals share = PICK(cosine > 0, weight * cosine, 0);
    *diffuse += share;
    *specular += PICK(cosine >= 0, weight * shine, 0);
    if (CORNER_COLORS) *tinted = along(*tinted, share, color);
}

// GOURAUD: what a light brings to the corners of faces, interpolated, in the lanes that want that.
static void light_corners(const Path *path, Place *place, Vector light, reals *diffuse,
                          reals *specular) {
    ints mine = place->facing.there & (place->facing.shading == AT_CORNERS);
    if (!ANY(mine)) return;
    reals d = 0, s = 0;
    Vector tinted = vector(0, 0, 0);
    const FaceCorners *corners = &place->corners;
    FOR_EACH_AXIS(light_corner(path, place, corners->point[a], corners->normal[a],
                               corners->color[a], corners->weight[a], light, &d, &s, &tinted))
    if (CORNER_COLORS) {
        // A product is interpolated, which is not the product of what is interpolated.
        Vector own = between(corners->color, corners->weight);
        ints some = mine & (d > 0);
        Vector more = minus(scaled(tinted, 1 / PICK(some, d, 1)), own);
        place->tint = pick3(some, more, vector(0, 0, 0));
    }
    *diffuse = PICK(mine, d, *diffuse);
    *specular = PICK(mine, s, *specular);
}

// Adds the colour that light k brings.
static void add_light(const Scene *scene, Path *path, Place *place, int k) {
    Seen seen = see(scene, path, place, k);
    if (PATHS) {
        ints how = 1;
        if (VEILED)
            how += TO_INTS(TO_REALS(seen.veil) * (64 / VEIL) + REAL(0.5));  // to a hundredth
        path->hash = FOLLOWED(place->shown, path->hash, PICK_INT(seen.lit, how, 0));
    }
    if (!ANY(seen.lit)) return;
    place->reached |= seen.lit;
    reals diffuse = seen.diffuse, specular = highlight_of(path, place, seen.ray.direction);
    if (SMOOTH) {
        ints smooth = place->facing.there & (place->facing.shading == BETWEEN_CORNERS);
        reals cosine = dot3(place->normal, seen.ray.direction);
        diffuse = PICK(smooth, larger(cosine, 0), diffuse);
    }
    if (GOURAUD) light_corners(path, place, splat(scene->lights[k].position), &diffuse, &specular);
    if (ATTENUATION) {
        reals left = faded(scene->lights + k, seen.distance);
        diffuse *= left;
        specular *= left;
    }
    if (VEILED) {
        reals clear = unveiled(seen.veil);
        diffuse *= clear;
        specular *= clear;
    }
    __global const Shade *row = scene->shades + k * scene->material_count;
    Vector light = shaded(scene, path, place, seen.lit, row, diffuse, specular);
    path->color = pick3(seen.lit, along(path->color, seen.share, light), path->color);
}

// Adds all light that reaches where the path is.
static void add_lights(const Scene *scene, Path *path, Place *place) {
    if (AMBIENT || OCCLUSION || NEAR) add_ambient(scene, path, place);
    if (NEST && !ANY(place->shown)) return;  // all lanes are at a far side
    for (int k = 0; k < scene->light_count; k++) add_light(scene, path, place, k);
}

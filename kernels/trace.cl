// Trace: follows the paths of one packet of camera rays (paper, section 11.11).

// FILM_PASSES: what the camera sees first, how far away along the ray, of which the camera is
// a point or (ORTHOGRAPHIC) beside one, and their normals in the world.
static Sample passes_of(const Scene *scene, const Path *path, Vector normal) {
    Vector from_eye = minus(path->point, splat(scene->camera->eye));
    if (!TREE) normal = in_world(scene->camera, normal.x, normal.y, normal.z);
    Sample sample = {{0}};
    sample.id = path->hit.id;
    sample.depth = dot3(from_eye, path->ray.direction) * scene->camera->unit;
    sample.normal = normal;
    return sample;
}

// FILM_GUIDES: what a filter looks at where paths have arrived first. before: 0, or that of lanes that have
// arrived before.
static Guide guide_of(const Scene *scene, const Path *path, const Place *place, Vector normal,
                      Guide before) {
    ints first = (path->hit.id >= 0) & (before.depth == 0);
    Vector from_eye = minus(path->point, splat(scene->camera->eye));
    Guide guide = {pick3(first, albedo_of(scene, path, place), before.albedo),
                   pick3(first, normal, before.normal),
                   PICK(first, dot3(from_eye, path->ray.direction), before.depth), 0};
    return guide;
}

// Traces the paths through a packet of pixels to their ends: their colours, and whether they show something.
// known: TILES: what they meet first; else 0.
static Sample traced(const Scene *scene, Pixels at, Draw draw, const Hit *known) {
    Path path = from_camera(scene, at, draw, known);
    reals alpha = PICK(path.hit.id >= 0, 1, 0);
    Aside aside[MAX_ASIDE];
    Splits splits = {0, path.weight > 0, 0};
    Vector first_normal = vector(0, 0, 0);
    Guide guide = {{0}};
    for (path.depth = 1; splits.count > 0 || ANY(path.hit.id >= 0); path.depth++) {
        Through through;
        if (OPACITY) {
            through = translucent_first(scene, &path);
            reals left = through.weight * (1 - through.part);
            if (path.depth == 1) alpha = PICK(path.hit.id >= 0, 1 - left, alpha);
        }
        Place place = arrive(scene, &path);
        first_normal = place.surface.normal;
        if (SMOOTH) first_normal = place.normal;
        if (FILM_PASSES) break;
        if (FILM_GUIDES && path.depth == 1)
            guide = guide_of(scene, &path, &place, first_normal, guide);
        add_lights(scene, &path, &place);
        ints alive;
        if (OPACITY && ANY(through.goes)) {
            alive = go_through(&path, &through);
            path.depth--;
        } else {
            if (!REFLECTION) break;
            alive = turn(scene, &path, &place, &splits, aside);
            if (path.depth == scene->max_depth || !ANY(alive)) {
                if (!SPLIT || splits.count == 0) break;
                alive = take_aside(&path, &splits, aside);
            }
        }
        go_on(scene, &path, alive, &through);
    }
    if (FILM_PASSES) return passes_of(scene, &path, first_normal);
    if (SPLIT) path.hash = splits.ended + PICK_INT(splits.traced, path.hash, 0);
    Sample sample = {path.color, alpha, path.hash};
    if (FILM_GUIDES) {
        reals bright = path.color.x + path.color.y + path.color.z;
        guide.square = bright * bright;
        sample.guide[0] = guide;
    }
    return sample;
}

// Onward: where a packet's paths go on, and the rays that are put aside until then.

// SPLIT: where a surface mirrors and transmits the mirrored rays of a packet are put aside, and traced
// when the others have ended. So no more are aside than max_depth - 1. Those for which there is no room
// are lost, and counted.
#define MAX_ASIDE (SPLIT ? 32 : 1)

// SPLIT: rays that were put aside, as in Path.
typedef struct {
    Ray ray;
    reals weight;
    ints alive, hash;
    Vector tint;
    ints scattered;
    int depth;
} Aside;

// SPLIT: of a packet.
typedef struct {
    int count;    // of the rays that are aside
    ints traced;  // the lanes of the path that is traced
    ints ended;   // the sum of the hashes of those before
} Splits;

// INDIRECT or FILM_GUIDES: the part of diffuse light that surfaces send on, linear RGB.
static Vector albedo_of(const Scene *scene, const Path *path, const Place *place) {
    Vector albedo = place->surface.diffuse;
    if (!SPHERE_COLORS) return albedo;
    if (TREE) return times(albedo, own_colors(scene, path, place));
    int s;
    Vector own = color_of(scene->sphere_colors, place->common);
    FOR_OTHER_HITS(s, mine, path->hit.id, place->common) {
        own = pick3(mine, color_of(scene->sphere_colors, s), own);
    }
    return times(albedo, own);
}

// INDIRECT: the direction of rays that are mirrored or scattered. Each is chosen with a probability in
// proportion to what it sends on, so that either weighs as much as both. pair: for the scattered ones.
static Vector bounced(const Scene *scene, Path *path, Place *place, Vector mirrored, ints shown,
                      Pair pair) {
    Vector albedo = albedo_of(scene, path, place);
    reals mirrors_part = PICK(place->reached, place->surface.reflection, 0);
    reals scatters = larger(albedo.x, larger(albedo.y, albedo.z)), both = mirrors_part + scatters;
    ints bounces =
        shown & (drawn(path->draw, CHOICE, 0, 0).u * both >= mirrors_part) & (scatters > 0);
    place->surface.reflection = PICK(shown, both, place->surface.reflection);
    path->tint = pick3(bounces, times(path->tint, scaled(albedo, 1 / scatters)), path->tint);
    path->scattered |= bounces;
    place->reached |= bounces;
    return pick3(bounces, above_surface(place->surface.normal, pair), mirrored);
}

// SPLIT: puts the mirrored rays aside in those lanes.
static void put_aside(const Scene *scene, Path *path, Splits *splits, Aside *aside, Ray mirror,
                      reals weight, ints both) {
    if (path->depth == scene->max_depth || !ANY(both)) return;
    if (splits->count == MAX_ASIDE) {
        atomic_inc(scene->lost + 1);
        return;
    }
    Aside *split = aside + splits->count++;
    split->ray = mirror;
    split->weight = weight;
    split->alive = both;
    split->depth = path->depth;
    if (PATHS) split->hash = path->hash;
    if (INDIRECT) split->tint = path->tint, split->scattered = path->scattered;
}

// SPLIT: goes on with the rays that were put aside last. Returns the lanes that have one.
static ints take_aside(Path *path, Splits *splits, const Aside *aside) {
    Aside next = aside[--splits->count];
    path->ray = next.ray;
    path->weight = next.weight;
    path->depth = next.depth;
    if (PATHS) {
        splits->ended += PICK_INT(splits->traced, path->hash, 0);
        splits->traced = next.alive;
        path->hash = next.hash;
    }
    if (INDIRECT) path->tint = next.tint, path->scattered = next.scattered;
    return next.alive;
}

// NEST: gives each path its next ray: through the surface where it is of glass, else mirrored, which is
// `onward`. Returns the lanes that have one.
static ints turn_at_glass(const Scene *scene, Path *path, Place *place, Vector onward,
                          ints entering, Splits *splits, Aside *aside) {
    Surface surface = place->surface;
    ints crossing = entering | place->out;
    ints mirrors = place->reached & place->shown & !entering;
    Ray mirror = path->ray;
    mirror.direction = onward;
    if (!ANY(crossing)) {
        path->ray = mirror;
        path->weight *= surface.reflection;
        return mirrors & (path->weight > 0);
    }
    Inside after = path->ray.inside;
    ints lacks_room = enter(&after, entering, path->hit.id, surface.order, surface.ior);
    leave(&after, place->out, path->hit.id);
    Vector normal = pick3(place->out, scaled(surface.normal, -1), surface.normal);
    Refraction bent =
        refracted(path->ray.direction, normal, medium_of(path->ray.inside), medium_of(after));
    ints through = crossing & !bent.total;
    if (path->depth < scene->max_depth && ANY(lacks_room & through)) atomic_inc(scene->lost);
    // Of what is transmitted; total reflection takes nothing.
    reals transmission = surface.transmission, reflection = surface.reflection;
    if (SPLIT) {
        reals part = transmission * surface.fresnel * bent.mirrored;
        transmission -= part;
        reflection += part;
        mirrors |= place->reached & entering & through;
    }
    reals transmitted = path->weight * PICK(entering & through, transmission, 1);
    reals mirrored_weight = path->weight * reflection;
    if (PATHS) path->hash = FOLLOWED(crossing, path->hash, PICK_INT(bent.total, 1, 0));
    if (SPLIT) {
        ints both = crossing & mirrors & (transmitted > 0) & (mirrored_weight > 0);
        put_aside(scene, path, splits, aside, mirror, mirrored_weight, both);
        crossing &= transmitted > 0;
    }
    path->ray.origin = pick3(crossing, path->point, path->ray.origin);
    path->ray.direction = pick3(crossing, bent.direction, mirror.direction);
    path->ray.inside = pick_inside(through & crossing, after, path->ray.inside);
    path->weight = PICK(crossing, transmitted, mirrored_weight);
    return (crossing | mirrors) & (path->weight > 0);
}

// REFLECTION: gives each path its next ray. Returns the lanes that have one.
static ints turn(const Scene *scene, Path *path, Place *place, Splits *splits, Aside *aside) {
    Vector normal = place->surface.normal, in = path->ray.direction;
    Vector onward = along(in, -2 * dot3(in, normal), normal);  // mirrored
    ints entering = place->shown & (place->surface.transmission > 0);
    if (INDIRECT) entering &= !path->scattered;  // to whom glass is opaque
    if (ROUND) place->surface.reflection *= 1 - place->missed;
    if (GLOSS || INDIRECT) {
        Pair pair = drawn(path->draw, MIRROR, 0, 0);
        ints shown = NEST ? place->shown & !entering : place->shown;
        if (GLOSS) onward = blurred(onward, normal, place->surface.spread, pair);
        if (INDIRECT) onward = bounced(scene, path, place, onward, shown, pair);
    }
    if (NEST) return turn_at_glass(scene, path, place, onward, entering, splits, aside);
    path->weight *= place->surface.reflection;
    path->ray.direction = onward;
    if (OPACITY) path->ray.passed[0] = nothing_passed();
    return place->reached & (path->weight > 0);
}

// REFLECTION or OPACITY: follows the rays of those lanes to what they meet next. OPACITY: those that wait
// stay where they are.
static void go_on(const Scene *scene, Path *path, ints alive, const Through *through) {
    bool from_camera = OPACITY && path->depth == 0;
    if (OPACITY && !ANY(alive)) {
        path->hit = no_hit();
    } else if (OPACITY && TREE && ANY(through->goes) && path->hit.later[0].left > 0) {
        path->hit = next_hit(path->hit, alive);
    } else {
        path->hit = first_hit(scene, path->ray, alive, false, ORTHOGRAPHIC && from_camera);
    }
    if (NEST && ANY(alive & (path->ray.inside.layers[0].sphere != 0))) {
        path->hit = first_side(scene, path->hit, path->ray);
        path->hit.id = PICK_INT(alive, path->hit.id, -1);
    }
    if (BACKGROUND && !from_camera) {
        ints gone = alive & (path->hit.id < 0);
        if (INDIRECT) gone &= !path->scattered;
        Vector seen = along(path->color, path->weight, splat(scene->background));
        path->color = pick3(gone, seen, path->color);
    }
    if (OPACITY) path->hit = pick_hit(through->waits, through->hit, path->hit);
    path->point = along(path->ray.origin, path->hit.distance, path->ray.direction);
    if (!ORTHOGRAPHIC && !from_camera) path->to_camera = unit(minus(path->eye, path->point));
}

// Trace: follows the paths of one packet of camera rays (paper, section 11.11).
//
// The host defines REFLECTION if a path can go on after its first hit: a material reflects or
// transmits, or surfaces light each other, and max_depth is more than 1; AMBIENT if there is ambient
// light that reaches every hit; and BACKGROUND if rays that leave the scene after a mirror or glass see
// something there. What the camera sees of it directly the host adds (clrt/film.py). In ambient light,
// also where spheres hide it (OCCLUSION), a path goes on in shadow. The other things that a scene may
// have or not are said of in camera.cl, sphere.cl, glass.cl, shading.cl, round.cl and draw.cl;
// everything else about it is run-time data.

// Most packets hit one sphere only, `common`: what the lanes need of it is loaded once for all of
// them. This runs its body for each other sphere that a lane has hit, see FOR_EACH_OF.
#define FOR_OTHER_HITS(s, mine, hit, common) FOR_EACH_OF(s, mine, PICK_INT(hit == common, -1, hit))

// Runs its body for each number in `numbers`, -1 in lanes that do not count: with the number in `s`,
// a scalar, and the lanes that have it in `mine`.
#define FOR_EACH_OF(s, mine, numbers)                                       \
    for (ints mine, rest_ = numbers;                                        \
         ANY(rest_ >= 0) && (s = GREATEST(rest_), mine = rest_ == s, true); \
         rest_ = PICK_INT(mine, -1, rest_))

// A sphere's own colour multiplies its ambient and diffuse light.
#ifdef SPHERE_COLORS
#define BLINN_PHONG(shade, sphere) \
    blinn_phong_of(shade, diffuse, specular, color_of(scene.sphere_colors, sphere))
#else
#define BLINN_PHONG(shade, sphere) blinn_phong(shade, diffuse, specular)
#endif

// Declares `light`, what the lanes that are `on` send to the camera: `row` has the shades of each
// material.
#ifdef INDIRECT
#define TINTED light = times(light, tint);
#else
#define TINTED
#endif
#ifdef TREE
#define SHADED(on, row)                                               \
    Vector light = vector(0, 0, 0);                                   \
    FOR_EACH_OF(s, mine, PICK_INT(on, material, -1)) {                \
        light = pick3(mine, BLINN_PHONG(row + s, hit.sphere), light); \
    }                                                                 \
    TINTED
#else
#define SHADED(on, row)                                                              \
    Vector light = BLINN_PHONG(row + scene.spheres[common].material, common);        \
    ints lit_sphere = PICK_INT(on, hit.sphere, -1);                                  \
    FOR_OTHER_HITS(s, mine, lit_sphere, common) {                                    \
        light = pick3(mine, BLINN_PHONG(row + scene.spheres[s].material, s), light); \
    }                                                                                \
    TINTED
#endif

// ROUND: where the spheres of `spheres` are in the scene's list.
#ifdef TREE
#define LISTED_IDS scene.ids
#else
#define LISTED_IDS 0
#endif

// Where a shadow ray ends, and from where the light's cone opens. RANDOM: at a point of a round light,
// and from its middle; to such a point a beam begins where the rays do, as to what is far away.
#if defined(ROUND) && defined(RANDOM)
#define TO_MIDDLE to_middle
#define LIGHT_DISTANCE (distance2 * inv_distance * cosine)
#define LIGHT_PLACE (scene.lights[k].radius > 0 ? vector(8, 8, 8) : splat(scene.lights[k].position))
#else
#define TO_MIDDLE to_light
#define LIGHT_DISTANCE (distance2 * inv_distance)
#define LIGHT_PLACE splat(scene.lights[k].position)
#endif

#if defined(LONG_LENS) || defined(ORTHOGRAPHIC) || defined(LENS)
#define ORIGIN_IN_COMMON false
#else
#define ORIGIN_IN_COMMON true
#endif

// The lanes that have hit a sphere from outside, which is what is shaded, and the first light to look
// at: where all lanes are at a far side, none.
#ifdef NEST
#define SHOWN on
#define FIRST_LIGHT (ANY(on) ? 0 : scene.light_count)
#else
#define SHOWN (hit.sphere >= 0)
#define FIRST_LIGHT 0
#endif

// NEST: the far sides that rays meet before `hit`.
#ifdef TREE
#define FAR_SIDES(hit, ray) \
    far_sides(hit, ray, scene.beads, scene.spheres, scene.ids, scene.sphere_count)
#else
#define FAR_SIDES(hit, ray) far_sides(hit, ray, scene.spheres, scene.sphere_count)
#endif

// The host defines SPLIT if a surface mirrors and transmits: the mirrored rays of a packet are put
// aside, and traced when the others have ended. So no more are aside than max_depth - 1.
#ifdef SPLIT
#define MAX_ASIDE 32
#define SOME_ASIDE (aside_count > 0)
typedef struct {
    Ray ray;
    reals weight;
    ints alive, path;
#ifdef INDIRECT
    Vector tint;
    ints scattered;
#endif
    int depth;
} Aside;
#else
#define SOME_ASIDE false
#endif

#if defined(FILM_PATHS) || defined(HASHED)
#define PATHS
#endif
// FNV's prime: paths are hashed here as in clrt/reference.py.
#define FOLLOWED(mask, path, value) \
    PICK_INT(mask, (path * 16777619 + (value)) & (ints)((INTEGER)0xffffffff), path)

// What a scene's rays meet: the kernel's arguments, as functions take them.
typedef struct {
    int max_depth;
    real shadow_bias;
    __global const Camera *camera;
    int sphere_count;
    __global const Sphere *spheres;
    int material_count;
    __global const Material *materials;
    int light_count;
    __global const Light *lights;
    __global const Shade *shades;
    __global const uchar *encloses;
#ifdef OCCLUSION
    int sky_count;
    __global const real *skies;
#endif
#ifdef BACKGROUND
    __global const real *background;
#endif
#ifdef SPHERE_COLORS
    __global const real *sphere_colors;
#endif
#ifdef NEST
    __global const Medium *around;
    __global int *lost;
#endif
#ifdef TREE
    __global const int *ids;
    __global const int *materials_of;
    __global const Bead *beads;
    __global const Node *nodes;
    __global const Leaf *leaves;
    __global const Shape *shape;
#ifdef NEST
    __global const Glass *glass;
#endif
#endif
} Scene;

#ifdef OCCLUSION
// The part of a sky that spheres leave open over some points: the mean of SKY_RAYS rays, the likelier
// the larger their cosine. ray: from the points, its direction does not count.
//
// SHARES: all lanes look the same way, drawn about the normal of one of them. That way is as likely as
// the lanes' mean cosine, so each weighs what it sees with its own cosine over that mean (the balance
// heuristic of Veach and Guibas, 1995). It is what is hidden that is weighed: under an open sky the
// part is 1, to the bit.
static reals open_sky(Scene scene,
#ifdef TREE
                      Tree tree,
#endif
                      Ray ray, Vector normal, ints on, Draw draw, int k) {
    reals hidden = 0;
    if (!ANY(on)) return 1;
    for (int i = 0; i < SKY_RAYS; i++) {
        Pair pair = drawn(draw, SKY, k, i);
        ints looks = on;
        reals part = 1;
        ray.direction = above_surface(normal, pair);
#ifdef SHARES
        uint lit = lane_bits(on), count = popcount(lit);
        uint skip = (uint)(draw.index * SKY_RAYS + i) % count;
        for (; skip; skip--) lit &= lit - 1;
        __private Vector ways[1] = {ray.direction};
        __private const real *way = (__private const real *)ways + LOWEST_BIT(lit);
        ray.direction = vector(way[0], way[LANES], way[2 * LANES]);
        reals cosine = dot3(normal, ray.direction);
        looks &= cosine > 0;
        cosine = PICK(looks, cosine, 0);
        part = cosine * (real)count / JOIN(total, LANES)(cosine);
#endif
        ints met =
            looks & met_before(ray, scene.skies[k], scene.spheres, LISTED_IDS, scene.sphere_count);
#ifdef TREE
        ints open = looks & !met;
        if (ANY(open))
            met |= occluded_in_tree(tree, ray, scene.skies[k], vector(8, 8, 8), open, true) != 0;
#endif
        hidden += PICK(met, part, 0);
    }
    return 1 - hidden / SKY_RAYS;
}
#ifdef TREE
#define OPEN_SKY(k) open_sky(scene, tree, ray, normal, reached, draw, k)
#else
#define OPEN_SKY(k) open_sky(scene, ray, normal, reached, draw, k)
#endif
#endif

// What the camera rays through a packet of pixels bring.
#ifdef RANDOM
static Sample traced(Scene scene, Pixels at, Draw draw) {
#else
static Sample traced(Scene scene, Pixels at) {
#endif
    int s;
#ifdef LENS
    // From a point of the lens to where the ray from its middle is in focus.
    Pair lens = drawn(draw, LENS_POINT, 0, 0);
    reals lens_x, lens_y, off_axis = scene.camera->aperture * sqrt(lens.u);
    sine_cosine_of_turn(lens.v, &lens_y, &lens_x);
    lens_x *= off_axis, lens_y *= off_axis;
    at.x -= lens_x * scene.camera->inv_focus;
    at.y -= lens_y * scene.camera->inv_focus;
#endif
#ifndef ORTHOGRAPHIC
    reals length2 = at.x * at.x + (at.y * at.y + 1);
    reals inv_length = inverse_sqrt(length2);
#endif
#ifdef TREE
    Tree tree = {scene.nodes, scene.leaves, scene.shape[0]};
#ifdef NEST
    tree.glass = scene.glass;
#endif
#endif
#ifdef ORTHOGRAPHIC
#ifdef TREE
    Vector to_camera = splat(scene.camera->back);
    Ray ray = {in_world(scene.camera, at.x, at.y, 0), scaled(to_camera, -1), -1, -1};
    Hit hit = visible_listed(ray, scene.spheres, scene.ids, scene.sphere_count);
    hit = nearest_in_tree(tree, hit, ray, (ints)(-1), ORIGIN_IN_COMMON);
#else
    Vector to_camera = vector(0, 0, 1);
    Ray ray = {vector(at.x, at.y, 0), vector(0, 0, -1), -1, -1};
#ifdef LITERAL
    ray.origin = plus(ray.origin, splat(scene.camera->eye));
#endif
    Hit hit = visible(at, ray, scene.spheres, scene.sphere_count);
#endif
    Vector point = along(ray.origin, hit.distance, ray.direction);
#else
#ifdef TREE
    Vector eye = splat(scene.camera->eye);
#ifdef LENS
    eye = plus(eye, in_world(scene.camera, lens_x, lens_y, 0));
#endif
    Vector to_camera = scaled(in_world(scene.camera, at.x, at.y, -1), -inv_length);
    Ray ray = {eye, scaled(to_camera, -1), -1, -1};
#ifdef LONG_LENS
    real ahead = dot_real(scene.camera->eye, scene.camera->back);
    reals start_x = at.x * ahead, start_y = at.y * ahead;
#ifdef LENS
    start_x += lens_x, start_y += lens_y;
#endif
    ray.origin = in_world(scene.camera, start_x, start_y, 0);
#endif
    Hit hit = nearest_listed(ray, -1, scene.spheres, scene.ids, scene.sphere_count);
    hit = nearest_in_tree(tree, hit, ray, (ints)(-1), ORIGIN_IN_COMMON);
    Vector point = along(ray.origin, hit.distance, ray.direction);
#else
    Vector through = vector(at.x, at.y, -1);
    Vector to_camera = scaled(through, -inv_length);
#if defined(LITERAL) || defined(LONG_LENS) || defined(LENS)
    Vector eye = splat(scene.camera->eye);
#ifdef LENS
    eye = plus(eye, vector(lens_x, lens_y, 0));
#endif
    Ray ray = {eye, scaled(to_camera, -1), -1, -1};
#ifdef LONG_LENS
    ray.origin = vector(at.x * eye.z, at.y * eye.z, 0);
#ifdef LENS
    ray.origin = plus(ray.origin, vector(lens_x, lens_y, 0));
#endif
#endif
    Hit hit = nearest(ray, scene.spheres, scene.sphere_count);
    Vector point = along(ray.origin, hit.distance, ray.direction);
#else
    Vector eye = vector(0, 0, 0);
    Ray ray = {eye, scaled(to_camera, -1), -1, -1};
    Hit hit = visible(at, length2, scene.spheres, scene.sphere_count);
    Vector point = scaled(through, hit.distance);
#endif
#endif
#endif

#ifdef NEST
    ray.inside = inside_of(scene.around);
    if (scene.around[0].sphere) {
#ifndef TREE
        hit = nearest(ray, scene.spheres, scene.sphere_count);  // visible() has other units
#endif
        hit = FAR_SIDES(hit, ray);
        point = along(ray.origin, hit.distance, ray.direction);
    }
#endif

    Vector color = vector(0, 0, 0);
    reals weight = 1;  // the product of the reflections and transmissions so far
#ifdef INDIRECT
    Vector tint = vector(1, 1, 1);  // of diffuse colours
    ints scattered = 0;             // the lanes whose ray comes from a diffuse surface
#endif
    ints path = 0;
#if defined(FILM_ALPHA) || defined(RANDOM)
    reals alpha = PICK(hit.sphere >= 0, 1, 0);
#endif
#ifdef FILM_PASSES
    Vector seen = vector(0, 0, 0);  // the normals of what is hit
#endif
#ifdef SPLIT
    Aside aside[MAX_ASIDE];
    int aside_count = 0;
    ints traced = weight > 0, ended = 0;  // the lanes of this path; the hashes of those before
#endif
    for (int depth = 1; SOME_ASIDE || ANY(hit.sphere >= 0); depth++) {
        ray.leaves = hit.sphere;
#ifdef RANDOM
        draw.bounce = depth - 1;
#endif
#ifdef TREE
        ints material = 0;
        Surface surface =
            surface_of_bead(point, hit.sphere, scene.beads, scene.materials_of, scene.materials,
#ifdef NEST
                            scene.glass,
#endif
                            scene.shadow_bias, &material);
        // Of the list beside the tree.
        for (s = 0; s < scene.sphere_count; s++) {
            ints mine = hit.sphere == scene.ids[s];
            if (ANY(mine))
                surface = pick_surface(mine, surface_at(point, scene.spheres + s, scene.materials),
                                       surface);
        }
#else
        int common = hit.common;
        Surface surface = surface_at(point, scene.spheres + common, scene.materials);
        ray.all_leave = common;
        FOR_OTHER_HITS(s, mine, hit.sphere, common) {
            surface =
                pick_surface(mine, surface_at(point, scene.spheres + s, scene.materials), surface);
            ray.all_leave = -1;
        }
#ifdef LITERAL
        ray.all_leave = -1;  // that sphere is tested like any other
#endif
#endif
        Vector normal = surface.normal;
#ifdef FILM_PASSES
        seen = normal;
        break;
#endif
        ray.origin = along(point, scene.shadow_bias, normal);
#ifdef PATHS
        path = FOLLOWED(hit.sphere >= 0, path, hit.sphere + 1);
#endif

#ifdef PHONG
        ints phong = surface.exponent < 0;
        reals exponent = PICK(phong, -surface.exponent, surface.exponent);
        // Light from there would be mirrored to the camera: R.V = L.mirrored.
        Vector mirrored = along(scaled(to_camera, -1), 2 * dot3(normal, to_camera), normal);
#endif
        ints reached = 0;  // the lanes that some light reaches
#ifdef ROUND
        reals missed = 1;  // the part that no light reaches: mirrored light ends with it
#endif
#ifdef NEST
        ints out = (hit.sphere >= 0) & is_inside(ray, hit.sphere);  // at a far side
        ints on = (hit.sphere >= 0) & !out;
#endif
#if defined(AMBIENT) || defined(OCCLUSION)
        {
            reached = SHOWN;
#ifdef ROUND
            missed = 0;
#endif
            reals diffuse = 0, specular = 0;
            __global const Shade *shade = scene.shades + scene.light_count * scene.material_count;
#ifdef AMBIENT
            {
                SHADED(reached, shade)
                color = pick3(reached, along(color, weight, light), color);
                shade += scene.material_count;
            }
#endif
#ifdef OCCLUSION
            for (int k = 0; k < scene.sky_count; k++, shade += scene.material_count) {
                reals share = weight * OPEN_SKY(k);
                SHADED(reached, shade)
                color = pick3(reached, along(color, share, light), color);
            }
#endif
        }
#endif
        for (int k = FIRST_LIGHT; k < scene.light_count; k++) {
            Vector to_light = minus(splat(scene.lights[k].position), ray.origin);
            reals distance2 = dot3(to_light, to_light);
            reals inv_distance = inverse_sqrt(distance2);
            to_light = scaled(to_light, inv_distance);
#if defined(ROUND) && defined(RANDOM)
            Vector to_middle = to_light;
            reals cosine = 1;  // of the angle between the middle and the point of the light
            if (scene.lights[k].radius > 0) {
                Cap cap = cap_of(to_light, distance2 * inv_distance, scene.lights[k].radius);
                Pair pair = drawn(draw, LIGHT_POINT, k, 0);
                to_light = tilted(to_light, pair.u * cap.versine, pair.v);
                cosine = 1 - pair.u * cap.versine;
            }
#endif
            reals diffuse = dot3(normal, to_light);
            Ray shadow = {ray.origin, to_light, ray.leaves, ray.all_leave};
#ifdef NEST
            shadow.inside = ray.inside;
            ints veil = 0;
#endif
            ints lit = SHOWN & (diffuse >= surface.horizon);
            reals share = weight;  // of this light's in the colour
#ifdef SPOT
            reals part = cone(scene.lights + k, TO_MIDDLE);
            lit &= part > 0;
            share *= part;
#endif
#if defined(ROUND) && !defined(RANDOM)
            if (scene.lights[k].radius > 0) {
                Cap cap = cap_of(to_light, distance2 * inv_distance, scene.lights[k].radius);
                lit = SHOWN & (diffuse > -cap.sine);
#ifdef SPOT
                lit &= part > 0;
#endif
                Cover cover = covered_by(shadow, cap, lit, scene.encloses + k * scene.sphere_count,
                                         scene.spheres, LISTED_IDS, scene.sphere_count);
#ifdef TREE
                cover = covered_in_tree(tree, cover, shadow, cap, lit, scene.lights[k].position,
                                        scene.lights[k].radius);
#endif
                reals above = 1;
                if (ANY(lit & (diffuse < cap.sine)))
                    above = 1 - part_covered(cap, scaled(normal, -1), HALF_PI, 1);
                reals visible = visible_part(cover, above);
                lit &= visible > 0;
                share *= visible;
                diffuse = mean_cosine(cap, diffuse) / PICK(above > 0, above, 1);
                missed *= PICK(lit, 1 - visible, 1);
#ifdef NEST
                veil = cover.veil;
                lit &= veil < OPAQUE;
#endif
            } else
#endif
            {
#ifdef NEST
#ifdef TREE
                if (ANY(lit))
                    veil = occluded_by_listed(shadow, LIGHT_DISTANCE,
                                              scene.encloses + k * scene.sphere_count,
                                              scene.spheres, scene.ids, scene.sphere_count);
                lit &= veil < OPAQUE;
                if (ANY(lit)) {
                    ints more =
                        occluded_in_tree(tree, shadow, LIGHT_DISTANCE, LIGHT_PLACE, lit, false);
                    veil = veiled(veil, lit, more);
                }
#else
                if (ANY(lit))
                    veil = occluded(shadow, LIGHT_DISTANCE, scene.encloses + k * scene.sphere_count,
                                    scene.spheres, scene.sphere_count);
#endif
                lit &= veil < OPAQUE;
#elif defined(TREE)
                if (ANY(lit))
                    lit &= !occluded_by_listed(shadow, LIGHT_DISTANCE,
                                               scene.encloses + k * scene.sphere_count,
                                               scene.spheres, scene.ids, scene.sphere_count);
                if (ANY(lit))
                    lit &= !occluded_in_tree(tree, shadow, LIGHT_DISTANCE, LIGHT_PLACE, lit, false);
#else
            lit &= !occluded(shadow, LIGHT_DISTANCE, scene.encloses + k * scene.sphere_count,
                             scene.spheres, scene.sphere_count);
#endif
#ifdef ROUND
                missed = PICK(lit, 0, missed);
#endif
            }
#ifdef PATHS
#ifdef NEST
            ints dim = TO_INTS(TO_REALS(veil) * (64 / VEIL) + REAL(0.5));  // to a hundredth
            path = FOLLOWED(SHOWN, path, PICK_INT(lit, 1 + dim, 0));
#else
            path = FOLLOWED(hit.sphere >= 0, path, PICK_INT(lit, 1, 0));
#endif
#endif
            if (!ANY(lit)) continue;
            reached |= lit;
#ifdef PHONG
            Vector half_way = plus(to_light, to_camera);
            reals specular = highlight(pick3(phong, mirrored, normal),
                                       pick3(phong, to_light, half_way), exponent);
#else
            reals specular = highlight(normal, plus(to_light, to_camera), surface.exponent);
#endif
#ifdef INDIRECT
            specular = PICK(scattered, 0, specular);
#endif
            __global const Shade *shade = scene.shades + k * scene.material_count;
#ifdef ATTENUATION
            reals left = faded(scene.lights + k, distance2 * inv_distance);
            diffuse *= left;
            specular *= left;
#endif
#ifdef NEST
            reals clear = unveiled(veil);
            diffuse *= clear;
            specular *= clear;
#endif
            SHADED(lit, shade)
            color = pick3(lit, along(color, share, light), color);
        }
#ifdef REFLECTION
#ifdef ROUND
        surface.reflection *= 1 - missed;
#endif
#define MIRRORED along(ray.direction, -2 * dot3(ray.direction, normal), normal)
#if defined(GLOSS) || defined(INDIRECT)
        Vector onward = MIRRORED;
#define ONWARD onward
#else
#define ONWARD MIRRORED
#endif
#ifdef NEST
        ints entering = on & (surface.transmission > 0), crossing = entering | out;
#ifdef INDIRECT
        entering &= !scattered;  // to whom glass is opaque
        crossing = entering | out;
#endif
#endif
#if defined(GLOSS) || defined(INDIRECT)
        Pair pair = drawn(draw, MIRROR, 0, 0);
#endif
#ifdef GLOSS
        onward = blurred(onward, normal, surface.spread, pair);
#endif
#ifdef INDIRECT
        {
            // Either is taken as often as it is strong, and weighs the more.
            ints shown = SHOWN;
#ifdef NEST
            shown &= !entering;
#endif
            Vector albedo = surface.diffuse;
#if defined(SPHERE_COLORS) && defined(TREE)
            albedo = times(albedo, color_of(scene.sphere_colors, hit.sphere));
#elif defined(SPHERE_COLORS)
            Vector own = color_of(scene.sphere_colors, common);
            FOR_OTHER_HITS(s, mine, hit.sphere, common) {
                own = pick3(mine, color_of(scene.sphere_colors, s), own);
            }
            albedo = times(albedo, own);
#endif
            reals mirrors_part = PICK(reached, surface.reflection, 0);
            reals scatters = larger(albedo.x, larger(albedo.y, albedo.z)),
                  both = mirrors_part + scatters;
            ints bounces =
                shown & (drawn(draw, CHOICE, 0, 0).u * both >= mirrors_part) & (scatters > 0);
            onward = pick3(bounces, above_surface(normal, pair), onward);
            surface.reflection = PICK(shown, both, surface.reflection);
            tint = pick3(bounces, times(tint, scaled(albedo, 1 / scatters)), tint);
            scattered |= bounces;
            reached |= bounces;
        }
#endif
#ifdef NEST
        ints mirrors = reached & on & !entering;
        Ray mirror = ray;
        mirror.direction = ONWARD;
        if (!ANY(crossing)) {
            ray = mirror;
            weight *= surface.reflection;
        } else {
            Inside after = ray.inside;
            ints lacks_room = enter(&after, entering, hit.sphere, surface.order, surface.ior);
            leave(&after, out, hit.sphere);
            Refraction bent = refracted(ray.direction, pick3(out, scaled(normal, -1), normal),
                                        medium_of(ray.inside), medium_of(after));
            ints through = crossing & !bent.total;
            if (depth < scene.max_depth && ANY(lacks_room & through)) atomic_inc(scene.lost);
            // Of what is transmitted; total reflection takes nothing.
            reals transmission = surface.transmission, reflection = surface.reflection;
#ifdef SPLIT
            reals part = transmission * surface.fresnel * bent.mirrored;
            transmission -= part;
            reflection += part;
            mirrors |= reached & entering & through;
#endif
            reals transmitted = weight * PICK(entering & through, transmission, 1);
            reals mirrored_weight = weight * reflection;
#ifdef PATHS
            path = FOLLOWED(crossing, path, PICK_INT(bent.total, 1, 0));
#endif
#ifdef SPLIT
            ints both = crossing & mirrors & (transmitted > 0) & (mirrored_weight > 0);
            if (depth < scene.max_depth && ANY(both)) {
                if (aside_count < MAX_ASIDE) {
                    Aside split = {mirror, mirrored_weight, both, path};
                    split.depth = depth;
#ifdef INDIRECT
                    split.tint = tint;
                    split.scattered = scattered;
#endif
                    aside[aside_count++] = split;
                } else {
                    atomic_inc(scene.lost + 1);
                }
            }
            crossing &= transmitted > 0;
#endif
            ray.origin = pick3(crossing, point, ray.origin);
            ray.direction = pick3(crossing, bent.direction, mirror.direction);
            ray.inside = pick_inside(through & crossing, after, ray.inside);
            weight = PICK(crossing, transmitted, mirrored_weight);
        }
        ints alive = (crossing | mirrors) & (weight > 0);
#ifdef SPLIT
        if (depth == scene.max_depth || !ANY(alive)) {
            if (aside_count == 0) break;
            Aside next = aside[--aside_count];
            ended += PICK_INT(traced, path, 0);
            ray = next.ray;
            weight = next.weight;
            traced = alive = next.alive;
            path = next.path;
            depth = next.depth;
#ifdef INDIRECT
            tint = next.tint;
            scattered = next.scattered;
#endif
        }
#else
        if (depth == scene.max_depth || !ANY(alive)) break;
#endif
#else
        weight *= surface.reflection;
        ints alive = reached & (weight > 0);
        if (depth == scene.max_depth || !ANY(alive)) break;
        ray.direction = ONWARD;
#endif
#ifdef TREE
        hit = nearest_listed(ray, alive, scene.spheres, scene.ids, scene.sphere_count);
        hit = nearest_in_tree(tree, hit, ray, alive, false);
#else
        hit = nearest(ray, scene.spheres, scene.sphere_count);
        hit.sphere = PICK_INT(alive, hit.sphere, -1);
#endif
#ifdef NEST
        if (ANY(alive & (ray.inside.sphere[0] != 0))) {
            hit = FAR_SIDES(hit, ray);
            hit.sphere = PICK_INT(alive, hit.sphere, -1);
        }
#endif
#ifdef BACKGROUND
        ints gone = alive & (hit.sphere < 0);
#ifdef INDIRECT
        gone &= !scattered;
#endif
        color = pick3(gone, along(color, weight, splat(scene.background)), color);
#endif
        point = along(ray.origin, hit.distance, ray.direction);
#ifndef ORTHOGRAPHIC
        to_camera = unit(minus(eye, point));
#endif
#else
        break;
#endif
    }
#if defined(SPLIT) && defined(PATHS)
    path = ended + PICK_INT(traced, path, 0);
#endif
#ifdef FILM_PASSES
    // Along the ray, of which the camera is a point or (ORTHOGRAPHIC) beside one.
    reals depth = dot3(minus(point, splat(scene.camera->eye)), ray.direction) * scene.camera->unit;
#ifndef TREE
    seen = in_world(scene.camera, seen.x, seen.y, seen.z);
#endif
    Sample sample = {hit.sphere, depth, seen};
#else
    Sample sample = {color, 0, path};
#if defined(FILM_ALPHA) || defined(RANDOM)
    sample.alpha = alpha;
#endif
#endif
    return sample;
}

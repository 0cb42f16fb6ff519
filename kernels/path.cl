// Path: what each ray of a packet carries, from the camera on, and what it has hit.

// PATHS: a hash, and in the lanes of a mask what was met next: with FNV's prime, as clrt/reference
// hashes paths.
#define FOLLOWED(mask, path, value) \
    PICK_INT(mask, (path * 16777619 + (value)) & (ints)((INTEGER)0xffffffff), path)

// The paths of a packet.
typedef struct {
    Ray ray;
    Hit hit;
    Vector point;      // of that hit
    Vector to_camera;  // from there; after a mirror as if nothing had bent it
    Vector eye;        // where the camera stands, or (LENS) a point of its lens
    Draw draw;         // RANDOM
    int depth;         // of the hit, from 1 on
    reals weight;      // the product of the reflections and of what went through so far
    Vector tint;       // INDIRECT: of diffuse colours
    ints scattered;    // INDIRECT: the lanes whose ray comes from a diffuse surface
    ints hash;         // PATHS: of what was met
    Vector color;      // that has come to the camera, linear RGB
} Path;

// Where a path is: what lights it, and where it goes on.
typedef struct {
    Surface surface;
    ints material;        // TREE: each lane's
    int common;           // without TREE: a sphere that most lanes have hit
    ints shown;           // the lanes that have hit something from outside, which is what is shaded
    ints out;             // NEST: the lanes at a far side
    ints reached;         // the lanes that some light reaches
    reals missed;         // ROUND: the part that no light reaches: mirrored light ends with it
    ints phong;           // PHONG: the lanes with Phong's highlight
    Vector mirrored;      // PHONG: light from there would be mirrored to the camera
    Facing facing;        // FACES
    FaceCorners corners;  // GOURAUD or CORNER_COLORS
    Vector tint;          // GOURAUD and CORNER_COLORS: is added to diffuse light's own colour
    Vector normal;        // SMOOTH: that is shaded with
} Place;

// LENS: a point of the lens in camera space, and where the ray from there goes through the screen so that it meets the
// ray from the lens' middle where that is in focus.
static Vector point_of_lens(__global const Camera *camera, Draw draw, Vector *through) {
    Pair pair = drawn(draw, LENS_POINT, 0, 0);
    reals x, y, off_axis = camera->aperture * sqrt(pair.u);
    sine_cosine_of_turn(pair.v, &y, &x);
    x *= off_axis, y *= off_axis;
    through->x -= x * camera->inv_focus;
    through->y -= y * camera->inv_focus;
    return vector(x, y, 0);
}

// ORTHOGRAPHIC: a line through the screen at right angles.
static void go_straight(const Scene *scene, Path *path, Pixels at) {
    path->to_camera = in_space(scene, vector(0, 0, 1));
    path->ray.origin = in_space(scene, vector(at.x, at.y, 0));
    if (LITERAL) path->ray.origin = plus(path->ray.origin, splat(scene->camera->eye));
    path->ray.direction = scaled(path->to_camera, -1);
}

// A ray from the camera; where it goes through the screen. Where nothing moves the camera from 0 it
// keeps that.
static Vector go_from_eye(const Scene *scene, Path *path, Pixels at) {
    Vector through = vector(at.x, at.y, -1), lens = vector(0, 0, 0);
    if (LENS) lens = point_of_lens(scene->camera, path->draw, &through);
    reals length2 = through.x * through.x + (through.y * through.y + 1);
    path->to_camera = scaled(in_space(scene, through), -inverse_sqrt(length2));
    path->ray.direction = scaled(path->to_camera, -1);
    if (!TREE && !LITERAL && !LONG_LENS && !LENS && !OPACITY) return through;
    path->eye = splat(scene->camera->eye);
    if (LENS) path->eye = plus(path->eye, in_space(scene, lens));
    path->ray.origin = path->eye;
    if (LONG_LENS) {
        real ahead =
            TREE ? dot_real(scene->camera->eye, scene->camera->back) : scene->camera->eye[2];
        Vector start = vector(through.x * ahead, through.y * ahead, 0);
        if (LENS) start = plus(start, lens);
        path->ray.origin = in_space(scene, start);
    }
    return through;
}

// A packet's camera rays; where they go through the screen.
static Vector look(const Scene *scene, Path *path, Pixels at, Draw draw) {
    path->draw = draw;
    path->weight = 1;
    path->tint = vector(1, 1, 1);
    path->ray.leaves = path->ray.all_leave = -1;
    if (OPACITY) path->ray.passed[0] = nothing_passed();
    if (!ORTHOGRAPHIC) return go_from_eye(scene, path, at);
    go_straight(scene, path, at);
    return vector(at.x, at.y, 0);
}

// Finds what camera rays meet, and where. known: TILES: which spheres and faces those are.
static void meet_first(const Scene *scene, Path *path, Pixels at, Vector through,
                       const Hit *known) {
    bool common = !ORTHOGRAPHIC && !LONG_LENS && !LENS;
    if (TILES) {
        path->hit = *known;
        if (CAPSULES)
            path->hit = nearest_in_tree(&scene->capsules->tree, OF_CAPSULES, path->hit, path->ray,
                                        (ints)(-1), common);
    } else if (ORTHOGRAPHIC && !TREE) {
        path->hit = visible_along(at, path->ray, scene->spheres, scene->sphere_count);
    } else if (TREE || LITERAL || LONG_LENS || LENS || OPACITY) {
        path->hit = first_hit(scene, path->ray, (ints)(-1), common, ORTHOGRAPHIC);
    } else {
        reals length2 = through.x * through.x + (through.y * through.y + 1);
        path->hit = visible(at, length2, scene->spheres, scene->sphere_count);
        path->point = scaled(through, path->hit.distance);
        return;
    }
    path->point = along(path->ray.origin, path->hit.distance, path->ray.direction);
}

// The paths through a packet of pixels, and what they meet first. known: see meet_first().
static Path from_camera(const Scene *scene, Pixels at, Draw draw, const Hit *known) {
    Path path = {{{0}}};
    Vector through = look(scene, &path, at, draw);
    meet_first(scene, &path, at, through, known);
    if (NEST) {
        path.ray.inside = inside_of(scene->around);
        if (scene->around[0].sphere) {
            // In units of a direction of length 1, which visible() has not.
            if (!TREE) path.hit = nearest(path.ray, scene->spheres, scene->sphere_count);
            path.hit = first_side(scene, path.hit, path.ray);
            path.point = along(path.ray.origin, path.hit.distance, path.ray.direction);
        }
    }
    return path;
}

// The surfaces that paths have hit in the list; whether all rays leave the same sphere.
static Surface surface_in_list(const Scene *scene, Path *path) {
    int s, common = path->hit.common;
    Surface surface =
        surface_at(path->point, scene->spheres + common, scene->materials, scene->glass + common);
    path->ray.all_leave = common;
    FOR_OTHER_HITS(s, mine, path->hit.id, common) {
        Surface other =
            surface_at(path->point, scene->spheres + s, scene->materials, scene->glass + s);
        surface = pick_surface(mine, other, surface);
        path->ray.all_leave = -1;
    }
    if (LITERAL) path->ray.all_leave = -1;  // that sphere is tested like any other
    return surface;
}

// TREE: the surfaces that paths have hit in the tree and in the list beside it. material: their indices.
static Surface surface_in_tree(const Scene *scene, Path *path, ints *material) {
    Surface surface = surface_of_beads(path->point, path->hit.id, scene->beads, scene->materials_of,
                                       scene->materials, scene->glass, scene->shadow_bias,
                                       scene->capsules, scene->faces, material);
    for (int s = 0; s < scene->sphere_count; s++) {
        ints mine = path->hit.id == scene->ids[s];
        if (!ANY(mine)) continue;
        Surface other = surface_at(path->point, scene->spheres + s, scene->materials,
                                   scene->glass + (NEST ? scene->ids[s] : 0));
        surface = pick_surface(mine, other, surface);
    }
    return surface;
}

// FACES: the faces that paths have met. Returns how far off them rays start.
static reals arrive_at_faces(const Scene *scene, const Path *path, Place *place) {
    Facing facing = facing_of(scene, path->ray, path->hit.id);
    Surface *surface = &place->surface;
    surface->normal = pick3(facing.there, facing.normal, surface->normal);
    if (SMOOTH) place->normal = surface->normal;
    if (SMOOTH || GOURAUD || CORNER_COLORS) {
        FaceCorners corners = face_corners(scene, &facing, path->point, path->hit.id);
        if (SMOOTH)
            place->normal = pick3(facing.there, normal_between(&facing, &corners), surface->normal);
        if (GOURAUD || CORNER_COLORS) place->corners = corners;
    }
    place->facing = facing;
    return facing.lift;
}

// The place where paths are: its surfaces, and which lanes are shaded. Their rays' origin is moved there,
// and PATHS: their hashes have it.
static Place arrive(const Scene *scene, Path *path) {
    Place place = {{{0}}};
    path->ray.leaves = path->hit.id;
    path->draw.bounce = path->depth - 1;
    place.common = path->hit.common;
    if (TREE) {
        place.surface = surface_in_tree(scene, path, &place.material);
    } else {
        place.surface = surface_in_list(scene, path);
    }
    reals lift = scene->shadow_bias;
    if (FACES) lift = arrive_at_faces(scene, path, &place);
    Vector normal = place.surface.normal;
    path->ray.origin = along(path->point, lift, normal);
    if (SMOOTH) normal = place.normal;
    place.shown = path->hit.id >= 0;
    if (PATHS) {
        ints token = path->hit.id + 1;
        if (FACES) token = PICK_INT(place.facing.there, place.facing.token, token);
        path->hash = FOLLOWED(place.shown, path->hash, token);
    }
    if (PHONG) {
        place.phong = place.surface.exponent < 0;
        place.surface.exponent = PICK(place.phong, -place.surface.exponent, place.surface.exponent);
        Vector to_camera = path->to_camera;
        place.mirrored = along(scaled(to_camera, -1), 2 * dot3(normal, to_camera), normal);
    }
    place.missed = 1;
    if (NEST) {
        place.out = place.shown & is_inside(path->ray, path->hit.id);
        place.shown &= !place.out;
    }
    return place;
}

// Scene: what a packet's rays meet: in the list of spheres, in their tree, in those of capsules and faces.

// The kernel's arguments, as functions take them.
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
    int sky_count;
    __global const real *skies;
    __global const real *background;
    __global const real *sphere_colors;
    __global const Glass *glass;
    __global const Medium *around;
    __global int *lost;
    __global const int *ids;  // 0 without TREE: `spheres` is then the scene's list
    __global const int *materials_of;
    __global const Bead *beads;
    Tree tree;
    CapsuleList capsules[ROOM(CAPSULES)];
    FaceList faces[ROOM(FACES)];
} Scene;

// The end of rays that have none in common: so far that a beam begins where they do.
#define FAR_AWAY vector(8, 8, 8)

// Most packets hit one sphere only, `common`: what the lanes need of it is loaded once for all of
// them. This runs its body for each other sphere that a lane has hit, see FOR_EACH_OF.
#define FOR_OTHER_HITS(s, mine, hit, common) FOR_EACH_OF(s, mine, PICK_INT(hit == common, -1, hit))

// Runs its body for each number in `numbers`, -1 in lanes that do not count: with the number in `s`,
// a scalar, and the lanes that have it in `mine`.
#define FOR_EACH_OF(s, mine, numbers)                                       \
    for (ints mine, rest_ = numbers;                                        \
         ANY(rest_ >= 0) && (s = GREATEST(rest_), mine = rest_ == s, true); \
         rest_ = PICK_INT(mine, -1, rest_))

// From the camera's axes to those of the spheres' space.
static Vector in_space(const Scene *scene, Vector v) {
    if (TREE) return in_world(scene->camera, v.x, v.y, v.z);
    return v;
}

// TREE: what rays meet first in the list beside the tree. line: see first_hit().
static Hit first_listed(const Scene *scene, Ray ray, ints on, bool line) {
    if (ORTHOGRAPHIC && line)
        return visible_listed(ray, on, scene->spheres, scene->ids, scene->glass,
                              scene->sphere_count);
    return nearest_listed(ray, on, scene->spheres, scene->ids, scene->glass, scene->sphere_count);
}

// CAPSULES or FACES: what rays meet first, beside the spheres that they do.
static Hit nearer_than_spheres(const Scene *scene, Hit hit, Ray ray, ints on, bool common) {
    if (CAPSULES) hit = nearest_in_tree(&scene->capsules->tree, OF_CAPSULES, hit, ray, on, common);
    if (FACES) hit = nearest_in_tree(&scene->faces->tree, OF_FACES, hit, ray, on, common);
    return hit;
}

// What rays meet first, in the lanes that are on. common: they have one origin. line:
// ORTHOGRAPHIC and OPACITY, they have no start.
static Hit first_hit(const Scene *scene, Ray ray, ints on, bool common, bool line) {
    Hit hit;
    if (TREE) {
        hit = first_listed(scene, ray, on, line);
        if (OPACITY) hit.later[0].left = LATER;
        // Two returns: one would cost scenes of spheres other instructions.
        if (!CAPSULES && !FACES)
            return nearest_in_tree(&scene->tree, OF_SPHERES, hit, ray, on, common);
        hit = nearest_in_tree(&scene->tree, OF_SPHERES, hit, ray, on, common);
        return nearer_than_spheres(scene, hit, ray, on, common);
    }
    if (ORTHOGRAPHIC && line) {
        hit = visible_along((Pixels){0}, ray, scene->spheres, scene->sphere_count);
    } else {
        hit = nearest(ray, scene->spheres, scene->sphere_count);
    }
    hit.id = PICK_INT(on, hit.id, -1);
    return hit;
}

// NEST: `hit`, or the far side of a sphere that a ray is inside of.
static Hit first_side(const Scene *scene, Hit hit, Ray ray) {
    if (TREE) {
        return far_sides_of_beads(hit, ray, scene->beads, scene->spheres, scene->ids,
                                  scene->sphere_count);
    }
    return far_sides(hit, ray, scene->spheres, scene->sphere_count);
}

// TREE: what the tree of a kind takes of a light, beside what is taken. See taken_in_tree().
static ints taken_with_tree(const Tree *tree, int kind, ints taken, Ray ray, reals distance,
                            Vector light, ints on) {
    on &= !takes_all(taken);
    if (!ANY(on)) return taken;
    ints more = taken_in_tree(tree, kind, ray, distance, light, on, false);
    return VEILED ? veiled(taken, on, more) : taken | more;
}

// What is taken of light k for the rays that are on, see taken_with(): rays to the light, which end
// at `distance`. light: where they end, if that is one point; else far away.
static ints taken_of_light(const Scene *scene, int k, Ray ray, reals distance, Vector light,
                           ints on) {
    __global const uchar *encloses = scene->encloses + k * scene->sphere_count;
    ints taken = 0;
    if (!TREE) {
        if (VEILED && !ANY(on)) return taken;
        return occluded(ray, distance, encloses, scene->spheres, scene->glass, scene->sphere_count);
    }
    if (ANY(on))
        taken = occluded_by_listed(ray, distance, encloses, scene->spheres, scene->ids,
                                   scene->glass, scene->sphere_count);
    taken = taken_with_tree(&scene->tree, OF_SPHERES, taken, ray, distance, light, on);
    if (CAPSULES) {
        taken =
            taken_with_tree(&scene->capsules->tree, OF_CAPSULES, taken, ray, distance, light, on);
    }
    if (FACES)
        taken = taken_with_tree(&scene->faces->tree, OF_FACES, taken, ray, distance, light, on);
    return taken;
}

// ROUND: what spheres cover of light k.
static Cover cover_of_light(const Scene *scene, int k, Ray ray, Cap cap, ints on) {
    __global const Light *light = scene->lights + k;
    Cover cover = covered_by(ray, cap, on, scene->encloses + k * scene->sphere_count,
                             scene->spheres, scene->ids, scene->glass, scene->sphere_count);
    if (!TREE) return cover;
    return covered_in_tree(&scene->tree, cover, ray, cap, on, light->position, light->radius);
}

// OCCLUSION and TREE: what is met in the tree of a kind, beside what is met before. See met_by().
static ints met_with_tree(const Tree *tree, int kind, ints met, Ray ray, reals distance, ints on) {
    ints open = on & !(OPACITY ? met >= OPAQUE : met);
    if (!ANY(open)) return met;
    ints more = taken_in_tree(tree, kind, ray, distance, FAR_AWAY, open, true);
    return OPACITY ? veiled(met, open, more) : met | (more != 0);
}

// OCCLUSION: the rays that are on and meet something before that distance, glass as well. OPACITY: what
// is taken of them by what they meet.
static ints met_by(const Scene *scene, Ray ray, reals distance, ints on) {
    ints met =
        met_before(ray, distance, scene->spheres, scene->ids, scene->glass, scene->sphere_count);
    met = OPACITY ? PICK_INT(on, met, 0) : on & met;
    if (!TREE) return met;
    met = met_with_tree(&scene->tree, OF_SPHERES, met, ray, distance, on);
    if (CAPSULES) met = met_with_tree(&scene->capsules->tree, OF_CAPSULES, met, ray, distance, on);
    if (FACES) met = met_with_tree(&scene->faces->tree, OF_FACES, met, ray, distance, on);
    return met;
}

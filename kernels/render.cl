// Render: the kernel. A work-item follows the paths of one packet of pixels (paper, section 11.11).
//
// The host defines REFLECTION if a path can go on after its first hit: a material reflects and
// max_depth is more than 1. The other things that a scene may have or not are LONG_LENS (camera.cl)
// and LIGHT_INSIDE (sphere.cl); everything else about it is run-time data.

// Most packets hit one sphere only, `common`: what the lanes need of it is loaded once for all of
// them. This runs its body for each other sphere that a lane has hit, with its index in `s`, a
// scalar, and with the lanes that hit it in `mine`. hit: indices, -1 in lanes that do not count.
#define FOR_OTHER_HITS(s, mine, hit, common)                                \
    for (ints mine, rest_ = PICK_INT(hit == common, -1, hit);               \
         ANY(rest_ >= 0) && (s = GREATEST(rest_), mine = rest_ == s, true); \
         rest_ = PICK_INT(mine, -1, rest_))

// FNV's prime: paths are hashed here as in clrt/reference.py.
#define HASHED(mask, path, value) \
    PICK_INT(mask, (path * 16777619 + (value)) & (ints)((INTEGER)0xffffffff), path)

// film: this band of rows, width * CHANNELS each; its first pixel is (first_column, first_row) of
// the picture, where a packet begins: first_column is a multiple of LANES. Global size: (packets of
// a row, rounded up to whole work-groups; rows).
__kernel void render(__global channel *film, int first_row, int width, int first_column,
                     int max_depth, real shadow_bias, __global const Camera *camera,
                     int sphere_count, __global const Sphere *spheres, int material_count,
                     __global const Material *materials, int light_count,
                     __global const Light *lights, __global const Shade *shades,
                     __global const uchar *encloses) {
    int column = get_global_id(0) * LANES, row = get_global_id(1), s;
    if (column >= width) return;

    Pixels at = pixels_at(camera, first_column + column, first_row + row);
    reals length2 = at.x * at.x + (at.y * at.y + 1);
    reals inv_length = inverse_sqrt(length2);
    Vector through = vector(at.x, at.y, -1);
    Vector to_camera = scaled(through, -inv_length);
#if defined(LITERAL) || defined(LONG_LENS)
    Vector eye = splat(camera->eye);
    Ray ray = {eye, scaled(to_camera, -1), -1, -1};
#ifdef LONG_LENS
    ray.origin = vector(at.x * eye.z, at.y * eye.z, 0);
#endif
    Hit hit = nearest(ray, spheres, sphere_count);
    Vector point = along(ray.origin, hit.distance, ray.direction);
#else
    Vector eye = vector(0, 0, 0);
    Ray ray = {eye, scaled(to_camera, -1), -1, -1};
    Hit hit = visible(at, length2, spheres, sphere_count);
    Vector point = scaled(through, hit.distance);
#endif

    Vector color = vector(0, 0, 0);
    reals weight = 1;  // the product of the reflections so far
    ints path = 0;
    for (int depth = 1; ANY(hit.sphere >= 0); depth++) {
        int common = hit.common;
        Surface surface = surface_at(point, spheres + common, materials);
        ray.leaves = hit.sphere;
        ray.all_leave = common;
        FOR_OTHER_HITS(s, mine, hit.sphere, common) {
            surface = pick_surface(mine, surface_at(point, spheres + s, materials), surface);
            ray.all_leave = -1;
        }
#ifdef LITERAL
        ray.all_leave = -1;  // that sphere is tested like any other
#endif
        Vector normal = surface.normal;
        ray.origin = along(point, shadow_bias, normal);
#ifdef FILM_PATHS
        path = HASHED(hit.sphere >= 0, path, hit.sphere + 1);
#endif

        ints reached = 0;  // the lanes that some light reaches
        for (int k = 0; k < light_count; k++) {
            Vector to_light = minus(splat(lights[k].position), ray.origin);
            reals distance2 = dot3(to_light, to_light);
            reals inv_distance = inverse_sqrt(distance2);
            to_light = scaled(to_light, inv_distance);
            reals diffuse = dot3(normal, to_light);
            Ray shadow = {ray.origin, to_light, ray.leaves, ray.all_leave};
            ints lit = (hit.sphere >= 0) & (diffuse >= surface.horizon) &
                       !occluded(shadow, distance2 * inv_distance, encloses + k * sphere_count,
                                 spheres, sphere_count);
#ifdef FILM_PATHS
            path = HASHED(hit.sphere >= 0, path, PICK_INT(lit, 1, 0));
#endif
            if (!ANY(lit)) continue;
            reached |= lit;
            reals specular = highlight(normal, plus(to_light, to_camera), surface.exponent);
            __global const Shade *shade = shades + k * material_count;
            Vector light = blinn_phong(shade + spheres[common].material, diffuse, specular);
            ints lit_sphere = PICK_INT(lit, hit.sphere, -1);
            FOR_OTHER_HITS(s, mine, lit_sphere, common) {
                light =
                    pick3(mine, blinn_phong(shade + spheres[s].material, diffuse, specular), light);
            }
            color = pick3(lit, along(color, weight, light), color);
        }
#ifdef REFLECTION
        weight *= surface.reflection;
        ints alive = reached & (weight > 0);
        if (depth == max_depth || !ANY(alive)) break;
        ray.direction = along(ray.direction, -2 * dot3(ray.direction, normal), normal);
        hit = nearest(ray, spheres, sphere_count);
        hit.sphere = PICK_INT(alive, hit.sphere, -1);
        point = along(ray.origin, hit.distance, ray.direction);
        to_camera = unit(minus(eye, point));
#else
        break;
#endif
    }
    expose(color, path, film + CHANNELS * ((size_t)row * width + column), width - column);
}

// Render: the kernel. A work-item follows the paths of one packet of pixels (paper, section 11.11).
//
// The host defines REFLECTION if a path can go on after its first hit: a material reflects and
// max_depth is more than 1. Everything else about a scene is run-time data.

// Runs its body once for each sphere that a lane of `mask` has hit: `s` is its index, a scalar, so
// that what the body reads of it is one load for all lanes; `mine` are the lanes that hit it.
#define FOR_EACH_HIT(s, mine, mask, hit)                                                          \
    for (ints mine, s##_left = PICK_INT(mask, hit, INT_MAX);                                      \
         s = LEAST(s##_left), mine = s##_left == s, s != INT_MAX;                                 \
         s##_left = PICK_INT(mine, INT_MAX, s##_left))

// film: this band of rows, width * 3 channels each. Global size: (packets of a row, rows).
__kernel void render(__global channel *film, int width, int first_row, int max_depth,
                     real shadow_bias, __global const Camera *camera, int sphere_count,
                     __global const Sphere *spheres, __global const Material *materials,
                     int light_count, __global const Light *lights) {
    int column = get_global_id(0) * LANES, row = get_global_id(1), s;
    if (column >= width) return;

    Ray ray = camera_ray(camera, column, first_row + row);
    Vector color = vector(0, 0, 0);
    reals weight = 1;  // the product of the reflections so far
    reals distance;
    ints hit = nearest(ray, spheres, sphere_count, &distance);
    ints alive = hit >= 0;  // the lanes whose path goes on
    for (int depth = 1; ANY(alive); depth++) {
        Vector point = along(ray.origin, distance, ray.direction);
        Vector normal = point;
        reals horizon = 0, exponent = 0, reflection = 0;
        FOR_EACH_HIT(s, mine, alive, hit) {
            __global const Sphere *sphere = spheres + s;
            __global const Material *material = materials + sphere->material;
            // Not point - centre: that of a giant is far, its anchor is near.
            Vector n = plus(minus(point, splat(sphere->anchor)), splat(sphere->offset));
            normal = pick3(mine, n, normal);
            horizon = PICK(mine, sphere->horizon, horizon);
            exponent = PICK(mine, material->exponent, exponent);
            reflection = PICK(mine, material->reflection, reflection);
        }
        normal = unit(normal);
        Vector to_camera = unit(scaled(point, -1));
        point = along(point, shadow_bias, normal);

        ints reached = 0;  // the lanes that some light reaches
        for (int k = 0; k < light_count; k++) {
            Vector to_light = minus(splat(lights[k].position), point);
            reals light_distance = sqrt(dot3(to_light, to_light));
            to_light = scaled(to_light, 1 / light_distance);
            reals diffuse = dot3(normal, to_light);
            ints lit = alive & (diffuse >= horizon);
            Ray shadow = {point, to_light, hit};
            lit &= !occluded(shadow, light_distance, spheres, sphere_count);
            if (!ANY(lit)) continue;
            reached |= lit;
            reals specular = highlight(normal, unit(plus(to_light, to_camera)), exponent);
            FOR_EACH_HIT(s, mine, lit, hit) {
                __global const Material *material = materials + spheres[s].material;
                Vector i = vector(blinn_phong(material, lights + k, 0, diffuse, specular),
                                  blinn_phong(material, lights + k, 1, diffuse, specular),
                                  blinn_phong(material, lights + k, 2, diffuse, specular));
                color = pick3(mine, along(color, weight, i), color);
            }
        }
#ifdef REFLECTION
        weight *= reflection;
        alive = reached & (weight > 0);
        if (depth == max_depth || !ANY(alive)) break;
        ray.direction = along(ray.direction, -2 * dot3(ray.direction, normal), normal);
        ray.origin = point;
        ray.leaves = hit;
        hit = nearest(ray, spheres, sphere_count, &distance);
        alive &= hit >= 0;
#else
        break;
#endif
    }
    expose(color, film + 3 * ((size_t)row * width + column), width - column);
}

// Render: the kernel.

// A work-item makes the pixels of one packet, or (REFINE) one pixel.
//
// film: this band of `height` rows, width * CHANNELS each; its first pixel is (first_column,
// first_row) of the picture, where a packet begins: first_column is a multiple of ROW. Global size:
// (packets of a row, rounded up to whole work-groups; rows of packets). HASHED: `paths` has rows of
// `width` as well, the first is the picture's row `top`.
// REFINE: of the pixels of this band that `list` has from `from` on, as many as `count`. Global size:
// `count`, rounded up.
// GATHER, REFINE: each pixel gets at most `samples`; where in it they lie `points` says, see
// clrt/renderer/samples.py.
// What a program does not need is NULL or 0.
__kernel void render(__global channel *film, int first_row, int width, int height, int first_column,
                     __global uint *paths, int top, __global const int *list, int from, int count,
                     int samples, __global const real *points, __global const uint2 *table,
                     int max_depth, real shadow_bias, __global const Camera *camera,
                     int sphere_count, __global const Sphere *spheres, int material_count,
                     __global const Material *materials, int light_count,
                     __global const Light *lights, __global const Shade *shades,
                     __global const uchar *encloses, int sky_count, __global const real *skies,
                     __global const real *background, __global const real *sphere_colors,
                     __global const Glass *glass, __global const real *opacities,
                     __global const Medium *around, __global int *lost, __global const int *ids,
                     __global const int *materials_of, __global const Bead *beads,
                     __global const Node *nodes, __global const Leaf *leaves,
                     __global const Shape *shape) {
    Scene scene = {max_depth,      shadow_bias, camera,      sphere_count, spheres,
                   material_count, materials,   light_count, lights,       shades,
                   encloses,       sky_count,   skies,       background,   sphere_colors,
                   glass,          opacities,   around,      lost,         TREE ? ids : 0,
                   materials_of,   beads};
    if (TREE) {
        Tree tree = {nodes, leaves, shape[0], glass};
        scene.tree = tree;
    }
    if (REFINE) {
        int item = get_global_id(0);
        if (item >= count) return;
        int pixel = list[from + item], column = pixel % width, row = pixel / width;
        Sample sample = refined(&scene, first_column + column, first_row + row, samples, points);
        store_row(exposure_of(sample), 0, film + CHANNELS * (size_t)pixel, 1);
        return;
    }
    int column = get_global_id(0) * ROW, row = get_global_id(1) * ROWS;
    if (column >= width) return;
    Sample sample;
    if (GATHER) {
        sample = gathered(&scene, first_column + column, first_row + row, samples, points, table);
    } else {
        Pixels at = pixels_at(camera, first_column + column, first_row + row);
        sample = traced(&scene, at, (Draw){0});
    }
    Exposure exposure = exposure_of(sample);
    film += CHANNELS * ((size_t)row * width + column);
    for (int i = 0; i < ROWS && row + i < height; i++)
        store_row(exposure, i, film + CHANNELS * (size_t)i * width, width - column);
    if (!HASHED) return;
    paths += (size_t)(first_row + row - top) * width + column;
    for (int i = 0; i < ROWS && row + i < height; i++)
        store_paths(sample.path, i, paths + (size_t)i * width, width - column);
}

// Render: the kernel. A work-item makes the pixels of one packet, or (REFINE) one pixel.
//
// film: this band of `height` rows, width * CHANNELS each; its first pixel is (first_column,
// first_row) of the picture, where a packet begins: first_column is a multiple of ROW. Global size:
// (packets of a row, rounded up to whole work-groups; rows of packets). HASHED: `paths` has rows of
// `width` as well, the first is the picture's row `top`.
// REFINE: of the pixels of this band that `list` has from `from` on, as many as `count`. Global size:
// `count`, rounded up.
// GATHER, REFINE: each pixel gets at most `samples`; where in it they lie `points` says, see
// clrt/samples.py.
__kernel void render(__global channel *film, int first_row, int width, int height, int first_column,
#ifdef HASHED
                     __global uint *paths, int top,
#endif
#ifdef REFINE
                     __global const int *list, int from, int count,
#endif
#if defined(GATHER) || defined(REFINE)
                     int samples, __global const real *points,
#endif
#ifdef RANDOM
                     __global const uint2 *table,
#endif
                     int max_depth, real shadow_bias, __global const Camera *camera,
                     int sphere_count, __global const Sphere *spheres, int material_count,
                     __global const Material *materials, int light_count,
                     __global const Light *lights, __global const Shade *shades,
                     __global const uchar *encloses
#ifdef OCCLUSION
                     ,
                     int sky_count, __global const real *skies
#endif
#ifdef BACKGROUND
                     ,
                     __global const real *background
#endif
#ifdef SPHERE_COLORS
                     ,
                     __global const real *sphere_colors
#endif
#ifdef NEST
                     ,
                     __global const Medium *around, __global int *lost
#endif
#ifdef TREE
                     ,
                     __global const int *ids, __global const int *materials_of,
                     __global const Bead *beads, __global const Node *nodes,
                     __global const Leaf *leaves, __global const Shape *shape
#ifdef NEST
                     ,
                     __global const Glass *glass
#endif
#endif
) {
#ifdef REFINE
    int item = get_global_id(0);
    if (item >= count) return;
    int pixel = list[from + item], column = pixel % width, row = pixel / width;
#else
    int column = get_global_id(0) * ROW, row = get_global_id(1) * ROWS;
    if (column >= width) return;
#endif

    Scene scene = {max_depth, shadow_bias, camera, sphere_count, spheres, material_count,
                   materials, light_count, lights, shades,       encloses};
#ifdef OCCLUSION
    scene.sky_count = sky_count;
    scene.skies = skies;
#endif
#ifdef BACKGROUND
    scene.background = background;
#endif
#ifdef SPHERE_COLORS
    scene.sphere_colors = sphere_colors;
#endif
#ifdef NEST
    scene.around = around;
    scene.lost = lost;
#endif
#ifdef TREE
    scene.ids = ids;
    scene.materials_of = materials_of;
    scene.beads = beads;
    scene.nodes = nodes;
    scene.leaves = leaves;
    scene.shape = shape;
#ifdef NEST
    scene.glass = glass;
#endif
#endif
#if defined(RANDOM)
    Sample sample = gathered(scene, first_column + column, first_row + row, samples, points, table);
#elif defined(GATHER) || defined(REFINE)
    Sample sample = gathered(scene, first_column + column, first_row + row, samples, points);
#else
    Sample sample = traced(scene, pixels_at(camera, first_column + column, first_row + row));
#endif
#ifdef REFINE
    store_row(exposure_of(sample), 0, film + CHANNELS * (size_t)pixel, 1);
#else
    Exposure exposure = exposure_of(sample);
    film += CHANNELS * ((size_t)row * width + column);
    for (int i = 0; i < ROWS && row + i < height; i++)
        store_row(exposure, i, film + CHANNELS * (size_t)i * width, width - column);
#ifdef HASHED
    paths += (size_t)(first_row + row - top) * width + column;
    for (int i = 0; i < ROWS && row + i < height; i++)
        store_paths(sample.path, i, paths + (size_t)i * width, width - column);
#endif
#endif
}

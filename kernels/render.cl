// Render: the kernel.

// Where a work-item stores pixels: the film's and (HASHED) the paths' rows of `width`, see render().
typedef struct {
    __global channel *film;
    __global uint *paths;
    int width, height;
} Target;

// Stores a packet's pixels from there on, as many as the film has.
static void store(const Target *target, Sample sample, int column, int row) {
    Exposure exposure = exposure_of(sample);
    size_t place = (size_t)row * target->width + column;
    __global channel *film = target->film + CHANNELS * place;
    for (int i = 0; i < ROWS && row + i < target->height; i++)
        store_row(exposure, i, film + CHANNELS * (size_t)i * target->width, target->width - column);
    if (!HASHED) return;
    __global uint *paths = target->paths + place;
    for (int i = 0; i < ROWS && row + i < target->height; i++)
        store_paths(sample.path, i, paths + (size_t)i * target->width, target->width - column);
}

// TILES: what a packet of a tile brings, whose first hits are there.
static Sample sample_of_tile(const Scene *scene, const Tile *tile, int block) {
    Hit hit = hit_of_tile(tile, block);
    return traced(scene, pixels_of_tile(scene, tile, block), (Draw){0}, &hit);
}

// GATHER and TILES: fills a tile for each of a pixel's samples; their means as gathered() makes them.
static void gather_tile(const Scene *scene, Tile *tile, int samples, __global const real *points,
                        Sample *means) {
    ints all = -1;
    for (int block = 0; block < BLOCKS; block++) means[block] = (Sample){{0}};
    for (int i = 0; i < samples; i++) {
        tile->right = points[2 * i], tile->up = points[2 * i + 1];
        fill_tile(scene, tile);
        for (int block = 0; block < BLOCKS; block++) {
            if (!is_wanted(tile, block)) continue;
            Sample sample = sample_of_tile(scene, tile, block), *mean = means + block;
            Sum sum = {mean->color, mean->alpha};
            if (FILM_GUIDES) sum.guide[0] = mean->guide[0];
            sum = with(sum, sample, all);
            *mean = (Sample){sum.color, sum.alpha, mean->path * 16777619 + sample.path};
            if (FILM_GUIDES) mean->guide[0] = sum.guide[0];
        }
    }
    for (int block = 0; block < BLOCKS; block++) {
        Sample *mean = means + block;
        Vector sum = mean->color;
        mean->color = vector(sum.x / samples, sum.y / samples, sum.z / samples);
        mean->alpha /= samples;
        if (FILM_GUIDES) mean->guide[0] = more_of((Guide){{0}}, mean->guide[0], 1 / (reals)samples);
    }
}

// TILES: makes the pixels of a tile.
static void render_tile(const Scene *scene, const Target *target, int column, int row,
                        int first_column, int first_row, int samples, __global const real *points) {
    Tile tile = {first_column + column, first_row + row, first_column + target->width,
                 first_row + target->height};
    Sample means[GATHER ? BLOCKS : 1];
    if (GATHER) {
        gather_tile(scene, &tile, samples, points, means);
    } else {
        fill_tile(scene, &tile);
    }
    for (int block = 0; block < BLOCKS; block++) {
        if (!is_wanted(&tile, block)) continue;
        Sample sample = GATHER ? means[block] : sample_of_tile(scene, &tile, block);
        store(target, sample, column + block % ACROSS * ROW, row + block / ACROSS * ROWS);
    }
}

// REFINE: makes a pixel of a film, as edges() lists it.
static void render_one(const Scene *scene, __global channel *film, int pixel, int width,
                       int first_column, int first_row, int samples, __global const real *points) {
    int least = pixel < 0 ? LEAST_OF_SMALL : 1;
    if (pixel < 0) pixel = ~pixel;
    int column = pixel % width, row = pixel / width;
    Sample sample = refined(scene, first_column + column, first_row + row, least, samples, points);
    store_row(exposure_of(sample), 0, film + CHANNELS * (size_t)pixel, 1);
}

// Makes the pixels of a packet. GATHER: of so many samples.
static void render_packet(const Scene *scene, const Target *target, int column, int row,
                          int first_column, int first_row, int samples, __global const real *points,
                          __global const uint2 *table) {
    Sample sample;
    if (GATHER) {
        sample = gathered(scene, first_column + column, first_row + row, samples, points, table);
    } else {
        Pixels at = pixels_at(scene->camera, first_column + column, first_row + row);
        sample = traced(scene, at, (Draw){0}, 0);
    }
    store(target, sample, column, row);
}

// A work-item makes the pixels of one packet, or (TILES) of one tile, or (REFINE) one pixel.
//
// film: this band of `height` rows, width * CHANNELS each; its first pixel is (first_column,
// first_row) of the picture, where a packet begins: first_column is a multiple of ROW. Global size:
// (packets of a row, rounded up to whole work-groups; rows of packets), or of tiles. HASHED: `paths`
// has rows of
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
                     __global const Glass *glass, __global const Medium *around, __global int *lost,
                     __global const int *ids, __global const int *materials_of,
                     __global const Bead *beads, __global const Node *nodes,
                     __global const Leaf *leaves, __global const Shape *shape, int first_capsule,
                     __global const Capsule *capsules, __global const Node *capsule_nodes,
                     __global const CapsuleLeaf *capsule_leaves,
                     __global const Shape *capsule_shape, int first_face,
                     __global const Face *faces, __global const FaceLook *looks,
                     __global const int *corners, __global const real *vertex_normals,
                     __global const real *vertex_colors, __global const Node *face_nodes,
                     __global const FaceLeaf *face_leaves, __global const Shape *face_shape) {
    Scene scene = {max_depth,      shadow_bias, camera,      sphere_count,   spheres,
                   material_count, materials,   light_count, lights,         shades,
                   encloses,       sky_count,   skies,       background,     sphere_colors,
                   glass,          around,      lost,        TREE ? ids : 0, materials_of,
                   beads};
    if (TREE) {
        Tree tree = {nodes, leaves, shape[0], glass};
        scene.tree = tree;
    }
    if (CAPSULES) {
        CapsuleList list = {
            first_capsule, capsules, {capsule_nodes, capsule_leaves, capsule_shape[0], glass}};
        scene.capsules[0] = list;
    }
    if (FACES) {
        Tree tree = {face_nodes, face_leaves, face_shape[0], glass};
        FaceList list = {first_face, faces, looks, corners, vertex_normals, vertex_colors, tree};
        scene.faces[0] = list;
    }
    if (REFINE) {
        int item = get_global_id(0);
        if (item < count)
            render_one(&scene, film, list[from + item], width, first_column, first_row, samples,
                       points);
        return;
    }
    Target target = {film, HASHED ? paths + (size_t)(first_row - top) * width : 0, width, height};
    if (TILES) {
        int column = get_global_id(0) * SIDE, row = get_global_id(1) * SIDE;
        render_tile(&scene, &target, column, row, first_column, first_row, samples, points);
        return;
    }
    int column = get_global_id(0) * ROW, row = get_global_id(1) * ROWS;
    if (column >= width) return;
    render_packet(&scene, &target, column, row, first_column, first_row, samples, points, table);
}

// Raster: what a tile's rays meet first, drawn leaf by leaf as the tile's beam meets them.
//
// It is a z-buffer inside the tree. A leaf that the beam meets is rasterised, packet by packet, and
// the farthest hit of all pixels ends the beam. Spheres and faces are tested by the packets' formulas. So
// ids and distances are theirs to the bit: rectangles and depths only pass over tests that would fail.

// 16 things of a leaf: the packets of the tile in which each can show, and from where on.
typedef struct {
    int16 left, right, top, bottom;
    wides nearest;
} Rects;

// TILES or REFINE: from where to where along an axis of the screen spheres can show, in slopes (ORTHOGRAPHIC: in
// lengths). x: their middles along that axis; den: depth^2 - radius^2, off by 16 x 3 u of itself.
static void silhouettes(wides x, wides depth, wides radius, wides den, wides *low, wides *high) {
    if (ORTHOGRAPHIC) {
        *low = x - radius;
        *high = x + radius;
        return;
    }
    wides inverse = 1 / den, middle = x * depth, reach = radius * sqrt(x * x + den);
    wides wider = reach + ((x < 0 ? -middle : middle) + reach) * (64 * UNIT_ROUNDOFF);
    *low = (middle - wider) * inverse;
    *high = (middle + wider) * inverse;
}

// TILES: the packets from the first pixel at or after `low` to the last at or before `high`, of `size`
// pixels each; whether there is a pixel. known: else it is all of them.
static wide_ints pixels_between(wides low, wides high, wide_ints known, int size, int16 *first,
                                int16 *last) {
    wide_ints in = !known | ((high >= 0) & (low <= SIDE - 1));
    low = (known & (low > 0)) ? low + REAL(0.999) : (wides)(0);
    high = (known & (high < SIDE - 1)) ? high : (wides)(SIDE - 1);
    *first = convert_int16(in ? low : (wides)(0));
    *last = convert_int16(in ? high : (wides)(0));
    in &= (wide_ints)(TO_WIDE_INTS(*first) <= TO_WIDE_INTS(*last));
    *first /= size;
    *last /= size;
    return in;
}

// Where 16 spheres can show on the screen, and from what distance on along a ray.
typedef struct {
    wides left, right, bottom, top;
    wides nearest;
    wide_ints known;  // else it is anywhere
} Silhouettes;

// TILES or REFINE: those of spheres at x, y and depth along the camera's axes, so far `away`.
//
// QUADRATIC accepts rays up to 4 u (|o - C| + r) outside a sphere, a centre along the camera's axes is off
// by up to 8 u |C|, and so is a ray: radii are widened by 32 u (|C| + r). That covers the rounding of a
// pixel's place as well, which is 4 u of what it is from the middle.
static Silhouettes silhouettes_of(__global const Camera *camera, wides x, wides y, wides depth,
                                  wides away, wides radius) {
    wides wider = radius + (away + radius) * (32 * UNIT_ROUNDOFF);
    Silhouettes of;
    // Rays start in the camera, or on a plane.
    of.nearest = (ORTHOGRAPHIC || LONG_LENS ? depth : away) - wider;
    if (LONG_LENS) depth += TREE ? dot_real(camera->eye, camera->back) : camera->eye[2];
    wides den = depth * depth - wider * wider;
    silhouettes(x, depth, wider, den, &of.left, &of.right);
    silhouettes(y, depth, wider, den, &of.bottom, &of.top);
    // Not of one that comes near the camera's plane.
    of.known = -1;
    if (!ORTHOGRAPHIC) of.known = (depth > 0) & (den > depth * depth * REAL(0.0625));
    return of;
}

// TREE: those of a leaf.
static Silhouettes silhouettes_of_leaf(__global const Camera *camera, __global const Leaf *leaf) {
    __global const wides *c = (__global const wides *)leaf->center;
    wides x = c[0] * camera->right[0] + (c[1] * camera->right[1] + c[2] * camera->right[2]);
    wides y = c[0] * camera->up[0] + (c[1] * camera->up[1] + c[2] * camera->up[2]);
    wides depth = -(c[0] * camera->back[0] + (c[1] * camera->back[1] + c[2] * camera->back[2]));
    wides away = sqrt(c[0] * c[0] + (c[1] * c[1] + c[2] * c[2]));
    return silhouettes_of(camera, x, y, depth, away, *(__global const wides *)leaf->radius);
}

// TILES: where the spheres of a leaf can show in the tile; those that can, as bits.
static uint rects_of_spheres(const Scene *scene, const Tile *tile, __global const Leaf *leaf,
                             Rects *to) {
    __global const Camera *camera = scene->camera;
    Silhouettes of = silhouettes_of_leaf(camera, leaf);
    to->nearest = of.nearest;
    real columns = REAL(0.5) / camera->step[0], rows = REAL(0.5) / camera->step[1];
    real x0 = REAL(0.5) * tile->left, y0 = REAL(0.5) * tile->top;
    wide_ints in = (*(__global const wides *)leaf->radius > 0) & (of.nearest <= tile->most);
    in &= pixels_between(of.left * columns - x0, of.right * columns - x0, of.known, ROW, &to->left,
                         &to->right);
    in &= pixels_between(y0 - of.top * rows, y0 - of.bottom * rows, of.known, ROWS, &to->top,
                         &to->bottom);
    return wide_bits(in);
}

// TILES: tests sphere k of a leaf in the packets in which it can show. Returns whether the farthest of
// all hits may be nearer now.
static bool draw_sphere(Tile *tile, __global const Leaf *leaf, const Rects *rects, int k) {
    int left = ((const int *)&rects->left)[k], right = ((const int *)&rects->right)[k];
    int top = ((const int *)&rects->top)[k], bottom = ((const int *)&rects->bottom)[k];
    real nearest = ((const real *)&rects->nearest)[k];
    const real *farthest = (const real *)tile->farthest;
    bool nearer = false;
    for (int j = top; j <= bottom; j++)
        for (int block = j * ACROSS + left; block <= j * ACROSS + right; block++) {
            if (nearest > farthest[block]) continue;
            Ray ray = ray_of_tile(tile, block);
            PACKET_QUADRATIC(ray, leaf, k)
            ints met = (delta > 0) & (b < 0) & (c > 0);
            if (!ANY(met)) continue;
            nearer |= farthest[block] >= tile->most;
            set_hit(tile, block, closer_of(hit_of_tile(tile, block), met, FIRST_ROOT, leaf->id[k]));
        }
    return nearer;
}

// TILES: tests the spheres of a leaf.
static void rasterise_spheres(const Scene *scene, Tile *tile, __global const Leaf *leaf) {
    Rects rects;
    bool nearer = false;
    for (uint bits = rects_of_spheres(scene, tile, leaf, &rects); bits; bits &= bits - 1)
        nearer |= draw_sphere(tile, leaf, &rects, LOWEST_BIT(bits));
    if (nearer) find_most(tile);
}

// What the tests of a tile's faces need of its rays, which all have one main axis.
typedef struct {
    int kz;
    Vector slope[ORTHOGRAPHIC ? 1 : BLOCKS];  // sx, sy, sz of Shears
} Slopes;

// TILES and FACES: those of a tile; whether all of its rays have the beam's axis for their main one.
static bool slopes_of(const Tile *tile, Slopes *slopes) {
    slopes->kz = tile->beam.m;
    for (int block = 0; block < (ORTHOGRAPHIC ? 1 : BLOCKS); block++) {
        Ray ray = ray_of_tile(tile, block);
        if (!has_one_shear(&tile->beam, ray.direction, (ints)(-1))) return false;
        Shears shears = shears_of(ray, slopes->kz);
        slopes->slope[block] = vector(shears.sx, shears.sy, shears.sz);
    }
    return true;
}

// TILES and FACES: the shears of a packet's rays. From one point rays start at 0.
static Shears shears_of_tile(const Tile *tile, const Slopes *slopes, int block) {
    Vector slope = slopes->slope[ORTHOGRAPHIC ? 0 : block], o = vector(0, 0, 0);
    if (ORTHOGRAPHIC || LONG_LENS) o = tile->origin[block];
    int kx = NEXT_AXIS(slopes->kz), ky = LAST_AXIS(slopes->kz);
    Shears shears = {0, 1, 2, slope.x, slope.y, slope.z};
    shears.ox = axis_of(o, kx), shears.oy = axis_of(o, ky), shears.oz = axis_of(o, slopes->kz);
    return shears;
}

// The least and the greatest of three.
#define LEAST_OF(a, b, c) ((a) < (b) ? ((a) < (c) ? (a) : (c)) : (b) < (c) ? (b) : (c))
#define MOST_OF(a, b, c) ((a) > (b) ? ((a) > (c) ? (a) : (c)) : (b) > (c) ? (b) : (c))

// TILES and FACES: widens the range of three slopes, or (ORTHOGRAPHIC) lengths, by what `off` corners are off.
static void range_of(const wides *x, const wides *depth, wides off, wides nearer, wides *low,
                     wides *high) {
    wides a = x[0], b = x[1], c = x[2], slack = off;
    if (!ORTHOGRAPHIC) a /= depth[0], b /= depth[1], c /= depth[2];
    *low = LEAST_OF(a, b, c);
    *high = MOST_OF(a, b, c);
    if (!ORTHOGRAPHIC) {
        wides larger = -*low > *high ? -*low : *high;
        slack = (1 + larger) * off / nearer;
    }
    *low -= slack;
    *high += slack;
}

// TILES and FACES: where the faces of a leaf can show in the tile; those that can, as bits.
//
// A ray that a face's test accepts passes it by 2 u max |f| at most (face.cl), where |f| is at most 2 |C| for
// a corner C: rays start before what they meet, and beside the axis no farther than it is. A corner along the
// camera's axes is off by 8 u |C|, and so is a ray, at that distance, with the rounding of its pixel's place. So a
// corner counts as a cube of 64 u |C|, which is less than 128 u times its largest coordinate. The slopes of what is
// within three cubes ahead of the camera are those of their corners: (x +- e) / (depth +- e) is within
// e (1 + |slope|) / (depth - e) of x / depth. A hit is a mean of the corners, off by as little, and at least as far
// along its ray as the least depth by the least length of such a ray.
static uint rects_of_faces(const Scene *scene, const Tile *tile, __global const FaceLeaf *leaf,
                           Rects *to) {
    __global const Camera *camera = scene->camera;
    wides x[3], y[3], depth[3], largest = 0;
    for (int c = 0; c < 3; c++) {
        __global const wides *v = (__global const wides *)leaf->corner[c];
        x[c] = v[0] * camera->right[0] + (v[1] * camera->right[1] + v[2] * camera->right[2]);
        y[c] = v[0] * camera->up[0] + (v[1] * camera->up[1] + v[2] * camera->up[2]);
        depth[c] = -(v[0] * camera->back[0] + (v[1] * camera->back[1] + v[2] * camera->back[2]));
        wides a = x[c] < 0 ? -x[c] : x[c], b = y[c] < 0 ? -y[c] : y[c];
        wides d = depth[c] < 0 ? -depth[c] : depth[c], most = MOST_OF(a, b, d);
        largest = most > largest ? most : largest;
    }
    wides off = 128 * UNIT_ROUNDOFF * largest, left, right, bottom, top;
    wides before = LEAST_OF(depth[0], depth[1], depth[2]) - off, nearer = before;
    if (LONG_LENS) {
        real ahead = dot_real(camera->eye, camera->back);
        FOR_EACH_AXIS(depth[a] += ahead)
        nearer += ahead;
    }
    range_of(x, depth, off, nearer, &left, &right);
    range_of(y, depth, off, nearer, &bottom, &top);
    // Not of one that comes near the camera's plane, or before where rays start.
    wide_ints known = before > 0;
    if (!ORTHOGRAPHIC) known &= nearer > largest * REAL(0.0625);
    wides length = 1;
    if (!ORTHOGRAPHIC) {
        wides across = MOST_OF(left, -right, (wides)(0)), above = MOST_OF(bottom, -top, (wides)(0));
        length = sqrt(1 + (across * across + above * above));
    }
    to->nearest = known ? before * length - off : (wides)(-INFINITY);
    real columns = REAL(0.5) / camera->step[0], rows = REAL(0.5) / camera->step[1];
    real x0 = REAL(0.5) * tile->left, y0 = REAL(0.5) * tile->top;
    wide_ints in = (x[0] == x[0]) & (to->nearest <= tile->most);
    in &= pixels_between(left * columns - x0, right * columns - x0, known, ROW, &to->left,
                         &to->right);
    in &= pixels_between(y0 - top * rows, y0 - bottom * rows, known, ROWS, &to->top, &to->bottom);
    return wide_bits(in);
}

// TILES and FACES: tests face k of a leaf in the packets in which it can show, as draw_sphere() does.
#define TILE_CORNER(c, k) corner[c][k]
static bool draw_face(Tile *tile, const Slopes *slopes, __global const FaceLeaf *leaf,
                      const Rects *rects, int k) {
    int left = ((const int *)&rects->left)[k], right = ((const int *)&rects->right)[k];
    int top = ((const int *)&rects->top)[k], bottom = ((const int *)&rects->bottom)[k];
    real nearest = ((const real *)&rects->nearest)[k];
    const real *farthest = (const real *)tile->farthest;
    int kx = NEXT_AXIS(slopes->kz), ky = LAST_AXIS(slopes->kz), id = leaf->id[k];
    bool nearer = false, closed = leaf->closed[k];
    real corner[3][3];
    FOR_EACH_AXIS(corner[a][0] = leaf->corner[a][kx][k]; corner[a][1] = leaf->corner[a][ky][k];
                  corner[a][2] = leaf->corner[a][slopes->kz][k])
    for (int j = top; j <= bottom; j++)
        for (int block = j * ACROSS + left; block <= j * ACROSS + right; block++) {
            if (nearest > farthest[block]) continue;
            Shears shears = shears_of_tile(tile, slopes, block);
            FACE_TEST(reals, ints, shears, TILE_CORNER)
            if (closed) met &= det * shears.sz > 0;
            if (!ANY(met)) continue;
            reals distance = FACE_DISTANCE(shears);
            met &= distance > 0;
            nearer |= farthest[block] >= tile->most;
            set_hit(tile, block, closer_of(hit_of_tile(tile, block), met, distance, id));
        }
    return nearer;
}

// TILES and FACES: tests the faces of a leaf.
static void rasterise_faces(const Scene *scene, Tile *tile, const Slopes *slopes,
                            __global const FaceLeaf *leaf) {
    Rects rects;
    bool nearer = false;
    for (uint bits = rects_of_faces(scene, tile, leaf, &rects); bits; bits &= bits - 1)
        nearer |= draw_face(tile, slopes, leaf, &rects, LOWEST_BIT(bits));
    if (nearer) find_most(tile);
}

// TILES: how far along the beam's axis what is seen may begin.
static real end_of_tile(const Tile *tile) { return tile->most * tile->forward + tile->begin; }

// TILES: what the tree of a kind has before the hits of a tile. slopes: FACES, of their tree.
static void walk_tile(const Scene *scene, const Tree *tree, int kind, Tile *tile,
                      const Slopes *slopes) {
    int stack[STACK], top = 0, e = 0;
    real starts[STACK], end = end_of_tile(tile);
    while (e >= 0) {
        if (e < tree->shape.node_count) {
            wides begins;
            uint bits = boxes_in_beam(&tile->beam, tree->nodes + e, end, &begins);
            if (bits) {
                e = descend(&tree->shape, e, bits, begins, stack, starts, &top);
                continue;
            }
        } else {
            __global const void *leaf = leaf_of(tree, kind, e);
            if (FACES && kind == OF_FACES) {
                rasterise_faces(scene, tile, slopes, leaf);
            } else {
                rasterise_spheres(scene, tile, leaf);
            }
            end = end_of_tile(tile);
        }
        e = next_of(stack, starts, &top, end);
    }
}

// TILES: as walk_tile(), packet by packet.
static void walk_packets(const Tree *tree, int kind, Tile *tile) {
    bool common = !ORTHOGRAPHIC && !LONG_LENS;
    for (int block = 0; block < BLOCKS; block++)
        set_hit(tile, block,
                nearest_in_tree(tree, kind, hit_of_tile(tile, block), ray_of_tile(tile, block),
                                (ints)(-1), common));
}

// TILES: whether a tile's beam pays in a tree.
static bool pays(const Tile *tile, const Tree *tree) {
    return tile->beam.width < WIDE_TILE * tree->shape.wide;
}

// TILES: fills a tile, whose place is there: what its camera rays meet first.
static void fill_tile(const Scene *scene, Tile *tile) {
    begin_tile(scene, tile);
    bool aimed = aim_tile(scene, tile);
    if (aimed && pays(tile, &scene->tree)) {
        walk_tile(scene, &scene->tree, OF_SPHERES, tile, 0);
    } else {
        walk_packets(&scene->tree, OF_SPHERES, tile);
    }
    if (FACES) {
        const Tree *faces = &scene->faces->tree;
        Slopes slopes;
        if (aimed && pays(tile, faces) && slopes_of(tile, &slopes)) {
            find_most(tile);
            walk_tile(scene, faces, OF_FACES, tile, &slopes);
        } else {
            walk_packets(faces, OF_FACES, tile);
        }
    }
}

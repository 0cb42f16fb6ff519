// Tile: what the camera rays of SIDE x SIDE pixels meet first, by one beam through the tree.
//
// It is a z-buffer inside the tree. A leaf that the beam meets is rasterised, packet by packet, and
// the farthest hit of all pixels ends the beam. A sphere is tested by the packets' formula. So ids and
// distances are theirs to the bit: rectangles and depths only pass over tests that would fail.

#define SIDE 32
#define ACROSS (SIDE / ROW)  // packets of a row of a tile
#define DOWN (SIDE / ROWS)   // and rows of them
#define BLOCKS (ACROSS * DOWN)
// A tile's beam is given up where it is so many times as wide as a packet's may be: 1.5 spheres a
// pixel. Small pictures of many spheres are quicker packet by packet (benchmarks/NOTES.md).
#define WIDE_TILE 64

// The rays of a tile's packets, and what they have met.
typedef struct {
    int column, row, end_column, end_row;  // in the picture; packets beyond are not wanted
    real right, up;  // GATHER: parts of half a pixel, by which its rays go beside pixels' middles
    Vector origin[ORTHOGRAPHIC || LONG_LENS ? BLOCKS : 1];
    Vector direction[ORTHOGRAPHIC ? 1 : BLOCKS];
    reals distance[BLOCKS];
    ints id[BLOCKS];
    wides farthest[BLOCKS / WIDE];  // the largest distance of each packet
    real most;                      // and of all
    real left, top;  // the first ray in half pixels from the screen's middle, see pixels_at()
    Beam beam;
    real begin;    // along it, how far ahead rays start at most, with some slack
    real forward;  // and how far they come in a distance of 1, at most
} Tile;

// TILES: the rays of a packet.
static Ray ray_of_tile(const Tile *tile, int block) {
    Ray ray = {tile->origin[ORTHOGRAPHIC || LONG_LENS ? block : 0],
               tile->direction[ORTHOGRAPHIC ? 0 : block]};
    ray.leaves = ray.all_leave = -1;
    if (OPACITY) ray.passed[0] = nothing_passed();
    return ray;
}

// TILES: a packet's hits so far, and new ones.
static Hit hit_of_tile(const Tile *tile, int block) {
    Hit hit = {tile->id[block], tile->distance[block], 0};
    return hit;
}
static void set_hit(Tile *tile, int block, Hit hit) {
    tile->id[block] = hit.id;
    tile->distance[block] = hit.distance;
    ((real *)tile->farthest)[block] = MOST((ints)(-1), hit.distance);
}

// TILES: finds the farthest hit anew.
static void find_most(Tile *tile) {
    wides most = tile->farthest[0];
    for (int i = 1; i < BLOCKS / WIDE; i++)
        most = tile->farthest[i] > most ? tile->farthest[i] : most;
    tile->most = JOIN(most, WIDE)(most);
}

// 16 spheres of a leaf: the packets of the tile in which each can show, and from where on.
typedef struct {
    int16 left, right, top, bottom;
    wides nearest;
} Rects;

// TILES: from where to where along an axis of the screen spheres can show, in slopes (ORTHOGRAPHIC: in
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

// TILES: where the spheres of a leaf can show in the tile; those that can, as bits.
//
// QUADRATIC accepts rays up to 4 u (|o - C| + r) outside a sphere, a centre along the camera's axes is off
// by up to 8 u |C|, and so is a ray: radii are widened by 32 u (|C| + r). That covers the rounding of a
// pixel's place as well, which is 4 u of what it is from the middle.
static uint rects_of(const Scene *scene, const Tile *tile, __global const Leaf *leaf, Rects *to) {
    __global const Camera *camera = scene->camera;
    __global const wides *c = (__global const wides *)leaf->center;
    wides radius = *(__global const wides *)leaf->radius;
    wides x = c[0] * camera->right[0] + (c[1] * camera->right[1] + c[2] * camera->right[2]);
    wides y = c[0] * camera->up[0] + (c[1] * camera->up[1] + c[2] * camera->up[2]);
    wides depth = -(c[0] * camera->back[0] + (c[1] * camera->back[1] + c[2] * camera->back[2]));
    wides away = sqrt(c[0] * c[0] + (c[1] * c[1] + c[2] * c[2]));
    wides wider = radius + (away + radius) * (32 * UNIT_ROUNDOFF);
    // Rays start in the camera, or on a plane.
    to->nearest = (ORTHOGRAPHIC || LONG_LENS ? depth : away) - wider;
    if (LONG_LENS) depth += dot_real(camera->eye, camera->back);
    wides den = depth * depth - wider * wider, left, right, bottom, top;
    silhouettes(x, depth, wider, den, &left, &right);
    silhouettes(y, depth, wider, den, &bottom, &top);
    // Not of one that comes near the camera's plane.
    wide_ints known = -1;
    if (!ORTHOGRAPHIC) known = (depth > 0) & (den > depth * depth * REAL(0.0625));
    real columns = REAL(0.5) / camera->step[0], rows = REAL(0.5) / camera->step[1];
    real x0 = REAL(0.5) * tile->left, y0 = REAL(0.5) * tile->top;
    wide_ints in = (radius > 0) & (to->nearest <= tile->most);
    in &= pixels_between(left * columns - x0, right * columns - x0, known, ROW, &to->left,
                         &to->right);
    in &= pixels_between(y0 - top * rows, y0 - bottom * rows, known, ROWS, &to->top, &to->bottom);
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
static void rasterise(const Scene *scene, Tile *tile, __global const Leaf *leaf) {
    Rects rects;
    bool nearer = false;
    for (uint bits = rects_of(scene, tile, leaf, &rects); bits; bits &= bits - 1)
        nearer |= draw_sphere(tile, leaf, &rects, LOWEST_BIT(bits));
    if (nearer) find_most(tile);
}

// The rays through the corners of a tile: where they start, and to where, not of unit length.
typedef struct {
    real o[4][3], d[4][3];
} Corners;

// TILES: those of a tile. largest: the largest coordinate of where rays start, at least 1.
static Corners corners_of(const Scene *scene, const Tile *tile, real *largest) {
    __global const Camera *camera = scene->camera;
    real ahead = LONG_LENS ? dot_real(camera->eye, camera->back) : 1;
    Corners corners;
    *largest = 1;
    for (int i = 0; i < 4; i++) {
        real x = (tile->left + i % 2 * (2 * (SIDE - 1))) * camera->step[0];
        real y = (tile->top - i / 2 * (2 * (SIDE - 1))) * camera->step[1];
        for (int a = 0; a < 3; a++) {
            real across = x * camera->right[a] + y * camera->up[a];
            corners.o[i][a] = ORTHOGRAPHIC || LONG_LENS ? ahead * across : 0;
            corners.d[i][a] = (ORTHOGRAPHIC ? 0 : across) - camera->back[a];
            *largest = fmax(*largest, fabs(corners.o[i][a]));
        }
    }
    return corners;
}

// TILES: the beam's planes of axis k. Slopes are least and greatest in corners, and so is where planes
// of one slope lie. The corners' are rounded by up to 12 u (1 + |slope|), and so are the rays' own.
static void bound_beam(Beam *beam, int k, const Corners *corners, real slack) {
    int a = beam->a[k], m = beam->m;
    real low = INFINITY, high = -INFINITY, lc = INFINITY, hc = -INFINITY;
    for (int i = 0; i < 4; i++) {
        real slope = corners->d[i][a] / corners->d[i][m];
        low = fmin(low, slope);
        high = fmax(high, slope);
    }
    beam->width *= high - low;
    low -= 32 * UNIT_ROUNDOFF * (1 + fabs(low));
    high += 32 * UNIT_ROUNDOFF * (1 + fabs(high));
    // Backwards along m the order turns.
    real lq = beam->sign > 0 ? low : high, hq = beam->sign > 0 ? high : low;
    for (int i = 0; i < 4; i++) {
        lc = fmin(lc, corners->o[i][a] - lq * corners->o[i][m]);
        hc = fmax(hc, corners->o[i][a] - hq * corners->o[i][m]);
    }
    beam->low_q[k] = lq;
    beam->high_q[k] = hq;
    beam->low_c[k] = lc - slack * (1 + fabs(lq));
    beam->high_c[k] = hc + slack * (1 + fabs(hq));
}

// TILES: makes the beam around the rays of a tile; whether they have an axis in common, and it pays.
static bool aim_tile(const Scene *scene, Tile *tile) {
    real largest;
    Corners corners = corners_of(scene, tile, &largest);
    Beam *beam = &tile->beam;
    real x = fabs(corners.d[0][0]), y = fabs(corners.d[0][1]), z = fabs(corners.d[0][2]);
    int m = beam->m = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
    beam->sign = corners.d[0][m] > 0 ? 1 : -1;
    beam->a[0] = m == 0 ? 1 : 0;
    beam->a[1] = m == 2 ? 1 : 2;
    beam->width = 1;
    real slack = SLACK * largest, start = INFINITY;
    tile->begin = -INFINITY;
    for (int i = 0; i < 4; i++) {
        const real *d = corners.d[i];
        real forward = d[m] * beam->sign, at = corners.o[i][m] * beam->sign;
        if (!(forward > REAL(0.25) * sqrt(d[0] * d[0] + (d[1] * d[1] + d[2] * d[2])))) return false;
        start = fmin(start, at);
        tile->begin = fmax(tile->begin, at + 2 * slack);
    }
    beam->behind = start - slack;
    real square = 1;
    for (int k = 0; k < 2; k++) {
        bound_beam(beam, k, &corners, slack);
        real low = fmin(beam->low_q[k], beam->high_q[k]);
        real high = fmax(beam->low_q[k], beam->high_q[k]);
        real least = fmax(fmax(low, -high), (real)0);
        square += least * least;
    }
    tile->forward = (1 + 8 * UNIT_ROUNDOFF) / sqrt(square);
    if (ORTHOGRAPHIC || LONG_LENS) {
        // As many spheres are in a cone of that width as in a bar of this one, through a ball of radius 1.
        real ahead = LONG_LENS ? dot_real(scene->camera->eye, scene->camera->back) : 1;
        real side = 2 * SIDE * ahead;
        beam->width = 6 * (side * scene->camera->step[0]) * (side * scene->camera->step[1]);
    }
    return beam->width < WIDE_TILE * scene->tree.shape.wide;
}

// TILES: the pixels of a packet.
static Pixels pixels_of_tile(const Scene *scene, const Tile *tile, int block) {
    int x = tile->column + block % ACROSS * ROW, y = tile->row + block / ACROSS * ROWS;
    Pixels at = pixels_at(scene->camera, x, y);
    if (GATHER) at = moved(at, scene->camera, tile->right, tile->up);
    return at;
}

// TILES: whether a packet is wanted.
static bool is_wanted(const Tile *tile, int block) {
    return tile->column + block % ACROSS * ROW < tile->end_column &&
           tile->row + block / ACROSS * ROWS < tile->end_row;
}

// TILES: the rays of the tile's packets, and what they meet in the list beside the tree.
static void begin_tile(const Scene *scene, Tile *tile) {
    tile->left = 2 * tile->column - scene->camera->last[0];
    tile->top = scene->camera->last[1] - 2 * tile->row;
    if (GATHER) tile->left += tile->right, tile->top += tile->up;
    for (int block = 0; block < BLOCKS; block++) {
        Path path = {{{0}}};
        look(scene, &path, pixels_of_tile(scene, tile, block), (Draw){0});
        if (ORTHOGRAPHIC || LONG_LENS || block == 0) tile->origin[block] = path.ray.origin;
        if (!ORTHOGRAPHIC || block == 0) tile->direction[block] = path.ray.direction;
        Hit hit = first_listed(scene, path.ray, (ints)(-1), ORTHOGRAPHIC);
        if (!is_wanted(tile, block)) hit.distance = -INFINITY;
        set_hit(tile, block, hit);
    }
    find_most(tile);
}

// TILES: how far along the beam's axis what is seen may begin.
static real end_of_tile(const Tile *tile) { return tile->most * tile->forward + tile->begin; }

// TILES: what the tree has before the hits of a tile.
static void walk_tile(const Scene *scene, Tile *tile) {
    const Tree *tree = &scene->tree;
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
            rasterise(scene, tile, leaf_of(tree, OF_SPHERES, e));
            end = end_of_tile(tile);
        }
        e = next_of(stack, starts, &top, end);
    }
}

// TILES: fills a tile, whose place is there: what its camera rays meet first.
static void fill_tile(const Scene *scene, Tile *tile) {
    begin_tile(scene, tile);
    if (aim_tile(scene, tile)) {
        walk_tile(scene, tile);
        return;
    }
    bool common = !ORTHOGRAPHIC && !LONG_LENS;
    for (int block = 0; block < BLOCKS; block++)
        set_hit(tile, block,
                nearest_in_tree(&scene->tree, OF_SPHERES, hit_of_tile(tile, block),
                                ray_of_tile(tile, block), (ints)(-1), common));
}

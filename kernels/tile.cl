// Tile: the camera rays of SIDE x SIDE pixels, what they meet so far, and one beam around all of them.

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
    Hit hit = {.id = tile->id[block], .distance = tile->distance[block]};
    if (OPACITY) {
        FOR_EACH_LATER(hit.later[0].distance[a] = hit.distance; hit.later[0].id[a] = NO_MORE)
    }
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

// TILES: makes the beam around the rays of a tile; whether they have an axis in common.
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
    return true;
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

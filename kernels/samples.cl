// Samples: several points of a pixel, and when they are enough.
//
// With HASHED a pixel's path is wanted beside its colour. Pixels whose paths are unlike a neighbour's
// are at an edge, and so may be those that have no neighbour on some side; edges() lists them, and a
// program with REFINE traces these again, its lanes as points of one pixel. With GATHER every pixel
// gets several samples: the lanes are then pixels, and all have their points at the same places.
//
// A ball of less than a pixel may lie between the points of all pixels around it. mark_balls() finds where
// it can show in closed form, however few there are. It looks at spheres one by one, not at what hides them.
//
// A picture is the mean over each pixel's square. The points are those of a Sobol sequence, scrambled
// after Owen, so that n of them miss the share of a pixel that lies beyond a straight edge by about
// 0.3 n^-0.75 (rms, tests/test_samples.py).

#if REFINE

// REFINE: 16 pixels of one row that each have a neighbour of another path, as bits: from `middle` on, in
// rows of `width`.
static uint edges_of(__global const uint *middle, int width) {
    uint16 own = vload16(0, middle);
    int16 unlike = 0;
    for (int row = -1; row < 2; row++) {
        __global const uint *at = middle + row * width;
        unlike |=
            (vload16(0, at - 1) != own) | (vload16(0, at) != own) | (vload16(0, at + 1) != own);
    }
    unlike &= (int16)(BITS_16);
    int8 a = unlike.lo | unlike.hi;
    int4 b = a.lo | a.hi;
    int2 c = b.lo | b.hi;
    return c.x | c.y;
}

// Marks of 16 pixels of a row, from `left` on: the lower half of a word says in which of them a ball may
// show that no neighbour's sample has met, the upper half in which of them a small one may.
typedef struct {
    __global uint *words;
    int left, top, right, bottom;  // of what is marked: columns and rows of the picture
    int per_row;                   // words
} Marks;

// REFINE: marks the pixels that the rectangle of a small ball reaches into.
static void mark(const Marks *to, __global const Camera *camera, real left, real right, real bottom,
                 real top, bool missed) {
    real columns = REAL(0.5) / camera->step[0], rows = REAL(0.5) / camera->step[1];
    // A pixel reaches half of one to each side of its middle.
    real x0 = REAL(0.5) * camera->last[0] + REAL(0.5);
    real y0 = REAL(0.5) * camera->last[1] + REAL(0.5);
    left = left * columns + x0, right = right * columns + x0;
    top = y0 - top * rows, bottom = y0 - bottom * rows;
    if (!(right >= to->left && left < to->right && bottom >= to->top && top < to->bottom)) return;
    // Columns and rows of the picture first: rounded as for the whole, whatever part is marked.
    int first = (int)fmax(left, (real)to->left) - to->left;
    int last = (int)fmin(right, (real)(to->right - 1)) - to->left;
    int end = (int)fmin(bottom, (real)(to->bottom - 1)) - to->top;
    for (int row = (int)fmax(top, (real)to->top) - to->top; row <= end; row++)
        for (int word = first / 16; word <= last / 16; word++) {
            int low = max(first - 16 * word, 0), high = min(last - 16 * word, 15);
            uint bits = (2u << high) - (1u << low);
            uint all = bits << 16 | (missed ? bits : 0);
            atomic_or(to->words + (size_t)row * to->per_row + word, all);
        }
}

// REFINE: where 16 spheres of the list can show; not those that are none, or giants.
static Silhouettes silhouettes_of_list(__global const Camera *camera,
                                       __global const Sphere *spheres, int count) {
    wides place[5];
    real *x = (real *)place, *y = x + WIDE, *depth = y + WIDE;
    real *away = depth + WIDE, *radius = away + WIDE;
    for (int k = 0; k < WIDE; k++) {
        __global const Sphere *sphere = spheres + min(k, count - 1);
        __global const real *c = sphere->anchor;
        x[k] = TREE ? dot_real(c, camera->right) : c[0];
        y[k] = TREE ? dot_real(c, camera->up) : c[1];
        depth[k] = -(TREE ? dot_real(c, camera->back) : c[2]);
        away[k] = sqrt(dot_real(c, c));
        bool there = k < count && !sphere->giant && sphere->c0 < INFINITY;
        radius[k] = there ? 1 / sphere->inv_radius : NAN;
    }
    return silhouettes_of(camera, place[0], place[1], place[2], place[3], place[4]);
}

// REFINE: marks the pixels in which spheres can show whose radius is less than `small`, or `missed`, in
// pixels: see Marks. The words are 0 before. Global size: any.
__kernel void mark_balls(__global uint *words, int left, int top, int right, int bottom,
                         int per_row, real missed, real small, __global const Camera *camera,
                         int sphere_count, __global const Sphere *spheres,
                         __global const Leaf *leaves, __global const Shape *shape) {
    Marks marks = {words, left, top, right, bottom, per_row};
    // Halves of rectangles, in pixels.
    real columns = REAL(0.25) / camera->step[0], rows = REAL(0.25) / camera->step[1];
    int listed = (sphere_count + WIDE - 1) / WIDE, all = listed;
    if (TREE) all += (shape->node_count - shape->lowest) * shape->per_node;
    for (int i = get_global_id(0); i < all; i += get_global_size(0)) {
        Silhouettes of[1];
        if (i < listed) {
            of[0] = silhouettes_of_list(camera, spheres + WIDE * i, sphere_count - WIDE * i);
        } else {
            of[0] = silhouettes_of_leaf(camera, leaves + (i - listed));
        }
        // Of these few are small: 16 at a time they cost what one does.
        wides wide = (of[0].right - of[0].left) * columns, high = (of[0].top - of[0].bottom) * rows;
        wides radius = wide < high ? wide : high;
        uint missed_bits = wide_bits(radius < missed);
        const real *each = (const real *)of;
        for (uint bits = wide_bits(of[0].known & (radius < small)); bits; bits &= bits - 1) {
            int k = LOWEST_BIT(bits);
            mark(&marks, camera, each[k], each[WIDE + k], each[2 * WIDE + k], each[3 * WIDE + k],
                 missed_bits >> k & 1);
        }
    }
}

// REFINE: lists the pixels of a film that are at an edge or marked, in any order. So are those at the
// picture's border: what lies beyond it may begin in them.
// paths: height x width. Those are listed that lie before column `right`, from column `left` and row
// `first_row` on, by their place in a film that begins with that row; ~place where a small ball is. A
// listed pixel has neighbours in `paths` but where the picture ends. marks: a word for each work-item.
// Global size: (columns / 16, rounded up; rows).
__kernel void edges(__global const uint *paths, int width, int height, int left, int first_row,
                    int right, __global const uint *marks, __global int *list,
                    __global int *count) {
    int column = left + 16 * get_global_id(0), row = first_row + get_global_id(1);
    uint mark = marks[get_global_id(1) * get_global_size(0) + get_global_id(0)];
    bool last = row == 0 || row == height - 1;
    __global const uint *at = paths + (size_t)row * width + column;
    uint bits = mark & 0xffff;
    if (!last && column > 0 && column + 17 <= width && column + 16 <= right) {
        bits |= edges_of(at, width);
    } else {
        for (int i = 0; i < 16 && column + i < right; i++) {
            bool unlike = last || column + i == 0 || column + i == width - 1;
            for (int place = 0; place < 9 && !unlike; place++)
                unlike = at[i] != at[i + (place / 3 - 1) * width + place % 3 - 1];
            bits |= (uint)unlike << i;
        }
    }
    if (!bits) return;
    int found[16], number = 0;
    for (int i = 0; i < 16; i++) {
        if (!(bits >> i & 1)) continue;
        int place = (row - first_row) * width + column + i;
        found[number++] = mark >> (16 + i) & 1 ? ~place : place;
    }
    int place = atomic_add(count, number);
    for (int i = 0; i < number; i++) list[place + i] = found[i];
}

#endif

// How many samples there are between two looks whether they are enough.
#define BATCH 16

// Of samples: by blocks, lest a sum of 65536 numbers is off by as many roundings.
typedef struct {
    Vector color;
    reals alpha;
    Guide guide[ROOM(FILM_GUIDES)];
} Sum;

// FILM_GUIDES: one plus part of another.
static Guide more_of(Guide a, Guide b, reals part) {
    Guide sum = {along(a.albedo, part, b.albedo), along(a.normal, part, b.normal),
                 a.depth + part * b.depth, a.square + part * b.square};
    return sum;
}

// GATHER or REFINE: adds a sample in the lanes that are on.
static Sum with(Sum sum, Sample sample, ints on) {
    sum.color = plus(sum.color, pick3(on, sample.color, vector(0, 0, 0)));
    sum.alpha += PICK(on, sample.alpha, 0);
    if (FILM_GUIDES) sum.guide[0] = more_of(sum.guide[0], sample.guide[0], PICK(on, REAL(1.0), 0));
    return sum;
}

// GATHER or REFINE: the sum of two sums.
static Sum sum_of(Sum a, Sum b) {
    Sum sum = {plus(a.color, b.color), a.alpha + b.alpha};
    if (FILM_GUIDES) sum.guide[0] = more_of(a.guide[0], b.guide[0], 1);
    return sum;
}

// GATHER: the mean of several samples of each pixel of a packet.
static Sample gathered(const Scene *scene, int column, int row, int samples,
                       __global const real *points, __global const uint2 *table) {
    Sum sum = {vector(0, 0, 0), 0};
    Draw draw = {table, (samples + BATCH - 1) / BATCH * BATCH, 0, hash_of_pixels(column, row), 0};
    reals count = 0;
    ints going = count >= 0, path = 0;
    Pixels at = pixels_at(scene->camera, column, row);
    for (int start = 0; start < samples && ANY(going); start += BATCH) {
        Sum block = {vector(0, 0, 0), 0};
        int end = min(start + BATCH, samples);
        for (int i = start; i < end; i++) {
            Pixels here = moved(at, scene->camera, points[2 * i], points[2 * i + 1]);
            draw.index = i;
            Sample sample = traced(scene, here, draw, 0);
            block = with(block, sample, going);
            path = path * 16777619 + sample.path;
        }
        sum = sum_of(sum, block);
        count += PICK(going, end - start, 0);
        // That no sample has met what is rare is no sign that it is not there. Where there is nothing
        // to see nothing is rare, but for a lens.
        if (RANDOM && !LENS) going &= sum.alpha > 0;
    }
    // Not times 1 / count: of what is 1 everywhere the mean is 1, to the bit.
    Sample mean = {vector(sum.color.x / count, sum.color.y / count, sum.color.z / count),
                   sum.alpha / count, path};
    if (FILM_GUIDES) mean.guide[0] = more_of((Guide){{0}}, sum.guide[0], 1 / count);
    return mean;
}

#define ENOUGH REAL(127.5)

// So many samples at least where a small ball is: 16 points leave room for a disc that covers 0.125 of a
// pixel, and 48 for 0.054 (tests/test_samples.py).
#define LEAST_OF_SMALL (3 * BATCH)

// REFINE: how far apart the colours of n samples may lie so that their mean is off by at most 1/255: an
// edge that parts them is missed by 0.3 n^-0.75 of that (rms); half of it is ENOUGH.
static real range_that_is_enough(int n) {
    real root = sqrt((real)n);
    return root * sqrt(root) / ENOUGH;
}

// REFINE: the mean of several samples of one pixel: at least so many, if no more are.
static Sample refined(const Scene *scene, int column, int row, int least, int samples,
                      __global const real *points) {
    Sum sum = {vector(0, 0, 0), 0};
    Vector low = vector(INFINITY, INFINITY, INFINITY), high = scaled(low, -1);
    reals least_seen = 1, most_seen = 0;
    int end = 0;
    for (bool enough = false; end < samples && !enough;) {
        Sum block = {vector(0, 0, 0), 0};
        for (int i = end; i < min(end + BATCH, samples); i += LANES) {
            ints on = i + LANE < samples;
            reals right = *(__global const reals *)(points + 2 * i);
            reals up = *(__global const reals *)(points + 2 * i + LANES);
            Sample sample =
                traced(scene, points_of(scene->camera, column, row, right, up), (Draw){0}, 0);
            block = with(block, sample, on);
            low = lower3(low, pick3(on, sample.color, low));
            high = higher3(high, pick3(on, sample.color, high));
            least_seen = PICK(on & (sample.alpha < least_seen), sample.alpha, least_seen);
            most_seen = PICK(on & (sample.alpha > most_seen), sample.alpha, most_seen);
        }
        sum = sum_of(sum, block);
        end = min(end + BATCH, samples);
        real range = JOIN(most, LANES)(high.x) - JOIN(least, LANES)(low.x);
        range = max(range, JOIN(most, LANES)(high.y) - JOIN(least, LANES)(low.y));
        range = max(range, JOIN(most, LANES)(high.z) - JOIN(least, LANES)(low.z));
        // A black ball before nothing has an edge as well. Of one sample alpha is 0 or 1.
        real seen = JOIN(total, LANES)(sum.alpha);
        if (FILM_ALPHA && !OPACITY && seen > 0 && seen < end) range = max(range, REAL(1.0));
        if (FILM_ALPHA && OPACITY)
            range = max(range, JOIN(most, LANES)(most_seen) - JOIN(least, LANES)(least_seen));
        enough = end >= least && !(range > range_that_is_enough(end));
    }
    Sample mean = {
        vector(JOIN(total, LANES)(sum.color.x) / end, JOIN(total, LANES)(sum.color.y) / end,
               JOIN(total, LANES)(sum.color.z) / end),
        JOIN(total, LANES)(sum.alpha) / end, 0};
    return mean;
}

// Denoise: a filter of the noise of few samples, by what the camera sees first.
//
// What a pixel's surface sends on, its colour without its albedo, is fitted around each pixel by a
// plane over normals: so what light makes of a curved surface stays. Neighbours count the less the more
// normal, depth, albedo and alpha are unlike the pixel's, and the more their colours differ than their
// noise explains, which the samples themselves tell. So there is little to do where there is little
// noise.
//
// Weights as of a cross bilateral filter: Petschnigg et al., Digital photography with flash and no-flash
// image pairs, SIGGRAPH 2004; the fit: Bitterli et al., Nonlinearly weighted first-order regression for
// denoising Monte Carlo renderings, EGSR 2016, in one pass of fewer neighbours.

#if FILM_GUIDES

#define FAR 2     // how many columns and rows away neighbours are
#define NEAR2 5   // the square of their distance, at most
#define STRIP 16  // rows that a work-item makes
#define TALL (STRIP + 2 * FAR)
#define SPAN ((2 * FAR + 2 * LANES - 1) / LANES * LANES)  // columns that it looks at
#define TAKEN 12                                          // numbers of each pixel

// Where a neighbour counts for nothing: at that distance in pixels; so unlike a normal, an albedo, an
// alpha; so many pixels' sides nearer or farther.
#define APART REAL(3.5)
#define TURNED REAL(0.85)
#define TINTED REAL(0.2)
#define COVERED REAL(0.5)
#define DEEPER REAL(16.0)
// How much noise explains of a difference, and how steep a plane may be.
#define NOISY REAL(1.0)
#define STIFF REAL(0.0002)
// Lest something is divided by 0: less than a byte's step of albedo, of light, of alpha.
#define SOME REAL(0.02)
#define LITTLE REAL(1e-6)
#define LEAST_ALPHA REAL(1e-4)
// The noise of one sample, which says nothing of it: more than there is.
#define UNKNOWN REAL(1e15)

// FILM_GUIDES: pixels as the filter looks at them.
typedef struct {
    Vector light;  // without albedo
    Vector albedo;
    Vector normal;
    reals alpha;  // 0 where there is nothing to share
    reals depth;
    reals noise;  // the variance of the sum of light
} Felt;

// FILM_GUIDES: sums over neighbours, each times its weight: of what differs from the pixel in the middle.
typedef struct {
    reals weight;
    Vector light, normal;
    Vector per_x, per_y, per_z;  // light times each part of the normal
    Vector square, mixed;        // of normals: x x, y y, z z; y z, z x, x y
} Fit;

// FILM_GUIDES: what was taken of pixels of a row.
static Felt felt_at(__private const real *taken) {
    typedef reals loose __attribute__((aligned(sizeof(real))));
    Felt felt;
    __private reals *parts = (__private reals *)&felt;
    for (int k = 0; k < TAKEN; k++) parts[k] = *(__private const loose *)(taken + k * TALL * SPAN);
    return felt;
}

// FILM_GUIDES: what a filter looks at in pixels whose numbers are taken in the film's order. samples: of a
// pixel.
static Felt felt_of(__private const real *taken, int samples) {
    Felt raw = felt_at(taken), felt = raw;
    Vector color = raw.light;
    reals alpha = raw.albedo.x, bright = color.x + color.y + color.z;
    // NaN and infinity are not shared.
    ints there = (alpha > LEAST_ALPHA) & (absolute(bright) < INFINITY);
    felt.alpha = PICK(there, alpha, 0);
    reals offset = SOME * alpha;
    felt.albedo = vector(raw.albedo.y + offset, raw.albedo.z + offset, raw.normal.x + offset);
    felt.normal = vector(raw.normal.y, raw.normal.z, raw.alpha);
    felt.depth = raw.depth / PICK(there, alpha, 1);
    Vector albedo = pick3(there, felt.albedo, vector(1, 1, 1));
    color = pick3(there, color, vector(0, 0, 0));
    felt.light = vector(color.x / albedo.x, color.y / albedo.y, color.z / albedo.z);
    reals per_light = 3 / (albedo.x + albedo.y + albedo.z);
    reals spread = (raw.noise - bright * bright) * (per_light * per_light);
    spread = PICK(spread > 0, spread, 0) / max(samples - 1, 1);
    felt.noise = samples > 1 ? spread : (reals)UNKNOWN;
    return felt;
}

// FILM_GUIDES: how much neighbours count by what is seen there. room: how much nearer or farther they may be.
static reals alike(Felt own, Felt other, real distance2, reals per_room2) {
    Vector turned = minus(other.normal, own.normal), tinted = minus(other.albedo, own.albedo);
    reals covered = other.alpha - own.alpha, deeper = other.depth - own.depth;
    reals unlike = distance2 / (APART * APART) + dot3(turned, turned) * (1 / (TURNED * TURNED)) +
                   dot3(tinted, tinted) * (1 / (TINTED * TINTED)) +
                   (covered * covered * (1 / (COVERED * COVERED)) + deeper * deeper * per_room2);
    return PICK((unlike < 1) & (other.alpha > 0), 1 - unlike, 0);
}

// FILM_GUIDES: the square of the difference of their light, beside what noise explains of it.
static reals differs(Felt own, Felt other, reals noise) {
    Vector lit = minus(other.light, own.light);
    reals sum = lit.x + lit.y + lit.z;
    return noise + sum * sum;
}

// FILM_GUIDES: adds neighbours.
static void add_to(Fit *fit, Felt own, Felt other, reals weight) {
    Vector light = minus(other.light, own.light), normal = minus(other.normal, own.normal);
    Vector weighed = scaled(normal, weight);
    fit->weight += weight;
    fit->light = along(fit->light, weight, light);
    fit->normal = plus(fit->normal, weighed);
    fit->per_x = along(fit->per_x, weighed.x, light);
    fit->per_y = along(fit->per_y, weighed.y, light);
    fit->per_z = along(fit->per_z, weighed.z, light);
    fit->square = plus(fit->square, times(weighed, normal));
    fit->mixed =
        plus(fit->mixed, vector(weighed.y * normal.z, weighed.z * normal.x, weighed.x * normal.y));
}

// FILM_GUIDES: by how much the fit's light is more in the middle than the pixel's own. Where nothing differs
// it is 0, to the bit.
static Vector more_light(const Fit *fit) {
    reals per = 1 / fit->weight;
    Vector mean = scaled(fit->normal, per), light = scaled(fit->light, per);
    // The normals' covariance, with something more on the diagonal, and its cofactors.
    Vector square = minus(scaled(fit->square, per), times(mean, mean));
    square = plus(square, vector(STIFF, STIFF, STIFF));
    Vector mixed =
        minus(scaled(fit->mixed, per), vector(mean.y * mean.z, mean.z * mean.x, mean.x * mean.y));
    Vector own =
        vector(square.y * square.z - mixed.x * mixed.x, square.z * square.x - mixed.y * mixed.y,
               square.x * square.y - mixed.z * mixed.z);
    Vector other =
        vector(mixed.y * mixed.z - mixed.x * square.x, mixed.z * mixed.x - mixed.y * square.y,
               mixed.x * mixed.y - mixed.z * square.z);
    reals determinant = square.x * own.x + (mixed.z * other.z + mixed.y * other.y);
    // How far the middle is from the mean, in units of the covariance.
    Vector off = vector(own.x * mean.x + (other.z * mean.y + other.y * mean.z),
                        other.z * mean.x + (own.y * mean.y + other.x * mean.z),
                        other.y * mean.x + (other.x * mean.y + own.z * mean.z));
    off = scaled(off, 1 / determinant);
    reals steep = dot3(off, mean);
    // sum of off times (light per normal - mean light times mean normal)
    Vector slope =
        plus(scaled(fit->per_x, off.x), plus(scaled(fit->per_y, off.y), scaled(fit->per_z, off.z)));
    return along(scaled(light, 1 + steep), -per, slope);
}

// FILM_GUIDES: adds two neighbours, on either side: one division for both.
static void add_pair(Fit *fit, Felt own, __private const real *middle, int away, real distance2,
                     reals per_room2) {
    Felt a = felt_at(middle + away), b = felt_at(middle - away);
    reals noise_a = NOISY * (own.noise + a.noise) + LITTLE;
    reals noise_b = NOISY * (own.noise + b.noise) + LITTLE;
    reals differs_a = differs(own, a, noise_a), differs_b = differs(own, b, noise_b);
    reals per_both = 1 / (differs_a * differs_b);
    reals weight_a = alike(own, a, distance2, per_room2) * noise_a * differs_b * per_both;
    reals weight_b = alike(own, b, distance2, per_room2) * noise_b * differs_a * per_both;
    add_to(fit, own, a, PICK(weight_a > 0, weight_a, 0));
    add_to(fit, own, b, PICK(weight_b > 0, weight_b, 0));
}

// FILM_GUIDES: how much more light there is in pixels than they have, times their albedo. side: a pixel's, where
// the camera's screen is 1 away or (ORTHOGRAPHIC) in the kernel's unit.
static Vector shared_at(__private const real *middle, real side) {
    Felt own = felt_at(middle);
    reals room = DEEPER * side * (ORTHOGRAPHIC ? (reals)1 : own.depth);
    reals per_room2 = 1 / (room * room);
    Fit fit = {1};
    for (int down = 0; down <= FAR; down++) {
        for (int right = -FAR; right <= FAR; right++) {
            int distance2 = down * down + right * right;
            if (distance2 > NEAR2 || (down == 0 && right <= 0)) continue;
            add_pair(&fit, own, middle, down * SPAN + right, distance2, per_room2);
        }
    }
    return times(more_light(&fit), own.albedo);
}

// FILM_GUIDES: takes a row of pixels from the film, number by number, from a column on; 0 beyond its ends.
static void take_row(__private real *taken, __global const channel *film, int width, int column,
                     bool there) {
    bool inside = there && column >= 0 && column + LANES + 2 * FAR <= width;
    for (int x = 0; x < LANES + 2 * FAR; x++) {
        if (inside || (there && column + x >= 0 && column + x < width)) {
            __global const float *from = film[column + x].color;
            for (int k = 0; k < TAKEN; k++) taken[k * TALL * SPAN + x] = from[k];
        } else {
            for (int k = 0; k < TAKEN; k++) taken[k * TALL * SPAN + x] = 0;
        }
    }
}

// FILM_GUIDES: makes a row of what was taken what the filter looks at.
static void feel_row(__private real *taken, int samples) {
    for (int x = 0; x < SPAN; x += LANES) {
        Felt felt = felt_of(taken + x, samples);
        __private const reals *parts = (__private const reals *)&felt;
        for (int k = 0; k < TAKEN; k++)
            *(__private reals *)(taken + x + k * TALL * SPAN) = parts[k];
    }
}

// FILM_GUIDES: makes a film with less noise of one with guides: colours with alpha, which stays as it is.
// That has `height` rows of `width`; those from row `first` on are made, up to `last`. Global size:
// (packets of LANES pixels in a row; STRIPs of rows).
__kernel void denoise(__global const channel *film, int width, int height, int first, int last,
                      int samples, __global const Camera *camera, __global float *out) {
    int column = get_global_id(0) * LANES, row = first + get_global_id(1) * STRIP;
    __private reals space[TAKEN * TALL * SPAN / LANES];
    __private real *taken = EACH_REAL(space);
    for (int y = 0; y < TALL; y++) {
        int from = row + y - FAR;
        bool there = from >= 0 && from < height;
        take_row(taken + y * SPAN, film + (there ? (size_t)from * width : 0), width, column - FAR,
                 there);
        feel_row(taken + y * SPAN, samples);
    }
    for (int y = 0; y < STRIP && row + y < last; y++) {
        Vector shared = shared_at(taken + (y + FAR) * SPAN + FAR, 2 * camera->step[0]);
        __private const real *more = EACH_REAL(shared);
        size_t place = (size_t)(row + y) * width + column;
        for (int i = 0; i < LANES && column + i < width; i++) {
            __global const float *color = film[place + i].color;
            __global float *to = out + 4 * (place + i - (size_t)first * width);
            for (int k = 0; k < 3; k++) to[k] = color[k] + more[k * LANES + i];
            to[3] = color[3];
        }
    }
}

#endif

// Film: pixels as they leave the kernel, in rows.
//
// Pixels are interleaved float32 RGB; with FILM_ALPHA float32 RGBA; with FILM_BYTES 8-bit RGB; with
// FILM_GUIDES, FILM_PASSES and FILM_PATHS one `channel` each. Floats are linear and not clipped.
//
// For each kind of film there are a `channel`, how many CHANNELS a pixel has, an Exposure, which is a
// packet's pixels as that film has them, and store_row().
//
// To store RGB lane by lane takes as long as to trace it, so vectors are put in the order of memory
// by swizzles: which pixel each element of the three vectors of a row belongs to (THIRDS), and
// which two pixels share each 32-bit word of its 3 * ROW bytes (LOW, HIGH).

#if ROW == 2
#define THIRDS(take) {take(0, s00), take(1, s01), take(2, s11)}
#define LOW s01
#define HIGH s11
#elif ROW == 4
#define THIRDS(take) {take(0, s0001), take(1, s1122), take(2, s2333)}
#define LOW s0120
#define HIGH s1230
#define HALF uint2
#define QUARTER uint
#elif ROW == 8
#define THIRDS(take) {take(0, s00011122), take(1, s23334445), take(2, s55666777)}
#define LOW s01245600
#define HIGH s12356700
#define HALF uint4
#define QUARTER uint2
#elif ROW == 16
#define THIRDS(take) \
    {take(0, s0001112223334445), take(1, s55666777888999aa), take(2, sabbbcccdddeeefff)}
#define LOW s01245689acde0000
#define HIGH s1235679abdef0000
#define HALF uint8
#define QUARTER uint4
#endif

// FILM_GUIDES: what a filter of noise looks at, see denoise.cl. Of what the camera sees first; of several
// samples the sums or means.
typedef struct {
    Vector albedo;  // the part of diffuse light that it sends on, linear RGB
    Vector normal;
    reals depth;   // how far away, in the kernel's unit
    reals square;  // of the brightness of each sample
} Guide;

// What a packet of camera rays brings.
typedef struct {
    Vector color;
    reals alpha;  // 1 where the camera sees something, else 0; OPACITY: between
    ints path;    // a hash of what was met
    ints id;      // FILM_PASSES: what the camera sees first, how far away, and its normal
    reals depth;
    Vector normal;
    Guide guide[ROOM(FILM_GUIDES)];
} Sample;

#if FILM_PATHS

typedef uint channel;
#define CHANNELS 1
typedef struct {
    ints path;
} Exposure;

// A packet's pixels as this film has them.
static Exposure exposure_of(Sample sample) {
    Exposure exposure = {sample.path};
    return exposure;
}

// Stores a row of the packet, as many of its pixels as `count`.
static void store_row(Exposure exposure, int row, __global channel *pixels, int count) {
    __private const INTEGER *each = EACH_INT(exposure.path) + row * ROW;
    for (int i = 0; i < ROW && i < count; i++) pixels[i] = (uint)each[i];
}

#elif FILM_PASSES

// 20 bytes.
typedef struct {
    float depth;      // in the world's unit of length; infinity where nothing is seen
    float normal[3];  // in the world; 0 there
    int id;           // of what is seen; -1 there
} channel;
#define CHANNELS 1
typedef Sample Exposure;

// A packet's pixels as this film has them.
static Exposure exposure_of(Sample sample) {
    ints seen = sample.id >= 0;
    sample.depth = PICK(seen, sample.depth, INFINITY);
    sample.normal = pick3(seen, sample.normal, vector(0, 0, 0));
    return sample;
}

// Stores a row of the packet, as many of its pixels as `count`.
static void store_row(Exposure exposure, int row, __global channel *pixels, int count) {
    __private const INTEGER *ids = EACH_INT(exposure.id) + row * ROW;
    __private const real *depths = EACH_REAL(exposure.depth) + row * ROW;
    __private const real *normals = EACH_REAL(exposure.normal) + row * ROW;
    for (int i = 0; i < ROW && i < count; i++) {
        pixels[i].depth = depths[i];
        for (int axis = 0; axis < 3; axis++) pixels[i].normal[axis] = normals[axis * LANES + i];
        pixels[i].id = ids[i];
    }
}

#elif FILM_GUIDES

// 48 bytes.
typedef struct {
    float color[4];  // premultiplied by the alpha that comes last
    float albedo[3];
    float normal[3];
    float depth;
    float square;
} channel;
#define CHANNELS 1
typedef Sample Exposure;

// A packet's pixels as this film has them.
static Exposure exposure_of(Sample sample) { return sample; }

// Stores a row of the packet, as many of its pixels as `count`.
static void store_row(Exposure exposure, int row, __global channel *pixels, int count) {
    __private const real *colors = EACH_REAL(exposure.color) + row * ROW;
    __private const real *alphas = EACH_REAL(exposure.alpha) + row * ROW;
    __private const real *guides = EACH_REAL(exposure.guide[0]) + row * ROW;
    for (int i = 0; i < ROW && i < count; i++) {
        __global float *all = pixels[i].color;
        for (int k = 0; k < 3; k++) all[k] = colors[k * LANES + i];
        all[3] = alphas[i];
        for (int k = 0; k < 8; k++) all[4 + k] = guides[k * LANES + i];
    }
}

#elif FILM_ALPHA

typedef float channel;
#define CHANNELS 4
typedef struct {
    Vector color;
    reals alpha;
} Exposure;

// A packet's pixels as this film has them.
static Exposure exposure_of(Sample sample) {
    Exposure exposure = {sample.color, sample.alpha};
    return exposure;
}

// Stores a row of the packet, as many of its pixels as `count`.
static void store_row(Exposure exposure, int row, __global channel *pixels, int count) {
    __private const real *rgba = EACH_REAL(exposure) + row * ROW;
    for (int i = 0; i < ROW && i < count; i++)
        for (int k = 0; k < 4; k++) pixels[4 * i + k] = rgba[k * LANES + i];
}

#elif FILM_BYTES

typedef uchar channel;
#define CHANNELS 3
typedef ROW_OF(uint) row_uints;
typedef struct {
    LANES_OF(uint) rgb;  // 0bgr
} Exposure;

// Adding this rounds to an integer, in the low bits.
#define ROUNDING (DOUBLE ? REAL(6755399441055744.0) : REAL(12582912.0))

// round(255 clip(c)), ties to even.
static ints developed(reals c) {
    c = PICK(c > 0, c, 0);
    c = PICK(c < 1, c, 1);
    return AS_INTS(c * 255 + ROUNDING) & 255;
}

// A packet's pixels as this film has them.
static Exposure exposure_of(Sample sample) {
    Exposure exposure = {JOIN(convert_, LANES_OF(uint))(developed(sample.color.x) |
                                                        developed(sample.color.y) << 8 |
                                                        developed(sample.color.z) << 16)};
    return exposure;
}

#if ROW == 1
// Words 0bgr as they are stored: one has no gap.
static row_uints without_gaps(row_uints rgb) { return rgb; }
#else
// Words 0bgr as they are stored: four make three without the gaps.
static row_uints without_gaps(row_uints rgb) {
    row_uints part = (row_uints)(ROW_NUMBERS) % 3 * 8;
    return rgb.LOW >> part | rgb.HIGH << (24 - part);
}
#endif

#if ROW > 2
// Stores a whole row at once. Pixels begin at any byte.
static void store_whole_row(row_uints rgb, __global channel *pixels) {
    typedef HALF loose_half __attribute__((aligned(1)));
    typedef QUARTER loose_quarter __attribute__((aligned(1)));
    *(__global loose_half *)pixels = rgb.lo;
    *(__global loose_quarter *)(pixels + 2 * ROW) = rgb.hi.lo;
}
#else
// Not for so few.
static void store_whole_row(row_uints rgb, __global channel *pixels) {}
#endif

// Stores a row of the packet, as many of its pixels as `count`.
static void store_row(Exposure exposure, int row, __global channel *pixels, int count) {
    row_uints rgb = without_gaps(((__private const row_uints *)&exposure.rgb)[row]);
    if (ROW > 2 && count >= ROW) {
        store_whole_row(rgb, pixels);
        return;
    }
    __private const uchar *each = (__private const uchar *)&rgb;
    for (int i = 0; i < 3 * ROW && i < 3 * count; i++) pixels[i] = each[i];
}

#else

typedef float channel;
#define CHANNELS 3
typedef ROW_OF(float) row_floats;
typedef struct {
    LANES_OF(float) r, g, b;
} Exposure;

// A packet's pixels as this film has them.
static Exposure exposure_of(Sample sample) {
    Exposure exposure = {JOIN(convert_, LANES_OF(float))(sample.color.x),
                         JOIN(convert_, LANES_OF(float))(sample.color.y),
                         JOIN(convert_, LANES_OF(float))(sample.color.z)};
    return exposure;
}

#if ROW == 1
// Stores the packet's one pixel of that row.
static void store_row(Exposure exposure, int row, __global channel *pixels, int count) {
    pixels[0] = ((__private const float *)&exposure.r)[row];
    pixels[1] = ((__private const float *)&exposure.g)[row];
    pixels[2] = ((__private const float *)&exposure.b)[row];
}
#else
// Stores a row of the packet, as many of its pixels as `count`.
static void store_row(Exposure exposure, int row, __global channel *pixels, int count) {
    row_floats r = ((__private const row_floats *)&exposure.r)[row];
    row_floats g = ((__private const row_floats *)&exposure.g)[row];
    row_floats b = ((__private const row_floats *)&exposure.b)[row];
    // Element i of the row's 3 * ROW is channel i % 3 of pixel i / 3.
    // A call, lest the selections are folded to shuffles, on which Oclgrind 21.10 crashes.
    ROW_OF(int) number = JOIN(convert_, ROW_OF(int))((ROW_OF(int))(ROW_NUMBERS));
#define TAKE(k, pixel) \
    ((number + k * ROW) % 3 == 0 ? r.pixel : (number + k * ROW) % 3 == 1 ? g.pixel : b.pixel)
    __private const row_floats thirds[3] = THIRDS(TAKE);
    if (count >= ROW) {
        typedef row_floats loose __attribute__((aligned(4)));
        for (int k = 0; k < 3; k++) ((__global loose *)pixels)[k] = thirds[k];
        return;
    }
    __private const float *each = (__private const float *)thirds;
    for (int i = 0; i < 3 * count; i++) pixels[i] = each[i];
}
#endif

#endif

// HASHED: stores the paths of a row of the packet, as many as `count`.
static void store_paths(ints path, int row, __global uint *paths, int count) {
    __private const INTEGER *each = EACH_INT(path) + row * ROW;
    for (int i = 0; i < ROW && i < count; i++) paths[i] = (uint)each[i];
}

// Draw: numbers at random, and directions made of them.
//
// The host defines OCCLUSION if spheres hide ambient light, LENS if what is out of focus is blurred,
// GLOSS if mirrors are rough and INDIRECT if surfaces light each other; RANDOM if any of them: each of
// a pixel's samples then draws its own light, lens, mirror and so on. The numbers are those of Sobol
// sequences, the same in all pixels but turned by a hash of the pixel, of what they are for and of the
// bounce (Cranley and Patterson, Randomization of Number Theoretic Methods for Multiple Integration,
// 1976): so a picture is the same whoever makes it.
#define RANDOM (OCCLUSION || LENS || GLOSS || INDIRECT)

typedef LANES_OF(uint) uints;

// What numbers are drawn for: a pair of each for every bounce, at most BOUNCES of them, but SKY, which
// has SKY_RAYS pairs for each sample and is the last of the table. See sampling() of clrt/pack.py.
enum { LENS_POINT, LIGHT_POINT, MIRROR, CHOICE, SKY };
#define BOUNCES 4
#define SKY_RAYS 4

typedef struct {
    __global const uint2 *table;
    int samples;  // as many as a pair has numbers
    int index;    // of this sample
    uints pixel;  // a hash of each lane's pixel
    int bounce;   // 0: from the camera
} Draw;

typedef struct {
    reals u, v;  // in [0, 1)
} Pair;

// A hash, see clrt/samples.py.
static uints mixed(uints n) {
    n = (n ^ n >> 16) * 0x7feb352du;
    n = (n ^ n >> 15) * 0x846ca68bu;
    return n ^ n >> 16;
}

static uints hash_of_pixels(int column, int row) {
#if LANES == 1
    return mixed((uint)column + mixed((uint)row));
#else
    uints lane = JOIN(convert_, LANES_OF(uint))(LANE);
    return mixed((uint)column + lane % ROW + mixed((uint)row + lane / ROW));
#endif
}

// With a tree the lanes share what they draw of skies, lights and lenses: so their rays stay a beam,
// which is 3 to 4 times as fast. Below 16 samples the packets show in the noise.
#define SHARES (TREE && LANES > 1)
static Pair drawn(Draw draw, int what, int which, int k) {
    int bounce = min(draw.bounce, BOUNCES - 1);
    __global const uint2 *pairs = draw.table + draw.samples * (bounce * SKY + what);
    int index = draw.index;
    if (what == SKY) {
        pairs = draw.table + draw.samples * (BOUNCES * SKY + bounce * SKY_RAYS);
        index = draw.index * SKY_RAYS + k;
    }
    uints hash = mixed(draw.pixel + (uint)(what + 8 * (which + 4096 * draw.bounce)));
    __private uints all[1] = {hash};
    if (SHARES && what != MIRROR && what != CHOICE) hash = (uints)(((__private uint *)all)[0]);
    uints u = hash + pairs[index].x, v = mixed(hash) + pairs[index].y;
#if DOUBLE
    Pair pair = {TO_REALS(u) * 2.3283064365386963e-10, TO_REALS(v) * 2.3283064365386963e-10};
#else
    Pair pair = {TO_REALS(u >> 8) * 5.9604645e-8f, TO_REALS(v >> 8) * 5.9604645e-8f};
#endif
    return pair;
}

// The sine and the cosine of a part of a turn.
static void sine_cosine_of_turn(reals turn, reals *sine, reals *cosine) {
    reals s, c;  // of half the angle, between -90 and 90 degrees
    sine_cosine(PI * (turn - REAL(0.5)), &s, &c);
    *sine = 2 * s * c;
    *cosine = 1 - 2 * s * s;
}

// A direction that is off another one: by an angle of this versine, 1 - cosine, to a side that is a part
// of a turn. Tangents after Duff et al., Building an Orthonormal Basis, Revisited, 2017.
static Vector tilted(Vector d, reals versine, reals turn) {
    reals sign = PICK(d.z < 0, -1, 1), a = -1 / (sign + d.z), b = d.x * d.y * a;
    Vector right = vector(1 + sign * d.x * d.x * a, sign * b, -sign * d.x);
    Vector up = vector(b, sign + d.y * d.y * a, -d.y);
    reals s, c, aside = root(versine * (2 - versine));
    sine_cosine_of_turn(turn, &s, &c);
    return along(along(scaled(d, 1 - versine), aside * c, right), aside * s, up);
}

// A direction above a surface, the likelier the larger its cosine.
static Vector above_surface(Vector normal, Pair pair) {
    reals cosine = sqrt(1 - pair.u);
    return tilted(normal, pair.u / (1 + cosine), pair.v);
}

// A mirrored direction, anywhere in a cone of that versine about it. What would go into the surface is
// mirrored by it.
static Vector blurred(Vector d, Vector normal, reals spread, Pair pair) {
    d = tilted(d, pair.u * spread, pair.v);
    reals into = dot3(d, normal);
    return along(d, -2 * PICK(into < 0, into, 0), normal);
}

// Draw: numbers at random, and directions made of them.
//
// With RANDOM each of a pixel's samples draws its own point of a light, of the lens, of a mirror's cone
// and so on. The numbers are those of Sobol sequences, the same in all pixels but shifted by a hash of
// the pixel, of what they are for and of the bounce: their bits are flipped by it, which leaves one
// point in every box of Sobol's (a digital shift: Owen, Monte Carlo Theory, Methods and Examples, 2013,
// chapter 17). So a picture is the same whoever makes it.

typedef LANES_OF(uint) uints;

// What numbers are drawn for: a pair of each for every bounce, at most BOUNCES of them, but SKY, which
// has SKY_RAYS pairs for each sample and is the last of the table. See sampling() of clrt/renderer/pack/arguments.py.
enum { LENS_POINT, LIGHT_POINT, MIRROR, CHOICE, SKY };
#define BOUNCES 4
#define SKY_RAYS 4

// Which numbers a packet's paths draw next.
typedef struct {
    __global const uint2 *table;
    int samples;  // as many as a pair has numbers
    int index;    // of this sample
    uints pixel;  // a hash of each lane's pixel
    int bounce;   // 0: from the camera
} Draw;

// Two numbers that were drawn, in [0, 1).
typedef struct {
    reals u, v;
} Pair;

// GATHER: a hash, see clrt/renderer/samples.py.
static uints mixed(uints n) {
    n = (n ^ n >> 16) * 0x7feb352du;
    n = (n ^ n >> 15) * 0x846ca68bu;
    return n ^ n >> 16;
}

// GATHER: a hash of each lane's pixel, the first of which stands in that column and row of the picture.
static uints hash_of_pixels(int column, int row) {
    uints lane = JOIN(convert_, LANES_OF(uint))(LANE);
    return mixed((uint)column + lane % ROW + mixed((uint)row + lane / ROW));
}

// With a tree the lanes draw from the same one of 16 x 16 cells, at skies, lights and lenses, each its
// own point of it: so their rays stay a beam. Cells of half the side cost as much, and of twice the side
// 1.15 times as much at 10^5 spheres.
#define SHARES (TREE && LANES > 1)
#define CELL 0xf0000000u

// RANDOM and TREE: hashes that have the highest bits of the first lane's.
static uints in_one_cell(uints hash) { return hash ^ ((*(__private uint *)&hash ^ hash) & CELL); }

// RANDOM: the pair of numbers for one purpose, `which` light of it, ray k of SKY_RAYS.
static Pair drawn(Draw draw, int what, int which, int k) {
    int bounce = min(draw.bounce, BOUNCES - 1);
    __global const uint2 *pairs = draw.table + draw.samples * (bounce * SKY + what);
    int index = draw.index;
    if (what == SKY) {
        pairs = draw.table + draw.samples * (BOUNCES * SKY + bounce * SKY_RAYS);
        index = draw.index * SKY_RAYS + k;
    }
    uints hash = mixed(draw.pixel + (uint)(what + 8 * (which + 4096 * draw.bounce)));
    uints shift_u = hash, shift_v = mixed(hash);
    if (SHARES && what != MIRROR && what != CHOICE) {
        shift_u = in_one_cell(shift_u);
        shift_v = in_one_cell(shift_v);
    }
    uints u = shift_u ^ pairs[index].x, v = shift_v ^ pairs[index].y;
    // As many of the 32 bits as a number holds: no rounding makes them 1.
    int dropped = DOUBLE ? 0 : 8;
    real each = DOUBLE ? REAL(2.3283064365386963e-10) : REAL(5.9604645e-8);
    Pair pair = {TO_REALS(u >> dropped) * each, TO_REALS(v >> dropped) * each};
    return pair;
}

// RANDOM: the sine and the cosine of a part of a turn.
static void sine_cosine_of_turn(reals turn, reals *sine, reals *cosine) {
    reals s, c;  // of half the angle, between -90 and 90 degrees
    sine_cosine(PI * (turn - REAL(0.5)), &s, &c);
    *sine = 2 * s * c;
    *cosine = 1 - 2 * s * s;
}

// RANDOM: a direction that is off another one: by an angle of this versine, 1 - cosine, to a side that is a part
// of a turn. Tangents after Duff et al., Building an Orthonormal Basis, Revisited, 2017.
static Vector tilted(Vector d, reals versine, reals turn) {
    reals sign = PICK(d.z < 0, -1, 1), a = -1 / (sign + d.z), b = d.x * d.y * a;
    Vector right = vector(1 + sign * d.x * d.x * a, sign * b, -sign * d.x);
    Vector up = vector(b, sign + d.y * d.y * a, -d.y);
    reals s, c, aside = root(versine * (2 - versine));
    sine_cosine_of_turn(turn, &s, &c);
    return along(along(scaled(d, 1 - versine), aside * c, right), aside * s, up);
}

// OCCLUSION or INDIRECT: a direction above a surface, the likelier the larger its cosine.
static Vector above_surface(Vector normal, Pair pair) {
    reals cosine = sqrt(1 - pair.u);
    return tilted(normal, pair.u / (1 + cosine), pair.v);
}

// GLOSS: a direction anywhere in a cone of that versine about a mirrored one. One that would lead into
// the surface is mirrored by it.
static Vector blurred(Vector d, Vector normal, reals spread, Pair pair) {
    d = tilted(d, pair.u * spread, pair.v);
    reals into = dot3(d, normal);
    return along(d, -2 * PICK(into < 0, into, 0), normal);
}

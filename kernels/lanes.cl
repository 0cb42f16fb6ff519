// Lanes: one work-item traces LANES neighbouring pixels in lock step, a packet.
//
// The source is written once, for LANES = 1 (scalars: one work-item a pixel, what a GPU wants) and
// for LANES = 2, 4, 8, 16 (OpenCL vectors, which PoCL turns into SIMD code). This file hides the
// difference.
//
//   real    one number                   float            (DOUBLE: double)
//   reals   one number a lane            float, float16   (DOUBLE: double, double16)
//   ints    one integer or mask a lane   int, int16       (DOUBLE: long, long16)
//
// A mask is what a comparison gives: false is 0; true is 1 in a scalar and -1 in a vector. So masks
// are only joined by &, | and !, and read by PICK and ANY. Never multiply by one: the lanes that a
// mask rules out may hold NaN, and 0 * NaN is NaN.

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#ifndef __has_builtin
#define __has_builtin(name) 0
#endif
// Oclgrind compiles these but cannot run them; PyOpenCL says that it is there.
#if __has_builtin(__builtin_reduce_or) && __has_builtin(__builtin_reduce_max) && \
    !defined(PYOPENCL_USING_OCLGRIND)
#define REDUCES
#endif

#if DOUBLE
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef double real;
#define REAL(literal) literal
#define FLOATING double
#define INTEGER long
#else
typedef float real;
#define REAL(literal) JOIN(literal, f)
#define FLOATING float
#define INTEGER int
#endif

#define NUMBERS_2 0, 1
#define NUMBERS_4 0, 1, 2, 3
#define NUMBERS_8 0, 1, 2, 3, 4, 5, 6, 7
#define NUMBERS_16 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15

// The bit of each of 16 places.
#define BITS_16 1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768

#if LANES == 1
#define LANES_OF(type) type
#define LANE 0
#define ANY(mask) (mask)
#define GREATEST(n) (n)
#else
#define LANES_OF(type) JOIN(type, LANES)
#define LANE ((ints)(JOIN(NUMBERS_, LANES)))
#ifdef REDUCES
// PoCL's any() is a call that spills every vector register; these become a few instructions.
#define ANY(mask) (__builtin_reduce_or(mask) != 0)
#define GREATEST(n) ((int)__builtin_reduce_max(n))
#else
#define ANY(mask) any(mask)
#define GREATEST(n) greatest(n)
#endif
#endif

// The pixels of a packet in a row. With a tree a packet is as square as can be, which keeps it
// narrow for longest; else it is a row, which is stored at once.
#if !TREE || LANES < 4
#define ROW LANES
#elif LANES == 4
#define ROW 2
#else
#define ROW 4
#endif
#define ROWS (LANES / ROW)
#if ROW == 1
#define ROW_OF(type) type
#define ROW_NUMBERS 0
#else
#define ROW_OF(type) JOIN(type, ROW)
#define ROW_NUMBERS JOIN(NUMBERS_, ROW)
#endif

typedef LANES_OF(FLOATING) reals;
typedef LANES_OF(INTEGER) ints;
#define AS_REALS(n) JOIN(as_, LANES_OF(FLOATING))(n)
#define AS_INTS(v) JOIN(as_, LANES_OF(INTEGER))(v)
#define TO_REALS(n) JOIN(convert_, LANES_OF(FLOATING))(n)
#define TO_INTS(v) JOIN(convert_, LANES_OF(INTEGER))(v)

// `?:` compiles to better code than select() on PoCL, and means the same for scalars and vectors.
#define PICK(mask, yes, no) ((mask) ? (reals)(yes) : (reals)(no))
#define PICK_INT(mask, yes, no) ((mask) ? (ints)(yes) : (ints)(no))
// A packet's numbers one by one, of a variable that holds one or more of `reals`, or of `ints`: lane i
// of the first is [i], of the second [LANES + i].
#define EACH_REAL(variable) ((__private real *)&(variable))
#define EACH_INT(variable) ((__private INTEGER *)&(variable))

#if LANES > 1 && !defined(REDUCES)
// The greatest of the lanes.
static int greatest(ints n) {
    __private ints all[1] = {n};
    __private const INTEGER *each = (__private const INTEGER *)all;
    INTEGER found = each[0];
    for (int i = 1; i < LANES; i++) found = max(found, each[i]);
    return (int)found;
}
#endif

// Not fmax() and fabs(), which are calls on PoCL.
static reals larger(reals a, reals b) { return PICK(a > b, a, b); }
static reals absolute(reals a) { return PICK(a < 0, -a, a); }

// The least and the greatest number of a vector, and the sum, by halves.
#define HALVED(name, n, half, pick)                  \
    static real JOIN(name, n)(JOIN(FLOATING, n) v) { \
        JOIN(FLOATING, half) a = v.lo, b = v.hi;     \
        return JOIN(name, half)(pick);               \
    }
static real least1(real v) { return v; }
static real most1(real v) { return v; }
static real total1(real v) { return v; }
static real least2(JOIN(FLOATING, 2) v) { return v.x < v.y ? v.x : v.y; }
static real most2(JOIN(FLOATING, 2) v) { return v.x > v.y ? v.x : v.y; }
static real total2(JOIN(FLOATING, 2) v) { return v.x + v.y; }
HALVED(least, 4, 2, a < b ? a : b)
HALVED(least, 8, 4, a < b ? a : b)
HALVED(least, 16, 8, a < b ? a : b)
HALVED(most, 4, 2, a > b ? a : b)
HALVED(most, 8, 4, a > b ? a : b)
HALVED(most, 16, 8, a > b ? a : b)
HALVED(total, 4, 2, a + b)
HALVED(total, 8, 4, a + b)
HALVED(total, 16, 8, a + b)

#if defined(__AVX512F__) && LANES == 16 && !DOUBLE && \
    __has_builtin(__builtin_ia32_rsqrt14ps512_mask)
// 1 / sqrt(a): AVX-512's estimate (14 bits) with a step of Newton's, off by 2 units in the last place.
static reals inverse_sqrt(reals a) {
    reals r = __builtin_ia32_rsqrt14ps512_mask(a, (reals)(0), (ushort)-1);
    return r * (1.5f - (0.5f * a * r) * r);
}
#else
// 1 / sqrt(a), off by 1 unit in the last place, and by far the slowest operation of the kernel.
static reals inverse_sqrt(reals a) { return 1 / sqrt(a); }
#endif

// A vector of each lane, in whichever space.
typedef struct {
    reals x, y, z;
} Vector;

// A vector of its coordinates.
static Vector vector(reals x, reals y, reals z) {
    Vector v = {x, y, z};
    return v;
}

// One vector, the same in all lanes.
static Vector splat(__global const real *v) {
    return vector((reals)(v[0]), (reals)(v[1]), (reals)(v[2]));
}

// The product of two vectors, their sum, difference, and one of them s times as long.
static reals dot3(Vector a, Vector b) { return a.x * b.x + (a.y * b.y + a.z * b.z); }
static Vector plus(Vector a, Vector b) { return vector(a.x + b.x, a.y + b.y, a.z + b.z); }
static Vector minus(Vector a, Vector b) { return vector(a.x - b.x, a.y - b.y, a.z - b.z); }
static Vector scaled(Vector a, reals s) { return vector(a.x * s, a.y * s, a.z * s); }

// The product of two vectors that all lanes have in common.
static real dot_real(__global const real *a, __global const real *b) {
    return a[0] * b[0] + (a[1] * b[1] + a[2] * b[2]);
}

// a + s b
static Vector along(Vector a, reals s, Vector b) {
    return vector(s * b.x + a.x, s * b.y + a.y, s * b.z + a.z);
}

// A zero vector becomes NaN, which every later comparison rules out.
static Vector unit(Vector a) { return scaled(a, inverse_sqrt(dot3(a, a))); }

// The products of their coordinates, the lower and the higher of each.
static Vector times(Vector a, Vector b) { return vector(a.x * b.x, a.y * b.y, a.z * b.z); }
static Vector lower3(Vector a, Vector b) {
    return vector(PICK(a.x < b.x, a.x, b.x), PICK(a.y < b.y, a.y, b.y), PICK(a.z < b.z, a.z, b.z));
}
static Vector higher3(Vector a, Vector b) {
    return vector(larger(a.x, b.x), larger(a.y, b.y), larger(a.z, b.z));
}

// PICK for vectors.
static Vector pick3(ints mask, Vector yes, Vector no) {
    return vector(PICK(mask, yes.x, no.x), PICK(mask, yes.y, no.y), PICK(mask, yes.z, no.z));
}

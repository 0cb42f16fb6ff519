// Lanes: one work-item traces LANES neighbouring pixels of a row in lock step, a packet.
//
// The source is written once, for LANES = 1 (scalars: one work-item a pixel, what a GPU wants) and
// for LANES = 2, 4, 8, 16 (OpenCL vectors, which PoCL turns into SIMD code). This file hides the
// difference. The host defines LANES, and DOUBLE if a number is to be a float64.
//
//   real    one number                   float            (DOUBLE: double)
//   reals   one number a lane            float, float16   (DOUBLE: double, double16)
//   ints    one integer or mask a lane   int, int16       (DOUBLE: int, long16)
//
// A mask is what a comparison gives: false is 0; true is 1 in a scalar and -1 in a vector. So masks
// are only joined by &, | and !, and read by PICK and ANY. Never multiply by one: the lanes that a
// mask rules out may hold NaN, and 0 * NaN is NaN.

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#ifndef __has_builtin
#define __has_builtin(name) 0
#endif

#ifdef DOUBLE
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef double real;
#define REAL(literal) literal
#else
typedef float real;
#define REAL(literal) JOIN(literal, f)
#endif

#if LANES == 1
typedef real reals;
typedef int ints;
#define LANE ((ints)(0))
#define TO_REALS(n) ((reals)(n))
#define ANY(mask) (mask)
#define LEAST(n) (n)
#define STORE(v, to) (*(to) = (v))
#else
#ifdef DOUBLE
typedef JOIN(double, LANES) reals;
typedef JOIN(long, LANES) ints;
#define TO_REALS(n) JOIN(convert_double, LANES)(n)
#else
typedef JOIN(float, LANES) reals;
typedef JOIN(int, LANES) ints;
#define TO_REALS(n) JOIN(convert_float, LANES)(n)
#endif
#if LANES == 2
#define LANE ((ints)(0, 1))
#elif LANES == 4
#define LANE ((ints)(0, 1, 2, 3))
#elif LANES == 8
#define LANE ((ints)(0, 1, 2, 3, 4, 5, 6, 7))
#else
#define LANE ((ints)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15))
#endif
#define STORE(v, to) JOIN(vstore, LANES)(v, 0, to)
#if __has_builtin(__builtin_reduce_or) && __has_builtin(__builtin_reduce_min)
// PoCL's any() is a call that spills every vector register; these become a few instructions.
#define ANY(mask) (__builtin_reduce_or(mask) != 0)
#define LEAST(n) ((int)__builtin_reduce_min(n))
#else
#define ANY(mask) any(mask)
static int least(ints n) {
    __private int each[LANES];
    STORE(JOIN(convert_int, LANES)(n), each);
    int found = each[0];
    for (int i = 1; i < LANES; i++) found = min(found, each[i]);
    return found;
}
#define LEAST(n) least(n)
#endif
#endif

// `?:` compiles to better code than select() on PoCL, and means the same for scalars and vectors.
#define PICK(mask, yes, no) ((mask) ? (reals)(yes) : (reals)(no))
#define PICK_INT(mask, yes, no) ((mask) ? (ints)(yes) : (ints)(no))

typedef struct {
    reals x, y, z;
} Vector;

static Vector vector(reals x, reals y, reals z) {
    Vector v = {x, y, z};
    return v;
}

static Vector splat(__global const real *v) {
    return vector((reals)(v[0]), (reals)(v[1]), (reals)(v[2]));
}

static reals dot3(Vector a, Vector b) { return a.x * b.x + (a.y * b.y + a.z * b.z); }

static Vector plus(Vector a, Vector b) { return vector(a.x + b.x, a.y + b.y, a.z + b.z); }

static Vector minus(Vector a, Vector b) { return vector(a.x - b.x, a.y - b.y, a.z - b.z); }

static Vector scaled(Vector a, reals s) { return vector(a.x * s, a.y * s, a.z * s); }

// a + s b
static Vector along(Vector a, reals s, Vector b) {
    return vector(s * b.x + a.x, s * b.y + a.y, s * b.z + a.z);
}

// The square root and the divide are correctly rounded on PoCL: 1 ulp together. A zero vector
// becomes NaN, which every later comparison rules out.
static Vector unit(Vector a) { return scaled(a, 1 / sqrt(dot3(a, a))); }

static Vector pick3(ints mask, Vector yes, Vector no) {
    return vector(PICK(mask, yes.x, no.x), PICK(mask, yes.y, no.y), PICK(mask, yes.z, no.z));
}

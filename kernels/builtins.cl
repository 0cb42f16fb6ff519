// Builtins: OpenCL's functions that the kernels call.
//
// PoCL 3.0 reads OpenCL's own header before each program, which declares some 15,000 functions and
// takes a tenth of a second. These take a hundredth of that. clrt/opencl/program.py puts this file
// in the place of that header there, and nowhere else.

#define FUNCTION __attribute__((overloadable, const))
#define ACCESS __attribute__((overloadable))
#define FOR_WIDTHS(WHAT, T) WHAT(T) WHAT(T##2) WHAT(T##4) WHAT(T##8) WHAT(T##16)

#define OF_REALS(T)          \
    T FUNCTION sqrt(T);      \
    T FUNCTION fabs(T);      \
    T FUNCTION fma(T, T, T); \
    T FUNCTION fmax(T, T);   \
    T FUNCTION fmin(T, T);   \
    T FUNCTION max(T, T);    \
    T FUNCTION min(T, T);    \
    T FUNCTION sin(T);       \
    T FUNCTION cos(T);       \
    T FUNCTION atan2(T, T);  \
    T FUNCTION exp(T);       \
    T FUNCTION exp2(T);      \
    T FUNCTION log(T);       \
    T FUNCTION log1p(T);     \
    T FUNCTION log2(T);      \
    T FUNCTION pow(T, T);    \
    T FUNCTION round(T);
FOR_WIDTHS(OF_REALS, float)
FOR_WIDTHS(OF_REALS, double)

#define OF_INTS(T)        \
    T FUNCTION min(T, T); \
    T FUNCTION max(T, T); \
    T FUNCTION popcount(T);
FOR_WIDTHS(OF_INTS, int)
FOR_WIDTHS(OF_INTS, uint)
FOR_WIDTHS(OF_INTS, long)
FOR_WIDTHS(OF_INTS, ulong)

#define OF_MASKS(T) int FUNCTION any(T);
FOR_WIDTHS(OF_MASKS, int)
FOR_WIDTHS(OF_MASKS, long)

// select() and conversions take two types, of one width.
#define FOR_WIDTHS_OF_BOTH(WHAT, T, U) \
    WHAT(T, U) WHAT(T##2, U##2) WHAT(T##4, U##4) WHAT(T##8, U##8) WHAT(T##16, U##16)
#define SELECTED(T, MASK) T FUNCTION select(T, T, MASK);
FOR_WIDTHS_OF_BOTH(SELECTED, float, int)
FOR_WIDTHS_OF_BOTH(SELECTED, int, int)
FOR_WIDTHS_OF_BOTH(SELECTED, double, long)
FOR_WIDTHS_OF_BOTH(SELECTED, long, long)
#define CONVERTED(T, U) T FUNCTION convert_##T(U);
#define CONVERTED_FROM(U)                   \
    FOR_WIDTHS_OF_BOTH(CONVERTED, int, U)   \
    FOR_WIDTHS_OF_BOTH(CONVERTED, uint, U)  \
    FOR_WIDTHS_OF_BOTH(CONVERTED, long, U)  \
    FOR_WIDTHS_OF_BOTH(CONVERTED, ulong, U) \
    FOR_WIDTHS_OF_BOTH(CONVERTED, float, U) \
    FOR_WIDTHS_OF_BOTH(CONVERTED, double, U)
CONVERTED_FROM(int)
CONVERTED_FROM(uint)
CONVERTED_FROM(long)
CONVERTED_FROM(ulong)
CONVERTED_FROM(float)
CONVERTED_FROM(double)

#define LOADED(T, FROM) T##16 ACCESS vload16(size_t, const FROM *);
LOADED(uint, __global uint)
LOADED(float, __global float)
LOADED(double, __global double)

size_t FUNCTION get_global_id(uint);
size_t FUNCTION get_global_size(uint);
int ACCESS atomic_inc(volatile __global int *);
int ACCESS atomic_add(volatile __global int *, int);
uint ACCESS atomic_or(volatile __global uint *, uint);

// Film: pixels as they leave the kernel, rows of interleaved RGB.
//
// The host defines FILM_BYTES for 8-bit pixels; else they are float32, linear and not clipped.

#ifdef FILM_BYTES
typedef uchar channel;
// round(255 clip(c)), ties to even: adding 1.5 * 2^23 leaves the rounded integer in the low bits.
static void develop(reals c, channel *to) {
    __private float each[LANES];
    __private real exact[LANES];
    c = PICK(c > 0, c, 0);
    c = PICK(c < 1, c, 1);
    STORE(c, exact);
    for (int i = 0; i < LANES; i++) each[i] = (float)exact[i] * 255.0f + 12582912.0f;
    for (int i = 0; i < LANES; i++) to[i] = (channel)as_uint(each[i]);
}
#else
typedef float channel;
static void develop(reals c, channel *to) {
    __private real exact[LANES];
    STORE(c, exact);
    for (int i = 0; i < LANES; i++) to[i] = (channel)exact[i];
}
#endif

// Stores the first `count` lanes. The loops of constant length become a few shuffles.
static void expose(Vector color, __global channel *pixels, int count) {
    __private channel r[LANES], g[LANES], b[LANES];
    develop(color.x, r);
    develop(color.y, g);
    develop(color.z, b);
    if (count >= LANES)
        for (int i = 0; i < LANES; i++) {
            pixels[3 * i] = r[i];
            pixels[3 * i + 1] = g[i];
            pixels[3 * i + 2] = b[i];
        }
    else
        for (int i = 0; i < count; i++) {
            pixels[3 * i] = r[i];
            pixels[3 * i + 1] = g[i];
            pixels[3 * i + 2] = b[i];
        }
}

// Angles: sines, cosines and back.

#define HALF_PI REAL(1.5707963267948966)
#define PI REAL(3.141592653589793)

#if DOUBLE
// Of an angle in radians.
static void sine_cosine(reals angle, reals *sine, reals *cosine) {
    *sine = sin(angle);
    *cosine = cos(angle);
}
// The angle of a sine and a cosine in this ratio, in radians.
static reals angle_of(reals sine, reals cosine) { return atan2(sine, cosine); }
#else
// Of an angle up to 90 degrees either way: off by 1e-7 (tests/test_round.py), as is angle_of(). The
// polynomials are minimax fits. PoCL's own take several times as long.
static void sine_cosine(reals angle, reals *sine, reals *cosine) {
    reals a = angle * angle;
    *sine =
        angle *
        (1 + a * (-0.16666658f + a * (0.00833305f + a * (-0.00019809075f + a * 2.6052248e-06f))));
    *cosine =
        1 + a * (-0.5f + a * (0.041666638f +
                              a * (-0.0013888362f + a * (2.4760162e-05f + a * -2.605149e-07f))));
}

// The angle from 0 to 90 degrees that has a sine and a cosine in this ratio.
static reals angle_of(reals sine, reals cosine) {
    ints steep = sine > cosine;
    reals small = PICK(steep, cosine, sine), large = PICK(steep, sine, cosine);
    reals t = small / PICK(large > 0, large, 1), u = t * t;
    reals angle =
        t *
        (1 +
         u * (-0.33333093f +
              u * (0.19993055f +
                   u * (-0.14207134f +
                        u * (0.10654679f +
                             u * (-0.07533678f + u * (0.043039385f + u * (-0.016283017f +
                                                                          u * 0.0029035539f))))))));
    return PICK(steep, 1.57079637f - angle, angle);
}
#endif

// The square root, 0 of what rounding has made negative.
static reals root(reals a) { return sqrt(PICK(a > 0, a, 0)); }

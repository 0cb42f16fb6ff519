// Shading: the Blinn-Phong terms (paper, section 11.8).

// 44 bytes as float32, 88 as float64. Linear RGB.
typedef struct {
    real ambient[3];
    real diffuse[3];
    real specular[3];
    real exponent;    // shininess / 4
    real reflection;  // in [0, 1]
} Material;

// 48 bytes as float32, 96 as float64. A point light.
typedef struct {
    real position[3];  // camera space
    real ambient[3];   // linear RGB
    real diffuse[3];
    real specular[3];
} Light;

// max(N.H, 0)^exponent of unit N and H. The rounding of N.H, not pow, spoils large exponents: at
// 25 / 2500 / 250000 pow(N.H) is off by 3e-6 / 3e-4 / 4e-2. |N - H|^2 / 2 = 1 - N.H keeps the digits
// that matter near the highlight: 2e-7 / 2e-6 / 3e-5. Where H is undefined (L = -V) the comparison
// with NaN fails and N.H counts as 0.
static reals highlight(Vector normal, Vector half_way, reals exponent) {
    Vector apart = minus(normal, half_way);
    reals q = REAL(0.5) * dot3(apart, apart);
    return PICK(q < 1, exp(exponent * log1p(-q)), PICK(exponent == 0, 1, 0));
}

static reals blinn_phong(__global const Material *material, __global const Light *light, int rgb,
                         reals diffuse, reals specular) {
    return material->ambient[rgb] * light->ambient[rgb] +
           material->diffuse[rgb] * light->diffuse[rgb] * diffuse +
           material->specular[rgb] * light->specular[rgb] * specular;
}

// Shading: what a surface is like at a hit, and the Blinn-Phong terms (paper, section 11.8).
//
// Attenuation is the paper's section 2, a spot its section 3.

// 36 bytes as float32, 72 as float64.
typedef struct {
    real exponent;      // of (N.H)^2: shininess / 8; of Phong's (R.V)^2: -shininess / 2
    real reflection;    // in [0, 1]
    real transmission;  // in [0, 1]; 0: opaque
    real ior;           // index of refraction
    real fresnel;       // 1: a part of what goes through is mirrored
    real spread;        // of mirrored rays: 1 - cosine of the largest angle that they are off by
    real diffuse[3];    // linear RGB
} Material;

// 52 bytes as float32, 104 as float64. A point light, in the spheres' space. A directional one is a
// point at 2^40 times the extent.
typedef struct {
    real position[3];
    real fade[3], strength;  // of its light strength / (fade[0] + fade[1] D + fade[2] D^2) is left
    real axis[3];            // the way that its middle shines, of unit length
    real edge[2];            // see cone()
    real radius;             // 0: a point
} Light;

// 36 bytes as float32, 72 as float64. What a material makes of a light, linear RGB: the products of
// their colours. One of each pair, index light * materials + material.
typedef struct {
    real ambient[3];
    real diffuse[3];
    real specular[3];
} Shade;

// What the packet's rays have hit, each lane its own.
typedef struct {
    Vector normal;  // unit length, outwards
    reals horizon;  // as in Sphere
    reals exponent, reflection;
    reals transmission, ior, fresnel;  // NEST
    ints order;                        // NEST: as in Glass
    reals spread;                      // GLOSS
    Vector diffuse;                    // INDIRECT or FILM_GUIDES
} Surface;

// The surface of a sphere of the list at the points of all lanes. glass: NEST, the sphere's.
static Surface surface_at(Vector point, __global const Sphere *sphere,
                          __global const Material *materials, __global const Glass *glass) {
    __global const Material *material = materials + sphere->material;
    // Not point - centre: that of a giant is far, its anchor is near. The length is off by what the
    // point is, 2^-24 |point| / radius, as is the direction.
    Vector from_center = plus(minus(point, splat(sphere->anchor)), splat(sphere->offset));
    Surface surface = {scaled(from_center, sphere->inv_radius), sphere->horizon, material->exponent,
                       material->reflection};
    if (NEST) {
        surface.transmission = material->transmission;
        surface.ior = material->ior;
        surface.fresnel = material->fresnel;
        surface.order = glass->order;
    }
    if (GLOSS) surface.spread = material->spread;
    if (INDIRECT || FILM_GUIDES) surface.diffuse = splat(material->diffuse);
    return surface;
}

// PICK for surfaces.
static Surface pick_surface(ints mask, Surface yes, Surface no) {
    Surface surface = {pick3(mask, yes.normal, no.normal), PICK(mask, yes.horizon, no.horizon),
                       PICK(mask, yes.exponent, no.exponent),
                       PICK(mask, yes.reflection, no.reflection)};
    surface.transmission = PICK(mask, yes.transmission, no.transmission);
    surface.ior = PICK(mask, yes.ior, no.ior);
    surface.fresnel = PICK(mask, yes.fresnel, no.fresnel);
    surface.order = PICK_INT(mask, yes.order, no.order);
    surface.spread = PICK(mask, yes.spread, no.spread);
    surface.diffuse = pick3(mask, yes.diffuse, no.diffuse);
    return surface;
}

#if DOUBLE
// (cosine^2)^exponent. Near 1 it is sine^2 that has the digits.
static reals power(reals cosine2, reals sine2, reals exponent) {
    reals log_cosine2 = PICK(sine2 < 0.5, log1p(-sine2), log(cosine2));
    return exp(exponent * log_cosine2);
}
#else
// (cosine^2)^exponent, as 2^(exponent log2(cosine2)), off by at most 2.5e-7 (tests/test_shading.py). The polynomials are
// minimax fits, off by 2^-25 of log2 and 2^-26 of 2^g with coefficients rounded to float32. PoCL's
// own exp and log1p take thrice as long.
static reals power(reals cosine2, reals sine2, reals exponent) {
    // cosine2 = (1 + f) 2^k with 1 + f in [2/3, 4/3)
    ints bits = AS_INTS(cosine2);
    ints k = (bits - AS_INTS((reals)(2.0f / 3))) >> 23;
    reals f = PICK(k == 0, -sine2, AS_REALS(bits - (k << 23)) - 1);
    reals f2 = f * f, f4 = f2 * f2;
    reals log2_per_f = (1.4426950216f - 0.7213465571f * f) +
                       f2 * (0.4808959663f - 0.3607895672f * f) +
                       f4 * ((0.2887113392f - 0.2367864996f * f) +
                             f2 * (0.2017991394f - 0.2222212703f * f) + f4 * 0.2027868629f);
    reals y = exponent * (TO_REALS(k) + f * log2_per_f);
    y = PICK(y > -126, y, -126);  // below is 0 anyway
    // Adding 1.5 * 2^23 rounds y to an integer, in the low bits.
    reals n = y + 12582912.0f;
    reals g = y - (n - 12582912.0f);
    reals g2 = g * g;
    reals exp2_g = (1.0f + 0.6931471825f * g) +
                   g2 * ((0.2402264625f + 0.0555032864f * g) +
                         g2 * ((0.0096184891f + 0.0013399931f * g) + g2 * 0.0001534581f));
    return AS_REALS(AS_INTS(exp2_g) + (AS_INTS(n) << 23));
}
#endif

// max(N.H, 0)^(2 exponent) with H = h / |h|. The rounding of N.H would spoil large ones: at
// 25 / 2500 / 250000 pow(N.H) is off by 3e-6 / 3e-4 / 4e-2. The part of h at right angles to N
// gives the sine of their angle, with which it is 2e-7 / 2e-6 / 3e-5. If h = 0, H is undefined and
// N.H counts as 0.
static reals highlight(Vector normal, Vector h, reals exponent) {
    reals along_normal = dot3(normal, h);
    reals inv_length = inverse_sqrt(dot3(h, h));
    reals cosine = along_normal * inv_length;
    reals value;
    if (LITERAL) {
        value = pow(cosine, 2 * exponent);
    } else {
        Vector aside = along(h, -along_normal, normal);
        reals sine2 = dot3(aside, aside) * (inv_length * inv_length);
        value = power(cosine * cosine, sine2, exponent);
    }
    return PICK(cosine > 0, value, PICK(exponent == 0, 1, 0));
}

// NEST or OPACITY: the part of a light that a veil leaves.
static reals unveiled(ints veil) {
    if (!ANY(veil != 0)) return 1;
    return PICK(veil < OPAQUE, exp2(TO_REALS(veil) * (-1 / VEIL)), 0);
}

// ATTENUATION: the part of a light that is left at a distance in the spheres' unit, at most 2^50.
static reals faded(__global const Light *light, reals distance) {
    reals weaker = light->fade[0] + distance * (light->fade[1] + distance * light->fade[2]);
    reals left = light->strength / weaker;
    return PICK(left < REAL(1125899906842624.0), left, REAL(1125899906842624.0));
}

// SPOT: the part of a light that its cone leaves: 1 up to the inner angle, 0 from the outer one, between
// them t^2 (3 - 2 t), with t linear in the cosine of the angle a from the axis. That is also linear in
// h = |L + axis|^2 = 4 sin^2(a / 2), which keeps its digits where 1 - cos(a) has lost them: a cone of
// 0.04 degrees is within 1/1020 in float32 (spot-0.01-0.04 of tests/hard_cases.py).
static reals cone(__global const Light *light, Vector to_light) {
    Vector off = plus(to_light, splat(light->axis));
    reals t = light->edge[0] - light->edge[1] * dot3(off, off);
    t = PICK(t > 0, t, 0);
    t = PICK(t < 1, t, 1);
    return t * t * (3 - 2 * t);
}

// The light that a shade sends to the camera, linear RGB: diffuse and specular are its two cosine terms.
// own: SPHERE_COLORS, the sphere's own colour, which multiplies its ambient and diffuse light.
static Vector blinn_phong(__global const Shade *shade, reals diffuse, reals specular, Vector own) {
    Vector term = along(splat(shade->ambient), diffuse, splat(shade->diffuse));
    if (SPHERE_COLORS) term = times(term, own);
    return along(term, specular, splat(shade->specular));
}

// SPHERE_COLORS and TREE: the colour of each lane's sphere, linear RGB.
static Vector colors_of(__global const real *colors, ints spheres) {
    __private const INTEGER *sphere = EACH_INT(spheres);
    __private reals found[3];
    __private real *each = EACH_REAL(found);
    for (int i = 0; i < LANES; i++) {
        __global const real *color = colors + 3 * (size_t)(sphere[i] < 0 ? 0 : sphere[i]);
        each[i] = color[0], each[LANES + i] = color[1], each[2 * LANES + i] = color[2];
    }
    return vector(found[0], found[1], found[2]);
}

// SPHERE_COLORS: the colour of one sphere, linear RGB.
static Vector color_of(__global const real *colors, int sphere) {
    return splat(colors + 3 * (size_t)sphere);
}

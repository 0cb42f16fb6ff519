// A yardstick: what a machine's cores can do for the picture of scenes/four-spheres.toml, 3840x2160
// pixels of 8-bit RGB, by hand in AVX-512 intrinsics and OpenMP.
//   cc -O3 -march=native -ffast-math -fopenmp yardstick.c -o yardstick -lm
//   ./yardstick 21          prints the median time of 21 frames
//   ./yardstick 1 out.ppm   writes the picture as well
// The paper's formula (Blinn-Phong, hard shadows, mirrors) in float32, with no more care than this
// scene and eight bits need: one white light, the light and the camera outside of all spheres,
// spheres apart from each other, a camera that looks along -z. What the spheres are is run-time data.
// Sixteen neighbouring pixels of a row, a packet, are traced in lock step, one in each lane.

#include <immintrin.h>
#include <math.h>
#include <omp.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 3840, HEIGHT = 2160, MAX_DEPTH = 3, MOST_SPHERES = 16 };
#define BIAS 1e-5

typedef __m512 Lanes;    // +, - and * work lane by lane
typedef __mmask16 Mask;  // a bit for each lane
typedef struct {
    Lanes x, y, z;
} Vector;
typedef struct {
    Mask met;        // the lanes whose ray meets a sphere
    Lanes distance;  // in units of the ray's direction
    __m512i sphere;  // which one
    int same;        // that of all of them; -1 if they differ
} Hit;
typedef struct {
    double center[3], radius, ambient[3], diffuse[3], specular[3], shininess, reflection;
} Sphere;

static const double eye[3] = {0, 0, 1}, light[3] = {5, 5, 5};
static const Sphere spheres[] = {
    {{-0.2, 0, -1}, 0.7, {0.1, 0, 0}, {0.7, 0, 0}, {1, 1, 1}, 100, 0.5},
    {{0.1, -0.3, 0}, 0.1, {0.1, 0, 0.1}, {0.7, 0, 0}, {1, 1, 1}, 100, 0.5},
    {{-0.3, 0, 0}, 0.15, {0, 0.1, 0}, {0, 0.6, 0}, {1, 1, 1}, 100, 0.5},
    {{0, -9000, 0}, 8999.3, {0.1, 0.1, 0.1}, {0.6, 0.6, 0.6}, {1, 1, 1}, 100, 0.5},
};
static int sphere_count;  // set at run time: loops over a constant number would be unrolled

// What packets need of the spheres: for each kind of number a row, which fits a register, so that
// each lane can pick that of the sphere it has hit.
typedef float Row[MOST_SPHERES] __attribute__((aligned(64)));
static Row center[3], inverse_radius, ambient[3], diffuse[3], specular[3], exponent, reflection;
static Row from_eye[3], from_light[3];  // to the center
// |point - center|^2 - radius^2, what is called the point's power.
static Row eye_power, light_power, origin_power;
static Row horizon;  // the least cosine to the normal at which light reaches a lifted point

static void fill_rows(void) {
    sphere_count = sizeof spheres / sizeof *spheres;
    for (int s = 0; s < sphere_count; s++) {
        const Sphere *given = &spheres[s];
        double r = given->radius, eye2 = 0, light2 = 0, origin2 = 0;
        for (int k = 0; k < 3; k++) {
            double c = given->center[k], e = c - eye[k], l = c - light[k];
            center[k][s] = c, from_eye[k][s] = e, from_light[k][s] = l;
            origin2 += c * c, eye2 += e * e, light2 += l * l;
            ambient[k][s] = given->ambient[k], diffuse[k][s] = given->diffuse[k];
            specular[k][s] = given->specular[k];
        }
        origin_power[s] = origin2 - r * r, eye_power[s] = eye2 - r * r;
        light_power[s] = light2 - r * r;
        inverse_radius[s] = 1 / r, exponent[s] = given->shininess / 4;
        reflection[s] = given->reflection;
        horizon[s] = -sqrt(BIAS * (2 * r + BIAS)) / (r + BIAS);
    }
}

static inline Lanes all(float a) { return _mm512_set1_ps(a); }
static inline Mask less(Mask in, Lanes a, Lanes b) {
    return _mm512_mask_cmp_ps_mask(in, a, b, _CMP_LT_OQ);
}

static inline Lanes dot(Vector a, Vector b) { return a.x * b.x + (a.y * b.y + a.z * b.z); }
static inline Vector scaled(Vector a, Lanes s) { return (Vector){a.x * s, a.y * s, a.z * s}; }
static inline Vector along(Vector a, Lanes s, Vector b) {  // a + s b
    return (Vector){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

static inline Vector triple(const Row rows[3], int s) {
    return (Vector){all(rows[0][s]), all(rows[1][s]), all(rows[2][s])};
}

// The processor's estimate has 14 bits; a step of Newton's makes it 23.
static inline Lanes inverse_sqrt(Lanes a) {
    Lanes r = _mm512_rsqrt14_ps(a);
    return r * (all(1.5f) - all(0.5f) * a * r * r);
}

// a^e = 2^(e log2 a), 0 < a <= 1. The polynomials are off by 1.3e-5 (log2, of a number from 1 to 2)
// and by 7.5e-5 of the value (2^x, x from 0 to 1).
static inline Lanes power(Lanes a, Lanes e) {
    Lanes m = _mm512_getmant_ps(a, _MM_MANT_NORM_1_2, _MM_MANT_SIGN_zero);
    Lanes log2 = all(0.04487361f) * m - all(0.41656373f);
    log2 = (log2 * m + all(1.63114892f)) * m - all(3.55079319f);
    log2 = (log2 * m + all(5.09171103f)) * m - all(2.8003641f);
    Lanes x = e * (_mm512_getexp_ps(a) + log2);
    Lanes rest = _mm512_reduce_ps(x, _MM_FROUND_TO_NEG_INF);  // x - floor(x)
    Lanes exp2 = (all(0.07802452f) * rest + all(0.22606716f)) * rest + all(0.69583354f);
    return _mm512_scalef_ps(exp2 * rest + all(0.99992522f), x);  // times 2^floor(x)
}

static inline Lanes pick(const Row row, Hit hit) {
    if (hit.same >= 0) return all(row[hit.same]);
    return _mm512_permutexvar_ps(hit.sphere, _mm512_load_ps(row));
}

// Lanes that did not hit sphere s. Spheres are convex: a ray that leaves s does not meet it again.
static inline Mask not_on(Hit hit, int s, Mask in) {
    if (hit.same >= 0) return in;  // the loops pass over that one
    return _mm512_mask_cmpneq_epi32_mask(in, hit.sphere, _mm512_set1_epi32(s));
}

// A ray meets a sphere at the smaller root of a t^2 - 2 b t + c: a = |way|^2, b = way . (from start
// to center), c is the start's power. What it meets lies ahead, b > 0. `same` is the last one met.
static inline void meet(Hit *hit, Mask in, Lanes a, Lanes b, Lanes c, int s) {
    Lanes delta = b * b - a * c;
    in = less(less(in, all(0), delta), all(0), b);
    if (!in) return;
    Lanes distance = c / (b + delta * inverse_sqrt(delta));
    in = less(in, distance, hit->distance);
    hit->distance = _mm512_mask_mov_ps(hit->distance, in, distance);
    hit->sphere = _mm512_mask_mov_epi32(hit->sphere, in, _mm512_set1_epi32(s));
    hit->met |= in;
    if (in) hit->same = s;
}

// The lanes of `in` that the light reaches. Rays run from the light, whose power is known, to the
// points; as it is outside, a sphere is in between where the foot of its center on the ray is.
static inline Mask lit(Mask in, Vector ray, Lanes ray2, Hit on) {
    for (int s = 0; s < sphere_count; s++) {
        if (s == on.same) continue;
        Lanes b = dot(ray, triple(from_light, s));
        Mask dark = less(in, all(0), b * b - ray2 * all(light_power[s]));
        dark = less(less(dark, all(0), b), b, ray2);
        if (dark) in &= ~not_on(on, s, dark);
    }
    return in;
}

// The colours of a packet, seen through (x, y, 0). shown: the spheres that may be met there.
static inline void trace(Lanes color[3], Lanes x, Lanes y, const int *shown, int shown_count) {
    const Hit nothing = {0, all(1e30f), _mm512_setzero_si512(), 0};
    const Vector camera = {all(eye[0]), all(eye[1]), all(eye[2])};
    Vector way = {x, y, all(-1)};
    color[0] = color[1] = color[2] = all(0);
    Lanes weight = all(1), way2 = dot(way, way);
    Hit hit = nothing;
    for (int k = 0; k < shown_count; k++) {
        int s = shown[k];
        Lanes b = x * all(from_eye[0][s]) + (y * all(from_eye[1][s]) - all(from_eye[2][s]));
        meet(&hit, 0xffff, way2, b, all(eye_power[s]), s);
    }
    Vector point = along(camera, hit.distance, way);
    way = scaled(way, inverse_sqrt(way2));
    Vector to_eye = scaled(way, all(-1));

    for (int depth = 1; hit.met; depth++) {
        __m512i same = _mm512_set1_epi32(hit.same);
        if (_mm512_mask_cmpneq_epi32_mask(hit.met, hit.sphere, same)) hit.same = -1;
        Vector middle = {pick(center[0], hit), pick(center[1], hit), pick(center[2], hit)};
        Vector normal = scaled(along(point, all(-1), middle), pick(inverse_radius, hit));
        Vector start = along(point, all(BIAS), normal);

        Vector ray = {start.x - all(light[0]), start.y - all(light[1]), start.z - all(light[2])};
        Lanes ray2 = dot(ray, ray);
        Vector to_light = scaled(ray, all(0) - inverse_sqrt(ray2));
        Lanes n_l = dot(normal, to_light), n_v = dot(normal, to_eye);
        Mask on = lit(less(hit.met, pick(horizon, hit), n_l), ray, ray2, hit);
        if (!on) break;

        // The cosine of the normal and the half-way vector H: |L + V|^2 = 2 + 2 L.V.
        Lanes n_h = (n_l + n_v) * inverse_sqrt(all(2) + all(2) * dot(to_light, to_eye));
        Lanes gloss = power(_mm512_max_ps(n_h, all(1e-6f)), pick(exponent, hit));
        for (int k = 0; k < 3; k++) {
            Lanes answer = pick(ambient[k], hit) + n_l * pick(diffuse[k], hit);
            answer += gloss * pick(specular[k], hit);
            color[k] = _mm512_mask3_fmadd_ps(weight, answer, color[k], on);
        }
        if (depth == MAX_DEPTH) break;

        weight *= pick(reflection, hit);
        way = along(way, all(-2) * dot(way, normal), normal);
        Lanes start2 = dot(start, start), start_way = dot(start, way);
        Hit next = nothing;
        for (int s = 0; s < sphere_count; s++) {
            if (s == hit.same) continue;
            Vector c = triple(center, s);
            Lanes start_power = start2 - all(2) * dot(start, c) + all(origin_power[s]);
            meet(&next, not_on(hit, s, on), all(1), dot(way, c) - start_way, start_power, s);
        }
        hit = next;
        point = along(start, hit.distance, way);
        to_eye = along(camera, all(-1), point);
        to_eye = scaled(to_eye, inverse_sqrt(dot(to_eye, to_eye)));
    }
}

// Rounds, clips and writes 48 bytes.
static inline void store(uint8_t *pixels, const Lanes color[3]) {
    __m512i r = _mm512_cvtps_epi32(color[0] * all(255));
    __m512i g = _mm512_cvtps_epi32(color[1] * all(255));
    __m512i b = _mm512_cvtps_epi32(color[2] * all(255));
    // Each quarter of the register becomes rrrrggggbbbb...., then rgbrgbrgbrgb....; they close up.
    __m512i bytes = _mm512_packus_epi16(_mm512_packs_epi32(r, g), _mm512_packs_epi32(b, b));
    const __m128i order = _mm_setr_epi8(0, 4, 8, 1, 5, 9, 2, 6, 10, 3, 7, 11, -1, -1, -1, -1);
    bytes = _mm512_shuffle_epi8(bytes, _mm512_broadcast_i32x4(order));
    _mm512_mask_storeu_epi32(pixels, 0x0fff, _mm512_maskz_compress_epi32(0x7777, bytes));
}

static void render(uint8_t *film) {
    const Lanes lane = _mm512_setr_ps(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
#pragma omp parallel for schedule(dynamic, 8)
    for (int row = 0; row < HEIGHT; row++) {
        double y = (double)HEIGHT / WIDTH * (1 - 2.0 * row / (HEIGHT - 1));
        int shown[MOST_SPHERES], shown_count = 0;
        for (int s = 0; s < sphere_count; s++)  // those that the plane of the row's rays cuts
            if (fabs(from_eye[1][s] + y * from_eye[2][s]) < spheres[s].radius * sqrt(1 + y * y))
                shown[shown_count++] = s;
        for (int column = 0; column < WIDTH; column += 16) {
            Lanes x = (all(column) + lane) * all(2.0 / (WIDTH - 1)) - all(1);
            Lanes color[3];
            trace(color, x, all(y), shown, shown_count);
            store(film + 3 * ((size_t)row * WIDTH + column), color);
        }
    }
}

static int ascending(const void *a, const void *b) {
    return *(const double *)a < *(const double *)b ? -1 : 1;
}

int main(int argc, char **argv) {
    static uint8_t film[3 * WIDTH * HEIGHT];
    static double took[999];
    int frames = argc > 1 ? atoi(argv[1]) : 21;
    if (frames < 1 || frames > 999) return fputs("frames: from 1 to 999\n", stderr), 2;
    fill_rows();
    for (int k = -3; k < frames; k++) {  // three to warm up
        double started = omp_get_wtime();
        render(film);
        if (k >= 0) took[k] = omp_get_wtime() - started;
    }
    qsort(took, frames, sizeof *took, ascending);
    printf("med %.3f ms, min %.3f ms of %d frames\n", 1e3 * took[frames / 2], 1e3 * took[0],
           frames);
    if (argc < 3) return 0;
    FILE *file = fopen(argv[2], "wb");
    if (file == NULL) return perror(argv[2]), 1;
    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    fwrite(film, sizeof film, 1, file);
    return fclose(file) != 0;
}

// Round: lights that are balls, or discs in the sky, which spheres hide in part.
//
// From a point such a light fills a cap of the sphere of
// directions, and so does each sphere before it. The part of a cap that another one covers has a
// closed form, so no samples and no noise are needed. Of several spheres the parts are added: exact
// where their caps do not overlap inside of the light's, else too dark by what they share.

// A light as seen from a point: a cap around the direction `to`, with the half angle `angle`, below
// 90 degrees.
typedef struct {
    Vector to;  // unit length
    reals angle, sine, cosine;
    reals versine;   // 1 - cosine, which would lose its digits
    reals distance;  // of its middle
} Cap;

// ROUND: a ball of that radius in the direction `to`, so far away. From inside it fills half the sky.
static Cap cap_of(Vector to, reals distance, reals radius) {
    reals sine = radius / distance;
    Cap cap;
    cap.sine = PICK(sine < 1, sine, 1);
    cap.cosine = root((1 - cap.sine) * (1 + cap.sine));
    cap.angle = angle_of(cap.sine, cap.cosine);
    cap.versine = cap.sine * cap.sine / (1 + cap.cosine);
    cap.to = to;
    cap.distance = distance;
    return cap;
}

// ROUND: the part of a cap that another one covers, of half angle b up to 90 degrees and 1 - cos(b)
// `versine`, around a direction. Their middles and the two points where their edges meet make two
// spherical triangles with the sides a, b and g: twice the sectors of both caps less the triangles.
static reals part_covered(Cap cap, Vector to, reals b, reals versine) {
    Vector chord = minus(to, cap.to);
    reals half_chord = root(dot3(chord, chord)) / 2;
    reals a = cap.angle, g = 2 * angle_of(half_chord, root((1 - half_chord) * (1 + half_chord)));
    reals apart = a + b - g, first = b + g - a, second = a + g - b;
    reals s0, c0, s1, c1, s2, c2, s3, c3;  // of a quarter of the perimeter, and so on
    sine_cosine((a + b + g) / 4, &s0, &c0);
    sine_cosine(PICK(first > 0, first, 0) / 4, &s1, &c1);
    sine_cosine(PICK(second > 0, second, 0) / 4, &s2, &c2);
    sine_cosine(PICK(apart > 0, apart, 0) / 4, &s3, &c3);
    // Half angles at the middles of both caps, and the triangle's excess (L'Huilier).
    reals at_cap = 2 * angle_of(root(s1 * c1 * s3 * c3), root(s0 * c0 * s2 * c2));
    reals at_other = 2 * angle_of(root(s2 * c2 * s3 * c3), root(s0 * c0 * s1 * c1));
    reals excess = 4 * angle_of(root(s0 * s1 * s2 * s3), root(c0 * c1 * c2 * c3));
    reals area = at_cap * cap.versine + at_other * versine - excess;
    reals part = area / (PI * cap.versine);
    // One inside the other.
    part = PICK(second <= 0, 1, PICK(first <= 0, versine / cap.versine, part));
    part = PICK(apart > 0, part, 0);
    return PICK(part < 1, part, 1);
}

// What spheres cover of a light, in whole numbers of 1 / VEIL: so a sum is the same in any order.
typedef struct {
    ints hidden;  // the part that opaque spheres hide
    ints veil;    // VEILED: what others take of it, see veiled()
} Cover;

// ROUND: adds a sphere: f leads to its centre, c = |f|^2 - radius^2. Where `met` it can be in the way.
// It is before the light if along a direction that both have in common its chord is nearer. takes: its
// veil.
static Cover covered(Cover cover, Cap cap, ints met, Vector f, reals radius, reals c,
                     ints around_light, ints takes) {
    reals ahead = dot3(f, cap.to), tangent = root(c);
    // cos(g) > cos(a + b), with no division
    met &= (c > 0) & (ahead > cap.cosine * tangent - cap.sine * radius);
    if (!ANY(met)) return cover;
    reals distance = sqrt(c + radius * radius);
    Vector to = scaled(f, 1 / distance);
    reals b = angle_of(radius, tangent);
    reals versine = radius * radius / (distance * (distance + tangent));
    reals part = part_covered(cap, to, b, versine);
    // On the way from one middle to the other, the middle of what both cover.
    Vector chord = minus(to, cap.to);
    reals half_chord = root(dot3(chord, chord)) / 2;
    reals g = 2 * angle_of(half_chord, root((1 - half_chord) * (1 + half_chord)));
    reals from = larger(-cap.angle, g - b), until = PICK(g + b < cap.angle, g + b, cap.angle);
    reals s, near, t, far;
    sine_cosine((from + until) / 2, &s, &near);
    sine_cosine(g - (from + until) / 2, &t, &far);
    met &= around_light | (distance * far < cap.distance * near);
    part = PICK(met, part, 0);
    if (VEILED) {
        reals left = 1 - part * (1 - exp2(TO_REALS(takes) * (-1 / VEIL)));
        ints glass = takes < OPAQUE;
        cover.veil = veiled(cover.veil, met & glass, TO_INTS(log2(left) * -VEIL + REAL(0.5)));
        part = PICK(glass, 0, part);
    }
    ints hidden = cover.hidden + TO_INTS(part * VEIL + REAL(0.5));
    cover.hidden = PICK_INT(hidden < (INTEGER)VEIL, hidden, (INTEGER)VEIL);
    return cover;
}

// ROUND: the part of a light that nothing hides. above: the part above the horizon.
static reals visible_part(Cover cover, reals above) {
    reals part = above - TO_REALS(cover.hidden) * (1 / VEIL);
    return PICK(part > 0, part, 0);
}

// ROUND: the mean of max(N.L, 0) over a light, 0 behind the horizon: Snyder, Area Light Sources for Real-Time
// Graphics, 1996, for a ball that it cuts. cosine: of its middle.
static reals mean_cosine(Cap cap, reals cosine) {
    reals whole = cosine * (1 + cap.cosine) / 2;
    ints cut = (cosine < cap.sine) & (cosine > -cap.sine);
    if (!ANY(cut)) return PICK(cosine > 0, whole, 0);
    reals sine = root((1 - cosine) * (1 + cosine)), cotangent = cap.cosine / cap.sine;
    reals y = -cotangent * cosine / PICK(sine > 0, sine, 1);
    y = PICK(y < 1, y, 1);
    y = PICK(y > -1, y, -1);
    reals aside = root((1 - y) * (1 + y));
    reals angle = angle_of(aside, absolute(y));
    angle = PICK(y < 0, PI - angle, angle);
    reals flux = (cosine * angle - cotangent * sine * aside) * (cap.sine * cap.sine) +
                 angle_of(sine * aside, cotangent);
    flux /= 2 * PI * cap.versine;
    return PICK(cut, PICK(flux > 0, flux, 0), PICK(cosine > 0, whole, 0));
}

// ROUND: what the spheres of a list cover of a light. ray: from the point, its direction does not count; ids: their
// places in the scene's list, 0 if they are that list.
static Cover covered_by(Ray ray, Cap cap, ints on, __global const uchar *encloses,
                        __global const Sphere *spheres, __global const int *ids,
                        __global const Glass *glass, int sphere_count) {
    Cover cover = {0};
    for (int i = 0; i < sphere_count; i++) {
        __global const Sphere *sphere = spheres + i;
        int s = ids ? ids[i] : i;
        ints met = on & (ray.leaves != s);
        if (NEST) met &= !is_inside(ray, s);
        Vector g = minus(ray.origin, splat(sphere->anchor)), m = splat(sphere->offset);
        reals c = dot3(g, along(g, 2, m)) + sphere->c0;
        Vector f = scaled(plus(g, m), -1);
        cover = covered(cover, cap, met, f, 1 / sphere->inv_radius, c, -(ints)(encloses[i]),
                        VEILED ? glass[s].veil : 0);
    }
    return cover;
}

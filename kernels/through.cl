// Through: rays that go straight on through surfaces that can be seen through, in any number and any order.
//
// What a packet's rays see through comes before what is opaque: some lanes go on until each is at an opaque
// surface, or has met nothing, and the others wait there. So all turn at once, and the depth of a packet
// is one number. A ray goes on where it began, to what it meets behind the last surface, see behind() of
// sphere.cl: nothing is kept of what is before, however many surfaces that are.

// Below this weight a ray that has gone through something ends.
#define LEAST_WEIGHT REAL(0.0009765625)

// How a packet stands to what can be seen through.
typedef struct {
    ints goes;   // the lanes that have met it
    ints waits;  // those at opaque surfaces, while others go on
    reals part;  // of its light that a surface gives: its opacity
    Ray ray;     // as it came there
    Hit hit;
    reals weight;
} Through;

// OPACITY: those of what each lane has hit.
static reals opacities_of(__global const Glass *glass, ints spheres) {
    __private const INTEGER *sphere = EACH_INT(spheres);
    __private reals found[1] = {1};
    for (int i = 0; i < LANES; i++)
        if (sphere[i] >= 0) EACH_REAL(found)[i] = OPACITY_OF(glass[sphere[i]]);
    return found[0];
}

// OPACITY: PICK for hits.
static Hit pick_hit(ints mask, Hit yes, Hit no) {
    Hit hit = no;
    hit.id = PICK_INT(mask, yes.id, no.id);
    hit.distance = PICK(mask, yes.distance, no.distance);
    if (ANY(mask)) hit.common = yes.common;
    return hit;
}

// OPACITY and TREE: what the last walk has found behind a hit.
static Hit next_hit(Hit hit, ints alive) {
    Later *later = hit.later;
    hit.id = PICK_INT(alive, later->id[0], -1);
    hit.distance = later->distance[0];
    FOR_EACH_LATER(later->id[a] = later->id[(a + 1) % LATER];
                   later->distance[a] = later->distance[(a + 1) % LATER])
    later->left--;
    return hit;
}

// OPACITY: where some lanes can see through what they have met, the others have met nothing until those
// are through.
static Through translucent_first(const Scene *scene, Path *path) {
    Through through;
    through.ray = path->ray;
    through.hit = path->hit;
    through.weight = path->weight;
    through.part = opacities_of(scene->glass, path->hit.id);
    through.goes = (path->hit.id >= 0) & (through.part < 1);
    through.waits = 0;
    if (!ANY(through.goes)) return through;
    through.waits = (path->hit.id >= 0) & !through.goes;
    path->hit.id = PICK_INT(through.goes, path->hit.id, -1);
    path->weight *= through.part;
    return through;
}

// OPACITY: the rays as they came, with the weight that is left. Returns the lanes that go on.
static ints go_through(Path *path, const Through *through) {
    path->ray = through->ray;
    Passed *passed = path->ray.passed;
    passed->distance = PICK(through->goes, through->hit.distance, passed->distance);
    passed->id = PICK_INT(through->goes, through->hit.id, passed->id);
    path->weight = PICK(through->goes, through->weight * (1 - through->part), through->weight);
    return through->goes & (path->weight >= LEAST_WEIGHT);
}

// Features: what a program is compiled for.
//
// The host defines each as a number, 0 where it is not used (Features of clrt/renderer/pack/features.py), and code asks
// by `if`: so every program's whole text is checked, and the compiler drops what is not used. `#if`
// chooses a type, a builtin, a whole definition or a kernel, never a part of a body. A heading that
// begins with a feature is that of a function which no program without it has.
//
// What the picture is to be:
//   LANES          A work-item traces so many pixels in lock step: 1, 2, 4, 8 or 16.
//   DOUBLE         Numbers are float64, else float32.
//   LITERAL        Rays meet spheres by the paper's formula as it stands, each tests all of them.
//   FILM_BYTES     The film has 8 bits a channel, else float32.
//   FILM_ALPHA     The film has a fourth channel: how much of a pixel shows something.
//   FILM_GUIDES    The film has what a filter of noise looks at, beside colours with alpha.
//   FILM_PASSES    The film has what the camera sees first: how far away, its normal and its number.
//   FILM_PATHS     The film has a hash of what each pixel's path has met.
//
// What its scene uses:
//   REFLECTION     A path can go on after its first hit.
//   ORTHOGRAPHIC   All camera rays are parallel.
//   LONG_LENS      What fills the picture may be far away against its size.
//   LIGHT_INSIDE   A light is inside a sphere.
//   TREE           There is a tree over the spheres: they are many, or there are others beside them.
//   CAPSULES       There are capsules beside the spheres, in a tree of their own.
//   FACES          There are triangles of meshes, in a tree of their own.
//   SMOOTH         A mesh is shaded with normals between those of its corners.
//   GOURAUD        A mesh is lit at its corners.
//   CORNER_COLORS  A mesh has colours at its corners.
//   SPHERE_COLORS  Spheres, capsules or faces have colours of their own.
//   AMBIENT        There is ambient light that reaches every point.
//   ATTENUATION    A light gets weaker with distance.
//   SPOT           A light shines into a cone.
//   PHONG          A material's highlight is Phong's.
//   NEST           A ray can be inside of so many transparent spheres at once, at most.
//   SPLIT          A surface mirrors and transmits.
//   OPACITY        Surfaces can be seen through.
//   BACKGROUND     Rays that leave the scene after a mirror see something there.
//   ROUND          A light is a ball or a disc.
//   OCCLUSION      What is near hides ambient light, by rays at random.
//   NEAR           What is near hides ambient light, in closed form.
//   LENS           What is out of focus is blurred.
//   GLOSS          A mirror is rough.
//   INDIRECT       Surfaces light each other.
//
// How its pixels are sampled:
//   HASHED         Pixels' paths are wanted beside their colours: edges get more samples.
//   REFINE         Only pixels at edges are made, each of many samples, which are the lanes.
//   GATHER         Every pixel gets several samples.
//   TILES          A work-item makes a tile of pixels, whose camera rays go through the tree as one.

// A sample draws a light's, a lens' or a mirror's point at random. What capsules and
// faces hide of a round light has no closed form.
#define RANDOM (OCCLUSION || LENS || GLOSS || INDIRECT || (ROUND && (CAPSULES || FACES)))
// Shadow rays lose a part of their light to what they enter.
#define VEILED (NEST || OPACITY)
// The hashes of paths are wanted.
#define PATHS (FILM_PATHS || HASHED)

// A feature is a number and may stand on either side of an &&.
#pragma clang diagnostic ignored "-Wconstant-logical-operand"

// The length of an array that a struct has for a feature: a member that is there changes the code of
// programs without it. PoCL's compiler has arrays of length 0, Intel's has not.
#ifdef POCL_DEVICE_ADDRESS_BITS
#define ROOM(feature) (feature)
#else
#define ROOM(feature) 1
#endif

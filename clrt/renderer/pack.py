"""Packing: a Scene as what its program is compiled for and the flat buffers that the kernel reads.

What does not depend on the camera is packed once (World), the rest for each picture (arguments).
Each dtype stands for the struct of the same name in ``kernels/*.cl``, byte for byte; what the
fields mean is said there.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import msgspec
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from clrt.errors import RequestError
from clrt.renderer import glass, samples
from clrt.scene import lens
from clrt.scene.camera import Camera
from clrt.scene.light import AmbientLight, DirectionalLight, LightKind, Shining, SpotLight
from clrt.scene.material import Material
from clrt.scene.scene import Scene, beyond_paper
from clrt.scene.spheres import Sphere, Spheres
from clrt.values import BLACK

Array: TypeAlias = NDArray[Any]
Real: TypeAlias = type[np.float32] | type[np.float64]
Precision: TypeAlias = Literal["robust", "literal", "double"]
PRECISIONS: dict[Precision, Real] = {
    "robust": np.float32,
    "literal": np.float32,
    "double": np.float64,
}
LANES = (1, 2, 4, 8, 16)
FilmKind: TypeAlias = Literal["float", "bytes", "alpha", "passes", "paths"]
PASSES = np.dtype([("depth", np.float32), ("normal", np.float32, 3), ("id", np.int32)])
FILMS: dict[FilmKind, tuple[np.dtype[Any], int]] = {
    "float": (np.dtype(np.float32), 3),
    "bytes": (np.dtype(np.uint8), 3),
    "alpha": (np.dtype(np.float32), 4),
    "passes": (PASSES, 1),
    "paths": (np.dtype(np.uint32), 1),
}
"""What the kernel stores for each pixel: of what dtype, and how many (film.cl)."""


class Features(msgspec.Struct, frozen=True):
    """What a program is compiled for: what the picture is to be, and what its scene uses.

    The kernels know each field by its name in capitals, a precision and a film by their values.
    """

    lanes: int
    precision: Precision
    film: FilmKind
    reflection: bool = False
    """A path can go on after its first hit."""
    orthographic: bool = False
    long_lens: bool = False
    """What fills the picture may be far away against its size."""
    light_inside: bool = False
    """A light is inside a sphere."""
    tree: bool = False
    """There are so many spheres that a tree over them pays."""
    sphere_colors: bool = False
    """Spheres have colours of their own."""
    ambient: bool = False
    """There is ambient light."""
    attenuation: bool = False
    """A light gets weaker with distance."""
    spot: bool = False
    """A light shines into a cone."""
    phong: bool = False
    """A material's highlight is Phong's."""
    nest: int = 0
    """How many transparent spheres a ray can be inside of at once; 0: there are none."""
    split: bool = False
    """A surface mirrors and transmits."""
    background: bool = False
    """Rays that leave the scene after a mirror see something there."""
    round: bool = False
    """A light is a ball or a disc."""
    occlusion: bool = False
    """Spheres hide ambient light."""
    lens: bool = False
    """What is out of focus is blurred."""
    gloss: bool = False
    """A mirror is rough."""
    indirect: bool = False
    """Surfaces light each other."""
    hashed: bool = False
    """Pixels' paths are wanted beside their colours: edges get more samples."""
    refine: bool = False
    """Only pixels at edges are made, each of many samples, which are the lanes."""
    gather: bool = False
    """Every pixel gets several samples."""

    @property
    def packet(self) -> tuple[int, int]:
        """Columns and rows of the pixels that a work-item renders: ROW and ROWS of lanes.cl."""
        columns = min(self.lanes, 2 if self.lanes == 4 else 4) if self.tree else self.lanes
        return columns, self.lanes // columns

    @property
    def options(self) -> list[str]:
        """The compiler's: every -D that the kernels know, with a number, 0 for what is not used."""
        known = {
            "DOUBLE": self.precision == "double",
            "LITERAL": self.precision == "literal",
            **{f"FILM_{film.upper()}": self.film == film for film in FILMS if film != "float"},
            **{name.upper(): getattr(self, name) for name in USES},
        }
        return [f"-DLANES={self.lanes}", *(f"-D{name}={int(used)}" for name, used in known.items())]


USES = Features.__struct_fields__[3:]
"""What a scene may use or not."""


GIANT = 4.0
"""A sphere is a giant if its radius is over this many times the camera's distance from its surface.

Near the surface of any other sphere |f|^2 - r^2 is off by up to 3 * 2^-24 r^2, which moves it by
1.5 * 2^-24 r: at most 6 units in the last place of that distance.
"""

# Beyond these a larger value gives the same picture: the host takes it down to them, so that no
# finite scene makes a kernel compute infinity - infinity or 0 * infinity.
MAX_RADIUS = 2.0**53  # in units of the scene's extent: a plane to the last bit of a float64
MAX_DISTANCE = 2.0**40  # of a light, the bias and a screen's side, in the same units
MAX_COLOR = 2.0**50  # white is 1
MAX_EXPONENT = 2.0**100
VEIL: dict[Real, float] = {np.float32: 2.0**23, np.float64: 2.0**40}
"""A veil's unit, see veiled() of sphere.cl."""
MAX_STRENGTH = 2.0**126  # of a light at distance 1

LEAST_RADIUS: dict[Real, float] = {np.float32: 2.0**-69, np.float64: 2.0**-531}
"""In units of the scene's extent. A radius' square, 2^-138, has 11 bits above the least number that
there is, so the silhouette is off by 2^-12 of the radius at most; float64 likewise."""
SPECK = 1e-5
"""A sphere of a radius less than this many times its distance is not worth an error: it is less
than a hundredth of a pixel."""

COLORS = ("ambient", "diffuse", "specular")
AXES = ("right", "up", "back")


def camera_dtype(real: Real) -> np.dtype[Any]:
    fields = [("step", real, 2), ("eye", real, 3), ("last", np.int32, 2)]
    axes = [(axis, real, 3) for axis in AXES]
    blur = [("aperture", real), ("inv_focus", real)]
    return np.dtype([*fields, *axes, ("unit", real), *blur], align=True)


def glass_dtype(real: Real) -> np.dtype[Any]:
    integer = np.int64 if real is np.float64 else np.int32
    return np.dtype([("order", integer), ("veil", integer)])


def medium_dtype(real: Real) -> np.dtype[Any]:
    return np.dtype([("sphere", np.int32), ("order", np.int32), ("ior", real)], align=True)


def sphere_dtype(real: Real) -> np.dtype[Any]:
    return np.dtype(
        [
            ("anchor", real, 3),
            ("c0", real),
            ("offset", real, 3),
            ("camera_c", real),
            ("screen_bounds", real, 4),
            ("inv_radius", real),
            ("horizon", real),
            ("giant", np.int32),
            ("material", np.int32),
        ],
        align=True,
    )


def material_dtype(real: Real) -> np.dtype[Any]:
    names = ("exponent", "reflection", "transmission", "ior", "fresnel", "spread")
    return np.dtype([*((name, real) for name in names), ("diffuse", real, 3)])


def light_dtype(real: Real) -> np.dtype[Any]:
    fade, cone = [("fade", real, 3), ("strength", real)], [("axis", real, 3), ("edge", real, 2)]
    return np.dtype([("position", real, 3), *fade, *cone, ("radius", real)])


def shade_dtype(real: Real) -> np.dtype[Any]:
    return np.dtype([(color, real, 3) for color in COLORS], align=True)


TREE_FROM = 48
"""From so many spheres on there is a tree (benchmarks/NOTES.md)."""


@dataclass(frozen=True)
class World:
    """What of a scene does not depend on its camera: spheres, materials and lights."""

    given: Sequence[Sphere]
    lights: Sequence[LightKind]
    shining: tuple[Shining, ...]
    """The lights that cast shadows."""
    skies: tuple[AmbientLight, ...]
    """Ambient light that spheres hide."""
    materials: dict[str, Material]
    precision: Precision
    tree: bool
    spheres: Spheres
    material_of: Array
    """(spheres,) int32: the index of each one's material."""
    light_inside: Array
    """int64: which spheres a light is inside of, in order."""
    packed_materials: Array
    shades: Array
    """(shining lights, materials), then a row for ambient light that reaches every point, if there
    is any, then one for each of the skies."""
    colors: Array | None
    """(spheres, 3) of real, if they have their own."""
    glass: Array | None
    """(spheres,) of glass_dtype, if some are transparent."""
    nest: int
    gone: Array
    """Indices of spheres that are as if they were not there."""

    def is_of(self, scene: Scene) -> bool:
        """Whether it is this scene's: by identity of the spheres, which can be many."""
        return (
            self.given is scene.spheres
            and self.lights == scene.lights
            and self.materials == scene.materials
        )


def pack_world(scene: Scene, precision: Precision) -> World:
    """Packs what does not depend on the camera."""
    wide, real = np.longdouble, PRECISIONS[precision]
    materials = list(scene.materials.values())
    shining = tuple(light for light in scene.lights if not isinstance(light, AmbientLight))
    spheres = Spheres.of(scene.spheres)
    index = {name: i for i, name in enumerate(scene.materials)}
    places = np.array([index[name] for name in spheres.names or ()], np.int32)
    material_of = places[spheres.material_index]
    panes, nest, gone = _glass(materials, material_of, spheres, real)
    packed_materials = np.zeros(len(materials), material_dtype(real))
    skies = tuple(light for light in scene.lights if isinstance(light, AmbientLight))
    ambient = [light.ambient for light in skies if not light.occlusion]
    skies = tuple(light for light in skies if light.occlusion)
    rows = len(shining) + bool(ambient) + len(skies)
    shades = np.zeros((rows, len(materials)), shade_dtype(real))
    with _overflow(precision):
        packed_materials["exponent"] = list(map(_exponent, materials))
        for name in ("reflection", "transmission", "ior", "fresnel"):
            packed_materials[name] = [getattr(m, name) for m in materials]
        sine = np.array([m.roughness for m in materials], wide)
        packed_materials["spread"] = sine**2 / (1 + np.sqrt(1 - sine**2))
        diffuse = np.array([m.diffuse for m in materials], wide).reshape(-1, 3)
        packed_materials["diffuse"] = np.clip(diffuse, 0, MAX_COLOR)
        for color in COLORS:
            of_material = np.array([getattr(m, color) for m in materials], wide).reshape(-1, 3)
            of_lights = [getattr(light, color) for light in shining]
            if ambient:
                of_lights.append(np.sum(ambient, axis=0) if color == "ambient" else BLACK)
            of_lights += [sky.ambient if color == "ambient" else BLACK for sky in skies]
            for row, of_light in zip(shades[color], of_lights, strict=True):
                row[:] = np.clip(of_material * np.array(of_light, wide), -MAX_COLOR, MAX_COLOR)
        colors = None
        if spheres.color is not None:
            colors = np.clip(spheres.color, -MAX_COLOR, MAX_COLOR).astype(real)
    return World(
        scene.spheres,
        scene.lights,
        shining,
        skies,
        dict(scene.materials),
        precision,
        precision != "literal" and len(spheres) >= TREE_FROM,
        spheres,
        material_of,
        np.flatnonzero(_encloses(spheres.center, spheres.radius, shining).any(axis=0)),
        packed_materials,
        shades,
        colors,
        panes,
        nest,
        gone,
    )


def _glass(
    materials: Sequence[Material], material_of: Array, spheres: Spheres, real: Real
) -> tuple[Array | None, int, Array]:
    """What concerns rays through each sphere, how many they can be inside of, and which spheres are
    as if they were not there; None, 0 and none if no sphere is transparent."""
    none = np.zeros(0, np.int64)
    transmission = np.array([m.transmission for m in materials], np.float64)
    transparent = (transmission > 0)[material_of] if len(materials) else none
    where = np.flatnonzero(transparent)
    if len(where) == 0:
        return None, 0, none
    met = glass.meetings(spheres.center[where].astype(np.float64), spheres.radius[where])
    nothing = np.array([glass.is_nothing(m) for m in materials], bool)[material_of[where]]
    panes = np.zeros(len(spheres), glass_dtype(real))
    panes["order"] = glass.orders(spheres.radius, transparent)
    unit = VEIL[real]
    with np.errstate(divide="ignore"):
        veil = np.minimum(-np.log2(transmission) * unit, 128 * unit - 1)
    panes["veil"] = np.rint(veil).astype(np.int64)[material_of]
    return panes, int(min(1 + met.max(), glass.MOST)), where[nothing & (met == 0)]


def _exponent(material: Material) -> float:
    if material.highlight == "phong":
        return -min(material.shininess / 2, MAX_EXPONENT)
    return min(material.shininess / 8, MAX_EXPONENT)


def _fades(light: Shining) -> bool:
    return not isinstance(light, DirectionalLight) and light.attenuation != (1, 0, 0)


def _encloses(center: Array, radius: Array, lights: Sequence[Shining]) -> Array:
    """Which spheres lights are inside of: (lights, spheres) uint8."""
    inside = np.zeros((len(lights), len(radius)), np.uint8)
    # In long double for few. Of many a light that is a rounding from a surface is on either side.
    wide = np.longdouble if len(radius) < TREE_FROM else np.float64
    for row, light in zip(inside, lights, strict=True):
        if isinstance(light, DirectionalLight):
            continue
        point = np.array(light.position, wide)
        for block in lens.blocks(len(radius)):
            row[block] = np.linalg.norm(point - center[block], axis=1) < radius[block]
    return inside


def _goes_on(world: World, scene: Scene) -> bool:
    """Whether a path can go on after its first hit."""
    used = world.materials.values()
    goes_on = scene.indirect or any(m.reflection > 0 or m.transmission > 0 for m in used)
    return scene.max_depth > 1 and goes_on


def _shows_background(world: World, scene: Scene) -> bool:
    """Elsewhere than where the camera sees it directly: clrt.film.develop adds it there."""
    return any(scene.film.background) and _goes_on(world, scene)


Stage: TypeAlias = Literal["picture", "edges"]


def stages(scene: Scene, film: FilmKind) -> list[Stage]:
    """What a film is made in: where a pixel gets more samples only if it is at an edge, all pixels
    first and then these."""
    sampled = scene.samples > 1 and film not in ("passes", "paths")
    return ["picture", "edges"] if sampled and not scene.is_random else ["picture"]


def features(
    world: World, scene: Scene, lanes: int, film: FilmKind, stage: Stage = "picture"
) -> Features:
    """What the program of a scene must have.

    Raises:
        RequestError: the precision does not know something of it.
    """
    if world.precision == "literal" and (key := beyond_paper(scene)):
        raise RequestError(f"precision: literal knows no {key}, expected robust or double")
    seen = Features(
        lanes,
        world.precision,
        film,
        orthographic=scene.camera.orthographic,
        long_lens=_has_long_lens(world, scene.camera),
        tree=world.tree,
        nest=world.nest,
    )
    if film == "passes":  # the camera's rays end where they meet something, lit or not
        return seen
    adaptive = len(stages(scene, film)) > 1
    random = scene.is_random and film != "paths"
    used = world.materials.values()
    return replace(
        seen,
        reflection=_goes_on(world, scene),
        light_inside=len(world.light_inside) > 0,
        sphere_colors=world.colors is not None,
        ambient=len(world.shades) > len(world.shining) + len(world.skies),
        attenuation=any(map(_fades, world.shining)),
        spot=any(isinstance(light, SpotLight) for light in world.shining),
        phong=any(material.highlight == "phong" for material in used),
        split=scene.max_depth > 1 and world.nest > 0 and any(map(glass.splits, used)),
        background=_shows_background(world, scene),
        round=any(light.is_round for light in world.shining),
        hashed=adaptive and stage == "picture",
        occlusion=random and len(world.skies) > 0,
        lens=random and scene.camera.has_lens,
        gloss=random and scene.is_glossy,
        indirect=random and scene.is_indirect,
        refine=stage == "edges",
        gather=random or (adaptive and stage == "picture" and base(scene) > 1),
    )


SMALL, SMALLS_BASE = 0.01, 4
"""Of what size spheres are so small that one sample misses what is between the pixels, see
lens.middle_size(), and how many each pixel then gets (benchmarks/NOTES.md)."""


def base(scene: Scene) -> int:
    """How many samples each pixel gets, at an edge or not."""
    small = lens.middle_size(scene.camera, scene.spheres) < SMALL
    return min(SMALLS_BASE if small else 1, scene.samples)


def _has_long_lens(world: World, camera: Camera) -> bool:
    """Whether rays start ahead of the camera. From inside glass its far side is seen, however near
    it is."""
    known = world.precision != "literal"
    return known and lens.is_long(camera) and not len(_media(world, camera))


def _media(world: World, camera: Camera) -> Array:
    """The transparent spheres that a camera is inside of, the smallest first, of medium_dtype."""
    real = PRECISIONS[world.precision]
    if world.glass is None:
        return np.zeros(0, medium_dtype(real))
    inside = glass.around(camera, world.spheres, world.glass["order"] > 0)
    inside = np.setdiff1d(inside, world.gone, assume_unique=True)
    found = np.zeros(len(inside), medium_dtype(real))
    found["sphere"] = inside + 1
    found["order"] = world.glass["order"][inside]
    found["ior"] = world.packed_materials["ior"][world.material_of[inside]]
    found[::-1].sort(order="order")
    return found


BATCH = 16
"""samples.cl: so many samples between two looks whether they are enough."""
BOUNCES, KINDS, SKY_RAYS = 4, 4, 4
"""draw.cl: for how many bounces there are numbers, of how many kinds beside those for skies, and
how many rays each of these gets."""


NUMBERS = ("top", "from", "count", "samples", "sky_count")
ORDER = (
    *("paths", "top", "list", "from", "count", "samples", "points", "table"),
    *("max_depth", "shadow_bias", "camera", "sphere_count", "spheres"),
    *("material_count", "materials", "light_count", "lights", "shades", "encloses"),
    *("sky_count", "skies", "background", "sphere_colors", "glass", "around", "lost"),
    *("ids", "materials_of", "beads", "nodes", "leaves", "shape"),
)
"""The kernel's arguments from `paths` on, see render.cl."""
NOTHING: dict[str, Any] = {name: np.int32(0) if name in NUMBERS else None for name in ORDER}
"""Of a scene that needs none of them: no buffer, and nothing to count."""


def sampling(features: Features, scene: Scene) -> dict[str, Any]:
    """More of a program's arguments: how many samples a pixel gets, and where they lie in it, see
    clrt.samples.offsets(). Where they are the lanes, x of as many as there are lanes, then y, in
    whole rounds."""
    if not (features.refine or features.gather):
        return {}
    lanes = features.lanes if features.refine else 1
    count = base(scene) if features.hashed else scene.samples
    found = np.zeros((-(-count // BATCH) * BATCH, 2), PRECISIONS[features.precision])
    found[:count] = samples.offsets(count)
    laid = np.ascontiguousarray(found.reshape(-1, lanes, 2).transpose(0, 2, 1))
    more = {"samples": np.int32(count), "points": laid}
    if features.occlusion or features.lens or features.gloss or features.indirect:
        others = samples.table(len(found), BOUNCES * KINDS, first=1)
        skies = samples.table(SKY_RAYS * len(found), BOUNCES, first=1 + BOUNCES * KINDS)
        more["table"] = np.concatenate([others.reshape(-1, 2), skies.reshape(-1, 2)])
    return more


def arguments(world: World, scene: Scene, width: int, height: int) -> dict[str, Any]:
    """The kernel's arguments for a picture of width x height pixels, by name and in its order, from
    `paths` on: NumPy scalars, and arrays that become buffers. Any program takes them: those that
    the scene has no use for are 0 and None. sampling() says how a program's pixels are sampled.

    Raises:
        RequestError: spheres are so far that their precision cannot show others, which are near.

    Lengths are scaled by a power of two, which is exact and cannot be seen, so that the spheres
    reach about 1 from the camera: neither their squares nor those of anything larger than 1e-19 of
    that leave float32's range. The space is the camera's, or, with a tree, the world's axes with
    the origin at the camera. "literal" leaves the scene where and as large as it is in the world,
    and treats no sphere in a special way. Everything is rounded once.

    With a tree `beads` has all spheres, and `spheres` those that the tree cannot hold;
    clrt.opencl.tree adds nodes, leaves and shape. Whoever runs the kernel adds `paths`, `top` and
    `lost`: in how many packets rays needed more room than there is, two numbers (enter() of
    glass.cl, put_aside() of onward.cl).
    """
    literal = world.precision == "literal"
    # Where long double is wider than float64 it has the digits for r = 1e9 and the range for 1e300.
    wide, real = np.longdouble, PRECISIONS[world.precision]
    eye = np.array(scene.camera.position, wide)
    basis = np.array(scene.camera.basis(), wide)
    turn = np.identity(3, wide) if world.tree else basis
    origin = np.zeros(3, wide) if literal else eye
    screen = lens.half_screen(scene.camera, width, height)
    ahead = wide(0)  # how far from the camera rays start
    is_beside = scene.camera.orthographic and not literal
    if is_beside or _has_long_lens(world, scene.camera):
        ahead = lens.start(scene.camera, world.spheres, screen, np.float64 if world.tree else wide)
        origin = origin - ahead * basis[2]

    def moved(points: Array) -> Array:
        turned: Array = (points - origin) @ turn.T
        return turned

    located = [light.position for light in world.shining if not isinstance(light, DirectionalLight)]
    light_distance = np.linalg.norm(moved(np.array(located, wide).reshape(-1, 3)), axis=1)
    if world.tree:
        reach, giants = _reach(world.spheres, origin.astype(np.float64))
        listed = np.union1d(giants, world.light_inside)
        if scene.camera.orthographic:
            # The tree's rays have a start.
            behind = lens.behind(scene.camera, world.spheres, screen, ahead)
            listed = np.union1d(listed, behind)
        center = moved(world.spheres.center[listed].astype(wide))
        radius = world.spheres.radius[listed].astype(wide)
        material_of = world.material_of[listed]
    else:
        center = moved(world.spheres.center.astype(wide))
        radius = world.spheres.radius.astype(wide)
        material_of = world.material_of
        reach = _extent(center, radius)
    extent: Any = wide(reach or light_distance.max(initial=0) or 1)
    scale = wide(1) if literal else np.ldexp(wide(1), -np.frexp(extent)[1])
    if not literal:
        _require_in_range(world, eye, extent)
    bias = float(scale * min(scene.shadow_bias, MAX_DISTANCE * extent))
    camera = np.zeros(1, camera_dtype(real))
    with _overflow(world.precision):
        camera["last"] = np.maximum([width - 1, height - 1], 1)
        if scene.camera.orthographic:
            screen = scale * np.minimum(screen, MAX_DISTANCE * extent)
        camera["step"] = screen / camera["last"]
        camera["eye"] = scale * moved(eye.reshape(1, 3))
        if scene.camera.has_lens:
            most = MAX_DISTANCE * extent
            camera["aperture"] = scale * np.minimum(scene.camera.aperture_radius, most)
            camera["inv_focus"] = 1 / (
                scale * np.clip(scene.camera.focus_distance or 0, 1 / most, most)
            )
        camera["unit"] = np.minimum(1 / scale, np.finfo(real).max)
        for axis, vector in zip(AXES, basis, strict=True):
            camera[axis] = vector
        lights = _pack_lights(world.shining, origin, turn, scale, extent, real)
        spheres = _pack_spheres(scale * center, scale * radius, bias, real, literal)
        spheres["screen_bounds"] = lens.bounds(scene.camera, scale * center, scale * radius)
        spheres["material"] = material_of
        gone = np.isin(listed, world.gone) if world.tree else world.gone
        spheres["c0"][gone], spheres["camera_c"][gone] = np.inf, -1  # no ray meets it
        shadow_bias = real(bias)
    chosen = world.spheres.center, world.spheres.radius
    if world.tree:
        chosen = chosen[0][listed], chosen[1][listed]
    found: dict[str, Any] = NOTHING | {
        "max_depth": np.int32(scene.max_depth),
        "shadow_bias": shadow_bias,
        "camera": camera,
        "sphere_count": np.int32(len(spheres)),
        "spheres": spheres,
        "material_count": np.int32(len(world.packed_materials)),
        "materials": world.packed_materials,
        "light_count": np.int32(len(lights)),
        "lights": lights,
        "shades": world.shades,
        "encloses": _encloses(*chosen, world.shining),
        "background": np.clip(scene.film.background, -MAX_COLOR, MAX_COLOR).astype(real),
        "sphere_colors": world.colors,
        "glass": world.glass,
    }
    if world.skies:
        far = np.array([light.distance for light in world.skies], wide)
        found["sky_count"] = np.int32(len(far))
        found["skies"] = np.minimum(scale * far, np.finfo(real).max).astype(real)
    if world.nest:
        media = _media(world, scene.camera)
        found["around"] = np.zeros(world.nest, medium_dtype(real))
        found["around"][: len(media)] = media[: world.nest]
    if world.tree:
        beads = _beads(world.spheres, origin.astype(np.float64), float(scale), real)
        beads[listed, 3] = beads[world.gone, 3] = np.nan
        found["ids"] = listed.astype(np.int32)
        found |= {"materials_of": world.material_of, "beads": beads}
    return found


def _pack_lights(
    lights: Sequence[Shining], origin: Array, turn: Array, scale: Any, extent: Any, real: Real
) -> Array:
    """Lights in the kernel's space. A directional one is a point so far that no digit tells.

    turn: the axes of that space; extent: how far the spheres reach in it before it is scaled.
    """
    packed = np.zeros(len(lights), light_dtype(real))
    for light, one in zip(lights, packed, strict=True):
        if isinstance(light, DirectionalLight):
            place = -MAX_DISTANCE * extent * (turn @ _unit(np.array(light.direction, turn.dtype)))
        else:
            place = turn @ (np.array(light.position, turn.dtype) - origin)
        nearer = 1 / np.maximum(np.linalg.norm(place) / (MAX_DISTANCE * extent), 1)
        one["position"] = scale * nearer * place
        one["radius"] = _light_radius(light, place) * scale * nearer
        one["fade"], one["strength"] = _fade(light, scale * nearer)
        one["axis"], one["edge"] = _cone(light, turn)
    return packed


def _light_radius(light: Shining, place: Array) -> Any:
    """Of a ball that fills as much of the sky, in the unit of its place."""
    if isinstance(light, DirectionalLight):
        return np.linalg.norm(place) * np.sin(np.radians(place.dtype.type(light.half_angle)))
    return np.minimum(place.dtype.type(light.radius), MAX_DISTANCE * (1 + np.linalg.norm(place)))


def _fade(light: Shining, scale: Any) -> tuple[Array, Any]:
    """Attenuation's coefficients for scaled distances, the largest of them 1, and 1 / the largest:
    so nothing overflows."""
    if isinstance(light, DirectionalLight):
        return np.array([1, 0, 0]), 1
    found: Array = light.attenuation / scale ** np.arange(3)
    return found / found.max(), np.minimum(1 / found.max(), MAX_STRENGTH)


def _cone(light: Shining, turn: Array) -> tuple[Array, Any]:
    """A spot's axis, and a, b of t = a - b h, see cone() of shading.cl; of other lights t = 2."""
    if not isinstance(light, SpotLight) or light.inner_angle == 180:
        return np.zeros(3), (2, 0)
    axis = turn @ _unit(np.array(light.look_at, turn.dtype) - np.array(light.position))
    angles = np.radians(np.array([light.outer_angle, light.inner_angle], turn.dtype))
    outer, inner = 4 * np.sin(angles / 2) ** 2
    steep = 1 / np.maximum(outer - inner, 1 / MAX_COLOR)
    return axis, (outer * steep, steep)


def _unit(v: Array) -> Array:
    v = v / abs(v).max()  # lest its square overflows
    unit: Array = v / np.linalg.norm(v)
    return unit


def _reach(spheres: Spheres, origin: Array) -> tuple[float, Array]:
    """How far many spheres reach from the origin, as _extent(), and which are giants."""
    reach, giants = 0.0, []
    for block in lens.blocks(len(spheres)):
        radius = spheres.radius[block].astype(np.float64)
        away = spheres.center[block] - origin
        distance = np.sqrt(np.einsum("ij,ij->i", away, away))
        surface = abs(distance - radius)
        giant = radius > GIANT * surface
        reach = max(reach, float(np.where(giant, surface, distance + radius).max(initial=0)))
        giants.append(np.flatnonzero(giant) + block.start)
    return reach, np.concatenate(giants)


def _beads(spheres: Spheres, origin: Array, scale: float, real: Real) -> Array:
    """(spheres, 4) of real: centre from the origin, and radius, scaled."""
    beads = np.empty((len(spheres), 4), real)
    for block in lens.blocks(len(spheres)):
        beads[block, :3] = (spheres.center[block] - origin) * scale
        beads[block, 3] = spheres.radius[block] * np.float64(scale)
    return beads


def tree_keys(spheres: Spheres) -> Array:
    """What a tree is ordered by, (spheres, 4) float32: centre and twice the radius, in units of the
    box around the centres, from about the middle one: so a ball of radius 1e9 as a ground leaves
    the others their digits."""
    sides = spheres.center.T.astype(np.float64, copy=False)  # each by itself: twice as fast
    half = float(max(np.max(side) / 2 - np.min(side) / 2 for side in sides)) or 1.0
    some = spheres.center[:: -(-len(spheres) // lens.LOOKED_AT)].astype(np.float64, copy=False)
    middle = np.sort(some, axis=0)[len(some) // 2]
    keys = np.empty((len(spheres), 4), np.float32)
    for block in lens.blocks(len(spheres)):
        # Halves, lest two centres be farther apart than any number.
        keys[block, :3] = (spheres.center[block] / 2 - middle / 2) / half
        keys[block, 3] = np.minimum(spheres.radius[block] / np.float64(half), 1e30)
    return keys


def _require_in_range(world: World, eye: Array, extent: Any) -> None:
    """Raises RequestError: a sphere that the camera sees is lost beside the farthest, which is no
    giant."""
    radii, least = world.spheres.radius, LEAST_RADIUS[PRECISIONS[world.precision]] * extent
    if not len(radii) or np.min(radii) >= least:
        return
    small = np.flatnonzero(radii < least)
    radius = radii[small].astype(np.longdouble)
    distance = np.linalg.norm(world.spheres.center[small].astype(np.longdouble) - eye, axis=1)
    seen = small[radius > SPECK * distance]
    if len(seen):
        # As words: a float64 may not hold the extent.
        wanted = "double" if world.precision == "robust" else "the farthest spheres nearer"
        raise RequestError(
            f"precision: {world.precision} cannot show a sphere of radius {radii[seen[0]]:.3g} and "
            f"one that reaches {np.format_float_scientific(extent, 2)} from the camera, "
            f"expected {wanted}"
        )


def _overflow(precision: Precision) -> Any:
    """ "literal" lets float32 overflow to infinity, as the paper's formula would; anything else
    that overflows is a bug."""
    return np.errstate(over="ignore" if precision == "literal" else "raise")


def _is_giant(center: Array, radius: Array) -> Array:
    giant: Array = radius > GIANT * abs(np.linalg.norm(center, axis=1) - radius)
    return giant


def _extent(center: Array, radius: Array) -> Any:
    """How far the spheres reach from the camera; of giants, the distance of their anchors."""
    distance = np.linalg.norm(center, axis=1)
    reach = np.where(_is_giant(center, radius), abs(distance - radius), distance + radius)
    return reach.max(initial=0)


def _pack_spheres(
    center: Array,
    radius: Array,
    bias: float,
    real: Real,
    literal: bool = False,
) -> Array:
    """Spheres from centres (n, 3) in camera space and radii (n,), of about unit extent.

    The rounding of a giant's anchor moves it off the surface. c0 takes that up: it is computed from
    the rounded anchor, before it is rounded itself.
    """
    giant = _is_giant(center, radius) & (not literal)
    distance = np.linalg.norm(center, axis=1)
    toward = np.where(giant, (distance - radius) / np.where(giant, distance, 1), 1)
    anchor = (toward[:, np.newaxis] * center).astype(real)
    offset = np.where(giant[:, np.newaxis], anchor - center, 0)
    flat = np.minimum(radius, MAX_RADIUS)

    spheres = np.zeros(len(radius), sphere_dtype(real))
    spheres["anchor"] = anchor
    spheres["offset"] = (flat / radius)[:, np.newaxis] * offset
    above = np.linalg.norm(offset, axis=1) - radius  # the anchor, above the surface
    spheres["c0"] = above * (2 * flat + above)
    above = distance - radius  # the camera
    spheres["camera_c"] = above * (2 * flat + above)
    spheres["inv_radius"] = 1 / np.maximum(flat, np.finfo(real).tiny)
    # A point lifted by `bias` off its sphere sees a light past the sphere down to this cosine: the
    # paper's shadow test, without a sphere tested against its own rounding.
    horizon = -np.sqrt(bias * (2 * radius + bias)) / (radius + bias)
    spheres["horizon"] = -2 if literal else horizon
    spheres["giant"] = giant
    return spheres

"""What a scene is.

The classes mirror the scene file table by table (docs/scenes.md). They check their values
whoever makes them: a file or Python code. Lengths are in world units, colours linear RGB.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Literal

import msgspec
from msgspec.structs import force_setattr

from clrt.errors import RequestError, SceneError
from clrt.particles import palette
from clrt.particles.particlefile import MATTE, ParticleFile
from clrt.scene.light import LIGHT_KINDS, AmbientLight, LightKind
from clrt.scene.spheres import Sphere, Spheres
from clrt.values import (
    BLACK,
    WHITE,
    Color,
    Vec3,
    all_of,
    count,
    number,
    require,
    some,
    switches,
    vectors,
)

MAX_DEPTH = 1000
"""Between mirrors that face each other a path has no end: seconds at 4K, but not hours."""

MAX_SAMPLES = 1 << 16
"""The most that a pixel can get."""


LENSES = {"perspective": "fov", "orthographic": "height"}
"""The key that says how much of the world a camera sees."""


class Camera(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where the picture is taken from.

    "perspective": all rays start at `position`, and the screen stands one unit ahead.
    "orthographic": all rays go along the view, from before everything: nothing is behind the
    camera, and it is inside nothing.
    """

    position: Vec3
    look_at: Vec3
    up: Vec3 = (0.0, 1.0, 0.0)
    fov: float | None = None
    """Perspective: horizontal, degrees, between 0 and 180; 90 if it is not given."""
    projection: Literal["perspective", "orthographic"] = "perspective"
    height: float | None = None
    """Orthographic: of what the picture shows, world units."""
    aperture_radius: float = 0.0
    """Perspective: of the lens, world units. Above 0 only what is at focus_distance is sharp."""
    focus_distance: float | None = None
    """How far along the view the plane is that is in focus, world units."""

    def __post_init__(self) -> None:
        vectors(self, "position", "look_at", "up")
        good = self.projection in LENSES
        require(good, "projection", "'perspective' or 'orthographic'", self.projection)
        for projection, key in LENSES.items():
            if projection != self.projection:
                good = getattr(self, key) is None
                expected = f"none, which goes with projection {projection!r} only"
                require(good, key, expected, getattr(self, key))
        if self.orthographic:
            number(self, "height", "a finite number above 0", lambda height: height > 0)
        else:
            force_setattr(self, "fov", 90.0 if self.fov is None else self.fov)
            number(self, "fov", "degrees between 0 and 180", lambda fov: 0 < fov < 180)
        number(self, "aperture_radius", "a finite number, at least 0", lambda radius: radius >= 0)
        if self.has_lens:
            expected = "0 with projection 'orthographic'"
            require(not self.orthographic, "aperture_radius", expected, self.aperture_radius)
        if self.has_lens or self.focus_distance is not None:
            needed = ", which aperture_radius needs" if self.focus_distance is None else ""
            expected = f"a finite number above 0{needed}"
            number(self, "focus_distance", expected, lambda distance: distance > 0)
        ahead = _minus(self.look_at, self.position)
        require(any(ahead), "look_at", "a point apart from position", self.look_at)
        good = all(map(math.isfinite, ahead))
        require(good, "look_at", "a point less than 1.8e308 from position", self.look_at)
        ahead, up = _near_one(ahead), _near_one(self.up)
        # The sine of the angle between them; below 1e-9 float64 cannot tell where right is.
        good = math.hypot(*_cross(ahead, up)) > 1e-9 * math.hypot(*ahead) * math.hypot(*up)
        require(good, "up", "a direction not parallel to look_at - position", self.up)

    @property
    def orthographic(self) -> bool:
        return self.projection == "orthographic"

    @property
    def has_lens(self) -> bool:
        """Whether what is out of focus is blurred."""
        return self.aperture_radius > 0

    def basis(self) -> tuple[Vec3, Vec3, Vec3]:
        """The unit vectors right, up and back (against the view), in world space."""
        back = _unit(_minus(self.position, self.look_at))
        right = _unit(_cross(_near_one(self.up), back))
        return right, _cross(back, right), back


class Material(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How a surface answers light (paper, section 11.8)."""

    ambient: Color = BLACK
    diffuse: Color = WHITE
    specular: Color = BLACK
    shininess: float = 100.0
    """At least 0. Blinn-Phong's alpha: the exponent is a quarter of it. Phong's exponent."""
    reflection: float = 0.0
    """The part of the mirrored light that is added, in [0, 1]."""
    highlight: Literal["blinn-phong", "phong"] = "blinn-phong"
    transmission: float = 0.0
    """The part of the light that goes through, in [0, 1]. reflection + transmission <= 1."""
    ior: float = 1.5
    """Index of refraction inside, 1 to 10."""
    fresnel: bool = False
    """Of the transmission the part that Fresnel's formulas say is mirrored."""
    roughness: float = 0.0
    """Of the mirrored ray only, in [0, 1]: the sine of the half angle of a cone about it. Rays are
    drawn uniformly over the cone's cap; those that would go into the surface are mirrored at it."""

    def __post_init__(self) -> None:
        good = self.highlight in ("blinn-phong", "phong")
        require(good, "highlight", "'blinn-phong' or 'phong'", self.highlight)
        vectors(self, "ambient", "diffuse", "specular")
        number(self, "shininess", "a finite number, at least 0", lambda alpha: alpha >= 0)
        number(self, "reflection", "a number from 0 to 1", lambda part: 0 <= part <= 1)
        number(self, "transmission", "a number from 0 to 1", lambda part: 0 <= part <= 1)
        both = self.reflection + self.transmission
        expected = f"at most 1 - reflection ({1 - self.reflection:g})"
        require(both <= 1 + 1e-12, "transmission", expected, self.transmission)
        number(self, "ior", "a number from 1 to 10", lambda ior: 1 <= ior <= 10)
        switches(self, "fresnel")
        number(self, "roughness", "a number from 0 to 1", lambda sine: 0 <= sine <= 1)

    @property
    def is_glossy(self) -> bool:
        """Whether it mirrors, into a cone."""
        mirrors = self.reflection > 0 or (self.fresnel and self.transmission > 0)
        return mirrors and self.roughness > 0


FRAMES = 10**7
"""The most that an animation can have."""


class Key(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where the camera is at a frame. What is None keeps the scene's camera's value."""

    frame: int
    position: Vec3 | None = None
    look_at: Vec3 | None = None
    up: Vec3 | None = None
    fov: float | None = None
    height: float | None = None

    def __post_init__(self) -> None:
        count(self, "frame", 0, FRAMES)
        vectors(self, *(key for key in CAMERA_VECTORS if getattr(self, key) is not None))
        for lens in LENSES.values():
            if getattr(self, lens) is not None:
                number(self, lens, "a finite number", lambda value: True)


CAMERA_VECTORS = ("position", "look_at", "up")
"""What of a camera a key can give, beside the number that LENSES names."""


class Animation(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How the camera moves. If the first and the last key say the same it goes round and round."""

    frames: int
    keys: Sequence[Key]
    fps: float = 30.0
    interpolation: Literal["smooth", "linear"] = "smooth"

    def __post_init__(self) -> None:
        good = self.interpolation in ("smooth", "linear")
        require(good, "interpolation", "'smooth' or 'linear'", self.interpolation)
        count(self, "frames", 1, FRAMES)
        number(self, "fps", "a number from 0.001 to 1000", lambda fps: 0.001 <= fps <= 1000)
        all_of(self, "keys", Key, "a Key")
        require(len(self.keys) >= 2, "keys", "at least two keys", len(self.keys))
        before = -1
        for i, key in enumerate(self.keys):
            good = before < key.frame <= self.frames
            expected = f"a frame from {before + 1} to {self.frames}, after that of the key before"
            require(good, f"keys[{i}].frame", expected, key.frame)
            before = key.frame


class LegendEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a colour stands for."""

    name: str
    color: Color

    def __post_init__(self) -> None:
        _line(self, "name")
        vectors(self, "color")


class Cell(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A box whose edges are drawn."""

    edges: tuple[Vec3, Vec3, Vec3]
    """A row for each of the three that meet in `origin`; (3, 3)."""
    origin: Vec3 = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        vectors(self, "origin")
        try:
            rows = tuple((float(x), float(y), float(z)) for x, y, z in self.edges)
            good = len(rows) == 3 and all(math.isfinite(x) for row in rows for x in row)
        except (TypeError, ValueError, OverflowError):
            good = False
        require(good, "edges", "three rows of three finite numbers", self.edges)
        force_setattr(self, "edges", rows)


def _line(struct: msgspec.Struct, key: str) -> None:
    given = getattr(struct, key)
    good = isinstance(given, str) and given.isprintable()
    require(good, key, "a line of text", given)


OUTLINE = 100.0
"""The widest, in pixels: a region is rendered with a margin of half as many."""


class Film(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What becomes of the light that a picture has gathered: clrt.film.develop has the steps."""

    background: Color = (0.0, 0.0, 0.0)
    """What every ray of the camera's sees that leaves the scene, after mirrors as well."""
    transparent: bool = False
    """The picture has alpha in place of the background."""
    transfer: Literal["linear", "srgb"] = "linear"
    """The curve of integer films and files; floats are linear."""
    outline: float = 0.0
    """The width of a line around what stands before something else, pixels; 0 draws none."""
    outline_color: Color = (0.0, 0.0, 0.0)
    depth_cue: tuple[float, float] = (0.0, 0.0)
    """From the first depth to the second, world units, colours go over into the background. Two
    zeros: they do not."""
    denoise: bool = False
    """For previews: neighbours that show the same spheres share the noise of few samples."""
    colorbar: str = ""
    """The label of a colour bar, or of a legend if there is one; " ": neither has one. "": none is
    drawn."""
    colorbar_cmap: str | None = None
    """The bar's colour map, by its name in clrt.palette; None: "viridis"."""
    colorbar_clim: tuple[float, float] | None = None
    """What the bar's ends stand for."""
    legend: Sequence[LegendEntry] = ()
    """What is drawn instead of the bar."""
    cells: Sequence[Cell] = ()
    """Boxes whose edges are drawn."""

    def __post_init__(self) -> None:
        vectors(self, "background", "outline_color")
        switches(self, "transparent", "denoise")
        good = self.transfer in ("linear", "srgb")
        require(good, "transfer", "'linear' or 'srgb'", self.transfer)
        expected = f"a number from 0 to {OUTLINE:g}"
        number(self, "outline", expected, lambda width: 0 <= width <= OUTLINE)
        try:
            near, far = map(float, self.depth_cue)
            good = math.isfinite(near) and math.isfinite(far) and (near < far or near == far == 0)
        except (TypeError, ValueError, OverflowError):
            good = False
        require(good, "depth_cue", "two finite numbers, the first one less", self.depth_cue)
        force_setattr(self, "depth_cue", (near, far))
        all_of(self, "legend", LegendEntry, "a LegendEntry")
        all_of(self, "cells", Cell, "a Cell")
        _line(self, "colorbar")
        good = self.colorbar_cmap is None or isinstance(self.colorbar_cmap, str)
        require(good, "colorbar_cmap", "the name of a colour map", self.colorbar_cmap)
        try:
            if self.colorbar_cmap is not None:
                palette.colormap(self.colorbar_cmap)
            if self.colorbar_clim is not None:
                clim = palette.check_limits(self.colorbar_clim)
                force_setattr(self, "colorbar_clim", clim)
        except RequestError as error:  # of cmap or clim
            raise SceneError(f"colorbar_{error}") from None


class Scene(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Everything that a picture depends on but its size."""

    camera: Camera
    lights: Sequence[LightKind] = ()
    materials: dict[str, Material] = {}
    spheres: Sequence[Sphere] = ()
    """Sphere by Sphere, or Spheres."""
    max_depth: int = 3
    """Ray segments from the camera; 1 means no reflection."""
    shadow_bias: float = 0.0
    """World units that a hit point is lifted off its surface; 0 is the exact geometry."""
    animation: Animation | None = None
    film: Film = Film()
    samples: int = 1
    """The most that a pixel gets; 1 is one ray through its middle."""
    indirect: bool = False
    """Light comes from lit surfaces as well, to their diffuse neighbours."""
    particles: Sequence[ParticleFile] = ()
    """They come after `spheres`, in this order. clrt.figure.resolver reads them."""

    def __post_init__(self) -> None:
        require(isinstance(self.camera, Camera), "camera", "a Camera", self.camera)
        all_of(self, "lights", LIGHT_KINDS, "a light")
        good = isinstance(self.materials, dict)
        require(good, "materials", "a dict of names and Materials", self.materials)
        for name, material in self.materials.items():
            good = isinstance(name, str) and isinstance(material, Material)
            require(good, f"materials.{name}", "a Material", material)
        all_of(self, "particles", ParticleFile, "a ParticleFile")
        good = self.animation is None or isinstance(self.animation, Animation)
        require(good, "animation", "an Animation", self.animation)
        require(isinstance(self.film, Film), "film", "a Film", self.film)
        bar = self.film.colorbar and not self.film.legend
        good = not bar or self.film.colorbar_clim is not None or len(self.particles) > 0
        require(good, "film.colorbar_clim", "two numbers beside colorbar", None)
        count(self, "max_depth", 1, MAX_DEPTH)
        number(self, "shadow_bias", "a finite number, at least 0", lambda bias: bias >= 0)
        count(self, "samples", 1, MAX_SAMPLES)
        switches(self, "indirect")
        for key in _spread_light(self):
            require(self.shadow_bias == 0, "shadow_bias", f"0 beside {key}", self.shadow_bias)
        if isinstance(self.spheres, Spheres):
            force_setattr(self, "spheres", self.spheres.with_names(tuple(self.materials)))
            used = self.spheres.names or ()
            wrong = [(i, name) for i, name in enumerate(used) if name not in self.materials]
            where = "spheres.material"
        else:
            all_of(self, "spheres", Sphere, "a Sphere")
            names = (sphere.material for sphere in self.spheres)
            wrong = [(i, name) for i, name in enumerate(names) if name not in self.materials]
            where = f"spheres[{wrong[0][0]}].material" if wrong else ""
        if not wrong:
            known = {*self.materials, MATTE}
            wrong = [
                (i, p.material) for i, p in enumerate(self.particles) if p.material not in known
            ]
            where = f"particles[{wrong[0][0]}].material" if wrong else ""
        if wrong:
            expected = f"the name of a material ({some(self.materials)})"
            require(False, where, expected, wrong[0][1])

    @property
    def is_random(self) -> bool:
        """Whether rays are drawn at random, so that each pixel needs many. Round lights alone do
        not make them so: their shadows have a closed form."""
        occluded = any(isinstance(light, AmbientLight) and light.occlusion for light in self.lights)
        return occluded or self.camera.has_lens or self.is_glossy or self.is_indirect

    @property
    def is_glossy(self) -> bool:
        """Whether paths go on from rough mirrors."""
        return self.max_depth > 1 and any(m.is_glossy for m in self.materials.values())

    @property
    def is_indirect(self) -> bool:
        """Whether paths go on from diffuse surfaces."""
        return self.max_depth > 1 and self.indirect


def beyond_one_ray(scene: Scene) -> str | None:
    """The first key of a scene that spreads a ray, or a light, over many directions: pictures of it
    are known by closed forms only. None if there is none."""
    for key in _spread_light(scene):
        return key
    for name, material in scene.materials.items():
        if material.roughness > 0:
            return f"roughness of materials.{name}"
    return "aperture_radius of camera" if scene.camera.has_lens else None


def beyond_paper(scene: Scene) -> str | None:
    """The first key of a scene that the paper's formulas to the letter do not know; None if they
    know all: what precision "literal" and the truth "seed" refuse."""
    for name, material in scene.materials.items():
        if material.transmission > 0:
            return f"transmission of materials.{name}"
    return beyond_one_ray(scene) or ("samples > 1" if scene.samples > 1 else None)


def _spread_light(scene: Scene) -> Iterator[str]:
    """The keys that let a point get light from more than single points."""
    for i, light in enumerate(scene.lights):
        for key in ("radius", "half_angle", "occlusion"):
            if getattr(light, key, 0) > 0:
                yield f"{key} of lights[{i}]"
    if scene.indirect:
        yield "indirect"


def _minus(a: Vec3, b: Vec3) -> Vec3:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _cross(a: Vec3, b: Vec3) -> Vec3:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _near_one(a: Vec3) -> Vec3:
    """Scaled by a power of two, which is exact, so that products stay in range."""
    _, exponent = math.frexp(max(map(abs, a)))
    return math.ldexp(a[0], -exponent), math.ldexp(a[1], -exponent), math.ldexp(a[2], -exponent)


def _unit(a: Vec3) -> Vec3:
    a = _near_one(a)
    length = math.hypot(*a)
    return a[0] / length, a[1] / length, a[2] / length

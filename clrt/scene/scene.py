"""Scene: all that a picture depends on but its size.

The classes mirror the scene file table by table (docs/scenes.md). They check their values
whoever makes them: a file or Python code. Lengths are in world units, colours linear RGB.
"""

from collections.abc import Container, Iterator, Sequence
from typing import Any

import msgspec
import numpy as np
from msgspec.structs import force_setattr

from clrt.particles.particlefile import STYLE_NAMES, ParticleFile
from clrt.scene.animation import Animation
from clrt.scene.camera import Camera
from clrt.scene.capsules import Capsule, Capsules
from clrt.scene.film import Film
from clrt.scene.light import LIGHT_KINDS, LightKind
from clrt.scene.material import Material
from clrt.scene.mesh import Mesh
from clrt.scene.rows import Rows
from clrt.scene.spheres import Sphere, Spheres
from clrt.values import (
    all_of,
    count,
    number,
    require,
    some,
    switches,
)

MAX_DEPTH = 1000
"""Between mirrors that face each other a path has no end: seconds at 4K, but not hours."""

MAX_SAMPLES = 1 << 16
"""The most that a pixel can get."""


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
    capsules: Sequence[Capsule] = ()
    """Capsule by Capsule, or Capsules. Indices count them after all spheres."""
    meshes: Sequence[Mesh] = ()
    """Indices count their faces, mesh by mesh, after all capsules."""

    def __post_init__(self) -> None:
        require(isinstance(self.camera, Camera), "camera", "a Camera", self.camera)
        all_of(self, "lights", LIGHT_KINDS, "a light")
        good = isinstance(self.materials, dict)
        require(good, "materials", "a dict of names and Materials", self.materials)
        for name, material in self.materials.items():
            good = isinstance(name, str) and isinstance(material, Material)
            require(good, f"materials.{name}", "a Material", material)
        all_of(self, "particles", ParticleFile, "a ParticleFile")
        all_of(self, "meshes", Mesh, "a Mesh")
        good = self.animation is None or isinstance(self.animation, Animation)
        require(good, "animation", "an Animation", self.animation)
        require(isinstance(self.film, Film), "film", "a Film", self.film)
        bar = self.film.colorbar and not self.film.legend
        good = not bar or self.film.colorbar_clim is not None or len(self.particles) > 0
        require(good, "film.colorbar_clim", "two numbers beside colorbar", None)
        good = (
            self.film.axes != "abc" or self.film.axes_edges is not None or len(self.particles) > 0
        )
        require(good, "film.axes_edges", "three rows beside axes of abc", None)
        good = self.film.scalebar is None or self.camera.orthographic
        require(good, "film.scalebar", "none with a perspective camera", self.film.scalebar)
        count(self, "max_depth", 1, MAX_DEPTH)
        number(self, "shadow_bias", "a finite number, at least 0", lambda bias: bias >= 0)
        count(self, "samples", 1, MAX_SAMPLES)
        switches(self, "indirect")
        for key in _spread_light(self):
            require(self.shadow_bias == 0, "shadow_bias", f"0 beside {key}", self.shadow_bias)
        known = {*self.materials, *STYLE_NAMES}
        unknown = [
            *_unknown_materials(self, "spheres", Sphere, Spheres),
            *_unknown_materials(self, "capsules", Capsule, Capsules),
            *(
                (f"meshes[{i}].material", one.material)
                for i, one in enumerate(self.meshes)
                if one.material not in self.materials
            ),
            *(
                (f"particles[{i}].material", one.material)
                for i, one in enumerate(self.particles)
                if one.material not in known
            ),
        ]
        for where, name in unknown:
            require(False, where, f"the name of a material ({some(self.materials)})", name)
        for key, used in (
            ("capsules", Capsules.of(self.capsules).used if len(self.capsules) else ()),
            ("meshes", [mesh.material for mesh in self.meshes]),
        ):
            for name in used:
                expected = f"0 where there are {key}"
                require(self.shadow_bias == 0, "shadow_bias", expected, self.shadow_bias)
                glass, where = self.materials[name].transmission, f"materials.{name}.transmission"
                require(glass == 0, where, f"0 of a material of {key}", glass)
        for key in translucency(self):
            require(self.shadow_bias == 0, "shadow_bias", f"0 beside {key}", self.shadow_bias)
            require(not self.indirect, "indirect", f"false beside {key}", self.indirect)
            for name, one in self.materials.items():
                where = f"materials.{name}.transmission"
                require(one.transmission == 0, where, f"0 beside {key}", one.transmission)
        mirrors = {name for name, one in self.materials.items() if one.reflection > 0}
        for i in _translucent(self.spheres, mirrors):
            expected = "1 beside reflection of its material"
            require(False, f"spheres[{i}].opacity", expected, self.spheres[i].opacity)

    @property
    def is_random(self) -> bool:
        """Whether rays are drawn at random, so that each pixel needs many. Round lights alone do
        not make them so: what spheres hide of them has a closed form. What others do has none."""
        occluded = any(getattr(light, "occlusion", False) is True for light in self.lights)
        spread = occluded or self.camera.has_lens or self.is_glossy or self.is_indirect
        is_round = any(getattr(light, "is_round", False) for light in self.lights)
        return spread or (is_round and len(self.capsules) + len(self.meshes) > 0)

    @property
    def is_glossy(self) -> bool:
        """Whether paths go on from rough mirrors."""
        return self.max_depth > 1 and any(m.is_glossy for m in self.materials.values())

    @property
    def is_indirect(self) -> bool:
        """Whether paths go on from diffuse surfaces."""
        return self.max_depth > 1 and self.indirect


def _unknown_materials(
    scene: Scene, key: str, one: type[msgspec.Struct], many: type[Rows[Any]]
) -> Iterator[tuple[str, str]]:
    """Checks what stands under a key, one by one or as arrays. Gives where materials are named that
    the scene has not, and their names."""
    given = getattr(scene, key)
    if isinstance(given, many):
        named = given.with_names(tuple(scene.materials))
        force_setattr(scene, key, named)
        for name in named.names or ():
            if name not in scene.materials:
                yield f"{key}.material", name
        return
    all_of(scene, key, one, f"a {one.__name__}")
    for i, thing in enumerate(getattr(scene, key)):
        if thing.material not in scene.materials:
            yield f"{key}[{i}].material", thing.material


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
    know all. Precision "literal" and the truth "seed" refuse such a key."""
    for name, material in scene.materials.items():
        if material.transmission > 0:
            return f"transmission of materials.{name}"
    for key in translucency(scene):
        return key
    for key in ("capsules", "meshes"):
        if len(getattr(scene, key)):
            return key
    return beyond_one_ray(scene) or ("samples > 1" if scene.samples > 1 else None)


def translucency(scene: Scene) -> Iterator[str]:
    """The keys that let surfaces be seen through."""
    for name, material in scene.materials.items():
        if material.opacity < 1:
            yield f"opacity of materials.{name}"
    for i in _translucent(scene.spheres, scene.materials):
        yield f"opacity of spheres[{i}]"


def _translucent(spheres: Sequence[Sphere], names: Container[str]) -> Iterator[int]:
    """The first of the spheres of those materials that can be seen through by themselves, if there
    is one."""
    if not isinstance(spheres, Spheres):
        found = [i for i, one in enumerate(spheres) if one.opacity < 1 and one.material in names]
    elif spheres.opacity is None:
        found = []
    else:
        of_them = np.array([name in names for name in spheres.names or ()], bool)
        found = np.flatnonzero((spheres.opacity < 1) & of_them[spheres.material_index]).tolist()
    yield from found[:1]


def _spread_light(scene: Scene) -> Iterator[str]:
    """The keys that let a point get light from more than single points."""
    for i, light in enumerate(scene.lights):
        for key in ("radius", "half_angle", "occlusion"):
            if getattr(light, key, 0):
                yield f"{key} of lights[{i}]"
    if scene.indirect:
        yield "indirect"

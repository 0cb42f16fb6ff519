"""World: what of a scene does not depend on its camera: things, materials, lights."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from clrt.renderer import glass
from clrt.renderer.pack import lights, meshes, spheres
from clrt.renderer.pack.structs import (
    COLORS,
    MAX_COLOR,
    MAX_EXPONENT,
    PRECISIONS,
    Array,
    Precision,
    Real,
    material_dtype,
    medium_dtype,
    overflow,
    shade_dtype,
)
from clrt.scene.camera import Camera
from clrt.scene.capsules import Capsule, Capsules
from clrt.scene.light import AmbientLight, LightKind, Shining
from clrt.scene.material import Material
from clrt.scene.mesh import Mesh
from clrt.scene.rows import Rows
from clrt.scene.scene import Scene
from clrt.scene.spheres import Sphere, Spheres
from clrt.values import BLACK


@dataclass(frozen=True)
class World:
    """Of a scene, packed."""

    precision: Precision
    given: tuple[Sequence[Sphere], Sequence[Capsule], Sequence[Mesh]]
    lights: Sequence[LightKind]
    materials: dict[str, Material]
    spheres: Spheres
    capsules: Capsules
    meshes: Sequence[Mesh]
    shining: tuple[Shining, ...]
    """The lights that cast shadows."""
    skies: tuple[AmbientLight, ...]
    """Ambient light that what is near hides."""
    material_of: Array
    """(things,) int32: the index of each one's material, of spheres, capsules, faces."""
    light_inside: Array
    """int64: the spheres that a light is inside of, in order."""
    packed_materials: Array
    shades: Array
    """(shining lights, materials), then a row for ambient light that reaches every point, if there
    is any, then one for each of the skies."""
    colors: Array | None
    """(things, 3) of real, if some have their own."""
    is_translucent: bool
    """Whether some can be seen through."""
    glass: Array | None
    """(things,) of glass_dtype, if shadow rays lose a part of their light to some."""
    nest: int
    """How many transparent spheres a ray can be inside of at once."""
    of_faces: dict[str, Array]
    """More of the kernel's arguments: what of faces does not depend on the camera."""
    gone: Array
    """Indices of things that are as if they were not there."""

    @cached_property
    def mesh_sizes(self) -> Array:
        """(meshes,): the longest side of the box around each, in the world's unit."""
        return meshes.sizes(self.meshes)

    @cached_property
    def radii(self) -> Array:
        """(things,) in the world's unit."""
        if not len(self.capsules) and not self.meshes:
            return self.spheres.radius
        # Of a face a tenth of its mesh's longest side, for outlines of folds.
        faces = np.repeat(self.mesh_sizes / 10, list(map(len, self.meshes)))
        parts = [self.spheres.radius, self.capsules.radius, faces]
        return np.concatenate(parts)

    def is_of(self, scene: Scene) -> bool:
        """Whether it is this scene's: by identity of what can be many."""
        return self.has_things_of(scene) and self.lights == scene.lights

    def has_things_of(self, scene: Scene) -> bool:
        """Whether it is this scene's but for its lights."""
        spheres, capsules, meshes = self.given
        return (
            spheres is scene.spheres
            and capsules is scene.capsules
            and meshes is scene.meshes
            and self.materials == scene.materials
        )

    def media(self, camera: Camera) -> Array:
        """The transparent spheres that a camera is inside of, the smallest first: (n,) of
        medium_dtype."""
        real = PRECISIONS[self.precision]
        if self.glass is None:
            return np.zeros(0, medium_dtype(real))
        inside = glass.around(camera, self.spheres, self.glass["order"][: len(self.spheres)] > 0)
        inside = np.setdiff1d(inside, self.gone, assume_unique=True)
        found = np.zeros(len(inside), medium_dtype(real))
        found["sphere"] = inside + 1
        found["order"] = self.glass["order"][inside]
        found["ior"] = self.packed_materials["ior"][self.material_of[inside]]
        found[::-1].sort(order="order")
        return found


def pack_world(scene: Scene, precision: Precision) -> World:
    """Packs what does not depend on the camera."""
    real = PRECISIONS[precision]
    materials = list(scene.materials.values())
    many, capsules = Spheres.of(scene.spheres), Capsules.of(scene.capsules)
    # Buffers of none cannot be made, and vertices of no face are nowhere in the picture.
    surfaces = [mesh.trimmed() for mesh in scene.meshes if len(mesh)]
    index = {name: i for i, name in enumerate(scene.materials)}
    material_of = np.concatenate(
        [
            np.array([index[name] for name in things.names or ()], np.int32)[things.material_index]
            for things in (many, capsules)
        ]
        + [meshes.per_face(surfaces, [index[mesh.material] for mesh in surfaces])]
    )
    opacity = spheres.opacities(materials, material_of, many)
    panes, nest, gone = spheres.panes(materials, material_of, many, opacity, real)
    with overflow(precision):
        packed_materials = _materials(materials, precision)
        colors = _colors([many, capsules, *surfaces], real)
        of_faces = meshes.arguments(surfaces, len(many) + len(capsules), real)
    return World(
        precision=precision,
        given=(scene.spheres, scene.capsules, scene.meshes),
        materials=dict(scene.materials),
        spheres=many,
        capsules=capsules,
        meshes=surfaces,
        material_of=material_of,
        packed_materials=packed_materials,
        colors=colors,
        is_translucent=opacity is not None,
        glass=panes,
        nest=nest,
        of_faces=of_faces,
        gone=gone,
        **_lit(scene, materials, many, precision),
    )


def relit(world: World, scene: Scene) -> World:
    """The world of a scene that has the same things, and other lights."""
    return replace(
        world, **_lit(scene, list(world.materials.values()), world.spheres, world.precision)
    )


def _lit(
    scene: Scene, materials: list[Material], many: Spheres, precision: Precision
) -> dict[str, Any]:
    """What of a world depends on lights. materials: in its order."""
    shining = tuple(light for light in scene.lights if not isinstance(light, AmbientLight))
    ambient = [light for light in scene.lights if isinstance(light, AmbientLight)]
    open_ambient = [light for light in ambient if not light.occlusion]
    skies = tuple(light for light in ambient if light.occlusion)
    with overflow(precision):
        shades = _shades(materials, shining, open_ambient, skies, precision)
    inside = lights.encloses(many.center, many.radius, shining).any(axis=0)
    return {
        "lights": scene.lights,
        "shining": shining,
        "skies": skies,
        "light_inside": np.flatnonzero(inside),
        "shades": shades,
    }


def _colors(parts: Sequence[Rows[Any] | Mesh], real: Real) -> Array | None:
    """(things, 3), if some have their own; the others are white, as faces whose corners have."""
    colors = [part.colors if isinstance(part, Mesh) else part.color for part in parts]
    if all(color is None for color in colors):
        return None
    found = np.ones((sum(map(len, parts)), 3), real)
    start = 0
    for part, color in zip(parts, colors, strict=True):
        if color is not None and not (isinstance(part, Mesh) and part.has_vertex_colors):
            found[start : start + len(part)] = np.clip(color, -MAX_COLOR, MAX_COLOR)
        start += len(part)
    return found


def _materials(materials: Sequence[Material], precision: Precision) -> Array:
    """(materials,) of material_dtype."""
    wide = np.longdouble
    found = np.zeros(len(materials), material_dtype(PRECISIONS[precision]))
    found["exponent"] = list(map(_exponent, materials))
    for name in ("reflection", "transmission", "ior", "fresnel"):
        found[name] = [getattr(m, name) for m in materials]
    sine = np.array([m.roughness for m in materials], wide)
    found["spread"] = sine**2 / (1 + np.sqrt(1 - sine**2))
    diffuse = np.array([m.diffuse for m in materials], wide).reshape(-1, 3)
    found["diffuse"] = np.clip(diffuse, 0, MAX_COLOR)
    return found


def _exponent(material: Material) -> float:
    """As the kernel takes it, see Material of shading.cl."""
    if material.highlight == "phong":
        return -min(material.shininess / 2, MAX_EXPONENT)
    return min(material.shininess / 8, MAX_EXPONENT)


def _shades(
    materials: Sequence[Material],
    shining: Sequence[Shining],
    ambient: Sequence[AmbientLight],
    skies: Sequence[AmbientLight],
    precision: Precision,
) -> Array:
    """What each material makes of each light, see World.shades. ambient: the ambient light that
    reaches every point."""
    wide = np.longdouble
    rows = len(shining) + bool(ambient) + len(skies)
    found = np.zeros((rows, len(materials)), shade_dtype(PRECISIONS[precision]))
    for color in COLORS:
        of_material = np.array([getattr(m, color) for m in materials], wide).reshape(-1, 3)
        of_lights = [getattr(light, color) for light in shining]
        from_all_sides = [np.sum([light.ambient for light in ambient], axis=0)] if ambient else []
        from_all_sides += [sky.ambient for sky in skies]
        of_lights += [light if color == "ambient" else BLACK for light in from_all_sides]
        for row, of_light in zip(found[color], of_lights, strict=True):
            row[:] = np.clip(of_material * np.array(of_light, wide), -MAX_COLOR, MAX_COLOR)
    return found

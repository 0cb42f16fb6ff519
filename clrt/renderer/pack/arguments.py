"""Arguments: what the kernel is given for a picture."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from clrt.errors import RequestError
from clrt.renderer import samples
from clrt.renderer.pack import capsules, lights, meshes, spheres
from clrt.renderer.pack.features import Features, base_samples, has_tree, starts_ahead
from clrt.renderer.pack.structs import (
    AXES,
    LEAST_FACE,
    LEAST_RADIUS,
    MAX_COLOR,
    MAX_DISTANCE,
    PRECISIONS,
    SPECK,
    Array,
    camera_dtype,
    medium_dtype,
    overflow,
)
from clrt.renderer.pack.world import World
from clrt.scene import lens
from clrt.scene.camera import Camera
from clrt.scene.light import DirectionalLight
from clrt.scene.scene import Scene

NUMBERS = ("top", "from", "count", "samples", "sky_count", "first_capsule", "first_face")
ORDER = (
    *("paths", "top", "list", "from", "count", "samples", "points", "table"),
    *("max_depth", "shadow_bias", "camera", "sphere_count", "spheres"),
    *("material_count", "materials", "light_count", "lights", "shades", "encloses"),
    *("sky_count", "skies", "background", "sphere_colors", "glass", "around", "lost"),
    *("ids", "materials_of", "beads", "nodes", "leaves", "shape"),
    *("first_capsule", "capsules", "capsule_nodes", "capsule_leaves", "capsule_shape"),
    *("first_face", "faces", "looks", "corners", "vertex_normals", "vertex_colors"),
    *("face_nodes", "face_leaves", "face_shape"),
)
"""The kernel's arguments from `paths` on, see render.cl."""
KEPT = (
    *("sphere_colors", "glass", "materials_of"),
    *("looks", "corners", "vertex_normals", "vertex_colors"),
)
"""Those that are a world's own: they depend on no camera and no light, and can be large."""
NOTHING: dict[str, Any] = {name: np.int32(0) if name in NUMBERS else None for name in ORDER}
"""Of a scene that needs none of them: no buffer, and nothing to count."""

BATCH = 16
"""samples.cl: so many samples between two looks whether they are enough."""
BOUNCES, KINDS, SKY_RAYS = 4, 4, 4
"""draw.cl: for how many bounces there are numbers, of how many kinds beside those for skies, and
how many rays each of these gets."""


NEAR = 4
"""So many times the median radius away are spheres that hide ambient light in closed form."""


def sampling(features: Features, scene: Scene) -> dict[str, Any]:
    """More of a program's arguments: how many samples a pixel gets, and where they lie in it, see
    clrt.samples.offsets(). Where they are the lanes, x of as many as there are lanes, then y, in
    whole rounds."""
    if not (features.refine or features.gather):
        return {}
    lanes = features.lanes if features.refine else 1
    count = base_samples(scene) if features.hashed else scene.samples
    found = np.zeros((-(-count // BATCH) * BATCH, 2), PRECISIONS[features.precision])
    found[:count] = samples.offsets(count)
    laid = np.ascontiguousarray(found.reshape(-1, lanes, 2).transpose(0, 2, 1))
    more = {"samples": np.int32(count), "points": laid}
    if features.is_random:
        others = samples.table(len(found), BOUNCES * KINDS, first=1)
        skies = samples.table(SKY_RAYS * len(found), BOUNCES, first=1 + BOUNCES * KINDS)
        more["table"] = np.concatenate([others.reshape(-1, 2), skies.reshape(-1, 2)])
    return more


@dataclass(frozen=True)
class Space:
    """The kernel's space: the camera's, or, with a tree, the world's axes with the origin at the
    camera. All of long double, which has the digits for r = 1e9 where it is wider than float64, and
    the range for 1e300."""

    origin: Array
    """(3,) in the world."""
    turn: Array
    """(3, 3): its axes."""
    scale: Any
    """A power of two. Times this the spheres reach about 1 from the origin."""
    extent: Any
    """How far they reach, not scaled."""

    def of(self, points: Array) -> Array:
        """(n, 3) points of the world, not scaled."""
        turned: Array = (points - self.origin) @ self.turn.T
        return turned


@dataclass(frozen=True)
class Listed:
    """The spheres of the kernel's list: all, or with a tree those that it cannot hold."""

    ids: Array | None
    """Their places in the scene's list; None: they are that list."""
    center: Array
    """(n, 3) in the kernel's space, not scaled."""
    radius: Array
    material_of: Array


def arguments_of(world: World, scene: Scene, width: int, height: int) -> dict[str, Any]:
    """The kernel's arguments for a picture of width x height pixels, by name and in its order, from
    `paths` on: NumPy scalars, and arrays that become buffers. Any program takes them: those that
    the scene has no use for are 0 and None. sampling() says how a program's pixels are sampled.

    Lengths are scaled by a power of two, which is exact and cannot be seen: neither the squares of
    spheres nor those of anything larger than 1e-19 of their extent leave float32's range. "literal"
    leaves the scene where and as large as it is in the world, and treats no sphere in a special
    way. Everything is rounded once.

    With trees `beads` has all spheres, `capsules` all capsules and `faces` all faces;
    clrt.opencl.tree adds nodes, leaves and shape of each kind. Whoever runs the kernel adds
    `paths`, `top` and `lost`: in how many packets rays needed more room than there is, two numbers
    (enter() of glass.cl, put_aside() of onward.cl).

    Raises:
        RequestError: some things are so far that the precision cannot show others, which are near.
    """
    real = PRECISIONS[world.precision]
    screen = lens.half_screen(scene.camera, width, height)
    space, listed = _space(world, scene, screen)
    bias = float(space.scale * min(scene.shadow_bias, MAX_DISTANCE * space.extent))
    with overflow(world.precision):
        camera = _camera(world, scene, space, screen, (width, height))
        of_lights = lights.pack_lights(
            world.shining, space.origin, space.turn, space.scale, space.extent, real
        )
        of_spheres = _spheres(world, scene, space, listed, bias)
        shadow_bias = real(bias)
    chosen = slice(None) if listed.ids is None else listed.ids
    center, radius = world.spheres.center[chosen], world.spheres.radius[chosen]
    found = NOTHING | {
        "max_depth": np.int32(scene.max_depth),
        "shadow_bias": shadow_bias,
        "camera": camera,
        "sphere_count": np.int32(len(of_spheres)),
        "spheres": of_spheres,
        "material_count": np.int32(len(world.packed_materials)),
        "materials": world.packed_materials,
        "light_count": np.int32(len(of_lights)),
        "lights": of_lights,
        "shades": world.shades,
        "encloses": lights.encloses(center, radius, world.shining),
        "background": np.clip(scene.film.background, -MAX_COLOR, MAX_COLOR).astype(real),
        "sphere_colors": world.colors,
        "glass": world.glass,
    }
    if world.skies:
        far = np.array([light.distance for light in world.skies], np.longdouble)
        if not any(sky.occlusion is True for sky in world.skies) and len(world.spheres):
            far = np.minimum(far, NEAR * world.spheres.median_radius)
        found["sky_count"] = np.int32(len(far))
        found["skies"] = np.minimum(space.scale * far, np.finfo(real).max).astype(real)
    if world.nest:
        media = world.media(scene.camera)
        found["around"] = np.zeros(world.nest, medium_dtype(real))
        found["around"][: len(media)] = media[: world.nest]
    if listed.ids is not None:
        beads = spheres.beads(
            world.spheres, space.origin.astype(np.float64), float(space.scale), real
        )
        n = len(world.spheres)
        beads[listed.ids, 3] = beads[world.gone[world.gone < n], 3] = np.nan
        if not n:  # OpenCL has no empty buffers: one that is not there
            beads = np.full((1, 4), np.nan, real)
        found["ids"] = listed.ids.astype(np.int32)
        found |= {"materials_of": world.material_of, "beads": beads}
        if len(world.capsules):
            rows = capsules.rows(
                world.capsules, space.origin.astype(np.float64), float(space.scale), real
            )
            gone = world.gone[(world.gone >= n) & (world.gone < n + len(rows))]
            rows[gone - n, 3] = np.nan
            found |= {"first_capsule": np.int32(n), "capsules": rows}
        if world.meshes:
            first = n + len(world.capsules)
            rows = meshes.rows(
                world.meshes, space.origin.astype(np.float64), float(space.scale), real
            )
            rows[world.gone[world.gone >= first] - first, 9] = np.nan
            found |= {"first_face": np.int32(first), "faces": rows, **world.of_faces}
    return found


def _space(world: World, scene: Scene, screen: Array) -> tuple[Space, Listed]:
    """The kernel's space, and which spheres are listed in it. screen: see lens.half_screen()."""
    literal, many = world.precision == "literal", has_tree(world)
    wide: Any = np.longdouble
    eye, basis = np.array(scene.camera.position, wide), np.array(scene.camera.basis(), wide)
    origin = np.zeros(3, wide) if literal else eye
    ahead = wide(0)  # how far from the camera rays start
    if (scene.camera.orthographic and not literal) or starts_ahead(world, scene.camera):
        kind = np.float64 if many else wide
        ahead = lens.start(scene.camera, world.spheres, world.capsules, world.meshes, screen, kind)
        origin = origin - ahead * basis[2]
    space = Space(origin, np.identity(3, wide) if many else basis, wide(1), wide(1))
    ids = None
    if many:
        here = origin.astype(np.float64)
        reach, giants = spheres.reach(world.spheres, here)
        reach = max(reach, capsules.reach(world.capsules, here))
        reach = max(reach, meshes.reach(world.meshes, here))
        listed = np.zeros(len(world.spheres), np.bool_)
        listed[giants] = listed[world.light_inside] = True
        if scene.camera.orthographic:
            # The tree's rays have a start.
            listed[lens.behind(scene.camera, world.spheres, screen, ahead)] = True
        ids = np.flatnonzero(listed)
    chosen = slice(None) if ids is None else ids
    center = space.of(world.spheres.center[chosen].astype(wide))
    radius = world.spheres.radius[chosen].astype(wide)
    if not many:
        reach = spheres.extent(center, radius)
    located = [light.position for light in world.shining if not isinstance(light, DirectionalLight)]
    distance = np.linalg.norm(space.of(np.array(located, wide).reshape(-1, 3)), axis=1)
    extent: Any = wide(reach or distance.max(initial=0) or 1)
    scale = wide(1) if literal else np.ldexp(wide(1), -np.frexp(extent)[1])
    if not literal:
        _require_in_range(world, scene.camera, extent)
    space = Space(origin, space.turn, scale, extent)
    return space, Listed(ids, center, radius, world.material_of[chosen])


def _require_in_range(world: World, camera: Camera, extent: Any) -> None:
    """Raises RequestError: a sphere or a capsule that the camera sees is lost beside the farthest,
    which is no giant, or a mesh."""
    _require_meshes_in_range(world, camera, extent)
    radii = world.radii[: len(world.spheres) + len(world.capsules)]
    least = LEAST_RADIUS[PRECISIONS[world.precision]] * extent
    if not len(radii) or np.min(radii) >= least:
        return
    small = np.flatnonzero(radii < least)
    radius = radii[small].astype(np.longdouble)
    if camera.orthographic:
        across = np.longdouble(camera.height)
    else:
        n = len(world.spheres)
        place = np.array(
            [*world.spheres.center[small[small < n]], *world.capsules.start[small[small >= n] - n]],
            np.longdouble,
        )
        across = np.linalg.norm(place - camera.position, axis=1)
    seen = small[radius > SPECK * across]
    if len(seen):
        what = "sphere" if seen[0] < len(world.spheres) else "capsule"
        raise _lost(world, f"{what} of radius {radii[seen[0]]:.3g}", extent)


def _require_meshes_in_range(world: World, camera: Camera, extent: Any) -> None:
    """Raises RequestError: so is a mesh, of which a face is judged by what the mean one has of the
    space that the mesh takes."""
    count = np.array(list(map(len, world.meshes)), np.longdouble)
    least = LEAST_FACE[PRECISIONS[world.precision]] * extent * np.cbrt(count)
    for k in np.flatnonzero(world.mesh_sizes < least).tolist():
        place = world.meshes[k].vertices[0].astype(np.longdouble)
        across = camera.height or np.linalg.norm(place - camera.position)
        if world.mesh_sizes[k] > SPECK * across:
            raise _lost(world, f"mesh of size {world.mesh_sizes[k]:.3g}", extent)


def _lost(world: World, what: str, extent: Any) -> RequestError:
    wanted = "double" if world.precision == "robust" else "the farthest things nearer"
    return RequestError(  # as words: a float64 may not hold the extent
        f"precision: {world.precision} cannot show a {what} and one that reaches "
        f"{np.format_float_scientific(extent, 2)} from the camera, expected {wanted}"
    )


def _camera(
    world: World, scene: Scene, space: Space, screen: Array, size: tuple[int, int]
) -> Array:
    """(1,) of camera_dtype."""
    real, scale, most = PRECISIONS[world.precision], space.scale, MAX_DISTANCE * space.extent
    found = np.zeros(1, camera_dtype(real))
    found["last"] = np.maximum([size[0] - 1, size[1] - 1], 1)
    if scene.camera.orthographic:
        screen = scale * np.minimum(screen, most)
    found["step"] = screen / found["last"]
    found["eye"] = scale * space.of(np.array(scene.camera.position, np.longdouble).reshape(1, 3))
    if scene.camera.has_lens:
        found["aperture"] = scale * np.minimum(scene.camera.aperture_radius, most)
        found["inv_focus"] = 1 / (scale * np.clip(scene.camera.focus_distance or 0, 1 / most, most))
    found["unit"] = np.minimum(1 / scale, np.finfo(real).max)
    for axis, vector in zip(AXES, np.array(scene.camera.basis(), np.longdouble), strict=True):
        found[axis] = vector
    return found


def _spheres(world: World, scene: Scene, space: Space, listed: Listed, bias: float) -> Array:
    """The listed spheres, (n,) of sphere_dtype. bias: scaled."""
    center, radius = space.scale * listed.center, space.scale * listed.radius
    literal = world.precision == "literal"
    found = spheres.pack_spheres(center, radius, bias, PRECISIONS[world.precision], literal)
    found["screen_bounds"] = lens.bounds(scene.camera, center, radius)
    found["material"] = listed.material_of
    gone = world.gone if listed.ids is None else np.isin(listed.ids, world.gone)
    found["c0"][gone], found["camera_c"][gone] = np.inf, -1  # no ray meets it
    return found

"""Trials: whether a new program is right.

It renders a small picture of a scene that needs just what it was compiled for, and the picture is
compared with the reference (benchmarks/NOTES.md: 4 ms). A program that is wrong is never used, see
clrt/renderer/maker.py.
"""

from typing import TYPE_CHECKING, Literal

import numpy as np
from msgspec.structs import replace

from clrt.errors import DeviceError
from clrt.film import metrics
from clrt.opencl import bands, edges, pocl, program
from clrt.renderer import samples
from clrt.renderer.dispatch import Dispatcher
from clrt.renderer.pack.arguments import BATCH, sampling
from clrt.renderer.pack.features import TREE_FROM, Features
from clrt.renderer.pack.structs import FILMS, PRECISIONS, Array
from clrt.scene.camera import Camera
from clrt.scene.capsules import Capsule
from clrt.scene.film import Film
from clrt.scene.light import AmbientLight, Light, LightKind, SpotLight
from clrt.scene.material import Material
from clrt.scene.mesh import Mesh, Shading
from clrt.scene.scene import Scene
from clrt.scene.spheres import Sphere
from clrt.truth import tracer
from clrt.truth.denoise import denoised
from clrt.values import BLACK

if TYPE_CHECKING:
    import pyopencl as cl

SIZE = (101, 13)  # whole packets and a part of one
SAMPLED_SIZE, SAMPLES = (37, 5), 17  # a whole round and a part of one


def try_here(device: "cl.Device", source: str, features: Features) -> bytes:
    """The binary of a program that is compiled and tried in this process: a compiler that crashes
    takes the process with it.

    Raises:
        DeviceError: the program is wrong. The message says so, as the end of a sentence.
    """
    with pocl.linking():
        return _try_here(device, source, features)


def _try_here(device: "cl.Device", source: str, features: Features) -> bytes:
    import pyopencl as cl

    context = cl.Context([device])
    profiling = cl.command_queue_properties.PROFILING_ENABLE
    queue = cl.CommandQueue(context, properties=profiling)
    built = program.compiled(context, device, source, features.options)
    scene, kernels = scene_for(features), program.kernels(built)
    width, height = size = size_for(features)
    dispatcher = Dispatcher(queue, features.precision)
    arguments = dispatcher.arguments(scene, width, height, (features, kernels), 0)
    if features.refine:
        dtype, channels = FILMS[features.film]
        film = np.empty((height, width, channels), dtype)
        everywhere = bands.upload(context, {"paths": np.arange(film.size, dtype=np.uint32)})
        arguments = arguments | sampling(features, scene)
        if features.nest:
            arguments["lost"] = np.zeros(2, np.int32)
        paths = everywhere["paths"]
        edges.refine(film, (0, 0), (0, 0, *size), paths, queue, kernels, arguments, 1)
    else:
        film, _ = dispatcher.exposed([(features, kernels)], scene, arguments, size, (0, 0, *size))
    if features.film == "guides":
        clear, _ = dispatcher.denoised((features, kernels), scene, arguments, film[..., 0])
        filtered = denoised(film[..., 0], scene.samples, float(arguments["camera"]["step"][0, 0]),
                            features.orthographic)  # fmt: skip
        if wrong := int((abs(clear - filtered).max(axis=2) > metrics.QUARTER_STEP).sum()):
            raise DeviceError(f"its compiler filters {wrong} of {width * height} pixels wrongly")
    if wrong := wrong_pixels(film, scene, features):
        raise DeviceError(f"its compiler is wrong about {wrong} of {width * height} pixels")
    return program.binary(built)


def size_for(features: Features) -> tuple[int, int]:
    """Of the picture: the truth of one with samples takes as many times as long."""
    return SAMPLED_SIZE if features.refine or features.gather else SIZE


def scene_for(features: Features) -> Scene:
    """A scene that needs just these features.

    A plane, which is a giant but for "literal", mirrors and shadows of two lights.
    """
    literal = features.precision == "literal"
    shine = 0.4 * features.reflection
    matte = Material((0.1, 0.0, 0.05), (0.6, 0.2, 0.3), (1, 1, 1), 40, shine)
    ground = Material((0.1, 0.1, 0.1), (0.5, 0.5, 0.4), (0.2, 0.2, 0.2), 9, shine / 2)
    if features.phong:
        ground = replace(ground, highlight="phong")
    fade = (0.5, 0.05, 0.02) if features.attenuation else (1, 0, 0)
    lights: list[LightKind] = [
        Light((4, 5, 3)),
        Light((-3.0, 2.5, 1.0), diffuse=(0.3, 0.3, 0.6), attenuation=fade),
    ]
    if features.spot:
        lights.append(SpotLight((0, 2, 2), (0, -0.5, 0), diffuse=(0.5, 0, 0), outer_angle=25))
    if features.round:  # as small as a point, which the truth knows; but next to an edge
        lights.append(Light((2, 4, 4), diffuse=(0.2, 0.5, 0.1), radius=1e-4))
    if features.ambient:
        lights.append(AmbientLight((0.3, 0.6, 0.3)))
    if features.occlusion or features.near:  # as far as nothing is
        how: Literal[True, "near"] = "near" if features.near else True
        lights.append(AmbientLight((0.1, 0.1, 0.3), occlusion=how, distance=1e-6))
    if features.gloss:
        matte, ground = (replace(m, roughness=1e-6) for m in (matte, ground))
    if features.light_inside:
        lights.append(Light((0.4, 0.1, -0.4), ambient=(0, 0, 0.1), specular=(0, 0, 0)))
    if features.indirect:  # from surfaces that send none; a mirror does nothing else
        matte, ground = replace(matte, reflection=0.0), replace(ground, diffuse=BLACK)
        black = {"ambient": BLACK, "diffuse": BLACK}
        lights = [
            replace(light, **{k: black[k] for k in black if hasattr(light, k)}) for light in lights
        ]
    clear = Material((0, 0.02, 0), (0, 0.1, 0), (0.5, 0.5, 0.5), 50, transmission=0.8)
    if features.split:
        clear = replace(clear, reflection=0.2, fresnel=True)
    radius = 20.0 if literal else 5000.0
    spheres: tuple[Sphere, ...] = (
        Sphere((-0.7, 0.0, -0.6), 0.5, "matte"),
        Sphere((0.4, 0.1, -0.4), 0.6, "matte"),
        Sphere((0.0, -0.35, 0.2), 0.15, "ground"),
        Sphere((0.0, -0.5 - radius, 0.0), radius, "ground"),
    )
    # Balls in balls, seen and shone through.
    spheres += tuple(
        Sphere((0.1, 0.05, 0.35), 0.3 / (k + 1), "clear") for k in range(features.nest)
    )
    if features.opacity:  # some around others, at equal places and before a mirror
        veils = ((-0.7, 0.0, -0.6, 0.6), (-0.7, 0.0, -0.6, 0.6), (0.3, 0.2, 0.3, 0.15),
                 (0.35, 0.2, 0.3, 0.15), (0.0, -0.35, 0.2, 0.2))  # fmt: skip
        spheres += tuple(
            Sphere((x, y, z), radius, "veil", opacity=1 - 0.15 * i)
            for i, (x, y, z, radius) in enumerate(veils)
        )
    if features.tree:  # a heap of beads, on and behind the others
        random = np.random.default_rng(1)
        beads = random.uniform((-1.2, -0.45, -1.5), (1.2, 0.2, 0.3), (2 * TREE_FROM, 3))
        spheres += tuple(Sphere(bead.tolist(), 0.06, "matte") for bead in beads)
    capsules: tuple[Capsule, ...] = ()
    if features.capsules:  # across the view, along it, tilted, with no length, before a mirror
        ends = ((-1.2, 0.3, -0.2), (0.1, 0.3, -0.2)), ((-0.2, 0.25, -1.0), (-0.2, 0.25, 0.5))
        tilted, ball = ((0.5, -0.4, 0.3), (1.1, 0.5, -0.5)), ((0.2, 0.35, 0.1), (0.2, 0.35, 0.1))
        capsules = tuple(
            Capsule(start, end, 0.07, "veil" if features.opacity else "matte")
            for start, end in (*ends, tilted, ball)
        )
        capsules += (Capsule((-0.2, -0.45, 0.0), (0.6, -0.4, 0.4), 0.02, "ground"),)
    if features.hashed and features.gather:  # most spheres are so small that nobody sees them
        speck = Sphere((0.0, 0.2, 0.0), 1e-6, "matte")
        spheres += (speck,) * (len(spheres) + len(capsules) + 1)
    if features.sphere_colors:
        spheres = tuple(
            replace(sphere, color=(1, 0.3 + 0.7 * (i % 2), 0.5)) for i, sphere in enumerate(spheres)
        )
    # The pictures have SIZE, so these are wide and low.
    away, fov = (14.0, 12.0) if features.long_lens else (2.0, 90.0)
    camera = Camera((0.0, 0.02 * away, away), (0.0, 0.0, 0.0), fov=fov)
    if features.orthographic:
        camera = Camera((0.0, 0.3, 0.5), (0.0, 0.2, 0.0), projection="orthographic", height=0.5)
    if features.lens:
        camera = replace(camera, aperture_radius=1e-7 * away, focus_distance=away)
    # The kernel's colours lack the background that the camera sees directly.
    film = Film((0.2, 0.5, 0.9), transparent=True) if features.background else Film()
    return Scene(
        camera,
        tuple(lights),
        {"matte": matte, "ground": ground}
        | ({"clear": clear} if features.nest else {})
        | ({"veil": replace(matte, opacity=0.6, reflection=0.0)} if features.opacity else {}),
        spheres,
        max_depth=3 if features.reflection else 1,
        shadow_bias=1e-3 * literal,
        film=film,
        indirect=features.indirect,
        capsules=capsules,
        meshes=_meshes(features) if features.faces else (),
        samples=SAMPLES if features.hashed or features.refine or features.gather else 1,
    )


def _meshes(features: Features) -> tuple[Mesh, ...]:
    """A closed one and one with two sides, of each shading that is asked for, before a mirror and a
    sphere."""
    asked: dict[Shading, bool] = {"phong": features.smooth, "gouraud": features.gouraud}
    shadings: list[Shading] = [name for name, wanted in asked.items() if wanted] or ["flat"]
    ends = np.concatenate([np.identity(3), -np.identity(3)])
    ball = [(i, j, k) if i + j + k in (3, 6) else (i, k, j) for i in (0, 3) for j in (1, 4)
            for k in (2, 5)]  # fmt: skip
    ball = [face if np.linalg.det(ends[list(face)]) > 0 else face[::-1] for face in ball]
    sheet = np.array([(0, 0, 0), (0.3, 0, 0.2), (0.3, 0.2, 0), (0, 0.25, 0.1)])
    colors = np.random.default_rng(2).uniform(0.2, 1, (6, 3)) if features.corner_colors else None
    found: list[Mesh] = []
    for i, shading in enumerate(shadings):
        material = "veil" if features.opacity else "matte"
        few = None if colors is None else colors[:4]
        apart = np.array((0.4 * i + 0.013, 0.007, 0))
        closed = 0.2 * ends + np.array((0.9, 0, 0.3)) + apart
        two_sided = sheet + np.array((-1.5, -0.2, 0.2)) + apart
        found.append(Mesh(closed, ball, None, colors, material, shading))
        found.append(Mesh(two_sided, [(0, 1, 2), (0, 3, 2)], None, few, material, shading))
    return tuple(found)


def wrong_pixels(film: Array, scene: Scene, features: Features) -> int:
    """How many pixels are off by more than rounding makes them, away from edges."""
    truth: tracer.Truth = "seed" if features.precision == "literal" else "exact"
    real = PRECISIONS[features.precision]
    wide, size = real if truth == "seed" else np.float64, size_for(features)
    scene = _as_known(scene)
    trace = tracer.trace(scene, *size, truth, wide)
    if features.film == "paths":
        off = film[..., 0] != trace.paths
    elif features.film == "passes":
        off = _wrong_passes(film[..., 0], trace)
    else:
        if features.film == "guides":
            film = film[..., 0]["color"]
        step = 1 / 255 if features.film == "bytes" else 0
        shown = film / np.float64(255) if features.film == "bytes" else film
        trues = [np.concatenate([trace.image, trace.alpha[..., np.newaxis]], axis=2)]
        if features.refine or features.gather:
            points = samples.offsets(int(sampling(features, scene)["samples"]))
            # Of a pixel whose first samples are enough the mean is theirs.
            ends = (BATCH, len(points)) if features.refine else (len(points),)
            trues = [tracer.mean(scene, *size, points[:end]) for end in ends]
        if features.film not in ("alpha", "guides"):
            trues = [true[..., :3] for true in trues]
        error = np.min([metrics.pixel_error(shown, true) for true in trues], axis=0)
        off = error > step / 2 + metrics.QUARTER_STEP
    return int((off & ~metrics.edges(trace.paths)).sum())


def _as_known(scene: Scene) -> Scene:
    """What the truth knows that looks the same: lights, apertures and roughness are so small that
    they are none, and no sphere is near enough to be in the way of the sky."""
    lights: list[LightKind] = []
    for light in scene.lights:
        if isinstance(light, Light | SpotLight):
            light = replace(light, radius=0.0)
        elif isinstance(light, AmbientLight):
            light = replace(light, occlusion=False)
        lights.append(light)
    materials = {name: replace(m, roughness=0.0) for name, m in scene.materials.items()}
    camera = replace(scene.camera, aperture_radius=0.0)
    return replace(scene, lights=tuple(lights), materials=materials, camera=camera, indirect=False)


def _wrong_passes(film: Array, trace: tracer.Trace) -> Array:
    seen = trace.id >= 0
    depth = np.where(seen, trace.depth, 0)
    off = (film["id"] != trace.id) | ((film["depth"] < np.inf) != seen)
    off |= abs(np.where(seen, film["depth"], 0) - depth) > metrics.QUARTER_STEP * (1 + abs(depth))
    wrong: Array = off | (abs(film["normal"] - trace.normal).max(axis=2) > metrics.QUARTER_STEP)
    return wrong

"""Passes and alpha: what the camera sees first, against the reference's hits."""

from typing import Any

import numpy as np
import pyopencl as cl
import pytest
from conftest import renderer_for
from hard_cases import CASES, PROGRAMS, HardCase, is_common, program_of
from msgspec.structs import replace
from test_numerics import WIDE, renderer_of

import clrt
from clrt import reference
from clrt.figure.rendering import Renderer
from clrt.film import metrics
from clrt.renderer.pack.features import LANES

U = 2.0**-24
# float32 has no such depths, nor long double more digits than float64 everywhere.
MEASURED = [c for c in CASES if "180" not in c.name and (c.dtype == np.float64 or WIDE)]


def rays(scene: clrt.Scene, width: int, height: int) -> tuple[np.ndarray, np.ndarray]:
    """Origins and directions of the pixels' rays, in long double, (height, width, 3)."""
    wide = np.longdouble
    eye = np.array(scene.camera.position, wide)
    right, up, back = (np.array(axis, wide) for axis in scene.camera.basis())
    if scene.camera.height is not None:
        top, ahead = wide(scene.camera.height) / 2, 0
        half = top * width / height
    else:
        half, ahead = np.tan(np.radians(wide(scene.camera.fov or 0)) / 2), 1
        top = half * height / width
    x, y = np.meshgrid(np.linspace(-half, half, width), np.linspace(top, -top, height))
    at = x[..., np.newaxis] * right + y[..., np.newaxis] * up
    if not ahead:
        return eye + at, np.broadcast_to(-back, at.shape)
    through = at - back
    direction = through / np.linalg.norm(through, axis=2, keepdims=True)
    return np.broadcast_to(eye, at.shape), direction


# Passes and alpha depend on what the camera sees first alone. Of the cases whose passes one program
# makes, those of the commonest program for colours have alpha too.
COMMONEST = {
    program_of(case, "passes"): program_of(case)
    for case in sorted(MEASURED, key=lambda case: PROGRAMS[program_of(case)])
}


def tried(alpha: bool) -> list[Any]:
    """Cases, each with a precision."""
    found = []
    for case in MEASURED:
        commonest = COMMONEST[program_of(case, "passes")] == program_of(case)
        for precision in ["robust", "double"] if case in MEASURED[::8] else ["robust"]:
            own = not is_common(case)
            # What the camera sees first is glass or not, however the path goes on.
            if alpha and (
                not commonest or (own and ("glass" in case.name or precision == "double"))
            ):
                continue
            marks = [pytest.mark.slow] * (precision == "double" and own)
            found.append(pytest.param(case, precision, id=f"{case.name}-{precision}", marks=marks))
    return found


@pytest.mark.parametrize(("case", "precision"), tried(alpha=True))
def test_alpha_of_hard_cases(device: cl.Device, case: HardCase, precision) -> None:
    """It is where the camera sees something, and the colours are those without it."""
    renderer = renderer_of(device, precision, 16)
    image, passes = renderer.render(case.scene, *case.size, alpha=True, passes=["id"])
    assert ((image[..., 3] == 1) == (passes["id"] >= 0)).all()
    assert set(np.unique(image[..., 3])) <= {0, 1}
    assert (image[..., :3] == renderer.render(case.scene, *case.size)).all()


@pytest.mark.parametrize(("case", "precision"), tried(alpha=False))
def test_hard_cases(device: cl.Device, case: HardCase, precision) -> None:
    """A point at the depth is off its sphere by no more than some units in the last place of how
    far it is, and the normal is the direction in which it lies from the centre. The depth itself
    may be off by more where a ray grazes."""
    if case.limit and precision == "robust":
        pytest.skip(case.limit)
    renderer = renderer_of(device, precision, 16)
    _, passes = renderer.render(case.scene, *case.size, passes=("depth", "normal", "id"))
    sphere = passes["id"]
    seen = replace(case.scene, max_depth=1, lights=())  # what the camera meets: quick
    trace = reference.trace(seen, *case.size, "exact", case.dtype)
    flips = sphere != trace.id
    assert flips.sum() <= case.flips
    assert not (flips & ~metrics.edges(trace.id)).any()
    none = sphere < 0
    assert (passes["depth"][none] == np.inf).all()
    assert not passes["normal"][none].any()
    if none.all():
        return
    origin, direction = rays(case.scene, *case.size)
    point = origin[~none] + passes["depth"][~none][:, np.newaxis] * direction[~none]
    spheres = clrt.Spheres.of(case.scene.spheres)
    center = spheres.center.astype(np.longdouble)[sphere[~none]]
    radius = spheres.radius.astype(np.longdouble)[sphere[~none]]
    away, far = point - center, point - np.array(case.scene.camera.position)
    near = abs(np.linalg.norm(center - case.scene.camera.position, axis=1) - radius)
    unit = U * (np.linalg.norm(far, axis=1) + near)
    bound = 10 if precision == "robust" else 1
    assert (abs(np.linalg.norm(away, axis=1) - radius) / unit).max() < bound
    unit = U + unit / radius
    off = np.linalg.norm(passes["normal"][~none] - away / radius[:, np.newaxis], axis=1)
    assert (off / unit).max() < bound


TRIED = [
    (n, name, precision)
    for name in ("four-spheres", "sunflower")
    for precision in ("robust", "literal", "double")
    for n in (LANES if precision == "robust" else (1, 16))
]


@pytest.mark.parametrize(
    ("lanes", "name", "precision"),
    [
        pytest.param(
            *way,
            marks=[pytest.mark.slow]
            * (way[0] not in (1, 16) or way[1:] == ("four-spheres", "double")),
        )
        for way in TRIED
    ],
)
def test_every_number_of_lanes(device: cl.Device, lanes: int, name: str, precision) -> None:
    """With a tree, which `sunflower` has, and without. What else there is of so many lanes has
    mirrors that show a background: so has this."""
    film = clrt.Film((0.2, 0.5, 0.9), transparent=True)
    scene = replace(clrt.load_scene(name), film=film)
    truth: reference.Truth = "seed" if precision == "literal" else "exact"
    trace = reference.trace(scene, 101, 67, truth)
    renderer = renderer_of(device, precision, lanes)
    image, passes = renderer.render(scene, 101, 67, alpha=True, passes=("id", "normal", "depth"))
    assert list(passes) == ["id", "normal", "depth"]
    flips = passes["id"] != trace.id
    assert flips.sum() <= (30 if precision == "literal" else 1)
    assert ((image[..., 3] == 1) == (passes["id"] >= 0)).all()
    seen = ~flips & (trace.id >= 0)
    bound = 1e-2 if precision == "literal" else 1e-4
    assert abs(passes["depth"][seen] / trace.depth[seen] - 1).max() < bound
    assert abs(passes["normal"][seen] - trace.normal[seen]).max() < bound
    if precision != "literal":
        assert abs(passes["normal"][seen]).max() > 0.9


def test_a_turned_camera_has_normals_in_the_world(device: cl.Device) -> None:
    scene = replace(
        clrt.load_scene("four-spheres"),
        camera=clrt.Camera((2.0, 1.5, 2.5), (0.1, -0.4, -0.3), up=(0.2, 1.0, 0.1), fov=42.0),
    )
    trace = reference.trace(scene, 101, 67)
    for precision in ("robust", "literal"):
        _, passes = renderer_for(device, 16, precision).render(scene, 101, 67, passes=["normal"])
        plane = trace.id == 3
        assert abs(passes["normal"][plane] - (0, 1, 0)).max() < 1e-3
        error = abs(passes["normal"] - trace.normal).max(axis=2)
        assert (error > 1e-3).sum() <= 20  # flips


def test_an_orthographic_depth_behind_the_position_is_negative(device: cl.Device) -> None:
    """What is drawn is the same wherever along its view the camera stands."""
    scene = clrt.load_scene("four-spheres")
    ahead = clrt.Camera((0, 0, 9), (0, 0, 0), projection="orthographic", height=2)
    behind = replace(ahead, position=(0, 0, -9), look_at=(0, 0, -18))
    renderer = renderer_for(device, 16)
    found = []
    for camera in (ahead, behind):
        _, passes = renderer.render(replace(scene, camera=camera), 64, 48, passes=["depth", "id"])
        found.append(passes)
    assert (found[0]["id"] == found[1]["id"]).all()
    seen = found[0]["id"] >= 0
    balls = seen & (found[0]["id"] < 3)
    assert balls.any()
    assert found[0]["depth"][balls].min() > 0 > found[1]["depth"][balls].max()
    assert abs(found[0]["depth"][balls] - found[1]["depth"][balls] - 18).max() < 1e-4


def test_passes_of_a_region_are_those_of_the_whole(renderer: Renderer) -> None:
    for name in ("four-spheres", "sunflower"):
        scene = clrt.load_scene(name)
        _, whole = renderer.render(scene, 101, 67, passes=("depth", "normal", "id"))
        for x0, y0, x1, y1 in [(17, 3, 50, 64), (0, 0, 1, 1), (99, 66, 101, 67)]:
            _, part = renderer.render(
                scene, 101, 67, passes=("depth", "normal", "id"), region=(x0, y0, x1, y1)
            )
            for key, found in part.items():
                assert found.flags.c_contiguous
                assert (found == whole[key][y0:y1, x0:x1]).all()


def test_kinds_of_passes(device: cl.Device) -> None:
    renderer = renderer_for(device, 16)
    image, passes = renderer.render("four-spheres", 8, 5, passes=("normal", "id", "depth", "id"))
    kinds = {name: (str(found.dtype), found.shape) for name, found in passes.items()}
    assert kinds == {
        "normal": ("float32", (5, 8, 3)), "id": ("int32", (5, 8)), "depth": ("float32", (5, 8))
    }  # fmt: skip
    assert image.shape == (5, 8, 3)
    image, passes = renderer.render("four-spheres", 8, 5, passes=())
    assert passes == {}
    held = renderer.render("four-spheres", 8, 5, passes=["id"])[1]["id"]
    before = held.copy()
    renderer.render("sunflower", 8, 5, passes=["id"])
    assert (held == before).all()  # nobody else's memory


@pytest.mark.parametrize("passes", [["albedo"], "albedo", ["id", "Depth"]])
def test_refuses_a_pass(passes) -> None:
    with pytest.raises(clrt.RequestError, match="passes: expected some of depth, normal, id, got"):
        Renderer().render("four-spheres", 8, 5, passes=passes)

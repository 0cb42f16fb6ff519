"""Edges of cells: as wide as they are to be, where they belong, and hidden by spheres."""

from typing import Any

import numpy as np
import pytest

import clrt
from clrt.film.decor import cell

Array = np.ndarray[Any, Any]
NONE = (0.0, 0.0, 0.0)
BEHIND_NOTHING = np.inf


def edge(start: Any, end: Any) -> clrt.Cell:
    """A cell that is nothing but one edge."""
    return clrt.Cell((tuple(np.subtract(end, start)), NONE, NONE), start)


def flat(height: float = 2.0, **options: Any) -> clrt.Camera:
    """What it shows of the plane z = 0 is `height` units high."""
    given = {"position": (0, 0, 9), "look_at": (0, 0, 0)} | options
    return clrt.Camera(projection="orthographic", height=height, **given)


def covered(
    cells: clrt.Cell | list[clrt.Cell],
    camera: clrt.Camera,
    size: tuple[int, int],
    depth: Array | None = None,
    region: tuple[int, int, int, int] | None = None,
) -> Array:
    """How much of each pixel they cover."""
    x0, y0, x1, y1 = region or (0, 0, *size)
    seen = np.full((y1 - y0, x1 - x0), BEHIND_NOTHING) if depth is None else depth
    cells = cells if isinstance(cells, list) else [cells]
    marks = cell.marks(cells, camera, size, (x0, y0, x1, y1), (0.5, 0.25, 1), seen)
    assert (np.diff(marks.pixel) > 0).all()
    share = marks.color[:, 3]
    assert (marks.color[:, :3] == share[:, np.newaxis] * np.array((0.5, 0.25, 1), np.float32)).all()
    found = np.zeros(seen.size)
    found[marks.pixel] = share
    return found.reshape(seen.shape)


def pixel_rays(camera: clrt.Camera, size: tuple[int, int]) -> tuple[Array, Array]:
    """Origins and unit directions through the middles of pixels, (height, width, 3)."""
    width, height = size
    right, up, back = np.array(camera.basis())
    if camera.height is not None:
        top = camera.height / 2
        side, ahead = top * width / height, 0.0
    else:
        side = np.tan(np.radians(camera.fov or 0) / 2)
        top, ahead = side * height / width, 1.0
    x, y = np.meshgrid(np.linspace(-side, side, width), np.linspace(top, -top, height))
    at = x[..., np.newaxis] * right + y[..., np.newaxis] * up
    eye = np.array(camera.position)
    if not ahead:
        return eye + at, np.broadcast_to(-back, at.shape)
    through = at - back
    return np.broadcast_to(eye, at.shape), through / np.linalg.norm(through, axis=2, keepdims=True)


def depth_of(ball: Any, radius: float, origin: Array, direction: Array) -> Array:
    """Where rays meet a sphere, as the pass has it."""
    f = origin - ball
    b = (f * direction).sum(axis=-1)
    delta = b**2 - (f * f).sum(axis=-1) + radius**2
    return np.where(delta > 0, -b - np.sqrt(np.maximum(delta, 0)), np.inf)


@pytest.mark.parametrize("angle", [0, 17, 43, 60, 90, 133])
@pytest.mark.parametrize("width", [0.4, 1.0, 2.0, 4.0])
def test_area(angle: float, width: float) -> None:
    """A line's length times its width, and two half discs at its ends.

    At 45 degrees pixels are at few distances from it: there a line of one pixel is up to 12 % off.
    """
    height = round(width / cell.WIDTH)
    size = 2 * height, height
    way = np.array((np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0)) * 0.3
    middle = np.array((0.2, 0.1, 0))
    length = np.linalg.norm(2 * way) * (height - 1) / 2  # pixels: the grid has its end points
    found = covered(edge(middle - way, middle + way), flat(), size)
    line, pale = max(width, 1), min(width, 1)
    inner, outer = line / 2 - 0.5, line / 2 + 0.5
    caps = np.pi * (inner**2 + outer * (outer**2 - inner**2) - 2 / 3 * (outer**3 - inner**3))
    assert found.sum() == pytest.approx(pale * (length * line + caps), rel=5e-3)
    assert found.max() <= pale * (1 + 1e-6)


CAMERAS = [
    flat(3.0),
    flat(5.0, position=(3, -2, 4), look_at=(0.2, 0.1, 0), up=(0.3, 1, 0)),
    clrt.Camera((0, 0, 4), (0, 0, 0), fov=60),
    clrt.Camera((3, -2, 4), (0.2, 0.1, 0), up=(0.3, 1, 0), fov=35),
    clrt.Camera((0.2, 0.1, 0.3), (1, 0.5, 0.2), fov=100),  # within
]
BOX = clrt.Cell(((1.1, 0, 0), (0.3, 1.2, 0), (-0.2, 0.4, 0.9)), (-0.5, -0.6, -0.4))


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("size", [(1080, 720), (540, 600)])
def test_edges_are_where_rays_meet_them(camera: clrt.Camera, size: tuple[int, int]) -> None:
    """The pixels of points on edges are covered, and only those beside them."""
    found = covered(BOX, camera, size)
    side, top = screen(camera, size)
    met = np.zeros((size[1] + 4, size[0] + 4), bool)
    corners = np.array(BOX.origin) + cell.CORNERS @ np.array(BOX.edges)
    for a, b in cell.EDGES:
        points = corners[a] + np.linspace(0, 1, 5000)[:, np.newaxis] * (corners[b] - corners[a])
        x, y, back = ((points - camera.position) @ np.array(camera.basis()).T).T
        ahead = -back if camera.height is None else np.ones(5000)
        inside = (ahead > 1e-3) & (abs(x) <= side * ahead) & (abs(y) <= top * ahead)
        x, y, ahead = x[inside], y[inside], ahead[inside]
        column = np.interp(x / ahead, np.linspace(-side, side, size[0]), np.arange(size[0]))
        row = np.interp(-y / ahead, np.linspace(-top, top, size[1]), np.arange(size[1]))
        met[np.rint(row).astype(int) + 2, np.rint(column).astype(int) + 2] = True
    assert met.sum() > 500
    assert (found[met[2:-2, 2:-2]] > 0).all()
    beside = np.lib.stride_tricks.sliding_window_view(met, (5, 5)).any(axis=(2, 3))
    assert not found[~beside].any()


@pytest.mark.parametrize("camera", CAMERAS)
def test_regions_do_not_show(camera: clrt.Camera) -> None:
    size = 200, 150
    depth = np.random.default_rng(1).uniform(1, 9, (150, 200)).astype(np.float32)
    whole = covered(BOX, camera, size, depth)
    assert whole.any()
    for x0, y0, x1, y1 in [
        (0, 0, 200, 75),
        (90, 31, 150, 32),
        (199, 149, 200, 150),
        (5, 0, 190, 140),
    ]:
        part = covered(BOX, camera, size, depth[y0:y1, x0:x1], (x0, y0, x1, y1))
        assert (part == whole[y0:y1, x0:x1]).all()


@pytest.mark.parametrize(
    ("camera", "start", "end"),
    [
        (flat(4.0), (-2, 0, 0), (2, 0, 0)),  # through the middle: half of it is in the ball
        (flat(4.0), (-2, 0.3, -3), (2, 0.1, 0.5)),  # behind, then in
        (flat(4.0), (-2, 0.3, 3), (2, 0.1, 2)),  # in front
        (clrt.Camera((0, 0.5, 5), (0, 0, 0), fov=60), (-2, 0, 0), (2, 0, 0)),
        (clrt.Camera((0, 0.5, 5), (0, 0, 0), fov=60), (-2.5, 0.2, -4), (1.5, 0.1, 3)),
        (clrt.Camera((2, 1.5, 3), (0, 0, 0), fov=70), (-2.5, 0.2, -4), (1.5, 0.1, 2)),
    ],
)
def test_a_ball_hides_its_share_of_an_edge(camera: clrt.Camera, start: Any, end: Any) -> None:
    """Of the points of an edge, those behind the ball's near side as seen from the camera."""
    size, ball, radius = (960, 540), np.array((0.1, 0.2, 0.0)), 1.0
    origin, direction = pixel_rays(camera, size)
    depth = depth_of(ball, radius, origin, direction)
    found = covered(edge(start, end), camera, size, depth)
    open_ = covered(edge(start, end), camera, size)
    assert ((found == open_) | (found == 0)).all()
    # Points that are spaced evenly on the screen, each with its own ray.
    side, top = screen(camera, size)
    a, b = (np.array(p, float) - camera.position for p in (start, end))
    basis = np.array(camera.basis())
    t = np.linspace(0, 1, 100_000)
    if camera.height is None:
        near, far = -basis[2] @ a, -basis[2] @ b
        t = t * near / (t * near + (1 - t) * far)
    point = a + t[:, np.newaxis] * (b - a)
    if camera.height is None:
        distance = np.linalg.norm(point, axis=1)
        hidden = distance > depth_of(
            ball - camera.position, radius, np.zeros(3), point / distance[:, np.newaxis]
        )
        place = point @ basis.T / -(point @ basis[2])[:, np.newaxis]
    else:
        hidden = -(point @ basis[2]) > depth_of(
            ball - camera.position,
            radius,
            point - (point @ basis[2])[:, np.newaxis] * basis[2],
            -basis[2],
        )
        place = point @ basis.T
    shown = (abs(place[:, 0]) < side) & (abs(place[:, 1]) < top)
    expected = hidden[shown].mean()
    assert 1 - found.sum() / open_.sum() == pytest.approx(expected, abs=0.006)


def screen(camera: clrt.Camera, size: tuple[int, int]) -> tuple[float, float]:
    """Half its width and height."""
    if camera.height is not None:
        return camera.height / 2 * size[0] / size[1], camera.height / 2
    side = np.tan(np.radians(camera.fov or 0) / 2)
    return side, side * size[1] / size[0]


def test_of_two_edges_the_larger_share_counts() -> None:
    size = 540, 540
    one, two = edge((-0.5, 0, 0), (0.5, 0, 0)), edge((0, -0.5, 0), (0, 0.5, 0))
    both = covered([one, two], flat(), size)
    assert (both == np.maximum(covered(one, flat(), size), covered(two, flat(), size))).all()


def test_what_is_behind_the_camera_is_not_there() -> None:
    camera = clrt.Camera((0, 0, 0), (0, 0, -1))
    assert not covered(edge((-1, 0, 1), (1, 0, 2)), camera, (200, 100)).any()
    # This one comes from behind, over the right shoulder, to the middle of the picture.
    found = covered(edge((2, 0, 2), (0, 0, -2)), camera, (540, 540))
    assert found[:, 269:].any(axis=0).all()
    assert not found[:, :269].any()
    assert not covered(edge((0, 0, 0), (0, 0, 0)), camera, (20, 10)).any()


@pytest.mark.parametrize("size", [(1, 1), (1, 9), (9, 1), (2, 2)])
@pytest.mark.parametrize("camera", CAMERAS)
def test_small_pictures(camera: clrt.Camera, size: tuple[int, int]) -> None:
    found = covered(BOX, camera, size)
    assert found.shape == size[::-1]
    assert np.isfinite(found).all()


def test_far_away_and_large() -> None:
    """Nothing is lost where numbers are large."""
    far = clrt.Camera((1e7, 0, 9), (1e7, 0, 0), projection="orthographic", height=2)
    found = covered(edge((1e7 - 1e9, 0, 0), (1e7 + 1e9, 0, 0)), far, (540, 540))
    assert found.sum() == pytest.approx(540, rel=1e-3)
    within = clrt.Camera((0, -1e-3, 0), (0, -1e-3, -1))
    found = covered(edge((-1e6, 0, 1e6), (1e6, 0, -1e6)), within, (540, 540))
    assert np.isfinite(found).all()
    assert found.any()

"""What a camera sees: where spheres show on the screen, and where rays start."""

import numpy as np
import pytest

import clrt
from clrt import Camera
from clrt.scene import lens

CAMERA = Camera((0, 0, 0), (0, 0, -1))
BESIDE = Camera((0, 0, 0), (0, 0, -1), projection="orthographic", height=2)

NONE = clrt.Capsules(np.zeros((0, 3)), np.zeros((0, 3)), 1, "m")


def test_view_holds_what_a_sphere_shows_of_itself() -> None:
    """Directions to random points of random spheres, ahead of the camera, lie in their views."""
    random = np.random.default_rng(5)
    center = random.normal(0, 3, (2000, 3))
    radius = random.uniform(0.01, 4, 2000)
    view = lens.bounds(CAMERA, center, radius)
    direction = random.normal(0, 1, (200, 2000, 3))
    direction /= np.linalg.norm(direction, axis=2, keepdims=True)
    point = center + radius[:, np.newaxis] * direction
    ahead = point[..., 2] < 0
    for axis in (0, 1):
        at = point[..., axis] / -point[..., 2]
        inside = (at >= view[:, 2 * axis]) & (at <= view[:, 2 * axis + 1])
        assert inside[ahead].all()
    assert np.isfinite(view).any(axis=1).mean() > 0.3  # it does narrow things down


@pytest.mark.parametrize("center", [(0.1, 0.2, 5.0), (-3.0, 0.0, 5.0), (0.0, -4.0, 4.5)])
def test_nothing_behind_the_camera_is_in_screen_bounds(center: tuple[float, float, float]) -> None:
    left, right, bottom, top = lens.bounds(CAMERA, np.array([center]), np.array([1.0]))[0]
    assert left == np.inf or right == -np.inf or bottom == np.inf or top == -np.inf


def test_a_sphere_around_the_camera_is_in_view_everywhere() -> None:
    for center in ((0.0, 0.0, 0.0), (-1.0, 0.5, 1.0), (1.0, -2.0, -1.0)):
        view = lens.bounds(CAMERA, np.array([center]), np.array([3.0]))[0]
        assert view.tolist() == [-np.inf, np.inf, -np.inf, np.inf]


def test_an_orthographic_view_is_as_wide_as_the_sphere() -> None:
    random = np.random.default_rng(5)
    center, radius = random.normal(0, 1, (2000, 3)), random.uniform(0.01, 1, 2000)
    bounds = lens.bounds(BESIDE, center, radius)
    low, high = bounds[:, ::2], bounds[:, 1::2]
    assert (low < center[:, :2] - radius[:, np.newaxis]).all()
    assert (high > center[:, :2] + radius[:, np.newaxis]).all()
    assert (high - low - 2 * radius[:, np.newaxis]).max() < 1e-5


@pytest.mark.parametrize("n", [5, 5000])
def test_orthographic_rays_start_before_all_that_is_small(n: int) -> None:
    random = np.random.default_rng(6)
    spheres = clrt.Spheres(random.normal(0, 2, (n, 3)), random.uniform(0.01, 0.3, n), "any")
    screen = lens.half_screen(BESIDE, 300, 200)
    assert screen.tolist() == [1.5, 1]
    ahead = lens.start(BESIDE, spheres, NONE, (), screen, np.float64)
    seen = (abs(spheres.center[:, :2]) < screen + spheres.radius[:, np.newaxis]).all(axis=1)
    first = (-spheres.center[:, 2] - spheres.radius)[seen].min()
    assert first - 0.4 < ahead < first + 0.3
    assert len(lens.behind(BESIDE, spheres, screen, ahead)) == 0
    # A ball that is larger than the picture does not move it, but is met before.
    ball = clrt.Spheres([[0, 0, 0], *spheres.center], [50, *spheres.radius], "any")
    assert lens.start(BESIDE, ball, NONE, (), screen, np.float64) == ahead
    assert lens.behind(BESIDE, ball, screen, ahead).tolist() == [0]
    alone = ball[:1]
    assert lens.start(BESIDE, alone, NONE, (), screen, np.float64) == pytest.approx(-50, abs=0.5)

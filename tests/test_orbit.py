"""Moves of the camera, against closed forms and what the float64 reference sees."""

import math

import numpy as np
import pytest
from msgspec.structs import replace

import clrt
from clrt.errors import SceneError
from clrt.scene.camera import Camera
from clrt.viewer import orbit

SIZE = (64, 36)
PERSPECTIVE = Camera((1.0, 2.0, 8.0), (0.5, -0.5, 1.0), fov=50)
ORTHOGRAPHIC = Camera(
    (1.0, 2.0, 8.0), (0.5, -0.5, 1.0), (0.1, 1.0, 0.2), projection="orthographic", height=3.0
)
CAMERAS = pytest.mark.parametrize("camera", [PERSPECTIVE, ORTHOGRAPHIC], ids=lambda c: c.projection)


def seen(camera: Camera, place: np.ndarray, pixel: tuple[int, int]) -> bool:
    """Whether the reference sees a bead there, a tenth of a pixel wide, at that pixel."""
    bead = clrt.Spheres(place[np.newaxis], 0.002, "bead")
    scene = clrt.Scene(camera, (), {"bead": clrt.Material()}, bead)
    column, row = pixel
    trace = clrt.reference.trace(scene, *SIZE, truth="exact", pixels=[(row, column)])
    return bool(trace.id[0] == 0)


def test_a_quarter_turn() -> None:
    camera = Camera((0.0, 0.0, 5.0), (0.0, 0.0, 1.0))
    assert orbit.turned(camera, 90, 0).position == pytest.approx((4, 0, 1), abs=1e-12)
    assert orbit.turned(camera, -90, 0).position == pytest.approx((-4, 0, 1), abs=1e-12)
    half = math.sqrt(8)
    assert orbit.turned(camera, 0, 45).position == pytest.approx((0, half, 1 + half), abs=1e-12)
    assert orbit.turned(camera, 90, -45).position == pytest.approx((half, -half, 1), abs=1e-12)


@CAMERAS
def test_turning_keeps_everything_but_the_position(camera: Camera) -> None:
    found = orbit.turned(camera, 37, -12)
    assert replace(found, position=camera.position) == camera
    distance = math.dist(camera.position, camera.look_at)
    assert math.dist(found.position, found.look_at) == pytest.approx(distance, rel=1e-14)
    again = orbit.turned(orbit.turned(camera, 360, 20), 0, -20)
    assert again.position == pytest.approx(camera.position, rel=1e-13)


def test_turning_stops_before_the_pole() -> None:
    camera = Camera((0.0, 0.0, 2.0), (0.0, 0.0, 0.0))
    for way in (1, -1):
        found = camera
        for _ in range(5):
            found = orbit.turned(found, 10, way * 50)
        rise = math.degrees(math.asin(found.position[1] / 2))
        assert rise == pytest.approx(way * orbit.POLE)
    # Nearer to it than that it stays where it is.
    above = Camera((0.0, 2.0, 0.01), (0.0, 0.0, 0.0))
    assert orbit.turned(above, 0, 5).position == pytest.approx(above.position, rel=1e-9)


@CAMERAS
@pytest.mark.parametrize("pixel", [(0, 0), (63, 35), (10, 30), (31, 17)])
def test_a_point_is_what_the_pixel_shows(camera: Camera, pixel: tuple[int, int]) -> None:
    place = orbit.point(camera, pixel, SIZE)
    assert seen(camera, place, pixel)
    ahead = np.subtract(camera.look_at, camera.position)
    assert (place - camera.look_at) @ ahead == pytest.approx(0, abs=1e-9)


@CAMERAS
def test_pan_takes_a_point_along(camera: Camera) -> None:
    place = orbit.point(camera, (20, 10), SIZE)
    found = orbit.panned(camera, 17, -4, SIZE)
    assert seen(found, place, (37, 6))
    assert not seen(camera, place, (37, 6))


@CAMERAS
def test_zoom_keeps_what_is_under_the_pointer(camera: Camera) -> None:
    at = (50, 9)
    place = orbit.point(camera, at, SIZE)
    other = orbit.point(camera, (48, 12), SIZE)
    found = orbit.zoomed(camera, 3, at, SIZE)
    assert seen(found, place, at)
    assert seen(found, other, (44, 18))  # three times as far from it
    back = orbit.zoomed(found, 1 / 3, at, SIZE)
    assert back.position == pytest.approx(camera.position, rel=1e-12)
    assert back.height == pytest.approx(camera.height) if camera.height else back.height is None


def test_projections_show_the_same_at_look_at() -> None:
    lens = replace(PERSPECTIVE, aperture_radius=0.1, focus_distance=3.0)
    straight = orbit.orthographic(lens, SIZE)
    # tan(25 degrees) wide on either side, one unit away.
    distance = math.dist(lens.position, lens.look_at)
    expected = 2 * distance * math.tan(math.radians(25)) * SIZE[1] / SIZE[0]
    assert straight.height == pytest.approx(expected)
    assert (straight.position, straight.aperture_radius) == (lens.position, 0)
    assert orbit.orthographic(straight, SIZE) is straight
    for pixel in ((3, 4), (60, 20)):
        assert seen(straight, orbit.point(PERSPECTIVE, pixel, SIZE), pixel)
    back = orbit.perspective(straight, 50, SIZE)
    assert replace(back, position=PERSPECTIVE.position) == PERSPECTIVE
    assert back.position == pytest.approx(PERSPECTIVE.position, rel=1e-13)
    assert orbit.perspective(back, 20, SIZE) is back


def test_one_pixel_and_no_camera() -> None:
    assert orbit.panned(PERSPECTIVE, 1, 1, (1, 1)).fov == 50
    with pytest.raises(SceneError):
        orbit.zoomed(PERSPECTIVE, 1e300, (0, 0), SIZE)

"""Views hold all that there is, and are no larger than that."""

import math
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.errors import RequestError
from clrt.figure import framing

RANDOM = np.random.default_rng(3)
NO_POINTS = np.zeros((0, 3))
CLOUDS = {
    "one": clrt.Spheres([[3.0, -2.0, 1.0]], 0.5, "m"),
    "cloud": clrt.Spheres(RANDOM.normal(size=(40, 3)), RANDOM.uniform(0.1, 1, 40), "m"),
    "far": clrt.Spheres(RANDOM.normal((1e6, -1e6, 1e6), size=(9, 3)), 0.3, "m"),
    "float32": clrt.Spheres(RANDOM.normal(size=(9, 3)).astype(np.float32), np.float32(0.3), "m"),
    "flat": clrt.Spheres(RANDOM.normal(size=(9, 3)) * [9, 1, 0], 0.1, "m"),
}
TOWARDS = [*framing.VIEWS.values(), (0.2, -3.0, 0.7), (1e-3, 0.0, -5.0)]
SIZES = [(192, 108), (50, 90)]


def on_screen(camera: clrt.Camera, spheres: clrt.Spheres, size: tuple[int, int]):
    """The least and the largest x and y of each sphere's outline in the picture, whose sides are at
    -1 and 1: (n,) each, by the planes through the eye that touch the sphere."""
    right, up, back = (np.array(axis) for axis in camera.basis())
    seen = spheres.center.astype(float) - camera.position
    radius, aspect = spheres.radius.astype(float), size[0] / size[1]
    if camera.orthographic:
        assert camera.height is not None
        half = camera.height / 2
        return [
            (seen @ axis + sign * radius) / (half * part)
            for axis, part in ((right, aspect), (up, 1))
            for sign in (-1, 1)
        ]
    assert camera.fov is not None
    half = math.tan(math.radians((camera.fov or 0) / 2))
    ahead = -(seen @ back)
    ends = []
    for axis, part in ((right, 1), (up, 1 / aspect)):
        across = seen @ axis
        middle, opening = np.arctan2(across, ahead), np.arcsin(radius / np.hypot(across, ahead))
        ends += [np.tan(middle + sign * opening) / (half * part) for sign in (-1, 1)]
    return ends


@pytest.mark.parametrize("projection", framing.PROJECTIONS)
@pytest.mark.parametrize("size", SIZES, ids=str)
@pytest.mark.parametrize("margin", [0.0, 0.03, 0.4])
@pytest.mark.parametrize("name", CLOUDS)
def test_a_view_holds_all_and_touches_two_sides(
    name: str, margin: float, size: tuple[int, int], projection: framing.Projection
) -> None:
    spheres, inner = CLOUDS[name], 1 - 2 * margin
    for towards in TOWARDS:
        camera = framing.holding([spheres], NO_POINTS, towards, size, projection, margin)
        left, right, bottom, top = on_screen(camera, spheres, size)
        ends = np.array([-left.min(), right.max(), -bottom.min(), top.max()])
        near = 1e-6 if name == "far" else 1e-9
        assert ends.max() == pytest.approx(inner, abs=near)
        wide, high = sorted(ends[:2]), sorted(ends[2:])
        both = [pair for pair in (wide, high) if pair[1] == pytest.approx(inner, abs=near)]
        assert any(pair[0] == pytest.approx(inner, abs=near) for pair in both), ends


@pytest.mark.parametrize("projection", framing.PROJECTIONS)
def test_the_camera_stands_where_it_is_said(projection: framing.Projection) -> None:
    for towards in TOWARDS:
        camera = framing.holding([CLOUDS["cloud"]], NO_POINTS, towards, (90, 50), projection)
        right, up, back = camera.basis()
        assert back == pytest.approx(np.array(towards) / np.linalg.norm(towards), abs=1e-12)
        if towards[0] == towards[1] == 0:
            assert up == pytest.approx((0, 1, 0))
        else:
            assert right[2] == pytest.approx(0, abs=1e-12)
            assert up[2] > 0


@pytest.mark.parametrize("projection", framing.PROJECTIONS)
@pytest.mark.parametrize("size", SIZES, ids=str)
def test_there_is_room_at_the_right(size: tuple[int, int], projection: framing.Projection) -> None:
    """For a colour bar: 0.3 of the width beside a margin of 0.1."""
    for spheres in (CLOUDS["one"], CLOUDS["cloud"], CLOUDS["flat"]):
        camera = framing.holding(
            [spheres], NO_POINTS, (1, 1, 1), size, projection, 0.1, (0.3, 0, 0)
        )
        left, right, bottom, top = on_screen(camera, spheres, size)
        ends = np.array(
            [-left.min() / 0.8, right.max() / 0.2, -bottom.min() / 0.8, top.max() / 0.8]
        )
        assert ends.max() == pytest.approx(1)
        filled = ends.reshape(2, 2).min(axis=1).max() if projection == "orthographic" else 1
        assert filled == pytest.approx(1)


def test_nothing_is_behind_the_camera() -> None:
    """Depths of the pass are counted from its position."""
    for projection in framing.PROJECTIONS:
        camera = framing.holding([CLOUDS["flat"]], NO_POINTS, (1, 0, 0), (90, 50), projection)
        _, _, back = camera.basis()
        ahead = -(CLOUDS["flat"].center - camera.position) @ np.array(back)
        assert (ahead > CLOUDS["flat"].radius).all()


def test_parts_are_held_together() -> None:
    for projection in framing.PROJECTIONS:
        parts = [CLOUDS["one"], CLOUDS["cloud"], CLOUDS["flat"]]
        rest: tuple[Any, ...] = (NO_POINTS, (1, 2, 3), (90, 50), projection)
        assert framing.holding(parts, *rest) == framing.holding([clrt.Spheres.joined(parts)], *rest)


def test_points_are_held_as_well() -> None:
    corner = np.array([[0.0, 0.0, 100.0]])
    camera = framing.holding([CLOUDS["one"]], corner, (1, 0, 0), (100, 100))
    assert camera.height == pytest.approx(100 + 0.5 - 1 + 0 * 2, abs=1)
    held = clrt.Spheres(np.concatenate([CLOUDS["one"].center, corner]), [0.5, 1e-9], "m")
    assert framing.holding([held], NO_POINTS, (1, 0, 0), (100, 100)).height == pytest.approx(
        camera.height
    )
    alone = framing.holding([], np.eye(3), (0, 0, 1), (10, 10))
    assert alone.height == 1


@pytest.mark.parametrize("given", ["X", "", (1, 2), (0, 0, 0), (1, 2, math.nan), None, 3, "xyz"])
def test_what_is_no_view(given: object) -> None:
    with pytest.raises(RequestError, match=r"view: expected one of corner, iso, x, -x, .* got"):
        framing.direction(given)  # type: ignore[arg-type]


def test_nothing_cannot_be_seen() -> None:
    with pytest.raises(RequestError, match="particles: expected at least one, got none"):
        framing.holding([clrt.Spheres(NO_POINTS, 1, "m")], NO_POINTS, (1, 1, 1), (10, 10))


@pytest.mark.parametrize("projection", framing.PROJECTIONS)
def test_what_is_far_from_the_middle_is_not_seen(projection: framing.Projection) -> None:
    one, size = clrt.Spheres(np.zeros((1, 3)), np.ones(1), "m"), SIZES[0]
    for x, zoom, expected in (
        (0, 1, True),
        (0.9, 50, True),
        (3, 1, True),
        (3, 9, False),
        (5e3, 1, False),
    ):
        camera = framing.holding(
            [one], np.zeros((0, 3)), (0, 0, 1), size, projection, zoom=zoom, center=(x, 0, 0)
        )
        assert framing.is_seen(camera, one, None, NO_POINTS, size) == expected


@pytest.mark.parametrize("projection", framing.PROJECTIONS)
def test_between_what_is_drawn_nothing_is_seen(projection: framing.Projection) -> None:
    """At a zoom of 1e5 the picture was blank without a word."""
    places = np.array([[-3.0, 0, 0], [3, 0, 0]])
    two = clrt.Spheres(places, np.ones(2), "m")
    camera = framing.holding([two], NO_POINTS, (0, 0, 1), SIZES[0], projection, zoom=1e5)
    rod = clrt.Capsules(places[:1], places[1:], 0.1, "m")
    assert not framing.is_seen(camera, two, None, NO_POINTS, SIZES[0])
    assert framing.is_seen(camera, two, rod, NO_POINTS, SIZES[0])

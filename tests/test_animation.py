"""The camera's way against closed forms, and frames that do not depend on each other."""

import math
import threading

import numpy as np
import pytest
from msgspec.structs import replace

import clrt
from clrt.motion.animation import Way, all_frames, animate, camera_at
from clrt.values import Vec3

ORBIT = clrt.load_scene("orbit")


def moving(*keys: clrt.Key, frames: int = 100, interpolation: str = "smooth") -> clrt.Scene:
    animation = clrt.Animation(frames, keys, interpolation=interpolation)  # type: ignore[arg-type]
    return replace(ORBIT, animation=animation)


def positions(scene: clrt.Scene, frames: range) -> np.ndarray:
    return np.array([camera_at(scene, k).position for k in frames])


@pytest.mark.parametrize("interpolation", ["smooth", "linear"])
def test_keys_are_hit_exactly(interpolation: str) -> None:
    places: list[Vec3] = [(0.0, 1.0, 3.0), (1.0, 0.5, 2.0), (-2.0, 0.25, 2.5)]
    scene = moving(
        *(clrt.Key(f, position=p, fov=50.0 + f) for f, p in zip((3, 10, 40), places, strict=True)),
        interpolation=interpolation,
    )
    for frame, place in zip((3, 10, 40), places, strict=True):
        assert camera_at(scene, frame).position == pytest.approx(place, abs=1e-15)
        assert camera_at(scene, frame).fov == pytest.approx(50 + frame)
    assert camera_at(scene, 0) == camera_at(scene, 3)  # still before the first key
    assert camera_at(scene, 99) == camera_at(scene, 40)  # and after the last


def test_what_a_key_leaves_out_keeps_the_cameras_value() -> None:
    scene = moving(clrt.Key(0, fov=40.0), clrt.Key(10, position=(0.0, 1.0, 3.0)))
    assert camera_at(scene, 0).position == ORBIT.camera.position
    assert camera_at(scene, 10).fov == ORBIT.camera.fov
    assert camera_at(scene, 5).look_at == ORBIT.camera.look_at


@pytest.mark.parametrize("interpolation", ["smooth", "linear"])
def test_two_keys_make_a_straight_line_at_constant_speed(interpolation: str) -> None:
    scene = moving(
        clrt.Key(0, position=(0.0, 1.0, 3.0)),
        clrt.Key(50, position=(5.0, 2.0, 3.0)),
        interpolation=interpolation,
    )
    step = np.diff(positions(scene, range(51)), axis=0)
    assert abs(step - [0.1, 0.02, 0]).max() < 1e-12


def test_smooth_is_exact_for_a_parabola_between_inner_keys() -> None:
    """Catmull-Rom's slopes at evenly spaced keys are those of a parabola through them."""
    at = [0, 10, 20, 30]
    scene = moving(*(clrt.Key(f, position=(f / 10, (f / 10) ** 2, 3.0)) for f in at))
    inner = positions(scene, range(10, 21))
    assert abs(inner[:, 1] - inner[:, 0] ** 2).max() < 1e-12


def test_a_loop_is_seamless() -> None:
    """Round the seam position and velocity go on as they do at the key opposite."""
    frames = len(all_frames(ORBIT))
    round_ = positions(ORBIT, range(frames + 1))
    assert round_[0] == pytest.approx(round_[-1], abs=1e-12)
    ring = np.concatenate([round_[:-1], round_[:2]])
    bend = np.linalg.norm(np.diff(ring, 2, axis=0), axis=1)
    assert bend[-1] < 1.5 * np.median(bend)
    radius = np.hypot(round_[:, 0] + 0.1, round_[:, 2] + 0.55)
    assert radius.min() > 0.98 * radius.max()  # eight keys make nearly a circle


def test_an_open_path_starts_towards_its_next_key() -> None:
    scene = moving(
        clrt.Key(0, position=(0.0, 1.0, 3.0)),
        clrt.Key(10, position=(1.0, 1.0, 3.0)),
        clrt.Key(20, position=(1.0, 2.0, 3.0)),
    )
    x, y, _ = positions(scene, range(2))[1]
    assert x > 0.05
    assert abs(y - 1) < 0.02


@pytest.mark.parametrize("dtype", [np.float32, np.uint8])
def test_a_frame_does_not_depend_on_the_others(dtype: type) -> None:
    alone = [next(iter(animate(ORBIT, 48, 27, frames=[k], dtype=dtype))) for k in (0, 61, 119)]
    row = list(animate(ORBIT, 48, 27, frames=range(120), dtype=dtype))
    assert len(row) == 120
    assert row[0].dtype == dtype
    for k, frame in zip((0, 61, 119), alone, strict=True):
        assert (row[k] == frame).all()
    still = replace(ORBIT, camera=camera_at(ORBIT, 61))
    assert (clrt.Renderer().render(still, 48, 27, dtype=dtype) == row[61]).all()
    assert len({frame.tobytes() for frame in row}) == 120


def test_an_impossible_camera_is_found_before_the_first_frame() -> None:
    through = moving(
        clrt.Key(0, position=(0.0, 0.0, 1.0), look_at=(0.0, 0.0, 0.0)),
        clrt.Key(10, position=(0.0, 0.0, -1.0), look_at=(0.0, 0.0, 0.0)),
        interpolation="linear",
    )
    with pytest.raises(clrt.SceneError, match=r"animation, frame 5: camera\.look_at: expected"):
        animate(through, 8, 8)
    with pytest.raises(clrt.SceneError, match="animation: expected a table, got none"):
        animate(clrt.load_scene("four-spheres"), 8, 8)


@pytest.mark.parametrize(
    ("keys", "options", "said"),
    [
        ((clrt.Key(0),), {}, "keys: expected at least two keys"),
        ((clrt.Key(5), clrt.Key(5)), {}, r"keys\[1\].frame: expected a frame from 6 to 100"),
        ((clrt.Key(9), clrt.Key(5)), {}, r"keys\[1\].frame"),
        ((clrt.Key(0), clrt.Key(101)), {}, r"keys\[1\].frame"),
        ((clrt.Key(0), clrt.Key(1)), {"fps": math.nan}, "fps"),
        ((clrt.Key(0), clrt.Key(1)), {"frames": 0}, "frames"),
    ],
)
def test_refuses(keys: tuple[clrt.Key, ...], options: dict, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        clrt.Animation(**{"frames": 100, "keys": keys, **options})


def test_closed_it_stops_at_once() -> None:
    """What is under way is not waited for: here it would never end."""
    started, stopped = threading.Event(), threading.Event()

    class Slow:
        first = True

        def render(self, scene, width, height, dtype, progress) -> np.ndarray:
            if self.first:
                self.first = False
                return np.zeros((height, width, 3), dtype)
            started.set()
            try:
                while True:
                    progress(1)
            finally:
                stopped.set()

    frames = animate(ORBIT, 8, 8, renderer=Slow())  # type: ignore[arg-type]
    next(frames)
    assert started.wait(20)
    frames.close()
    assert stopped.is_set()


def test_a_million_frames_and_a_key_for_each_of_many() -> None:
    """Were the frames or the keys worked through one by one this would take minutes."""
    way = Way(moving(clrt.Key(0), clrt.Key(10**6, position=(0.0, 1.0, 3.0)), frames=10**6))
    way.check(range(10**6))
    keys = [clrt.Key(k, position=(math.cos(k), 1.0, 3.0)) for k in range(20_000)]
    scene = moving(*keys, frames=20_000)
    way = Way(scene)
    for k in range(0, 20_000, 4000):
        assert way.camera(k).position == pytest.approx(keys[k].position)


@pytest.mark.parametrize("frames", [[-5], [1.5], [0, 1000], ["1"], range(5, 200)])
def test_refuses_frames_that_are_not_there(frames) -> None:
    expected = "frames: expected whole numbers from 0 to 99, got"
    with pytest.raises(clrt.RequestError, match=expected):
        animate(moving(clrt.Key(0), clrt.Key(9, fov=50.0)), 8, 8, frames=frames)


def test_an_impossible_frame_among_many_is_found() -> None:
    scene = moving(clrt.Key(0, fov=50.0), clrt.Key(9, fov=300.0), frames=10, interpolation="linear")
    with pytest.raises(clrt.SceneError, match=r"animation, frame 5: camera.fov: expected degrees"):
        Way(scene).check(range(10))
    Way(scene).check(range(5))

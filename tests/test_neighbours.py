"""The distance of nearest neighbours, against all pairs."""

import numpy as np
import pytest

from clrt.particles import neighbours
from clrt.particles.neighbours import spacing

RANDOM = np.random.default_rng(7)
GRID = np.stack(np.meshgrid(*[np.arange(9.0)] * 3), -1).reshape(-1, 3)
CLOUDS: dict[str, np.ndarray] = {
    "cube": RANDOM.uniform(size=(700, 3)),
    "float32": RANDOM.uniform(size=(300, 3)).astype(np.float32),
    "grid": GRID,
    "flat": RANDOM.normal(size=(500, 3)) * [0, 1, 1],
    "line": RANDOM.normal(size=(200, 3)) * [0, 0, 1],
    "twice": np.repeat(RANDOM.normal(size=(100, 3)), 2, axis=0),
    "one far": np.vstack([RANDOM.normal(size=(100, 3)), [[1e9, 0, 0]]]),
    "far": RANDOM.normal(size=(100, 3)) + 1e6,
    "many at one place": np.vstack([np.zeros((300, 3)), [[0, 3, 4]]]),
}


@pytest.mark.parametrize("name", CLOUDS)
def test_as_of_all_pairs(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    points = CLOUDS[name].astype(float)
    apart = np.linalg.norm(points[:, np.newaxis] - points, axis=2)
    nearest = np.where(apart > 0, apart, np.inf).min(axis=1)
    assert spacing(CLOUDS[name]) == pytest.approx(np.median(nearest), rel=1e-12)
    monkeypatch.setattr(neighbours, "ASKED", 10)
    asked = nearest[np.linspace(0, len(points) - 1, 10).astype(int)]
    assert spacing(CLOUDS[name]) == pytest.approx(np.median(asked), rel=1e-12)


@pytest.mark.parametrize("n", [0, 1, 2, 2000])
def test_no_two_places(n: int) -> None:
    assert spacing(np.ones((n, 3))) is None


def test_two_places() -> None:
    assert spacing(np.array([[0.0, 0, 0], [0, 0, 2]])) == 2

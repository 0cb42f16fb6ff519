"""examples/visible_surfaces.py: which ways find what each pixel shows, and where a painter cannot.

What is right is each pixel's nearest of all spheres, by the roots of the ray's quadratic.
"""

import runpy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

EXAMPLE = Path(__file__).parents[1] / "examples" / "visible_surfaces.py"
ways = SimpleNamespace(**runpy.run_path(str(EXAMPLE)))
SIZE = (96, 54)


def nearest(spheres: np.ndarray) -> np.ndarray:
    x, y = np.linspace(-1, 1, SIZE[0]), np.linspace(0.5625, -0.5625, SIZE[1])
    rays = np.stack(np.broadcast_arrays(x, y[:, np.newaxis], -1), axis=-1).astype(np.longdouble)
    a = (rays**2).sum(axis=-1, keepdims=True)
    b = rays @ spheres[:, :3].T
    c = (spheres[:, :3] ** 2).sum(axis=1) - spheres[:, 3] ** 2
    with np.errstate(invalid="ignore"):
        found = (b - np.sqrt(b**2 - a * c)) / a
    found[np.isnan(found)] = np.inf
    return np.where(np.isfinite(found.min(axis=-1)), found.argmin(axis=-1), -1)


def apart(count: int) -> np.ndarray:
    """Spheres of many sizes, none of which touch."""
    random = np.random.default_rng(3)
    kept = np.zeros((0, 4))
    while len(kept) < count:
        center = random.uniform((-2, -1.2, -4), (2, 1.2, -1.5))
        room = np.linalg.norm(kept[:, :3] - center, axis=1) - kept[:, 3]
        radius = min(0.95 * room.min(initial=0.9), random.uniform(0.02, 0.5))
        if radius > 0.02:
            kept = np.vstack([kept, [*center, radius]])
    return kept


@pytest.mark.parametrize(
    "way", [ways.truth, ways.by_z_buffer, ways.by_scanline, ways.by_rays], ids=lambda w: w.__name__
)
@pytest.mark.parametrize("spheres", [ways.clump(60), apart(60)], ids=["clump", "apart"])
def test_these_ways_are_right(way, spheres: np.ndarray) -> None:
    assert (way(spheres, SIZE) == nearest(spheres)).all()


def test_a_painter_is_right_by_tangents_if_no_spheres_intersect() -> None:
    spheres = apart(120)
    right = nearest(spheres)
    assert (ways.by_painter(spheres, SIZE, "tangent") == right).all()
    assert (ways.by_painter(spheres, SIZE, "nearest point") != right).any()
    behind_the_rim = np.array([[-1.22, 0, -2.74, 2], [1.184, 0, -2.647, 0.4]])
    right = nearest(behind_the_rim)
    assert (ways.by_painter(behind_the_rim, SIZE, "tangent") == right).all()
    assert (ways.by_painter(behind_the_rim, SIZE, "middle") != right).any()


@pytest.mark.parametrize("by", ["nearest point", "middle", "tangent"])
def test_no_painter_is_right_if_they_do(by: str) -> None:
    spheres = ways.clump(60)
    assert (ways.by_painter(spheres, SIZE, by) != nearest(spheres)).sum() > 20
    # Two that intersect: either order is wrong.
    two = np.array([[-0.1, 0, -2, 0.5], [0.1, 0, -2, 0.5]])
    right = nearest(two)
    for order in (two, two[::-1]):
        shown = ways.by_painter(order, SIZE, by)
        shown = np.where(shown < 0, -1, shown if order is two else 1 - shown)
        assert (shown != right).any()

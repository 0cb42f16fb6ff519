"""Bonds by distance, against all pairs and their images; and those that a file lists."""

from itertools import product

import numpy as np
import pytest

import clrt
from clrt.particles import bonds
from clrt.particles.bonds import Bonds

RANDOM = np.random.default_rng(11)
SKEW = np.array([[4.0, 0, 0], [1.9, 3.5, 0], [-1.5, 1.6, 3.0]])
CLOUDS: dict[str, tuple[np.ndarray, np.ndarray | float, np.ndarray | None]] = {
    "no box": (RANDOM.uniform(size=(300, 3)), 0.06, None),
    "float32": (RANDOM.uniform(size=(200, 3)).astype(np.float32), 0.08, None),
    "box": (RANDOM.uniform(size=(90, 3)), 0.12, np.eye(3)),
    "skew": (RANDOM.uniform(-2, 3, (60, 3)) @ SKEW, 0.5, SKEW),
    "left-handed": (RANDOM.uniform(size=(60, 3)) @ SKEW, 0.5, SKEW[::-1]),
    "larger than the box": (RANDOM.uniform(size=(3, 3)), 0.8, np.eye(3)),
    "its own images": (np.zeros((1, 3)), 0.55, SKEW / 4),
    "a box of two edges": (RANDOM.uniform(size=(80, 3)), 0.1, np.diag([1.0, 1.0, 0.0])),
    "a box of one edge": (RANDOM.uniform(size=(80, 3)), 0.1, np.diag([0.0, 1.0, 0.0])),
    "no edges": (RANDOM.uniform(size=(80, 3)), 0.1, np.zeros((3, 3))),
    "a few reach far": (RANDOM.uniform(size=(90, 3)), np.r_[[0.3] * 5, [0.05] * 85], np.eye(3)),
    "all reach far": (RANDOM.uniform(size=(60, 3)), RANDOM.uniform(0, 0.2, 60), np.eye(3)),
    "some do not": (RANDOM.uniform(size=(60, 3)), RANDOM.integers(0, 2, 60) * 0.1, None),
    "one far": (np.vstack([RANDOM.uniform(size=(90, 3)), [[1e9, 0, 3]]]), 0.1, None),
    "all along z": (RANDOM.normal(size=(90, 3)) * [0, 0, 1], 0.05, None),
    "twice": (np.repeat(RANDOM.uniform(size=(50, 3)), 2, axis=0), 0.1, None),
    "none": (np.zeros((0, 3)), 1.0, np.eye(3)),
    "reach of none": (RANDOM.uniform(size=(9, 3)), 0.0, None),
}


def of_all(points: np.ndarray, reach: np.ndarray | float, cell: np.ndarray | None) -> set:
    """(first, second, shift), the first not above the second."""
    points = points.astype(float)
    reach = np.broadcast_to(reach, len(points))
    cell = np.zeros((3, 3)) if cell is None else cell
    found = set()
    for shift in product(*(range(-6, 7) if edge.any() else [0] for edge in cell)):
        away = np.linalg.norm(points + np.array(shift) @ cell - points[:, None], axis=2)
        for a, b in zip(*np.nonzero((away < reach[:, None] + reach) & (away > 0)), strict=True):
            found.add(one_way(int(a), int(b), shift))
    return found


def one_way(a: int, b: int, shift: tuple[int, ...]) -> tuple[int, ...]:
    turned = tuple(-one for one in shift)
    return min((a, b, *shift), (b, a, *turned))


def as_set(found: Bonds) -> set:
    rows = zip(found.pairs.tolist(), found.shifts.tolist(), strict=True)
    each = [one_way(pair[0], pair[1], tuple(shift)) for pair, shift in rows]
    assert len(each) == len(set(each))
    return set(each)


@pytest.mark.parametrize("name", CLOUDS)
def test_as_of_all_pairs(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    points, reach, cell = CLOUDS[name]
    expected = of_all(points, reach, cell)
    assert bool(expected) == (name not in ("none", "reach of none"))
    found = bonds.within(points, reach, cell)
    assert found.pairs.dtype == found.shifts.dtype == np.int32
    assert as_set(found) == expected
    monkeypatch.setattr(bonds, "AT_ONCE", 7)
    monkeypatch.setattr(bonds, "MOST_COLUMNS", 4)
    assert as_set(bonds.within(points, reach, cell)) == expected
    if found.pairs.size:
        ways = found.ways(points, cell)
        reach = np.broadcast_to(reach, len(points))[found.pairs].sum(axis=1)
        assert (np.linalg.norm(ways, axis=1) < reach).all()


@pytest.mark.parametrize("name", ["box", "skew", "left-handed", "a box of two edges", "no box"])
def test_listed_bonds_go_to_the_nearest_image(name: str) -> None:
    points, _, cell = CLOUDS[name]
    pairs = RANDOM.permutation(len(points))[:40].reshape(-1, 2)
    ways = bonds.listed(pairs, points, cell).ways(points, cell)
    cell = np.zeros((3, 3)) if cell is None else cell
    shifts = np.array(list(product(range(-6, 7), repeat=3))) @ cell
    away = np.linalg.norm(points[pairs[:, 1]] - points[pairs[:, 0]] + shifts[:, None], axis=2)
    assert np.linalg.norm(ways, axis=1) == pytest.approx(away.min(axis=0), rel=1e-12)


def water(unit: str, scale: float) -> clrt.Particles:
    """Two molecules, the second across the wall; a dummy atom and two locations of another."""
    places = [
        [0, 0, 0],
        [0.96, 0, 0],
        [-0.24, 0.93, 0],
        [0, 0, 8.9],
        [0.96, 0, 8.9],
        [0, 0.96, 0.2],
    ]
    return clrt.Particles(
        np.array([*places, [0.5, 0.5, 0], [4, 0, 0], [5, 0, 0], [5, 0.3, 0]]) * scale,
        elements=[8, 1, 1, 8, 1, 1, 0, 6, 6, 6],
        cell=np.eye(3) * 10 * scale,
        unit=unit,
        texts={"altloc": ["", "", "", "", "", "", "", "", "A", "B"]},
    )


@pytest.mark.parametrize(("unit", "scale"), [("angstrom", 1.0), ("nm", 0.1)])
def test_automatic(unit: str, scale: float) -> None:
    found = bonds.automatic(water(unit, scale))
    assert as_set(found) == {
        (0, 1, 0, 0, 0), (0, 2, 0, 0, 0), (0, 3, 0, 0, -1), (0, 5, 0, 0, 0), (3, 4, 0, 0, 0),
        (7, 8, 0, 0, 0), (7, 9, 0, 0, 0),
    }  # fmt: skip


def test_automatic_needs_elements() -> None:
    with pytest.raises(clrt.RequestError, match="bonds: expected particles whose elements are"):
        bonds.automatic(clrt.Particles(np.zeros((2, 3))))


def test_residues_have_bonds() -> None:
    """A peptide's, and of two ions beside it only the one that is listed."""
    names = ["N", "CA", "C", "N", "CA", "NA", "NA"]
    x = np.array([0, 1.46, 2.9, 4.2, 5.6, 7.6, -1.9])
    found = clrt.Particles(
        x[:, np.newaxis] * [1, 0, 0],
        elements=[7, 6, 6, 7, 6, 11, 11],
        texts={"name": names, "residue": ["GLY"] * 3 + ["ALA"] * 2 + ["NA"] * 2},
        values={"residue_id": [1, 1, 1, 2, 2, 3, 4]},
        bonds=[(5, 4), (1, 0)],
    )
    of_file = bonds.of_file(found)
    assert of_file is not None
    assert sorted(of_file.pairs.tolist()) == [[1, 0], [1, 2], [2, 3], [3, 4], [5, 4]]
    assert bonds.of_file(clrt.Particles(np.zeros((2, 3)))) is None
    only = bonds.of_file(clrt.Particles(np.eye(3), bonds=[(2, 0)], cell=np.eye(3) * 1.5))
    assert only is not None
    assert only.pairs.tolist() == [[2, 0]]
    assert only.shifts.tolist() == [[-1, 0, 1]]

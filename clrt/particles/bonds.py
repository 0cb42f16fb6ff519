"""Bonds: which particles are bonded, and across which edges of their box."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from clrt.errors import RequestError
from clrt.particles import elements
from clrt.particles.particles import Particles
from clrt.values import Array

RESIDUE = ("residue", "residue_id", "chain", "insertion", "segment", "copy")
"""Columns that tell residues apart."""
STRETCH = 1.2
"""Atoms are bonded that are nearer than the sum of their covalent radii times this."""
AT_ONCE = 1 << 17
"""Pairs whose distance is asked for at a time, about, so that they stay in a core's cache."""
FEW, FAR = 16, 1.3
"""One in so many particles that reach so many times as far as the others are looked at alone."""
MOST_COLUMNS = 1 << 20
"""Along a side; where there would be more they are wider."""


class Bonds(NamedTuple):
    """m bonds."""

    pairs: Array
    """(m, 2) int32: the first particle and the second."""
    shifts: Array
    """(m, 3) int32: how many edges of the box the second is moved by, so that it is beside the
    first."""

    def where(self, kept: Array) -> "Bonds":
        """Those of which (m,) bool is True."""
        return self if kept.all() else Bonds(self.pairs[kept], self.shifts[kept])

    def ways(self, positions: Array, cell: Array | None) -> Array:
        """(m, 3) float64, from each first particle to its second."""
        first, second = self.pairs.T
        found: Array = positions[second].astype(np.float64) - positions[first]
        return found if cell is None else found + self.shifts @ cell


def listed(pairs: Array, positions: Array, cell: Array | None) -> Bonds:
    """Bonds that a file lists: each goes to that image of its second particle which is nearest.

    The nearest image in parts of the edges is rounded to, and its 26 neighbours are looked at: in a
    box as skew as simulations have them (tilts up to a half) the nearest one is among them.

    Args:
        pairs: (m, 2).
        positions: (n, 3).
        cell: (3, 3), the edges of the box; rows of 0 are none. None: there is no box.
    """
    pairs = pairs.astype(np.int32, copy=False)
    none = Bonds(pairs, np.zeros((len(pairs), 3), np.int32))
    edges = None if cell is None else completed(cell)
    if edges is None:
        return none
    assert cell is not None
    ways = none.ways(positions, None)
    there: Array = np.asarray(cell.any(axis=1))
    parts = np.rint(ways @ np.linalg.inv(edges)) * there
    near = ways - parts @ cell
    best, shift = np.einsum("ij,ij->i", near, near), np.zeros((len(pairs), 3))
    for step in _steps([1 if one else 0 for one in there]):
        moved = near + step @ cell
        away = np.einsum("ij,ij->i", moved, moved)
        better = away < best * (1 - 1e-9)  # of equal ones the rounded one
        best, shift[better] = np.where(better, away, best), step
    return Bonds(pairs, (shift - parts).astype(np.int32))


def automatic(particles: Particles) -> Bonds:
    """Atoms nearer than STRETCH times the sum of their covalent radii, but no two of hydrogen, and
    none of two locations of one atom. A particle that is no atom has no bonds.

    Raises:
        RequestError: no elements are known.
    """
    numbers = particles.elements
    if numbers is None:
        expected = "particles whose elements are known, or a distance"
        raise RequestError(f"bonds: expected {expected}, got none")
    radii = elements.COVALENT[numbers] * (STRETCH / particles.angstroms)
    found = within(particles.positions, np.where(numbers == 0, 0.0, radii), periodic(particles))
    first, second = found.pairs.T
    one, other = numbers[first], numbers[second]
    kept = ((one != 1) | (other != 1)) & (one != 0) & (other != 0)
    if (altloc := particles.texts.get("altloc")) is not None:
        one, other = altloc[first], altloc[second]
        kept &= (one == other) | (one == "") | (other == "")
    return found.where(kept)


def of_file(particles: Particles) -> Bonds | None:
    """The bonds that a file lists, and those that its format leaves to the names of residues: of
    atoms as near as automatic() has it, in one residue, or both in proteins or nucleic acids. None:
    it says nothing of bonds.

    A PDB file lists bonds of other atoms only (CONECT, "Connectivity Section" of the format's
    description), and mmCIF those between residues (struct_conn). What the residues are made of is
    in a dictionary of 400 MB; by the distances it is found as well.
    """
    cell = periodic(particles)
    own = None
    if particles.bonds is not None:
        own = listed(particles.bonds, particles.positions, cell)
    if "residue" not in particles.texts or particles.elements is None:
        return own
    found = automatic(particles)
    first, second = found.pairs.T
    same = np.ones(len(first), bool)
    for name in RESIDUE:
        if (column := particles.texts.get(name, particles.values.get(name))) is not None:
            same &= column[first] == column[second]
    columns = particles.columns
    is_polymer = np.asarray(columns["protein"]) | np.asarray(columns["nucleic"])
    found = found.where(same | (is_polymer[first] & is_polymer[second]))
    return found if own is None else joined(own, found)


def joined(own: Bonds, more: Bonds) -> Bonds:
    """Some bonds, and others that are none of them."""
    pairs = np.concatenate([own.pairs, more.pairs])
    shifts = np.concatenate([own.shifts, more.shifts])
    turned = pairs[:, 0] > pairs[:, 1]
    keys = np.concatenate([np.sort(pairs), np.where(turned[:, None], -shifts, shifts)], axis=1)
    first = np.sort(np.unique(keys, axis=0, return_index=True)[1])
    return Bonds(pairs[first], shifts[first])


def periodic(particles: Particles) -> Array | None:
    """(3, 3): the edges of the box, along which there are images."""
    if particles.cell is None:
        return None
    found: Array = particles.cell * np.array(particles.periodic)[:, np.newaxis]
    return found


def within(positions: Array, reach: Array | float, cell: Array | None) -> Bonds:
    """Particles that are nearer than the sum of their reaches, but not at one place; of particles
    in a box, with each image of the others, and with those of themselves.

    Particles stand in columns along z, in the order of their z. Those near one are in its column
    and the 8 around it, in each of which two binary searches find them. Each pair is found once: a
    particle looks behind itself in its own column, and into 4 of the others; of the images there
    are those on one side only. 10^6 atoms of a membrane take 1.1 s, in a box 1.4 s, and 0.4 GB.

    Args:
        positions: (n, 3), finite.
        reach: (n,), or one for all.
        cell: as listed().
    """
    n = len(positions)
    points = np.asarray(positions, np.float64)
    reach = np.broadcast_to(np.asarray(reach, np.float64), n)
    widest = 2 * float(reach.max(initial=0.0))
    if n == 0 or widest == 0:
        return Bonds(np.zeros((0, 2), np.int32), np.zeros((0, 3), np.int32))
    edges = None if cell is None else completed(cell)
    if edges is None:
        pairs = np.stack(_pairs(points, reach), axis=1).astype(np.int32)
        return Bonds(pairs, np.zeros((len(pairs), 3), np.int32))
    assert cell is not None
    there: Array = np.asarray(cell.any(axis=1))
    parts = points @ np.linalg.inv(edges)
    home = np.floor(parts) * there
    if home.any():
        parts -= home
        points = points - home @ cell
    row, moved = _images(parts, edges, there, widest)
    reach = np.concatenate([reach, reach[row]])
    first, second = _pairs(np.concatenate([points, points[row] + moved @ cell]), reach)
    kept = first < n  # else both are images
    first, second = first[kept], second[kept]
    across = second >= n
    shifts = np.zeros((len(first), 3), np.int32)
    shifts[across] = moved[second[across] - n]
    second[across] = row[second[across] - n]
    if home.any():
        shifts += (home[first] - home[second]).astype(np.int32)
    return Bonds(np.stack([first, second], axis=1).astype(np.int32), shifts)


def completed(cell: Array) -> Array | None:
    """A box's edges, with a unit vector across the others for each that there is not; None: it has
    none, or they are in a plane."""
    there = cell.any(axis=1)
    if not there.any():
        return None
    edges = cell.astype(np.float64)
    if not there.all():
        across = np.linalg.svd(edges[there])[2][np.count_nonzero(there) :]
        edges[~there] = across
    return edges if np.linalg.matrix_rank(edges) == 3 else None


def _steps(most: list[int]) -> Iterator[Array]:
    """Whole steps of at most so many edges along each, but not none."""
    sides = [np.arange(-one, one + 1) for one in most]
    for step in np.stack(np.meshgrid(*sides, indexing="ij"), -1).reshape(-1, 3):
        if step.any():
            yield step


def _images(parts: Array, edges: Array, there: Array, reach: float) -> tuple[Array, Array]:
    """Which particles have images that are so near to the box, and how many edges these are moved
    by, (k, 3). Of two opposite steps there is one, that whose first number is positive.

    parts: (n, 3), where the particles are in the box, parts of its edges.
    """
    # A plane of the box that is `reach` away cuts its edge at this part.
    margin = reach * np.linalg.norm(np.linalg.inv(edges), axis=0) * (1 + 1e-9) + 1e-12
    most = [int(np.ceil(m)) if one else 0 for m, one in zip(margin, there, strict=True)]
    rows, steps = [np.zeros(0, np.intp)], [np.zeros((0, 3))]
    near = {
        (axis, k): (parts[:, axis] >= -margin[axis] - k) & (parts[:, axis] <= 1 + margin[axis] - k)
        for axis in range(3)
        for k in range(-most[axis], most[axis] + 1)
        if k
    }
    for step in _steps(most):
        axes = np.flatnonzero(step)
        if step[axes[0]] > 0:
            found = np.flatnonzero(near[axes[0], step[axes[0]]])
            for axis in axes[1:]:
                found = found[near[axis, step[axis]][found]]
            rows.append(found)
            steps.append(np.broadcast_to(step, (len(found), 3)))
    return np.concatenate(rows), np.concatenate(steps)


def _pairs(points: Array, reach: Array) -> tuple[Array, Array]:
    """The numbers of points that are nearer than the sum of their reaches, but not at one place;
    the first is below the second. A few that reach far, as ions in water, ask by themselves."""
    most = reach.max()
    usual = np.partition(reach, -(len(reach) // FEW) - 1)[-(len(reach) // FEW) - 1]
    if most < FAR * usual:
        return _asked(points, reach, None)
    far = reach > usual
    others = np.flatnonzero(~far)
    first, second = (others[one] for one in _asked(points[others], reach[others], None))
    more = _asked(points, reach, far)
    return np.concatenate([first, more[0]]), np.concatenate([second, more[1]])


def _asked(points: Array, reach: Array, asking: Array | None) -> tuple[Array, Array]:
    """The same, of pairs that have one of those that are `asking`, (n,) bool; None: of all."""
    low = points.min(axis=0)
    size = points.max(axis=0) - low
    widest = 2 * float(reach.max())
    width = max(widest, float(size[:2].max()) / MOST_COLUMNS) * (1 + 1e-9)
    u, v = (np.floor((points[:, axis] - low[axis]) / width).astype(np.int64) for axis in (0, 1))
    many = int(v.max()) + 3
    column = (u + 1) * many + v + 1
    order = np.lexsort((points[:, 2], column))
    column = column[order]
    begins = np.flatnonzero(np.diff(column, prepend=-1))
    columns = column[begins]
    rank = np.repeat(np.arange(len(begins)), np.diff(begins, append=len(column)))
    x, y, z = np.ascontiguousarray((points[order] - low).T)
    reach = reach[order]
    asks = None if asking is None else asking[order]
    # Ranks and z as one number, rounded by less than `spare`.
    step = float(size[2]) + 3 * widest
    key = rank * step + z
    spare = 4 * float(np.spacing(key[-1] + step))
    window = reach + widest / 2 + spare
    firsts, seconds = list[Array](), list[Array]()
    after = (0, 1, many - 1, many, many + 1)
    for aside in after if asks is None else (*after, *(-one for one in after[1:])):
        at = np.searchsorted(columns, columns + aside)
        at[at == len(columns)] = 0
        beside = np.where(columns[at] == columns + aside, at, -1)[rank]
        rows = np.flatnonzero(beside >= 0 if asks is None else (beside >= 0) & asks)
        middle = beside[rows] * step + z[rows]
        if asks is None and aside == 0:
            begin = rows + 1
        else:
            begin = np.searchsorted(key, middle - window[rows])
        end = np.searchsorted(key, middle + window[rows], "right")
        for i, j in _candidates(rows, begin, end):
            away = (x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2 + (z[i] - z[j]) ** 2
            good = (away < (reach[i] + reach[j]) ** 2) & (away > 0)
            if asks is not None:
                good &= ~asks[j] | (i < j)  # both ask
            near = np.flatnonzero(good)
            firsts.append(order[i[near]])
            seconds.append(order[j[near]])
    first, second = np.concatenate(firsts), np.concatenate(seconds)
    return np.minimum(first, second), np.maximum(first, second)


def _candidates(rows: Array, begin: Array, end: Array) -> Iterator[tuple[Array, Array]]:
    """Each row with each number from begin to below end, (k,) and (k,), AT_ONCE or a bit more at a
    time."""
    counts = np.maximum(end - begin, 0)
    upto = np.cumsum(counts)
    at = 0
    while at < len(rows):
        done = int(upto[at - 1]) if at else 0
        to = max(int(np.searchsorted(upto, done + AT_ONCE, "right")), at + 1)
        part = counts[at:to]
        before = upto[at:to] - part - done
        total = int(upto[to - 1]) - done
        yield (
            np.repeat(rows[at:to], part),
            np.arange(total) + np.repeat(begin[at:to] - before, part),
        )
        at = to

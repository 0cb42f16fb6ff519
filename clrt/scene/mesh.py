"""Mesh: triangles that share corners, of one material, lit flat, Gouraud or Phong.

H. Gouraud, Continuous shading of curved surfaces, IEEE Trans. Comput. C-20 (1971);
B. T. Phong, Illumination for computer generated pictures, CACM 18 (1975).
"""

import copy
import warnings
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from clrt.errors import SceneWarning
from clrt.values import Array, check_rows, floats, frozen, owned, require

Shading: TypeAlias = Literal["flat", "gouraud", "phong"]
SHADINGS: tuple[Shading, ...] = get_args(Shading)


class Mesh:
    """Triangles between points, kept as arrays. Immutable, and equal to another by value.

    Faces without area are dropped, with a warning that counts them. A mesh is closed if each of its
    edges has two faces, in opposite directions, and it holds something; it is then seen from
    outside only. Faces of a closed mesh that is inside out, so that its volume is negative, are
    turned. Normals that are against the faces', as a whole, are turned: scikit-image gives such.

    Args:
        vertices: (n, 3), world units. float32 and float64 are kept as they are; others become
            float64.
        faces: (m, 3) of indices into the vertices, counter-clockwise as seen from the front.
        normals: (n, 3), one a vertex, of any length above 0; where it is 0, and where there are
            none, smooth shading has the faces' normals weighed by their areas.
        colors: (n, 3), one a vertex, or (m, 3), one a face; of both sizes alike they are the
            vertices'. Linear RGB, multiplies the material's ambient and diffuse. None: white.
        material: the name of one of the scene's materials.
        shading: "flat", "gouraud" or "phong"; None: "phong" where there are normals, else "flat".

    Raises:
        SceneError: naming the first value that is wrong.
    """

    def __init__(
        self,
        vertices: ArrayLike,
        faces: ArrayLike,
        normals: ArrayLike | None = None,
        colors: ArrayLike | None = None,
        material: str = "",
        shading: Shading | None = None,
    ) -> None:
        self.vertices = floats("vertices", vertices, 3)
        n = len(self.vertices)
        self.faces = _indices(faces, n)
        given = len(self.faces)
        self.normals = _rows_of("normals", normals, (n,), "one a vertex")
        self.colors = _rows_of("colors", colors, (n, given), "one a vertex or one a face")
        self._colors_are_vertices = self.colors is not None and len(self.colors) == n
        require(isinstance(material, str), "material", "a material's name", material)
        self.material = material
        self.shading: Shading = _shading(shading) or ("flat" if normals is None else "phong")
        areas = self._drop_degenerate(_doubled_areas(self.vertices, self.faces))
        closed = len(self.faces) > 0 and _is_closed(self.vertices, self.faces)
        volume = _volume(self.vertices, self.faces, areas) if closed else 0.0
        self.closed = volume != 0
        """Whether each edge has two faces, in opposite directions, and there is an inside."""
        if volume < 0:
            self.faces = frozen(np.ascontiguousarray(self.faces[:, ::-1]))
            areas = -areas
        if self.normals is not None and _agreement(self.normals, self.faces, areas) < 0:
            self.normals = frozen(-self.normals)

    def _drop_degenerate(self, areas: Array) -> Array:
        """Leaves out faces without area: two of their corners are at one place, or all on a line to
        the last bit of float64. Returns the areas of the others."""
        kept = areas.any(axis=0)
        if kept.all():
            return areas
        flat, n = np.count_nonzero(~kept), len(self.faces)
        warnings.warn(
            f"faces: {flat:,} of {n:,} have no area and are left out", SceneWarning, stacklevel=4
        )
        if self.colors is not None and not self.has_vertex_colors:
            self.colors = frozen(self.colors[kept])
        self.faces = frozen(self.faces[kept])
        return areas[:, kept]

    def made_of(self, material: str, shading: Shading | None = None) -> "Mesh":
        """It of another material, and shaded otherwise if that is given.

        Raises:
            SceneError: there is no such shading.
        """
        shading = _shading(shading) or self.shading
        if (material, shading) == (self.material, self.shading):
            return self
        found = copy.copy(self)
        found.material, found.shading = material, shading
        return found

    def without_colors(self) -> "Mesh":
        """It in its material's colours only."""
        found = copy.copy(self)
        found.colors = None
        return found

    def trimmed(self) -> "Mesh":
        """It without the vertices that no face has; itself if there are none."""
        used = np.zeros(len(self.vertices), bool)
        used[self.faces.ravel()] = True
        if used.all():
            return self
        found = copy.copy(self)
        found.__dict__.pop("vertex_normals", None)
        found.vertices = frozen(self.vertices[used])
        places = np.cumsum(used, dtype=np.int32) - 1
        found.faces = frozen(places[self.faces])
        if self.normals is not None:
            found.normals = frozen(self.normals[used])
        if self.colors is not None and self.has_vertex_colors:
            found.colors = frozen(self.colors[used])
        return found

    @property
    def has_vertex_colors(self) -> bool:
        """Whether there are colours, one a vertex."""
        return self.colors is not None and self._colors_are_vertices

    @property
    def corners(self) -> Array:
        """(m, 3, 3) of the vertices' dtype: faces, their corners, x y z."""
        found: Array = self.vertices[self.faces]
        return found

    @cached_property
    def face_normals(self) -> Array:
        """(m, 3) float64, of unit length: towards where corners are counter-clockwise."""
        return _unit(_doubled_areas(self.vertices, self.faces).T)

    @cached_property
    def vertex_normals(self) -> Array:
        """(n, 3) float64, of unit length: those that were given, or the sum of the faces' normals
        weighed by area; 0 where that is 0."""
        given = None if self.normals is None else _unit(self.normals.astype(np.float64))
        if given is not None and given.any(axis=1).all():
            return given
        areas, summed = _doubled_areas(self.vertices, self.faces), np.zeros(self.vertices.shape)
        for axis in range(3):
            weights = np.repeat(areas[axis], 3)
            summed[:, axis] = np.bincount(self.faces.ravel(), weights, len(self.vertices))
        smooth = _unit(summed)
        if given is None:
            return smooth
        return np.where(given.any(axis=1, keepdims=True), given, smooth)

    @property
    def corner_normals(self) -> Array:
        """(m, 3, 3) float64, of unit length: faces, their corners, x y z. Where a vertex has none
        it is the face's."""
        found: Array = self.vertex_normals[self.faces]
        if not self.vertex_normals.any(axis=1).all():
            none = ~found.any(axis=2)
            found[none] = np.repeat(self.face_normals[:, np.newaxis], 3, axis=1)[none]
        return found

    @property
    def corner_colors(self) -> Array | None:
        """(m, 3, 3): faces, their corners, red green blue; None: white."""
        if self.colors is None:
            return None
        if self.has_vertex_colors:
            found: Array = self.colors[self.faces]
            return found
        return np.broadcast_to(self.colors[:, np.newaxis], (len(self.faces), 3, 3))

    def __len__(self) -> int:
        """How many faces there are."""
        return len(self.faces)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Mesh):
            return NotImplemented
        looks, others = (
            (mesh.material, mesh.shading, mesh.has_vertex_colors) for mesh in (self, other)
        )
        if looks != others:
            return False
        return all(
            a is b or (a is not None and b is not None and np.array_equal(a, b))
            for a, b in zip(self._arrays(), other._arrays(), strict=True)
        )

    def __hash__(self) -> int:
        return hash((self.vertices.shape, self.faces.shape, self.material, self.shading))

    def __repr__(self) -> str:
        closed = ", closed" if self.closed else ""
        return f"Mesh({len(self.vertices)} vertices, {len(self)} faces, {self.shading}{closed})"

    def _arrays(self) -> tuple[Array | None, ...]:
        return self.vertices, self.faces, self.normals, self.colors


def path_tokens(meshes: Sequence[Mesh], first: int) -> Array:
    """(faces,) uint32: what the hash of a path has of each face, where `first` things come before
    them. It is one for a mesh, so that an edge between its faces is none of the picture; of a flat
    one it has the face's normal to a 64th, for there light jumps."""
    found = np.empty(sum(map(len, meshes)), np.uint32)
    start = 0
    for k, mesh in enumerate(meshes):
        some = found[start : start + len(mesh)]
        some[:] = first + k + 1
        if mesh.shading == "flat":
            for block in blocks(len(mesh)):
                x, y, z = (np.rint(mesh.face_normals[block].T * 64) + 64).astype(np.int64)  # to 128
                some[block] ^= ((x + (y << 8) + (z << 16)) * 0x9E3779B1).astype(np.uint32)
        start += len(mesh)
    return found


def _shading(given: Shading | None) -> Shading | None:
    """
    Raises:
        SceneError: there is no such shading.
    """
    known = given is None or given in SHADINGS
    require(known, "shading", "'flat', 'gouraud' or 'phong'", given)
    return given


def _indices(given: ArrayLike, n: int) -> Array:
    """(m, 3) int32 of indices below n that nobody else can change.

    Raises:
        SceneError: they are not.
    """
    try:
        found = np.asarray(given)
    except ValueError:  # rows of different lengths
        found = np.zeros(())
    if found.size == 0:
        found = np.zeros((0, 3), np.int32)
    good = found.ndim == 2 and found.shape[1] == 3 and found.dtype.kind in "iu"
    require(good, "faces", "whole numbers of shape (m, 3)", given)
    if found.size and not (found.min() >= 0 and found.max() < n):
        rows = (found >= 0) & (found < n)
        check_rows("faces", rows, found, f"indices from 0 to {n - 1}" if n else "no vertices")
    return owned(found.astype(np.int32, copy=False))


def _rows_of(key: str, given: ArrayLike | None, counts: tuple[int, ...], what: str) -> Array | None:
    """(n, 3) of one of those counts, or None.

    Raises:
        SceneError: they are not.
    """
    if given is None:
        return None
    found = floats(key, given, 3)
    require(len(found) in counts, key, what, found)
    return found


BLOCK = 1 << 14
"""Faces that are worked on at a time: what is between fits into a core's own memory."""


def blocks(n: int) -> Iterator[slice]:
    """Slices of n faces, BLOCK at a time."""
    return (slice(start, start + BLOCK) for start in range(0, n, BLOCK))


def _doubled_areas(vertices: Array, faces: Array) -> Array:
    """(3, m) float64: the cross product of two edges of each face, in a unit in which the longest
    edge is between 2^-40 and 2: so their squares stay in range, be they 1e-200 or 1e200 long."""
    scale = _near_one(vertices)
    found, longest = _crosses(vertices, faces, scale, 1.0)
    unit = _near_one(longest)
    return found if unit < 2.0**40 else _crosses(vertices, faces, scale, unit)[0]


def _crosses(vertices: Array, faces: Array, scale: float, unit: float) -> tuple[Array, Array]:
    """The cross product of two edges of each face, (3, m) float64, and their longest side. Corners
    are multiplied by one power of two, then edges by another."""
    sides = [np.ascontiguousarray(vertices[:, axis], np.float64) * scale for axis in range(3)]
    found, longest = np.empty((3, len(faces))), np.zeros(1)
    one, other = np.empty((3, BLOCK)), np.empty((3, BLOCK))
    for block in blocks(len(faces)):
        corners = faces[block].T.astype(np.intp)
        p, q = one[:, : corners.shape[1]], other[:, : corners.shape[1]]
        for axis, side in enumerate(sides):
            a, b, c = side.take(corners)
            np.subtract(b, a, out=p[axis])
            np.subtract(c, a, out=q[axis])
        if unit != 1:
            p *= unit
            q *= unit
        longest = np.maximum(longest, max(p.max(), -p.min(), q.max(), -q.min()))
        for axis in range(3):
            i, j = (axis + 1) % 3, (axis + 2) % 3
            np.subtract(p[i] * q[j], p[j] * q[i], out=found[axis, block])
    return found, longest


def _along(vertices: Array, faces: Array, axis: int, scale: float) -> Iterator[Array]:
    """One coordinate, times a power of two, of the first, second and third corners."""
    side = vertices[:, axis].astype(np.float64) * scale
    yield from (side[faces[:, k]] for k in range(3))


def _near_one(values: Array) -> float:
    """A power of two that takes the largest of some values to between 1/2 and 1."""
    size = max(float(np.max(values, initial=0)), -float(np.min(values, initial=0)))
    return float(np.ldexp(1.0, -np.frexp(size)[1])) if size > 2.0**-1000 else 2.0**1000


def _unit(vectors: Array) -> Array:
    """Rows of unit length, 0 where they are 0."""
    found = np.zeros(vectors.shape)
    for block in blocks(len(vectors)):
        some = np.ascontiguousarray(vectors[block].T)
        # Divided by their largest number first, so that its square is in range.
        largest = np.maximum(some.max(axis=0), -some.min(axis=0))
        there = largest > 0
        some = some / np.where(there, largest, 1)
        length = np.sqrt(some[0] * some[0] + (some[1] * some[1] + some[2] * some[2]))
        found[block] = (some / np.where(there, length, 1)).T
    return found


def _is_closed(vertices: Array, faces: Array) -> bool:
    """Whether each edge has two faces in opposite directions. Vertices at one place are one."""
    return _balanced(faces, len(vertices)) or _balanced(_merged(vertices)[faces], len(vertices))


def _balanced(faces: Array, n: int) -> bool:
    """Whether each edge between n vertices has two faces in opposite directions."""
    if len(faces) % 2:
        return False
    # Of an edge and its direction; both directions of one edge are neighbours once sorted.
    keys = np.empty((len(faces), 3), np.int64)
    for block in blocks(len(faces)):
        corners = faces[block].T.astype(np.int64)
        for k in range(3):
            start, end = corners[k], corners[(k + 1) % 3]
            edge = np.minimum(start, end) * n + np.maximum(start, end)
            keys[block, k] = 2 * edge + (start > end)
    flat = keys.reshape(-1)
    flat.sort()
    for block in blocks(len(flat) // 2):
        there, back = flat[0::2][block], flat[1::2][block]
        if (there & 1).any() or (back != there + 1).any():
            return False
    return True


def _merged(vertices: Array) -> Array:
    """(n,): for each vertex the number of its place."""
    whole = np.ascontiguousarray(vertices + 0.0)  # so -0.0 is 0.0
    rows = whole.view(np.dtype((np.void, whole.itemsize * 3)))[:, 0]
    found: Array = np.unique(rows, return_inverse=True)[1]
    return found


def _agreement(normals: Array, faces: Array, areas: Array) -> float:
    """Above 0 if normals of corners are on the faces' side, more than not."""
    return sum(
        float(corner @ areas[axis])
        for axis in range(3)
        for corner in _along(normals, faces, axis, 1.0)
    )


def _volume(vertices: Array, faces: Array, areas: Array) -> float:
    """What a closed mesh holds, in a unit of its own; negative if it is inside out. 0 if what it
    holds is less than the sum's error: faces back to back hold nothing."""
    scale, volume, most = _near_one(vertices), 0.0, 0.0
    for axis in range(3):
        side = vertices[:, axis].astype(np.float64) * scale
        side -= side[faces[0, 0]]
        for block in blocks(len(faces)):
            parts = side.take(faces[block, 0]) * areas[axis, block]
            volume += float(parts.sum())
            most += float(abs(parts).sum())
    return volume if abs(volume) > 2.0**-40 * most else 0.0

"""Which sphere does each pixel show? Four ways to find out, and where the painter is wrong.

A camera at the origin looks along -z; the screen one unit ahead of it is 2 wide. spheres: (n, 4),
x, y, z and radius, all of them ahead. Each way returns the index of the sphere that each pixel
shows, -1 where it shows none.
"""

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

import clrt

Floats = NDArray[np.float64]
Ids = NDArray[np.int32]
Size = tuple[int, int]  # columns and rows


def screen(size: Size) -> tuple[Floats, Floats]:
    """x of each column, and y of each row, of the rays (x, y, -1)."""
    width, height = size
    return np.linspace(-1, 1, width), np.linspace(1, -1, height) * (height / width)


def boxes(spheres: Floats, size: Size) -> NDArray[np.int64]:
    """The columns, from and to, and the rows, from and to, between which each can show, (n, 4)."""
    x, y = screen(size)
    depth, radius = -spheres[:, 2], spheres[:, 3]
    ends = []
    for axis, places in ((0, x), (1, -y)):  # y falls with the row
        middle = spheres[:, axis] * (1, -1)[axis]
        square = depth**2 - radius**2
        half = radius * np.sqrt(middle**2 + square)
        first, last = ((middle * depth + side * half) / square for side in (-1, 1))
        ends += [np.searchsorted(places, first), np.searchsorted(places, last, "right")]
    return np.stack(ends, axis=1)


def distance(sphere: Floats, x: Floats, y: Floats) -> Floats:
    """How far along the rays (x, y, -1) a sphere is met, infinity where it is not."""
    cx, cy, cz, radius = sphere
    square = x**2 + y**2 + 1
    toward = x * cx + y * cy - cz
    # |direction x center|^2: its difference from r^2 keeps its digits for a sphere that is far.
    across = (y * cz + cy) ** 2 + (x * cz + cx) ** 2 + (x * cy - y * cx) ** 2
    inside = radius**2 * square - across
    root = np.sqrt(np.maximum(inside, 0))
    return np.where(inside > 0, (toward - root) / square, np.inf)


def by_rays(spheres: Floats, size: Size) -> Ids:
    """Ray by ray, by clrt: each ray asks for its nearest sphere, which a tree finds."""
    matte = clrt.Material((0.1, 0.1, 0.1), (0.6, 0.6, 0.6), (0, 0, 0), 1)
    arrays = clrt.Spheres(spheres[:, :3], spheres[:, 3], "matte")
    camera = clrt.Camera((0, 0, 0), (0, 0, -1))
    scene = clrt.Scene(camera, [clrt.Light((5, 5, 5))], {"matte": matte}, arrays)
    with clrt.Renderer() as renderer:
        _, passes = renderer.render(scene, *size, passes=("id",))
    ids: Ids = passes["id"]
    return ids


def by_z_buffer(spheres: Floats, size: Size, tile: int = 32) -> Ids:
    """Sphere by sphere, in tiles: each pixel keeps the nearest so far, and its depth. A tile takes
    its spheres from near to far, and ends where the next begins behind its farthest pixel."""
    x, y = screen(size)
    shown, depth = np.full((len(y), len(x)), -1, np.int32), np.full((len(y), len(x)), np.inf)
    box = boxes(spheres, size)
    begins = -spheres[:, 2] - spheres[:, 3]
    for top in range(0, len(y), tile):
        in_rows = np.flatnonzero((box[:, 2] < top + tile) & (box[:, 3] > top))
        for left in range(0, len(x), tile):
            here = (box[in_rows, 0] < left + tile) & (box[in_rows, 1] > left)
            ids = in_rows[here]
            farthest = np.inf
            for i in ids[np.argsort(begins[ids])]:
                if begins[i] > farthest:
                    break
                columns = slice(max(box[i, 0], left), min(box[i, 1], left + tile))
                rows = slice(max(box[i, 2], top), min(box[i, 3], top + tile))
                found = distance(spheres[i], x[columns], y[rows, np.newaxis])
                nearer = found < depth[rows, columns]
                if nearer.any():
                    depth[rows, columns][nearer] = found[nearer]
                    shown[rows, columns][nearer] = i
                    farthest = depth[top : top + tile, left : left + tile].max()
    return shown


def by_painter(spheres: Floats, size: Size, by: str = "nearest point") -> Ids:
    """From the farthest to the nearest sphere, each over what is there. "Farthest" can be read in
    three ways. By the length of a tangent is right for spheres that are apart: the plane of points
    with equal tangents to two of them lies between them, and the camera is on the side of the one
    that it sees first. No order is right for spheres that intersect."""
    x, y = screen(size)
    shown = np.full((len(y), len(x)), -1, np.int32)
    middle, radius = np.linalg.norm(spheres[:, :3], axis=1), spheres[:, 3]
    tangent = np.sqrt(middle**2 - radius**2)
    far = {"middle": middle, "nearest point": middle - radius, "tangent": tangent}[by]
    box = boxes(spheres, size)
    for i in np.argsort(-far, kind="stable"):
        columns, rows = slice(*box[i, :2]), slice(*box[i, 2:])
        covers = np.isfinite(distance(spheres[i], x[columns], y[rows, np.newaxis]))
        shown[rows, columns][covers] = i
    return shown


def by_scanline(spheres: Floats, size: Size, every: int = 1) -> Ids:
    """Row by row (the first of so many): the spheres that meet it are a list that is kept from row
    to row. Where each begins and ends cuts the row into spans. A span whose ends show the same
    sphere shows it all along, any other is halved."""
    x, y = screen(size)
    shown = np.full((len(y[::every]), len(x)), -1, np.int32)
    box = boxes(spheres, size)
    order = np.argsort(box[:, 2], kind="stable")
    active, taken = np.zeros(0, np.int64), 0
    for line, row in enumerate(range(0, len(y), every)):
        more = int(np.searchsorted(box[order, 2], row, "right"))
        active = np.concatenate([active, order[taken:more]])
        active, taken = active[box[active, 3] > row], more
        cuts = np.unique(_spans(spheres[active], x, y[row]))
        first, last = cuts[:-1], cuts[1:] - 1
        while len(first):
            left, right = (_nearest(spheres, active, x[end], y[row]) for end in (first, last))
            for a, b, i in zip(first, last, left, strict=True):
                shown[line, a : b + 1] = i
            shown[line, last] = right
            rest = (left != right) & (last - first > 1)
            first, last, middle = first[rest], last[rest], (first + last)[rest] // 2
            first, last = np.concatenate([first, middle]), np.concatenate([middle, last])
    return shown


def _spans(spheres: Floats, x: Floats, y: float) -> NDArray[np.int64]:
    """The columns, from and to, between which each sphere shows in the row, (2, n)."""
    cx, cy, cz, radius = spheres.T
    # distance() has a hit where this is above 0: a x^2 + 2 b x + c.
    a = radius**2 - cz**2 - cy**2
    b = cx * (y * cy - cz)
    c = radius**2 * (y**2 + 1) - (y * cz + cy) ** 2 - cx**2 * (y**2 + 1)
    half = np.sqrt(np.maximum(b**2 - a * c, 0))
    return np.stack([np.searchsorted(x, (b + side * half) / -a) for side in (-1, 1)])


def _nearest(spheres: Floats, active: NDArray[np.int64], x: Floats, y: Floats) -> Ids:
    """Of the active spheres the nearest at each x; -1 where there is none."""
    found = distance(spheres[active].T[:, :, np.newaxis], x, y)
    best = np.argmin(found, axis=0)
    return np.where(np.isfinite(found.min(axis=0)), active[best], -1).astype(np.int32)


def truth(spheres: Floats, size: Size) -> Ids:
    """All spheres, in no order, each in all pixels that it can show in, in float64."""
    x, y = screen(size)
    shown, depth = np.full((len(y), len(x)), -1, np.int32), np.full((len(y), len(x)), np.inf)
    for i, (left, right, top, bottom) in enumerate(boxes(spheres, size)):
        part = slice(top, bottom), slice(left, right)
        found = distance(spheres[i], x[part[1]], y[part[0], np.newaxis])
        nearer = found < depth[part]
        depth[part][nearer], shown[part][nearer] = found[nearer], i
    return shown


WAYS: dict[str, Callable[[Floats, Size], Ids]] = {
    "rays": by_rays,
    "tiles with a z-buffer": by_z_buffer,
    "painter, by nearest point": by_painter,
    "painter, by middle": partial(by_painter, by="middle"),
    "painter, by tangent": partial(by_painter, by="tangent"),
    "scanline": by_scanline,
}


def clump(count: int) -> Floats:
    """Balls that intersect, as a molecule's do."""
    random = np.random.default_rng(7)
    centers = random.normal(0, 0.25, (count, 3)) * (1.6, 0.9, 1) + (0, 0, -1.7)
    return np.column_stack([centers, random.uniform(0.06, 0.18, count)])


def main() -> None:
    size, spheres = (480, 270), clump(200)
    right = truth(spheres, size)
    # A colour for each sphere, the last one for none; darker where a pixel is right.
    colors = np.append(
        np.random.default_rng(0).integers(90, 230, (len(spheres), 3)), [[255] * 3], 0
    )
    panels = [colors[right].astype(np.uint8)]
    for name, way in WAYS.items():
        shown = way(spheres, size)
        wrong = shown != right
        print(
            f"{name}: {np.count_nonzero(wrong)} of {np.count_nonzero(right >= 0)} pixels are wrong"
        )
        if name.startswith("painter"):
            panels.append(
                np.where(wrong[..., np.newaxis], (255, 0, 0), colors[shown]).astype(np.uint8)
            )
    rows = [np.concatenate(panels[i : i + 2], axis=1) for i in (0, 2)]
    clrt.save("visible_surfaces.png", np.concatenate(rows))


if __name__ == "__main__":
    main()

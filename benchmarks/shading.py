"""Shading: how far flat, Gouraud and Phong shading of a sphere of triangles are from the sphere."""

import sys
from typing import Any

import click
import numpy as np

import clrt
from benchmarks import harness
from clrt.scene.mesh import SHADINGS, Shading

PARTS = (1, 2, 3, 4, 6, 8, 12, 16)
"""In how many the edges of an icosahedron are cut: 20 to 5,120 faces."""
MATERIAL = clrt.Material((0.1, 0.1, 0.1), (0.6, 0.6, 0.6), (0.5, 0.5, 0.5), shininess=100)
CAMERA = clrt.Camera((0, 0, 3), (0, 0, 0), projection="orthographic", height=2.1)
LIGHTS = (clrt.Light((3, 4, 5)),)


@click.command("shading")
@click.pass_obj
def command(quick: bool) -> None:
    """Draws a sphere of more and more triangles, flat, Gouraud and Phong, against the true sphere,
    all by the float64 truth."""
    side = 60 if quick else 240
    sphere = clrt.Scene(
        CAMERA, LIGHTS, {"m": MATERIAL}, [clrt.Sphere((0, 0, 0), 1, "m")], max_depth=1
    )
    right = clrt.reference.trace(sphere, side, side)
    figures = []
    for parts in PARTS[:3] if quick else PARTS:
        vertices, faces = geodesic(parts)
        print(f"{len(faces):,} faces", file=sys.stderr)
        for shading in SHADINGS:
            found = clrt.reference.trace(scene_of(vertices, faces, shading), side, side)
            figures.append({"faces": len(faces), "shading": shading, **errors(found, right)})
    results = {"side": side, "figures": figures}
    print(tabulated(results))
    harness.record(harness.results_folder(quick), "shading", results)


def geodesic(parts: int) -> tuple[Any, Any]:
    """A unit sphere's vertices (n, 3), and faces (20 parts^2, 3): an icosahedron with its edges in
    so many parts."""
    long = (1 + 5**0.5) / 2
    signs = [(a, b) for a in (-1, 1) for b in (-long, long)]
    corners = np.array(
        [(0, a, b) for a, b in signs]
        + [(b, 0, a) for a, b in signs]
        + [(a, b, 0) for a, b in signs]
    ) / np.hypot(1, long)
    near = np.linalg.norm(corners[:, np.newaxis] - corners, axis=2) < 1.1
    triples = [
        (i, j, k)
        for i in range(12)
        for j in range(i + 1, 12)
        for k in range(j + 1, 12)
        if near[i, j] and near[j, k] and near[i, k]
    ]
    grid = [(i, j) for i in range(parts + 1) for j in range(parts + 1 - i)]
    at = {place: n for n, place in enumerate(grid)}
    local = [(at[i, j], at[i + 1, j], at[i, j + 1]) for i, j in grid if i + j < parts]
    local += [(at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]) for i, j in grid if i + j < parts - 1]
    weights = np.array([(parts - i - j, i, j) for i, j in grid]) / parts
    points = np.einsum("kc,fcx->fkx", weights, corners[np.array(triples)]).reshape(-1, 3)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    faces = (np.array(local) + len(grid) * np.arange(20)[:, np.newaxis, np.newaxis]).reshape(-1, 3)
    _, first, which = np.unique(np.round(points, 9), axis=0, return_index=True, return_inverse=True)
    vertices, faces = points[first], which.reshape(-1)[faces]
    inward = np.linalg.det(vertices[faces]) < 0
    faces[inward] = faces[inward, ::-1]
    return vertices, faces


def scene_of(vertices: Any, faces: Any, shading: Shading) -> clrt.Scene:
    """The sphere's scene with a mesh in its place, whose normals are the sphere's."""
    mesh = clrt.Mesh(vertices, faces, vertices, material="m", shading=shading)
    return clrt.Scene(CAMERA, LIGHTS, {"m": MATERIAL}, meshes=[mesh], max_depth=1)


def errors(found: Any, right: Any) -> dict[str, float]:
    """Of colours where both are seen, white is 1; and which part of the sphere is not covered."""
    seen = right.id >= 0
    both = seen & (found.id >= 0)
    off = abs(found.image - right.image).max(axis=-1)[both]
    return {
        "rms": float(np.sqrt((off**2).mean())),
        "p99": float(np.percentile(off, 99)),
        "max": float(off.max()),
        "uncovered": 1 - float(both.sum() / seen.sum()),
    }


def tabulated(results: dict[str, Any]) -> str:
    """Markdown."""
    side, figures = results["side"], results["figures"]
    head = (
        f"{side}x{side}, faces",
        *(f"{shading}: {what}" for shading in SHADINGS for what in ("rms", "99 %")),
        "rim not covered",
    )
    rows = []
    for faces in sorted({figure["faces"] for figure in figures}):
        of = {one["shading"]: one for one in figures if one["faces"] == faces}
        cells = [f"{of[s][key]:.4f}" for s in SHADINGS for key in ("rms", "p99")]
        rows.append((f"{faces:,}", *cells, f"{of['flat']['uncovered']:.2%}"))
    return harness.table(head, rows)

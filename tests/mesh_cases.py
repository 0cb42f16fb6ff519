"""Meshes that break naive ray tracing of triangles: each with its reason. All are lit."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace

import clrt
from clrt import Camera, Capsule, Light, Material, Mesh, Scene, Sphere
from clrt.scene.mesh import Shading

Array = np.ndarray
SIZE = 60, 45


class MeshCase(NamedTuple):
    name: str
    reason: str
    scene: Scene


MATERIALS = {
    "red": Material((0.1, 0.02, 0.02), (0.7, 0.2, 0.1), (0.6, 0.6, 0.6), shininess=60),
    "mirror": Material((0.02, 0.02, 0.02), (0.2, 0.3, 0.5), (1, 1, 1), reflection=0.5),
    "phong": Material((0.1, 0.1, 0), (0.5, 0.5, 0.1), (0.8, 0.8, 0.8), 40, highlight="phong"),
}
CAMERA = Camera((0.3, 0.4, 3), (0, 0, 0), fov=50)
LIGHTS = (Light((3, 4, 5)), Light((-5, 3, 2), diffuse=(0.3, 0.3, 0.5)))


def icosahedron() -> tuple[Array, Array]:
    """Corners (12, 3) of unit length, and faces (20, 3)."""
    long = (1 + 5**0.5) / 2
    corners: list[tuple[float, float, float]] = [(0, a, b) for a in (-1, 1) for b in (-long, long)]
    corners += [(b, 0, a) for a in (-1, 1) for b in (-long, long)]
    corners += [(a, b, 0) for a in (-1, 1) for b in (-long, long)]
    vertices = np.array(corners) / np.hypot(1, long)
    edge = np.linalg.norm(vertices[:, np.newaxis] - vertices, axis=2)
    near = (edge > 0) & (edge < 1.1)
    faces = [
        (i, j, k) if np.linalg.det(vertices[[i, j, k]]) > 0 else (i, k, j)
        for i in range(12)
        for j in range(i + 1, 12)
        for k in range(j + 1, 12)
        if near[i, j] and near[j, k] and near[i, k]
    ]
    return vertices, np.array(faces)


def sphere(
    parts: int, radius: float = 1, center: tuple[float, ...] = (0, 0, 0)
) -> tuple[Array, Array]:
    """A sphere's vertices and faces: an icosahedron, each edge of it in so many parts."""
    corners, triangles = icosahedron()
    rows = [(i, j) for i in range(parts + 1) for j in range(parts + 1 - i)]
    place = {ij: n for n, ij in enumerate(rows)}
    local = [[place[i, j], place[i + 1, j], place[i, j + 1]] for i, j in rows if i + j < parts]
    local += [
        [place[i + 1, j], place[i + 1, j + 1], place[i, j + 1]]
        for i, j in rows
        if i + j < parts - 1
    ]
    weights = np.array([(parts - i - j, i, j) for i, j in rows]) / parts
    points = np.einsum("kc,fcx->fkx", weights, corners[triangles])
    points /= np.linalg.norm(points, axis=2, keepdims=True)
    faces = (np.array(local) + len(rows) * np.arange(len(triangles))[:, None, None]).reshape(-1, 3)
    _, first, merged = np.unique(
        np.round(points.reshape(-1, 3), 9), axis=0, return_index=True, return_inverse=True
    )
    vertices = points.reshape(-1, 3)[first]
    return vertices * radius + np.array(center), merged.reshape(-1)[faces]


def ball(
    parts: int, shading: Shading = "flat", material: str = "red", radius: float = 1,
    center: tuple[float, float, float] = (0, 0, 0),
) -> Mesh:  # fmt: skip
    vertices, faces = sphere(parts, radius, center)
    return Mesh(vertices, faces, vertices - center, material=material, shading=shading)


def square(size: float, y: float, material: str = "red", other_way: bool = False) -> Mesh:
    """Two faces of a floor, seen from above."""
    corners = size * np.array([[-1.0, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]]) + [0, y, 0]
    faces = [[0, 1, 3], [1, 2, 3]] if other_way else [[0, 1, 2], [0, 2, 3]]
    return Mesh(corners, faces, material=material)


def shown(*meshes: Mesh, **more: object) -> Scene:
    return replace(Scene(CAMERA, LIGHTS, MATERIALS, meshes=meshes), **more)


def scaled(scene: Scene, scale: float, by: tuple[float, float, float] = (0, 0, 0)) -> Scene:
    """A scene, scaled and then moved."""

    def there(point: tuple[float, ...]) -> tuple[float, float, float]:
        x, y, z = (scale * a + b for a, b in zip(point, by, strict=True))
        return x, y, z

    camera = scene.camera
    lights = [replace(one, position=there(one.position)) for one in LIGHTS]
    meshes = [
        Mesh(scale * m.vertices + by, m.faces, m.normals, m.colors, m.material, m.shading)
        for m in scene.meshes
    ]
    return replace(
        scene,
        camera=replace(camera, position=there(camera.position), look_at=there(camera.look_at)),
        lights=lights,
        meshes=meshes,
    )


def slivers() -> Mesh:
    """A fan of triangles a million times as long as they are wide, and one beside each other."""
    count = 40
    angles = np.linspace(0, 4e-5, count)
    rim = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1) * 2 - [1, 0, 0]
    fan = np.concatenate([[[-1.0, 0, 0]], rim])
    faces = np.array([[0, k, k + 1] for k in range(1, count)])
    across = np.array([[-1, 0.3, 0], [1, 0.3, 0], [1, 0.3 + 2e-6, 0], [-1, 0.8, 0], [1, 0.8, 0.1]])
    more = np.array([[0, 1, 2], [0, 2, 3], [3, 2, 4]]) + len(fan)
    return Mesh(np.concatenate([fan, across]), np.concatenate([faces, more]), material="red")


def aimed() -> Scene:
    """The middle column and row of pixels lie exactly on edges, the middle pixel on a corner."""
    grid = np.arange(-3.0, 4)
    x, y = np.meshgrid(grid, grid)
    vertices = np.stack([x.ravel(), y.ravel(), -0.25 * (x + y).ravel() ** 2], axis=1)
    at = np.arange(49).reshape(7, 7)
    quads = np.stack([at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]], axis=-1).reshape(-1, 4)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return shown(Mesh(vertices, faces, material="red"), camera=Camera((0, 0, 4), (0, 0, 0)))


def colored(by_face: bool) -> Mesh:
    vertices, faces = sphere(3)
    random = np.random.default_rng(1)
    colors = random.uniform(0, 1, (len(faces if by_face else vertices), 3))
    return Mesh(vertices, faces, vertices, colors, "red")


def cases() -> Iterator[MeshCase]:
    shadings: tuple[Shading, ...] = ("flat", "gouraud", "phong")
    for shading in shadings:
        yield MeshCase(f"ball-{shading}", "a closed mesh", shown(ball(4, shading)))
    for shading in shadings:
        vertices, faces = sphere(4)
        half = faces[(vertices[faces].mean(axis=1) @ [0.5, 0.2, -1]) > -0.1]
        bowl = Mesh(vertices, half, vertices, material="phong", shading=shading)
        floor = square(4, -1)
        yield MeshCase(f"bowl-{shading}", "an open mesh, from both sides", shown(bowl, floor))
    yield MeshCase("colors-of-corners", "interpolated", shown(colored(by_face=False)))
    yield MeshCase("colors-of-faces", "one each", shown(colored(by_face=True)))
    yield MeshCase("edges", "pixels that lie on edges and a corner", aimed())
    yield MeshCase("slivers", "a million times as long as wide", shown(slivers()))
    yield MeshCase(
        "coplanar",
        "two floors in one plane, parted otherwise: the smaller index",
        shown(square(1, 0, "red"), square(1.5, 0, "phong", other_way=True)),
    )
    double = Mesh([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 1]], material="red")
    yield MeshCase("back-to-back", "two faces at one place: it holds nothing", shown(double))
    through = Mesh([[-2, -1, 2.9], [2, 1.5, 3.1], [0.3, 0.4, 4]], [[0, 1, 2]], material="phong")
    yield MeshCase("through-the-camera", "a face that the camera is in", shown(through, ball(2)))
    around = ball(3, "phong", "phong", radius=9)
    yield MeshCase("around-the-camera", "closed: not seen from inside", shown(around, ball(3)))
    small, large = scaled(shown(ball(4, "phong"), square(2, -1)), 1e-6), scaled(shown(ball(4)), 1e6)
    yield MeshCase("1e-6", "no length is special", small)
    yield MeshCase("1e6", "no length is special", large)
    far = scaled(shown(ball(4), square(2, -1)), 1, (1e5, -2e5, 1e5))
    yield MeshCase("far-away", "world coordinates lose their last digits", far)
    yield MeshCase(
        "from-afar",
        "small angles",
        shown(ball(4), square(2, -1), camera=Camera((300, 400, 3000), (0, 0, 0), fov=0.05)),
    )
    yield MeshCase(
        "touching",
        "spheres and a capsule that lie on faces, and go through them",
        shown(
            square(4, -0.5),
            ball(2, radius=0.4, center=(-0.8, 0, 0)),
            spheres=[Sphere((0.3, 0, 0), 0.5, "mirror"), Sphere((0.9, -0.5, 0.6), 0.3, "red")],
            capsules=[Capsule((-0.6, -0.4, 0.9), (0.5, -0.4, 0.9), 0.1, "red")],
        ),
    )
    yield MeshCase(
        "mirrors",
        "faces mirror as they are, however they are shaded",
        shown(
            square(4, -1, "mirror"),
            ball(2, "phong", "mirror"),
            ball(2, "gouraud", "red", 0.4, (1, 0.4, 0.4)),
            spheres=[Sphere((-1, 0.6, 0.2), 0.4, "red")],
            max_depth=4,
        ),
    )
    wall = Camera((0.3, 0.4, 3), (0, 0, 0), projection="orthographic", height=2.5)
    yield MeshCase("orthographic", "lines without a start", shown(ball(3), camera=wall))
    near = replace(wall, position=(0.03, 0.04, 0.3))
    yield MeshCase("orthographic-inside", "and that begin behind", shown(ball(3), camera=near))
    yield MeshCase(
        "walls",
        "light along a wall, and a seam where walls meet",
        shown(
            Mesh(
                [[-2, -1, -2], [2, -1, -2], [2, -1, 2], [-2, -1, 2], [-2, 2, -2], [2, 2, -2]],
                [[0, 2, 1], [0, 3, 2], [0, 1, 5], [0, 5, 4]],
                material="red",
            ),
            lights=(Light((0.2, -0.9, -1.9)), clrt.DirectionalLight((-1, -0.5, -1e-3))),
        ),
    )


CASES = tuple(cases())

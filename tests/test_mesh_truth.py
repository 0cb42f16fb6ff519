"""The truth of meshes: where rays meet faces, and how these are shaded."""

from fractions import Fraction

import mesh_cases
import numpy as np
import pytest
from mesh_cases import CASES, LIGHTS, MATERIALS, MeshCase, ball, shown, sphere, square
from msgspec.structs import replace

import clrt
from clrt import Camera, Capsule, Light, Material, Mesh, Scene, Sphere
from clrt.scene.mesh import path_tokens
from clrt.truth import faces, hits, tracer
from clrt.truth.rays import Rays
from clrt.truth.world import World


def from_point(world: World, origin: np.ndarray, direction: np.ndarray) -> Rays:
    """Rays from a point along (n, 3)."""
    n = len(direction)
    way = (direction / np.linalg.norm(direction, axis=1, keepdims=True)).T.astype(world.dtype)
    start = np.repeat(np.asarray(origin, world.dtype)[:, np.newaxis], n, axis=1)
    none = np.full(n, -1)
    inside = np.zeros((n, len(world.panes)), bool)
    behind = np.full(n, -np.inf)
    return Rays(np.arange(n), np.ones(n), start, way, none, inside, none, 0, behind, none)


def world_of(*meshes: Mesh, dtype: type = np.float64) -> World:
    return World(shown(*meshes), True, np.dtype(dtype))


@pytest.mark.parametrize("dtype", [np.float64, np.longdouble])
def test_the_sign_is_that_of_the_exact_value(dtype: type) -> None:
    random = np.random.default_rng(4)
    corners: np.ndarray = random.normal(size=(3, 3, 400)).astype(dtype)
    # Through a corner, through an edge, nearly so, and anywhere.
    part: np.ndarray = np.where(np.arange(400) % 4 == 0, 0, random.uniform(0, 1, 400)).astype(dtype)
    way = corners[:, 0] + part * (corners[:, 1] - corners[:, 0])
    way[:, 300:] += random.normal(size=(3, 100)) * np.repeat([1e-20, 1e-17, 1e-15, 1], 25)
    found = faces._weights(way, corners)
    certain = 0
    for n in range(400):
        d = [Fraction(*x.as_integer_ratio()) for x in way[:, n]]
        c = [[Fraction(*x.as_integer_ratio()) for x in corners[:, k, n]] for k in range(3)]
        for k in range(3):
            a, b = c[(k + 2) % 3], c[(k + 1) % 3]
            cross = [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]
            exact = sum(x * y for x, y in zip(d, cross, strict=True))
            assert (found[k, n] > 0, found[k, n] < 0) == (exact > 0, exact < 0)
            certain += exact == 0
    assert certain > 50


def test_no_ray_passes_between_faces() -> None:
    # From inside, one face left out, so that backs are seen.
    vertices, all_faces = sphere(6)
    mesh = Mesh(vertices, all_faces[1:], material="red")
    assert not mesh.closed
    world = world_of(mesh)
    start = np.array([0.3, -0.2, 0.1])
    edges = np.concatenate([mesh.faces[:, :2], mesh.faces[:, 1:]])
    part = np.random.default_rng(2).uniform(0, 1, (len(edges), 1))
    points = vertices[edges[:, 0]] * (1 - part) + vertices[edges[:, 1]] * part
    gap = vertices[all_faces[0]].mean(axis=0)
    aims = np.concatenate([vertices, points, vertices[edges].mean(axis=1)])
    aims = aims[np.linalg.norm(aims - gap, axis=1) > 0.2]
    hit, distance = hits.nearest(world, from_point(world, start, aims - start))
    assert len(aims) > 2000
    assert (hit >= 0).all()
    away = np.linalg.norm(aims - start, axis=1)
    assert abs(distance - away).max() < 1e-14
    # Through where the face is left out they pass.
    hit, _ = hits.nearest(world, from_point(world, start, (gap - start)[np.newaxis]))
    assert hit.tolist() == [-1]


def test_what_is_met_is_in_the_face_and_nothing_is_before_it() -> None:
    random = np.random.default_rng(8)
    triangles = random.normal(size=(60, 3, 3)) * np.repeat([0.1, 0.5, 2], 20)[:, None, None]
    mesh = Mesh(triangles.reshape(-1, 3), np.arange(180).reshape(60, 3), material="red")
    world = world_of(mesh)
    start, way = (
        np.array([0.1, 0.2, 5.0]),
        random.normal(size=(2000, 3)) * [0.4, 0.4, 0] - [0, 0, 1],
    )
    rays = from_point(world, start, way)
    hit, distance = hits.nearest(world, rays)
    assert 0.3 < (hit >= 0).mean() < 0.99
    # Where each plane is met, by a solver; whether that is inside, by coordinates in the triangle.
    unit = rays.direction.T
    best = np.full(len(way), np.inf)
    for corners in triangles:
        matrix = np.stack([corners[1] - corners[0], corners[2] - corners[0]], axis=1)
        systems = np.concatenate([np.repeat(matrix[None], 2000, 0), -unit[:, :, None]], axis=2)
        u, v, t = np.linalg.solve(systems, np.repeat((start - corners[0])[None, :, None], 2000, 0))[
            ..., 0
        ].T
        inside = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)
        best[inside] = np.minimum(best[inside], t[inside])
    assert ((hit >= 0) == np.isfinite(best)).all()
    assert abs(distance[hit >= 0] - best[hit >= 0]).max() < 1e-11


def test_ids_count_after_spheres_and_capsules() -> None:
    scene = shown(
        square(2, -1),
        ball(1, center=(1, 0, 0), radius=0.3),
        spheres=[Sphere((-1, 0, 0), 0.3, "red")],
        capsules=[Capsule((0, 0, 0), (0, 0.3, 0), 0.2, "red")],
    )
    found = tracer.trace(scene, 80, 60).id
    assert set(found[found >= 4].ravel()) < set(range(4, 24))
    assert {-1, 0, 1, 2, 3} < set(found.ravel().tolist())


def test_of_coplanar_faces_the_smaller_id_is_seen() -> None:
    one, other = square(1, 0, "red"), square(1, 0, "phong", other_way=True)
    for meshes in ((one, other), (other, one)):
        for tilt in (0.0, 0.3):
            turn = np.array([[1, tilt, 0], [-tilt, 1, 0.1], [0, 0.2, 1]])
            tilted = [Mesh(m.vertices @ turn, m.faces, material=m.material) for m in meshes]
            found = tracer.trace(shown(*tilted), 50, 40).id
            assert set(found.ravel().tolist()) == {-1, 0, 1}


def test_closed_and_open() -> None:
    inside = Camera((0.1, 0.05, 0), (0, 0, -1))
    closed = ball(2)
    assert set(tracer.trace(shown(closed, camera=inside), 9, 9).id.ravel()) == {-1}
    opened = Mesh(closed.vertices, closed.faces[:-1], closed.normals, None, "red", "flat")
    found = tracer.trace(shown(opened, camera=inside), 30, 20)
    assert set(found.id.ravel()) - {-1} <= set(range(79))
    assert (found.id >= 0).mean() > 0.9
    # Backs are turned to the camera: the normals point inwards.
    seen = found.id >= 0
    assert (found.normal[seen] @ [0, 0, -1.0]).min() < -0.5
    assert (opened.face_normals[found.id[seen]] == -found.normal[seen]).all()


@pytest.mark.parametrize("is_open", [False, True])
def test_no_face_shadows_itself_or_its_neighbour(is_open: bool) -> None:
    vertices, corners = sphere(8)
    corners = corners[1:] if is_open else corners
    smooth = Mesh(vertices, corners, material="red")
    scene = shown(smooth, lights=(Light((0.3, 0.4, 30)),))  # about where the camera is
    found = tracer.trace(scene, 80, 60)
    assert (found.id >= 0).sum() > 900
    dark = (found.image[..., 0] <= 0.11) & (found.normal @ [0, 0, 1.0] > 0.3)
    assert not dark.any()


def test_a_floor_of_faces_is_a_plane_of_one_shade() -> None:
    # 2 * 20^2 faces in one plane: light jumps nowhere, and the pass is the same everywhere.
    grid = np.linspace(-2, 2, 21)
    x, y = np.meshgrid(grid, grid)
    vertices = np.stack([x.ravel(), y.ravel(), 0.3 * x.ravel() + 0.1 * y.ravel()], axis=1)
    at = np.arange(441).reshape(21, 21)
    quads = np.stack([at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]], axis=-1).reshape(-1, 4)
    both = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    scene = shown(Mesh(vertices, both, material="red"), camera=Camera((0, 0, 2), (0, 0, 0)))
    corner = [[-2, -2], [2, -2], [2, 2], [-2, 2]]
    four = np.array([[x, y, 0.3 * x + 0.1 * y] for x, y in corner])
    whole = replace(scene, meshes=[Mesh(four, [[0, 1, 2], [0, 2, 3]], material="red")])
    one, other = tracer.trace(scene, 80, 60), tracer.trace(whole, 80, 60)
    assert len(np.unique(one.id)) > 300
    assert abs(one.image - other.image).max() < 1e-13
    assert (one.paths == other.paths).all()  # a hash knows the plane, not its faces


def plain(normals: list[list[float]], shading: str, light: Light, **more: object) -> Scene:
    corners = [[-1.0, -1, 0], [1, -1, 0], [0, 1, 0]]
    mesh = Mesh(corners, [[0, 1, 2]], normals, material="m", shading=shading)  # type: ignore[arg-type]
    material = Material((0.1, 0.1, 0.1), (0.5, 0.6, 0.7), (0.2, 0.3, 0.4), 40, **more)  # type: ignore[arg-type]
    return Scene(Camera((0, 0, 2), (0, 0, 0)), (light,), {"m": material}, meshes=[mesh])


NORMALS = [[-0.6, 0.0, 0.8], [0.6, 0, 0.8], [0, 1, 0.1]]
LAMP = Light((0.5, 3, 1), ambient=(0.9, 1, 1), diffuse=(1, 0.9, 1), attenuation=(1, 0.1, 0.01))


@pytest.mark.parametrize("highlight", ["blinn-phong", "phong"])
@pytest.mark.parametrize("shading", ["flat", "gouraud", "phong"])
def test_shading_by_its_formula(shading: str, highlight: str) -> None:
    """Each pixel's light, written down again for one triangle."""
    scene = plain(NORMALS, shading, LAMP, highlight=highlight)
    found = tracer.trace(scene, 41, 41)
    corners, normals = scene.meshes[0].corners[0], np.array(NORMALS)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    material, camera, position = scene.materials["m"], np.array([0.0, 0, 2]), np.array([0.5, 3, 1])

    def direct(point: np.ndarray, normal: np.ndarray, gouraud: bool) -> np.ndarray:
        to_light, to_camera = (a / np.linalg.norm(a) for a in (position - point, camera - point))
        cosine = normal @ to_light
        if gouraud and cosine < 0:
            return np.zeros(3)
        half = (to_light + to_camera) / np.linalg.norm(to_light + to_camera)
        mirrored = 2 * cosine * normal - to_light
        shine = (
            max(normal @ half, 0) ** 10
            if highlight == "blinn-phong"
            else max(mirrored @ to_camera, 0) ** 40
        )
        diffuse = np.array(material.diffuse) * LAMP.diffuse * max(cosine, 0)
        return diffuse + np.array(material.specular) * LAMP.specular * shine

    checked = 0
    for row, column in zip(*np.nonzero(found.id == 0), strict=True):
        way = np.array([(column - 20) / 20, (20 - row) / 20, -1])
        point = camera + 2 * way
        at = np.linalg.solve(np.vstack([corners[:, :2].T, [1, 1, 1]]), [*point[:2], 1])
        if shading == "gouraud":
            light = sum(
                w * direct(c, n, True) for w, c, n in zip(at, corners, normals, strict=True)
            )
        else:
            between = at @ normals if shading == "phong" else np.array([0, 0, 1.0])
            light = direct(point, between / np.linalg.norm(between), False)
        distance = np.linalg.norm(position - point)
        expected = np.array(material.ambient) * LAMP.ambient
        expected += light / (1 + 0.1 * distance + 0.01 * distance**2)
        assert found.image[row, column] == pytest.approx(expected, abs=1e-13)
        checked += 1
    assert checked > 200
    passed = found.normal[20, 20]
    assert (passed.tolist() == [0, 0, 1]) == (shading != "phong")


def test_normals_of_corners_turn_with_an_open_face() -> None:
    front = plain(NORMALS, "phong", LAMP)
    turned = front.meshes[0]
    flipped = Mesh(turned.vertices, [[0, 2, 1]], -np.array(NORMALS), None, "m", "phong")
    one, other = (tracer.trace(s, 40, 30) for s in (front, replace(front, meshes=[flipped])))
    assert abs(one.image - other.image).max() < 1e-15
    assert abs(one.normal - other.normal).max() < 1e-15


def test_a_light_behind_a_face_does_not_reach_it_however_its_normals_lean() -> None:
    scene = plain([[0, 1, 0.1]] * 3, "phong", Light((0, 9, -0.1)))
    seen = tracer.trace(scene, 20, 20)
    assert (seen.image[seen.id == 0] == 0).all()


def test_seen_through() -> None:
    clear = {"m": Material((0, 0, 0), opacity=0.25), **MATERIALS}
    vertices, corners = sphere(3)
    whole = Mesh(vertices, corners, material="m")
    pierced = Mesh(vertices, corners[1:], material="m")
    start = Camera((0.03, 0.02, 9), (0, 0, 0), fov=10)
    for mesh, layers in ((whole, 1), (pierced, 2)):
        found = tracer.trace(Scene(start, LIGHTS, clear, meshes=[mesh]), 31, 31)
        assert found.alpha[15, 15] == pytest.approx(1 - 0.75**layers)


def test_spheres_and_meshes_shadow_each_other() -> None:
    scene = shown(
        square(3, -1),
        lights=(Light((0, 9, 0)),),
        spheres=[Sphere((0, 0, 0), 0.5, "red")],
        camera=Camera((0, 3, 3), (0, -1, 0)),
    )
    found = tracer.trace(scene, 60, 60)
    floor = found.id >= 1
    with_roof = replace(scene, meshes=[*scene.meshes, square(2, 2)])
    roofed = tracer.trace(replace(with_roof, camera=Camera((0, 0, 6), (0, -1, 0))), 60, 60)
    assert (found.image[floor][:, 0] < 0.1001).mean() > 0.01  # of the sphere, on the floor
    ball_seen = roofed.id == 0
    assert ball_seen.sum() > 10
    assert roofed.image[ball_seen][:, 0].max() < 0.1001  # of the roof, on the sphere


def test_tokens() -> None:
    flat, smooth = ball(2), ball(2, "phong")
    tokens = path_tokens([flat, smooth, square(1, 0)], 7)
    assert len(np.unique(tokens[:80])) == 80
    assert np.unique(tokens[80:160]).tolist() == [9]
    assert len(np.unique(tokens[160:])) == 1
    assert tokens.dtype == np.uint32


def test_an_orthographic_camera_sees_the_same_wherever_it_stands() -> None:
    scenes = [case.scene for case in CASES if case.name.startswith("orthographic")]
    one, other = (tracer.trace(scene, 60, 45) for scene in scenes)
    assert (one.id == other.id).all()
    assert (one.id >= 0).mean() > 0.3


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_hard_cases(case: MeshCase) -> None:
    """float64 and long double say the same, but where a path goes another way."""
    width, height = (size // 2 for size in mesh_cases.SIZE)
    one = tracer.trace(case.scene, width, height)
    other = tracer.trace(case.scene, width, height, dtype=np.longdouble)
    assert np.isfinite(one.image).all()
    assert (one.id >= 0).sum() > 0
    flips = one.paths != other.paths
    assert flips.mean() < 0.01
    assert abs(one.image - other.image)[~flips].max() < 1e-6
    again = clrt.reference.trace(case.scene, width, height, pixels=[(3, 4)])
    assert (again.image == one.image[3, 4]).all()

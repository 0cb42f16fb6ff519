"""Meshes in figures: alone, beside particles, from the command line."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from mesh_cases import sphere
from msgspec.structs import replace

import clrt
from clrt import Mesh
from clrt.commands.cli import main
from clrt.errors import RequestError
from clrt.figure import compose, sources, surfaces
from clrt.figure.compose import Look
from clrt.film import color
from clrt.motion import cluster
from clrt.motion.surfaces import Surfaces, are_meshes
from clrt.renderer.pack.world import pack_world
from clrt.truth import tracer
from clrt.viewer import subject

VERTICES, FACES = sphere(4, 2.0, (5, 0, 0))
MESH = Mesh(VERTICES, FACES)
SIZE = 60, 40


def alone(mesh: object = MESH, how: str | None = None, **look: object) -> clrt.Scene:
    clim = look.get("clim")
    given = surfaces.read(mesh, how, None, look.get("cmap"), clim)  # type: ignore[arg-type]
    return compose.mesh_scene(Look(mesh=given, style="matte", size=SIZE, **look))  # type: ignore[arg-type]


def test_alone_it_fills_the_picture() -> None:
    scene = alone()
    seen = tracer.trace(scene, *SIZE).id >= 0
    rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    assert (rows[0], rows[-1]) in ((1, 38), (2, 37))
    assert abs(columns[0] + columns[-1] - 59) <= 1
    (mesh,) = scene.meshes
    assert mesh.material == "mesh"
    blue = color.linear(np.array([70, 130, 180], np.uint8))
    expected = 0.7 * blue.astype(float)
    assert np.array(scene.materials["mesh"].diffuse) == pytest.approx(expected, abs=1e-7)


def test_beside_particles_the_frame_holds_both() -> None:
    particles = clrt.Particles(np.array([[-5.0, 0, 0], [-5, 1, 0]]), radii=np.array([0.5, 0.5]))
    look = Look(mesh=surfaces.read(MESH, "red", 0.5), style="matte", size=SIZE, view="z")
    scene = compose.scene(particles, look)
    found = tracer.trace(scene, *SIZE)
    ids = found.id
    assert (ids >= 2).any()
    assert ((ids >= 0) & (ids < 2)).any()
    columns = np.flatnonzero((ids >= 0).any(axis=0))
    assert columns[0] <= 2
    assert columns[-1] >= 57
    assert scene.materials["mesh"].opacity == 0.5
    assert scene.materials["mesh"].diffuse == pytest.approx((0.7, 0, 0))
    assert scene.materials["matte"].opacity == 1
    gray = compose.scene(particles, replace(look, mesh=surfaces.read(MESH)))
    assert len(set(gray.materials["mesh"].diffuse)) == 1


def test_colors() -> None:
    height = {"vertices": VERTICES, "faces": FACES, "height": VERTICES[:, 2]}
    scene = alone(height, "height", cmap="gray", colorbar="z (m)")
    (mesh,) = scene.meshes
    assert mesh.colors is not None
    assert mesh.colors[VERTICES[:, 2].argmax()].tolist() == [1, 1, 1]
    assert scene.film.colorbar_clim == pytest.approx((VERTICES[:, 2].min(), VERTICES[:, 2].max()))
    assert scene.film.colorbar_cmap == "gray"
    assert scene.materials["mesh"].diffuse == (0.7, 0.7, 0.7)  # the colours are the mesh's
    blue = Mesh(VERTICES, FACES, colors=np.broadcast_to([0.0, 0, 1], VERTICES.shape))
    assert alone(blue, "red").meshes[0].colors is None  # else they would be multiplied: black
    with pytest.raises(
        RequestError, match=r"mesh_color: expected the name of numbers \('height'\)"
    ):
        alone(height, "depth")
    with pytest.raises(RequestError, match="colorbar: expected a mesh that is coloured by numbers"):
        alone(colorbar="z")
    with pytest.raises(RequestError, match="mesh_opacity: expected a number from 0 to 1, got 2"):
        surfaces.read(MESH, opacity=2)


def test_flat_meshes_are_seen_from_above() -> None:
    square = Mesh([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], [[0, 1, 2], [0, 2, 3]])
    back = np.array(alone(square).camera.basis()[2])
    assert back == pytest.approx([0, 0, 1])


@pytest.mark.filterwarnings("ignore:faces. 1 of 1 have no area")
def test_a_mesh_without_faces_is_refused_and_no_trouble_in_a_scene() -> None:
    with pytest.raises(RequestError, match="mesh: expected faces that have an area"):
        surfaces.read((VERTICES, [[1, 1, 2]]))
    none = replace(alone(), meshes=(Mesh(VERTICES, np.zeros((0, 3), int), material="mesh"),))
    assert not pack_world(none, "robust").meshes


def test_what_is_of_particles_is_refused() -> None:
    with pytest.raises(RequestError, match="select: expected particles, of a mesh alone there are"):
        alone(select="x > 0")
    with pytest.raises(RequestError, match="radii: expected particles"):
        clrt.plot(MESH, radii=3)
    with pytest.raises(RequestError, match="mesh: expected one mesh, got two"):
        clrt.plot(MESH, mesh=MESH)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    scene = clrt.Scene(clrt.Camera((0, 0, 9), (0, 0, 0)), materials={"m": clrt.Material()},
                       meshes=[Mesh(VERTICES, FACES, material="m")])  # fmt: skip
    clrt.save_scene(tmp_path / "a.toml", scene)
    return tmp_path / "a.0.ply"


def test_sources(file: Path) -> None:
    scene = sources.of_mesh(file, style="matte", size=SIZE, view=None, select=None, cell=False)
    assert scene.meshes[0] == MESH.made_of("mesh")
    look = sources.look(mesh=file, mesh_opacity=0.25, size=SIZE)
    assert look.mesh is not None
    assert look.mesh.opacity == 0.25
    with pytest.raises(RequestError, match="mesh: expected one beside its colour"):
        sources.look(mesh_color="red")


def test_check_says_what_a_mesh_is(file: Path) -> None:
    found = CliRunner().invoke(main, ["check", str(file)]).output
    assert found == f"{file}: 320 faces, 162 vertices, closed\n  has       no normals or colours\n"


def test_a_mesh_a_frame(tmp_path: Path) -> None:
    """All as the first one is seen; colours mean the same in all, or what they mean there."""
    for k in (2, 10):
        rows = [f"{x} {y} {z} {k * z}" for x, y, z in VERTICES * k]
        rows += [f"3 {a} {b} {c}" for a, b, c in FACES]
        head = f"ply\nformat ascii 1.0\nelement vertex {len(VERTICES)}\n"
        head += "".join(f"property float {name}\n" for name in ("x", "y", "z", "heat"))
        head += f"element face {len(FACES)}\nproperty list uchar int vertex_indices\nend_header\n"
        (tmp_path / f"a{k}.ply").write_text(head + "\n".join(rows) + "\n")
    pattern = str(tmp_path / "a*.ply")
    assert are_meshes([pattern])
    assert not are_meshes([pattern, "a.xyz"])
    look = {"mesh_color": "heat", "cmap": "gray", "size": SIZE, "label": "{frame}"}
    way = Surfaces([pattern], **look)
    one, other = way.scenes(way.check(way.frames))
    assert (one.camera, one.lights) == (other.camera, other.lights)
    assert [len(scene.meshes[0]) for scene in (one, other)] == [len(FACES)] * 2
    assert np.ptp(other.meshes[0].vertices) == pytest.approx(5 * np.ptp(one.meshes[0].vertices))
    assert [one.film.label, other.film.label] == ["0", "1"]
    (low, high), first = (
        colors_of(one),
        colors_of(Surfaces([pattern], **look, clim="first").scene(0)),
    )
    assert low[0] > first[0][0]
    assert high[0] < first[1][0]
    assert cluster.fingerprint(one) != cluster.fingerprint(other)
    assert cluster.fingerprint(way.said) == cluster.fingerprint(Surfaces([pattern], **look).said)


def colors_of(scene: clrt.Scene) -> list[np.ndarray]:
    """At the lowest and the highest vertex."""
    (mesh,) = scene.meshes
    assert mesh.colors is not None
    return [mesh.colors[k] for k in (VERTICES[:, 2].argmin(), VERTICES[:, 2].argmax())]


def test_in_view(file: Path) -> None:
    drawn = {"mesh_color": "red", "cell": False, "select": None}
    found = subject.of_mesh(file, drawn, ["--samples", "4"])
    assert found.words == (str(file), "--samples", "4", "--mesh-color", "red")
    scene = found.at(0)
    assert scene.meshes[0].vertices.shape == VERTICES.shape
    assert found.framed(scene, (90, 90), "z").basis()[2] == pytest.approx((0, 0, 1))
    with pytest.raises(RequestError, match="select: expected particles, of a mesh alone"):
        subject.of_mesh(file, {"select": "x > 0"})


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ["{}", "--select", "x > 0"],
            "--select: expected particles, of a mesh alone there are none",
        ),
        (["{}", "--frame", "1"], "--frame: expected a file of particles"),
        (["{}", "--mesh", "{}"], "--mesh: expected a file of particles"),
        (["{}", "--mesh-color", "none"], "--mesh-color: expected the name of numbers (none)"),
        (["{}", "--mesh-opacity", "0.5", "--style", "mirror"], "--mesh-opacity: expected 1 beside"),
        (["{}", "--mesh-opacity", "2"], "--mesh-opacity: expected a number from 0 to 1"),
        (["none.stl"], "none.stl: cannot be read"),
        (["{}", "--view-all"], "--view-all: expected files of particles"),
        (["four-spheres", "--mesh", "{}"], "--mesh: expected a file of particles"),
    ],
)
def test_commands_say_in_one_line_what_is_wrong(words: list[str], said: str, file: Path) -> None:
    given = [word.format(file) for word in words]
    command = "animate" if "--view-all" in words else "render"
    found = CliRunner().invoke(main, [command, *given, "-o", str(file.parent / "a.png")])
    text = str(found.exception) if isinstance(found.exception, RequestError) else found.output
    assert said in text
    assert len(text.strip().splitlines()) == 1

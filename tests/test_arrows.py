"""Vectors as arrows, and the box's edges as capsules."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import clrt
from clrt.commands.cli import main
from clrt.errors import ParticleWarning, RequestError
from clrt.figure import compose
from clrt.figure.compose import Look
from clrt.figure.representation import represented
from clrt.film import color
from clrt.motion.trajectory import Flow

pytestmark = pytest.mark.filterwarnings("ignore:vectors. 1 of 5 are no")

WAYS = np.array([[2.0, 0, 0], [0, 0, -1], [0, 0, 0], [np.nan, 0, 0], [0, 1e-3, 0]])
HERE = clrt.Particles(
    np.arange(5)[:, np.newaxis] * [0, 3.0, 0],
    radii=[0.5, 0.4, 0.5, 0.5, 0.5],
    values={f"v{axis}": WAYS[:, i] for i, axis in enumerate("xyz")},
    cell=np.array([[9.0, 0, 0], [3, 9, 0], [0, 0, 12]]),
    origin=(1.0, 2, 3),
)


def arrows(**given: Any) -> clrt.Capsules:
    found = represented(HERE, vectors="v", **given).capsules
    assert found is not None
    return found


def test_arrows_end_where_vectors_do() -> None:
    """Their length is counted from the surface; the last ball of a head ends there."""
    found = arrows(vector_scale=1.5, replicate=(2, 1, 1))
    many = len(found) // 2
    assert many % 3 == 0  # two have no arrow
    for k, way in ((0, WAYS[0]), (1, WAYS[1]), (2, WAYS[4])):
        row = (0, 1, 4)[k]
        unit = way / np.linalg.norm(way)
        mine = slice(k, many, 3)
        assert (found.start[k] == HERE.positions[row]).all()
        along = (found.end[mine] - HERE.positions[row]) @ unit + found.radius[mine]
        assert HERE.radii is not None
        assert along.max() == pytest.approx(HERE.radii[row] + 1.5 * np.linalg.norm(way))
        assert found.radius[mine].max() <= found.radius[3] + 1e-12
        assert (found.start[many:][mine] - found.start[mine] == [9.0, 0, 0]).all()
    assert found.radius[0] == pytest.approx(0.25 * 0.5)
    assert found.radius[2] < 1e-3


def test_arrows_are_as_long_as_it_suits() -> None:
    reach = arrows().end - arrows().start
    lengths = np.linalg.norm(WAYS[[0, 1, 4]], axis=1)
    scale = 2 * 0.5 / lengths.mean()
    assert np.linalg.norm(reach[0]) < 0.5 + scale * lengths[0]
    made = represented(HERE, vectors="v")
    assert made.parts[1].center[0] == pytest.approx([0.5 + 2 * scale, 0, 0])
    scene = compose.scene(HERE, Look(vectors="v", view="-y", margin=0, size=(100, 100)))
    assert scene.camera.height == pytest.approx(1 + 2 * scale, rel=0.02)


def test_colours_of_arrows() -> None:
    own = arrows(color="index").color
    assert own is not None
    assert len(np.unique(own, axis=0)) == 3
    red = arrows(vector_color="red").color
    assert red is not None
    assert (red == color.linear(np.array([255, 0, 0], np.uint8))).all()
    shade: Any = np.array([1.0, 0, 0])
    given = compose.scene(HERE, Look(vectors="v", vector_color=shade))
    assert np.array_equal(given.capsules.color, red)  # type: ignore[attr-defined]


def test_frames_have_arrows_of_one_scale(tmp_path: Path) -> None:
    head = "2\nProperties=pos:R:3:radius:R:1:v:R:3\n"
    frames = [f"{head}0 0 0 {r} {v} 0 0\n5 0 0 {r} {v} 0 0\n" for v, r in ((1, 1), (3, 0.5))]
    (tmp_path / "a.xyz").write_text("".join(frames))
    flow = Flow(tmp_path / "a.xyz", Look(vectors="v", size=(64, 48)))
    first, second = flow.scene(0).capsules, flow.scene(1).capsules
    assert first[0].radius == second[0].radius == 0.25
    assert max(one.end[0] for one in second) - max(one.end[0] for one in first) == pytest.approx(
        3.5
    )


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"vectors": "w"}, "vectors: expected one of 'v', 'speed', got 'w'"),
        ({"vectors": ""}, "vectors: expected the name of three columns, as v of vx, vy and vz"),
        ({"vectors": "v", "vector_scale": -1}, "vector_scale: expected a finite number above 0"),
        ({"vectors": "v", "vector_color": "?"}, "vector_color: expected a colour's name"),
        ({"cell": "soft"}, "cell: expected true, false or 'solid', got 'soft'"),
    ],
)
def test_faults(given: dict[str, Any], message: str) -> None:
    with pytest.raises(RequestError, match=message):
        compose.scene(HERE, Look(**given))


def test_arrays_of_vectors() -> None:
    bare = HERE.replaced(values={})
    with pytest.raises(RequestError, match="vectors: expected columns as vx, vy, vz, got 'v'"):
        compose.scene(bare, Look(vectors="v"))
    with pytest.raises(RequestError, match=r"vectors: expected numbers of shape \(5, 3\)"):
        clrt.plot(bare, vectors=WAYS[1:])


def test_what_is_not_drawn_is_said() -> None:
    with pytest.warns(ParticleWarning, match="vectors: 1 of 5 are no finite numbers"):
        arrows()
    with pytest.warns(ParticleWarning, match="bonds: none are found"):
        represented(HERE, bonds=1e-3, bond_radius=0.1)
    looks: dict[str, Any] = {"bond_radius": 0.1, "bond_color": "red", "vector_scale": 2}
    for key, value in looks.items():
        said = f"{key}: expected {key[: key.index('_')]}s, there are none to draw"
        with pytest.warns(ParticleWarning, match=said):
            represented(HERE, **{key: value})


def test_a_solid_box() -> None:
    made = represented(HERE, cell="solid", replicate=(1, 1, 2))
    edges = made.capsules
    assert edges is not None
    assert len(edges) == 12
    ways = edges.end - edges.start
    for edge in ([9.0, 0, 0], [3, 9, 0], [0, 0, 24]):
        assert sum((way == edge).all() or (way == np.negative(edge)).all() for way in ways) == 4
    assert (np.concatenate([edges.start, edges.end]).min(axis=0) == HERE.origin).all()
    scene = compose.scene(HERE, Look(cell="solid"))
    lines = compose.scene(HERE, Look(cell=True))
    assert (len(scene.film.cells), len(scene.capsules)) == (0, 12)
    assert (len(lines.film.cells), len(lines.capsules)) == (1, 0)
    assert scene.camera == lines.camera


@pytest.mark.parametrize("words", [("--cell", "solid"), ("--cell=solid",), ("--cell",), ()])
def test_words_of_the_box(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file's name after --cell is no word of it."""
    monkeypatch.chdir(tmp_path)
    Path("a.xyz").write_text('1\nLattice="9 0 0 0 9 0 0 0 9"\nC 1 1 1\n')
    given: list[Any] = []
    monkeypatch.setattr("clrt.figure.sources.look", lambda **look: given.append(look))
    CliRunner().invoke(main, ["render", *words, "a.xyz"])
    expected = {("--cell",): True, (): False}
    assert given[0]["cell"] == expected.get(words, "solid")

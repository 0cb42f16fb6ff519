"""Bonds as capsules: whole ones and halves, their ends, radii and colours."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from msgspec.structs import replace

import clrt
from clrt import reference
from clrt.commands.cli import main
from clrt.errors import RequestError
from clrt.figure import compose, sources
from clrt.figure.compose import Look
from clrt.figure.representation import represented
from clrt.figure.resolver import resolved
from clrt.files.scenefile import load_scene
from clrt.film import color, metrics
from clrt.motion.trajectory import Flow

ROOT = Path(__file__).parents[1]
CHAIN = clrt.Particles(
    np.arange(4)[:, np.newaxis] * [1.5, 0, 0] + [0.1, 5, 5],
    elements=[6, 6, 8, 6],
    bonds=[(0, 1), (1, 2)],
    cell=np.diag([6.0, 10, 10]),
    unit="angstrom",
)
RING = clrt.Particles(CHAIN.positions, cell=CHAIN.cell, radii=np.full(4, 0.4), bonds=[(3, 0)])


def ends(made: Any) -> list[list[float]]:
    """x of both ends of each capsule."""
    found = np.stack([made.capsules.start[:, 0], made.capsules.end[:, 0]], axis=1)
    return found.round(9).tolist()


def test_one_capsule_where_ends_have_one_colour_else_two() -> None:
    made = represented(CHAIN, bonds="file")
    assert ends(made) == [[0.1, 1.6], [1.6, 2.35], [3.1, 2.35]]
    assert len(made.parts) == 1
    assert made.capsules is not None
    assert made.capsules.color is not None
    carbon, oxygen = color.linear(np.array([[0x90] * 3, [0xFF, 0x0D, 0x0D]], np.uint8))
    assert (made.capsules.color == [carbon, carbon, oxygen]).all()
    assert made.capsules.names == ("soft",)
    one = represented(CHAIN, bonds="file", bond_color="red").capsules
    assert one is not None
    assert one.color is not None
    assert len(one) == 2
    assert (one.color == color.linear(np.array([255, 0, 0], np.uint8))).all()
    white = represented(CHAIN, bonds="file", color="material", material="gold").capsules
    assert white is not None
    assert white.color is None


def test_halves_across_the_box() -> None:
    made = represented(RING, bonds="file")
    assert ends(made) == [[4.6, 5.35], [0.1, -0.65]]
    assert made.parts[1].center[:, 0] == pytest.approx([5.35, -0.65])
    scene = compose.scene(RING, Look(bonds="file", view="z", size=(600, 300), margin=0))
    # Twice as wide as high: it holds the halves and their round ends.
    assert scene.camera.height is not None
    assert scene.camera.height * 2 == pytest.approx(6 + 2 * 0.12, rel=1e-6)
    many = represented(RING, bonds="file", replicate=(2, 1, 1))
    assert ends(many) == [[4.6, 5.35], [0.1, -0.65], [10.6, 11.35], [6.1, 5.35]]
    beside = RING.replaced(positions=np.add(RING.positions, [1.5, 0, 0]))
    assert ends(represented(beside, bonds="file", wrap=True)) == [[0.1, 1.6]]


def test_bonds_go_with_their_particles() -> None:
    assert ends(represented(CHAIN, bonds="file", hide="x < 1")) == [[1.6, 2.35], [3.1, 2.35]]
    mask = np.array([1, 1, 0, 1], bool)
    assert ends(represented(CHAIN, bonds="file", mask=mask)) == [[0.1, 1.6]]
    given = np.array([[2, 3], [1, 3], [0, 1]])
    assert ends(represented(CHAIN, bonds=given, mask=mask)) == [[1.6, 4.6], [0.1, 1.6]]
    only = represented(CHAIN, bonds="auto", select="element == 'C'", bond_color="red")
    assert ends(only) == [[0.1, 1.6], [4.6, 5.35], [0.1, -0.65]]


@pytest.mark.parametrize(
    ("particles", "given", "expected"),
    [
        (CHAIN, {}, None),
        (CHAIN, {"balls": True}, 2),
        (CHAIN, {"balls": True, "bonds": "none"}, None),
        (CHAIN, {"balls": True, "bonds": False}, None),
        (CHAIN, {"bonds": True}, 2),
        (CHAIN, {"bonds": "auto"}, 5),
        (CHAIN, {"bonds": 1.6}, 5),
        (CHAIN, {"bonds": 1.4}, None),
        (CHAIN, {"bonds": np.array([[0, 3], [0, 1]])}, 3),
        (CHAIN.replaced(bonds=None), {"bonds": True}, 5),
        (CHAIN.replaced(bonds=None), {"balls": True}, 5),
        (CHAIN.replaced(bonds=None, elements=None), {"balls": True}, None),
    ],
)
def test_which(particles: clrt.Particles, given: dict[str, Any], expected: int | None) -> None:
    """Of one colour: one each, and two across the box."""
    made = represented(particles, radius=0.3, bond_color="red", **given).capsules
    assert (None if made is None else len(made)) == expected


def test_radii() -> None:
    def thick(particles: clrt.Particles, **given: Any) -> float:
        made = represented(particles, **{"bonds": "file", **given}).capsules
        assert made is not None
        return float(made.radius[0])

    assert thick(CHAIN) == pytest.approx(0.15)
    assert thick(CHAIN.replaced(unit="nm")) == pytest.approx(0.015)
    assert thick(CHAIN.replaced(unit=None)) == pytest.approx(0.15)
    assert thick(RING) == pytest.approx(0.12)
    assert thick(RING, scale=0.5) == pytest.approx(0.06)
    assert thick(RING, bond_radius=0.7) == 0.7
    balls: dict[str, Any] = {"balls": True}
    assert represented(CHAIN, **balls).spheres.radius[:3] == pytest.approx([0.425, 0.425, 0.38])
    assert represented(RING, **balls).spheres.radius == pytest.approx(np.full(4, 0.2))
    assert represented(RING, **balls, radius=0.3).spheres.radius == pytest.approx(np.full(4, 0.3))
    both = CHAIN.replaced(radii=np.full(4, 9.0))
    assert represented(both, **balls).spheres.radius[0] == pytest.approx(0.425)
    some = represented(CHAIN, **balls, radius={"O": 1.0}).spheres.radius
    assert some == pytest.approx([0.425, 0.425, 1, 0.425])


@pytest.mark.parametrize(
    ("particles", "given", "message"),
    [
        (
            CHAIN.replaced(bonds=None),
            {"bonds": "file"},
            "bonds: expected particles with bonds; auto",
        ),
        (RING, {"bonds": "auto"}, "bonds: expected particles whose elements are known"),
        (
            CHAIN,
            {"bonds": "all"},
            "bonds: expected 'file', 'auto', 'none' or a distance above 0, got",
        ),
        (
            CHAIN,
            {"bonds": 0},
            "bonds: expected 'file', 'auto', 'none' or a distance above 0, got 0",
        ),
        (CHAIN, {"bonds": np.array([[0, 4]])}, r"bonds\[0\]: expected indices of particles from 0"),
        (CHAIN, {"bond_radius": 0.0}, "bond_radius: expected a finite number above 0, got 0"),
        (CHAIN, {"bond_color": "rde"}, "bond_color: expected a colour.* got 'rde'"),
    ],
)
def test_faults(particles: clrt.Particles, given: dict[str, Any], message: str) -> None:
    with pytest.raises(RequestError, match=message):
        compose.scene(particles, Look(**given))


def test_a_saved_scene_finds_the_same_bonds(tmp_path: Path) -> None:
    """The words of the command line go into the scene file, and none of the bonds."""
    path = tmp_path / "a.xyz"
    path.write_text('4\nLattice="6 0 0 0 9 0 0 0 9"\nC 0 0 0\nC 1.5 0 0\nO 3 0 0\nC 4.5 0 0\n')
    look = sources.look(style="ball-and-stick", bonds="auto", bond_radius=0.2, bond_color="#00f")
    drawn = sources.of_file(path, 0, look)
    assert len(drawn.capsules) == 5
    kept = sources.in_file(drawn, path, 0, look)
    assert len(kept.capsules) == 0
    clrt.save_scene(tmp_path / "a.toml", kept)
    assert resolved(load_scene(tmp_path / "a.toml")) == drawn
    clrt.save_scene(tmp_path / "c.toml", drawn)  # as one of Python's
    found = resolved(load_scene(tmp_path / "c.toml"))
    assert found.spheres == drawn.spheres
    assert found.capsules == drawn.capsules
    (tmp_path / "b.toml").write_text(
        (tmp_path / "a.toml").read_text()
        + "[[capsules]]\nstart = [0, 0, 1]\nend = [0, 1, 1]\nradius = 1\n"
        + 'material = "ball-and-stick"'
    )
    found = resolved(load_scene(tmp_path / "b.toml"))
    assert len(found.capsules) == 6
    assert found.capsules[0].radius == 1


def test_frames_have_their_own_bonds_of_one_radius(tmp_path: Path) -> None:
    path = tmp_path / "a.xyz"
    head = "3\nProperties=pos:R:3:radius:R:1\n"
    path.write_text(f"{head}0 0 0 .4\n1 0 0 .3\n9 0 0 .4\n{head}0 0 0 .1\n3 0 0 .4\n4 0 0 .4\n")
    flow = Flow(path, Look(bonds=1.5, size=(64, 48)))
    first, second = flow.scene(0).capsules, flow.scene(1).capsules
    assert [one.start for one in (*first, *second)] == [(0, 0, 0), (3, 0, 0)]
    assert [one.radius for one in (*first, *second)] == pytest.approx([0.09, 0.09])


def test_a_part_of_a_protein_beside_the_truth() -> None:
    """Whatever is off is where a path meets something else."""
    particles = clrt.read(ROOT / "scenes" / "data" / "1tii.pdb.gz")
    sticks = Look(style="matte", bonds="file", radius=0.3, bond_radius=0.3, select="chain == 'C'")
    scene = replace(compose.scene(particles, replace(sticks, size=(64, 36))), film=clrt.Film())
    scene = replace(scene, samples=1)
    truth, renderer = reference.trace(scene, 64, 36), clrt.Renderer()
    off = metrics.pixel_error(renderer.render(scene, 64, 36), truth.image) > 1 / 1020
    assert not (off & (renderer.paths(scene, 64, 36) == truth.paths)).any()


def test_the_command_the_call_and_the_saved_scene_draw_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.xyz").write_text('3\nLattice="3 0 0 0 9 0 0 0 9"\nC 0 0 0\nC 1.5 0 0\nO 0 1.2 0\n')
    words = ["--width", "64", "--height", "48", "--samples", "4", "-q"]
    drawn = ["--style", "ball-and-stick", "--cell", "solid", "--bond-color", "#444"]
    for line in (
        ["a.xyz", "-o", "a.png", "--save-scene", "a.toml", *drawn],
        ["a.toml", "-o", "b.png"],
    ):
        done = CliRunner().invoke(main, ["render", *line, *words], catch_exceptions=False)
        assert done.exit_code == 0, done.stderr
    picture = clrt.plot(
        "a.xyz", style="ball-and-stick", cell="solid", bond_color="#444", samples=4, size=(64, 48)
    )
    assert len(picture.scene.capsules) == 12 + 1 + 2 + 1
    assert Path("a.png").read_bytes() == Path("b.png").read_bytes() == picture._repr_png_()

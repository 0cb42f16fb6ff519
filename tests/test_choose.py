"""Which particles there are, where their images are, and what a kind of them is given."""

import time
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from msgspec.structs import replace

import clrt
from clrt.commands.cli import main
from clrt.errors import ParticleWarning, RequestError
from clrt.figure.compose import Look, scene
from clrt.figure.decoration import decorated
from clrt.figure.representation import represented
from clrt.film import color
from clrt.film.decor import panel
from clrt.particles import choose, elements, palette
from clrt.scene.film import Film

RANDOM = np.random.default_rng(3)
RENDERER = clrt.Renderer()
N = 30
AT = RANDOM.uniform(-4, 9, (N, 3))
CELL = np.array([[5.0, 0, 0], [1, 4, 0], [0, 1, 6]])
CHAINS = np.array(["B", "A", "C"])[np.arange(N) % 3]
ALL = clrt.Particles(
    AT,
    radii=0.3,
    elements=np.array([1, 8, 17])[np.arange(N) % 3],
    types=np.arange(N) % 2 + 1,
    values={"heat": AT[:, 0] ** 2},
    cell=CELL,
    origin=(1, 2, 3),
    texts={"chain": CHAINS, "name": np.array(["CA", "CB", "OW", "N", "X"])[np.arange(N) % 5]},
)


def centres(**how: Any) -> np.ndarray:
    return represented(ALL, **how).spheres.center


def test_select_and_hide() -> None:
    assert (centres(select="x > 0") == AT[AT[:, 0] > 0]).all()
    assert (centres(hide="chain in ('A', 'C')") == AT[CHAINS == "B"]).all()
    both = represented(ALL, select="index >= 10", hide="element == 'H'")
    assert both.rows is not None
    assert both.rows.tolist() == [k for k in range(10, N) if k % 3]
    assert (both.spheres.center == AT[both.rows]).all()


def test_what_is_selected_has_the_colours_of_its_own_range() -> None:
    found = represented(ALL, select="heat < 9", color="heat")
    cold = ALL.values["heat"][ALL.values["heat"] < 9]
    assert found.meaning.clim == (cold.min(), cold.max())
    # But the expression is one over all.
    part = represented(ALL, select="index > 20", color="x - min(x)").meaning.clim
    assert part is not None
    assert part[0] == (AT[21:, 0] - AT[:, 0].min()).min()


def test_nothing_is_left() -> None:
    with pytest.raises(RequestError) as error:
        represented(ALL, select="chain == 'D' and x > 0")
    assert str(error.value).startswith("select: expected to keep at least one of 30 particles, got")
    assert "chain is one of 'A', 'B', 'C'; x is from " in str(error.value)
    with pytest.raises(RequestError, match=r"hide: expected to keep at least one"):
        represented(ALL, hide="True")
    for text, said in (("x", "a condition"), ("chain", "a condition"), ("x >", "invalid syntax")):
        with pytest.raises(RequestError, match=f"select: .*{said}"):
            represented(ALL, select=text)


def test_wrapped_particles_are_in_the_box() -> None:
    found = choose.wrapped(ALL).positions
    part = (found - ALL.origin) @ np.linalg.inv(CELL)
    assert part.min() >= -1e-12
    assert part.max() <= 1 + 1e-12
    away = (AT - found) @ np.linalg.inv(CELL)
    assert away == pytest.approx(np.rint(away), abs=1e-12)
    inside = np.rint(away) == 0
    kept = inside.all(axis=1)
    assert kept.any()
    assert (found[kept] == AT[kept]).all()
    with pytest.raises(RequestError, match="wrap: expected particles in a box, got none"):
        choose.wrapped(clrt.Particles(AT))


def test_images() -> None:
    found = represented(ALL, select="x > 0", replicate=(2, 1, 3), color="chain", cell=True)
    kept = AT[AT[:, 0] > 0]
    expected = [kept + i * CELL[0] + k * CELL[2] for i in range(2) for k in range(3)]
    assert found.spheres.center == pytest.approx(np.concatenate(expected))
    assert found.cell is not None
    assert np.array(found.cell.edges) == pytest.approx(CELL * [[2], [1], [3]])
    assert found.rows is not None
    assert (AT[found.rows] == np.tile(kept, (6, 1))).all()
    own = found.spheres.color
    assert own is not None
    assert (own == np.tile(own[: len(kept)], (6, 1))).all()
    with pytest.raises(RequestError, match="replicate: expected particles in a box, got none"):
        represented(clrt.Particles(AT, radii=1), replicate=(2, 1, 1))


def test_radii_of_kinds() -> None:
    radii = represented(ALL, radius={"1": 0.5, "Cl": 2.0, "CA": 1.0}).spheres.radius
    for k in range(N):
        own = 0.5 if k % 2 == 0 else 0.3
        own = 2.0 if k % 3 == 2 else own
        assert radii[k] == (1.0 if k % 5 == 0 else own)
    bare = clrt.Particles(AT, elements=ALL.elements)
    found = represented(bare, radius={"H": 0.5}).spheres.radius
    expected = elements.VAN_DER_WAALS[bare.elements]
    assert (found == np.where(bare.elements == 1, 0.5, expected)).all()


def test_a_kind_that_is_not_there_is_warned_of() -> None:
    with pytest.warns(ParticleWarning, match=r"radius: no particle is called 'CL', .*mean 'Cl'"):
        represented(ALL, radius={"CL": 2.0})
    with pytest.warns(ParticleWarning, match="colors: no particle is called 'Q'"):
        represented(ALL, colors={"Q": "red", "H": "blue"})


def legend_of(**how: Any) -> dict[str, list[int]]:
    film = decorated(Film(colorbar=" "), [represented(ALL, **how)])
    srgb = {one.name: color.to_srgb(np.array(one.color)) for one in film.legend}
    return {name: np.rint(255 * one).astype(int).tolist() for name, one in srgb.items()}


RED, TEAL = [255, 0, 0], [0, 128, 128]


def test_colours_of_kinds() -> None:
    """And the legend says them."""
    first = [one.tolist() for one in palette.OKABE_ITO[:3]]
    assert legend_of(color="chain") == dict(zip("ABC", first, strict=True))
    changed = legend_of(color="chain", colors={"B": "red"})
    assert changed == {"A": first[0], "B": RED, "C": first[2]}
    own = represented(ALL, color="chain", colors={"B": "red"}).spheres.color
    assert own is not None
    assert (own[0::3] == color.linear(np.array(RED, np.uint8))).all()
    assert (own[1::3] == color.linear(palette.OKABE_ITO[0])).all()
    assert legend_of(colors={"1": "teal"})["1"] == TEAL
    assert list(legend_of(colors={"Cl": "teal", "H": "red"})) == ["H", "O", "Cl"]
    assert legend_of(colors={"OW": "red"})["OW"] == RED
    assert legend_of(color="x > 0") == {"False": first[0], "True": first[1]}


def test_a_legend_of_text_is_there_by_itself() -> None:
    def film(**how: Any) -> Film:
        return scene(ALL, Look(size=(320, 180), **how)).film

    assert film(color="chain").colorbar == " "  # its title is a label that is given
    assert film(color="chain").colorbar_room
    assert not film(color="chain", colorbar="").legend
    assert not film(color="heat").colorbar


def test_many_kinds_have_different_colours() -> None:
    assert len({tuple(one) for one in palette.of_kinds(100).tolist()}) == 100
    assert (palette.of_kinds(8) == palette.OKABE_ITO).all()
    assert len(palette.of_kinds(0)) == 0


def test_names_of_colours_one_by_one() -> None:
    names = np.array(["red", "teal"])[np.arange(N) % 2]
    small: dict[str, Any] = {"size": (16, 9), "samples": 1}
    own = clrt.plot(ALL, colors=names.tolist(), **small).scene.spheres.color  # type: ignore[attr-defined]
    assert (own == color.linear(np.array([RED, TEAL], np.uint8)[np.arange(N) % 2])).all()


def test_flat_data_are_seen_from_above() -> None:
    flat = clrt.Particles(AT * [1, 1, 0], radii=0.3)
    look = Look(size=(64, 36))
    assert scene(flat, look).camera.basis()[2] == (0, 0, 1)
    right, up, back = scene(ALL, look).camera.basis()
    assert back == pytest.approx((3**0.5 / 4, -0.75, 0.5))  # azimuth -60, height 30 degrees
    assert right[0] > 0.8
    assert up[2] > 0.8


@pytest.mark.parametrize("projection", ["orthographic", "perspective"])
def test_nothing_is_drawn_under_the_bar(projection: Any) -> None:
    size = (160, 90)
    how: dict[str, Any] = {"color": "heat", "radius": 3.0, "style": "matte", "samples": 1}
    look = Look(colorbar="heat", zoom=3, size=size, projection=projection, **how)
    shown = scene(ALL, look)
    under = slice(size[0] - panel.room(shown.film, size)[0], None)

    def alpha(room: bool) -> Any:
        film = replace(shown.film, colorbar_room=room)
        return RENDERER.render(replace(shown, film=film), *size, alpha=True)[:, under, 3]

    assert alpha(False)[:4].any()  # above the bar
    assert not alpha(True)[:4].any()


def test_a_million_particles_are_selected_from_soon() -> None:
    """50 ms on a quiet machine (docs/particles.md); here ten times that, for others are at work."""
    n = 10**6
    x = RANDOM.normal(size=(n, 3))
    chains = np.array(["A", "B", "C", "D"])[RANDOM.integers(0, 4, n)]
    particles = clrt.Particles(x, texts={"chain": chains}, types=RANDOM.integers(1, 4, n))
    columns = particles.columns
    started = time.perf_counter()
    kept = choose.selected(columns, n, "x > 0 and type == 1 and chain != 'B'", "z > 1")
    assert time.perf_counter() - started < 0.5
    expected = (x[:, 0] > 0) & (particles.types == 1) & (chains != "B") & ~(x[:, 2] > 1)
    assert np.array_equal(kept, expected)  # type: ignore[arg-type]


def run(*words: str) -> Any:
    return CliRunner().invoke(main, [*words], catch_exceptions=False)


def test_check_says_what_a_file_holds(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    np.savez(
        "a.npz", positions=AT, types=np.arange(N) % 2, v_x=AT[:, 0], v_y=AT[:, 1], v_z=AT[:, 2]
    )
    said = run("check", "a.npz").stdout
    assert said.startswith("a.npz: 30 particles, 1 frame\n")
    assert f"x               {AT[:, 0].min():.6g} to {AT[:, 0].max():.6g}" in said
    for name in ("speed", "v_x", "type", "box       none"):
        assert f"  {name}" in said


def test_formats_and_styles_are_listed() -> None:
    said = run("formats").stdout
    for suffix in (".npz", ".dump", ".pdb", ".toml", ".mp4"):
        assert suffix in said
    assert [line.split()[0] for line in run("styles").stdout.splitlines()] == [
        "soft", "matte", "outline", "mirror", "ball-and-stick",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--select", "xx > 0"], "a.npz: --select: no column is called 'xx', at character 1"),
        (["--radius", "A=b"], "expected a number, or numbers of types, elements or names"),
        (["--radius", "0=-1"], "--radius[0]: expected a finite number above 0, got -1.0"),
        (["--radius", "-1"], "--radius: expected a finite number above 0, got -1.0"),
        (["--colors", "0=redd"], "--colors: expected a colour's name, #rgb, #rrggbb or three numb"),
        (["--clim", "first"], ""),
        (["--clim=all"], ""),
        (["--clim", "1", "x"], "expected LO HI, first or all, got '1 x'"),
        (["--view", "cornr"], "; did you mean 'corner'?"),
        (["--view", "0 0 0"], "--view: expected one of corner, iso,"),
        (["--up", "z", "--view", "z"], "a.npz: --up: expected a direction not along the view"),
        (["--zoom", "0"], "--zoom: expected a finite number above 0, got 0"),
        (["--center", "1,2"], "--center: expected three numbers, as 1,1,0, got '1,2'"),
        (["--replicate", "2", "2", "0"], "--replicate: expected three whole numbers from 1"),
        (["--replicate", "1000", "1000", "1000"], "images in all"),
        (["--view", "0,0,0"], "three numbers, not all 0, as 1,1,0"),
        (["--replicate", "2", "2", "2"], "a.npz: --replicate: expected particles in a box"),
        (["--style", "sofft"], "--style: expected one of soft, matte, outline, mirror, ball-and-"),
        (["--projection", "persp"], "--projection: expected orthographic or perspective, got"),
    ],
    ids=str,
)  # fmt: skip
def test_errors_are_of_the_option(
    words: list[str], said: str, tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    np.savez("a.npz", positions=AT, types=np.arange(N) % 2, radii=0.5)
    result = run(
        "render", "a.npz", "--width", "16", "--height", "9", "--samples", "1", *words, "-q"
    )
    assert result.exit_code == (2 if said else 0)
    assert said in result.stderr


def test_python_s_words_are_python_s() -> None:
    with pytest.raises(RequestError, match=r"^radii\[H\]: expected a finite number above 0"):
        clrt.plot(ALL, radii={"H": -1})
    with pytest.raises(RequestError, match=r"^select: no column is called"):
        clrt.plot(ALL, select="xx > 0")

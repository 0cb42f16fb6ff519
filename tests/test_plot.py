"""clrt.plot, and that `clrt render PARTICLES` draws the same."""

import io
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from msgspec.structs import replace
from PIL import Image

import clrt
from clrt.commands.cli import main
from clrt.figure.coloring import STEEL_BLUE
from clrt.figure.framing import PROJECTIONS
from clrt.film import color
from clrt.film.decor import panel
from clrt.particles import palette

RANDOM = np.random.default_rng(5)
N = 45  # fewer than have a tree: its programs take three times as long to compile
AT = RANDOM.uniform(-3, 3, (N, 3))
SPEED = RANDOM.normal(size=N)
RENDERER = clrt.Renderer()
SMALL: dict[str, Any] = {"size": (64, 48), "samples": 4, "renderer": RENDERER}
WORDS = ["--width", "64", "--height", "48", "--samples", "4", "-q"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    np.savez(
        "a.npz",
        positions=AT,
        radii=RANDOM.uniform(0.2, 0.6, N),
        types=np.arange(N) % 3,
        speed=SPEED,
        cell=np.diag([6.0, 6.0, 6.0]),
        origin=[-3.0, -3.0, -3.0],
    )
    return tmp_path


def command(*words: str) -> Result:
    return CliRunner().invoke(main, ["render", *words], catch_exceptions=False)


SAME: list[tuple[list[str], dict[str, Any]]] = [
    ([], {}),
    (["--color", "speed", "--cmap", "plasma", "--clim", "-1", "0.5"],
     {"color": "speed", "cmap": "plasma", "clim": (-1, 0.5)}),
    (["--scale", "0.3", "--view", "-y"], {"scale": 0.3, "view": "-y"}),
    (["--projection", "perspective", "--margin", "0.2", "--color", "material", "--radius", "0.5"],
     {"projection": "perspective", "margin": 0.2, "color": "material", "radii": 0.5}),
    (["--style", "soft"], {"style": "soft"}),
    (["--style", "outline"], {"style": "outline"}),
    (["--style", "mirror", "--view", "z"], {"style": "mirror", "view": (0, 0, 2)}),
    (["--style", "matte", "--view", "1,-2, 0.5", "--up", "x", "--zoom", "2"],
     {"style": "matte", "view": (1, -2, 0.5), "up": (1, 0, 0), "zoom": 2}),
    (["--center", "1 2 3", "--projection", "perspective", "--zoom", "3"],
     {"center": (1, 2, 3), "projection": "perspective", "zoom": 3}),
    (["--select", "x > 0", "--hide", "type == 1", "--radius", "0=0.2,2=0.5", "--view", "corner"],
     {"select": "x > 0", "hide": "type == 1", "radii": {0: 0.2, 2: 0.5}}),
    (["--color", "x**2 + y**2", "--wrap", "--replicate", "2", "1", "1", "--colorbar", "r"],
     {"color": "x**2 + y**2", "wrap": True, "replicate": (2, 1, 1), "colorbar": "r"}),
    (["--colors", "0=red,1=rgb(1, 2, 3)", "--colorbar", "kinds"],
     {"colors": {0: "red", "1": "rgb(1, 2, 3)"}, "colorbar": "kinds"}),
    (["--color", "speed > 0", "--colors", "True=red", "--zoom", "2"],
     {"color": "speed > 0", "colors": {"True": "red"}, "zoom": 2}),
    (["--colors", "teal"], {"colors": "teal"}),
    (["--opacity", "0.2 + 0.8 * (x > 0)"], {"opacity": "0.2 + 0.8 * (x > 0)"}),
    (["--opacity", "0.3", "--select", "x > 0"], {"opacity": 0.3, "select": "x > 0"}),
    (["--background", "#203040"], {"background": (0x20 / 255, 0x30 / 255, 0x40 / 255)}),
    (["--transparent"], {"transparent": True}),
    (["--cell", "--view", "-x"], {"cell": True, "view": "-x"}),
    (["--color", "speed", "--colorbar", "speed"], {"color": "speed", "colorbar": "speed"}),
    (["--colorbar", " "], {"colorbar": " "}),
]  # fmt: skip


def test_denoise_is_asked_for_in_the_film(folder: Path) -> None:
    """In a style that has no noise: it takes no other program."""
    words = ("-o", "a.png", "--save-scene", "a.toml", "--style", "matte", *WORDS)
    assert command("a.npz", *words, "--denoise").exit_code == 0
    assert "\ndenoise = true\n" in Path("a.toml").read_text()
    picture = clrt.plot(clrt.read("a.npz"), **{**SMALL, "style": "matte", "denoise": True})
    assert picture.scene.film.denoise
    assert Path("a.png").read_bytes() == picture._repr_png_()


@pytest.mark.parametrize(("words", "keywords"), SAME, ids=str)
def test_the_command_and_the_call_give_the_same_bytes(
    folder: Path, words: list[str], keywords: dict[str, Any]
) -> None:
    """And so does the scene that the command saves."""
    assert command("a.npz", "-o", "a.png", "--save-scene", "a.toml", *words, *WORDS).exit_code == 0
    picture = clrt.plot(clrt.read("a.npz"), **SMALL, **keywords)
    picture.save("b.png")
    assert Path("a.png").read_bytes() == Path("b.png").read_bytes() == picture._repr_png_()
    assert command("a.toml", "-o", "c.png", "--width", "64", "--height", "48", "-q").exit_code == 0
    assert Path("a.png").read_bytes() == Path("c.png").read_bytes()
    assert command("a.npz", "-o", "a.npy", *words, *WORDS).exit_code == 0
    assert command("a.toml", "-o", "c.npy", "--width", "64", "--height", "48", "-q").exit_code == 0
    assert Path("a.npy").read_bytes() == Path("c.npy").read_bytes()


def test_a_picture_of_arrays_saves_its_scene(folder: Path) -> None:
    picture = clrt.plot(AT, radii=0.4, values=SPEED, **SMALL)
    clrt.save_scene("b.toml", picture.scene)
    assert command("b.toml", "-o", "b.png", "--width", "64", "--height", "48", "-q").exit_code == 0
    assert Path("b.png").read_bytes() == picture._repr_png_()


def test_defaults_are_those_of_figures(folder: Path) -> None:
    assert command("a.npz", "-o", "a.png", "-q", "--save-scene", "a.toml").exit_code == 0
    assert Image.open("a.png").size == (1920, 1080)
    assert clrt.load_scene("a.toml").samples == 16


def test_a_picture_is_an_array(folder: Path) -> None:
    picture = clrt.plot(AT, radii=0.4, **SMALL)
    array = np.asarray(picture)
    assert array.shape == (48, 64, 3)
    assert array.dtype == np.uint8
    assert np.asarray(picture, np.float32).dtype == np.float32
    assert array[0, 0].tolist() == [255, 255, 255]
    shown = Image.open(io.BytesIO(picture._repr_png_()))
    assert (np.asarray(shown) == array).all()
    assert "srgb" in shown.info
    assert repr(picture) == "Picture(64x48, Spheres(n=45))"
    picture.save("a.jpg")
    with pytest.raises(clrt.RequestError, match=r"a\.exr: expected float32"):
        picture.save("a.exr")
    again = RENDERER.render(picture.scene, 64, 48, dtype="uint8")
    assert (again == array).all()


def test_six_routes_give_the_same_bytes(folder: Path) -> None:
    """npz, csv, ply, xyz, dump, and arrays in Python, text with 17 digits."""
    radii, speed = RANDOM.uniform(0.2, 0.6, N), SPEED
    columns = np.column_stack([AT, radii, speed])
    rows = [" ".join(f"{x:.17g}" for x in row) for row in columns]
    np.savez("r.npz", positions=AT, radii=radii, speed=speed)
    head = "x,y,z,radius,speed"
    Path("r.csv").write_text("\n".join([head, *(row.replace(" ", ",") for row in rows)]))
    properties = "\n".join(f"property double {name}" for name in head.split(","))
    ply = f"ply\nformat {{}} 1.0\nelement vertex {N}\n{properties}\nend_header\n"
    Path("r.ply").write_bytes(ply.format("binary_little_endian").encode() + columns.tobytes())
    Path("s.ply").write_text(ply.format("ascii") + "\n".join(rows) + "\n")
    comment = "Properties=pos:R:3:radius:R:1:speed:R:1"
    Path("r.xyz").write_text("\n".join([str(N), comment, *rows]) + "\n")
    box = "ITEM: BOX BOUNDS pp pp pp\n-3 3\n-3 3\n-3 3"
    atoms = f"ITEM: ATOMS {head.replace(',', ' ')}"
    dump = ["ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS", str(N), box, atoms, *rows]
    Path("r.dump").write_text("\n".join(dump) + "\n")
    expected = clrt.plot(AT, radii=radii, values=speed, **SMALL)._repr_png_()
    for name in ("r.npz", "r.csv", "r.ply", "s.ply", "r.xyz", "r.dump"):
        assert command(name, "-o", "a.png", "--color", "speed", *WORDS).exit_code == 0
        assert Path("a.png").read_bytes() == expected, name


HIDDEN = """
ldconfig -p | sed -n 's/.*=> //p' | grep -E '/lib(GL|EGL|OSMesa|gallium|vulkan|X11|xcb|wayland)' |
while read -r library; do mount --bind /dev/null "$library" || exit 9; done
exec "$@"
"""
DRAWN = """
from clrt.commands.cli import main
main(["render", "a.npz", "-o", "a.png", "--color", "speed", "--colorbar", "speed", "--cell",
      "--width", "64", "--height", "48", "--samples", "4", "-q"], standalone_mode=False)
maps = [line.split(maxsplit=5)[5].strip() for line in open("/proc/self/maps") if ".so" in line]
print(*sorted(set(maps)), sep="\\n")
"""


@pytest.mark.parametrize("hidden", [False, True])
def test_nothing_of_a_display_is_needed(folder: Path, hidden: bool) -> None:
    """No OpenGL, EGL, Vulkan or X of the system is loaded; and where they are empty files, as they
    are none in a slim container, it draws as before."""
    words = [sys.executable, "-c", DRAWN]
    if hidden:
        words = ["unshare", "-rm", "sh", "-c", HIDDEN, "sh", *words]
    done = subprocess.run(words, capture_output=True, text=True)
    if hidden and ("unshare" in done.stderr or done.returncode == 9):
        pytest.skip("no namespaces")
    assert done.returncode == 0, done.stderr
    loaded = [Path(line).name for line in done.stdout.split("\n") if "/site-packages/" not in line]
    assert any(name.startswith("libc.so") for name in loaded)  # it does look
    assert not [name for name in loaded if re.match("lib(GL|EGL|OSMesa|vulkan|X11|xcb|wayl)", name)]
    assert Image.open("a.png").size == (64, 48)


LIT = (0.6, -0.8, -2.0)  # the key light's way, right, up and back of the camera: docs/styles.md


@pytest.mark.parametrize("srgb", [(255, 0, 0), (68, 1, 84), (128, 128, 128), (255, 255, 255)])
def test_a_fully_lit_matte_sphere_has_the_colour_of_the_bar(srgb: tuple[int, int, int]) -> None:
    """Where its normal is towards the middle of the key light, which is 10 degrees wide: a point at
    its edge alone gives 254 in place of 255."""
    colors = np.array([srgb], np.uint8)
    options: dict[str, Any] = {"margin": 0, "view": "x", "renderer": RENDERER, "samples": 64}
    picture = clrt.plot([[1, 2, 3]], radii=2, colors=colors, size=(201, 201), **options)
    right, up, _ = -np.array(LIT) / np.linalg.norm(LIT)
    row, column = round(100 - 100 * up), round(100 + 100 * right)
    assert np.asarray(picture)[row, column].tolist() == list(srgb)
    assert np.asarray(picture).max(axis=(0, 1)).tolist() == [255, 255, 255]  # the ground


def test_colours_by_every_way() -> None:
    """All are the colour of the material times their own."""

    def drawn(**given: Any) -> Any:
        return clrt.plot(AT, radii=0.3, **SMALL, **given).scene.spheres.color  # type: ignore[attr-defined]

    assert (drawn() == color.linear(np.array(STEEL_BLUE, np.uint8))).all()
    assert drawn(color="material") is None
    red = color.linear(np.array([255, 0, 0], np.uint8))
    for one in ("red", "#f00", (1.0, 0, 0), np.array([255, 0, 0], np.uint8)):
        assert (drawn(colors=one) == red).all()
    many = RANDOM.integers(0, 256, (N, 3), np.uint8)
    assert (drawn(colors=many) == color.linear(many)).all()
    assert (drawn(colors=many, color="x") == drawn(colors=many)).all()
    assert (drawn(values=SPEED, color="x") == color.linear(palette.of_values(SPEED))).all()
    assert (drawn(color="x") == color.linear(palette.of_values(AT[:, 0]))).all()


def test_a_bar_says_what_the_colours_mean() -> None:
    """And a legend of elements or types; what is drawn stays left of them."""

    def film(**given: Any) -> clrt.Film:
        particles = clrt.read({"positions": AT, "types": np.arange(N) % 3, "numbers": [6] * N})
        options = {**SMALL, "size": (640, 480), "colorbar": "all"}
        picture = clrt.plot(particles, **{**options, **given})
        clear = clrt.plot(particles, **{**options, **given, "transparent": True, "margin": 0.0})
        bar = panel.room(clear.scene.film, (640, 480))[0]
        bare = replace(clear.scene, film=replace(clear.scene.film, colorbar=""))
        alpha = RENDERER.render(bare, 640, 480, alpha=True)[..., 3]
        assert not alpha[:, 640 - bar + 1 :].any()
        assert alpha[1].any() or alpha[:, 1].any()
        return picture.scene.film

    bar = film(values=SPEED, cmap="plasma")
    assert bar.colorbar_cmap == "plasma"
    assert bar.colorbar_clim == (SPEED.min(), SPEED.max())
    assert film(values=SPEED, clim=(0, 1)).colorbar_clim == (0, 1)
    assert [entry.name for entry in film().legend] == ["C"]
    assert [entry.name for entry in film(color="type").legend] == ["0", "1", "2"]
    with pytest.raises(clrt.RequestError, match="colorbar: expected particles coloured by a colu"):
        film(colors="red")


def test_a_box_is_the_particles_or_another() -> None:
    cell = np.diag([1.0, 2.0, 3.0])
    particles = clrt.read({"positions": AT, "cell": cell, "origin": [1.0, 0.0, 0.0]})
    options = {**SMALL, "radii": 0.5}
    (own,) = clrt.plot(particles, cell=True, **options).scene.film.cells
    assert own == clrt.Cell(((1, 0, 0), (0, 2, 0), (0, 0, 3)), (1, 0, 0))
    (other,) = clrt.plot(AT, cell=20 * cell, **options).scene.film.cells
    assert other == clrt.Cell(((20, 0, 0), (0, 40, 0), (0, 0, 60)))
    assert clrt.plot(particles, cell=False, **options).scene.film.cells == ()
    height = clrt.plot(AT, cell=20 * cell, **options).scene.camera.height
    assert height is not None
    assert height > 60  # it is in view as well


def test_masked_particles_are_not_there() -> None:
    """A clip plane is a mask."""
    mask = AT[:, 0] > -2.5
    picture = clrt.plot(AT, radii=0.3, values=SPEED, mask=mask, **SMALL)
    part = clrt.plot(AT[mask], radii=0.3, values=SPEED[mask], **SMALL)
    assert picture._repr_png_() == part._repr_png_()
    assert len(picture.scene.spheres) == mask.sum() < N


def test_nan_is_gray_and_a_constant_column_the_middle() -> None:
    values = np.array([np.nan, 1.0, 1.0])
    shown = clrt.plot(np.eye(3) * 5, radii=1, values=values, **SMALL).scene.spheres
    gray, middle = color.linear(np.array([palette.UNKNOWN, palette.colormap("viridis")[128]], "u1"))
    assert (shown.color == [gray, middle, middle]).all()  # type: ignore[attr-defined]


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"radii": [1, 2]}, "radii: expected 45 of them, as positions, got (2,)"),
    ({"radii": -1}, "radii: expected a finite number above 0, got -1"),
    ({"colors": "redd"}, "colors: expected a colour's name, #rgb, #rrggbb or three numbers from 0"),
    ({"colors": [[1, 2, 3]]}, "colors: expected 45 of them, as positions, got (1, 3)"),
    ({"colors": "red", "values": SPEED}, "values: expected none beside colors"),
    ({"values": [1, 2]}, "values: expected 45 of them, as positions, got (2,)"),
    ({"values": ["a"] * N}, "values: expected numbers (n,), got"),
    ({"color": "speed"}, "color: expected one of 'material', 'x', 'y', 'z', 'radius', 'index'"),
    ({"opacity": 1.5}, "opacity: expected a number from 0 to 1, got 1.5"),
    ({"opacity": [0.5]}, "opacity: expected 45 of them, as positions, got (1,)"),
    ({"opacity": "x"}, "opacity: expected numbers from 0 to 1, got "),
    ({"opacity": ""}, "opacity: expected a number or an expression, got ''"),
    ({"opacity": 0.5, "style": "mirror"}, "spheres[0].opacity: expected 1 beside reflection"),
    ({"scale": 0}, "scale: expected a finite number above 0, got 0"),
    ({"cmap": "jets"}, "cmap: expected one of viridis, plasma, turbo, coolwarm"),
    ({"clim": (2, 1)}, "clim: expected two finite numbers, the lower one first, got (2, 1)"),
    ({"mask": [1] * N}, "mask: expected 45 times True or False, got"),
    ({"mask": np.ones(3, bool)}, "mask: expected 45 times True or False, got"),
    ({"mask": np.zeros(N, bool)}, "particles: expected at least one, got none"),
    ({"cell": True}, "cell: expected particles in a box, got none"),
    ({"cell": [1, 2]}, "cell: expected finite numbers of shape (3, 3), got [1, 2]"),
    ({"view": "w"}, "view: expected one of corner, iso, x, -x, y, -y, z, -z or three numb"),
    ({"projection": "flat"}, "projection: expected orthographic or perspective, got 'flat'"),
    ({"margin": 0.5}, "margin: expected a number from 0 to below 0.5, got 0.5"),
    ({"background": "whitish"}, "background: expected a colour's name, #rgb, #rrggbb or three num"),
    ({"background": (1, 2, 3)}, "background: expected a colour's name, #rgb, #rrggbb or three num"),
    ({"style": "nice"}, "style: expected one of soft, matte, outline, mirror, ball-and-stick"),
    ({"samples": 0}, "samples: expected a whole number from 1 to 65536, got 0"),
    ({"size": (0, 5)}, "size: expected two whole numbers above 0, got (0, 5)"),
    ({"size": 5}, "size: expected two whole numbers above 0, got 5"),
]  # fmt: skip


@pytest.mark.parametrize(("given", "message"), WRONG, ids=[str(one)[:60] for one, _ in WRONG])
def test_a_wrong_argument_is_one_line(given: dict[str, Any], message: str) -> None:
    with pytest.raises(clrt.RequestError) as error:
        clrt.plot(AT, **{"radii": 0.3, **SMALL, **given})
    assert str(error.value).startswith(message)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["a.npz", "--color", "sped"],
            "a.npz: --color: expected one of 'type', 'material', 'speed',",
        ),
        (["a.npz", "--style", "nice"], "--style: expected one of soft,"),
        (["a.npz", "--frame", "1"], "a.npz: expected a frame from 0 to 0, got 1"),
        (["a.npz", "--save-scene", "a.json"], "a.json: expected a name that ends in .toml"),
        (["a.npz", "-o", "a.npz"], "a.npz: is read as well: expected another name"),
        (["b.npz"], "b.npz: no such file"),
        (["orbit", "--color", "speed"], "--color: expected a file of particles, orbit is a scene"),
        (["orbit", "--save-scene", "a.toml"], "--save-scene: expected a file of particles, orbit"),
        (["orbit", "--frame", "0"], "--frame: expected a file of particles, orbit is a scene"),
        (["orbit", "--cell"], "--cell: expected a file of particles, orbit is a scene"),
    ],
    ids=str,
)
def test_a_wrong_word_is_one_line(folder: Path, words: list[str], message: str) -> None:
    result = command(*words, *WORDS)
    assert result.exit_code == 2
    assert result.stderr.startswith(f"clrt: {message}")
    assert len(result.stderr.splitlines()) == 1
    assert sorted(path.name for path in folder.iterdir()) == ["a.npz"]


@pytest.mark.parametrize("projection", PROJECTIONS)
@pytest.mark.parametrize("size", [(64, 48), (40, 60)])
def test_all_is_in_the_picture_and_fills_it(size: tuple[int, int], projection: Any) -> None:
    """As the kernel sees it: with no margin spheres come to two sides, and with one they do not."""
    options: dict[str, Any] = {"radii": 0.5, "size": size, "transparent": True, "samples": 64}
    options |= {"renderer": RENDERER, "projection": projection, "values": SPEED}
    alpha = np.asarray(clrt.plot(AT, margin=0.0, **options))[..., 3]
    edges = [alpha[0], alpha[-1], alpha[:, 0], alpha[:, -1]]
    assert sum(edge.any() for edge in edges) >= 2
    alpha = np.asarray(clrt.plot(AT, margin=0.05, **options))[..., 3]
    assert not any(edge.any() for edge in (alpha[0], alpha[-1], alpha[:, 0], alpha[:, -1]))
    assert alpha.any()

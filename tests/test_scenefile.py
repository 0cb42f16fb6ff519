"""Scene files: what is wrong is said with file, key and what was expected."""

import functools
import os
import pickle
import re
import tempfile
import threading
from pathlib import Path

import numpy as np
import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

import clrt
from clrt.files.scenefile import parse_scene
from clrt.storage import folder

GOOD = """
max_depth = 3
[camera]
position = [0, 0.0, 1.0]
look_at = [0.0, 0.0, 0.0]
[[lights]]
position = [5.0, 5.0, 5.0]
[materials.red]
ambient = [0.1, 0.0, 0.0]
diffuse = [0.7, 0.0, 0.0]
specular = [1.0, 1.0, 1.0]
shininess = 100.0
[[spheres]]
center = [-0.2, 0.0, -1.0]
radius = 0.7
material = "red"
"""


ANIMATION = """
[animation]
frames = 9
keys = [{frame = 0, fov = 50.0}, {frame = 8, position = [0.0, 1.0, 2.0]}]
"""


@functools.cache
def renderer() -> clrt.Renderer:
    return clrt.Renderer()


def test_defaults() -> None:
    scene = parse_scene(GOOD)
    assert scene.shadow_bias == 0
    assert scene.camera.up == (0, 1, 0)
    assert scene.camera.fov == 90
    assert scene.lights[0].type == "point"
    assert scene.lights[0] == clrt.Light((5, 5, 5), diffuse=(1, 1, 1))
    assert scene.materials["red"].reflection == 0
    assert isinstance(scene.camera.position[0], float)
    assert scene.film == clrt.Film() == clrt.Film((0, 0, 0), False, "linear", 0, (0, 0, 0), (0, 0))


def test_a_film() -> None:
    film = """[film]
    background = [1, 0.5, 0.25]
    transparent = true
    transfer = "srgb"
    outline = 1.5
    outline_color = [0, 0, 1]
    depth_cue = [-3, 4]
    """
    expected = clrt.Film((1, 0.5, 0.25), True, "srgb", 1.5, (0, 0, 1), (-3, 4))
    assert parse_scene(GOOD + film).film == expected


def test_what_is_drawn_over() -> None:
    film = """[film]
    colorbar = "speed"
    colorbar_cmap = "plasma_r"
    colorbar_clim = [0, 5]
    [[film.legend]]
    name = "Na"
    color = [0.5, 0, 1]
    [[film.cells]]
    edges = [[1, 0, 0], [0, 2, 0], [0.5, 0, 3]]
    [[film.cells]]
    edges = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    origin = [-1, 0, 1]
    """
    expected = clrt.Film(
        colorbar="speed",
        colorbar_cmap="plasma_r",
        colorbar_clim=(0, 5),
        legend=(clrt.LegendEntry("Na", (0.5, 0, 1)),),
        cells=[
            clrt.Cell(((1, 0, 0), (0, 2, 0), (0.5, 0, 3))),
            clrt.Cell(((1, 0, 0), (0, 1, 0), (0, 0, 1)), (-1, 0, 1)),
        ],
    )
    found = parse_scene(GOOD + film).film
    assert found == expected
    assert hash(found) == hash(expected)  # of equal pictures
    assert pickle.loads(pickle.dumps(found)) == expected


def test_what_spreads_rays() -> None:
    """All keys of it, at once and with infinity."""
    text = """
    samples = 16
    indirect = true
    [camera]
    position = [0, 0, 1]
    look_at = [0, 0, 0]
    aperture_radius = 0.1
    focus_distance = 2
    [film]
    denoise = true
    [materials.fog]
    reflection = 0.5
    roughness = 0.25
    [[lights]]
    position = [5, 5, 5]
    radius = 0.5
    [[lights]]
    type = "directional"
    direction = [0, -1, 0]
    half_angle = 0.27
    [[lights]]
    type = "spot"
    position = [0, 1, 0]
    look_at = [0, 0, 0]
    radius = 2
    [[lights]]
    type = "ambient"
    occlusion = true
    distance = inf
    [[lights]]
    type = "ambient"
    distance = 0.5
    """
    assert parse_scene(text) == clrt.Scene(
        clrt.Camera((0, 0, 1), (0, 0, 0), aperture_radius=0.1, focus_distance=2),
        (
            clrt.Light((5, 5, 5), radius=0.5),
            clrt.DirectionalLight((0, -1, 0), half_angle=0.27),
            clrt.SpotLight((0, 1, 0), (0, 0, 0), radius=2),
            clrt.AmbientLight(occlusion=True),
            clrt.AmbientLight(distance=0.5),
        ),
        {"fog": clrt.Material(reflection=0.5, roughness=0.25)},
        film=clrt.Film(denoise=True),
        samples=16,
        indirect=True,
    )
    plain = parse_scene(GOOD)
    assert (plain.samples, plain.indirect, plain.camera.has_lens) == (1, False, False)


@pytest.mark.parametrize("name", clrt.builtin_scenes())
def test_builtin_scenes_have_a_picture_beside_them(name: str) -> None:
    assert clrt.load_scene(name).spheres
    assert (folder("scenes") / f"{name}.png").is_file()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("radius = 0.7", "radius = -1", "spheres[0].radius: expected a finite number above 0"),
        ("radius = 0.7", "radius = nan", "spheres[0].radius: expected a finite number above 0"),
        ("radius = 0.7", "radius = '1'", "spheres[0].radius: expected `float`, got `str`"),
        ("radius = 0.7", "radius = true", "spheres[0].radius: expected `float`, got `bool`"),
        ("radius = 0.7", "radius = 1e400", "spheres[0].radius: expected a finite number above 0"),
        ("radius = 0.7", f"radius = 1{'0' * 400}", "spheres[0].radius: number out of range"),
        ("radius = 0.7", "", "spheres[0].radius: expected a value, got none"),
        ("radius = 0.7", "radius = 0.7\ncolour = 1", "spheres[0].colour: unknown key"),
        ('material = "red"', 'material = "blue"', "spheres[0].material: expected the name"),
        ("[-0.2, 0.0, -1.0]", "[-0.2, 0.0]", "spheres[0].center: expected `array` of length 3"),
        ("[-0.2, 0.0, -1.0]", "[inf, 0.0, 1.0]", "spheres[0].center: expected three finite"),
        ("[-0.2, 0.0, -1.0]", "[0.0, 'a', 1.0]", "spheres[0].center[1]: expected `float`"),
        ("shininess = 100.0", "highlight = 'x'", "materials.red.highlight: "),
        ("shininess = 100.0", "shininess = 1\nfuzz = 1", "materials.red.fuzz: unknown key"),
        ("shininess = 100.0", "shininess = 1\nreflection = 1.1", "materials.red.reflection: "),
        (
            "[5.0, 5.0, 5.0]",
            "[5.0, 5.0, 5.0]\ntype = 'sun'",
            "lights[0].type: expected 'point', 'directional', 'spot' or 'ambient', got 'sun'",
        ),
        ("[5.0, 5.0, 5.0]", "[5.0, 5.0, 5.0]\ntype = 1", "lights[0].type: expected 'point', "),
        (
            "[5.0, 5.0, 5.0]",
            "[5.0, 5.0, 5.0]\ndirection = [1.0, 0.0, 0.0]",
            "lights[0].direction: expected in lights of type 'directional', not 'point'",
        ),
        (
            "position = [5.0, 5.0, 5.0]",
            "type = 'directional'",
            "lights[0].direction: expected a value, got none",
        ),
        (
            "position = [5.0, 5.0, 5.0]",
            "type = 'ambient'\nattenuation = [1.0, 0.0, 0.0]",
            "lights[0].attenuation: expected in lights of type 'point' and 'spot', not 'ambient'",
        ),
        ("[5.0, 5.0, 5.0]", "[5.0, 5.0, 5.0]\ncolour = 1", "lights[0].colour: unknown key"),
        (
            "[5.0, 5.0, 5.0]",
            "[5.0, 5.0, 5.0]\ntype = 'spot'\nlook_at = [0.0, 0.0, 0.0]\nouter_angle = 20.0\n"
            "inner_angle = 30.0",
            "lights[0].inner_angle: expected degrees from 0 to outer_angle (20.0), got 30.0",
        ),
        (
            "[5.0, 5.0, 5.0]",
            "[5.0, 5.0, 5.0]\nhalf_angle = 1.0",
            "lights[0].half_angle: expected in lights of type 'directional', not 'point'",
        ),
        (
            "position = [5.0, 5.0, 5.0]",
            "type = 'ambient'\nradius = 1.0",
            "lights[0].radius: expected in lights of type 'point' and 'spot', not 'ambient'",
        ),
        (
            "position = [5.0, 5.0, 5.0]",
            "type = 'directional'\ndirection = [0.0, -1.0, 0.0]\nocclusion = true",
            "lights[0].occlusion: expected in lights of type 'ambient', not 'directional'",
        ),
        (
            "[5.0, 5.0, 5.0]",
            "[5.0, 5.0, 5.0]\nradius = -1.0",
            "lights[0].radius: expected a finite number, at least 0, got -1.0",
        ),
        (
            "position = [5.0, 5.0, 5.0]",
            "type = 'ambient'\ndistance = -inf",
            "lights[0].distance: expected a number above 0, got -inf",
        ),
        (
            "position = [5.0, 5.0, 5.0]",
            "type = 'ambient'\nocclusion = 1",
            "lights[0].occlusion: expected `bool | str`, got `int`",
        ),
        (
            "[camera]",
            "[camera]\naperture_radius = 0.1",
            "camera.focus_distance: expected a finite number above 0, which aperture_radius needs",
        ),
        (
            "[camera]",
            "[camera]\nprojection = 'orthographic'\nheight = 1\naperture_radius = 0.1\n"
            "focus_distance = 1.0",
            "camera.aperture_radius: expected 0 with projection 'orthographic', got 0.1",
        ),
        ("shininess = 100.0", "roughness = 2", "materials.red.roughness: expected a number from"),
        ("[camera]", "[film]\ndenoise = 1\n[camera]", "film.denoise: expected `bool`, got `int`"),
        ("max_depth = 3", "samples = 0", "samples: expected a whole number from 1 to 65536, got 0"),
        ("max_depth = 3", "samples = 2.5", "samples: expected `int`, got `float`"),
        ("max_depth = 3", "indirect = 'no'", "indirect: expected `bool`, got `str`"),
        (
            "max_depth = 3",
            "indirect = true\nshadow_bias = 1e-5",
            "shadow_bias: expected 0 beside indirect, got 1e-05",
        ),
        ("max_depth = 3", "max_depth = 0", "max_depth: expected a whole number from 1 to 1000"),
        ("max_depth = 3", "max_depth = 3000000000", "max_depth: expected a whole number"),
        ("max_depth = 3", "max_depth = 2.5", "max_depth: expected `int`"),
        ("max_depth = 3", "max_depth = 1000000", "max_depth: expected a whole number from 1 to"),
        ("max_depth = 3", "depth = 3", "depth: unknown key"),
        ("max_depth = 3", "'' = 3", '"": unknown key'),
        ("max_depth = 3", "max_depth = 2020-01-01", "max_depth: expected `int`"),
        ("[camera]", "[camera]\nup = [0.0, 0.0, 1.0]", "camera.up: expected a direction not"),
        ("[camera]", "[camera]\nfov = 200.0", "camera.fov: expected degrees"),
        ("[camera]", "[camera]\nheight = 2", "camera.height: expected none, which goes with"),
        (
            "[camera]",
            "[camera]\nprojection = 'orthographic'\nheight = 1\nfov = 50",
            "camera.fov: expected none, which goes with projection 'perspective' only, got 50.0",
        ),
        (
            "[camera]",
            "[camera]\nprojection = 'orthographic'",
            "camera.height: expected a finite number above 0, got None",
        ),
        ("[camera]", "[camera]\nprojection = 'x'", "camera.projection: "),
        ("[camera]", "[[camera]]", "camera: expected `object`"),
        ("[camera]", "[film]\noutline = -1.0\n[camera]", "film.outline: expected a number from 0"),
        ("[camera]", "[film]\ndepth_cue = [1]\n[camera]", "film.depth_cue: expected `array`"),
        ("[camera]", "[film]\ntransfer = 'x'\n[camera]", "film.transfer: invalid enum value 'x'"),
        ("[camera]", "[film]\nalpha = true\n[camera]", "film.alpha: unknown key"),
        (
            "[camera]",
            "[film]\ncolorbar_cmap = 'jett'\n[camera]",
            "film.colorbar_cmap: expected one of viridis, plasma, turbo, coolwarm",
        ),
        (
            "[camera]",
            "[film]\ncolorbar = 'speed'\n[camera]",
            "film.colorbar_clim: expected two numbers beside colorbar, got None",
        ),
        (
            "[camera]",
            "[[film.cells]]\nedges = [[1, 0, 0]]\n[camera]",
            "film.cells[0].edges: expected `array` of length 3",
        ),
        ("look_at = [0.0, 0.0, 0.0]", "", "camera.look_at: expected a value, got none"),
        ("max_depth = 3", "max_depth == 3", "not TOML: "),
        ("max_depth = 3", "max_depth = " + "[" * 2000, "not TOML: "),
        ("max_depth = 3", "max_depth = " + "9" * 5000, "not TOML: "),
        ("[camera]", "[animation]\nframes = 9\n[camera]", "animation.keys: expected a value"),
        (
            "[camera]",
            "[animation]\nframes = 9\nkeys = [{frame = 3}, {frame = 2}]\n[camera]",
            "animation.keys[1].frame: expected a frame from 4 to 9",
        ),
        (
            "[camera]",
            "[animation]\nframes = 9\nkeys = [{frame = 3}, {frame = 4, fov = inf}]\n[camera]",
            "animation.keys[1].fov: expected a finite number",
        ),
    ],
)
def test_names_file_key_and_what_was_expected(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    assert old in GOOD
    path = tmp_path / "wrong.toml"
    path.write_text(GOOD.replace(old, new))
    with pytest.raises(clrt.SceneError) as caught:
        clrt.load_scene(path)
    assert str(caught.value).startswith(f"{path}: {said}")
    assert "\n" not in str(caught.value)


def test_no_camera() -> None:
    with pytest.raises(clrt.SceneError, match="camera: expected a value, got none"):
        parse_scene("")


def test_unreadable(tmp_path: Path) -> None:
    with pytest.raises(clrt.SceneError, match="no such file, nor a built-in scene"):
        clrt.load_scene(tmp_path / "none.toml")
    with pytest.raises(clrt.SceneError, match="cannot be read"):
        clrt.load_scene(tmp_path)
    with pytest.raises(clrt.SceneError, match=r"cannot be read: .*embedded null"):
        clrt.load_scene("a\0b")
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe")
    with pytest.raises(clrt.SceneError, match="expected UTF-8"):
        clrt.load_scene(binary)
    large = tmp_path / "large.toml"
    with large.open("wb") as file:
        file.truncate(200_000_000)
    for endless in ("/dev/zero", large):
        with pytest.raises(clrt.SceneError, match="cannot be read: expected at most 64 MB"):
            clrt.load_scene(endless)


def test_a_pipe_is_waited_for_only_if_somebody_writes(tmp_path: Path) -> None:
    pipe = tmp_path / "scene.toml"
    os.mkfifo(pipe)
    with pytest.raises(clrt.SceneError, match="camera: expected a value, got none"):
        clrt.load_scene(pipe)
    reading, writing = os.pipe()

    def write() -> None:
        os.write(writing, GOOD.encode())
        os.close(writing)

    threading.Timer(0.3, write).start()
    assert clrt.load_scene(f"/dev/fd/{reading}") == parse_scene(GOOD)
    os.close(reading)


WORDS = re.findall(r"[\w.\-]+|[^\w\s]|\s", GOOD + ANIMATION)
NUMBERS = [i for i, word in enumerate(WORDS) if re.fullmatch(r"-?[\d.]+", word)]
ODD_NUMBERS = ["0", "-0.0", "1", "-7", "0.5", "179.9", "1e-320", "-1e308", "1e20", "nan", "inf",
               "9" * 400, "1000", "true", "2020-01-01", '"1"', "[]", "[1, 2, 3]", "{}"]  # fmt: skip
ODD_WORDS = sorted({*WORDS, *ODD_NUMBERS, '"""', "\0", "é"})


@st.composite
def mutated(draw: st.DrawFn) -> bytes:
    """A scene file with some numbers changed, words gone, doubled or moved, or a byte spoilt."""
    words = WORDS.copy()
    for i in draw(st.lists(st.sampled_from(NUMBERS), max_size=4)):
        words[i] = draw(st.sampled_from(ODD_NUMBERS))
    for _ in range(draw(st.sampled_from([0, 0, 0, 1, 2]))):
        at = draw(st.integers(0, len(words) - 1))
        new = draw(st.lists(st.sampled_from(ODD_WORDS), max_size=3))
        words[at : at + draw(st.integers(0, 3))] = new
    text = bytearray("".join(words).encode())
    if draw(st.sampled_from([False, False, False, True])):
        text[draw(st.integers(0, len(text) - 1))] = draw(st.integers(0, 255))
    return bytes(text)


@settings(max_examples=400, deadline=None)
@given(text=mutated())
def test_a_mutated_file_is_a_picture_or_one_line(text: bytes) -> None:
    with tempfile.NamedTemporaryFile(suffix=".toml") as file:
        file.write(text)
        file.flush()
        try:
            scene = clrt.load_scene(file.name)
            assert np.isfinite(renderer().render(scene, 5, 2)).all()
            for frame in clrt.animate(scene, 4, 3, frames=[0, 5], renderer=renderer()):
                assert np.isfinite(frame).all()
        except clrt.SceneError as error:
            event(re.sub(r"[\d'`].*", "", str(error).removeprefix(file.name)))
        else:
            event("pictures")

"""Scene files: what is wrong is said with file, key and what was expected."""

from pathlib import Path

import pytest

import clrt
from clrt.data import folder
from clrt.scenefile import parse_scene

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


def test_defaults() -> None:
    scene = parse_scene(GOOD)
    assert scene.shadow_bias == 0
    assert scene.camera.up == (0, 1, 0)
    assert scene.camera.fov == 90
    assert scene.lights[0].type == "point"
    assert scene.lights[0].diffuse == (1, 1, 1)
    assert scene.materials["red"].reflection == 0
    assert isinstance(scene.camera.position[0], float)


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
        ("shininess = 100.0", "", "materials.red.shininess: expected a value, got none"),
        ("shininess = 100.0", "shininess = 1\nfuzz = 1", "materials.red.fuzz: unknown key"),
        ("shininess = 100.0", "shininess = 1\nreflection = 1.1", "materials.red.reflection: "),
        ("[5.0, 5.0, 5.0]", "[5.0, 5.0, 5.0]\ntype = 'spot'", "lights[0].type: "),
        ("max_depth = 3", "max_depth = 0", "max_depth: expected a whole number, at least 1"),
        ("max_depth = 3", "max_depth = 3000000000", "max_depth: expected a whole number"),
        ("max_depth = 3", "max_depth = 2.5", "max_depth: expected `int`"),
        ("max_depth = 3", "depth = 3", "depth: unknown key"),
        ("max_depth = 3", "max_depth = 2020-01-01", "max_depth: expected `int`"),
        ("[camera]", "[camera]\nup = [0.0, 0.0, 1.0]", "camera.up: expected a direction not"),
        ("[camera]", "[camera]\nfov = 200.0", "camera.fov: expected degrees"),
        ("[camera]", "[[camera]]", "camera: expected `object`"),
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
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe")
    with pytest.raises(clrt.SceneError, match="expected UTF-8"):
        clrt.load_scene(binary)

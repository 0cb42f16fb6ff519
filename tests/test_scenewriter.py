"""Scenes to files, and back."""

from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

import clrt
from clrt.errors import RequestError
from clrt.files.scenewriter import save_scene

CAMERA = clrt.Camera((0, 0, 9), (0, 0, 0))
ODD = clrt.Scene(
    camera=clrt.Camera((1 / 3, -2e-300, 9), (0, 0, 0), projection="orthographic", height=0.1 + 0.2),
    lights=[
        clrt.AmbientLight(occlusion=True, distance=3.5),
        clrt.DirectionalLight((1, 2, 3), half_angle=1.5),
        clrt.SpotLight((0, 1, 2), (3, 4, 5)),
        clrt.PointLight((1, 2, 3), attenuation=(0, 0, 1)),
    ],
    materials={
        'a "name" of\ttwo': clrt.Material((0.1, 0.2, 0.3)),
        "ü": clrt.Material(fresnel=True),
    },
    spheres=[clrt.Sphere((0, 0, 0.1), 1e-7, "ü", (0.5, 2.0, -1.0)), clrt.Sphere((1, 2, 3), 4, "ü")],
    film=clrt.Film(background=(0.5, 0.5, 0.5), transparent=True, transfer="srgb", outline=1.5),
    animation=clrt.Animation(9, [clrt.Key(0, position=(1, 2, 3)), clrt.Key(8, height=2)]),
    samples=9,
)


@pytest.mark.parametrize("name", [*clrt.builtin_scenes(), "odd"])
def test_a_scene_comes_back(name: str, tmp_path: Path) -> None:
    scene = ODD if name == "odd" else clrt.load_scene(name)
    save_scene(tmp_path / "a.toml", scene)
    assert clrt.load_scene(tmp_path / "a.toml") == scene
    assert [path.name for path in tmp_path.iterdir()] == ["a.toml"]


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("colored", [False, True])
@pytest.mark.parametrize("opaque", [False, True])
def test_arrays_go_into_a_file_beside_it(
    kind: type, colored: bool, opaque: bool, tmp_path: Path
) -> None:
    random = np.random.default_rng(2)
    colors = random.uniform(0, 1, (40, 3)).astype(np.float32) if colored else None
    if colors is not None:
        colors[:4] = np.array([[0, 0, 0], [1, 1, 1], [1e-7, 0.0031308, 0.0031309], [0.5, 1, 0]])
    spheres = clrt.Spheres(
        random.normal(size=(40, 3)).astype(kind),
        random.uniform(0.1, 1, 40),
        "m",
        colors,
        None if opaque else random.uniform(0, 1, 40).astype(kind),
    )
    scene = clrt.Scene(CAMERA, materials={"m": clrt.Material()}, spheres=spheres)
    save_scene(tmp_path / "a.toml", scene)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.npz", "a.toml"]
    loaded = clrt.load_scene(tmp_path / "a.toml")
    assert loaded.particles[0].file == str(tmp_path / "a.npz")
    with clrt.Renderer() as renderer:
        expected = renderer.render(scene, 30, 20)
        assert (renderer.render(loaded, 30, 20) == expected).all()


@pytest.mark.parametrize(
    "spheres",
    [
        clrt.Spheres([[0, 0, 0], [1, 1, 1]], 0.5, ["m", "n"]),
        clrt.Spheres([[0, 0, 0]], 0.5, "m", [[0.5, 2.0, -1.0]]),
        clrt.Spheres([[0, 0, 0]], 0.5, "m", np.array([[0.1, 0.2, 0.3]])),
    ],
    ids=["materials", "no sRGB", "float64"],
)
def test_arrays_that_a_file_of_particles_cannot_hold_go_into_the_scene(
    spheres: clrt.Spheres, tmp_path: Path
) -> None:
    both = {"m": clrt.Material(), "n": clrt.Material()}
    scene = clrt.Scene(CAMERA, materials=both, spheres=spheres)
    save_scene(tmp_path / "a.toml", scene)
    assert not (tmp_path / "a.npz").exists()
    assert clrt.load_scene(tmp_path / "a.toml").spheres == tuple(spheres)


def test_files_are_named_from_the_scenes_folder(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in").mkdir()
    (tmp_path / "out").mkdir()
    np.save("in/a.npy", np.zeros((1, 4)) + 1)
    absolute = str(tmp_path / "in" / "a.npy")
    scene = clrt.Scene(
        CAMERA, particles=[clrt.ParticleFile("in/a.npy"), clrt.ParticleFile(absolute)]
    )
    save_scene("out/a.toml", scene)
    text = Path("out/a.toml").read_text()
    assert '"../in/a.npy"' in text
    assert f'"{absolute}"' in text
    assert (clrt.render("out/a.toml", 9, 9) == clrt.render(scene, 9, 9)).all()


def test_where_it_cannot_be(tmp_path: Path) -> None:
    with pytest.raises(RequestError, match=r"a\.json: expected a name that ends in \.toml"):
        save_scene(tmp_path / "a.json", ODD)
    with pytest.raises(RequestError, match=r"the folder .* does not exist"):
        save_scene(tmp_path / "no" / "a.toml", ODD)


def test_it_reads_well(tmp_path: Path) -> None:
    """Numbers that belong together are on one line, and what is the default is left out."""
    save_scene(tmp_path / "a.toml", replace(ODD, animation=None))
    text = (tmp_path / "a.toml").read_text()
    assert "background = [0.5, 0.5, 0.5]\n" in text
    assert "shadow_bias" not in text
    assert max(map(len, text.splitlines())) < 120

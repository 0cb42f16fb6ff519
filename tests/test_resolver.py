"""Files of particles that a scene names."""

import os
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from msgspec.structs import replace

import clrt
from clrt.figure.resolver import Resolver, resolved
from clrt.figure.styles import STYLES
from clrt.film import color
from clrt.particles import palette

SCENE = """
[camera]
position = [0.0, 0.0, 9.0]
look_at = [0.0, 0.0, 0.0]
[[lights]]
position = [5.0, 9.0, 7.0]
[materials.red]
diffuse = [0.9, 0.1, 0.1]
[[particles]]
file = "atoms/a.npz"
radius = 0.4
[[spheres]]
center = [0.0, 1.0, 0.0]
radius = 1.0
material = "red"
[[particles]]
file = "atoms/b.csv"
material = "red"
color = "speed"
cmap = "plasma"
clim = [0.0, 4.0]
scale = 0.5
"""
A = np.array([[-2.0, 0.0, 0.5], [2.0, 0.1, 0.0]])
B = np.array([[-1.0, -2.0, 0.0], [1.0, -2.0, 0.5], [0.5, -1.0, 1.0]])


@pytest.fixture
def path(tmp_path: Path) -> Path:
    (tmp_path / "atoms").mkdir()
    np.savez(tmp_path / "atoms" / "a.npz", positions=A, types=[0, 1])
    rows = [f"{x},{y},{z},1.0,{i}" for i, (x, y, z) in enumerate(B)]
    (tmp_path / "atoms" / "b.csv").write_text("\n".join(["x,y,z,radius,speed", *rows]))
    scene = tmp_path / "my.toml"
    scene.write_text(SCENE)
    return scene


def test_particles_come_after_spheres_in_the_order_of_their_file(path: Path) -> None:
    scene = clrt.load_scene(path)
    assert [one.file for one in scene.particles] == [
        str(path.parent / "atoms" / name) for name in ("a.npz", "b.csv")
    ]
    found = resolved(scene)
    assert found.particles == ()
    spheres = found.spheres
    assert isinstance(spheres, clrt.Spheres)
    assert spheres.center.tolist() == [[0, 1, 0], *A.tolist(), *B.tolist()]
    assert spheres.radius.tolist() == [1, 0.4, 0.4, 0.5, 0.5, 0.5]
    assert [one.material for one in spheres] == ["red", *["soft"] * 2, *["red"] * 3]
    own = [palette.OKABE_ITO[:2], palette.of_values([0, 1, 2], "plasma", (0, 4))]
    assert spheres.color is not None
    assert spheres.color[0].tolist() == [1, 1, 1]
    assert (spheres.color[1:] == np.concatenate([color.linear(one) for one in own])).all()
    assert found.materials == {"soft": STYLES["soft"].material, **scene.materials}


def test_a_scene_may_have_its_own_style(path: Path) -> None:
    scene = clrt.load_scene(path)
    own = clrt.Material(diffuse=(0.5, 0.5, 0.5))
    found = resolved(replace(scene, materials={**scene.materials, "soft": own}))
    assert found.materials["soft"] == own


def test_a_picture_of_it_is_that_of_its_spheres(path: Path) -> None:
    """And the truth, which knows such scenes too, is near."""
    scene = clrt.load_scene(path)
    with clrt.Renderer() as renderer:
        picture, passes = renderer.render(scene, 60, 40, passes=("id",))
        assert (picture == renderer.render(resolved(scene), 60, 40)).all()
        assert set(np.unique(passes["id"])) == {-1, *range(6)}
        assert (renderer.render(path, 60, 40) == picture).all()
    truth = clrt.reference.trace(scene, 60, 40)
    assert (truth.id == passes["id"]).all()
    assert np.abs(truth.image - picture).max() < 1 / 1020


def test_the_same_in_python(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    loaded = clrt.load_scene(path)
    monkeypatch.chdir(path.parent)
    scene = clrt.Scene(
        camera=loaded.camera,
        lights=loaded.lights,
        materials=loaded.materials,
        spheres=loaded.spheres,
        particles=[
            clrt.ParticleFile("atoms/a.npz", radius=0.4),
            clrt.ParticleFile(
                "atoms/b.csv", 0, "red", scale=0.5, color="speed", cmap="plasma", clim=(0, 4)
            ),
        ],
    )
    assert resolved(scene) == resolved(loaded)


def test_what_was_read_is_kept_while_the_file_stays(path: Path) -> None:
    resolver, scene = Resolver(), clrt.load_scene(path)
    spheres = resolver.scene(scene).spheres
    moved = replace(scene, camera=replace(scene.camera, fov=30.0))
    assert resolver.scene(moved).spheres is spheres
    assert resolver.scene(replace(scene, spheres=scene.spheres[:0])).spheres is not spheres
    spheres = resolver.scene(scene).spheres
    file = path.parent / "atoms" / "a.npz"
    os.utime(file, ns=(1, 1))
    assert resolver.scene(scene).spheres is not spheres
    file.unlink()
    with pytest.raises(clrt.SceneError, match=r"particles\[0\].file: .*a.npz: no such file"):
        resolver.scene(scene)


def test_a_colour_bar_is_that_of_the_first_column(path: Path) -> None:
    scene = clrt.load_scene(path)
    look = clrt.Film(colorbar="speed")
    film = resolved(replace(scene, film=look)).film
    assert (film.colorbar_cmap, film.colorbar_clim) == ("plasma", (0, 4))
    own = clrt.Film(colorbar="speed", colorbar_cmap="turbo", colorbar_clim=(1, 2))
    shown = resolved(replace(scene, film=own)).film
    assert replace(shown, colorbar_ends=(False, False)) == own
    assert shown.colorbar_ends == (True, False)  # of speeds to 2
    types = resolved(replace(scene, film=look, particles=scene.particles[:1])).film
    assert [entry.name for entry in types.legend] == ["0", "1"]
    bare = replace(scene.particles[0], color="material")
    with pytest.raises(clrt.SceneError, match=r"film\.colorbar: expected particles coloured by"):
        resolved(replace(scene, film=look, particles=[bare]))


def test_a_box_is_drawn_where_there_is_one(path: Path) -> None:
    np.savez(path.parent / "c.npz", positions=A, cell=[1.0, 2.0, 3.0], origin=[4.0, 5.0, 6.0])
    boxed = clrt.ParticleFile(str(path.parent / "c.npz"), radius=1, cell=True)
    scene = replace(clrt.load_scene(path), particles=[boxed])
    edges = ((1, 0, 0), (0, 2, 0), (0, 0, 3))
    assert resolved(scene).film.cells == (clrt.Cell(edges, (4, 5, 6)),)
    with pytest.raises(clrt.SceneError, match=r"particles\[0\]\.cell: expected particles in a box"):
        resolved(replace(scene, particles=[replace(boxed, file=str(path.parent / "atoms/a.npz"))]))


def test_a_scene_without_them_stays_itself() -> None:
    scene = clrt.load_scene("four-spheres")
    assert resolved(scene) is scene


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"file": ""}, "file: expected a file's name, got ''"),
    ({"file": 3}, "file: expected `str`, got `int`"),
    ({"frame": -1}, "frame: expected a whole number from 0 to 2147483647, got -1"),
    ({"radius": 0.0}, "radius: expected a finite number above 0, got 0.0"),
    ({"scale": float("inf")}, "scale: expected a finite number above 0, got inf"),
    (
        {"color": ""},
        "color: expected 'file', 'element', 'type', 'material' or an expression over columns",
    ),
    ({"cmap": "jets"}, "cmap: expected one of viridis, plasma, turbo, coolwarm"),
    (
        {"clim": [2.0, 1.0]},
        "clim: expected two finite numbers, the lower one first, got (2.0, 1.0)",
    ),
    ({"clim": [2.0]}, "clim: expected `array` of length 2, got 1"),
    ({"cell": 1}, "cell: expected `bool | str`, got `int`"),
    ({"colour": "file"}, "colour: unknown key"),
    ({"material": "gold"}, "material: expected the name of a material ('red'), got 'gold'"),
]


@pytest.mark.parametrize(("keys", "message"), WRONG, ids=str)
def test_a_wrong_key_is_one_line(keys: dict[str, Any], message: str, tmp_path: Path) -> None:
    import tomli_w

    table = {"file": "a.npz", **keys}
    camera = {"position": [0, 0, 9], "look_at": [0, 0, 0]}
    text = tomli_w.dumps({"camera": camera, "materials": {"red": {}}, "particles": [table]})
    (tmp_path / "my.toml").write_text(text)
    with pytest.raises(clrt.SceneError) as error:
        clrt.load_scene(tmp_path / "my.toml")
    assert str(error.value).startswith(f"{tmp_path}/my.toml: particles[0].{message}")


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        (
            {"color": "file"},
            "particles[0].color: expected one of 'type', 'material', 'x', 'y', 'z', 'index'",
        ),
        ({"frame": 1}, "particles[0].file: {}: expected a frame from 0 to 0, got 1"),
    ],
    ids=str,
)
def test_what_a_file_has_not_is_one_line(path: Path, keys: dict[str, Any], message: str) -> None:
    scene = clrt.load_scene(path)
    changed = replace(scene.particles[0], **keys)
    with pytest.raises(clrt.SceneError) as error:
        clrt.render(replace(scene, particles=[changed]), 8, 8)
    file = str(path.parent / "atoms" / "a.npz")
    assert str(error.value).startswith(message.format(file))
    assert file in str(error.value)


def test_a_particle_file_checks_itself_in_python_too() -> None:
    with pytest.raises(clrt.SceneError, match="scale: expected a finite number above 0, got -1"):
        clrt.ParticleFile("a.npz", scale=-1)
    with pytest.raises(clrt.SceneError, match=r"particles\[0\]: expected a ParticleFile, got 'a"):
        clrt.Scene(clrt.Camera((0, 0, 1), (0, 0, 0)), particles=["a.npz"])  # type: ignore[list-item]
    assert msgspec.structs.asdict(clrt.ParticleFile("a.npz"))["cmap"] == "viridis"

"""Scene files, written: a Scene to TOML, and arrays of spheres to an .npz beside it."""

import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import tomli_w
from msgspec.structs import fields, replace

from clrt.errors import RequestError
from clrt.files.image import check_file, written_whole
from clrt.film import color
from clrt.particles.particlefile import ParticleFile
from clrt.scene.mesh import Mesh
from clrt.scene.scene import Scene
from clrt.scene.spheres import Sphere, Spheres

NUMBERS = re.compile(r"\[\s+((?:[-+.\w]+,\s+)+)\]")
"""A list of numbers, one a line, as tomli_w has them."""


def save_scene(path: str | Path, scene: Scene) -> None:
    """Writes a scene file. Rendered at the same size and precision it gives the same picture.

    Files of particles stay where they are, and the scene names them from its folder. Many spheres
    (clrt.Spheres) go into an .npz file of the same name beside it.

    Raises:
        RequestError: the name does not end in .toml, or the file cannot be there.
        OutputError: it could not be written.
    """
    path = Path(path)
    arrays = path.with_suffix(".npz")
    check_scene(path)
    placed = [replace(one, file=_from(path.parent, one.file)) for one in scene.particles]
    spheres: Sequence[Sphere] = scene.spheres
    if isinstance(spheres, Spheres) and (columns := _columns(spheres)):
        check_file(arrays)
        with written_whole(arrays) as beside, beside.open("wb") as file:
            np.savez(file, **columns)
        opacity = "opacity" if "opacity" in columns else None
        material = (spheres.names or ("",))[0]
        placed.insert(0, ParticleFile(arrays.name, material=material, opacity=opacity))
        spheres = ()
    text = NUMBERS.sub(
        _one_line, tomli_w.dumps(_plain(replace(scene, spheres=spheres, particles=placed)))
    )
    with written_whole(path) as beside:
        beside.write_text(text, encoding="utf-8")


def check_scene(path: Path) -> None:
    """Finds out whether a scene file could be written there.

    Raises:
        RequestError: it could not.
    """
    if path.suffix != ".toml":
        raise RequestError(f"{path}: expected a name that ends in .toml")
    check_file(path)


def _from(folder: Path, file: str) -> str:
    """A file's name from a folder."""
    return file if os.path.isabs(file) else os.path.relpath(file, folder)


def _columns(spheres: Spheres) -> dict[str, Any] | None:
    """Arrays of an .npz file that are read as these spheres, to the bit; None if there are none."""
    columns = {"positions": spheres.center, "radii": spheres.radius}
    if len(spheres.names or ()) != 1 or len(spheres) == 0:
        return None
    if spheres.opacity is not None:
        columns["opacity"] = spheres.opacity
    if spheres.color is None:
        return columns
    with np.errstate(invalid="ignore"):
        srgb = color.to_srgb_and_back(spheres.color.astype(np.float64))
        inside = ((srgb >= 0) & (srgb <= 1)).all()
    same = inside and np.array_equal(color.linear(srgb), spheres.color)
    return columns | {"colors": srgb} if same else None


def _plain(value: Any) -> Any:
    """Tables, lists and values, without those that are the defaults."""
    if isinstance(value, msgspec.Struct):
        tag = value.__struct_config__.tag
        table = {} if tag is None else {"type": tag}
        for field in fields(value):
            given = getattr(value, field.encode_name)
            if given is not None and not _is_default(field, given):
                table[field.name] = _plain(given)
        return table
    if isinstance(value, Mesh):
        keys = ("vertices", "faces", "normals", "colors", "material", "shading")
        given = {key: getattr(value, key) for key in keys}
        return {key: _plain(one) for key, one in given.items() if one is not None}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, dict):
        return {name: _plain(one) for name, one in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_plain(one) for one in value]
    return value


def _is_default(field: Any, given: Any) -> bool:
    if field.default_factory is not msgspec.NODEFAULT:
        return bool(given == field.default_factory())
    return bool(given == field.default)


def _one_line(found: re.Match[str]) -> str:
    return f"[{', '.join(found[1].replace(',', ' ').split())}]"

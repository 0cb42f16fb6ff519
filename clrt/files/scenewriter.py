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
from clrt.files.meshes.ply import NORMALS
from clrt.film import color
from clrt.particles.particlefile import ParticleFile
from clrt.scene.capsules import Capsule, Capsules
from clrt.scene.mesh import Mesh
from clrt.scene.scene import Scene
from clrt.scene.spheres import Sphere, Spheres
from clrt.values import Array

NUMBERS = re.compile(r"\[\s+((?:[-+.\w]+,\s+)+)\]")
"""A list of numbers, one a line, as tomli_w has them."""


INLINE_FACES = 100
"""Meshes of more faces go into files of their own."""


def save_scene(path: str | Path, scene: Scene) -> None:
    """Writes a scene file. Rendered at the same size and precision it gives the same picture.

    Files of particles stay where they are, and the scene names them from its folder. Many spheres
    (clrt.Spheres) go into an .npz file of the same name beside it, many capsules (clrt.Capsules)
    into a .capsules.npz, large meshes into .ply files.

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
    capsules = _capsules(path, scene.capsules)
    inline = () if capsules else scene.capsules
    tables = (
        _plain(replace(scene, spheres=spheres, particles=placed, meshes=(), capsules=inline))
        | capsules
    )
    if scene.meshes:
        tables["meshes"] = [_mesh(path, k, mesh) for k, mesh in enumerate(scene.meshes)]
    text = NUMBERS.sub(_one_line, tomli_w.dumps(tables))
    with written_whole(path) as beside:
        beside.write_text(text, encoding="utf-8")


def _capsules(path: Path, capsules: Sequence[Capsule]) -> dict[str, Any]:
    """The table of many capsules, which go into a file beside the scene's; {} of others."""
    if not isinstance(capsules, Capsules) or not len(capsules):
        return {}
    columns = {name: getattr(capsules, name) for name in ("start", "end", "radius")}
    columns["material"] = np.array(capsules.names)[capsules.material_index]
    if capsules.color is not None:
        columns["color"] = capsules.color
    file = path.with_suffix(".capsules.npz")
    check_file(file)
    with written_whole(file) as beside, beside.open("wb") as opened:
        np.savez(opened, **columns)
    return {"capsules": [{"file": file.name}]}


def _mesh(path: Path, k: int, mesh: Mesh) -> dict[str, Any]:
    """The table of a scene's mesh k. A large one goes into a file beside the scene's."""
    looks = {"material": mesh.material, "shading": mesh.shading}
    if len(mesh) > INLINE_FACES and (content := _ply(mesh)) is not None:
        file = path.with_suffix(f".{k}.ply")
        check_file(file)
        with written_whole(file) as beside:
            beside.write_bytes(content)
        return {"file": file.name, **looks}
    arrays = {key: getattr(mesh, key) for key in ("vertices", "faces", "normals", "colors")}
    return {key: one.tolist() for key, one in arrays.items() if one is not None} | looks


def _ply(mesh: Mesh) -> bytes | None:
    """A binary .ply file that is read as this mesh, to the bit; None if there is none."""
    srgb = None if mesh.colors is None else _srgb(mesh.colors)
    if mesh.colors is not None and srgb is None:
        return None
    vertices: list[tuple[Sequence[str], Array]] = [("xyz", mesh.vertices)]
    if mesh.normals is not None:
        vertices.append((NORMALS, mesh.normals))
    faces: list[tuple[Sequence[str], Array]] = []
    if srgb is not None:
        (vertices if mesh.has_vertex_colors else faces).append((("red", "green", "blue"), srgb))
    lengths = np.full(len(mesh), 3, np.uint8)
    header, parts = ["ply", "format binary_little_endian 1.0"], []
    for element, rows, given in (
        ("vertex", len(mesh.vertices), vertices),
        ("face", len(mesh), [(("",), lengths), (("vertex_indices",), mesh.faces), *faces]),
    ):
        header.append(f"element {element} {rows}")
        fields = [
            (str(k), array.dtype.newbyteorder("<"), array.shape[1:])
            for k, (_, array) in enumerate(given)
        ]
        table = np.empty(rows, fields)
        for k, (names, array) in enumerate(given):
            table[str(k)] = array
            if array is mesh.faces:
                header.append("property list uchar int vertex_indices")
            elif array is not lengths:
                kind = "float" if array.dtype == np.float32 else "double"
                header += [f"property {kind} {name}" for name in names]
        parts.append(table.tobytes())
    return "\n".join([*header, "end_header\n"]).encode() + b"".join(parts)


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
    srgb = _srgb(spheres.color)
    return None if srgb is None else columns | {"colors": srgb}


def _srgb(colors: Array) -> Array | None:
    """Colours as files have them that are read as these, to the bit; None if there are none."""
    with np.errstate(invalid="ignore"):
        found = color.to_srgb_and_back(colors.astype(np.float64))
        inside = ((found >= 0) & (found <= 1)).all()
    return found if inside and np.array_equal(color.linear(found), colors) else None


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

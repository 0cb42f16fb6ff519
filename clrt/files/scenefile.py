"""Scene files: TOML to Scene, with errors that name file, key and what was expected."""

import os
import re
import tomllib
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeVar
from zipfile import BadZipFile

import msgspec
import numpy as np
from msgspec.structs import replace

from clrt import storage
from clrt.errors import RequestError, SceneError, SceneWarning
from clrt.files.meshes.reader import is_mesh, read_mesh
from clrt.files.particles.suffix import is_particles, reads_it
from clrt.particles.particlefile import ParticleFile
from clrt.scene.animation import Animation
from clrt.scene.camera import Camera
from clrt.scene.capsules import Capsule, Capsules
from clrt.scene.film import Film
from clrt.scene.light import LIGHT_KINDS, PointLight
from clrt.scene.material import Material
from clrt.scene.mesh import Mesh, Shading
from clrt.scene.scene import Scene
from clrt.scene.spheres import Sphere
from clrt.values import Vec3, did_you_mean, frozen

T = TypeVar("T")
MAX_FILE_BYTES = 64 << 20  # bytes: half a million spheres, which take ten seconds to read

# tomllib takes a time that grows with the square of a dotted key's parts.
PARTS = 50
LONG_KEY = re.compile(
    rf"""(?<![\w"'-])(?:(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){{{PARTS}}}"""
)


class MeshTable(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A mesh as a scene file has it."""

    material: str
    file: str | None = None
    """From the scene file's folder. Or the following."""
    vertices: list[Vec3] | None = None
    faces: list[tuple[int, int, int]] | None = None
    normals: list[Vec3] | None = None
    colors: list[Vec3] | None = None
    """Linear RGB, one a vertex or one a face."""
    shading: Shading | None = None


class TOMLError(SceneError):
    """A text that is no TOML."""


def builtin_scenes() -> list[str]:
    """The names of the scenes that come with clrt."""
    return sorted(path.stem for path in storage.folder("scenes").glob("*.toml"))


def load_scene(source: str | Path) -> Scene:
    """Reads a scene file.

    Args:
        source: the name of a built-in scene, or a path to a TOML file.

    Raises:
        SceneError: it cannot be read, or is not a scene.
    """
    name = str(source)
    path = Path(source)
    if name in builtin_scenes():
        path = storage.folder("scenes") / f"{name}.toml"
    elif path.is_file() and is_mesh(path):
        raise SceneError(f"{name}: is a mesh, expected a scene: clrt render draws it")
    elif path.is_file() and is_particles(path):
        expected = "is a file of particles, expected a scene: clrt.plot and clrt render draw it"
        raise SceneError(f"{name}: {expected}")
    try:
        text = _read(path)
    except FileNotFoundError:
        known = ", ".join(builtin_scenes())
        raise SceneError(f"{name}: no such file, nor a built-in scene ({known})") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise SceneError(f"{name}: cannot be read: {reason}") from None
    try:
        scene = parse_scene(text.decode("utf-8-sig"), path.parent)
        for doubt in doubts(scene):
            warnings.warn(f"{name}: {doubt}", SceneWarning, stacklevel=2)
        return _placed(scene, path.parent)
    except UnicodeDecodeError:
        said = "expected UTF-8 text" if path.suffix == ".toml" else reads_it(path)
        raise SceneError(f"{name}: {said}") from None
    except TOMLError as error:
        said = str(error) if path.suffix == ".toml" else reads_it(path)
        raise SceneError(f"{name}: {said}") from None
    except SceneError as error:
        raise SceneError(f"{name}: {error}") from None


def doubts(scene: Scene) -> Iterator[str]:
    """What a scene can say but hardly means."""
    for name, material in scene.materials.items():
        for key in ("ambient", "diffuse", "specular"):
            if max(getattr(material, key)) > 1:
                found = list(getattr(material, key))
                yield f"materials.{name}.{key}: {found} is over 1: colours are from 0 to 1"
    if max(scene.film.background) > 1:
        found = list(scene.film.background)
        yield f"film.background: {found} is over 1: colours are from 0 to 1"
    if not scene.lights and any(
        map(len, (scene.spheres, scene.capsules, scene.meshes, scene.particles))
    ):
        yield "there are no [[lights]]: all that is there is black"


def as_scene(source: Scene | str | Path) -> Scene:
    """The scene itself, or the one that load_scene() reads.

    Raises:
        SceneError: it is neither.
    """
    if isinstance(source, Scene):
        return source
    if isinstance(source, str | Path):
        return load_scene(source)
    raise SceneError(f"scene: expected a Scene, a name or a path, got {type(source).__name__}")


def _placed(scene: Scene, folder: Path) -> Scene:
    """The scene, with the names of files that it gives from its folder."""
    if not scene.particles:
        return scene
    placed = [replace(one, file=str(folder / one.file)) for one in scene.particles]
    return replace(scene, particles=placed)


def _read(path: Path) -> bytes:
    # So a pipe that nobody writes to is empty, where to open it would wait for a writer.
    file = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    os.set_blocking(file, True)
    with open(file, "rb") as opened:
        text = opened.read(MAX_FILE_BYTES + 1)
    if len(text) > MAX_FILE_BYTES:
        raise ValueError(f"expected at most {MAX_FILE_BYTES >> 20} MB of TOML")
    return text


def parse_scene(text: str, folder: Path = Path()) -> Scene:
    """Makes a scene of TOML text. Files of meshes are read, from that folder; those of particles
    are named as in the text.

    Raises:
        SceneError: naming the key and what was expected.
    """
    if found := LONG_KEY.search(text):
        line = text.count("\n", 0, found.start()) + 1
        raise TOMLError(f"not TOML that is read: line {line} has a key of over {PARTS} parts")
    try:
        tables = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # of TOML, and of numbers and nesting beyond it
        raise TOMLError(f"not TOML: {error}") from None
    materials = tables.get("materials")
    if isinstance(materials, dict):
        # msgspec does not say in which entry of a dict an error lies.
        for name, table in materials.items():
            _convert(table, Material, f"materials.{name}")
    if isinstance(tables.get("lights"), list):
        tables["lights"] = [_light(table, i) for i, table in enumerate(tables["lights"])]
    if isinstance(tables.get("meshes"), list):
        tables["meshes"] = [_mesh(table, i, folder) for i, table in enumerate(tables["meshes"])]
    listed = tables.get("capsules")
    if not (isinstance(listed, list) and any(map(_is_in_file, listed))):
        return _convert(tables, Scene, "")
    del tables["capsules"]
    parts = [_capsules(table, f"capsules[{i}]", folder) for i, table in enumerate(listed)]
    return replace(_convert(tables, Scene, ""), capsules=Capsules.joined(parts))


def parse_camera(text: str) -> Camera:
    """Makes a camera of the keys of a scene file's [camera], with commas between them.

    Raises:
        SceneError: naming the key and what was expected.
    """
    try:
        tables = tomllib.loads(f"camera = {{ {text} }}")
    except (ValueError, RecursionError) as error:
        raise SceneError(f"not TOML: {error}") from None
    return _convert(tables["camera"], Camera, "camera")


def _light(table: Any, i: int) -> Any:
    """A light's table with its kind, and without keys of other kinds."""
    if not isinstance(table, dict):
        return table
    kind = table.get("type", "point")
    fields = {k.__struct_config__.tag: k.__struct_fields__ for k in LIGHT_KINDS}
    where = f"lights[{i}]"
    if not isinstance(kind, str) or kind not in fields:
        *most, last = map(repr, fields)
        raise SceneError(f"{where}.type: expected {', '.join(most)} or {last}, got {kind!r}")
    for key in set(table) - {"type", *fields[kind]}:
        if having := [repr(other) for other in fields if key in fields[other]]:
            kinds = " and ".join(having)
            raise SceneError(f"{where}.{key}: expected in lights of type {kinds}, not {kind!r}")
    return {**table, "type": kind}


def _mesh(table: Any, i: int, folder: Path) -> Mesh:
    """The mesh of a table."""
    where = f"meshes[{i}]"
    given = _convert(table, MeshTable, where)
    if given.file is not None:
        for key in ("vertices", "faces", "normals", "colors"):
            if getattr(given, key) is not None:
                raise SceneError(f"{where}.{key}: expected none beside file")
        try:
            return read_mesh(folder / given.file, given.material, given.shading)
        except RequestError as error:
            raise SceneError(f"{where}.file: {error}") from None
    if given.vertices is None or given.faces is None:
        raise SceneError(f"{where}: expected file, or vertices and faces")
    try:
        return Mesh(
            np.array(given.vertices).reshape(-1, 3),
            np.array(given.faces).reshape(-1, 3),
            given.normals,
            given.colors,
            given.material,
            given.shading,
        )
    except SceneError as error:
        raise SceneError(f"{where}.{error}") from None


def _is_in_file(table: Any) -> bool:
    return isinstance(table, dict) and "file" in table


def _capsules(table: Any, where: str, folder: Path) -> Capsules:
    """The capsules of a table: its own, or those of an .npz file, whose arrays are the arguments of
    clrt.Capsules."""
    if not _is_in_file(table):
        return Capsules.of([_convert(table, Capsule, where)])
    for key in table.keys() - {"file"}:
        raise SceneError(f"{where}.{key}: expected none beside file")
    path = folder / str(table["file"])
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            given = {name: frozen(arrays[name]) for name in arrays.files}
        return Capsules(**given)
    except (OSError, EOFError, ValueError, TypeError, AttributeError, BadZipFile) as error:
        said = error.strerror if isinstance(error, OSError) else error
        expected = "an .npz file of start, end, radius, material and color"
        raise SceneError(f"{where}.file: {path}: expected {expected}: {said}") from None


def _convert(tables: Any, kind: type[T], path: str) -> T:
    try:
        return msgspec.convert(tables, kind)
    except msgspec.ValidationError as error:
        raise SceneError(_located(str(error), path)) from None


def _located(message: str, path: str) -> str:
    """Turns msgspec's "what - at `$.where`" into "where: what"."""
    at = message.rfind(" - at `$")
    if at >= 0:
        path += message[at + 8 : -1]
        message = message[:at]
    if found := re.match(
        r"Object (contains unknown|missing required) field `(.*)`", message, re.DOTALL
    ):
        path += "." + (found[2] or '""')
        is_unknown = found[1] == "contains unknown"
        message = f"unknown key{_hint(path)}" if is_unknown else "expected a value, got none"
    elif found := re.match(r"([\w.\[\]]+): (expected .*)", message):  # one of scene.py's own
        path += f".{found[1]}"
        message = found[2]
    return f"{path.lstrip('.')}: {message[0].lower()}{message[1:]}"


TABLES: tuple[tuple[str, str, type[msgspec.Struct]], ...] = (
    ("", "at the top, before the first [table]", Scene),
    ("camera", "in [camera]", Camera),
    ("film", "in [film]", Film),
    ("materials", "in [materials.NAME]", Material),
    ("lights", "in [[lights]]", PointLight),
    ("spheres", "in [[spheres]]", Sphere),
    ("capsules", "in [[capsules]]", Capsule),
    ("meshes", "in [[meshes]]", MeshTable),
    ("particles", "in [[particles]]", ParticleFile),
    ("animation", "in [animation]", Animation),
)
"""What the path of each begins with, and where its keys stand."""


def _hint(path: str) -> str:
    """Where an unknown key belongs, or which one is meant: after a table's header every key is one
    of that table."""
    first, key = re.split(r"[.\[]", path.lstrip("."))[0], path.rpartition(".")[2]
    if "." not in path.lstrip("."):
        first = ""
    own = [name for start, _, kind in TABLES if start == first for name in kind.__struct_fields__]
    if near := did_you_mean(key, own):
        return near
    homes = [
        place for start, place, kind in TABLES if key in kind.__struct_fields__ and start != first
    ]
    return f": it belongs {' or '.join(homes)}" if homes else ""

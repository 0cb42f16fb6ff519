"""Sources: a file of particles as the scene that shows it."""

from pathlib import Path
from typing import Any

from msgspec.structs import replace

from clrt.errors import RequestError, named
from clrt.figure import compose, surfaces
from clrt.figure.compose import Look
from clrt.files.particles.reader import read
from clrt.particles.particlefile import ParticleFile
from clrt.scene.scene import Scene


def look(**given: Any) -> Look:
    """How particles are drawn. None is as if the option was not given.

    Raises:
        RequestError: a key is wrong, or the mesh cannot be read.
    """
    source, color, opacity = (given.pop(f"mesh{end}", None) for end in ("", "_color", "_opacity"))
    if source is not None:
        cmap, clim = given.get("cmap"), given.get("clim")
        given["mesh"] = surfaces.read(source, color, opacity, cmap, clim)
    elif color is not None or opacity is not None:
        raise RequestError("mesh: expected one beside its colour and opacity, got none")
    return Look(**{key: value for key, value in given.items() if value is not None})


def mesh_look(path: Path, **given: Any) -> Look:
    """How a file of a mesh alone is drawn, for compose.mesh_scene().

    Raises:
        RequestError: as look(), or another mesh was given.
    """
    if given.get("mesh") is not None:
        raise RequestError(f"mesh: expected a file of particles, {path} is a mesh")
    return look(**{**given, "mesh": path})


def of_mesh(path: Path, **given: Any) -> Scene:
    """The scene that shows a mesh alone.

    Raises:
        RequestError: as mesh_look(), or something was given that is of particles.
    """
    return compose.mesh_scene(mesh_look(path, **given))


def of_file(path: Path, frame: int, look: Look, **reading: Any) -> Scene:
    """The scene that shows a frame of a file, with its particles as spheres.

    Args:
        reading: other arguments of clrt.read().

    Raises:
        RequestError: it cannot be read, or lacks a quantity that is to be drawn; it names the file.
        OutputError: it does not fit into memory.
    """
    particles = read(path, frame, **reading)
    with named(path):
        return compose.scene(particles, look)


def in_file(scene: Scene, path: Path, frame: int, look: Look) -> Scene:
    """The same scene, but its particles stay in their file."""
    one = ParticleFile(str(path), frame, **look.coloring)
    # The particles will add these again.
    film = replace(
        scene.film,
        **dict.fromkeys(("cells", "legend", "labels"), ()),
        **dict.fromkeys(("colorbar_cmap", "colorbar_clim", "axes_edges"), None),
        label=look.label,
        colorbar_ends=(False, False),
    )
    return replace(scene, spheres=(), capsules=(), particles=(one,), film=film)

"""Cluster: a frame of an animation by itself, on any of many machines."""

import hashlib
import importlib.metadata
import os
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

import msgspec

from clrt.errors import RequestError
from clrt.figure.compose import Look
from clrt.figure.rendering import Renderer
from clrt.files import image, numbered
from clrt.files.particles.suffix import is_particles
from clrt.files.scenefile import load_scene
from clrt.motion.animation import Frames, Way
from clrt.motion.surfaces import Surfaces, are_meshes
from clrt.motion.trajectory import Flow
from clrt.opencl.device import target
from clrt.renderer.pack.structs import Precision
from clrt.scene.mesh import Mesh
from clrt.scene.rows import Rows
from clrt.scene.scene import Scene


def render_frame(
    source: Scene | str | Path,
    frame: int,
    out_pattern: str | Path,
    *,
    width: int = 1920,
    height: int = 1080,
    precision: Precision = "robust",
    lanes: int | None = None,
    device: str | None = None,
    threads: int | None = None,
    resume: bool = False,
    **look: Any,
) -> Path:
    """Renders one frame of an animation to a numbered picture, as `clrt animate` does.

    Arguments and result can be pickled, so that Dask, submitit or multiprocessing can call it
    (docs/cluster.md). It may be called again, as after a worker was lost: the picture is the same,
    and is there whole or not at all. A process keeps the device, compiled programs and the last
    scene for its next call.

    Args:
        source: a scene with an animation: the name of a built-in one, the path of a scene file that
            all machines can read, or a Scene. Or the path of a trajectory of particles.
        frame: the number of the frame.
        out_pattern: the pictures' name, #### where the number goes; the suffix chooses the format.
        width, height: pixels.
        precision, lanes, device, threads: as for Renderer.
        resume: whether a picture that is there already, whole and of this kind, is left.
        look: how the particles of a trajectory are drawn: fields of clrt.figure.Look.

    Returns:
        The picture's path.

    Raises:
        SceneError: there is no such scene, it has no animation, or no camera can be at this frame.
        RequestError: there is no such frame, or no such picture can be; or the pictures that are
            there were made otherwise, of another size, with other lanes or for another CPU.
        OutputError: it could not be written, or does not fit into memory.
        DeviceError: there is no such device, or it fails.
    """
    pattern = Path(out_pattern)
    numbered.check_pattern(pattern)
    way, of_scene = _opened(source, size=(width, height), **look)
    way.check([frame])
    path, scene = numbered.picture(pattern, frame), way.scene(frame)
    image.check_output(path, width, height, alpha=scene.film.transparent)
    dtype = image.film_dtype(path)
    renderer = _renderer(precision, lanes, device, threads)
    renderer.prepare(scene, dtype)
    made = numbered.join(
        pattern, kind(of_scene, width, height, renderer), way.fps, way.frames, adds=True
    )
    if not (resume and made.is_made(path)):
        picture = renderer.render(scene, width, height, dtype=dtype)
        image.save(path, picture, transfer=scene.film.transfer)
    return path


def kind(of_scene: str, width: int, height: int, renderer: Renderer) -> numbered.Kind:
    """The common ground of a renderer's pictures of a scene, whose fingerprint() is given."""
    return numbered.Kind(
        of_scene,
        (width, height),
        renderer.precision,
        renderer.lanes,
        target(renderer.device),
        importlib.metadata.version("clrt"),
    )


def fingerprint(scene: Scene) -> str:
    """A hash of all that a scene says, the same on every machine."""

    def plain(value: Any) -> Any:
        """Values of the types that msgspec does not know, in plain ones."""
        if isinstance(value, Rows):
            return [value.names, value.material_index, *(getattr(value, a) for a in value.ARRAYS)]
        if isinstance(value, Mesh):
            arrays = value.vertices, value.faces, value.normals, value.colors
            return value.material, value.shading, value.has_vertex_colors, arrays
        return value.dtype.str, value.shape, value.tobytes()

    return hashlib.sha256(msgspec.json.encode(scene, enc_hook=plain)).hexdigest()[:16]


def _opened(source: Scene | str | Path, **look: Any) -> tuple[Frames, str]:
    """A scene's frames, or a trajectory's, and a hash of the scene."""
    if isinstance(source, Scene):
        return Way(source), fingerprint(source)
    state: tuple[int, ...] = ()
    with suppress(OSError):  # it is a built-in scene, or an error
        file = os.stat(source)
        state = file.st_dev, file.st_ino, file.st_mtime_ns
    if are_meshes([str(source)]):
        way = Surfaces([str(source)], **look)
        return way, fingerprint(way.said)
    if is_particles(Path(source)):
        return _flow(Path(source), Look(**look), state)
    del look["size"]
    if look:
        expected = f"a trajectory of particles, {source} is a scene"
        raise RequestError(f"{next(iter(look))}: expected {expected}")
    return _read(str(source), state)


@lru_cache(maxsize=1)
def _read(name: str, state: tuple[int, ...]) -> tuple[Frames, str]:
    """A scene file's. `state` tells another file, or a changed one, of the same name."""
    return _opened(load_scene(name))


@lru_cache(maxsize=1)
def _flow(path: Path, look: Look, state: tuple[int, ...]) -> tuple[Frames, str]:
    """A trajectory's, as of _read()."""
    flow = Flow(path, look)
    return flow, fingerprint(flow.said)


@lru_cache
def _renderer(
    precision: Precision, lanes: int | None, device: str | None, threads: int | None
) -> Renderer:
    return Renderer(precision=precision, lanes=lanes, device=device, threads=threads)

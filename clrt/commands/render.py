"""clrt render: a picture of a scene, or of particles."""

import resource
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from clrt.commands.groups import Grouped
from clrt.commands.loading import Kind, changed, kind_of, opened
from clrt.commands.options import (
    RenderingOptions,
    film_options,
    rendering_options,
    scene_options,
)
from clrt.commands.particles import (
    PARTICLE_KEYS,
    only_for_particles,
    particle_options,
    reading_options,
)
from clrt.commands.picture import Picture, asked
from clrt.commands.terminal import say
from clrt.errors import RequestError, SceneError, called, named

if TYPE_CHECKING:
    from clrt.figure.compose import Look
    from clrt.renderer.checks import Region
    from clrt.scene.camera import Camera
    from clrt.scene.scene import Scene

USUAL_SIZE: dict[Kind, tuple[int, int]] = {
    "mesh": (1920, 1080),
    "particles": (1920, 1080),
    "scene": (3840, 2160),
}


@click.command(cls=Grouped)
@click.pass_context
@click.argument("scene", default="four-spheres")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="PATH",
    help="Default <scene>.png here. 8-bit .png .jpg .webp .tif .bmp .ppm; .svg and .pdf with words "
    "as such (need clrt[text]); linear float32 .npy .npz .pfm .exr.",
)
@click.option(
    "--width",
    type=click.IntRange(min=1),
    metavar="N",
    help="Default: 3840, of particles 1920.",
)
@click.option(
    "--height",
    type=click.IntRange(min=1),
    metavar="N",
    help="Default: 2160, of particles 1080.",
)
@click.option(
    "--region",
    type=int,
    nargs=4,
    metavar="X0 Y0 X1 Y1",
    help="Only the columns from X0 to before X1 and rows from Y0, counted from the top, to before "
    "Y1 of the picture.",
)
@scene_options
@film_options
@click.option(
    "--passes",
    metavar="NAMES",
    help="Some of depth,normal,id beside the picture, for .npz and .exr.",
)
@click.option(
    "--bits",
    type=click.Choice(["8", "16"]),
    callback=lambda context, option, text: text and int(text),
    help="Of a channel; 16 for .png and .tif. Default: 8, or the format's float32.",
)
@rendering_options
@particle_options
@click.option(
    "--frame",
    type=int,
    metavar="N",
    help="Of a file of particles, counted from 0, -1 for the last; default: 0.",
)
@reading_options
@click.option(
    "--output-format",
    metavar="NAME",
    help="Of a picture that goes to stdout (-o -): png, jpg, ...; default: png.",
)
@click.option(
    "--save-scene",
    type=click.Path(path_type=Path),
    metavar="PATH",
    help="Also write the scene of the particles, a .toml that draws the same picture.",
)
@click.option("-v", "--verbose", is_flag=True, help="Say where time and memory go.")
def render(
    context: click.Context,
    scene: str,
    output: Path | None,
    width: int | None,
    height: int | None,
    region: "Region | None",
    changes: dict[str, Any],
    film: dict[str, Any],
    passes: str | None,
    bits: int | None,
    rendering: RenderingOptions,
    drawn: dict[str, Any],
    frame: int | None,
    reading: dict[str, str],
    output_format: str | None,
    save_scene: Path | None,
    verbose: bool,
) -> None:
    """Renders SCENE: a file of particles (see 'clrt formats'), a mesh (.stl, .obj, .ply with
    faces), a TOML file, or a built-in scene's name; default: four-spheres.

    \b
    Examples:
      clrt render atoms.xyz -o atoms.png
      clrt render protein.pdb --hide water --color chain
      clrt render flow.dump --frame 3 --color speed --colorbar "speed (m/s)"
      clrt render salt.xyz --radius Na=1.0,Cl=1.8 --colors Na=gold,Cl=teal --colorbar ions
      clrt render salt.xyz --select "0 < z < 3" --view z --zoom 2 --cell
      zcat flow.dump.gz | clrt render - --format dump --frame -1 -o - > last.png
      clrt render cell.dump --mesh walls.stl --mesh-opacity 0.3
      clrt render surface.ply --mesh-color curvature
      clrt render my.toml -o my.png --width 1920 --height 1080

    Expressions are Python's over columns ('clrt check FILE' lists them): comparisons, and, or, not,
    in, arithmetic, abs, sqrt, log10, min, max, text in quotes. The headings from "Which particles"
    to "Where they are seen from" are for files of particles.
    """
    started = time.perf_counter()
    kind = kind_of(scene, reading)
    if kind == "mesh" and frame is not None:
        raise RequestError(f"--frame: expected a file of particles, {scene} is a mesh")
    if kind == "scene":
        only_for_particles(scene, **drawn, **reading, frame=frame, save_scene=save_scene)
    usual = USUAL_SIZE[kind]
    size = width or usual[0], height or usual[1]
    picture = asked(scene, output, output_format, size, region, passes, bits)
    look = {"samples": rendering.samples, **film}
    drawing, command = None, ""  # of particles none: made by clrt.plot it is the same file
    if kind == "scene":
        loaded, command = _scene(scene, look, context.obj)
    else:
        look |= {"size": size, **drawn}
        loaded, drawing = _figure(Path(scene), kind, frame or 0, look, reading)
        loaded = _seen_by(loaded, changes["camera"])
    loaded = changed(loaded, **changes)
    picture.check(loaded)
    if save_scene is not None:
        _save_scene(save_scene, loaded, Path(scene), frame or 0, drawing, reading)
    _make(picture, loaded, rendering, command, verbose, started)


def _scene(name: str, look: dict[str, Any], command: str) -> "tuple[Scene, str]":
    """A scene, and the command that its picture names: none if particles are in it."""
    from clrt.figure.resolver import resolved

    loaded = opened(name, **look)
    with named(name, SceneError):
        return resolved(loaded), "" if loaded.particles else command


def _figure(
    path: Path, kind: Kind, frame: int, look: dict[str, Any], reading: dict[str, str]
) -> "tuple[Scene, Look | None]":
    """The scene of a file of particles, and how they are drawn, or of a mesh alone."""
    from clrt.figure import sources

    with called(PARTICLE_KEYS):
        if kind == "mesh":
            return sources.of_mesh(path, **look), None
        drawing = sources.look(**look)
        return sources.of_file(path, frame, drawing, **reading), drawing


def _seen_by(figure: "Scene", camera: "Camera | None") -> "Scene":
    """A figure as another camera sees it, if there is one."""
    if camera is None:
        return figure
    from clrt.figure.styles import seen_by

    return seen_by(figure, camera)


def _save_scene(
    output: Path,
    scene: "Scene",
    path: Path,
    frame: int,
    drawing: "Look | None",
    reading: dict[str, str],
) -> None:
    """Writes the scene of a file: particles stay in it.

    Raises:
        RequestError: a scene cannot say how the file is read, or would stand in its place.
    """
    from clrt.figure import sources
    from clrt.files import scenewriter
    from clrt.files.image import check_apart

    check_apart(output, path)
    if "format" in reading or str(path) == "-":
        raise RequestError("--save-scene: expected a file whose name tells its format")
    if reading:
        option = next(iter(reading))
        raise RequestError(f"--save-scene: expected no --{option}: a scene cannot say it")
    said = scene if drawing is None else sources.in_file(scene, path, frame, drawing)
    scenewriter.save_scene(output, said)


def _make(
    picture: Picture,
    scene: "Scene",
    rendering: RenderingOptions,
    command: str,
    verbose: bool,
    started: float,
) -> None:
    """Renders a picture, writes it, and says how long that took.

    Args:
        command: the one that the file names.
        started: when the process's work began, as time.perf_counter() tells it.
    """
    from clrt.opencl.device import label

    ready = time.perf_counter()
    with rendering.renderer() as renderer:
        if verbose:
            say(f"{label(renderer.device)}, {renderer.lanes} lanes, {renderer.precision}")
        renderer.prepare(scene, picture.dtype, passes=picture.passes)
        compiled = time.perf_counter()
        image, how = picture.made(renderer, scene, rendering.quiet)
        rendered = time.perf_counter()
        if verbose:
            say(
                f"imports and scene {ready - started:.3f} s, device and kernel "
                f"{compiled - ready:.3f} s, picture {rendered - compiled:.3f} s (kernel "
                f"alone {renderer.kernel_seconds:.4f} s)"
            )
    picture.write(image, transfer=scene.film.transfer, command=command, **how)
    if verbose:
        say(f"file {time.perf_counter() - rendered:.3f} s, peak memory {_peak_memory()} MB")
    if not rendering.quiet:
        columns, rows = picture.size
        say(f"{picture.output}: {columns}x{rows}, rendered in {rendered - compiled:.3f} s")


def _peak_memory() -> int:
    """The most memory that this process has had, MB."""
    status = Path("/proc/self/status")
    if status.exists():
        # getrusage() counts what the process had that started this one.
        return int(status.read_text().split("VmHWM:")[1].split()[0]) // 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024

"""clrt render: a picture of a scene, or of particles."""

import resource
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from clrt.commands.groups import Grouped
from clrt.commands.loading import changed, opened
from clrt.commands.options import (
    RenderingOptions,
    film_options,
    rendering_options,
    scene_options,
    stem_of,
)
from clrt.commands.particles import (
    PARTICLE_KEYS,
    only_for_particles,
    particle_options,
    reading_options,
)
from clrt.commands.terminal import Progress, say
from clrt.errors import RequestError, SceneError, called, named

if TYPE_CHECKING:
    from clrt.figure.compose import Look
    from clrt.renderer.checks import Region
    from clrt.scene.scene import Scene


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
    from clrt.figure import resolver, styles
    from clrt.figure.apart import picture_and_words
    from clrt.files import vector
    from clrt.files.image import check_apart, check_output, check_suffix, film_dtype, save
    from clrt.files.meshes.reader import is_mesh
    from clrt.files.particles.suffix import is_particles
    from clrt.opencl.device import label
    from clrt.renderer.checks import check_passes, check_region, check_size

    output = output or Path(f"{stem_of(scene)}.png")
    if to_stdout := str(output) == "-":
        output = Path(f"stdout.{output_format or 'png'}")
    elif output_format is not None:
        raise RequestError("--output-format: expected -o -: else the suffix tells")
    has_mesh = not reading and is_mesh(Path(scene))
    if has_mesh and frame is not None:
        raise RequestError(f"--frame: expected a file of particles, {scene} is a mesh")
    if has_particles := has_mesh or "format" in reading or is_particles(Path(scene)):
        width, height = width or 1920, height or 1080
    else:
        only_for_particles(scene, **drawn, **reading, frame=frame, save_scene=save_scene)
        width, height = width or 3840, height or 2160
    left, top, right, bottom = check_region(region, *check_size(width, height))
    names = None if passes is None else check_passes(passes.split(","))
    check_suffix(output)
    if (is_vector := output.suffix.lower() in vector.SUFFIXES) and region is not None:
        raise RequestError(f"--region: expected a format of pixels, {output} has words")
    if not to_stdout:
        check_apart(output, Path(scene))
    look = {"samples": rendering.samples, **film}
    drawing = None
    if has_particles:
        look |= {"size": (width, height), **drawn}
        loaded, drawing = _figure(Path(scene), has_mesh, frame or 0, look, reading)
        if changes["camera"] is not None:
            loaded = styles.seen_by(loaded, changes["camera"])
    else:
        loaded = opened(scene, **look)
        has_particles = len(loaded.particles) > 0
        with named(scene, SceneError):
            loaded = resolver.resolved(loaded)
    loaded = changed(loaded, **changes)
    alpha, dtype = loaded.film.transparent, film_dtype(output, bits)
    size = right - left, bottom - top
    check_output(output, *size, alpha=alpha, bits=bits, passes=names is not None)
    if save_scene is not None:
        check_apart(save_scene, Path(scene))
        _save_scene(save_scene, loaded, Path(scene), frame or 0, drawing, reading)
    ready = time.perf_counter()
    with rendering.renderer() as renderer:
        if verbose:
            say(f"{label(renderer.device)}, {renderer.lanes} lanes, {renderer.precision}")
        renderer.prepare(loaded, dtype, passes=names)
        compiled = time.perf_counter()
        how: dict[str, Any]
        with Progress(bottom - top, rendering.quiet) as progress:
            if is_vector:
                image, overlay = picture_and_words(renderer, loaded, width, height, progress.add)
                how = {"overlay": overlay}
            else:
                more: dict[str, Any] = {"dtype": dtype, "passes": names or (), "region": region}
                image, found = renderer.render(loaded, width, height, progress=progress.add, **more)
                how = {"passes": found}
        rendered = time.perf_counter()
        if verbose:
            say(
                f"imports and scene {ready - started:.3f} s, device and kernel "
                f"{compiled - ready:.3f} s, picture {rendered - compiled:.3f} s (kernel "
                f"alone {renderer.kernel_seconds:.4f} s)"
            )
    # Of particles it does not: made by clrt.plot or of another format it is the same file.
    command = "" if has_particles else context.obj
    how |= {"transfer": loaded.film.transfer, "command": command}
    if to_stdout:
        _print(output, image, how)
    else:
        save(output, image, **how)
    if verbose:
        say(f"file {time.perf_counter() - rendered:.3f} s, peak memory {_peak_memory()} MB")
    if not rendering.quiet:
        say(f"{output}: {right - left}x{bottom - top}, rendered in {rendered - compiled:.3f} s")


def _figure(
    path: Path, is_mesh: bool, frame: int, look: dict[str, Any], reading: dict[str, str]
) -> "tuple[Scene, Look | None]":
    """The scene of a file of particles, and how they are drawn, or of a mesh alone."""
    from clrt.figure import sources

    with called(PARTICLE_KEYS):
        if is_mesh:
            return sources.of_mesh(path, **look), None
        drawing = sources.look(**look)
        return sources.of_file(path, frame, drawing, **reading), drawing


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
        RequestError: a scene cannot say how the file is read.
    """
    from clrt.figure import sources
    from clrt.files import scenewriter

    if "format" in reading or str(path) == "-":
        raise RequestError("--save-scene: expected a file whose name tells its format")
    if reading:
        option = next(iter(reading))
        raise RequestError(f"--save-scene: expected no --{option}: a scene cannot say it")
    said = scene if drawing is None else sources.in_file(scene, path, frame, drawing)
    scenewriter.save_scene(output, said)


def _print(output: Path, image: Any, how: dict[str, Any]) -> None:
    """Writes the bytes of a file of that name to stdout."""
    from tempfile import TemporaryDirectory

    from clrt.files.image import save

    with TemporaryDirectory() as folder:
        save(Path(folder) / output, image, **how)
        sys.stdout.buffer.write((Path(folder) / output).read_bytes())


def _peak_memory() -> int:
    """The most memory that this process has had, MB."""
    status = Path("/proc/self/status")
    if status.exists():
        # getrusage() counts what the process had that started this one.
        return int(status.read_text().split("VmHWM:")[1].split()[0]) // 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024

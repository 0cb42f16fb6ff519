"""The command line. What a command needs is imported when it runs: --help stays quick."""

import math
import os
import resource
import shlex
import sys
import time
import warnings
from collections.abc import Sequence
from contextlib import closing, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeVar

import click

from clrt.commands.options import (
    camera_keys,
    film_options,
    frame_options,
    only_for_particles,
    particle_options,
    rendering_options,
    shard_of,
)
from clrt.errors import ClrtError, ClrtWarning, RequestError, SceneError, named

if TYPE_CHECKING:
    from msgspec import Struct
    from tqdm import tqdm

    from clrt.renderer.renderer import Region
    from clrt.scene.scene import Camera, Scene

T = TypeVar("T", bound="Struct")


def say(text: str) -> None:
    """A line on stderr; what a scene file or a file's name says goes there as text only."""
    with suppress(OSError):  # nobody listens
        click.echo("".join(c if c.isprintable() else ascii(c)[1:-1] for c in text), err=True)


def _say_warning(message: Warning | str, category: type[Warning], *where: object) -> None:
    """clrt's own. Nobody at a shell can mend what the libraries warn of."""
    if issubclass(category, ClrtWarning):
        say(f"clrt: {message}")


def _command(words: Sequence[str]) -> str:
    """What a picture says that made it. Not where to: the same picture is the same bytes."""
    kept, rest = ["clrt"], iter(words)
    for word in rest:
        if word in ("-o", "--output"):
            next(rest, None)
        elif not word.startswith(("-o", "--output=")):
            kept.append(word)
    return shlex.join(kept)


class Commands(click.Group):
    """Turns errors into one line on stderr and an exit status."""

    def main(self, *words: Any, **options: Any) -> Any:
        options.setdefault("obj", _command((words or [options.get("args")])[0] or sys.argv[1:]))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("always", ClrtWarning)
                warnings.showwarning = _say_warning  # type: ignore[assignment]
                return super().main(*words, **options)
        except ClrtError as error:
            said, status = str(error), error.exit_status
        except MemoryError:
            said, status = "not enough memory: render it in parts (--region) or smaller", 1
        except OSError as error:
            with suppress(OSError):  # what stdout still holds would fail again at the end
                os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
            said, status = str(error) if error.filename else f"stdout: {error.strerror or error}", 1
        except Exception as error:
            import traceback

            file, line, *_ = traceback.extract_tb(error.__traceback__)[-1]
            said = f"this is a bug in clrt: {error!r} in {file}:{line}"
            status = 1
        say(f"clrt: {said}")
        sys.exit(status)


def changed(given: T, **options: Any) -> T:
    """A scene, or a part of one, with what options say in place of its own values."""
    from msgspec.structs import replace

    try:
        return replace(given, **{key: value for key, value in options.items() if value is not None})
    except ValueError as error:
        raise RequestError(str(error)) from None


def opened(name: str, *, samples: int | None, background: str | None, **film: Any) -> "Scene":
    """A scene with what options say of its samples and its film."""
    from clrt.files.scenefile import load_scene
    from clrt.film import color

    loaded = load_scene(name)
    ground = None if background is None else color.named(background)
    return changed(loaded, samples=samples, film=changed(loaded.film, background=ground, **film))


class Progress:
    """A bar of tqdm's on stderr, for work that takes longer than it takes to import tqdm."""

    def __init__(self, rows: int, quiet: bool) -> None:
        self.total = rows
        self.done = 0
        self.due = math.inf if quiet else time.perf_counter() + 0.3
        self.bar: tqdm[Any] | None = None

    def __enter__(self) -> Self:
        return self

    def add(self, rows: int) -> None:
        self.done += rows
        if self.bar is not None:
            self.bar.update(rows)
        elif time.perf_counter() > self.due:
            from tqdm import tqdm

            self.bar = tqdm(total=self.total, initial=self.done, unit="row", leave=False)

    def __exit__(self, *error: object) -> None:
        if self.bar is not None:
            self.bar.close()


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="clrt")
def main() -> None:
    """Ray traces scenes of spheres through OpenCL.

    \b
    Examples:
      clrt render                                  the paper's scene at 4K
      clrt render my.toml -o my.png --width 1920 --height 1080
      clrt animate                                 a video round that scene
      clrt encode 'frames/####.png' -o my.mp4      a video of numbered pictures
      clrt check my.toml                           is the scene file right?
      clrt compare a.png b.png                     how far apart are two pictures?
      clrt devices                                 where can it run?
    """


@main.command()
@click.pass_context
@click.argument("scene", default="four-spheres")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="PATH",
    help="The picture's file; default <scene>.png here. The suffix chooses the format: "
    "8-bit .png .jpg .webp .tif .bmp .ppm; linear float32, not clipped, .npy .npz .pfm .exr.",
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
    "--max-depth",
    type=click.IntRange(min=1),
    metavar="N",
    help="Ray segments from the camera, 1 for no reflection; default: the scene's.",
)
@click.option(
    "--shadow-bias",
    type=click.FloatRange(min=0),
    metavar="X",
    help="World units, 0 for the exact geometry; default: the scene's.",
)
@click.option(
    "--region",
    type=int,
    nargs=4,
    metavar="X0 Y0 X1 Y1",
    help="Only the columns from X0 to before X1 and rows from Y0, counted from the top, to before "
    "Y1 of the picture.",
)
@click.option(
    "--camera",
    metavar="TOML",
    callback=camera_keys,
    help="In place of the scene's: keys of its table with commas between, as "
    "'position = [0, 1, 3], look_at = [0, 0, 0]'.",
)
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
    type=click.IntRange(min=0),
    metavar="N",
    help="Of a file of particles, counted from 0; default: 0.",
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
    max_depth: int | None,
    shadow_bias: float | None,
    region: "Region | None",
    camera: "Camera | None",
    background: str | None,
    transparent: bool | None,
    transfer: str | None,
    passes: str | None,
    bits: int | None,
    samples: int | None,
    precision: Any,
    lanes: int | None,
    device: str | None,
    threads: int | None,
    quiet: bool,
    frame: int | None,
    save_scene: Path | None,
    verbose: bool,
    **drawn: Any,
) -> None:
    """Renders SCENE, a built-in scene's name, a TOML file or a file of particles; default:
    four-spheres.

    The options from --color to --save-scene are for files of particles: .npz .npy .csv .ply .xyz
    .extxyz .dump .lammpstrj, and with an extra .pdb .cif .gsd. All of them are in view, at most 16
    samples a pixel, on the sRGB curve.

    \b
    Examples:
      clrt render --width 3840 --height 2160
      clrt render first-result -o small.jpg --width 480 --height 270
      clrt render my.toml -o linear.npy --shadow-bias 0 --precision double
      clrt render -o left.png --region 0 0 1920 2160
      clrt render -o smooth.png --samples 64
      clrt render my.toml -o cut-out.png --transparent --transfer srgb
      clrt render my.toml -o all.exr --passes depth,normal,id
      clrt render atoms.xyz -o atoms.png --style soft
      clrt render flow.dump -o flow.png --frame 3 --color speed --colorbar "speed (m/s)"
    """
    started = time.perf_counter()
    from clrt.files.image import check_apart, check_output, check_suffix, film_dtype, save
    from clrt.files.particles.suffix import is_particles
    from clrt.opencl.device import label
    from clrt.renderer.renderer import Renderer, check_passes, check_region, check_size

    output = output or Path(f"{Path(scene).stem}.png")
    if has_particles := is_particles(Path(scene)):
        width, height = width or 1920, height or 1080
    else:
        only_for_particles(scene, **drawn, frame=frame, save_scene=save_scene)
        width, height = width or 3840, height or 2160
    left, top, right, bottom = check_region(region, *check_size(width, height))
    names = None if passes is None else check_passes(passes.split(","))
    check_suffix(output)
    check_apart(output, Path(scene))
    look: dict[str, Any] = {
        "samples": samples,
        "background": background,
        "transparent": transparent,
        "transfer": transfer,
    }
    if has_particles:
        from clrt.figure import sources
        from clrt.figure.styles import seen_by
        from clrt.files.scenewriter import save_scene as write_scene

        drawing = sources.look(size=(width, height), **look, **drawn)
        loaded = sources.of_file(Path(scene), frame or 0, drawing)
        if camera is not None:
            loaded = seen_by(loaded, camera)
    else:
        from clrt.figure.resolver import resolved

        loaded = opened(scene, **look)
        has_particles = len(loaded.particles) > 0
        with named(scene, SceneError):
            loaded = resolved(loaded)
    loaded = changed(loaded, max_depth=max_depth, shadow_bias=shadow_bias, camera=camera)
    alpha, dtype = loaded.film.transparent, film_dtype(output, bits)
    size = right - left, bottom - top
    check_output(output, *size, alpha=alpha, bits=bits, passes=names is not None)
    if save_scene is not None:
        check_apart(save_scene, Path(scene))
        write_scene(save_scene, sources.in_file(loaded, Path(scene), frame or 0, drawing))
    ready = time.perf_counter()
    with Renderer(precision=precision, lanes=lanes, device=device, threads=threads) as renderer:
        if verbose:
            say(f"{label(renderer.device)}, {renderer.lanes} lanes, {precision}")
        renderer.prepare(loaded, dtype, passes=names)
        compiled = time.perf_counter()
        with Progress(bottom - top, quiet) as progress:
            film, found = renderer.render(
                loaded,
                width,
                height,
                dtype=dtype,
                passes=names or (),
                region=region,
                progress=progress.add,
            )
        rendered = time.perf_counter()
        if verbose:
            say(
                f"imports and scene {ready - started:.3f} s, device and kernel "
                f"{compiled - ready:.3f} s, picture {rendered - compiled:.3f} s (kernel "
                f"alone {renderer.kernel_seconds:.4f} s)"
            )
    # Of particles it does not: made by clrt.plot or of another format it is the same file.
    command = "" if has_particles else context.obj
    save(output, film, passes=found, transfer=loaded.film.transfer, command=command)
    if verbose:
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
        say(f"file {time.perf_counter() - rendered:.3f} s, peak memory {peak} MB")
    if not quiet:
        say(f"{output}: {right - left}x{bottom - top}, rendered in {rendered - compiled:.3f} s")


@main.command()
@click.argument("scene", default="orbit")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="PATH",
    help="Default <scene>.mp4 here. The suffix chooses: .mp4 (needs the extra clrt[video]), "
    ".webp .gif .apng; or a name with #### for numbered pictures of any still format.",
)
@frame_options
@click.option("--width", type=click.IntRange(min=1), default=1920, show_default=True, metavar="N")
@click.option("--height", type=click.IntRange(min=1), default=1080, show_default=True, metavar="N")
@film_options
@rendering_options
@particle_options
@click.option(
    "--view-all",
    is_flag=True,
    help="All frames' particles are in view; default: the box and the particles of frame 0.",
)
@click.option(
    "--resume",
    is_flag=True,
    help="Leave out numbered pictures that are there already, whole and of this size.",
)
@click.option(
    "--shard",
    callback=shard_of,
    metavar="I/N",
    help="Of numbered pictures, only every Nth of these frames, from the Ith, counted from 0: so N "
    "machines share the work.",
)
def animate(
    scene: str,
    output: Path | None,
    frames: range | None,
    step: int,
    fps: float | None,
    crf: int,
    width: int,
    height: int,
    background: str | None,
    transparent: bool | None,
    transfer: str | None,
    samples: int | None,
    precision: Any,
    lanes: int | None,
    device: str | None,
    threads: int | None,
    quiet: bool,
    view_all: bool,
    resume: bool,
    shard: tuple[int, int] | None,
    **drawn: Any,
) -> None:
    """Renders the animation of SCENE, a built-in scene's name or a TOML file, or a trajectory of
    particles; default: orbit.

    The options from --color to --view-all are for trajectories, .xyz .extxyz .dump .lammpstrj, and
    with an extra .pdb .gsd. All frames are seen as the first one.

    \b
    Examples:
      clrt animate                                     orbit.mp4, 120 frames at 1920x1080
      clrt animate my.toml -o small.webp --width 480 --height 270 --step 2
      clrt animate my.toml -o 'frames/####.png' --shard 0/2       one half of the work
      clrt animate my.toml -o 'frames/####.png' --resume          what is still missing
      clrt animate flow.dump -o flow.mp4 --color speed --colorbar speed
    """
    started = time.perf_counter()
    import numpy as np
    from tqdm import tqdm

    from clrt.files import image, numbered, video
    from clrt.files.particles.suffix import is_particles
    from clrt.motion import animation, cluster
    from clrt.renderer.renderer import Renderer

    output = output or Path(f"{Path(scene).stem}.mp4")
    image.check_apart(output, Path(scene))
    look: dict[str, Any] = {
        "samples": samples,
        "background": background,
        "transparent": transparent,
        "transfer": transfer,
    }
    way: animation.Frames
    if is_particles(Path(scene)):
        from clrt.figure.sources import look as looking
        from clrt.motion.trajectory import Flow

        drawing = looking(size=(width, height), **look, **drawn)
        way = Flow(Path(scene), drawing, view_all=view_all)
    else:
        only_for_particles(scene, **drawn, view_all=view_all)
        loaded = opened(scene, **look)
        with named(scene, SceneError):
            way = animation.Way(loaded)
    asked = (way.frames if frames is None else frames)[::step]
    if not asked or asked[-1] not in way.frames:
        raise RequestError(f"--frames: expected frames from 0 to {way.frames[-1]}")
    with named(scene, SceneError):
        way.check(asked)
    fps = way.fps / step if fps is None else fps
    pattern = numbered.is_pattern(output)
    for option, given in (("--resume", resume), ("--shard", shard)):
        if given and not pattern:
            raise RequestError(f"{option}: expected an output with ####: a video is made in one go")
    film = way.said.film
    video.check_output(output, width, height, len(asked), fps, alpha=film.transparent)
    first, parts = shard or (0, 1)
    due: Sequence[int] = asked[first::parts]
    skipped = 0
    dtype = image.film_dtype(output) if pattern else np.uint8
    with Renderer(precision=precision, lanes=lanes, device=device, threads=threads) as renderer:
        renderer.prepare(
            way.scene(asked[0]), dtype
        )  # in this thread: clrt.opencl.pocl.signals_kept
        if pattern:
            kind = cluster.kind(cluster.fingerprint(way.said), width, height, renderer)
            adds = resume or shard is not None
            made = numbered.join(output, kind, way.fps, asked, adds=adds)
            if resume:
                missing = [k for k in due if not made.is_made(numbered.picture(output, k))]
                skipped, due = len(due) - len(missing), missing
        rendered = animation.animate(way, width, height, frames=due, dtype=dtype, renderer=renderer)
        with (
            closing(rendered),
            tqdm(rendered, total=len(due), unit="frame", disable=quiet, leave=False) as bar,
        ):
            if pattern:
                # They do not say which command: by any one they are the same.
                for k, frame in zip(due, bar, strict=True):
                    name = numbered.picture(output, k)
                    image.save(name, frame, transfer=film.transfer)
            else:
                video.save(output, bar, fps, crf)
    if not quiet:
        seconds = time.perf_counter() - started
        kept = f", {skipped} were there" if resume else ""
        say(f"{output}: {len(due)} frames of {width}x{height} in {seconds:.1f} s{kept}")


@main.command()
@click.argument("pattern", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    required=True,
    metavar="PATH",
    help="The video: .mp4 (needs the extra clrt[video]), .webp .gif .apng.",
)
@frame_options
@click.option("-q", "--quiet", is_flag=True, help="Print errors only.")
def encode(
    pattern: Path,
    output: Path,
    frames: range | None,
    step: int,
    fps: float | None,
    crf: int,
    quiet: bool,
) -> None:
    """Makes a video of the numbered pictures PATTERN, a name with #### where the number goes.

    \b
    Examples:
      clrt encode 'frames/####.png' -o orbit.mp4
      clrt encode 'frames/####.png' -o half.webp --frames 0-59 --fps 15
    """
    started = time.perf_counter()
    from tqdm import tqdm

    from clrt.files import image, numbered, video

    if numbered.is_pattern(output):
        raise RequestError(f"{output}: expected the name of a video, without ####")
    chosen, usual = numbered.complete(pattern, frames, step)
    fps = usual if fps is None else fps
    height, width, channels = image.read(numbered.picture(pattern, chosen[0])).shape
    video.check_output(output, width, height, len(chosen), fps, alpha=channels == 4)
    for k in chosen:
        image.check_apart(output, numbered.picture(pattern, k))
    with (
        closing(numbered.films(pattern, chosen)) as films,
        tqdm(films, total=len(chosen), unit="frame", disable=quiet, leave=False) as bar,
    ):
        video.save(output, bar, fps, crf)
    if not quiet:
        seconds = time.perf_counter() - started
        say(f"{output}: {len(chosen)} frames of {width}x{height} in {seconds:.1f} s")


@main.command()
@click.argument("scene", default="four-spheres")
@click.option(
    "--host",
    default="127.0.0.1",
    show_default=True,
    metavar="TEXT",
    help="The address to listen at. Other machines can connect to others than the default.",
)
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=0,
    metavar="N",
    help="Default: a free one.",
)
@rendering_options
@particle_options
def view(
    scene: str,
    host: str,
    port: int,
    samples: int | None,
    precision: Any,
    lanes: int | None,
    device: str | None,
    threads: int | None,
    quiet: bool,
    **drawn: Any,
) -> None:
    """Shows SCENE in a browser, a built-in scene's name, a TOML file or a file of particles;
    default: four-spheres.

    It prints an address, which it opens if there is a browser. Whoever knows it can look. Ctrl-C
    ends it.

    \b
    Examples:
      clrt view
      clrt view my.toml --samples 64
      clrt view flow.dump --color speed --style soft
      ssh -L 8000:127.0.0.1:8000 there clrt view my.toml --port 8000
    """
    import webbrowser

    from clrt.files.particles.suffix import is_particles
    from clrt.renderer.renderer import Renderer
    from clrt.viewer import subject
    from clrt.viewer.session import Session

    try:
        from clrt.viewer.server import View
    except ModuleNotFoundError:
        raise RequestError("clrt view needs websockets: pip install 'websockets>=17'") from None

    given = {"precision": precision, "lanes": lanes, "device": device}
    words = [w for k, v in given.items() if v not in (None, "robust") for w in (f"--{k}", str(v))]
    if is_particles(Path(scene)):
        looked_at = subject.of_file(Path(scene), drawn, words)
    else:
        only_for_particles(scene, **drawn)
        looked_at = subject.of(scene, words)
    first = Session(looked_at, samples).scene
    with Renderer(precision=precision, lanes=lanes, device=device, threads=threads) as renderer:
        renderer.prepare(first, "uint8")  # in this thread: clrt.opencl.pocl.signals_kept
        renderer.prepare(changed(first, samples=1), "uint8", alpha=False, passes=("id",))
        shown = View(renderer, lambda: Session(looked_at, samples), scene)
        with shown.listen(host, port) as listening:
            address = shown.address(listening)
            click.echo(address)
            if not quiet:
                say("Ctrl-C ends it")
            if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
                webbrowser.open(address)
            listening.serve_forever()


@main.command()
@click.option("-v", "--verbose", is_flag=True, help="Say what a bug report needs.")
def devices(verbose: bool) -> None:
    """Lists the OpenCL devices; the first is the default."""
    from clrt.opencl import pocl
    from clrt.opencl.device import devices as found
    from clrt.opencl.device import label

    for device in found():
        click.echo(label(device))
        if verbose:
            click.echo(
                f"  platform  {device.platform.version.strip()}\n"
                f"  device    {device.version.strip()}\n"
                f"  CPU       {pocl.name_given(device) or 'as PoCL says'}\n"
                f"  threads   {device.max_compute_units}\n"
                f"  lanes     {device.native_vector_width_float} of float32, "
                f"{device.native_vector_width_double} of float64\n"
                f"  memory    {device.global_mem_size >> 20} MB"
            )
    if verbose:
        import platform
        from importlib.metadata import version

        from clrt.storage import cache_folder

        packages = ("clrt", "pyopencl", "numpy", "pillow", "msgspec", "click")
        click.echo(
            f"cache       {cache_folder()}\n"
            f"versions    {', '.join(f'{name} {version(name)}' for name in packages)}, "
            f"Python {platform.python_version()}\n"
            f"machine     {platform.platform()}, {len(os.sched_getaffinity(0))} of "
            f"{os.cpu_count()} cores"
        )


@main.command()
@click.argument("scene")
def check(scene: str) -> None:
    """Checks SCENE, a built-in scene's name or a TOML file, and says what is in it."""
    from clrt.figure.resolver import resolved
    from clrt.files.scenefile import load_scene
    from clrt.motion import animation

    loaded = load_scene(scene)
    with named(scene, SceneError):
        loaded = resolved(loaded)
    if loaded.animation is not None:
        with named(scene, SceneError):
            animation.Way(loaded).check(animation.all_frames(loaded))
    click.echo(
        f"{scene}: {len(loaded.spheres)} spheres, {len(loaded.materials)} materials, "
        f"{len(loaded.lights)} lights, max_depth {loaded.max_depth}, "
        f"shadow_bias {loaded.shadow_bias:g}"
    )


@main.command()
@click.argument("a", type=click.Path(path_type=Path))
@click.argument("b", type=click.Path(path_type=Path))
@click.option(
    "--heatmap",
    type=click.Path(path_type=Path),
    metavar="PATH",
    help="Also draw where the pictures differ.",
)
def compare(a: Path, b: Path, heatmap: Path | None) -> None:
    """Says how far picture A is from picture B.

    \b
    Examples:
      clrt compare mine.png theirs.png --heatmap where.png
      clrt compare robust.npy double.npy
    """
    import numpy as np

    from clrt import memory
    from clrt.files import image
    from clrt.film import metrics

    first, second = image.load(a), image.load(b)
    advice = "compare parts of them"
    memory.require(27 * first.size, f"to compare {a} with {b}", advice)  # measured
    if heatmap is not None:
        image.check_output(heatmap, first.shape[1], first.shape[0])
        for picture in (a, b):
            image.check_apart(heatmap, picture)
    found = metrics.difference(first, second)
    curves = {image.is_srgb(picture): picture for picture in (a, b)}
    if {True, False} <= curves.keys():
        say(f"clrt: {curves[True]} is sRGB and {curves[False]} is not: compared as they are")
    click.echo(
        f"pixels   {found.pixels}\n"
        f"max      {found.max:.3e}\n"
        f"RMSE     {found.rmse:.3e}\n"
        f"PSNR     {found.psnr:.2f} dB\n"
        f"p50      {found.p50:.3e}\n"
        f"p99      {found.p99:.3e}\n"
        f"p99.9    {found.p999:.3e}\n"
        f"> 1/255  {found.over_255}\n"
        f"> 1/1020 {found.over_1020}, {found.interior_flips} of them away from edges"
    )
    if heatmap is not None:
        map_ = metrics.heatmap(metrics.pixel_error(first, second))
        if image.film_dtype(heatmap) is np.uint8:
            map_ = np.rint(255 * map_).astype(np.uint8)
        image.save(heatmap, map_)
        say(f"{heatmap}: written")

"""clrt animate: a video or numbered pictures of a scene's animation, or of a trajectory."""

import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from clrt.commands.groups import Grouped
from clrt.commands.loading import kind_of, opened
from clrt.commands.options import (
    RenderingOptions,
    VideoOptions,
    film_options,
    rendering_options,
    shard_of,
    stem_of,
    video_options,
)
from clrt.commands.particles import (
    PARTICLE_KEYS,
    only_for_particles,
    particle_options,
    reading_options,
)
from clrt.commands.terminal import say
from clrt.errors import ClrtError, FrameError, RequestError, SceneError, called, named

if TYPE_CHECKING:
    from clrt.figure.rendering import Renderer
    from clrt.files.numbered import Record
    from clrt.motion.animation import Frames


@click.command(cls=Grouped)
@click.argument("scenes", nargs=-1, metavar="[SCENE]...")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="PATH",
    help="Default <scene>.mp4 here. The suffix chooses: .mp4 .mov .mkv (need clrt[video]), "
    ".webp .gif .apng; or a name with #### for numbered pictures of any still format.",
)
@video_options
@click.option("--width", type=click.IntRange(min=1), default=1920, show_default=True, metavar="N")
@click.option("--height", type=click.IntRange(min=1), default=1080, show_default=True, metavar="N")
@film_options
@rendering_options
@particle_options
@reading_options
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
    scenes: tuple[str, ...],
    output: Path | None,
    video: VideoOptions,
    width: int,
    height: int,
    film: dict[str, Any],
    rendering: RenderingOptions,
    drawn: dict[str, Any],
    reading: dict[str, str],
    view_all: bool,
    resume: bool,
    shard: tuple[int, int] | None,
) -> None:
    """Renders the animation of SCENE, a built-in scene's name or a TOML file, or a trajectory of
    particles; default: orbit. Several files, or a pattern as 'dump.*', have one frame each; they
    may be meshes (.stl, .obj, .ply with faces).

    The headings from "Which particles" to "Where they are seen from" are for trajectories (see
    'clrt formats'). All frames are seen as the first one.

    \b
    Examples:
      clrt animate                                     orbit.mp4, 120 frames at 1920x1080
      clrt animate my.toml -o small.webp --width 480 --height 270 --step 2
      clrt animate my.toml -o 'frames/####.png' --shard 0/2       one half of the work
      clrt animate my.toml -o 'frames/####.png' --resume          what is still missing
      clrt animate flow.dump -o flow.mp4 --color speed --colorbar speed
      clrt animate 'post/dump.*.gz' -o flow.mp4
    """
    started = time.perf_counter()
    import numpy as np
    from tqdm import tqdm

    from clrt.files import image, numbered
    from clrt.files import video as videos
    from clrt.motion import animation

    scene = scenes[0] if scenes else "orbit"
    quiet, output = rendering.quiet, output or Path(f"{stem_of(scene)}.mp4")
    for one in scenes:
        image.check_apart(output, Path(one))
    look = {"samples": rendering.samples, **film}
    way = _way(scene, scenes, (width, height), look, drawn, reading, view_all)
    asked = _asked(scene, way, video)
    fps = way.fps / video.step if video.fps is None else video.fps
    pattern = numbered.is_pattern(output)
    for option, given in (("--resume", resume), ("--shard", shard)):
        if given and not pattern:
            raise RequestError(f"{option}: expected an output with ####: a video is made in one go")
    transparent, transfer = way.said.film.transparent, way.said.film.transfer
    videos.check_output(output, width, height, len(asked), fps, alpha=transparent)
    first, parts = shard or (0, 1)
    share: Sequence[int] = asked[first::parts]
    dtype = image.film_dtype(output) if pattern else np.uint8
    faults = list[ClrtError]()
    with rendering.renderer() as renderer:
        renderer.prepare(way.scene(asked[0]), dtype)  # in this thread: see pocl.signals_kept()
        due = share
        if pattern:
            adds = resume or shard is not None
            made = _record(way, asked, output, (width, height), renderer, reading, adds)
            if resume:
                due = [k for k in share if not made.is_made(numbered.picture(output, k))]
        rendered = animation.animate(way, width, height, frames=due, dtype=dtype, renderer=renderer)
        good = _good(rendered, faults)
        with (
            closing(rendered),
            tqdm(good, total=len(due), unit="frame", disable=quiet or None, leave=False) as bar,
        ):
            if pattern:
                # They do not say which command: by any one they are the same.
                for k, frame in zip(due, bar, strict=False):
                    image.save(numbered.picture(output, k), frame, transfer=transfer)
            else:
                videos.save(output, bar, fps, video.crf, video.quality)
    if faults:
        raise FrameError(f"{faults[0]}; {output} has the frames before it")
    if not quiet:
        what = f"{output}: {len(due)} frames of {width}x{height}"
        if not pattern:
            what = videos.said(output, width, height, len(due), fps, video.quality)
        kept = f", {len(share) - len(due)} were there" if resume else ""
        say(f"{what}, in {time.perf_counter() - started:.1f} s{kept}")


def _way(
    scene: str,
    scenes: Sequence[str],
    size: tuple[int, int],
    look: dict[str, Any],
    drawn: dict[str, Any],
    reading: dict[str, str],
    view_all: bool,
) -> "Frames":
    """The frames of what is to be shown: meshes, a trajectory or the animation of a scene.

    Args:
        scene: the first of `scenes`, or what is shown where there are none.
    """
    from clrt.motion import animation
    from clrt.motion.surfaces import Surfaces, are_meshes

    if not reading and are_meshes(scenes):
        if view_all:
            raise RequestError(f"--view-all: expected files of particles, {scene} is a mesh")
        with called(PARTICLE_KEYS):
            return Surfaces(scenes, size=size, **look, **drawn)
    if len(scenes) > 1 or kind_of(scene, reading) == "particles":
        from clrt.figure.sources import look as looking
        from clrt.motion.trajectory import Flow

        with called(PARTICLE_KEYS):
            drawing = looking(size=size, **look, **drawn)
            return Flow(scenes, drawing, view_all=view_all, **reading)
    only_for_particles(scene, **drawn, **reading, view_all=view_all)
    loaded = opened(scene, **look)
    with named(scene, SceneError):
        return animation.Way(loaded)


def _asked(scene: str, way: "Frames", video: VideoOptions) -> range:
    """The frames that options ask for, and that there are."""
    asked = (way.frames if video.frames is None else video.frames)[:: video.step]
    if not asked or asked[-1] not in way.frames:
        raise RequestError(f"--frames: expected frames from 0 to {way.frames[-1]}")
    with named(scene, SceneError):
        way.check(asked)
    return asked


def _record(
    way: "Frames",
    asked: range,
    pattern: Path,
    size: tuple[int, int],
    renderer: "Renderer",
    reading: dict[str, str],
    adds: bool,
) -> "Record":
    """The note beside numbered pictures that says of what kind they are.

    Args:
        adds: whether pictures that are there stay.
    """
    from clrt.files import numbered
    from clrt.motion import cluster

    what = " ".join([cluster.fingerprint(way.said), *reading.values()])
    kind = cluster.kind(what, *size, renderer)
    return numbered.join(pattern, kind, way.fps, asked, adds=adds)


def _good(frames: Iterable[Any], faults: list[ClrtError]) -> Iterator[Any]:
    """The frames up to the first that cannot be made, so that they are kept.

    Args:
        faults: what is wrong with that goes here.

    Raises:
        ClrtError: there are none before it.
    """
    made = 0
    try:
        for frame in frames:
            yield frame
            made += 1
    except ClrtError as error:
        if not made:
            raise
        faults.append(error)

"""clrt encode: a video of numbered pictures."""

import time
from contextlib import closing
from pathlib import Path

import click

from clrt.commands.options import VideoOptions, video_options
from clrt.commands.terminal import say
from clrt.errors import RequestError


@click.command()
@click.argument("pattern", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    required=True,
    metavar="PATH",
    help="The video: .mp4 .mov .mkv (need the extra clrt[video]), .webp .gif .apng.",
)
@video_options
@click.option("-q", "--quiet", is_flag=True, help="Print errors only.")
def encode(
    pattern: Path,
    output: Path,
    video: VideoOptions,
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

    from clrt.files import image, numbered
    from clrt.files import video as videos

    if numbered.is_pattern(output):
        raise RequestError(f"{output}: expected the name of a video, without ####")
    chosen, usual = numbered.complete(pattern, video.frames, video.step)
    fps = usual if video.fps is None else video.fps
    height, width, channels = image.read(numbered.picture(pattern, chosen[0])).shape
    videos.check_output(output, width, height, len(chosen), fps, alpha=channels == 4)
    for k in chosen:
        image.check_apart(output, numbered.picture(pattern, k))
    with (
        closing(numbered.films(pattern, chosen)) as films,
        tqdm(films, total=len(chosen), unit="frame", disable=quiet or None, leave=False) as bar,
    ):
        videos.save(output, bar, fps, video.crf, video.quality)
    if not quiet:
        seconds = time.perf_counter() - started
        what = videos.said(output, width, height, len(chosen), fps, video.quality)
        say(f"{what}, in {seconds:.1f} s")

"""clrt compare: how far two pictures are apart."""

from pathlib import Path

import click

from clrt.commands.terminal import say


@click.command()
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

"""Options of commands that make pictures."""

import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from clrt.errors import RequestError, SceneError

if TYPE_CHECKING:
    from clrt.scene.scene import Camera

RENDERING_OPTIONS = (
    click.option(
        "--samples",
        type=click.IntRange(min=1),
        metavar="N",
        help="The most that a pixel gets; default: the scene's.",
    ),
    click.option(
        "--precision",
        type=click.Choice(["robust", "literal", "double"]),
        default="robust",
        show_default=True,
        help="robust: float32; literal: float32, the paper's formula; double: float64.",
    ),
    click.option(
        "--lanes",
        type=click.Choice(["1", "2", "4", "8", "16"]),
        callback=lambda context, option, text: text and int(text),
        help="Pixels traced in lock step; default: what suits the device.",
    ),
    click.option(
        "--device",
        metavar="TEXT",
        help="Part of a device's or platform's name, see 'clrt devices'.",
    ),
    click.option(
        "--threads",
        type=click.IntRange(min=1, max=1024),
        metavar="N",
        help="Threads of PoCL; default: all cores.",
    ),
    click.option("-q", "--quiet", is_flag=True, help="Print errors only."),
)


def rendering_options(command: Callable[..., None]) -> Callable[..., None]:
    """What `render` and `animate` take alike."""
    for option in reversed(RENDERING_OPTIONS):
        command = option(command)
    return command


def _is_color(context: click.Context, option: click.Parameter, text: str | None) -> str | None:
    if text is not None:
        from clrt.film.color import named

        try:
            named(text)
        except RequestError as error:
            raise click.BadParameter(str(error)) from None
    return text


FILM_OPTIONS = (
    click.option(
        "--background",
        metavar="COLOR",
        callback=_is_color,
        help="A name, #rgb or #rrggbb; default: the scene's, of particles white.",
    ),
    click.option(
        "--transparent", is_flag=True, default=None, help="Alpha in place of the background."
    ),
    click.option(
        "--transfer",
        type=click.Choice(["linear", "srgb"]),
        help="The curve of 8 and 16 bits; default: the scene's, of particles srgb.",
    ),
)


def film_options(command: Callable[..., None]) -> Callable[..., None]:
    """What becomes of the light."""
    for option in reversed(FILM_OPTIONS):
        command = option(command)
    return command


PARTICLE_OPTIONS = (
    click.option(
        "--color",
        metavar="TEXT",
        help="Of particles: file, element, type or material, or a column's name; default: the "
        "first of those four that there is.",
    ),
    click.option("--cmap", metavar="NAME", help="Colour map of a column; default: viridis."),
    click.option(
        "--clim",
        type=float,
        nargs=2,
        metavar="LO HI",
        help="What the map's ends stand for; default: the column's range.",
    ),
    click.option(
        "--radius",
        type=float,
        metavar="X",
        help="Of all particles; default: the file's, or else the elements' van der Waals radii.",
    ),
    click.option("--scale", type=float, metavar="X", help="Of all radii; default: 1."),
    click.option(
        "--view",
        metavar="NAME",
        help="Where the camera stands: iso, x, -x, y, -y, z or -z; default: iso.",
    ),
    click.option(
        "--projection", metavar="NAME", help="orthographic or perspective; default: orthographic."
    ),
    click.option(
        "--margin",
        type=float,
        metavar="X",
        help="The part of the picture that stays free at each side; default: 0.03.",
    ),
    click.option("--style", metavar="NAME", help="matte, soft, outline or mirror; default: matte."),
    click.option("--cell", is_flag=True, help="Draw the edges of the file's box."),
    click.option(
        "--colorbar",
        metavar="LABEL",
        help="Draw a colour bar, or a legend of elements or types.",
    ),
)


def particle_options(command: Callable[..., None]) -> Callable[..., None]:
    """How particles are drawn: clrt.figure.Look has a field for each."""
    for option in reversed(PARTICLE_OPTIONS):
        command = option(command)
    return command


def only_for_particles(scene: str, **given: Any) -> None:
    """Finds out whether one of these was given with a scene.

    Raises:
        RequestError: it was.
    """
    for name, value in given.items():
        if value is not None and value is not False:
            option = name.replace("_", "-")
            raise RequestError(f"--{option}: expected a file of particles, {scene} is a scene")


def _frames(context: click.Context, option: click.Parameter, text: str | None) -> range | None:
    """--frames A-B, both included, or one number."""
    if text is None:
        return None
    found = re.fullmatch(r"([0-9]{1,9})(?:-([0-9]{1,9}))?", text)
    if found is None:
        raise click.BadParameter(f"expected A-B, as 0-59, got {text!r}")
    return range(int(found[1]), int(found[2] or found[1]) + 1)


def shard_of(
    context: click.Context, option: click.Parameter, text: str | None
) -> tuple[int, int] | None:
    """--shard I/N."""
    if text is None:
        return None
    found = re.fullmatch(r"([0-9]{1,9})/([0-9]{1,9})", text)
    if found is None or int(found[1]) >= int(found[2]):
        raise click.BadParameter(f"expected I/N with 0 <= I < N, as 0/50, got {text!r}")
    return int(found[1]), int(found[2])


FRAME_OPTIONS = (
    click.option(
        "--frames",
        callback=_frames,
        metavar="A-B",
        help="Only these frames, both included; default: all.",
    ),
    click.option(
        "--step",
        type=click.IntRange(min=1),
        default=1,
        show_default=True,
        metavar="N",
        help="Only every Nth frame.",
    ),
    click.option(
        "--fps",
        type=float,
        metavar="X",
        help="Frames a second; default: the scene's.",
    ),
    click.option(
        "--crf",
        type=click.IntRange(0, 51),
        default=18,
        show_default=True,
        metavar="N",
        help="Quality of .mp4: 0 is lossless, more is smaller.",
    ),
)


def frame_options(command: Callable[..., None]) -> Callable[..., None]:
    """What `animate` and `encode` take alike."""
    for option in reversed(FRAME_OPTIONS):
        command = option(command)
    return command


def camera_keys(
    context: click.Context, option: click.Parameter, text: str | None
) -> "Camera | None":
    """The keys of a scene file's [camera], with commas between them."""
    if text is None:
        return None
    from clrt.files.scenefile import parse_camera

    try:
        return parse_camera(text)
    except SceneError as error:
        raise click.BadParameter(str(error)) from None

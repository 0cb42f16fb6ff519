"""Options that several commands have, in groups. A command gets the values of a group as one
argument."""

import functools
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import click

from clrt.errors import RequestError, SceneError

if TYPE_CHECKING:
    from clrt.figure.rendering import Renderer
    from clrt.scene.camera import Camera

Command: TypeAlias = Callable[..., None]


def _group(
    name: str, kind: Callable[..., Any], options: Sequence[Callable[[Command], Command]]
) -> Callable[[Command], Command]:
    """A decorator: a command has these options, and gets kind(**values) as its argument `name`."""

    def decorate(command: Command) -> Command:
        @functools.wraps(command)
        def gathered(*words: Any, **values: Any) -> None:
            given = {key: values.pop(key) for key in keys}
            command(*words, **values, **{name: kind(**given)})

        params: list[click.Parameter] = gathered.__dict__.setdefault("__click_params__", [])
        before = len(params)
        for option in reversed(options):
            option(gathered)
        keys = [param.name or "" for param in params[before:]]
        return gathered

    return decorate


class RenderingOptions(NamedTuple):
    """Which renderer is to make the picture."""

    samples: int | None
    precision: Any
    lanes: int | None
    device: str | None
    threads: int | None
    quiet: bool

    def renderer(self) -> "Renderer":
        from clrt.figure.rendering import Renderer

        renderer = Renderer(
            precision=self.precision, lanes=self.lanes, device=self.device, threads=self.threads
        )
        renderer.quiet = self.quiet
        return renderer

    def words(self) -> list[str]:
        """Those that a command line needs for the same picture."""
        given = {"precision": self.precision, "lanes": self.lanes, "device": self.device}
        used = {key: str(value) for key, value in given.items() if value not in (None, "robust")}
        return [word for key, text in used.items() for word in (f"--{key}", text)]


class VideoOptions(NamedTuple):
    """Which frames, how fast, and how well they are kept."""

    frames: range | None
    step: int
    fps: float | None
    crf: int


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


rendering_options = _group("rendering", RenderingOptions, RENDERING_OPTIONS)


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


film_options = _group("film", dict, FILM_OPTIONS)
"""Keys of a scene's film."""


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


particle_options = _group("drawn", dict, PARTICLE_OPTIONS)
"""How particles are drawn: fields of clrt.figure.Look."""


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


VIDEO_OPTIONS = (
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


video_options = _group("video", VideoOptions, VIDEO_OPTIONS)


def _camera_keys(
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


SCENE_OPTIONS = (
    click.option(
        "--max-depth",
        type=click.IntRange(min=1),
        metavar="N",
        help="Ray segments from the camera, 1 for no reflection; default: the scene's.",
    ),
    click.option(
        "--shadow-bias",
        type=click.FloatRange(min=0),
        metavar="X",
        help="World units, 0 for the exact geometry; default: the scene's.",
    ),
    click.option(
        "--camera",
        metavar="TOML",
        callback=_camera_keys,
        help="In place of the scene's: keys of its table with commas between, as "
        "'position = [0, 1, 3], look_at = [0, 0, 0]'.",
    ),
)
scene_options = _group("changes", dict, SCENE_OPTIONS)
"""Keys of a scene, in place of its own."""


format_option = click.option(
    "--format",
    metavar="NAME",
    help="Of files of particles whose names do not tell: npz, npy, csv, ply, xyz, dump, data, pdb, "
    "cif, gsd or vtk.",
)


def stem_of(source: str) -> str:
    """What a picture of a source is called, without suffix."""
    return re.sub(r"[*?\[\]]", "", Path(source).stem).strip("._-") or "particles"

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
        """The options that a command line needs for the same picture."""
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
        help="The most that a pixel gets; default: the scene's, of particles 16.",
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


def _by_kind(context: click.Context, option: click.Parameter, text: str | None) -> Any:
    """One value for all, or A=X,B=Y; commas in brackets part nothing."""
    if text is None or "=" not in text:
        return text
    pairs = re.findall(r"([^=]+)=((?:[^,(]|\([^)]*\))*)(?:,|$)", text)
    if "".join(f"{key}={value}," for key, value in pairs).rstrip(",") != text.rstrip(","):
        raise click.BadParameter(f"expected A=X,B=Y, got {text!r}")
    return {key.strip(): value.strip() for key, value in pairs}


def _radius(context: click.Context, option: click.Parameter, text: str | None) -> Any:
    found = _by_kind(context, option, text)
    try:
        if isinstance(found, dict):
            return {key: float(value) for key, value in found.items()}
        return None if found is None else float(found)
    except ValueError:
        expected = "a number, or numbers of types, elements or names, as Na=1.0,Cl=1.8"
        raise click.BadParameter(f"expected {expected}, got {text!r}") from None


def _clim(context: click.Context, option: click.Parameter, words: Any) -> Any:
    """--clim LO HI, or a word, which Grouped gives twice."""
    if words is None or words[0] in CLIM_WORDS:
        return words and words[0]
    try:
        return tuple(map(float, words))
    except ValueError:
        raise click.BadParameter(f"expected LO HI, first or all, got {' '.join(words)!r}") from None


CLIM_WORDS = ("first", "all")

PARTICLE_OPTIONS = (
    click.option("--select", metavar="EXPR", help="Only these, as 'x > 0 and chain == \"A\"'."),
    click.option("--hide", metavar="EXPR", help="Not these, as water."),
    click.option("--wrap", is_flag=True, help="Move particles into their box."),
    click.option(
        "--replicate", type=int, nargs=3, metavar="NX NY NZ", help="Images along the box's edges."
    ),
    click.option(
        "--color",
        metavar="EXPR",
        help="file, element, type, material, or columns, as speed or 'x**2 + y**2'; default: the "
        "first of file, element and type that there is, else steel blue.",
    ),
    click.option(
        "--colors",
        metavar="A=COLOR,...",
        callback=_by_kind,
        help="Of types, elements, names or texts, as Na=red,Cl=#0a0; or of all.",
    ),
    click.option("--cmap", metavar="NAME", help="Colour map of numbers; default: viridis."),
    click.option(
        "--clim",
        nargs=2,
        metavar="LO HI",
        callback=_clim,
        help="What the map's ends stand for, or of a trajectory: first, all. Default: the range, "
        "of ten frames.",
    ),
    click.option(
        "--colorbar", metavar="LABEL", help="Draw a colour bar, or a legend of kinds; '': none."
    ),
    click.option(
        "--radius",
        metavar="X|A=X,...",
        callback=_radius,
        help="Of all, or of types, elements, names, as Na=1.0,Cl=1.8; default: the file's, the "
        "elements' van der Waals radii, or by the distance of neighbours.",
    ),
    click.option("--scale", type=float, metavar="X", help="Of all radii; default: 1."),
    click.option("--style", metavar="NAME", help="See 'clrt styles'; default: soft."),
    click.option("--cell", is_flag=True, help="Draw the edges of the box."),
    click.option(
        "--view",
        metavar="NAME|X,Y,Z",
        help="Where the camera stands: corner, iso, x, -x, y, -y, z, -z, or three numbers; "
        "default: corner, of flat data z.",
    ),
    click.option("--up", metavar="NAME|X,Y,Z", help="What is up in the picture; default: z."),
    click.option("--zoom", type=float, metavar="X", help="Default: 1, which holds all."),
    click.option("--center", metavar="X,Y,Z", help="The picture's middle; default: that of all."),
    click.option(
        "--projection", metavar="NAME", help="orthographic or perspective; default: orthographic."
    ),
    click.option(
        "--margin",
        type=float,
        metavar="X",
        help="The part that stays free at each side; default: 0.03.",
    ),
)


particle_options = _group("drawn", dict, PARTICLE_OPTIONS)
"""How particles are drawn: fields of clrt.figure.Look."""
PARTICLE_KEYS = {
    key: f"--{key}"
    for key in (
        *("select", "hide", "wrap", "replicate", "color", "colors", "cmap", "clim", "colorbar"),
        *("radius", "scale", "style", "cell", "view", "up", "zoom", "center", "projection"),
        *("margin", "background", "samples", "altloc", "assembly"),
    )
}
"""What a key of a Look is called on the command line."""

HEADINGS = {
    "Picture": ("output", "width", "height", "samples", "style", "background", "transparent"),
    "Which particles": (
        *("select", "hide", "frame", "altloc", "assembly", "wrap", "replicate", "cell"),
    ),
    "Their colours": ("color", "colors", "cmap", "clim", "colorbar"),
    "Their radii": ("radius", "scale"),
    "Where they are seen from": (
        "view",
        "up",
        "zoom",
        "center",
        "projection",
        "margin",
        "view_all",
    ),
    "Frames and videos": ("frames", "step", "fps", "crf", "resume", "shard"),
    "Files": ("format", "output_format", "transfer", "bits", "passes", "region", "save_scene"),
    "Scenes": ("max_depth", "shadow_bias", "camera"),
}
"""Of the help of commands that make pictures; other options come last."""
LAST = "Device and help"


class Grouped(click.Command):
    """A command whose options stand under headings."""

    def parse_args(self, context: click.Context, args: list[str]) -> list[str]:
        words = iter(args)
        found: list[str] = []
        for word in words:
            name, equals, value = word.partition("=")
            if name == "--clim" and equals:
                found.append("--clim")
                word = value
            elif found and found[-1] == "--clim":
                pass
            else:
                found.append(word)
                continue
            found += [word, word] if word in CLIM_WORDS else [word]
        return super().parse_args(context, found)

    def format_options(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        rows = {
            param.name: row
            for param in self.get_params(context)
            if isinstance(param, click.Option)
            and (row := param.get_help_record(context)) is not None
        }
        for heading, names in HEADINGS.items():
            if there := [rows.pop(name) for name in names if name in rows]:
                with formatter.section(heading):
                    formatter.write_dl(there)
        with formatter.section(LAST):
            formatter.write_dl(list(rows.values()))


def only_for_particles(scene: str, **given: Any) -> None:
    """Finds out whether one of these was given with a scene.

    Raises:
        RequestError: it was.
    """
    for name, value in given.items():
        if value is not None and value is not False and value != ():
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


READING_OPTIONS = (
    click.option(
        "--format",
        metavar="NAME",
        help="Of files of particles whose names do not tell: npz, npy, csv, ply, xyz, dump, data, "
        "pdb, cif, gsd, gro, poscar or vtk.",
    ),
    click.option(
        "--altloc",
        metavar="NAME",
        help="Of an atom's alternate locations in .pdb and .cif: most, the most occupied, or all; "
        "default: most.",
    ),
    click.option(
        "--assembly",
        metavar="NAME",
        help="A biological assembly that a .pdb or .cif has, as 1; default: the atoms listed.",
    ),
)


def _reading(**given: str | None) -> dict[str, str]:
    return {key: text for key, text in given.items() if text is not None}


reading_options = _group("reading", _reading, READING_OPTIONS)
"""How files of particles are read, where it is said: arguments of clrt.read()."""


def stem_of(source: str) -> str:
    """What a picture of a source is called, without suffix."""
    return re.sub(r"[*?\[\]]", "", Path(source).stem).strip("._-") or "particles"

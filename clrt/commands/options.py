"""Options that several commands have, beside those of particles."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from clrt.commands.groups import group
from clrt.errors import RequestError, SceneError

if TYPE_CHECKING:
    from clrt.figure.rendering import Renderer
    from clrt.scene.camera import Camera


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
    quality: int


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


rendering_options = group("rendering", RenderingOptions, RENDERING_OPTIONS)


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
        "--denoise",
        is_flag=True,
        default=None,
        help="Filter the noise of occlusion and soft shadows; for fewer than 16 samples.",
    ),
    click.option(
        "--transfer",
        type=click.Choice(["linear", "srgb"]),
        help="The curve of 8 and 16 bits; default: the scene's, of particles srgb.",
    ),
)


film_options = group("film", dict, FILM_OPTIONS)
"""Keys of a scene's film."""


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
        help="Quality of .mp4, .mov and .mkv: 0 is lossless, more is smaller.",
    ),
    click.option(
        "--quality",
        type=click.IntRange(0, 100),
        default=80,
        show_default=True,
        metavar="N",
        help="Of .webp: 100 is lossless, less is smaller.",
    ),
)


video_options = group("video", VideoOptions, VIDEO_OPTIONS)


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
scene_options = group("changes", dict, SCENE_OPTIONS)
"""Keys of a scene, in place of its own."""


def stem_of(source: str) -> str:
    """What a picture of a source is called, without suffix."""
    return re.sub(r"[*?\[\]]", "", Path(source).stem).strip("._-") or "particles"

"""Groups of options: a command gets the values of a group as one argument, and its help has them
under headings."""

import functools
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import click

Command: TypeAlias = Callable[..., None]


def group(
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
        keys = {param.name or "" for param in params[before:]}
        return gathered

    return decorate


CLIM_WORDS = ("first", "all")
"""Of --clim, in place of its two numbers."""
IN_PLACE = {"--clim": CLIM_WORDS, "--scalebar": ("auto",)}
"""Options of two values, and words that stand for both."""

SOLID = "--cell-solid"
"""What Grouped makes of --cell solid, for --cell has no value."""

HEADINGS = {
    "Picture": (
        "output",
        "width",
        "height",
        "samples",
        "style",
        "background",
        "transparent",
        "denoise",
    ),
    "Which particles": (
        *("select", "hide", "frame", "altloc", "assembly", "wrap", "replicate", "cell"),
    ),
    "Their colours": ("color", "colors", "opacity", "cmap", "clim", "colorbar"),
    "Words": (
        *("title", "label", "labels", "scalebar", "axes", "colorbar_side"),
        *("font_size", "line_width"),
    ),
    "Their radii": ("radius", "scale"),
    "Their bonds": ("bonds", "bond_radius", "bond_color"),
    "Their vectors": ("vectors", "vector_scale", "vector_color"),
    "A mesh": ("mesh", "mesh_color", "mesh_opacity"),
    "Where they are seen from": (
        *("view", "up", "zoom", "center", "projection", "margin", "view_all"),
    ),
    "Frames and videos": ("frames", "step", "fps", "crf", "quality", "resume", "shard"),
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
            if word == "--cell=solid" or (word == "solid" and found[-1:] == ["--cell"]):
                found[len(found) - (word == "solid") :] = [SOLID]
                continue
            if name in IN_PLACE and equals:
                found.append(name)
                word = value
            elif found and found[-1] in IN_PLACE:
                name = found[-1]
            else:
                found.append(word)
                continue
            found += [word, word] if word in IN_PLACE[name] else [word]
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

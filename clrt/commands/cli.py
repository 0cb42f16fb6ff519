"""The command line: its commands, and errors as one line and an exit status.

A command is a module of this package and is imported when somebody calls for it. A command imports
the rest of clrt when it runs, so that --help stays quick.
"""

import importlib
import os
import shlex
import sys
import warnings
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import click

from clrt.commands.terminal import say
from clrt.errors import ClrtError, ClrtWarning

COMMANDS = (
    *("animate", "check", "compare", "devices", "encode", "formats", "render", "styles"),
    "view",
)
"""Modules of this package, each with a command of its name."""


class Warnings:
    """Says clrt's own, each once. Nobody at a shell can mend what the libraries warn of."""

    def __init__(self) -> None:
        self._said: set[str] = set()

    def __call__(
        self, message: Warning | str, category: type[Warning], *where: object, **more: object
    ) -> None:
        if issubclass(category, ClrtWarning) and str(message) not in self._said:
            self._said.add(str(message))
            say(f"clrt: {message}")


def _command(words: Sequence[str]) -> str:
    """The command that a picture names as its maker. It leaves out the output, so that the same
    picture is the same bytes."""
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
                warnings.showwarning = Warnings()
                return super().main(*words, **options)
        except ClrtError as error:
            said, status = str(error), error.exit_status
        except MemoryError:
            said, status = "not enough memory: render it in parts (--region) or smaller", 1
        except OSError as error:
            with suppress(OSError):  # else the rest of stdout's buffer would fail again at the end
                os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
            said, status = str(error) if error.filename else f"stdout: {error.strerror or error}", 1
        except Exception as error:
            import traceback

            file, line, *_ = traceback.extract_tb(error.__traceback__)[-1]
            said = f"this is a bug in clrt: {error!r} in {file}:{line}"
            status = 1
        say(f"clrt: {said}")
        sys.exit(status)

    def resolve_command(
        self, context: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
            from clrt.values import did_you_mean

            hint = did_you_mean(args[0], COMMANDS)
            context.fail(f"No such command {args[0]!r}{hint or '; clrt --help lists them'}")
        return super().resolve_command(context, args)

    def list_commands(self, context: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, context: click.Context, name: str) -> click.Command | None:
        if name not in COMMANDS:
            return None
        command: click.Command = getattr(importlib.import_module(f"clrt.commands.{name}"), name)
        return command


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="clrt")
def main() -> None:
    """Ray traces particles, meshes and scenes through OpenCL.

    \b
    Examples:
      clrt render                                  the paper's scene at 4K
      clrt render atoms.xyz -o atoms.png           a figure of particles
      clrt render surface.stl                      a figure of a mesh
      clrt render my.toml -o my.png --width 1920 --height 1080
      clrt animate                                 a video round that scene
      clrt encode 'frames/####.png' -o my.mp4      a video of numbered pictures
      clrt check my.toml                           is the scene file right?
      clrt check atoms.xyz                         what can be selected and shown?
      clrt view atoms.xyz                          turn it in a browser
      clrt compare a.png b.png                     how far apart are two pictures?
      clrt devices                                 where can it run?

    In bash eval "$(_CLRT_COMPLETE=bash_source clrt)" completes commands and options; zsh_source and
    fish_source do in those.
    """

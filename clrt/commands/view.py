"""clrt view: a scene or particles on a page, which a browser shows."""

import os
from pathlib import Path
from typing import Any

import click

from clrt.commands.groups import Grouped
from clrt.commands.loading import changed, kind_of
from clrt.commands.options import RenderingOptions, rendering_options
from clrt.commands.particles import (
    PARTICLE_KEYS,
    only_for_particles,
    particle_options,
    reading_options,
)
from clrt.commands.terminal import say
from clrt.errors import RequestError, called


@click.command(cls=Grouped)
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
@reading_options
def view(
    scene: str,
    host: str,
    port: int,
    rendering: RenderingOptions,
    drawn: dict[str, Any],
    reading: dict[str, str],
) -> None:
    """Shows SCENE in a browser, a built-in scene's name, a TOML file, a file of particles or of a
    mesh; default: four-spheres.

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

    from clrt.viewer import subject
    from clrt.viewer.session import Session

    try:
        from clrt.viewer.server import View
    except ModuleNotFoundError:
        raise RequestError("clrt view needs websockets: pip install 'websockets>=17'") from None

    samples = rendering.samples
    words = rendering.words()
    kind = kind_of(scene, reading)
    if kind == "scene":
        only_for_particles(scene, **drawn, **reading)
        looked_at = subject.of(scene, words)
    else:
        with called(PARTICLE_KEYS):
            looked_at = (
                subject.of_mesh(Path(scene), drawn, words)
                if kind == "mesh"
                else subject.of_file(Path(scene), drawn, words, reading)
            )
    first = Session(looked_at, samples).scene
    with rendering.renderer() as renderer:
        renderer.prepare(first, "uint8")  # in this thread: see pocl.signals_kept()
        renderer.prepare(changed(first, samples=1), "uint8", alpha=False, passes=("id",))
        shown = View(renderer, lambda: Session(looked_at, samples), scene)
        with shown.listen(host, port) as listening:
            address = shown.address(listening)
            click.echo(address)
            if not rendering.quiet:
                say("Ctrl-C ends it")
            if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
                webbrowser.open(address)
            listening.serve_forever()

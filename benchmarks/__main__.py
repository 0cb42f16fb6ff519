"""python -m benchmarks: speed beside error, on this machine."""

import json
import subprocess
import sys
import time
from pathlib import Path

import click

from benchmarks import (
    accuracy,
    animation,
    atoms,
    features,
    harness,
    many,
    newcomer,
    peers,
    pictures,
    readme,
    samples,
    scale,
    shading,
    speed,
    targets,
    translucent,
    triangles,
    view,
    visibility,
)


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--quick", is_flag=True, help="Small and few: only shows that it runs.")
@click.pass_context
def main(context: click.Context, quick: bool) -> None:
    """Measures clrt on this machine; run it with nothing else running.

    Each part prints a table and writes benchmarks/results/<part>.json, which also says on what
    machine and with what versions. With --quick they go to a temporary folder.
    """
    context.obj = quick


main.add_command(accuracy.command)
main.add_command(animation.command)
main.add_command(atoms.command)
main.add_command(features.command)
main.add_command(many.command)
main.add_command(newcomer.command)
main.add_command(peers.command)
main.add_command(pictures.command)
main.add_command(readme.command)
main.add_command(samples.command)
main.add_command(scale.command)
main.add_command(shading.command)
main.add_command(speed.command)
main.add_command(targets.command)
main.add_command(triangles.command)
main.add_command(translucent.command)
main.add_command(view.command)
main.add_command(visibility.command)

SHOWN = {part for part, _ in readme.TABLES.values()} | {"pictures"}
PARTS = [name for name in main.commands if name in SHOWN]
"""Those of which README.md and docs/ show something; `many` measures what `files` shows."""


@main.command("all")
@click.option("--embree", type=click.Path(exists=True, path_type=Path), metavar="PROGRAM",
              help="As of `many`.")  # fmt: skip
@click.pass_obj
def every(quick: bool, embree: Path | None) -> None:
    """All parts that README.md and docs/ show, one after the other, and then their tables.

    It goes on where it was stopped: a part whose figures are of the clrt/ and kernels/ that are
    committed, and of this CPU, stays. One that was interrupted is measured from its start. It says
    how long the parts took when they were last measured. A part that fails, as `view` without
    Chromium, is named at the end.
    """
    times = harness.RESULTS / "seconds.json"
    seconds: dict[str, float] = json.loads(times.read_text()) if times.exists() else {}
    parts = [part for part in PARTS if quick or not is_of_today(part)]
    minutes = round(sum(seconds.get(part, 0.0) for part in parts) / 60)
    unknown = [part for part in parts if part not in seconds]
    click.echo(f"{len(parts)} of {len(PARTS)} parts, about {minutes} minutes", nl=False)
    click.echo(f", and nobody knows of {', '.join(unknown)}" if unknown else "")
    words = [sys.executable, "-m", "benchmarks", *(["--quick"] if quick else [])]
    failed = []
    for part in parts:
        more = ["--embree", str(embree)] if embree and part == "many" else []
        click.echo(
            f"\n{part}: some {seconds.get(part, '?')} s, from {time.strftime('%H:%M:%S')} on"
        )
        started = time.monotonic()
        if subprocess.run([*words, part, *more]).returncode:
            failed.append(part)
            continue
        seconds[part] = round(time.monotonic() - started)
        if not quick:
            times.write_text(json.dumps(seconds, indent=1, sort_keys=True) + "\n")
    if not quick:
        subprocess.run([*words, "readme"], check=True)
    if failed:
        sys.exit(f"not measured: {', '.join(failed)}")


def is_of_today(part: str) -> bool:
    """Whether a part's figures are of what is committed, and of this CPU."""
    path = harness.RESULTS / f"{part}.json"
    if not path.exists():
        return False
    measured, here = json.loads(path.read_text())["machine"], harness.machine()
    return all(measured.get(key) == here[key] for key in ("clrt", "code", "cpu", "device"))


if __name__ == "__main__":
    main()

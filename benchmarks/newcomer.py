"""A newcomer's first ten minutes: what README.md tells to do, in a fresh clone, with empty caches.

Each command is cold: nothing was installed, compiled or downloaded before, and no program of an
earlier command is of use to a later one unless it is the same.
"""

import os
import re
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from benchmarks import harness
from benchmarks.chromium import PROGRAM, Chromium

ROOT = Path(__file__).parents[1]
READY = "document.querySelector('button[name=save]:enabled') !== null"
SAID = ("what", "the command", "s")


def steps(readme: str) -> Iterator[tuple[str, str, dict[str, str]]]:
    """What each of README.md's steps is for, its command, and the files that it asks for."""
    install, _, picture = blocks(readme, "sh")[0].rpartition(" && ")
    yield "install", install, {}
    yield "the first picture", picture, {}
    shown = [line for line in blocks(readme, "")[0].splitlines() if line.startswith("clrt ")]
    commands = [re.split(r"\s{2,}", line)[0] for line in shown]
    for what, word in (("a figure from a .pdb", "render"), ("a view in a browser", "view"),
                       ("a video", "animate")):  # fmt: skip
        yield what, next(c for c in commands if c.split()[1] == word), {}
    yield "a figure from arrays", "python points.py", {"points.py": blocks(readme, "python")[0]}
    scene = re.search(r"`(clrt render scene\.toml[^`]*)`", readme)
    assert scene is not None
    yield "a scene", scene[1], {"scene.toml": blocks(readme, "toml")[0]}


def blocks(page: str, language: str) -> list[str]:
    found = re.findall(r"^```(\w*)\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    return [text.strip() for said, text in found if said == language]


@click.command("newcomer")
@click.pass_obj
def command(quick: bool) -> None:
    """Times what README.md tells to do, in a fresh clone with empty caches. Takes the network."""
    readme = (ROOT / "README.md").read_text()
    found = []
    with tempfile.TemporaryDirectory() as name:
        clone = Path(name) / "clrt"
        subprocess.run(["git", "clone", "-q", str(ROOT), str(clone)], check=True)
        environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
        path = [str(clone / ".venv/bin"), *environment["PATH"].split(":")]
        here = [part for part in path if not part.startswith(os.environ.get("VIRTUAL_ENV", "\0"))]
        environment |= {
            "PATH": ":".join(here),
            "XDG_CACHE_HOME": f"{name}/cache",
            "PIP_NO_CACHE_DIR": "1",
        }
        for what, words, files in steps(readme):
            for file, text in files.items():
                (clone / file).write_text(text + "\n")
            if " view " in words:
                seconds = viewed(words, clone, environment, Path(name))
            else:
                started = time.perf_counter()
                subprocess.run(
                    ["bash", "-c", words],
                    cwd=clone,
                    env=environment,
                    check=True,
                    stdout=subprocess.DEVNULL,
                )
                seconds = time.perf_counter() - started
            if seconds is not None:
                found.append({"what": what, "command": words, "seconds": seconds})
                print(f"{what}: {seconds:.1f} s", flush=True)
    print(tabulated({"steps": found}))
    harness.record(harness.results_folder(quick), "newcomer", {"steps": found})


def viewed(words: str, folder: Path, environment: dict[str, str], profile: Path) -> float | None:
    """Seconds until the page has its last picture; None without Chromium."""
    if PROGRAM is None:
        return None
    with Chromium(profile / "profile") as browser:
        started = time.perf_counter()
        run: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
        process = subprocess.Popen(
            words.split(), cwd=folder, env=environment, text=True, bufsize=1, **run
        )
        try:
            assert process.stdout is not None
            said = (re.search(r"http://\S+", line) for line in process.stdout)
            address = next(each[0] for each in said if each)
            page = browser.open(address)
            page.wait(READY, 120)
            return time.perf_counter() - started
        finally:
            process.terminate()
            process.wait()


def tabulated(figures: dict[str, Any]) -> str:
    rows = [
        (f["what"], f"`{f['command']}`".replace("|", "\\|"), f"{f['seconds']:.1f}")
        for f in figures["steps"]
    ]
    return harness.table(SAID, rows)

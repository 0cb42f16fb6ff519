"""The pictures of README.md and docs/, made anew by the commands that the pages give.

The file of results has their hashes: tests/test_readme.py fails where a page shows another one, or
one of an older version.
"""

import hashlib
import itertools
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path

import click
from PIL import Image

import clrt
from benchmarks import harness
from benchmarks.chromium import PROGRAM

ROOT = Path(__file__).parents[1]
PLOTS = ("benchmarks/results/", "docs/samples.webp", "docs/atoms.webp")
"""Pictures that other parts draw."""
QUALITY = {"million": 35, "orbital": 60}
"""Of .webp; 80 of all others."""
GALLERY = "--width 1200 --height 675"
SMALL = "--width 480 --height 270"
SCENE = "clrt render {0} -o scenes/{0}.png --width 960 --height {1}"
# What makes a picture, beside those of the gallery.
COMMANDS = {
    **{
        f"scenes/{name}.png": SCENE.format(name, height)
        for name, height in (
            *(("first-result", 540), ("four-spheres", 540), ("glass", 480), ("lights", 360)),
            *(("orbit", 540), ("sunflower", 540)),
        )
    },
    "scenes/shading.png": "clrt render shading -o scenes/shading.png --width 1200 --height 338",
    "scenes/orbit.webp": f"clrt animate orbit -o scenes/orbit.webp --step 2 {SMALL}",
    "scenes/gyroid.webp": "python examples/gyroid.py",
    "docs/linear.png": f"clrt render -o docs/linear.png {SMALL}",
    "docs/srgb.png": f"clrt render -o docs/srgb.png {SMALL} --transfer srgb",
    "docs/color-bar.png": "python examples/color_bar.py",
    "docs/opacity.webp": "python examples/protein_in_water.py",
    "docs/words.png": "python examples/words.py",
    "docs/visible-surfaces.png": "python examples/visible_surfaces.py",
    "docs/view.webp": "scripts/view_picture",
}


@click.command("pictures")
@click.argument("words", nargs=-1, metavar="[WORD]...")
@click.pass_obj
def command(quick: bool, words: tuple[str, ...]) -> None:
    """Makes the pictures of the pages anew; with WORDs only those whose path has one of them."""
    made = iter(()) if quick else itertools.chain(others(words), gallery(words))
    for path in made:
        print(f"{path}: {(ROOT / path).stat().st_size / 1e3:.0f} kB", flush=True)
    hashes = {path: hashed(path) for path in sorted(shown()) if not path.startswith(PLOTS)}
    if not words:
        harness.record(harness.results_folder(quick), "pictures", {"pictures": hashes})


def shown() -> set[str]:
    """The pictures that the pages show."""
    found = set()
    for page in (ROOT / "README.md", *(ROOT / "docs").glob("*.md")):
        for name in re.findall(r"!\[.*?\]\((.*?)\)", page.read_text()):
            found.add(os.path.relpath(page.parent / name, ROOT))
    return found


def hashed(path: str) -> str:
    return hashlib.sha256((ROOT / path).read_bytes()).hexdigest()[:16]


def wanted(path: str, words: Iterable[str]) -> bool:
    return not words or any(word in path for word in words)


def run(words: str, folder: Path) -> None:
    """With this environment's commands."""
    bin = Path(sys.executable).parent
    path = {"PATH": f"{bin}:{os.environ['PATH']}"}
    subprocess.run(shlex.split(words), cwd=folder, check=True, env=os.environ | path)


def others(words: tuple[str, ...]) -> Iterator[str]:
    """Makes those beside the gallery, and gives their paths."""
    for path, line in COMMANDS.items():
        if not wanted(path, words) or (path == "docs/view.webp" and PROGRAM is None):
            continue
        if not line.startswith("python "):
            run(line, ROOT)
        else:
            with tempfile.TemporaryDirectory() as folder:
                run(line.replace("examples/", f"{ROOT}/examples/"), Path(folder))
                (made,) = Path(folder).glob("*.png")
                keep(made, ROOT / path)
        yield path


def gallery(words: tuple[str, ...]) -> Iterator[str]:
    """Runs the gallery's programs, and the commands whose output has the name of a picture."""
    page = (ROOT / "docs" / "gallery.md").read_text()
    pictures = {Path(name).stem: name for name in re.findall(r"!\[\]\((gallery/.*?)\)", page)}
    plot, here = clrt.plot, Path.cwd()
    variables: dict[str, object] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "scenes").symlink_to(ROOT / "scenes")
        os.chdir(folder)
        clrt.plot = lambda *what, **how: None  # type: ignore[assignment]
        try:
            for kind, text in re.findall(r"^```(\w+)\n(.*?)^```", page, re.DOTALL | re.MULTILINE):
                if kind == "python":
                    exec(text, variables)
                    continue
                for line in text.splitlines():
                    output = Path(shlex.split(line)[shlex.split(line).index("-o") + 1])
                    path = f"docs/{pictures.get(output.stem)}"
                    if output.stem not in pictures or not wanted(path, words):
                        continue
                    run(line if "--width" in line else f"{line} {GALLERY}", folder)
                    keep(folder / output, ROOT / path)
                    yield path
        finally:
            os.chdir(here)
            clrt.plot = plot


def keep(made: Path, path: Path) -> None:
    """Moves a picture to its place; one that has another suffix there is converted."""
    if made.suffix == path.suffix:
        path.write_bytes(made.read_bytes())
    else:
        Image.open(made).save(path, quality=QUALITY.get(path.stem, 80), method=6)

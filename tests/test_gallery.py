"""The gallery: its commands and programs run, one after the other, and agree."""

import inspect
import re
import shlex
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

import clrt
from clrt.commands.cli import main

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "gallery.md").read_text()


def test_the_gallery(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Smaller than the page says. A call gives the picture of the command beside it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    plot, renderer = clrt.plot, clrt.Renderer()
    small = {"size": (64, 36), "samples": 1, "renderer": renderer}
    shown: list[clrt.Picture] = []
    monkeypatch.setattr(
        clrt, "plot", lambda *what, **how: shown.append(plot(*what, **{**how, **small}))
    )
    variables: dict[str, object] = {}
    exec(PAGE.partition("```python\n")[2].partition("```")[0], variables)
    recipes = re.findall(r"^## .*?(?=^## |\Z)", PAGE, re.DOTALL | re.MULTILINE)
    assert len(recipes) >= 13
    compared = 0
    for recipe in recipes:
        blocks = re.findall(r"^```(python|sh)\n(.*?)^```", recipe, re.DOTALL | re.MULTILINE)
        assert blocks, recipe
        still = None
        shown.clear()
        for kind, text in blocks:
            if kind == "python":
                exec(text, variables)
                continue
            for line in text.splitlines():
                words = [*shlex.split(line)[1:], "--width", "64", "--height", "36"]
                done = CliRunner().invoke(main, [*words, "--samples", "1"])
                assert done.exit_code == 0, done.stderr
                name = words[words.index("-o") + 1]
                still = Path(name) if words[0] == "render" else None
        if still is not None and shown:
            assert still.read_bytes() == shown[-1]._repr_png_(), recipe
            compared += 1
    assert compared >= 10


def test_the_commands_of_how_do_i_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    commands = re.findall(r"^clrt render .*", (ROOT / "docs/howto.md").read_text(), re.MULTILINE)
    assert len(commands) == 2
    for command in commands:
        words = [*shlex.split(command)[1:], "--width", "64", "--height", "36", "--samples", "1"]
        words[words.index("-o") + 1] = str(tmp_path / "shown.png")
        done = CliRunner().invoke(main, words)
        assert done.exit_code == 0, done.stderr


def test_the_words_of_how_do_i_are_there() -> None:
    """Options that `clrt render` takes as they stand in the tables, keywords of clrt.plot."""
    page = (ROOT / "docs/howto.md").read_text()
    options = re.findall(r"`(--[^`]+)`", page)
    assert len(options) > 15
    render = main.get_command(click.Context(main), "render")
    assert render is not None
    for words in options:
        render.make_context("render", ["four-spheres", *shlex.split(words)])
    answers = [line.split("|")[2] for line in page.splitlines() if line.startswith("|")]
    keywords = re.findall(r"[`(, ](\w+)=", " ".join(answers))
    assert len(keywords) > 10
    assert set(keywords) <= set(inspect.signature(clrt.plot).parameters)


def test_the_pictures_are_the_gallerys() -> None:
    shown = set(re.findall(r"!\[\]\(gallery/(.*?)\)", PAGE))
    assert shown == {path.name for path in (ROOT / "docs" / "gallery").iterdir()}


def test_the_data_is_small_and_its_source_is_said() -> None:
    folder = ROOT / "scenes" / "data"
    said = (folder / "README.md").read_text()
    for path in (*folder.glob("*.npz"), *folder.glob("*.gz")):
        assert path.stat().st_size < 1e6
        assert f"`{path.name}`" in said

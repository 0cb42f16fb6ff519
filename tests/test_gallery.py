"""The gallery: its commands and programs run, one after the other."""

import re
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner

import clrt
from clrt.commands.cli import main

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "gallery.md").read_text()


def test_the_gallery(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Smaller than the page says."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    (tmp_path / "docs" / "gallery").mkdir(parents=True)
    plot, renderer = clrt.plot, clrt.Renderer()
    small = {"size": (64, 36), "samples": 1, "renderer": renderer}
    monkeypatch.setattr(clrt, "plot", lambda *what, **how: plot(*what, **{**how, **small}))
    variables: dict[str, object] = {}
    recipes = re.findall(r"^## .*?(?=^## |\Z)", PAGE, re.DOTALL | re.MULTILINE)
    assert len(recipes) >= 10
    for recipe in recipes:
        blocks = re.findall(r"^```(python|sh)\n(.*?)^```", recipe, re.DOTALL | re.MULTILINE)
        assert blocks, recipe
        for kind, text in blocks:
            if kind == "python":
                exec(text, variables)
                continue
            for line in text.splitlines():
                words = [*shlex.split(line)[1:], "--width", "64", "--height", "36"]
                done = CliRunner().invoke(main, [*words, "--samples", "1"])
                assert done.exit_code == 0, done.stderr


def test_the_pictures_are_the_gallerys() -> None:
    shown = set(re.findall(r"!\[\]\(gallery/(.*?)\)", PAGE))
    assert shown == {path.name for path in (ROOT / "docs" / "gallery").iterdir()}


def test_the_data_is_small_and_its_source_is_said() -> None:
    folder = ROOT / "scenes" / "data"
    said = (folder / "README.md").read_text()
    for path in folder.glob("*.npz"):
        assert path.stat().st_size < 1e6
        assert f"`{path.name}`" in said

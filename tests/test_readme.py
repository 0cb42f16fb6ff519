"""The tables of README.md and docs/ say what benchmarks/results/ says."""

import json
import shutil
from pathlib import Path

import clrt
from benchmarks import harness, newcomer, pictures, readme


def test_no_table_is_stale() -> None:
    """Else: python -m benchmarks readme."""
    assert not readme.stale(readme.pages())


def test_every_table_is_in_one_page() -> None:
    text = "".join(page.read_text() for page in readme.pages())
    for name in readme.TABLES:
        assert text.count(f"<!-- {name} -->\n") == text.count(f"<!-- /{name} -->\n") == 1, name


def test_changed_figures_make_a_table_stale(tmp_path: Path) -> None:
    results = tmp_path / "results"
    shutil.copytree(harness.RESULTS, results)
    figures = json.loads((results / "peers.json").read_text())
    figures["peers"][0]["median"] *= 1.5
    (results / "peers.json").write_text(json.dumps(figures))
    found = readme.stale(readme.pages(), results)
    assert [page.name for page in found] == ["README.md", "speed.md"]
    for page, text in found.items():  # written, it is stale no more
        copy = tmp_path / page.name
        copy.write_text(text)
        assert not readme.stale([copy], results)


def test_numbers() -> None:
    assert readme.number(1413.06) == "1,413"
    assert readme.number(0.02436) == "0.0244"


def test_every_picture_has_what_makes_it() -> None:
    """Else: a line in benchmarks/pictures.py, or a recipe in docs/gallery.md."""
    made = {path for path in pictures.shown() if not path.startswith(pictures.PLOTS)}
    assert {path for path in made if "/gallery/" not in path} == made & set(pictures.COMMANDS)


def test_the_readme_gives_each_step_of_a_newcomer() -> None:
    steps = list(newcomer.steps((readme.ROOT / "README.md").read_text()))
    assert [words.split()[:2] for _, words, _ in steps] == [
        ["python3", "-m"],
        [".venv/bin/clrt", "render"],
        ["clrt", "render"],
        ["clrt", "view"],
        ["clrt", "animate"],
        ["python", "points.py"],
        ["clrt", "render"],
    ]


def test_no_table_or_picture_is_of_another_version() -> None:
    """Else: python -m benchmarks all."""
    parts = {part for part, _ in readme.TABLES.values()} | {"pictures"}
    said = {part: json.loads((harness.RESULTS / f"{part}.json").read_text()) for part in parts}
    versions = {part: figures["machine"]["clrt"] for part, figures in said.items()}
    assert versions == dict.fromkeys(parts, clrt.__version__)
    shown = {path for path in pictures.shown() if not path.startswith(pictures.PLOTS)}
    assert said["pictures"]["pictures"] == {path: pictures.hashed(path) for path in shown}

"""What `import clrt` gives, and that what the README and examples/ say runs."""

import re
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

import clrt

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
RUN_ELSEWHERE = ["cluster"]  # programs that start others: tests/test_cluster.py


def test_every_public_name_is_there() -> None:
    assert clrt.__all__ == sorted(clrt.__all__)
    for name in clrt.__all__:
        assert getattr(clrt, name) is not None
    assert clrt.__version__ == version("clrt")
    with pytest.raises(AttributeError):
        clrt.nothing_of_the_kind  # noqa: B018


def test_every_documented_dotted_name_is_there() -> None:
    """After `import clrt` alone, each in a process that has imported nothing else."""
    told = "\n".join(path.read_text() for path in [*PAGES, *(ROOT / "examples").glob("*.py")])
    names = set(re.findall(r"\bclrt(?:\.[A-Za-z_]\w*)+", told)) - {"clrt.toml"}
    assert {"clrt.color.linear", "clrt.figure.Look", "clrt.decor.legend"} <= names
    code = "import importlib, sys\n" + "".join(
        "for one in [m for m in sys.modules if m.split('.')[0] == 'clrt']: del sys.modules[one]\n"
        f"import clrt\n{name}\n"
        for name in sorted(names)
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    "page",
    [page for page in PAGES if page.stem not in RUN_ELSEWHERE],
    ids=lambda page: page.stem,
)
def test_what_a_page_says_runs(page: Path, tmp_path: Path, monkeypatch) -> None:
    """All its Python, one block after the other."""
    if page.stem == "gallery":
        pytest.skip("tests/test_gallery.py runs it")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    blocks = re.findall(r"^```python\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE)
    exec("\n".join(blocks), {})


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_page_leads_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\((?!https?:)(.*?)\)", page.read_text()):
        assert (page.parent / target.partition("#")[0]).exists(), target


def test_the_readme_is_short() -> None:
    assert len((ROOT / "README.md").read_text().splitlines()) <= 140


SMALLER = """
import clrt, runpy, sys
render, plot = clrt.render, clrt.plot
clrt.render = lambda scene, width, height, **how: render(scene, width // 3, height // 3, **how)
clrt.plot = lambda *what, **how: plot(*what, **{**how, "size": (320, 180)})
runpy.run_path(sys.argv[1], run_name="__main__")
"""


@pytest.mark.parametrize("path", sorted((ROOT / "examples").glob("*.py")), ids=lambda p: p.stem)
def test_an_example_runs(path: Path, tmp_path: Path) -> None:
    words = [sys.executable, "-c", SMALLER, str(path)]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert list(tmp_path.iterdir()) or done.stdout

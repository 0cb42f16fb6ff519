"""What `import clrt` gives, and that what the README and examples/ say runs."""

import re
import runpy
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

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


@pytest.mark.parametrize("path", sorted((ROOT / "examples").glob("*.py")), ids=lambda p: p.stem)
def test_an_example_runs(
    path: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """With fewer pixels and samples than it says."""
    render, plot = clrt.render, clrt.plot

    def smaller(scene: Any, width: int, height: int, **how: Any) -> Any:
        one = scene if isinstance(scene, str) else replace(scene, samples=1)
        return render(one, width // 3, height // 3, **how)

    small = {"size": (320, 180), "samples": 1}
    monkeypatch.setattr(clrt, "render", smaller)
    monkeypatch.setattr(clrt, "plot", lambda *what, **how: plot(*what, **{**how, **small}))
    monkeypatch.chdir(tmp_path)
    try:
        runpy.run_path(str(path), run_name="__main__")
    except SystemExit as ended:  # it lacks what it uses, and says so
        if ended.code:
            raise
    assert list(tmp_path.iterdir()) or capsys.readouterr().out

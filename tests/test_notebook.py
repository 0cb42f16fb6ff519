"""A scene on a canvas among the cells of a notebook."""

import asyncio
import subprocess
import sys
import time
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

import clrt
from benchmarks import chromium, jupyter
from benchmarks.chromium import CONTROL, PIXELS, Chromium, Page
from clrt.viewer import orbit

MARIMO = """
import marimo

app = marimo.App()

@app.cell
def _():
    import clrt
    clrt.show("four-spheres")

app.run() if __name__ == "__main__" else None
"""
# Marimo keeps what a cell shows in shadow trees.
FIND = """(function find(node) {
  for (const element of node.querySelectorAll("*")) {
    if (element.matches(".clrt-view")) return element;
    const found = element.shadowRoot && find(element.shadowRoot);
    if (found) return found;
  }
})(document)"""
READY = f"(view => view && !view.querySelector('button[name=save]').disabled)({FIND})"


def test_each_view_is_painted() -> None:
    async def shown() -> None:
        canvas = clrt.show(clrt.load_scene("four-spheres"))
        sent: asyncio.Queue[tuple[dict[str, Any], list[bytes]]] = asyncio.Queue()
        canvas.send = lambda content, files: sent.put_nowait((content, files))

        def say(view: str, message: object) -> None:
            canvas._heard(canvas, {"view": view, "message": message}, [])

        say("a", None)
        say("b", None)
        for _ in "ab":
            content, _ = await asyncio.wait_for(sent.get(), 30)
            assert content["header"]["about"]["spheres"] == 4
        say("a", {"do": "resize", "width": 40, "height": 20})
        while True:
            content, files = await asyncio.wait_for(sent.get(), 60)
            assert content["view"] == "a"
            assert "error" not in content["header"]
            if "preview" in content["header"]:
                continue
            say("a", {"do": "shown", "number": content["header"]["number"]})
            if content["header"]["final"]:
                break
        assert files[0].startswith(b"\x89PNG")
        assert content["header"]["command"] == ""  # it is no file
        say("a", False)
        say("b", False)
        say("b", {"do": "reset"})  # too late
        assert not canvas._painters

    asyncio.run(shown())


def test_outside_of_a_notebook() -> None:
    with pytest.raises(clrt.RequestError, match="in a notebook"):
        clrt.show("four-spheres")


def test_without_anywidget(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "clrt.viewer.canvas", None)
    with pytest.raises(clrt.RequestError, match="pip install anywidget"):
        clrt.show("four-spheres")


@pytest.fixture
def page(tmp_path: Path) -> Iterator[Page]:
    """A notebook of Marimo."""
    if chromium.PROGRAM is None or find_spec("marimo") is None:
        pytest.skip("no chromium or no marimo")
    (tmp_path / "notebook.py").write_text(MARIMO)
    words = ["run", "notebook.py", "--headless", "--no-token", "--port", "0"]
    with (tmp_path / "log").open("wb") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", "marimo", *words], cwd=tmp_path, stdout=log, stderr=log
        )
    try:
        while "http://" not in (said := (tmp_path / "log").read_text()):
            assert process.poll() is None, said
            time.sleep(0.1)
        address = said.partition("http://")[2].split()[0]
        with Chromium(tmp_path / "profile", (900, 700)) as browser:
            yield browser.open(f"http://{address}")
    finally:
        process.terminate()
        process.wait()


def expected(width: int, height: int) -> np.ndarray:
    """What a canvas of this size shows at first."""
    scene = clrt.load_scene("four-spheres")
    camera = orbit.held(scene.camera, (16, 9), (width, height))
    return clrt.render(replace(scene, camera=camera), width, height, dtype="uint8")


@pytest.mark.slow
def test_marimo(page: Page) -> None:
    page.wait(READY, 60)
    canvas = f"{FIND}.querySelector('canvas')"
    width, height, pixels = page.value(f"{PIXELS}({canvas})")
    seen = np.array(pixels, np.uint8).reshape(height, width, 4)[..., :3]
    assert (seen == expected(width, height)).all()
    x, y = page.value(f"(b => [b.x + 100, b.y + 100])({canvas}.getBoundingClientRect())")
    page.drag((x, y), (x + 20, y), (x + 60, y + 10))
    page.wait(READY)
    page.value(f"{FIND}.querySelector('button[name=command]').click()")
    assert "position" in page.value(f"{FIND}.querySelector('pre').textContent")


CELLS = [
    "import clrt\nclrt.show('four-spheres')",
    "clrt.show(clrt.Particles([[0, 0, 0], [1, 0, 0]], radii=0.6))",
    # Jupyter starts threads as well.
    "import gc, threading\ngc.collect()\n"
    "print(sum('(_' in each.name for each in threading.enumerate()), sum("
    "1 for each in gc.get_objects() if type(each).__name__ == 'Session'), flush=True)",
    "import sys, time\nfor _ in range(8):\n    print('x' * 1_000_000); time.sleep(0.1)",
]
CELL_COUNT = "document.querySelectorAll('.jp-Cell').length"
IN_JUPYTER = f"!!{jupyter.VIEW}?.querySelector('button[name=save]:enabled')"
BOTH = "document.querySelectorAll('.clrt-view button[name=save]:enabled').length === 2"
PRINTED = (
    "[...document.querySelectorAll('.jp-OutputArea-output pre')].map(e => e.textContent.trim())"
    ".find(text => /^\\d+ \\d+$/.test(text)) ?? ''"
)
CANVAS = f"{jupyter.VIEW}.querySelector('canvas')"
STATUS = f"{jupyter.VIEW}.querySelector('[role=status]').value"


@pytest.fixture(params=["lab", "notebook"])
def book(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Page]:
    """A notebook of Jupyter, whose first cell was run."""
    if (
        chromium.PROGRAM is None
        or find_spec({"lab": "jupyterlab"}.get(request.param, "notebook")) is None
    ):
        pytest.skip("no chromium or no Jupyter")
    jupyter.written(tmp_path / "book.ipynb", CELLS)
    with (
        jupyter.served(tmp_path, request.param) as address,
        Chromium(tmp_path / "profile", (1200, 900)) as browser,
    ):
        page = browser.open(address)
        jupyter.opened(page)
        jupyter.run(page, 0)
        page.wait(IN_JUPYTER, 60)
        yield page


def middle(page: Page) -> tuple[float, float]:
    x, y = page.value(
        f"(b => [b.x + b.width / 2, b.y + b.height / 2])({CANVAS}.getBoundingClientRect())"
    )
    return x, y


@pytest.mark.slow
def test_jupyter(book: Page) -> None:
    width, height, pixels = book.value(f"{PIXELS}({CANVAS})")
    seen = np.array(pixels, np.uint8).reshape(height, width, 4)[..., :3]
    assert (seen == expected(width, height)).all()
    # Keys are the canvas's own: b adds a cell there, and d d deletes one.
    x, y = middle(book)
    book.drag((x, y), (x + 1, y))
    before = book.value(CELL_COUNT)
    for key in "oabsddmyxq":
        book.key(key)
    assert book.value(CELL_COUNT) == before
    book.wait(IN_JUPYTER)
    # Two canvases: each is drawn, and run again five times they leave nothing behind.
    jupyter.run(book, 1)
    book.wait(BOTH, 60)
    jupyter.run(book, 2)
    before = book.wait(PRINTED)
    for _ in range(5):
        jupyter.run(book, 1)
        book.wait(BOTH, 60)
    book.value("document.querySelectorAll('.jp-OutputArea-output pre').forEach(e => e.remove())")
    jupyter.run(book, 2)
    assert book.wait(PRINTED) == before
    # Nor does a tab that is reloaded.
    book.key("s", CONTROL)
    book.value("new Promise(done => setTimeout(done, 1000))")
    book.value("window.old = true")
    book.do("Page.reload")
    book.wait("!window.old")
    jupyter.opened(book)
    book.wait(BOTH, 60)
    book.value("document.querySelectorAll('.jp-OutputArea-output pre').forEach(e => e.remove())")
    jupyter.run(book, 2)
    assert book.wait(PRINTED) == before
    # jupyter_server drops pictures while a cell prints much.
    jupyter.run(book, 3)
    for step in range(40):
        book.drag((x, y), (x + 10, y + step % 3))
        book.value("new Promise(done => setTimeout(done, 50))")
    book.wait(IN_JUPYTER, 20)
    # A kernel that has gone says so.
    jupyter.restart(book)
    book.wait(f"{STATUS} === 'the kernel has gone: run the cell again'")
    book.drag((x, y), (x + 30, y))
    assert book.value(STATUS) == "the kernel has gone: run the cell again"

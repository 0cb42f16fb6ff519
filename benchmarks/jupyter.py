"""Jupyter: a notebook in JupyterLab or Notebook, in Chromium, whose cells are run there."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

from benchmarks.chromium import CONTROL, Page

App = Literal["lab", "notebook"]
PATIENCE = 0.5
WHERE = {"lab": "lab/tree", "notebook": "notebooks"}


def written(path: Path, cells: Sequence[str]) -> None:
    """A notebook of cells of code."""
    bare: dict[str, Any] = {
        "cell_type": "code",
        "execution_count": None,
        "metadata": {},
        "outputs": [],
    }
    made = [{**bare, "id": f"c{i}", "source": text} for i, text in enumerate(cells)]
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    book = {"nbformat": 4, "nbformat_minor": 5, "metadata": {"kernelspec": kernel}, "cells": made}
    path.write_text(json.dumps(book))


@contextmanager
def served(folder: Path, app: App, port: int = 0) -> Iterator[str]:
    """The address of the notebook `book.ipynb` in a folder."""
    own = {f"JUPYTER_{name}_DIR": str(folder / name) for name in ("CONFIG", "RUNTIME", "DATA")}
    words = [app, "--no-browser", "--allow-root", f"--ServerApp.port={port}"]
    words += ["--ServerApp.token=", "--ServerApp.password=", f"--ServerApp.root_dir={folder}"]
    words += ["--LabApp.news_url=None", "--LabApp.check_for_updates_class="
              "jupyterlab.handlers.announcements.NeverCheckForUpdate"]  # fmt: skip
    log = folder / "log"
    with log.open("wb") as file:
        process = subprocess.Popen(
            [sys.executable, "-m", "jupyter", *words],
            stdout=file, stderr=file, env=os.environ | own, cwd=folder,
        )  # fmt: skip
    try:
        while "http://127.0.0.1" not in (said := log.read_text()):
            assert process.poll() is None, said
            time.sleep(0.1)
        host = said.partition("http://127.0.0.1:")[2].split("/")[0]
        yield f"http://127.0.0.1:{host}/{WHERE[app]}/book.ipynb"
    finally:
        # Asked to end while its kernel restarts it would never do so. Without it the kernel ends.
        process.kill()
        process.wait()


VIEW = "document.querySelector('.clrt-view')"
IDLE = "!!document.querySelector('.jp-Notebook-ExecutionIndicator[data-status=idle]')"
DIALOG = "document.querySelector('.jp-Dialog .jp-mod-accept')"  # which kernel?


def opened(page: Page) -> None:
    """Waits until the notebook has its kernel."""
    page.wait(f"{IDLE} || !!{DIALOG}", 60)
    page.value("new Promise(done => setTimeout(done, 1000))")
    page.value(f"{DIALOG}?.click()")
    page.wait(f"{IDLE} && !{DIALOG}", 30)


def run(page: Page, cell: int) -> None:
    """Runs a cell."""
    at = f"document.querySelectorAll('.jp-CodeCell')[{cell}]"
    prompt = f"{at}.querySelector('.jp-InputPrompt').textContent"
    before = json.dumps(page.value(prompt))
    for _ in range(5):  # a dialog may come late
        page.value(f"{DIALOG}?.click()")
        page.value(f"{at}.querySelector('.cm-content').focus()")
        page.key("Enter", CONTROL)
        page.value(f"new Promise(done => setTimeout(done, {1000 * PATIENCE}))")
        if page.value(f"{prompt} !== {before}"):
            return
    raise RuntimeError(f"cell {cell} does not run")


def restart(page: Page) -> None:
    """Restarts the kernel."""
    button = "document.querySelector('[data-command=\"notebook:restart-kernel\"]')"
    x, y = page.value(f"(b => [b.x + 9, b.y + 9])({button}.getBoundingClientRect())")
    page.drag((x, y), (x, y))
    page.wait(f"!!{DIALOG}", 10)
    page.value(f"{DIALOG}.click()")
    page.wait(f"!{DIALOG}")

"""How soon a picture follows the pointer: the view in Chromium, beside a picture that is there.

Times are those of the page: from the pointer's event to the frame after the picture was drawn.
"""

import importlib.util
import json
import multiprocessing
import signal
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import click
import numpy as np

import clrt
from benchmarks import harness, jupyter, many
from benchmarks.chromium import Chromium, Page
from clrt.figure import compose
from clrt.figure.compose import Look
from clrt.scene.scene import Scene
from clrt.viewer.server import View
from clrt.viewer.session import Session
from clrt.viewer.subject import Subject

SIZE = (1920, 1080)
EVENTS = 1 / 60
"""Seconds between two of the pointer's."""

# `painted` is called in the task after the frame that shows what was drawn.
SCRIPT = """
const channel = new MessageChannel(), waiting = [];
channel.port1.onmessage = () => waiting.shift()(performance.now());
window.painted = () => new Promise((done) => requestAnimationFrame(() => {
  waiting.push(done);
  channel.port2.postMessage(0);
}));
window.stamps = [];   // of the change of each number, from 1 on
const send = WebSocket.prototype.send;
WebSocket.prototype.send = function (text) {
  if (!/"(shown|pick)"/.test(text)) window.stamps.push(window.event?.timeStamp);
  send.call(this, text);
};
const decode = window.createImageBitmap;
let got;
window.createImageBitmap = (file, options) => {
  got = performance.now();
  if (file.type === "image/jpeg") window.last = file;
  return decode(file, options);
};
window.seen = [];
document.addEventListener("picture", async ({ detail }) => {
  const came = got, at = await window.painted();
  window.seen.push({ ...detail, came, at });
});
"""

# The same as the view does, with a picture that is there.
STILL = """
(() => {
  const canvas = document.querySelector("canvas");
  const context = canvas.getContext("bitmaprenderer");
  window.still = [];
  window.follow = async (event) => {
    const bitmap = await createImageBitmap(window.last, { colorSpaceConversion: "none" });
    context.transferFromImageBitmap(bitmap);
    window.still.push(await window.painted() - event.timeStamp);
  };
  canvas.addEventListener("pointermove", window.follow);
})()
"""


def molecule() -> Scene:
    """10⁵ atoms."""
    return many.scene_of(many.molecule(100_000), 1)


def gas() -> Scene:
    """3,000 spheres, as BOOK has them."""
    random = np.random.default_rng(1)
    particles = clrt.Particles(random.uniform(0, 15, (3000, 3)), radii=0.5)
    return compose.scene(particles, Look())


SCENES: dict[str, Callable[[], Scene]] = {
    "four-spheres": lambda: clrt.load_scene("four-spheres"),
    "10⁵ atoms": molecule,
}
OTHERS = SCENES | {"3,000 spheres": gas}


def serve(name: str, told: Connection) -> None:
    """Shows a scene until it is interrupted."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit())
    scene = OTHERS[name]()
    subject = Subject((name,), lambda frame: scene)
    with clrt.Renderer() as renderer:
        view = View(renderer, lambda: Session(subject), name)
        with view.listen("127.0.0.1", 0) as listening:
            told.send(view.address(listening))
            listening.serve_forever()


@contextmanager
def shown(name: str) -> Iterator[str]:
    """The address of a view in a process of its own."""
    told, tell = multiprocessing.Pipe(duplex=False)
    process = multiprocessing.get_context("spawn").Process(target=serve, args=(name, tell))
    process.start()
    try:
        yield told.recv()
    finally:
        process.terminate()
        process.join()


def wander(
    page: Page, seconds: float, buttons: int, start: tuple[float, float] = (700, 500)
) -> float:
    """Moves the pointer to the right, again and again; returns how long it took."""
    left: dict[str, Any] = {"button": "left" if buttons else "none", "buttons": buttons}
    started = due = time.perf_counter()
    while due < started + seconds:
        step = round((due - started) / EVENTS)
        page.mouse("Moved", start[0] + 4 * (step % 120), start[1] + step % 7, **left)
        due += EVENTS
        time.sleep(max(due - time.perf_counter(), 0))
    return time.perf_counter() - started


def measure(browser: Chromium, name: str, seconds: float) -> dict[str, Any]:
    with shown(name) as address:
        page = browser.open("about:blank")
        page.do("Page.addScriptToEvaluateOnNewDocument", source=SCRIPT)
        page.resize(SIZE[0], SIZE[1] + 100)
        page.do("Page.navigate", url=address)
        page.wait("window.seen?.some(({ final }) => final)")
        height = page.value("document.querySelector('canvas').clientHeight")
        page.resize(SIZE[0], 2 * SIZE[1] + 100 - height)
        page.wait("document.querySelector('canvas').clientHeight === " + str(SIZE[1]))
        left: dict[str, Any] = {"button": "left", "buttons": 1, "clickCount": 1}
        page.mouse("Pressed", 700, 500, **left)
        wander(page, 1.0, 1)  # until its size is found
        page.value("(() => { window.seen = []; window.first = window.stamps.length; })()")
        took = wander(page, seconds, 1)
        found = json.loads(page.value("JSON.stringify([window.first, window.stamps, window.seen])"))
        page.mouse("Released", 700, 500, **left)
        page.wait("(window.seen.at(-1) ?? {}).final")
        page.value(STILL)
        wander(page, seconds, 0)
        still = page.value("window.still")
        page.close()
    first, stamps, seen = found
    return figures(first, stamps, seen, still, took)


def figures(
    first: int, stamps: list[float], seen: list[dict[str, Any]], still: list[float], took: float
) -> dict[str, Any]:
    """Of all changes after the first ones, those that were shown: in seconds."""
    moving = [picture for picture in seen if picture["moves"]]
    late = []
    change = first
    for picture in moving:
        while change < picture["changes"]:
            late.append((picture["at"] - stamps[change]) / 1e3)
            change += 1
    return {
        "size": statistics.mode(tuple(picture["size"]) for picture in moving),
        "fps": len(moving) / took,
        "latency": harness.summary(late),
        "still": harness.summary([ms / 1e3 for ms in still]),
        "render": statistics.median(picture["render"] for picture in moving),
        "encode": statistics.median(picture["encode"] for picture in moving),
        "show": statistics.median(picture["at"] - picture["came"] for picture in moving) / 1e3,
    }


PICTURES = "document.addEventListener('picture', ({ detail }) => (window.seen ??= []).push(detail))"
BOOK = """import clrt, numpy as np
random = np.random.default_rng(1)
clrt.show(clrt.Particles(random.uniform(0, 15, (3000, 3)), radii=0.5))"""
CANVAS = "document.querySelector('.clrt-view canvas')"
FINAL = "(window.seen?.at(-1) ?? {}).final"


def fluency(page: Page, seconds: float) -> dict[str, Any]:
    """Pictures a second while the pointer goes round, and what takes their time."""
    page.value(PICTURES)
    x, y, wide, high = page.value(
        f"(b => [b.x + b.width / 2, b.y + b.height / 2, b.width, b.height])"
        f"({CANVAS}.getBoundingClientRect())"
    )
    left: dict[str, Any] = {"button": "left", "buttons": 1, "clickCount": 1}
    page.mouse("Pressed", x, y, **left)
    wander(page, 1.0, 1, (x, y))
    page.value("window.seen = []")
    took = wander(page, seconds, 1, (x, y))
    seen = [each for each in page.value("window.seen") if each["moves"]]
    page.mouse("Released", x, y, **left)
    page.wait(FINAL)
    return {
        "canvas": (round(wide), round(high)),
        "size": statistics.mode(tuple(picture["size"]) for picture in seen),
        "fps": len(seen) / took,
        "render": statistics.median(picture["render"] for picture in seen),
        "encode": statistics.median(picture["encode"] for picture in seen),
    }


def measure_notebook(browser: Chromium, folder: Path, seconds: float) -> dict[str, dict[str, Any]]:
    """3,000 spheres in JupyterLab, and in the page with a canvas of the same size."""
    found = {}
    jupyter.written(folder / "book.ipynb", [BOOK])
    with jupyter.served(folder, "lab") as address:
        page = browser.open("about:blank")
        page.resize(1300, 800)
        page.do("Page.navigate", url=address)
        jupyter.opened(page)
        jupyter.run(page, 0)
        page.wait("document.querySelector('.clrt-view button[name=save]:enabled') !== null", 60)
        found["JupyterLab"] = fluency(page, seconds)
        page.close()
    wide, high = found["JupyterLab"]["canvas"]
    with shown("3,000 spheres") as address:
        page = browser.open(address)
        page.resize(wide, high)
        page.wait("document.querySelector('button[name=save]:enabled') !== null", 60)
        bar = page.value(f"innerHeight - {CANVAS}.clientHeight")
        page.resize(wide, high + bar)
        page.wait(f"{CANVAS}.clientHeight === {high}")
        page.wait("document.querySelector('button[name=save]:enabled') !== null", 60)
        found["the page"] = fluency(page, seconds)
        page.close()
    return found


@click.command("view")
@click.pass_obj
def command(quick: bool) -> None:
    """Times how soon pictures follow the pointer; needs Chromium (Debian's), and takes JupyterLab
    if it is there."""
    found, beside = {}, {}
    with tempfile.TemporaryDirectory() as profile, Chromium(Path(profile), SIZE) as browser:
        for name in SCENES:
            found[name] = measure(browser, name, 1.0 if quick else 8.0)
        if importlib.util.find_spec("jupyterlab"):
            beside = measure_notebook(browser, Path(profile), 1.0 if quick else 6.0)
    print(table(found), fluent(beside), sep="\n\n")
    record = {"canvas": SIZE, "scenes": found, "beside": beside}
    harness.record(harness.results_folder(quick), "view", record)


def fluent(found: dict[str, dict[str, Any]]) -> str:
    """Pictures a second in JupyterLab and in the page."""
    rows = [
        [
            name,
            *("x".join(map(str, each[key])) for key in ("canvas", "size")),
            *(f"{each['fps']:.0f}", f"{1e3 * each['render']:.1f}", f"{1e3 * each['encode']:.1f}"),
        ]
        for name, each in found.items()
    ]
    head = ("3,000 spheres", "canvas", "most are", "a second", "render, ms", "encode, ms")
    return harness.table(head, rows)


def table(found: dict[str, dict[str, Any]]) -> str:
    """How late pictures are, and what takes the time."""

    def row(name: str, t: dict[str, Any]) -> list[str]:
        late, still = t["latency"]["median"], t["still"]["median"]
        rest = late - t["render"] - t["encode"] - t["show"]
        return [
            name,
            "x".join(map(str, t["size"])),
            f"{t['fps']:.0f}",
            *(
                f"{1e3 * s:.1f}"
                for s in (late, still, late - still, rest, t["render"], t["encode"], t["show"])
            ),
        ]

    head = ("canvas 1920x1080", "most are", "a second", "latency, ms", "of a still JPEG", "more")
    parts = ("wait, transport", "render", "encode", "decode, paint")
    return harness.table((*head, *parts), [row(name, t) for name, t in found.items()])

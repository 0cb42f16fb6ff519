"""What a user would pick instead, on the same picture, in turn in one run."""

import shutil
import statistics
from collections.abc import Callable
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

import clrt
from benchmarks import harness, paper, povray_peer
from clrt import reference
from clrt.figure.rendering import Renderer
from clrt.film import metrics

PAPER_SECONDS = 21 * 60 + 21  # section 11.11, on a machine that the paper does not name
OWN_SHADING = ("Mitsuba", "POV-Ray")
LOOP_SHRINK = 24  # the paper's loop renders 160x90 and is scaled: its time grows with the pixels


@click.command("peers")
@click.pass_obj
def command(quick: bool) -> None:
    """Compares clrt with the paper's loop and NumPy, and with those of Numba, Mitsuba and POV-Ray
    that are installed."""
    width, height, turns = (480, 270, 1) if quick else (3840, 2160, 3)
    scene = clrt.load_scene("four-spheres")
    truth = reference.trace(scene, width, height, "seed")
    pictures: dict[str, NDArray[Any]] = {}
    notes: dict[str, str] = {}
    contenders: dict[str, Callable[[], float]] = {}

    def add(
        name: str,
        render: Callable[[], NDArray[Any]],
        *,
        frames: int = 1,
        scale: int = 1,
        note: str = "",
    ) -> None:
        """A contender: the median of some frames, times `scale`."""

        def keep() -> None:
            pictures.pop(name, None)  # as in a loop: the next film takes the memory of the last
            pictures[name] = render()

        def run() -> float:
            return scale * statistics.median(harness.wall(keep)() for _ in range(frames))

        contenders[name] = run
        notes[name] = note

    renderer, double = Renderer(), Renderer(precision="double")
    add("clrt", lambda: renderer.render(scene, width, height, dtype=np.uint8), frames=5)
    add("clrt, float64", lambda: double.render(scene, width, height, dtype=np.uint8), frames=5)
    try:
        from benchmarks import numba_peer
    except ImportError:
        print("Numba is not installed: pip install 'clrt[bench]'")
    else:
        note = f"float32, prange, chunks of {numba_peer.CHUNK} rows"
        add("Numba", lambda: numba_peer.render(scene, width, height), frames=5, note=note)
    try:
        from benchmarks import mitsuba_peer
    except ImportError:
        print("Mitsuba is not installed: pip install 'clrt[peers]'")
    else:
        note = f"{mitsuba_peer.VARIANT}, one path a pixel; its own shading"
        add("Mitsuba", mitsuba_peer.contender(scene, width, height), note=note)
    if shutil.which("povray"):

        def povray() -> float:
            pictures["POV-Ray"], seconds = povray_peer.render(scene, width, height)
            return seconds

        contenders["POV-Ray"] = povray
        notes["POV-Ray"] = "its own shading; its trace time"
    add("NumPy", lambda: reference.render(scene, width, height, "seed"), note="the reference")
    seconds = harness.in_turn(contenders, turns)

    small = (width // LOOP_SHRINK, height // LOOP_SHRINK)
    add(
        "the paper's loop",
        lambda: paper.render(scene, *small),
        scale=LOOP_SHRINK**2,
        note=f"{LOOP_SHRINK}² x its time at {small[0]}x{small[1]}",
    )
    loop = {"the paper's loop": contenders["the paper's loop"]}
    seconds |= harness.in_turn(loop, min(turns, 3))

    rows, figures = [], []
    for name, took in seconds.items():
        time = harness.summary(took)
        figure = {
            "name": name,
            **time,
            "mpixel_per_s": width * height / time["median"] / 1e6,
            "mray_per_s": truth.rays / time["median"] / 1e6,
            "ratio": time["median"] / harness.summary(seconds["clrt"])["median"],
            "note": notes[name],
        }
        error = ""
        if pictures[name].shape == truth.image.shape and name not in OWN_SHADING:
            picture = pictures[name]
            scale = 255 if picture.dtype == np.uint8 else 1
            found = metrics.difference(picture / np.float32(scale), truth.image)
            figure |= {"rmse": found.rmse, "over_255": found.over_255}
            error = f"{found.over_255}"
        figures.append(figure)
        rows.append(
            (
                name,
                f"{1e3 * time['median']:,.1f}",
                f"{1e3 * time['min']:,.1f}-{1e3 * time['max']:,.1f}",
                f"{figure['mpixel_per_s']:,.3g}",
                f"{figure['mray_per_s']:,.3g}",
                error,
                f"{figure['ratio']:,.1f}",
                notes[name],
            )
        )
    if not quick:
        ratio = PAPER_SECONDS / harness.summary(seconds["clrt"])["median"]
        note = "the paper's figure, on its machine"
        rows.append(
            ("the paper", f"{1e3 * PAPER_SECONDS:,}", "", "", "", "", f"{ratio:,.0f}", note)
        )
    print(f"four-spheres, {width}x{height}, max_depth 3, {truth.rays:,} rays\n")
    head = ("what", "ms", "spread", "Mpixel/s", "Mray/s", "pixels off > 1/255", "x clrt", "note")
    print(harness.table(head, rows))
    folder = harness.results_folder(quick)
    harness.record(folder, "peers", {"size": [width, height], "rays": truth.rays, "peers": figures})
    plot(figures, folder / "peers.png")


def plot(figures: list[dict[str, Any]], path: Any) -> None:
    """A bar for each."""
    drawn, axes = harness.figure()
    names = [f["name"] for f in figures]
    times = [1e3 * f["median"] for f in figures]
    bars = axes.barh(names, times, color=["tab:green", "tab:blue"] + ["tab:gray"] * len(names))
    axes.bar_label(bars, [f"{t:,.0f}" for t in times], padding=3)
    axes.set(xscale="log", xlabel="ms for the picture; lower is better")
    axes.set_xlim(right=max(times) * 4)
    axes.invert_yaxis()
    drawn.savefig(path, dpi=110)
    print(f"{path}: written")

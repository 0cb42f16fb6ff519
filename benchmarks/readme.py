"""python -m benchmarks readme: the tables of README.md and docs/, from the recorded figures."""

import json
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import click

from benchmarks import (
    atoms,
    features,
    files,
    harness,
    many,
    newcomer,
    peers,
    samples,
    scale,
    shading,
    view,
    visibility,
)

ROOT = Path(__file__).parents[1]
Figures = dict[str, Any]


def pages(root: Path = ROOT) -> list[Path]:
    return [root / "README.md", *sorted((root / "docs").glob("*.md"))]


def stale(found: Iterable[Path], results: Path = harness.RESULTS) -> dict[Path, str]:
    """The pages of which a table is not as the figures make it, and what they should be."""
    made = {page: filled(page.read_text(), results) for page in found}
    return {page: text for page, text in made.items() if text != page.read_text()}


def filled(page: str, results: Path) -> str:
    """A page's text, with the tables between its markers made anew."""

    def made(marked: re.Match[str]) -> str:
        name = marked[1]
        part, tabulate = TABLES[name]
        figures = json.loads((results / f"{part}.json").read_text())
        text = f"{tabulate(figures)}\n\n{origin(part, figures['machine'])}"
        return f"<!-- {name} -->\n\n{text}\n\n<!-- /{name} -->"

    return re.sub(rf"<!-- ({'|'.join(TABLES)}) -->.*?<!-- /\1 -->", made, page, flags=re.DOTALL)


def origin(part: str, machine: Figures) -> str:
    """When, on what and with what the figures were measured."""
    driver = machine["device"].split(", ")[-1]
    opencl = f"{'PoCL' if 'PoCL' in machine['device'] else 'driver'} {driver}"
    measured = f"{machine['date']}, {machine['cpu']}, {machine['cores']} cores, {opencl}"
    return f"{part}.json: {measured}, clrt {machine['clrt']}"


def number(x: float) -> str:
    """Three digits, or all before the point."""
    return f"{x:,.0f}" if x >= 100 else f"{x:.3g}"


def ms(seconds: float) -> str:
    return f"{1e3 * seconds:,.1f}"


def spread(times: Figures) -> str:
    """From the least to the most; nothing if it was measured once."""
    return f"{ms(times['min'])}-{ms(times['max'])}" if times["min"] < times["max"] else ""


def size(figures: Figures) -> str:
    return "x".join(map(str, figures["size"]))


def errors(point: Figures) -> list[str]:
    """A picture's, against both truths."""
    cells = []
    for found in (point["exact"], point.get("seed")):
        if found is None:
            cells += [""] * 4
            continue
        cells += [f"{found['max_off_flips']:.1e}", f"{found['p999']:.1e}",
                  f"{found['over_1020']:,}",
                  f"{found['flips']:,} ({found['interior_flips']:,})"]  # fmt: skip
    return cells


def accuracy(figures: Figures) -> str:
    what = ("max off flips", "p99.9", "> 1/1020", "flips (interior)")
    head = (
        "scene, precision, lanes",
        "ms",
        *(f"{t}: {w}" for t in ("exact", "seed") for w in what),
    )
    rows = []
    for p in figures["points"]:
        lanes = f"{p['lanes']} lane{'s' * (p['lanes'] > 1)}"
        rows.append((f"{p['scene']}, {p['precision']}, {lanes}", ms(p["median"]), *errors(p)))
    return harness.table(head, rows)


def accuracy_short(figures: Figures) -> str:
    """four-spheres in each precision, and robust far from the origin; 16 lanes."""
    errors_of = ("exact: max", "exact: > 1/1020", "seed: max", "seed: > 1/1020")
    head = (f"{size(figures)}, 16 lanes", "ms", *errors_of)
    rows = []
    for p in figures["points"]:
        far = p["scene"].startswith("moved") and p["precision"] == "robust"
        if p["lanes"] == 16 and (p["scene"] == "four-spheres" or far):
            label, cells = f"{p['scene']}, {p['precision']}", errors(p)
            rows.append((label, ms(p["median"]), cells[0], cells[2], cells[4], cells[6]))
    return harness.table(head, rows)


def peer(figure: Figures) -> list[str]:
    over = f"{figure['over_255']:,}" if "over_255" in figure else ""
    ratio = figure["ratio"]
    return [ms(figure["median"]), spread(figure), number(figure["mpixel_per_s"]),
            number(figure["mray_per_s"]), over,
            f"{ratio:,.0f}" if ratio >= 100 else f"{ratio:.1f}", figure["note"]]  # fmt: skip


def all_peers(figures: Figures) -> str:
    head = (f"four-spheres, {size(figures)}", "ms", "spread", "Mpixel/s", "Mray/s",
            "pixels off > 1/255", "x clrt", "note")  # fmt: skip
    rows = [(figure["name"], *peer(figure)) for figure in figures["peers"]]
    ratio = peers.PAPER_SECONDS / figures["peers"][0]["median"]
    note = "the paper's figure, on its machine"
    rows.append(("the paper", ms(peers.PAPER_SECONDS), *[""] * 4, f"{ratio:,.0f}", note))
    return f"{figures['rays']:,} rays\n\n{harness.table(head, rows)}"


def speed_short(figures: Figures) -> str:
    head = (f"four-spheres, {size(figures)}", "ms", "Mpixel/s", "Mray/s", "x clrt", "note")
    cells = {figure["name"]: peer(figure) for figure in figures["peers"]}
    return harness.table(head, [(n, c[0], c[2], c[3], c[5], c[6]) for n, c in cells.items()])


def timed(figures: Figures, parts: dict[str, Figures]) -> str:
    rows = [(n, ms(times["median"]), spread(times), times["note"]) for n, times in parts.items()]
    return harness.table((f"four-spheres, {size(figures)}", "ms", "spread", "note"), rows)


def kernel(figures: Figures) -> str:
    grown = figures["How its cost grows"]
    more = {name: t for name, t in grown.items() if re.search("one sphere more|threads?$", name)}
    return timed(figures, figures["The kernel"] | more)


def whole_command(figures: Figures) -> str:
    return timed(figures, figures["The whole command"])


def targets(figures: Figures) -> str:
    rows: list[Sequence[str]] = []
    scenes: list[str] = []
    for target in (name for name in figures if name not in ("machine", "size")):
        for precision, times in figures[target].items():
            scenes = list(times)
            cells = (
                " / ".join(ms(t["median"]) for t in lanes.values()) for lanes in times.values()
            )
            rows.append((f"{target}, {precision}", *cells))
    return harness.table((f"{size(figures)}, 16 / 8 lanes, ms", *scenes), rows)


def animation(figures: Figures) -> str:
    times = {name: harness.summary(took) for name, took in figures["seconds"].items()}
    slower = max(times[name]["median"] for name in ("rendering alone", "encoding alone"))
    rows = []
    for name, t in times.items():
        cores = harness.summary(figures["core_seconds"][name][1:])["median"]  # but the warm-up
        rows.append((name, f"{t['median']:.2f}", f"{t['min']:.2f}-{t['max']:.2f}", f"{cores:.2f}",
                     f"{t['median'] / slower:.2f}"))  # fmt: skip
    head = ("what", "s", "spread", "core-seconds", "x the slower part")
    peaks = ", ".join(f"{n} frames {mb:.0f} MB" for n, mb in figures["peak_mb"].items())
    return f"{harness.table(head, rows)}\n\npeak memory, 160x90: {peaks}"


def many_spheres(figures: Figures) -> str:
    return harness.table(many.HEAD, [many.row(figure) for figure in figures["figures"]])


def script(figures: Figures) -> str:
    rows = [
        (f"{f['name']}, {f['spheres']:,}", f"{f['median']:.2f}", f"{f['min']:.2f}-{f['max']:.2f}",
         f"{f['peak_mb']:,.0f}")
        for f in figures["script"]
    ]  # fmt: skip
    return harness.table(("atoms to .png, 1920x1080", "s", "spread", "peak memory, MB"), rows)


# The name between a table's markers, the part whose figures it takes, and what makes it of them.
TABLES: dict[str, tuple[str, Callable[[Figures], str]]] = {
    "accuracy-short": ("accuracy", accuracy_short),
    "speed-short": ("peers", speed_short),
    "accuracy": ("accuracy", accuracy),
    "peers": ("peers", all_peers),
    "kernel": ("speed", kernel),
    "command": ("speed", whole_command),
    "targets": ("targets", targets),
    "animation": ("animation", animation),
    "features": ("features", lambda f: features.table(f["size"], f["features"])),
    "many": ("many", many_spheres),
    "script": ("files", script),
    "files": ("files", lambda f: files.table(f["files"])),
    "newcomer": ("newcomer", newcomer.tabulated),
    "scale": ("scale", scale.report),
    "view": ("view", lambda f: view.table(f["scenes"])),
    "shading": ("shading", shading.tabulated),
    "visibility": ("visibility", visibility.tabulated),
    **{name: ("samples", table) for name, table in samples.TABLES.items()},
    "atoms": ("atoms", atoms.table),
}


@click.command("readme")
@click.option("--check", is_flag=True, help="Write nothing; the exit status is 1 if one is stale.")
def command(check: bool) -> None:
    """Writes the tables of README.md and docs/ from benchmarks/results/."""
    found = stale(pages())
    for page, text in found.items():
        if not check:
            page.write_text(text)
        click.echo(f"{page.relative_to(ROOT)}: {'a table is stale' if check else 'written'}")
    sys.exit(int(check and bool(found)))

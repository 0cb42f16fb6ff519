"""From a file of particles to a PNG: the whole command, by format, and where its time goes."""

import re
import subprocess
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks import harness

Array = NDArray[Any]
HEAD = ("particles", "file", "MB", "s", "imports, read", "device", "picture", "kernels", "encode")
STAGES = ("scene", "device", "picture", "kernels", "encode")
SAID = re.compile(
    r"imports and scene ([\d.]+) s, device and kernel ([\d.]+) s, picture ([\d.]+) s "
    r"\(kernel alone ([\d.]+) s\)\s+file ([\d.]+) s"
)
"""What `clrt render -v` says."""


def write(folder: Path, spheres: Array) -> list[Path]:
    """Spheres (n, 4), the radius last, in each of the formats that need no extra."""
    n, text = len(spheres), folder / "a.text"
    np.savetxt(text, spheres, fmt="%.9g")
    rows = text.read_bytes()
    names = ("x", "y", "z", "radius")
    np.savez(folder / "a.npz", positions=spheres[:, :3], radii=spheres[:, 3])
    (folder / "a.csv").write_bytes(",".join(names).encode() + b"\n" + rows.replace(b" ", b","))
    properties = "".join(f"property float {name}\n" for name in names)
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {n}\n{properties}end_header\n"
    (folder / "a.ply").write_bytes(head.encode() + spheres.astype("<f4").tobytes())
    (folder / "a.xyz").write_bytes(f"{n}\nProperties=pos:R:3:radius:R:1\n".encode() + rows)
    box = "ITEM: BOX BOUNDS pp pp pp\n" + "-1 1\n" * 3
    head = f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{n}\n{box}ITEM: ATOMS x y z radius\n"
    (folder / "a.dump").write_bytes(head.encode() + rows)
    return [folder / f"a{suffix}" for suffix in (".npz", ".ply", ".csv", ".xyz", ".dump")]


def measure(makes: Sequence[Array], size: tuple[int, int], turns: int) -> list[dict[str, Any]]:
    """The commands one after the other, of one sample a pixel, and the default's of .npz."""
    found = []
    for spheres in makes:
        with TemporaryDirectory() as folder:
            paths = write(Path(folder), spheres.astype(np.float32))
            runs: dict[str, tuple[Path, Sequence[str]]] = {
                path.suffix: (path, ("--samples", "1")) for path in paths
            }
            runs[".npz, 16 samples"] = paths[0], ()
            stages: dict[str, list[list[float]]] = {name: [] for name in runs}
            contenders: dict[str, Callable[[], float]] = {
                name: partial(command, path, size, words, stages[name])
                for name, (path, words) in runs.items()
            }
            for name, seconds in harness.in_turn(contenders, turns).items():
                parts = dict(zip(STAGES, np.median(stages[name], axis=0).tolist(), strict=True))
                megabytes = runs[name][0].stat().st_size / 1e6
                what = {"particles": len(spheres), "file": name, "mb": megabytes}
                found.append({**what, **parts, **harness.summary(seconds)})
    return found


def command(
    path: Path, size: tuple[int, int], words: Sequence[str], stages: list[list[float]]
) -> float:
    """The seconds that `clrt render` takes. stages gets what it says of its parts."""
    picture = path.with_suffix(".png")
    sides = ["--width", str(size[0]), "--height", str(size[1])]
    run = [sys.executable, "-m", "clrt", "render", str(path), "-o", str(picture), "-v", *sides]

    def rendered() -> None:
        done = subprocess.run([*run, *words], capture_output=True, text=True, check=True)
        said = SAID.search(done.stderr)
        assert said is not None, done.stderr
        stages.append([float(number) for number in said.groups()])

    return harness.wall(rendered)()


def table(found: Sequence[dict[str, Any]]) -> str:
    return harness.table(HEAD, [row(figure) for figure in found])


def row(figure: dict[str, Any]) -> Sequence[str]:
    parts = (f"{figure[stage]:.2f}" for stage in STAGES)
    seconds = f"{figure['median']:.2f} ({figure['min']:.2f}-{figure['max']:.2f})"
    return f"{figure['particles']:,}", figure["file"], f"{figure['mb']:.0f}", seconds, *parts

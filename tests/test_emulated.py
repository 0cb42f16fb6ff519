"""CPUs that are not at hand, emulated: pictures equal to this one's, cold and warm."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import clrt
from benchmarks.triangles import ball
from clrt.film.metrics import QUARTER_STEP

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not shutil.which("qemu-x86_64"), reason="apt-get install qemu-user"),
]
# Each way to be told a name that does not agree with PoCL's library: QEMU has no AVX-512, which it
# masks of the servers, and `max` has no model that LLVM knows.
CPUS = ("Nehalem", "EPYC-Milan", "Skylake-Server", "max")
# With 16 lanes, the default; in float64 one of each width of vectors. Of capsules and faces one
# lane says enough: a compiler takes 20 times as long here, and longer for more lanes.
MADE = [(cpu, "robust") for cpu in CPUS]
MADE += [(cpu, "double") for cpu in ("Nehalem", "Haswell")]
SIZE = (64, 36)
BALL = ball(3, 0.4, (-0.5, 0, -1.5))
SHAPES = clrt.Scene(
    clrt.Camera((0, 0, 0), (0, 0, -1)),
    (clrt.Light((5, 5, 4)),),
    {"m": clrt.Material((0.1, 0.1, 0.1), (0.7, 0.5, 0.2), (0.3, 0.3, 0.3), 64)},
    spheres=(clrt.Sphere((0, -100.6, -2), 100, "m"),),
    capsules=(clrt.Capsule((0.1, -0.3, -1.5), (0.8, 0.4, -1.2), 0.15, "m"),),
    meshes=(clrt.Mesh(BALL.vertices, BALL.faces, material="m"),),
)


def scene_of(cpu: str, precision: str) -> clrt.Scene:
    """Capsules and faces where there is no fused multiply-add, which differences of products need
    a way without for."""
    return SHAPES if (cpu, precision) == ("Nehalem", "robust") else clrt.load_scene("four-spheres")


def emulated(folder: Path, cpu: str, precision: str, python: bool = True) -> np.ndarray:
    """What a CPU renders, and one, which LLVM knows least of, once more from its cache.

    python: whether what clrt starts is emulated as well, for sys.executable is a script that
        starts the emulator.
    """
    folder.mkdir(parents=True)
    scene = scene_of(cpu, precision)
    clrt.save_scene(folder / "scene.toml", scene)
    script = folder / "python"
    real = str(Path(sys.executable).resolve())
    words = ["qemu-x86_64", "-cpu", cpu, "-0", str(script) if python else real, real]
    script.write_text(f'#!/bin/sh\nexec {" ".join(words)} "$@" 2> /dev/null\n')
    script.chmod(0o755)
    environment = {
        **os.environ,
        "PYTHONHOME": sys.base_prefix,
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        "XDG_CACHE_HOME": str(folder / "cache"),
        "OCL_ICD_VENDORS": str(folder),  # the wheel's PoCL only
    }
    if cpu == "Nehalem":
        # In QEMU 7.2 on a Zen 5, OpenBLAS takes it for a core that has more, and crashes.
        environment["OPENBLAS_CORETYPE"] = cpu
    films = []
    for name in ("cold.npy", "warm.npy")[: 2 if cpu == "max" else 1]:
        command = ["-m", "clrt", "render", "scene.toml", "-o", name, "--precision", precision]
        command += ["--lanes", "1"] * (scene is SHAPES)
        size = ["--width", str(SIZE[0]), "--height", str(SIZE[1])]
        done = subprocess.run(
            [str(script), *command, *size], cwd=folder, env=environment, timeout=300
        )
        assert done.returncode == 0
        films.append(np.load(folder / name))
    assert (films[0] == films[-1]).all()
    return films[0]


@pytest.fixture(scope="module")
def films(
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[dict[tuple[str, str], "Future[np.ndarray]"]]:
    """All of them under way, one on each core."""
    folder = tmp_path_factory.mktemp("emulated")
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as threads:
        yield {
            (cpu, precision): threads.submit(emulated, folder / cpu / precision, cpu, precision)
            for cpu, precision in MADE
        }


@pytest.mark.parametrize(("cpu", "precision"), MADE)
def test_an_emulated_cpu_renders_the_same(films, cpu: str, precision) -> None:
    scene = scene_of(cpu, precision)
    lanes = 1 if scene is SHAPES else None
    native = clrt.render(scene, *SIZE, precision=precision, lanes=lanes)
    bound = QUARTER_STEP if precision == "robust" else 1e-6
    assert abs(films[cpu, precision].result() - native).max() < bound


def test_what_it_starts_is_not_emulated(tmp_path: Path) -> None:
    native = clrt.render(clrt.load_scene("four-spheres"), *SIZE)
    film = emulated(tmp_path / "a", "Haswell", "robust", python=False)
    assert abs(film - native).max() < QUARTER_STEP

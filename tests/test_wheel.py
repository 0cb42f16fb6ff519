"""The wheel, installed elsewhere, renders: kernels, scenes and tables are inside it."""

import subprocess
import sys
import venv
from pathlib import Path

import pytest
from PIL import Image

ROOT = Path(__file__).parents[1]


@pytest.mark.slow
def test_renders_from_an_installed_wheel(tmp_path: Path) -> None:
    def run(*words: object) -> None:
        done = subprocess.run(list(map(str, words)), cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr

    run(sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", tmp_path, ROOT)
    (wheel,) = tmp_path.glob("clrt-*.whl")
    environment = tmp_path / "environment"
    venv.create(environment, with_pip=True)
    run(environment / "bin" / "pip", "install", "-q", wheel)
    tables = "from clrt import elements, palette; palette.colormap('turbo')"
    run(environment / "bin" / "python", "-c", tables)
    run(environment / "bin" / "clrt", "render", "sunflower", "--width", 64, "--height", 36)
    assert Image.open(tmp_path / "sunflower.png").size == (64, 36)

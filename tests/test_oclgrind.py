"""The kernels under Oclgrind: out of bounds, uninitialised, races."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from clrt.pack import LANES

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not shutil.which("oclgrind"), reason="apt-get install oclgrind"),
]
HERE = Path(__file__).parent
OUT_OF_BOUNDS = """
import small_pictures
from clrt import trial
from clrt.opencl import program
source = program.kernel_source().replace("* width + column);", "* width + column + 1);")
assert source != program.kernel_source()
program.kernel_source = lambda: source
trial.tried, trial.wrong_pixels = trial.try_here, lambda *words: 0  # which would find it as well
small_pictures.WIDTH, small_pictures.CASES, small_pictures.REGION = 16, [], None
small_pictures.main([4])
"""


def findings(*words: str) -> list[str]:
    """What Oclgrind finds while a Python program runs, a paragraph each."""
    command = ["oclgrind", "--data-races", "--uninitialized", "--max-errors", "1000000"]
    done = subprocess.run(
        [*command, sys.executable, *words], cwd=HERE, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.startswith("Oclgrind Simulator: ")
    return [text.strip() for text in re.split(r"\n\s*\n", done.stderr) if text.strip()]


@pytest.mark.parametrize("lanes", LANES)
def test_small_pictures(lanes: int) -> None:
    found = findings("small_pictures.py", str(lanes))
    if lanes == 16:
        # Oclgrind 21.10 takes element 11 for uninitialised when 16 are shuffled, be they constants
        # (`v.sbbbbbbbbbbbbbbbb`), and only that one; so it does as the film is written.
        false = re.compile(r"Uninitialized value written .* of film\.cl:", re.DOTALL)
        found = [text for text in found if not false.match(text)]
    assert not found


def test_what_is_wrong_is_found() -> None:
    found = findings("-c", OUT_OF_BOUNDS)
    assert any(text.startswith("Invalid write") for text in found)

"""Programs are kept as binaries, and a spoilt one does no harm."""

from pathlib import Path

import numpy as np
import pyopencl as cl
import pytest

import clrt
from clrt.errors import DeviceError
from clrt.program import Program
from clrt.renderer import Renderer


def picture(device: cl.Device) -> np.ndarray:
    with Renderer(device=device) as renderer:
        return renderer.render(clrt.load_scene("four-spheres"), 40, 23)


def test_kept_cut_short_and_refused(
    device: cl.Device, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    first = picture(device)
    (kept,) = (tmp_path / "clrt").iterdir()
    whole = kept.read_bytes()
    assert (picture(device) == first).all()
    assert kept.read_bytes() == whole
    for spoilt in (b"", whole[:-100], b"x" * len(whole)):
        kept.write_bytes(spoilt)
        assert (picture(device) == first).all()
        assert [path.name for path in (tmp_path / "clrt").iterdir()] == [kept.name]


def test_a_cache_that_cannot_be_written(
    device: cl.Device, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "clrt").write_text("a file where the folder would be")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert picture(device).any()


def test_what_does_not_compile_says_why(device: cl.Device) -> None:
    with pytest.raises(DeviceError, match=r"cannot compile the kernel: .*error: "):
        Program(cl.Context([device]), device, ["-DLANES=5"])

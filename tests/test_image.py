"""Image files: each format read back, whole or not there."""

import os
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from clrt import data
from clrt.errors import OutputError, RequestError
from clrt.files import image

BYTES = np.random.default_rng(1).integers(0, 256, (20, 30, 3), np.uint8)
FLOATS = np.random.default_rng(2).normal(0, 3, (20, 30, 3)).astype(np.float32)


@pytest.mark.parametrize("suffix", [".png", ".webp", ".tif", ".tiff", ".bmp", ".ppm", ".PNG"])
def test_8_bit_round_trip(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    image.save(path, BYTES)
    assert (np.rint(255 * image.load(path)) == BYTES).all()


@pytest.mark.parametrize("suffix", [".jpg", ".jpeg"])
def test_jpeg_round_trip(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    smooth = np.broadcast_to(np.arange(64, dtype=np.uint8)[:, None, None] * 3, (64, 64, 3))
    image.save(path, np.ascontiguousarray(smooth))
    assert abs(255 * image.load(path) - smooth).max() < 4


@pytest.mark.parametrize("suffix", [".npy", ".pfm"])
def test_float_round_trip(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    image.save(path, FLOATS)
    assert (image.load(path) == FLOATS).all()


@pytest.mark.parametrize("suffix", image.SUFFIXES)
def test_every_suffix_has_a_film(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    image.check_output(path, 30, 20)
    image.save(path, BYTES if image.film_dtype(path) is np.uint8 else FLOATS)
    assert image.load(path).shape == (20, 30, 3)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_check_output(tmp_path: Path) -> None:
    with pytest.raises(RequestError, match=r"ends in one of \.png"):
        image.check_output(tmp_path / "a.exr", 1, 1)
    with pytest.raises(RequestError, match="does not exist"):
        image.check_output(tmp_path / "none" / "a.png", 1, 1)
    (tmp_path / "a.png").mkdir()
    os.mkfifo(tmp_path / "b.png")
    (tmp_path / "c.png").symlink_to("/dev/full")
    for name in ("a.png", "b.png", "c.png"):
        with pytest.raises(RequestError, match="is a folder or a device, expected a file's name"):
            image.check_output(tmp_path / name, 1, 1)


@pytest.mark.parametrize(
    ("suffix", "largest"),
    [
        (".jpg", (65500, 1)),
        (".webp", (16383, 1)),
        (".webp", (1, 16383)),
        (".tif", (10**9 // 50000, 50000)),
        (".bmp", (10**9 // 50000, 50000)),
    ],
)
def test_what_a_format_can_hold(tmp_path: Path, suffix: str, largest: tuple[int, int]) -> None:
    path = tmp_path / f"a{suffix}"
    width, height = largest
    image.check_output(path, width, height)
    if width * height < 10**6:
        image.save(path, np.zeros((height, width, 3), np.uint8))
        assert image.load(path).shape == (height, width, 3)
    with pytest.raises(RequestError, match=f"a{suffix}: {suffix} has no more than"):
        image.check_output(path, width + 1, height + 1)


def test_a_link_is_followed(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "a.png").symlink_to("there/b.png")
    for _ in range(2):
        image.check_output(tmp_path / "a.png", 30, 20)
        image.save(tmp_path / "a.png", BYTES)
        assert (tmp_path / "a.png").is_symlink()
        assert [path.name for path in (tmp_path / "there").iterdir()] == ["b.png"]


def test_permissions_stay(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    image.save(path, BYTES)
    path.chmod(0o640)
    image.save(path, BYTES)
    assert path.stat().st_mode & 0o777 == 0o640


def test_a_failed_write_leaves_what_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.npy"
    image.save(path, FLOATS)
    before = path.read_bytes()

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setitem(image._WRITE_FLOATS, ".npy", stop)
    with pytest.raises(KeyboardInterrupt):
        image.save(path, FLOATS)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["a.npy"]


def test_too_large_for_the_format(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="cannot be written"):
        image.save(tmp_path / "a.webp", np.zeros((1, 20000, 3), np.uint8))
    assert not list(tmp_path.iterdir())


def test_unreadable(tmp_path: Path) -> None:
    with pytest.raises(RequestError, match="No such file"):
        image.load(tmp_path / "none.png")
    for name in ("a.png", "a.npy", "a.pfm"):
        (tmp_path / name).write_bytes(b"nothing of the kind")
        with pytest.raises(RequestError, match="cannot be read"):
            image.load(tmp_path / name)
    for spoilt in (b"", b"PK\3\4 not a zip"):
        (tmp_path / "a.npy").write_bytes(spoilt)
        with pytest.raises(RequestError, match="cannot be read"):
            image.load(tmp_path / "a.npy")
    for array in (np.zeros(5), np.zeros((2, 2, 3), np.uint16)):
        np.save(tmp_path / "b.npy", array)
        with pytest.raises(RequestError, match="expected float or uint8 of shape"):
            image.load(tmp_path / "b.npy")


def test_16_bits_a_channel(tmp_path: Path) -> None:
    gray = np.arange(256, dtype=np.uint8).reshape(16, 16)
    Image.fromarray(gray).save(tmp_path / "8.png")
    Image.fromarray(gray.astype(np.uint16) * 257).save(tmp_path / "16.png")
    assert (image.load(tmp_path / "16.png") == image.load(tmp_path / "8.png")).all()
    Image.fromarray(gray.astype(np.int32)).save(tmp_path / "32.tif")
    with pytest.raises(RequestError, match="expected 8 or 16 bits a channel, got mode I"):
        image.load(tmp_path / "32.tif")


def test_a_picture_larger_than_memory_is_not_decoded(tmp_path: Path) -> None:
    header = struct.pack(">II5B", 60000, 60000, 8, 2, 0, 0, 0)
    chunk = b"IHDR" + header
    (tmp_path / "bomb.png").write_bytes(
        b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + chunk + struct.pack(">I", zlib.crc32(chunk))
        + struct.pack(">I", 9) + b"IDAT"
    )  # fmt: skip
    with pytest.raises(OutputError, match=r"bomb.png: 60000x60000 needs 72.0 GB of memory"):
        image.load(tmp_path / "bomb.png")


def test_what_a_killed_process_left_goes(tmp_path: Path) -> None:
    """And what one that lives holds, what is young and what is not ours stays."""
    old, held, young = (tmp_path / f".{letter * 16}.part" for letter in "abc")
    other = tmp_path / ".other.part"
    for path in (old, held, young, other):
        path.touch()
    for path in (old, held, other):
        os.utime(path, (0, 0))
    lock = data.locked(held)
    image.save(tmp_path / "a.png", BYTES)
    os.close(lock)
    assert set(tmp_path.iterdir()) == {held, young, other, tmp_path / "a.png"}


@pytest.mark.parametrize("suffix", image.SUFFIXES)
def test_is_whole(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    assert not image.is_whole(path, 30, 20)
    image.save(path, BYTES if image.film_dtype(path) is np.uint8 else FLOATS)
    assert image.is_whole(path, 30, 20)
    assert not image.is_whole(path, 20, 30)
    path.write_bytes(path.read_bytes()[:-40])
    assert not image.is_whole(path, 30, 20)
    path.write_bytes(b"")
    assert not image.is_whole(path, 30, 20)

"""PNG: what the file says by the standard, read with zlib and by other libraries."""

import io
import os
import struct
import zlib

import av
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from clrt.files import png

RANDOM = np.random.default_rng(1)


def noise(height: int, width: int) -> NDArray[np.uint8]:
    return RANDOM.integers(0, 256, (height, width, 3), np.uint8)


def smooth(height: int, width: int) -> NDArray[np.uint8]:
    ramp = np.arange(height)[:, np.newaxis, np.newaxis] + 2 * np.arange(width)[:, np.newaxis]
    return (ramp // 3 * (1, 2, 3)).astype(np.uint8)


FILMS = {
    "a pixel": noise(1, 1),
    "a row": noise(1, 1000),
    "a column": noise(1000, 1),
    "noise of many bands": noise(500, 2000),
    "smooth, of many bands": smooth(700, 1900),
    "black": np.zeros((400, 1500, 3), np.uint8),
    "white": np.full((400, 1500, 3), 255, np.uint8),
    "rows longer than a band": noise(3, 200_000),
    "every other pixel of a film": noise(600, 2000)[::2, 1::2],
    "upside down": noise(300, 1000)[::-1, ::-1],
}


def written(film: NDArray[np.uint8]) -> bytes:
    file = io.BytesIO()
    png.write(file, film)
    return file.getvalue()


def chunks(content: bytes) -> list[tuple[bytes, bytes]]:
    """Kind and content of each, whose checksums are right."""
    assert content[:8] == b"\x89PNG\r\n\x1a\n"
    at, found = 8, []
    while at < len(content):
        (length,) = struct.unpack(">I", content[at : at + 4])
        kind, inside = content[at + 4 : at + 8], content[at + 8 : at + 8 + length]
        (checksum,) = struct.unpack(">I", content[at + 8 + length : at + 12 + length])
        assert checksum == zlib.crc32(kind + inside)
        found.append((kind, inside))
        at += 12 + length
    return found


@pytest.mark.parametrize("film", FILMS.values(), ids=FILMS)
def test_by_the_standard(film: NDArray[np.uint8]) -> None:
    height, width, _ = film.shape
    found = chunks(written(film))
    assert found[0] == (b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0))
    assert {kind for kind, _ in found[1:-1]} == {b"IDAT"}
    assert found[-1] == (b"IEND", b"")
    # zlib checks the stream's end and Adler-32.
    rows = zlib.decompress(b"".join(inside for kind, inside in found if kind == b"IDAT"))
    filtered = np.frombuffer(rows, np.uint8).reshape(height, 1 + 3 * width)
    assert (filtered[:, 0] == 1).all()  # Sub: each byte less that of the pixel on its left
    pixels = np.cumsum(filtered[:, 1:].reshape(film.shape), axis=1, dtype=np.uint8)
    assert (pixels == film).all()


@pytest.mark.parametrize("film", FILMS.values(), ids=FILMS)
def test_others_read_it(film: NDArray[np.uint8]) -> None:
    content = written(film)
    assert (np.asarray(Image.open(io.BytesIO(content))) == film).all()
    with av.open(io.BytesIO(content), "r", format="png_pipe") as file:
        (frame,) = file.decode(video=0)
        assert (frame.to_ndarray(format="rgb24") == film).all()


def test_a_file_does_not_depend_on_the_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    film = noise(500, 2000)
    files = set()
    for cores in (1, 2, 7):
        monkeypatch.setattr(os, "sched_getaffinity", lambda _, cores=cores: set(range(cores)))
        files.add(written(film))
    assert len(files) == 1


def test_memory_is_bounded_by_bands(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a film of 100 bands, no more are compressed ahead than there are cores and one."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1, 2})
    real, begun, written_at = png._compressed, [], []

    def compressed(band):
        begun.append(band)
        return real(band)

    monkeypatch.setattr(png, "_compressed", compressed)

    class File(io.BytesIO):
        def write(self, content) -> int:
            if content[4:] == b"IDAT":
                written_at.append(len(begun))
            return super().write(content)

    png.write(File(), np.zeros((100, png.BAND // 3, 3), np.uint8))
    assert len(begun) == 100
    assert all(bands <= k + 4 for k, bands in enumerate(written_at))


@pytest.mark.parametrize(("kind", "most"), [("noise", 1.001), ("smooth", 0.02), ("black", 0.006)])
def test_how_long_a_file_is(kind: str, most: float) -> None:
    black = np.zeros((1000, 1000, 3), np.uint8)
    film = {"noise": noise(1000, 1000), "smooth": smooth(1000, 1000), "black": black}[kind]
    assert len(written(film)) < most * film.nbytes


def test_checksums_are_joined() -> None:
    parts = [RANDOM.bytes(n) for n in (1, 70_000, 3, 500_000)]
    checksum = 1
    for part in parts:
        checksum = png._joined(checksum, png._Band(b"", zlib.adler32(part), len(part)))
    assert checksum == zlib.adler32(b"".join(parts))

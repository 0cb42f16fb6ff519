"""PNG, written in bands by all cores (Portable Network Graphics, third edition, W3C 2025).

Pillow's encoder holds Python's lock, so it works on one core only, and takes longer to choose a
filter for each row than zlib takes to compress them all.
"""

import struct
import zlib
from collections.abc import Iterator, Sequence
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from clrt import cgroups
from clrt.pipeline import in_order

# A file depends on its picture only, and not on the number of cores: so do its bands. Smaller ones
# cost time, larger ones leave cores idle at the end of a 1080p picture.
BAND = 1 << 19  # bytes of pixels, or one row
SUB = 1  # the filter: each byte less that of the pixel on its left
ADLER = 65521


class _Band(NamedTuple):
    """Some rows: their part of the zlib stream, and its checksum and length before compression."""

    stream: bytes
    adler: int
    length: int


def write(file: IO[bytes], film: NDArray[Any], notes: Sequence[tuple[bytes, bytes]] = ()) -> None:
    """Writes a film, uint8 or uint16 (height, width, 3), or 4 with straight alpha, as RGB or RGBA.

    notes: chunks, each a kind and its bytes, that come before the picture.
    """
    height, width, channels = film.shape
    file.write(b"\x89PNG\r\n\x1a\n")
    depth, color, not_interlaced = 8 * film.itemsize, {3: 2, 4: 6}[channels], 0
    _chunk(file, b"IHDR", struct.pack(">2I5B", width, height, depth, color, 0, 0, not_interlaced))
    for kind, content in notes:
        _chunk(file, kind, content)
    # zlib's stream (RFC 1950): a header, compressed data, and a checksum of the plain data.
    _chunk(file, b"IDAT", b"\x78\x01")
    checksum = 1
    threads = cgroups.cores()
    for band in in_order(_compressed, _bands(film), threads):
        _chunk(file, b"IDAT", band.stream)
        checksum = _joined(checksum, band)
    _chunk(file, b"IDAT", struct.pack(">I", checksum))
    _chunk(file, b"IEND", b"")


def _bands(film: NDArray[Any]) -> Iterator[tuple[NDArray[Any], bool]]:
    """Some rows each, and whether they are the last ones."""
    rows = max(BAND // film[0].nbytes, 1)
    for top in range(0, len(film), rows):
        yield film[top : top + rows], top + rows >= len(film)


def _compressed(band: tuple[NDArray[Any], bool]) -> _Band:
    pixels, last = band
    rows, columns, channels = pixels.shape
    if pixels.dtype == np.uint16:  # the high byte first
        pixels = np.ascontiguousarray(pixels, ">u2").view(np.uint8)
        channels *= 2
    pixels = pixels.reshape(rows, columns * channels)
    filtered = np.empty((rows, 1 + columns * channels), np.uint8)
    filtered[:, 0] = SUB
    filtered[:, 1 : 1 + channels] = pixels[:, :channels]
    np.subtract(pixels[:, channels:], pixels[:, :-channels], out=filtered[:, 1 + channels :])
    # Runs only (Z_RLE) are quicker on noise, but a crystal repeats itself: 1.9 times the bytes.
    deflate = zlib.compressobj(1, wbits=-zlib.MAX_WBITS)
    end = zlib.Z_FINISH if last else zlib.Z_SYNC_FLUSH  # up to a whole byte, so bands can be joined
    stream = deflate.compress(filtered.data) + deflate.flush(end)
    return _Band(stream, zlib.adler32(filtered.data), filtered.nbytes)


def _joined(checksum: int, band: _Band) -> int:
    """The Adler-32 of two texts, one after the other, of the Adler-32 of each.

    It is b << 16 | a, where a is 1 + the sum of the bytes, and b the sum of all a on the way.
    """
    a, b = checksum & 0xFFFF, checksum >> 16
    own_a, own_b = band.adler & 0xFFFF, band.adler >> 16
    b += own_b + band.length * (a - 1)
    return (b % ADLER) << 16 | (a + own_a - 1) % ADLER


def _chunk(file: IO[bytes], kind: bytes, content: bytes) -> None:
    file.write(struct.pack(">I", len(content)) + kind)
    file.write(content)
    file.write(struct.pack(">I", zlib.crc32(content, zlib.crc32(kind))))

"""Opened: a file's bytes, unpacked, of stdin as well, and text as UTF-8."""

import codecs
import io
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import IO, Any, cast

from clrt.errors import RequestError
from clrt.files.particles import suffix
from clrt.files.particles.text import Lines

BUFFER = 1 << 20  # bytes
ORDERS = {codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}


def _zstd(path: Path) -> IO[bytes]:
    """A file that is packed with Zstandard, unpacked to a temporary one, in which one can go
    back."""
    try:
        import zstandard
    except ImportError:
        raise RequestError(f"{path}: needs zstandard: pip install 'clrt[zst]'") from None
    import tempfile

    unpacked = tempfile.TemporaryFile()  # noqa: SIM115
    with path.open("rb") as file:
        zstandard.ZstdDecompressor().copy_stream(file, unpacked)
    unpacked.seek(0)
    return cast(IO[bytes], unpacked)


class Whole(io.RawIOBase):
    """The bytes of a packed file, which end where it is cut short, not at an error before."""

    def __init__(self, file: Any) -> None:
        self.file = file
        self.is_cut = False
        self.seek, self.tell, self.fileno = file.seek, file.tell, file.fileno  # type: ignore[method-assign]

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        try:
            found = self.file.read1(len(buffer))
        except EOFError:
            self.is_cut = True
            return 0
        buffer[: len(found)] = found
        return len(found)

    def close(self) -> None:
        self.file.close()
        super().close()


def _library(name: str, opener: str) -> Callable[[Path], IO[bytes]]:
    """Opens files by one of Python's modules, which is imported when it is needed."""
    return lambda path: cast(IO[bytes], getattr(import_module(name), opener)(path))


OPENERS: dict[str, Callable[[Path], IO[bytes]]] = {
    ".gz": _library("gzip", "GzipFile"),
    ".bz2": _library("bz2", "BZ2File"),
    ".xz": _library("lzma", "LZMAFile"),
    ".zst": _zstd,
}


@lru_cache(maxsize=1)
def _all_of(stream: IO[bytes]) -> bytes:
    """All that comes from a stream, which several readers may want."""
    return stream.read()


def is_packed(path: Path) -> bool:
    """Whether the bytes are not those of the file on the disk."""
    return str(path) == suffix.STDIN or suffix.split(path)[1] != ""


def binary(path: Path) -> IO[bytes]:
    """A file's bytes, in which one can go back.

    Raises:
        RequestError: an extra is missing.
    """
    if str(path) == suffix.STDIN:
        return io.BytesIO(_all_of(sys.stdin.buffer))
    opener = OPENERS.get(suffix.split(path)[1])
    return path.open("rb") if opener is None else opener(path)


def lines(path: Path) -> Lines:
    """A file's lines. UTF-16 becomes UTF-8.

    Raises:
        RequestError: an extra is missing.
    """
    # Files on the disk without Python's buffer between: Lines has one of its own.
    packed = is_packed(path)
    raw: Any = binary(path) if packed else io.FileIO(path)
    raw = Whole(raw) if hasattr(raw, "read1") else raw
    begin = raw.read(2)
    raw.seek(0)
    if (order := ORDERS.get(begin)) is not None:
        text = raw.read().decode(order).encode()
        raw.close()
        raw, packed = io.BytesIO(text), True
    return Lines(path, io.BufferedReader(raw, BUFFER), packed)


@contextmanager
def on_disk(path: Path, form: str) -> Iterator[Path]:
    """A file of these bytes that libraries can open by its name."""
    if not is_packed(path):
        yield path
        return
    import shutil
    import tempfile

    with tempfile.TemporaryDirectory(prefix="clrt-") as folder:
        end = suffix.split(path)[1]
        name = path.name.removesuffix(path.name[-len(end) :]) if end else f"stdin.{form}"
        unpacked = Path(folder) / name
        with binary(path) as source, unpacked.open("wb") as file:
            shutil.copyfileobj(source, file, BUFFER)
        yield unpacked

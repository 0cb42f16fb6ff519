"""Image files: a film encoded by the suffix of its file's name, written whole or not at all."""

import os
import re
import secrets
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from clrt import data, memory
from clrt.errors import ClrtError, OutputError, RequestError


class ByteFormat(NamedTuple):
    """How Pillow writes an 8-bit format, and how large a picture can be."""

    name: str
    options: dict[str, Any]
    side: int = 2**31 - 1  # pixels each way
    pixels: int = 2**48  # in all
    memory: int = 4  # bytes a pixel that Pillow and the format's library take, measured


# PNG: level 1 takes 0.6 of the time of level 6 for 1.6 times the bytes. TIFF and BMP: files of
# 4 GiB, LZW makes noise longer by a third.
BYTE_FORMATS = {
    ".png": ByteFormat("PNG", {"compress_level": 1}),
    ".jpg": ByteFormat("JPEG", {"quality": 95, "subsampling": 0}, side=65500),
    ".jpeg": ByteFormat("JPEG", {"quality": 95, "subsampling": 0}, side=65500),
    ".webp": ByteFormat("WEBP", {"lossless": True, "method": 0}, side=16383, memory=28),
    ".tif": ByteFormat("TIFF", {"compression": "tiff_lzw"}, pixels=10**9),
    ".tiff": ByteFormat("TIFF", {"compression": "tiff_lzw"}, pixels=10**9),
    ".bmp": ByteFormat("BMP", {}, pixels=10**9),
    ".ppm": ByteFormat("PPM", {}),
}
ENDS = {".png": b"IEND\xaeB`\x82", ".jpg": b"\xff\xd9", ".jpeg": b"\xff\xd9"}
FLOAT_FORMATS = (".npy", ".pfm")
SUFFIXES = (*BYTE_FORMATS, *FLOAT_FORMATS)


def check_output(path: Path, width: int, height: int) -> None:
    """Finds out before rendering what would fail after it.

    Raises:
        RequestError: the suffix names no format, the format has no pictures of this size, or the
            file cannot be there.
        OutputError: film and format do not fit into memory.
    """
    check_suffix(path)
    check_file(path)
    suffix = path.suffix.lower()
    needed = 12  # bytes a pixel of a float film, which is written as it is
    if suffix in BYTE_FORMATS:
        form = BYTE_FORMATS[suffix]
        check_sides(path, width, height, form.side)
        if width * height > form.pixels:
            raise RequestError(f"{path}: {suffix} has no more than {form.pixels} pixels: use .png")
        needed = 3 + form.memory
    memory.require(needed * width * height, f"{path}: a picture of {width}x{height}")


def check_suffix(path: Path) -> None:
    """Finds out whether the suffix names a format.

    Raises:
        RequestError: it does not.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise RequestError(f"{path}: expected a name that ends in one of {' '.join(SUFFIXES)}")


def check_sides(path: Path, width: int, height: int, largest: int) -> None:
    """Finds out whether a format has such pictures.

    Raises:
        RequestError: it has not.
    """
    if max(width, height) > largest:
        most = f"{path.suffix} has no more than {largest} pixels each way"
        raise RequestError(f"{path}: {most}, not {width}x{height}")


def check_file(path: Path) -> None:
    """Finds out whether a file of this name could be written.

    Raises:
        RequestError: it is something else, or its folder is not there or not writable.
    """
    try:
        target = path.resolve()  # a link stays one, and what it names is written
        exists, has_folder = target.exists(), target.parent.is_dir()
        is_other = exists and not target.is_file()
    except (OSError, RuntimeError, ValueError) as error:
        raise RequestError(f"{path}: {getattr(error, 'strerror', None) or error}") from None
    if is_other:
        raise RequestError(f"{path}: is a folder or a device, expected a file's name")
    if not has_folder:
        raise RequestError(f"{path}: the folder {target.parent} does not exist")
    if exists and not os.access(target, os.W_OK):
        raise RequestError(f"{path}: is there and not writable")
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise RequestError(f"{path}: the folder {target.parent} is not writable")


def check_apart(output: Path, source: Path) -> None:
    """Finds out whether the output is what is read.

    Raises:
        RequestError: it is.
    """
    with suppress(OSError):
        if output.samefile(source):
            raise RequestError(f"{output}: is read as well: expected another name")


def film_dtype(path: Path) -> type[np.uint8] | type[np.float32]:
    """What the pixels of a film for this file are: uint8, or float32 (linear, not clipped)."""
    return np.uint8 if path.suffix.lower() in BYTE_FORMATS else np.float32


def save(path: str | Path, film: NDArray[Any]) -> None:
    """Writes a film to a file, whole or not at all. The suffix chooses the format.

    Args:
        film: (height, width, 3): uint8 for .png .jpg .webp .tif .bmp .ppm, float32 for .npy .pfm.

    Raises:
        RequestError: the film is not for this suffix, or the file cannot be there.
        OutputError: it could not be written, or the format cannot hold it.
    """
    path, film = Path(path), np.asarray(film)
    check_suffix(path)
    check_file(path)
    if film.ndim != 3 or film.shape[2] != 3 or film.dtype != film_dtype(path):
        expected = f"{np.dtype(film_dtype(path))} of shape (height, width, 3)"
        raise RequestError(f"{path}: expected {expected}, got {film.dtype} of {film.shape}")
    write = _write_bytes if film.dtype == np.uint8 else _WRITE_FLOATS[path.suffix.lower()]
    with written_whole(path) as beside, beside.open("wb") as file:
        write(file, path.suffix.lower(), film)


PART = r"\.[0-9a-f]{16}\.part"  # the name of a file that is being written


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Gives a file to write into, beside `path`, and then renames it to that.

    So `path` is there whole or not at all, whatever happens meanwhile.

    Raises:
        OutputError: it could not be written, or the format cannot hold it.
    """
    target = path.resolve()
    for old in data.abandoned(target.parent.glob(".*.part")):  # by one that was killed
        if re.fullmatch(PART, old.name):
            old.unlink(missing_ok=True)
    beside = target.with_name(f".{secrets.token_hex(8)}.part")
    lock = None
    try:
        beside.touch(exist_ok=False)
        with suppress(OSError):  # some network file systems have no locks
            lock = data.locked(beside)
        yield beside
        if target.exists():
            shutil.copymode(target, beside)
        beside.replace(target)
    except ClrtError:  # not of the writing
        raise
    except (OSError, ValueError, RuntimeError, OverflowError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise OutputError(f"{path}: cannot be written: {reason}") from None
    finally:
        with suppress(OSError):
            beside.unlink(missing_ok=True)
        if lock is not None:
            os.close(lock)


def load(path: Path) -> NDArray[np.float32]:
    """Reads a picture of any of the formats: float32 (height, width, 3), 8-bit ones as c / 255.

    Raises:
        RequestError: it is not there, or is no such picture.
        OutputError: it does not fit into memory.
    """
    if path.exists() and not path.is_file():
        raise RequestError(f"{path}: is a folder or a device, expected a picture")
    advice = "load parts of it"
    try:
        memory.require(2 * path.stat().st_size, str(path), advice)
        if path.suffix.lower() == ".npy":
            image = np.load(path, allow_pickle=False)
        elif path.suffix.lower() == ".pfm":
            image = _read_pfm(path)
        else:
            from PIL import Image

            Image.MAX_IMAGE_PIXELS = None  # clrt writes larger ones itself
            with Image.open(path) as opened:
                width, height = opened.size
                # Measured: Pillow's pictures before and after it converts them, and this one.
                memory.require(20 * width * height, f"{path}: {width}x{height}", advice)
                if opened.mode.startswith("I;16"):  # Pillow clips where it should divide
                    gray = np.asarray(opened).astype(np.float32) / np.float32(65535)
                    image = np.repeat(gray[..., np.newaxis], 3, axis=2)
                elif opened.mode in ("I", "F"):  # whose white nobody knows
                    raise ValueError(f"expected 8 or 16 bits a channel, got mode {opened.mode}")
                else:
                    image = np.asarray(opened.convert("RGB"))
    except OutputError:
        raise
    except Exception as error:  # what a spoilt file makes of NumPy and Pillow has no end
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        raise RequestError(f"{path}: cannot be read: {reason}") from None
    good = (
        isinstance(image, np.ndarray) and image.ndim == 3 and image.shape[2] == 3 and image.size > 0
    )
    if not good or (image.dtype != np.uint8 and image.dtype.kind != "f"):
        raise RequestError(f"{path}: expected float or uint8 of shape (height, width, 3)")
    scale = 255 if image.dtype == np.uint8 else 1
    linear: NDArray[np.float32] = image.astype(np.float32) / np.float32(scale)
    return linear


def is_whole(path: Path, width: int, height: int) -> bool:
    """Whether a file is a picture of this size, and its end is there."""
    kind = path.suffix.lower()
    with suppress(Exception):  # see load()
        if kind in FLOAT_FORMATS:
            found = np.load(path, "r") if kind == ".npy" else _read_pfm(path)
            return bool(found.shape == (height, width, 3))
        from PIL import Image

        Image.MAX_IMAGE_PIXELS = None
        with Image.open(path) as opened:
            if opened.size != (width, height):
                return False
            if kind in ENDS:  # to decode it would take longer than to render it
                with path.open("rb") as file:
                    file.seek(-len(ENDS[kind]), os.SEEK_END)
                    return file.read() == ENDS[kind]
            opened.load()
            return True
    return False


def _write_bytes(file: IO[bytes], suffix: str, film: NDArray[Any]) -> None:
    from PIL import Image

    form = BYTE_FORMATS[suffix]
    Image.fromarray(film).save(file, form.name, **form.options)


def _write_npy(file: IO[bytes], suffix: str, film: NDArray[Any]) -> None:
    # Not np.save(), which does not say why a disk takes no more.
    film = np.ascontiguousarray(film)
    header = np.lib.format.header_data_from_array_1_0(film)
    np.lib.format.write_array_header_1_0(file, header)
    file.write(film.data)


def _write_pfm(file: IO[bytes], suffix: str, film: NDArray[Any]) -> None:
    height, width, _ = film.shape
    # A negative scale says little-endian; rows run from the bottom to the top.
    file.write(b"PF\n%d %d\n-1.0\n" % (width, height))
    for row in film[::-1]:
        file.write(row.astype("<f4").tobytes())


_WRITE_FLOATS: dict[str, Callable[[IO[bytes], str, NDArray[Any]], None]] = {
    ".npy": _write_npy,
    ".pfm": _write_pfm,
}


def _read_pfm(path: Path) -> NDArray[Any]:
    with path.open("rb") as file:
        if file.readline().strip() != b"PF":
            raise ValueError("expected a PFM file of three channels")
        width, height = map(int, file.readline().split())
        order = "<" if float(file.readline()) < 0 else ">"
        pixels = np.frombuffer(file.read(), f"{order}f4")
    return pixels.reshape(height, width, 3)[::-1]

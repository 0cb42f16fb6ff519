"""Image files: a film encoded by the suffix of its file's name, written whole or not at all."""

import io
import os
import re
import secrets
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from clrt import memory, storage
from clrt.errors import ClrtError, OutputError, RequestError
from clrt.files import deep, png, vector
from clrt.film.decor.drawing import Overlay

Array = NDArray[Any]


class ByteFormat(NamedTuple):
    """How Pillow writes a format of integers, and how large a picture can be."""

    name: str
    options: dict[str, Any]
    side: int = 2**31 - 1  # pixels each way
    pixels: int = 2**48  # in all
    memory: int = 4  # bytes a pixel that Pillow and the format's library take, measured


# PNG is our own, see png.py. TIFF and BMP: files of 4 GiB, LZW makes noise longer by a third.
BYTE_FORMATS = {
    ".png": ByteFormat("PNG", {}, memory=0),
    ".jpg": ByteFormat("JPEG", {"quality": 95, "subsampling": 0}, side=65500),
    ".jpeg": ByteFormat("JPEG", {"quality": 95, "subsampling": 0}, side=65500),
    ".webp": ByteFormat(
        "WEBP", {"lossless": True, "exact": True, "method": 0}, side=16383, memory=28
    ),
    ".tif": ByteFormat("TIFF", {"compression": "tiff_lzw"}, pixels=10**9),
    ".tiff": ByteFormat("TIFF", {"compression": "tiff_lzw"}, pixels=10**9),
    ".bmp": ByteFormat("BMP", {}, pixels=10**9),
    ".ppm": ByteFormat("PPM", {}),
}
ENDS = {".png": b"IEND\xaeB`\x82", ".jpg": b"\xff\xd9", ".jpeg": b"\xff\xd9"}
FLOAT_FORMATS = tuple(deep.WRITE)
SUFFIXES = (*BYTE_FORMATS, *FLOAT_FORMATS)
"""Of files that are pixels; those of vector.py have words beside them."""
WITH_ALPHA = (".png", ".webp", ".tif", ".tiff", ".npy", ".npz", ".exr", *vector.SUFFIXES)
WITH_16_BITS = (".png", ".tif", ".tiff")
WITH_PASSES = (".npz", ".exr")
UNSIGNED = (np.uint8, np.uint16)
PASSES_BYTES = 20  # a pixel, of all passes
LOAD_PARTS = "load parts of it"


def check_output(
    path: Path,
    width: int,
    height: int,
    *,
    alpha: bool = False,
    bits: int | None = None,
    passes: bool = False,
) -> None:
    """Finds out before rendering whether saving would fail after it.

    Args:
        bits: of a channel, see film_dtype().
        passes: whether the file is to hold some.

    Raises:
        RequestError: the suffix names no format, the format has no such pictures, or the file
            cannot be there.
        OutputError: film and format do not fit into memory.
    """
    check_suffix(path)
    check_file(path)
    suffix = path.suffix.lower()
    film = film_dtype(path, bits)
    if alpha:
        _check_can(path, WITH_ALPHA, "alpha")
    if passes:
        _check_can(path, WITH_PASSES, "passes")
    needed = pixel = np.dtype(film).itemsize * (3 + alpha)  # bytes of the film, and all; measured
    if suffix in BYTE_FORMATS:
        form = BYTE_FORMATS[suffix]
        check_sides(path, width, height, form.side)
        if width * height > form.pixels:
            raise RequestError(f"{path}: {suffix} has no more than {form.pixels} pixels: use .png")
        needed += form.memory
    if film is np.uint16 and suffix != ".png":
        deep.check_size16(path, width, height)
        needed = 7 * pixel
    if suffix in vector.SUFFIXES:
        vector.check(path)
        needed += 40
    if suffix == ".exr":
        deep.library(*deep.OPENEXR)
        needed = 2 * pixel
    needed += 2 * PASSES_BYTES * passes
    memory.require(needed * width * height, f"{path}: a picture of {width}x{height}")


def _check_can(path: Path, suffixes: Sequence[str], what: str) -> None:
    if path.suffix.lower() not in suffixes:
        raise RequestError(f"{path}: {path.suffix} has no {what}: use one of {' '.join(suffixes)}")


def check_suffix(path: Path) -> None:
    """Finds out whether the suffix names a format.

    Raises:
        RequestError: it does not.
    """
    if path.suffix.lower() not in (known := (*SUFFIXES, *vector.SUFFIXES)):
        raise RequestError(f"{path}: expected a name that ends in one of {' '.join(known)}")


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
        target = path.resolve()  # a link stays one: its target is written
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
    """Finds out whether the output is the same file as the input.

    Raises:
        RequestError: it is.
    """
    with suppress(OSError):
        if output.samefile(source):
            raise RequestError(f"{output}: is read as well: expected another name")


def film_dtype(
    path: Path, bits: int | None = None
) -> type[np.uint8] | type[np.uint16] | type[np.float32]:
    """The dtype of a film for this file: uint8, uint16 or float32 (linear, not clipped).

    bits: of a channel, 8 or 16; default: 8, or the float32 of the format.

    Raises:
        RequestError: the format has no such pixels.
    """
    if bits == 16:
        _check_can(path, WITH_16_BITS, "16 bits a channel")
        return np.uint16
    if path.suffix.lower() in (*BYTE_FORMATS, *vector.SUFFIXES):
        return np.uint8
    if bits is not None:
        _check_can(path, tuple(BYTE_FORMATS), f"{bits} bits a channel")
    return np.float32


def save(
    path: str | Path,
    film: NDArray[Any],
    *,
    passes: Mapping[str, NDArray[Any]] | None = None,
    transfer: str = "linear",
    command: str = "",
    overlay: Overlay | None = None,
) -> None:
    """Writes a film to a file, whole or not at all. The suffix chooses the format.

    Args:
        film: (height, width, 3), or 4 with alpha where the format has it: uint8 for .png .jpg .webp
            .tif .bmp .ppm .svg .pdf, uint16 for .png .tif, float32 for .npy .npz .pfm .exr.
            Integers are straight colours, floats premultiplied ones.
        passes: "depth", "normal" and "id" as Renderer.render() gives them, for .npz and .exr.
        transfer: the curve of the integers in it, "linear" or "srgb": a PNG says if it is sRGB.
        command: the command that made it, which a PNG notes.
        overlay: words and shapes over it, for .svg and .pdf.

    Raises:
        RequestError: the film is not for this suffix, or the file cannot be there.
        OutputError: it could not be written, or the format cannot hold it.
    """
    path, film = Path(path), np.asarray(film)
    suffix = path.suffix.lower()
    check_suffix(path)
    check_file(path)
    dtypes = [np.dtype(film_dtype(path))] + [np.dtype(np.uint16)] * (suffix in WITH_16_BITS)
    channels = (3, 4) if suffix in WITH_ALPHA else (3,)
    if film.ndim != 3 or film.shape[2] not in channels or film.dtype not in dtypes:
        shape = f"(height, width, {' or '.join(map(str, channels))})"
        expected = f"{' or '.join(map(str, dtypes))} of shape {shape}"
        raise RequestError(f"{path}: expected {expected}, got {film.dtype} of {film.shape}")
    if passes:
        _check_can(path, WITH_PASSES, "passes")
    if transfer not in ("linear", "srgb"):
        raise RequestError(f"transfer: expected 'linear' or 'srgb', got {transfer!r}")
    if suffix in vector.SUFFIXES:
        with written_whole(path) as beside:
            vector.write(beside, suffix, film, overlay, transfer)
        return
    with written_whole(path) as beside, beside.open("wb") as file:
        if suffix in FLOAT_FORMATS:
            deep.WRITE[suffix](file, film, passes or {})
        else:
            _write_integers(file, suffix, film, _notes(transfer, command))


def as_png(film: NDArray[Any], *, transfer: str = "linear", command: str = "") -> bytes:
    """The .png that save() would write of a film of integers."""
    file = io.BytesIO()
    _write_integers(file, ".png", film, _notes(transfer, command))
    return file.getvalue()


@cache
def _sweep(folder: Path) -> None:
    """Removes the unfinished files of killed processes. Once: to list a folder of ten thousand
    pictures takes as long as to write one."""
    for old in storage.abandoned(folder.glob(".*.part")):
        if re.fullmatch(PART, old.name):
            old.unlink(missing_ok=True)


PART = r"\.[0-9a-f]{16}\.part"  # the name of a file that is being written


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Gives a file to write into, beside `path`, and then renames it to that.

    So `path` is there whole or not at all, whatever happens meanwhile.

    Raises:
        OutputError: it could not be written, or the format cannot hold it.
    """
    target = path.resolve()
    _sweep(target.parent)
    beside = target.with_name(f".{secrets.token_hex(8)}.part")
    lock = None
    try:
        beside.touch(exist_ok=False)
        with suppress(OSError):  # some network file systems have no locks
            lock = storage.locked(beside)
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
    """Reads a picture of any of the formats: float32 (height, width, 3), or 4 with alpha.

    Integers become parts of the largest, and premultiplied. Their curve stays as it is.

    Raises: as read().
    """
    image = read(path)
    loaded = image.astype(np.float32)
    if image.dtype.kind == "u":
        loaded /= np.float32(np.iinfo(image.dtype).max)
        if image.shape[2] == 4:
            loaded[..., :3] *= loaded[..., 3:]
    return loaded


def read(path: Path) -> NDArray[Any]:
    """Reads a picture of any of the formats: (height, width, 3 or 4), uint8, uint16 or of floats
    as in its file.

    Raises:
        RequestError: it is not there, or is no such picture.
        OutputError: it does not fit into memory.
    """
    if path.exists() and not path.is_file():
        raise RequestError(f"{path}: is a folder or a device, expected a picture")
    try:
        memory.require(2 * path.stat().st_size, str(path), LOAD_PARTS)
        image = deep.READ.get(path.suffix.lower(), _read_integers)(path)
    except (OutputError, RequestError):
        raise
    except Exception as error:  # NumPy and Pillow raise anything of a spoilt file
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        raise RequestError(f"{path}: cannot be read: {reason}") from None
    good = isinstance(image, np.ndarray) and image.ndim == 3 and image.shape[2] in (3, 4)
    if not good or image.size == 0 or not (image.dtype.kind == "f" or image.dtype in UNSIGNED):
        expected = "float, uint8 or uint16 of shape (height, width, 3 or 4)"
        raise RequestError(f"{path}: expected {expected}")
    picture: Array = image
    return picture


def _read_integers(path: Path) -> Array:
    from PIL import Image

    Image.MAX_IMAGE_PIXELS = None  # clrt writes larger ones itself
    with Image.open(path) as opened:
        width, height = opened.size
        is_deep = any(";16" in str(tile[3]) for tile in opened.tile)
        alpha = opened.has_transparency_data
        # Measured: Pillow's pictures before and after it converts them, and this one.
        needed = (36 if alpha or is_deep else 20) * width * height
        memory.require(needed, f"{path}: {width}x{height}", LOAD_PARTS)
        if opened.mode.startswith("I;16"):  # Pillow clips where it should divide
            return np.repeat(np.asarray(opened).astype(np.uint16)[..., np.newaxis], 3, axis=2)
        if opened.mode in ("I", "F"):  # whose white nobody knows
            raise ValueError(f"expected 8 or 16 bits a channel, got mode {opened.mode}")
        if is_deep:  # of which Pillow drops half
            return deep.read16(path, 4 if alpha else 3)
        return np.asarray(opened.convert("RGBA" if alpha else "RGB"))


def is_srgb(path: Path) -> bool | None:
    """Whether a picture says that it is sRGB; None where its format cannot say."""
    kind = path.suffix.lower()
    if kind in FLOAT_FORMATS:
        return False
    if kind != ".png":
        return None
    from PIL import Image

    with Image.open(path) as opened:
        return "srgb" in opened.info


def is_whole(path: Path, width: int, height: int) -> bool:
    """Whether a file is a picture of this size, and its end is there."""
    kind = path.suffix.lower()
    with suppress(Exception):  # see load()
        if kind in FLOAT_FORMATS:
            shape = np.load(path, "r").shape if kind == ".npy" else deep.READ[kind](path).shape
            return shape in ((height, width, 3), (height, width, 4))
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


def _notes(transfer: str, command: str) -> list[tuple[bytes, bytes]]:
    """The chunks of a PNG that tell its curve and its maker."""
    from importlib.metadata import version

    notes = [(b"sRGB", b"\0")] * (transfer == "srgb")  # perceptual
    notes.append((b"tEXt", f"Software\0clrt {version('clrt')}".encode()))
    if command:  # a file's name need not be text
        text = command.encode(errors="backslashreplace")
        notes.append((b"iTXt", b"Comment\0\0\0\0\0" + text))
    return notes


def _write_integers(
    file: IO[bytes], suffix: str, film: Array, notes: list[tuple[bytes, bytes]]
) -> None:
    if suffix == ".png":
        png.write(file, film, notes)
        return
    from PIL import Image

    form = BYTE_FORMATS[suffix]
    if film.dtype == np.uint16:
        file.write(deep.encoded16(film))
    else:
        Image.fromarray(film).save(file, form.name, **form.options)

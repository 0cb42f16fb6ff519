"""Deep pictures, which Pillow does not write: floats, and 16 bits a channel. Each format has an
encoder and a reader."""

import importlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from clrt.errors import RequestError

Array = NDArray[Any]
Passes = Mapping[str, Array]

# Libraries that only some formats need, and the advice where one is not installed.
OPENEXR = ("OpenEXR", ".exr needs OpenEXR: pip install openexr")
PYAV = ("av", "16 bits a channel need PyAV: pip install av")


def library(module: str, said: str) -> Any:
    """OPENEXR or PYAV.

    Raises:
        RequestError: it is not installed.
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        raise RequestError(said) from None


def _write_npy(file: IO[bytes], film: Array, passes: Passes) -> None:
    # Not np.save(), which does not say why a disk takes no more.
    film = np.ascontiguousarray(film)
    header = np.lib.format.header_data_from_array_1_0(film)
    np.lib.format.write_array_header_1_0(file, header)
    file.write(film.data)


def _read_npy(path: Path) -> Array:
    found: Array = np.load(path, allow_pickle=False)
    return found


def _write_npz(file: IO[bytes], film: Array, passes: Passes) -> None:
    np.savez(file, **{"image": film, **passes})  # type: ignore[arg-type]


def _read_npz(path: Path) -> Array:
    with np.load(path, allow_pickle=False) as found:
        image: Array = found["image"]
        return image


def _write_pfm(file: IO[bytes], film: Array, passes: Passes) -> None:
    height, width, _ = film.shape
    # A negative scale says little-endian; rows run from the bottom to the top.
    file.write(b"PF\n%d %d\n-1.0\n" % (width, height))
    for row in film[::-1]:
        file.write(row.astype("<f4").tobytes())


def _read_pfm(path: Path) -> Array:
    with path.open("rb") as file:
        if file.readline().strip() != b"PF":
            raise ValueError("expected a PFM file of three channels")
        width, height = map(int, file.readline().split())
        order = "<" if float(file.readline()) < 0 else ">"
        pixels = np.frombuffer(file.read(), f"{order}f4")
    return pixels.reshape(height, width, 3)[::-1]


# As compositors know them.
EXR_CHANNELS: dict[str, tuple[str, ...]] = {
    "depth": ("Z",),
    "normal": ("N.X", "N.Y", "N.Z"),
    "id": ("id",),
}


def _write_exr(file: IO[bytes], film: Array, passes: Passes) -> None:
    openexr = library(*OPENEXR)
    layers = [(tuple("RGBA"[: film.shape[2]]), film)]
    layers += [(EXR_CHANNELS[name], found) for name, found in passes.items()]
    channels = {}
    for names, values in layers:
        planes = np.moveaxis(values.reshape(*film.shape[:2], -1), 2, 0)
        for name, plane in zip(names, planes, strict=True):
            plane = np.ascontiguousarray(plane)
            channels[name] = plane.view(np.uint32) if plane.dtype == np.int32 else plane
    header = {"compression": openexr.ZIP_COMPRESSION, "type": openexr.scanlineimage}
    with openexr.File(header, channels) as written:
        written.write(file.name)


def _read_exr(path: Path) -> Array:
    openexr = library(*OPENEXR)
    with openexr.File(str(path), separate_channels=True) as found:
        channels = found.channels()
        names = [name for name in "RGBA" if name in channels]
        return np.stack([channels[name].pixels for name in names], axis=2)


WRITE: dict[str, Callable[[IO[bytes], Array, Passes], None]] = {
    ".npy": _write_npy,
    ".npz": _write_npz,
    ".pfm": _write_pfm,
    ".exr": _write_exr,
}
READ: dict[str, Callable[[Path], Array]] = {
    ".npy": _read_npy,
    ".npz": _read_npz,
    ".pfm": _read_pfm,
    ".exr": _read_exr,
}

PIXELS = {3: "rgb48", 4: "rgba64"}


def check_size16(path: Path, width: int, height: int) -> None:
    """Finds out whether a picture of 16 bits a channel could be written.

    Raises:
        RequestError: PyAV is not there, or FFmpeg has no pictures as large.
    """
    library(*PYAV)
    if (8 * width + 1024) * (height + 128) >= 2**31:
        raise RequestError(f"{path}: 16 bits a channel: no pictures as large as {width}x{height}")


def encoded16(film: NDArray[np.uint16]) -> bytes:
    """A picture of 16 bits a channel as a whole TIFF."""
    from fractions import Fraction

    av = library(*PYAV)
    pixels = PIXELS[film.shape[2]]
    frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(film), format=f"{pixels}le")
    encoder = av.CodecContext.create("tiff", "w")
    encoder.height, encoder.width, _ = film.shape
    encoder.pix_fmt, encoder.options = f"{pixels}le", {"compression_algo": "deflate"}
    encoder.time_base = encoder.sample_aspect_ratio = Fraction(1)
    return b"".join(bytes(packet) for part in (frame, None) for packet in encoder.encode(part))


def read16(path: Path, channels: int) -> NDArray[np.uint16]:
    """A picture of 16 bits a channel."""
    av = library(*PYAV)
    with av.open(str(path)) as file:
        frame = next(file.decode(video=0))
    found: NDArray[np.uint16] = frame.to_ndarray(format=f"{PIXELS[channels]}le")
    return found

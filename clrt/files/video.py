"""Videos: frames encoded by the suffix of the file's name, written whole or not at all."""

from collections.abc import Iterable, Iterator
from fractions import Fraction
from itertools import chain, pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from clrt import memory
from clrt.errors import RequestError
from clrt.files import image, numbered

if TYPE_CHECKING:
    import av

Frames = Iterable[NDArray[np.uint8]]

# Pillow's name of each format, and its options. Pillow keeps all frames until it has the last.
PICTURES: dict[str, tuple[str, dict[str, Any]]] = {
    ".webp": ("WEBP", {"quality": 70, "method": 2}),
    ".gif": ("GIF", {}),
    ".apng": ("PNG", {"compress_level": 1}),
}
SIDES = {".mp4": 16384, ".webp": 16383, ".gif": 65535, ".apng": 2**31 - 1}  # pixels each way
SUFFIXES = tuple(SIDES)
WITH_ALPHA = (".webp", ".apng")
# Of an .mp4, as H.264 numbers them (ITU-T H.273): matrix, primaries and transfer of BT.709, whose
# transfer players take for that of sRGB; and a range of 16 to 235.
BT709 = 1
LIMITED = 1


def check_output(
    path: Path, width: int, height: int, frames: int, fps: float, *, alpha: bool = False
) -> None:
    """Finds out before rendering whether saving would fail after it.

    Raises:
        RequestError: the suffix names no format, or none of this size or with alpha, or the folder
            or PyAV is not there.
        OutputError: the frames do not fit into memory.
    """
    if numbered.is_pattern(path):
        numbered.check_pattern(path)
        image.check_output(numbered.picture(path, 0), width, height, alpha=alpha)
        return
    if path.suffix.lower() not in SUFFIXES:
        known = " ".join(SUFFIXES)
        raise RequestError(
            f"{path}: expected a name that ends in {known}, or has #### for a number"
        )
    if alpha and path.suffix.lower() not in WITH_ALPHA:
        able = f"{' '.join(WITH_ALPHA)} or numbered pictures"
        raise RequestError(f"{path}: {path.suffix} has no alpha: use {able}")
    image.check_file(path)
    image.check_sides(path, width, height, SIDES[path.suffix.lower()])
    what = f"{path}: {frames} frames of {width}x{height}"
    if not 0.001 <= fps <= 1000:
        raise RequestError(f"--fps: expected a number from 0.001 to 1000, got {fps:g}")
    if path.suffix.lower() == ".gif" and not 1 / 655 <= fps <= 50:
        raise RequestError(f"{path}: .gif has from 1/655 to 50 frames a second, not {fps:g}")
    if path.suffix.lower() in PICTURES:
        needed = (16 + 10 * frames) * width * height  # measured, as for .mp4
        memory.require(needed, what, "take .mp4, fewer frames or smaller ones")
    else:
        if (width + 128) * (height + 128) >= 2**28:  # FFmpeg's
            raise RequestError(f"{path}: .mp4 has no frames as large as {width}x{height}")
        memory.require(70 * width * height, what, "take smaller ones")
        try:
            import av  # noqa: F401
        except ImportError:
            raise RequestError(f"{path}: .mp4 needs PyAV: pip install av") from None


def save(path: Path, frames: Frames, fps: float, crf: int) -> None:
    """Encodes frames, (height, width, 3) uint8 each, or 4 where the format has alpha: at least one.

    Args:
        fps: frames a second.
        crf: of .mp4: from 0, lossless, to 51; 18 is hard to tell from the picture.

    Raises:
        OutputError: it could not be written.
    """
    with image.written_whole(path) as beside:
        if path.suffix.lower() == ".mp4":
            _write_mp4(beside, iter(frames), fps, crf)
        else:
            name, options = PICTURES[path.suffix.lower()]
            _write_pictures(beside, frames, fps, name, options)


def _write_mp4(path: Path, frames: Iterator[NDArray[np.uint8]], fps: float, crf: int) -> None:
    import av

    first = next(frames)
    height, width, _ = first.shape
    # H.264 as browsers play it, yuv420p, has a colour for each 2 x 2 pixels: odd sizes get another
    # row or column, like the last.
    padding = ((0, height % 2), (0, width % 2), (0, 0))
    try:
        with av.open(str(path), "w", format="mp4", options={"movflags": "faststart"}) as file:
            stream = file.add_stream("libx264", rate=Fraction(fps).limit_denominator(1001))
            stream.width, stream.height = width + width % 2, height + height % 2
            stream.pix_fmt = "yuv420p"
            stream.options = {"crf": str(crf), "preset": "veryfast"}
            codec = stream.codec_context
            codec.colorspace = codec.color_primaries = codec.color_trc = BT709
            codec.color_range = LIMITED
            for frame in chain([first], frames):
                padded = np.pad(frame, padding, "edge") if height % 2 or width % 2 else frame
                file.mux(stream.encode(_as_bt709(padded)))
            file.mux(stream.encode())
    except av.FFmpegError as error:
        raise ValueError(f"H.264: {error.strerror or error}") from None


def _as_bt709(frame: NDArray[np.uint8]) -> "av.VideoFrame":
    """The frame as H.264 is given it: by the matrix of BT.709, in limited range.

    FFmpeg takes BT.601 by default, and a player that finds no matrix in a file guesses it by the
    picture's size: Chromium showed (213, 55, 39) for (200, 40, 40) at 1920x1080.
    """
    import av

    made = av.VideoFrame.from_ndarray(frame, format="rgb24").reformat(
        format="yuv420p",
        dst_colorspace="ITU709",
        src_color_range="JPEG",
        dst_color_range="MPEG",
    )
    made.colorspace, made.color_range = BT709, LIMITED
    return made


def _write_pictures(
    path: Path,
    frames: Frames,
    fps: float,
    name: str,
    options: dict[str, Any],
) -> None:
    from PIL import Image

    first, *rest = map(Image.fromarray, frames)
    if name == "WEBP" and first.mode == "RGBA":
        # Only frames that are whole keep their alpha where they are clear all along a side.
        options = {**options, "kmax": 1}
    # GIF counts hundredths of a second: each frame ends at the one nearest to its end.
    ends = [round(100 * k / fps) for k in range(len(rest) + 2)]
    in_hundredths = [10 * (end - start) for start, end in pairwise(ends)]
    with path.open("wb") as file:
        first.save(
            file,
            name,
            save_all=True,
            append_images=rest,
            duration=in_hundredths if name == "GIF" else 1000 / fps,
            loop=0,
            **options,
        )

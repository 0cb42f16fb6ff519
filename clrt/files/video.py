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

# FFmpeg's names of what H.264 is put into.
CONTAINERS = {".mp4": "mp4", ".mov": "mov", ".mkv": "matroska"}
# Pillow's name of each format, and its options. Pillow keeps all frames until it has the last.
PICTURES: dict[str, tuple[str, dict[str, Any]]] = {
    ".webp": ("WEBP", {"method": 2}),
    ".gif": ("GIF", {}),
    ".apng": ("PNG", {"compress_level": 1}),
}
SIDES = {
    **dict.fromkeys(CONTAINERS, 16384),
    **{".webp": 16383, ".gif": 65535, ".apng": 2**31 - 1},
}
"""Pixels each way."""
SUFFIXES = tuple(SIDES)
WITH_ALPHA = (".webp", ".apng")
TICKS = {".gif": 100, ".webp": 1000, ".apng": 1000}
"""In a second: each frame ends at the one nearest to its end. Chromium cuts those of .apng to so
many."""
SLOW = 0.010
"""Seconds: browsers show frames that are to last no longer ten times as long or so."""
CHROMA = "chroma-qp-offset=-6"
"""Hues are kept better than H.264 keeps those of films: a colour bar is off by 2.3 levels on
average in place of 3.2 (viridis, 640x360, crf 18), for a sixth more bytes."""
CRF, QUALITY = 18, 80
"""If none is given."""
# Of H.264, as H.264 numbers them (ITU-T H.273): matrix, primaries and transfer of BT.709, whose
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
        if path.suffix.lower() not in image.SUFFIXES:
            known = " ".join(image.SUFFIXES)
            raise RequestError(f"{path}: expected a name that ends in one of {known}")
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
            raise RequestError(f"{path}: H.264 has no frames as large as {width}x{height}")
        memory.require(70 * width * height, what, "take smaller ones")
        try:
            import av  # noqa: F401
        except ImportError:
            raise RequestError(f"{path}: {path.suffix} needs PyAV: pip install av") from None


def size_of(path: Path, width: int, height: int) -> tuple[int, int]:
    """The width and height that a video's file has. H.264 as browsers play it, yuv420p, has a
    colour for each 2 x 2 pixels: odd sizes get another row or column, like the last."""
    if path.suffix.lower() not in CONTAINERS:
        return width, height
    return width + width % 2, height + height % 2


def said(
    path: Path, width: int, height: int, frames: int, fps: float, quality: int | None = None
) -> str:
    """What a file has, in a line: its frames, and what it does not keep as it was asked for."""
    suffix, (columns, rows) = path.suffix.lower(), size_of(path, width, height)
    words = [f"{path}: {frames} frames of {columns}x{rows}"]
    if (columns, rows) != (width, height):
        words.append(f"for {width}x{height} is odd")
    if suffix == ".webp":
        words.append(f"quality {QUALITY if quality is None else quality}")
    if suffix in TICKS:
        lasts = _durations(suffix, fps, frames)
        least, most, unit = min(lasts), max(lasts), "hundredths of a second"
        if suffix != ".gif":
            unit = "ms"
        if least != most:
            words.append(f"that last {least} or {most} {unit}")
        if least / TICKS[suffix] <= SLOW:
            words.append(f"so short ({least} {unit}) that browsers show them longer")
    return ", ".join(words)


def _durations(suffix: str, fps: float, frames: int) -> list[int]:
    """How long frames last, in ticks of a format."""
    ends = [round(TICKS[suffix] * k / fps) for k in range(frames + 1)]
    return [end - start for start, end in pairwise(ends)]


def save(
    path: Path, frames: Frames, fps: float, crf: int | None = None, quality: int | None = None
) -> None:
    """Encodes frames, (height, width, 3) uint8 each, or 4 where the format has alpha: at least one.

    Args:
        fps: frames a second.
        crf: of H.264: from 0, lossless, to 51; default: 18, which is hard to tell from the picture.
        quality: of .webp: from 0 to 100, which is lossless; default: 80.

    Raises:
        OutputError: it could not be written.
    """
    with image.written_whole(path) as beside:
        suffix = path.suffix.lower()
        if suffix in CONTAINERS:
            _write_h264(beside, suffix, iter(frames), fps, CRF if crf is None else crf)
        else:
            _write_pictures(beside, suffix, frames, fps, QUALITY if quality is None else quality)


def _write_h264(
    path: Path, suffix: str, frames: Iterator[NDArray[np.uint8]], fps: float, crf: int
) -> None:
    import av

    first = next(frames)
    height, width, _ = first.shape
    padding = ((0, height % 2), (0, width % 2), (0, 0))
    flags = {} if suffix == ".mkv" else {"movflags": "faststart"}
    try:
        with av.open(str(path), "w", format=CONTAINERS[suffix], options=flags) as file:
            stream = file.add_stream("libx264", rate=Fraction(fps).limit_denominator(1001))
            stream.width, stream.height = width + width % 2, height + height % 2
            stream.pix_fmt = "yuv420p"
            stream.options = {"crf": str(crf), "preset": "veryfast", "x264-params": CHROMA}
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


def _write_pictures(path: Path, suffix: str, frames: Frames, fps: float, quality: int) -> None:
    from PIL import Image

    name, options = PICTURES[suffix]
    if suffix == ".webp":
        options = options | ({"lossless": True} if quality == 100 else {"quality": quality})
        if quality < 100:
            frames = map(_filled, frames)
    first, *rest = map(Image.fromarray, frames)
    if suffix == ".webp" and first.mode == "RGBA":
        # Only frames that are whole keep their alpha where they are clear all along a side.
        options = {**options, "kmax": 1}
    in_ms = [1000 // TICKS[suffix] * one for one in _durations(suffix, fps, len(rest) + 1)]
    with path.open("wb") as file:
        first.save(file, name, save_all=True, append_images=rest, duration=in_ms, loop=0, **options)


def _filled(frame: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A frame whose colours under alpha 0, which are black, are those of the nearest pixel of its
    row or of its column that is seen, or the mean of all where there is none. Lossy formats have a
    colour for 2 x 2 pixels and mix those of blocks: black there tinted silhouettes by up to 55
    levels."""
    if frame.shape[2] != 4 or frame[..., 3].all():
        return frame
    seen = frame[..., 3] > 0
    if not seen.any():
        return frame
    aside, far = _nearest(seen)
    upward, high = (one.T for one in _nearest(seen.T))
    row, column = np.indices(seen.shape)
    by_row = far <= high
    like = frame[np.where(by_row, row, upward), np.where(by_row, aside, column), :3]
    like[np.minimum(far, high) == NEVER] = frame[seen][:, :3].mean(axis=0)
    found = frame.copy()
    found[..., :3] = np.where(seen[..., np.newaxis], frame[..., :3], like)
    return found


NEVER = 1 << 30


def _nearest(seen: NDArray[np.bool_]) -> tuple[NDArray[np.integer], NDArray[np.integer]]:
    """For each pixel the column of the nearest one of its row that is seen, and how far away that
    is: NEVER, if there is none."""
    width = seen.shape[1]
    column = np.arange(width, dtype=np.int32)
    before = np.maximum.accumulate(np.where(seen, column, -NEVER), axis=1)
    after = np.minimum.accumulate(np.where(seen, column, NEVER)[:, ::-1], axis=1)[:, ::-1]
    is_after = after - column < column - before
    nearest = np.where(is_after, after, before)
    away = np.where(seen.any(axis=1, keepdims=True), abs(nearest - column), NEVER)
    return np.clip(nearest, 0, width - 1), away

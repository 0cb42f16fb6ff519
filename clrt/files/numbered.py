"""Numbered pictures: their names, and the file beside them that says how they are made.

So a video can be made in pieces, by several machines, of pictures that are of one kind.
"""

import math
import os
import re
import secrets
from collections.abc import Generator, Iterable
from contextlib import closing
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from clrt.errors import OutputError, RequestError
from clrt.files import image
from clrt.film.develop import integers
from clrt.pipeline import in_order

FPS = 30.0  # of pictures of which nothing is said
AHEAD = 2  # pictures that are read while one is encoded


class Kind(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The common ground of pictures that are frames of one video, equal to the bit whoever made
    them."""

    scene: str
    """A hash of it."""
    size: tuple[int, int]
    """Width and height, pixels."""
    precision: str
    lanes: int
    target: str
    """The CPU that the kernel is compiled for, see clrt.opencl.device.target()."""
    clrt: str
    """Its version."""


class Record(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The file beside the pictures."""

    kind: Kind
    fps: float
    """Frames a second, if none is left out."""
    frames: tuple[int, int, int]
    """The first, the last and the step of those that were asked for."""
    since: float = 0.0
    """Older pictures (seconds of the epoch, by the file system's clock) are of another kind."""

    def is_made(self, path: Path) -> bool:
        """Whether a picture is there, whole and of this kind."""
        return image.is_whole(path, *self.kind.size) and self.is_newer(path)

    def is_newer(self, path: Path) -> bool:
        return path.stat().st_mtime >= self.since


def is_pattern(path: Path) -> bool:
    """Whether the name stands for numbered pictures: it has #s where the number goes."""
    return "#" in path.name


def check_pattern(path: Path) -> None:
    """Finds out whether numbers have one place in the name.

    Raises:
        RequestError: they have not.
    """
    if not is_pattern(path):
        raise RequestError(f"{path}: expected a name with #### where the number goes")
    if "#" * path.name.count("#") not in path.name:
        raise RequestError(f"{path}: expected all # in one place")


def picture(pattern: Path, frame: int) -> Path:
    """The name of a frame's picture: #### becomes 0007."""
    hashes = pattern.name.count("#")
    return pattern.with_name(pattern.name.replace("#" * hashes, f"{frame:0{hashes}d}"))


def record_path(pattern: Path) -> Path:
    """The name of the file beside the pictures: frames/####.png has frames/frames.png.json."""
    return pattern.with_name(re.sub("#+", "frames", pattern.name) + ".json")


def found(pattern: Path, record: Record | None = None) -> list[int]:
    """The numbers of the pictures that are there and, if there is a record, not older than it says.

    Raises:
        RequestError: the folder cannot be read.
    """
    before, after = re.split("#+", pattern.name)
    name = re.compile(f"{re.escape(before)}([0-9]+){re.escape(after)}")
    try:
        matches = filter(None, map(name.fullmatch, os.listdir(pattern.parent)))
    except OSError as error:
        raise RequestError(f"{pattern}: {error.strerror}") from None
    there = ((int(match[1]), pattern.with_name(match[0])) for match in matches)
    return sorted(
        k
        for k, path in there
        if path == picture(pattern, k) and (record is None or record.is_newer(path))
    )


def record(pattern: Path) -> Record | None:
    """The note beside the pictures; None if there is none.

    Raises:
        RequestError: it cannot be read.
    """
    path = record_path(pattern)
    try:
        return msgspec.json.decode(path.read_bytes(), type=Record)
    except FileNotFoundError:
        return None
    except (OSError, msgspec.MsgspecError) as error:
        reason = getattr(error, "strerror", None) or error
        raise RequestError(f"{path}: cannot be read ({reason}): remove it to start anew") from None


def join(pattern: Path, kind: Kind, fps: float, frames: range, *, adds: bool) -> Record:
    """Says beside the pictures that these frames are going to be made, and how.

    Args:
        fps, frames: as in Record.
        adds: whether pictures that are there stay. Else, if all of them are among `frames`, they
            may be of another kind: they are made anew.

    Raises:
        RequestError: those that are there are of another kind.
        OutputError: it could not be written.
    """
    said = record(pattern)
    if said is None:
        _write(pattern, Record(kind, fps, _ends(frames)), keep=True)
        said = record(pattern) or Record(kind, fps, _ends(frames))  # another may have been first
    if said.kind != kind:
        if adds or not set(found(pattern)) <= set(frames):
            raise RequestError(_mixed(pattern, said.kind, kind))
        path = record_path(pattern)
        path.touch()
        said = Record(kind, fps, _ends(frames), path.stat().st_mtime)
        _write(pattern, said)
    both = _ends(hull([frames, of(said)]))
    if both != said.frames:
        said = msgspec.structs.replace(said, frames=both)
        _write(pattern, said)
    return said


def complete(pattern: Path, frames: range | None, step: int) -> tuple[range, float]:
    """The frames of a video that is made of pictures, and how many of them it shows a second.

    Args:
        frames: default: those that are there, and those that were asked for.
        step: only every stepth of them.

    Raises:
        RequestError: one is missing.
    """
    check_pattern(pattern)
    said = record(pattern)
    there = found(pattern, said)
    if frames is None:
        parts = [range(k, k + 1) for k in there] + ([of(said)] if said else [])
        if not parts:
            raise RequestError(f"{pattern}: no such pictures: render them first (clrt animate)")
        frames = hull(parts)
    chosen = frames[::step]
    if not chosen:
        raise RequestError("--frames: expected A-B with A <= B")
    if missing := sorted(set(chosen) - set(there)):
        name = picture(pattern, missing[0]).name
        what = f"{len(missing)} of {len(chosen)} pictures are missing, the first is {name}"
        advice = "render them (clrt animate --resume) or take others (--frames, --step)"
        raise RequestError(f"{pattern}: {what}: {advice}")
    return chosen, said.fps / chosen.step if said else FPS


def films(pattern: Path, frames: range) -> Generator[NDArray[np.uint8], None, None]:
    """Reads pictures, some ahead of the one that is yielded: uint8 (height, width, 3) each, or 4
    with straight alpha.

    Raises:
        RequestError: one is no picture, or has not the size of the first, or alpha as it has.
    """
    shape = None
    with closing(in_order(_film, (picture(pattern, k) for k in frames), AHEAD)) as read:
        for k, film in zip(frames, read, strict=True):
            shape = shape or film.shape
            if film.shape != shape:
                expected, got = (
                    f"{s[1]}x{s[0]}{' with alpha' * (s[2] == 4)}" for s in (shape, film.shape)
                )
                name = picture(pattern, k)
                raise RequestError(f"{name}: expected {expected} as the first, got {got}")
            yield film


def _film(path: Path) -> NDArray[np.uint8]:
    film = image.read(path)
    if film.dtype == np.uint16:
        return np.rint(film / 257).astype(np.uint8)
    return film if film.dtype == np.uint8 else integers(film, np.dtype(np.uint8), "linear")


def of(record: Record) -> range:
    """The frames that were asked for."""
    first, last, step = record.frames
    return range(first, last + 1, step)


def hull(parts: Iterable[range]) -> range:
    """The smallest evenly spaced range that holds them all, none of them empty."""
    parts = list(parts)
    first, last = min(part[0] for part in parts), max(part[-1] for part in parts)
    steps = (part.step for part in parts if len(part) > 1)
    step = math.gcd(*steps, *(part[0] - first for part in parts))
    return range(first, last + 1, step or 1)


def _ends(frames: range) -> tuple[int, int, int]:
    return frames[0], frames[-1], frames.step


def _mixed(pattern: Path, theirs: Kind, ours: Kind) -> str:
    names = Kind.__struct_fields__
    both = ((name, getattr(theirs, name), getattr(ours, name)) for name in names)
    what = "; ".join(f"{name} {a}, not {b}" for name, a, b in both if a != b)
    advice = f"(see {record_path(pattern).name}): render these alike, or remove those and it"
    return f"{pattern}: the pictures there have {what} {advice}"


def _write(pattern: Path, record: Record, *, keep: bool = False) -> None:
    """Writes it whole or not at all; with `keep` another's, written meanwhile, stays.

    Raises:
        OutputError: it could not be written.
    """
    path = record_path(pattern)
    beside = path.with_name(f".{secrets.token_hex(8)}.part")
    try:
        beside.write_bytes(msgspec.json.format(msgspec.json.encode(record)) + b"\n")
        try:
            os.link(beside, path)  # unless it is there
        except OSError as error:
            if not (keep and isinstance(error, FileExistsError)):  # or there are no links
                beside.replace(path)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror}") from None
    finally:
        beside.unlink(missing_ok=True)

"""STL: triangles with their corners, each for itself, as text or binary. Equal corners are one.

3D Systems, StereoLithography Interface Specification (1989).
"""

import re

import numpy as np

from clrt.errors import SceneError
from clrt.files.meshes.surface import Surface, merged
from clrt.files.particles import rules
from clrt.files.particles.text import Lines
from clrt.values import Array

FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
HEADER = 84  # bytes: words, and how many facets there are
VERTEX = re.compile(rb"^[ \t]*vertex[ \t]+(.*)$", re.MULTILINE | re.IGNORECASE)
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"


def read(lines: Lines) -> Surface:
    """The facets of a file. Their normals are not read: corners tell them.

    Raises:
        SceneError: naming file and line, and what was expected.
    """
    whole = lines.file.read()
    if len(whole) >= HEADER:
        count = int.from_bytes(whole[80:84], "little")
        size = HEADER + count * FACET.itemsize
        # Binary ones may begin with "solid" as well. Their length tells.
        if size == len(whole) or whole.lstrip()[:5].lower() != b"solid":
            return _binary(lines, whole, count)
    return _text(lines, whole)


def _binary(lines: Lines, whole: bytes, count: int) -> Surface:
    there = (len(whole) - HEADER) // FACET.itemsize
    if there < count:
        raise SceneError(f"{lines.path}: expected {count} facets, the file ends after {there}")
    facets = np.frombuffer(whole, FACET, count, HEADER)
    if (facets["more"] & 0x8000).any():
        rules.say(str(lines.path), "colours of facets: are not read")
    corners = facets["corners"].astype(np.float32).reshape(-1, 3)
    return _surface(corners)


def _text(lines: Lines, whole: bytes) -> Surface:
    if whole.lstrip()[:5].lower() != b"solid":
        raise SceneError(f"{lines.path}: expected 'solid' or a binary STL, got {whole[:20]!r}")
    found = VERTEX.findall(whole)
    text = b"\n".join(found)
    numbers = np.fromstring(text, np.float64, sep=" ") if _is_numbers(text) else np.zeros(0)
    if len(numbers) != 3 * len(found) or len(found) % 3:
        raise _wrong(lines, whole)
    return _surface(numbers.reshape(-1, 3))


def _is_numbers(text: bytes) -> bool:
    """Whether there are but numbers, for NumPy stops at a word without an error."""
    return not text.translate(None, b"0123456789+-.eE \t\r\n")


def _wrong(lines: Lines, whole: bytes) -> SceneError:
    """What is wrong with the first line that is."""
    corners = 0
    for number, line in enumerate(whole.decode("utf-8", "replace").splitlines(), 1):
        words = line.split()
        if not words:
            continue
        lines.number = number
        key = words[0].lower()
        if key == "vertex":
            corners += 1
            if len(words) != 4 or not all(re.fullmatch(NUMBER, word) for word in words[1:]):
                return lines.error("vertex and three numbers", line.strip())
        elif key == "endloop":
            if corners != 3:
                return lines.error("a loop of three vertices", f"{corners}")
            corners = 0
    return lines.error("a loop of three vertices", None)


def _surface(corners: Array) -> Surface:
    vertices, which = merged(corners)
    return Surface(vertices, which.reshape(-1, 3))

"""Develop: the steps of a picture after it was traced, always in this order:

    depth cue -> outline -> cells, labels, colour bar, words -> background -> clip ->
    transfer -> bytes

The scene's `film` says which steps there are. Each is a function of arrays, and works on pixels
(..., 4): linear red, green and blue, premultiplied by the alpha that comes last. The kernel has
added the background that mirrored rays see; the background that the camera sees is added here. If
noise is filtered (kernels/denoise.cl), it is before all of these.
"""

import functools
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from clrt.film import color
from clrt.scene.film import Film
from clrt.values import Color

Array = NDArray[Any]

BLOCK = 1 << 13  # pixels that are developed at a time: their arrays stay in the cache

EVERYWHERE = 1 << 31
"""More pixels than a picture has each way."""

NEARER = 0.25
"""How far a line lies on the nearer side of its edge, in pixels: so it is as many pixels wide as it
is to be, with even numbers as with odd ones."""


def needs_passes(film: Film) -> bool:
    """Whether some step looks at depths and ids."""
    return film.outline > 0 or film.depth_cue != (0, 0) or bool(film.cells or film.labels)


def has_marks(film: Film) -> bool:
    """Whether something is drawn over the picture: clrt.decor has it."""
    words = film.title or film.label or film.axes or film.scalebar is not None
    return bool(film.cells or film.colorbar or film.labels or words)


def has_steps(film: Film, dtype: np.dtype[Any], alpha: bool) -> bool:
    """Whether a picture of that dtype, with alpha or without, needs steps here: kernels make
    floats, linear bytes, and floats with alpha."""
    if needs_passes(film) or has_marks(film) or (any(film.background) and not alpha):
        return True
    return dtype != np.float32 and (alpha or dtype != np.uint8 or film.transfer != "linear")


def line_width(film: Film, samples: int = 1) -> float:
    """Of an outline. At one sample a pixel a line that is there has a pixel at least."""
    least = 1.0 if samples == 1 else 0.0
    return max(film.outline, least) if film.outline > 0 else 0.0


def halo(film: Film, samples: int = 1) -> int:
    """How many pixels around a region its steps look at."""
    if film.labels:  # one that is elsewhere may take the place of one that would be here
        return EVERYWHERE
    line = int(line_width(film, samples) / 2 + 0.5 + NEARER) + 1 if film.outline > 0 else 0
    return max(line, int(samples > 1 and film.depth_cue != (0, 0)))


class Seen(NamedTuple):
    """The first surfaces that the camera sees, in a picture and as far around it as halo() says."""

    sphere: Array
    """(height, width), the index of the one that is seen, -1 for none."""
    depth: Array
    """(height, width), world units, infinity where there is none."""
    radius: Array
    """(spheres,), world units."""
    picture: tuple[slice, slice]
    """Where in it the picture lies."""
    samples: int = 1
    """The most that a pixel gets. These are at its middle."""


class Marks(NamedTuple):
    """Colours over n pixels of a picture."""

    pixel: Array
    """(n,), row times the picture's width plus column, ascending."""
    color: Array
    """(n, 4) float32, premultiplied."""
    hides: bool = False
    """Nothing of the picture is left under it."""


def develop(
    exposed: Array,
    film: Film,
    out: Array,
    seen: Seen | None = None,
    marks: Sequence[Marks] = (),
) -> None:
    """Takes a picture through all its steps.

    Args:
        exposed: (height, width, 4) float32, premultiplied.
        out: (height, width, 3), or 4 with alpha, float32, uint8 or uint16: where it goes. Integers
            are straight colours, floats premultiplied ones.
        seen: if needs_passes().
        marks: if has_marks(), one over the other.
    """
    depth = line = None
    if seen is not None and film.outline > 0:
        width = line_width(film, seen.samples)
        line = outline(seen.sphere, seen.depth, seen.radius, width)[seen.picture]
        if seen.samples == 1:  # either the pixel's middle is on the line or it is not
            line = line > 0.5
    if seen is not None and film.depth_cue != (0, 0):
        depth = (seen.depth if seen.samples == 1 else up_to_edges(seen.depth))[seen.picture]
    rows = max(BLOCK // exposed.shape[1], 1)
    starts = range(0, len(exposed), rows)
    ends = np.append(starts, len(exposed)) * exposed.shape[1]
    cuts = [np.searchsorted(one.pixel, ends).tolist() for one in marks]
    for i, start in enumerate(starts):
        some = slice(start, start + rows)
        picture = exposed[some]
        if depth is not None:
            picture = depth_cued(picture, depth[some], film.depth_cue)
        if line is not None:
            picture = drawn_over(picture, line[some], film.outline_color)
        for one, cut in zip(marks, cuts, strict=True):
            if cut[i] < cut[i + 1]:
                picture = marked(picture, start * exposed.shape[1], one)
        if out.shape[2] == 3:
            picture = on_background(picture, film.background)
        if out.dtype.kind == "u":
            picture = integers(picture, out.dtype, film.transfer)
        out[some] = picture


def up_to_edges(depth: Array) -> Array:
    """Depths, also of pixels whose middle is just beside a sphere that they show: the least of
    their neighbours'."""
    around = np.pad(depth, 1, constant_values=np.inf)
    rows, columns = depth.shape
    least = depth
    for down in range(3):
        for right in range(3):
            least = np.minimum(least, around[down : down + rows, right : right + columns])
    return np.where(np.isinf(depth), least, depth)


def depth_cued(picture: Array, depth: Array, cue: tuple[float, float]) -> Array:
    """Fades far surfaces: all of a surface is there at the depth cue[0], nothing at cue[1].

    depth: (...), world units; infinity where there is nothing.
    """
    near, far = cue
    share = np.clip((depth - near) / (far - near), 0, 1)
    found: Array = picture * (1 - share)[..., np.newaxis]
    return found


def outline(sphere: Array, depth: Array, radius: Array, width: float) -> Array:
    """How much of each pixel is on a line, (height, width) float32 in [0, 1].

    A line runs where a sphere stands before nothing, or before another one whose depth is more than
    half the smaller radius away.

    Args:
        sphere: (height, width), the index of the one that is seen, -1 for none.
        depth: (height, width), infinity where there is none.
        radius: (spheres,), in the unit of the depths.
        width: of the line, pixels.
    """
    reach = width / 2 + 0.5  # a pixel is half a pixel long from its middle
    margin = int(reach + NEARER)
    rows, columns = sphere.shape
    covered = np.zeros((rows + 2 * margin, columns + 2 * margin), np.float32)
    flat, stride = covered.reshape(-1), covered.shape[1]
    for axis in (0, 1):
        for step, near in zip((1, -1), _nearer_sides(sphere, depth, radius, axis), strict=True):
            here = (near[:, 0] + margin) * stride + near[:, 1] + margin
            shift = [0.0, 0.0]
            shift[axis] = NEARER * step
            for down in range(-margin, margin + 1):
                for right in range(-margin, margin + 1):
                    share = reach - np.hypot(down - shift[0], right - shift[1])
                    if share > 0:
                        there = here + down * stride + right
                        flat[there] = np.maximum(flat[there], np.float32(min(share, width, 1)))
    return covered[margin : margin + rows, margin : margin + columns]


def _nearer_sides(sphere: Array, depth: Array, radius: Array, axis: int) -> tuple[Array, Array]:
    """The pixels (n, 2) that a line parts from the next one along an axis, and that are the nearer
    of the two; and those that a line parts from the one before, likewise."""
    differ = sphere[1:] != sphere[:-1] if axis == 0 else sphere[:, 1:] != sphere[:, :-1]
    this = np.argwhere(differ)
    following = this + np.eye(2, dtype=np.int64)[axis]
    a, b = tuple(this.T), tuple(following.T)
    jump = depth[b] - depth[a]  # at most one of them is infinite
    size = np.append(radius, np.inf)  # that of none, -1, is the last
    edge = abs(jump) > np.minimum(size[sphere[a]], size[sphere[b]]) / 2
    return this[edge & (jump > 0)], following[edge & (jump < 0)]


def drawn_over(picture: Array, share: Array, ink: Color) -> Array:
    """Covers a share of each pixel, (...), with a colour that hides what is behind it."""
    share = share[..., np.newaxis]
    found: Array = picture * (1 - share) + share * np.array((*ink, 1), picture.dtype)
    return found


def marked(picture: Array, first: int, marks: Marks) -> Array:
    """Rows of a picture with the marks over them.

    first: the number of their first pixel in the picture.
    """
    height, width, _ = picture.shape
    start, end = np.searchsorted(marks.pixel, (first, first + height * width))
    if start == end:
        return picture
    found = picture.copy()
    pixels, over = found.reshape(-1, 4), marks.color[start:end]
    at = marks.pixel[start:end] - first
    pixels[at] = over if marks.hides else pixels[at] * (1 - over[:, 3:]) + over
    return found


def on_background(picture: Array, background: Color) -> Array:
    """The colours (..., 3) of a picture before a background."""
    found: Array = picture[..., :3]
    if any(background):
        left = 1 - picture[..., 3]
        found = np.empty(found.shape, picture.dtype)
        for i, part in enumerate(np.array(background, picture.dtype)):  # in long loops
            np.add(picture[..., i], left * part, out=found[..., i])
    return found


def integers(picture: Array, dtype: np.dtype[Any], transfer: str) -> Array:
    """Pixels as whole numbers, 0 to 255 or 65535, ties to even: (..., 3), or with alpha (..., 4).

    With alpha colours are straight. They are clipped, and sRGB if `transfer` is; alpha is linear.
    """
    plain = dtype == np.uint8 and picture.dtype == np.float32 and picture.shape[-1] == 3
    if plain and transfer == "srgb":
        return _srgb_bytes(picture)
    exact = picture.astype(np.float64)  # float32 would round twice
    if picture.shape[-1] == 4:
        alpha = exact[..., 3:]
        exact[..., :3] /= np.where(alpha > 0, alpha, 1)
    exact = np.fmin(np.fmax(exact, 0), 1)  # NaN is 0
    if transfer == "srgb":
        exact[..., :3] = color.to_srgb(exact[..., :3])
    whole: Array = np.rint(np.iinfo(dtype).max * exact).astype(dtype)
    return whole


LEAST = np.float32(2.0**-13)
"""Less than this is byte 0 on the curve of sRGB."""
SHIFT = 12
"""Bits of a float32 that a step of the table has not: it has 2048 steps from x to 2 x."""
FIRST, ONE, INFINITE = (int(np.float32(x).view(np.uint32)) >> SHIFT for x in (LEAST, 1, np.inf))


def _srgb_bytes(picture: Array) -> Array:
    """What integers() finds without this, sooner: by a table, and where a step of it has two bytes
    by the curve itself."""
    linear = picture.reshape(-1)
    # As indices that NumPy need neither convert nor check: half the time. A float below 0 is a
    # number below 0, hence the first step; the last is that of NaN.
    step = (linear.view(np.int32) >> SHIFT).astype(np.intp) - FIRST
    found: Array = _srgb_table().take(step, mode="clip")
    doubtful = np.flatnonzero(found < 0)
    found[doubtful] = _on_curve(linear[doubtful])
    return found.astype(np.uint8).reshape(picture.shape)


def _on_curve(linear: Array) -> Array:
    exact = np.fmin(np.fmax(linear.astype(np.float64), 0), 1)  # NaN is 0
    found: Array = np.rint(255 * color.to_srgb(exact)).astype(np.int16)
    return found


@functools.cache
def _srgb_table() -> Array:
    """int16, the byte of every step from LEAST to infinity; -1 where it has two."""
    begin = np.arange(FIRST, ONE, dtype=np.uint32) << SHIFT
    end = begin + ((1 << SHIFT) - 1)
    low, high = (_on_curve(bits.view(np.float32)) for bits in (begin, end))
    below = np.where(low == high, low, -1).astype(np.int16)
    # The last step, to which NaN is clipped, has both.
    return np.concatenate([below, np.full(INFINITE - ONE, 255, np.int16), [np.int16(-1)]])

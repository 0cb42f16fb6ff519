"""Structs: each dtype stands for the struct of the same name in ``kernels/*.cl``, byte for byte.

The comments there say what the fields mean.
"""

from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[Any]
Real: TypeAlias = type[np.float32] | type[np.float64]
Precision: TypeAlias = Literal["robust", "literal", "double"]
PRECISIONS: dict[Precision, Real] = {
    "robust": np.float32,
    "literal": np.float32,
    "double": np.float64,
}
FilmKind: TypeAlias = Literal["float", "bytes", "alpha", "guides", "passes", "paths"]
PASSES = np.dtype([("depth", np.float32), ("normal", np.float32, 3), ("id", np.int32)])
GUIDES = np.dtype(
    [
        ("color", np.float32, 4),
        ("albedo", np.float32, 3),
        ("normal", np.float32, 3),
        ("depth", np.float32),
        ("square", np.float32),
    ]
)
FILMS: dict[FilmKind, tuple[np.dtype[Any], int]] = {
    "float": (np.dtype(np.float32), 3),
    "bytes": (np.dtype(np.uint8), 3),
    "alpha": (np.dtype(np.float32), 4),
    "guides": (GUIDES, 1),
    "passes": (PASSES, 1),
    "paths": (np.dtype(np.uint32), 1),
}
"""What the kernel stores for each pixel: of what dtype, and how many (film.cl)."""

# Beyond these a larger value gives the same picture: the host takes it down to them, so that no
# finite scene makes a kernel compute infinity - infinity or 0 * infinity.
MAX_RADIUS = 2.0**53  # in units of the scene's extent: a plane to the last bit of a float64
MAX_DISTANCE = 2.0**40  # of a light, the bias and a screen's side, in the same units
MAX_COLOR = 2.0**50  # white is 1
MAX_EXPONENT = 2.0**100
VEIL: dict[Real, float] = {np.float32: 2.0**23, np.float64: 2.0**40}
"""A veil's unit, see veiled() of sphere.cl."""
MAX_STRENGTH = 2.0**126  # of a light at distance 1

LEAST_RADIUS: dict[Real, float] = {np.float32: 2.0**-69, np.float64: 2.0**-531}
"""In units of the scene's extent. A radius' square, 2^-138, has 11 bits above the least number that
there is, so the silhouette is off by 2^-12 of the radius at most; float64 likewise."""
LEAST_FACE: dict[Real, float] = {np.float32: 2.0**-46, np.float64: 2.0**-354}
"""Likewise of a face's side: to find where a ray meets it three lengths are multiplied."""
SPECK = 1e-5
"""A sphere of a radius less than this many times its distance is not worth an error: it is less
than a hundredth of a pixel."""

COLORS = ("ambient", "diffuse", "specular")
AXES = ("right", "up", "back")


def camera_dtype(real: Real) -> np.dtype[Any]:
    fields = [("step", real, 2), ("eye", real, 3), ("last", np.int32, 2)]
    axes = [(axis, real, 3) for axis in AXES]
    blur = [("aperture", real), ("inv_focus", real)]
    return np.dtype([*fields, *axes, ("unit", real), *blur], align=True)


def glass_dtype(real: Real, opacity: bool = False) -> np.dtype[Any]:
    integer = np.int64 if real is np.float64 else np.int32
    more = [("opacity", real)] if opacity else []
    return np.dtype([("order", integer), ("veil", integer), *more])


def medium_dtype(real: Real) -> np.dtype[Any]:
    return np.dtype([("sphere", np.int32), ("order", np.int32), ("ior", real)], align=True)


def sphere_dtype(real: Real) -> np.dtype[Any]:
    return np.dtype(
        [
            ("anchor", real, 3),
            ("c0", real),
            ("offset", real, 3),
            ("camera_c", real),
            ("screen_bounds", real, 4),
            ("inv_radius", real),
            ("horizon", real),
            ("giant", np.int32),
            ("material", np.int32),
        ],
        align=True,
    )


def face_look_dtype(real: Real) -> np.dtype[Any]:
    numbers = [(name, np.int32) for name in ("shading", "token", "closed")]
    return np.dtype([("normal", real, 3), *numbers], align=True)


def material_dtype(real: Real) -> np.dtype[Any]:
    names = ("exponent", "reflection", "transmission", "ior", "fresnel", "spread")
    return np.dtype([*((name, real) for name in names), ("diffuse", real, 3)])


def light_dtype(real: Real) -> np.dtype[Any]:
    fade, cone = [("fade", real, 3), ("strength", real)], [("axis", real, 3), ("edge", real, 2)]
    return np.dtype([("position", real, 3), *fade, *cone, ("radius", real)])


def shade_dtype(real: Real) -> np.dtype[Any]:
    return np.dtype([(color, real, 3) for color in COLORS], align=True)


def overflow(precision: Precision) -> Any:
    """ "literal" lets float32 overflow to infinity, as the paper's formula would; anything else
    that overflows is a bug."""
    return np.errstate(over="ignore" if precision == "literal" else "raise")

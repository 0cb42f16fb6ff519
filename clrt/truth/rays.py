"""Rays: those at one bounce, as arrays. A vector is an array of shape (3, n), one column a ray."""

from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[Any]


def dot(a: Array, b: Array) -> Array:
    product: Array = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product


def norm(a: Array) -> Array:
    length: Array = np.sqrt(dot(a, a))
    return length


def unit(a: Array) -> Array:
    length = norm(a)
    return np.divide(a, length, out=np.zeros_like(a), where=length > 0)


@dataclass
class Rays:
    """Rays that are at the same bounce, one a column."""

    pixel: Array
    """Whose light they bring, (n,): no two of them the same one's."""
    weight: Array
    """How much of it the pixel gets."""
    origin: Array
    direction: Array
    leaves: Array
    """The sphere that each comes from; -1: the camera."""
    inside: NDArray[np.bool_]
    """(n, transparent spheres): which it is inside of."""
    path: NDArray[np.uint32]
    """A hash of the spheres and lights that it has met."""
    bounce: int
    behind: Array
    """How far along each the last surface is that it went straight through; -infinity: none yet."""
    passed: Array
    """The sphere of that surface; -1: none."""

    def turned(self) -> "Rays":
        """Them, on a way on which they have gone through nothing yet."""
        return replace(
            self, behind=np.full_like(self.behind, -np.inf), passed=np.full_like(self.passed, -1)
        )

    def only(self, some: Array, **changes: Array) -> "Rays":
        """The rays of a mask, each quantity as it is or as it is given."""
        kept = {
            name: changes.get(name, getattr(self, name))[..., some]
            for name in (
                "pixel",
                "weight",
                "origin",
                "direction",
                "leaves",
                "path",
                "behind",
                "passed",
            )
        }
        inside = changes.get("inside", self.inside)[some]
        return Rays(**kept, inside=inside, bounce=self.bounce)

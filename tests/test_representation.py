"""Particles as spheres."""

import numpy as np

from clrt.figure.representation import represented
from clrt.particles.particles import Particles


def test_positions_are_centres_and_not_copied() -> None:
    bare = Particles(np.arange(12.0).reshape(4, 3))
    assert represented(bare, radius=1).spheres.center is bare.positions

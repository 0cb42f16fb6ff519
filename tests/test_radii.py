"""How large the spheres of particles are."""

import numpy as np
import pytest

from clrt.errors import ParticleWarning
from clrt.figure.representation import represented
from clrt.particles.particles import Particles

AT = np.arange(12.0).reshape(4, 3)
OWN = Particles(AT, radii=[1, 2, 3, 4], elements=[1, 6, 8, 0])
BARE = Particles(AT)


def test_radii_are_the_files_or_the_elements() -> None:
    assert represented(OWN).spheres.radius.tolist() == [1, 2, 3, 4]
    assert represented(OWN, scale=0.5).spheres.radius.tolist() == [0.5, 1, 1.5, 2]
    assert represented(OWN, radius=2, scale=0.5).spheres.radius.tolist() == [1, 1, 1, 1]
    atoms = Particles(AT, elements=[1, 6, 8, 0])
    assert represented(atoms).spheres.radius.tolist() == [1.2, 1.7, 1.52, 1.0]
    nm = Particles(AT, elements=[1, 6, 8, 0], unit="nm")
    assert represented(nm).spheres.radius == pytest.approx([0.12, 0.17, 0.152, 0.1])


def test_a_radius_of_the_neighbours_is_said() -> None:
    with pytest.warns(ParticleWarning, match=r"radius 2\.598: half the median .* --radius X"):
        found = represented(BARE).spheres.radius
    assert found == pytest.approx(np.full(4, 27**0.5 / 2))
    with pytest.warns(ParticleWarning, match="radius 1: there is one place"):
        assert represented(Particles(AT[:1])).spheres.radius == 1

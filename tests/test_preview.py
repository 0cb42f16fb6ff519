"""Spheres as discs, beside the truth."""

import numpy as np
import pytest

import clrt
from clrt.figure import compose
from clrt.figure.framing import Projection
from clrt.viewer.preview import HEIGHT, PAINTED, preview


@pytest.mark.parametrize("projection", ["perspective", "orthographic"])
def test_it_covers_what_the_picture_covers(projection: Projection) -> None:
    random = np.random.default_rng(1)
    particles = clrt.Particles(random.uniform(0, 4, (20, 3)), radii=0.4)
    look = clrt.figure.Look(projection=projection, size=(160, 90), style="matte")
    scene = compose.scene(particles, look)
    seen = clrt.reference.trace(scene, 160, 90).id >= 0
    found = (preview(scene, (160, 90)) != 255).any(axis=2)
    assert (found != seen).mean() < 0.02
    assert seen.mean() > 0.05


def test_the_nearer_one_is_in_front() -> None:
    ends = clrt.Particles(np.diag([0, 0, 1.0])[1:], radii=0.5, colors=np.diag([1.0, 0, 1])[::2])
    scene = compose.scene(ends, clrt.figure.Look(view="z", size=(90, 90)))
    red, _, blue = preview(scene, (90, 90))[45, 45].astype(int)
    assert blue > 100 > red


def test_its_size_and_its_work_have_a_limit() -> None:
    random = np.random.default_rng(1)
    n = 20_000
    many = clrt.Particles(random.uniform(0, 1, (n, 3)), radii=0.3)
    scene = compose.scene(many, clrt.figure.Look(size=(1920, 1080), style="matte"))
    assert n * HEIGHT > PAINTED
    assert preview(scene, (1920, 1080)).shape == (HEIGHT, 320, 3)
    assert preview(clrt.load_scene("four-spheres"), (3, 2)).shape == (2, 3, 3)

"""What gives particles their colours and opacities, and what is asked for that they do not have."""

from typing import Any

import numpy as np
import pytest

from clrt.errors import RequestError
from clrt.figure.representation import represented
from clrt.film import color
from clrt.particles import elements, palette
from clrt.particles.particles import Particles

AT = np.arange(12.0).reshape(4, 3)
ALL = Particles(
    AT,
    radii=[1, 2, 3, 4],
    colors=np.array([(255, 0, 0), (0, 128, 0), (0, 0, 7), (9, 9, 9)], np.uint8),
    elements=[1, 6, 8, 0],
    types=[1, 2, 9, -1],
    values={"v": [np.nan, 2.0, 4.0, np.inf], "flat": [5.0, 5.0, 5.0, 5.0]},
)
BARE = Particles(AT)
STEEL = np.array([70, 130, 180], np.uint8)


def test_the_first_colours_that_there_are() -> None:
    assert represented(ALL).source.by == "file"
    assert (
        represented(Particles(AT, elements=[1, 1, 1, 1], types=[0, 0, 0, 0])).source.by == "element"
    )
    assert represented(Particles(AT, types=[0, 0, 0, 0]), radius=1).source.by == "type"
    bare = represented(BARE, radius=1)
    assert bare.source.by == "one"
    assert bare.spheres.color == pytest.approx(np.tile(color.linear(STEEL), (4, 1)))
    assert represented(BARE, radius=1, material="gold").source.by == "material"


def test_colours_become_linear() -> None:
    def linear(srgb) -> list[list[float]]:
        return color.linear(np.asarray(srgb, np.uint8)).tolist()

    def of(name: str) -> list[list[float]]:
        found = represented(ALL, color=name).spheres.color
        assert found is not None
        return found.tolist()

    assert of("file") == linear(ALL.colors)
    assert of("element") == linear(elements.COLORS[[1, 6, 8, 0]])
    assert of("type") == linear(palette.OKABE_ITO[[1, 2, 1, 7]])
    assert represented(ALL, color="material").spheres.color is None
    viridis = palette.colormap("viridis")
    assert of("v") == linear([palette.UNKNOWN, viridis[0], viridis[-1], viridis[-1]])
    assert of("flat") == linear([viridis[128]] * 4)
    assert of("x") == linear(palette.of_values(AT[:, 0]))
    assert of("radius") == linear(palette.of_values([1, 2, 3, 4]))


def test_the_range_of_a_column() -> None:
    assert represented(ALL, color="v").meaning.clim == (2, 4)
    outside = represented(ALL, color="v", clim=(3, 3.5), cmap="plasma")
    plasma = color.linear(palette.colormap("plasma"))
    assert outside.meaning.clim == (3, 3.5)
    assert outside.spheres.color is not None
    assert (outside.spheres.color[1:] == plasma[[0, -1, -1]]).all()
    assert represented(ALL).meaning.clim is None


@pytest.mark.parametrize("name", ["file", "element", "type", "speed"])
def test_what_there_is_not(name: str) -> None:
    with pytest.raises(RequestError) as error:
        represented(Particles(AT, values={"v": [1, 2, 3, 4]}), radius=1, color=name)
    expected = "'material', 'v', 'x', 'y', 'z', 'index'"
    assert str(error.value) == f"color: expected one of {expected}, got {name!r}"


def test_a_column_named_as_what_all_can_have_is_not_meant() -> None:
    odd = Particles(AT, types=[0, 1, 2, 3], values={"type": [9, 9, 9, 9], "element": [1, 2, 3, 4]})
    assert represented(odd, radius=1, color="type").source.by == "type"
    assert represented(odd, radius=1, color="element").source.by == "column"


def test_opacities_are_said_or_the_files() -> None:
    def found(particles: Particles = BARE, **drawn: Any) -> Any:
        spheres = represented(particles, radius=1, **drawn).spheres
        return None if spheres.opacity is None else spheres.opacity.tolist()

    seen_through = BARE.replaced(opacities=[0.5, 1, 0, 0.25])
    assert found() is None
    assert found(opacity=1) is None
    assert found(opacity="1 + 0 * x") is None
    assert found(opacity=0.5) == [0.5] * 4
    assert found(opacity="1") is None  # as the command line gives numbers
    assert found(opacity="0") == [0] * 4
    with pytest.raises(RequestError, match="opacity: expected numbers from 0 to 1, got 2 of '2'"):
        found(opacity="2")
    assert found(opacity="(x > 3) / 2") == [0, 0, 0.5, 0.5]
    assert found(seen_through) == [0.5, 1, 0, 0.25]
    assert found(seen_through, opacity=1) is None
    assert found(seen_through, select="x > 0", opacity="opacity / 2") == [0.5, 0, 0.125]
    box = seen_through.replaced(cell=np.eye(3) * 20)
    assert found(box, hide="x > 3", replicate=(1, 1, 2)) == [0.5, 1] * 2
    with pytest.raises(RequestError, match="opacity: expected numbers from 0 to 1, got 3 of 'x'"):
        found(opacity="x")
    with pytest.raises(RequestError, match=r"opacity: .*'w'"):
        found(opacity="w")
    with pytest.raises(RequestError, match="opacity: expected numbers from 0 to 1, got text"):
        found(ALL, opacity="element")

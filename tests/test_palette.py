"""Colour maps, held against matplotlib's, and sRGB made linear."""

import numpy as np
import pytest

from clrt.errors import RequestError
from clrt.film import color
from clrt.particles import palette


def test_linear_follows_the_standard() -> None:
    """Its inverse, IEC 61966-2-1, gives back every byte; the ends are exact."""
    linear = color.linear(np.arange(256, dtype=np.uint8)).astype(np.float64)
    back = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    assert abs(255 * back - np.arange(256)).max() < 1e-4
    assert linear[0] == 0
    assert linear[255] == 1


def test_bytes_and_the_same_floats_are_equal_in_bits() -> None:
    given = np.random.default_rng(1).integers(0, 256, (1000, 3), np.uint8)
    assert (color.linear(given) == color.linear(given / 255)).all()
    assert color.linear(given).shape == (1000, 3)
    assert color.linear(given).dtype == np.float32


@pytest.mark.parametrize("name", palette.COLORMAPS)
def test_the_tables_are_matplotlibs(name: str) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    theirs = matplotlib.colormaps[name]
    assert abs(palette.colormap(name) - 255 * theirs(np.arange(256))[:, :3]).max() <= 0.5
    assert (palette.colormap(f"{name}_r") == palette.colormap(name)[::-1]).all()


@pytest.mark.parametrize("name", [*palette.COLORMAPS, "magma", "RdBu_r", "tab10"])
@pytest.mark.parametrize("clim", [None, (-0.5, 1.5), (3.0, 4.0)])
def test_values_are_matplotlibs(name: str, clim: tuple[float, float] | None) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    values = np.random.default_rng(1).normal(size=3000)
    values[:4] = -1e300, 1e300, np.inf, -np.inf
    finite = values[np.isfinite(values)]
    norm = matplotlib.colors.Normalize(*(clim or (finite.min(), finite.max())))
    theirs = 255 * matplotlib.colormaps[name](norm(values))[:, :3]
    assert abs(palette.of_values(values, name, clim) - theirs).max() <= 0.5


MAP = palette.colormap("viridis")
LOW, MIDDLE, HIGH, GRAY = MAP[0], MAP[128], MAP[255], palette.UNKNOWN


@pytest.mark.parametrize(
    ("values", "clim", "expected"),
    [
        ([np.nan, 0, 1], None, [GRAY, LOW, HIGH]),
        ([np.nan, np.nan], None, [GRAY, GRAY]),
        ([5, 5, 5], None, [MIDDLE] * 3),
        ([5, 5, np.nan, np.inf, -np.inf], None, [MIDDLE, MIDDLE, GRAY, HIGH, LOW]),
        ([4, 5, 6], (5, 5), [LOW, MIDDLE, HIGH]),
        ([-1, 0, 1, 2], (0, 1), [LOW, LOW, HIGH, HIGH]),
        ([np.inf, -np.inf], None, [HIGH, LOW]),
        ([-1.7e308, 0, 1.7e308], None, [LOW, MIDDLE, HIGH]),
        ([0, 5e-324], None, [LOW, HIGH]),
        ([], None, np.zeros((0, 3))),
        ([True, False], None, [HIGH, LOW]),
    ],
)
def test_hard_values(values: list[float], clim: tuple[float, float] | None, expected: list) -> None:
    with np.errstate(all="raise", under="ignore"):
        found = palette.of_values(values, clim=clim)
    assert found.dtype == np.uint8
    assert (found == np.array(expected)).all()


@pytest.mark.parametrize("clim", [(1, 0), (0, np.nan), (0, np.inf), (1,), "ab", 3, (None, 1)])
def test_no_range(clim: object) -> None:
    with pytest.raises(RequestError, match="clim: expected two finite numbers, the lower"):
        palette.of_values([1.0], clim=clim)  # type: ignore[arg-type]


def test_no_such_map(monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as without:
        without.setitem(__import__("sys").modules, "matplotlib", None)
        with pytest.raises(RequestError, match="'jett': pip install matplotlib for more"):
            palette.of_values([1.0], "jett")
        assert (palette.of_values([np.nan], "turbo") == GRAY).all()
    pytest.importorskip("matplotlib")
    with pytest.raises(RequestError, match=r"cmap: expected one of viridis.* or of matplotlib's"):
        palette.of_values([1.0], "jett")


def test_types_have_the_palette_over_and_over() -> None:
    found = palette.of_types(np.array([0, 1, 7, 8, -1], np.int32))
    assert (found == palette.OKABE_ITO[[0, 1, 7, 0, 7]]).all()
    assert len(np.unique(palette.OKABE_ITO, axis=0)) == 8

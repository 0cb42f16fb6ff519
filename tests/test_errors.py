"""Errors and warnings call a key as those do who gave it."""

import pytest

from clrt.errors import ParticleWarning, RequestError, called, warn


def test_a_key_is_called_as_who_gave_it_calls_it() -> None:
    with pytest.warns(ParticleWarning, match="^radius: nothing$"):
        warn("radius", "nothing")
    with called({"radius": "--radius", "scale": "--scale"}):
        with called({"radius": "radii"}), pytest.warns(ParticleWarning, match="^radii: nothing$"):
            warn("radius", "nothing")
        with pytest.warns(ParticleWarning, match="^--scale: nothing$"):
            warn("scale", "nothing")
    expected = pytest.raises(RequestError, match=r"^a\.xyz: --radius: expected")
    with expected, called({"radius": "--radius"}):
        raise RequestError("a.xyz: radius: expected one")
    with pytest.warns(ParticleWarning, match="^radius: nothing$"):
        warn("radius", "nothing")

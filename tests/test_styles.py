"""Styles, and that docs/styles.md has the same table."""

import re
from pathlib import Path

import numpy as np
import pytest

import clrt
from clrt.figure import styles

PAGE = (Path(__file__).parents[1] / "docs" / "styles.md").read_text()


def test_the_page_has_the_same_table() -> None:
    rows = re.findall(r"^\| `([\w-]+)` \| (.*) \|$", PAGE, re.M)
    assert [name for name, _ in rows] == list(styles.STYLES)
    for name, numbers in rows:
        style, material = styles.STYLES[name], styles.STYLES[name].material
        colors = [material.ambient, material.diffuse, material.specular]
        assert all(len(set(color)) == 1 for color in colors)
        told = [color[0] for color in colors] + [material.shininess, material.reflection]
        told += [style.outline, style.half_angle, style.reach]
        assert told == [float(number) for number in numbers.split(" | ")]
    assert f"({', '.join(f'{part:g}' for part in styles.KEY)})" in PAGE


@pytest.mark.parametrize("name", ["matte", "soft", "outline"])
def test_what_faces_the_key_light_has_its_own_colour(name: str) -> None:
    material = styles.STYLES[name].material
    assert np.add(material.ambient, material.diffuse).tolist() == [1, 1, 1]


def test_the_key_light_comes_from_the_upper_left() -> None:
    camera = clrt.Camera((5, 4, 3), (0, 0, 1), (0, 0, 1))
    key, fill = styles.lights(styles.STYLES["soft"], camera, 8.0)
    assert isinstance(key, clrt.DirectionalLight)
    right, up, back = (np.dot(axis, key.direction) for axis in camera.basis())
    assert (right, up, back) == pytest.approx(styles.KEY)
    assert right > 0 > up  # the way that it travels
    assert back < 0
    assert key.half_angle == 10
    assert fill == clrt.AmbientLight(occlusion=True, distance=2.0)
    assert styles.lights(styles.STYLES["matte"], camera, 8.0)[1] == clrt.AmbientLight()

"""What near spheres hide of the sky, in closed form."""

import numpy as np
import pyopencl as cl
import pytest
from conftest import renderer_for

import clrt
from clrt.errors import SceneError
from clrt.renderer.pack.arguments import NEAR

OTHERS = 0.35
SIZE = 48, 27


def test_as_written_out(device: cl.Device) -> None:
    """Balls in a tree above a floor that is in the list beside it; all parts of all of them."""
    random = np.random.default_rng(4)
    center = np.append(random.uniform((-2, -1, 0.2), (2, 1, 1.0), (70, 3)), [(0, 0, -500)], axis=0)
    radius = np.append(random.uniform(0.15, 0.25, 70), 500.0)
    white = clrt.Material((1, 1, 1), (0, 0, 0), (0, 0, 0))
    camera = clrt.Camera((0, 0, 9), (0, 0, 0), up=(0, 1, 0), projection="orthographic", height=2.4)
    scene = clrt.Scene(camera, (clrt.AmbientLight(occlusion="near"),), {"white": white},
                       clrt.Spheres(center, radius, "white"))  # fmt: skip
    image, seen = renderer_for(device, 16).render(scene, *SIZE, passes=("depth", "normal", "id"))
    across = 1.2 * SIZE[0] / SIZE[1]
    x, y = np.meshgrid(np.linspace(-across, across, SIZE[0]), np.linspace(1.2, -1.2, SIZE[1]))
    point = np.stack([x, y, 9 - seen["depth"].astype(np.float64)], axis=2)
    way = center - point[..., np.newaxis, :]
    distance = np.linalg.norm(way, axis=3)
    cosine = np.einsum("yxk,yxik->yxi", seen["normal"], way) / distance
    sine = np.minimum(radius / distance, 1)
    cut = np.maximum(cosine + sine, 0) ** 2 / (4 * sine)
    part = np.where(cosine > sine, cosine, cut) * sine**2
    off = np.maximum(distance - radius, 0) / (NEAR * np.median(radius))
    part *= np.maximum(1 - off**4, 0)
    np.put_along_axis(part, seen["id"][..., np.newaxis], 0, axis=2)
    part = np.sort(part, axis=2)
    left = np.prod(1 - part[..., -4:], axis=2) * np.prod(1 - OTHERS * part[..., :-4], axis=2)
    assert 0.05 < left.min() < 0.5 < left.max()
    assert abs(image - left[..., np.newaxis]).max() < 1 / 1020


def test_what_it_can_be() -> None:
    with pytest.raises(SceneError, match="occlusion: expected true or false, got 'far'"):
        clrt.AmbientLight(occlusion="far")  # type: ignore[arg-type]

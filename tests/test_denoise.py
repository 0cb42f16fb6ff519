"""The filter of noise: it keeps what is no noise, and is what clrt.truth.denoise writes out."""

import re
from typing import Any

import numpy as np
import pyopencl as cl
from conftest import renderer_for
from msgspec.structs import replace
from numpy.typing import NDArray

import clrt
from clrt.opencl import program
from clrt.opencl.denoise import FAR, STRIP
from clrt.renderer.pack.structs import GUIDES
from clrt.truth.denoise import denoised

ROWS, COLUMNS, STEP = 37, 45, 0.01


def clear(device: cl.Device, guides: NDArray[Any], samples: int = 4) -> NDArray[np.float32]:
    """By the kernel."""
    renderer, scene = renderer_for(device, 16), clrt.load_scene("four-spheres")
    dim = clrt.AmbientLight(occlusion=True)
    scene = replace(scene, shadow_bias=0.0, lights=(*scene.lights, dim), samples=samples)
    program = renderer._programs_of(scene, ["guides"])["guides"][0]
    arguments = renderer._dispatcher.arguments(scene, COLUMNS, ROWS, program, 0.0)
    arguments["camera"]["step"] = STEP
    return renderer._dispatcher.denoised(program, scene, arguments, guides)[0]


def noisy() -> NDArray[Any]:
    """A ball and what is behind it: of two albedos, and partly of nothing."""
    random = np.random.default_rng(1)
    guides = np.zeros((ROWS, COLUMNS), GUIDES)
    y, x = np.mgrid[-1 : 1 : ROWS * 1j, -1 : 1 : COLUMNS * 1j]
    high = np.sqrt(np.maximum(0.8 - x**2 - y**2, 0))
    guides["normal"] = np.stack([x, y, high + 0.01], axis=2) / np.sqrt(0.8)
    guides["albedo"] = np.where(x < 0.2, 0.8, 0.3)[..., np.newaxis] * (1, 0.5, 0.7)
    guides["depth"] = 5 - high
    alpha = np.clip(9 - 9 * y, 0, 1)
    light = (0.5 + high) * (1 + 0.2 * random.standard_normal((ROWS, COLUMNS)))
    guides["color"] = np.concatenate([light[..., np.newaxis] * guides["albedo"],
                                      np.ones((ROWS, COLUMNS, 1))], axis=2)  # fmt: skip
    for name in ("color", "albedo", "normal", "depth"):
        part = guides[name]
        part *= alpha.reshape(alpha.shape + (1,) * (part.ndim - 2))
    bright = guides["color"][..., :3].sum(axis=2)
    guides["square"] = bright**2 * random.uniform(1, 1.1, bright.shape)
    return guides


def test_as_written_out(device: cl.Device) -> None:
    guides = noisy()
    guides["color"][9, 9, 1] = np.nan
    guides["color"][20, 30, 0] = np.inf
    for samples in (1, 4):
        made, truth = clear(device, guides, samples), denoised(guides, samples, STEP, False)
        good = np.isfinite(made)
        assert np.argwhere(~good).tolist() == [[9, 9, 1], [20, 30, 0]]
        assert abs(made[good] - truth[good]).max() < 1e-5
        assert np.array_equal(made[..., 3], guides["color"][..., 3])
    rough = guides["color"][12:24, 12:22, 0]
    assert made[12:24, 12:22, 0].std() < 0.7 * rough.std()


def test_what_is_everywhere_alike_stays_to_the_bit(device: cl.Device) -> None:
    guides = noisy()
    guides["albedo"], guides["color"] = (0.3, 0.2, 0.7), (0.1, 0.7, 0.3, 1.0)
    assert np.array_equal(clear(device, guides), guides["color"])


def test_nothing_comes_over_an_edge(device: cl.Device) -> None:
    """Between normals, depths, albedos, and before nothing. Neighbours on either side of a pixel
    share a division, which rounds."""
    for name, there in (("normal", (0, 0, 1)), ("depth", 40), ("albedo", 0.9), ("color", 0)):
        guides = noisy()
        guides["normal"], guides["depth"], guides["albedo"] = (0, 1, 0), 5, 0.3
        guides[name][:, 20:] = there
        before = clear(device, guides)[:, :20]
        guides["color"][:, 20:, :3] *= 7
        assert abs(clear(device, guides)[:, :20] - before).max() < 2.0**-22


def test_the_kernel_and_the_host_have_the_same_numbers() -> None:
    found = dict(re.findall(r"#define (FAR|STRIP) +(\d+)", program.kernel_source()))
    assert found == {"FAR": str(FAR), "STRIP": str(STRIP)}

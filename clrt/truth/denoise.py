"""Denoise: the filter of noise that kernels/denoise.cl has, in float64."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

AROUND = [
    (down, right) for down in range(-2, 3) for right in range(-2, 3) if 0 < down**2 + right**2 <= 5
]
APART, TURNED, TINTED, COVERED, DEEPER = 3.5, 0.85, 0.2, 0.5, 16.0
"""Where a neighbour counts for nothing, see denoise.cl, as the rest."""
NOISY, STIFF = 1.0, 0.0002
SOME, LITTLE, LEAST_ALPHA, UNKNOWN = 0.02, 1e-6, 1e-4, 1e15


def denoised(guides: Array, samples: int, step: float, orthographic: bool) -> Array:
    """A film (rows, columns, 4) float64 with less noise: colours, premultiplied by alpha.

    Args:
        guides: (rows, columns) of structs.GUIDES.
        samples: of a pixel.
        step: half a pixel's side on the screen, as the kernel's camera has it.
        orthographic: whether the camera is.
    """
    kept = guides["color"].astype(np.float64)
    color, alpha = kept[..., :3], kept[..., 3]
    with np.errstate(invalid="ignore", over="ignore"):
        bright = color.sum(axis=2)
        there = (alpha > LEAST_ALPHA) & (abs(bright) < np.inf)
        tint = np.where(there[..., np.newaxis], guides["albedo"] + SOME * kept[..., 3:], 1)
        light = np.where(there[..., np.newaxis], color, 0) / tint
        spread = (guides["square"] - bright**2) * (3 / tint.sum(axis=2)) ** 2
    noise = np.maximum(np.nan_to_num(spread), 0) / max(samples - 1, 1)
    if samples == 1:
        noise = np.full(alpha.shape, UNKNOWN)
    depth = guides["depth"] / np.where(there, alpha, 1)
    room = 2 * step * DEEPER * (np.ones_like(depth) if orthographic else depth)
    normal = guides["normal"].astype(np.float64)
    own = light, tint, normal, np.where(there, alpha, 0)[..., np.newaxis]
    felt = np.concatenate([*own, depth[..., np.newaxis], noise[..., np.newaxis]], axis=2)
    padded = np.pad(felt, ((2, 2), (2, 2), (0, 0)))
    total, moved = np.ones(alpha.shape), np.zeros((*alpha.shape, 6))
    squares = np.zeros((*alpha.shape, 3, 6))
    rows, columns = alpha.shape
    for down, right in AROUND:
        other = padded[2 + down : 2 + down + rows, 2 + right : 2 + right + columns]
        off = other - felt
        unlike = (down**2 + right**2) / APART**2 + (off[..., 9] / COVERED) ** 2
        unlike += (off[..., 6:9] ** 2).sum(axis=2) / TURNED**2
        unlike += (off[..., 3:6] ** 2).sum(axis=2) / TINTED**2
        with np.errstate(divide="ignore", invalid="ignore"):
            unlike += (off[..., 10] / room) ** 2
        explained = NOISY * (felt[..., 11] + other[..., 11]) + LITTLE
        weight = explained / (explained + off[..., :3].sum(axis=2) ** 2) * (1 - unlike)
        weight = np.where((unlike < 1) & (other[..., 9] > 0), weight, 0)
        both = np.concatenate([off[..., 6:9], off[..., :3]], axis=2)
        total += weight
        moved += weight[..., np.newaxis] * both
        squares += np.einsum("yx,yxi,yxj->yxij", weight, off[..., 6:9], both)
    mean = moved / total[..., np.newaxis]
    among = squares / total[..., np.newaxis, np.newaxis]
    among -= mean[..., :3, np.newaxis] * mean[..., np.newaxis, :]
    slope = np.linalg.solve(among[..., :3] + STIFF * np.identity(3), among[..., 3:])
    more = mean[..., 3:] - np.einsum("yxi,yxij->yxj", mean[..., :3], slope)
    kept[..., :3] += np.where(there[..., np.newaxis], more * tint, 0)
    return kept

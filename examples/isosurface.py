"""A surface of equal density around atoms, with the atoms inside, rendered to isosurface.png.

The surface is found by scikit-image's marching cubes: pip install scikit-image.
"""

import sys

import numpy as np

import clrt

try:
    from skimage.measure import marching_cubes
except ImportError:
    print("expected scikit-image: pip install scikit-image")
    sys.exit()

# Benzene: carbon and hydrogen, in ångströms.
angle = np.arange(6) * np.pi / 3
ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
atoms = clrt.read(
    {
        "positions": np.concatenate([1.39 * ring, 2.48 * ring]),
        "elements": np.repeat(["C", "H"], 6),
    }
)
# A density: a Gaussian for each atom, on a grid of 0.1 ångströms.
spacing, low = 0.1, np.array([-4.6, -4.6, -2.6])
counts = np.ceil(-2 * low / spacing).astype(int) + 1
x, y, z = (low[i] + spacing * np.arange(counts[i]) for i in range(3))
density = np.zeros(counts)
for (a, b, c), width in zip(atoms.positions, np.repeat([0.85, 0.6], 6), strict=True):
    along = (np.exp(-(((p - at) / width) ** 2)) for p, at in ((x, a), (y, b), (z, c)))
    density += np.einsum("i,j,k->ijk", *along)

vertices, faces, normals, _ = marching_cubes(density, 0.12, spacing=(spacing,) * 3)
picture = clrt.plot(
    atoms,
    style="ball-and-stick",
    mesh=(vertices + low, faces, normals),
    mesh_color="cornflowerblue",
    mesh_opacity=0.35,
    size=(1280, 720),
)
picture.save("isosurface.png")

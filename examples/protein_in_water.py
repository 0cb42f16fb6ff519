"""A protein in water that can be seen through: water is put where the file has no atom.

python examples/protein_in_water.py  # makes protein-in-water.png
"""

from pathlib import Path

import numpy as np

import clrt

APART, CELLS = 3.1, 16  # the places of water, in angstrom, and how many on each side
FILE = Path(__file__).parents[1] / "scenes" / "data" / "1tii.pdb.gz"

atoms = clrt.read(FILE).positions
middle = atoms.mean(axis=0)
cells = np.stack(np.meshgrid(*[np.arange(-CELLS, CELLS + 1)] * 3), axis=-1).reshape(-1, 3)
taken = {tuple(cell) for cell in np.rint((atoms - middle) / APART).astype(int).tolist()}
cells = np.array([cell for cell in cells.tolist() if tuple(cell) not in taken])
water = middle + APART * cells + np.random.default_rng(1).uniform(-0.8, 0.8, cells.shape)

picture = clrt.plot(
    np.concatenate([atoms, water]),
    radii=np.repeat([1.7, 1.4], [len(atoms), len(water)]),
    colors=np.repeat(["tomato", "lightskyblue"], [len(atoms), len(water)]),
    opacity=np.repeat([1.0, 0.03], [len(atoms), len(water)]),
    style="matte",
    zoom=1.4,
    size=(1200, 675),
)
picture.save("protein-in-water.png")

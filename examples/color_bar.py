"""Beads coloured by a value, in a tilted cell, with a colour bar: rendered to color-bar.png."""

import numpy as np

import clrt
from clrt import color, palette

edges = np.array([(2.0, 0, 0), (0.5, 2, 0), (-0.3, 0.2, 2)])
part = np.stack(np.meshgrid(*3 * [np.arange(30) / 30 + 1 / 60], indexing="ij"), -1).reshape(-1, 3)
a, b, c = 2 * np.pi * part.T
height = np.sin(a) * np.cos(b) + np.sin(b) * np.cos(c) + np.sin(c) * np.cos(a)
part, height = part[height > 0.45], height[height > 0.45]  # one side of a gyroid

limits = palette.limits(height)
film = clrt.Film(
    background=(1, 1, 1),
    transfer="srgb",
    colorbar="height over the surface",
    colorbar_cmap="plasma",
    colorbar_clim=limits,
    cells=[clrt.Cell(edges.tolist())],
)
middle = edges.sum(axis=0) / 2
scene = clrt.Scene(
    camera=clrt.Camera(middle + np.array((4, 2.2, 6)), middle, fov=38),
    lights=(
        clrt.AmbientLight((0.35, 0.35, 0.35)),
        clrt.DirectionalLight((-1, -2, -1.2), ambient=(0, 0, 0), diffuse=(0.65, 0.65, 0.65)),
    ),
    materials={"bead": clrt.Material(ambient=(1, 1, 1), diffuse=(1, 1, 1))},
    spheres=clrt.Spheres(
        part @ edges, 0.036, "bead", color.linear(palette.of_values(height, "plasma", limits))
    ),
    film=film,
    samples=16,
)
picture = clrt.render(scene, 960, 540, dtype="uint8")
clrt.save("color-bar.png", picture, transfer="srgb")

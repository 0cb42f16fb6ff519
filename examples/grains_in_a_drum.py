"""A cell of grains with its walls: a drum of triangles that can be seen through, rendered to
drum.png. Walls of a file are drawn by `clrt render grains.dump --mesh walls.stl`."""

import numpy as np

import clrt

rng = np.random.default_rng(7)
around, radius, height = 96, 5.0, 4.0

# Grains at the places of a close packing that lie in the drum, below a slope, a little moved.
i, j, k = np.stack(np.meshgrid(*3 * [np.arange(-12, 13)], indexing="ij")).reshape(3, -1)
places = 0.62 * np.stack([i + (j + k) % 2 / 2, 0.87 * j, 0.82 * k + 0.5], axis=1)
inside = np.hypot(places[:, 0], places[:, 1]) < radius - 0.35
inside &= (places[:, 2] > 0.3) & (places[:, 2] < 1.8 + 0.25 * places[:, 0])
grains = places[inside] + rng.normal(0, 0.02, (np.count_nonzero(inside), 3))
speed = 0.2 + np.exp(2 * (grains[:, 2] - 1.8 - 0.25 * grains[:, 0]))

# The wall is a band of two triangles a step, the floor a fan about its middle.
angle = np.linspace(0, 2 * np.pi, around, endpoint=False)
rim = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
low, high = (np.column_stack([rim, np.full(around, z)]) for z in (0.0, height))
vertices = np.concatenate([low, high, [[0.0, 0, 0]]])
here = np.arange(around)
after = (here + 1) % around
wall = np.concatenate(
    [
        np.stack([here, after, here + around], axis=1),
        np.stack([after, after + around, here + around], axis=1),
    ]
)
floor = np.stack([np.full(around, 2 * around), after, here], axis=1)

picture = clrt.plot(
    grains,
    radii=rng.uniform(0.22, 0.3, len(grains)),
    values=speed,
    colorbar="speed (m/s)",
    mesh=(vertices, np.concatenate([wall, floor])),
    mesh_color="lightgray",
    mesh_opacity=0.3,
    view=(0.3, -1.0, 0.7),
    size=(1280, 720),
)
picture.save("drum.png")

"""Some 700,000 beads on a gyroid, cut to a ball: made by NumPy, rendered to gyroid.png."""

import numpy as np

import clrt

beads, turns = 230, 2.5  # beads across, periods of the surface
x, y, z = p = np.stack(np.meshgrid(*3 * [np.linspace(-1, 1, beads)], indexing="ij")).reshape(3, -1)
a, b, c = turns * np.pi * p
height = np.sin(a) * np.cos(b) + np.sin(b) * np.cos(c) + np.sin(c) * np.cos(a)
center = p[:, (abs(height) < 0.17) & (x * x + y * y + z * z < 1)].T
# Its colour is where a bead stands: gold below, blue above, pale within.
up = (center[:, 1:2] + 1) / 2
color = (1 - up) * (1.0, 0.55, 0.12) + up * (0.1, 0.4, 1.0)
color += 0.7 * (1 - np.linalg.norm(center, axis=1)[:, np.newaxis]) * (1 - color)

ground = clrt.Spheres([[0, -1001, 0]], 1000, "ground", [[0.8, 0.8, 0.8]])
scene = clrt.Scene(
    camera=clrt.Camera(position=(2.2, 1.25, 2.5), look_at=(0, -0.05, 0), fov=52),
    lights=(
        clrt.Light(position=(4, 6, 3)),
        clrt.Light(position=(-6, 3, 4), diffuse=(0.25, 0.25, 0.35), specular=(0.1, 0.1, 0.1)),
        clrt.Light(position=(2.4, 1.5, 2.6), diffuse=(0.25, 0.25, 0.25), specular=(0, 0, 0)),
    ),
    materials={
        "bead": clrt.Material((0.06, 0.06, 0.06), (0.75, 0.75, 0.75), (0.3, 0.3, 0.3), 60),
        "ground": clrt.Material((0.04, 0.04, 0.04), (0.5, 0.5, 0.5), (0, 0, 0), 1, reflection=0.25),
    },
    spheres=clrt.Spheres(
        np.concatenate([center, ground.center]),
        np.append(np.full(len(center), 1.15 / beads), 1000),
        ["bead"] * len(center) + ["ground"],
        np.concatenate([color, ground.color]),
    ),
)
clrt.save("gyroid.png", clrt.render(scene, 1280, 720, dtype="uint8"))
print(f"gyroid.png: {len(scene.spheres):,} spheres")

"""Builds a scene in Python, a spiral of beads on a plane, and renders it to spiral.png."""

import math

import clrt

matte = clrt.Material(ambient=(0.05, 0.05, 0.06), diffuse=(0.5, 0.5, 0.6), specular=(0, 0, 0),
                      shininess=1)  # fmt: skip
gold = clrt.Material(ambient=(0.1, 0.07, 0.02), diffuse=(0.7, 0.5, 0.2), specular=(1, 1, 1),
                     shininess=120, reflection=0.3)  # fmt: skip
spheres = [clrt.Sphere(center=(0, -1000.0, 0), radius=1000, material="matte")]
for k in range(90):
    turn, height = 0.35 * k, 0.012 * k
    radius = 0.14 - 0.001 * k
    center = (0.9 * math.cos(turn), radius + height, 0.9 * math.sin(turn))
    spheres.append(clrt.Sphere(center, radius, "gold"))
scene = clrt.Scene(
    camera=clrt.Camera(position=(0, 1.9, 2.6), look_at=(0, 0.5, 0), fov=55),
    lights=(clrt.Light(position=(4, 6, 3)), clrt.Light((-5, 3, 1), diffuse=(0.2, 0.2, 0.4))),
    materials={"matte": matte, "gold": gold},
    spheres=tuple(spheres),
)
clrt.save("spiral.png", clrt.render(scene, 1280, 720, dtype="uint8"))

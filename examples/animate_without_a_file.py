"""Moves the camera by hand, without an [animation], and writes one picture a frame."""

import math

from msgspec.structs import replace

import clrt

scene = clrt.load_scene("four-spheres")
with clrt.Renderer() as renderer:  # compiles once
    for frame in range(8):
        angle = 0.1 * (frame - 3.5)
        position = (2 * math.sin(angle), 0.2, 2 * math.cos(angle) - 1)
        camera = clrt.Camera(position, look_at=(0, -0.2, -0.6))
        film = renderer.render(replace(scene, camera=camera), 640, 360, dtype="uint8")
        clrt.save(f"swing-{frame}.png", film)

"""Surface: the light that a hit point sends to the camera (section 3, 11.8)."""

import numpy as np

from clrt.scene.light import AmbientLight, Shining
from clrt.scene.mesh import SHADINGS
from clrt.truth import camera, faces, lights
from clrt.truth.hits import Met
from clrt.truth.rays import Array, dot, unit
from clrt.truth.world import World


def ambient_term(world: World, light: Shining | AmbientLight, met: Met) -> Array:
    """The light that a hit point sends wherever the light is (section 3)."""
    term: Array = world.ambient[:, world.material[met.hit]] * world.column(light.ambient)
    return term if met.color is None else term * met.color


def term(
    world: World,
    light: Shining,
    point: Array,
    to_light: Array,
    distance: Array,
    clear: Array,
    met: Met,
) -> Array:
    """The light of a lamp that a hit point sends to the camera, if it is reached (3, 11.8)."""
    material, normal = world.material[met.hit], met.shaded
    to_camera = camera.to_camera(world, point)
    half_way = unit(to_light + to_camera)
    mirrored = 2 * dot(normal, to_light) * normal - to_light
    shininess = world.shininess[material]
    highlight = np.where(
        world.phong[material],
        np.maximum(dot(mirrored, to_camera), 0) ** shininess,
        np.maximum(dot(normal, half_way), 0) ** (shininess / 4),
    )
    cosine = dot(to_light, normal)
    cosine[met.of_faces] = np.maximum(cosine[met.of_faces], 0)  # a normal between corners' may turn
    diffuse = world.diffuse[:, material] * world.column(light.diffuse) * cosine
    if met.color is not None:
        diffuse = diffuse * met.color
    specular = world.specular[:, material] * world.column(light.specular) * highlight
    direct = diffuse + specular
    at_corners = world.shading[met.face] == SHADINGS.index("gouraud")
    some = np.flatnonzero(met.of_faces)[at_corners]
    direct[:, some] = faces.gouraud(
        world, light, met.face[at_corners], met.side[at_corners], met.at[:, at_corners]
    )
    ambient = ambient_term(world, light, met)
    found: Array = ambient + lights.left(light, distance) * clear * direct
    return found

"""Surface: the light that a hit point sends to the camera (section 3, 11.8)."""

import numpy as np

from clrt.scene.light import AmbientLight, Shining
from clrt.truth import camera, lights
from clrt.truth.rays import Array, dot, unit
from clrt.truth.world import World


def ambient_term(world: World, light: Shining | AmbientLight, hit: Array) -> Array:
    """The light that a hit point sends wherever the light is (section 3)."""
    term: Array = world.ambient[:, world.material[hit]] * world.column(light.ambient)
    return term if world.color is None else term * world.color[:, hit]


def term(
    world: World,
    light: Shining,
    point: Array,
    to_light: Array,
    distance: Array,
    clear: Array,
    normal: Array,
    hit: Array,
) -> Array:
    """The light of a lamp that a hit point sends to the camera, if it is reached (3, 11.8)."""
    material = world.material[hit]
    to_camera = camera.to_camera(world, point)
    half_way = unit(to_light + to_camera)
    mirrored = 2 * dot(normal, to_light) * normal - to_light
    shininess = world.shininess[material]
    highlight = np.where(
        world.phong[material],
        np.maximum(dot(mirrored, to_camera), 0) ** shininess,
        np.maximum(dot(normal, half_way), 0) ** (shininess / 4),
    )
    diffuse = world.diffuse[:, material] * world.column(light.diffuse) * dot(to_light, normal)
    if world.color is not None:
        diffuse = diffuse * world.color[:, hit]
    specular = world.specular[:, material] * world.column(light.specular) * highlight
    ambient = ambient_term(world, light, hit)
    found: Array = ambient + lights.left(light, distance) * clear * (diffuse + specular)
    return found

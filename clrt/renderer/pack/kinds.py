"""Kinds: what stands in the scene's trees, one for each kind."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from clrt.opencl import tree
from clrt.renderer.pack import capsules, meshes, spheres
from clrt.renderer.pack.features import Features
from clrt.renderer.pack.structs import Array, Real
from clrt.renderer.pack.world import World


@dataclass(frozen=True, eq=False)
class Kind:
    """What stands in a tree."""

    number: int
    """As tree.cl counts them."""
    leaf: Callable[[Real], np.dtype[Any]]
    names: dict[str, str]
    """The kernel's arguments of what tree.Tree.fit() finds."""
    count: Callable[[World], int]
    first: Callable[[World], int]
    """The id of the first of them."""
    keys: Callable[[World], Array]
    """What its tree is ordered by."""


SPHERES = Kind(
    0,
    tree.leaf_dtype,
    {"things": "beads", "nodes": "nodes", "leaves": "leaves", "shape": "shape"},
    lambda world: len(world.spheres),
    lambda world: 0,
    lambda world: spheres.tree_keys(world.spheres),
)
CAPSULES = Kind(
    1,
    tree.capsule_leaf_dtype,
    {
        "things": "capsules",
        "nodes": "capsule_nodes",
        "leaves": "capsule_leaves",
        "shape": "capsule_shape",
    },
    lambda world: len(world.capsules),
    lambda world: len(world.spheres),
    lambda world: capsules.tree_keys(world.capsules),
)
FACES = Kind(
    2,
    tree.face_leaf_dtype,
    {
        "things": "faces",
        "nodes": "face_nodes",
        "leaves": "face_leaves",
        "shape": "face_shape",
    },
    lambda world: meshes.count(world.meshes),
    lambda world: len(world.spheres) + len(world.capsules),
    lambda world: meshes.tree_keys(world.meshes),
)

KINDS = (SPHERES, CAPSULES, FACES)


def kinds_of(features: Features) -> list[Kind]:
    """Those that have a tree."""
    used = {SPHERES: features.tree, CAPSULES: features.capsules, FACES: features.faces}
    return [kind for kind in KINDS if used[kind]]

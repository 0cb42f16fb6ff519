"""Features: what a program is compiled for. Nothing else decides what a scene needs."""

from collections.abc import Sequence
from typing import Any, Literal, TypeAlias

import msgspec
import numpy as np
from msgspec.structs import replace

from clrt.errors import RequestError
from clrt.film import develop
from clrt.renderer import glass
from clrt.renderer.pack.structs import FILMS, FilmKind, Precision
from clrt.renderer.pack.world import World
from clrt.scene import lens
from clrt.scene.camera import Camera
from clrt.scene.light import DirectionalLight, Shining, SpotLight
from clrt.scene.scene import Scene, beyond_paper

LANES = (1, 2, 4, 8, 16)


class Features(msgspec.Struct, frozen=True):
    """What a program is compiled for: what the picture is to be, and what its scene uses.

    The kernels know each field by its name in capitals, a precision and a film by their values.
    """

    lanes: int
    precision: Precision
    film: FilmKind
    reflection: bool = False
    """A path can go on after its first hit."""
    orthographic: bool = False
    long_lens: bool = False
    """What fills the picture may be far away against its size."""
    light_inside: bool = False
    """A light is inside a sphere."""
    tree: bool = False
    """There is a tree over the spheres: they are many, or there are others beside them."""
    capsules: bool = False
    """There are capsules beside the spheres, in a tree of their own."""
    faces: bool = False
    """There are triangles of meshes, in a tree of their own."""
    smooth: bool = False
    """A mesh is shaded with normals between those of its corners."""
    gouraud: bool = False
    """A mesh is lit at its corners."""
    corner_colors: bool = False
    """A mesh has colours at its corners."""
    sphere_colors: bool = False
    """Spheres, capsules or faces have colours of their own."""
    ambient: bool = False
    """There is ambient light."""
    attenuation: bool = False
    """A light gets weaker with distance."""
    spot: bool = False
    """A light shines into a cone."""
    phong: bool = False
    """A material's highlight is Phong's."""
    nest: int = 0
    """How many transparent spheres a ray can be inside of at once; 0: there are none."""
    split: bool = False
    """A surface mirrors and transmits."""
    opacity: bool = False
    """Surfaces can be seen through."""
    background: bool = False
    """Rays that leave the scene after a mirror see something there."""
    round: bool = False
    """A light is a ball or a disc."""
    near: bool = False
    """What is near hides ambient light, in closed form."""
    occlusion: bool = False
    """What is near hides ambient light."""
    lens: bool = False
    """What is out of focus is blurred."""
    gloss: bool = False
    """A mirror is rough."""
    indirect: bool = False
    """Surfaces light each other."""
    hashed: bool = False
    """Pixels' paths are wanted beside their colours: edges get more samples."""
    refine: bool = False
    """Only pixels at edges are made, each of many samples, which are the lanes."""
    gather: bool = False
    """Every pixel gets several samples."""

    @property
    def is_random(self) -> bool:
        """Whether samples draw points at random: RANDOM of features.cl."""
        drawn = self.occlusion or self.lens or self.gloss or self.indirect
        return drawn or (self.round and (self.capsules or self.faces))

    @property
    def packet(self) -> tuple[int, int]:
        """Columns and rows of the pixels that are traced in lock step: ROW and ROWS of lanes.cl."""
        columns = min(self.lanes, 2 if self.lanes == 4 else 4) if self.tree else self.lanes
        return columns, self.lanes // columns

    @property
    def tiles(self) -> bool:
        """Whether camera rays go through the tree by tiles of pixels.

        They pay as soon as there is a tree (benchmarks/NOTES.md). Samples have packets, but the few
        that each pixel has where edges get more. So has a single lane, as on a GPU: a work-item has
        no room for the 24 KB of a tile there.
        """
        packets = self.refine or (self.gather and not self.hashed)
        return self.tree and self.lanes > 1 and not packets

    @property
    def item(self) -> tuple[int, int]:
        """Columns and rows of the pixels that a work-item renders."""
        return (TILE, TILE) if self.tiles else self.packet

    @property
    def options(self) -> list[str]:
        """The compiler's: every -D that the kernels know, with a number, 0 for what is not used."""
        known = {
            "DOUBLE": self.precision == "double",
            "LITERAL": self.precision == "literal",
            **{f"FILM_{film.upper()}": self.film == film for film in FILMS if film != "float"},
            **{name.upper(): getattr(self, name) for name in USES},
            "TILES": self.tiles,
        }
        return [f"-DLANES={self.lanes}", *(f"-D{name}={int(used)}" for name, used in known.items())]


USES = Features.__struct_fields__[3:]
"""What a scene may use or not."""


TREE_FROM = 48
"""From so many spheres on there is a tree (benchmarks/NOTES.md)."""
TILE = 32
"""SIDE of tile.cl: columns and rows of a tile."""
SMALL, SMALLS_BASE = 0.01, 4
"""Of what size spheres are so small that one sample misses what is between the pixels, see
lens.middle_size(), and how many each pixel then gets (benchmarks/NOTES.md)."""
Stage: TypeAlias = Literal["picture", "edges"]


ENOUGH = 16
"""Samples of a pixel from which on a filter of noise spoils more than it mends, in some pictures
(benchmarks/NOTES.md)."""


def exposures(
    scene: Scene, dtype: np.dtype[Any], alpha: bool, passes: Sequence[str] | None
) -> list[FilmKind]:
    """The films that kernels must make for a picture, its own first."""
    look = scene.film
    own: FilmKind = "float" if dtype == np.float32 else "bytes"
    if scene.film.denoise and scene.is_random and scene.samples < ENOUGH:
        own = "guides"
    elif alpha or develop.has_steps(look, dtype, alpha):
        own = "alpha"
    return [own, "passes"] if passes or develop.needs_passes(look) else [own]


def stages(scene: Scene, film: FilmKind) -> list[Stage]:
    """What a film is made in: where a pixel gets more samples only if it is at an edge, all pixels
    first and then these."""
    sampled = scene.samples > 1 and film not in ("passes", "paths")
    return ["picture", "edges"] if sampled and not scene.is_random else ["picture"]


def features_of(
    world: World, scene: Scene, lanes: int, film: FilmKind, stage: Stage = "picture"
) -> Features:
    """What the program of a scene must have.

    Raises:
        RequestError: the precision does not know something of it.
    """
    if world.precision == "literal" and (key := beyond_paper(scene)):
        raise RequestError(f"precision: literal knows no {key}, expected robust or double")
    seen = Features(
        lanes,
        world.precision,
        film,
        orthographic=scene.camera.orthographic,
        long_lens=starts_ahead(world, scene.camera),
        tree=has_tree(world),
        capsules=len(world.capsules) > 0,
        faces=len(world.meshes) > 0,
        smooth=any(mesh.shading == "phong" for mesh in world.meshes),
        nest=world.nest,
    )
    if film == "passes":  # the camera's rays end where they meet something, lit or not
        return seen
    adaptive = len(stages(scene, film)) > 1
    random = scene.is_random and film != "paths"
    used = world.materials.values()
    drawn = any(sky.occlusion is True for sky in world.skies)
    return replace(
        seen,
        reflection=_goes_on(world, scene),
        light_inside=len(world.light_inside) > 0,
        gouraud=any(mesh.shading == "gouraud" for mesh in world.meshes),
        corner_colors="vertex_colors" in world.of_faces,
        sphere_colors=world.colors is not None,
        ambient=len(world.shades) > len(world.shining) + len(world.skies),
        attenuation=any(map(_fades, world.shining)),
        spot=any(isinstance(light, SpotLight) for light in world.shining),
        phong=any(material.highlight == "phong" for material in used),
        split=scene.max_depth > 1 and world.nest > 0 and any(map(glass.splits, used)),
        opacity=world.is_translucent,
        background=_shows_background(world, scene),
        # What capsules hide of it is drawn at random, so a hash knows its middle only.
        round=any(light.is_round for light in world.shining)
        and (random or not (seen.capsules or seen.faces)),
        hashed=adaptive and stage == "picture",
        near=film != "paths" and len(world.skies) > 0 and not drawn,
        occlusion=random and drawn,
        lens=random and scene.camera.has_lens,
        gloss=random and scene.is_glossy,
        indirect=random and scene.is_indirect,
        refine=stage == "edges",
        gather=random or (adaptive and stage == "picture" and base_samples(scene) > 1),
    )


def has_tree(world: World) -> bool:
    """Whether there are trees: over the spheres, and over whatever else there is."""
    many = len(world.spheres) >= TREE_FROM or len(world.capsules) > 0 or len(world.meshes) > 0
    return world.precision != "literal" and many


def starts_ahead(world: World, camera: Camera) -> bool:
    """Whether rays start ahead of the camera. From inside glass its far side is seen, however near
    it is."""
    known = world.precision != "literal"
    return known and lens.is_long(camera) and not len(world.media(camera))


def base_samples(scene: Scene) -> int:
    """How many samples each pixel gets, at an edge or not."""
    small = lens.middle_size(scene.camera, scene.spheres, scene.capsules) < SMALL
    return min(SMALLS_BASE if small else 1, scene.samples)


def missed(scene: Scene) -> float:
    """Balls are looked for whose rectangle's shorter half is less than this, in pixels.

    A ball of more than 0.71 pixels that reaches into a pixel has the middle of that or of a
    neighbour inside, one of more than 0.40 one of the points of samples.CENTRED. The rectangle of
    what looks long and slanted is up to 1.26 times as wide as that out to 48 degrees from the view.
    """
    return 0.51 if base_samples(scene) == SMALLS_BASE else 0.9


def _goes_on(world: World, scene: Scene) -> bool:
    """Whether a path can go on after its first hit."""
    used = world.materials.values()
    goes_on = scene.indirect or any(m.reflection > 0 or m.transmission > 0 for m in used)
    return scene.max_depth > 1 and goes_on


def _shows_background(world: World, scene: Scene) -> bool:
    """Elsewhere than where the camera sees it directly: clrt.film.develop adds it there."""
    return any(scene.film.background) and _goes_on(world, scene)


def _fades(light: Shining) -> bool:
    """Whether a light gets weaker with distance."""
    return not isinstance(light, DirectionalLight) and light.attenuation != (1, 0, 0)

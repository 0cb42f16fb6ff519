"""Dispatch: a device's queue and a scene's buffers, which together expose films."""

import warnings
from collections import defaultdict
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from clrt import memory
from clrt.errors import SceneWarning
from clrt.opencl import bands, edges
from clrt.opencl.denoise import denoise
from clrt.opencl.tree import Tree
from clrt.renderer import glass
from clrt.renderer.pack.arguments import KEPT, arguments_of, sampling
from clrt.renderer.pack.features import Features, missed
from clrt.renderer.pack.kinds import KINDS, Kind, kinds_of
from clrt.renderer.pack.structs import FILMS, Precision
from clrt.renderer.pack.world import World, pack_world, relit
from clrt.scene.scene import Scene

if TYPE_CHECKING:
    import pyopencl as cl

Array: TypeAlias = NDArray[Any]
Program: TypeAlias = "tuple[Features, dict[str, cl.Kernel]]"
Box: TypeAlias = tuple[int, int, int, int]


class Dispatcher:
    """Runs programs over films. It keeps the packed scene while only the camera changes, its tree,
    and the memory of films that are gone, for the next ones."""

    def __init__(self, queue: "cl.CommandQueue", precision: Precision) -> None:
        self._queue = queue
        self._precision = precision
        self._world: World | None = None
        # The kinds that have been exchanged for as many others since their tree was built.
        self._moved: set[int] = set()
        # Large arguments of the world on the device, by name.
        self._uploaded: dict[str, cl.Buffer] = {}
        self._films: defaultdict[str, memory.Films] = defaultdict(memory.Films)
        self.trees: dict[int, Tree] = {}
        """By the numbers of their kinds."""

    def close(self) -> None:
        """Waits for the device and lets go of buffers and memory."""
        self._queue.finish()
        self._world = None
        self._uploaded.clear()
        self.trees.clear()
        self._films.clear()

    def world(self, scene: Scene) -> World:
        """The packed scene without its camera, kept while only the camera changes. Where only
        lights do as well, all the rest is kept."""
        if self._world is not None and self._world.has_things_of(scene):
            if not self._world.is_of(scene):
                self._world = relit(self._world, scene)
        else:
            self._uploaded.clear()
            before, self._world = self._world, pack_world(scene, self._precision)
            for kind in KINDS:
                if before is None or kind.count(before) != kind.count(self._world):
                    self.trees.pop(kind.number, None)  # else its order may still do: see _fitted()
            self._moved = set(self.trees)
        return self._world

    def arguments(
        self, scene: Scene, width: int, height: int, program: Program, seconds: float
    ) -> dict[str, Any]:
        """Those of any program for this scene, see arguments_of().

        Args:
            program: one that can build the tree.
            seconds: how long kernels ran for the picture before.
        """
        features, kernels = program
        world = self.world(scene)
        arguments = arguments_of(world, scene, width, height)
        for kind in kinds_of(features):
            things = arguments[kind.names["things"]]
            fitted = self._fitted(kind, world, things, kernels, seconds)
            arguments |= {kind.names[name]: value for name, value in fitted.items()}
        # Those of the world are copied to the device once, not for each program and picture.
        own = {name: arguments[name] for name in KEPT if arguments[name] is not None}
        missing = {name: own[name] for name in own if name not in self._uploaded}
        self._uploaded |= bands.upload(self._queue.context, missing)
        return arguments | self._uploaded

    def _fitted(
        self,
        kind: Kind,
        world: World,
        things: Array,
        kernels: "dict[str, cl.Kernel]",
        seconds: float,
    ) -> dict[str, Any]:
        """The tree of a kind, fitted to where things are: see Tree.fit()."""
        tree, first = self.trees.get(kind.number), kind.first(world)
        if tree is not None:
            fitted = tree.fit(things, kernels, first)
            if kind.number not in self._moved:
                return fitted
            # As many elsewhere: their order is kept if the picture is there sooner so.
            self._moved.remove(kind.number)
            loose = tree.looseness()
            # The picture before may have been a small one, hence the bound.
            if loose <= 2 and seconds * (loose - 1) <= tree.build_seconds:
                return fitted
            del tree, fitted, self.trees[kind.number]  # lest it and the next are there at once
        # Nothing here keeps the keys while the tree is fitted: they are 160 MB of 10^7 spheres.
        tree = Tree(
            kind.keys(world) if kind.count(world) else np.zeros((1, 4), np.float32),
            self._queue,
            kernels,
            kind.number,
            kind.leaf,
        )
        self.trees[kind.number] = tree
        return tree.fit(things, kernels, first)

    def blank(self, shape: tuple[int, ...], dtype: np.dtype[Any], use: str = "picture") -> Array:
        """A film that nobody else has, of memory that was a film for the same use if there is any.

        Raises:
            OutputError: it does not fit into memory.
        """
        return self._films[use].film(shape, dtype)

    def exposed(
        self,
        programs: Sequence[Program],
        scene: Scene,
        arguments: dict[str, Any],
        size: tuple[int, int],
        box: Box,
        *,
        use: str = "picture",
        out: Array | None = None,
        progress: Callable[[int], object] | None = None,
    ) -> tuple[Array, float]:
        """A film as one program makes it, or a second one after it.

        Args:
            programs: that of each of stages().
            size: of the whole picture, columns and rows.
            box: columns and rows of the picture that are wanted, as of a region.
            use: see blank().
            out: the film to expose, of any strides.
            progress: called with the number of rows just finished by the last program.

        Returns:
            (rows, columns, channels): `out`, or a film of the caller's own. And how long the kernel
            ran, in seconds, by the device's own clock.
        """
        import pyopencl as cl

        features, kernels = programs[0]
        x0, y0, x1, y1 = box
        if features.hashed:  # by a pixel, whose paths are compared with those inside
            x0, y0, x1, y1 = (
                max(x0 - 1, 0),
                max(y0 - 1, 0),
                min(x1 + 1, size[0]),
                min(y1 + 1, size[1]),
            )
        # From the packet on that the first pixel is in: so each is one of the whole picture's.
        columns, rows = features.packet
        x0, y0 = x0 // columns * columns, y0 // rows * rows
        dtype, channels = FILMS[features.film]
        wanted = box[3] - box[1], box[2] - box[0], channels
        shape = y1 - y0, x1 - x0, channels
        if out is not None and out.flags.c_contiguous and shape == wanted:
            film = out
        else:
            film = self.blank(shape, dtype, use)
        if features.nest:
            arguments = arguments | {"lost": np.zeros(2, np.int32)}
        first, paths = arguments | sampling(features, scene), None
        if features.hashed:
            paths = cl.Buffer(self._queue.context, cl.mem_flags.READ_WRITE, 4 * shape[0] * shape[1])
            first |= {"paths": paths, "top": np.int32(y0)}
        seconds = bands.fill(
            film,
            (x0, y0),
            features.item,
            1 if features.tiles else bands.GROUP,
            self._queue,
            kernels["render"],
            first,
            progress if len(programs) == 1 else quiet(progress),
        )
        inside = box[0] - x0, box[1] - y0, box[2] - x0, box[3] - y0
        if len(programs) > 1 and paths is not None:
            features, kernels = programs[1]
            more = arguments | sampling(features, scene)
            seconds += edges.refine(
                film, (x0, y0), inside, paths, self._queue, kernels, more, missed(scene), progress
            )
        if features.nest:
            _say_lost(arguments["lost"])
        if film is out:
            return out, seconds
        cut = film[inside[1] : inside[3], inside[0] : inside[2]]
        if out is not None:
            out[...] = cut
            return out, seconds
        if shape == wanted:
            return film, seconds
        # The margin is dropped in place: the film may be as large as memory.
        flat, length = film.reshape(-1), channels * wanted[1]
        for i, row in enumerate(cut):
            flat[i * length : (i + 1) * length] = row.reshape(-1)
        return flat[: len(cut) * length].reshape(wanted), seconds

    def denoised(
        self,
        program: Program,
        scene: Scene,
        arguments: dict[str, Any],
        guides: Array,
        progress: Callable[[int], object] | None = None,
    ) -> tuple[Array, float]:
        """A film (rows, columns, 4) with less noise than one of the kind "guides" has, and how long
        the kernel ran, in seconds."""
        features, kernels = program
        out = self.blank((*guides.shape, 4), np.dtype(np.float32), "denoised")
        seconds = denoise(
            guides, out, features.lanes, self._queue, kernels["denoise"], scene.samples,
            arguments["camera"], progress,
        )  # fmt: skip
        return out, seconds


def quiet(progress: Callable[[int], object] | None) -> Callable[[int], object] | None:
    """It may raise, but is told of nothing."""
    return None if progress is None else lambda rows: progress(0)


def _say_lost(lost: Array) -> None:
    """Warns of rays that the kernel had no room for."""
    if lost[0]:
        warnings.warn(
            f"in {lost[0]} packets of rays some were inside of more than {glass.MOST} transparent "
            "spheres at once: of the largest they have not seen the far side",
            SceneWarning,
            stacklevel=2,
        )
    if lost[1]:
        warnings.warn(
            f"in {lost[1]} packets of rays some were mirrored and transmitted too often: "
            "take a smaller max_depth",
            SceneWarning,
            stacklevel=2,
        )

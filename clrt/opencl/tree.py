"""Trees: the order of many spheres, and the boxes around them, made by the device.

kernels/build.cl does the work, kernels/tree.cl says how a tree is laid out.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pyopencl as cl

Array = NDArray[Any]

WIDE = 16  # children of a node, spheres of a leaf
MAX_LEVELS = 6  # of full nodes between the root's children and the lowest: 2^36 spheres
# A beam is worth its while up to as many things in its cone, if they stood all around, and so many
# tests of boxes and things (benchmarks/NOTES.md).
BEAMS = ((24, 48), (24, 48), (96, 160))
"""Of each kind, as tree.cl counts them."""
ITEMS = 4096  # work-items at most: PoCL would compile again for a larger grid
COARSE_LEVELS = 6  # that are halved one after the other, before each work-item takes a part


@dataclass(frozen=True)
class Plan:
    """The shape of a complete tree: `root` children of the root, WIDE of each node below it, down
    `levels` levels, and `leaves` leaves of each of the lowest nodes."""

    root: int
    levels: int
    leaves: int

    @classmethod
    def of(cls, n: int) -> "Plan":
        """For n spheres: the fewest levels, and leaves that are as full as can be."""
        for levels in range(MAX_LEVELS + 1):
            needed = -(-n // (WIDE * WIDE**levels))
            if needed <= WIDE * WIDE:
                break
        # Of the products of two numbers up to 16 the least that is enough; the lowest nodes full.
        _, _, leaves, root = min(
            (root * leaves, -leaves, leaves, root)
            for leaves in range(1, WIDE + 1)
            for root in range(1, WIDE + 1)
            if root * leaves >= needed
        )
        return cls(root, levels, leaves)

    @property
    def numbers(self) -> tuple[np.int32, np.int32, np.int32]:
        return np.int32(self.root), np.int32(self.levels), np.int32(self.leaves)

    @property
    def counts(self) -> list[int]:
        """Nodes of each level, the root's first."""
        return [1, *(self.root * WIDE**level for level in range(self.levels + 1))]

    @property
    def leaf_count(self) -> int:
        return self.counts[-1] * self.leaves

    @property
    def depth(self) -> int:
        """How often the list of spheres is halved."""
        return 4 * (self.levels + 2)


def node_dtype(real: Any) -> np.dtype[Any]:
    return np.dtype([("lo", real, (3, WIDE)), ("hi", real, (3, WIDE))])


def leaf_dtype(real: Any) -> np.dtype[Any]:
    return np.dtype(
        [("center", real, (3, WIDE)), ("radius", real, WIDE), ("id", np.int32, WIDE)], align=True
    )


def capsule_leaf_dtype(real: Any) -> np.dtype[Any]:
    ends = [("start", real, (3, WIDE)), ("axis", real, (3, WIDE))]
    rest = [("length", real, WIDE), ("radius", real, WIDE), ("id", np.int32, WIDE)]
    return np.dtype([*ends, *rest], align=True)


def face_leaf_dtype(real: Any) -> np.dtype[Any]:
    numbers = [("closed", np.int32, WIDE), ("id", np.int32, WIDE)]
    return np.dtype([("corner", real, (3, 3, WIDE)), *numbers], align=True)


def shape_dtype(real: Any) -> np.dtype[Any]:
    names = ("node_count", "lowest", "per_node", "inner", "outer")
    fields = [(name, np.int32) for name in names]
    return np.dtype([*fields, ("wide", real), ("budget", np.int32)], align=True)


class Tree:
    """A tree over a list of things of one kind, fitted to where they are seen from again and again.

    Args:
        keys: (n, 4) float32: x, y, z and a side of the box around each, twice a sphere's radius, in
            any one unit.
        kernels: those of build.cl, by name.
        kind: as tree.cl counts them: 0 are spheres.
        leaf: the dtype of their leaves, of a real.
    """

    def __init__(
        self,
        keys: Array,
        queue: "cl.CommandQueue",
        kernels: "dict[str, cl.Kernel]",
        kind: int = 0,
        leaf: Callable[[Any], np.dtype[Any]] = leaf_dtype,
    ) -> None:
        import pyopencl as cl

        started = time.perf_counter()
        self._kind, self._leaf = np.int32(kind), leaf
        self.n = np.int64(len(keys))
        self.plan = Plan.of(len(keys))
        self._queue = queue
        flags = cl.mem_flags
        copied = flags.READ_WRITE | flags.COPY_HOST_PTR
        sorted_keys = cl.Buffer(queue.context, copied, hostbuf=np.ascontiguousarray(keys))
        self.order = cl.Buffer(queue.context, copied, hostbuf=np.arange(len(keys), dtype=np.int32))
        self._nodes: cl.Buffer | None = None
        self._leaves: cl.Buffer | None = None
        spans = [(k, k + 1) for k in range(COARSE_LEVELS)] + [(COARSE_LEVELS, self.plan.depth)]
        for start, end in spans:
            self._run(
                kernels["split"], 1 << start,
                sorted_keys, self.order, self.n, *self.plan.numbers,
                np.int32(start), np.int32(end),
            )  # fmt: skip
        queue.finish()
        self.build_seconds = time.perf_counter() - started
        self._area_at_first = 0.0

    def fit(self, things: Array, kernels: "dict[str, cl.Kernel]", first: int = 0) -> dict[str, Any]:
        """Moves leaves and boxes to where things are.

        Args:
            things: (n, numbers) as their struct has them: of spheres x, y, z and radius, which is
                NaN of those that the tree is to leave out.
            first: the id of the first of them.

        Returns:
            `things`, `nodes`, `leaves` and `shape` as the kernel takes them.
        """
        import pyopencl as cl

        real, flags, context = things.dtype, cl.mem_flags, self._queue.context
        counts, plan = self.plan.counts, self.plan
        starts = np.concatenate([[0], np.cumsum(counts)]).tolist()
        if self._nodes is None:
            size = starts[-1] * node_dtype(real).itemsize
            self._nodes = cl.Buffer(context, flags.READ_WRITE, size)
            size = plan.leaf_count * self._leaf(real).itemsize
            self._leaves = cl.Buffer(context, flags.READ_WRITE, size)
        where = cl.Buffer(context, flags.READ_ONLY | flags.USE_HOST_PTR, hostbuf=things)
        lowest = len(counts) - 1
        self._run(
            kernels["fit_leaves"], counts[lowest],
            self.order, self._kind, where, self.n, *plan.numbers, self._leaves, self._nodes,
            np.int32(starts[lowest]), np.int32(first),
        )  # fmt: skip
        for level in reversed(range(lowest)):
            children = plan.root if level == 0 else WIDE
            places = (starts[level + 1], starts[level], counts[level], children)
            self._run(kernels["fit_nodes"], counts[level], self._nodes, *map(np.int32, places))
        self._queue.finish()  # the device reads `things` itself: an error must not free it
        self._real = real
        if self._area_at_first == 0:
            self._area_at_first = self._area()
        shape = np.zeros(1, shape_dtype(real))
        shape["node_count"], shape["lowest"] = starts[-1], starts[lowest]
        shape["per_node"], shape["inner"] = plan.leaves, plan.root - WIDE + 1
        shape["outer"] = starts[-1] - starts[lowest] * plan.leaves
        in_beam, budget = BEAMS[self._kind]
        shape["wide"] = 4 * np.pi * in_beam / max(len(things), 1)
        shape["budget"] = budget
        return {"things": where, "nodes": self._nodes, "leaves": self._leaves, "shape": shape}

    def looseness(self) -> float:
        """By how much the boxes around the leaves have grown since the tree was built: the sum of
        their surfaces, in units of the whole one's. The times that rays meet them grow like it."""
        area = self._area()
        return area / self._area_at_first if self._area_at_first > 0 else np.inf

    def _area(self) -> float:
        import pyopencl as cl

        assert self._nodes is not None  # once it was fitted
        counts = self.plan.counts
        nodes = np.empty(sum(counts), node_dtype(self._real))
        cl.enqueue_copy(self._queue, nodes, self._nodes)
        with np.errstate(invalid="ignore"):
            x, y, z = np.maximum(nodes["hi"] - nodes["lo"], 0).transpose(1, 0, 2)
            areas = x * y + y * z + z * x
            low, high = nodes["lo"][0].min(axis=1), nodes["hi"][0].max(axis=1)
            a, b, c = high - low
        return float(areas[-counts[-1] :].sum(dtype=np.float64) / (a * b + b * c + c * a))

    def _run(self, kernel: "cl.Kernel", items: int, *arguments: Any) -> None:
        import pyopencl as cl

        kernel.set_args(*arguments)
        cl.enqueue_nd_range_kernel(self._queue, kernel, (min(items, ITEMS),), (1,))

"""Engine: a device, its programs and a scene's buffers, which together make a film."""

import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, Self, TypeAlias

import numpy as np
from numpy.typing import DTypeLike, NDArray

from clrt import storage
from clrt.errors import DeviceError, DeviceWarning, LinkError, RequestError
from clrt.film import develop
from clrt.film.decor import decorations
from clrt.opencl import pocl, program
from clrt.opencl.denoise import FAR
from clrt.opencl.device import check_process, find_device, label
from clrt.renderer.checks import Passes, Region, check_passes, check_region, check_size, film_dtype
from clrt.renderer.dispatch import Dispatcher, Program, quiet
from clrt.renderer.pack.features import LANES, Features, exposures, features_of, stages
from clrt.renderer.pack.structs import PRECISIONS, FilmKind, Precision
from clrt.scene.scene import Scene

if TYPE_CHECKING:
    import pyopencl as cl

Array: TypeAlias = NDArray[Any]
PATIENCE = 1  # seconds after which a person wonders


class Engine:
    """Renders scenes on one device, keeping compiled programs: see clrt.Renderer, which reads the
    files that a scene names."""

    def __init__(
        self,
        *,
        precision: Precision = "robust",
        lanes: int | None = None,
        device: "str | cl.Device | None" = None,
        threads: int | None = None,
    ) -> None:
        if precision not in PRECISIONS:
            raise RequestError(f"precision: expected one of {list(PRECISIONS)}, got {precision!r}")
        if lanes is not None and lanes not in LANES:
            raise RequestError(f"lanes: expected one of {list(LANES)}, got {lanes!r}")
        check_process()
        if device is None or isinstance(device, str):
            device = find_device(device, threads)
        import pyopencl as cl  # after find_device, which prepares its environment

        self.device = device
        self.precision = precision
        self.real = PRECISIONS[precision]
        if self.real is np.float64 and device.native_vector_width_double == 0:
            raise DeviceError(f"{label(device)} has no float64, which precision double needs")
        self.lanes = lanes or default_lanes(device)
        widest = pocl.NARROW // np.dtype(self.real).itemsize
        if pocl.is_narrow(device) and self.lanes > widest:
            self._narrow(widest, "PoCL could not be told which CPU to compile for")
        with self._errors():
            self._context = cl.Context([device])
            self._queue = cl.CommandQueue(
                self._context, properties=cl.command_queue_properties.PROFILING_ENABLE
            )
        self._programs: dict[Features, dict[str, cl.Kernel]] = {}
        self._dispatcher = Dispatcher(self._queue, precision)
        self._lock = threading.RLock()  # a kernel has its arguments until it is enqueued
        self.quiet = False
        """Whether a terminal is not told when compiling takes long."""
        self._told = False
        self.kernel_seconds = 0.0
        """How long kernels ran for the last picture, by the device's own clock."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Waits for the device and lets go of it."""
        with self._lock:
            self._dispatcher.close()
            self._programs.clear()

    @contextmanager
    def _errors(self) -> Iterator[None]:
        """Turns OpenCL's errors into clrt's."""
        import pyopencl as cl

        try:
            yield
        except cl.Error as error:
            raise DeviceError(f"{label(self.device)} cannot do this: {error}") from None

    @contextmanager
    def _working(self, scene: Scene) -> Iterator[None]:
        """While the device works for one caller, and OpenCL's errors are clrt's.

        Raises:
            RequestError: the scene's particles are still in their files.
        """
        check_process()  # before the lock, which a fork may have for ever
        if scene.particles:
            said = "expected none that are in files: clrt.Renderer reads them"
            raise RequestError(f"particles: {said}")
        with self._lock, self._errors():
            yield

    def paths(self, scene: Scene, width: int, height: int) -> NDArray[np.uint32]:
        """A hash of each pixel's path, (height, width), to compare with reference.trace()'s."""
        with self._working(scene):
            box = 0, 0, *check_size(width, height)
            used = self._programs_of(scene, ["paths"])["paths"]
            arguments = self._dispatcher.arguments(
                scene, width, height, used[0], self.kernel_seconds
            )
            exposed, self.kernel_seconds = self._dispatcher.exposed(
                used, scene, arguments, (width, height), box
            )
            return exposed[..., 0]

    def picture(
        self,
        scene: Scene,
        size: tuple[int, int],
        dtype: np.dtype[Any],
        alpha: bool,
        names: Sequence[str] | None,
        region: Region | None,
        out: Array | None,
        progress: Callable[[int], object] | None,
    ) -> tuple[Array, Passes]:
        """A picture and its passes: see Renderer.render()."""
        with self._working(scene):
            width, height = check_size(*size)
            box = left, top, right, bottom = check_region(region, width, height)
            shape = bottom - top, right - left, 3 + alpha
            if out is not None and (out.shape != shape or not out.flags.writeable):
                raise RequestError(f"out: expected a writeable array of {shape}, got {out.shape}")
            kinds = exposures(scene, dtype, alpha, names)
            programs = self._programs_of(scene, kinds)
            own = programs[kinds[0]]
            if kinds[0] in ("alpha", "guides"):  # what is wrong there is said before the work
                decorations.drawings(scene, size, None)
            arguments = self._dispatcher.arguments(
                scene, width, height, own[0], self.kernel_seconds
            )
            seconds, found, seen = 0.0, {}, None

            def expose(used: Sequence[Program], box: Region, **options: Any) -> tuple[Array, float]:
                return self._dispatcher.exposed(used, scene, arguments, size, box, **options)

            def grown(pixels: int) -> tuple[Region, tuple[slice, slice]]:
                """The box with so many more around it, and where in that it lies."""
                x0, y0 = max(left - pixels, 0), max(top - pixels, 0)
                inside = np.s_[top - y0 : bottom - y0, left - x0 : right - x0]
                return (x0, y0, min(right + pixels, width), min(bottom + pixels, height)), inside

            if "passes" in programs:
                around, inside = grown(develop.halo(scene.film, scene.samples))
                looks, seconds = expose(
                    programs["passes"], around, use="passes", progress=quiet(progress)
                )
                looks = looks[..., 0]
                found = {name: looks[inside][name].copy() for name in names or ()}
                radius = self._dispatcher.world(scene).radii
                seen = develop.Seen(looks["id"], looks["depth"], radius, inside, scene.samples)
            if "guides" in programs or (
                "alpha" in programs and develop.has_steps(scene.film, dtype, alpha)
            ):
                around, inside = grown(FAR if "guides" in programs else 0)
                exposed, more = expose(own, around, use="exposed", progress=progress)
                if "guides" in programs:
                    exposed, filtering = self._dispatcher.denoised(
                        own[0], scene, arguments, exposed[..., 0], quiet(progress)
                    )
                    exposed, more = exposed[inside], more + filtering
                image = self._dispatcher.blank(shape, dtype) if out is None else out
                marks = decorations.marks(scene, size, box, alpha, seen)
                develop.develop(exposed, scene.film, image, seen, marks)
            else:
                image, more = expose(own, box, out=out, progress=progress)
            self.kernel_seconds = seconds + more
            return image, found

    def prepare(
        self,
        scene: Scene,
        dtype: DTypeLike | None = None,
        *,
        alpha: bool | None = None,
        passes: Sequence[str] | None = None,
    ) -> None:
        """Compiles the programs that a picture of such a scene needs."""
        alpha = scene.film.transparent if alpha is None else alpha
        with self._working(scene):
            self._programs_of(
                scene, exposures(scene, film_dtype(dtype), alpha, check_passes(passes))
            )

    def _programs_of(
        self, scene: Scene, kinds: Sequence[FilmKind]
    ) -> dict[FilmKind, list[Program]]:
        """The programs of each film, one after the other; if those of so many lanes do not work,
        those of fewer."""
        world = self._dispatcher.world(scene)
        while True:
            needed = {
                kind: [
                    features_of(world, scene, self.lanes, kind, stage)
                    for stage in stages(scene, kind)
                ]
                for kind in kinds
            }
            every = dict.fromkeys(features for some in needed.values() for features in some)
            try:
                if missing := [features for features in every if features not in self._programs]:
                    self._make(missing)
            except DeviceError as error:
                narrower = [n for n in LANES if n < self.lanes]
                if not narrower or isinstance(error, LinkError):
                    raise DeviceError(f"{label(self.device)} cannot be used: {error}") from None
                self._narrow(narrower[-1], str(error))
                continue
            return {
                kind: [(features, self._programs[features]) for features in some]
                for kind, some in needed.items()
            }

    def _make(self, wanted: Sequence[Features]) -> None:
        """Takes programs from the cache; else they are compiled, tried and kept.

        Raises:
            DeviceError: one has not passed its trial.
        """
        import pyopencl as cl

        source, missing = program.kernel_source(), {}
        for features in wanted:
            path = program.cache_path(self.device, source, features.options)
            if (binary := storage.kept(path)) is not None:
                with suppress(cl.Error):  # it is refused, as by another build of the same version
                    self._load(features, binary)
                    continue
            missing[features] = path
        if not missing:
            return
        from clrt.renderer import maker

        binaries = maker.made(self.device, source, list(missing), self._waiting)
        for (features, path), binary in zip(missing.items(), binaries, strict=True):
            storage.keep(path, binary)
            self._load(features, binary)

    def _waiting(self, seconds: float) -> None:
        """Says once, on a terminal, why nothing is to be seen yet."""
        if seconds > PATIENCE and not (self._told or self.quiet) and sys.stderr.isatty():
            self._told = True
            print("clrt: compiling for this kind of scene, once", file=sys.stderr)

    def _load(self, features: Features, binary: bytes) -> None:
        loaded = program.loaded(self._context, self.device, binary)
        self._programs[features] = program.kernels(loaded)

    def _narrow(self, lanes: int, why: str) -> None:
        self.lanes, before = lanes, self.lanes
        message = f"{label(self.device)}: {before} lanes cannot be used, {lanes} are: {why}"
        warnings.warn(message, DeviceWarning, stacklevel=2)


def default_lanes(device: "cl.Device") -> int:
    """16 on a CPU whatever its vectors' width: wider packets than those have more to do at a time,
    which hides latency (benchmarks/NOTES.md)."""
    import pyopencl as cl

    return max(LANES) if device.type & cl.device_type.CPU else 1

"""Errors and warnings, and the exit status that each error gives the command."""

import re
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from types import MappingProxyType

_CALLED = ContextVar[Mapping[str, str]]("_CALLED", default=MappingProxyType({}))
"""What keys are called by who gave them: see called()."""


class ClrtError(Exception):
    """An error that says in one line what to do about it."""

    exit_status = 1


class DeviceError(ClrtError):
    """No OpenCL device can do the work."""


class LinkError(DeviceError):
    """What a device has compiled cannot be linked, however few its lanes are."""


class OutputError(ClrtError):
    """The picture cannot be written, or does not fit into memory."""


class RequestError(ClrtError, ValueError):
    """A request makes no sense: a size, a suffix, a folder."""

    exit_status = 2


class SceneError(RequestError):
    """A scene that is not one. The message names file, key and what was expected."""


class FrameError(SceneError):
    """A frame of a trajectory that cannot be read, while others can."""

    exit_status = 1


class CutError(SceneError):
    """A file ends where something is still to come."""


@contextmanager
def named(source: object, kind: type[ClrtError] = RequestError) -> Iterator[None]:
    """Puts the name of a file, or of a scene, before the errors of it."""
    try:
        yield
    except kind as error:
        raise kind(f"{source}: {error}") from None


@contextmanager
def called(names: Mapping[str, str]) -> Iterator[None]:
    """Calls a key that an error begins with, after a file's name or not, as those call it who gave
    it: {"radius": "--radius"}. Warnings of warn() as well."""
    before = _CALLED.set({**_CALLED.get(), **names})
    try:
        yield
    except RequestError as error:
        keys = "|".join(map(re.escape, names))
        text = re.sub(
            rf"^((?:\S[^:]*: )??)({keys})(?=[:\[.])",
            lambda found: found[1] + names[found[2]],
            str(error),
        )
        raise type(error)(text) from None
    finally:
        _CALLED.reset(before)


class ClrtWarning(UserWarning):
    """Something is not as it may seem. The command prints a line."""


class DeviceWarning(ClrtWarning):
    """A device does the work, but not in the way that was asked for."""


class SceneWarning(ClrtWarning):
    """A picture is not quite what its scene says."""


class ParticleWarning(ClrtWarning):
    """A file has something that is not used."""


def warn(key: str, text: str, kind: type[Warning] = ParticleWarning) -> None:
    """Warns of particles that have not all that a key needs, or of what a key makes of a scene."""
    warnings.warn(f"{_CALLED.get().get(key, key)}: {text}", kind, stacklevel=3)

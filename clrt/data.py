"""Where clrt's own files are."""

import os
import stat
import tempfile
from pathlib import Path

from clrt.errors import DeviceError

ROOM = 1 << 20  # bytes; a compiled kernel takes a seventh of it


def folder(name: str) -> Path:
    """The folder "kernels" or "scenes": inside the package in a wheel, beside it in a checkout."""
    inside = Path(__file__).parent / name
    return inside if inside.is_dir() else inside.parents[1] / name


def cache_folder() -> Path:
    """Where clrt keeps what it can make again: in the user's cache (XDG base directories), or in
    the temporary folder if that cannot be written or is full.

    Raises:
        DeviceError: neither has room.
    """
    for find in (_of_user, _temporary):
        try:
            found = find()
            with tempfile.TemporaryFile(dir=found) as probe:
                os.posix_fallocate(probe.fileno(), 0, ROOM)
            return found
        except (OSError, RuntimeError):  # expanduser() where there is no home
            continue
    raise DeviceError("no room for compiled kernels: set XDG_CACHE_HOME to a folder with 1 MB free")


def _of_user() -> Path:
    found = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser()) / "clrt"
    found = found.absolute()  # whatever folder the process works in later
    found.mkdir(parents=True, exist_ok=True)
    return found


def _temporary() -> Path:
    """A folder that only this user can write, the same one in every run."""
    found = Path(tempfile.gettempdir()).absolute() / f"clrt-{os.getuid()}"
    found.mkdir(mode=0o700, exist_ok=True)
    status = found.lstat()
    if status.st_uid != os.getuid() or not stat.S_ISDIR(status.st_mode):
        raise PermissionError(f"{found} is somebody else's")
    return found

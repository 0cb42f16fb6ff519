"""Storage: the folders that clrt comes with, the cache of compiled programs, and locks."""

import errno
import fcntl
import hashlib
import os
import secrets
import stat
import tempfile
import time
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path

from clrt.errors import DeviceError

LOCK_GRACE_SECONDS = 60  # a younger file may not be locked yet
ROOM = 1 << 20  # bytes; a compiled kernel takes a seventh of it
KEPT_ROOM = 200 << 20  # bytes of all that is kept: 1200 programs
KEY_LENGTH = 64  # of a kept file's name: sha256, in hexadecimal digits
IN_MEMORY = "/dev/shm"  # Linux has a file system there; some containers' has 64 MB
ROOM_IN_MEMORY = 32 << 20  # bytes


def folder(name: str) -> Path:
    """The folder "kernels", "scenes" or "tables"."""
    return Path(__file__).parent / name


def cache_folder(runs: bool = False) -> Path:
    """The folder for things that clrt can make again. It is in the user's cache (XDG base
    directories), or in the temporary folder if that cannot be written or is full.

    runs: whether programs must run from there, and of this process only. Those are kept in memory,
        unless XDG_CACHE_HOME says where: PoCL waits for a disk at each file, 6 ms a program.

    Raises:
        DeviceError: neither has room, or lets programs run.
    """
    reason = ""
    finds = [_of_user, _temporary]
    if runs and "XDG_CACHE_HOME" not in os.environ:
        finds.insert(0, _in_memory)
    for find in finds:
        try:
            found = find()
            with tempfile.TemporaryFile(dir=found) as probe:
                os.posix_fallocate(probe.fileno(), 0, ROOM)
            if not (runs and os.statvfs(found).f_flag & os.ST_NOEXEC):
                return found
            reason = "set XDG_CACHE_HOME to a folder that is not mounted noexec"
        except (OSError, RuntimeError) as error:  # expanduser() where there is no home
            if getattr(error, "errno", None) == errno.EFBIG:
                reason = "no file may have 1 MB (ulimit -f): allow it"
    reason = reason or "set XDG_CACHE_HOME to a folder with 1 MB free"
    raise DeviceError(f"no room for compiled kernels: {reason}")


def _of_user() -> Path:
    found = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser()) / "clrt"
    found = found.absolute()  # whatever folder the process works in later
    found.mkdir(parents=True, exist_ok=True)
    return found


def _temporary() -> Path:
    return _own(tempfile.gettempdir())


def _in_memory() -> Path:
    found = os.statvfs(IN_MEMORY)
    if found.f_bavail * found.f_frsize < ROOM_IN_MEMORY or found.f_flag & os.ST_NOEXEC:
        raise OSError(f"{IN_MEMORY} has no room for programs")
    return _own(IN_MEMORY)


def _own(parent: str) -> Path:
    """A folder that only this user can write, the same one in every run."""
    found = Path(parent).absolute() / f"clrt-{os.getuid()}"
    found.mkdir(mode=0o700, exist_ok=True)
    status = found.lstat()
    if status.st_uid != os.getuid() or not stat.S_ISDIR(status.st_mode):
        raise PermissionError(f"{found} is somebody else's")
    return found


def kept(path: Path) -> bytes | None:
    """The content that keep() wrote; None if it is not there, cut short or changed."""
    with suppress(OSError):
        # So a pipe, which only a vandal puts there, is an error and nothing to wait for.
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK), "rb") as file:
            content = file.read()
        size = hashlib.sha256().digest_size
        if hashlib.sha256(content[size:]).digest() == content[:size]:
            with suppress(OSError):
                os.utime(path)  # used now: see _make_room()
            return content[size:]
    return None


def keep(path: Path, content: bytes) -> None:
    """Keeps it as sha256(content) + content, and forgets the files that were not used for longest.

    Whole or not at all: a reader that has the old file open reads the old content.

    Args:
        path: in the cache folder, with a name of KEY_LENGTH.
    """
    beside = path.with_suffix(f".{secrets.token_hex(4)}")
    with suppress(OSError):  # slower next time
        try:
            beside.write_bytes(hashlib.sha256(content).digest() + content)
            os.replace(beside, path)
        finally:
            beside.unlink(missing_ok=True)
        _make_room(path.parent)


def _make_room(cache: Path) -> None:
    found = []
    for path in cache.iterdir():
        with suppress(OSError):  # another process has removed it
            if len(path.name) >= KEY_LENGTH:
                status = path.stat()
                found.append((status.st_mtime_ns, status.st_size, path))
    left = KEPT_ROOM
    for _, size, path in sorted(found, reverse=True):
        left -= size
        if left < 0:
            path.unlink(missing_ok=True)


def locked(path: Path) -> int:
    """Locks a file or folder for as long as this process lives, or until the file that is returned
    is closed.

    Raises:
        OSError: another has locked it, or the file system has no locks.
    """
    file = os.open(path, os.O_RDONLY)
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(file)
        raise
    return file


def abandoned(paths: Iterable[Path]) -> Iterator[Path]:
    """The files and folders that were locked by a process that has ended."""
    for path in paths:
        try:
            if time.time() - path.stat().st_mtime > LOCK_GRACE_SECONDS:
                os.close(locked(path))
                yield path
        except OSError:  # its process lives, or it is gone
            continue

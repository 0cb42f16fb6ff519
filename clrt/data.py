"""Where clrt's own files are."""

import os
from pathlib import Path


def folder(name: str) -> Path:
    """The folder "kernels" or "scenes": inside the package in a wheel, beside it in a checkout."""
    inside = Path(__file__).parent / name
    return inside if inside.is_dir() else inside.parents[1] / name


def user_cache() -> Path:
    """The user's folder for caches, which PoCL and PyOpenCL use as well (XDG base directories)."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser())


def cache_folder() -> Path:
    """Where clrt keeps what it can make again."""
    return user_cache() / "clrt"

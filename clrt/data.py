"""Where clrt's own files are."""

from pathlib import Path


def folder(name: str) -> Path:
    """The folder "kernels" or "scenes": inside the package in a wheel, beside it in a checkout."""
    inside = Path(__file__).parent / name
    return inside if inside.is_dir() else inside.parents[1] / name

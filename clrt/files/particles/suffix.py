"""Suffix: whether a file is one of particles, and of which format, by its name."""

from pathlib import Path

SUFFIXES = (
    *(".npz", ".npy", ".csv", ".ply", ".xyz", ".extxyz", ".dump", ".lammpstrj"),
    *(".pdb", ".cif", ".gsd"),
)
"""Those of clrt.files.particles.reader.READERS, which takes longer to import."""


def split(path: Path) -> tuple[str, bool]:
    """The format's suffix, and whether the file is gzipped."""
    name = path.name.lower()
    return Path(name.removesuffix(".gz")).suffix, name.endswith(".gz")


def is_particles(path: Path) -> bool:
    """Whether the suffix is that of a format of particles."""
    return split(path)[0] in SUFFIXES

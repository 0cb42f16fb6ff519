"""clrt formats: which files are read and written."""

import click

PARTICLES = (
    (".npz .npy", "NumPy", ""),
    (".csv .tsv", "text with a header", ""),
    (".ply", "PLY: its vertices", ""),
    (".xyz .extxyz", "XYZ, plain or extended; many frames", ""),
    (".dump .lammpstrj .lammpsdump", "LAMMPS's text dump; many frames", ""),
    (".data .lmp", "LAMMPS's data", ""),
    (".gro", "GROMACS; many frames", ""),
    (".poscar .contcar .vasp .xdatcar", "VASP", ""),
    (".pdb .ent", "Protein Data Bank; many frames", "clrt[mol]"),
    (".cif .mmcif", "mmCIF, CIF of a crystal", "clrt[mol]"),
    (".gsd", "GSD (HOOMD); many frames", "clrt[gsd]"),
    (".vtp .vtu .vtk", "VTK", "clrt[vtk]"),
    (".xtc .trr .dcd", "frames of a system that another file has", "clrt[traj]"),
)
WRITTEN = (
    (".png .jpg .webp .tif .bmp .ppm", "pictures of 8 bits, .png and .tif also of 16", ""),
    (".npy .npz .pfm", "pictures of linear float32", ""),
    (".svg .pdf", "pictures with words as such", "clrt[text]"),
    (".exr", "pictures of linear float32, with passes", "clrt[exr]"),
    (".webp .gif .apng", "videos", ""),
    (".mp4 .mov .mkv", "videos, H.264", "clrt[video]"),
)


@click.command()
def formats() -> None:
    """Lists the formats of files that are read and written."""
    from clrt.files.particles.suffix import SUFFIXES

    click.echo("Particles, read, also gzipped:")
    left = list(SUFFIXES)
    for suffixes, what, extra in PARTICLES:
        there = [suffix for suffix in suffixes.split() if suffix in left]
        if there:
            _say(" ".join(there), what, extra)
            left = [suffix for suffix in left if suffix not in there]
    if left:
        _say(" ".join(left), "", "")
    click.echo("Scenes, read:")
    _say(".toml", "docs/scenes.md", "")
    click.echo("Written:")
    for row in WRITTEN:
        _say(*row)


def _say(suffixes: str, what: str, extra: str) -> None:
    needs = f"; pip install '{extra}'" if extra else ""
    click.echo(f"  {suffixes:32}{what}{needs}")

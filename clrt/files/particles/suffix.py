"""Suffix: of which format a file of particles is, by its name or by how it begins."""

import re
from glob import has_magic, iglob
from pathlib import Path

FORMATS: dict[str, tuple[str, ...]] = {
    "npz": (".npz",),
    "npy": (".npy",),
    "csv": (".csv", ".tsv"),
    "ply": (".ply",),
    "xyz": (".xyz", ".extxyz"),
    "dump": (".dump", ".lammpstrj", ".lammpsdump"),
    "data": (".data", ".lmp"),
    "pdb": (".pdb", ".ent"),
    "cif": (".cif", ".mmcif"),
    "gsd": (".gsd",),
    "gro": (".gro",),
    "poscar": (".vasp",),
    "vtk": (".vtp", ".vtu", ".vtk"),
}
"""The suffixes of each, in small letters. clrt.files.particles.reader reads them, which takes
longer to import."""
SUFFIXES = tuple(suffix for suffixes in FORMATS.values() for suffix in suffixes)
PACKED = (".gz", ".bz2", ".xz", ".zst")
STDIN = "-"
BEGIN = {b"ITEM: ": "dump", b"ply\n": "ply", b"ply\r": "ply", b"\x93NUMPY": "npy"}
"""How files begin that need no suffix."""
NAMES = {
    "dump": "dump",
    "data": "data",
    "poscar": "poscar",
    "contcar": "poscar",
    "xdatcar": "poscar",
}
"""The first words of names, as dump.16000 and data.lj, that need no suffix."""

ELSEWHERE = {
    "ase.io.read": ".mol .sdf .traj .xsf .cube .xsd .res .gen .cell .cfg .db .castep .outcar",
    "ovito.io.import_file": ".imd .fhi .bin .vtm .pvd .gdf",
    "MDAnalysis.Universe": ".mol2 .psf .prmtop .tpr .crd .pdbqt .pqr",
    "trimesh.load": ".glb .gltf .off .3mf",
    "pyvista.read": ".vti .vts .vtr .vtkhdf .pvtu .pvtp .case .foam",
}
"""What reads other formats, and gives objects that clrt.plot() takes."""
MESHES = (".stl", ".obj")
PLACES = (
    *(".xtc", ".trr", ".dcd", ".nc", ".ncdf", ".trj", ".mdcrd", ".tng", ".trz", ".coor", ".h5md"),
)
"""The suffixes of files that have places of atoms and say little of what they are."""


def split(path: Path) -> tuple[str, str]:
    """The format's suffix, or "", and that of how it is packed, or ""."""
    packed = next((end for end in PACKED if path.name.lower().endswith(end)), "")
    return Path(path.name.lower().removesuffix(packed)).suffix, packed


def format_of(path: Path) -> str | None:
    """The format of a file by its name, or else by its first bytes; None: of none."""
    name = path.name.lower().removesuffix(split(path)[1])
    bare = re.sub(r"[._-]?\d+$", "", name)  # flow.dump.100 and dump.16000
    for known in (name, bare):
        suffix = Path(known).suffix
        for form, suffixes in FORMATS.items():
            if suffix in suffixes:
                return form
    if name.endswith(".toml"):
        return None
    if found := NAMES.get(re.split(r"[._\-\d]", name)[0]):
        return found
    try:
        with path.open("rb") if path.is_file() else Path("/dev/null").open("rb") as file:
            begin = file.read(8)
    except OSError:
        return None
    return next((form for start, form in BEGIN.items() if begin.startswith(start)), None)


def is_particles(path: Path) -> bool:
    """Whether a file is one of particles, or those are that a pattern as dump.* means."""
    if str(path) == STDIN:
        return True
    if has_magic(str(path)) and not path.exists():
        path = Path(next(iglob(str(path)), path))
    return format_of(path) is not None


def reads_it(path: Path) -> str:
    """What is said of a file that is of no format: what reads it, and which formats there are."""
    suffix = split(path)[0]
    known = f"clrt reads {' '.join(SUFFIXES)} and scenes .toml"
    if suffix in PLACES:
        call = f"clrt animate system.gro {path.name[:40]}"
        return f"{suffix} has places and no atoms: {call} reads both by MDAnalysis; {known}"
    if suffix in MESHES:
        return f"{suffix} is a mesh: clrt render draws it, clrt.read_mesh reads it; {known}"
    for reader, suffixes in ELSEWHERE.items():
        if suffix in suffixes.split():
            package = reader.split(".")[0]
            call = f"clrt.plot({reader}({path.name[:40]!r}))"
            return f"clrt does not read {suffix}; {package} does: {call}; {known}"
    return f"{known}; --format NAME reads a file whose name does not tell"

"""The house: a module imports only modules of lower layers (docs/design.md has the same table)."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
LAYERS = [
    names.split()
    for names in (
        "ahead decor.ticks errors files.particles.suffix opencl.bands opencl.tree samples "
        "viewer.schedule",
        "data decor.lettering files.deep files.png memory metrics opencl.edges values",
        "color elements files.image files.particles.text light opencl.pocl palette particles "
        "spheres",
        "files.particles.columns files.particles.trajectory opencl.device particlefile",
        "files.particles.arrays files.particles.csv files.particles.hoomd "
        "files.particles.lammps files.particles.molecules files.particles.ply "
        "files.particles.xyz opencl.program scene",
        "decor.legend files.particles.objects files.scenefile files.scenewriter film glass "
        "lens styles",
        "coloring decor.cell decor.panel files.numbered files.particles.reader moves options "
        "pack view",
        "decor.decorations exposer figure files.resolved files.video",
        "files.figures reference",
        "trial",
        "renderer",
        "animation picture",
        "flow",
        "cluster viewer.subject",
        "viewer.session",
        "viewer.painter",
        "viewer.canvas viewer.server",
        "cli viewer.notebook",
        "__main__",
    )
]
LAYER_OF = {module: i for i, modules in enumerate(LAYERS) for module in modules}


def name_of(path: Path) -> str:
    return ".".join(path.relative_to(ROOT / "clrt").with_suffix("").parts)


MODULES = {
    name_of(path): path
    for path in (ROOT / "clrt").rglob("*.py")
    if path.name != "__init__.py"  # clrt's own only says where each public name comes from
}


def imports_of(path: Path) -> set[str]:
    """The modules of clrt that it imports, anywhere in it."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "clrt":
            home = (node.module or "").removeprefix("clrt").lstrip(".")
            for alias in node.names:
                name = f"{home}.{alias.name}".lstrip(".")
                found.add(name if name in MODULES else home)
    return found


def test_every_module_has_a_layer() -> None:
    assert set(MODULES) == set(LAYER_OF)


def test_imports_lead_downward() -> None:
    for module, path in MODULES.items():
        for other in imports_of(path):
            assert LAYER_OF[other] < LAYER_OF[module], f"{module} imports {other}"


def test_opencl_and_files_know_nothing_of_each_other_nor_opencl_of_scenes() -> None:
    for module, path in MODULES.items():
        if module.startswith("opencl."):
            assert not [o for o in imports_of(path) if o.startswith("files.") or o == "scene"]
        if module.startswith("files."):
            assert not [o for o in imports_of(path) if o.startswith("opencl.")]


def test_only_the_command_line_knows_click() -> None:
    knowing = {
        m for m, path in MODULES.items() if re.search(r"^import click", path.read_text(), re.M)
    }
    assert knowing == {"cli", "options"}


def test_the_design_has_the_same_layers() -> None:
    rows = re.findall(r"^\| (\d+) \| (.*?) \|", (ROOT / "docs" / "design.md").read_text(), re.M)
    told = {name: int(layer) for layer, names in rows for name in re.findall(r"`(.*?)`", names)}
    expected = {f"{m.replace('.', '/')}.py": layer for m, layer in LAYER_OF.items()}
    assert told == expected

"""The house: a package imports only packages below it, and inside a package no two modules need
each other (docs/design.md has the same list)."""

import ast
import re
from graphlib import TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGES = [
    "commands",
    "viewer",
    "motion",
    "figure",
    "renderer",
    "files",
    "truth",
    "film",
    "scene",
    "particles",
    "opencl",
]
"""From the top down. The modules beside them are below all."""
GROUND = ["cgroups", "errors", "memory", "pipeline", "storage", "values"]
TOP = ["__main__", "reference"]
"""Modules above all: the command as a process, and clrt.reference as people call it."""


def name_of(path: Path) -> str:
    parts = path.relative_to(ROOT / "clrt").with_suffix("").parts
    return ".".join(part for part in parts if part != "__init__")


MODULES = {
    name: path
    for path in (ROOT / "clrt").rglob("*.py")
    if (name := name_of(path))  # clrt's own __init__ only says where each public name comes from
}


def floor_of(module: str) -> int:
    """How high its package is."""
    package = module.split(".")[0]
    if package in TOP:
        return len(PACKAGES)
    return -1 if package in GROUND else len(PACKAGES) - 1 - PACKAGES.index(package)


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


IMPORTS = {module: imports_of(path) for module, path in MODULES.items()}


def test_every_module_has_a_place() -> None:
    assert {module.split(".")[0] for module in MODULES} == {*TOP, *PACKAGES, *GROUND}


def test_imports_lead_downward() -> None:
    for module, others in IMPORTS.items():
        for other in others:
            assert floor_of(other) <= floor_of(module), f"{module} imports {other}"


def test_no_two_modules_need_each_other() -> None:
    TopologicalSorter(IMPORTS).prepare()  # raises CycleError


def test_files_know_nothing_of_opencl() -> None:
    for module, others in IMPORTS.items():
        if module.startswith("files."):
            assert not [other for other in others if other.startswith("opencl")], module


def test_only_the_command_line_knows_click() -> None:
    for module, path in MODULES.items():
        if re.search(r"^import click|^from click", path.read_text(), re.M):
            assert module.startswith("commands."), module


def test_the_design_has_the_same_packages() -> None:
    text = (ROOT / "docs" / "design.md").read_text()
    rows = [re.findall(r"`(.*?)`", row) for row in re.findall(r"^\| (`.*?) \|", text, re.M)]
    told = [row for row in rows if not row[0].startswith("kernels/")]
    assert told == [[f"{name}/"] for name in PACKAGES] + [[f"{name}.py"] for name in GROUND]

"""The kernels' text: a feature is a number and code asks by `if`; functions fit a screen and say
what they are for; what no feature asks for is in no program."""

import re
from pathlib import Path

import pyopencl as cl
import pytest

from clrt import storage
from clrt.opencl import program
from clrt.renderer.pack.features import Features
from clrt.renderer.pack.structs import FILMS

FILES = sorted(storage.folder("kernels").glob("*.cl"))
SCREEN = 60  # lines
CONDITIONAL = re.compile(r"\s*#\s*(if|ifdef|ifndef|elif|else|endif)\b")
FUNCTION = re.compile(r"(?:static|__kernel) [^(;]*?(\w+)\(")
KNOWN = dict(
    re.findall(r"^//   ([A-Z_]+) +(\S.*)$", (FILES[0].parent / "features.cl").read_text(), re.M)
)
"""The features by name, and what the list says of each."""


def functions(text: str) -> dict[str, list[list[str]]]:
    """The lines of each function by its name, of which there can be several definitions."""
    found: dict[str, list[list[str]]] = {}
    lines = text.split("\n")
    for i, line in enumerate(lines):
        if start := FUNCTION.match(line):
            last = i
            while not lines[last].endswith("}") or (last > i and lines[last] != "}"):
                last += 1
            found.setdefault(start[1], []).append(lines[i : last + 1])
    return found


def headings(text: str) -> dict[str, str]:
    """What stands above each function; above the first of several that stand together."""
    found: dict[str, str] = {}
    heading, above = "", False
    for line in text.split("\n"):
        if line.startswith("//"):
            heading = heading * above + line[2:]
        elif start := FUNCTION.match(line):
            found.setdefault(start[1], heading)
        above = line.startswith("//")
        if not line:
            heading = ""
    return found


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_no_preprocessor_in_a_function_and_none_is_longer_than_a_screen(path: Path) -> None:
    for name, definitions in functions(path.read_text()).items():
        for lines in definitions:
            assert not any(map(CONDITIONAL.match, lines)), name
            assert len(lines) <= SCREEN, name


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_each_function_has_a_heading(path: Path) -> None:
    for name, heading in headings(path.read_text()).items():
        assert heading.strip(), name


def test_the_list_has_each_feature_that_the_host_defines() -> None:
    told: set[str] = set()
    for film in FILMS:
        told |= {option[2:].split("=")[0] for option in Features(1, "robust", film).options}
    assert set(KNOWN) == told
    assert all(sentence[0].isupper() for sentence in KNOWN.values())


def test_the_preprocessor_asks_for_nothing_else() -> None:
    """It would take a name that is misspelt for 0."""
    source = program.kernel_source()
    lines = re.findall(r"^\s*#\s*(?:if|ifdef|ifndef|elif)\b((?:.*\\\n)*.*)", source, re.M)
    asked = set(re.findall(r"\b(?!\d)\w+", " ".join(lines)))
    asked -= set(re.findall(r"#define (\w+)", source)) | set(KNOWN)
    asked -= {"defined", "__has_builtin", "PYOPENCL_USING_OCLGRIND", "POCL_DEVICE_ADDRESS_BITS"}
    # What the compiler says that it has.
    asked -= {name for name in asked if re.fullmatch(r"__(AVX|FMA|builtin)\w+|FP_FAST_FMAF", name)}
    assert not asked


def test_the_design_has_the_files_in_their_order() -> None:
    design = (Path(__file__).parents[1] / "docs" / "design.md").read_text()
    names = ["builtins", *program.KERNELS]
    assert re.findall(r"^\| `kernels/(\w+)\.cl` \|", design, re.M) == names
    assert {path.stem for path in FILES} == set(names)


LISTED = {"reflection", "light_inside", "sphere_colors", "ambient", "attenuation", "spot", "phong"}
SOME: dict[str, set[str]] = {
    "nothing": set(),
    "a tree": {"tree"},
    "glass": {"reflection", "nest"},
    "what is seen through": {"reflection", "opacity", "tree"},
    "all of few samples": {*LISTED, "tree", "nest", "split", "background", "round"},
    "capsules": {"tree", "capsules", "reflection"},
    "faces": {"tree", "faces", "reflection"},
    "meshes": {"tree", "faces", "smooth", "gouraud", "corner_colors", "sphere_colors", "opacity"},
    "at random": {
        *LISTED,
        "gather",
        "tree",
        "capsules",
        "faces",
        "smooth",
        "round",
        "lens",
        "occlusion",
        "gloss",
        "indirect",
    },
}


@pytest.mark.parametrize("name", SOME)
def test_what_is_for_a_feature_is_in_no_program_without_it(device: cl.Device, name: str) -> None:
    """A heading begins with the features that a function is for, joined by `and` or `or`. Told to
    optimise nothing, the compiler keeps the names of the functions that a program needs."""
    if "Portable Computing Language" not in device.platform.name:
        pytest.skip("says nothing of the functions that are in a binary")
    features = Features(4, "robust", "float", **dict.fromkeys(SOME[name], True))
    used = {k[2:]: v != "0" for k, v in (option.split("=") for option in features.options)}
    used["RANDOM"] = bool({"lens", "occlusion", "gloss", "indirect"} & SOME[name])
    used["RANDOM"] |= "round" in SOME[name] and bool({"capsules", "faces"} & SOME[name])
    source = program.kernel_source()
    needs = {
        function: bool(eval(asks[1], {}, used))
        for function, heading in headings(source).items()
        if (asks := re.match(r" ([A-Z_]+(?: (?:and|or) [A-Z_]+)*): ", heading))
    }
    # By names that are no part of another.
    renamed = [f"#define {name}(...) is_{name}_there(__VA_ARGS__)\n" for name in needs]
    built = cl.Program(cl.Context([device]), "".join(renamed) + source)
    (binary,) = built.build(options=[*features.options, "-cl-opt-disable"]).binaries
    found = {function for function in needs if f"is_{function}_there".encode() in binary}
    assert not {function for function in found if not needs[function]}
    assert not SOME[name] or found

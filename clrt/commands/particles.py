"""Options of commands that draw particles: how these are read, and how they are drawn."""

import re
from typing import Any

import click

from clrt.commands.groups import CLIM_WORDS, SOLID, group
from clrt.errors import RequestError


def _by_kind(context: click.Context, option: click.Parameter, text: str | None) -> Any:
    """One value for all, or A=X,B=Y; commas in brackets part nothing."""
    if text is None or "=" not in text:
        return text
    pairs = re.findall(r"([^=]+)=((?:[^,(]|\([^)]*\))*)(?:,|$)", text)
    if "".join(f"{key}={value}," for key, value in pairs).rstrip(",") != text.rstrip(","):
        raise click.BadParameter(f"expected A=X,B=Y, got {text!r}")
    return {key.strip(): value.strip() for key, value in pairs}


def _radius(context: click.Context, option: click.Parameter, text: str | None) -> Any:
    found = _by_kind(context, option, text)
    try:
        if isinstance(found, dict):
            return {key: float(value) for key, value in found.items()}
        return None if found is None else float(found)
    except ValueError:
        expected = "a number, or numbers of types, elements or names, as Na=1.0,Cl=1.8"
        raise click.BadParameter(f"expected {expected}, got {text!r}") from None


def _bonds(context: click.Context, option: click.Parameter, text: str | None) -> Any:
    from clrt.particles.particlefile import BONDS

    if text is None or text in BONDS:
        return text
    try:
        return float(text)
    except ValueError:
        expected = f"{', '.join(BONDS)} or a distance"
        raise click.BadParameter(f"expected {expected}, got {text!r}") from None


def _clim(context: click.Context, option: click.Parameter, words: Any) -> Any:
    """--clim LO HI, or a word, which Grouped gives twice."""
    if words is None or words[0] in CLIM_WORDS:
        return words and words[0]
    try:
        return tuple(map(float, words))
    except ValueError:
        raise click.BadParameter(f"expected LO HI, first or all, got {' '.join(words)!r}") from None


def _scalebar(context: click.Context, option: click.Parameter, words: Any) -> Any:
    """--scalebar X LABEL, or auto, which Grouped gives twice."""
    if words is None or words[0] == "auto":
        return words and words[0]
    try:
        return float(words[0]), words[1]
    except ValueError:
        expected = "X LABEL, as 10 '10 nm', or auto"
        raise click.BadParameter(f"expected {expected}, got {' '.join(words)!r}") from None


PARTICLE_OPTIONS = (
    click.option("--select", metavar="EXPR", help="Only these, as 'x > 0 and chain == \"A\"'."),
    click.option("--hide", metavar="EXPR", help="Not these, as water."),
    click.option("--wrap", is_flag=True, help="Move particles into their box."),
    click.option(
        "--replicate", type=int, nargs=3, metavar="NX NY NZ", help="Images along the box's edges."
    ),
    click.option(
        "--color",
        metavar="EXPR",
        help="file, element, type, material, or columns, as speed or 'x**2 + y**2'; default: the "
        "first of file, element and type that there is, else steel blue.",
    ),
    click.option(
        "--colors",
        metavar="A=COLOR,...",
        callback=_by_kind,
        help="Of types, elements, names or texts, as Na=red,Cl=#0a0; or of all.",
    ),
    click.option("--cmap", metavar="NAME", help="Colour map of numbers; default: viridis."),
    click.option(
        "--clim",
        nargs=2,
        metavar="LO HI",
        callback=_clim,
        help="What the map's ends stand for, or of a trajectory: first, all. Default: the range, "
        "of ten frames.",
    ),
    click.option(
        "--colorbar", metavar="LABEL", help="Draw a colour bar, or a legend of kinds; '': none."
    ),
    click.option(
        "--colorbar-side", metavar="NAME", help="Where the bar is: right or bottom; default: right."
    ),
    click.option("--title", metavar="TEXT", help="Above the picture."),
    click.option(
        "--label",
        metavar="TEXT",
        help="In the upper left corner, with fields as '{frame:03d}': frame, time, step, and "
        "columns of one value.",
    ),
    click.option(
        "--labels", metavar="EXPR", help="A column that is written at each particle that is seen."
    ),
    click.option(
        "--scalebar",
        nargs=2,
        metavar="X LABEL",
        callback=_scalebar,
        help="A line of a length, as 10 '10 nm'; or auto.",
    ),
    click.option(
        "--axes",
        is_flag=False,
        flag_value="xyz",
        metavar="[xyz|abc]",
        help="Which way the axes go, or the box's edges.",
    ),
    click.option(
        "--font-size",
        metavar="X|PT/WIDTH",
        help="Of text: a part of the picture's smaller side, or points on a page, as 8pt/85mm; "
        "default: 1/36 of it.",
    ),
    click.option(
        "--line-width", metavar="X|PT/WIDTH", help="Of the box's edges; default: 1/540 of it."
    ),
    click.option(
        "--radius",
        metavar="X|A=X,...",
        callback=_radius,
        help="Of all, or of types, elements, names, as Na=1.0,Cl=1.8; default: the file's, the "
        "elements' van der Waals radii, or by the distance of neighbours.",
    ),
    click.option("--scale", type=float, metavar="X", help="Of all radii; default: 1."),
    click.option(
        "--opacity",
        metavar="EXPR",
        help="From 0 to 1, a number or columns, as '0.2 + 0.8 * (type == 1)'; default: the file's, "
        "else 1.",
    ),
    click.option("--style", metavar="NAME", help="See 'clrt styles'; default: soft."),
    click.option(
        "--cell", is_flag=True, help="Draw the edges of the box; --cell solid: with shadows."
    ),
    click.option(SOLID, "is_solid", is_flag=True, hidden=True),
    click.option(
        "--bonds",
        metavar="file|auto|X",
        callback=_bonds,
        help="The file's; auto: by covalent radii; X: of all that are nearer; none. Default: the "
        "file's, or else auto, of the style ball-and-stick.",
    ),
    click.option(
        "--bond-radius",
        type=float,
        metavar="X",
        help="Default: 0.15 ångströms, or 0.3 of the least radius where the unit is unknown.",
    ),
    click.option(
        "--bond-color", metavar="atoms|COLOR", help="Default: atoms, each half that of its atom."
    ),
    click.option(
        "--vectors", metavar="NAME", help="Arrows at the particles: v of columns vx, vy, vz."
    ),
    click.option(
        "--vector-scale",
        type=float,
        metavar="X",
        help="How long arrows are; default: their mean is twice the median radius.",
    ),
    click.option("--vector-color", metavar="atoms|COLOR", help="Default: atoms."),
    click.option(
        "--mesh", metavar="FILE", help="A .ply, .stl or .obj that is drawn beside the particles."
    ),
    click.option(
        "--mesh-color",
        metavar="COLOR|NAME",
        help="Or numbers of its vertices or faces; default: the file's, else gray or steel blue.",
    ),
    click.option("--mesh-opacity", type=float, metavar="X", help="From 0 to 1; default: 1."),
    click.option(
        "--view",
        metavar="NAME|X,Y,Z",
        help="Where the camera stands: corner, iso, x, -x, y, -y, z, -z, or three numbers; "
        "default: corner, of flat data z.",
    ),
    click.option("--up", metavar="NAME|X,Y,Z", help="What is up in the picture; default: z."),
    click.option("--zoom", type=float, metavar="X", help="Default: 1, which holds all."),
    click.option("--center", metavar="X,Y,Z", help="The picture's middle; default: that of all."),
    click.option(
        "--projection", metavar="NAME", help="orthographic or perspective; default: orthographic."
    ),
    click.option(
        "--margin",
        type=float,
        metavar="X",
        help="The part that stays free at each side; default: 0.03.",
    ),
)


def _drawn(is_solid: bool, **given: Any) -> dict[str, Any]:
    return given | {"cell": "solid" if is_solid else given["cell"]}


particle_options = group("drawn", _drawn, PARTICLE_OPTIONS)
"""How particles are drawn: fields of clrt.figure.Look."""

PARTICLE_KEYS = {
    key: f"--{key.replace('_', '-')}"
    for key in (
        *("select", "hide", "wrap", "replicate", "color", "colors", "cmap", "clim", "colorbar"),
        *("radius", "scale", "opacity", "style", "cell", "view", "up", "zoom", "center"),
        *("projection", "bonds", "bond_radius", "bond_color"),
        *("vectors", "vector_scale", "vector_color"),
        *("mesh", "mesh_color", "mesh_opacity"),
        *("margin", "background", "samples", "altloc", "assembly"),
        *("title", "label", "labels", "scalebar", "axes"),
    )
} | {"colorbar_side": "--colorbar-side", "font_size": "--font-size", "line_width": "--line-width"}
"""What a key of a Look is called on the command line."""


READING_OPTIONS = (
    click.option(
        "--format",
        metavar="NAME",
        help="Of files of particles whose names do not tell: npz, npy, csv, ply, xyz, dump, data, "
        "pdb, cif, gsd, gro, poscar or vtk.",
    ),
    click.option(
        "--altloc",
        metavar="NAME",
        help="Of an atom's alternate locations in .pdb and .cif: most, the most occupied, or all; "
        "default: most.",
    ),
    click.option(
        "--assembly",
        metavar="NAME",
        help="A biological assembly that a .pdb or .cif has, as 1; default: the atoms listed.",
    ),
)


def _reading(**given: str | None) -> dict[str, str]:
    return {key: text for key, text in given.items() if text is not None}


reading_options = group("reading", _reading, READING_OPTIONS)
"""How files of particles are read, where it is said: arguments of clrt.read()."""


def only_for_particles(scene: str, **given: Any) -> None:
    """Finds out whether one of these was given with a scene.

    Raises:
        RequestError: it was.
    """
    for name, value in given.items():
        if value is not None and value is not False and value != ():
            option = name.replace("_", "-")
            raise RequestError(f"--{option}: expected a file of particles, {scene} is a scene")

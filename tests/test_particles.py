"""Particles: checked once, and made of columns by their names."""

import pickle
import warnings
from typing import Any

import numpy as np
import pytest
from conftest import same

import clrt
from clrt.files.particles.columns import distinct, particles

FOUR = np.arange(12.0).reshape(4, 3)


def test_what_nobody_can_change_is_not_copied() -> None:
    mine, given = FOUR.copy(), FOUR.astype(np.float32)
    mine.flags.writeable = False
    assert clrt.Particles(mine).positions is mine
    kept = clrt.Particles(given, radii=1, values={"speed": given[:, 0]})
    given[:] = -1
    assert (kept.positions == FOUR).all()
    assert kept.positions.dtype == np.float32
    assert (kept.values["speed"] == FOUR[:, 0]).all()
    for array in (kept.positions, kept.radii, kept.values["speed"], kept.origin):
        assert array is not None
        assert not array.flags.writeable


def test_kinds_of_numbers() -> None:
    found = clrt.Particles(
        FOUR.astype(">f4"),
        radii=[1, 2, 3, 4],
        colors=np.full((4, 3), 200),
        elements=[1.0, 6, 0, 118],
        types=np.array([1, 2, 3, 2**31 - 1], np.uint64),
        values={"id": np.arange(4), "broken": np.array([True, False, True, True])},
        cell=np.eye(3, dtype=int),
    )
    kinds = (found.positions, found.radii, found.colors, found.elements, found.types, found.cell)
    assert [np.asarray(array).dtype for array in kinds] == ["=f4", "=f8", "u1", "u1", "=i4", "=f8"]
    assert len(found) == 4
    assert repr(found) == "Particles(n=4, columns=['id', 'broken'])"
    assert same(clrt.Particles(np.zeros((0, 3)), radii=2.0).radii, np.zeros(0))
    assert (pickle.loads(pickle.dumps(found)).positions == found.positions).all()


def test_text_and_bonds() -> None:
    found = clrt.Particles(
        FOUR,
        texts={
            "chain": ["A", "A", "B", ""],
            "residue": np.array([b"ALA", b"GLY", b"\xc3\x85", b"Z"]),
        },
        bonds=[(0, 1), (1, 3), (2, 3)],
        unit="nm",
    )
    assert found.texts["residue"].tolist() == ["ALA", "GLY", "Å", "Z"]
    assert found.bonds is not None
    assert found.bonds.dtype == np.int32
    part = found.where([False, True, True, True])
    assert part.texts["chain"].tolist() == ["A", "B", ""]
    assert same(part.bonds, np.array([[0, 2], [1, 2]], np.int32))
    assert part.unit == "nm"
    assert clrt.Particles(FOUR, bonds=[]).bonds.shape == (0, 2)  # type: ignore[union-attr]
    objects = np.array(["a", "bc", "", "d"], object)
    assert clrt.Particles(FOUR, texts={"name": objects}).texts["name"].tolist() == objects.tolist()
    for array in (found.bonds, *found.texts.values()):
        assert not array.flags.writeable


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"positions": FOUR[:, :1]}, "positions: expected numbers of shape (n, 3), got float64 of"),
        ({"positions": "x"}, "positions: expected numbers of shape (n, 3), got array('x'"),
        ({"positions": [[0, 0, np.nan]]}, "positions[0]: expected finite numbers, got [0.0, 0.0, "),
        ({"radii": [1, 2, 0, 4]}, "radii[2]: expected a finite number above 0, got 0.0"),
        ({"radii": [1, 2, 3]}, "radii: expected 4 of them, as positions, got (3,)"),
        ({"radii": [1, np.inf, 3, 4]}, "radii[1]: expected a finite number, got inf"),
        ({"radii": -1}, "radii: expected a finite number above 0, got -1.0"),
        ({"colors": np.full((4, 3), 1.5)}, "colors[0]: expected sRGB from 0 to 1, got [1.5,"),
        ({"colors": np.full((4, 3), 256)}, "colors[0]: expected sRGB from 0 to 255, got [256,"),
        ({"colors": np.zeros((4, 4), np.uint8)}, "colors: expected numbers of shape (n, 3), got u"),
        ({"colors": np.zeros((3, 3), np.uint8)}, "colors: expected 4 of them, as positions, got ("),
        ({"elements": [1, 2, 3, 119]}, "elements[3]: expected an atomic number from 0 to 118, got"),
        ({"elements": [1, 2, 3.5, 1]}, "elements[2]: expected an atomic number from 0 to 118, got"),
        ({"elements": ["H"] * 4}, "elements: expected whole numbers, got <U1 of (4,)"),
        ({"types": [1, 2, np.nan, 1]}, "types[2]: expected a whole number, got nan"),
        ({"types": [0, 1, 2, 0], "type_names": ("A", "B")}, "types[2]: expected one that has a na"),
        ({"values": {"v": np.zeros((4, 3))}}, "v: expected numbers (n,), got float64 of (4, 3)"),
        ({"values": {"v": ["a"] * 4}}, "v: expected numbers (n,), got ['a', 'a', 'a', 'a']"),
        ({"values": {"v": [1, 2]}}, "v: expected 4 of them, as positions, got (2,)"),
        ({"cell": [1, 2, 3]}, "cell: expected finite numbers of shape (3, 3), got [1, 2, 3]"),
        ({"cell": np.full((3, 3), np.inf)}, "cell: expected finite numbers of shape (3, 3), got f"),
        ({"texts": {"name": ["a"]}}, "name: expected 4 of them, as positions, got (1,)"),
        ({"texts": {"name": [1, 2, 3, 4]}}, "name: expected text (n,), got [1, 2, 3, 4]"),
        ({"texts": {"v": ["a"] * 4}, "values": {"v": [1] * 4}}, "v: expected either numbers or te"),
        ({"bonds": [0, 1]}, "bonds: expected whole numbers of shape (m, 2), got [0, 1]"),
        ({"bonds": [[0, 1.5]]}, "bonds: expected whole numbers of shape (m, 2), got [[0, 1.5]]"),
        ({"bonds": [[0, 1], [3, 4]]}, "bonds[1]: expected indices of particles from 0 to 3, got ["),
        ({"bonds": [[0, 1], [-1, 2]]}, "bonds[1]: expected indices of particles from 0 to 3, got"),
        ({"bonds": [[2, 2]]}, "bonds[0]: expected two different particles, got [2, 2]"),
        ({"unit": ""}, "unit: expected the name of a unit of length, got ''"),
        ({"origin": "here"}, "origin: expected finite numbers of shape (3,), got 'here'"),
    ],
)
def test_wrong_values_are_named(change: dict[str, Any], said: str) -> None:
    with pytest.raises(clrt.SceneError) as caught:
        clrt.Particles(**{"positions": FOUR, **change})
    assert str(caught.value).startswith(said)
    assert "\n" not in str(caught.value)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_column() -> None:
    found = clrt.Particles(FOUR, radii=2, values={"speed": [1, 2, 3, 4]})
    assert (found.column("z") == FOUR[:, 2]).all()
    assert (found.column("radius") == 2).all()
    assert (found.column("speed") == [1, 2, 3, 4]).all()
    with pytest.raises(clrt.RequestError) as caught:
        found.column("spede")
    there = "'speed', 'x', 'y', 'z', 'radius', 'index'"
    expected = f"expected a column that there is ({there}), got 'spede'; did you mean 'speed'?"
    assert str(caught.value) == expected


def made(**columns: Any) -> clrt.Particles:
    return particles({name: np.asarray(given) for name, given in columns.items()}, "a")


XYZ = {"x": [0.0, 1], "y": [2.0, 3], "z": [4.0, 5]}
GRAY: dict[str, Any] = {"colors": [[0.5, 0.5, 0.5]] * 2}


def test_names_of_columns() -> None:
    for columns in (XYZ, {"X": XYZ["x"], "Y": XYZ["y"], "Z": XYZ["z"]}):
        assert (made(**columns).positions == [[0, 2, 4], [1, 3, 5]]).all()
    for name in ("positions", "position", "pos", "xyz", "Position"):
        assert len(made(**{name: FOUR})) == 4
    assert same(made(**XYZ, radius=[1, 2]).radii, [1, 2])
    assert same(made(**XYZ, r=3).radii, 3)
    assert same(made(**XYZ, Diameter=[1, 2]).radii, [0.5, 1])
    # r, g and b are colours together, and r alone is a radius.
    found = made(**XYZ, r=[0, 255], g=[1, 2], b=[3, 4], radius=[1, 2])
    assert same(found.colors, [[0, 1, 3], [255, 2, 4]])
    assert found.colors is not None
    assert found.colors.dtype == np.uint8
    found = made(**XYZ, red=[0.5, 1], green=[0, 0], blue=[0, 0])
    assert same(found.colors, np.array([[0.5, 0, 0], [1, 0, 0]]))
    assert made(**XYZ, color=[1.0, 2.0], name=[3, 4]).values.keys() == {"color", "name"}
    found = made(**XYZ, Temperature=[1, 2], ID=[7, 8])
    assert found.values.keys() == {"Temperature", "ID"}
    assert found.radii is None
    assert found.colors is None


def test_colours_by_other_names() -> None:
    expected = np.array([[1, 0, 0], [0, 0.5, 0]])
    for name in ("ColorR ColorG ColorB", "RGB:0 RGB:1 RGB:2", "color.r color.g color.b"):
        parts = dict(zip(name.split(), expected.T, strict=True))
        found = made(**XYZ, **parts)
        assert same(found.colors, expected)
        assert found.values == {}


def test_colours_of_16_bits_and_floats_to_255() -> None:
    wide = np.array([[0, 65535, 257], [1, 2, 3]], np.uint16)
    assert np.allclose(made(**XYZ, colors=wide).colors, wide / 65535, atol=1e-7)  # type: ignore[arg-type]
    assert same(made(**XYZ, colors=wide % 256).colors, wide % 256)
    halves = np.array([[0, 127.5, 255], [0.25, 1, 2]])
    assert same(made(**XYZ, colors=halves).colors, halves / 255)
    wide = np.array([[0, 65535, 257.0], [1, 2, 3]])
    assert np.allclose(made(**XYZ, colors=wide).colors, wide / 65535, atol=1e-7)  # type: ignore[arg-type]


def test_floats_that_are_bytes() -> None:
    def colors(*red: float) -> np.ndarray:
        return np.asarray(made(**XYZ, red=red, green=[0.0, 0.0], blue=[0.0, 0.0]).colors)

    assert colors(0.0, 255.0).dtype == np.uint8
    assert colors(0.0, 1.0).dtype == np.float64
    for wrong in (256.0, 1.5, np.nan, -1.0, np.inf):
        with pytest.raises(clrt.SceneError, match=r"colors\[1\]: expected"):
            colors(0.0, wrong)


@pytest.mark.parametrize(
    ("columns", "numbers", "types", "names"),
    [
        ({"numbers": [6, 1]}, [6, 1], None, None),
        ({"species": ["C", "h"]}, [6, 1], None, None),
        ({"elements": np.array([b"Cl", b"NA"])}, [17, 11], None, None),
        ({"species": ["B", "A"]}, None, [1, 0], ("A", "B")),
        ({"species": ["C", "C12"]}, [6, 6], None, None),
        ({"element": ["A", "B"], "type": [5, 6]}, None, [5, 6], None),
        ({"type": [1, 2]}, None, [1, 2], None),
        ({"type": ["O", "H"]}, [8, 1], [1, 0], ("H", "O")),
        ({"type": ["Å", "many_letters"]}, None, [1, 0], ("many_letters", "Å")),
        ({"name": ["CA", "OW"]}, [6, 8], None, None),
        ({"name": ["bead", "W1"]}, None, [1, 0], ("W1", "bead")),
        ({"mass": [12.011, 1.008]}, [6, 1], None, None),
        ({"mass": [1.0, 1.0]}, None, None, None),
        ({"mass": [12.0, 15.035], "name": ["CA", "CB"]}, [6, 6], None, None),
        ({"numbers": [8, 8], "mass": [12.011, 1.008]}, [8, 8], None, None),
    ],
)  # fmt: skip
def test_elements_and_types(
    columns: dict[str, Any],
    numbers: list[int] | None,
    types: list[int] | None,
    names: tuple[str, ...] | None,
) -> None:
    found = made(**XYZ, **columns)
    assert (found.elements is None) == (numbers is None)
    assert numbers is None or same(found.elements, numbers)
    assert (found.types is None) == (types is None)
    assert types is None or same(found.types, types)
    assert found.type_names == names
    assert found.values.keys() == columns.keys() & {"mass"}


def test_distinct_names_are_in_order() -> None:
    random = np.random.default_rng(1)
    for names in (["C", "Ca", "H", "", "12345678"], ["a", "Zz", "b" * 40], ["é", "e"]):
        which = random.integers(0, len(names), 500)
        for array in (np.array(names)[which], np.char.encode(np.array(names), "utf-8")[which]):
            kinds, index = distinct(array)
            assert np.char.encode(kinds).tolist() == sorted(name.encode() for name in names)
            assert [kinds[i] for i in index] == [names[i] for i in which]


def warned(**columns: Any) -> tuple[clrt.Particles, list[str]]:
    """Particles of columns, and what is said of them."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = made(**columns)
    assert all(warning.category is clrt.ParticleWarning for warning in caught)
    return found, [str(warning.message).removeprefix("a: ") for warning in caught]


def test_what_has_no_meaning_is_a_column_or_named() -> None:
    found, said = warned(
        **XYZ,
        label=["a", "b"],
        residue=np.array(["ALA", "Å"], object),
        forces=np.arange(6.0).reshape(2, 3),
        tags=np.arange(4).reshape(2, 2),
        time=1.0,
        faces=[[0, 1, 2]],
    )
    assert found.texts["label"].tolist() == ["a", "b"]
    assert found.texts["residue"].tolist() == ["ALA", "Å"]
    assert list(found.values) == ["forces_x", "forces_y", "forces_z", "tags_1", "tags_2"]
    assert found.values["forces_z"].tolist() == [2, 5]
    expected = "is not used, expected numbers or text of shape (2,)"
    assert said == [f"time: {expected}", f"faces: {expected}"]


NAN, INF = np.nan, np.inf


@pytest.mark.parametrize(
    ("columns", "left", "said"),
    [
        ({"x": [0, NAN, 2, 3]}, [0, 2, 3], ["1 of 4 particles are left out: no finite position"]),
        ({"x": [0, 1, -INF, INF]}, [0, 1], ["2 of 4 particles are left out: no finite position"]),
        ({"radius": [1, 0, 2, 0]}, [0, 2], ["2 of 4 particles are left out: radius 0"]),
        ({"diameter": [1, NAN, 2, INF]}, [0, 2], ["2 of 4 particles are left out: no finite radi"]),
        (
            {"x": [NAN, 1, 2, 3], "radius": [0, 0, NAN, 1]},
            [3],
            ["1 of 4 particles are left out: no f", "1 of 4 particles are left out: radius 0",
             "1 of 4 particles are left out: no finite radius"],
        ),
        ({"v": [NAN, 1, 2, 3]}, [0, 1, 2, 3], []),
    ],
)  # fmt: skip
def test_what_cannot_be_drawn_is_left_out_and_counted(
    columns: dict[str, Any], left: list[int], said: list[str]
) -> None:
    four = {axis: np.arange(4.0) for axis in "xyz"} | {"id": np.arange(4), "name": list("HCNO")}
    found, lines = warned(**four | columns)
    assert found.values["id"].tolist() == left
    assert found.texts["name"].tolist() == ["HCNO"[i] for i in left]
    assert same(found.elements, np.array([1, 6, 7, 8])[left])
    assert len(lines) == len(said)
    assert all(line.startswith(start) for line, start in zip(lines, said, strict=True))


def test_an_error_names_the_line_of_its_row_whatever_is_left_out() -> None:
    columns = {"positions": np.array([[NAN] * 3, [1, 1, 1], [2, 2, 2]])}
    columns["radius"] = np.array([1.0, 1, -1])
    said = "a: line 12: radii: expected a finite number above 0, got -1.0"
    with pytest.raises(clrt.SceneError, match=said), pytest.warns(clrt.ParticleWarning):
        particles(columns, "a", line_of=lambda row: 10 + row)


def test_bonds_of_what_is_left_out_go_with_it() -> None:
    columns = {"positions": np.array([[0, 0, 0], [NAN, 0, 0], [1, 0, 0], [2.0, 0, 0]])}
    with pytest.warns(clrt.ParticleWarning):
        found = particles(columns, "a", bonds=[(0, 1), (2, 3), (0, 2)], unit="nm")
    assert same(found.bonds, [[1, 2], [0, 1]])
    assert found.unit == "nm"


def test_places_that_several_have() -> None:
    random = np.random.default_rng(5)
    for n in (300, 200_000):
        at = random.normal(size=(n, 3))
        assert warned(positions=at)[1] == []
        few, many = at.copy(), at.copy()
        few[: n // 200] = at[-1]
        many[: n // 10] = at[n // 2 : n // 2 + n // 10]
        assert warned(positions=few)[1] == []
        (said,) = warned(positions=many)[1]
        share = "30 of" if n == 300 else "about 10% of"
        assert said.startswith(f"{share} {n} particles are at the place of another")
    # A grid, whose x has few values, and one that is flat.
    for shape in ((40, 40, 40), (1, 250, 200)):
        grid = np.stack(np.meshgrid(*map(np.arange, shape)), axis=-1).reshape(-1, 3).astype(float)
        assert warned(positions=grid)[1] == []
        (said,) = warned(positions=np.concatenate([grid, grid[::20]]))[1]
        assert said.startswith("about 5% of ")
    assert warned(positions=np.ones((3, 3)))[1] == ["all 3 particles are at one place"]
    assert warned(positions=[[0.0, 0, 0], [-0.0, 0, 0]])[1] == ["all 2 particles are at one place"]
    assert warned(positions=np.ones((1, 3)))[1] == []
    assert warned(positions=[[1, 2, 3], [1, 3, 2], [2, 1, 3]])[1] == []


def test_no_z() -> None:
    flat = {"x": [1.0, 2], "y": [3.0, 4]}
    for columns in (flat, {"pos": FOUR[:2, :2]}, {"Points_0": [1, 2], "Points_1": [3, 4]}):
        found = made(**columns)
        assert found.positions.shape == (2, 3)
        assert (found.positions[:, 2] == 0).all()
    given = np.array([[1, 2], [3, 4]], np.float32)
    assert same(clrt.Particles(given).positions, np.array([[1, 2, 0], [3, 4, 0]], np.float32))


@pytest.mark.parametrize("names", ["Points:{0}", "Points_{0}", "position.{x}", "pos_{x}", "Pos{X}",
                                   "center_{x}", "Coord[{1}]", "{X} (nm)", "{x}[Å]"])  # fmt: skip
def test_other_names_of_positions(names: str) -> None:
    parts = [{"0": str(i), "1": str(i + 1), "x": "xyz"[i], "X": "XYZ"[i]} for i in range(3)]
    for part in parts:
        part |= {"{0}": part["0"]}
    headers = [
        names.replace("{0}", p["0"]).replace("{1}", p["1"]).replace("{x}", p["x"]).replace(
            "{X}", p["X"])
        for p in parts
    ]  # fmt: skip
    found = made(**{name: FOUR[:, i] for i, name in enumerate(headers)}, v=[1, 2, 3, 4])
    assert (found.positions == FOUR).all()
    assert list(found.values) == ["v"]
    assert found.unit == {"{X} (nm)": "nm", "{x}[Å]": "angstrom"}.get(names)


def test_a_radius_in_another_unit() -> None:
    names = {"X (m)": [1, 2], "Y (m)": [1, 2], "Z (m)": [1, 2]}
    found = made(**names, **{"Radius (mm)": [1, 2], "T (K)": [3, 4], "d (m)": [5, 6]})
    assert np.allclose(found.radii, [1e-3, 2e-3], rtol=1e-15)  # type: ignore[arg-type]
    assert found.unit == "m"
    assert list(found.values) == ["T (K)", "d (m)"]
    assert same(made(**names, **{"Diameter (cm)": [1, 2]}).radii, [0.005, 0.01])
    assert same(made(**XYZ, **{"radius (nm)": [1, 2]}).radii, [1, 2])


def test_r_that_is_no_radius() -> None:
    at = {"x": [3.0, 1, 0], "y": [4.0, 1, 2], "z": [0.0, 1, 0]}
    found, said = warned(**at, r=[1, 2, 3], theta=[0, 0, 0], phi=[1, 2, 3])
    assert found.radii is None
    assert list(found.values) == ["r", "theta", "phi"]
    assert said == ["r: is no radius beside theta: it is a column"]
    for distance in ([5, 1.732, 2], [5.0, 1.4142, 2]):
        found, said = warned(**at, r=distance)
        assert found.radii is None
        assert said == ["r: is the distance from the origin: it is a column, no radius"]
    assert same(made(**at, r=[5, 1, 2]).radii, [5, 1, 2])
    assert same(made(**at, r=[5, 5, 5]).radii, [5, 5, 5])
    found = made(**at, r=[1, 2, 3], radius=[2, 2, 2], theta=[0, 0, 0])
    assert same(found.radii, [2, 2, 2])


@pytest.mark.parametrize(
    ("columns", "opacities", "said"),
    [
        ({"alpha": [255, 255], **GRAY}, None, []),
        ({"opacity": [1.0, 1.0]}, None, []),
        ({"Transparency": [0, 0]}, None, []),
        ({"alpha": [255, 0], **GRAY}, [1, 0], []),
        ({"alpha": np.array([65535, 0], np.uint16), **GRAY}, [1, 0], []),
        ({"Opacity": [0.5, 0.25]}, [0.5, 0.25], []),
        ({"Transparency": [0.25, 0.0]}, [0.75, 1], []),
        ({"color": [[0, 0, 0, 0.5], [0, 0, 0, 1]]}, [0.5, 1], []),
        ({"alpha": [0, 1]}, None, ["alpha: is a column, no opacity beside no colours: not drawn"]),
        (
            {"opacity": [0.5, 7.1]},
            None,
            ["opacity: is a column, no opacity from 0 to 1: not drawn"],
        ),
        (
            {"opacity": [0.5, np.nan]},
            None,
            ["opacity: is a column, no opacity from 0 to 1: not drawn"],
        ),
        (
            {"alpha": [0, 0], **GRAY},
            None,
            ["alpha: says that no particle is seen: all are drawn opaque"],
        ),
    ],
)
def test_opacity(columns: dict[str, Any], opacities: Any, said: list[str]) -> None:
    found, lines = warned(**XYZ, **columns)
    assert len(found.values) == 1
    assert [line[:50] for line in lines] == [line[:50] for line in said]
    assert (found.opacities is None) == (opacities is None)
    if opacities is not None:
        assert same(found.opacities, opacities)
        assert same(found.column("opacity"), opacities)
        assert same(found.where([False, True]).opacities, opacities[1:])


def test_ellipsoids_are_the_spheres_around_them() -> None:
    shape = {"shapex": [1.0, 4], "shapey": [2.0, 1], "shapez": [1.0, 1]}
    found, said = warned(**XYZ, **shape)
    assert same(found.radii, [1, 2])
    assert said == ["shapex shapey shapez: are drawn as the spheres around them"]
    assert list(found.values) == list(shape)
    halves = {f"AsphericalShape{axis[-1].upper()}": column for axis, column in shape.items()}
    assert same(warned(**XYZ, **halves)[0].radii, [2, 4])
    assert warned(**XYZ, **shape, radius=[1, 1])[1] == []


def test_no_positions() -> None:
    with pytest.raises(clrt.SceneError, match=r"^a: expected columns x, y and z or positions \(n"):
        made(x=[1], z=[2])
    with pytest.raises(clrt.SceneError, match="got 'positions'"):
        made(positions=[1, 2, 3])


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ({"x": ["a", "b"]}, "a: positions: expected numbers of shape (n, 3), got"),
        ({"diameter": ["a", "b"]}, "a: radii: expected numbers of shape (n,) or one number, got"),
        ({"radius": [1, 2, 3]}, "a: radii: expected 2 of them, as positions, got (3,)"),
        ({"species": ["H"] * 3}, "a: elements: expected 2 of them, as positions, got (3,)"),
        ({"type": ["A"] * 3}, "a: types: expected 2 of them, as positions, got (3,)"),
        ({"type": [[1, 2], [3, 4]]}, "a: types: expected whole numbers, got int64 of (2, 2)"),
        ({"type": [1, 1.5]}, "a: types[1]: expected a whole number, got 1.5"),
    ],
)
def test_columns_that_do_not_fit(columns: dict[str, Any], said: str) -> None:
    with pytest.raises(clrt.SceneError) as caught:
        made(**{**XYZ, **columns})
    assert str(caught.value).startswith(said)


def test_types_without_a_name() -> None:
    columns = {"pos": FOUR[:2], "type": np.array([0, 2])}
    with pytest.raises(
        clrt.SceneError, match=r"a: types\[1\]: expected one that has a name, got 2"
    ):
        particles(columns, "a", type_names=("C", "H"))

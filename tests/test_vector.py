"""SVG and PDF: words are words, the picture is the pixels without them."""

import base64
import io
import re
import zlib
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

import clrt
from clrt.commands.cli import main
from clrt.figure.apart import picture_and_words

pytest.importorskip("matplotlib")

SIZE = 240, 135
FILM = clrt.Film(
    background=(1, 1, 1),
    transfer="srgb",
    title="Φ = 0.25 ± 0.01 & more",
    label="t = {time:.1f} ps",
    labels=[clrt.Label("Å1", (0.0, 0.0, -1.0), 9.0), clrt.Label("hidden", (0.0, 0.0, -99.0))],
    colorbar="v $v_x$",
    colorbar_clim=(0.0, 1.0),
    colorbar_ends=(True, True),
    axes="xyz",
)


@pytest.fixture(scope="module")
def scene() -> clrt.Scene:
    from msgspec.structs import replace

    from clrt.figure.resolver import resolved

    return resolved(replace(clrt.load_scene("four-spheres"), film=FILM))


@pytest.fixture(scope="module")
def drawn(scene: clrt.Scene):
    return picture_and_words(clrt.Renderer(), scene, *SIZE)


def test_svg(scene: clrt.Scene, drawn, tmp_path: Path) -> None:
    image, overlay = drawn
    for name in ("a.svg", "b.svg"):
        clrt.save(tmp_path / name, image, transfer="srgb", overlay=overlay)
    text = (tmp_path / "a.svg").read_text()
    assert text == (tmp_path / "b.svg").read_text()
    said = [re.sub("<[^>]*>", "", one) for one in re.findall(r"<text.*?</text>", text, re.DOTALL)]
    assert {"Φ = 0.25 ± 0.01 &amp; more", "t = 0.0 ps", "Å1", "0.0", "x", "y", "z"} <= set(said)
    assert "hidden" not in said
    (data,) = re.findall(r'xlink:href="data:image/png;base64,([^"]+)"', text)
    inside = np.asarray(Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB"))
    assert (inside == image).all()
    bare = clrt.Film(background=(1, 1, 1), transfer="srgb")
    from msgspec.structs import replace

    assert (image == clrt.render(replace(scene, film=bare), *SIZE, dtype="uint8")).all()
    # An em, 7 pixels here, is 8 points.
    (size,) = re.findall(r'<svg[^>]*?width="([\d.]+)pt" height="([\d.]+)pt"', text)
    wide, high = map(float, size)
    assert (wide, high) == pytest.approx((SIZE[0] * 8 / 7, SIZE[1] * 8 / 7), rel=1e-3)
    # The middle of the map, as of the picture.
    assert "#21918c" in text or "#20928c" in text


def test_pdf(drawn, tmp_path: Path) -> None:
    image, overlay = drawn
    clrt.save(tmp_path / "a.pdf", image, transfer="srgb", overlay=overlay)
    data = (tmp_path / "a.pdf").read_bytes()
    assert data.startswith(b"%PDF")
    assert b"/FontFile2" in data  # the font is inside
    pattern = re.compile(rb"/FlateDecode[^>]*>>\s*stream\r?\n(.*?)\r?\nendstream", re.DOTALL)
    streams = [zlib.decompress(one) for one in pattern.findall(data)]
    assert any(b" Tj" in one or b" TJ" in one for one in streams)  # text is shown as such


def test_by_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.csv").write_text("x,y,z,radius\n0,0,0,1\n3,0,0,1\n")

    def run(*words: str) -> str:
        result = CliRunner().invoke(main, ["render", "a.csv", *words], catch_exceptions=False)
        assert (result.exit_code == 0) == (not result.stderr.startswith("clrt:"))
        return result.stderr

    run("-o", "a.svg", "--width", "80", "--height", "45", "--title", "Τίτλος", "--samples", "1")
    assert "Τίτλος</text>" in Path("a.svg").read_text()
    said = run("-o", "b.svg", "--region", "0", "0", "9", "9")
    assert "--region: expected a format of pixels, b.svg has words" in said
    assert "a.svg: .svg has no passes" in run("-o", "a.svg", "--passes", "id")
    monkeypatch.setattr("clrt.files.vector.find_spec", lambda name: None)
    assert "b.pdf: .pdf needs matplotlib: pip install 'clrt[text]'" in run("-o", "b.pdf")
    assert not Path("b.pdf").exists()
    picture = clrt.plot([[0.0, 0, 0]], radii=1, size=(40, 30), samples=1, title="one")
    monkeypatch.undo()
    picture.save(tmp_path / "c.svg")
    assert "one</text>" in (tmp_path / "c.svg").read_text()

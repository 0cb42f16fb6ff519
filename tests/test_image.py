"""Image files: each format read back, whole or not there."""

import os
import re
import struct
import sys
import zlib
from pathlib import Path

import numpy as np
import OpenEXR
import png
import pytest
import tifffile
from PIL import Image

import clrt
from clrt import storage
from clrt.errors import OutputError, RequestError
from clrt.files import deep, image

BYTES = np.random.default_rng(1).integers(0, 256, (20, 30, 3), np.uint8)
WORDS = np.random.default_rng(1).integers(0, 65536, (20, 30, 3), np.uint16)
FLOATS = np.random.default_rng(2).normal(0, 3, (20, 30, 3)).astype(np.float32)
ALPHA_BYTES = np.random.default_rng(3).integers(0, 256, (20, 30, 4), np.uint8)
ALPHA_WORDS = np.random.default_rng(3).integers(0, 65536, (20, 30, 4), np.uint16)
ALPHA_FLOATS = np.random.default_rng(4).normal(0, 3, (20, 30, 4)).astype(np.float32)
PASSES = {
    "depth": np.where(np.indices((20, 30))[1] < 9, np.inf, FLOATS[..., 0]).astype(np.float32),
    "normal": FLOATS,
    "id": np.arange(-1, 599, dtype=np.int32).reshape(20, 30),
}


@pytest.mark.parametrize("suffix", [".png", ".webp", ".tif", ".tiff", ".bmp", ".ppm", ".PNG"])
def test_8_bit_round_trip(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    image.save(path, BYTES)
    assert (np.rint(255 * image.load(path)) == BYTES).all()


@pytest.mark.parametrize("suffix", [".jpg", ".jpeg"])
def test_jpeg_round_trip(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    smooth = np.broadcast_to(np.arange(64, dtype=np.uint8)[:, None, None] * 3, (64, 64, 3))
    image.save(path, np.ascontiguousarray(smooth))
    assert abs(255 * image.load(path) - smooth).max() < 4


@pytest.mark.parametrize("suffix", image.FLOAT_FORMATS)
def test_float_round_trip(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    image.save(path, FLOATS)
    assert (image.load(path) == FLOATS).all()


WITH_ALPHA = {np.dtype(film.dtype): film for film in (ALPHA_BYTES, ALPHA_WORDS, ALPHA_FLOATS)}


@pytest.mark.parametrize("suffix", image.SUFFIXES)
def test_alpha_round_trip(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    for bits in (None, 16)[: 1 + (suffix in image.WITH_16_BITS)]:
        film = WITH_ALPHA[np.dtype(image.film_dtype(path, bits))]
        if suffix not in image.WITH_ALPHA:
            with pytest.raises(RequestError, match=rf"a{suffix}: {suffix} has no alpha: use one"):
                image.check_output(path, 30, 20, alpha=True)
            with pytest.raises(RequestError, match=r"of shape \(height, width, 3\), got"):
                image.save(path, film)
            continue
        image.check_output(path, 30, 20, alpha=True, bits=bits)
        image.save(path, film)
        found = image.load(path)
        if film.dtype == np.float32:  # premultiplied as it is
            assert (found == film).all()
        else:
            exact = film / np.float64(np.iinfo(film.dtype).max)
            exact[..., :3] *= exact[..., 3:]
            assert abs(found - exact).max() < 1e-7


@pytest.mark.parametrize("suffix", image.WITH_16_BITS)
def test_16_bit_round_trip(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    image.check_output(path, 30, 20, bits=16)
    image.save(path, WORDS)
    assert (np.rint(image.load(path) * np.float64(65535)) == WORDS).all()
    assert image.is_whole(path, 30, 20)


@pytest.mark.parametrize("film", [WORDS, ALPHA_WORDS], ids=["RGB", "RGBA"])
def test_others_read_16_bits(tmp_path: Path, film: np.ndarray) -> None:
    """Libraries that are not used to write them, and a checker of PNG's rules."""
    image.save(tmp_path / "a.tif", film)
    page = tifffile.TiffFile(tmp_path / "a.tif").pages.first
    assert (page.asarray() == film).all()
    extra = (tifffile.EXTRASAMPLE.UNASSALPHA,) if film.shape[2] == 4 else ()
    assert page.extrasamples == extra
    image.save(tmp_path / "a.png", film, transfer="srgb", command="clrt render")
    width, height, rows, information = png.Reader(filename=str(tmp_path / "a.png")).read()
    assert (np.array(list(rows)).reshape(height, width, -1) == film).all()
    assert (information["bitdepth"], information["alpha"]) == (16, film.shape[2] == 4)


@pytest.mark.parametrize("film", [BYTES, ALPHA_BYTES, WORDS], ids=["8", "8 and alpha", "16"])
def test_a_png_says_what_it_is(tmp_path: Path, film: np.ndarray) -> None:
    path = tmp_path / "a.png"
    for transfer, command in (("linear", ""), ("srgb", "clrt render a.toml -o 'ä ∑.png'")):
        image.save(path, film, transfer=transfer, command=command)
        assert image.is_srgb(path) is (transfer == "srgb")
        said = Image.open(path).info
        assert ("srgb" in said) == (transfer == "srgb")
        assert said["Software"] == f"clrt {clrt.__version__}"
        assert said.get("Comment", "") == command
        kinds = [
            kind for kind, _ in png.Reader(filename=str(path)).chunks()
        ]  # which checks their sums
        assert kinds.index(b"IHDR") == 0
        assert kinds.index(b"tEXt") < kinds.index(b"IDAT")


def test_a_command_that_is_no_text(tmp_path: Path) -> None:
    image.save(tmp_path / "a.png", BYTES, command="clrt render -o \udcff.png")
    assert Image.open(tmp_path / "a.png").info["Comment"] == r"clrt render -o \udcff.png"
    with pytest.raises(RequestError, match="transfer: expected 'linear' or 'srgb', got 'sRGB'"):
        image.save(tmp_path / "b.png", BYTES, transfer="sRGB")


def test_what_other_formats_say() -> None:
    assert image.is_srgb(Path("a.npy")) is image.is_srgb(Path("a.exr")) is False
    assert image.is_srgb(Path("a.jpg")) is image.is_srgb(Path("a.tif")) is None


def test_passes_round_trip(tmp_path: Path) -> None:
    for film in (FLOATS, ALPHA_FLOATS):
        image.save(tmp_path / "a.npz", film, passes=PASSES)
        with np.load(tmp_path / "a.npz") as found:
            assert list(found) == ["image", "depth", "normal", "id"]
            for name, expected in ({"image": film} | PASSES).items():
                assert found[name].dtype == expected.dtype
                assert (found[name] == expected).all()
        image.save(tmp_path / "a.exr", film, passes=PASSES)
        assert (image.load(tmp_path / "a.exr") == film).all()
        with OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True) as file:
            channels = {name: found.pixels for name, found in file.channels().items()}
        assert channels.keys() == {*"RGBA"[: film.shape[2]], "Z", "N.X", "N.Y", "N.Z", "id"}
        assert (channels["Z"] == PASSES["depth"]).all()
        assert np.isinf(channels["Z"]).any()
        for k, axis in enumerate("XYZ"):
            assert (channels[f"N.{axis}"] == PASSES["normal"][..., k]).all()
        assert channels["id"].dtype == np.uint32
        assert (channels["id"].view(np.int32) == PASSES["id"]).all()
        assert channels["id"][0, 0] == 0xFFFFFFFF
    image.save(tmp_path / "a.exr", FLOATS, passes={"id": PASSES["id"]})
    assert image.is_whole(tmp_path / "a.exr", 30, 20)


def test_the_same_film_is_the_same_bytes(tmp_path: Path) -> None:
    """Whenever it is written."""
    for suffix in image.SUFFIXES:
        paths = [tmp_path / f"{name}{suffix}" for name in "ab"]
        for path, now in zip(paths, (1e9, 1.5e9), strict=True):
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr("time.time", lambda now=now: now)
                image.save(path, BYTES if image.film_dtype(path) is np.uint8 else FLOATS)
        assert paths[0].read_bytes() == paths[1].read_bytes(), suffix


@pytest.mark.parametrize(
    ("name", "options", "said"),
    [
        (
            "a.jpg",
            {"bits": 16},
            r"a.jpg: .jpg has no 16 bits a channel: use one of .png .tif .tiff",
        ),
        ("a.npy", {"bits": 16}, r"a.npy: .npy has no 16 bits a channel: use one of .png"),
        ("a.exr", {"bits": 8}, r"a.exr: .exr has no 8 bits a channel: use one of .png .jpg"),
        ("a.png", {"passes": True}, r"a.png: .png has no passes: use one of .npz .exr"),
        ("a.pfm", {"alpha": True}, r"a.pfm: .pfm has no alpha: use one of .png .webp"),
    ],
)
def test_what_a_format_cannot_do(tmp_path: Path, name: str, options: dict, said: str) -> None:
    with pytest.raises(RequestError, match=said):
        image.check_output(tmp_path / name, 30, 20, **options)
    with pytest.raises(RequestError, match=r"b.png: .png has no passes"):
        image.save(tmp_path / "b.png", BYTES, passes=PASSES)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("module", "name", "options", "said"),
    [
        ("av", "a.tif", {"bits": 16}, "16 bits a channel need PyAV: pip install av"),
        ("OpenEXR", "a.exr", {}, ".exr needs OpenEXR: pip install openexr"),
    ],
)
def test_without_a_library(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    module: str,
    name: str,
    options: dict,
    said: str,
) -> None:
    path = tmp_path / name
    image.save(path, WORDS if options else FLOATS)
    monkeypatch.setitem(sys.modules, module, None)
    for use in (
        lambda: image.check_output(path, 30, 20, **options),
        lambda: image.save(path, WORDS if options else FLOATS),
        lambda: image.load(path),
    ):
        with pytest.raises(RequestError, match=f"^{re.escape(said)}$"):
            use()
    assert [found.name for found in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("suffix", image.SUFFIXES)
def test_every_suffix_has_a_film(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    image.check_output(path, 30, 20)
    image.save(path, BYTES if image.film_dtype(path) is np.uint8 else FLOATS)
    assert image.load(path).shape == (20, 30, 3)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_check_output(tmp_path: Path) -> None:
    with pytest.raises(RequestError, match=r"ends in one of \.png"):
        image.check_output(tmp_path / "a.hdr", 1, 1)
    with pytest.raises(RequestError, match="does not exist"):
        image.check_output(tmp_path / "none" / "a.png", 1, 1)
    (tmp_path / "a.png").mkdir()
    os.mkfifo(tmp_path / "b.png")
    (tmp_path / "c.png").symlink_to("/dev/full")
    for name in ("a.png", "b.png", "c.png"):
        with pytest.raises(RequestError, match="is a folder or a device, expected a file's name"):
            image.check_output(tmp_path / name, 1, 1)


@pytest.mark.parametrize(
    ("suffix", "largest"),
    [
        (".jpg", (65500, 1)),
        (".webp", (16383, 1)),
        (".webp", (1, 16383)),
        (".tif", (10**9 // 50000, 50000)),
        (".bmp", (10**9 // 50000, 50000)),
    ],
)
def test_what_a_format_can_hold(tmp_path: Path, suffix: str, largest: tuple[int, int]) -> None:
    path = tmp_path / f"a{suffix}"
    width, height = largest
    image.check_output(path, width, height)
    if width * height < 10**6:
        image.save(path, np.zeros((height, width, 3), np.uint8))
        assert image.load(path).shape == (height, width, 3)
    with pytest.raises(RequestError, match=f"a{suffix}: {suffix} has no more than"):
        image.check_output(path, width + 1, height + 1)


def test_a_link_is_followed(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "a.png").symlink_to("there/b.png")
    for _ in range(2):
        image.check_output(tmp_path / "a.png", 30, 20)
        image.save(tmp_path / "a.png", BYTES)
        assert (tmp_path / "a.png").is_symlink()
        assert [path.name for path in (tmp_path / "there").iterdir()] == ["b.png"]


def test_permissions_stay(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    image.save(path, BYTES)
    path.chmod(0o640)
    image.save(path, BYTES)
    assert path.stat().st_mode & 0o777 == 0o640


def test_a_failed_write_leaves_what_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.npy"
    image.save(path, FLOATS)
    before = path.read_bytes()

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setitem(deep.WRITE, ".npy", stop)
    with pytest.raises(KeyboardInterrupt):
        image.save(path, FLOATS)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["a.npy"]


def test_too_large_for_the_format(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="cannot be written"):
        image.save(tmp_path / "a.webp", np.zeros((1, 20000, 3), np.uint8))
    assert not list(tmp_path.iterdir())


def test_unreadable(tmp_path: Path) -> None:
    with pytest.raises(RequestError, match="No such file"):
        image.load(tmp_path / "none.png")
    for name in ("a.png", "a.npy", "a.pfm", "a.npz", "a.exr"):
        (tmp_path / name).write_bytes(b"nothing of the kind")
        with pytest.raises(RequestError, match="cannot be read"):
            image.load(tmp_path / name)
    for spoilt in (b"", b"PK\3\4 not a zip"):
        (tmp_path / "a.npy").write_bytes(spoilt)
        with pytest.raises(RequestError, match="cannot be read"):
            image.load(tmp_path / "a.npy")
    for array in (np.zeros(5), np.zeros((2, 2, 3), np.int32), np.zeros((2, 2, 2))):
        np.save(tmp_path / "b.npy", array)
        with pytest.raises(RequestError, match="expected float, uint8 or uint16 of shape"):
            image.load(tmp_path / "b.npy")


def test_16_bits_a_channel(tmp_path: Path) -> None:
    gray = np.arange(256, dtype=np.uint8).reshape(16, 16)
    Image.fromarray(gray).save(tmp_path / "8.png")
    Image.fromarray(gray.astype(np.uint16) * 257).save(tmp_path / "16.png")
    assert (image.load(tmp_path / "16.png") == image.load(tmp_path / "8.png")).all()
    Image.fromarray(gray.astype(np.int32)).save(tmp_path / "32.tif")
    with pytest.raises(RequestError, match="expected 8 or 16 bits a channel, got mode I"):
        image.load(tmp_path / "32.tif")


def test_a_picture_larger_than_memory_is_not_decoded(tmp_path: Path) -> None:
    header = struct.pack(">II5B", 60000, 60000, 8, 2, 0, 0, 0)
    chunk = b"IHDR" + header
    (tmp_path / "bomb.png").write_bytes(
        b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + chunk + struct.pack(">I", zlib.crc32(chunk))
        + struct.pack(">I", 9) + b"IDAT"
    )  # fmt: skip
    with pytest.raises(OutputError, match=r"bomb.png: 60000x60000 needs 72.0 GB of memory"):
        image.load(tmp_path / "bomb.png")


def test_what_a_killed_process_left_goes(tmp_path: Path) -> None:
    """And what one that lives holds, what is young and what is not ours stays."""
    old, held, young = (tmp_path / f".{letter * 16}.part" for letter in "abc")
    other = tmp_path / ".other.part"
    for path in (old, held, young, other):
        path.touch()
    for path in (old, held, other):
        os.utime(path, (0, 0))
    lock = storage.locked(held)
    image.save(tmp_path / "a.png", BYTES)
    os.close(lock)
    assert set(tmp_path.iterdir()) == {held, young, other, tmp_path / "a.png"}


@pytest.mark.parametrize("suffix", image.SUFFIXES)
def test_is_whole(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    assert not image.is_whole(path, 30, 20)
    image.save(path, BYTES if image.film_dtype(path) is np.uint8 else FLOATS)
    assert image.is_whole(path, 30, 20)
    assert not image.is_whole(path, 20, 30)
    path.write_bytes(path.read_bytes()[:-40])
    assert not image.is_whole(path, 30, 20)
    path.write_bytes(b"")
    assert not image.is_whole(path, 30, 20)

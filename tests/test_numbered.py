"""Numbered pictures: names, and the file beside them that keeps two kinds apart."""

import os
import re
import threading
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from clrt.errors import OutputError, RequestError
from clrt.files import image, numbered
from clrt.files.numbered import Kind, hull, join

KIND = Kind("0123456789abcdef", (8, 8), "robust", 16, "skylake-avx512 (PoCL)", "0.2.0")
NARROW = replace(KIND, lanes=8)


@pytest.fixture
def pattern(tmp_path: Path) -> Path:
    return tmp_path / "###.png"


def draw(pattern: Path, frames: range, size: tuple[int, int] = (8, 8)) -> None:
    for k in frames:
        image.save(numbered.picture(pattern, k), np.zeros((size[1], size[0], 3), np.uint8))


@pytest.mark.parametrize(
    ("pattern", "frame", "name", "record"),
    [
        ("a/####.png", 7, "a/0007.png", "a/frames.png.json"),
        ("shot-#.jpg", 12, "shot-12.jpg", "shot-frames.jpg.json"),
        ("##a.npy", 0, "00a.npy", "framesa.npy.json"),
        ("####.png", 123456, "123456.png", "frames.png.json"),
    ],
)
def test_names(pattern: str, frame: int, name: str, record: str) -> None:
    assert numbered.is_pattern(Path(pattern))
    assert numbered.picture(Path(pattern), frame) == Path(name)
    assert numbered.record_path(Path(pattern)) == Path(record)


def test_what_is_there_is_found(pattern: Path) -> None:
    """And what only looks alike is not."""
    draw(pattern, range(9, 12))
    draw(pattern.with_name("####.png"), range(5))
    draw(pattern.with_name("a###.png"), range(5))
    draw(pattern.with_name("###.jpg"), range(5))
    draw(pattern, range(1000, 1001))
    assert numbered.found(pattern) == [9, 10, 11, 1000]


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        ([range(5)], range(5)),
        ([range(3, 20, 4)], range(3, 20, 4)),
        ([range(60), range(60, 120)], range(120)),
        ([range(0, 20, 2), range(1, 20, 2)], range(20)),
        ([range(0, 20, 4), range(6, 30, 4)], range(0, 27, 2)),
        ([range(7, 8)], range(7, 8)),
        ([range(k, k + 1) for k in (4, 0, 8, 2)], range(0, 9, 2)),  # 6 is missing
        ([range(k, k + 1) for k in (1, 2, 4)], range(1, 5)),
    ],
)
def test_hull(parts: list[range], expected: range) -> None:
    assert hull(parts) == expected


def test_joined_it_says_how_they_are_made_and_which(pattern: Path) -> None:
    for frames, asked in (
        (range(60), (0, 59, 1)),
        (range(30, 40), (0, 59, 1)),
        (range(60, 120), (0, 119, 1)),
    ):
        join(pattern, KIND, 24.0, frames, adds=True)
        said = numbered.record(pattern)
        assert said is not None
        assert (said.kind, said.fps, said.frames) == (KIND, 24.0, asked)
    assert [path.name for path in pattern.parent.iterdir()] == ["frames.png.json"]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"scene": "fedcba9876543210"}, "scene 0123456789abcdef, not fedcba9876543210"),
        ({"size": (16, 9)}, r"size \(8, 8\), not \(16, 9\)"),
        ({"precision": "double"}, "precision robust, not double"),
        ({"lanes": 8, "clrt": "0.3.0"}, "lanes 16, not 8; clrt 0.2.0, not 0.3.0"),
        ({"target": "haswell (PoCL)"}, r"target skylake-avx512 \(PoCL\), not haswell \(PoCL\)"),
    ],
)
def test_a_mix_is_refused(pattern: Path, change: dict, said: str) -> None:
    join(pattern, KIND, 24.0, range(10), adds=False)
    draw(pattern, range(3))
    before = numbered.record_path(pattern).read_bytes()
    expected = rf"^{re.escape(str(pattern))}: the pictures there have {said} \(see frames.png.json"
    for frames, adds in ((range(10), True), (range(1, 10), False), (range(1), True)):
        with pytest.raises(RequestError, match=expected):
            join(pattern, replace(KIND, **change), 24.0, frames, adds=adds)
    assert numbered.record_path(pattern).read_bytes() == before


def test_all_made_anew_they_may_be_of_another_kind(pattern: Path) -> None:
    """Those that are not yet made anew do not count."""
    join(pattern, KIND, 24.0, range(5), adds=False)
    draw(pattern, range(5))
    for k in range(5):
        os.utime(numbered.picture(pattern, k), (1e9, 1e9))
    join(pattern, NARROW, 24.0, range(9), adds=False)
    draw(pattern, range(2))
    said = join(pattern, NARROW, 24.0, range(9), adds=True)
    made = [k for k in range(9) if said.is_made(numbered.picture(pattern, k))]
    assert made == numbered.found(pattern, said) == [0, 1]
    with pytest.raises(RequestError, match=r"7 of 9 pictures are missing, the first is 002.png"):
        numbered.complete(pattern, None, 1)
    with pytest.raises(RequestError, match="lanes 8, not 16"):
        join(pattern, KIND, 24.0, range(9), adds=True)


def test_what_is_there_and_of_no_kind_that_is_known_is_taken(pattern: Path) -> None:
    """As of clrt 0.1, and of other programs."""
    draw(pattern, range(3))
    said = join(pattern, KIND, 24.0, range(9), adds=True)
    assert [k for k in range(9) if said.is_made(numbered.picture(pattern, k))] == [0, 1, 2]


def test_many_that_start_at_once_agree(pattern: Path) -> None:
    """Of two kinds one is refused, whoever is first."""
    for _ in range(20):
        start = threading.Barrier(8)
        outcomes: list[Kind | None] = []

        def begin(kind: Kind, start=start, outcomes=outcomes) -> None:
            start.wait()
            try:
                outcomes.append(join(pattern, kind, 24.0, range(9), adds=True).kind)
            except RequestError:
                outcomes.append(None)

        threads = [threading.Thread(target=begin, args=[(KIND, NARROW)[i % 2]]) for i in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert len(outcomes) == 8
        assert outcomes.count(None) == 4
        assert len(set(outcomes)) == 2
        assert [path.name for path in pattern.parent.iterdir()] == ["frames.png.json"]
        numbered.record_path(pattern).unlink()


def test_without_links(pattern: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "link", refuse)
    for kind in (KIND, KIND):
        assert join(pattern, kind, 24.0, range(9), adds=True).kind == KIND
    with pytest.raises(RequestError, match="lanes 16, not 8"):
        join(pattern, NARROW, 24.0, range(9), adds=True)


def test_a_spoilt_file_is_told(pattern: Path) -> None:
    path = numbered.record_path(pattern)
    for content in (b"", b"{}", b'{"kind": 1}', b"\xff"):
        path.write_bytes(content)
        with pytest.raises(RequestError, match=r"frames.png.json: cannot be read .*: remove it"):
            join(pattern, KIND, 24.0, range(9), adds=True)
        assert path.read_bytes() == content


def test_a_folder_that_is_full_or_not_there(pattern: Path) -> None:
    gone = pattern.parent / "none" / "#.png"
    with pytest.raises(OutputError, match=r"frames.png.json: cannot be written: No such file"):
        join(gone, KIND, 24.0, range(9), adds=True)


def test_films_are_read_in_order_and_few_ahead(
    pattern: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shades = range(0, 200, 10)
    for k, shade in enumerate(shades):
        image.save(numbered.picture(pattern, k), np.full((8, 8, 3), shade, np.uint8))
    real, begun = image.read, []

    def read(path: Path):
        begun.append(path)
        return real(path)

    monkeypatch.setattr(image, "read", read)
    for k, film in enumerate(numbered.films(pattern, range(20))):
        assert (film == shades[k]).all()
        assert len(begun) <= k + 1 + numbered.AHEAD

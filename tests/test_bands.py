"""How much of a film a launch fills."""

import numpy as np
import pytest

from clrt.opencl import bands

WIDTH, HEIGHT = 3840, 217
PACKET = 4, 4


def parts_of(samples: int, seconds_of_a_sample: float, **arguments: object) -> list[bands.Part]:
    """All launches of a picture on a device of two units, each of which takes so long."""
    given = {"samples": samples, "sphere_count": 100, "paths": None, **arguments}
    pace = bands.Pace((HEIGHT, WIDTH), PACKET, 2, given)
    found = [bands.Part(0, 0, 0, WIDTH)]
    while (part := pace.after(found[-1])).rows:
        found.append(part)
        pace.took(part, part.rows * part.columns * samples * seconds_of_a_sample)
    return found[1:]


@pytest.mark.parametrize("seconds", [1e-9, 1e-6])
@pytest.mark.parametrize("samples", [1, 257, 4096, 65536])
def test_parts_cover_a_film_once(samples: int, seconds: float) -> None:
    seen = np.zeros((HEIGHT, WIDTH), np.uint8)
    for part in parts_of(samples, seconds):
        assert part.left % PACKET[0] == 0
        assert part.top % PACKET[1] == 0
        seen[part.inside] += 1
    assert (seen == 1).all()


def test_only_rows_of_many_samples_are_cut() -> None:
    for samples in (1, 16, 256):
        assert {part.columns for part in parts_of(samples, 1e-6)} == {WIDTH}
    assert {part.columns for part in parts_of(4096, 1e-6, paths=object())} == {WIDTH}
    pieces = parts_of(4096, 1e-6)
    assert max(part.rows * part.columns * 4096 for part in pieces) <= bands.PIECE_SAMPLES
    # What a sample takes is known after the first launch.
    slow = max(part.rows * part.columns for part in pieces[1:])
    assert slow < max(part.rows * part.columns for part in parts_of(4096, 1e-9)[1:])

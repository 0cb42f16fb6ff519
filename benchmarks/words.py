"""What words add to a figure: `python benchmarks/words.py`, milliseconds at 1920x1080.

The first figure of a process reads the font; later ones, as the frames of a video, have only the
label and the labels anew.
"""

import statistics
import time

import numpy as np
from msgspec.structs import replace

import clrt
from clrt.film import develop
from clrt.film.decor import decorations

SIZE = 1920, 1080
REGION = (0, 0, *SIZE)


def main() -> None:
    random = np.random.default_rng(1)
    film = clrt.Film(
        background=(1, 1, 1),
        transfer="srgb",
        title="Sodium chloride, Φ = 0.25 ± 0.01",
        label="t = 0.25 ps",
        labels=[
            clrt.Label(f"Na{k}", tuple(at), 0.1)
            for k, at in enumerate(random.uniform(-1, 1, (12, 3)))
        ],
        scalebar="auto",
        scalebar_label="Å",
        axes="xyz",
        colorbar="speed (Å/ps)",
        colorbar_clim=(0.0, 1.0),
        colorbar_room=True,
    )
    camera = clrt.Camera((0, 0, 9), (0, 0, 0), projection="orthographic", height=3)
    nothing = np.full(SIZE[::-1], np.inf, np.float32)
    seen = develop.Seen(nothing, nothing, np.zeros(0), np.s_[:, :])
    exposed = np.zeros((*SIZE[::-1], 4), np.float32)
    out = np.empty((*SIZE[::-1], 3), np.uint8)
    bare = clrt.Film(background=(1, 1, 1), transfer="srgb")
    develop.develop(exposed, bare, out)

    def took(label: str | None) -> float:
        start = time.perf_counter()
        marks = []
        if label is not None:
            scene = clrt.Scene(camera, film=replace(film, label=label))
            marks = decorations.marks(scene, SIZE, REGION, False, seen)
        develop.develop(exposed, bare, out, seen, marks)
        return 1e3 * (time.perf_counter() - start)

    plain = statistics.median(took(None) for _ in range(9))
    print(f"first figure: {took('t = 0.50 ps') - plain:.1f} ms")
    again = statistics.median(took(f"t = {k} ps") - plain for k in range(15))
    print(f"each frame: {again:.1f} ms (median of 15)")
    sizes = [film.font_size * (1 + k / 1000) for k in range(1, 10)]
    fresh = []
    for size in sizes:  # of which nothing is kept
        film = replace(film, font_size=size)
        fresh.append(took("t = 0 ps") - plain)
    print(f"another figure: {statistics.median(fresh):.1f} ms (median of {len(fresh)})")


if __name__ == "__main__":
    main()

"""Animation: how a camera moves, by keys."""

from collections.abc import Sequence
from typing import Literal

import msgspec

from clrt.scene.camera import CAMERA_VECTORS, LENSES
from clrt.values import (
    Vec3,
    all_of,
    count,
    number,
    require,
    vectors,
)

FRAMES = 10**7
"""The most that an animation can have."""


class Key(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The camera's place at a frame. None keeps the value of the scene's camera."""

    frame: int
    position: Vec3 | None = None
    look_at: Vec3 | None = None
    up: Vec3 | None = None
    fov: float | None = None
    height: float | None = None

    def __post_init__(self) -> None:
        count(self, "frame", 0, FRAMES)
        vectors(self, *(key for key in CAMERA_VECTORS if getattr(self, key) is not None))
        for lens in LENSES.values():
            if getattr(self, lens) is not None:
                number(self, lens, "a finite number", lambda value: True)


class Animation(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How the camera moves. If the first and the last key say the same it goes round and round."""

    frames: int
    keys: Sequence[Key]
    fps: float = 30.0
    interpolation: Literal["smooth", "linear"] = "smooth"

    def __post_init__(self) -> None:
        good = self.interpolation in ("smooth", "linear")
        require(good, "interpolation", "'smooth' or 'linear'", self.interpolation)
        count(self, "frames", 1, FRAMES)
        number(self, "fps", "a number from 0.001 to 1000", lambda fps: 0.001 <= fps <= 1000)
        all_of(self, "keys", Key, "a Key")
        require(len(self.keys) >= 2, "keys", "at least two keys", len(self.keys))
        before = -1
        for i, key in enumerate(self.keys):
            good = before < key.frame <= self.frames
            expected = f"a frame from {before + 1} to {self.frames}, after that of the key before"
            require(good, f"keys[{i}].frame", expected, key.frame)
            before = key.frame

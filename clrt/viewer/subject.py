"""Subject: what is looked at, and how the command line names it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from clrt.animation import Way, all_frames
from clrt.files.scenefile import as_scene
from clrt.scene import Scene


@dataclass(frozen=True)
class Subject:
    """A scene, or one a frame."""

    words: Sequence[str]
    """Of `clrt render`, which draw it but for its camera, size and samples: its name first. None
    where it is no file."""
    at: Callable[[int], Scene]
    """The scene of a frame."""
    frames: int = 1
    fps: float = 30.0


def of(source: Scene | str | Path, words: Sequence[str] = ()) -> Subject:
    """A scene, and the frames of its animation.

    Args:
        source: a scene, or what load_scene() takes.
        words: of `clrt render`, beside the name.

    Raises:
        SceneError: it cannot be read, or is not a scene.
    """
    scene = as_scene(source)
    words = () if isinstance(source, Scene) else (str(source), *words)
    if scene.animation is None:
        return Subject(words, lambda frame: scene)
    way = Way(scene)
    way.check(all_frames(scene))
    still = replace(scene, animation=None)  # a camera that is moved by hand may not suit its keys

    def at(frame: int) -> Scene:
        return replace(still, camera=way.camera(frame))

    return Subject(words, at, scene.animation.frames, scene.animation.fps)


def described(scene: Scene, index: int) -> dict[str, Any] | None:
    """What is known of one sphere; None of -1, which is none."""
    if index < 0:
        return None
    sphere = scene.spheres[index]
    return {
        "index": index,
        "position": sphere.center,
        "radius": sphere.radius,
        "material": sphere.material,
    }

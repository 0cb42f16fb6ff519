"""Loading: what a source is, and scenes with the values of options in place of their own."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, TypeVar

from clrt.errors import RequestError

if TYPE_CHECKING:
    from msgspec import Struct

    from clrt.scene.scene import Scene

T = TypeVar("T", bound="Struct")

Kind: TypeAlias = Literal["mesh", "particles", "scene"]


def kind_of(source: str, reading: Mapping[str, str]) -> Kind:
    """What a source is, by its name, or by what is said of how particles are read."""
    from clrt.files.meshes.reader import is_mesh
    from clrt.files.particles.suffix import is_particles

    if not reading and is_mesh(Path(source)):
        return "mesh"
    return "particles" if "format" in reading or is_particles(Path(source)) else "scene"


def changed(given: T, **options: Any) -> T:
    """A scene, or a part of one, whose values give way to those of options that were given."""
    from msgspec.structs import replace

    try:
        return replace(given, **{key: value for key, value in options.items() if value is not None})
    except ValueError as error:
        raise RequestError(str(error)) from None


def opened(name: str, *, samples: int | None, background: str | None, **film: Any) -> "Scene":
    """Reads a scene; options that were given replace its samples and values of its film."""
    from clrt.files.scenefile import load_scene
    from clrt.film import color

    loaded = load_scene(name)
    ground = None if background is None else color.named(background)
    return changed(loaded, samples=samples, film=changed(loaded.film, background=ground, **film))

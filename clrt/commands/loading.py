"""Loading: scenes with the values that options give in place of their own."""

from typing import TYPE_CHECKING, Any, TypeVar

from clrt.errors import RequestError

if TYPE_CHECKING:
    from msgspec import Struct

    from clrt.scene.scene import Scene

T = TypeVar("T", bound="Struct")


def changed(given: T, **options: Any) -> T:
    """A scene, or a part of one, with what options say in place of its own values."""
    from msgspec.structs import replace

    try:
        return replace(given, **{key: value for key, value in options.items() if value is not None})
    except ValueError as error:
        raise RequestError(str(error)) from None


def opened(name: str, *, samples: int | None, background: str | None, **film: Any) -> "Scene":
    """A scene with what options say of its samples and its film."""
    from clrt.files.scenefile import load_scene
    from clrt.film import color

    loaded = load_scene(name)
    ground = None if background is None else color.named(background)
    return changed(loaded, samples=samples, film=changed(loaded.film, background=ground, **film))

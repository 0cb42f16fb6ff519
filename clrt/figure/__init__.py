"""Figure: particles as a scene, and as a picture."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from clrt.figure.compose import Look as Look


def __getattr__(name: str) -> Any:
    if name == "Look":
        from clrt.figure.compose import Look

        return Look
    raise AttributeError(f"module 'clrt.figure' has no attribute {name!r}")

"""Decorations over a picture: colour bars, legends, cells."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from clrt.film.decor import legend as legend


def __getattr__(name: str) -> Any:
    if name == "legend":  # clrt.decor.legend, after `import clrt` alone
        import importlib

        return importlib.import_module("clrt.film.decor.legend")
    raise AttributeError(f"module 'clrt.film.decor' has no attribute {name!r}")

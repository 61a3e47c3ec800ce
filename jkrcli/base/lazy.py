"""Names of a package that are imported when they are first asked for: a package that costs nothing to import."""

from __future__ import annotations

from importlib import import_module

TYPE_CHECKING = False  # typing's own takes as long to import as all that a bare command needs
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from typing import Any


def lazily(package: str, homes: Mapping[str, str]) -> Callable[[str], Any]:
    """The ``__getattr__`` of ``package`` whose names stand in its modules: ``homes[module]``, parted by spaces.

    What it gives raises AttributeError for every other name. For the types the package imports the same names.
    """
    places = {name: module for module, names in homes.items() for name in names.split()}

    def load(name: str) -> Any:
        if name not in places:
            raise AttributeError(f"module {package} has no attribute {name}")
        return getattr(import_module(places[name], package), name)

    return load

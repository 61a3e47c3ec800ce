"""Names of a package that are imported when they are first used: a package that costs nothing to import."""

from __future__ import annotations

from importlib import import_module

TYPE_CHECKING = False  # typing's own takes as long to import as all that a bare command needs
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any


def lazily(package: str, file: str) -> Callable[[str], Any]:
    """The ``__getattr__`` of the ``package`` of a ``file`` that imports its names for the types: each is imported when
    it is first used; AttributeError for every other name."""
    places: dict[str, str] = {}

    def load(name: str) -> Any:
        if not places:
            places.update(_imported(file))
        if name not in places:
            raise AttributeError(f"module {package} has no attribute {name}")
        return getattr(import_module(places[name], package), name)

    return load


def _imported(file: str) -> dict[str, str]:
    """Where each name stands that ``file`` imports under ``if TYPE_CHECKING:``, up to the first empty line."""
    with open(file, encoding="utf-8") as lines:  # noqa: PTH123  # pathlib takes as long as all else here
        block = lines.read().partition("\nif TYPE_CHECKING:\n")[2].partition("\n\n")[0]
    for sign in ("# fmt: skip", "(", ")", ","):
        block = block.replace(sign, " ")
    parts = (part.partition(" import ") for part in block.split(" from ")[1:])
    return {name: module for module, _, names in parts for name in names.split()}

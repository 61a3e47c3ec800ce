"""Adhesive (JKR) contact of axisymmetric bodies: nonadhesive series in, adhesive curves out.

Lengths in m, forces in N, moduli in Pa, work of adhesion in J/m^2; compression and indentation are positive.

``import jkrcli as jkr`` offers the names in ``__all__``, loaded when they are first used (see jkrcli.api).
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from .base.errors import InputError, JkrError, Refusal

if TYPE_CHECKING:
    from .api import (
        identify,
        load_case,
        measured_curves,
        parse_case,
        plot,
        read,
        save,
        solve,
        summary,
        table,
        to_pandas,
        transform,
    )

__version__ = "0.1.0"
__all__ = [
    "InputError",
    "JkrError",
    "Refusal",
    "identify",
    "load_case",
    "measured_curves",
    "parse_case",
    "plot",
    "read",
    "save",
    "solve",
    "summary",
    "table",
    "to_pandas",
    "transform",
]


def __getattr__(name: str) -> Any:
    """The names of the Python interface, imported when they are first asked for."""
    if name not in __all__:
        raise AttributeError(f"module jkrcli has no attribute {name}")
    return getattr(importlib.import_module(".api", __name__), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]

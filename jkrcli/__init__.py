"""Adhesive (JKR) contact of axisymmetric bodies: nonadhesive series in, adhesive curves out.

Lengths in m, forces in N, moduli in Pa, work of adhesion in J/m^2; compression and indentation are positive.

``import jkrcli as jkr`` offers the names of jkrcli.api, which is loaded when one of them is first used.
"""

from __future__ import annotations

TYPE_CHECKING = False  # typing's own takes as long to import as all else here, and Ctrl-C is minded only after it
if TYPE_CHECKING:
    from typing import Any

    from .api import *  # noqa: F403
    from .fem.solver import FEM as FEM
    from .hybrid.solver import Hybrid as Hybrid
    from .many.inverse import find_value as find_value
    from .many.maps import study_map as study_map
    from .measured.functions import *  # noqa: F403
    from .viscoelastic.fit_functions import *  # noqa: F403
    from .viscoelastic.functions import *  # noqa: F403

__version__ = "0.2.0"


def __getattr__(name: str) -> Any:
    """A name of jkrcli.api or of a wing; AttributeError for every other, that of a room among them, which an import
    then finds."""
    from importlib import import_module, util

    if name == "__all__" or not (name.startswith("_") or util.find_spec(f".{name}", __name__)):
        from .base.wings import absent

        if name == "__all__":
            names = [*import_module(".api", __name__).__all__, *_of_wings()]
            return sorted(names, key=lambda name: (not name.isupper(), name))  # FEM, classes, functions
        if name in (of_wings := _of_wings()):
            return getattr(import_module(f".{of_wings[name]}", __name__), name)
        api = import_module(".api", __name__)
        if name in api.__all__:
            return getattr(api, name)
        if refused := absent(name):
            raise AttributeError(f"{name} {refused}")
    raise AttributeError(f"module {__name__} has no attribute {name}")


def _of_wings() -> dict[str, str]:
    """The names that wings offer, with their modules."""
    from .base.wings import wings

    return {name: module for wing in wings() for name, module in wing.functions.items()}


def __dir__() -> list[str]:
    return [*__getattr__("__all__"), "__version__"]

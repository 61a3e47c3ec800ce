"""The indenters, one file per shape; every module in this folder is imported, and registers its own."""

from __future__ import annotations

import importlib
import pkgutil

from ..indenter import SHAPES, Indenter, shape

# isort: off
from .sphere import Sphere  # in the order in which messages name the shapes
from .paraboloid import Paraboloid
from .power_law import PowerLaw
from .rounded_flat import RoundedFlat
from .table import TableProfile
# isort: on

__all__ = ["SHAPES", "Indenter", "Paraboloid", "PowerLaw", "RoundedFlat", "Sphere", "TableProfile", "shape"]

for _module in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_module.name}")

"""The indenters; every module in this folder is imported, and registers its own."""

import importlib
import pkgutil

from ..problem import SHAPES, Indenter, shape
from .analytic import FlatPunch, Paraboloid, PowerLaw, Pyramid, RoundedCone, RoundedFlat, Sphere
from .table import TableProfile

for _module in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_module.name}")

"""Adhesive (JKR) contact of axisymmetric bodies: nonadhesive series in, adhesive curves out.

Lengths in m, forces in N, moduli in Pa, work of adhesion in J/m^2; compression and indentation are positive.

``import jkrcli as jkr`` offers the names in ``__all__``, loaded when they are first used (see jkrcli.api).
"""

from __future__ import annotations

import importlib

TYPE_CHECKING = False  # typing's own takes as long to import as all else here, and Ctrl-C is minded only after it
if TYPE_CHECKING:
    from typing import Any

    from .adhesion.program import Program
    from .adhesion.rate.laws import LogRate, PowerRate
    from .api import (
        check,
        compare,
        cycle,
        cycle_at_speed,
        cycle_relaxing,
        identify,
        identify_joint,
        identify_law,
        identify_relaxation,
        identify_tension,
        load_case,
        look,
        measured_curves,
        parse_case,
        plan,
        plot,
        profile,
        pull_off,
        read,
        save,
        solve,
        study_map,
        summary,
        table,
        to_pandas,
        transform,
        work,
    )  # fmt: skip
    from .base.errors import InputError, JkrError, Refusal
    from .base.unknown import Unknown
    from .bodies.grading import Exponential, Linear, Power, Tabulated
    from .bodies.indenters import (
        EqualAreaCone,
        Paraboloid,
        PowerLaw,
        RoundedCone,
        RoundedFlat,
        Sphere,
        TableProfile,
    )
    from .bodies.materials import Elastic, Graded, TransverselyIsotropic
    from .bodies.problem import HalfSpace, Layer, Loading, Problem, Rigid, Specimen
    from .bodies.relaxation import PowerRelaxation, Prony, StandardSolid
    from .data.measured.curve import Reading
    from .methods.closed_form.method import ClosedForm
    from .methods.fem.method import FEM
    from .methods.guards import Limits
    from .methods.hybrid.method import Hybrid
    from .methods.layered.layered import Layered

__version__ = "0.2.0"
__all__ = [
    "FEM", "ClosedForm", "Elastic", "EqualAreaCone", "Exponential", "Graded", "HalfSpace", "Hybrid", "InputError",
    "JkrError", "Layer", "Layered", "Limits", "Linear", "Loading", "LogRate", "Paraboloid", "Power", "PowerLaw",
    "PowerRate", "PowerRelaxation", "Problem", "Program", "Prony", "Reading", "Refusal", "Rigid", "RoundedCone",
    "RoundedFlat", "Specimen", "Sphere", "StandardSolid", "TableProfile", "Tabulated", "TransverselyIsotropic",
    "Unknown", "check", "compare", "cycle", "cycle_at_speed", "cycle_relaxing", "identify", "identify_joint",
    "identify_law", "identify_relaxation", "identify_tension", "load_case", "look", "measured_curves", "parse_case",
    "plan", "plot", "profile", "pull_off", "read", "save", "solve", "study_map", "summary", "table", "to_pandas",
    "transform", "work",
]  # fmt: skip
_HOMES = {  # of what is not in jkrcli.api
    ".adhesion.rate.laws": ("LogRate", "PowerRate"),
    ".adhesion.program": ("Program",),
    ".base.errors": ("InputError", "JkrError", "Refusal"),
    ".base.unknown": ("Unknown",),
    ".bodies.grading": ("Exponential", "Linear", "Power", "Tabulated"),
    ".bodies.indenters": (
        "EqualAreaCone",
        "Paraboloid",
        "PowerLaw",
        "RoundedCone",
        "RoundedFlat",
        "Sphere",
        "TableProfile",
    ),
    ".bodies.materials": ("Elastic", "Graded", "TransverselyIsotropic"),
    ".bodies.problem": ("HalfSpace", "Layer", "Loading", "Problem", "Rigid", "Specimen"),
    ".bodies.relaxation": ("PowerRelaxation", "Prony", "StandardSolid"),
    ".data.measured.curve": ("Reading",),
    ".methods.closed_form.method": ("ClosedForm",),
    ".methods.fem.method": ("FEM",),
    ".methods.guards": ("Limits",),
    ".methods.hybrid.method": ("Hybrid",),
    ".methods.layered.layered": ("Layered",),
}


def __getattr__(name: str) -> Any:
    """The names of the Python interface, imported when they are first asked for."""
    if name not in __all__:
        raise AttributeError(f"module jkrcli has no attribute {name}")
    home = next((module for module, names in _HOMES.items() if name in names), ".api")
    return getattr(importlib.import_module(home, __name__), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]

"""Adhesive (JKR) contact of axisymmetric bodies: nonadhesive series in, adhesive curves out.

Lengths in m, forces in N, moduli in Pa, work of adhesion in J/m^2; compression and indentation are positive.

``import jkrcli as jkr`` offers the names in ``__all__``, loaded when they are first used (see jkrcli.api).
"""

from __future__ import annotations

from .base.lazy import lazily

TYPE_CHECKING = False  # typing's own takes as long to import as all else here, and Ctrl-C is minded only after it
# isort: off
if TYPE_CHECKING:
    from .adhesion import LogRate, PowerRate, Program
    from .api import (
        check,
        compare,
        cycle,
        cycle_at_speed,
        cycle_relaxing,
        fit,
        identify,
        identify_joint,
        identify_law,
        identify_relaxation,
        identify_tension,
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
    )
    from .case.reading import load_case  # fmt: skip
    from .base import InputError, JkrError, Refusal, Unknown
    from .bodies import (
        Coated, Elastic, Exponential, Graded, GradedTransverselyIsotropic, HalfSpace, Layer, Linear, Loading,
        Paraboloid, Power, PowerLaw, PowerRelaxation, Problem, Prony, Pyramid, Rigid, RoundedCone, RoundedFlat,
        Specimen, Sphere, StandardSolid, TableProfile, Tabulated, TransverselyIsotropic,
    )  # fmt: skip
    from .data import Reading
    from .methods import FEM, ClosedForm, Hybrid, Layered, Limits

# isort: on

__version__ = "0.2.0"
__all__ = [
    "FEM", "ClosedForm", "Coated", "Elastic", "Exponential", "Graded", "GradedTransverselyIsotropic", "HalfSpace",
    "Hybrid", "InputError", "JkrError", "Layer", "Layered", "Limits", "Linear", "Loading", "LogRate", "Paraboloid",
    "Power", "PowerLaw", "PowerRate", "PowerRelaxation", "Problem", "Program", "Prony", "Pyramid", "Reading", "Refusal",
    "Rigid", "RoundedCone", "RoundedFlat", "Specimen", "Sphere", "StandardSolid", "TableProfile", "Tabulated",
    "TransverselyIsotropic", "Unknown", "check", "compare", "cycle", "cycle_at_speed", "cycle_relaxing", "fit",
    "identify", "identify_joint", "identify_law", "identify_relaxation", "identify_tension", "load_case", "look",
    "measured_curves", "parse_case", "plan", "plot", "profile", "pull_off", "read", "save", "solve", "study_map",
    "summary", "table", "to_pandas", "transform", "work",
]  # fmt: skip

__getattr__ = lazily(__name__, __file__)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]

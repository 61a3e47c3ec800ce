"""From a nonadhesive series to the adhesive curve and what it means."""

from __future__ import annotations

from ..base.lazy import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from .course import Course
    from .critical import Errors, point_error
    from .curve import AdhesiveCurve, CriticalPoint, Equilibrium, EquilibriumCurve
    from .device import CONTROLS, DISPLACEMENT_CONTROL, LOAD_CONTROL
    from .finite_range import FiniteRangeBody, FiniteRangeCurve
    from .law import AskedRange, Range
    from .nonadhesive import Nonadhesive
    from .path import Jump, TimedState
    from .program import Program
    from .rate.history import RateContact
    from .rate.laws import RATE_LAWS, LogRate, PowerRate, RateLaw, rate_law_of, rate_parameters
    from .relaxation.history import RelaxingContact
    from .relaxation.limits import limits_of
    from .slopes.result import TWO_SIDED_90, Slopes
    from .stability import Behaviour, behaviour, stable_radius
    from .validity import LIMITS, Validity, end_of_body, refuse_wetting

__getattr__ = lazily(
    __name__,
    {
        ".course": "Course",
        ".critical": "Errors point_error",
        ".curve": "AdhesiveCurve CriticalPoint Equilibrium EquilibriumCurve",
        ".device": "CONTROLS DISPLACEMENT_CONTROL LOAD_CONTROL",
        ".finite_range": "FiniteRangeBody FiniteRangeCurve",
        ".law": "AskedRange Range",
        ".nonadhesive": "Nonadhesive",
        ".path": "Jump TimedState",
        ".program": "Program",
        ".rate.history": "RateContact",
        ".rate.laws": "RATE_LAWS LogRate PowerRate RateLaw rate_law_of rate_parameters",
        ".relaxation.history": "RelaxingContact",
        ".relaxation.limits": "limits_of",
        ".slopes.result": "TWO_SIDED_90 Slopes",
        ".stability": "Behaviour behaviour stable_radius",
        ".validity": "LIMITS Validity end_of_body refuse_wetting",
    },
)

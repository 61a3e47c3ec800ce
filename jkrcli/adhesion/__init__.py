"""From a nonadhesive series to the adhesive curve and what it means."""

from __future__ import annotations

from ..base.lazy import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from .curve import (
        CONTROLS,
        DISPLACEMENT_CONTROL,
        LOAD_CONTROL,
        AdhesiveCurve,
        CriticalPoint,
        Equilibrium,
        EquilibriumCurve,
        control,
        position,
        resolved,
        transform,
        yielding,
    )
    from .device_path import REST, Course, Jump, Program, TimedState
    from .energy_error import energy_lost_error, separation_error
    from .finite_range import FiniteRangeBody, FiniteRangeCurve, Range, RangeRequest, unable
    from .from_rest import FromRest, LoadingHistory, Rest, histories, history_error
    from .interpolation import Nonadhesive
    from .pull_off_error import Errors, point_error
    from .rate import (
        RATE_LAWS,
        History,
        LogRate,
        PowerRate,
        RateContact,
        RateLaw,
        parameters_of,
        rate_law_of,
        rate_parameters,
    )
    from .relaxation import RelaxedHistory, RelaxingContact
    from .slopes import RULES, checked_rule
    from .slopes.result import TWO_SIDED_90, Slopes
    from .stability import (
        Behaviour,
        Cycle,
        FoundWork,
        behaviour,
        behaviours,
        branch,
        cycle,
        stable_radius,
        trace,
        turning_radius,
        work_from_pull_off,
    )
    from .validity import (
        LIMITS,
        REMEDY,
        Strains,
        Validity,
        end_of_body,
        faces,
        judge,
        large_strains,
        refuse_wetting,
        regime,
        sizes,
        strain_size,
        strain_words,
        unresolved,
        with_large_strains,
    )

__getattr__ = lazily(__name__, __file__)

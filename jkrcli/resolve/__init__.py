"""What the same bodies would do otherwise: solved again, without slip, with a range, as a half-space."""

from __future__ import annotations

from ..base.lazy import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from .analysis import (
        JKR,
        Analysis,
        Lost,
        adhesive,
        analyse,
        forecast,
        nonadhesive,
        seconds_of_page,
        where_lost,
        with_solved_points,
    )
    from .comparison import StickingEffect, effect_as_json, effect_facts, effect_on, sticking_effect, sticking_warnings
    from .histories import (
        LostByHistory,
        checked_histories,
        curves_from_rest,
        lost_by_history,
        rest_of,
        seconds_of_histories,
        solved_on,
        strains_after,
        with_history_solved,
    )
    from .profile import profile_columns, radius_under
    from .refine_pull_off import is_solved

__getattr__ = lazily(__name__, __file__)

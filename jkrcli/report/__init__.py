"""One object per result: columns, summary (JSON), words, figure; and the files and pictures of them."""

from __future__ import annotations

from ..base.lazy import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from .check import Check
    from .dem import Exported
    from .forward import (
        COMPONENTS,
        Compared,
        Cycled,
        CycledByProgram,
        Fields,
        MeasuredByHistory,
        MeasuredPullOff,
        Profile,
        PullOff,
        Transformed,
        figure_of,
    )
    from .inverse import (
        Fits,
        Fitted,
        JointFitted,
        LawFit,
        Look,
        RelaxationFits,
        RelaxationFitted,
        TensionFitted,
        Work,
        plan_table,
        rivals_table,
    )
    from .plots.studies import MU, MapPanel, filled_figure, is_filled, lines_figure, zones_figure
    from .rate import CycledAtSpeed, CycledInLimits, CycledRelaxing, traced_histories
    from .result import PICTURES, SHOWN, AnyResult, Figure, Files, Output, Result, Results, as_result
    from .solved import Imported, Meshed, Solved

__getattr__ = lazily(__name__, __file__)

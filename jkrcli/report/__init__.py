"""One object per result: columns, summary (JSON), words, figure; and the files and pictures of them."""

from __future__ import annotations

from ..base.lazy import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from .check import Check
    from .compare import Compared
    from .cycle import Cycled, CycledByProgram
    from .dem import Exported
    from .fields import COMPONENTS, Fields, Profile
    from .fit import Fits, Fitted, plan_table, rivals_table
    from .fit_together import JointFitted, LawFit, TensionFitted
    from .look import Look
    from .mesh import Meshed
    from .plots.maps import MU, MapPanel, filled_figure, is_filled, lines_figure, zones_figure
    from .pull_off import MeasuredByHistory, MeasuredPullOff, PullOff
    from .rate import CycledAtSpeed
    from .relaxation import CycledInLimits, CycledRelaxing, traced_histories
    from .relaxation_fit import RelaxationFits, RelaxationFitted
    from .result import PICTURES, SHOWN, AnyResult, Figure, Files, Output, Result, Results, as_result
    from .solved import Imported, Solved
    from .transform import Transformed, figure_of
    from .work import Work

__getattr__ = lazily(__name__, __file__)

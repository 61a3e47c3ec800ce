"""Fits of E*, w and the zero points to measured curves: orthogonal distances to the two-parameter family of one series.

settings: what is asked; points: which rows; model: what an instrument reads; search: the nearest curve; confidence.
"""

from __future__ import annotations

from ...base.lazy import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from ..answer import FittedValue
    from ..parameters import ALIAS, Parameter
    from .body import FittedBody, body_of, for_each
    from .fitting import Failure, fit, fit_all
    from .joint import JointFit, joint_fit, shared_of, with_radii
    from .plan import further, planned
    from .points import third_differences
    from .record import receding
    from .result import Fit, Further, JKRBeside
    from .settings import USUALLY_FREE, Loss, Settings, settings_of, uncertain_of
    from .statistics import covariance, larger, rise, robust_scale, t_quantile

__getattr__ = lazily(__name__, __file__)

"""From measured curves to properties: E, w and zero points by fits, w point by point."""

from __future__ import annotations

from ..base.lazy import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from .forward_model import FittedBody, body_of, for_each
    from .joint import JointFit, joint_fit, shared_of, with_radii
    from .least_squares import covariance, larger, rise, robust_scale, t_quantile
    from .parameters import ALIAS, FittedValue, Parameter
    from .procedure import Failure, fit, fit_all, further, planned
    from .record import receding
    from .result import Fit, Further, JKRBeside
    from .rows import third_differences
    from .settings import USUALLY_FREE, Loss, Settings, settings_of, uncertain_of


# --------------------------------------------------------------------------------------------------
# Fits of E*, w and the zero points to measured curves: orthogonal distances to the two-parameter family of one
# series.
#
# settings: what is asked; points: which rows; model: what an instrument reads; search: the nearest curve; confidence.

__getattr__ = lazily(__name__, __file__)

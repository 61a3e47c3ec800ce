"""What a force curve would make of one more unknown: one step of Gauss and Newton from the end of its fit."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...base import Array
from .coloured import spread as covariance
from .force_curve_fit import ForceCurveFit


@dataclass(frozen=True, eq=False)
class OneMore:
    """One step of Gauss and Newton from a fit with one more unknown, whose derivatives are the last column of ``J``;
    ``step``: of all unknowns; ``size``: of the last one's, in standard errors of white noise."""

    fit: ForceCurveFit
    J: Array
    step: Array
    size: float

    @classmethod
    def of(cls, fit: ForceCurveFit, column: Array) -> OneMore:
        off, J = fit.model.residuals(fit.x, 0.0)
        J, noise = np.column_stack([J, column]), fit.spread.noise
        scale = np.maximum(np.linalg.norm(J, axis=0), np.finfo(float).tiny)
        Q, triangle = np.linalg.qr(fit.model.whitened(J / scale, noise))
        along = Q.T @ fit.model.whitened(off, noise)
        return cls(fit, J, -np.linalg.lstsq(triangle, along, rcond=None)[0] / scale, abs(float(along[-1])))

    @property
    def last(self) -> float:
        """The step of the one more."""
        return float(self.step[-1])

    @cached_property
    def error(self) -> float:
        """Its standard error."""
        model, weight = self.fit.model, self.fit.weight
        off = model.ordered(model.residuals(self.fit.x, 0.0)[0] + self.J @ self.step, weight)
        spread = covariance(off, model.ordered(self.J, weight), (), weight)
        return math.sqrt(max(spread.covariance[-1, -1], 0.0))


def drift_left_out(fit: ForceCurveFit) -> OneMore:
    """A drift of z0 [m/s] that was not fitted: one step of a search that knows it."""
    model = replace(fit.model, positions=(*fit.model.positions, "drift"))
    values = fit.model.values(fit.x) | {"drift": 0.0}
    J = model.evaluated(model.unknowns(values), 0.0)[1]
    return OneMore.of(fit, J[:, model.names.index("drift")])


def another_modulus(fit: ForceCurveFit) -> OneMore:
    """Change of ln s on the way back against the way in that the data ask for: one step of a search with a modulus for
    each direction."""
    off, J = fit.model.residuals(fit.x, 0.0)
    back = np.arange(off.size) >= fit.model.stretches[0].P.size
    return OneMore.of(fit, J[:, fit.names.index("ln_s")] * back)

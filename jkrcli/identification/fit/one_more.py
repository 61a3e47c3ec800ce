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

    found: ForceCurveFit
    J: Array
    step: Array
    size: float

    @classmethod
    def of(cls, found: ForceCurveFit, column: Array) -> OneMore:
        off, J = found.model.residuals(found.x, 0.0)
        J, noise = np.column_stack([J, column]), found.spread.noise
        scale = np.maximum(np.linalg.norm(J, axis=0), np.finfo(float).tiny)
        Q, triangle = np.linalg.qr(found.model.whitened(J / scale, noise))
        along = Q.T @ found.model.whitened(off, noise)
        return cls(found, J, -np.linalg.lstsq(triangle, along, rcond=None)[0] / scale, abs(float(along[-1])))

    @property
    def last(self) -> float:
        """The step of the one more."""
        return float(self.step[-1])

    @cached_property
    def error(self) -> float:
        """Its standard error."""
        model, weight = self.found.model, self.found.weight
        off = model.ordered(model.residuals(self.found.x, 0.0)[0] + self.J @ self.step, weight)
        spread = covariance(off, model.ordered(self.J, weight), (), weight)
        return math.sqrt(max(spread.covariance[-1, -1], 0.0))


def unasked_drift(found: ForceCurveFit) -> OneMore:
    """A drift of z0 [m/s] that was not fitted: one step of a search that knows it."""
    model = replace(found.model, positions=(*found.model.positions, "drift"))
    values = found.model.values(found.x) | {"drift": 0.0}
    J = model.evaluated(np.array([values[name] for name in model.names]), 0.0)[1]
    return OneMore.of(found, J[:, model.names.index("drift")])


def another_modulus(found: ForceCurveFit) -> OneMore:
    """Change of ln s on the way back against the way in that the data ask for: one step of a search with a modulus for
    each direction."""
    off, J = found.model.residuals(found.x, 0.0)
    back = np.arange(off.size) >= found.model.stretches[0].P.size
    return OneMore.of(found, J[:, found.names.index("ln_s")] * back)

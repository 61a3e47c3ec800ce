"""The adhesive curves of one body for every modulus factor and every work of adhesion.

With all moduli multiplied by s and work of adhesion w (Eq. 13)
    delta = D(a) - sqrt(w/s) T(a)        P = s H(a) - sqrt(w s) V(a)
D, H: delta_H and P_H of the series; T = sqrt(4 pi a/S'), V = S T: its adhesive parts at w = 1 J/m^2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicHermiteSpline, PPoly

from ...adhesion.curve import Nonadhesive
from ...adhesion.slopes.result import Slopes
from ...base.arrays import Array
from ...series import Series

REFINED = 6  # choice: nodes per interval of the series; the cubics between them err far less than the curve itself
FUNCTIONS = 4  # D, T, H, V


@dataclass(frozen=True, eq=False)
class Family:
    """log D, log T, log H, log V over u = log a (a in m) with two derivatives; power laws beyond the ends.

    ``low, high``: log of the smallest and largest contact radius of the series. ``rates``: derivatives of the same four
    logs by the body's own parameters, None where it has none that vary.
    """

    logs: PPoly
    low: float
    high: float
    rates: PPoly | None = None

    @classmethod
    def of(cls, series: Series, slopes: Slopes) -> Family:
        """The family of a series; its adhesive curves are evaluated by their own rule, on a finer grid."""
        body, u = Nonadhesive(series, slopes), _grid(series)
        a = np.clip(np.exp(u), series.a[0], series.a[-1])
        here, rate = body.with_rates(a)
        values = np.stack([here.delta_H, here.t, here.P_H, here.S * here.t], axis=1)
        rates = np.stack([rate.delta_H, rate.t, rate.P_H, rate.S * here.t + here.S * rate.t], axis=1)
        logs = CubicHermiteSpline(u, np.log(values), a[:, None] * rates / values)
        return cls(_with_derivatives(_extended(logs)), float(u[0]), float(u[-1]))

    def rate_from(self, base: Family, step: float) -> Array:
        """Coefficients of the change of the four logs from ``base`` on, per ``step`` of a parameter."""
        return (self.logs.c[..., :FUNCTIONS] - base.logs.c[..., :FUNCTIONS]) / step

    def with_rates(self, parts: list[Array]) -> Family:
        """This family with its derivatives by parameters, as ``rate_from`` gives them."""
        return Family(self.logs, self.low, self.high, PPoly(np.concatenate(parts, axis=2), self.logs.x))

    def at(self, u: Array) -> tuple[Array, Array, Array]:
        """(D, T, H, V) and their first and second derivatives by u, each of shape (4, n)."""
        found = self.logs(u).T
        values = np.exp(found[:FUNCTIONS])
        first, second = found[FUNCTIONS : 2 * FUNCTIONS], found[2 * FUNCTIONS :]
        return values, values * first, values * (second + first**2)

    def relative_rates(self, u: Array) -> Array:
        """Derivatives of log (D, T, H, V) by the body's parameters, shape (parameters, 4, n)."""
        if self.rates is None:
            return np.empty((0, FUNCTIONS, u.size))
        return self.rates(u).T.reshape(-1, FUNCTIONS, u.size)


def _grid(series: Series) -> Array:
    """Nodes in log a: ``REFINED`` per interval, evenly spaced in log(a - a0) where the curve is smooth in it."""
    z = np.log(series.a - series.a0)
    inner = z[:-1, None] + np.diff(z)[:, None] * np.arange(REFINED) / REFINED
    return np.log(series.a0 + np.exp(np.append(inner.ravel(), z[-1])))


def _extended(logs: CubicHermiteSpline) -> PPoly:
    """The cubics with a straight line added at each end, far enough for any foot point."""
    ends, width = logs.x[[0, -1]], logs.x[-1] - logs.x[0] + 1
    before, after = np.zeros((2, *logs.c.shape[::2]))
    before[2:] = logs(ends[0], 1), logs(ends[0]) - width * logs(ends[0], 1)
    after[2:] = logs(ends[1], 1), logs(ends[1])
    c = np.concatenate([before[:, None], logs.c, after[:, None]], axis=1)
    return PPoly(c, np.concatenate([[ends[0] - width], logs.x, [ends[1] + width]]))


def _with_derivatives(logs: PPoly) -> PPoly:
    """One piecewise cubic that gives values, first and second derivatives in one evaluation."""
    zero = np.zeros_like(logs.c[:1])
    first, second = logs.derivative(1).c, logs.derivative(2).c
    return PPoly(
        np.concatenate([logs.c, np.concatenate([zero, first]), np.concatenate([zero, zero, second])], 2), logs.x
    )

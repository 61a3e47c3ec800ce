"""A smooth nonadhesive series given by log g and log s as B-splines in the log of the radius.

With y = a - a0, x = log y, g = d(delta_H)/da = exp(v(x)) and s = S' = exp(u(x)), both positive by construction:

    delta_H = int_0^y g dy        S = S0 + int_0^y s dy        P_H = int_0^y S g dy

Well below the first radius v and u go on as straight lines, that is g and s as power laws, integrated in closed form.
Power laws (Hertz, cones, thin layers) are straight lines throughout: the roughness int (v'')^2 dx does not see them.
All quantities here are dimensionless, scaled by their largest values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.interpolate import BSpline, CubicSpline

from ...base import Array
from ...series import Series

Points = tuple[Array, Array, Array]
OnGrid = tuple[tuple[tuple[Array, Array], tuple[Array, Array]], ...]
GAUSS_X, GAUSS_W = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True)
class SplineTuning:
    """The splines of log g and log s, and the grid on which they are integrated."""

    degree: int = 5  # tuned on noisy series, by `make tuning`
    below: float = 2.5  # in x, how far they reach below the first point; tuned on the same, by `make tuning`
    intervals_below: int = 3  # there; tuned on the same, by `make tuning`
    step: float = 0.04  # of the grid in x; theory: Hermite and Gauss errors stay below 1e-9
    # of an integral towards zero radius, kept positive below it; tuned on imported tables, by `make constants`: no body
    # has less
    small_exponent: float = 0.2


TUNING = SplineTuning()


class LogColumns(NamedTuple):
    """``logs`` (4, m) of delta, P, S, S' at some radii, ``rates`` (2, m), the d/dx of the first two, and the
    ``jacobian`` (4, m, p) of the logs with respect to all coefficients."""

    logs: Array
    rates: Array
    jacobian: Array


@dataclass(frozen=True, eq=False)
class Shape:
    """What is known of v and u, but for their levels: a solution at rising log radii ``x`` (m,).

    ``logs``, (2, m): v and u. ``starts``, (3,): delta, S - S0 and P - S0 delta at x[0] over what they would be were g
    and s power laws below. ``log_S0``: over the level of u, where the slope at first touch is above 0.
    """

    x: Array
    logs: Array
    starts: Array
    log_S0: float

    @classmethod
    def of(cls, series: Series, y_scale: float) -> Shape | None:
        """That of an exact ``series``; radii beyond the flat end over ``y_scale`` [m]. None where S' is unknown."""
        if series.S is None or series.dS is None:
            return None
        x, S0 = np.log((series.a - series.a0) / y_scale), series.S0 or 0.0
        log_delta = CubicSpline(x, np.log(series.delta / series.delta[-1]))
        S_scale = float(series.P[-1] / series.delta[-1])
        logs = np.stack([log_delta(x) + np.log(log_delta(x, 1)) - x, np.log(series.dS * y_scale / S_scale)])
        q, m = CubicSpline(x, logs, axis=1)(x[0], 1)
        gy, sy = np.exp(logs[:, 0] + x[0])
        delta, S = series.delta[0] / series.delta[-1], (series.S[0] - S0) / S_scale
        P = (series.P[0] - S0 * series.delta[0]) / series.P[-1]
        starts = np.array([delta * (q + 1) / gy, S * (m + 1) / sy, P / S * (q + m + 2) / gy])
        return cls(x, logs, starts, math.log(S0 / S_scale) if S0 > 0 else 0.0)

    def __call__(self, x: Array, order: int = 0) -> Array:
        """v and u at log radii ``x`` (m,), or their first derivatives, (2, m); beyond those known they are straight."""
        known = CubicSpline(self.x, self.logs, axis=1)
        near = np.clip(x, self.x[0], self.x[-1])
        rates: Array = known(near, 1)
        return rates if order == 1 else known(near) + (x - near) * rates


class LogSplineModel:
    """The integrals above on a fixed grid of x, for any coefficients.

    ``x``: the data's log radii, shape (n,), any order. Coefficients are those of v, those of u, and log S0 where it is
    free; in each of v and u the first two are value and slope of a straight line in x, and the sum of squares of the
    others (``rough_v``, ``rough_u``) is the roughness int (v'')^2 dx. With a ``shape`` v, u and log S0 are those over
    its own.
    """

    def __init__(self, x: Array, intervals: int, S0: float | None, shape: Shape | None = None):
        low, high = float(np.min(x)) - TUNING.below, float(np.max(x))
        self.knots = _knots(np.sort(x), intervals)
        self.size = self.knots.size - TUNING.degree - 1
        self.shapes = self._shapes()
        self.S0 = S0
        self.x = np.linspace(low, high, int(np.ceil((high - low) / TUNING.step)) + 2)
        self.step = self.x[1] - self.x[0]
        inner = (self.x[:-1, None] + self.step * (1 + GAUSS_X) / 2).ravel()
        self.inner_y = np.exp(inner)
        self.y = np.exp(self.x)
        panels = np.repeat(np.arange(self.x.size - 1), GAUSS_X.size)
        self.inner = panels, *_hermite(np.tile((1 + GAUSS_X) / 2, self.x.size - 1), self.step)
        self.basis, self.inner_basis = self.design(self.x), self.design(inner)
        self.first_slope = self.design(self.x[:1], 1)[0]
        self.parameters = 2 * self.size + (S0 is None)
        self.v, self.u = slice(0, self.size), slice(self.size, 2 * self.size)
        self.rough_v, self.rough_u = slice(2, self.size), slice(self.size + 2, 2 * self.size)
        self.shape, self.log_S0 = shape, 0.0 if shape is None else shape.log_S0
        self.starts = np.ones(3) if shape is None else shape.starts
        self.known, self.known_rates = self.of_shape(self.x), self.of_shape(self.x, 1)
        self.known_inner = self.of_shape(inner)

    def of_shape(self, x: Array, order: int = 0) -> Array:
        """v and u of the ``shape`` at ``x`` (m,), or their first derivatives, (2, m)."""
        return np.zeros((2, x.size)) if self.shape is None else self.shape(x, order)

    def straight(self, v: tuple[float, float], u: tuple[float, float], log_S0: float) -> Array:
        """Coefficients of v = v[0] + v[1] x and u = u[0] + u[1] x."""
        coefficients = np.zeros(self.parameters)
        coefficients[self.v][:2], coefficients[self.u][:2] = v, u
        if self.S0 is None:
            coefficients[-1] = log_S0
        return coefficients

    def interpolation(self, x: Array) -> Points:
        """Grid index and the cubic Hermite weights (for values, for x-derivatives) of the points ``x``."""
        i = np.clip(((x - self.x[0]) / self.step).astype(int), 0, self.x.size - 2)
        return (i, *_hermite((x - self.x[i]) / self.step, self.step))

    def columns(self, coefficients: Array, at: Points, basis: Array, grid: OnGrid | None = None) -> LogColumns:
        """The columns at the points of ``at`` (from ``interpolation``), whose spline values are ``basis``."""
        (log_delta, d_delta), (log_P, d_P), (log_S, d_S) = grid or self.on_grid(coefficients)
        jacobian = np.zeros((4, basis.shape[0], self.parameters))
        for row, derivatives in enumerate((d_delta, d_P, d_S)):
            jacobian[row] = interpolate(at, *derivatives)
        jacobian[3, :, self.u] = basis
        delta, P, S = (interpolate(at, *pair) for pair in (log_delta, log_P, log_S))
        known_v, known_u = (interpolate(at, *pair) for pair in zip(self.known, self.known_rates, strict=True))
        v, u = known_v + basis @ coefficients[self.v], known_u + basis @ coefficients[self.u]
        rate = np.exp(interpolate(at, self.x, np.ones_like(self.x)) + v)
        rates = np.stack([rate / np.exp(delta), rate * np.exp(S - P)])
        return LogColumns(np.stack([delta, P, S, u]), rates, jacobian)

    def on_grid(self, c: Array) -> OnGrid:
        """Logs of delta, P, S on the grid with their d/dx, and the same two of the logs' Jacobians."""
        g, s = np.exp(self.known[0] + self.basis @ c[self.v]), np.exp(self.known[1] + self.basis @ c[self.u])
        gy, sy = g * self.y, s * self.y
        inner_gy = np.exp(self.known_inner[0] + self.inner_basis @ c[self.v]) * self.inner_y
        inner_sy = np.exp(self.known_inner[1] + self.inner_basis @ c[self.u]) * self.inner_y
        q, m = (self.known_rates[i, 0] + self.first_slope @ c[part] for i, part in enumerate((self.v, self.u)))
        (q1, dq1), (m1, dm1), (qm2, dqm2) = (_floored_exponent(power) for power in (q + 1, m + 1, q + m + 2))
        S_start = np.exp(self.log_S0 + c[-1]) if self.S0 is None else self.S0
        first_delta, first_S, first_P = self.starts * (gy[0] / q1, sy[0] / m1, gy[0] / qm2)
        first_P *= first_S
        b, db = self.basis[0], self.first_slope

        delta = first_delta + self._cumulate(inner_gy)
        S = S_start + first_S + self._cumulate(inner_sy)
        d_delta, d_gy = np.zeros((2, self.x.size, self.parameters))
        d_delta[:, self.v] = first_delta * (b - db * dq1 / q1) + self._cumulate(inner_gy[:, None] * self.inner_basis)
        d_gy[:, self.v] = gy[:, None] * self.basis
        d_S = np.zeros((self.x.size, self.parameters))
        d_S[:, self.u] = first_S * (b - db * dm1 / m1) + self._cumulate(inner_sy[:, None] * self.inner_basis)
        d_sy = np.zeros_like(d_S)
        d_sy[:, self.u] = sy[:, None] * self.basis
        first_dP = np.zeros(self.parameters)
        first_dP[self.v] = S_start * first_delta * (b - db * dq1 / q1) + first_P * (b - db * dqm2 / qm2)
        first_dP[self.u] = first_P * (b - db * dm1 / m1 - db * dqm2 / qm2)
        if self.S0 is None:
            d_S[:, -1] = S_start
            first_dP[-1] = S_start * first_delta

        log_S = _logs(S, sy, d_S, d_sy)
        inner = self.inner
        inner_S = np.exp(interpolate(inner, *log_S[0]))
        inner_rate = inner_S * inner_gy
        integrand = inner_rate[:, None] * interpolate(inner, *log_S[1])
        integrand[:, self.v] += inner_rate[:, None] * self.inner_basis
        P = S_start * first_delta + first_P + self._cumulate(inner_rate)
        d_P = first_dP + self._cumulate(integrand)
        d_rate = d_S * gy[:, None] + S[:, None] * d_gy
        return _logs(delta, gy, d_delta, d_gy), _logs(P, S * gy, d_P, d_rate), log_S

    def _cumulate(self, integrand: Array) -> Array:
        """Integral over x from the first grid point to each: (inner points, ...) -> (grid, ...)."""
        out = np.zeros((self.x.size, *integrand.shape[1:]))
        for j, weight in enumerate(GAUSS_W * self.step / 2):
            out[1:] += weight * integrand[j :: GAUSS_W.size]
        return np.cumsum(out, axis=0)

    def design(self, x: Array, order: int = 0) -> Array:
        """Values at ``x`` of what the coefficients of v (and of u) multiply, or their derivatives, shape (m, size)."""
        return self._splines(np.clip(x, self.x[0], self.x[-1]), order) @ self.shapes

    def _splines(self, x: Array, order: int) -> Array:
        """B-splines (or derivatives) at ``x``, shape (m, size)."""
        if order == 0:
            return BSpline.design_matrix(np.clip(x, self.knots[0], self.knots[-1]), self.knots, TUNING.degree).toarray()
        return BSpline(self.knots, np.eye(self.size), TUNING.degree)(x, order)

    def _shapes(self) -> Array:
        """B-spline coefficients, by columns, of 1, of x, and of shapes of unit roughness orthogonal in it."""
        sites = sliding_window_view(self.knots[1:-1], TUNING.degree).mean(axis=1)  # Greville: they give x
        rough, vectors = np.linalg.eigh(self._roughness())
        return np.column_stack([np.ones(self.size), sites, vectors[:, 2:] / np.sqrt(rough[2:])])

    def _roughness(self) -> Array:
        """Gram matrix of second derivatives, int B_i'' B_j'' dx, exact by Gauss points in every interval."""
        breaks = self.knots[TUNING.degree : self.size + 1]
        nodes, weights = np.polynomial.legendre.leggauss(TUNING.degree - 1)
        h = np.diff(breaks)[:, None]
        x = (breaks[:-1, None] + h * (1 + nodes) / 2).ravel()
        second = self._splines(x, 2)
        return second.T @ (second * (h * weights / 2).ravel()[:, None])


def _floored_exponent(power: float) -> tuple[float, float]:
    """``power`` and 1 (its derivative), continued smoothly to positive values below TUNING.small_exponent."""
    if power >= TUNING.small_exponent:
        return power, 1.0
    slope = float(np.exp(max(power / TUNING.small_exponent - 1, -50.0)))
    return TUNING.small_exponent * slope, slope


def _hermite(t: Array, step: float) -> tuple[Array, Array]:
    """Weights of the end values and of the end derivatives at the fraction ``t`` of an interval, (2, m) each."""
    values = np.array([(1 + 2 * t) * (1 - t) ** 2, t**2 * (3 - 2 * t)])
    slopes = np.array([t * (1 - t) ** 2, t**2 * (t - 1)]) * step
    return values, slopes


def _logs(value: Array, rate: Array, d_value: Array, d_rate: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """(log, its d/dx) of a column from its value and d/dx, and the same two of the log's Jacobian (grid, p)."""
    log_rate = rate / value
    d_log = d_value / value[:, None]
    return (np.log(value), log_rate), (d_log, d_rate / value[:, None] - log_rate[:, None] * d_log)


def interpolate(at: Points, values: Array, slopes: Array) -> Array:
    """Hermite interpolation of grid values (grid, ...) with given x-derivatives."""
    i, (h0, h1), (k0, k1) = at
    shape = (i.size,) + (1,) * (values.ndim - 1)
    h0, h1, k0, k1 = (weight.reshape(shape) for weight in (h0, h1, k0, k1))
    return h0 * values[i] + h1 * values[i + 1] + k0 * slopes[i] + k1 * slopes[i + 1]


def _knots(x: Array, intervals: int) -> Array:
    """Clamped knots for sorted ``x``: breakpoints half after the data and half even in x, and few below the data."""
    low, high = x[0], x[-1]
    even = np.linspace(0, 1, x.size)
    rank = (even + (x - low) / (high - low)) / 2
    breaks = np.interp(np.linspace(0, 1, intervals + 1), rank, x)
    below = np.linspace(low - TUNING.below, low, TUNING.intervals_below, endpoint=False)
    return np.concatenate([[below[0]] * TUNING.degree, below, breaks, [high] * TUNING.degree])

"""Slopes by integrating instead of differentiating: S' and d(delta_H)/da fitted through their integrals.

The data meet a model of splines in the logs of delta_H and P_H, weighted by their own errors; an error of the
radius counts through the slopes of both columns and correlates them (effective variance). The roughness of
log S' and log d(delta_H)/da over log a is penalised, each by a weight found from the data.
Nothing is differentiated, S' > 0 holds by construction, and the fit's covariance gives the band. Residuals that
follow their neighbours show what the splines cannot bend to: they get more knots, and what remains widens the band.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.interpolate import BSpline, CubicSpline
from scipy.linalg import lapack
from scipy.optimize import minimize_scalar
from scipy.special import stdtrit

from ...base.errors import LEVEL, Estimate, InputError, Refusal, Unknown
from ...base.numerics import HALF_WIDTH, MOST_SOLVES, MOST_STEPS, SHOWN, TINY, UNSEEN, Array
from ...series import RawSeries, Series
from . import ERROR_AT_DISPLACEMENT, ERROR_COMMON, Slopes, covariance_from_errors, shift_error
from .nodes import AS_THEY_ARE, Ahead, node_radii

# --------------------------------------------------------------------------------------------------
# A smooth nonadhesive series given by log g and log s as B-splines in the log of the radius.
#
# With y = a - a0, x = log y, g = d(delta_H)/da = exp(v(x)) and s = S' = exp(u(x)), both positive by construction:
#
#     delta_H = int_0^y g dy        S = S0 + int_0^y s dy        P_H = int_0^y S g dy
#
# Well below the first radius v and u go on as straight lines, that is g and s as power laws, integrated in closed
# form. Power laws (Hertz, cones, thin layers) are straight lines throughout: the roughness int (v'')^2 dx does not
# see them. All quantities here are dimensionless, scaled by their largest values.

Points = tuple[Array, Array, Array]
OnGrid = tuple[tuple[tuple[Array, Array], tuple[Array, Array]], ...]
GAUSS_X, GAUSS_W = np.polynomial.legendre.leggauss(3)

# The splines of log g and log s, and the grid on which they are integrated.
SPLINE_DEGREE = 5  # tuned on noisy series, by `make tuning`
SPLINE_BELOW = 2.5  # in x, how far they reach below the first point; tuned on the same, by `make tuning`
SPLINE_INTERVALS_BELOW = 3  # there; tuned on the same, by `make tuning`
SPLINE_STEP = 0.04  # of the grid in x; theory: Hermite and Gauss errors stay below 1e-9
# of an integral towards zero radius, kept positive below it; tuned on imported tables, by `make constants`: no body
# has less
SPLINE_SMALL_EXPONENT = 0.2


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
        x = np.sort(x)
        low, high = float(x[0]) - SPLINE_BELOW, float(x[-1])
        # Clamped knots: breakpoints half after the data and half even in x, and few below the data
        rank = (np.linspace(0, 1, x.size) + (x - x[0]) / (high - x[0])) / 2
        below = np.linspace(low, x[0], SPLINE_INTERVALS_BELOW, endpoint=False)
        within = np.interp(np.linspace(0, 1, intervals + 1), rank, x)
        self.knots = np.concatenate([[low] * SPLINE_DEGREE, below, within, [high] * SPLINE_DEGREE])
        self.size = self.knots.size - SPLINE_DEGREE - 1
        # B-spline coefficients, by columns, of 1, of x, and of shapes of unit roughness orthogonal in it
        sites = sliding_window_view(self.knots[1:-1], SPLINE_DEGREE).mean(axis=1)  # Greville: they give x
        # Gram matrix of second derivatives, int B_i'' B_j'' dx, exact by Gauss points in every interval.
        breaks = self.knots[SPLINE_DEGREE : self.size + 1]
        nodes, weights = np.polynomial.legendre.leggauss(SPLINE_DEGREE - 1)
        h = np.diff(breaks)[:, None]
        x = (breaks[:-1, None] + h * (1 + nodes) / 2).ravel()
        second = self._splines(x, 2)
        rough, vectors = np.linalg.eigh(second.T @ (second * (h * weights / 2).ravel()[:, None]))
        self.shapes = np.column_stack([np.ones(self.size), sites, vectors[:, 2:] / np.sqrt(rough[2:])])
        self.S0 = S0
        self.x = np.linspace(low, high, int(np.ceil((high - low) / SPLINE_STEP)) + 2)
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
            return BSpline.design_matrix(np.clip(x, self.knots[0], self.knots[-1]), self.knots, SPLINE_DEGREE).toarray()
        return BSpline(self.knots, np.eye(self.size), SPLINE_DEGREE)(x, order)


def _floored_exponent(power: float) -> tuple[float, float]:
    """``power`` and 1 (its derivative), continued smoothly to positive values below SPLINE_SMALL_EXPONENT."""
    if power >= SPLINE_SMALL_EXPONENT:
        return power, 1.0
    slope = float(np.exp(max(power / SPLINE_SMALL_EXPONENT - 1, -50.0)))
    return SPLINE_SMALL_EXPONENT * slope, slope


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


# --------------------------------------------------------------------------------------------------
# Penalised nonlinear least squares with the penalties' weights estimated from the data.
#
# Minimises |r(c)|^2 + sum_j lambda_j |c_j|^2, c_j being blocks of the coefficients c, by Gauss-Newton. The lambdas
# maximise the restricted likelihood of each linearised problem (each penalty is a Gaussian prior of unknown variance
# on its block), by the fixed point of Wood and Fasiolo (Biometrics 73 (2017) 1071):
#
#     lambda_j <- lambda_j * phi (size_j/lambda_j - tr V_jj) / |c_j|^2        V = (J^T J + Lambda)^-1
#
# phi V is the covariance of the coefficients seen as a posterior (Nychka 1988: intervals from it hold on average over
# the curve). It is the scatter that noise causes, phi V J^T J V, and an allowance for smoothing bias, phi V Lambda V;
# bodies bend less than draws of the prior do, and where noise hides the bending a part of the allowance is right. The
# lambdas are known the less the fewer the data, and so is how far errors of neighbours go together: the covariance is
# the mean over all that the data leave possible.
#
# Residuals come in rows (rows, n) in the order of recording. Neighbours in a row correlate by rho, AR(1), so that r_i
# - rho r_(i-1) are independent, and this change of variables belongs to the likelihood: rho and the lambdas are told
# apart together (Krivobokova and Kauermann, J. Am. Stat. Assoc. 102 (2007) 1328).

Linearised = tuple[Array, Array]  # residuals (rows, n) and their Jacobian (rows, n, p)
Residuals = Callable[[Array], Linearised]

# How the fit steps, how the penalties follow the data, and when both are settled.
PENALTY_LEAST = 1e-15  # lambda, in units of the mean diagonal of J^T J over the block; theory: round-off
PENALTY_MOST = 100.0  # and the largest; tuned on imported tables, by `make constants`: it leaves none of the block
# variance of a coefficient before data are seen; tuned on imported tables, by `make constants`: bodies do not bend
# more
PENALTY_MOST_PRIOR = 10.0
PENALTY_SPREAD = tuple(4.0**n for n in range(-7, 3))  # about a lambda; choice: beyond, weights vanish
PENALTY_BIAS = 0.2  # of the allowance for smoothing bias, in noise; tuned on noisy series, by `make noise-study`
PENALTY_FACTOR = 100.0  # most that an update changes a lambda by; tuned on noisy series, by `make tuning`
PENALTY_SETTLED = 0.02  # change of log(lambda); tuned on the same, by `make tuning`
PENALTY_FREEZE = 25  # steps, after which the lambdas stay; tuned on the same, by `make tuning`
PENALTY_STEPS = 50  # tuned on imported tables, by `make constants`: what has not settled then does not
PENALTY_DAMPING = 1e-8  # least, of the diagonal of the linearised problem; tuned on the same, by `make tuning`
PENALTY_POOR_STEP = 0.2  # below it the next step is damped (Levenberg); tuned on the same, by `make tuning`
PENALTY_HALVINGS = 30  # theory: down to a billionth of a step
# of a coefficient; tuned on imported tables, by `make constants`: all of them belong to logarithms
PENALTY_LONGEST_STEP = 5.0
PENALTY_TOLERANCE = 3e-2  # of a step, in standard deviations of the fit; tuned on the same, by `make tuning`
PENALTY_STUCK = 0.5  # standard deviations of a step still open at the end; choice: more is flagged as not settled
# Correlations of neighbours that are thought possible beside none; choice: beyond the last, noise is drift
PENALTY_CORRELATIONS = (0.15, 0.3, 0.45, 0.6, 0.7, 0.78, 0.85, 0.9, 0.94, 0.97, 0.985)
PENALTY_UNCORRELATED = 0.5  # probability of no correlation before data are seen; theory: as likely as any
PENALTY_WORTH = 2.0  # log of a likelihood ratio that makes a correlation believed; choice: none is simpler
PENALTY_BEYOND = 4.0  # standard errors of the residuals' own correlation; choice: above, none is tried
# tuned on imported tables, by `make constants`: residuals over those of the fit, beyond which a correlation's are
# not believed
PENALTY_LINEAR = 2.0


@dataclass(frozen=True, eq=False)
class PenalisedFit:
    """A penalised fit: coefficients ``c`` (p,) and what is left, residuals (rows, n), Jacobian (rows, n, p).

    Both before neighbours are decorrelated by ``rho``. ``lambdas`` of the ``blocks``: in units of the mean diagonal of
    J^T J. ``spent``: the effective number of parameters. ``settled``: whether the steps became small.
    ``phi_floor``: the least ``phi``, of round-off.
    """

    c: Array
    residuals: Array
    jacobian: Array
    blocks: Sequence[slice]
    rho: float
    phi: float
    phi_floor: float
    lambdas: Array
    spent: float
    settled: bool

    @property
    def independent(self) -> Array:
        """The residuals with the correlation ``rho`` of neighbours taken out, (rows, n)."""
        return decorrelated(self.residuals, self.rho)

    def flat(self, rho: float) -> Linearised:
        """Residuals and Jacobian with the correlation ``rho`` taken out."""
        return _flat((self.residuals, self.jacobian), rho)

    def response(self, change: Array) -> Array:
        """By how much the coefficients (p,) move with a ``change`` (rows, n) of the residuals, the lambdas as they
        are: -(J^T J + Lambda)^-1 J^T change."""
        J = self.flat(self.rho)[1]
        return -self._covariance @ (J.T @ decorrelated(change, self.rho).ravel())

    @property
    def scatter(self) -> Array:
        """Covariance (p, p) over ``phi`` of the coefficients by the scatter of the rows alone, V J^T J V."""
        J = self.flat(self.rho)[1]
        return self._covariance @ (J.T @ J) @ self._covariance

    @cached_property
    def _covariance(self) -> Array:
        """V = (J^T J + Lambda)^-1, (p, p)."""
        J = self.flat(self.rho)[1]
        normal, penalty = J.T @ J, np.zeros(self.c.size)
        for block, lam in zip(self.blocks, self.lambdas, strict=True):
            penalty[block] = lam * np.diag(normal)[block].mean()
        return _inverse(_factor(normal, penalty + 1e-15 * np.diag(normal).max()))


@dataclass(frozen=True, eq=False)
class _Linear:
    """The solution of one linearised problem."""

    step: Array
    penalty: Array
    phi: float
    lambdas: Array
    spent: float
    deviations: float


def decorrelated(values: Array, rho: float) -> Array:
    """Rows ``values`` (rows, n, ...) of which neighbours correlate by ``rho``, made independent at equal variance."""
    if rho == 0:
        return values
    out = values.copy()
    out[:, 1:] = (values[:, 1:] - rho * values[:, :-1]) / math.sqrt(1 - rho**2)
    return out


def minimise(
    residuals: Residuals,
    start: Array,
    blocks: Sequence[slice],
    phi_floor: float,
    lambdas: Array,
    freeze: int,
    rho: float,
) -> PenalisedFit:
    """The fit from ``start``. ``residuals(c)``: (r, Jacobian of r); ``lambdas``: first guess.

    After ``freeze`` steps the lambdas stay as they are.
    """
    c, damping = start, 0.0
    seen = residuals(c)
    for step in range(PENALTY_STEPS):
        now = _flat(seen, rho)
        linear = _linear(now, c, blocks, lambdas, phi_floor, damping, updates=MOST_STEPS if step < freeze else 0)
        lambdas = linear.lambdas
        c, seen, taken = _line_search(residuals, c, seen, linear, rho)
        moved = taken * linear.deviations
        if linear.deviations < PENALTY_TOLERANCE or moved < 1e-3 * PENALTY_TOLERANCE:
            break
        damping = (
            max(10 * damping, PENALTY_DAMPING)
            if taken < PENALTY_POOR_STEP
            else damping / 3 * (damping > PENALTY_DAMPING)
        )
    settled = moved < PENALTY_STUCK and (taken > 0 or linear.deviations < PENALTY_STUCK)
    return PenalisedFit(c, *seen, blocks, rho, linear.phi, phi_floor, lambdas, linear.spent, settled)


def _flat(seen: Linearised, rho: float) -> Linearised:
    """Residuals (m,) and Jacobian (m, p) with the correlation of neighbours taken out."""
    r, J = seen
    return decorrelated(r, rho).ravel(), decorrelated(J, rho).reshape(-1, J.shape[-1])


# ---------------------------------------------------------------------- what the data leave possible
@dataclass(frozen=True, eq=False)
class Posterior:
    """The mean over lambdas and correlations: ``V`` (p, p), covariance of the coefficients over the fit's phi.

    ``inner``: the same with no more smoothing bias than there is away from the ends; for what is read off within.
    ``rho``: the correlation of neighbours with the greatest probability; ``evidence``: log of the greatest likelihood
    of any over that of none.
    """

    V: Array
    inner: Array
    rho: float
    evidence: float


@dataclass(frozen=True, eq=False)
class _Guess:
    """One choice of the lambdas: its log likelihood, log of the coefficients' size, Cholesky factor, penalty, phi over
    the fit's, step to its minimum."""

    height: float
    log_size: float
    factor: Array
    penalty: Array
    ratio: float
    step: Array


def posterior(fit: PenalisedFit, noise: bool, correlated: bool) -> Posterior:
    """What lambdas and, where ``correlated``, correlations the data leave possible, and the covariance over all.

    The prior is even in the size of a block's coefficients, 1/sqrt(lambda) (Gelman 2006); that of ``inner``, in
    ``noise``, in the log of this size, for many bodies do not bend at all.
    """
    rhos = np.array(_possible(fit, PENALTY_CORRELATIONS)) if correlated else np.zeros(1)
    spread = PENALTY_SPREAD[1::2] if correlated else PENALTY_SPREAD
    priors = np.full(rhos.size, (1 - PENALTY_UNCORRELATED) / max(rhos.size - 1, 1))
    priors[0] = PENALTY_UNCORRELATED if correlated else 1.0
    best = [_at_best(fit, float(rho)) for rho in rhos]
    heights = np.array([height for height, _ in best])
    guesses: list[_Guess] = []
    masses = np.full(rhos.size, -np.inf)
    for i, rho in enumerate(rhos):
        if heights[i] > heights.max() + math.log(UNSEEN):
            weight = _log_det(fit, rho) + math.log(priors[i])
            of_rho = list(_guesses(fit, fit.flat(rho), best[i][1], weight, spread))
            masses[i] = np.logaddexp.reduce([guess.height for guess in of_rho])
            guesses += of_rho
    full = _mean_covariance(guesses, fit.phi, 1.0, 1.0)
    inner = _mean_covariance(guesses, fit.phi, 0.0, PENALTY_BIAS) if noise else full
    return Posterior(full, inner, float(rhos[np.argmax(masses)]), float(heights.max() - heights[0]))


def _possible(fit: PenalisedFit, rhos: Sequence[float]) -> tuple[float, ...]:
    """0 and those of ``rhos`` that the residuals' own correlation allows, and what the fit has taken from it: beyond,
    a likelihood is that of a linearised fit far from where it holds."""
    r, n = fit.residuals, fit.residuals.shape[1]
    lag1 = float(np.sum(r[:, 1:] * r[:, :-1]) / max(np.sum(r**2), TINY))
    limit = lag1 + PENALTY_BEYOND / math.sqrt(n) + (1 + 3 * max(lag1, 0.0)) * fit.spent / n
    return (0.0, *(rho for rho in rhos if rho <= limit))


def _log_det(fit: PenalisedFit, rho: float) -> float:
    """Log of the determinant of what ``decorrelated`` does to the rows."""
    rows, n = fit.residuals.shape
    return -rows * (n - 1) / 2 * math.log1p(-(rho**2))


def _at_best(fit: PenalisedFit, rho: float) -> tuple[float, Array]:
    """Log of the restricted likelihood of ``rho`` at its best lambdas, and these times the scales of their blocks.

    Minus infinity where it is that of a step so long that the linearised problem says nothing of it.
    """
    now, lambdas = fit.flat(rho), fit.lambdas
    if rho != fit.rho:
        lambdas = _linear(now, fit.c, fit.blocks, lambdas, fit.phi_floor, 0.0, MOST_STEPS).lambdas
    diagonal = np.einsum("mp,mp->p", now[1], now[1])
    best = np.array([lam * diagonal[block].mean() for lam, block in zip(lambdas, fit.blocks, strict=True)])
    (guess,) = _guesses(fit, now, best, _log_det(fit, rho), (1.0,))
    there = np.sum((fit.residuals + fit.jacobian @ guess.step) ** 2)
    return guess.height if there <= PENALTY_LINEAR**2 * np.sum(fit.residuals**2) else -math.inf, best


def _guesses(
    fit: PenalisedFit, now: Linearised, best: Array, log_prior: float, spread: tuple[float, ...]
) -> Iterator[_Guess]:
    """All lambdas about the best ones with their restricted likelihood: others are part of the error."""
    (r, J), c, blocks = now, fit.c, fit.blocks
    normal, gradient = J.T @ J, J.T @ r
    ridge = 1e-15 * np.diag(normal).max()
    free = r.size - c.size + sum(c[block].size for block in blocks)
    for factors in itertools.product(spread, repeat=len(blocks)):
        penalty, log_weight, log_size = np.zeros(c.size), log_prior, 0.0
        for block, lam, factor in zip(blocks, best, factors, strict=True):
            penalty[block] = lam * factor
            log_weight += c[block].size * math.log(lam * factor) / 2
            log_size -= math.log(lam * factor) / 2
        system = _factor(normal, penalty + ridge)
        step = -_solve(system, gradient + penalty * c)
        objective = float(r @ r + 2 * gradient @ step + step @ normal @ step + penalty @ (c + step) ** 2)
        phi = max(objective / free, fit.phi_floor)
        log_det = 2 * float(np.log(np.diag(system)).sum())
        height = log_weight - (log_det + free * math.log(phi) + objective / phi) / 2
        yield _Guess(height, log_size, system, penalty, phi / fit.phi, step)


def _mean_covariance(guesses: Sequence[_Guess], phi: float, prior: float, bias: float) -> Array:
    """Covariance over ``phi`` of the mixture of all guesses, about where the fit stands, with the part ``bias`` of the
    allowance for smoothing bias; ``prior``: power of the coefficients' size."""
    heights = np.array([guess.height + prior * guess.log_size for guess in guesses])
    weights = np.exp(heights - heights.max())
    V = np.zeros_like(guesses[0].factor)
    for weight, guess in zip(weights / weights.sum(), guesses, strict=True):
        if weight > UNSEEN:
            posterior_V = _inverse(guess.factor)
            allowance = (1 - bias) * (posterior_V * guess.penalty) @ posterior_V if bias < 1 else 0.0
            V += weight * (guess.ratio * (posterior_V - allowance) + np.outer(guess.step, guess.step) / phi)
    return V


def _factor(normal: Array, added: Array) -> Array:
    """Upper Cholesky factor of ``normal`` with ``added`` on its diagonal."""
    system = normal.copy()
    system.flat[:: added.size + 1] += added
    factor, wrong = lapack.dpotrf(system.T, overwrite_a=True)  # in place: LAPACK's order is by columns
    if wrong:
        raise np.linalg.LinAlgError("the penalised normal matrix is not positive definite")
    return np.asarray(factor)


def _solve(factor: Array, right: Array) -> Array:
    return np.asarray(lapack.dpotrs(factor, right)[0])


def _inverse(factor: Array) -> Array:
    upper = lapack.dpotri(factor)[0]  # zero below the diagonal, as its factor is
    full: Array = upper + upper.T
    full.flat[:: upper.shape[0] + 1] /= 2
    return full


def _linear(
    now: Linearised, c: Array, blocks: Sequence[slice], lambdas: Array, phi_floor: float, damping: float, updates: int
) -> _Linear:
    """The linearised problem solved at ``c``, its lambdas iterated to the maximum of the restricted likelihood."""
    r, J = now
    normal, gradient = J.T @ J, J.T @ r
    diagonal = np.diag(normal)
    scales = np.array([diagonal[block].mean() for block in blocks])
    for update in range(updates + 1):
        penalty = np.zeros(c.size)
        for block, lam in zip(blocks, lambdas * scales, strict=True):
            penalty[block] = lam
        V = _inverse(_factor(normal, penalty + 1e-15 * diagonal.max()))
        step = -V @ (gradient + penalty * c)
        spent = float(np.sum(V * normal))
        rss = max(float(r @ r + 2 * gradient @ step + step @ normal @ step), 0.0)
        phi = max(rss / max(r.size - spent, 1.0), phi_floor)
        if update == updates:
            break
        updated, ahead = np.empty_like(lambdas), c + step
        for i, (block, lam, scale) in enumerate(zip(blocks, lambdas, scales, strict=True)):
            x = ahead[block]
            free = max(x.size - lam * scale * float(np.trace(V[block, block])), 1e-12 * x.size)
            rough = max(lam * scale * float(x @ x), TINY)
            ratio = np.clip(phi * free / rough, 1 / PENALTY_FACTOR, PENALTY_FACTOR)
            updated[i] = np.clip(lam * ratio, max(PENALTY_LEAST, phi / (scale * PENALTY_MOST_PRIOR)), PENALTY_MOST)
        if np.abs(np.log(updated / lambdas)).max() < PENALTY_SETTLED:
            break
        lambdas = updated
    system = normal + np.diag(penalty + 1e-15 * diagonal.max())
    deviations = float(np.sqrt(max(step @ system @ step, 0.0) / phi))
    if damping > 0:
        step = -_solve(_factor(system, damping * np.diag(system)), gradient + penalty * c)
    return _Linear(step, penalty, phi, lambdas, spent, deviations)


def _line_search(
    residuals: Residuals, c: Array, now: Linearised, linear: _Linear, rho: float
) -> tuple[Array, Linearised, float]:
    """The first of the steps 1, 1/2, 1/4 ... that does not raise the objective by more than a rounding of phi."""

    def objective(r: Array, c: Array) -> float:
        return float(np.sum(decorrelated(r, rho) ** 2) + linear.penalty @ c**2)

    before = objective(now[0], c) + 1e-6 * linear.phi
    taken = min(1.0, PENALTY_LONGEST_STEP / max(float(np.max(np.abs(linear.step))), TINY))
    for _ in range(PENALTY_HALVINGS):
        trial = c + taken * linear.step
        there = residuals(trial)
        if objective(there[0], trial) <= before:
            return trial, there, taken
        taken /= 2
    return c, now, 0.0


# --------------------------------------------------------------------------------------------------
# The scatter of the data about a fitted model: how much of it each column carries, and where.
#
# Relative variances of a, delta and P at every point. An error of the radius moves delta and P together, by the
# slopes k = dlog(delta)/dlog(a) and m = dlog(P)/dlog(a) (effective variance; Orear, Am. J. Phys. 50 (1982) 912):
#
#     cov(log delta, log P) = diag(var_delta, var_P) + var_a (k, m)^T (k, m)

# What the residuals are believed to tell about the scatter of the data.
SCATTER_TRACE = 1e-3  # the least share of a column; tuned on noisy series, by `make tuning`
SCATTER_MOST_TREND = 4.0  # exponent of the variance over the radius; tuned on the same, by `make tuning`
SCATTER_OUTLIER = 3.0  # standard deviations where points begin to count less; tuned on the same, by `make tuning`
SCATTER_FREE = 20  # points that tell the errors of a, delta, P apart; tuned on the same, by `make tuning`
SCATTER_FALSE = 5e-3  # probability of an outlier reported in a series without any; choice: rare
SCATTER_CHANCE = 2.5  # theory: standard deviations of the correlation of neighbours that chance brings once in 160


def whitener(variances: Array, k: Array, m: Array) -> Array:
    """Inverse Cholesky factors, shape (2, 2, n), of the covariance of (log delta, log P)."""
    radius, delta, P = np.broadcast_to(variances, (3, k.size))
    l11 = np.sqrt(delta + k**2 * radius)
    l21 = k * m * radius / l11
    l22 = np.sqrt(P + m**2 * radius * delta / (delta + k**2 * radius))
    out = np.zeros((2, 2, k.size))
    out[0, 0] = 1 / l11
    out[1, 0], out[1, 1] = -l21 / (l11 * l22), 1 / l22
    return out


def estimate(x: Array, residuals: Array, k: Array, m: Array, spent: float, floor: float) -> tuple[Array, Array]:
    """The scatter that ``residuals`` (2, n) of log delta and log P at ``x`` show: relative variances (3, n) of a,
    delta, P, the largest share being 1, and which points (n,) are outliers.

    Three shares by moments, a power law of the radius by maximum likelihood, and less weight for points far out: those
    that chance does not bring count as one standard deviation off. Few points tell neither shares nor power.
    ``spent``: effective number of parameters of the fit; ``floor``: variance below which nothing is known.
    """
    shares, size = np.ones((3, 1)), np.ones(x.size)
    inliers = np.ones(x.size, dtype=bool)
    for round_ in range(MOST_SOLVES):
        if x.size >= SCATTER_FREE:
            shares = _shares(residuals[:, inliers], k[inliers], m[inliers], spent, floor)
        white = np.einsum("ijn,jn->in", whitener(shares, k, m), residuals)
        squares = np.mean(white**2, axis=0)
        if not np.mean(squares[inliers]) > floor:
            return np.ones((3, x.size)), np.zeros(x.size, dtype=bool)
        if x.size >= SCATTER_FREE:
            # Exponent b of variance ~ a^b: the maximum of the Gaussian likelihood, one size parameter profiled out
            seen, centred = squares[inliers], x[inliers] - x[inliers].mean()
            trend = minimize_scalar(
                lambda b, seen=seen, centred=centred: float(np.log(np.mean(seen * np.exp(-b * centred)))),
                bounds=(-SCATTER_MOST_TREND, SCATTER_MOST_TREND),
                method="bounded",
            )
            size = np.exp(float(trend.x) * x)
        relative = squares / size
        # theory: the sum of two squares is exponential, of median log 2; outliers hide in a mean that holds them
        unit = np.median(relative) / math.log(2) if round_ == 0 else np.mean(relative[inliers])
        # The square, in units of the mean of free others, that chance brings among all with probability
        # SCATTER_FALSE: both are exponential, so that their ratio exceeds t with probability (1 + t/free)^-free
        free = max(inliers.sum() - spent / 2, 2.0)
        rare = float(free * math.expm1(math.log(x.size / SCATTER_FALSE) / free))
        before, inliers = inliers, relative <= unit * rare
        if round_ > 0 and (before == inliers).all():
            break
    distance = np.sqrt(relative / np.mean(relative[inliers]))
    far = np.where(inliers, np.maximum(1.0, distance / SCATTER_OUTLIER), distance)
    return shares * size * far**2, ~inliers


def _shares(residuals: Array, k: Array, m: Array, spent: float, floor: float) -> Array:
    """Relative variances of a, delta and P, shape (3, 1), largest 1: the three second moments hold all three."""
    r, s = residuals
    n = r.size
    freedom = max(n - spent / 2, 1.0) / n
    radius = max(float(np.mean(r * s / (k * m))), 0.0) / freedom
    delta = float(np.mean(r**2)) / freedom - radius * float(np.mean(k**2))
    P = float(np.mean(s**2)) / freedom - radius * float(np.mean(m**2))
    largest = max(radius, delta, P)
    if largest <= floor:
        return np.ones((3, 1))
    return np.maximum(np.array([[radius], [delta], [P]]) / largest, SCATTER_TRACE)


def correlation_length(residuals: Array) -> float:
    """Number of neighbours in each row of ``residuals`` (rows, n), in order, that are worth one independent value:
    1 + 2 sum of the autocorrelations up to the first that is not positive, of the worst row; 1 where neighbours
    correlate by no more than chance brings, 1/sqrt(n). (Geyer, Statist. Sci. 7 (1992) 473, Sec. 3.3.)"""
    n = residuals.shape[1]
    lengths = [1.0]
    for row in residuals:
        correlations = np.correlate(row, row, "full")[n:] / max(float(row @ row), TINY)
        if correlations[0] * np.sqrt(n) > SCATTER_CHANCE:
            positive = np.logical_and.accumulate(correlations > 0)
            lengths.append(1 + 2 * float(correlations[positive].sum()))
    return max(lengths)


TOO_FEW = "the correlation of neighbouring rows cannot be estimated from so few points"
UNSETTLED = "the fit did not converge: a, delta and P contradict each other; look for outliers"

# The rounds of the rule "integral".
INTEGRAL_FEWEST = 5  # points; theory: two power laws have four parameters
INTEGRAL_DECADES = 12.0  # of a - a0; choice: the grid grows with them, a series over more has a radius out of place
INTEGRAL_INTERVALS = 24  # of the splines, twice as many if need be; tuned on noisy series, by `make tuning`
INTEGRAL_MOST_BINS = 400  # of points; choice: more points are fitted no better
INTEGRAL_STIFF = 1e-2  # penalty of the first fit over what the data weigh; tuned on the same, by `make tuning`
INTEGRAL_NOISE = 3e-4  # relative scatter above which it is noise; choice: below, splines do not bend
INTEGRAL_TELL_CORRELATION = 20  # points that tell correlations; tuned on the same, by `make noise-study`
INTEGRAL_EVIDENCE = 3.5  # log of a likelihood ratio from which correlation is reported; theory: by chance once in 250
INTEGRAL_RECORDED = 0.9  # rank correlation with x of rows in the order of recording; choice: noise leaves more
INTEGRAL_SHARE = 1e-2  # least of the variances of a, delta, P in later rounds; tuned on the same, by `make tuning`
INTEGRAL_BESIDE = 4  # choice: rows on either side that tell a radius far off; three outliers among them do no harm
INTEGRAL_FAR = 8.0  # choice: standard deviations; the fit itself finds what is nearer
# Of the errors of the radii, each the largest of many rows, what is left of them in a smooth fit:
INTEGRAL_RADII = 0.1  # tuned on random bodies, by `make bounds`
INTEGRAL_RATES = 1.5  # and of the rates; tuned on random bodies, by `make bounds`
# Of the variance of loads, what all columns share where each mesh is one stiffness that is too large:
INTEGRAL_OF_MESHES = 0.98  # tuned on series of finite elements in increments, by `make node-study`
INTEGRAL_FLOOR = 1e-7  # theory: of the scatter, accuracy of the model's own integrals and linear algebra


@dataclass(frozen=True, eq=False)
class _Data:
    """Scaled logs of the data, many of them put together in bins of equal number; few stay alone.

    ``order``: that of recording where x follows it, as neighbours in it share their errors, else that of x; of all
    else, ``lever``: dx/dlog(a) = a/(a - a0), (n,), which grows without bound at the edge of a flat end; ``measured``
    (2, n): logs of delta and P; ``stated``: relative variances of (a, delta, P), (3, n), or None; ``shift``: half-width
    (n,) of an error of x that all rows share, where their radii are those of nodes, else None: then the stated
    variances are what rows err by, at least.
    """

    order: Array
    x: Array
    lever: Array
    measured: Array
    stated: Array | None
    shift: Array | None = None

    @cached_property
    def bins(self) -> tuple[Array, Array]:
        """The first point of each bin, and how many points are in it."""
        # of one size: where some hold one point and some two, the noise left in them differs as it does not along the
        # record, and correlation is estimated too small
        starts = np.arange(0, self.x.size, -(-self.x.size // INTEGRAL_MOST_BINS))
        return starts, np.diff(np.append(starts, self.x.size))

    def mean(self, values: Array) -> Array:
        """Means over the bins, of values (..., n)."""
        starts, counts = self.bins
        return np.add.reduceat(values, starts, axis=-1) / counts


def integral(series: Series) -> Slopes:
    """S, S', and the smoothed delta_H and P_H, at the radii of ``series``; refused below 5 points."""
    raw = RawSeries(series.a, series.delta, series.P)
    settled = _settle(raw, series.errors, series.a0, series.S0, series.own)
    return _slopes(settled, raw, series.errors, series.a0, series.a)


def smoothed(
    raw: RawSeries, a0: float = 0.0, S0: float | None = 0.0, own: Series | None = None, ahead: Ahead = AS_THEY_ARE,
    load_errors: Array | None = None,
) -> tuple[Series, Slopes]:  # fmt: skip
    """A series and its slopes from increments, also where they are too noisy to be a series (columns out of order).

    Where radii are those of nodes, the moments at which the next node is reached are found first, the edge being
    ``ahead`` of it (``Ahead``); ``load_errors`` (2, m): relative half-widths of the loads at equal depth,
    which rows share, over displacements [m]. The series holds the fitted columns at the data's radii, sorted and
    without repeats, but for those of outliers beyond all others.
    """
    nodes, errors, shift = node_radii(raw), dict[str, Array](), None
    raw = raw.touching
    if nodes is not None:
        touches = nodes.touches(ahead.elements)
        there = touches.rows.a > a0
        raw, errors, shift = touches.rows.only(there), {"a": touches.errors[there]}, ahead.left * touches.element[there]
    settled = _settle(raw, errors, a0, S0, own, shift)
    inliers = np.delete(raw.a, settled.outliers)
    a = np.unique(raw.a[(raw.a >= inliers.min()) & (raw.a <= inliers.max())])
    # where nodes are reached is known for each by itself: it is scatter, which the fit has
    of_loads = {} if load_errors is None else {"P": raw.P * np.interp(raw.delta, *load_errors)}
    fitted = _slopes(settled, raw, of_loads, a0, a)
    assert fitted.delta is not None
    assert fitted.P is not None
    return Series(a, fitted.delta, fitted.P, a0=a0, S0=S0, own=own), fitted


def _settle(
    raw: RawSeries, errors: Mapping[str, Array], a0: float, S0: float | None, own: Series | None,
    shift: Array | None = None,
) -> _Settled:  # fmt: skip
    """The fit of the columns (n,), in units of their largest values; ``shift`` (n,) [m]: half-width of an error that
    the radii of nodes share, whose ``errors`` are those of each row for itself, however little rows scatter about a
    fit: they keep in step with the increments."""
    data = _prepare(raw, errors, a0)
    if shift is not None:
        data = replace(data, shift=(shift / (raw.a - a0))[data.order])
    shape = None if own is None else Shape.of(own, float(np.max(raw.a) - a0))
    # The fit with the knots that the data need; residuals still correlated count as that many fewer data
    S0 = None if S0 is None else S0 * float(np.max(raw.delta)) / float(np.max(raw.P))
    for intervals in (INTEGRAL_INTERVALS, 2 * INTEGRAL_INTERVALS):
        settled = _fit(_Task(LogSplineModel(data.x, intervals, S0, shape), data))
        length = 1.0 if _explained(settled.fit, data) else correlation_length(settled.fit.independent)
        if length == 1 and settled.known.rho < max(PENALTY_CORRELATIONS):
            break
    inflated = replace(settled.known, V=length * settled.known.V, inner=length * settled.known.inner)
    return replace(settled, known=inflated)


def _slopes(settled: _Settled, raw: RawSeries, errors: Mapping[str, Array], a0: float, wanted: Array) -> Slopes:
    """The slopes at the radii ``wanted`` (m,) from the ``settled`` fit of the columns (n,)."""
    a, fit = raw.a, settled.fit
    y_scale, delta_scale, P_scale = float(np.max(a) - a0), float(np.max(raw.delta)), float(np.max(raw.P))
    S_scale = P_scale / delta_scale
    x = np.log((wanted - a0) / y_scale)
    scales = np.array([delta_scale, P_scale, S_scale, S_scale / y_scale, delta_scale / y_scale, S_scale / y_scale**2])
    values, covariance, joint = _evaluate(settled, x, scales)
    delta_H, P_H, S, dS = values
    if errors:
        order = np.argsort(a)
        there = {name: np.interp(wanted, a[order], errors[name][order]) for name in errors}
        if "P" in there:  # S and S' are those of the fit: P's errors, which vary as slowly, or the series' own if less
            of_P = {"S": there["P"] / P_H * S, "dS": there["P"] / P_H * dS}
            there |= {name: np.minimum(error, there.get(name, error)) for name, error in of_P.items()}
        if "a" in there:
            there["a"] = INTEGRAL_RADII * there["a"]
        common = INTEGRAL_OF_MESHES if settled.of_nodes else ERROR_COMMON
        stated = covariance_from_errors(wanted, there, dS, ERROR_AT_DISPLACEMENT, common)
        assert stated is not None
        # what the scatter does not show is shared by all points; that of nodes shows nothing of it
        shared = stated if settled.of_nodes else max(0.0, 1 - fit.phi) * stated
        joint[:, :4, :4] += shared
        # rates in their logs err as columns do that err smoothly: d(delta_H)/da as the radius, S'' as S'
        if wanted.size > 1 and "a" in there:
            of_radius = INTEGRAL_RATES / INTEGRAL_RADII * there["a"] / wanted / HALF_WIDTH
            joint[:, 4, 4] += (np.gradient(delta_H, wanted) * of_radius) ** 2
            joint[:, 5, 5] += (2 * dS / wanted * of_radius) ** 2
        covariance += shared
    # Degrees of freedom of the scatter (Satterthwaite, Biometrics Bull. 2 (1946) 110): those of all residuals
    # where both columns carry as much of it, of half of them where one does, or where an error of the radius is
    # in both
    rows = fit.independent
    carried = np.linalg.eigvalsh(rows @ rows.T)
    share = float(np.sum(carried) ** 2 / max(carried.size * np.sum(carried**2), TINY))
    freedom = max((rows.size - fit.spent) * max(share, 1 / carried.size), 1.0)
    # scatter of a size that is known beforehand, that of nodes, is normal
    known_size = settled.of_nodes and fit.phi <= fit.phi_floor
    quantile = HALF_WIDTH if known_size else float(stdtrit(freedom, (1 + LEVEL) / 2))
    error = Unknown(TOO_FEW) if settled.hidden else shift_error(dS, covariance, quantile)
    known = {} if settled.hidden else {"covariance": covariance, "joint": joint}
    columns = {"delta": delta_H, "P": P_H, **known}
    flags, rho = tuple(_flags(settled, raw)), settled.correlation
    return Slopes(S, dS, "integral", error, float(fit.lambdas[1]), flags, quantile=quantile, correlation=rho, **columns)


def _flags(settled: _Settled, raw: RawSeries) -> Iterator[str]:
    """Sentences on what is wrong with the data."""
    if not settled.fit.settled:
        yield UNSETTLED
    rows = [str(row) for row in np.sort(raw.rows[settled.outliers])]
    if rows:
        some = ", ".join(rows[:SHOWN]) + (", ..." if len(rows) > SHOWN else "")
        are = "is an outlier and has" if len(rows) == 1 else "are outliers and have"
        yield f"{len(rows)} of {raw.a.size} rows {are} little weight: {some}"
    if settled.hidden:
        yield f"errors of neighbouring rows may be correlated; {TOO_FEW} ({raw.a.size})"
    rho = settled.correlation
    if isinstance(rho, float) and rho > 0 and settled.known.evidence > INTEGRAL_EVIDENCE:
        bins = settled.fit.residuals.size / 2
        worth = bins * (1 - rho) / (1 + rho)
        yield (
            f"errors of neighbouring rows are autocorrelated ({rho:.2f}): effective sample size {max(worth, 1):.0f} of "
            f"{raw.a.size} rows, in the stated error"
        )


def _evaluate(settled: _Settled, x: Array, scales: Array) -> tuple[Array, Array, Array]:
    """delta_H, P_H, S, S' in SI at the log radii ``x``, shape (4, m), their covariance, (m, 4, 4), and that, (m, 6, 6),
    of these, d(delta_H)/da and S'' away from the ends, from those of the coefficients."""
    model, fit = settled.model, settled.fit
    basis, y = model.design(x), np.exp(x)[:, None]
    columns = model.columns(fit.c, model.interpolation(x), basis)
    values = np.exp(columns.logs)
    jacobian = np.zeros((6, *columns.jacobian.shape[1:]))
    jacobian[:4] = columns.jacobian * values[:, :, None]
    jacobian[4, :, model.v] = np.exp(model.of_shape(x)[0] + basis @ fit.c[model.v])[:, None] * basis
    bend = model.design(x, 1)  # S'' = S' u'(x)/y
    rate = model.of_shape(x, 1)[1] + bend @ fit.c[model.u]
    jacobian[5, :, model.u] = values[3][:, None] / y * (rate[:, None] * basis + bend)
    jacobian *= scales[:, None, None]
    full, shared = jacobian[:4], np.outer(settled.by_shift, settled.by_shift) / HALF_WIDTH**2
    of_all, of_inner = (fit.phi * V + shared for V in (settled.known.V, settled.known.inner))
    covariance = np.einsum("imp,pq,jmq->mij", full, of_all, full, optimize=True)
    joint = np.einsum("imp,pq,jmq->mij", jacobian, of_inner, jacobian, optimize=True)
    return values * scales[:4, None], covariance, joint


def _prepare(raw: RawSeries, errors: Mapping[str, Array], a0: float) -> _Data:
    a, delta, P = raw.a, raw.delta, raw.P
    usable = (a > a0) & (delta > 0) & (P > 0)
    different = np.unique(a[usable]).size
    if different < INTEGRAL_FEWEST:
        raise Refusal(
            f"slopes 'integral': needs at least {INTEGRAL_FEWEST} points with different contact radii, delta > 0 and "
            f"P > 0, got {different}; give more increments, or refine the mesh where radii repeat"
        )
    if not usable.all():
        i = int(np.argmin(usable))
        raise InputError(
            f"slopes 'integral': point {i + 1} has a = {a[i]:g} m, delta = {delta[i]:g} m, P = {P[i]:g} N; all must be "
            "positive: drop it"
        )
    stated = None
    columns = {"a": a, "delta": delta, "P": P}
    if any(np.any(errors[name] > 0) for name in columns.keys() & errors):
        stated = np.stack([(errors.get(name, 0 * v) / v / HALF_WIDTH) ** 2 for name, v in columns.items()])
    y = a - a0
    decades = np.log10(y)
    if np.ptp(decades) > INTEGRAL_DECADES:  # more than a series has: the radius that lies farthest off
        i = int(np.argmax(np.abs(decades - np.median(decades))))
        raise InputError(
            f"slopes 'integral': point {i + 1} has a = {a[i]:g} m, radii beyond the flat end differ by "
            f"{np.ptp(decades):.0f} decades, at most {INTEGRAL_DECADES:g} are fitted: drop it"
        )
    x, logs = np.log(y / np.max(y)), np.log([delta / np.max(delta), P / np.max(P)])
    # The order of recording where x follows it, else that of x
    recorded = np.arange(x.size)
    ranks = np.argsort(np.argsort(x, kind="stable"), kind="stable")
    follows = float(np.corrcoef(recorded, ranks)[0, 1]) > INTEGRAL_RECORDED
    order = recorded if follows else np.argsort(x, kind="stable")
    return _Data(order, x[order], (a / y)[order], logs[:, order], None if stated is None else stated[:, order])


class _Task:
    """The data as a least-squares problem: residuals of log delta and log P, whitened, over bins of points."""

    def __init__(self, model: LogSplineModel, data: _Data):
        self.model, self.data, x = model, data, data.mean(data.x)
        self.blocks = (model.rough_v, model.rough_u)
        self.at, self.basis = model.interpolation(x), model.design(x)
        self.everywhere = model.interpolation(data.x)

    def difference(self, grid: OnGrid) -> Array:
        """Model minus data at every point, shape (2, n)."""
        (log_delta, _), (log_P, _), _ = grid
        return np.stack([interpolate(self.everywhere, *pair) for pair in (log_delta, log_P)]) - self.data.measured

    def minimise(
        self, start: Array, variances: Array, lambdas: Array, floor: float, freeze: int, rho: float = 0.0
    ) -> PenalisedFit:
        """The fit with given relative variances of (a, delta, P), (3, n), the radius' slopes taken at ``start``."""
        data, whiten = self.data, self._whitener(start, variances)[0]

        def residuals(c: Array) -> tuple[Array, Array]:
            grid = self.model.on_grid(c)
            white = np.einsum("ijn,jn->in", whiten, data.mean(self.difference(grid)))
            jacobian = self.model.columns(c, self.at, self.basis, grid).jacobian[:2]
            return white, np.einsum("ijn,jnp->inp", whiten, jacobian)

        return minimise(residuals, start, self.blocks, floor, lambdas, freeze, rho)

    def _whitener(self, c: Array, variances: Array) -> tuple[Array, Array]:
        """What whitens residuals of relative ``variances`` (3, n), (2, 2, bins), and the rates (2, bins) over x of log
        delta and log P, at the coefficients ``c``."""
        data, rates = self.data, self.model.columns(c, self.at, self.basis).rates
        k, m = rates * data.mean(data.lever)
        return whitener(data.mean(variances), k, m) * np.sqrt(data.bins[1]), rates

    def by_shift(self, fit: PenalisedFit, variances: Array) -> Array:
        """By how much the coefficients (p,) of the ``fit`` move with the error that all rows share."""
        if self.data.shift is None:
            return np.zeros(fit.c.size)
        whiten, rates = self._whitener(fit.c, variances)
        return fit.response(np.einsum("ijn,jn->in", whiten, rates * self.data.mean(self.data.shift)))

    def scatter(self, fit: PenalisedFit) -> tuple[Array, Array]:
        """The scatter of a, delta and P as the residuals of ``fit`` show it: variances, outliers."""
        grid = self.model.on_grid(fit.c)
        columns = self.model.columns(fit.c, self.at, self.basis, grid)
        k, m = (self.data.lever * np.repeat(rate, self.data.bins[1]) for rate in columns.rates)
        return estimate(self.data.x, self.difference(grid), k, m, fit.spent, INTEGRAL_FLOOR**2)


@dataclass(frozen=True, eq=False)
class _Settled:
    """A fit with all that was ``known`` in the end: ``outliers``: their points; ``noisy``: whether the residuals are
    noise; ``few``: whether the points are too few to tell its correlation; ``by_shift`` (p,): half-width of the
    coefficients by an error that all rows share; ``of_nodes``: whether the radii are those of nodes."""

    model: LogSplineModel
    fit: PenalisedFit
    known: Posterior
    outliers: Array
    noisy: bool
    few: bool
    by_shift: Array
    of_nodes: bool

    @property
    def hidden(self) -> bool:
        """Whether too few points seem to have correlated errors."""
        return self.noisy and self.few and correlation_length(self.fit.residuals) > 1

    @property
    def correlation(self) -> Estimate | None:
        """The correlation of neighbours, or why it is unknown; None where the residuals are no noise."""
        if not self.noisy:
            return None
        return Unknown(TOO_FEW) if self.few else self.known.rho


def _explained(fit: PenalisedFit, data: _Data) -> bool:
    """Whether round-off, or the stated errors, explain the residuals."""
    return fit.phi <= fit.phi_floor or (data.stated is not None and fit.phi <= 1)


def _fit(task: _Task) -> _Settled:
    """The fit with penalties found from the data, in rounds, each with the scatter that the one before has shown."""
    stiff = np.full(len(task.blocks), INTEGRAL_STIFF)
    data, stated, of_nodes = task.data, task.data.stated, task.data.shift is not None
    variances = _far_off(data) * np.ones((3, 1)) if stated is None else stated
    best: PenalisedFit | None = None
    used = variances  # by the best fit
    outliers = np.zeros(data.x.size, dtype=bool)
    rho, noisy, many = 0.0, False, data.x.size >= INTEGRAL_TELL_CORRELATION
    for share in (1.0, INTEGRAL_SHARE, INTEGRAL_SHARE):
        variances = np.maximum(variances, np.maximum(share * variances.max(axis=0), INTEGRAL_FLOOR**2))
        floor = 1.0 if of_nodes else INTEGRAL_FLOOR**2 / float(np.mean(variances))
        # a stiff fit first: far from the solution a linearised one takes all for signal
        start = best or task.minimise(_start(task), variances, stiff, floor, 0)
        fit = task.minimise(start.c, variances, start.lambdas, floor, PENALTY_FREEZE, rho)
        if best is not None and not fit.settled:
            break  # weights too uneven to go on: the last fit stands
        if fit.settled:
            # noise, rather than what the splines cannot bend to?
            scatter = math.sqrt(fit.phi * float(np.mean(np.median(variances, axis=1))))
            best, used = fit, variances
            noisy = data.stated is None and not _explained(fit, data) and scatter > INTEGRAL_NOISE
        if stated is None and fit.phi <= floor:
            break
        if stated is None:
            variances, outliers = task.scatter(best or start)
        else:
            variances = stated
        rho = 0.0
        if best is not None and noisy and many:
            # The likeliest correlation of every other up to 0.9: a fit that leaves more to it follows what drifts
            rhos = _possible(best, PENALTY_CORRELATIONS[1:8:2])
            heights = [_at_best(best, rho)[0] for rho in rhos]
            heights[0] += PENALTY_WORTH
            rho = rhos[int(np.argmax(heights))]
    fit = best or fit
    known = posterior(fit, noisy, noisy and many)
    if of_nodes:
        known = replace(known, inner=fit.scatter)
    by_shift = task.by_shift(fit, used)
    return _Settled(task.model, fit, known, data.order[outliers], noisy, not many, by_shift, of_nodes)


def _far_off(data: _Data) -> Array:
    """Relative variances (n,) of the first fit, in the order of recording: 1, and more for rows whose radius lies far
    off what their load and displacement, beside those of their neighbours, make of it: a radius beyond all others bends
    any spline to itself."""
    x, load = data.x, np.sum(data.measured, axis=0)
    n, reach = x.size, INTEGRAL_BESIDE
    if n <= 2 * reach + 1:
        return np.ones(n)
    rows = np.arange(n)[:, None] + np.array([j for j in range(-reach, reach + 1) if j])
    rows = np.where((rows >= 0) & (rows < n), rows, rows - np.sign(rows) * (2 * reach + 1))  # at the ends one-sided
    exponent = float(np.median(x[n // 2 :] - x[: -(n // 2)]) / np.median(load[n // 2 :] - load[: -(n // 2)]))
    expected = exponent * (load[:, None] - load[rows])
    gap = np.abs(x - np.median(x[rows] + expected, axis=1))
    usual = float(np.median(gap)) / 0.6745  # theory: the median of the size of a normal number
    # theory: an exponent that changes along the record moves a row by no more than the way to its neighbours
    far = gap > np.maximum(INTEGRAL_FAR * usual, np.median(np.abs(expected), axis=1))
    return np.where(far, (gap / max(usual, INTEGRAL_FLOOR)) ** 2, 1.0)


def _start(task: _Task) -> Array:
    """Coefficients of the bodies' own shape, brought to the level of the data; else of power laws through their logs.
    The large radii count most, they are surest."""
    if task.model.shape is None:
        # Coefficients of straight lines through the logs of the data.
        (k, log_k), (m, log_m) = (
            np.polyfit(task.data.x, logs, 1, w=np.exp(task.data.x)) for logs in task.data.measured
        )
        k = max(float(k), 0.2)
        excess = max(float(m) - k, 0.2)
        log_S = float(np.log(1 + excess / k)) + log_m - log_k  # S = P' / delta'
        half = float(np.log(0.5)) if task.model.S0 is None or task.model.S0 > 0 else 0.0
        v = (float(np.log(k) + log_k), k - 1)
        u = (float(np.log(excess)) + log_S + half, excess - 1)
        return task.model.straight(v, u, log_S + half)
    gap = task.difference(task.model.on_grid(np.zeros(task.model.parameters)))
    level_delta, level_P = -np.average(gap, axis=1, weights=np.exp(task.data.x))
    return task.model.straight((level_delta, 0.0), (level_P - level_delta, 0.0), level_P - level_delta)

"""Slopes as the paper finds them (Sec. 3, Fig. 2, App. B): interpolate P(delta), differentiate, smooth, differentiate.

A not-a-knot cubic spline through the points P_H(delta_H) and the first touch (0, 0) is differentiated at the points;
S at first touch is imposed by an infinite weight (0 for round indenters, S0 where it is known); a smoothing spline of
S(a) with leave-one-out cross-validation gives S' as its derivative. The values of S are either kept from the cubic
spline, as in the paper's examples ("loocv-kept"), or re-evaluated by the smoothing spline, the paper's optional step
("loocv"); S' may be smoothed further, as the paper says ("loocv-smoothed"). Everything is scaled by the data's own
ranges: the paper's dimensionless form up to constant factors.

Known limits: noise is amplified before any smoothing sees it, and the smoothing spline is a natural one (S'' = 0 at
both ends), so that S' is biased at the last points wherever S is not a straight line there; the bias is estimated and
flagged.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import LinAlgError, cho_solve_banded, cholesky_banded
from scipy.optimize import minimize_scalar

from ...base.errors import NOTICEABLE, InputError, Refusal
from ...base.numerics import HALF_WIDTH, Array
from ...base.units import show
from ...series import Series
from . import Slopes, covariance_from_errors, shift_error

# --------------------------------------------------------------------------------------------------
# Cubic smoothing spline with exact leave-one-out cross-validation, in O(n) by banded matrices.
#
# Minimises sum_i W_i (y_i - g(x_i))^2 + lambda int g''^2 dx (Eq. B1) over natural cubic splines g with knots x_i, in
# the form of Reinsch (1967), as in Green and Silverman, Nonparametric Regression and Generalized Linear Models
# (1994), Ch. 2-3. With the second differences Q and the curvature's Gram matrix T:
#
#     (T + lambda Q^T W^-1 Q) gamma = Q^T y        g = y - lambda W^-1 Q gamma        gamma = g'' at the inner points
#
# The central bands of the inverse (Hutchinson and de Hoog 1985) give the leverages A_ii. As 1 - A_ii and the residual
# both carry the factor lambda/W_i, the left-out residual is (Q gamma)_i / (Q B^-1 Q^T)_ii: no cancellation, any
# lambda. A point with infinite weight is met exactly (W^-1 = 0).

Criterion = Literal["loocv", "gcv"]

# Bounds of the smoothing parameter, in units of the mean spacing.
SMOOTHING_LEAST = 1e-8  # theory: below, the penalty drowns in round-off
SMOOTHING_MOST = 1e13  # theory: above, the Gram matrix does
SMOOTHING_NEAR = 0.1  # choice: of log(lambda), within which a minimum lies at a bound; Brent stops within 1e-4


@dataclass(frozen=True, eq=False)
class SmoothingSpline:
    """A natural cubic spline by its values ``g`` and second derivatives ``curvature`` at the knots ``x``.

    ``smoothing_lambda`` belongs to abscissae scaled to unit mean spacing; ``score`` is the minimised criterion with
    ordinates of unit range; ``left_out``: y_i minus the fit without point i (NaN-free; 0 at infinite weight).
    """

    x: Array
    g: Array
    curvature: Array
    smoothing_lambda: float
    score: float
    left_out: Array

    @property
    def at_bound(self) -> Literal["lower", "upper"] | None:
        """Which bound of the range of the smoothing parameter the minimum of the criterion lies at; None: inside."""
        if math.log(self.smoothing_lambda / SMOOTHING_LEAST) < SMOOTHING_NEAR:
            return "lower"
        return "upper" if math.log(SMOOTHING_MOST / self.smoothing_lambda) < SMOOTHING_NEAR else None

    def __call__(self, x: Array, order: int = 0) -> Array:
        """Value (``order`` 0), first or second derivative at ``x``; straight beyond the ends."""
        x = np.asarray(x, dtype=float)
        i = np.clip(np.searchsorted(self.x, x, side="right") - 1, 0, self.x.size - 2)
        inside = np.clip(x, self.x[0], self.x[-1])
        h = self.x[i + 1] - self.x[i]
        right, left = (inside - self.x[i]) / h, (self.x[i + 1] - inside) / h
        c0, c1 = self.curvature[i], self.curvature[i + 1]
        if order == 2:
            return np.where(x == inside, left * c0 + right * c1, 0.0)
        slope = (self.g[i + 1] - self.g[i]) / h + h / 6 * ((3 * right**2 - 1) * c1 - (3 * left**2 - 1) * c0)
        if order == 1:
            return slope
        bulge = h**2 / 6 * ((right**3 - right) * c1 + (left**3 - left) * c0)
        return left * self.g[i] + right * self.g[i + 1] + bulge + slope * (x - inside)


class _Smoother:
    """Matrices of one set of abscissae (unit mean spacing) and weights."""

    def __init__(self, x: Array, inverse_weights: Array):
        h = np.diff(x)
        self.q = np.array([1 / h[:-1], -1 / h[:-1] - 1 / h[1:], 1 / h[1:]])  # rows j, j+1, j+2 of column j of Q
        self.inverse_weights = inverse_weights
        self.gram = _bands((h[:-1] + h[1:]) / 3, h[1:-1] / 6, np.zeros(max(h.size - 3, 0)))
        u, q = inverse_weights, self.q
        self.penalty = _bands(
            u[:-2] * q[0] ** 2 + u[1:-1] * q[1] ** 2 + u[2:] * q[2] ** 2,
            u[1:-2] * q[1, :-1] * q[0, 1:] + u[2:-1] * q[2, :-1] * q[1, 1:],
            u[2:-2] * q[2, :-2] * q[0, 2:],
        )

    def times_q(self, gamma: Array) -> Array:
        """Q gamma, shape (n, ...)."""
        out = np.zeros((gamma.shape[0] + 2, *gamma.shape[1:]))
        for k in range(3):
            out[k : out.shape[0] - 2 + k] += (self.q[k] * gamma.T).T
        return out

    def times_q_transposed(self, y: Array) -> Array:
        """Q^T y: second divided differences, shape (n - 2, ...)."""
        return sum((self.q[k] * y[k : y.shape[0] - 2 + k].T).T for k in range(3))

    def factor(self, lam: float) -> Array:
        return cholesky_banded(self.gram + lam * self.penalty, check_finite=False)

    def gamma(self, factor: Array, y: Array) -> Array:
        return cho_solve_banded((factor, False), self.times_q_transposed(y), check_finite=False)

    def influence(self, factor: Array) -> Array:
        """(Q B^-1 Q^T)_ii with B the factored matrix, shape (n,): (1 - A_ii) W_i/lambda."""
        # Central bands of B^-1 from B = U^T U (Hutchinson and de Hoog): plain floats, the recursion is sequential
        m = factor.shape[1]
        first, second = np.zeros(m), np.zeros(m)
        first[:-1] = factor[1, 1:] / factor[2, :-1]
        second[:-2] = factor[0, 2:] / factor[2, :-2]
        rows = zip((1 / factor[2] ** 2)[::-1].tolist(), first[::-1].tolist(), second[::-1].tolist(), strict=True)
        next0 = next1 = beyond0 = 0.0  # B^-1 at (i+1, i+1), (i+1, i+2), (i+2, i+2)
        bands = []
        for pivot, l1, l2 in rows:
            s2 = -l1 * next1 - l2 * beyond0
            s1 = -l1 * next0 - l2 * next1
            s0 = pivot - l1 * s1 - l2 * s2
            bands.append((s0, s1, s2))
            next0, next1, beyond0 = s0, s1, next0
        s0, s1, s2 = (band[: m - k] for k, band in enumerate(np.array(bands[::-1]).T))
        q = self.q
        out = np.zeros(q.shape[1] + 2)
        for k in range(3):
            out[k : out.size - 2 + k] += q[k] ** 2 * s0
        # point i meets columns i-2, i-1, i of Q with the entries q[2], q[1], q[0]
        out[1:-2] += 2 * q[1, :-1] * q[0, 1:] * s1
        out[2:-1] += 2 * q[2, :-1] * q[1, 1:] * s1
        out[2:-2] += 2 * q[2, :-2] * q[0, 2:] * s2
        return out


def _bands(diagonal: Array, first: Array, second: Array) -> Array:
    """Upper banded storage of a symmetric pentadiagonal matrix."""
    out = np.zeros((3, diagonal.size))
    out[2] = diagonal
    out[1, 1:] = first
    out[0, 2:] = second
    return out


def smoothing_spline(
    x: Array,
    y: Array,
    weights: Array | None = None,
    smoothing_lambda: float | None = None,
    criterion: Criterion = "loocv",
) -> SmoothingSpline:
    """Leave-one-out smoothing: a cubic smoothing spline of ``y`` (n,) at strictly increasing ``x`` (n,); n >= 4.

    ``weights``: positive, infinite for a value to be met exactly. ``smoothing_lambda``: in units of the mean spacing
    (abscissae) and of the weights; by default it minimises the left-out residuals ("loocv") or the generalised
    cross-validation score ("gcv") over a continuous range. The data are brought to unit mean spacing and unit range
    first, so that the result does not depend on the units.
    """
    weights = np.ones(x.size) if weights is None else weights
    width = (x[-1] - x[0]) / (x.size - 1)
    height = float(np.ptp(y)) or 1.0
    smoother = _Smoother((x - x[0]) / width, 1 / weights)
    scaled = (y - y[0]) / height
    score = _score(smoother, scaled, weights, criterion)
    if smoothing_lambda is None:
        # Lambda at the least score: a coarse grid in log(lambda) finds the valley, Brent's method its floor.
        decades = round(math.log10(SMOOTHING_MOST / SMOOTHING_LEAST))
        grid = np.linspace(math.log(SMOOTHING_LEAST), math.log(SMOOTHING_MOST), decades + 1)
        values = [score(value) for value in grid]
        best = int(np.argmin(values))
        low, high = grid[max(best - 1, 0)], grid[min(best + 1, grid.size - 1)]
        minimum = minimize_scalar(score, bounds=(low, high), method="bounded", options={"xatol": 1e-4, "maxiter": 40})
        smoothing_lambda = math.exp(minimum.x if minimum.fun <= values[best] else grid[best])
    factor = smoother.factor(smoothing_lambda)
    gamma = smoother.gamma(factor, scaled)
    residual = smoother.times_q(gamma)
    left_out = np.where(np.isinf(weights), 0.0, height * residual / smoother.influence(factor))
    return SmoothingSpline(
        x,
        y - height * smoothing_lambda / weights * residual,
        np.concatenate([[0.0], gamma, [0.0]]) * height / width**2,
        smoothing_lambda,
        score(math.log(smoothing_lambda)),
        left_out,
    )


def linear_fit(spline: SmoothingSpline, weights: Array, y: Array) -> tuple[Array, Array]:
    """Values and slopes at the knots that other ordinates ``y`` (n, k) would get with the same lambda and weights."""
    width = (spline.x[-1] - spline.x[0]) / (spline.x.size - 1)
    smoother = _Smoother((spline.x - spline.x[0]) / width, 1 / weights)
    gamma = smoother.gamma(smoother.factor(spline.smoothing_lambda), y)
    g = y - (spline.smoothing_lambda / weights * smoother.times_q(gamma).T).T
    h = np.diff(spline.x)[:, None]
    c = np.concatenate([np.zeros((1, y.shape[1])), gamma, np.zeros((1, y.shape[1]))]) / width**2
    slopes = np.diff(g, axis=0) / h
    first = slopes - h / 6 * (2 * c[:-1] + c[1:])
    return g, np.concatenate([first, slopes[-1:] + h[-1:] / 6 * (c[-2:-1] + 2 * c[-1:])])


def _score(smoother: _Smoother, y: Array, weights: Array, criterion: Criterion) -> Callable[[float], float]:
    """The criterion as a function of log(lambda); points of infinite weight do not count."""
    free = np.isfinite(weights)

    def score(log_lambda: float) -> float:
        try:
            factor = smoother.factor(math.exp(log_lambda))
        except LinAlgError:  # spacings so uneven that this much smoothing drowns in round-off: out of reach
            return math.inf
        residual, influence = smoother.times_q(smoother.gamma(factor, y)), smoother.influence(factor)
        if criterion == "loocv":
            return float(np.mean(weights[free] * (residual / influence)[free] ** 2))
        trace = np.mean((influence / weights)[free])
        return float(np.mean(weights[free] * (residual / weights)[free] ** 2) / trace**2)

    return score


# What the rule "loocv" asks of a series, and how it tells its errors.
LOOCV_FEWEST = 5  # points; theory: leaving one out must leave a cubic
# random replicas of the noise; tuned on noisy series, by `make constants`: half as many move stated errors by an
# eighth, as 1/sqrt(2 * 64) says
LOOCV_PROBES = 64
LOOCV_SMOOTHED = 0.2  # choice: of the radius, over which "loocv-smoothed" smooths S' once more
DIFFERENCES = 6  # order of those that tell noise from a smooth S(a); tuned on exact and noisy series, by `make noise`
MEDIAN_SQUARE = 0.4549  # theory: of a normal number of variance 1


KEPT = "S kept from the cubic spline P(delta)"
REEVALUATED = "S re-evaluated by the smoothing spline"


def loocv(
    series: Series, criterion: Criterion = "loocv", keep_S: bool = False, smooth_dS: bool = False
) -> Slopes:  # fmt: skip
    """Find S and S' at the radii of ``series``, shape (n,); refused below 5 points or where S' is not positive.

    Parameters: ``criterion``: what the smoothing parameter minimises; ``keep_S``: keep S of the cubic spline P(delta),
    the paper's default, instead of re-evaluating it by the smoothing spline, its optional step; ``smooth_dS``: smooth
    S' by a spline of its own, a further step that the paper names. Source: the paper's Fig. 2, Sec. 3 and App. B.
    """
    if len(series) < LOOCV_FEWEST:
        raise Refusal(
            f"slopes 'loocv': needs at least {LOOCV_FEWEST} points with different contact radii, got {len(series)}; "
            "give more increments, or refine the mesh where radii repeat"
        )
    raw = interpolated_slope(series.delta, series.P)
    a, ordinates, weights = series.a, raw, np.ones(raw.size)
    if series.S0 is not None:  # the known slope at first touch, at infinite weight
        a, ordinates = np.append(series.a0, a), np.append(series.S0, raw)
        weights = np.append(math.inf, weights)
    spline = smoothing_spline(a, ordinates, weights, criterion=criterion)
    S, dS = raw if keep_S else spline(series.a), spline(series.a, 1)
    further, plain = None, dS
    if smooth_dS and (dS > 0).all():
        # log S' over log a, which powers are straight lines in; it has no scatter of its own left to choose lambda by
        x = np.log(series.a)
        lam = (LOOCV_SMOOTHED * (x.size - 1) / (math.sqrt(2) * float(x[-1] - x[0]))) ** 4
        further = smoothing_spline(x, np.log(dS), smoothing_lambda=lam)
        dS = np.exp(further.g)
    bad = (dS <= 0) | (S <= 0)
    if bad.any():
        radii = ", ".join(f"{a:.4g}" for a in series.a[bad][:5]) + (", ..." if bad.sum() > 5 else "")
        raise InputError(
            f"slopes 'loocv': S or dS/da is not positive at {int(bad.sum())} of {len(series)} radii ({radii} m), where "
            "Eq. 13 has no solution: the data are too noisy there; use the slopes 'integral', or drop those points"
        )
    # Estimated error of S' [N/m^2] caused by S'' = 0 at the last point, at every radius.
    x = spline.x
    width = (x[-1] - x[0]) / (x.size - 1)
    h = x[-1] - x[-2]
    layer = math.sqrt(2) * spline.smoothing_lambda**0.25 * width
    length = h / math.log(2 + math.sqrt(3)) + layer
    probe = max(x[-1] - 4 * length, (x[0] + x[-1]) / 2)
    curvature = float(spline(np.array(probe), 2))
    bias = curvature * (h / (2 * math.sqrt(3)) + layer) * np.exp(-(x[-1] - series.a) / length)
    covariance = _covariance(series, spline, weights, dS, np.hypot(bias, dS - plain), keep_S, further)
    flags: tuple[str, ...] = ()
    if (relative := abs(bias[-1]) / dS[-1]) >= NOTICEABLE:
        reached = int(np.sum(np.abs(bias) / dS > NOTICEABLE))
        flags = (
            f"natural end of the smoothing spline: dS/da is off by about {100 * relative:.2g} % at the largest radius "
            f"{show(float(series.a[-1]), 'length')}, by more than {100 * NOTICEABLE:g} % at the last {reached} points",
        )
    error = shift_error(dS, covariance, HALF_WIDTH)
    bound = {
        "lower": ", its lower bound: S(a) is interpolated, not smoothed",
        "upper": ", its upper bound: S(a) is a straight line",
    }.get(spline.at_bound or "", "")
    reason = f"{KEPT if keep_S else REEVALUATED}; lambda = {spline.smoothing_lambda:.2g}{bound}"
    derived = not (keep_S or smooth_dS)
    name = f"{criterion}{'-kept' if keep_S else '-smoothed' if smooth_dS else ''}"
    return Slopes(S, dS, name, error, spline.smoothing_lambda, flags, reason, covariance=covariance, derived=derived)


# With the smoothing chosen by generalised cross-validation (GCV), S of the cubic spline kept as in the paper's
# examples, or S' smoothed once more
gcv = partial(loocv, criterion="gcv")
loocv_kept = partial(loocv, keep_S=True)
gcv_kept = partial(loocv, criterion="gcv", keep_S=True)
loocv_smoothed = partial(loocv, smooth_dS=True)


def interpolated_slope(delta: Array, P: Array) -> Array:
    """dP/d(delta) at the points, from the not-a-knot cubic spline through them and (0, 0).

    ``delta`` has shape (n,), ``P`` (n,) or (n, k) for k sets of loads; so has the result.
    """
    depth, load = delta[-1], np.max(np.abs(P))
    x = np.concatenate([[0.0], delta / depth])
    y = np.concatenate([np.zeros((1, *P.shape[1:])), P / load])
    return CubicSpline(x, y, bc_type="not-a-knot").derivative()(x)[1:] * load / depth


def divided_differences(x: Array, y: Array, order: int) -> Array:
    """Return the divided differences of an ``order`` of ``y`` (n, ...) at ``x`` (n,), shape (n - order, ...)."""
    for gap in range(1, order + 1):
        y = ((y[1:] - y[:-1]).T / (x[gap:] - x[:-gap])).T
    return y


def _covariance(
    series: Series, spline: SmoothingSpline, weights: Array, dS: Array, bias: Array, keep_S: bool,
    further: SmoothingSpline | None,
) -> Array:  # fmt: skip
    """Covariance (n, 4, 4) of (delta_H, P_H, S, S'): replicas of the noise, end bias, and the series' own errors.

    The noise is taken as independent and of one relative size on a, delta and P. White noise is sent through the same
    linear steps (fixed lambda), all columns seen at given radius; its size is set by the scatter of the interpolated
    slopes about the smoothing spline. A spline that interpolates has none, whatever the noise: there the size is that
    of differences of high order, which the slopes of smooth data lose, their median over the radii.
    """
    first = spline.x.size - len(series)
    shape = (3, len(series), LOOCV_PROBES)
    a, delta, P = (
        np.random.default_rng(1).standard_normal(shape) * np.stack([series.a, series.delta, series.P])[..., None]
    )
    S, growth = spline.g[first:, None], np.gradient(series.delta, series.a)[:, None]
    raw = interpolated_slope(series.delta, P - S * delta) - dS[:, None] * a
    smooth, slope = linear_fit(spline, weights, np.concatenate([np.zeros((first, LOOCV_PROBES)), raw]))
    smooth, slope = smooth[first:], slope[first:]
    scatter = interpolated_slope(series.delta, series.P) - spline.g[first:]
    if spline.at_bound == "lower" and len(series) > DIFFERENCES:
        differences = divided_differences(series.a, np.column_stack([raw, scatter + spline.g[first:]]), DIFFERENCES)
        size = math.sqrt(np.median(differences[:, -1] ** 2 / np.mean(differences[:, :-1] ** 2, axis=1)) / MEDIAN_SQUARE)
    else:
        size = math.sqrt(np.sum(scatter**2) / np.mean(np.sum((raw - smooth) ** 2, axis=0)))
    of_S = raw if keep_S else smooth
    if further is not None:
        slope = linear_fit(further, np.ones(len(series)), slope / dS[:, None])[0] * dS[:, None]
    replicas = size * np.stack([delta - growth * a, P - S * growth * a, of_S, slope], axis=1)
    covariance = np.einsum("nip,njp->nij", replicas, replicas) / LOOCV_PROBES
    covariance[:, 3, 3] += bias**2
    of_errors = covariance_from_errors(series.a, series.errors, dS)
    return covariance if of_errors is None else covariance + of_errors

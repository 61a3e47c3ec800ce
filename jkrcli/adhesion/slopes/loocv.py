"""Slopes as the paper finds them (Sec. 3, Fig. 2, App. B): interpolate P(delta), differentiate, smooth, differentiate.

A not-a-knot cubic spline through the points P_H(delta_H) and the first touch (0, 0) is differentiated at the points;
S at first touch is imposed by an infinite weight (0 for round indenters, S0 where it is known); a smoothing spline of
S(a) with leave-one-out cross-validation gives S' as its derivative. The values of S are either kept from the cubic
spline, as in the paper's examples ("loocv-kept"), or re-evaluated by the smoothing spline, the paper's optional step
("loocv"). Everything is scaled by the data's own ranges: the paper's dimensionless form up to constant factors.

Known limits: noise is amplified before any smoothing sees it, and the smoothing spline is a natural one (S'' = 0 at
both ends), so that S' is biased at the last points wherever S is not a straight line there; the bias is estimated and
flagged.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from ...base import NOTICEABLE, Array, InputError, Refusal
from ...series import Series
from .result import TWO_SIDED_90, Slopes, covariance_from_errors, shift_error
from .smoothing import Criterion, SmoothingSpline, linear_fit, smoothing_spline


@dataclass(frozen=True)
class LoocvTuning:
    """What the rule "loocv" asks of a series, and how it tells its errors."""

    fewest: int = 5  # points; theory: leaving one out must leave a cubic
    # random replicas of the noise; tuned on noisy series, by `make constants`: half as many move stated errors by an
    # eighth, as 1/sqrt(2 * 64) says
    probes: int = 64


TUNING = LoocvTuning()
KEPT = "S kept from the cubic spline P(delta)"
REEVALUATED = "S re-evaluated by the smoothing spline"


def loocv(series: Series, criterion: Criterion = "loocv", keep_S: bool = False) -> Slopes:
    """Find S and S' at the radii of ``series``, shape (n,); refused below 5 points or where S' is not positive.

    Parameters: ``criterion``: what the smoothing parameter minimises; ``keep_S``: keep S of the cubic spline P(delta),
    the paper's default, instead of re-evaluating it by the smoothing spline, its optional step. Source: the paper's
    Fig. 2 and App. B.
    """
    if len(series) < TUNING.fewest:
        raise Refusal(
            f"slopes 'loocv': needs at least {TUNING.fewest} points with different contact radii, got {len(series)}; "
            "give more increments, or refine the mesh where radii repeat"
        )
    raw = interpolated_slope(series.delta, series.P)
    a, ordinates, weights = _with_first_touch(series, raw)
    spline = smoothing_spline(a, ordinates, weights, criterion=criterion)
    S, dS = raw if keep_S else spline(series.a), spline(series.a, 1)
    _refuse_falling(series, S, dS)
    bias = _end_bias(spline, series.a)
    covariance = _covariance(series, spline, weights, dS, bias, keep_S)
    flags = tuple(_end_flags(series, dS, bias))
    error = shift_error(dS, covariance, TWO_SIDED_90)
    reason = f"{KEPT if keep_S else REEVALUATED}; {_lambda_words(spline)}"
    return Slopes(
        S, dS, "loocv", error, spline.smoothing_lambda, flags, reason, covariance=covariance, derived=not keep_S
    )


def gcv(series: Series) -> Slopes:
    """Find S and S' as ``loocv`` does, the smoothing chosen by generalised cross-validation (GCV)."""
    return replace(loocv(series, "gcv"), method="gcv")


def loocv_kept(series: Series) -> Slopes:
    """Find S' as ``loocv`` does and keep S of the cubic spline: the paper's examples."""
    return replace(loocv(series, keep_S=True), method="loocv-kept")


def gcv_kept(series: Series) -> Slopes:
    """Find S' as ``gcv`` does and keep S of the cubic spline."""
    return replace(loocv(series, "gcv", keep_S=True), method="gcv-kept")


def _lambda_words(spline: SmoothingSpline) -> str:
    """The smoothing parameter, and what it means where cross-validation ends at a bound of its range."""
    value = f"lambda = {spline.smoothing_lambda:.2g}"
    match spline.at_bound:
        case "lower":
            return f"{value}, its lower bound: S(a) is interpolated, not smoothed"
        case "upper":
            return f"{value}, its upper bound: S(a) is a straight line"
    return value


def interpolated_slope(delta: Array, P: Array) -> Array:
    """dP/d(delta) at the points, from the not-a-knot cubic spline through them and (0, 0).

    ``delta`` has shape (n,), ``P`` (n,) or (n, k) for k sets of loads; so has the result.
    """
    depth, load = delta[-1], np.max(np.abs(P))
    x = np.concatenate([[0.0], delta / depth])
    y = np.concatenate([np.zeros((1, *P.shape[1:])), P / load])
    return CubicSpline(x, y, bc_type="not-a-knot").derivative()(x)[1:] * load / depth


def _with_first_touch(series: Series, S: Array) -> tuple[Array, Array, Array]:
    """Radii, slopes and weights with the known slope at first touch prepended at infinite weight."""
    if series.S0 is None:
        return series.a, S, np.ones(S.size)
    weights = np.ones(S.size + 1)
    weights[0] = math.inf
    return np.concatenate([[series.a0], series.a]), np.concatenate([[series.S0], S]), weights


def _refuse_falling(series: Series, S: Array, dS: Array) -> None:
    bad = (dS <= 0) | (S <= 0)
    if bad.any():
        radii = ", ".join(f"{a:.4g}" for a in series.a[bad][:5]) + (", ..." if bad.sum() > 5 else "")
        raise InputError(
            f"slopes 'loocv': S or dS/da is not positive at {int(bad.sum())} of {len(series)} radii ({radii} m), where "
            "Eq. 13 has no solution: the data are too noisy there; use the slopes 'integral', or drop those points"
        )


def _end_bias(spline: SmoothingSpline, a: Array) -> Array:
    """Estimated error of S' [N/m^2] caused by S'' = 0 at the last point, at every radius.

    A cubic spline with a wrong end curvature c errs in its slope by c h/(2 sqrt 3), falling by 2 - sqrt 3 per point;
    the smoother's boundary layer (lambda e'''' + e = 0, length l = sqrt 2 lambda^(1/4)) errs by c l, falling as
    exp(-x/l). c is read off the spline where the end no longer reaches.
    """
    x = spline.x
    width = (x[-1] - x[0]) / (x.size - 1)
    h = x[-1] - x[-2]
    layer = math.sqrt(2) * spline.smoothing_lambda**0.25 * width
    length = h / math.log(2 + math.sqrt(3)) + layer
    probe = max(x[-1] - 4 * length, (x[0] + x[-1]) / 2)
    curvature = float(spline(np.array(probe), 2))
    return curvature * (h / (2 * math.sqrt(3)) + layer) * np.exp(-(x[-1] - a) / length)


def _end_flags(series: Series, dS: Array, bias: Array) -> list[str]:
    relative = abs(bias[-1]) / dS[-1]
    if relative < NOTICEABLE:
        return []
    reached = int(np.sum(np.abs(bias) / dS > NOTICEABLE))
    return [
        f"natural end of the smoothing spline: dS/da is off by about {100 * relative:.2g} % at the largest radius "
        f"{series.a[-1]:.4g} m, by more than {100 * NOTICEABLE:g} % at the last {reached} points"
    ]


def _covariance(series: Series, spline: SmoothingSpline, weights: Array, dS: Array, bias: Array, keep_S: bool) -> Array:
    """Covariance (n, 4, 4) of (delta_H, P_H, S, S'): replicas of the noise, end bias, and the series' own errors.

    The noise is taken as independent and of one relative size on a, delta and P. White noise is sent through the same
    linear steps (fixed lambda), all columns seen at given radius; its size is set by the scatter of the interpolated
    slopes about the smoothing spline.
    """
    first = spline.x.size - len(series)
    shape = (3, len(series), TUNING.probes)
    a, delta, P = (
        np.random.default_rng(1).standard_normal(shape) * np.stack([series.a, series.delta, series.P])[..., None]
    )
    S, growth = spline.g[first:, None], np.gradient(series.delta, series.a)[:, None]
    raw = interpolated_slope(series.delta, P - S * delta) - dS[:, None] * a
    smooth, slope = linear_fit(spline, weights, np.concatenate([np.zeros((first, TUNING.probes)), raw]))
    smooth, slope = smooth[first:], slope[first:]
    scatter = interpolated_slope(series.delta, series.P) - spline.g[first:]
    size = math.sqrt(np.sum(scatter**2) / np.mean(np.sum((raw - smooth) ** 2, axis=0)))
    of_S = raw if keep_S else smooth
    replicas = size * np.stack([delta - growth * a, P - S * growth * a, of_S, slope], axis=1)
    covariance = np.einsum("nip,njp->nij", replicas, replicas) / TUNING.probes
    covariance[:, 3, 3] += bias**2
    of_errors = covariance_from_errors(series.a, series.errors, dS)
    return covariance if of_errors is None else covariance + of_errors

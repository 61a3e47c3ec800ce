"""The scatter of the data about a fitted model: how much of it each column carries, and where.

Relative variances of a, delta and P at every point. An error of the radius moves delta and P together, by the slopes
k = dlog(delta)/dlog(a) and m = dlog(P)/dlog(a) (effective variance; Orear, Am. J. Phys. 50 (1982) 912):

    cov(log delta, log P) = diag(var_delta, var_P) + var_a (k, m)^T (k, m)
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from ...base import MOST_SOLVES, TINY, Array


@dataclass(frozen=True)
class ScatterTuning:
    """What the residuals are believed to tell about the scatter of the data."""

    trace: float = 1e-3  # the least share of a column; tuned on noisy series, by `make tuning`
    most_trend: float = 4.0  # exponent of the variance over the radius; tuned on the same, by `make tuning`
    outlier: float = 3.0  # standard deviations where points begin to count less; tuned on the same, by `make tuning`
    free: int = 20  # points that tell the errors of a, delta, P apart; tuned on the same, by `make tuning`
    false: float = 5e-3  # probability of an outlier reported in a series without any; choice: rare
    chance: float = 2.5  # theory: standard deviations of the correlation of neighbours that chance brings once in 160


TUNING = ScatterTuning()


def floored(variances: Array, share: float, floor: float) -> Array:
    """Variances (3, n), each at least ``share`` of the largest of its point, and ``floor``."""
    return np.maximum(variances, np.maximum(share * variances.max(axis=0), floor))


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
        if x.size >= TUNING.free:
            shares = _shares(residuals[:, inliers], k[inliers], m[inliers], spent, floor)
        white = np.einsum("ijn,jn->in", whitener(shares, k, m), residuals)
        squares = np.mean(white**2, axis=0)
        if not np.mean(squares[inliers]) > floor:
            return np.ones((3, x.size)), np.zeros(x.size, dtype=bool)
        if x.size >= TUNING.free:
            size = np.exp(_trend(x[inliers], squares[inliers]) * x)
        relative = squares / size
        # theory: the sum of two squares is exponential, of median log 2; outliers hide in a mean that holds them
        unit = np.median(relative) / math.log(2) if round_ == 0 else np.mean(relative[inliers])
        before, inliers = inliers, relative <= unit * _rare(inliers.sum() - spent / 2, x.size)
        if round_ > 0 and (before == inliers).all():
            break
    distance = np.sqrt(relative / np.mean(relative[inliers]))
    far = np.where(inliers, np.maximum(1.0, distance / TUNING.outlier), distance)
    return shares * size * far**2, ~inliers


def _rare(free: float, n: int) -> float:
    """The square, in units of the mean of ``free`` others, that chance brings among ``n`` with probability
    ``TUNING.false``: both are exponential, so that their ratio exceeds t with probability (1 + t/free)^-free."""
    free = max(free, 2.0)
    return float(free * math.expm1(math.log(n / TUNING.false) / free))


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
    return np.maximum(np.array([[radius], [delta], [P]]) / largest, TUNING.trace)


def _trend(x: Array, squares: Array) -> float:
    """Exponent b of variance ~ a^b: the maximum of the Gaussian likelihood, one size parameter profiled out."""
    centred = x - x.mean()
    minimum = minimize_scalar(
        lambda b: float(np.log(np.mean(squares * np.exp(-b * centred)))),
        bounds=(-TUNING.most_trend, TUNING.most_trend),
        method="bounded",
    )
    return float(minimum.x)


def correlation_length(residuals: Array) -> float:
    """Number of neighbours in each row of ``residuals`` (rows, n), in order, that are worth one independent value:
    1 + 2 sum of the autocorrelations up to the first that is not positive, of the worst row; 1 where neighbours
    correlate by no more than chance brings, 1/sqrt(n). (Geyer, Statist. Sci. 7 (1992) 473, Sec. 3.3.)"""
    n = residuals.shape[1]
    lengths = [1.0]
    for row in residuals:
        correlations = np.correlate(row, row, "full")[n:] / max(float(row @ row), TINY)
        if correlations[0] * np.sqrt(n) > TUNING.chance:
            positive = np.logical_and.accumulate(correlations > 0)
            lengths.append(1 + 2 * float(correlations[positive].sum()))
    return max(lengths)

"""Statistics of residuals: scatter, covariance, structure. Formulae of nonlinear regression, SciPy's quantiles."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy import special

from ...base import Array
from .settings import Loss

# Theory: turns of the losses at 95 % efficiency for normal noise (Holland and Welsch 1977).
TURNS = {"soft_l1": 1.345, "huber": 1.345, "cauchy": 2.385, "linear": math.inf}


@dataclass(frozen=True)
class StatisticsTuning:
    """Chances below which noise is no explanation, and what is known of normal noise."""

    normal_median: float = 0.6745  # theory: median of |x| of a normal x of standard deviation 1
    improbable: float = 1e-3  # choice: of misfit, and of differences between records
    suspicious: float = 1e-4  # choice: of order in residuals


TUNING = StatisticsTuning()


def robust_scale(residuals: Array) -> float:
    """Standard deviation of normal residuals, from their median size."""
    return float(np.median(np.abs(residuals))) / TUNING.normal_median


# SciPy's losses at residuals z in units of the turn: rho by z^2, its psi = rho'/2 and psi' by z.
LOSSES: Mapping[Loss, tuple[Callable[[Array], Array], ...]] = {
    "linear": (lambda s: s, lambda z: z, np.ones_like),
    "huber": (lambda s: np.where(s <= 1, s, 2 * np.sqrt(s) - 1), lambda z: np.clip(z, -1, 1),
              lambda z: (np.abs(z) <= 1).astype(float)),
    "soft_l1": (lambda s: 2 * (np.sqrt(1 + s) - 1), lambda z: z / np.sqrt(1 + z**2), lambda z: (1 + z**2) ** -1.5),
    "cauchy": (np.log1p, lambda z: z / (1 + z**2), lambda z: (1 - z**2) / (1 + z**2) ** 2),
}  # fmt: skip


def influence(z: Array, loss: Loss) -> tuple[Array, Array]:
    """psi and psi' of a loss at residuals ``z`` in units of its turn."""
    _, psi, slope = LOSSES[loss]
    return psi(z), slope(z)


def costs(residuals: Array, loss: Loss, width: float) -> float:
    """Half the sum of the losses of ``residuals``, which turn at ``width``."""
    return 0.5 * width**2 * float(np.sum(LOSSES[loss][0]((residuals / width) ** 2)))


def variance_factor(residuals: Array, dof: int, loss: Loss, width: float) -> float:
    """Factor of (J^T J)^-1: the residual variance, or its counterpart for M-estimates (Huber 1981, Sec. 7.6)."""
    turn = 1.0 if loss == "linear" else width
    psi, slope = influence(residuals / turn, loss)
    return float(np.sum(psi**2) / dof * turn**2 / max(float(np.mean(slope)), 1e-3) ** 2)


def covariance(jacobian: Array, factor: float) -> Array | None:
    """Covariance ``factor`` (J^T J)^-1; None where the data do not determine all parameters."""
    size = np.linalg.norm(jacobian, axis=0)
    if not (size > 0).all():
        return None
    _, singular, right = np.linalg.svd(jacobian / size, full_matrices=False)
    if singular[-1] < 1e-10 * singular[0]:  # theory: what round-off of 1e-16 leaves of its square
        return None
    return factor * (right.T / singular**2) @ right / np.outer(size, size)


def covariance_of_uneven(jacobian: Array, residuals: Array) -> Array | None:
    """Covariance of the parameters where the noise of the points, residuals (k, n), is not known to be even.

    (J^T J)^-1 sum_i g_i g_i^T (J^T J)^-1 with g_i what point i adds to J^T r, over 1 - its leverage (White 1980; HC3 of
    MacKinnon and White, J. Econometrics 29 (1985) 305).
    """
    inverse = covariance(jacobian, 1.0)
    if inverse is None:
        return None
    k, n = residuals.shape
    rows = jacobian.reshape(k, n, -1)
    leverage = np.einsum("knp,pq,knq->n", rows, inverse, rows)
    pulls = np.einsum("knp,kn->np", rows, residuals) / (1 - np.minimum(leverage, 0.5))[:, None]
    spread: Array = inverse @ (pulls.T @ pulls) @ inverse
    return spread


def larger(one: Array | None, other: Array | None) -> Array | None:
    """The covariance ``one`` with the standard deviations of ``other`` where these are larger; None where there is
    none."""
    if one is None or other is None:
        return one
    scale = np.sqrt(np.maximum(np.diag(other) / np.diag(one), 1.0))
    return one * np.outer(scale, scale)


def t_quantile(level: float, dof: int) -> float:
    """Half-width of a two-sided interval in standard errors."""
    return float(special.stdtrit(dof, (1 + level) / 2))


def rise(level: float, dof: int, parameters: int = 1) -> float:
    """Relative rise of the sum of squares on the border of a joint confidence region (F test)."""
    return float(parameters / dof * special.fdtri(parameters, dof, level))


@dataclass(frozen=True)
class Structure:
    """Order in residuals along the curve: ``lag1`` autocorrelation, number of sign ``runs`` and how many are
    ``expected``; ``probability`` that independent residuals show as much (the smaller of both tests, doubled)."""

    lag1: float
    runs: int
    expected: float
    probability: float

    @property
    def suspicious(self) -> bool:
        return self.probability < TUNING.suspicious


def structure(residuals: Array) -> Structure:
    """Lag-1 autocorrelation and the runs test of Wald and Wolfowitz, both against positive structure."""
    n = residuals.size
    centred = residuals - np.mean(residuals)
    total = float(np.sum(centred**2))
    lag1 = float(np.sum(centred[1:] * centred[:-1]) / total) if total > 0 else 0.0
    above = residuals > np.median(residuals)
    k = int(above.sum())
    m = n - k
    runs = 1 + int(np.sum(above[1:] != above[:-1]))
    expected = 1 + 2 * k * m / n
    variance = max((expected - 1) * (expected - 2) / (n - 1), 1e-12)
    chances = special.ndtr([-lag1 * math.sqrt(n), (runs - expected) / math.sqrt(variance)])
    return Structure(lag1, runs, float(expected), float(min(1.0, 2 * min(chances))))

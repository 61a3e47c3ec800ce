"""Penalised nonlinear least squares with the penalties' weights estimated from the data.

Minimises |r(c)|^2 + sum_j lambda_j |c_j|^2, c_j being blocks of the coefficients c, by Gauss-Newton. The lambdas
maximise the restricted likelihood of each linearised problem (each penalty is a Gaussian prior of unknown variance on
its block), by the fixed point of Wood and Fasiolo (Biometrics 73 (2017) 1071):

    lambda_j <- lambda_j * phi (size_j/lambda_j - tr V_jj) / |c_j|^2        V = (J^T J + Lambda)^-1

phi V is the covariance of the coefficients seen as a posterior (Nychka 1988: intervals from it hold on average over
the curve). It is the scatter that noise causes, phi V J^T J V, and an allowance for smoothing bias, phi V Lambda V.
The lambdas are known the less the fewer the data: the covariance is the mean over all that the data leave possible.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from ...base.arrays import Array

Linearised = tuple[Array, Array]  # residuals and their Jacobian
Residuals = Callable[[Array], Linearised]


@dataclass(frozen=True)
class PenaltyTuning:
    """How the fit steps, how the penalties follow the data, and when both are settled."""

    least: float = 1e-15  # lambda, in units of the mean diagonal of J^T J over the block; theory: round-off
    most: float = 100.0  # and the largest; choice: it leaves none of the block
    most_prior: float = 10.0  # variance of a coefficient before data are seen; choice: bodies do not bend more
    spread: tuple[float, ...] = tuple(4.0**n for n in range(-7, 3))  # about a lambda; choice: beyond, weights vanish
    negligible: float = 1e-4  # weight of a lambda; choice: below, it does not show
    updates: int = 40  # of the lambdas in a step; choice: they settle long before
    factor: float = 100.0  # most that an update changes a lambda by; tuned on noisy series, by `make tuning`
    settled: float = 0.02  # change of log(lambda); tuned on the same, by `make tuning`
    freeze: int = 25  # steps, after which the lambdas stay; tuned on the same, by `make tuning`
    steps: int = 50  # choice: what has not settled then does not
    damping: float = 1e-8  # least, of the diagonal of the linearised problem; tuned on the same, by `make tuning`
    poor_step: float = 0.2  # below it the next step is damped (Levenberg); tuned on the same, by `make tuning`
    halvings: int = 30  # choice: down to a billionth of a step
    longest_step: float = 5.0  # of a coefficient; choice: all of them belong to logarithms
    tolerance: float = 3e-2  # of a step, in standard deviations of the fit; tuned on the same, by `make tuning`
    stuck: float = 0.5  # standard deviations of a step still open at the end; choice: more is flagged as not settled


TUNING = PenaltyTuning()


@dataclass(frozen=True, eq=False)
class PenalisedFit:
    """A penalised fit: coefficients ``c`` (p,), their covariance ``V`` (p, p) over ``phi``, residuals (m,).

    ``lambdas``: in units of the mean diagonal of J^T J. ``spent``: the effective number of parameters. ``settled``:
    whether the steps became small. ``floored``: whether the residuals show less than the least ``phi``.
    """

    c: Array
    V: Array
    residuals: Array
    phi: float
    lambdas: Array
    spent: float
    settled: bool
    floored: bool


@dataclass(frozen=True, eq=False)
class _Linear:
    """The solution of one linearised problem."""

    step: Array
    penalty: Array
    phi: float
    lambdas: Array
    spent: float
    deviations: float


def minimise(
    residuals: Residuals, start: Array, blocks: Sequence[slice], phi_floor: float, lambdas: Array, freeze: int
) -> PenalisedFit:
    """The fit from ``start``. ``residuals(c)``: (r, Jacobian of r); ``lambdas``: first guess.

    After ``freeze`` steps the lambdas stay as they are.
    """
    c, damping = start, 0.0
    now = residuals(c)
    for step in range(TUNING.steps):
        linear = _linear(now, c, blocks, lambdas, phi_floor, damping, updates=TUNING.updates if step < freeze else 0)
        lambdas = linear.lambdas
        c, now, taken = _line_search(residuals, c, now, linear)
        moved = taken * linear.deviations
        if linear.deviations < TUNING.tolerance or moved < 1e-3 * TUNING.tolerance:
            break
        damping = (
            max(10 * damping, TUNING.damping) if taken < TUNING.poor_step else damping / 3 * (damping > TUNING.damping)
        )
    settled = moved < TUNING.stuck and (taken > 0 or linear.deviations < TUNING.stuck)
    known = freeze > 0  # else only a place to start from
    V = _averaged(linear, now, c, blocks, phi_floor) if known else np.zeros((c.size, c.size))
    return PenalisedFit(c, V, now[0], linear.phi, lambdas, linear.spent, settled, linear.phi <= phi_floor)


def _averaged(linear: _Linear, now: Linearised, c: Array, blocks: Sequence[slice], phi_floor: float) -> Array:
    """Covariance over ``linear.phi`` of the coefficients, the lambdas being as uncertain as the data leave them.

    The mean over lambdas about the best ones, weighted by their restricted likelihood and a prior even in the size of a
    block's coefficients, 1/sqrt(lambda) (Gelman 2006): what the fit would be with other lambdas is part of its error.
    """
    r, J = now
    normal, gradient = J.T @ J, J.T @ r
    ridge = 1e-15 * np.diag(normal).max()
    best = [lam * np.diag(normal)[block].mean() for lam, block in zip(linear.lambdas, blocks, strict=True)]
    free = r.size - c.size + sum(c[block].size for block in blocks)
    likelihoods, covariances = [], []
    for factors in itertools.product(TUNING.spread, repeat=len(blocks)):
        penalty, log_prior = np.zeros(c.size), 0.0
        for block, lam, factor in zip(blocks, best, factors, strict=True):
            penalty[block] = lam * factor
            log_prior += (c[block].size - 1) / 2 * math.log(factor)
        system = cho_factor(normal + np.diag(penalty + ridge))
        step = -cho_solve(system, gradient + penalty * c)
        objective = float(r @ r + 2 * gradient @ step + step @ normal @ step + penalty @ (c + step) ** 2)
        phi = max(objective / free, phi_floor)
        log_det = 2 * float(np.log(np.diag(system[0])).sum())
        likelihoods.append(log_prior - (log_det + free * math.log(phi) + objective / phi) / 2)
        covariances.append((system, phi / linear.phi, step))
    weights = np.exp(np.array(likelihoods) - max(likelihoods))
    V = np.zeros_like(normal)
    for weight, (system, ratio, step) in zip(weights / weights.sum(), covariances, strict=True):
        if weight > TUNING.negligible:
            V += weight * (ratio * cho_solve(system, np.eye(c.size)) + np.outer(step, step) / linear.phi)
    return V


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
        system = normal + np.diag(penalty + 1e-15 * diagonal.max())
        V = cho_solve(cho_factor(system), np.eye(c.size))
        step = -V @ (gradient + penalty * c)
        spent = float(np.sum(V * normal))
        rss = max(float(r @ r + 2 * gradient @ step + step @ normal @ step), 0.0)
        phi = max(rss / max(r.size - spent, 1.0), phi_floor)
        if update == updates:
            break
        pieces = zip(blocks, lambdas, scales, strict=True)
        updated = np.array([_update(lam, scale, (c + step)[b], V[b, b], phi) for b, lam, scale in pieces])
        if np.abs(np.log(updated / lambdas)).max() < TUNING.settled:
            break
        lambdas = updated
    deviations = float(np.sqrt(max(step @ system @ step, 0.0) / phi))
    if damping > 0:
        step = -cho_solve(cho_factor(system + damping * np.diag(np.diag(system))), gradient + penalty * c)
    return _Linear(step, penalty, phi, lambdas, spent, deviations)


def _update(lam: float, scale: float, c: Array, V: Array, phi: float) -> float:
    free = max(c.size - lam * scale * float(np.trace(V)), 1e-12 * c.size)
    rough = max(lam * scale * float(c @ c), 1e-300)
    ratio = np.clip(phi * free / rough, 1 / TUNING.factor, TUNING.factor)
    return float(np.clip(lam * ratio, max(TUNING.least, phi / (scale * TUNING.most_prior)), TUNING.most))


def _line_search(residuals: Residuals, c: Array, now: Linearised, linear: _Linear) -> tuple[Array, Linearised, float]:
    """The first of the steps 1, 1/2, 1/4 ... that does not raise the objective by more than a rounding of phi."""

    def objective(r: Array, c: Array) -> float:
        return float(r @ r + linear.penalty @ c**2)

    before = objective(now[0], c) + 1e-6 * linear.phi
    taken = min(1.0, TUNING.longest_step / max(float(np.max(np.abs(linear.step))), 1e-300))
    for _ in range(TUNING.halvings):
        trial = c + taken * linear.step
        found = residuals(trial)
        if objective(found[0], trial) <= before:
            return trial, found, taken
        taken /= 2
    return c, now, 0.0

"""Penalised nonlinear least squares with the penalties' weights estimated from the data.

Minimises |r(c)|^2 + sum_j lambda_j |c_j|^2, c_j being blocks of the coefficients c, by Gauss-Newton. The lambdas
maximise the restricted likelihood of each linearised problem (each penalty is a Gaussian prior of unknown variance on
its block), by the fixed point of Wood and Fasiolo (Biometrics 73 (2017) 1071):

    lambda_j <- lambda_j * phi (size_j/lambda_j - tr V_jj) / |c_j|^2        V = (J^T J + Lambda)^-1

phi V is the covariance of the coefficients seen as a posterior (Nychka 1988: intervals from it hold on average over
the curve). It is the scatter that noise causes, phi V J^T J V, and an allowance for smoothing bias, phi V Lambda V;
bodies bend less than draws of the prior do, and where noise hides the bending a part of the allowance is right.
The lambdas are known the less the fewer the data, and so is how far errors of neighbours go together: the covariance
is the mean over all that the data leave possible.

Residuals come in rows (rows, n) in the order of recording. Neighbours in a row correlate by rho, AR(1), so that
r_i - rho r_(i-1) are independent, and this change of variables belongs to the likelihood: rho and the lambdas are told
apart together (Krivobokova and Kauermann, J. Am. Stat. Assoc. 102 (2007) 1328).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack

from ...base import MOST_STEPS, TINY, UNSEEN, Array

Linearised = tuple[Array, Array]  # residuals (rows, n) and their Jacobian (rows, n, p)
Residuals = Callable[[Array], Linearised]


@dataclass(frozen=True)
class PenaltyTuning:
    """How the fit steps, how the penalties follow the data, and when both are settled."""

    least: float = 1e-15  # lambda, in units of the mean diagonal of J^T J over the block; theory: round-off
    most: float = 100.0  # and the largest; tuned on imported tables, by `make constants`: it leaves none of the block
    # variance of a coefficient before data are seen; tuned on imported tables, by `make constants`: bodies do not bend
    # more
    most_prior: float = 10.0
    spread: tuple[float, ...] = tuple(4.0**n for n in range(-7, 3))  # about a lambda; choice: beyond, weights vanish
    bias: float = 0.2  # of the allowance for smoothing bias, in noise; tuned on noisy series, by `make noise-study`
    factor: float = 100.0  # most that an update changes a lambda by; tuned on noisy series, by `make tuning`
    settled: float = 0.02  # change of log(lambda); tuned on the same, by `make tuning`
    freeze: int = 25  # steps, after which the lambdas stay; tuned on the same, by `make tuning`
    steps: int = 50  # tuned on imported tables, by `make constants`: what has not settled then does not
    damping: float = 1e-8  # least, of the diagonal of the linearised problem; tuned on the same, by `make tuning`
    poor_step: float = 0.2  # below it the next step is damped (Levenberg); tuned on the same, by `make tuning`
    halvings: int = 30  # theory: down to a billionth of a step
    # of a coefficient; tuned on imported tables, by `make constants`: all of them belong to logarithms
    longest_step: float = 5.0
    tolerance: float = 3e-2  # of a step, in standard deviations of the fit; tuned on the same, by `make tuning`
    stuck: float = 0.5  # standard deviations of a step still open at the end; choice: more is flagged as not settled
    # Correlations of neighbours that are thought possible beside none; choice: beyond the last, noise is drift
    correlations: tuple[float, ...] = (0.15, 0.3, 0.45, 0.6, 0.7, 0.78, 0.85, 0.9, 0.94, 0.97, 0.985)
    uncorrelated: float = 0.5  # probability of no correlation before data are seen; theory: as likely as any
    worth: float = 2.0  # log of a likelihood ratio that makes a correlation believed; choice: none is simpler
    beyond: float = 4.0  # standard errors of the residuals' own correlation; choice: above, none is tried
    # tuned on imported tables, by `make constants`: residuals over those of the fit, beyond which a correlation's are
    # not believed
    linear: float = 2.0


TUNING = PenaltyTuning()


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
    for step in range(TUNING.steps):
        now = _flat(seen, rho)
        linear = _linear(now, c, blocks, lambdas, phi_floor, damping, updates=MOST_STEPS if step < freeze else 0)
        lambdas = linear.lambdas
        c, seen, taken = _line_search(residuals, c, seen, linear, rho)
        moved = taken * linear.deviations
        if linear.deviations < TUNING.tolerance or moved < 1e-3 * TUNING.tolerance:
            break
        damping = (
            max(10 * damping, TUNING.damping) if taken < TUNING.poor_step else damping / 3 * (damping > TUNING.damping)
        )
    settled = moved < TUNING.stuck and (taken > 0 or linear.deviations < TUNING.stuck)
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
    rhos = np.array(_possible(fit, TUNING.correlations)) if correlated else np.zeros(1)
    spread = TUNING.spread[1::2] if correlated else TUNING.spread
    priors = np.full(rhos.size, (1 - TUNING.uncorrelated) / max(rhos.size - 1, 1))
    priors[0] = TUNING.uncorrelated if correlated else 1.0
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
    inner = _mean_covariance(guesses, fit.phi, 0.0, TUNING.bias) if noise else full
    return Posterior(full, inner, float(rhos[np.argmax(masses)]), float(heights.max() - heights[0]))


def likeliest_correlation(fit: PenalisedFit) -> float:
    """The correlation of neighbours, among every other up to 0.9, with the greatest likelihood: a fit that leaves more
    to it follows what drifts."""
    rhos = _possible(fit, TUNING.correlations[1:8:2])
    heights = [_at_best(fit, rho)[0] for rho in rhos]
    heights[0] += TUNING.worth
    return rhos[int(np.argmax(heights))]


def _possible(fit: PenalisedFit, rhos: Sequence[float]) -> tuple[float, ...]:
    """0 and those of ``rhos`` that the residuals' own correlation allows, and what the fit has taken from it: beyond,
    a likelihood is that of a linearised fit far from where it holds."""
    r, n = fit.residuals, fit.residuals.shape[1]
    lag1 = float(np.sum(r[:, 1:] * r[:, :-1]) / max(np.sum(r**2), TINY))
    limit = lag1 + TUNING.beyond / math.sqrt(n) + (1 + 3 * max(lag1, 0.0)) * fit.spent / n
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
    return guess.height if there <= TUNING.linear**2 * np.sum(fit.residuals**2) else -math.inf, best


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
        pieces = zip(blocks, lambdas, scales, strict=True)
        updated = np.array([_update(lam, scale, (c + step)[b], V[b, b], phi) for b, lam, scale in pieces])
        if np.abs(np.log(updated / lambdas)).max() < TUNING.settled:
            break
        lambdas = updated
    system = normal + np.diag(penalty + 1e-15 * diagonal.max())
    deviations = float(np.sqrt(max(step @ system @ step, 0.0) / phi))
    if damping > 0:
        step = -_solve(_factor(system, damping * np.diag(system)), gradient + penalty * c)
    return _Linear(step, penalty, phi, lambdas, spent, deviations)


def _update(lam: float, scale: float, c: Array, V: Array, phi: float) -> float:
    free = max(c.size - lam * scale * float(np.trace(V)), 1e-12 * c.size)
    rough = max(lam * scale * float(c @ c), TINY)
    ratio = np.clip(phi * free / rough, 1 / TUNING.factor, TUNING.factor)
    return float(np.clip(lam * ratio, max(TUNING.least, phi / (scale * TUNING.most_prior)), TUNING.most))


def _line_search(
    residuals: Residuals, c: Array, now: Linearised, linear: _Linear, rho: float
) -> tuple[Array, Linearised, float]:
    """The first of the steps 1, 1/2, 1/4 ... that does not raise the objective by more than a rounding of phi."""

    def objective(r: Array, c: Array) -> float:
        return float(np.sum(decorrelated(r, rho) ** 2) + linear.penalty @ c**2)

    before = objective(now[0], c) + 1e-6 * linear.phi
    taken = min(1.0, TUNING.longest_step / max(float(np.max(np.abs(linear.step))), TINY))
    for _ in range(TUNING.halvings):
        trial = c + taken * linear.step
        there = residuals(trial)
        if objective(there[0], trial) <= before:
            return trial, there, taken
        taken /= 2
    return c, now, 0.0

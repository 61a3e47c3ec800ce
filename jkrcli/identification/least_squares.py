"""The one search of all fits, and what follows from searching again: profiles.

``LeastSquares`` is what is minimised: a model, which gives its ``State`` at any unknowns, bounds and the loss, by a
trust region: its own for squares, SciPy's ("trf") for robust losses. An interval by the profile holds what follows from
the unknowns with one more row.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import optimize

from ..base import MOST_STEPS, NOTICEABLE, Array, JkrError, SolveError
from .fit.settings import Loss
from .fit.statistics import costs


@dataclass(frozen=True)
class SearchTuning:
    """Steps of a search, ends of profiles, and what laws of records over time have in common."""

    doublings: int = 6  # choice: of the step in which a profile must reach its limit, else it has none
    pull: float = 10.0  # theory: how much more a constrained value weighs than the data, whose pull is then a hundredth
    reach: float = 12.0  # choice: guard, how far logs may move from their start
    poor: float = 0.25  # theory: More (1978): of the predicted reduction, below which steps are shorter
    good: float = 0.75  # theory: the same, above which they may be longer
    longer: float = 1.01  # choice: factor within which a step is as long as the radius
    singular: float = 1e-14  # theory: of the largest singular value, rounding
    misfit: float = 1.3  # choice: scatter over the noise from row to row beyond which the law or the body is doubted


TUNING = SearchTuning()


@dataclass(frozen=True, eq=False)
class State:
    """What a model says at some unknowns: ``residuals`` (n,), and the ``jacobian`` (n, unknowns), which ``rates``
    computes on request."""

    residuals: Array
    rates: Callable[[], Array]

    @cached_property
    def jacobian(self) -> Array:
        return self.rates()

    @cached_property
    def cost(self) -> float:
        """Half the sum of squares, infinite where there is none."""
        half = 0.5 * float(self.residuals @ self.residuals)
        return half if math.isfinite(half) else math.inf

    def rows(self, chosen: Array) -> State:
        """That of the ``chosen`` rows."""
        return State(self.residuals[chosen], lambda: self.jacobian[chosen])

    def moved(self, by: Array) -> State:
        """That of readings which are less ``by`` so much."""
        return State(self.residuals + by, lambda: self.jacobian)


Outcome = Callable[[Array], tuple[float, Array]]  # a value and its derivatives by the unknowns


@dataclass(frozen=True, eq=False)
class LeastSquares:
    """What is minimised: the squares, or the robust ``loss`` that turns at ``width``, of a ``model``, within
    ``bounds``; relative changes below ``converged`` are none, those of the cost below ``cost`` if that is more."""

    model: Callable[[Array], State]
    bounds: tuple[Array, Array]
    converged: float = 1e-8  # as SciPy's; far below any standard error
    cost: float = 0.0
    evaluations: int | None = None
    loss: Loss = "linear"
    width: float = 1.0

    def least(self, start: Array) -> Least:
        """The least from the unknowns ``start`` on."""
        remembered: list[tuple[Array, State]] = []

        def at(x: Array) -> State:
            if not (remembered and np.array_equal(remembered[0][0], x)):
                remembered[:] = [(x.copy(), self.model(x))]
            return remembered[0][1]

        start = np.clip(start, *self.bounds)
        if not np.isfinite(at(start).residuals).all():
            raise SolveError("no curve of this body resembles the record")
        if self.loss == "linear":
            return self._of_squares(start, at(start))
        solution = optimize.least_squares(
            lambda x: at(x).residuals, start, lambda x: at(x).jacobian, bounds=self.bounds,
            method="trf", x_scale="jac", loss=self.loss, f_scale=self.width, max_nfev=self.evaluations,
            ftol=max(self.cost, self.converged), xtol=self.converged, gtol=self.converged,
        )  # fmt: skip
        steps, ended = int(solution.nfev), solution.status > 0
        return Least(self, solution.x, at(solution.x), float(solution.cost), solution.active_mask != 0, steps, ended)

    def _of_squares(self, x: Array, state: State) -> Least:
        """The least of squares by steps of Gauss and Newton within a radius, in units of the columns' lengths, that
        grows and shrinks with how well each foretells the cost (More, Lecture Notes in Mathematics 630 (1978) 105)."""
        cost, most, (low, high) = state.cost, self.evaluations or MOST_STEPS * x.size, self.bounds
        units, radius, steps = np.zeros_like(x), math.inf, 1
        while steps < most:
            slopes = state.jacobian.T @ state.residuals
            inner = ~((x <= low) & (slopes > 0) | (x >= high) & (slopes < 0))
            if not np.abs(slopes[inner]).max(initial=0.0) > self.converged:
                return self._ended(x, state, steps, True)
            units = np.maximum(units, np.linalg.norm(state.jacobian, axis=0))
            length = np.where(units > 0, units, 1.0)
            radius = min(radius, float(np.linalg.norm(x * length)) or 1.0)
            ball = _Ball.of(state.jacobian[:, inner] / length[inner], state.residuals)
            while steps < most:
                new = x.copy()
                new[inner] -= ball.step(radius) / length[inner]
                new = np.clip(new, low, high)
                there, steps = self._if_any(new), steps + 1
                change, moved = state.jacobian @ (new - x), float(np.linalg.norm((new - x) * length))
                predicted = -float(change @ (state.residuals + change / 2))
                reduction = -math.inf if there is None else cost - there.cost
                ratio = reduction / predicted if predicted > 0 else 0.0
                close = float(np.linalg.norm(new - x)) < self.converged * (self.converged + float(np.linalg.norm(x)))
                little = max(self.cost, self.converged) * cost
                foretold = TUNING.poor < ratio or (predicted < little and reduction > -little)
                ended = close or (foretold and reduction < little)
                if ratio < TUNING.poor:
                    radius = TUNING.poor * moved
                elif ratio > TUNING.good and TUNING.longer * moved > radius:
                    radius = 2 * radius
                if there is not None and reduction > 0:
                    x, state, cost = new, there, there.cost
                if ended:
                    return self._ended(x, state, steps, True)
                if reduction > 0:
                    break
        return self._ended(x, state, steps, False)

    def _if_any(self, x: Array) -> State | None:
        """The state at unknowns a step away; None where there is none: the next step is shorter."""
        with contextlib.suppress(SolveError):
            return self.model(x)
        return None

    def _ended(self, x: Array, state: State, steps: int, ended: bool) -> Least:
        low, high = self.bounds
        return Least(self, x, state, state.cost, (x <= low) | (x >= high), steps, ended)

    def holding(self, outcome: Outcome, value: float, weight: float) -> LeastSquares:
        """The same with one more row, that pulls an ``outcome`` to a ``value``."""

        def model(x: Array) -> State:
            state, (here, by) = self.model(x), outcome(x)
            off = np.append(state.residuals, weight * (here - value))
            return State(off, lambda: np.vstack([state.jacobian, weight * by]))

        return replace(self, model=model)


@dataclass(frozen=True, eq=False)
class Least:
    """The unknowns ``x`` of the least ``cost``, half the sum of the losses, of a ``problem``, and the ``state`` there;
    ``at_bound``: mask of those that end on a bound; ``ended``: whether it is a minimum, and not where the search was
    given up after so many ``steps``."""

    problem: LeastSquares
    x: Array
    state: State
    cost: float
    at_bound: Array
    steps: int
    ended: bool

    @property
    def dof(self) -> int:
        """Degrees of freedom."""
        return max(self.state.residuals.size - self.x.size, 1)

    @property
    def variance(self) -> float:
        """Of the residuals."""
        return 2 * self.cost / self.dof

    def profile(self, outcome: Outcome, step: float, limit: float) -> float | None:
        """The value of an ``outcome`` at which the least cost with it constrained is ``limit`` higher, where a
        ``step`` from here leads to; None: it never is.

        One more row pulls at the constrained value: what it comes to, and what that costs, lie on the profile.
        """
        here, loss, width = outcome(self.x)[0], self.problem.loss, self.problem.width
        weight = TUNING.pull * math.sqrt(2 * limit) / abs(step)
        near, known = [self.x], {0.0: (-math.sqrt(limit), self.x)}  # a search from elsewhere may end elsewhere

        def excess(k: float) -> float:
            if k not in known:
                constrained = self.problem.holding(outcome, here + k * step, weight).least(near[0])
                cost = costs(constrained.state.residuals[:-1], loss, width)
                known[k] = (math.sqrt(max(cost - self.cost, 0.0)) - math.sqrt(limit), constrained.x)
            value, near[0] = known[k]
            return value

        with contextlib.suppress(JkrError):
            for k in 2.0 ** np.arange(TUNING.doublings):
                if excess(k) >= 0:
                    excess(optimize.brentq(excess, 0.0 if k <= 1 else k / 2, k, xtol=NOTICEABLE, rtol=NOTICEABLE))
                    return outcome(near[0])[0]
                reached = outcome(near[0])[0]
                if abs(reached - here) < k * abs(step) / 2:  # a bound holds it
                    return reached
        return None


@dataclass(frozen=True, eq=False)
class _Ball:
    """Where the squares ``along`` right singular vectors ``V`` of derivatives, of singular ``sizes``, are least."""

    along: Array
    sizes: Array
    V: Array

    @classmethod
    def of(cls, J: Array, off: Array) -> _Ball:
        triangle: Array = np.asarray(np.linalg.qr(np.column_stack([J, off]), mode="r"))
        n = J.shape[1]
        U, sizes, V = np.linalg.svd(triangle[:n, :n])
        return cls(U.T @ triangle[:n, n], np.maximum(sizes, TUNING.singular * sizes[0]), V)

    def step(self, radius: float) -> Array:
        """The step to there that is no longer than ``radius``, by Newton's method for the inverse of its length."""
        more, coordinates = 0.0, self.along / self.sizes
        for _ in range(MOST_STEPS):
            length = float(np.linalg.norm(coordinates))
            if length <= TUNING.longer * radius:
                break
            rate = float(np.sum(coordinates**2 / (self.sizes**2 + more))) / length
            more += (length / radius - 1) * length / rate
            coordinates = self.sizes * self.along / (self.sizes**2 + more)
        inside: Array = coordinates @ self.V
        return inside


def by_differences(residuals: Callable[[Array], Array], x: Array, steps: Array) -> State:
    """The state of a model that gives residuals alone: derivatives by forward ``steps`` of the unknowns."""
    here = residuals(x)

    def rates() -> Array:
        return np.stack([(residuals(x + step) - here) / step.sum() for step in np.diag(steps)], axis=1)

    return State(here, rates)

"""The one search of all fits, and what follows from searching again: profiles.

``LeastSquares`` is what is minimised: a model, which gives its ``State`` at any unknowns, bounds and the loss, by a
trust region: its own for squares, SciPy's ("trf") for robust losses. An interval by the profile holds what follows from
the unknowns with one more row.
"""

from __future__ import annotations

import contextlib
import math
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from typing import Literal, get_args

import numpy as np

from ..base import numerics
from ..base.errors import NOTICEABLE, InputError, JkrError, SolveError
from ..base.executors import Pool, batches_in_order
from ..base.numerics import MOST_STEPS, SAME, TINY, TOGETHER, Array, f_quantile, median
from ..base.process import REMEMBERED
from .choices import Loss, Values
from .cosine import cosine_transform, fast_length
from .lockstep import Flow, alone, ask, by_groups, together
from .parameters import ALIAS, LIMITED, LOG, ONE_SIDED, FittedValue, Parameter, Unknowns

# --------------------------------------------------------------------------------------------------
# Statistics of residuals: scatter, covariance, structure. Formulae of nonlinear regression.

# Theory: turns of the losses at 95 % efficiency for normal noise (Holland and Welsch 1977).
TURNS = {"soft_l1": 1.345, "huber": 1.345, "cauchy": 2.385, "linear": math.inf}

# Chances below which noise is no explanation, and what is known of normal noise.
STATISTICS_NORMAL_MEDIAN = 0.6745  # theory: median of |x| of a normal x of standard deviation 1
STATISTICS_IMPROBABLE = 1e-3  # choice: of misfit, and of differences between records


def robust_scale(residuals: Array) -> float:
    """Standard deviation of normal residuals, from their median size."""
    return median(np.abs(residuals)) / STATISTICS_NORMAL_MEDIAN


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
    return inverse @ (pulls.T @ pulls) @ inverse


def larger(one: Array | None, other: Array | None) -> Array | None:
    """The covariance ``one`` with the standard deviations of ``other`` where these are larger; None where there is
    none."""
    if one is None or other is None:
        return one
    scale = np.sqrt(np.maximum(np.diag(other) / np.diag(one), 1.0))
    return one * np.outer(scale, scale)


@lru_cache(maxsize=REMEMBERED)
def t_quantile(level: float, dof: int) -> float:
    """Half-width of a two-sided interval in standard errors."""
    return math.sqrt(f_quantile(1, dof, level))


def chi2_increase(level: float, dof: int, parameters: int = 1) -> float:
    """Relative rise of the sum of squares on the border of a joint confidence region (F test)."""
    return parameters / dof * f_quantile(parameters, dof, level)


@dataclass(frozen=True)
class Structure:
    """Order in residuals along the curve: ``lag1`` autocorrelation, number of sign ``runs`` and how many are
    ``expected``; ``probability`` that independent residuals show as much (the smaller of both tests, doubled)."""

    lag1: float
    runs: int
    expected: float
    probability: float


def structure(residuals: Array) -> Structure:
    """Lag-1 autocorrelation and the runs test of Wald and Wolfowitz, both against positive structure."""
    n = residuals.size
    centred = residuals - residuals.sum() / n
    total = float(centred @ centred)
    lag1 = float(centred[1:] @ centred[:-1]) / total if total > 0 else 0.0
    above = residuals > median(residuals)
    k = int(np.count_nonzero(above))
    m = n - k
    runs = 1 + int(np.count_nonzero(above[1:] != above[:-1]))
    expected = 1 + 2 * k * m / n
    variance = max((expected - 1) * (expected - 2) / (n - 1), 1e-12)
    normal = min(-lag1 * math.sqrt(n), (runs - expected) / math.sqrt(variance))
    return Structure(lag1, runs, float(expected), min(1.0, math.erfc(-normal / math.sqrt(2))))


# Steps of a search, ends of profiles, and what laws of records over time have in common.
SEARCH_DOUBLINGS = 6  # choice: of the step in which a profile must reach its limit, else it has none
SEARCH_PULL = 10.0  # theory: how much more a constrained value weighs than the data, whose pull is then a hundredth
SEARCH_REACH = 12.0  # choice: guard, how far logs may move from their start
SEARCH_POOR = 0.25  # theory: More (1978): of the predicted reduction, below which steps are shorter
SEARCH_GOOD = 0.75  # theory: the same, above which they may be longer
SEARCH_LONGER = 1.01  # choice: factor within which a step is as long as the radius
SEARCH_SINGULAR = 1e-14  # theory: of the largest singular value, rounding
SEARCH_DIGITS = 1e-4  # theory: what is left of unit columns beside the others; its square is far above round-off
SEARCH_FLAT = 1e-12  # theory: of squares, the least curvature, which round-off leaves known to 1e-4
SEARCH_MISFIT = 1.3  # choice: scatter over the noise from row to row beyond which the law or the body is doubted


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
    def products(self) -> tuple[Array, Array]:
        """J^T J, and J^T r, the derivatives of the cost."""
        J = self.jacobian
        return J.T @ J, J.T @ self.residuals

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
Model = Callable[[Array], State]  # one with ``many``, a kernel of (model, x), is asked for all searches at once


def states(asked: Sequence[tuple[Model, Array]]) -> list[State | Exception]:
    """The states of models at their unknowns, those of one kind by its kernel ``many``."""
    return by_groups(asked, lambda one: getattr(one[0], "many", _each), lambda many, some: many(some))


def _each(asked: Sequence[tuple[Model, Array]]) -> list[State | Exception]:
    answers: list[State | Exception] = []
    for model, x in asked:
        try:
            answers.append(model(x))
        except Exception as error:
            answers.append(error)
    return answers


@dataclass(frozen=True, eq=False)
class LeastSquares:
    """What is minimised: the squares, or the robust ``loss`` that turns at ``width``, of a ``model``, within
    ``bounds``; relative changes below ``converged`` are none, those of the cost below ``cost`` if that is more."""

    model: Model
    bounds: tuple[Array, Array]
    converged: float = 1e-8  # as SciPy's; far below any standard error
    cost: float = 0.0
    evaluations: int | None = None
    loss: Loss = "linear"
    width: float = 1.0

    def least(self, start: Array) -> Least:
        """The least from the unknowns ``start`` on."""
        return alone(self.searching(start))

    def searching(self, start: Array) -> Flow[Least]:
        """The least from the unknowns ``start`` on, as a flow: side by side with other searches."""
        start = np.clip(start, *self.bounds)
        state = yield from ask(states, (self.model, start))
        if not np.isfinite(state.residuals).all():
            raise SolveError("no curve of this body resembles the force curve")
        if self.loss == "linear":
            return (yield from self._of_squares(start, state))
        from scipy.optimize import least_squares

        remembered = [(start, state)]

        def at(x: Array) -> State:
            if not np.array_equal(remembered[0][0], x):
                remembered[:] = [(x.copy(), self.model(x))]
            return remembered[0][1]

        solution = least_squares(
            lambda x: at(x).residuals, start, lambda x: at(x).jacobian, bounds=self.bounds,
            method="trf", x_scale="jac", loss=self.loss, f_scale=self.width, max_nfev=self.evaluations,
            ftol=max(self.cost, self.converged), xtol=self.converged, gtol=self.converged,
        )  # fmt: skip
        steps, ended = int(solution.nfev), solution.status > 0
        return Least(self, solution.x, at(solution.x), float(solution.cost), solution.active_mask != 0, steps, ended)

    def _of_squares(self, x: Array, state: State) -> Flow[Least]:
        """The least of squares by steps of Gauss and Newton within a radius, in units of the columns' lengths, that
        grows and shrinks with how well each foretells the cost (More, Lecture Notes in Mathematics 630 (1978) 105)."""
        cost, most = state.cost, self.evaluations or MOST_STEPS * x.size
        units, radius, steps = np.zeros_like(x), math.inf, 1
        while steps < most:
            step = yield from ask(steps_within, (self, x, state, units, radius))
            units, radius = step.units, step.radius
            if not step.left > self.converged or (
                0 <= step.predicted < self.cost * cost and SEARCH_LONGER * step.moved < radius
            ):
                return self._ended(x, state, steps, True)  # the step to the least is not worth taking
            there, steps = None, steps + 1
            with contextlib.suppress(SolveError):  # where there is no state the next step is shorter
                there = yield from ask(states, (self.model, step.new))
            reduction = -math.inf if there is None else cost - there.cost
            ratio = reduction / step.predicted if step.predicted > 0 else 0.0
            little = max(self.cost, self.converged) * cost
            foretold = SEARCH_POOR < ratio or (step.predicted < little and reduction > -little)
            ended = step.share < self.converged or (foretold and reduction < little)
            if ratio < SEARCH_POOR:
                radius = SEARCH_POOR * step.moved
            elif ratio > SEARCH_GOOD and SEARCH_LONGER * step.moved > radius:
                radius = 2 * radius
            if there is not None and reduction > 0:
                x, state, cost = step.new, there, there.cost
            if ended:
                return self._ended(x, state, steps, True)
        return self._ended(x, state, steps, False)

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
        problem = replace(self.problem, cost=NOTICEABLE * limit / max(self.cost, limit))
        here, loss, width = outcome(self.x)[0], problem.loss, problem.width
        weight = SEARCH_PULL * math.sqrt(2 * limit) / abs(step)
        near, known = [self.x], {0.0: (-math.sqrt(limit), self.x)}  # a search from elsewhere may end elsewhere

        def excess(k: float) -> float:
            if k not in known:
                constrained = problem.holding(outcome, here + k * step, weight).least(near[0])
                cost = costs(constrained.state.residuals[:-1], loss, width)
                known[k] = (math.sqrt(max(cost - self.cost, 0.0)) - math.sqrt(limit), constrained.x)
            value, near[0] = known[k]
            return value

        with contextlib.suppress(JkrError):
            for k in 2.0 ** np.arange(SEARCH_DOUBLINGS):
                if excess(k) >= 0:
                    ends = np.array([0.0 if k <= 1 else k / 2]), np.array([k])
                    excess(float(numerics.zeros_between(np.vectorize(excess), *ends, NOTICEABLE)[0]))
                    return outcome(near[0])[0]
                reached = outcome(near[0])[0]
                if abs(reached - here) < k * abs(step) / 2:  # a bound holds it
                    return reached
        return None


@dataclass(frozen=True, eq=False)
class Step:
    """A step of a search to ``new`` unknowns: ``moved``: its length in ``units`` of the columns' lengths, within a
    ``radius``; ``share``: its length over that of the unknowns as they are; ``predicted``: how much it would lower the
    cost; ``left``: largest derivative of the cost by an unknown that no bound holds."""

    new: Array
    units: Array
    radius: float
    moved: float
    share: float
    predicted: float
    left: float


def steps_within(asked: Sequence[tuple[LeastSquares, Array, State, Array, float]]) -> list[Step]:
    """The steps to where the squares of some problems, linear in the unknowns, are least within a radius, each from its
    unknowns and their state on, with the columns' lengths so far."""
    answers: dict[int, Step] = {}
    for size in {x.size for _, x, _, _, _ in asked}:
        places = [place for place, (_, x, _, _, _) in enumerate(asked) if x.size == size]
        problems, starts, at, lengths, radii = zip(*(asked[place] for place in places), strict=True)
        x, units, radius = np.array(starts), np.array(lengths), np.array(radii)
        low, high = np.array([problem.bounds for problem in problems]).transpose(1, 0, 2)
        squares, slopes = map(np.array, zip(*(state.products for state in at), strict=True))
        units = np.maximum(units, np.sqrt(np.diagonal(squares, axis1=1, axis2=2)))
        unit = 1 / np.where(units > 0, units, 1.0)
        seen = np.diagonal(squares, axis1=1, axis2=2) > 0  # no row depends on the others here
        inner = seen & ~((x <= low) & (slopes > 0) | (x >= high) & (slopes < 0))
        left, reach = np.max(np.abs(slopes), axis=1, where=inner, initial=0.0), _lengths(x / unit)
        radius = np.minimum(radius, np.where(reach > 0, reach, 1.0))
        # The step of Gauss and Newton where no bound holds an unknown, and squares keep digits enough.
        scaled, along = squares * (unit[:, :, None] * unit[:, None]), slopes * unit
        pivots = _pivots(scaled)
        whole = inner.all(axis=1) & (pivots.min(axis=1, initial=1.0) > SEARCH_DIGITS * pivots.max(axis=1, initial=0.0))
        step = np.zeros_like(x)
        step[whole] = np.linalg.solve(scaled[whole], along[whole, :, None])[..., 0]
        whole &= _lengths(step) <= SEARCH_LONGER * radius
        others = np.flatnonzero(~whole & (left > 0)).tolist()
        for i in others:
            some, most = inner[i], float(radius[i])
            step[i] = 0.0
            step[i, some] = _shorter(at[i], some, unit[i, some], scaled[i][some][:, some], along[i, some], most)
        new = np.minimum(np.maximum(x - step * unit, low), high)
        change = new - x
        predicted = -np.einsum("bi,bi->b", change, slopes + (squares @ change[..., None])[..., 0] / 2)
        for i in others:
            off = at[i].jacobian @ change[i]
            predicted[i] = -(off @ (at[i].residuals + off / 2))
        moved = _lengths(change / unit)
        share = _lengths(change) / (np.array([problem.converged for problem in problems]) + _lengths(x))
        each = zip(new, units, *(item.tolist() for item in (radius, moved, share, predicted, left)), strict=True)
        answers |= zip(places, (Step(*items) for items in each), strict=True)
    return [answers[place] for place in range(len(asked))]


def _lengths(vectors: Array) -> Array:
    return np.sqrt(np.einsum("bi,bi->b", vectors, vectors))


def _pivots(squares: Array) -> Array:
    """The diagonals of the Cholesky factors of matrices, 0 of those that are not positive definite."""
    try:
        pivots: Array = np.diagonal(np.linalg.cholesky(squares), axis1=1, axis2=2)
    except np.linalg.LinAlgError:
        if len(squares) == 1:
            return np.zeros(squares.shape[:2])
        pivots = np.concatenate([_pivots(one[None]) for one in squares])
    return pivots


def _shorter(state: State, inner: Array, unit: Array, squares: Array, slopes: Array, radius: float) -> Array:
    """The step, in ``unit`` of the ``inner`` unknowns, to where the squares of a state are least within a radius, by
    Newton's method for the inverse of its length; ``squares`` J^T J and ``slopes`` J^T r in these units."""
    # What is left along right singular vectors of J, their singular values, and they themselves; by J itself where
    # squares lose too many digits.
    each, V = np.linalg.eigh(squares)
    if each[0] > SEARCH_FLAT * each[-1]:
        sizes, rows = np.sqrt(each), V.T
        along = slopes @ V / sizes
    else:
        Q, triangle = np.linalg.qr(state.jacobian[:, inner] * unit)
        U, sizes, rows = np.linalg.svd(triangle)
        along, sizes = U.T @ (Q.T @ state.residuals), np.maximum(sizes, SEARCH_SINGULAR * sizes[0])
    more, coordinates = 0.0, along / sizes
    for _ in range(MOST_STEPS):
        length = math.hypot(*coordinates)
        if length <= SEARCH_LONGER * radius:
            break
        rate = float(np.sum(coordinates**2 / (sizes**2 + more))) / length
        more += (length / radius - 1) * length / rate
        coordinates = sizes * along / (sizes**2 + more)
    return coordinates @ rows


def by_differences(residuals: Callable[[Array], Array], x: Array, steps: Array) -> State:
    """The state of a model that gives residuals alone: derivatives by forward ``steps`` of the unknowns."""
    here = residuals(x)

    def rates() -> Array:
        return np.stack([(residuals(x + step) - here) / step.sum() for step in np.diag(steps)], axis=1)

    return State(here, rates)


# --------------------------------------------------------------------------------------------------
# Errors and intervals of whatever the unknowns of a search mean: by their covariance, by profiles, by samples, and by
# inputs that are uncertain themselves.
#
# Each quantity has a scale on which it is regular (``Parameter.kind``), and intervals are made there.

# How intervals are computed.
INTERVAL_STEP = 1e-6  # theory: of unknowns, for central differences: of smooth meanings round-off leaves 1e-10
INTERVAL_EXACT = 1e-24  # theory: variance of residuals over their standard deviations that round-off leaves
INTERVAL_BEGIN = 0.1  # choice: of a log, where a profile begins while no error is known


Followed = Literal["covariance", "profile"]  # how intervals are computed where records are not drawn again
Meaning = Callable[[Array], Values]  # of the unknowns: quantities by name, on their scales


@dataclass(frozen=True, eq=False)
class Intervals:
    """What the unknowns of a ``least`` mean, and how well it is known: ``covariance`` of the unknowns, None where they
    are not determined; ``t``: half-width of intervals of a ``level`` in standard errors; ``profiled``: by profiles, for
    which residuals have a ``variance``, None: that of the covariance; ``samples`` of the unknowns (n, unknowns)."""

    least: Least
    quantities: Sequence[Parameter]
    meaning: Meaning
    covariance: Array | None
    t: float
    level: float
    profiled: bool = False
    variance: float | None = None
    samples: Array | None = None

    @classmethod
    def of(
        cls, unknowns: Unknowns, least: Least, level: float, confidence: str = "covariance",
        E_star: float | None = None, variance: float | None = None,
    ) -> Intervals:  # fmt: skip
        """Of the first ``unknowns`` of a search whose residuals have a known ``variance``, or that which they show, and
        of what a factor of all moduli makes of ``E_star`` [Pa]."""
        if confidence not in get_args(Followed):
            raise InputError(f"fit: --confidence {confidence}: is for curves each for itself: leave it out")
        follow = () if E_star is None else (Parameter(ALIAS, True, scale=LOG, quantity="modulus", follows=True),)

        def meaning(x: Array) -> dict[str, float]:
            values = unknowns.meaning(x)
            return values if E_star is None else values | {ALIAS: values["modulus"] + math.log(E_star)}

        variance = max(least.variance, INTERVAL_EXACT) if variance is None else variance
        own, t = covariance(least.state.jacobian, variance), t_quantile(level, least.dof)
        return cls(least, (*unknowns.parameters, *follow), meaning, own, t, level, confidence == "profile")

    @cached_property
    def here(self) -> Values:
        """All quantities on their scales."""
        return self.meaning(self.least.x)

    @cached_property
    def rates(self) -> dict[str, Array]:
        """Their derivatives by the unknowns, by central differences."""
        return self._rates(self.least.x)

    def _rates(self, x: Array) -> dict[str, Array]:
        sigma = np.ones(x.size) if self.covariance is None else np.sqrt(np.diag(self.covariance))
        steps = INTERVAL_STEP * np.maximum(np.abs(x), np.minimum(sigma, 1.0))
        ends = [(self.meaning(x + step), self.meaning(x - step), 2 * float(step.sum())) for step in np.diag(steps)]
        return {name: np.array([(high[name] - low[name]) / width for high, low, width in ends]) for name in self.here}

    @cached_property
    def drawn(self) -> list[Values]:
        """What the samples mean."""
        return [] if self.samples is None else [self.meaning(x) for x in self.samples]

    def sampled(self, names: Sequence[str]) -> Array | None:
        """The samples of quantities (n, names), SI; None where there are none."""
        chosen = [item for name in names for item in self.quantities if item.name == name]
        rows = [[item.outer(values[item.name]) for item in chosen] for values in self.drawn]
        return np.array(rows) if rows else None

    def covariance_of(self, names: Sequence[str]) -> Array | None:
        """The covariance of quantities, SI."""
        if self.covariance is None:
            return None
        slopes = {item.name: item.derivative(self.here[item.name]) for item in self.quantities}
        by = np.array([slopes[name] * self.rates[name] for name in names])
        with np.errstate(all="ignore"):
            matrix: Array = by @ self.covariance @ by.T
        return matrix if np.isfinite(matrix).all() else None

    def estimates(self) -> tuple[FittedValue, ...]:
        """All quantities with their intervals, those that follow from others with theirs."""
        estimates: list[FittedValue] = []
        for item in self.quantities:
            estimates.append(self._estimate(item, estimates))
        return tuple(estimates)

    def _estimate(self, item: Parameter, before: Sequence[FittedValue]) -> FittedValue:
        y = self.here[item.name]
        if not self.rates[item.name].any():
            value = item.outer(y) if item.value is None else item.value
            return FittedValue(item.name, value, False, item.dimension)
        estimate = item.estimate(y, self.errors[item.name], self.t)
        if self.drawn:  # the scatter of the samples, and the interval of so many of them
            values = np.array([item.outer(sample[item.name]) for sample in self.drawn])
            low, high = map(float, np.quantile(values, [(1 - self.level) / 2, (1 + self.level) / 2]))
            if item.kind in LIMITED and low <= 0:
                low, high = 0.0, float(np.quantile(values, self.level))
            return replace(estimate, error=float(np.std(values, ddof=1)), low=low, high=high)
        if not self.profiled:
            return self.with_limit(estimate) if item.kind == "root" and estimate.low == 0 else estimate
        if item.follows:  # the log of a quantity that follows from one alone has the profile of that
            rate = self.rates[item.name]
            for one, other in zip(self.quantities, before, strict=False):
                by = self.rates[one.name]
                power = float(rate @ by) / max(float(by @ by), TINY)
                if one.kind == "log" and np.linalg.norm(rate - power * by) <= SAME * np.linalg.norm(rate):
                    shared = [None if end is None else estimate.value * (end / other.value) ** power
                              for end in (other.low, other.high)]  # fmt: skip
                    return replace(estimate, low=shared[0 if power > 0 else 1], high=shared[1 if power > 0 else 0])
            return estimate
        ends = self.end(item, -self.t), self.end(item, self.t)
        if item.kind in LIMITED and (ends[0] is None or ends[0] <= 0):
            ends = 0.0, self.end(item, ONE_SIDED * self.t)
        return replace(estimate, low=ends[0], high=ends[1])

    @cached_property
    def errors(self) -> Mapping[str, float | None]:
        """The standard errors on the scales; None where the unknowns are not determined, or a variance is infinite."""
        if self.covariance is None:
            return dict.fromkeys(self.rates)
        by = np.array(list(self.rates.values()))
        with np.errstate(all="ignore"):
            errors = np.sqrt(np.maximum(np.sum(by @ self.covariance * by, axis=1), 0.0)).tolist()
        return {name: error if math.isfinite(error) else None for name, error in zip(self.rates, errors, strict=True)}

    def with_limit(self, estimate: FittedValue) -> FittedValue:
        """The estimate of a quantity that may be 0, as far as its profile goes: curves bend in its root."""
        item = next(one for one in self.quantities if one.name == estimate.name)
        high = max(self.end(item, ONE_SIDED * self.t) or 0.0, estimate.high or 0.0)
        return replace(estimate, error=max(high / (2 * self.t), estimate.error or 0.0), high=high)

    def end(self, item: Parameter, width: float) -> float | None:
        """The value at which the least cost with the quantity held is as much higher as ``width`` standard errors make
        it where the model is linear; None: it never is."""
        rate, sigma = self.rates[item.name], self.errors[item.name]
        step = math.copysign(INTERVAL_BEGIN, width) if sigma is None else width * sigma
        if item.kind == "log":  # of a vague one more would overflow
            step = max(min(step, 1.0), -1.0)
        variance = self.variance
        if variance is None:
            J = self.least.state.jacobian
            variance = (sigma or 0.0) ** 2 / float(np.sum(np.linalg.lstsq(J.T, rate, rcond=None)[0] ** 2))

        def outcome(x: Array) -> tuple[float, Array]:
            return self.meaning(x)[item.name], self._rates(x)[item.name]

        y = self.least.profile(outcome, step, 0.5 * width**2 * variance)
        if y is None:
            return None
        # a log that ends where the search may not go ends nothing that the data leave, but for an end of the user's
        i, given = int(np.argmax(rate)), 0 < (item.high if width > 0 else item.low) < math.inf
        own = item.kind == "log" and abs(rate[i] - 1) < NOTICEABLE and np.count_nonzero(rate) == 1
        if own and not given and abs(y - self.least.problem.bounds[1 if width > 0 else 0][i]) < NOTICEABLE:
            return None
        return 0.0 if item.kind == "positive" and y < SAME * (sigma or 0.0) else item.outer(y)


# ---------------------------------------------------------------------- samples
def bootstrap(
    least: Least, change: Callable[[np.random.Generator], Callable[[State], State]], cost: float, count: int, seed: int,
    pool: Pool | None,
) -> Array:  # fmt: skip
    """Unknowns of the least of ``count`` problems, each with its states changed at random, to ``cost`` relatively, from
    a first step by Gauss and Newton; fewer where no search reaches it (samples, unknowns)."""
    draw = partial(_samples, least, change, cost, seed)
    samples = batches_in_order(pool, draw, range(count), "bootstrap", TOGETHER)
    return np.array([x for x in samples if x is not None])


def _samples(
    least: Least, change: Callable[[np.random.Generator], Callable[[State], State]], cost: float, seed: int,
    numbers: list[int],
) -> list[Array | Exception | None]:  # fmt: skip
    """The samples of some ``numbers``, searched side by side."""

    def sampling(changed: Callable[[State], State]) -> Flow[Array | None]:
        here = changed(least.state)
        near = least.x - np.linalg.lstsq(here.jacobian, here.residuals, rcond=None)[0]
        problem = replace(least.problem, model=_Changed(least.problem.model, changed), converged=cost, cost=cost)
        with contextlib.suppress(JkrError):
            return (yield from problem.searching(near)).x
        return None

    return together([sampling(change(np.random.default_rng([seed, number]))) for number in numbers])


@dataclass(frozen=True, eq=False)
class _Changed:
    """A model whose states are ``changed``."""

    model: Model
    changed: Callable[[State], State]

    def __call__(self, x: Array) -> State:
        return self.changed(self.model(x))

    @staticmethod
    def many(asked: Sequence[tuple[_Changed, Array]]) -> list[State | Exception]:
        """The states of some of them, each at its unknowns."""
        found = states([(one.model, x) for one, x in asked])
        each = zip(asked, found, strict=True)
        return [state if isinstance(state, Exception) else one.changed(state) for (one, _), state in each]


# ---------------------------------------------------------------------- uncertain inputs, to first order
def wider(item: FittedValue, systematic: Values, t: float) -> FittedValue:
    """The estimate with its ``systematic`` errors by name, what each changes, added in quadrature."""
    total = math.hypot(*systematic.values())
    if total == 0:
        return item
    error = None if item.error is None else math.hypot(item.error, total)
    low = None if item.low is None else item.value - math.hypot(item.value - item.low, t * total)
    high = None if item.high is None else item.value + math.hypot(item.high - item.value, t * total)
    if low is not None and item.dimension in ("modulus", "work"):
        low = max(low, 0.0)
    return replace(item, error=error, low=low, high=high, systematic=dict(systematic))


# --------------------------------------------------------------------------------------------------
# Least squares under noise whose neighbours follow each other: drift, hum, 1/f, slow steps.
#
# The noise is what the free rows of a record say, without any model of the contact. Its spectrum, S(f) = A + B/(1 +
# (f/c)^2)^(b/2), white and of one correlation time (b = 2) or of a power of the frequency (c far below all), follows
# by the likelihood of Whittle (Ark. Mat. 2, 423, 1953) from the squares of the cosine transform of their residuals in
# octaves, each divided by the share of it that the fit has left; where too few rows are free, from that of all.
# Spectra that are nearly as likely have a share in it, as they go on differently below the frequencies that are seen.
# The cosine transform takes a series that ends elsewhere than it began for no jump.
#
# With rows weighted by W the covariance of the unknowns is (WJ)^+ W C W^T (WJ)^+T, C the noise (White, Econometrica
# 48, 817, 1980); where W C W^T = 1, the generalised least squares, it is the least there is. Noise slower than the
# free rows are long hides in them (a random walk of a fifth of the white noise, in every fifth record): where they
# tell none that is slow, its colour is that of all residuals, if they are as likely with it and it raises standard
# errors by no more than ``COLOURED_HIDDEN``. Other residuals in contact that are larger or slower are no noise: an
# excess reports them. Where noise goes on rising below the frequencies of the free rows (1/f) nothing tells how far:
# standard errors are wider there, by the excess too. An octave stands at the frequency where 1/f has its mean over
# what the fit has left of it: at that of its middle, the lowest octave of a run, of which a straight line was taken,
# would tell two thirds of such noise.

# How spectra are estimated.
COLOURED_CORNERS = 24  # choice: correlation times tried, from a few rows to the whole record
COLOURED_POWERS = (0.5, 0.75, 1.0, 1.25, 1.5, 2.0)  # choice: of 1/f, tried
COLOURED_ROUNDS = 8  # choice: of reweighting; the likelihood is then good to 1e-3
COLOURED_SHARE = 0.25  # choice: of an octave that the fit must have left, below which it joins the next
COLOURED_LEAST = 4.0  # theory: Akaike's criterion, 2 ln of the likelihoods' ratio for two more parameters
COLOURED_BESIDE = 8  # choice: least rows on each side of missing ones, whose means a line goes through
COLOURED_LIKELY = 0.05  # choice: of the likeliest spectrum, likelihood below which one has no share
COLOURED_FREE = 40  # choice: free rows of a direction that tell its noise
COLOURED_SEEN = 4.0  # choice: of the lowest frequency of the free rows, the lowest corner that they tell
# choice: of the lowest frequency of the free rows, the corner of a power of f: below what a record sees, but not so
# far that its mean says nothing of the offsets
COLOURED_LOWEST = 0.05
# of standard errors, where noise goes on rising at frequencies that no free row tells; tuned on cycles with 1/f
# noise, by `make record-bounds`
COLOURED_UNSEEN = 1.1
COLOURED_EXCEEDED = 2.0  # choice: of the noise there, what the rows in contact say more of it at most
# choice: of standard errors, by which slow noise that free rows do not tell may raise them; more is misfit
COLOURED_HIDDEN = 3.0
COLOURED_WHITE = 0.5  # theory: before the data nothing speaks for a slow part of the noise or against it
# choice: of the white part at the lowest frequency that free rows tell, the slow parts that may hide
COLOURED_HEIGHTS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)
COLOURED_IMPOSSIBLE = 1e-12  # choice: chance of a spectrum that is left out
COLOURED_SINGULAR = 1e-12  # theory: of the largest singular value, round-off of some thousand rows, each 2e-16


@dataclass(frozen=True)
class Spectrum:
    """A + sum of B/(1 + (f/c)^2)^(b/2) over frequencies f per row, ``slow`` parts (B, c, b)."""

    A: float
    slow: tuple[tuple[float, float, float], ...] = ()

    def __call__(self, f: Array) -> Array:
        density, squares, part = np.full(f.shape, self.A), f * f, np.empty(f.shape)
        for B, corner, power in self.slow:
            np.add(squares, corner**2, out=part)
            if power != 2:
                part **= power / 2
            density += np.divide(B * corner**power, part, out=part)
        return density

    def times(self, factor: float) -> Spectrum:
        """The same of a variance ``factor`` times as large."""
        return Spectrum(factor * self.A, tuple((factor * B, corner, power) for B, corner, power in self.slow))

    def level(self, rows: int) -> float:
        """The variance of a row of so many."""
        return float(np.mean(density(self, rows)))

    def beyond(self, f: float) -> bool:
        """Whether most of it goes on rising at frequencies below ``f``, which no run of free rows tells."""
        there = [(c, B / (1 + (f / c) ** 2) ** (b / 2)) for B, c, b in self.slow]
        return sum(S for c, S in there if c < f) > (self.A + sum(S for _, S in there)) / 2

    def whitened(self, columns: Array) -> Array:
        """Columns of rows in the order of time, (rows, ...), so that this noise has unit variance and no colour."""
        if not self.slow:
            return columns / math.sqrt(self.A)
        return (waves(columns).T / np.sqrt(density(self, len(columns)))).T

    def unlikely(self, series: Array) -> float:
        """Minus twice the logarithm of the likelihood of a series in the order of time (Whittle)."""
        if not series.size:
            return 0.0
        S = np.maximum(density(self, series.size), TINY)
        return float(np.sum(np.log(S) + cosine_transform(series) ** 2 / S))

    def drawn(self, rng: np.random.Generator, rows: int) -> Array:
        """A series of so many ``rows`` of this noise."""
        from scipy.fft import idct

        return idct(np.sqrt(density(self, rows)) * rng.normal(size=rows), norm="ortho")


@dataclass(frozen=True, eq=False)
class Spread:
    """``covariance`` of the unknowns; ``tau``: how many rows count as one, the factor by which the colour of the noise
    raises their variances; ``excess``: the factor by which the residuals of all rows would widen the standard errors
    beyond it (both medians). ``dof``: rows that determine the ``noise``; ``seen``: its waves in the free rows."""

    covariance: Array
    tau: float
    excess: float
    dof: int
    noise: Spectrum
    seen: Periodogram | None = None

    @cached_property
    def possible(self) -> Possible | None:
        """Where the noise of free rows is white, what it may be as well, each with its chance."""
        return None if self.seen is None or self.noise.slow else self.seen.possible()


@dataclass(frozen=True, eq=False)
class Possible:
    """Spectra that a noise may have, each with its ``chance``: A + B/(1 + (f/c)^2)^(b/2), the ``shape`` of which is the
    number of its ``corner`` c and ``power`` b."""

    chance: Array
    A: Array
    B: Array
    shape: Array
    corner: Array
    power: Array

    def of_waves(self, f: Array, squares: Array) -> Array:
        """The sums of ``squares`` (columns, n) of waves of frequencies ``f`` (columns, n), each by what a spectrum has
        there: (spectra, columns)."""
        slow = _slow(f.ravel(), self.corner[:, None], self.power[:, None]).reshape(-1, *f.shape)
        of_slow = np.einsum("scn,cn->sc", slow, squares)
        return np.outer(self.A, squares.sum(axis=1)) + self.B[:, None] * of_slow[self.shape]


def _slow(f: Array, corner: Array, power: Array) -> Array:
    """1/(1 + (f/c)^2)^(b/2) = c^b/(c^2 + f^2)^(b/2) of frequencies, for each corner c and power b, of which most are
    2."""
    shape: Array = f * f + corner**2
    other = np.flatnonzero(power != 2)
    shape[other] **= power[other] / 2
    return np.divide(corner**power, shape, out=shape)


def frequencies(rows: int) -> Array:
    """Those of the cosine transform, per row."""
    return np.arange(rows) / (2 * rows)


@lru_cache(maxsize=TOGETHER)
def density(noise: Spectrum, rows: int) -> Array:
    """That of a ``noise`` at the frequencies of so many ``rows``."""
    return noise(frequencies(rows))


def waves(columns: Array) -> Array:
    """The orthonormal cosine transform of columns of rows."""
    return cosine_transform(columns.T).T


@dataclass(frozen=True, eq=False)
class TimeOrder:
    """The ``order`` in time of some rows of a record, their ``places`` from the first on, and for each gap between them
    the number of the row that ends it, in ``ends``, and how many are ``missing``."""

    order: Array
    places: Array
    ends: tuple[int, ...]
    missing: tuple[int, ...]

    @classmethod
    def of(cls, rows: Array) -> TimeOrder:
        order = np.argsort(rows, kind="stable")
        places = rows[order] - rows.min()
        steps = places[1:] - places[:-1]
        gaps = np.flatnonzero(steps > 1)
        return cls(order, places, tuple((gaps + 1).tolist()), tuple((steps[gaps] - 1).tolist()))

    def series(self, columns: Array, noise: Spectrum) -> Array:
        """Columns of the rows, (rows, ...), in the order of time. Over those that are missing straight lines through
        the means of as many beside them, as much of them as ``noise`` of that length is slow: it goes on meanwhile."""
        known = columns.T[..., self.order]
        series = np.zeros((*known.shape[:-1], int(self.places[-1]) + 1))
        series[..., self.places] = known
        slow_shares = (1 - noise.A / noise(0.5 / np.array(self.missing))).tolist() if self.missing else ()
        for i, count, slow in zip(self.ends, self.missing, slow_shares, strict=True):
            beside, at = max(count, COLOURED_BESIDE), int(self.places[i])
            parts = known[..., max(i - beside, 0) : i], known[..., i : i + beside]
            first, last = (slow * part.sum(axis=-1, keepdims=True) / part.shape[-1] for part in parts)
            series[..., at - count : at] = first + np.arange(1, count + 1) / (count + 1) * (last - first)
        return series.T


def in_time(columns: Array, rows: Array, noise: Spectrum) -> Array:
    """Columns of some ``rows`` of a record in the order of time, the missing ones bridged as the ``noise`` goes on."""
    return TimeOrder.of(rows).series(columns, noise)


def covariance_coloured(off: Array, J: Array, free: Sequence[Array], weight: Spectrum, rounding: float = 0.0) -> Spread:
    """The covariance of unknowns from residuals ``off`` and their derivatives ``J``, in the order of time, that were
    fitted with the ``weight`` of such noise; very large where the data do not determine an unknown. ``free``:
    residuals of runs of rows out of contact; ``rounding``: variance of readings in steps of a converter, the least."""
    free = [run for run in free if run.size > 2]  # of fewer a line leaves nothing
    # as many waves as are transformed fast: of each what is not of these rows counts as taken
    waves = off.size if weight.slow else fast_length(off.size)
    columns = np.zeros((J.shape[1] + 1, waves))
    columns[:-1, : off.size], columns[-1, : off.size] = J.T, off
    rows = cosine_transform(columns)
    own = density(weight, off.size) if weight.slow else 1.0  # no white weight changes the covariance
    if weight.slow:
        rows /= np.sqrt(own)
    Q, inverse = _factors(rows[:-1])
    f = frequencies(waves)
    octaves = Octaves.of(f, np.einsum("ij,ij->j", Q, Q) + (1 - off.size / waves))
    all_rows = Periodogram(octaves, octaves.means(rows[-1] ** 2)).spectrum()
    every = all_rows(f) * own if all_rows.slow or weight.slow else all_rows.A
    loose = sum(run.size for run in free)
    seen = _of_base_lines(free, rounding) if loose >= COLOURED_FREE else None
    noise = Spectrum(float(np.mean(every))) if seen is None else seen.spectrum()

    def of(noise: Array | float) -> Array:
        if isinstance(noise, float) and not weight.slow:  # Q Q^T = 1
            return noise * (inverse @ inverse.T)
        return inverse @ ((Q * (noise / own)) @ Q.T) @ inverse.T

    def of_spectrum(noise: Spectrum) -> tuple[Array, float]:
        level = density(noise, waves) if noise.slow else noise.A
        return of(level), float(np.mean(level))

    beside, (covariance, level) = of(every), (of(every), float(np.mean(every))) if seen is None else of_spectrum(noise)
    rise = _rise(beside, covariance)
    colour = weight if weight.slow else all_rows
    if seen is not None and rise < COLOURED_HIDDEN**2 and not noise.slow and colour.slow and colour.A:
        # noise slower than the free rows are long shows in all: of this colour, if it is as likely in them
        hidden = colour.times(noise.A / colour.A)
        if seen.unlikely(hidden) <= seen.unlikely(noise):
            noise, (covariance, level) = hidden, of_spectrum(hidden)
            rise = _rise(beside, covariance)
    tau, excess = _rise(covariance, of(level)), math.sqrt(max(rise, 1.0))
    if seen is not None and noise.beyond(1 / (2 * max(run.size for run in free))):
        covariance = covariance * (COLOURED_UNSEEN * min(excess, COLOURED_EXCEEDED)) ** 2
    return Spread(covariance, max(tau, 1.0), excess, off.size if seen is None else loose, noise, seen)


def _factors(J: Array) -> tuple[Array, Array]:
    """Q and R^-1 of J^T = Q^T R, the rows of Q orthonormal: by J J^T, a fifth of the work, unless that loses too many
    digits; very large along what J, (unknowns, rows), does not tell."""
    squares = J @ J.T
    size = np.sqrt(squares.diagonal())
    size[size == 0] = 1.0
    with contextlib.suppress(np.linalg.LinAlgError):
        lower = np.linalg.cholesky(squares / (size[:, None] * size))
        if (pivots := lower.diagonal()).min(initial=1.0) > SEARCH_DIGITS * pivots.max(initial=0.0):
            inverse = np.linalg.inv(lower) / size
            return inverse @ J, inverse.T
    Q, R = np.linalg.qr(J.T / size)
    U, s, V = np.linalg.svd(R)
    return Q.T, (V.T / np.maximum(s, COLOURED_SINGULAR * s[0])) @ U.T / size[:, None]


def _rise(one: Array, other: Array) -> float:
    """The median factor between the variances of two covariances."""
    pairs = zip(one.diagonal().tolist(), other.diagonal().tolist(), strict=True)
    factors = [more / less for more, less in pairs if less > 0]
    return statistics.median(factors) if factors else 1.0


def _of_base_lines(runs: Sequence[Array], rounding: float) -> Periodogram:
    """The residuals of runs of free rows, of each of which the fit has taken a straight line, their variance not below
    that of ``rounding``, which a line that stands still does not show."""
    order, octaves = _beside_lines(tuple(run.size for run in runs))
    parts = []
    for off in runs:
        n = off.size
        along = np.arange((1 - n) / 2, n / 2)
        along *= along @ off * 12 / (n * (n**2 - 1.0))
        along += off.sum() / n
        parts.append(cosine_transform(off - along))
    power = np.concatenate(parts)[order]
    power *= power
    return Periodogram(octaves, np.maximum(octaves.means(power), max(rounding, TINY)))


@lru_cache(maxsize=TOGETHER)
def _beside_lines(runs: tuple[int, ...]) -> tuple[Array, Octaves]:
    """The order by frequency of the waves of runs of so many rows, and their octaves beside a line through each run."""
    f = np.concatenate([np.arange(rows) / (2 * rows) for rows in runs])
    order, taken = np.argsort(f, kind="stable"), np.concatenate([taken_by_line(rows) for rows in runs])
    return order, Octaves.of(f[order], taken[order])


def taken_by_line(rows: int) -> Array:
    """How much of each wave a straight line over so many rows takes: of a constant the lowest, of a slope the odd ones,
    whose transform goes with cos t/sin^2 t, t = pi k/(2 n)."""
    taken, t = np.zeros(rows), np.pi / (2 * rows) * np.arange(1, rows, 2)
    taken[0], taken[1::2] = 1.0, 6 / (rows**2 * (rows**2 - 1.0)) * (np.cos(t) / np.sin(t) ** 2) ** 2
    return taken


@dataclass(frozen=True, eq=False)
class Octaves:
    """Octaves of the waves of a series, from those of number ``first`` on, about frequencies ``centre``: the ``count``
    of waves that the fit has left of each; ``lowest``: the lowest frequency above 0."""

    first: Array
    count: Array
    centre: Array
    lowest: float

    @classmethod
    def of(cls, f: Array, taken: Array) -> Octaves:
        """Of frequencies ``f`` in increasing order; ``taken``: how much of each wave the fit has. An octave of which
        too little is left joins the next; the last is up to two wide, as half of one tells little."""
        lowest = float(f[np.searchsorted(f, 0.0, side="right")])
        begins = np.append(0, 2 ** np.arange(max(math.ceil(math.log2(f.size)) - 1, 0)))
        left = np.empty((2, f.size))
        np.subtract(1.0, np.minimum(taken, 1.0), out=left[0])
        np.divide(left[0], np.maximum(f, lowest / 2), out=left[1])
        octaves: list[list[float]] = []  # the first wave of each, how many are left of it, and their sum over f
        for begin, waves, over_f in zip(begins.tolist(), *np.add.reduceat(left, begins, axis=1).tolist(), strict=True):
            if octaves and octaves[-1][1] <= COLOURED_SHARE * (begin - octaves[-1][0]):
                octaves[-1][1:] = octaves[-1][1] + waves, octaves[-1][2] + over_f
            else:
                octaves.append([begin, waves, over_f])
        first, count, over = np.array(octaves).T.copy()
        return cls(first.astype(int), count, count / over, lowest)  # the centre is where 1/f is its mean

    def means(self, power: Array) -> Array:
        """The mean squares of waves, of ``power`` each, in octaves."""
        return np.add.reduceat(power, self.first) / self.count

    @property
    def slow(self) -> tuple[Array, Array]:
        """Slow parts at the centres, (shapes, octaves), over what they are at the lowest, (shapes,)."""
        corner, power = _shapes(self.lowest)
        slow = _slow(self.centre, corner[:, None], power[:, None])
        return slow / slow[:, :1], slow[:, 0]

    @property
    def hidden(self) -> tuple[Array, Array, Array]:
        """White spectra 1 or 1 + r with one slow part r: 1/(1 + r), (spectra, octaves), n ln(1 + r) of all n waves, and
        the heights of r by its shape, (spectra,)."""
        slow, tops = self.slow
        heights = np.array(COLOURED_HEIGHTS)[:, None]
        risen = np.ones((1 + heights.size * len(slow), slow.shape[1]))
        risen[1:] += (heights[..., None] * slow).reshape(-1, slow.shape[1])
        return 1 / risen, np.log(risen) @ self.count, np.append(0.0, heights / tops)


@dataclass(frozen=True, eq=False)
class Periodogram:
    """The ``mean`` squares of the waves of a series in ``octaves``."""

    octaves: Octaves
    mean: Array

    def unlikely(self, noise: Spectrum) -> float:
        """Minus twice the logarithm of Whittle's likelihood of a spectrum."""
        return float(_unlikely(self.mean, noise(self.octaves.centre)[None], self.octaves.count)[0])

    def spectrum(self) -> Spectrum:
        """The spectrum that is likeliest, with those that are nearly so; white where none that falls gains enough."""
        mean, count = self.mean, self.octaves.count
        white = float(mean @ count / count.sum())
        if not white or sum(n * math.log(white / level) for level, n in _falling(mean, count)) < COLOURED_LEAST:
            return Spectrum(white)  # no spectrum that falls gains as much
        (corner, power), (slow, tops) = _shapes(self.octaves.lowest), self.octaves.slow
        # A and B, not below 0, that are likeliest for each shape, by least squares weighted with the spectrum so far
        items = np.stack([np.ones_like(slow), slow, slow**2, np.broadcast_to(mean, slow.shape), slow * mean], axis=1)
        S = np.broadcast_to(np.maximum(mean, 1e-3 * mean.max()), slow.shape)
        for _ in range(COLOURED_ROUNDS):
            weights = count / np.maximum(S, TINY) ** 2
            aa, ab, bb, a, b = (items @ weights[..., None])[..., 0].T
            determinant = aa * bb * (1 + COLOURED_SINGULAR) - ab * ab
            A, B = (a * bb - b * ab) / determinant, (b * aa - a * ab) / determinant
            A, B = np.where(B < 0, a / aa, np.where(A < 0, 0.0, A)), np.where(B < 0, 0.0, np.where(A < 0, b / bb, B))
            S = A[:, None] + B[:, None] * slow
        deviance = _unlikely(mean, A[:, None] + B[:, None] * slow, count)
        if deviance.min() > count.sum() * (np.log(white) + 1) - COLOURED_LEAST:
            return Spectrum(white)
        share = np.exp((deviance.min() - deviance) / 2)
        share = np.where(share > COLOURED_LIKELY, share, 0.0) / share[share > COLOURED_LIKELY].sum()
        parts = zip((share * B / tops).tolist(), corner.tolist(), power.tolist(), strict=True)
        return Spectrum(float(share @ A), tuple(part for part in parts if part[0]))

    def possible(self) -> Possible:
        """Spectra with their chances after the data: white or with one slow part, those of one correlation time and
        those of 1/f being as likely before."""
        (corner, power), (level, rise, over_A) = _shapes(self.octaves.lowest), self.octaves.hidden

        # chances before the data, of white noise and of each shape at each height, and the number of its shape
        corners, powers, heights = COLOURED_CORNERS, len(COLOURED_POWERS), len(COLOURED_HEIGHTS)
        kinds = np.repeat([1 / corners, 1 / powers], [corners, powers]) / 2
        before = np.append(COLOURED_WHITE, np.tile((1 - COLOURED_WHITE) / heights * kinds, heights))
        shape = np.append(0, np.tile(np.arange(corners + powers), heights))

        # the likeliest A of A (1 + r) is the mean square over 1 + r, and minus twice the logarithm of Whittle's
        # likelihood there n ln A + the sum of ln(1 + r), but for a constant
        waves = self.octaves.count.sum()
        A = level @ (self.octaves.count * self.mean) / waves
        unlikely = waves * np.log(A) + rise
        chance = before * np.exp((unlikely.min() - unlikely) / 2)
        kept = chance > COLOURED_IMPOSSIBLE * chance.sum()
        return Possible(chance[kept] / chance[kept].sum(), A[kept], (A * over_A)[kept], shape[kept], corner, power)


def _shapes(lowest: float) -> tuple[Array, Array]:
    """Corners and powers of slow parts, of one correlation time and of 1/f, of runs of a ``lowest`` frequency."""
    first, powers = COLOURED_SEEN * lowest, np.array(COLOURED_POWERS)
    corners = first * (0.2 / first) ** (np.arange(COLOURED_CORNERS) / (COLOURED_CORNERS - 1))
    return np.append(corners, 0 * powers + COLOURED_LOWEST * lowest), np.append(0 * corners + 2.0, powers)


def _falling(mean: Array, count: Array) -> list[tuple[float, float]]:
    """The likeliest spectrum of octaves with these ``mean`` squares that rises nowhere: means of those that do pooled
    (Barlow et al., Statistical Inference under Order Restrictions, 1972), the level and the waves of each pool."""
    pools: list[tuple[float, float]] = []
    for one, weight in zip(mean.tolist(), count.tolist(), strict=True):
        pool = one, weight
        while pools and pools[-1][0] < pool[0]:
            before = pools.pop()
            waves = before[1] + pool[1]
            pool = (before[0] * before[1] + pool[0] * pool[1]) / waves, waves
        pools.append(pool)
    least = COLOURED_SINGULAR * float(mean.max())
    return [(max(level, least), waves) for level, waves in pools]


def _unlikely(mean: Array, S: Array, count: Array) -> Array:
    """Minus twice the logarithm of Whittle's likelihood of spectra ``S``, (spectra, octaves)."""
    likely = np.maximum(S, COLOURED_SINGULAR * mean.max())
    return np.where((S > 0).all(axis=1), np.sum(count * (np.log(likely) + mean / likely), axis=1), np.inf)

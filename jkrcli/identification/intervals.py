"""Errors and intervals of whatever the unknowns of a search mean: by their covariance, by profiles, by samples, and by
inputs that are uncertain themselves.

Each quantity has a scale on which it is regular (``Parameter.kind``), and intervals are made there.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Literal, get_args

import numpy as np

from ..base import NOTICEABLE, SAME, TINY, TOGETHER, Array, InputError, JkrError, Pool, in_order
from .answer import FittedValue
from .fit.statistics import covariance, t_quantile
from .least_squares import Least, State
from .parameters import ALIAS, LIMITED, LOG, ONE_SIDED, Parameter, Unknowns


@dataclass(frozen=True)
class IntervalTuning:
    """How intervals are computed."""

    step: float = 1e-6  # theory: of unknowns, for central differences: of smooth meanings round-off leaves 1e-10
    exact: float = 1e-24  # theory: variance of residuals over their standard deviations that round-off leaves
    begin: float = 0.1  # choice: of a log, where a profile begins while no error is known


TUNING = IntervalTuning()
Followed = Literal["covariance", "profile"]  # how intervals are computed where records are not drawn again
Meaning = Callable[[Array], Mapping[str, float]]  # of the unknowns: quantities by name, on their scales


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

        variance = max(least.variance, TUNING.exact) if variance is None else variance
        own, t = covariance(least.state.jacobian, variance), t_quantile(level, least.dof)
        return cls(least, (*unknowns.parameters, *follow), meaning, own, t, level, confidence == "profile")

    @cached_property
    def here(self) -> Mapping[str, float]:
        """All quantities on their scales."""
        return self.meaning(self.least.x)

    @cached_property
    def rates(self) -> dict[str, Array]:
        """Their derivatives by the unknowns."""
        return self._rates(self.least.x)

    def _rates(self, x: Array) -> dict[str, Array]:
        sigma = np.ones(x.size) if self.covariance is None else np.sqrt(np.diag(self.covariance))
        steps = TUNING.step * np.maximum(np.abs(x), np.minimum(sigma, 1.0))
        ends = [(self.meaning(x + step), self.meaning(x - step), 2 * float(step.sum())) for step in np.diag(steps)]
        return {name: np.array([(high[name] - low[name]) / width for high, low, width in ends]) for name in self.here}

    @cached_property
    def drawn(self) -> list[Mapping[str, float]]:
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
        matrix: Array = by @ self.covariance @ by.T
        return matrix

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
        estimate = item.estimate(y, self._sigma(item), self.t)
        if self.drawn:
            return self._of_samples(item, estimate)
        if not self.profiled:
            return self._with_limit(estimate, item) if item.kind == "root" and estimate.low == 0 else estimate
        return self._shared(item, estimate, before) if item.follows else self._with_profile(item, estimate)

    def _sigma(self, item: Parameter) -> float | None:
        """The standard error on the scale."""
        rate = self.rates[item.name]
        return None if self.covariance is None else math.sqrt(max(float(rate @ self.covariance @ rate), 0.0))

    def _of_samples(self, item: Parameter, estimate: FittedValue) -> FittedValue:
        """The estimate with the scatter of the samples, and the interval of so many of them."""
        values = np.array([item.outer(sample[item.name]) for sample in self.drawn])
        low, high = map(float, np.quantile(values, [(1 - self.level) / 2, (1 + self.level) / 2]))
        if item.kind in LIMITED and low <= 0:
            low, high = 0.0, float(np.quantile(values, self.level))
        return replace(estimate, error=float(np.std(values, ddof=1)), low=low, high=high)

    def _with_limit(self, estimate: FittedValue, item: Parameter) -> FittedValue:
        """The estimate of a signed root that may be 0, as far as its profile goes: curves bend in it."""
        high = max(self.end(item, ONE_SIDED * self.t) or 0.0, estimate.high or 0.0)
        return replace(estimate, error=high / (2 * self.t), high=high)

    def _with_profile(self, item: Parameter, estimate: FittedValue) -> FittedValue:
        low, high = self.end(item, -self.t), self.end(item, self.t)
        if item.kind in LIMITED and (low is None or low <= 0):
            low, high = 0.0, self.end(item, ONE_SIDED * self.t)
        return replace(estimate, low=low, high=high)

    def _shared(self, item: Parameter, estimate: FittedValue, before: Sequence[FittedValue]) -> FittedValue:
        """The estimate of the log of a quantity with the profile of one that it follows from alone."""
        rate = self.rates[item.name]
        for one, other in zip(self.quantities, before, strict=False):
            by = self.rates[one.name]
            power = float(rate @ by) / max(float(by @ by), TINY)
            if one.kind == "log" and np.linalg.norm(rate - power * by) <= SAME * np.linalg.norm(rate):
                ends = [None if end is None else estimate.value * (end / other.value) ** power
                        for end in (other.low, other.high)]  # fmt: skip
                return replace(estimate, low=ends[0 if power > 0 else 1], high=ends[1 if power > 0 else 0])
        return estimate

    def end(self, item: Parameter, width: float) -> float | None:
        """The value at which the least cost with the quantity held is as much higher as ``width`` standard errors make
        it where the model is linear; None: it never is."""
        rate, sigma = self.rates[item.name], self._sigma(item)
        step = math.copysign(TUNING.begin, width) if sigma is None else width * sigma
        if item.kind == "log":  # of a vague one more would overflow
            step = max(min(step, 1.0), -1.0)
        variance = self.variance
        if variance is None:
            J = self.least.state.jacobian
            variance = (sigma or 0.0) ** 2 / float(np.sum(np.linalg.lstsq(J.T, rate, rcond=None)[0] ** 2))

        def outcome(x: Array) -> tuple[float, Array]:
            return self.meaning(x)[item.name], self._rates(x)[item.name]

        y = self.least.profile(outcome, step, 0.5 * width**2 * variance)
        if y is None or self._ends_on_bound(item, y, width > 0):
            return None
        return 0.0 if item.kind == "positive" and y < SAME * (sigma or 0.0) else item.outer(y)

    def _ends_on_bound(self, item: Parameter, y: float, above: bool) -> bool:
        """Whether a log ends where the search may not go, which is no end of what the data leave, but for that which
        the user gave."""
        i, rate = int(np.argmax(self.rates[item.name])), self.rates[item.name]
        own = item.kind == "log" and abs(rate[i] - 1) < NOTICEABLE and np.count_nonzero(rate) == 1
        if not own or 0 < (item.high if above else item.low) < math.inf:
            return False
        return abs(y - self.least.problem.bounds[1 if above else 0][i]) < NOTICEABLE


# ---------------------------------------------------------------------- samples
def bootstrap(
    least: Least, change: Callable[[np.random.Generator], Callable[[State], State]], cost: float, count: int, seed: int,
    pool: Pool | None,
) -> Array:  # fmt: skip
    """Unknowns of the least of ``count`` problems, each with its states changed at random, to ``cost`` relatively, from
    a first step by Gauss and Newton; fewer where no search reaches it (samples, unknowns)."""
    samples = in_order(pool, partial(_sample, least, change, cost, seed), range(count), "bootstrap", TOGETHER)
    return np.array([x for x in samples if x is not None])


def _sample(
    least: Least, change: Callable[[np.random.Generator], Callable[[State], State]], cost: float, seed: int, number: int
) -> Array | None:
    changed, model = change(np.random.default_rng([seed, number])), least.problem.model
    here = changed(least.state)
    near = least.x - np.linalg.lstsq(here.jacobian, here.residuals, rcond=None)[0]
    with contextlib.suppress(JkrError):
        return replace(least.problem, model=lambda x: changed(model(x)), converged=cost, cost=cost).least(near).x
    return None


# ---------------------------------------------------------------------- uncertain inputs, to first order
def changes_by(
    name: str, centre: float, sigma: float, here: Mapping[str, float], outcome: Callable[[float], Mapping[str, float]]
) -> dict[str, float]:
    """Change of everything in ``outcome`` by a change of the input ``name`` by ``sigma`` from its value ``centre``,
    where it is ``here``.

    The input is moved to both sides, where that is possible, the body solved anew and the data fitted again; InputError
    where it is uncertain by all of its value or more, but for Poisson's ratios.
    """
    if sigma >= centre and not name.startswith("nu"):
        raise InputError(f"the uncertainty of {name} is {sigma / centre:.3g} times its value: give less than the value")
    ends = [(centre, here)]
    for value in (centre - sigma, centre + sigma):
        with contextlib.suppress(InputError):  # beyond what the quantity can be, as nu > 1/2
            ends.append((value, outcome(value)))
    if len(ends) == 1:
        raise InputError(f"{name} cannot be {sigma:g} off its value {centre:g} to either side")
    (one, low), (two, high) = ends[-2:]
    return {key: (high[key] - low[key]) / (two - one) * sigma for key in here}


def wider(item: FittedValue, systematic: Mapping[str, float], t: float) -> FittedValue:
    """The estimate with its ``systematic`` errors by name added in quadrature."""
    total = math.hypot(*systematic.values())
    if total == 0:
        return item
    error = None if item.error is None else math.hypot(item.error, total)
    low = None if item.low is None else item.value - math.hypot(item.value - item.low, t * total)
    high = None if item.high is None else item.value + math.hypot(item.high - item.value, t * total)
    if low is not None and item.dimension in ("modulus", "work"):
        low = max(low, 0.0)
    return replace(item, error=error, low=low, high=high, systematic={k: abs(v) for k, v in systematic.items()})

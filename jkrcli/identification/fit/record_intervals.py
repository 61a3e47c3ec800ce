"""Intervals of a raw record beyond its covariance: the profiles of what its unknowns mean, and samples, records that
the fitted model and the noise of the free rows might have made."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...base import Array, Pool, in_order
from ..answer import ONE_SIDED, FittedValue
from .force_curve import ForceCurveFit
from .settings import Settings


@dataclass(frozen=True)
class RecordIntervalTuning:
    """How intervals are found."""

    step: float = 1e-6  # choice: of unknowns, for central differences; outcomes are smooth in them
    samples: int = 20  # choice: of a bootstrap, in one task


TUNING = RecordIntervalTuning()
Meaning = Callable[[Array], Mapping[str, float]]  # of the unknowns: values by name, SI


def rates(found: ForceCurveFit, x: Array, meaning: Meaning) -> dict[str, Array]:
    """Derivatives of what the unknowns ``x`` of a fit mean, by central differences."""
    sizes = np.maximum(np.abs(x), np.sqrt(np.diag(found.covariance)))
    curved = [name.startswith(("ln_", "q:", "r:")) for name in found.names]  # all others are linear in the outcome
    steps = TUNING.step * np.where(curved, np.abs(x), sizes)
    ends = [(meaning(x + step), meaning(x - step), 2 * float(step.sum())) for step in np.diag(steps)]
    return {name: np.array([(high[name] - low[name]) / width for high, low, width in ends]) for name in ends[0][0]}


def profiles(items: Sequence[FittedValue], found: ForceCurveFit, meaning: Meaning, t: float) -> list[FittedValue]:
    """The estimates with the ends of their profiles; moduli of layers share that of their factor."""
    ends = [item if item.dimension == "modulus" else _profiled(item, found, meaning, t) for item in items]
    factor = next(item for item in ends if item.name == "modulus")
    return [_scaled(item, factor) if item.dimension == "modulus" else item for item in ends]


def _scaled(item: FittedValue, factor: FittedValue) -> FittedValue:
    low, high = (None if end is None else end * item.value / factor.value for end in (factor.low, factor.high))
    return replace(item, low=low, high=high)


def _profiled(item: FittedValue, found: ForceCurveFit, meaning: Meaning, t: float) -> FittedValue:
    """The estimate with the ends of its profile, ``t`` standard errors away where the model is linear; of w not below
    0, an upper limit where 0 is not excluded."""
    if item.error is None:
        return item
    log = item.name == "modulus"  # a factor; position errors, numbers too, go through 0

    def outcome(x: Array) -> tuple[float, Array]:
        value, rate = meaning(x)[item.name], rates(found, x, meaning)[item.name]
        return (math.log(value), rate / value) if log else (value, rate)

    least = found.least
    by, J = outcome(least.x)[1], least.state.jacobian
    plain = float(np.sum(np.linalg.lstsq(J.T, by, rcond=None)[0] ** 2))
    error = math.sqrt(float(by @ found.covariance @ by))

    def end(step: float) -> float | None:
        at = least.profile(outcome, step, 0.5 * (step * step) / plain)
        return math.exp(at) if log and at is not None else at

    low, high = end(-t * error), end(t * error)
    if item.dimension == "work" and (low is None or low <= 0):
        return replace(item, low=0.0, high=end(ONE_SIDED * t * error))
    return replace(item, low=low, high=high)


def samples(found: ForceCurveFit, settings: Settings, pool: Pool | None) -> Array:
    """Unknowns of fits to records that the model and the noise may have made (samples, unknowns)."""
    drawn = partial(_sample, found, settings.seed)
    outcomes = in_order(pool, drawn, range(settings.samples), "bootstrap", TUNING.samples)
    return np.array([x for x in outcomes if x is not None])


def _sample(found: ForceCurveFit, seed: int, number: int) -> Array | None:
    """The unknowns of the sample of that ``number``: residuals as they are, with other noise."""
    rows, least = found.model.rows - found.model.rows.min(), found.least
    noise = found.spread.noise.drawn(np.random.default_rng([seed, number]), int(rows.max()) + 1)[rows]
    other = found.model.whitened(noise, found.weight) - least.state.residuals
    return least.sample(lambda state: state.moved(other), least.problem.converged)


def of_samples(item: FittedValue, values: Array, level: float) -> FittedValue:
    """The estimate with the scatter of its sampled ``values``, and the interval of so many of them."""
    if item.error is None:
        return item
    low, high = map(float, np.quantile(values, [(1 - level) / 2, (1 + level) / 2]))
    if item.dimension == "work" and low <= 0:
        low, high = 0.0, float(np.quantile(values, level))
    return replace(item, error=float(np.std(values, ddof=1)), low=low, high=high)

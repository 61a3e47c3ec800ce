"""Confidence of a fit to prepared readings: intervals as the settings want them, the systematic part, and how much
worse JKR describes the same rows beside adhesion of finite range."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...base import Array, JkrError, Pool, Unknown
from ...bodies import changed
from ..answer import FittedValue
from ..intervals import Intervals, bootstrap, changes_by, wider
from ..least_squares import State
from ..parameters import LOG, Parameter, dimension_of
from .body import FittedBody
from .model import Objective
from .points import Points
from .result import JKRBeside
from .search import TUNING as SEARCH
from .search import Minimum, minimise, robust, search
from .settings import RANGES, Settings
from .statistics import covariance, covariance_of_uneven, larger, t_quantile, variance_factor


@dataclass(frozen=True)
class ConfidenceTuning:
    """How intervals are computed."""

    few: int = 10  # choice: degrees of freedom, below which residuals do not show the noise's change along the curve


TUNING = ConfidenceTuning()


@dataclass(frozen=True, eq=False)
class Confidence:
    """What is known of a fit: ``estimates`` with their intervals, ``covariance`` of the free parameters, SI,
    ``samples`` of a bootstrap, ``scatter``: standard deviation of the residuals, ``dof``: degrees of freedom."""

    estimates: tuple[FittedValue, ...]
    covariance: Array | None
    samples: Array | None
    scatter: float
    dof: int


def confidence_of(
    minimum: Minimum, settings: Settings, jkr: JKRBeside | Unknown | None = None, pool: Pool | None = None
) -> Confidence:
    """All parameters and what follows from them, with intervals as ``settings`` want them; ``jkr``: beside a range;
    ``pool``: for the samples of a bootstrap.

    A range that JKR does without is known on one side only, by its profile; nothing where the search did not end.
    """
    if not minimum.least.ended:
        settings = replace(settings, confidence="covariance", uncertain={})
    objective, (inner, factor, dof) = minimum.objective, spread_of(minimum, settings)
    t, samples = t_quantile(settings.level, dof), None
    if settings.confidence == "bootstrap":
        change = partial(_redrawn, minimum.distances.residuals.shape)
        samples = bootstrap(minimum.least, change, SEARCH.converged_rough, settings.samples, settings.seed, pool)
    intervals = Intervals(
        minimum.least, _quantities(minimum), partial(_meaning, minimum), inner, t, settings.level,
        settings.confidence == "profile", factor, samples,
    )  # fmt: skip
    estimates = intervals.estimates()
    if isinstance(jkr, JKRBeside) and jkr.excess < 0.5 * t**2 * factor:
        here = objective.values(minimum.x)
        estimates = tuple(_and_none(_one_sided(item, intervals), jkr.values, here) for item in estimates)
    changes = {name: _changes(minimum, settings, name, sigma) for name, sigma in settings.uncertain.items()}
    estimates = tuple(wider(item, {name: by[item.name] for name, by in changes.items()}, t) for item in estimates)
    free = objective.unknowns.names
    return Confidence(estimates, intervals.covariance_of(free), intervals.sampled(free), math.sqrt(factor), dof)


def _quantities(minimum: Minimum) -> list[Parameter]:
    """The parameters, and what follows from them."""
    follow = _follows(minimum.objective, minimum.x)
    dimensions = {name: dimension_of(name) if name in RANGES else "modulus" for name in follow}
    following = (Parameter(name, True, scale=LOG, quantity=kind, follows=True) for name, kind in dimensions.items())
    return [*minimum.objective.parameters, *following]


def _meaning(minimum: Minimum, y: Array) -> dict[str, float]:
    """What the unknowns of the search mean, on the scales of the quantities."""
    objective, x = minimum.objective, minimum.objective.at(minimum.x, y)
    own = {p.name: float(v) for p, v in zip(objective.parameters, x, strict=True)}
    return own | {name: math.log(value) if value > 0 else -math.inf for name, value in _follows(objective, x).items()}


def _one_sided(item: FittedValue, intervals: Intervals) -> FittedValue:
    """A range that is not significantly above 0, by the largest that it may have, or a tension by the least."""
    if item.name not in RANGES or not item.free:
        return item
    quantity = next(one for one in intervals.quantities if one.name == item.name)
    if quantity.follows:
        return replace(item, error=None, low=None, high=None)
    end = intervals.end(quantity, intervals.t if item.name == "range" else -intervals.t)
    low, high = (0.0, end) if item.name == "range" else (end, None)
    return replace(item, error=None, low=low, high=high)


def _and_none(item: FittedValue, jkr: Mapping[str, float], here: Mapping[str, float]) -> FittedValue:
    """The estimate where a range is not significant: its interval holds that of JKR as well."""
    name = "modulus" if item.dimension == "modulus" and item.name not in jkr else item.name
    if item.name in RANGES or name not in jkr or item.error is None or item.low is None or item.high is None:
        return item
    shift = jkr[name] - here[name] if name == item.name else item.value * (jkr[name] / here[name] - 1)
    low, high = min(item.low, item.low + shift), max(item.high, item.high + shift)
    low = max(low, 0.0) if item.dimension == "work" else low
    return replace(item, error=math.hypot(item.error, shift), low=low, high=high)


def spread_of(minimum: Minimum, settings: Settings) -> tuple[Array | None, float, int]:
    """The covariance of the unknowns of the search, the variance of the residuals, and their degrees of freedom."""
    residuals, jacobian, free = minimum.distances.residuals, minimum.least.state.jacobian, minimum.least.x
    measured = set(minimum.objective.points.columns)
    columns = len(measured)
    dof = max(residuals.shape[1] * (columns - 1) - free.size, 1)  # a foot point takes one number from every point
    factor = variance_factor(residuals, dof, settings.loss, minimum.width)
    inner = covariance(jacobian, factor) if minimum.least.ended else None
    even = measured <= settings.noise.keys()  # else that is more than a record of a sensor shows
    if settings.loss == "linear" and dof >= TUNING.few and not even:
        inner = larger(inner, covariance_of_uneven(jacobian, residuals))
    return inner, factor, dof


def _follows(objective: Objective, x: Array) -> dict[str, float]:
    """E* [Pa] and the moduli E of all layers [Pa] that are no parameters themselves, and tension [Pa] or range [m]."""
    values = objective.values(x)
    problem = changed(objective.body.problem, {name: value for name, value in values.items() if ":" in name})
    following = replace(objective.body, problem=problem).moduli(values.get("modulus", 1.0))
    if objective.ranged:
        following |= {"stress": values["w"] / values["range"]} if "range" in values else {}
        following |= {"range": values["w"] / values["stress"]} if "stress" in values else {}
    return {name: value for name, value in following.items() if name not in values}


def _redrawn(shape: tuple[int, int], rng: np.random.Generator) -> Callable[[State], State]:
    """Residuals of this ``shape`` (columns, rows) at rows drawn with replacement."""
    rows = rng.integers(0, shape[1], shape[1])
    every = (np.arange(shape[0])[:, None] * shape[1] + rows).ravel()
    return lambda state: state.rows(every)


# ---------------------------------------------------------------------- beside a range
def jkr_beside(minimum: Minimum, body: FittedBody, points: Points, settings: Settings) -> JKRBeside | Unknown:
    """The nearest curve of JKR to the rows of ``minimum``, in its scales; Unknown where none comes near."""
    plain = settings.without(RANGES)
    try:
        near = search(body, points, plain)
        objective = replace(near.objective, scales=minimum.objective.scales)
        jkr = robust(minimise(objective, near.x), settings.loss)
        jkr = minimise(objective, jkr.x, settings.loss, minimum.width)  # the same turn of a robust loss
    except JkrError as error:
        return Unknown(str(error))
    if not jkr.least.ended:
        return Unknown(f"the fit did not converge in {SEARCH.evaluations} steps")
    values = objective.values(jkr.x)
    rms, with_range = (math.sqrt(float(np.mean(item.distances.residuals**2))) for item in (jkr, minimum))
    E_star = values["modulus"] * body.problem.E_star
    return JKRBeside(E_star, values["w"], rms, with_range, jkr.cost - minimum.cost, values)


# ---------------------------------------------------------------------- uncertain inputs of the body, to first order
def _changes(minimum: Minimum, settings: Settings, name: str, sigma: float) -> dict[str, float]:
    """Change of every estimate by a change of the input ``name`` by its standard deviation ``sigma``."""
    objective = minimum.objective

    def outcome(value: float) -> dict[str, float]:
        moved = replace(objective, body=objective.body.with_values({name: value}))
        again = minimise(moved, minimum.x, settings.loss, minimum.width)
        return again.objective.values(again.x) | _follows(again.objective, again.x)

    here = objective.values(minimum.x) | _follows(objective, minimum.x)
    return changes_by(name, objective.body.nominal(name), sigma, here, outcome)

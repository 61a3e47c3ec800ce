"""Confidence of what was fitted: covariance, profile likelihood, bootstrap, uncertain inputs of the body."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...base import Array, InputError, Pool, Unknown, in_order
from ...bodies import changed
from ..answer import FittedValue
from ..least_squares import Least
from ..parameters import Parameter, dimension_of
from .model import Objective
from .result import JKRBeside
from .search import Minimum, minimise
from .settings import RANGES, Settings
from .statistics import covariance, covariance_of_uneven, larger, t_quantile, variance_factor


@dataclass(frozen=True)
class ConfidenceTuning:
    """How intervals are found."""

    few: int = 10  # choice: degrees of freedom, below which residuals do not tell how the noise changes along the curve
    widest: float = 100.0  # choice: half-width of a log, from which on nothing is told of a value (its ends overflow)
    step: float = 1e-5  # theory: of the unknowns, for central differences: about the cube root of round-off
    guard: float = 1e-3  # choice: of a log, how near to where the search may not go it is held there
    samples: int = 50  # choice: of a bootstrap, in one task
    enough: float = 1e-7  # choice: change of a sample's unknowns that is none: some ten thousandths of their scatter


TUNING = ConfidenceTuning()
Interval = tuple[float | None, float | None]


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
    """All parameters and what follows from them, with intervals as ``settings`` ask for them; ``jkr``: beside a range;
    ``pool``: for the samples of a bootstrap.

    A range that JKR does without is known on one side only, by its profile; nothing where the search was given up.
    """
    if not minimum.least.ended:
        settings = replace(settings, confidence="covariance", uncertain={})
    objective, (inner, factor, dof) = minimum.objective, spread_of(minimum, settings)
    samples = _bootstrap(minimum, settings, pool) if settings.confidence == "bootstrap" else None
    t = t_quantile(settings.level, dof)
    untold = isinstance(jkr, JKRBeside) and jkr.excess < 0.5 * t**2 * factor
    spread = _Spread(minimum, settings, inner, samples, t, factor, untold)
    estimates = (*(spread.parameter(i) for i in range(len(objective.parameters))), *spread.derived())
    if untold and isinstance(jkr, JKRBeside):
        here = objective.values(minimum.x)
        estimates = tuple(_and_none(item, jkr.values, here) for item in estimates)
    if settings.uncertain:
        changes = {name: _changes(minimum, settings, name, sigma) for name, sigma in settings.uncertain.items()}
        estimates = tuple(
            wider(item, {name: change[item.name] for name, change in changes.items()}, t) for item in estimates
        )
    return Confidence(estimates, spread.outer_covariance(), spread.outer_samples(), math.sqrt(factor), dof)


def _and_none(item: FittedValue, jkr: Mapping[str, float], here: Mapping[str, float]) -> FittedValue:
    """The estimate where the data do not tell a range from none: its interval holds that of JKR as well."""
    name = "modulus" if item.dimension == "modulus" and item.name not in jkr else item.name
    if item.name in RANGES or name not in jkr or item.error is None or item.low is None or item.high is None:
        return item
    shift = jkr[name] - here[name] if name == item.name else item.value * (jkr[name] / here[name] - 1)
    low, high = min(item.low, item.low + shift), max(item.high, item.high + shift)
    low = max(low, 0.0) if item.dimension == "work" else low
    return replace(item, error=math.hypot(item.error, shift), low=low, high=high)


def spread_of(minimum: Minimum, settings: Settings) -> tuple[Array | None, float, int]:
    """The covariance of the free unknowns, the variance of the residuals, and their degrees of freedom."""
    objective, free = minimum.objective, minimum.objective.free
    residuals = minimum.found.residuals
    columns = len(objective.points.columns)
    dof = max(residuals.shape[1] * (columns - 1) - free.size, 1)  # a foot point takes one number from every point
    factor = variance_factor(residuals, dof, settings.loss, minimum.width)
    jacobian = minimum.found.jacobian(free)
    inner = covariance(jacobian, factor) if minimum.least.ended else None
    even = set(objective.points.columns) <= settings.noise.keys()  # else that is more than a record of a sensor tells
    if settings.loss == "linear" and dof >= TUNING.few and not even:
        inner = larger(inner, covariance_of_uneven(jacobian, residuals))
    return inner, factor, dof


@dataclass(frozen=True, eq=False)
class _Spread:
    """Uncertainty of the optimiser's unknowns: covariance ``inner`` and bootstrap ``samples`` of the free ones."""

    minimum: Minimum
    settings: Settings
    inner: Array | None
    samples: Array | None
    t: float
    factor: float
    untold: bool

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return self.minimum.objective.parameters

    def outer_covariance(self) -> Array | None:
        if self.inner is None:
            return None
        free = self.minimum.objective.free
        by = np.array([self.parameters[i].derivative(float(self.minimum.x[i])) for i in free])
        return self.inner * np.outer(by, by) if (by != 0).all() else None

    def outer_samples(self) -> Array | None:
        if self.samples is None:
            return None
        free = [self.parameters[i] for i in self.minimum.objective.free]
        return np.array([[p.outer(v) for p, v in zip(free, row, strict=True)] for row in self.samples])

    def parameter(self, i: int) -> FittedValue:
        """The estimate of parameter ``i``: intervals are made in its unknown and carried over."""
        p, x = self.parameters[i], float(self.minimum.x[i])
        if not p.free:
            return FittedValue(p.name, p.outer(x), False, p.dimension)
        if p.name in RANGES and self.untold:
            return self._one_sided(i)
        sigma = self._sigma(i)
        error = None if sigma is None else p.derivative(x) * sigma
        low, high = (None if end is None else p.outer(end) for end in self._interval(i))
        return FittedValue(p.name, p.outer(x), True, p.dimension, error, low, high)

    def _one_sided(self, i: int) -> FittedValue:
        """A range that is not told from 0, by the largest that it may have, or a tension by the least."""
        p, x = self.parameters[i], float(self.minimum.x[i])
        inner = self._profile(i, 1 if p.name == "range" else -1)
        end = None if inner is None else p.outer(inner)
        low, high = (0.0, end) if p.name == "range" else (end, None)
        return FittedValue(p.name, p.outer(x), True, p.dimension, None, low, high)

    def _position(self, i: int) -> int:
        return int(np.flatnonzero(self.minimum.objective.free == i)[0])

    def _sigma(self, i: int) -> float | None:
        position = self._position(i)
        if self.samples is not None:
            return float(np.std(self.samples[:, position], ddof=1))
        return None if self.inner is None else float(np.sqrt(self.inner[position, position]))

    def _interval(self, i: int) -> Interval:
        x, sigma = float(self.minimum.x[i]), self._sigma(i)
        if self.samples is not None:
            tails = [(1 - self.settings.level) / 2, (1 + self.settings.level) / 2]
            low, high = np.quantile(self.samples[:, self._position(i)], tails)
            return float(low), float(high)
        if self.settings.confidence == "profile":
            return self._profile(i, -1), self._profile(i, 1)
        if sigma is None or (self.parameters[i].kind == "log" and self.t * sigma > TUNING.widest):
            return None, None
        return x - self.t * sigma, x + self.t * sigma

    def _profile(self, i: int, side: int) -> float | None:
        """The end of the interval, where the least cost with parameter ``i`` held is t^2/2 times the variance higher;
        None: it never is."""
        position, sigma, kind = self._position(i), self._sigma(i), self.parameters[i].kind
        unit = self.minimum.units * (np.arange(self.minimum.units.size) == position)
        step = self.t * sigma if sigma is not None else 0.1
        step = side * min(step, 1.0 if kind == "log" else math.inf)  # of a vague one: more would overflow
        least = self.minimum.least
        end = least.profile(lambda y: (float(unit @ y), unit), step, 0.5 * self.t**2 * self.factor)
        low, high = (float(unit @ np.nan_to_num(bound)) for bound in least.problem.bounds)
        if end is None or kind == "linear":
            return end
        if kind == "positive":
            return 0.0 if end <= 2 * low else end
        given = self.parameters[i].low if side < 0 else self.parameters[i].high
        guard = not 0 < given < math.inf  # of the search, which is no end of what the data leave
        return None if guard and abs(end - (low if side < 0 else high)) < TUNING.guard else end

    def derived(self) -> list[FittedValue]:
        """E* of the materials that touch and the moduli of the layers, where they follow from free parameters."""
        found = []
        gradients = self._log_gradients()
        for name, value in _follows(self.minimum.objective, self.minimum.x).items():
            parents = np.flatnonzero(gradients[name])
            told = parents.size and not (name in RANGES and self.untold)
            error, low, high = self._of_log(value, gradients[name], parents) if told else (None, None, None)
            dimension = dimension_of(name) if name in RANGES else "modulus"
            found.append(FittedValue(name, value, parents.size > 0, dimension, error, low, high))
        return found

    def _log_gradients(self) -> dict[str, Array]:
        """d(log value)/dx by all unknowns of what follows from the parameters; only moduli, layers, w and its range
        enter."""
        objective, x = self.minimum.objective, self.minimum.x
        found = {name: np.zeros(x.size) for name in _follows(objective, x)}
        for i in objective.free:
            if self.parameters[i].kind == "linear":
                continue
            size = 1.0 if self.parameters[i].kind == "log" else float(x[i])
            unit = TUNING.step * size * (np.arange(x.size) == i)
            low, high = _follows(objective, x - unit), _follows(objective, x + unit)
            for name, gradient in found.items():
                rate = (math.log(high[name]) - math.log(low[name])) / (2 * TUNING.step)
                gradient[i] = rate / size if abs(rate) >= TUNING.step else 0.0
        return found

    def _of_log(self, value: float, gradient: Array, parents: Array) -> tuple[float | None, float | None, float | None]:
        """Standard error and interval of a ``value`` by the ``gradient`` of its log."""
        free = self.minimum.objective.free
        if parents.size == 1:
            i = int(parents[0])
            sigma, by = self._sigma(i), float(gradient[i])
            low, high = (
                None if end is None else value * math.exp(by * (end - self.minimum.x[i])) for end in self._interval(i)
            )
            return None if sigma is None else value * abs(by) * sigma, low, high
        matrix = np.cov(self.samples.T) if self.samples is not None else self.inner
        if matrix is None:
            return None, None, None
        sigma = float(np.sqrt(gradient[free] @ np.atleast_2d(matrix) @ gradient[free]))
        if self.t * sigma > TUNING.widest:
            return value * sigma, None, None
        return value * sigma, value * math.exp(-self.t * sigma), value * math.exp(self.t * sigma)


def _follows(objective: Objective, x: Array) -> dict[str, float]:
    """E* [Pa] and the moduli E of all layers [Pa] that are no parameters themselves, and tension [Pa] or range [m]."""
    values, body = objective.values(x), objective.body
    problem = changed(body.problem, {name: value for name, value in values.items() if ":" in name})
    s = values.get("modulus", 1.0)
    found = {"E_star": s * problem.E_star}
    if problem.indenter.material is None:  # else its own modulus is scaled too, and none of the layers' follows
        materials = problem.specimen.materials
        found |= {f"E:{name}": s * m.surface.E for name, m in zip(body.layer_names, materials, strict=True)}
    if objective.ranged:
        found |= {"stress": values["w"] / values["range"]} if "range" in values else {}
        found |= {"range": values["w"] / values["stress"]} if "stress" in values else {}
    return {name: value for name, value in found.items() if name not in values}


def _bootstrap(minimum: Minimum, settings: Settings, pool: Pool | None) -> Array:
    """Free unknowns of fits to rows drawn with replacement, shape (samples, free)."""
    drawn = partial(_resampled, minimum.least, minimum.found.residuals.shape, settings.seed)
    found = in_order(pool, drawn, range(settings.samples), "bootstrap", TUNING.samples)
    return np.array([y * minimum.units for y in found if y is not None])


def _resampled(least: Least, shape: tuple[int, int], seed: int, number: int) -> Array | None:
    """The unknowns of the sample of that ``number``, of residuals of this ``shape`` (columns, rows)."""
    rows = np.random.default_rng([seed, number]).integers(0, shape[1], shape[1])
    every = (np.arange(shape[0])[:, None] * shape[1] + rows).ravel()
    return least.sample(lambda state: state.rows(every), TUNING.enough)


# ---------------------------------------------------------------------- uncertain inputs of the body, to first order
def _changes(minimum: Minimum, settings: Settings, name: str, sigma: float) -> dict[str, float]:
    """Change of every estimate by a change of the input ``name`` by its standard deviation ``sigma``."""
    objective = minimum.objective

    def outcome(value: float) -> dict[str, float]:
        moved = replace(objective, body=objective.body.with_values({name: value}))
        found = minimise(moved, minimum.x, settings.loss, minimum.width)
        return found.objective.values(found.x) | _follows(found.objective, found.x)

    here = objective.values(minimum.x) | _follows(objective, minimum.x)
    return changes_by(name, objective.body.nominal(name), sigma, here, outcome)


def changes_by(
    name: str, centre: float, sigma: float, here: Mapping[str, float], outcome: Callable[[float], Mapping[str, float]]
) -> dict[str, float]:
    """Change of everything in ``outcome`` by a change of the input ``name`` by ``sigma`` from its value ``centre``,
    where it is ``here``.

    The input is moved to both sides, where that is possible, the body solved anew and the data fitted again.
    """
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

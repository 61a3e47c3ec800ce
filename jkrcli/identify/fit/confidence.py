"""Confidence of the fitted parameters: covariance, profile likelihood, bootstrap."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from ...base.errors import JkrError
from ...series import Array
from .body import Body, changed
from .parameters import Parameter
from .result import Estimate
from .settings import Settings
from .solve import Minimum, Objective, fixed_at, minimise
from .statistics import covariance, t_quantile, variance_factor

WIDENED = 6  # doublings of the step in which a profile must reach its limit
GRADIENT = 1e-5  # of the unknowns, for what follows from them

Interval = tuple[float | None, float | None]


@dataclass(frozen=True, eq=False)
class Confidence:
    """``estimates`` with their intervals; ``covariance`` of the free parameters, SI; ``samples`` of a bootstrap;
    ``scatter``: standard deviation of the residuals; ``dof``: degrees of freedom."""

    estimates: tuple[Estimate, ...]
    covariance: Array | None
    samples: Array | None
    scatter: float
    dof: int


def intervals(minimum: Minimum, settings: Settings) -> Confidence:
    """Estimates of all parameters and of what follows from them, with intervals as ``settings`` ask for them."""
    objective, free = minimum.objective, minimum.objective.free
    residuals = minimum.found.residuals
    columns = len(objective.points.columns)
    dof = max(residuals.shape[1] * (columns - 1) - free.size, 1)  # a foot point takes one number from every point
    factor = variance_factor(residuals, dof, settings.loss, minimum.width)
    inner = covariance(minimum.jacobian(), factor)
    samples = _bootstrap(minimum, settings) if settings.confidence == "bootstrap" else None
    t = t_quantile(settings.level, dof)
    told = _Told(minimum, settings, inner, samples, t, factor)
    estimates = (*(told.parameter(i) for i in range(len(objective.parameters))), *told.derived())
    return Confidence(estimates, told.outer_covariance(), told.outer_samples(), math.sqrt(factor), dof)


@dataclass(frozen=True, eq=False)
class _Told:
    """What is known after the fit, in the optimiser's unknowns."""

    minimum: Minimum
    settings: Settings
    inner: Array | None
    samples: Array | None
    t: float
    factor: float

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

    def parameter(self, i: int) -> Estimate:
        """The estimate of parameter ``i``: intervals are made in its unknown and carried over."""
        p, x = self.parameters[i], float(self.minimum.x[i])
        if not p.free:
            return Estimate(p.name, p.outer(x), False, p.dimension)
        low, high = self._interval(i)
        sigma = self._sigma(i)
        error = None if sigma is None else p.derivative(x) * sigma
        low, high = (None if end is None else p.outer(end) for end in (low, high))
        return Estimate(p.name, p.outer(x), True, p.dimension, error, low, high)

    def _sigma(self, i: int) -> float | None:
        position = int(np.flatnonzero(self.minimum.objective.free == i)[0])
        if self.samples is not None:
            return float(np.std(self.samples[:, position], ddof=1))
        return None if self.inner is None else float(np.sqrt(self.inner[position, position]))

    def _interval(self, i: int) -> Interval:
        x, sigma = float(self.minimum.x[i]), self._sigma(i)
        if self.samples is not None:
            column = self.samples[:, int(np.flatnonzero(self.minimum.objective.free == i)[0])]
            low, high = np.quantile(column, [(1 - self.settings.level) / 2, (1 + self.settings.level) / 2])
            return float(low), float(high)
        if self.settings.confidence == "profile":
            return self._profile(i, -1), self._profile(i, 1)
        return (None, None) if sigma is None else (x - self.t * sigma, x + self.t * sigma)

    def _profile(self, i: int, side: int) -> float | None:
        """Where the least cost with parameter ``i`` held rises by t^2/2 times the variance; None: it never does."""
        x, limit = float(self.minimum.x[i]), self.minimum.cost + 0.5 * self.t**2 * self.factor
        sigma = self._sigma(i)
        step = side * (self.t * sigma if sigma is not None else 0.1)
        p = self.parameters[i]
        objective = fixed_at(self.minimum.objective, p.name)
        start = self.minimum.x.copy()

        def excess(k: float) -> float:
            start[i] = x + k * step
            if objective.free.size == 0:
                return 0.5 * float(np.sum(objective.distances(start).residuals ** 2)) - limit
            return minimise(objective, start, self.settings.loss, self.minimum.width).cost - limit

        for k in 2.0 ** np.arange(WIDENED):
            if p.kind == "positive" and x + k * step < 0:
                k = -x / step
            try:
                if excess(k) >= 0:
                    return x + step * float(brentq(excess, 0.0 if k <= 1 else k / 2, k, xtol=1e-3, rtol=1e-3))
            except JkrError:
                return None
            if p.kind == "positive" and x + k * step <= 0:
                return 0.0
        return None

    def derived(self) -> list[Estimate]:
        """E* of the materials that touch and the moduli of the layers, where they follow from free parameters."""
        here = _follows(self.minimum, self.minimum.x)
        found = []
        for name, value in here.items():
            gradient = self._gradient(name)
            parents = np.flatnonzero(gradient)
            if parents.size == 0:
                found.append(Estimate(name, value, False, "modulus"))
                continue
            error, low, high = self._of_log(value, gradient, parents)
            found.append(Estimate(name, value, True, "modulus", error, low, high))
        return found

    def _gradient(self, name: str) -> Array:
        """d(log value)/dx by all unknowns; only moduli and layers enter."""
        found = np.zeros(self.minimum.x.size)
        for i in self.minimum.objective.free:
            if self.parameters[i].kind == "log":
                ends = []
                for sign in (-1, 1):
                    x = self.minimum.x.copy()
                    x[i] += sign * GRADIENT
                    ends.append(math.log(_follows(self.minimum, x)[name]))
                found[i] = (ends[1] - ends[0]) / (2 * GRADIENT)
        found[np.abs(found) < GRADIENT] = 0.0
        return found

    def _of_log(self, value: float, gradient: Array, parents: Array) -> tuple[float | None, float | None, float | None]:
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
        return value * sigma, value * math.exp(-self.t * sigma), value * math.exp(self.t * sigma)


def _follows(minimum: Minimum, x: Array) -> dict[str, float]:
    """E* [Pa] and the moduli E of all layers [Pa] that are no parameters themselves."""
    objective = minimum.objective
    values = {p.name: p.outer(float(v)) for p, v in zip(objective.parameters, x, strict=True)}
    body: Body = objective.body
    problem = changed(body, {name: value for name, value in values.items() if ":" in name})
    s = values.get("modulus", 1.0)
    found = {"E_star": s * problem.E_star}
    if problem.indenter.material is None:  # else its own modulus is scaled too, and none of the layers' follows
        materials = problem.specimen.materials
        found |= {f"E:{name}": s * m.surface.E for name, m in zip(body.layer_names, materials, strict=True)}
    return {name: value for name, value in found.items() if name not in values}


def values_at(minimum: Minimum, x: Array) -> dict[str, float]:
    """All parameters and what follows from them at the unknowns ``x``, SI."""
    pairs = zip(minimum.objective.parameters, x, strict=True)
    return {p.name: p.outer(float(v)) for p, v in pairs} | _follows(minimum, x)


def _bootstrap(minimum: Minimum, settings: Settings) -> Array:
    """Free unknowns of fits to rows drawn with replacement, shape (samples, free)."""
    random = np.random.default_rng(settings.seed)
    objective, free = minimum.objective, minimum.objective.free
    n = len(objective.points)
    found = []
    for _ in range(settings.samples):
        rows = random.integers(0, n, n)
        values = {name: column[rows] for name, column in objective.points.values.items()}
        drawn: Objective = replace(objective, points=replace(objective.points, values=values))
        try:
            found.append(minimise(drawn, minimum.x, settings.loss, minimum.width).x[free])
        except JkrError:
            continue
    return np.array(found)

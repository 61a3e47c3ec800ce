"""One least-squares fit: from points and starting values to the parameters that minimise the distances."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from ...base.errors import SolveError
from ...series import Array
from .body import Body
from .distances import Distances, distances
from .model import Readings, scaled
from .parameters import Parameter
from .points import Points
from .settings import Loss

CONVERGED = 1e-13  # relative change of parameters and cost
OF_LAYERS, ROBUST = 1e-9, 1e-7  # the same where layers vary and with a robust loss, where steps are less sure
EVALUATIONS = 200
REACH, BODY_REACH = 7.0, 9.0  # of logs
FAINT = 1e-8  # least w, in natural units: at 0 the shift by its root is along the curve and has no derivative by w


@dataclass(frozen=True, eq=False)
class Objective:
    """Scaled distances of ``points`` as a function of the free unknowns; the others keep their values."""

    body: Body
    parameters: tuple[Parameter, ...]
    points: Points
    scales: Array

    @property
    def free(self) -> Array:
        """Indices of the free parameters."""
        return np.flatnonzero([parameter.free for parameter in self.parameters])

    def readings(self, x: Array, rated: bool = True) -> Readings:
        """The readings for all unknowns ``x``; where layers vary the body is solved anew."""
        values = {p.name: p.outer(float(v)) for p, v in zip(self.parameters, x, strict=True) if p.of_body}
        free = [p.name for p in self.parameters if p.of_body and p.free]
        family = self.body.family
        if values:
            body = self.body.rated(values, free) if rated and free else self.body.with_values(values)
            family = body.family
        return Readings(family, self.parameters, x, self.points.columns, self.scales)

    def distances(self, x: Array, rated: bool = True) -> Distances:
        target = scaled(self.points.columns, dict(self.points.values), self.scales)
        return distances(self.readings(x, rated), target)


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where the sum of losses is least: ``x`` all unknowns, ``found`` the distances there, ``cost`` half that sum.

    ``at_bound``: names of parameters that end on a bound; ``width``: of the robust loss, in scaled units.
    """

    objective: Objective
    x: Array
    found: Distances
    cost: float
    at_bound: tuple[str, ...]
    evaluations: int
    width: float = 1.0

    def jacobian(self) -> Array:
        """Derivatives of the residuals by the free unknowns, shape (residuals, free)."""
        rows = self.found.jacobian()[self.objective.free]
        return rows.reshape(rows.shape[0], -1).T


def minimise(objective: Objective, start: Array, loss: Loss = "linear", width: float = 1.0) -> Minimum:
    """The least sum of squares (or of a robust ``loss`` that turns at ``width``) from the unknowns ``start``.

    SciPy's trust region (method "trf", bounds respected). SolveError where it does not converge.
    """
    free = objective.free
    begin = np.array(start, dtype=float)
    low, high = _bounds(objective, begin)
    begin[free] = np.clip(begin, low, high)[free]
    units = _units(objective)[free]
    remembered: list[tuple[Array, Distances]] = []

    def at(y: Array) -> Distances:
        if not (remembered and np.array_equal(remembered[0][0], y)):
            x = begin.copy()
            x[free] = y * units
            remembered[:] = [(y.copy(), objective.distances(x))]
        return remembered[0][1]

    def residuals(y: Array) -> Array:
        return at(y).residuals.ravel()

    def jacobian(y: Array) -> Array:
        rows = at(y).jacobian()[free]
        return rows.reshape(rows.shape[0], -1).T * units

    inside = _inside(begin[free] / units, low[free] / units, high[free] / units)
    varied = any(objective.parameters[i].of_body for i in free)
    close = ROBUST if loss != "linear" else OF_LAYERS if varied else CONVERGED
    found = least_squares(
        residuals, inside, jacobian, bounds=(low[free] / units, high[free] / units), method="trf", x_scale="jac",
        loss=loss, f_scale=width, ftol=close, xtol=close, gtol=close, max_nfev=EVALUATIONS,
    )  # fmt: skip
    if found.status <= 0:
        raise SolveError(f"the fit did not converge in {EVALUATIONS} steps; give starting values or fix a parameter")
    x = begin.copy()
    x[free] = found.x * units
    names = [objective.parameters[i].name for i in free]
    held = tuple(name for name, mask in zip(names, found.active_mask, strict=True) if mask != 0)
    return Minimum(objective, x, at(found.x), float(found.cost), held, int(found.nfev))


def _bounds(objective: Objective, start: Array) -> tuple[Array, Array]:
    """Bounds of the unknowns; logs stay near their start, those of layers around their nominal values."""
    low, high = [], []
    units = _natural(objective)
    for p, x in zip(objective.parameters, start, strict=True):
        middle, reach = (p.inner(objective.body.nominal(p.name)), BODY_REACH) if p.of_body else (float(x), REACH)
        least, most = (middle - reach, middle + reach) if p.kind == "log" else (-np.inf, np.inf)
        if p.kind == "positive":
            least = FAINT * units[p.name]
        low.append(max(p.inner(p.low) if p.kind != "linear" else p.low, least))
        high.append(min(p.inner(p.high) if np.isfinite(p.high) else np.inf, most))
    return np.array(low), np.array(high)


def _inside(y: Array, low: Array, high: Array) -> Array:
    """Strictly between the bounds, as the trust region wants it."""
    room = np.where(np.isfinite(high - low), high - low, np.maximum(np.abs(y), 1.0))
    return np.clip(y, low + 1e-8 * room, high - 1e-8 * room)


def _units(objective: Objective) -> Array:
    """Size of each unknown: logs 1, the others by the body."""
    units = _natural(objective)
    return np.array([1.0 if p.kind == "log" else units[p.name] for p in objective.parameters])


def _natural(objective: Objective) -> dict[str, float]:
    """The nonadhesive body at half of its largest radius: delta, P, and w that shifts it by its own displacement."""
    middle = np.array([objective.body.family.high - math.log(2)])
    D, T, H, _ = objective.body.family.at(middle)[0][:, 0]
    return {"w": (D / T) ** 2, "delta0": D, "P0": H, "compliance": D / H}


def fixed_at(objective: Objective, name: str) -> Objective:
    """The same objective with one parameter held at whatever value the unknowns give it."""
    held = (replace(p, free=False, value=p.value or 1.0) if p.name == name else p for p in objective.parameters)
    return replace(objective, parameters=tuple(held))

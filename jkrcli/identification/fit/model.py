"""The statistical model of a record: what an instrument reads at contact radius a, and how far a record lies from it.

delta_read = delta0 + delta(a) + compliance P(a)        P_read = P0 + P(a)        a_read = a

Every measured point has its own unknown contact radius. At its foot point the distance vector is normal to the curve of
readings, so that these unknowns drop out of the problem (variable projection): a change of the parameters moves the
distance by the normal part of the change of the readings alone. With two columns that derivative is exact; with three
it leaves out the turning of the normal plane, which does not enter the gradient.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ...base.arrays import Array
from .body import FittedBody
from .family import Family
from .points import Points
from .settings import Parameter


@dataclass(frozen=True)
class FootPointTuning:
    """Limits of the search for foot points on the curve of readings; radii by their logs."""

    vertices: int = 400  # tuned on records by `make tuning`: of the polyline that starts the foot points
    beyond_last: float = 0.4  # tuned on records by `make tuning`: beyond the series, on the way to a solution
    below_fold: float = 0.5  # tuned on records by `make tuning`: below the radius of stationary displacement
    steps: int = 8  # choice: guard; Newton's method needs two or three
    longest_step: float = 0.1  # choice: guard, some vertices
    least_bend: float = 0.2  # choice: guard, of the squared speed along the curve, where a point is far off it
    close: float = 1e-6  # theory: errors of the distance are its square


TUNING = FootPointTuning()


@dataclass(frozen=True)
class Drift:
    """w and the moduli times 1 + change times the place on the record: 0 at the contact radius ``low``, 1 at ``high``
    [m], less ``centre``."""

    name: str
    change: float
    centre: float
    low: float
    high: float

    def factor(self, a: Array) -> Array:
        """What w or the moduli are multiplied by at contact radii ``a`` [m]; even beyond the record."""
        return 1 + self.change * (np.clip((a - self.low) / (self.high - self.low), -0.2, 1.2) - self.centre)

    def applied(self, functions: tuple[Array, Array, Array], u: Array) -> tuple[Array, Array, Array]:
        """The family's functions (D, T, H, V) and their derivatives by u = log a with this drift."""
        a, factor = np.exp(u), self.factor(np.exp(u))
        rate = self.change * a / (self.high - self.low) / factor
        power = np.array(DRIFTS[self.name])[:, None]
        first, second = power * rate, power * rate * (1 - rate)
        value, by_u, by_uu = functions
        g = factor**power
        return g * value, g * (by_u + first * value), g * (by_uu + 2 * first * by_u + (second + first**2) * value)


DRIFTS = {"w": (0.0, 0.5, 0.0, 0.5), "modulus": (0.0, -0.5, 1.0, 0.5)}  # theory: powers of w and moduli in the family


@dataclass(frozen=True, eq=False)
class Readings:
    """The readings of one set of parameters; ``x``: the optimiser's unknowns in the order of ``parameters``.

    ``columns``: those of a, delta, P that are measured; each is divided by its scale in ``scales`` [m, m, N].
    ``drift``: of w or of the moduli along the record.
    """

    family: Family
    parameters: tuple[Parameter, ...]
    x: Array
    columns: tuple[str, ...]
    scales: Array
    drift: Drift | None = None

    def value(self, name: str) -> float:
        """The value of the parameter called ``name``, SI."""
        pairs = zip(self.parameters, self.x, strict=True)
        return next(parameter.outer(float(x)) for parameter, x in pairs if parameter.name == name)

    def along(self, u: Array) -> tuple[Array, Array, Array]:
        """Scaled readings and their first and second derivatives by u = log a, each of shape (columns, n)."""
        s, w = self.value("modulus"), self.value("w")
        found = []
        for order, (D, T, H, V) in enumerate(self._functions(u)):
            delta, P = D - np.sqrt(w / s) * T, s * H - np.sqrt(w * s) * V
            delta0, P0 = (self.value("delta0"), self.value("P0")) if order == 0 else (0.0, 0.0)
            found.append(self._scaled(np.exp(u), delta0 + delta + self.value("compliance") * P, P0 + P))
        return found[0], found[1], found[2]

    def by_parameters(self, u: Array) -> Array:
        """Derivatives of the scaled readings by the optimiser's unknowns, shape (parameters, columns, n)."""
        (D, T, H, V), _, _ = self._functions(u)
        s, w, compliance = self.value("modulus"), self.value("w"), self.value("compliance")
        root, q = np.sqrt(s), np.sqrt(w)
        one, zero = np.ones_like(u), np.zeros_like(u)
        half = 1 / (2 * q) if q > 0 else 0.0  # a free w stays above 0

        def through_machine(delta: Array, P: Array) -> tuple[Array, Array]:
            return delta + compliance * P, P

        rates = {  # of the readings of delta and P
            "modulus": through_machine(q / root * T / 2, s * H - q * root * V / 2),
            "w": through_machine(-T / root * half, -root * V * half),
            "delta0": (one, zero),
            "P0": (zero, one),
            "compliance": (s * H - q * root * V, zero),
        }
        of_body = iter(self.family.relative_rates(u))
        found = []
        for parameter in self.parameters:
            if parameter.of_body:
                rD, rT, rH, rV = next(of_body) if parameter.free else np.zeros((4, u.size))
                rows = through_machine(D * rD - q / root * T * rT, s * H * rH - q * root * V * rV)
            else:
                rows = rates[parameter.name]
            found.append(self._scaled(zero, *rows))
        return np.stack(found)

    def _functions(self, u: Array) -> tuple[Array, Array, Array]:
        found = self.family.at(u)
        return found if self.drift is None else self.drift.applied(found, u)

    def _scaled(self, a: Array, delta: Array, P: Array) -> Array:
        rows = {"a": a, "delta": delta, "P": P}
        return np.stack([rows[name] for name in self.columns]) / self.scales[:, None]


# ---------------------------------------------------------------------- foot points
@dataclass(frozen=True, eq=False)
class Distances:
    """Distances of n points: ``u`` log of the foot points' radii, ``residuals`` (k, n), scaled.

    Two columns: k = 1, the signed normal distance; three: k = 3, the distance vector. ``tangent``: unit vectors along
    the curve at the foot points (columns, n).
    """

    readings: Readings
    u: Array
    residuals: Array
    tangent: Array

    def jacobian(self, chosen: Array) -> Array:
        """Derivatives of all residuals by the ``chosen`` unknowns, shape (k n, chosen)."""
        rates = self.readings.by_parameters(self.u)
        if len(self.readings.columns) == 2:
            rows = -np.einsum("cn,pcn->pn", _normal(self.tangent), rates)[:, None]
        else:
            along = np.einsum("cn,pcn->pn", self.tangent, rates)
            rows = -(rates - along[:, None] * self.tangent)
        return rows[chosen].reshape(len(chosen), -1).T


def distances(readings: Readings, points: Array) -> Distances:
    """Nearest points of the curve to the scaled measured ``points`` (columns, n)."""
    radii = points[readings.columns.index("a")] * readings.scales[0] if "a" in readings.columns else None
    u = arc(readings, None if radii is None else float(radii.min()))
    u = u[cKDTree(readings.along(u)[0].T).query(points.T)[1]]  # of the nearest vertices
    for _ in range(TUNING.steps):
        X, first, second = readings.along(u)
        gap = points - X
        length2 = np.einsum("cn,cn->n", first, first)
        slope = np.einsum("cn,cn->n", first, gap)
        bend = length2 - np.einsum("cn,cn->n", second, gap)
        step = slope / np.maximum(bend, TUNING.least_bend * length2)
        step = np.clip(step, -TUNING.longest_step, TUNING.longest_step)
        u = u + step
        if np.max(np.abs(step)) < TUNING.close:
            break
    X, first, _ = readings.along(u)
    tangent, gap = first / np.sqrt(np.einsum("cn,cn->n", first, first)), points - X
    if len(readings.columns) == 2:
        gap = np.einsum("cn,cn->n", _normal(tangent), gap)[None]
    return Distances(readings, u, gap, tangent)


def _normal(tangent: Array) -> Array:
    return np.stack([-tangent[1], tangent[0]])


def arc(readings: Readings, least: float | None = None) -> Array:
    """log a of the vertices of the part of the curve on which points are looked for, down to the ``least`` radius that
    was measured [m], if any."""
    family = readings.family
    whole = np.linspace(family.low - TUNING.below_fold, family.high, TUNING.vertices // 2)
    s, w = readings.value("modulus"), readings.value("w")
    (D, T, _, _), _, _ = family.at(whole)
    fold = whole[np.argmin(D - np.sqrt(w / s) * T)]
    below = fold - TUNING.below_fold if least is None else min(fold - TUNING.below_fold, math.log(least))
    return np.linspace(max(below, whole[0]), family.high + TUNING.beyond_last, TUNING.vertices)


# ---------------------------------------------------------------------- what is minimised
@dataclass(frozen=True, eq=False)
class Objective:
    """Scaled distances of ``points`` as a function of the free unknowns; the others keep their values."""

    body: FittedBody
    parameters: tuple[Parameter, ...]
    points: Points
    scales: Array
    drift: Drift | None = None

    @property
    def free(self) -> Array:
        """Indices of the free parameters."""
        return np.flatnonzero([parameter.free for parameter in self.parameters])

    def held(self, *names: str) -> Objective:
        """The same objective with these parameters held at whatever values the unknowns give them."""
        parameters = (replace(p, free=False, value=p.value or 1.0) if p.name in names else p for p in self.parameters)
        return replace(self, parameters=tuple(parameters))

    def values(self, x: Array) -> dict[str, float]:
        """All parameters by name at the unknowns ``x``, SI."""
        return {p.name: p.outer(float(v)) for p, v in zip(self.parameters, x, strict=True)}

    def distances(self, x: Array, rated: bool = True) -> Distances:
        """The distances at all unknowns ``x``; where layers vary the body is solved anew, without their derivatives
        where not ``rated``."""
        own = {name: value for name, value in self.values(x).items() if ":" in name}
        varied = [p.name for p in self.parameters if p.of_body and p.free]
        body = self.body.rated(own, varied) if rated and varied else self.body.with_values(own)
        columns = self.points.columns
        target = np.stack([self.points.values[name] for name in columns]) / self.scales[:, None]
        return distances(Readings(body.family, self.parameters, x, columns, self.scales, self.drift), target)

    def natural_units(self) -> dict[str, float]:
        """Sizes of unknowns by the nonadhesive body at half of its largest radius: delta, P, and w that shifts it by
        its own displacement."""
        middle = np.array([self.body.family.high - math.log(2)])
        D, T, H, _ = self.body.family.at(middle)[0][:, 0]
        return {"w": (D / T) ** 2, "delta0": D, "P0": H, "compliance": D / H}

"""The statistical model of a record: what an instrument reads at contact radius a, and how far a record lies from it.

delta_read = delta0 + delta(a) + compliance P(a)        P_read = P0 + P(a)        a_read = a

Every measured point has its own unknown contact radius. At its foot point the distance vector is normal to the curve of
readings, so that these unknowns drop out of the problem (variable projection): a change of the parameters moves the
distance by the normal part of the change of the readings alone. With two columns that derivative is exact; with three
it leaves out the turning of the normal plane, which does not enter the gradient.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ...base import MOST_SOLVES, TINY, Array
from ..parameters import Parameter, Unknowns
from .body import FittedBody
from .family import ADVANCING, RECEDING, RESTING, Drift, Member, Members, RestingMember
from .points import Points
from .settings import RANGES


@dataclass(frozen=True)
class FootPointTuning:
    """Limits of the search for foot points on the curve of readings; radii by their logs."""

    vertices: int = 400  # tuned on records by `make tuning`: of the polyline that starts the foot points
    beyond_last: float = 0.4  # tuned on records by `make tuning`: beyond the series, on the way to a solution
    below_fold: float = 0.5  # tuned on records by `make tuning`: below the radius of stationary displacement

    longest_step: float = 0.1  # choice: guard, some vertices
    least_bend: float = 0.2  # choice: guard, of the squared speed along the curve, where a point is far off it
    close: float = 1e-6  # theory: errors of the distance are its square


TUNING = FootPointTuning()


@dataclass(frozen=True, eq=False)
class Readings:
    """The readings at the ``values`` of the parameters, SI, whose ``names`` are in the optimiser's order.

    ``columns``: those of a, delta, P that are measured; each is divided by its scale in ``scales`` [m, m, N].
    ``drift``: of w or of the moduli along the record; ``edge``: what it does, as ``edges`` numbers it.
    """

    members: Members
    names: Sequence[str]
    values: Mapping[str, float]
    columns: tuple[str, ...]
    scales: Array
    drift: Drift | None = None
    edge: int = RECEDING

    @cached_property
    def member(self) -> Member:
        """The curve behind the readings."""
        values = self.values
        if self.edge == RESTING:
            return RestingMember(self.members.plain, values["modulus"], values["a_turn"], self.drift)
        w = values["w_approach" if self.edge == ADVANCING else "w"]
        return self.members.member({**values, "w": w}, self.drift)

    def radii(self, u: Array) -> Array:
        """Contact radii [m]."""
        return self.member.along(u)[0][0]

    def along(self, u: Array) -> tuple[Array, Array, Array]:
        """Scaled readings and their first and second derivatives by u, each of shape (columns, n)."""
        value, first, second = self.member.along(u)
        zeros = self.values["delta0"], self.values["P0"]
        return self._read(value, *zeros), self._read(first), self._read(second)

    def by_parameters(self, u: Array) -> Array:
        """Derivatives of the scaled readings by the optimiser's unknowns, shape (parameters, columns, n)."""
        one, zero = np.ones_like(u), np.zeros_like(u)
        rates = {name: self._read(by) for name, by in self.member.rates(u).items()}
        if self.edge == ADVANCING:
            rates["w_approach"] = rates.pop("w")
        rates |= {
            "delta0": self._scaled(zero, one, zero),
            "P0": self._scaled(zero, zero, one),
            "compliance": self._scaled(zero, self.member.along(u)[0][2], zero),
        }
        none = self._scaled(zero, zero, zero)
        return np.stack([rates.get(name, none) for name in self.names])

    def _read(self, states: Array, delta0: float = 0.0, P0: float = 0.0) -> Array:
        a, delta, P = states
        return self._scaled(a, delta0 + delta + self.values["compliance"] * P, P0 + P)

    def _scaled(self, a: Array, delta: Array, P: Array) -> Array:
        rows = {"a": a, "delta": delta, "P": P}
        return np.stack([rows[name] for name in self.columns]) / self.scales[:, None]


# ---------------------------------------------------------------------- foot points
@dataclass(frozen=True, eq=False)
class FootPoints:
    """Those of n points whose edge does the same, among all of the ``places``: ``u`` log of their places on the curve,
    ``residuals`` (k, n), scaled.

    Two columns: k = 1, the signed normal distance; three: k = 3, the distance vector. ``tangent``: unit vectors along
    the curve at the foot points (columns, n).
    """

    readings: Readings
    places: Array
    u: Array
    residuals: Array
    tangent: Array

    @property
    def a(self) -> Array:
        """Their contact radii [m]."""
        return self.readings.radii(self.u)

    def line(self) -> dict[str, Array]:
        """The curve of the readings by column, and its contact radii "a", SI."""
        readings, u = self.readings, arc(self.readings)
        low, high = float(self.u.min()), float(self.u.max())
        if readings.edge == ADVANCING:
            u = np.append(u[u < high], high)
        elif readings.edge == RESTING:
            u = np.array([low, high])
        else:
            end = max(float(np.exp(readings.members.plain.high)), float(self.a.max()))
            u = u[readings.radii(u) <= end]
        values = dict(zip(readings.columns, readings.along(u)[0] * readings.scales[:, None], strict=True))
        return {"a": readings.radii(u)} | values

    def rates(self, chosen: Array) -> Array:
        """Derivatives of the residuals by the ``chosen`` unknowns, shape (chosen, k, n)."""
        rates = self.readings.by_parameters(self.u)[chosen]
        if len(self.readings.columns) == 2:
            return -np.einsum("cn,pcn->pn", _normal(self.tangent), rates)[:, None]
        along = np.einsum("cn,pcn->pn", self.tangent, rates)
        return -(rates - along[:, None] * self.tangent)


@dataclass(frozen=True, eq=False)
class Distances:
    """Distances of all points, each of one of the ``parts`` from the curve that its edge is on."""

    parts: tuple[FootPoints, ...]

    @property
    def readings(self) -> Readings:
        """Those of the edge that moves last."""
        return self.parts[-1].readings

    def at(self, edge: int) -> FootPoints:
        """Those of the points whose edge does this."""
        return next(part for part in self.parts if part.readings.edge == edge)

    def _together(self, columns: Sequence[Array]) -> Array:
        """Columns (..., n) of all points, in their order, from those of the parts."""
        if len(columns) == 1:
            return columns[0]
        return np.concatenate(columns, axis=-1)[..., np.argsort(np.concatenate([part.places for part in self.parts]))]

    @cached_property
    def residuals(self) -> Array:
        return self._together([part.residuals for part in self.parts])

    @cached_property
    def a(self) -> Array:
        """Contact radii of the foot points [m]."""
        return self._together([part.a for part in self.parts])

    @property
    def along(self) -> Array:
        """The order of the points along the path."""
        ways = (np.argsort(part.u)[:: -1 if part.readings.edge == RECEDING else 1] for part in self.parts)
        return np.concatenate([part.places[way] for part, way in zip(self.parts, ways, strict=True)])

    def jacobian(self, chosen: Array) -> Array:
        """Derivatives of all residuals by the ``chosen`` unknowns, shape (k n, chosen)."""
        return self._together([part.rates(chosen) for part in self.parts]).reshape(len(chosen), -1).T

    def line(self) -> dict[str, Array]:
        """The curve of the readings in one stroke, by column, and its contact radii "a", SI."""
        lines = [part.line() for part in self.parts]
        return {name: np.concatenate([line[name] for line in lines]) for name in lines[0]}


def foot_points(readings: Readings, points: Array, places: Array) -> FootPoints:
    """Nearest points of the curve to the scaled measured ``points`` (columns, all) of the ``places``."""
    points = points[:, places]
    radii = points[readings.columns.index("a")] * readings.scales[0] if "a" in readings.columns else None
    u = arc(readings, None if radii is None else float(radii.min()))
    u = u[cKDTree(readings.along(u)[0].T).query(points.T)[1]]  # of the nearest vertices
    for _ in range(MOST_SOLVES):  # Newton's method needs two or three
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
    speed = np.sqrt(np.maximum(np.einsum("cn,cn->n", first, first), TINY))
    tangent, gap = first / speed, points - X
    if len(readings.columns) == 2:
        gap = np.einsum("cn,cn->n", _normal(tangent), gap)[None]
    return FootPoints(readings, places, u, gap, tangent)


def _normal(tangent: Array) -> Array:
    return np.stack([-tangent[1], tangent[0]])


def arc(readings: Readings, least: float | None = None) -> Array:
    """u of the vertices of the part of the curve on which foot points are sought, down to the ``least`` radius that was
    measured [m], if any."""
    return np.linspace(*readings.member.ends(TUNING.below_fold, TUNING.beyond_last, least), TUNING.vertices)


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

    @property
    def ranged(self) -> bool:
        """Whether adhesion has a range."""
        return any(parameter.name in RANGES for parameter in self.parameters)

    def holding(self, *names: str) -> Objective:
        """The same objective with these parameters fixed at their values in the unknowns."""
        parameters = (replace(p, free=False, value=p.value or 1.0) if p.name in names else p for p in self.parameters)
        return replace(self, parameters=tuple(parameters))

    def values(self, x: Array) -> dict[str, float]:
        """All parameters by name at the unknowns ``x``, SI."""
        return {p.name: p.outer(float(v)) for p, v in zip(self.parameters, x, strict=True)}

    def at(self, x: Array, y: Array) -> Array:
        """All unknowns ``x`` with the free ones as the search takes them, ``y``."""
        x = x.copy()
        x[self.free] = y * self.unknowns.scales
        return x

    def readings(self, x: Array, rated: bool = True) -> Readings:
        """The readings at all unknowns ``x``; where layers vary the body is solved anew, without their derivatives
        where not ``rated``."""
        values, varied = self.values(x), [p.name for p in self.parameters if p.of_body and p.free]
        own = {name: value for name, value in values.items() if ":" in name}
        body = self.body.rated(own, varied) if rated and varied else self.body.with_values(own)
        return Readings(body.members(self.ranged), tuple(values), values, self.points.columns, self.scales, self.drift)

    def distances(self, x: Array, rated: bool = True) -> Distances:
        """The distances of the points from the ``readings``."""
        readings, edges = self.readings(x, rated), self.points.edges
        edges = np.full(len(self.points), RECEDING) if edges is None else edges
        target = np.stack([self.points.values[name] for name in readings.columns]) / self.scales[:, None]
        each = ((replace(readings, edge=edge), np.flatnonzero(edges == edge)) for edge in np.unique(edges))
        return Distances(tuple(foot_points(part, target, places) for part, places in each))

    @cached_property
    def unknowns(self) -> Unknowns:
        """Of the search, in units by the nonadhesive body at half of its largest radius: delta, P, and w that shifts
        it by its own displacement."""
        family = self.body.family
        D, _, H, _ = family.at(np.array([family.high - math.log(2)]))[0][:, 0]
        w = family.natural_work
        return Unknowns(self.parameters, {"w": w, "w_approach": w, "delta0": D, "P0": H, "compliance": D / H})

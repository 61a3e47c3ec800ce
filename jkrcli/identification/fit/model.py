"""The statistical model of a record: what an instrument reads at contact radius a, and how far a record lies from it.

delta_read = delta0 + delta(a) + compliance P(a)        P_read = P0 + P(a)        a_read = a

Every measured point has its own unknown contact radius. At its foot point the distance vector is normal to the curve of
readings, so that these unknowns drop out of the problem (variable projection): a change of the parameters moves the
distance by the normal part of the change of the readings alone. With two columns that derivative is exact; with three
it leaves out the turning of the normal plane, which does not enter the gradient.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ...base import MOST_SOLVES, TINY, Array
from ..parameters import Parameter
from .body import FittedBody
from .edges import ADVANCING, RECEDING, RESTING, RestingMember
from .family import Drift, Member, Members
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
    """The readings of one set of parameters; ``x``: the optimiser's unknowns in the order of ``parameters``.

    ``columns``: those of a, delta, P that are measured; each is divided by its scale in ``scales`` [m, m, N].
    ``drift``: of w or of the moduli along the record; ``edge``: what it does, as ``edges`` numbers it.
    """

    members: Members
    parameters: tuple[Parameter, ...]
    x: Array
    columns: tuple[str, ...]
    scales: Array
    drift: Drift | None = None
    edge: int = RECEDING

    @cached_property
    def values(self) -> dict[str, float]:
        """The values of the parameters by name, SI."""
        return {p.name: p.outer(float(x)) for p, x in zip(self.parameters, self.x, strict=True)}

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
        values, rows = self.values, []
        for order, (a, delta, P) in enumerate(self.member.along(u)):
            delta0, P0 = (values["delta0"], values["P0"]) if order == 0 else (0.0, 0.0)
            rows.append(self._scaled(a, delta0 + delta + values["compliance"] * P, P0 + P))
        return rows[0], rows[1], rows[2]

    def by_parameters(self, u: Array) -> Array:
        """Derivatives of the scaled readings by the optimiser's unknowns, shape (parameters, columns, n)."""
        one, zero = np.ones_like(u), np.zeros_like(u)
        compliance, of_body = self.values["compliance"], iter(self.member.own_rates(u))
        through_machine = {
            name: np.stack([a, delta + compliance * P, P]) for name, (a, delta, P) in self.member.rates(u).items()
        }
        if self.edge == ADVANCING:
            through_machine["w_approach"] = through_machine.pop("w")
        rates = through_machine | {
            "delta0": np.stack([zero, one, zero]),
            "P0": np.stack([zero, zero, one]),
            "compliance": np.stack([zero, self.member.along(u)[0][2], zero]),
        }
        derivatives = []
        for parameter in self.parameters:
            rows = rates.get(parameter.name, np.zeros((3, u.size)))
            if parameter.of_body and parameter.free:
                a, delta, P = next(of_body)
                rows = np.stack([a, delta + compliance * P, P])
            derivatives.append(self._scaled(*rows))
        return np.stack(derivatives)

    def _scaled(self, a: Array, delta: Array, P: Array) -> Array:
        rows = {"a": a, "delta": delta, "P": P}
        return np.stack([rows[name] for name in self.columns]) / self.scales[:, None]


# ---------------------------------------------------------------------- foot points
@dataclass(frozen=True, eq=False)
class Distances:
    """Distances of n points: ``u`` log of the foot points' places, ``residuals`` (k, n), scaled.

    Two columns: k = 1, the signed normal distance; three: k = 3, the distance vector. ``tangent``: unit vectors along
    the curve at the foot points (columns, n).
    """

    readings: Readings
    u: Array
    residuals: Array
    tangent: Array

    @property
    def a(self) -> Array:
        """Contact radii of the foot points [m]."""
        return self.readings.radii(self.u)

    @property
    def along(self) -> Array:
        """The order of the points along the curve."""
        return np.argsort(self.u)

    def line(self) -> dict[str, Array]:
        """The curve of the readings by column, and its contact radii "a", SI."""
        readings, u = self.readings, arc(self.readings)
        low, high = float(self.u.min()), float(self.u.max())
        match readings.edge:
            case edge if edge == ADVANCING:
                u = np.append(u[u < high], high)
            case edge if edge == RESTING:
                u = np.array([low, high])
            case _:
                a, end = readings.radii(u), float(np.exp(readings.members.plain.high))
                u = u[a <= max(end, float(self.a.max()))]
        values = dict(zip(readings.columns, readings.along(u)[0] * readings.scales[:, None], strict=True))
        return {"a": readings.radii(u)} | values

    def jacobian(self, chosen: Array) -> Array:
        """Derivatives of all residuals by the ``chosen`` unknowns, shape (k n, chosen)."""
        rates = self.readings.by_parameters(self.u)
        if len(self.readings.columns) == 2:
            rows = -np.einsum("cn,pcn->pn", _normal(self.tangent), rates)[:, None]
        else:
            along = np.einsum("cn,pcn->pn", self.tangent, rates)
            rows = -(rates - along[:, None] * self.tangent)
        return rows[chosen].reshape(len(chosen), -1).T


@dataclass(frozen=True, eq=False)
class PathDistances:
    """Distances of the points of a cycle, each ``part`` of them from the curve that its edge is on; ``places``: of its
    points among all. ``u``: log of their contact radii."""

    parts: tuple[Distances, ...]
    places: tuple[Array, ...]

    @property
    def readings(self) -> Readings:
        """Those of the edge that moves last."""
        return self.parts[-1].readings

    def at(self, edge: int) -> Distances:
        """Those of the points whose edge does this."""
        return next(part for part in self.parts if part.readings.edge == edge)

    def _together(self, columns: Sequence[Array]) -> Array:
        """Columns (..., n) of all points, in their order, from those of the parts."""
        return np.concatenate(columns, axis=-1)[..., np.argsort(np.concatenate(self.places))]

    @cached_property
    def residuals(self) -> Array:
        return self._together([part.residuals for part in self.parts])

    @cached_property
    def a(self) -> Array:
        return self._together([part.a for part in self.parts])

    @property
    def u(self) -> Array:
        return np.log(self.a)

    @property
    def along(self) -> Array:
        """The order of the points along the path."""
        return np.concatenate([
            place[np.argsort(-part.u if part.readings.edge == RECEDING else part.u)]
            for part, place in zip(self.parts, self.places, strict=True)
        ])  # fmt: skip

    def jacobian(self, chosen: Array) -> Array:
        size = self.residuals.shape[0]
        columns = [part.jacobian(chosen).T.reshape(len(chosen), size, -1) for part in self.parts]
        return self._together(columns).reshape(len(chosen), -1).T

    def line(self) -> dict[str, Array]:
        """The curve of the readings in one stroke, as ``Distances.line``."""
        lines = [part.line() for part in self.parts]
        return {name: np.concatenate([line[name] for line in lines]) for name in lines[0]}


def distances(readings: Readings, points: Array) -> Distances:
    """Nearest points of the curve to the scaled measured ``points`` (columns, n)."""
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
    return Distances(readings, u, gap, tangent)


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

    def distances(self, x: Array, rated: bool = True) -> Distances | PathDistances:
        """The distances at all unknowns ``x``; where layers vary the body is solved anew, without their derivatives
        where not ``rated``."""
        own = {name: value for name, value in self.values(x).items() if ":" in name}
        varied = [p.name for p in self.parameters if p.of_body and p.free]
        body = self.body.rated(own, varied) if rated and varied else self.body.with_values(own)
        columns, edges = self.points.columns, self.points.edges
        target = np.stack([self.points.values[name] for name in columns]) / self.scales[:, None]
        readings = Readings(body.members(self.ranged), self.parameters, x, columns, self.scales, self.drift)
        if edges is None:
            return distances(readings, target)
        places = {edge: np.flatnonzero(edges == edge) for edge in np.unique(edges)}
        parts = [distances(replace(readings, edge=edge), target[:, place]) for edge, place in places.items()]
        return PathDistances(tuple(parts), tuple(places.values()))

    def natural_units(self) -> dict[str, float]:
        """Sizes of unknowns by the nonadhesive body at half of its largest radius: delta, P, and w that shifts it by
        its own displacement."""
        family = self.body.family
        D, _, H, _ = family.at(np.array([family.high - math.log(2)]))[0][:, 0]
        return {"w": family.natural_work, "w_approach": family.natural_work, "delta0": D, "P0": H, "compliance": D / H}

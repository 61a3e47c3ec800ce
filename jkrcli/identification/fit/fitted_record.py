"""A fitted record: radii, loads and positions of its rows, and how a change of the model changes its loads.

Columns are derivatives of the loads P of all rows at fixed positions z of the device. As delta = z - P/k, a change dP
at fixed displacement delta is dP (1 - P'/k) at fixed position, P' the derivative of the load by the position.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import ndtri

from ...base import Array
from ...data import APPROACH
from .body import FittedBody
from .device_path import grid
from .family import Family
from .force_curve import ForceCurveModel, base_line
from .force_curve_fit import ForceCurveFit
from .force_curve_readings import DirectionReadings
from .record_change import LITTLE, Change, RivalModel, Values, interpolated


@dataclass(frozen=True)
class Known:
    """What the user knows before the data: the longest ``range`` of adhesion [m], inf where nothing is, and the largest
    surface ``tension`` [N/m], 0 where nothing is; and the ``level`` of intervals."""

    range: float = math.inf
    tension: float = 0.0
    level: float = 0.95

    @property
    def quantile(self) -> float:
        """Half-width of intervals, in standard errors."""
        return float(ndtri((1 + self.level) / 2))


@dataclass(frozen=True, eq=False)
class FittedRecord:
    """The ``fit`` of a record of a ``body``, and what is ``known`` besides, as rivals need them."""

    body: FittedBody
    fit: ForceCurveFit
    known: Known = Known()

    @property
    def model(self) -> ForceCurveModel:
        return self.fit.model

    @cached_property
    def values(self) -> Values:
        """All unknowns, by name."""
        return self.model.values(self.fit.x)

    @property
    def residuals(self) -> Array:
        """Residuals [N] of all rows."""
        return self.model.residuals(self.fit.x, 0.0)[0]

    @property
    def jacobian(self) -> Array:
        """Their derivatives by the unknowns, (rows, unknowns)."""
        return self.model.residuals(self.fit.x, 0.0)[1]

    def by_unknown(self, name: str) -> Array:
        """The column of the Jacobian that belongs to an unknown."""
        return self.jacobian[:, self.fit.names.index(name)]

    @cached_property
    def retraction(self) -> DirectionReadings | None:
        return next((part for part in self.model.stretches if part.kind != APPROACH), None)

    @cached_property
    def radii(self) -> list[tuple[Array, Array]]:
        """Contact radius [m] of the rows of each stretch, and which of them rest."""
        return [self.model.contact_radii(part, self.values) for part in self.model.stretches]

    def radii_of(self, part: DirectionReadings) -> tuple[Array, Array]:
        """The same of one stretch."""
        return self.radii[self.model.stretches.index(part)]

    @cached_property
    def a(self) -> Array:
        """Contact radius [m] of all rows, 0 where they are free."""
        return np.concatenate([a for a, _ in self.radii])

    @cached_property
    def a_max(self) -> float:
        """Largest contact radius [m]."""
        return float(self.a.max())

    @cached_property
    def modulus(self) -> float:
        """Factor of the body's moduli."""
        return math.exp(self.values["ln_s"])

    @property
    def E_star(self) -> float:
        """E* of the body as fitted [Pa]."""
        return self.modulus * self.body.problem.E_star

    @cached_property
    def work(self) -> float:
        """The largest w of the directions [J/m^2], 0 where none adheres."""
        return max(0.0, *(self.values[f"q:{part.kind}"] for part in self.model.stretches)) * self.modulus

    @cached_property
    def nonadhesive(self) -> tuple[Array, Array]:
        """Load [N] of all rows at their contact radii without adhesion, and the contact stiffness there [N/m]."""
        _, T, H, V = self.model.family.at(np.log(np.maximum(self.a, LITTLE**2 * self.a_max)))[0]
        touching = self.modulus * (self.a > 0)
        return touching * H, touching * V / T

    @cached_property
    def loads(self) -> Array:
        """Loads of the contact [N] at all rows, of the model."""
        lines = np.concatenate([base_line(part, self.values)[0] for part in self.model.stretches])
        loads: Array = np.concatenate([part.P for part in self.model.stretches]) + self.residuals - lines
        return loads

    @cached_property
    def depth(self) -> Array:
        """Position of the device beyond its zero [m], at all rows."""
        return np.concatenate([self.model.depth(part, self.values) for part in self.model.stretches])

    @cached_property
    def by_position(self) -> Array:
        """P', the derivative of the loads by the position of the device [N/m], its turn where it is."""
        return self.model.by_position(self.fit.x)

    @cached_property
    def at_fixed_position(self) -> Array:
        """1 - P'/k: a change of load at fixed position over that at fixed displacement."""
        return 1 - self.by_position / self.model.k

    def by_changes(self, changes: Array) -> Array:
        """Derivative of the loads [N] by an amount of ``changes`` (4, n) of the logs of D, T, H, V on the grid."""
        each = interpolated(grid(self.model.family), changes)
        return self.model.by_body(self.fit.x, [each] * len(self.model.stretches))

    def towards(self, other: Family, amount: float) -> Array:
        """Derivative of the loads by an amount, ``amount`` of which makes the body that of the ``other`` family."""
        return self.by_changes(log_ratio(other, self.model.family) / amount)

    def column(self, change: Change) -> Array:
        """Derivative of the loads by the amount of a change, at 0 unless the change has a column of its own."""
        if change.column is not None:
            return change.column
        model = RivalModel.of(self.model, change)
        x = np.concatenate([self.fit.x, [LITTLE, *change.starts[0][1:]]])
        if change.log_changes is None:
            return (model.off(x, 0.0) - self.residuals) / LITTLE
        u, values = grid(self.model.family), model.values(x)
        each = [change.log_changes(model, part, values) for part in model.stretches]
        return self.model.by_body(self.fit.x, [None if g is None else interpolated(u, g / LITTLE) for g in each])

    @cached_property
    def reach(self) -> float:
        """How far the device moves in contact [m]."""
        return max(part.reach for part in self.model.stretches)

    @cached_property
    def duration(self) -> float:
        """How long the record lasts [s]."""
        return self.model.stretches[0].lasting

    @cached_property
    def tip_turn(self) -> float:
        """Where the tip turns [m], beside z0: at the device's turn less its deflection there."""
        part = self.model.stretches[0]
        i = int(np.argmax(part.z))
        line = base_line(part, self.values)[0][i]
        return part.turn - float(part.P[i] - line) / self.model.k

    def rows(self, part: DirectionReadings, chosen: Array | bool = True) -> Array:
        """Which rows of all are those of one stretch that are ``chosen``."""
        return np.concatenate([np.full(one.P.size, chosen if one is part else False) for one in self.model.stretches])

    def time(self, part: DirectionReadings) -> Array:
        """Time since the turn, in units of a whole record; by the number of rows where no column tells it."""
        if min(float(np.ptp(one.t)) for one in self.model.stretches) > 0:
            return np.abs(part.t) / self.duration
        return np.abs(part.rows - part.rows[-1]) / sum(float(np.ptp(one.rows)) for one in self.model.stretches)


def log_ratio(other: Family, family: Family) -> Array:
    """Logs (4, n) of D, T, H, V of an ``other`` body over a ``family``'s, on its grid; constant where one ends."""
    inside = np.clip(grid(family), max(family.low, other.low), min(family.high, other.high))
    ratio: Array = np.log(other.at(inside)[0] / family.at(inside)[0])
    return ratio

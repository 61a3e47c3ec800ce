"""A fit of a raw record as rivals look at it: radii, loads and positions of its rows, and what changes of the model
make of its loads."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...base import Array
from ...data.measured.curve import APPROACH
from .body import FittedBody
from .device_path import grid
from .family import Family
from .force_curve import DirectionReadings, ForceCurveFit, ForceCurveModel, base_line
from .record_change import LITTLE, Change, RivalModel, by_log


@dataclass(frozen=True, eq=False)
class Situation:
    """A fit of a record of a ``body``, as rivals look at it."""

    body: FittedBody
    found: ForceCurveFit

    @property
    def model(self) -> ForceCurveModel:
        return self.found.model

    @cached_property
    def here(self) -> tuple[Array, Array]:
        """Residuals [N] of all rows and their derivatives by the unknowns."""
        return self.model.residuals(self.found.x, 0.0)

    @cached_property
    def back(self) -> DirectionReadings | None:
        """The retraction."""
        return next((part for part in self.model.stretches if part.kind != APPROACH), None)

    @cached_property
    def radii(self) -> list[tuple[Array, Array]]:
        """Contact radius [m] of the rows of each stretch, and which of them rest."""
        values = self.model.values(self.found.x)
        return [self.model.contact_radii(part, values) for part in self.model.stretches]

    @cached_property
    def a(self) -> Array:
        """Contact radius [m] of all rows, 0 where they are free."""
        return np.concatenate([a for a, _ in self.radii])

    @cached_property
    def widest(self) -> float:
        """Largest contact radius [m]."""
        return float(self.a.max())

    @cached_property
    def modulus(self) -> float:
        """Factor of the body's moduli."""
        return math.exp(self.model.values(self.found.x)["ln_s"])

    @cached_property
    def work(self) -> float:
        """The largest w of the directions [J/m^2], 0 where none adheres."""
        values = self.model.values(self.found.x)
        return max(0.0, *(values[f"q:{part.kind}"] for part in self.model.stretches)) * self.modulus

    @cached_property
    def nonadhesive(self) -> tuple[Array, Array]:
        """Load [N] of all rows at their contact radii without adhesion, and the contact stiffness there [N/m]."""
        _, T, H, V = self.model.family.at(np.log(np.maximum(self.a, LITTLE**2 * self.widest)))[0]
        touching = self.modulus * (self.a > 0)
        return touching * H, touching * V / T

    @cached_property
    def loads(self) -> Array:
        """Loads of the contact [N] at all rows, of the model."""
        values = self.model.values(self.found.x)
        lines = np.concatenate([base_line(part, values)[0] for part in self.model.stretches])
        found: Array = np.concatenate([part.P for part in self.model.stretches]) + self.here[0] - lines
        return found

    @cached_property
    def by_position(self) -> Array:
        """Derivative of the loads by the position of the device [N/m], its turn where it is."""
        return self.model.by_position(self.found.x)

    @cached_property
    def yields(self) -> Array:
        """What is left at fixed position of a change of load at fixed displacement."""
        return 1 - self.by_position / self.model.k

    def on(self, changes: Array) -> Array:
        """Derivative of the loads [N] by an amount of ``changes`` (4, n) of the logs of D, T, H, V on the grid."""
        same = by_log(grid(self.model.family), changes)
        return self.model.by_body(self.found.x, [same] * len(self.model.stretches))

    def neighbour(self, other: Family, size: float) -> Array:
        """Derivative of the loads by an amount ``size`` of which makes the body that of ``other``."""
        own = self.model.family
        inside = np.clip(grid(own), max(own.low, other.low), min(own.high, other.high))
        change = np.log(other.at(inside)[0] / own.at(inside)[0])
        return self.on(change / size)

    def column(self, change: Change) -> Array:
        """Derivative of the loads by the amount of a change, at 0."""
        if change.column is not None:
            return change.column
        model = RivalModel.of(self.model, change)
        e, first = LITTLE, change.starts[0]
        x = np.concatenate([self.found.x, [e, *first[1:]]])
        values = model.values(x)
        if change.bends is not None:
            u, each = grid(self.model.family), [change.bends(model, part, values) for part in model.stretches]
            changes = [None if one is None else by_log(u, one / e) for one in each]
            return self.model.by_body(self.found.x, changes)
        return (model.off(x, 0.0) - self.here[0]) / e

    @cached_property
    def reach(self) -> float:
        """How far the device moves in contact [m]."""
        return max(part.reach for part in self.model.stretches)

    def only(self, part: DirectionReadings, column: Array) -> Array:
        """A column on the rows of one stretch, 0 on the others."""
        own = np.concatenate([np.full(one.P.size, one is part) for one in self.model.stretches])
        return np.where(own, column, 0.0)

    @cached_property
    def lasting(self) -> float:
        """How long the record lasts [s]."""
        return self.model.stretches[0].lasting

    @cached_property
    def tip_turn(self) -> float:
        """Where the tip turns [m], beside z0: at the device's turn less its deflection there."""
        part = self.model.stretches[0]
        i = int(np.argmax(part.z))
        line = base_line(part, self.model.values(self.found.x))[0][i]
        return part.turn - float(part.P[i] - line) / self.model.k

    def rows(self, part: DirectionReadings, chosen: Array) -> Array:
        """Which rows of all are those of one stretch that are ``chosen``."""
        return np.concatenate([chosen if one is part else np.zeros(one.P.size, bool) for one in self.model.stretches])

    def time(self, part: DirectionReadings) -> Array:
        """Time since the turn, in units of a whole record; by the number of rows where no column tells it."""
        if min(float(np.ptp(one.t)) for one in self.model.stretches) > 0:
            return np.abs(part.t) / self.lasting
        return np.abs(part.rows - part.rows[-1]) / sum(float(np.ptp(one.rows)) for one in self.model.stretches)

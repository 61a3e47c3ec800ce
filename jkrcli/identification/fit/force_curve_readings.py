"""Rows of a raw record as its model takes them: each direction from its far end inwards, with its base line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...base import ROWS, Array, known
from ...data import APPROACH, BaseLine, Direction, ForceCurve
from .interference import Wave
from .points import in_contact, third_differences


@dataclass(frozen=True)
class ReadingsTuning:
    """Which rows are left out."""

    # tuned on fits, by `make constants`: of the rows in contact, those next to the turning point that are left out
    turning: float = 0.01


TUNING = ReadingsTuning()


@dataclass(frozen=True, eq=False)
class DirectionReadings:
    """The ``rows`` of one direction, from the far end inwards: device position ``z`` [m], reading ``P`` [N].

    ``touching``: whether a row may be in contact; where ``jumped``, all those rows are, and the others are free, by a
    jump, or by a window about first touch that is left out.
    ``line``: the base line of the free rows alone, ``wave``: on top of it. ``t``: time since the end
    of the approach [s], 0 where it is not known, ``waits`` until the retraction, of ``lasting`` in all. ``turn``: where
    the device turns [m]; ``tension``: the largest above the noise [N].
    """

    kind: str
    rows: Array
    line: BaseLine
    z: Array
    P: Array
    touching: Array
    jumped: bool
    t: Array
    turn: float
    tension: float
    wave: Wave | None = None
    waits: float = 0.0
    lasting: float = 0.0

    @cached_property
    def spacing(self) -> float:
        """Usual distance of neighbouring rows [m]; the mean where most of them repeat their position."""
        steps = np.abs(np.diff(self.z))
        return float(np.median(steps)) or float(np.mean(steps))

    @cached_property
    def travel(self) -> float:
        """How far the device moves in all [m]."""
        return self.turn - float(self.z.min())

    @property
    def way(self) -> Array:
        """The share of the travel between the turn and each row."""
        return (self.turn - self.z) / self.travel

    @cached_property
    def reach(self) -> float:
        """How far the device moves in contact [m], about."""
        touching = float(np.ptp(self.z[self.touching])) if self.jumped and self.touching.any() else 0.0
        return touching or 0.1 * float(np.ptp(self.z))

    def thinned(self) -> DirectionReadings:
        """Means of neighbouring rows, none across the border of contact."""
        size = self.z.size // ROWS
        if size < 2:
            return self
        first = np.union1d(np.arange(0, self.z.size, size), np.flatnonzero(np.diff(self.touching)) + 1)
        count = np.diff(np.append(first, self.z.size))
        z, P, t = (np.add.reduceat(column, first) / count for column in (self.z, self.P, self.t))
        return replace(self, rows=self.rows[first], touching=self.touching[first], z=z, P=P, t=t)


def stretches(
    record: ForceCurve, kinds: Sequence[str], waves: Mapping[str, Wave] | None = None
) -> tuple[DirectionReadings, ...]:
    """The directions ``kinds`` of a record as the model takes them: rows within a jump belong to neither side and are
    left out. ``waves``: what was taken off the loads of the record and is to be fitted with the rest."""
    sides = [side for kind in kinds if (side := record.direction(kind)) is not None]
    return tuple(_stretch(record, side, (waves or {}).get(side.segment.kind)) for side in sides)


def _stretch(record: ForceCurve, side: Direction, wave: Wave | None) -> DirectionReadings:
    curve, rows = record.curve, np.arange(side.segment.first, side.segment.last + 1)
    if side.segment.kind != APPROACH:
        rows = rows[::-1]
    z = curve.device[rows]
    P = curve.load[rows] if wave is None else curve.load[rows] + wave(z)
    line, tension, touching, keep = _base_and_contact(side, z, P)
    contact = np.count_nonzero(touching) or rows.size - side.border[1]
    keep[rows.size - round(TUNING.turning * contact) :] = False
    keep &= ~np.isin(rows, record.spikes)
    into = record.direction(APPROACH)
    last = int(np.argmax(curve.device)) if into is None else into.segment.last
    t = np.zeros(len(curve)) if curve.t is None else curve.t - curve.t[last]
    return DirectionReadings(
        side.segment.kind, rows[keep], line, z[keep], P[keep], touching[keep], bool(touching.any()), t[rows[keep]],
        float(curve.device.max()), tension, wave, max(float(t[rows[-1]]), 0.0), float(np.ptp(t)),
    )  # fmt: skip


def _base_and_contact(side: Direction, z: Array, P: Array) -> tuple[BaseLine, float, Array, Array]:
    """Base line of a direction, its largest tension [N], masks of the rows in contact and of those to keep; no row is
    surely in contact without a jump at first touch. Without a base line the load is that over 0."""
    tension, touching, keep = known(side.adhesion) or 0.0, np.zeros(z.size, dtype=bool), np.ones(z.size, dtype=bool)
    if not side.begins_free:
        touching = in_contact({"delta": z, "P": P}, 0.0)
        line = BaseLine(0.0, 0.0, float(z[0]), 0, third_differences(P), 0.0, False)
        tension = max(-float(P.min()), 0.0)
        return line, tension if tension > line.least else 0.0, touching, touching.copy()
    if side.jumps or (side.segment.kind != APPROACH and tension):
        first, last = side.border
        touching[last:], keep[first + 1 : last] = True, False
    return side.base, tension, touching, keep

"""The sine in a base line: light reflected by the specimen interferes with that of the cantilever.

The reading repeats itself whenever the device has moved by half a wavelength of the light. Amplitude and phase are of
each direction; the period is of the light and common to both.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...base import FEWEST_ROWS, Array
from ...data import APPROACH, Curve, Direction, ForceCurve, examine


@dataclass(frozen=True)
class InterferenceTuning:
    """Where a sine is searched, and when it is no noise."""

    blocks: int = 2000  # choice: means of successive free rows that are transformed
    shortest: int = 6  # theory: of them in a period; their means leave sinc(1/6) = 95 % of the wave
    finer: int = 4  # theory: frequencies tried for each that the free way tells apart; sinc(1/8)^2 leaves 95 % between
    shares: tuple[float, ...] = (0.5, 1.0, 1.0)  # choice: of the free rows, in rounds; a large wave hides their end
    clear: float = 14.0  # theory: once in a thousand by chance of a thousand frequencies (Scargle, ApJ 263, 835, 1982)


TUNING = InterferenceTuning()


@dataclass(frozen=True)
class Wave:
    """``cos`` and ``sin`` [N] of 2 pi (z - at)/period over the device's position z; ``period, at`` in m."""

    period: float
    at: float
    cos: float
    sin: float

    def __call__(self, z: Array) -> Array:
        return parts(z - self.at, self.period) @ (self.cos, self.sin)


def parts(along: Array, period: float) -> Array:
    """Cosine and sine of a way ``along`` [m] over the period, (rows, 2)."""
    phase = 2 * math.pi * along / period
    return np.stack([np.cos(phase), np.sin(phase)], axis=-1)


def straightened(record: ForceCurve) -> tuple[ForceCurve, Mapping[str, Wave]]:
    """The record examined again without the sine of its base lines, and that of each direction by its kind; the record
    itself and none where no sine exceeds the noise.

    Without the wave the free rows are determined better, and by them the wave.
    """
    curve, waves = record.curve, dict[str, Wave]()
    for share in TUNING.shares:
        sides = [side for side in record.directions if side.base.rows >= FEWEST_ROWS]
        free = {side.segment.kind: _free(curve, side, share) for side in sides}
        period = _period(list(free.values())) if free else None
        if period is None:
            return examine(curve), {}
        waves = {kind: _wave(z, off, period) for kind, (z, off) in free.items()}
        record = examine(_without(curve, sides, waves))
    return record, waves


def _without(curve: Curve, directions: Sequence[Direction], waves: Mapping[str, Wave]) -> Curve:
    """The curve less its waves; the device stays where it is."""
    z, P = curve.device, curve.load.copy()
    for side in directions:
        rows = side.segment.rows
        P[rows] -= waves[side.segment.kind](z[rows])
    return replace(curve, delta=z if curve.stiffness is None else z - P / curve.stiffness, P=P)


def _free(curve: Curve, side: Direction, share: float) -> tuple[Array, Array]:
    """Positions [m] of a share of the free rows of a direction, from the far end on, and their loads over its base line
    [N], in means of some rows."""
    order, end = 1 if side.segment.kind == APPROACH else -1, round(share * side.base.rows)
    z, off = (column[side.segment.rows][::order][:end] for column in (curve.device, curve.load))
    off = off - np.polynomial.Polynomial.fit(z, off, 1)(z)
    size = max(1, z.size // TUNING.blocks)
    along, loads = (column[: z.size // size * size].reshape(-1, size).mean(axis=1) for column in (z, off))
    return along, loads


def _period(free: list[tuple[Array, Array]]) -> float | None:
    """The period that explains most, among those of which one or more lie in the free way; None where none explains
    more than chance does."""
    way, count = max(float(np.ptp(z)) for z, _ in free), max(z.size for z, _ in free)
    size, total, rows = TUNING.finer * count, 0.0, 0
    power = np.zeros(size // 2 + 1)
    for z, off in free:
        order = np.argsort(z)
        even = np.interp(np.arange(z[order[0]], z[order[-1]], way / count), z[order], off[order])
        power += 2 / even.size * np.abs(np.fft.rfft(even, size)) ** 2
        total, rows = total + float(even @ even), rows + even.size
    periods = way * TUNING.finer / np.maximum(np.arange(power.size), 1)
    power = np.where((periods <= way) & (periods >= TUNING.shortest * way / count), power, 0.0)
    best = int(np.argmax(power))
    return float(periods[best]) if power[best] > 2 * TUNING.clear * (total - power[best]) / rows else None


def _wave(z: Array, off: Array, period: float) -> Wave:
    """The wave of a period that is nearest to ``off``, a straight line apart."""
    along = z - z[0]
    design = np.column_stack([np.ones_like(z), along / np.ptp(z), parts(along, period)])
    c, s = np.linalg.lstsq(design, off, rcond=None)[0][2:]
    return Wave(period, float(z[0]), float(c), float(s))

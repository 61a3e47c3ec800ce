"""Records of retraction over time: which rows are fitted, and what the device did."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...adhesion.rate.program import Program
from ...base.arrays import Array
from ...base.errors import InputError
from ...data.measured import Curve
from ..fit.points import third_differences


@dataclass(frozen=True)
class RateRecordTuning:
    """How the rows of a retraction are told."""

    least: int = 20  # choice: rows of a record
    moving: float = 0.1  # choice: of the travel, beyond which the device surely moves back
    recovered: float = 0.2  # choice: of the pull-off force: rows of less tension behind it are taken as free
    straight: float = 1.5  # choice: scatter about a straight line over the noise, beyond which the motion is no line
    knots: int = 40  # choice: points of a motion that is no line


TUNING = RateRecordTuning()


@dataclass(frozen=True, eq=False)
class RateRecord:
    """One retraction: times ``t`` [s], load ``P`` [N], where measured radius ``a`` [m], with their standard deviations
    ``noise``; the device moves by ``base`` (t, x) but for a shift and a tilt of standard deviations ``loose`` [m]."""

    curve: Curve
    t: Array
    P: Array
    a: Array | None
    noise: dict[str, float]
    base: tuple[Array, Array]
    loose: tuple[float, float]
    stiffness: float
    rows: Array

    @property
    def tilt(self) -> tuple[float, float]:
        """Middle and half-width [s] of the times, over which the tilt grows from -1 to 1."""
        return float(self.t[0] + self.t[-1]) / 2, float(self.t[-1] - self.t[0]) / 2

    def program(self, shift: float, tilt: float) -> Program:
        """What the device did, moved by ``shift`` [m] and tilted by ``tilt`` [m] at the ends."""
        t, x = self.base
        middle, half = self.tilt
        return Program(t, x + shift + tilt * (t - middle) / half)

    def thinned(self, most: int) -> RateRecord:
        """The record by at most ``most`` of its rows, its ends among them."""
        some = np.unique(np.linspace(0, self.t.size - 1, min(most, self.t.size)).astype(int))
        a = None if self.a is None else self.a[some]
        return replace(self, t=self.t[some], P=self.P[some], a=a, rows=self.rows[some])

    @property
    def speed(self) -> float:
        """Mean speed of the device on its way back [m/s]."""
        t, x = self.base
        return float((x[0] - x[-1]) / (t[-1] - t[0]))


def rate_record(curve: Curve, segment: str | None) -> RateRecord:
    """The retraction in ``curve``: its rows of ``segment`` (default: "retract" where it names any), from the turn of
    the device to loss of contact. InputError where a column is missing or too few rows are left."""
    missing = [name for name in ("t", "delta", "P") if getattr(curve, name) is None]
    if missing:
        raise InputError(f"{curve.where}: a fit over speed needs t, delta and P, it lacks {', '.join(missing)}")
    numbers = np.arange(len(curve))
    if curve.segment is not None:
        numbers = numbers[curve.segment == (segment or "retract")]
    part = curve.rows(numbers)
    t, P, device = part.t, part.P, part.device if numbers.size else np.empty(0)
    assert t is not None
    assert P is not None
    if (np.diff(t) <= 0).any():
        row = int(numbers[int(np.flatnonzero(np.diff(t) <= 0)[0]) + 1]) + 1
        raise InputError(f"{curve.where}: time must rise from row to row, it does not in row {row}")
    chosen = _retraction(t, P, device) if t.size >= TUNING.least else np.empty(0, dtype=int)
    if chosen.size < TUNING.least:
        raise InputError(f"{curve.where}: {chosen.size} rows of a retraction, at least {TUNING.least} are needed")
    noise = {"P": third_differences(P[chosen]), "delta": third_differences(device[chosen])}
    a = None if part.a is None else part.a[chosen]
    if a is not None:
        noise["a"] = third_differences(a)
    floors = {"P": np.ptp(P[chosen]), "delta": np.ptp(device[chosen]), "a": 0.0 if a is None else np.ptp(a)}
    noise = {name: max(value, 1e-6 * float(floors[name])) for name, value in noise.items()}
    base, loose = _motion(t[chosen], device[chosen], noise["delta"])
    stiffness = np.inf if curve.stiffness is None else curve.stiffness
    return RateRecord(curve, t[chosen], P[chosen], a, noise, base, loose, float(stiffness), numbers[chosen])


def _retraction(t: Array, P: Array, device: Array) -> Array:
    """Rows from the turn of the device to loss of contact."""
    top, end = float(np.quantile(device, 0.99)), float(np.min(device))
    moved = np.flatnonzero(device > top - TUNING.moving * (top - end))
    last = int(moved[-1]) if moved.size else 0
    lowest = last + int(np.argmin(P[last:]))
    fitted = slice(last, max(lowest, last + 2))
    rate, level = np.polyfit(t[fitted] - t[last], device[fitted], 1)
    before = t[last] + (top - level) / rate if rate < 0 else t[0]
    begin = int(np.searchsorted(t, max(before, t[0])))
    free = float(np.median(P[-max(5, P.size // 50) :]))
    level_P = free if abs(free) < 0.3 * (np.max(P) - np.min(P)) else 0.0
    risen = np.flatnonzero(P[lowest:] - level_P > TUNING.recovered * (P[lowest] - level_P))
    over = lowest + int(risen[0]) if risen.size else t.size
    return np.arange(begin, over)


def _motion(t: Array, device: Array, noise: float) -> tuple[tuple[Array, Array], tuple[float, float]]:
    """The device's motion as points (t, x), and standard deviations of its shift and tilt, from noise alone."""
    middle, half = (t[0] + t[-1]) / 2, (t[-1] - t[0]) / 2
    z = (t - middle) / half
    line = np.polynomial.polynomial.polyfit(z, device, 1)
    ends = np.array([t[0], t[-1]])
    loose = noise / np.sqrt(t.size), noise / np.sqrt(np.sum((z - z.mean()) ** 2))
    residual = device - np.polynomial.polynomial.polyval(z, line)
    if np.std(residual) <= TUNING.straight * noise + 1e-9 * np.ptp(device):
        return (ends, np.polynomial.polynomial.polyval(np.array([-1.0, 1.0]), line)), loose
    knots = np.linspace(t[0], t[-1], min(TUNING.knots, t.size // 4) + 1)
    hats = np.stack([np.interp(t, knots, row) for row in np.eye(knots.size)], axis=1)
    return (knots, np.linalg.lstsq(hats, device, rcond=None)[0]), loose

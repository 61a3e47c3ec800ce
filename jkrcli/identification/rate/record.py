"""Records of retraction over time: which rows are fitted, and what the device did."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...adhesion import Program
from ...base import FEWEST_ROWS, SAME, Array, InputError, evenly
from ...data import Curve
from ..fit import third_differences
from ..motion import check_over_time, check_rising, noise_of, through


@dataclass(frozen=True)
class RateRecordTuning:
    """Limits of the rows of a retraction."""

    moving: float = 0.1  # choice: of the travel, beyond which the device surely moves back
    recovered: float = 0.2  # choice: of the pull-off force: rows of less tension behind it are taken as free
    still: float = 3.0  # theory: standard deviations above the highest rows, where the way back would begin: it waited
    highest: float = 2.33  # theory: standard deviations by which 1 % of rows at rest lie higher
    straight: float = 1.5  # choice: scatter about a straight line over the noise, beyond which the motion is no line
    knots: int = 40  # choice: points of a motion that is no line


TUNING = RateRecordTuning()


@dataclass(frozen=True, eq=False)
class RateRecord:
    """One retraction: times ``t`` [s], load ``P`` [N], where measured radius ``a`` [m]; their standard deviations from
    row to row, ``noise``, and those by which they are weighed, ``sigma``. The device moves by ``base`` (t, x) but for a
    shift and a tilt of standard deviations ``loose`` [m]; ``rows`` of the curve."""

    curve: Curve
    t: Array
    P: Array
    a: Array | None
    noise: dict[str, float]
    sigma: dict[str, float]
    base: tuple[Array, Array]
    loose: tuple[float, float]
    stiffness: float
    rows: Array

    @property
    def columns(self) -> dict[str, Array]:
        """What was measured of load and radius, by name."""
        return {"P": self.P} | ({} if self.a is None else {"a": self.a})

    @property
    def tilt(self) -> tuple[float, float]:
        """Middle and half-width [s] of the times, over which the tilt grows from -1 to 1."""
        return float(self.t[0] + self.t[-1]) / 2, float(self.t[-1] - self.t[0]) / 2

    def program(self, shift: float, tilt: float, onwards: bool = False) -> Program:
        """What the device did, moved by ``shift`` [m] and tilted by ``tilt`` [m] at the ends; ``onwards``: moving on as
        at the last row for as long as there is contact."""
        t, x = self.base
        middle, half = self.tilt
        moved = x + shift + tilt * (t - middle) / half
        rate = float((moved[-1] - moved[-2]) / (t[-1] - t[-2]))
        return Program(t, moved, rate if onwards and rate < 0 else None)

    def thinned(self, most: int) -> RateRecord:
        """The record by at most ``most`` of its rows, its ends among them."""
        some = evenly(self.t.size, most)
        a = None if self.a is None else self.a[some]
        return replace(self, t=self.t[some], P=self.P[some], a=a, rows=self.rows[some])

    @property
    def speed(self) -> float:
        """Mean speed of the device on its way back [m/s]."""
        t, x = self.base
        return float((x[0] - x[-1]) / (t[-1] - t[0]))


def rate_record(curve: Curve, segment: str | None, lost: float | None = None) -> RateRecord:
    """The retraction in ``curve``: its rows of ``segment`` (default: "retract" where it names any), from the turn of
    the device until the time ``lost`` [s], None: that at which the readings show the contact to be lost. InputError
    where a column is missing or too few rows are left."""
    check_over_time(curve, "a fit over speed")
    if segment not in (None, "retract"):
        raise InputError(f"{curve.where}: a fit over speed takes the retraction alone: leave --segment {segment} out")
    if curve.segment is None and segment is not None:
        curve.only(segment)  # refuses
    numbers = np.arange(len(curve)) if curve.segment is None else np.flatnonzero(curve.segment == "retract")
    part = curve.rows(numbers)
    t, P, device = part.time, part.load, part.device
    check_rising(curve.where, t, numbers)
    chosen = _retraction(t, P, device, lost) if t.size >= FEWEST_ROWS else np.empty(0, dtype=int)
    if chosen.size < FEWEST_ROWS:
        raise InputError(f"{curve.where}: {chosen.size} rows of a retraction, at least {FEWEST_ROWS} are needed")
    base, loose = _motion(t[chosen], device[chosen])
    stiffness = np.inf if curve.stiffness is None else float(curve.stiffness)
    a = None if part.a is None else part.a[chosen]
    record = RateRecord(curve, t[chosen], P[chosen], a, {}, {}, base, loose, stiffness, numbers[chosen])
    noise = {name: noise_of(column) for name, column in record.columns.items()}
    return replace(record, noise=noise, sigma=noise)


def _retraction(t: Array, P: Array, device: Array, lost: float | None) -> Array:
    """Rows from the turn of the device to loss of contact; none where the device does not move back."""
    top, end = float(np.quantile(device, 0.99)), float(np.min(device))
    moved = np.flatnonzero(device > top - TUNING.moving * (top - end))
    last = int(moved[-1]) if moved.size else 0
    if last + 2 > t.size:
        return np.empty(0, dtype=int)
    lowest = last + int(np.argmin(P[last:]))
    fitted = slice(last, max(lowest, last + 2))
    since, way = t[fitted] - t[last], device[fitted]  # of two rows at least, whose times rise
    rate = float((since - since.mean()) @ way / np.sum((since - since.mean()) ** 2))
    level = float(way.mean() - rate * since.mean())
    noise = third_differences(device)
    begin = 0
    if rate < 0 and level + rate * (t[0] - t[last]) > top + TUNING.still * noise:
        begin = int(np.searchsorted(t, t[last] + (top - TUNING.highest * noise - level) / rate))
    over = _over(P, lowest) if lost is None else max(int(np.searchsorted(t, lost)), begin + FEWEST_ROWS)
    return np.arange(begin, min(over, t.size))


def _over(P: Array, lowest: int) -> int:
    """The row that shows contact to be lost."""
    free = float(np.median(P[-max(5, P.size // 50) :]))
    level = free if abs(free) < 0.3 * (np.max(P) - np.min(P)) else 0.0
    return recovered(P - level, lowest)


def recovered(P: Array, lowest: int) -> int:
    """The row behind the ``lowest`` where the tension has all but gone; the number of rows where it never has."""
    risen = np.flatnonzero(P[lowest:] > TUNING.recovered * P[lowest])
    return lowest + int(risen[0]) if risen.size else P.size


def _motion(t: Array, device: Array) -> tuple[tuple[Array, Array], tuple[float, float]]:
    """The device's motion as points (t, x), and standard deviations of its shift and tilt, from noise alone: that of
    the readings about the motion."""
    middle, half = (t[0] + t[-1]) / 2, (t[-1] - t[0]) / 2
    z, least = (t - middle) / half, SAME * float(np.ptp(device))
    line = np.polynomial.Polynomial(np.polynomial.polynomial.polyfit(z, device, 1))
    base, noise = (t[[0, -1]], line(np.array([-1.0, 1.0]))), _rms(device - line(z), 2)
    if noise > TUNING.straight * third_differences(device) + least:
        knots = np.linspace(t[0], t[-1], min(TUNING.knots, t.size // 4) + 1)
        places, pieces = through(t, device, knots)
        base, noise = (knots, places), _rms(device - pieces, knots.size)
    noise = max(noise, least)
    return base, (noise / np.sqrt(t.size), noise / np.sqrt(np.sum((z - z.mean()) ** 2)))


def _rms(residuals: Array, parameters: int) -> float:
    """Standard deviation of the readings that ``residuals`` are left of."""
    return float(np.sqrt(np.sum(residuals**2) / (residuals.size - parameters)))

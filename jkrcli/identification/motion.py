"""What a device did, from its readings: straight pieces between corners."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from ..base import MOST_STEPS, SAME, Array, InputError
from ..data import Curve
from .fit import third_differences


@dataclass(frozen=True)
class MotionTuning:
    """Limits of the search for corners."""

    # tuned on relaxing records, by `make constants`: corners, ends among them; of more no pieces are straight
    most: int = 9
    worth: float = 30.0  # theory: of the sum of squares over the noise's; chance gives 20 in one of 1e3 records of 1e4
    tried: int = 64  # choice: rows of a piece where a corner is begun; it is then moved
    straight: float = 1.1  # choice: scatter over the noise up to which no corner is missing


TUNING = MotionTuning()


def noise_of(column: Array) -> float:
    """Standard deviation of the readings of a column from row to row, not below what is the same."""
    return max(third_differences(column), SAME * float(np.ptp(column)))


def noise_about(off: Array, column: Array, taken: float, unit: float = 1.0) -> float:
    """That of the readings of a column which are so many units ``off`` a model; unknowns have ``taken`` a share of
    their squares."""
    return max(math.sqrt(float(np.mean(off**2)) / (1 - taken)) * unit, SAME * float(np.ptp(column)))


def check_over_time(curve: Curve, what: str) -> None:
    """Refuse a curve that holds no readings over time, ``what`` needs them."""
    if missing := [name for name in ("t", "delta", "P") if name not in curve.measured]:
        raise InputError(f"{curve.where}: {what} needs t, delta and P, it lacks {', '.join(missing)}")


def check_rising(where: str, t: Array, rows: Array) -> None:
    """Refuse times that do not rise, by the numbers of their ``rows``."""
    if (falls := np.flatnonzero(np.diff(t) <= 0)).size:
        row = int(rows[falls[0] + 1]) + 1
        raise InputError(f"{where}: time must rise from row to row, it does not in row {row}")


def corners(t: Array, x: Array, noise: float) -> tuple[Array, Array]:
    """The times and places of the corners, ends among them, of straight pieces that leave of ``x`` at rising times
    ``t`` no more than ``noise``; as many as are worth it."""
    knots, sums = [0, t.size - 1], _Sums.of(t, x)
    while len(knots) < TUNING.most:
        rest = x - through(t, x, t[knots])[1]
        if np.sqrt(np.mean(rest**2)) < TUNING.straight * noise:
            break
        better = _settled(sums, sorted([*knots, _next(rest, knots)]))
        if sums.left(knots) - sums.left(better) < TUNING.worth * noise**2:
            break
        knots = better
    times = _between_rows(t, x, knots)
    return times, through(t, x, times)[0]


def _between_rows(t: Array, x: Array, knots: list[int]) -> Array:
    """The times of the corners; for two in rows one after the other that where the straight pieces before and behind
    them meet, if they do so between these rows: a device turns there, and goes beyond both."""
    times, places = t[knots], through(t, x, t[knots])[0]
    slopes = np.diff(places) / np.diff(times)
    for i in range(len(knots) - 3, 0, -1):
        if knots[i + 1] == knots[i] + 1 and slopes[i - 1] != slopes[i + 1]:
            ahead = (places[i + 1] - places[i] - slopes[i + 1] * (times[i + 1] - times[i])) / (
                slopes[i - 1] - slopes[i + 1]
            )
            if 0 <= ahead <= times[i + 1] - times[i]:
                times = np.concatenate([times[:i], [times[i] + ahead], times[i + 2 :]])
                places = through(t, x, times)[0]
                slopes = np.diff(places) / np.diff(times)
    return times


def through(t: Array, x: Array, knots: Array) -> tuple[Array, Array]:
    """Places at the times ``knots`` by least squares, and the straight pieces through them at all times."""
    hats = np.stack([np.interp(t, knots, row) for row in np.eye(knots.size)], axis=1)
    places = np.linalg.lstsq(hats, x, rcond=None)[0]
    return places, hats @ places


@dataclass(frozen=True, eq=False)
class _Sums:
    """Sums of 1, t, t^2, x, t x and x^2 over the rows before each, ``upto`` (rows + 1, 6), of columns about their
    means: what is left by any straight pieces follows from them."""

    t: Array
    upto: Array

    @classmethod
    def of(cls, t: Array, x: Array) -> _Sums:
        t, x = (t - t.mean()) / np.ptp(t), x - x.mean()
        rows = np.stack([np.ones_like(t), t, t**2, x, t * x, x**2], axis=1)
        return cls(t, np.concatenate([np.zeros((1, 6)), np.cumsum(rows, axis=0)]))

    def left(self, knots: list[int]) -> float:
        """The least sum of squares about straight pieces between ``knots``."""
        first, last = np.array(knots[:-1]), np.array(knots[1:])
        a, h = self.t[first], self.t[last] - self.t[first]
        last[-1] += 1
        n, t, tt, x, tx, xx = (self.upto[last] - self.upto[first]).T
        u, uu, ux = (t - n * a) / h, (tt - 2 * a * t + n * a**2) / h**2, (tx - a * x) / h  # of u = (t - a)/h
        ends, both, right = np.zeros(len(knots)), u - uu, np.zeros(len(knots))
        ends[:-1], right[:-1] = n - 2 * u + uu, x - ux
        ends[1:] += uu
        right[1:] += ux
        matrix = np.diag(ends) + np.diag(both, 1) + np.diag(both, -1)
        return float(np.sum(xx) - right @ np.linalg.solve(matrix, right))


def _next(rest: Array, knots: list[int]) -> int:
    """The row of a new corner: in the piece that leaves most, where a hat stands out most in what is left."""
    squares = [float(np.sum(rest[a : b + 1] ** 2)) if b - a > 1 else -1.0 for a, b in itertools.pairwise(knots)]
    a, b = knots[(i := int(np.argmax(squares)))], knots[i + 1]
    tops, rows = np.unique(np.linspace(a + 1, b - 1, min(b - a - 1, TUNING.tried)).astype(int)), np.arange(a, b + 1)
    sums = [abs(float(np.sum(rest[a : b + 1] * np.interp(rows, [a, top, b], [0, 1, 0])))) for top in tops]
    return int(tops[int(np.argmax(sums))])


def _settled(sums: _Sums, knots: list[int]) -> list[int]:
    """The knots moved, one after the other, each to the row between its neighbours that leaves least, until none
    moves."""
    for _ in range(MOST_STEPS):
        before = list(knots)
        for i in range(1, len(knots) - 1):
            width = max((knots[i + 1] - knots[i - 1]) // 8, 1)
            while width:
                tried = [k for k in (knots[i] - width, knots[i], knots[i] + width) if knots[i - 1] < k < knots[i + 1]]
                best = min(tried, key=lambda k: sums.left([*knots[:i], k, *knots[i + 1 :]]))
                width = width if best != knots[i] else width // 2
                knots[i] = best
        if knots == before:
            break
    return knots

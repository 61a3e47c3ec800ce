"""The w-free functions of a series between its rows, such that the energy of a contact is a function of its state.

Through the rows go cubics of log delta_H over log(a - a0), and a quintic of log S over log a through S, S' and S''; S'
is its slope. In each interval delta_H has besides a multiple of s^2 (1 - s)^2, which vanishes with its slope at the
rows and makes int S d(delta_H) what P_H gains from row to row; P_H is that integral. Power laws (Hertz) are exact with
any number of rows. All of it is tabulated once, so finely that cubics between the nodes conserve energy to about 1e-10.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..base import Array, PiecewiseCubic, PiecewiseQuintic, composite_gauss, spline_slopes


@dataclass(frozen=True)
class BetweenTuning:
    """How finely the functions are tabulated."""

    spacing: float = 0.01  # theory: of log(a - a0); cubics between leave a share of 0.01^4/384 of the energies
    close: float = 1e-3  # theory: of log a; S' and S'' tell S to the fourth power of it, better than S is known
    # Of P_H, what its rounding leaves of a gain: just beyond a flat end S hardly grows, and no hump can make it up
    rounding: float = 1e-13  # theory: 450 times the machine epsilon, for the formula of a load


TUNING = BetweenTuning()


class Logs(NamedTuple):
    """``columns``: log of (delta_H, P_H) over log(a - a0); ``slopes``: log of (S, S') over log a; both at the same
    radii."""

    columns: PiecewiseCubic
    slopes: PiecewiseCubic


@dataclass(frozen=True, eq=False)
class Rows:
    """The functions at radii ``a`` [m], in SI, all (n,); ``rates`` (n, 2): slopes of log delta_H and of log S' over the
    logarithms of ``Logs``, NaN where they are not known. ``a0``: radius of first contact [m]. ``bends``: numbers of the
    rows at which delta_H is not smooth: splines of it end there. ``derived``: whether S' is the derivative of S."""

    a: Array
    a0: float
    delta: Array
    P: Array
    S: Array
    dS: Array
    rates: Array
    bends: Array = field(default_factory=lambda: np.empty(0, int))
    derived: bool = True

    @cached_property
    def logs(self) -> Logs:
        """Cubics through the rows alone: slopes that are not known are those of splines, that of log P_H is given by
        dP_H = S d(delta_H), that of log S is a S'/S where S' is the derivative of S."""
        x, z = np.log(self.a), np.log(self.a - self.a0)
        rates = self.rates
        if np.isnan(rates).any():
            fitted = np.stack([self._pieces(z, np.log(self.delta)), spline_slopes(x, np.log(self.dS))], 1)
            rates = np.where(np.isnan(rates), fitted, rates)
        rate, rate_dS = rates.T
        rate = _rising(z, np.log(self.delta), rate)
        by_P = _rising(z, np.log(self.P), self.S * self.delta / self.P * rate)
        by_S = self.a * self.dS / self.S if self.derived else spline_slopes(x, np.log(self.S))
        return Logs(
            PiecewiseCubic(z, np.log(np.stack([self.delta, self.P], 1)), np.stack([rate, by_P], 1)),
            PiecewiseCubic(x, np.log(np.stack([self.S, self.dS], 1)), np.stack([by_S, rate_dS], 1)),
        )

    def _pieces(self, x: Array, y: Array) -> Array:
        """Slopes of splines through ``y`` that end at the bends; there that of the piece before, where y is smooth."""
        slopes = np.empty_like(y)
        for lo, hi in itertools.pairwise([y.size - 1, *self.bends[::-1].tolist(), 0]):
            slopes[hi : lo + 1] = spline_slopes(x[hi : lo + 1], y[hi : lo + 1])
        return slopes


def _rising(x: Array, y: Array, slopes: Array) -> Array:
    """The ``slopes`` at the points, none larger than three times the chord on either side, where ``y`` rises there:
    steeper ones make a cubic fall in between (Fritsch and Carlson, SIAM J. Numer. Anal. 17 (1980) 238)."""
    chord = np.diff(y) / np.diff(x)
    most = 3 * np.minimum(np.append(chord[0], chord), np.append(chord, chord[-1]))
    return np.where(most > 0, np.minimum(slopes, most), slopes)


def between(rows: Rows) -> Logs:
    """The functions between the ``rows``; those through the rows alone where the columns contradict each other so much
    that delta_H or S would have to fall in between, or S' is not the derivative of S."""
    plain = rows.logs
    if not rows.derived:
        return plain

    # Places z = log(a - a0) close enough to each other, the rows among them, each in an interval i of the rows.
    z, widths = plain.columns.x, np.diff(plain.columns.x)
    counts = np.maximum(np.ceil(widths / TUNING.spacing).astype(int), 1)
    first = np.repeat(np.arange(counts.size), counts)
    inner = np.arange(first.size) - np.repeat(np.cumsum(counts) - counts, counts)
    places, i = np.append(z[first] + widths[first] * inner / counts[first], z[-1]), np.append(first, first[-1])

    # The quintic of log S over log a, through its slope a S'/S and the slope of that.
    rate = rows.a * rows.dS / rows.S
    bend = rate * (1 + plain.slopes(plain.slopes.x, 1)[:, 1] - rate)
    log_S = PiecewiseQuintic(plain.slopes.x, np.log(rows.S), rate, bend, TUNING.close)

    def cubic(z: Array) -> tuple[Array, Array]:
        """exp of the cubic of log delta_H, and its slope over z."""
        value = np.exp(plain.columns(z)[..., 0])
        return value, value * plain.columns(z, 1)[..., 0]

    def hump(at: Array, i: Array) -> tuple[Array, Array]:
        """s^2 (1 - s)^2 in the intervals ``i`` of the rows, and its slope over z."""
        s = (at - z[i]) / widths[i]
        return (s * (1 - s)) ** 2, 2 * s * (1 - s) * (1 - 2 * s) / widths[i]

    # int S d(delta_H) from place to place, of the cubic and of one hump, and in each interval as many humps as make up
    # what P_H gains there; none where the cubic misses round-off alone.
    at, weights = composite_gauss(places)
    weights = weights * np.exp(log_S(np.log(rows.a0 + np.exp(at))))
    gained, by_hump = (np.sum(weights * slope, 1) for _, slope in (cubic(at), hump(at, first[:, None])))
    gain = np.diff(rows.P)
    missed = gain - np.bincount(first, gained)
    humps = np.where(np.abs(missed) > TUNING.rounding * rows.P[1:], missed / np.bincount(first, by_hump), 0.0)
    gains = gained + humps[first] * by_hump
    gains *= (gain / np.bincount(first, gains))[first]  # round-off
    P = rows.P[0] + np.append(0.0, np.cumsum(gains))

    # delta_H, S and S' at the places, with their slopes.
    delta, by_z = (value + humps[i] * added for value, added in zip(cubic(places), hump(places, i), strict=True))
    x = np.log(rows.a0 + np.exp(places))
    log_S_here, rate, bend = (log_S(x, order) for order in range(3))
    S = np.exp(log_S_here)
    if not all((values > 0).all() for values in (by_z, rate, delta, P)):
        return plain  # delta_H or S falls somewhere, or a load is none
    log_dS = log_S_here + np.log(rate) - x
    return Logs(
        PiecewiseCubic(places, np.log(np.stack([delta, P], 1)), np.stack([by_z / delta, S / P * by_z], 1)),
        PiecewiseCubic(x, np.stack([log_S_here, log_dS], 1), np.stack([rate, rate + bend / rate - 1], 1)),
    )

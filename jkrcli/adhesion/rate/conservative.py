"""The functions of a series between its rows such that the energy of a contact is a function of its state.

``Nonadhesive`` interpolates its four functions each for itself: between the rows P_H' is S delta_H', and S' the slope
of S, only as nearly as the interpolation is exact, and a contact followed over time does the work of the difference.
Here log S is a quintic of log a through S, S' and S'' of the rows, and S' its slope; delta_H is the cubic of before
and, in each interval, a multiple of s^2 (1 - s)^2, which vanishes with its slope at the rows and makes int S d(delta_H)
what P_H gains from row to row; P_H is that integral.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import BPoly

from ...base.arrays import Array
from ..curve import Nonadhesive, composite_gauss


@dataclass(frozen=True)
class ConservativeTuning:
    """How finely the functions are tabulated."""

    spacing: float = 0.01  # theory: of log(a - a0); cubics between leave a share of 0.01^4/384 of the energies


TUNING = ConservativeTuning()


@dataclass(frozen=True, eq=False)
class Conservative(Nonadhesive):
    """The functions of a series at so many radii that the cubics between them conserve energy to about 1e-10."""


def conservative(body: Nonadhesive) -> Nonadhesive:
    """``body`` between its rows by functions that belong to one energy; ``body`` itself where its columns contradict
    each other so much that delta_H or S would have to fall in between."""
    if isinstance(body, Conservative):
        return body
    between = _Between(body.knots)
    z, first = between.table
    a, at_rows = between.rows.series.a0 + np.exp(z), np.searchsorted(first, np.arange(between.z.size))
    delta, by_z = between.delta(z, np.append(first, first[-1]))
    log_S, rate, bend = (between.log_S(np.log(a), order) for order in range(3))
    if not ((by_z > 0).all() and (rate > 0).all()):
        return body
    S = np.exp(log_S)
    columns = np.stack([a, delta, between.loads, S, S * rate / a])
    columns[:, at_rows] = np.stack([between.rows.a, *between.rows.points[:4]])
    a, delta, P, S, dS = columns
    series = replace(between.rows.series, a=a, delta=delta, P=P, S=S, dS=dS, errors={})
    slopes = replace(between.rows.slopes, S=S, dS=dS, delta=None, P=None, covariance=None, joint=None)
    return Conservative(series, slopes, np.stack([by_z / delta, rate + bend / rate - 1], 1))


@dataclass(frozen=True, eq=False)
class _Between:
    """The functions between the ``rows``, at places z = log(a - a0)."""

    rows: Nonadhesive

    @cached_property
    def z(self) -> Array:
        return np.log(self.rows.a - self.rows.series.a0)

    @cached_property
    def table(self) -> tuple[Array, Array]:
        """Places close enough to each other, the rows among them, and the interval of the rows that begins or lies
        before each but the last."""
        widths = np.diff(self.z)
        counts = np.maximum(np.ceil(widths / TUNING.spacing).astype(int), 1)
        first = np.repeat(np.arange(counts.size), counts)
        inner = np.arange(first.size) - np.repeat(np.cumsum(counts) - counts, counts)
        return np.append(self.z[first] + widths[first] * inner / counts[first], self.z[-1]), first

    @cached_property
    def log_S(self) -> BPoly:
        """log S over log a, with its slope a S'/S and the slope of that."""
        _, _, S, dS, _ = self.rows.points
        x = np.log(self.rows.a)
        rate = self.rows.a * dS / S
        bend = rate * (1 + self.rows.logs[1](x, 1)[:, 1] - rate)
        return BPoly.from_derivatives(x, np.stack([np.log(S), rate, bend], 1))

    @cached_property
    def gained(self) -> tuple[Array, Array]:
        """int S d(delta_H) between places of the table, of the cubic and of one s^2 (1 - s)^2, (n,) both."""
        z, first = self.table
        at, weights = composite_gauss(z)
        S = np.exp(self.log_S(np.log(self.rows.series.a0 + np.exp(at))))
        _, cubic = self.cubic(at)
        _, hump = self.hump(at, first[:, None])
        return np.sum(weights * S * cubic, 1), np.sum(weights * S * hump, 1)

    @cached_property
    def added(self) -> Array:
        """The multiple [m] of s^2 (1 - s)^2 in each interval of the rows."""
        cubic, hump = (np.bincount(self.table[1], values) for values in self.gained)
        return (np.diff(self.rows.points.P_H) - cubic) / hump

    @property
    def loads(self) -> Array:
        """P_H [N] at the table."""
        cubic, hump = self.gained
        gains = cubic + self.added[self.table[1]] * hump
        return self.rows.points.P_H[0] + np.append(0.0, np.cumsum(gains))

    def delta(self, z: Array, i: Array) -> tuple[Array, Array]:
        """delta_H [m] and its slope over z at places in the intervals ``i``."""
        (cubic, rate), (hump, by_z) = self.cubic(z), self.hump(z, i)
        return cubic + self.added[i] * hump, rate + self.added[i] * by_z

    def cubic(self, z: Array) -> tuple[Array, Array]:
        """exp of the cubic of log delta_H, and its slope over z."""
        log_delta = self.rows.logs[0]
        value = np.exp(log_delta(z)[..., 0])
        return value, value * log_delta(z, 1)[..., 0]

    def hump(self, z: Array, i: Array) -> tuple[Array, Array]:
        """s^2 (1 - s)^2 in the intervals ``i`` of the rows, and its slope over z."""
        width = np.diff(self.z)[i]
        s = (z - self.z[i]) / width
        return (s * (1 - s)) ** 2, 2 * s * (1 - s) * (1 - 2 * s) / width

"""A body's adhesive contact for every work of adhesion, solved for the contact radius (Eq. 13)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...adhesion.curve import ROUND_OFF, AdhesiveCurve, transform
from ...adhesion.slopes.result import Slopes
from ...series import Array, Series

STEPS, CONVERGED = 60, 1e-13  # halvings at worst; relative step
# What a measured row is: usable, or why it is not.
OK, NONE, BELOW, ABOVE = "ok", "no adhesion", "below the series", "above the series"


@dataclass(frozen=True, eq=False)
class Body:
    """What Eq. 13 needs of a body at any contact radius of its series, by the adhesive curves' one evaluation rule.

    delta = delta_H - sqrt(w/w1) t and P = P_H - sqrt(w/w1) S t, with the shift t at the work of adhesion ``w1``.
    """

    series: Series
    slopes: Slopes

    @cached_property
    def w1(self) -> float:
        """A work of adhesion [J/m^2] whose shift t is about delta_H."""
        series = self.series
        return float(np.median(series.delta**2 * self.slopes.dS / series.a)) / (4 * math.pi)

    @cached_property
    def _curves(self) -> tuple[AdhesiveCurve, AdhesiveCurve]:
        """At w1 and at 0; where the slopes' fit has its own delta_H and P_H, at w1 and 4 w1, which hold the same."""
        other = 0.0 if self.slopes.delta is None else 4 * self.w1
        return transform(self.series, self.slopes, self.w1), transform(self.series, self.slopes, other)

    def at(self, a: Array) -> Array:
        """delta_H [m], P_H [N], t [m] and S t [N] at the radii ``a`` [m]: shape (4, n)."""
        first, other = (np.stack(curve.at(a)) for curve in self._curves)
        return self._parts(first, other)

    def rates(self, a: Array) -> Array:
        """The derivatives of the same by a."""
        first, other = (np.stack(curve.rates(a)) for curve in self._curves)
        return self._parts(first, other)

    def _parts(self, first: Array, other: Array) -> Array:
        """Linear in the root of w: nonadhesive part and factor of the root."""
        nonadhesive = other if self.slopes.delta is None else 2 * first - other
        return np.concatenate([nonadhesive, nonadhesive - first])

    def covariance(self, a: Array) -> Array | None:
        """Covariance (n, 4, 4) of (delta_H, P_H, S, S') at the radii ``a``, linear between the series' points."""
        held = self.slopes.covariance
        if held is None:
            return None
        entries = held.reshape(len(self.series), 16).T
        return np.stack([np.interp(a, self.series.a, entry) for entry in entries], axis=1).reshape(-1, 4, 4)

    def radius(self, delta: Array, P: Array) -> tuple[Array, Array]:
        """Contact radius [m] at each displacement [m] and load [N], and the state of each row (radius 0 where not OK).

        The radius solves F(a) = P_H - P - S (delta_H - delta) = 0. As P_H' = S delta_H', F' = -S' (delta_H - delta): F
        rises up to the nonadhesive contact at ``delta`` and falls beyond, where delta_H > delta. So there is one
        adhesive radius or none: one, if the load is below the nonadhesive load at the same displacement.
        """
        nodes = self.series.a
        before, last = self._last_positive(delta, P)
        end = nodes.size - 1
        low, high = nodes[np.maximum(last, 0)].copy(), nodes[np.minimum(last + 1, end)]
        top = (last == before) & (0 <= before) & (before < end)  # F may rise above 0 between two nodes
        low[top] = _root(lambda a: (delta[top] - self.at(a)[0], self.rates(a)[0]), low[top], high[top])
        none = top & (self._excess(low, delta, P)[0] < 0)
        below, above = last < 0, last == end
        for out, rows, node in ((below, below.copy(), nodes[0]), (above, above & (before < end), nodes[-1])):
            excess, fall = self._excess(np.full(rows.sum(), node), delta[rows], P[rows])
            out[rows] = np.abs(excess) > ROUND_OFF * node * fall
        state = np.select([none, below, above], [NONE, BELOW, ABOVE], OK)
        a = low  # the very ends, but for round-off
        between = (state == OK) & (0 <= last) & (last < end)
        a[between] = _root(lambda a: self._excess(a, delta[between], P[between]), low[between], high[between])
        return np.where(state == OK, a, 0.0), state

    @cached_property
    def _nodes(self) -> Array:
        """delta_H, P_H and S at the radii of the series."""
        delta_H, P_H, t, T = self.at(self.series.a)
        return np.stack([delta_H, P_H, T / t])

    def _last_positive(self, delta: Array, P: Array) -> tuple[Array, Array]:
        """Of the nodes of the series the last with delta_H <= ``delta``, and the last with F > 0 beyond that, or that
        one (-1: none): by bisection, as F falls there."""
        delta_H, P_H, S = self._nodes
        before = np.searchsorted(delta_H, delta, side="right") - 1
        low, high = before, np.full(delta.size, delta_H.size)
        while (high - low > 1).any():
            middle = np.maximum((low + high) // 2, 0)
            positive = P_H[middle] - P - S[middle] * (delta_H[middle] - delta) > 0
            open_ = high - low > 1
            low, high = np.where(open_ & positive, middle, low), np.where(open_ & ~positive, middle, high)
        return before, low

    def _excess(self, a: Array, delta: Array, P: Array) -> tuple[Array, Array]:
        """F(a) [N] and -F'(a) [N/m]."""
        delta_H, P_H, t, T = self.at(a)
        dS = 4 * math.pi * self.w1 * a / t**2
        return P_H - P - T / t * (delta_H - delta), dS * (delta_H - delta)


def _root(falling: Callable[[Array], tuple[Array, Array]], low: Array, high: Array) -> Array:
    """The root of a falling function in each bracket: Newton's method, halving where that would leave the bracket.

    ``falling``: the function and minus its derivative.
    """
    a = (low + high) / 2
    for _ in range(STEPS):
        value, fall = falling(a)
        low, high = np.where(value > 0, a, low), np.where(value > 0, high, a)
        step = np.divide(value, fall, out=np.full_like(a, np.inf), where=fall > 0)
        new = np.where((a + step >= low) & (a + step <= high), a + step, (low + high) / 2)
        done = np.abs(new - a) <= CONVERGED * a
        a = new
        if done.all():
            break
    return a

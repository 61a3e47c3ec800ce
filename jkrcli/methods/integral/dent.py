"""A profile with a dent: what stands for F in the contact equation where a body keeps a dent that relaxes.

In Abel's space the dent is a function of one place x, as F is. It is known at points, close to each other where the
edge of a contact passes, and linear between them; its integrals with the weights of the contact equation are exact.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...base.numerics import Array
from .fredholm import LegendrePanels, angle


@dataclass(frozen=True, eq=False)
class DentPoints:
    """The points ``x`` [m] from 0 to the end of the panels of ``basis``, whose edges are among them."""

    basis: LegendrePanels
    x: Array

    @classmethod
    def spaced(cls, basis: LegendrePanels, spacing: float, kinks: Array) -> DentPoints:
        """Points no farther than ``spacing`` [m] from each other, ``kinks`` [m] of the indenter's F among them."""
        edges = basis.panels.edges
        cuts = np.unique([*edges, *kinks[(kinks > 0) & (kinks < edges[-1])]])
        pairs = itertools.pairwise(cuts.tolist())
        parts = [np.linspace(a, b, math.ceil((b - a) / spacing) + 1) for a, b in pairs]
        return cls(basis, np.unique(np.concatenate(parts)))

    @cached_property
    def panels(self) -> Array:
        """The panel of each interval between points."""
        return self.basis.panel_of((self.x[:-1] + self.x[1:]) / 2)

    @cached_property
    def first(self) -> Array:
        """The first interval of each panel, and their number."""
        return np.searchsorted(self.panels, np.arange(self.basis.count + 1))

    @cached_property
    def halves(self) -> tuple[Array, Array]:
        """The polynomials at both ends of each interval, times half its width, (intervals, order)."""
        half = np.diff(self.x)[:, None] / 2
        return tuple(half * self.basis.local(x, self.panels) for x in (self.x[:-1], self.x[1:]))  # type: ignore[return-value]

    @cached_property
    def _values(self) -> tuple[Array, Array]:
        panel = self.basis.panel_of(self.x)
        return panel, self.basis.local(self.x, panel)

    def sums(self, coefficients: Array) -> Array:
        """The sum of polynomials with ``coefficients`` (size,) at all points."""
        panel, values = self._values
        return np.einsum("ni,ni->n", values, coefficients.reshape(-1, self.basis.order)[panel])

    def integral(self, values: Array) -> float:
        """Integral of ``values`` at the points over all of them."""
        return float(np.diff(self.x) @ (values[1:] + values[:-1])) / 2


@dataclass(frozen=True, eq=False)
class DentedProfile:
    """The function with the ``values`` [m] at ``points``, in place of F: see ``AbelMoments``."""

    points: DentPoints
    values: Array

    def F(self, x: Array) -> Array:
        """The function [m] at the places ``x`` [m]."""
        return np.interp(x, self.points.x, self.values)

    @cached_property
    def _sums(self) -> Array:
        """Integrals of the polynomials of each one's panel times the function up to the points, (points, order)."""
        left, right = self.points.halves
        steps = left * self.values[:-1, None] + right * self.values[1:, None]
        return np.vstack([np.zeros(steps.shape[1]), np.cumsum(steps, axis=0)])

    def moments(self, a: Array) -> Array:
        """Integrals int_0^a b F of all polynomials, (a.size, size)."""
        points, basis, sums = self.points, self.points.basis, self._sums
        i = np.clip(np.searchsorted(points.x, a, side="right") - 1, 0, points.panels.size - 1)
        panel, begin = points.panels[i], points.x[i]
        ends = [basis.local(x, panel) * F[:, None] for x, F in ((begin, self.values[i]), (a, self.F(a)))]
        whole = sums[points.first[1:]] - sums[points.first[:-1]]
        total = np.where(np.arange(basis.count)[:, None] < panel[:, None, None], whole, 0.0)
        last = sums[i] - sums[points.first[panel]] + (a - begin)[:, None] / 2 * (ends[0] + ends[1])
        total[np.arange(a.size), panel] = last
        return total.reshape(a.size, basis.size)

    def integral(self, moments: Array) -> Array:
        """int_0^a F [m^2] from the ``moments``."""
        basis = self.points.basis
        return moments.reshape(-1, basis.count, basis.order)[:, :, 0] @ np.sqrt(np.diff(basis.panels.edges))

    def arcs(self, a: Array, b: Array) -> Array:
        """int_a^c F(x)/sqrt(c^2 - x^2) dx [m] for c = a + b."""
        return np.array([self._arc(float(low), float(low + wide), _over_root) for low, wide in zip(a, b, strict=True)])

    def opened(self, a: float, c: float) -> float:
        """int_a^c F(x) sqrt(c^2 - x^2) dx [m^3]."""
        return self._arc(a, c, _times_root)

    def _arc(self, a: float, c: float, integrals: Callable[[Array, float], tuple[Array, Array]]) -> float:
        """Integral from ``a`` to ``c`` with a weight, of which the ``integrals`` from x to c are known."""
        x = self.points.x
        inside = slice(int(np.searchsorted(x, a, side="right")), int(np.searchsorted(x, c, side="left")))
        low, high = np.interp((a, c), x, self.values)
        places = np.concatenate([[a], x[inside], [c]])
        values = np.concatenate([[low], self.values[inside], [high]])
        rates = (values[1:] - values[:-1]) / (places[1:] - places[:-1])
        weight, moment = integrals(places, c)
        # F = F(a) + rates[0] (t - a), and at each point on the bend of F times t less the point
        bends = np.concatenate([rates[:1], rates[1:] - rates[:-1]])
        return float(low * weight[0] + bends @ (moment[:-1] - places[:-1] * weight[:-1]))


def _over_root(x: Array, c: float) -> tuple[Array, Array]:
    """int_x^c 1/sqrt(c^2 - t^2) dt and int_x^c t/sqrt(c^2 - t^2) dt."""
    return angle(c - x, np.full_like(x, c)), np.sqrt((c - x) * (c + x))


def _times_root(x: Array, c: float) -> tuple[Array, Array]:
    """int_x^c sqrt(c^2 - t^2) dt and int_x^c t sqrt(c^2 - t^2) dt."""
    theta, root = _over_root(x, c)
    return (c**2 * theta - x * root) / 2, root**3 / 3

"""A profile with a dent: what stands for F in the contact equation where a body keeps a dent that relaxes.

In Abel's space the dent is a function of one place x, as F is. It is known at points, close to each other where the
edge of a contact passes, and linear between them; its integrals with the weights of the contact equation are exact.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...base.numerics import Array
from .fredholm import LegendrePanels, angle, rule

ARC_NODES = 64  # choice: integrals over many zones at once, where jumps end, are good to 1e-4


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
    def spacing(self) -> Array:
        """Widths [m] of the intervals between points."""
        return np.diff(self.x)

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
        half = self.spacing[:, None] / 2
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
        return float(self.spacing @ (values[1:] + values[:-1])) / 2


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
        """int_a^c F(x)/sqrt(c^2 - x^2) dx [m] for c = a + b, by x = c cos(psi), which passes over bends."""
        nodes, weights = rule(ARC_NODES)
        half = angle(b, a + b)[:, None] / 2
        return half[:, 0] * (self.F((a + b)[:, None] * np.cos(half * (nodes + 1))) @ weights)

    @cached_property
    def _integrals(self) -> Array:
        """int_0^x F [m^2] up to all points."""
        return np.append(0.0, np.cumsum(self.points.spacing * (self.values[1:] + self.values[:-1]) / 2))

    def inside(self, a: Array) -> Array:
        """int_0^a F dx [m^2]."""
        x, F = self.points.x, self.values
        i = np.minimum(np.maximum(x.searchsorted(a, side="right") - 1, 0), x.size - 2)
        beyond = a - x[i]
        slope = (F[i + 1] - F[i]) / self.points.spacing[i]
        return np.asarray(self._integrals[i] + beyond * (F[i] + slope * beyond / 2))

    def zone(self, a: float, c: float) -> Zone:
        """The function over the zone from ``a`` to ``c`` [m]."""
        x, F = self.points.x, self.values
        first = min(max(int(x.searchsorted(a, side="right")) - 1, 0), F.size - 2)
        end = max(int(x.searchsorted(c)), first + 1)
        slopes = (F[first + 1 : end + 1] - F[first:end]) / self.points.spacing[first:end]
        at, low = x[first:end].copy(), float(F[first] + slopes[0] * (a - x[first]))
        at[0] = a
        bends = slopes.copy()
        bends[1:] -= slopes[:-1]
        return Zone(c, low, at, bends)


@dataclass(frozen=True, eq=False)
class Zone:
    """A function over a zone that ends at ``c`` [m]: F(x) = ``F`` + sum of ``bends`` max(x - at, 0), the first ``at``
    the zone's begin a."""

    c: float
    F: float
    at: Array
    bends: Array

    @property
    def slope(self) -> float:
        """F' at a."""
        return float(self.bends[0])

    @cached_property
    def roots(self) -> Array:
        """sqrt(c^2 - x^2) [m] where it bends."""
        return np.sqrt((self.c - self.at) * (self.c + self.at))

    @property
    def root(self) -> float:
        """The same at a."""
        return float(self.roots[0])

    @cached_property
    def _angles(self) -> Array:
        return np.arctan2(self.roots, self.at)

    @property
    def arc(self) -> float:
        """int_a^c (F(x) - F(a))/sqrt(c^2 - x^2) dx [m]: of a bend sqrt(c^2 - x_i^2) - x_i arccos(x_i/c)."""
        return float(self.bends @ (self.roots - self.at * self._angles))

    @property
    def arc_by_c(self) -> float:
        """Its derivative by c."""
        return float(self.bends @ self.roots) / self.c

    @property
    def opened(self) -> float:
        """int_a^c F(x) sqrt(c^2 - x^2) dx [m^3]."""
        flat = (self.c**2 * self._angles - self.at * self.roots) / 2  # int sqrt(c^2 - x^2) from each bend on
        return float(self.bends @ (self.roots**3 / 3 - self.at * flat) + self.F * flat[0])

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

from ..base.numerics import Array
from ..methods.integral.finite_range import Discs, Rims
from ..methods.integral.fredholm import LegendrePanels, angle, in_chebyshev, rule, tension_moments

DENT_ARC = 64  # choice: integrals over many zones at once, where jumps end, are good to 1e-4
DENT_STEP = 1e-6  # theory: of the width of an annulus, for a derivative: rounding leaves ten digits


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

    def arcs(self, a: Array, b: Array) -> Array:
        """int_a^c F(x)/sqrt(c^2 - x^2) dx [m] for c = a + b, by x = c cos(psi), which passes over bends."""
        nodes, weights = rule(DENT_ARC)
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
        roots = np.sqrt((c - at) * (c + at))
        return Zone(c, low, at, bends, roots, np.arctan2(roots, at))


@dataclass(frozen=True, eq=False)
class Zone:
    """A function over a zone that ends at ``c`` [m]: F(x) = ``F`` + sum of ``bends`` max(x - at, 0), the first ``at``
    the zone's begin a; ``roots`` there: sqrt(c^2 - x^2) [m], ``angles``: arccos(x/c)."""

    c: float
    F: float
    at: Array
    bends: Array
    roots: Array
    angles: Array

    @property
    def slope(self) -> float:
        """F' at a."""
        return float(self.bends[0])

    @property
    def root(self) -> float:
        """sqrt(c^2 - a^2) [m]."""
        return float(self.roots[0])

    @property
    def arc(self) -> float:
        """int_a^c (F(x) - F(a))/sqrt(c^2 - x^2) dx [m]: of a bend sqrt(c^2 - x_i^2) - x_i arccos(x_i/c)."""
        return float(self.bends @ (self.roots - self.at * self.angles))

    @property
    def arc_by_c(self) -> float:
        """Its derivative by c."""
        return float(self.bends @ self.roots) / self.c

    @property
    def opened(self) -> float:
        """int_a^c F(x) sqrt(c^2 - x^2) dx [m^3]."""
        flat = (self.c**2 * self.angles - self.at * self.roots) / 2  # int sqrt(c^2 - x^2) from each bend on
        return float(self.bends @ (self.roots**3 / 3 - self.at * flat) + self.F * flat[0])


def dented_state(discs: Discs, b: float, s: float) -> tuple[Rims, Array, Array]:
    """The state of one disc with an annulus ``b`` [m] wide under a ``DentedProfile``, int_0^c K phi of it on the
    polynomials, and the derivatives of delta [m], P [N] and the gap [m] by a at the same c and by c at the same a,
    (3, 2).

    Another a at the same c is the flat end of radius a pressed by d(delta), as phi stays continuous there; with
    another c the tension sqrt(c^2 - t^2) changes by c/sqrt(c^2 - t^2).
    """
    dented, basis = discs.abel, discs.basis
    assert isinstance(dented, DentedProfile)
    a, e = float(discs.a[0]), DENT_STEP * b
    c, E, zone = a + b, 2 * discs.E_star, dented.zone(a, a + b)
    root, theta = zone.root, math.atan2(zone.root, a)
    (rho, _), (kappa, further) = tension_moments(basis, np.array([a, a]), np.array([b, b + e]))
    ends, beta = discs.ends[0], discs.beta[0]
    # M of the only disc times four vectors
    p, order = int(discs.panel[0]), basis.order
    M, block = discs.schur[p], slice(p * order, (p + 1) * order)
    whole = np.stack([beta, discs.phi_F[0], rho, kappa]) @ M
    M_beta, M_F, M_rho, M_kappa = whole - (whole[:, block] @ discs.partial[0].T) @ M[block]
    edge, S = 1 - float(ends @ M_beta), a - float(beta @ M_beta)
    z, Q = zone.F - float(ends @ M_F), float(dented.inside(discs.a)[0] - beta @ M_F)
    # (pi/2) phi = delta - F - b smooth within a, -s sqrt(c^2 - x^2) beyond, and continuous at a
    delta = (z - s * (float(ends @ M_rho) + root)) / edge
    smooth = delta * M_beta - M_F - s * M_rho
    opens = theta - float(kappa @ M_beta)  # less u of the flat end at c, times pi/2
    gap = zone.arc + (zone.F - delta) * theta - s * b + float(kappa @ smooth)
    P = E * (delta * S - Q + s * (float(beta @ M_rho) - (c**2 * theta - a * root) / 2))
    # Derivatives of all polynomials at a
    by_y = basis.local(discs.a, discs.panel) @ in_chebyshev(order)[1] * 2 / basis.widths[discs.panel, None]
    steep = basis.scattered(np.zeros(1, dtype=int), discs.panel, by_y, 1)[0]
    by_a = (s * a / root + zone.slope + float(steep @ smooth)) / edge
    by_c = -s * c * (float(ends @ M_kappa) + 1 / root) / edge
    P_by_c = E * (by_c * S + s * c * (float(beta @ M_kappa) - theta))
    gap_by_c = zone.arc_by_c + (zone.F - delta) * a / (c * root) - by_c * opens - s
    gap_by_c += float((further - kappa) @ smooth) / e - s * c * float(kappa @ M_kappa)
    rows = [[by_a, by_c], [E * S * by_a, P_by_c], [-2 / math.pi * opens * by_a, 2 / math.pi * gap_by_c]]
    rims = Rims(*(np.array([value]) for value in (a, c, delta, P, 2 / math.pi * gap)))
    return rims, smooth, np.array(rows)

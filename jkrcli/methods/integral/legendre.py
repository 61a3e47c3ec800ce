"""Legendre polynomials on panels, orthonormal: the functions on which a smooth kernel is a small matrix.

K(x, t) = sum b_i(x) K_ij b_j(t) holds to the accuracy with which polynomials follow K on a panel, whatever densities it
acts on. Contact radii then need no edges of panels of their own: a disc cuts one panel, whose integrals are exact.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import legendre

from ...base import Array
from .quadrature import Panels, crowded, crowded_rule, rule

Function = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class LegendrePanels:
    """Orthonormal Legendre polynomials b [m^-1/2] of degrees below the order on each of the ``panels``; panel by
    panel."""

    panels: Panels

    @property
    def order(self) -> int:
        return self.panels.order

    @property
    def count(self) -> int:
        """Number of panels."""
        return self.panels.edges.size - 1

    @property
    def size(self) -> int:
        """Number of polynomials."""
        return self.count * self.order

    @cached_property
    def projection(self) -> Array:
        """Matrix from values at the nodes of the panels to the integrals of b times what has these values."""
        nodes, weights = rule(self.order)
        once = legendre.legvander(nodes, self.order - 1).T * weights * np.sqrt(np.arange(self.order) + 0.5)[:, None]
        return np.kron(np.diag(np.sqrt(np.diff(self.panels.edges) / 2)), once)

    def panel_of(self, x: Array) -> Array:
        """Number of the panel that holds each x; the upper one at an edge, the last one at the end."""
        return np.clip(np.searchsorted(self.panels.edges, x, side="right") - 1, 0, self.count - 1)

    def local(self, x: Array, panel: Array) -> Array:
        """Values of the polynomials of each point's ``panel``, (..., order)."""
        lo, width = self.panels.edges[panel], np.diff(self.panels.edges)[panel]
        values = legendre.legvander(2 * (x - lo) / width - 1, self.order - 1)
        return values * np.sqrt((2 * np.arange(self.order) + 1) / width[..., None])

    def at(self, x: Array) -> Array:
        """All polynomials at the points ``x``, (x.size, size)."""
        panel = self.panel_of(x)
        return self.scattered(np.arange(x.size), panel, self.local(x, panel), x.size)

    def scattered(self, row: Array, panel: Array, values: Array, rows: int) -> Array:
        """Values (m, order) of the polynomials of each one's ``panel`` added up in (rows, size)."""
        total = np.zeros((rows, self.count, self.order))
        np.add.at(total, (row, panel), values)
        return total.reshape(rows, self.size)


@dataclass(frozen=True, eq=False)
class AbelMoments:
    """Integrals of the function ``F`` [m] of an indenter from 0 on: cut at its ``kinks`` [m], nodes crowded above each,
    where F may begin like a root."""

    F: Function
    kinks: Array
    basis: LegendrePanels
    inner: int

    @cached_property
    def _stops(self) -> tuple[Array, Array]:
        """Edges of panels and kinks, and the integrals of b F from the beginning of each one's panel."""
        edges = self.basis.panels.edges
        cuts = np.unique(np.concatenate([edges, self.kinks[self.kinks < edges[-1]]]))
        panel = self.basis.panel_of(cuts[:-1])
        steps = self._over(panel, cuts[:-1], cuts[1:])
        sums = np.vstack([np.zeros(self.basis.order), np.cumsum(steps, axis=0)])
        begin = np.searchsorted(cuts, edges[panel])
        return cuts, np.vstack([sums[:-1] - sums[begin], sums[-1] - sums[begin[-1]]])

    def moments(self, a: Array) -> Array:
        """Integrals int_0^a b F of all polynomials, (a.size, size)."""
        cuts, sums = self._stops
        panel = self.basis.panel_of(a)
        edges = self.basis.panels.edges
        ends = np.searchsorted(cuts, edges[1:])
        whole = sums[ends - 1] + self._over(np.arange(self.basis.count), cuts[ends - 1], edges[1:])
        last = np.clip(np.searchsorted(cuts, a, side="right") - 1, 0, cuts.size - 2)
        total = np.where(np.arange(self.basis.count)[:, None] < panel[:, None, None], whole, 0.0)
        total[np.arange(a.size), panel] = sums[last] + self._over(panel, cuts[last], a)
        return total.reshape(a.size, self.basis.size)

    def _over(self, panel: Array, lo: Array, hi: Array) -> Array:
        """Integrals of b F over intervals of one panel each, (intervals, order)."""
        x, w = crowded(lo, hi, self.inner)
        return np.einsum("pn,pnq->pq", w * self.F(x), self.basis.local(x, np.broadcast_to(panel[:, None], x.shape)))

    def integral(self, moments: Array) -> Array:
        """int_0^a F [m^2] from the ``moments``."""
        by_panel = moments.reshape(-1, self.basis.count, self.basis.order)[:, :, 0]
        return by_panel @ np.sqrt(np.diff(self.basis.panels.edges))

    def arcs(self, a: Array, b: Array) -> Array:
        """int_a^c F(x)/sqrt(c^2 - x^2) dx [m] for c = a + b, by x = c cos(psi)."""
        row, _, upper, lower = cut_angles(np.array([0.0, *self.kinks, np.inf]), a, b)
        u, v = crowded_rule(self.inner, 2)
        psi = upper[:, None] - (upper - lower)[:, None] * u
        values = self.F((a + b)[row][:, None] * np.cos(psi))
        return np.bincount(row, (upper - lower) * (values @ v), a.size)


def angle(beyond: Array, c: Array) -> Array:
    """arccos(t/c) [rad] from the distance ``beyond`` = c - t [m], without cancellation."""
    return 2 * np.arcsin(np.sqrt(np.clip(beyond / (2 * c), 0.0, 1.0)))


def cut_angles(edges: Array, a: Array, b: Array) -> tuple[Array, Array, Array, Array]:
    """The angles psi of x = c cos(psi) from a to c = a + b, cut at the ``edges``: number of the pair, interval between
    edges, and the upper and the lower end [rad] of every piece."""
    c = a + b
    first, last = (np.clip(np.searchsorted(edges, x, side="right") - 1, 0, edges.size - 2) for x in (a, c))
    counts = last - first + 1
    row = np.repeat(np.arange(a.size), counts)
    cell = np.arange(row.size) - np.repeat(np.cumsum(counts) - counts, counts) + first[row]
    a, b, c = a[row], b[row], c[row]
    left, right = np.maximum(edges[cell], a), np.minimum(np.where(cell == last[row], np.inf, edges[cell + 1]), c)
    upper = angle(np.where(left == a, b, c - left), c)
    return row, cell, upper, np.where(right == c, 0.0, angle(c - right, c))


def tension_moments(basis: LegendrePanels, a: Array, b: Array) -> tuple[Array, Array]:
    """Integrals over (a, c = a + b) of all polynomials times sqrt(c^2 - t^2), and over it: two of (a.size, size)."""
    c = a + b
    row, panel, upper, lower = cut_angles(basis.panels.edges, a, b)
    widest = float(np.max(upper - lower))
    nodes, weights = rule(basis.order // 2 + 5 + math.ceil(8 * widest))  # polynomials of cos(psi) to rounding
    half = (upper - lower)[:, None] / 2
    psi = (upper + lower)[:, None] / 2 + half * nodes
    values = basis.local(c[row][:, None] * np.cos(psi), np.broadcast_to(panel[:, None], psi.shape))
    over = np.einsum("pn,pnq->pq", half * weights, values)
    times = np.einsum("pn,pnq->pq", half * weights * (c[row][:, None] * np.sin(psi)) ** 2, values)
    return basis.scattered(row, panel, times, a.size), basis.scattered(row, panel, over, a.size)

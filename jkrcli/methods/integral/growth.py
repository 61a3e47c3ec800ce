"""The contact of an indenter that grows while it sticks, from the flat ends of all radii.

A disc of radius b that sticks and is pressed down by d(delta) moves the surface outside; a point is touched when it has
come up to the profile, and keeps its radial displacement. In the densities of ``stuck``, with E_j(s; b) what an end of
radius b lacks at s > b to its own displacement, and F the Abel image of the profile,

    D_j(s) = int_0^s E_j(s; b) delta'(b) db,         F(x) = (1/Lambda) int_0^x (Z_1(x, s) D_1(s) + Z_2(x, s) D_2(s)) ds,

a Volterra equation for delta_H; then P_H = int S d(delta_H). Z gives back what lies on top of each other in the rings'
fields of a compressible half-space: with s = x tanh(tau), Z_1 ds = 2 eta sin(2 eta tau) d(tau), Z_2 ds = -2 eta
tanh(tau) cos(2 eta tau) d(tau), each as the limit of a decaying exponential (eta = 0: F = D_1).

It is collocated: the unknown is q = d(delta)/dF, which is smooth where F is not, a polynomial on each of some pieces.
With the right ends of the pieces among the nodes (Radau) errors do not grow from piece to piece, as they would with
Gauss nodes (Brunner, Collocation Methods for Volterra Integral Equations, Sec. 2.4).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.polynomial import legendre

from ...base import ROUNDED, Array
from ...bodies import Indenter
from .density import TUNING as DENSITY
from .quadrature import EXACT, crowded, gauss, rule, split
from .stuck import StuckDisc


@dataclass(frozen=True)
class GrowthTuning:
    """Integrals of the ring fields Z."""

    last: float = 19.0  # largest tau; theory: 1 - tanh^2 is then below rounding
    first: tuple[float, ...] = (0.25, 0.5)  # cuts of the first piece; choice: a fourth of a coating's thickness


TUNING = GrowthTuning()


@cache
def radau(count: int) -> tuple[Array, Array]:
    """Radau nodes and weights on [-1, 1] with the right end among them, exact to the degree 2 count - 2."""
    both = np.zeros(count + 1)
    both[count], both[count - 1] = 1.0, -1.0
    nodes = np.sort(legendre.legroots(both).real)
    nodes[-1] = 1.0
    weights = (1 + nodes) / (count * legendre.legval(nodes, np.eye(count)[-1])) ** 2
    return nodes, weights


@dataclass(frozen=True, eq=False)
class Pieces:
    """Piecewise polynomials of a radius between the increasing ``edges`` [m] by their values at ``count`` Radau nodes
    on each; on pieces that begin at a kink (``crowd``) they are polynomials of the root of the distance."""

    edges: Array
    crowd: Array
    count: int

    @classmethod
    def of(cls, indenter: Indenter, largest: float, widest: float, count: int) -> Pieces:
        """Pieces up to the contact radius ``largest`` [m], at most ``widest`` [m] each; narrower at the axis, where a
        stiff coating changes more within a fraction of its thickness."""
        kinks = [indenter.a0, *(b for b in indenter.joints if indenter.a0 < b < largest)]
        edges: list[float] = []
        for lo, hi in itertools.pairwise([*kinks, largest]):
            plain = np.linspace(lo, hi, max(math.ceil((hi - lo) / widest - ROUNDED), 1) + 1)
            edges += list(plain[:-1]) if lo > 0 else [0.0, *plain[1] * np.array(TUNING.first), *plain[1:-1]]
        crowd = np.isin(edges, [b for b in kinks if b > 0])
        return cls(np.append(edges, largest), crowd, count)

    @cached_property
    def nodes(self) -> Array:
        """All nodes (n,) [m]."""
        u = (radau(self.count)[0] + 1) / 2
        part = np.where(self.crowd[:, None], u**2, u)
        nodes = self.edges[:-1, None] + np.diff(self.edges)[:, None] * part
        nodes[:, -1] = self.edges[1:]
        return np.ravel(nodes)

    def piece(self, x: Array) -> Array:
        """Number of the piece that each ``x`` [m] lies on."""
        return np.clip(np.searchsorted(self.edges, x, side="left") - 1, 0, self.crowd.size - 1)

    def basis(self, x: Array, piece: Array) -> Array:
        """Polynomials (..., count) of the ``piece`` at each ``x`` [m] on it: 1 at their own node, 0 at the others."""
        lo, hi = self.edges[piece], self.edges[piece + 1]
        part = np.clip((x - lo) / (hi - lo), 0.0, 1.0)
        local = 2 * np.where(self.crowd[piece], np.sqrt(part), part) - 1
        nodes, weights = radau(self.count)
        degrees = np.arange(self.count)
        project = legendre.legvander(nodes, self.count - 1) * weights[:, None] * (degrees + 0.5)
        return legendre.legvander(local, self.count - 1) @ project.T

    def spread(self, values: Array, piece: Array) -> Array:
        """Rows of values (m, count) put at the columns of their ``piece``: (m, n)."""
        out = np.zeros((piece.size, self.crowd.size, self.count))
        out[np.arange(piece.size), piece] = values
        return out.reshape(piece.size, -1)

    def at(self, x: Array) -> Array:
        """Matrix (m, n) from values at the nodes to values at ``x`` (m,) [m]."""
        return self.spread(self.basis(x, self.piece(x)), self.piece(x))

    def integrals(self, indenter: Indenter, x: Array, inner: int, power: int = 0) -> Array:
        """Matrix (m, n) from the values of a function at the nodes to its integrals over b^power dF(b) from a0 to ``x``
        [m]; ``inner``: Gauss nodes on each piece."""
        piece = self.piece(x)
        whole = self._over(indenter, self.edges[1:], np.arange(self.crowd.size), inner, power)
        before = np.arange(self.crowd.size)[:, None] < piece[:, None, None]
        full = np.broadcast_to(whole, (piece.size, *whole.shape)) * before
        return full.reshape(piece.size, -1) + self.spread(self._over(indenter, x, piece, inner, power), piece)

    def _over(self, indenter: Indenter, x: Array, piece: Array, inner: int, power: int) -> Array:
        """Integrals over b^power dF of the polynomials (m, count) from the beginning of their ``piece`` to ``x``."""
        t, w = crowded(self.edges[piece], x, inner)
        basis = self.basis(t, np.broadcast_to(piece[:, None], t.shape))
        return np.einsum("mi,mic->mc", w * indenter.abel_slope(t) * t**power, basis)


@dataclass(frozen=True, eq=False)
class Growth:
    """Contact of ``indenter`` that grows while it sticks; ``disc``: the flat ends of the radii of all nodes of
    ``pieces``; ``inner``: Gauss nodes of integrals over dF."""

    indenter: Indenter
    disc: StuckDisc
    pieces: Pieces
    inner: int

    @cached_property
    def rate(self) -> Array:
        """d(delta_H)/dF at the nodes."""
        b = self.pieces.nodes
        F = self.indenter.abel(b)
        weights = self.pieces.integrals(self.indenter, b, self.inner)
        D = [weights * self.disc.residual[:, :, j].T for j in (0, 1)]
        matrix = D[0] if self.disc.eta == 0 else self._unwound(D, F)
        return np.linalg.solve(matrix / F[:, None], np.full(F.size, self.disc.Lambda))

    def _unwound(self, D: list[Array], F: Array) -> Array:
        """Z_1 D_1 + Z_2 D_2 at the nodes, from the matrices ``D`` that give D_j there."""
        rows = [self._rings(x) for x in self.pieces.nodes]
        return sum(np.array([row[j] for row in rows]) @ (D[j] / F[:, None]) for j in (0, 1)) * np.ones_like(D[0])

    def _rings(self, x: float) -> tuple[Array, Array]:
        """Rows (n,) that give Z_1 D_1 and Z_2 D_2 at the node ``x`` [m] from D_1/F and D_2/F at the nodes.

        D(x) is taken out of the integrals, as the limit of a decaying exponential gives it.
        """
        eta, edges = self.disc.eta, self.pieces.edges
        inside = np.append(edges[edges < x * (1 - 1e-12)], [])
        ends = np.append(np.arctanh(inside / x), TUNING.last)
        lo, hi = split(ends[:-1], ends[1:], np.maximum(np.ceil(np.diff(ends) / DENSITY.widest), 1).astype(int))
        tau, w = gauss(lo, hi, *rule(EXACT))
        s = x * np.tanh(tau)
        values = self.pieces.at(s) * self.indenter.abel(s)[:, None]
        here = self.pieces.at(np.array([x]))[0] * self.indenter.abel(np.array([x]))
        first, second = 2 * eta * w * np.sin(2 * eta * tau), -2 * eta * w * np.cos(2 * eta * tau)
        start = 2 * eta * ends[0]
        return (
            first @ values + (math.cos(start) - first.sum()) * here,
            (second * np.tanh(tau)) @ values + (math.sin(start) - second.sum()) * here,
        )

    def displacement(self, a: Array) -> Array:
        """delta_H at contact radii ``a`` [m]."""
        return self.pieces.integrals(self.indenter, a, self.inner) @ self.rate

    def load(self, a: Array) -> Array:
        """P_H at contact radii ``a`` [m], over 2 E* [m^2]."""
        mean = self.rate * self.disc.S / self.pieces.nodes
        return self.pieces.integrals(self.indenter, a, self.inner, 1) @ mean

    def stiffness(self, a: Array) -> tuple[Array, Array]:
        """S [m] and S' at contact radii ``a`` [m], over 2 E*."""
        between = self.pieces.at(a)
        return a * np.exp(between @ np.log(self.disc.S / self.pieces.nodes)), np.exp(between @ np.log(self.disc.dS))

"""High-order elements along one line; the elements of a rectangle are products of two of them.

On every interval between ``edges`` stand Lagrange polynomials on the Gauss-Lobatto points of its own degree. A field
that is smooth on an interval is met with an error that falls exponentially with the degree (Babuska and Suri 1994).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.polynomial import legendre

from ..integral.quadrature import rule

Array = np.ndarray
EXTRA = 2  # Gauss points per interval beyond the degree


@cache
def lobatto(degree: int) -> Array:
    """Gauss-Lobatto points on [-1, 1], ends included; of degree 0 the centre."""
    if degree == 0:
        return np.zeros(1)
    inner = legendre.legroots(legendre.legder([0.0] * degree + [1.0])).real if degree > 1 else np.zeros(0)
    return np.concatenate([[-1.0], inner, [1.0]])


@cache
def _inverse(degree: int) -> Array:
    """From values at the Gauss-Lobatto points to Legendre coefficients."""
    return np.linalg.inv(legendre.legvander(lobatto(degree), degree))


def shapes(degree: int, x: Array) -> tuple[Array, Array]:
    """Lagrange polynomials of ``degree`` and their derivatives at ``x`` in [-1, 1], (x.size, degree + 1)."""
    inverse = _inverse(degree)
    slopes = legendre.legvander(x, max(degree - 1, 0)) @ legendre.legder(inverse) if degree else np.zeros((x.size, 1))
    return legendre.legvander(x, degree) @ inverse, slopes


@dataclass(frozen=True, eq=False)
class Line:
    """Continuous elements between increasing ``edges``, interval i of degree ``degrees[i]`` >= 1."""

    edges: Array
    degrees: Array

    @cached_property
    def nodes(self) -> Array:
        """Positions of the unknowns, increasing."""
        inner = [
            (a + b) / 2 + (b - a) / 2 * lobatto(int(p))[1:]
            for a, b, p in zip(self.edges[:-1], self.edges[1:], self.degrees, strict=True)
        ]
        return np.concatenate([self.edges[:1], *inner])

    @cached_property
    def rule(self) -> tuple[Array, Array]:
        """Gauss points and weights, interval by interval."""
        parts = [rule(int(p) + EXTRA) for p in self.degrees]
        half = np.diff(self.edges) / 2
        centre = self.edges[:-1] + half
        x = np.concatenate([c + h * u for c, h, (u, _) in zip(centre, half, parts, strict=True)])
        return x, np.concatenate([h * v for h, (_, v) in zip(half, parts, strict=True)])

    @cached_property
    def basis(self) -> tuple[Array, Array]:
        """Shape functions and their derivatives at the Gauss points, (points, unknowns)."""
        return self._collocated(self.degrees, np.ones(self.degrees.size - 1, dtype=bool))

    def pressure(self, joined: Array) -> Array:
        """Shape functions of one degree less at the Gauss points, continuous at inner edge i where ``joined[i]``."""
        return self._collocated(self.degrees - 1, joined)[0]

    def at(self, x: Array, joined: Array) -> tuple[Array, Array, Array]:
        """Shape functions, derivatives, and those of the pressure at any increasing ``x`` off the edges."""
        owner = np.searchsorted(self.edges, x) - 1
        local = 2 * (x - self.edges[owner]) / np.diff(self.edges)[owner] - 1
        values, slopes = _assembled(owner, local, self.degrees, np.ones_like(joined), np.diff(self.edges))
        return values, slopes, _assembled(owner, local, self.degrees - 1, joined, np.diff(self.edges))[0]

    def _collocated(self, degrees: Array, joined: Array) -> tuple[Array, Array]:
        local = np.concatenate([rule(int(p) + EXTRA)[0] for p in self.degrees])
        owner = np.repeat(np.arange(self.degrees.size), self.degrees + EXTRA)
        return _assembled(owner, local, degrees, joined, np.diff(self.edges))


def _assembled(owner: Array, local: Array, degrees: Array, joined: Array, widths: Array) -> tuple[Array, Array]:
    """Shape functions and derivatives at the places ``local`` in [-1, 1] of the intervals ``owner``."""
    starts = np.concatenate([[0], np.cumsum(degrees + 1 - np.append(joined, False))])
    values, slopes = np.zeros((2, local.size, starts[-1]))
    for i, degree in enumerate(degrees.tolist()):
        rows = np.flatnonzero(owner == i)
        block = np.ix_(rows, starts[i] + np.arange(degree + 1))
        values[block], slopes[block] = shapes(degree, local[rows])
        slopes[block] *= 2 / widths[i]
    return values, slopes

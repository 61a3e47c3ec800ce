"""High-order elements along one line, and where their intervals end; elements of a rectangle are products of two.

On every interval between ``edges`` stand Lagrange polynomials on the Gauss-Lobatto points of its own degree. A field
that is smooth on an interval is met with an error that falls exponentially with the degree (Babuska and Suri 1994).

Intervals are short where the correction varies fast, and towards singular corners: seen from a place where the body
ends or changes, the contact is a ring source at some distance; the correction varies over that distance there, and over
ever longer ones away from it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.polynomial import legendre

from ...base import Array, Refusal
from ..integral import rule
from .region import Region


@dataclass(frozen=True)
class LineTuning:
    """How long intervals are, and of which degree towards singular corners."""

    extra: int = 2  # Gauss points per interval beyond the degree; tuned on reference bodies, by `make tuning`
    spare: float = 0.2  # part of an interval that is done without; choice: with 0.3 errors of thick layers change sign
    length: float = 1.5  # of intervals, over the distance of the source; tuned on reference bodies, by `make tuning`
    growth: float = 0.67  # of lengths with the distance from the contact; tuned on reference bodies, by `make tuning`
    far_growth: float = 1.0  # the same far from it; tuned on reference bodies, by `make tuning`
    far: float = 10.0  # contact radii, or depths of the first interface; tuned on reference bodies, by `make tuning`
    # Of a field that decays exponentially, in lengths: over which it changes, and after which it is gone:
    decaying: float = 0.5  # tuned on random bodies, by `make bounds`
    decayed: float = 2.0  # tuned on random bodies, by `make bounds`
    corner: float = 0.15  # ratio of intervals towards a singular corner; theory: Babuska and Suri 1994, about 0.15
    corner_degree: int = 2  # on the smallest of them, growing by one per interval; theory: likewise
    most: int = 10_000  # intervals between two stops; choice: no solve of the cost that is allowed has as many


TUNING = LineTuning()
SAMPLES = np.unique(np.concatenate([np.linspace(0, 1, 65), np.geomspace(1e-5, 1, 65), 1 - np.geomspace(1e-5, 1, 65)]))


@cache
def lobatto(degree: int) -> Array:
    """Gauss-Lobatto points on [-1, 1], ends included; of degree 0 the centre."""
    if degree == 0:
        return np.zeros(1)
    inner = legendre.legroots(legendre.legder([0.0] * degree + [1.0])).real if degree > 1 else np.zeros(0)
    return np.concatenate([[-1.0], inner, [1.0]])


@cache
def _inverse(degree: int) -> Array:
    """Matrix from values at the Gauss-Lobatto points to Legendre coefficients."""
    return np.linalg.inv(legendre.legvander(lobatto(degree), degree))


def shapes(degree: int, x: Array) -> tuple[Array, Array]:
    """Lagrange polynomials of ``degree`` and their derivatives at ``x`` in [-1, 1], (x.size, degree + 1)."""
    inverse = _inverse(degree)
    slopes = legendre.legvander(x, max(degree - 1, 0)) @ legendre.legder(inverse) if degree else np.zeros((x.size, 1))
    return legendre.legvander(x, degree) @ inverse, slopes


@dataclass(frozen=True, eq=False)
class LineElements:
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
        parts = [rule(int(p) + TUNING.extra) for p in self.degrees]
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
        local = np.concatenate([rule(int(p) + TUNING.extra)[0] for p in self.degrees])
        owner = np.repeat(np.arange(self.degrees.size), self.degrees + TUNING.extra)
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


def lines(region: Region, degree: int) -> tuple[LineElements, LineElements]:
    """Elements of a ``degree`` along r and along z."""
    first = region.first
    gap = region.width - 1 if not region.cut_beside else np.inf

    def radial(r: Array) -> Array:
        size = np.minimum(first + _grown(r - 1, first), gap + region.width - r)
        return TUNING.length * np.minimum(size, _decaying(r, region))

    def vertical(z: Array) -> Array:
        return TUNING.length * np.minimum(first + _grown(z - first, first), gap + z)

    # As many graded intervals as let both errors fall together; fewer where the singularity is weaker.
    corners = [(z, degree // 2) for z in region.corners] + [(z, max(degree // 2 - 1, 1)) for z in region.free_edges]
    at_side = max((count for _, count in corners), default=0)
    r = _partition([0.0, *region.cuts, region.width], radial, region.cut_beside)
    z = _partition(
        [*region.tops, *region.kinks, *(region.cuts if region.far else ()), region.depth], vertical, region.cut_beside
    )
    return _graded(r, [(region.width, at_side)], degree), _graded(z, corners, degree)


def extended(r: LineElements, region: Region, degree: int) -> LineElements:
    """The line ``r`` and intervals on to the end of the wider ``region``."""
    end = float(r.edges[-1])

    def beyond(x: Array) -> Array:
        return TUNING.length * np.minimum(region.first + _grown(x - 1, region.first), _decaying(x, region))

    more = _partition([end, region.width], beyond, region.cut_beside)[1:]
    degrees = np.full(more.size, degree)
    return LineElements(np.concatenate([r.edges, more]), np.concatenate([r.degrees, degrees]))


def _grown(beyond: Array, first: float) -> Array:
    """What lengths gain at the distance ``beyond`` the contact, or below the ``first`` interface."""
    faster = (TUNING.far_growth - TUNING.growth) * np.maximum(beyond - TUNING.far * max(1.0, first), 0.0)
    return TUNING.growth * np.maximum(beyond, 0.0) + faster


def _decaying(r: Array, region: Region) -> Array:
    """Distance over which a field that decays exponentially changes, under a stiff layer many thicknesses, and where it
    has decayed more."""
    if region.algebraic or not region.cut_beside:
        return np.full(np.shape(r), np.inf)
    gone = r - 1 - TUNING.decayed * region.length
    return TUNING.decaying * region.length + TUNING.growth * np.maximum(gone, 0.0)


def _partition(stops: Iterable[float], size: Callable[[Array], Array], wide: bool) -> Array:
    """Edges between the ``stops``, the intervals hardly longer than ``size`` says in them: those of thick layers are so
    few that otherwise errors change sign with the degree, and two degrees agree by accident."""
    ends = np.unique(list(stops))
    edges: list[Array] = [ends[:1]]
    for lo, hi in itertools.pairwise(ends):
        x = lo + (hi - lo) * SAMPLES
        density = 1 / size(x)
        count = np.concatenate([[0.0], np.cumsum(np.diff(x) * (density[1:] + density[:-1]) / 2)])
        if count[-1] > TUNING.most:
            instead = "layered or fem" if wide else "fem (with a rigid indenter)"
            raise Refusal(
                f"hybrid: the contact or body is so large against the nearest interface that elements would lie in "
                f"{count[-1]:.2g} rows (limit {TUNING.most}); ask for a smaller contact, or use the method {instead}"
            )
        pieces = max(1, math.ceil(float(count[-1]) - TUNING.spare))
        edges += [np.interp(np.arange(1, pieces) * count[-1] / pieces, count, x), np.array([hi])]
    return np.concatenate(edges)


def _graded(edges: Array, corners: list[tuple[float, int]], degree: int) -> LineElements:
    """Intervals next to every corner cut geometrically, with degrees that fall towards it."""
    pieces = [(a, b, degree) for a, b in itertools.pairwise(edges.tolist())]
    for corner, count in corners:
        pieces = [part for piece in pieces for part in _cut(piece, corner, count)]
    return LineElements(np.array([0.0, *(b for _, b, _ in pieces)]), np.array([p for *_, p in pieces]))


def _cut(piece: tuple[float, float, int], corner: float, count: int) -> list[tuple[float, float, int]]:
    """A piece that ends at the ``corner`` cut ``count`` times, every time at ``TUNING.corner`` of the distance."""
    a, b, degree = piece
    if not count or corner not in (a, b):
        return [piece]
    far = b if a == corner else a
    marks = [far, *(corner + (far - corner) * TUNING.corner**k for k in range(1, count + 1)), corner]
    degrees = [degree, *(min(degree, TUNING.corner_degree + k) for k in range(count - 1, -1, -1))]
    return sorted((min(p, q), max(p, q), d) for (p, q), d in zip(itertools.pairwise(marks), degrees, strict=True))

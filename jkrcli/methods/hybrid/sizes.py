"""Where the intervals of the two lines end: short where the correction varies fast, and towards singular corners.

Seen from a place where the body ends or changes, the contact is a ring source at some distance; the correction varies
over that distance there, and over ever longer ones away from it.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from ...base.errors import Refusal
from .lines import Line
from .region import Region

Array = np.ndarray
GROWTH, FAR_GROWTH = 0.67, 1.0  # of the lengths, with the distance from the contact, near it and far from it
FAR = 10.0  # in contact radii or depths of the first interface
CORNER = 0.15  # ratio of successive intervals towards a singular corner
CORNER_DEGREE = 2  # on the smallest of them, growing by one per interval
MOST = 10_000  # intervals between two stops: no solve of the cost that is allowed has as many
SAMPLES = np.unique(np.concatenate([np.linspace(0, 1, 65), np.geomspace(1e-5, 1, 65), 1 - np.geomspace(1e-5, 1, 65)]))


@dataclass(frozen=True)
class Resolution:
    """``degree`` of the elements; ``length``: their size over the distance of the source."""

    degree: int
    length: float = 1.5

    @property
    def corners(self) -> int:
        """Intervals that are graded towards each singular corner: both errors then fall together."""
        return self.degree // 2

    @property
    def edges(self) -> int:
        """Intervals graded towards each interface at a side, where the singularity is weaker."""
        return max(self.degree // 2 - 1, 1)

    def coarser(self, less: int) -> Resolution:
        """The same intervals with degrees lower by ``less``."""
        return replace(self, degree=self.degree - less)


def lines(region: Region, resolution: Resolution) -> tuple[Line, Line]:
    """The lines along r and along z."""
    first = region.first
    gap = region.width - region.reach if not region.cut_beside else np.inf

    def radial(r: Array) -> Array:
        return resolution.length * np.minimum(first + _grown(r - region.reach, first), gap + region.width - r)

    def vertical(z: Array) -> Array:
        return resolution.length * np.minimum(first + _grown(z - first, first), gap + z)

    corners = [(z, resolution.corners) for z in region.corners] + [(z, resolution.edges) for z in region.free_edges]
    at_side = max((count for _, count in corners), default=0)
    r = _partition([0.0, *region.cuts, region.width], radial, region.cut_beside)
    z = _partition(
        [*region.tops, *region.kinks, *(region.cuts if region.far else ()), region.depth], vertical, region.cut_beside
    )
    return _graded(r, [(region.width, at_side)], resolution.degree), _graded(z, corners, resolution.degree)


def extended(r: Line, region: Region, resolution: Resolution) -> Line:
    """The line ``r`` and intervals on to the end of the wider ``region``."""
    end = float(r.edges[-1])

    def beyond(x: Array) -> Array:
        return resolution.length * (region.first + _grown(x - region.reach, region.first))

    more = _partition([end, region.width], beyond, region.cut_beside)[1:]
    degrees = np.full(more.size, resolution.degree)
    return Line(np.concatenate([r.edges, more]), np.concatenate([r.degrees, degrees]))


def _grown(beyond: Array, first: float) -> Array:
    """What lengths gain at the distance ``beyond`` the contact, or below the ``first`` interface."""
    faster = (FAR_GROWTH - GROWTH) * np.maximum(beyond - FAR * max(1.0, first), 0.0)
    return GROWTH * np.maximum(beyond, 0.0) + faster


def _partition(stops: Iterable[float], size: Callable[[Array], Array], wide: bool) -> Array:
    """Edges between the ``stops``, the intervals about as long as ``size`` says in them."""
    ends = np.unique(list(stops))
    edges: list[Array] = [ends[:1]]
    for lo, hi in itertools.pairwise(ends):
        x = lo + (hi - lo) * SAMPLES
        density = 1 / size(x)
        count = np.concatenate([[0.0], np.cumsum(np.diff(x) * (density[1:] + density[:-1]) / 2)])
        if count[-1] > MOST:
            instead = "layered or fem" if wide else "fem (with a rigid indenter)"
            raise Refusal(
                f"hybrid: the contact or body is so large against the nearest interface that elements would lie in "
                f"{count[-1]:.2g} rows (limit {MOST}); ask for a smaller contact, or use the method {instead}"
            )
        pieces = max(1, round(float(count[-1]) + 0.2))
        edges += [np.interp(np.arange(1, pieces) * count[-1] / pieces, count, x), np.array([hi])]
    return np.concatenate(edges)


def _graded(edges: Array, corners: list[tuple[float, int]], degree: int) -> Line:
    """Intervals next to every corner cut geometrically, with degrees that fall towards it."""
    groups = [[(a, b, degree)] for a, b in itertools.pairwise(edges.tolist())]
    for corner, count in corners:
        for i, (a, b) in enumerate(itertools.pairwise(edges.tolist())):
            if count and corner in (a, b):
                groups[i] = _cut(groups[i], corner, count)
    pieces = list(itertools.chain(*groups))
    return Line(np.array([0.0, *(b for _, b, _ in pieces)]), np.array([p for *_, p in pieces]))


def _cut(pieces: list[tuple[float, float, int]], corner: float, count: int) -> list[tuple[float, float, int]]:
    """The piece next to ``corner`` cut ``count`` times, every time at CORNER of the distance."""
    nearest = pieces[0] if pieces[0][0] == corner else pieces[-1]
    a, b, degree = nearest
    far = b if a == corner else a
    marks = [far, *(corner + (far - corner) * CORNER**k for k in range(1, count + 1)), corner]
    degrees = [degree, *(min(degree, CORNER_DEGREE + k) for k in range(count - 1, -1, -1))]
    cut = [(min(p, q), max(p, q), d) for (p, q), d in zip(itertools.pairwise(marks), degrees, strict=True)]
    return sorted(cut + [piece for piece in pieces if piece is not nearest])

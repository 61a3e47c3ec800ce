"""Gauss quadrature on composite panels: its rules, how many nodes an accuracy needs, and panels with nested radii."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from ...base import Array

# nodes on a panel over which a function is a power or an exponential; tuned on bodies, by `make constants`: exact to
# rounding
EXACT = 12


@dataclass(frozen=True)
class QuadratureTuning:
    """How nodes are planned for an accuracy of the contact equation."""

    most_nodes: int = 10  # on a panel; tuned on bodies, by `make constants`: beyond, narrower panels are as cheap
    # Times the kernel's scale: highest wave number noticed:
    frequency: float = 5.0  # tuned on reference bodies, by `make tuning`
    # of panels, from one refinement to the next where phi is not smooth; choice: what a step costs
    narrower: float = 1.5
    # Crowding of panels before each radius under a kernel with a logarithm, where phi is not smooth at its edge:
    unsmooth_nodes: int = 4  # least on a panel; tuned on graded layers, by `make tuning`
    # Error there: square of this, the panel's width, the logarithm's strength:
    edge: float = 0.03  # tuned on reference bodies, by `make tuning`
    most_cuts: int = 8  # tuned on graded layers, by `make tuning`
    shrink: float = 0.2  # ratio of successive panels; tuned on graded layers, by `make tuning`


TUNING = QuadratureTuning()


@cache
def rule(order: int) -> tuple[Array, Array]:
    """Gauss-Legendre nodes and weights on [-1, 1], read-only."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    nodes.setflags(write=False)
    weights.setflags(write=False)
    return nodes, weights


@cache
def to_legendre(order: int) -> Array:
    """Matrix from values at the Gauss nodes (..., order) to the coefficients of their Legendre polynomials."""
    nodes, weights = rule(order)
    return np.polynomial.legendre.legvander(nodes, order - 1) * (np.arange(order) + 0.5) * weights[:, None]


@cache
def crowded_rule(order: int, power: int) -> tuple[Array, Array]:
    """Gauss nodes and weights on [0, 1] in the root of that ``power``: they crowd at 0, where a function may begin like
    a root (power 2) or a logarithm (power 3)."""
    u, v = rule(order)
    u, v = (u + 1) / 2, v / 2
    return u**power, power * u ** (power - 1) * v


def crowded(lo: Array, hi: Array, order: int) -> tuple[Array, Array]:
    """Nodes and weights (intervals, order) between ``lo`` and ``hi`` that crowd at ``lo``, where a function may begin
    like a root."""
    u, v = crowded_rule(order, 2)
    width = (hi - lo)[:, None]
    return lo[:, None] + width * u, width * v


def gauss(lo: Array, hi: Array, nodes: Array, weights: Array) -> tuple[Array, Array]:
    """Nodes and weights of a composite rule on the panels (lo, hi) from one on [-1, 1], flat, panel by panel."""
    half = (hi - lo)[:, None] / 2
    return np.ravel((lo + hi)[:, None] / 2 + half * nodes), np.ravel(half * weights)


def split(lo: Array, hi: Array, pieces: Array) -> tuple[Array, Array]:
    """Every panel (lo, hi) cut into the given number of equal pieces, in order."""
    step = np.repeat((hi - lo) / pieces, pieces)
    start = np.repeat(lo, pieces)
    index = np.arange(pieces.sum()) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    return start + index * step, start + (index + 1) * step


def phase_allowed(order: int, error: Array | float) -> Array | float:
    """The phase k d [rad] that ``order`` Gauss nodes integrate with a relative ``error``: C (k d)^(2 order) of cos(kx)
    on a panel of the width d."""
    C = math.exp(4 * math.lgamma(order + 1) - 3 * math.lgamma(2 * order + 1)) / (2 * order + 1)
    return (error / C) ** (1 / (2 * order))


@dataclass(frozen=True)
class Quadrature:
    """A planned quadrature: ``order`` Gauss nodes on panels no wider than ``widest`` [m], ``nodes`` in all;
    ``crowding``: cuts of the last panel before each radius; ``inner``: Gauss nodes per panel in the integrals of F;
    ``groups``: into how many the radii are dealt out in turn, each solved on ``nodes`` of its own."""

    order: int
    widest: float
    nodes: int
    crowding: int = 0
    inner: int = 20
    groups: int = 1

    @classmethod
    def cheapest(
        cls, radii: Array, a0: float, scale: float, tolerance: float, orders: Iterable[int] | None = None
    ) -> Quadrature:
        """Quadrature of fewest nodes expected to be accurate to ``tolerance`` at the increasing ``radii`` [m], for a
        flat end of the radius ``a0`` and a kernel that varies over the length ``scale`` [m]."""
        widths = np.diff(np.unique(np.concatenate([[0.0, a0], radii])))
        plans = []
        for order in orders or range(1, TUNING.most_nodes + 1):
            widest = float(phase_allowed(order, tolerance)) * scale / TUNING.frequency
            pieces = np.ceil(widths / widest) if math.isfinite(widest) else np.ones(widths.size)
            plans.append(cls(order, widest, int(order * np.maximum(pieces, 1).sum())))
        return min(plans, key=lambda plan: plan.nodes)

    @classmethod
    def crowded(cls, radii: Array, a0: float, scale: float, tolerance: float, strength: float) -> Quadrature:
        """Quadrature as by ``cheapest``, with panels that crowd before each radius, for a kernel -``strength`` ln |x -
        t| [1/m]."""
        orders = range(TUNING.unsmooth_nodes, TUNING.most_nodes + 1)
        plain = cls.cheapest(radii, a0, scale, tolerance, orders)
        wide = min(float(np.max(np.diff(radii, prepend=0.0))), plain.widest)
        excess = TUNING.edge * strength * wide / math.sqrt(tolerance)
        cuts = min(math.ceil(math.log(max(excess, 1.0)) / -math.log(TUNING.shrink)), TUNING.most_cuts)
        return cls(plain.order, plain.widest, plain.nodes + plain.order * cuts * radii.size, cuts)

    def finer(self) -> Quadrature:
        """Quadrature of one or two more nodes on the same panels: at least one order of magnitude more accurate."""
        order = self.order + (1 if self.order <= 4 else 2)
        nodes, crowding = self.nodes // self.order * order, self.crowding + bool(self.crowding)
        return replace(self, order=order, nodes=nodes, crowding=crowding, inner=self.inner + 8)

    def narrower(self) -> Quadrature:
        """Quadrature of narrower panels and the same order, more crowded: product integration loses accuracy at higher
        orders."""
        nodes, widest = math.ceil(self.nodes * TUNING.narrower), self.widest / TUNING.narrower
        return replace(self, widest=widest, nodes=nodes, crowding=self.crowding + 1, inner=self.inner + 8)


@dataclass(frozen=True, eq=False)
class Panels:
    """Composite Gauss panels from 0 to the largest radius: ends ``edges`` [m], ``order`` nodes on each.

    ``x, w`` [m]: all nodes and weights; ``stops[n]`` nodes lie inside the radius ``radii[n]``.
    """

    edges: Array
    order: int
    radii: Array
    x: Array
    w: Array
    stops: Array

    @property
    def places(self) -> Array:
        """Where the contact equation needs the kernel: at the nodes, then at the radii [m]."""
        return np.concatenate([self.x, self.radii])

    @classmethod
    def through(cls, radii: Array, quadrature: Quadrature, a0: float = 0.0) -> Panels:
        """Panels with edges at all ``radii`` (increasing, > 0) and at the flat end ``a0`` [m].

        The last panel before each radius is cut ``quadrature.crowding`` times, at ``TUNING.shrink`` of its width from
        the radius, for a solution that is not smooth at the edge of its contact.
        """
        radii = np.asarray(radii, dtype=float)
        edges = np.unique(np.concatenate([[0.0], [a0] if a0 < radii[-1] else [], radii]))
        pieces = np.maximum(np.ceil(np.diff(edges) / quadrature.widest * (1 - 1e-12)), 1).astype(int)
        lo, _ = split(edges[:-1], edges[1:], pieces)
        edges = np.append(lo, radii[-1])
        before = edges[np.searchsorted(edges, radii) - 1]
        cuts = radii[:, None] - (radii - before)[:, None] * TUNING.shrink ** np.arange(1, quadrature.crowding + 1)
        edges = np.sort(np.concatenate([edges, np.ravel(cuts)]))
        x, w = gauss(edges[:-1], edges[1:], *rule(quadrature.order))
        return cls(edges, quadrature.order, radii, x, w, quadrature.order * np.searchsorted(edges, radii))

"""Product integration of a logarithmic kernel of the first kind on panels in the angle tau, t = a cos(tau).

    int_0^(pi/2) (k(x - t) + k(x + t))/2 psi(tau) dtau = right side at x = a cos(theta)

psi is finite at the edge tau = 0 with tau^2 ln(tau) behind it: panels are halved towards it, and psi(0) is found from
the first of them by what it begins with. Where a panel is near theta its part is integrated with points that crowd at
theta, or at its nearer end, as the fifth power: they follow a kernel over many decades. The part of x + t is that
of x - t on the panels mirrored at pi/2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from ...base import Array
from ..integral import crowded_rule, gauss, rule
from .product import lagrange

Function = Callable[[Array], Array]


@dataclass(frozen=True)
class AnglesTuning:
    """Points near a singularity, and what psi begins with."""

    # of the crowding; tuned on bodies, by `make constants`: 28 points and more then follow a kernel over the decades of
    # a/kappa
    power: int = 5
    # widths of a panel, within which it is; tuned on bodies, by `make constants`: ten nodes then err by 1e-10
    near: float = 1.0
    # panels at the edge from which psi(0) is found; tuned on bodies, by `make constants`: with five it errs by 1e-6
    first: int = 3
    terms: int = 2  # theory: psi = c0 + sum tau^2n (c_n + d_n ln(tau)), n up to this


TUNING = AnglesTuning()


@dataclass(frozen=True, eq=False)
class Angles:
    """Nodes ``tau`` and weights ``w`` (n,) on panels between ``edges`` from 0 to pi/2, ``order`` on each.

    ``edge`` (n,): psi(0) = edge . psi. Distances are those for a = 1: ``apart, across`` (n, n): |x - t|, x + t, with
    weights ``plain, mirrored``, zero where a panel is near; ``distance`` (m, points) of the m near panels, with
    ``weights`` (m, points, order), for the node ``row`` and the panel ``column``.
    """

    edges: Array
    order: int
    tau: Array
    w: Array
    edge: Array
    apart: Array
    across: Array
    plain: Array
    mirrored: Array
    distance: Array
    weights: Array
    row: Array
    column: Array

    @classmethod
    @lru_cache(maxsize=32)
    def of(cls, levels: int, cuts: int, order: int, points: int) -> Angles:
        """2^``cuts`` equal panels, the first of them halved up to 2^-``levels``; ``points`` near a singularity."""
        whole = np.pi / 2
        equal, halved = np.linspace(0, whole, 2**cuts + 1), whole * 0.5 ** np.arange(levels, cuts, -1.0)
        edges = np.concatenate([[0.0], halved, equal[1:]])
        tau, w = gauss(edges[:-1], edges[1:], *rule(order))
        both = np.concatenate([edges, (np.pi - edges[::-1])[1:]])
        lo, hi = both[:-1, None], both[1:, None]
        near = np.maximum(np.maximum(lo - tau, tau - hi), 0) < TUNING.near * (hi - lo)
        far = np.repeat(~near, order, axis=0).reshape(2, tau.size, tau.size)
        apart = _apart(tau[:, None], tau[:, None] - tau)
        across = np.add.outer(np.cos(tau), np.cos(tau))
        plain, mirrored = far[0].T * w, far[1, ::-1].T * w
        rest = _near(tau, both, near, order, points)
        return cls(edges, order, tau, w, _edge(edges, tau, w, order), apart, across, plain, mirrored, *rest)

    @cached_property
    def nearest(self) -> float:
        """The least distance at which a singular kernel counts, over a."""
        return float(min(self.distance.min(), self.apart[self.plain > 0].min(initial=np.inf)))

    def matrices(self, singular: Function, smooth: Function, a: float) -> Array:
        """Matrices (m, n, n) of the sums of two kernels k(s) [1/m] of s [m], which give m values each, at the contact
        radius ``a`` [m]."""
        i, j = np.tril_indices(self.tau.size)
        apart, across = a * self.apart[i, j], a * self.across[i, j]
        K = self.plain * _symmetric(singular(np.maximum(apart, a * self.nearest)), i, j)
        K += self.mirrored * _symmetric(singular(across), i, j)
        K += self.w * _symmetric(smooth(apart) + smooth(across), i, j)
        near = np.einsum("kmq,mqj->kmj", singular(a * self.distance), self.weights)
        for one, part in zip(K.reshape(*K.shape[:2], -1, self.order), near, strict=True):
            np.add.at(one, (self.row, self.column), part)
        return K / 2


def _symmetric(values: Array, i: Array, j: Array) -> Array:
    full = np.empty((len(values), i[-1] + 1, i[-1] + 1))
    full[:, i, j] = full[:, j, i] = values
    return full


def _apart(tau: Array, difference: Array) -> Array:
    """|cos(tau) - cos(tau - difference)| without cancellation."""
    return 2 * np.abs(np.sin(difference / 2) * np.sin(tau - difference / 2))


def _near(tau: Array, both: Array, near: Array, order: int, points: int) -> tuple[Array, Array, Array, Array]:
    """Distances, weights, rows and columns of the ``near`` (panels, n) among the panels between ``both``; a panel that
    holds the node is cut there."""
    panel, row = np.nonzero(near)
    theta, lo, hi = tau[row], both[panel], both[panel + 1]
    inside = (lo < theta) & (theta < hi)
    start, end = np.clip(theta, lo, hi), np.where(theta >= hi, lo, hi)
    start, end = np.append(start, theta[inside]), np.append(end, lo[inside])
    panel, row, lo, hi = (np.append(x, x[inside]) for x in (panel, row, lo, hi))
    u, v = crowded_rule(points, TUNING.power)
    offset = (end - start)[:, None] * u
    local = (start[:, None] + offset - lo[:, None]) / (hi - lo)[:, None]
    panels = (both.size - 1) // 2
    beyond = panel >= panels
    local = np.where(beyond[:, None], 1 - local, local)
    distance = _apart(tau[row][:, None], (tau[row] - start)[:, None] - offset)
    weights = lagrange(order, local) * (np.abs(end - start)[:, None] * v)[..., None]
    return distance, weights, row, np.where(beyond, 2 * panels - 1 - panel, panel)


def _edge(edges: Array, tau: Array, w: Array, order: int) -> Array:
    """The row that takes psi at the nodes to psi(0): least squares on the first panels by what psi begins with."""
    n = TUNING.first * order
    t, root = tau[:n] / edges[TUNING.first], np.sqrt(w[:n])
    powers = [t ** (2 * i) for i in range(1, TUNING.terms + 1)]
    basis = np.stack([np.ones(n), *powers, *(power * np.log(t) for power in powers)], axis=1)
    row = np.zeros(tau.size)
    row[:n] = np.linalg.pinv(basis * root[:, None])[0] * root
    return row

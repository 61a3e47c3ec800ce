"""Product integration of the kernel's logarithmic part on composite Gauss panels.

The symmetrised Nystrom matrix of ``equation`` is Galerkin's with the polynomials l_i of each panel that are 1 at one
Gauss node and 0 at the others, as long as Gauss quadrature may stand for the integrals. Where the kernel tau(|x - t|)
has a logarithm at x = t it may not: here the entries are the integrals themselves,

    K_ij = 1/(w_i w_j) int int l_i(x) (tau(|x - t|) + tau(x + t))/2 l_j(t) dx dt,

so that the matrix stays symmetric, positive definite and nested. On one panel the difference s = x - t has a polynomial
weight and only int tau(s) s^n ds are needed; close panels use quadrature points that crowd at the ends that face each
other; tau(x + t) is the difference to a mirrored panel.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from ...base import Array, EvenCubic
from ..integral import Panels, crowded_rule, rule, to_legendre

Transform = Callable[[Array], Array]


@dataclass(frozen=True)
class ProductTuning:
    """Points of the integrals on panels that lie close to each other."""

    close: float = 2.0  # widths of the wider one, within which panels do; tuned on graded layers, by `make tuning`
    # points along each of two panels, for each node of one: the polynomials of the nodes in a root of three
    crowded: float = 3.0  # tuned on graded layers, by `make tuning`
    least: int = 14  # of those points; tuned on graded layers, by `make tuning`
    per_decade: int = 250  # knots of the spline of tau, good to 1e-9; tuned on graded layers, by `make tuning`


TUNING = ProductTuning()


def _points(order: int) -> int:
    """Points along a panel of ``order`` nodes."""
    return max(TUNING.least, math.ceil(TUNING.crowded * order))


def product_matrix(transform: Transform, panels: Panels) -> Array:
    """Matrix of K at all nodes and, in its last columns and rows, at the radii (of those only the nodes inside count).

    ``transform``: tau(s) [1/m] for s > 0, at most a logarithm at 0; entries [1/m], shape (nodes + radii, nodes +
    radii). The block of the radii among themselves is left at zero.
    """
    n = panels.x.size
    transform = _tabulated(transform, panels)
    total = np.zeros((n + panels.radii.size, n + panels.radii.size))
    total[:n, :n] = (_entries(transform, panels, False) + _entries(transform, panels, True)) / 2
    total[:n, n:] = (_columns(transform, panels, False) + _columns(transform, panels, True)) / 2
    total[n:, :n] = total[:n, n:].T
    return total


def _tabulated(transform: Transform, panels: Panels) -> Transform:
    """A spline over ln(s) in place of tau, several times as fast and good to 1e-9."""
    from scipy.interpolate import CubicSpline

    smallest = float(np.diff(panels.edges).min()) * crowded_rule(2 * _points(panels.order), 3)[0][0]
    ln_s = logarithms(smallest, 2 * float(panels.edges[-1]))
    spline = EvenCubic(ln_s[0], ln_s[1] - ln_s[0], CubicSpline(ln_s, transform(np.exp(ln_s))).c)
    return lambda s: spline(np.log(s))


def logarithms(smallest: float, largest: float) -> Array:
    """Evenly spaced knots ln(s) with which a spline of tau is good to 1e-9."""
    ends = math.log(smallest), math.log(largest)
    return np.linspace(*ends, math.ceil(TUNING.per_decade * (ends[1] - ends[0]) / math.log(10)))


def _entries(transform: Transform, panels: Panels, mirrored: bool) -> Array:
    """Block of the nodes: the part of x - t or, ``mirrored``, of x + t."""
    order, count = panels.order, panels.edges.size - 1
    lo, width = panels.edges[:-1], np.diff(panels.edges)
    plain = _symmetric(transform, panels.x, mirrored).reshape(count, order, count, order)
    gaps = lo[:, None] + lo if mirrored else lo[:, None] - panels.edges[1:]
    right, left = np.nonzero(np.tril(gaps < TUNING.close * np.maximum(width[:, None], width), 0 if mirrored else -1))
    points = _points(order)
    project = _projection(order, points)
    facing = project if mirrored else project[:, ::-1]
    u = crowded_rule(points, 3)[0]
    gap = np.maximum(gaps[right, left], 0.0)[:, None, None]
    values = transform(gap + width[right][:, None, None] * u[:, None] + width[left][:, None, None] * u)
    blocks = np.einsum("bqr,qi,rj->bij", values, project, facing, optimize=True)
    plain[right, :, left, :] = blocks
    plain[left, :, right, :] = blocks.transpose(0, 2, 1)
    if not mirrored:
        each = np.arange(count)
        s, weights = _alone(order, 2 * points)
        plain[each, :, each, :] = np.tensordot(transform(width[:, None] * s), weights, 1)
    return plain.reshape(panels.x.size, -1)


def _columns(transform: Transform, panels: Panels, mirrored: bool) -> Array:
    """Columns of the radii a at the nodes t inside each: the part of a - t or, ``mirrored``, of a + t."""
    order, count = panels.order, panels.edges.size - 1
    lo, width = panels.edges[:-1], np.diff(panels.edges)
    distance = panels.x[:, None] + panels.radii if mirrored else np.abs(panels.x[:, None] - panels.radii)
    plain = transform(distance).reshape(count, order, -1)
    gaps = (lo if mirrored else -panels.edges[1:])[:, None] + panels.radii
    inside = panels.edges[1:, None] <= panels.radii
    panel, radius = np.nonzero(inside & (gaps < TUNING.close * width[:, None]))
    points = _points(order)
    project = _projection(order, points)
    values = transform(gaps[panel, radius][:, None] + width[panel][:, None] * crowded_rule(points, 3)[0])
    plain[panel, :, radius] = values @ (project if mirrored else project[:, ::-1])
    return plain.reshape(panels.x.size, -1)


def _symmetric(transform: Transform, x: Array, mirrored: bool) -> Array:
    """tau of all distances between the nodes, zero where there is none."""
    i, j = np.tril_indices(x.size, 0 if mirrored else -1)
    values = np.zeros((x.size, x.size))
    values[i, j] = values[j, i] = transform(x[i] + x[j] if mirrored else x[i] - x[j])
    return values


@cache
def _projection(order: int, points: int) -> Array:
    """(1/w_i) int l_i f = sum over the crowded nodes q of f_q times this (q, i)."""
    u, v = crowded_rule(points, 3)
    return v[:, None] * lagrange(order, u) / (rule(order)[1] / 2)


@cache
def _alone(order: int, points: int) -> tuple[Array, Array]:
    """Nodes s and weights (s, i, j) of int tau(s) sum over x - t = +s and -s of l_i(x) l_j(t), over w_i w_j."""
    s, v = crowded_rule(points, 3)
    nodes, w = rule(order)
    inside = np.outer(1 - s, (nodes + 1) / 2)
    first, second = lagrange(order, inside), lagrange(order, inside + s[:, None])
    overlap = np.einsum("q,s,sqi,sqj->sij", w / 2, v * (1 - s), first, second, optimize=True)
    return s, (overlap + overlap.transpose(0, 2, 1)) / np.outer(w / 2, w / 2)


def lagrange(order: int, u: Array) -> Array:
    """l_i(u) on [0, 1] for the Gauss nodes, last axis i."""
    return np.polynomial.legendre.legvander(2 * u - 1, order - 1) @ to_legendre(order).T

"""The contact equation discretised, and the nonadhesive contact at all contact radii from its one factor.

On composite Gauss panels whose edges are the wanted radii, the symmetrised matrices A = I + (2/pi) sqrt(w) K sqrt(w) of
smaller radii are leading blocks of the largest one, so are their Cholesky factors L, and running sums over

    y = L^-1 sqrt(w),    z = L^-1 sqrt(w) F

give S = 2 E* sum y^2 and P = delta S - 2 E* sum y z at every radius (a sum of terms of one sign). With one more forward
substitution for the columns K(t, a_n), y and z are known at the radii themselves: delta_H = z(a)/y(a), which phi(a) = 0
means, and S' = (pi^2 E*/2) phi_1(a)^2 = 2 E* y(a)^2.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from typing import Any, Protocol

import numpy as np
from numpy.polynomial import chebyshev, legendre

from ...base.errors import Refusal, SolveError
from ...base.numerics import Array
from ...bodies.indenters import Indenter
from ...bodies.problem import Loading, Quantity
from ...series import Series
from ..radii import ROUGH, Response, Search

# --------------------------------------------------------------------------------------------------
# The Fredholm kernel K(x, t) of the contact equation: what every kernel offers, and sums of cosines.

CHUNK = 256  # nodes in k per matrix product; tuned on ranges, by `make constants`: a bound on the memory


class FredholmKernel(Protocol):
    """Fredholm kernel K(x, t) [1/m] of the contact equation: symmetric, smooth, zero for a homogeneous half-space."""

    @property
    def scale(self) -> float:
        """The length over which K varies [m], about the thickness of the top layer; infinite for K = 0."""
        ...

    def times(self, x: Array, t: Array, values: Array) -> Array:
        """sum_j K(x_i, t_j) values_j (x.size, m) of values (t.size, m)."""
        ...


@dataclass(frozen=True, eq=False)
class CosineKernel:
    """K as a sum of cosines at the nodes ``k`` [1/m], ``weights`` [1/m] = quadrature weights times g - 1.

    K depends on x - t and x + t only, but a matrix of it is a product C D C^T of cosines: it costs less than a table of
    that one function, is symmetric and free of interpolation.
    """

    k: Array
    weights: Array
    scale: float

    def times(self, x: Array, t: Array, values: Array) -> Array:
        total = np.zeros((x.size, values.shape[1]))
        for part in _chunks(self.k.size):
            waves = self.weights[part, None] * (np.cos(np.outer(self.k[part], t)) @ values)
            total += np.cos(np.outer(x, self.k[part])) @ waves
        return total

    def square(self, x: Array) -> Array:
        total = np.zeros((x.size, x.size))
        for sign in (1.0, -1.0):
            k, amplitude = self.k[sign * self.weights > 0], np.sqrt(np.abs(self.weights[sign * self.weights > 0]))
            for part in _chunks(k.size):
                cosines = np.cos(np.outer(x, k[part])) * amplitude[part]
                total += sign * (cosines @ cosines.T)  # one array with its transpose: half the work of two
        return total


def _chunks(count: int) -> Iterator[slice]:
    return (slice(start, start + CHUNK) for start in range(0, count, CHUNK))


# --------------------------------------------------------------------------------------------------
# Gauss quadrature on composite panels: its rules, how many nodes an accuracy needs, and panels with nested radii.

# nodes on a panel over which a function is a power or an exponential; tuned on bodies, by `make constants`: exact to
# rounding
EXACT = 12

# How nodes are planned for an accuracy of the contact equation.
QUADRATURE_MOST_NODES = 10  # on a panel; tuned on bodies, by `make constants`: beyond, narrower panels are as cheap
# Times the kernel's scale: highest wave number noticed:
QUADRATURE_FREQUENCY = 5.0  # tuned on reference bodies, by `make tuning`
# of panels, from one refinement to the next where phi is not smooth; choice: what a step costs
QUADRATURE_NARROWER = 1.5
# Crowding of panels before each radius under a kernel with a logarithm, where phi is not smooth at its edge:
QUADRATURE_UNSMOOTH_NODES = 4  # least on a panel; tuned on graded layers, by `make tuning`
# Error there: square of this, the panel's width, the logarithm's strength:
QUADRATURE_EDGE = 0.03  # tuned on reference bodies, by `make tuning`
QUADRATURE_MOST_CUTS = 8  # tuned on graded layers, by `make tuning`
QUADRATURE_SHRINK = 0.2  # ratio of successive panels; tuned on graded layers, by `make tuning`


@cache
def rule(order: int) -> tuple[Array, Array]:
    """Gauss-Legendre nodes and weights on [-1, 1], read-only."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    nodes.setflags(write=False)
    weights.setflags(write=False)
    return nodes, weights


def to_legendre(order: int) -> Array:
    """Matrix from values at the Gauss nodes (..., order) to the coefficients of their Legendre polynomials."""
    nodes, weights = rule(order)
    return np.polynomial.legendre.legvander(nodes, order - 1) * (np.arange(order) + 0.5) * weights[:, None]


def lagrange(order: int, u: Array) -> Array:
    """l_i(u) on [0, 1] for the Gauss nodes, last axis i."""
    return legendre.legvander(2 * u - 1, order - 1) @ to_legendre(order).T


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


def distinct(values: Any) -> Array:
    """Each of the ``values`` once, in rising order; the counts keep NumPy from loading its masked arrays, 10 ms."""
    return np.unique(values, return_counts=True)[0]


def split(lo: Array, hi: Array, pieces: Array) -> tuple[Array, Array]:
    """Every panel (lo, hi) cut into the given number of equal pieces, in order."""
    step = np.repeat((hi - lo) / pieces, pieces)
    start = np.repeat(lo, pieces)
    index = np.arange(pieces.sum()) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    return start + index * step, start + (index + 1) * step


def phase_allowed(order: int, error: Array | float) -> Array | float:
    """The phase k d [rad] that ``order`` Gauss nodes integrate with a relative ``error``: C (k d)^(2 order) of cos(kx)
    on a panel of the width d."""
    ln_C = 4 * math.lgamma(order + 1) - 3 * math.lgamma(2 * order + 1) - math.log(2 * order + 1)
    return error ** (1 / (2 * order)) * math.exp(-ln_C / (2 * order))


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
        widths = np.diff(distinct(np.concatenate([[0.0, a0], radii])))
        plans = []
        for order in orders or range(1, QUADRATURE_MOST_NODES + 1):
            widest = float(phase_allowed(order, tolerance)) * scale / QUADRATURE_FREQUENCY
            pieces = np.ceil(widths / widest) if math.isfinite(widest) else np.ones(widths.size)
            plans.append(cls(order, widest, int(order * np.maximum(pieces, 1).sum())))
        return min(plans, key=lambda plan: plan.nodes)

    @classmethod
    def crowded(
        cls, radii: Array, a0: float, scale: float, tolerance: float, strength: float,
        orders: Iterable[int] = range(QUADRATURE_UNSMOOTH_NODES, QUADRATURE_MOST_NODES + 1),
        most_cuts: float = QUADRATURE_MOST_CUTS,
    ) -> Quadrature:  # fmt: skip
        """Quadrature as by ``cheapest``, with panels that crowd before each radius, for a kernel -``strength`` ln |x -
        t| [1/m]."""
        plain = cls.cheapest(radii, a0, scale, tolerance, orders)
        wide = min(float(np.max(np.diff(radii, prepend=0.0))), plain.widest)
        excess = QUADRATURE_EDGE * strength * wide / math.sqrt(tolerance)
        cuts = int(min(math.ceil(math.log(max(excess, 1.0)) / -math.log(QUADRATURE_SHRINK)), most_cuts))
        return cls(plain.order, plain.widest, plain.nodes + plain.order * cuts * radii.size, cuts)

    def finer(self) -> Quadrature:
        """Quadrature of one or two more nodes on the same panels: at least one order of magnitude more accurate."""
        order = self.order + (1 if self.order <= 4 else 2)
        nodes, crowding = self.nodes // self.order * order, self.crowding + bool(self.crowding)
        return replace(self, order=order, nodes=nodes, crowding=crowding, inner=self.inner + 8)

    def narrower(self) -> Quadrature:
        """Quadrature of narrower panels and the same order, more crowded: product integration loses accuracy at higher
        orders."""
        nodes, widest = math.ceil(self.nodes * QUADRATURE_NARROWER), self.widest / QUADRATURE_NARROWER
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

        The last panel before each radius is cut ``quadrature.crowding`` times, at ``QUADRATURE_SHRINK`` of its width
        from the radius, for a solution that is not smooth at the edge of its contact.
        """
        radii = np.asarray(radii, dtype=float)
        edges = distinct(np.concatenate([[0.0], [a0] if a0 < radii[-1] else [], radii]))
        pieces = np.maximum(np.ceil(np.diff(edges) / quadrature.widest * (1 - 1e-12)), 1).astype(int)
        lo, _ = split(edges[:-1], edges[1:], pieces)
        edges = np.append(lo, radii[-1])
        before = edges[np.searchsorted(edges, radii) - 1]
        cuts = radii[:, None] - (radii - before)[:, None] * QUADRATURE_SHRINK ** np.arange(1, quadrature.crowding + 1)
        edges = np.sort(np.concatenate([edges, np.ravel(cuts)]))
        x, w = gauss(edges[:-1], edges[1:], *rule(quadrature.order))
        return cls(edges, quadrature.order, radii, x, w, quadrature.order * np.searchsorted(edges, radii))


@dataclass(frozen=True, eq=False)
class DiscreteEquation:
    """The contact equation on ``panels``, factorised, for any right-hand side.

    ``factor``: lower Cholesky factor of A; ``columns``: (2/pi) sqrt(w) K(x, a_n) of the radii a_n;
    ``largest``: the largest (2/pi) |K(x, x)| [1/m].
    """

    panels: Panels
    factor: Array
    columns: Array
    largest: float

    @classmethod
    def of(cls, K: Array, panels: Panels) -> DiscreteEquation:
        """Equation of the kernel ``K`` [1/m] at the ``places`` of the panels.

        Raises SolveError where A is not positive definite: the panels do not resolve the kernel.
        """
        n, root = panels.x.size, np.sqrt(panels.w)
        K = 2 / math.pi * K
        factor = nested_factor(K[:n, :n], root, panels, "the kernel")
        return cls(panels, factor, root[:, None] * K[:n, n:], np.max(np.abs(np.diag(K))))

    def forward(self, nodes: Array, edges: Array) -> tuple[Array, Array]:
        """Halves L^-1 sqrt(w) U (m, nodes) and the ends (pi/2) phi(a) (m, radii) of the solutions for the m right-hand
        sides (2/pi) U, given at the ``nodes`` (m, nodes) and at the radii, ``edges`` (m, radii)."""
        right = np.column_stack([*(np.sqrt(self.panels.w) * nodes), self.columns])
        forward = forward_substitution(self.factor, right)
        halves, columns = forward[:, : len(nodes)].T, forward[:, len(nodes) :]
        last, each = self.panels.stops - 1, np.arange(self.panels.radii.size)
        sums = [np.cumsum(half[:, None] * columns, axis=0)[last, each] for half in halves]
        return halves, edges - np.array(sums)

    def density(self, n: int, U: Array) -> Array:
        """Density phi at the nodes inside the radius n for the right-hand side (2/pi) ``U``, given there; in the unit
        of U."""
        stop = int(self.panels.stops[n])
        root, factor = np.sqrt(self.panels.w[:stop]), self.factor[:stop, :stop]
        half = forward_substitution(factor, 2 / math.pi * root * U)
        return forward_substitution(factor.T[::-1, ::-1], half[::-1])[::-1] / root


def nested_factor(K: Array, root: Array, panels: Panels, kernel: str) -> Array:
    """Lower Cholesky factor of I + sqrt(w) K sqrt(w), ``root`` the sqrt(w).

    SolveError, which calls K by ``kernel``, where that is not positive definite.
    """
    A = K * root
    A *= root[:, None]
    A.flat[:: root.size + 1] += 1.0
    try:
        return np.linalg.cholesky(A)
    except np.linalg.LinAlgError:
        raise SolveError(
            f"contact equation: {panels.x.size} nodes up to a = {panels.radii[-1]:g} m do not resolve {kernel} "
            "(matrix not positive definite)"
        ) from None


def rounding_error(panels: Panels, largest: float, S: Array) -> Array:
    """Relative error at each radius from the rounding of K, whose entries are at most ``largest`` [1/m].

    It is counted against the smallest eigenvalue, which a/S bounds (S for 2 E* = 1).
    """
    a = panels.radii
    return 4 * np.finfo(float).eps * (8 + a * largest) * np.maximum(S / a, 1)


def forward_substitution(L: Array, b: Array, block: int = 64) -> Array:
    """L^-1 b of a lower triangular L, in blocks: products of matrices, and LAPACK's dense solver on the diagonal.

    NumPy has no triangular solver; to import SciPy's takes a third of the time of a whole ``jkr run``.
    """
    x = np.empty_like(b)
    for start in range(0, len(L), block):
        rows = slice(start, start + block)
        x[rows] = np.linalg.solve(L[rows, rows], b[rows] - L[rows, :start] @ x[:start])
    return x


@dataclass(frozen=True, eq=False)
class ContactResult:
    """Nonadhesive contact at the radii of the ``panels``: delta [m], P [N], S [N/m], dS [N/m^2]; ``rounding``: relative
    error that the rounding of K lets expect at each radius."""

    panels: Panels
    delta: Array
    P: Array
    S: Array
    dS: Array
    rounding: Array

    @property
    def columns(self) -> Array:
        """Rows delta, P, S, S'."""
        return np.array([self.delta, self.P, self.S, self.dS])


@dataclass(frozen=True, eq=False)
class EquationResult(ContactResult):
    """Contact of an ``indenter`` at all radii of the ``equation``, with the right-hand side it was solved for.

    ``F``: panel means of the Abel image at the nodes [m].
    """

    indenter: Indenter
    equation: DiscreteEquation
    F: Array

    def density(self, n: int, adhesive_shift: float = 0.0) -> tuple[Array, Array, Array]:
        """Nodes, weights [m] and phi [m] there, at radius n, for the displacement delta_H - ``adhesive_shift`` [m]."""
        inside = slice(int(self.panels.stops[n]))
        phi = self.equation.density(n, self.delta[n] - adhesive_shift - self.F[inside])
        return self.panels.x[inside], self.panels.w[inside], phi


def solve(K: Array, panels: Panels, indenter: Indenter, E_star: float, inner: int = 20) -> EquationResult:
    """Nonadhesive contact of an ``indenter`` at all radii, from the kernel ``K`` [1/m] at the places of the ``panels``;
    ``inner``: Gauss nodes per panel in the integrals of F.

    Raises SolveError where the nodes are too coarse: the equation or S' is not positive.
    """
    equation = DiscreteEquation.of(K, panels)
    a, last = panels.radii, panels.stops - 1
    F = panel_means(indenter.abel, np.array(indenter.joints), panels.edges, panels.order, inner)
    sides, ends = np.array([np.ones_like(F), F]), np.array([np.ones_like(a), indenter.abel(a)])
    (y, z), (y_edge, z_edge) = equation.forward(sides, ends)
    if not (y_edge > 0).all():
        raise SolveError(f"contact equation: S' is not positive at a = {a[np.argmin(y_edge)]:g} m: nodes too coarse")
    delta = z_edge / y_edge
    S, products = np.cumsum(y**2)[last], np.cumsum(y * z)[last]
    P, scale = delta * S - products, 2 * E_star
    rounding = rounding_error(panels, equation.largest, S)
    return EquationResult(panels, delta, scale * P, scale * S, scale * y_edge**2, rounding, indenter, equation, F)


def panel_means(f: Callable[[Array], Array], cuts: Array, edges: Array, order: int, inner: int) -> Array:
    """Values of ``f`` at ``order`` Gauss nodes on each panel between the increasing ``edges``, replaced there by its
    projection on polynomials of degree order - 1.

    Sums of w f q over the nodes are then exact integrals of f q for such polynomials q, whatever kinks f has at the
    ``cuts``: only the kernel limits the accuracy. The integrals place ``inner`` nodes quadratically above each cut and
    edge, where f may begin like (x - b)^(3/2) or x^d.
    """
    cuts = distinct(np.concatenate([edges, cuts[cuts < edges[-1]]]))
    lo, hi = cuts[:-1], cuts[1:]
    owner = np.searchsorted(edges, lo, side="right") - 1
    x, w = crowded(lo, hi, inner)
    width = np.diff(edges)
    local = np.clip(2 * (x - edges[owner][:, None]) / width[owner][:, None] - 1, -1, 1)
    moments = np.einsum("pq,pqn->pn", w * f(x), np.polynomial.legendre.legvander(local, order - 1))
    per_panel = np.zeros((width.size, order))
    np.add.at(per_panel, owner, moments)
    nodes, _ = rule(order)
    basis = np.polynomial.legendre.legvander(nodes, order - 1) * (2 * np.arange(order) + 1)
    return np.ravel(per_panel @ basis.T / width[:, None])


# --------------------------------------------------------------------------------------------------
# Legendre polynomials on panels, orthonormal: the functions on which a smooth kernel is a small matrix.
#
# K(x, t) = sum b_i(x) K_ij b_j(t) holds to the accuracy with which polynomials follow K on a panel, whatever
# densities it acts on. Contact radii then need no edges of panels of their own: a disc cuts one panel, whose
# integrals are exact.

Function = Callable[[Array], Array]


@cache
def in_chebyshev(order: int) -> tuple[Array, Array]:
    """Legendre polynomials b_j = sqrt(2 j + 1) L_j, of norm 1 on (0, 1), as sums of Chebyshev's, b = T A, and their
    derivatives on (-1, 1) as sums of themselves, b' = b D: two matrices (order, order)."""
    norms = np.sqrt(2 * np.arange(order) + 1)
    A, D = np.zeros((order, order)), np.zeros((order, order))
    for j, unit in enumerate(np.eye(order)):
        terms, by_y = chebyshev.poly2cheb(legendre.leg2poly(unit)), legendre.legder(unit)
        A[: terms.size, j] = terms * norms[j]
        D[: by_y.size, j] = by_y * norms[j] / norms[: by_y.size]
    return A, D


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

    @property
    def projection(self) -> Array:
        """Matrix from values at the nodes of the panels to the integrals of b times what has these values."""
        nodes, weights = rule(self.order)
        once = legendre.legvander(nodes, self.order - 1).T * weights * np.sqrt(np.arange(self.order) + 0.5)[:, None]
        return np.kron(np.diag(np.sqrt(np.diff(self.panels.edges) / 2)), once)

    @property
    def widths(self) -> Array:
        """Widths [m] of the panels."""
        return np.diff(self.panels.edges)

    def panel_of(self, x: Array) -> Array:
        """Number of the panel that holds each x; the upper one at an edge, the last one at the end."""
        return np.minimum(np.maximum(self.panels.edges.searchsorted(x, side="right") - 1, 0), self.count - 1)

    def local(self, x: Array, panel: Array) -> Array:
        """Values of the polynomials of each point's ``panel``, (..., order)."""
        lo, width = self.panels.edges[panel], self.widths[panel]
        angles = np.arccos(np.minimum(np.maximum(2 * (x - lo) / width - 1, -1.0), 1.0))[..., None]
        return np.cos(np.arange(self.order) * angles) @ in_chebyshev(self.order)[0] / np.sqrt(width[..., None])

    def at(self, x: Array) -> Array:
        """All polynomials at the points ``x``, (x.size, size)."""
        panel = self.panel_of(x)
        return self.scattered(np.arange(x.size), panel, self.local(x, panel), x.size)

    def integral(self, moments: Array) -> Array:
        """The integrals of functions from the integrals of all polynomials times these, ``moments`` (n, size)."""
        return moments.reshape(-1, self.count, self.order)[:, :, 0] @ np.sqrt(self.widths)

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
        cuts = distinct(np.concatenate([edges, self.kinks[self.kinks < edges[-1]]]))
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

    def arcs(self, a: Array, b: Array) -> Array:
        """int_a^c F(x)/sqrt(c^2 - x^2) dx [m] for c = a + b."""
        return abel_arcs(self.F, self.kinks, a, b, self.inner)


def abel_arcs(F: Function, kinks: Array, a: Array, b: Array, inner: int) -> Array:
    """int_a^c F(x)/sqrt(c^2 - x^2) dx [m] for c = a + b, by x = c cos(psi), with ``inner`` nodes above each kink."""
    row, _, upper, lower = cut_angles(np.array([0.0, *kinks, np.inf]), a, b)
    u, v = crowded_rule(inner, 2)
    psi = upper[:, None] - (upper - lower)[:, None] * u
    values = F((a + b)[row][:, None] * np.cos(psi))
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


# --------------------------------------------------------------------------------------------------
# A pair of bodies whose kernel is known: contact radii for any loading, and the series that a method returns.

COLUMNS = ("delta", "P", "S", "dS")
LOOSEST = 1e-2  # tolerance of a method; choice: no worse result is worth a method without a mesh

FLOPS_PER_SECOND = 1e10  # of the dense algebra; tuned on series of 100 to 2000 points, by `make bench`


class Contact(Protocol):
    """An indenter on a body whose kernel is known.

    ``scale``: the length over which the kernel varies [m]; ``limit``: the radius up to which it is known [m]. Beyond it
    a search may try its steps, but its result means "more than that".
    """

    @property
    def indenter(self) -> Indenter: ...

    @property
    def E_star(self) -> float: ...

    @property
    def scale(self) -> float: ...

    @property
    def limit(self) -> float: ...

    def plan(self, radii: Array, tolerance: float) -> Any:
        """A discretisation expected to be accurate to ``tolerance`` at the increasing ``radii`` [m]."""
        ...

    def solved(self, radii: Array, plan: Any) -> Any:
        """Nonadhesive contact at the increasing ``radii`` [m]."""
        ...


class InaccurateError(Refusal):
    """Refusal: the tolerance was not reached; ``fixed``: the message where the tolerance is not the user's to choose;
    ``reached``: the relative error in its place, infinite where that is not known."""

    def __init__(self, lines: str | Sequence[str], fixed: str, reached: float = math.inf):
        super().__init__(lines)
        self.fixed, self.reached = fixed, reached

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.lines, self.fixed, self.reached)

    @property
    def would_do(self) -> float:
        """The tolerance that is advised in place of the one that was not reached."""
        return 2 * self.reached


def search(contact: Contact, loading: Loading, accuracy: float) -> Search:
    """The search for the radii of a ``loading``; depths and loads are met to the relative ``accuracy``."""
    accuracies = max(ROUGH, accuracy), accuracy
    return Search(loading, contact.indenter, contact.E_star, partial(response, contact), accuracies, contact.scale)


def response(contact: Contact, to: Quantity, accuracy: float) -> Response:
    """Function delta_H or P_H of the contact radius, with a quadrature planned for ``accuracy``."""
    name, a0 = {"depth": "delta", "load": "P"}[to], contact.indenter.a0
    most = math.sqrt((contact.limit - a0) * (contact.limit + a0))

    def at(radii: Array) -> Array:
        v = np.sqrt((radii - a0) * (radii + a0))
        beyond = max(float(v[-1]) / most, 1.0)
        inside = radii if beyond == 1 else np.hypot(a0, v / beyond)
        values: Array = getattr(contact.solved(inside, contact.plan(inside, accuracy / 4)), name)
        if beyond == 1:
            return values
        # The power of v = sqrt(a^2 - a0^2) with which a response goes on beyond its last two points; of one
        # alone, the second
        ends = np.log(v[-2:]), np.log(values[-2:])
        power = float(np.diff(ends[1])[0] / np.diff(ends[0])[0]) if v.size > 1 else 2.0
        return values * beyond**power

    return at


def series_of(result: ContactResult, errors: Array, contact: Contact, tolerance: float) -> Series:
    """The series of a ``result`` of a ``contact`` with relative ``errors`` (radii,) or, one row for each of
    ``COLUMNS``, (4, radii); S at first touch is solved to the ``tolerance``."""
    radii, a0, S0 = result.panels.radii, contact.indenter.a0, 0.0
    if a0 > 0:  # that of a flat punch
        first = np.array([a0])
        S0 = float(contact.solved(first, contact.plan(first, tolerance)).S[0])
    columns = dict(zip(COLUMNS, result.columns, strict=True))
    absolute = dict(zip(COLUMNS, errors * result.columns, strict=True))
    return Series(radii, **columns, errors=absolute | {"a": 0 * radii}, a0=a0, S0=S0)


def tolerance_remedy(method: str, error: float) -> str:
    """Advice to accept the relative ``error`` that was reached, empty where no such tolerance is allowed."""
    return f"set {method}.tolerance to {2 * error:.0e}, or " if 2 * error <= LOOSEST else ""

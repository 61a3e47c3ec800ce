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
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...base import Array, SolveError
from ...bodies import Indenter
from .quadrature import Panels, crowded, rule


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
    cuts = np.unique(np.concatenate([edges, cuts[cuts < edges[-1]]]))
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

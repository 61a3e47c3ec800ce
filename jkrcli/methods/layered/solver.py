"""Nested solution of the contact equation for all contact radii at once.

    phi(x) + (2/pi) int_0^a K(x,t) phi(t) dt = (2/pi) (delta - F(x)),    0 <= x <= a        (Lebedev-Ufliand)

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
from scipy.linalg import solve_triangular

from ...base.errors import SolveError
from ...bodies.indenters import Indenter, TableProfile
from .kernel import Kernel, gauss, rule, split

Array = np.ndarray
SHRINK = 0.2


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

    @classmethod
    def through(
        cls, radii: Array, order: int, widest: float, breaks: tuple[float, ...] = (), crowding: int = 0
    ) -> Panels:
        """Panels with edges at all ``radii`` (increasing, > 0) and ``breaks``, none wider than ``widest`` [m].

        ``crowding``: so many times the last panel before each radius is cut at ``SHRINK`` of its width from the radius,
        for a solution that is not smooth at the edge of its contact.
        """
        radii = np.asarray(radii, dtype=float)
        inner = [b for b in breaks if 0 < b < radii[-1]]
        edges = np.unique(np.concatenate([[0.0], inner, radii]))
        pieces = np.maximum(np.ceil(np.diff(edges) / widest * (1 - 1e-12)), 1).astype(int)
        lo, _ = split(edges[:-1], edges[1:], pieces)
        edges = np.append(lo, radii[-1])
        before = edges[np.searchsorted(edges, radii) - 1]
        cuts = radii[:, None] - (radii - before)[:, None] * SHRINK ** np.arange(1, crowding + 1)
        edges = np.sort(np.concatenate([edges, np.ravel(cuts)]))
        x, w = gauss(edges[:-1], edges[1:], *rule(order))
        return cls(edges, order, radii, x, w, order * np.searchsorted(edges, radii))


@dataclass(frozen=True, eq=False)
class Nested:
    """Nonadhesive contact at the radii of ``panels``: delta [m], P [N], S [N/m], dS [N/m^2], and what phi needs later.

    ``factor``: lower Cholesky factor of the symmetrised matrix; ``F``: panel means of the Abel image at the nodes [m];
    ``rounding``: relative error that the rounding of K lets expect at each radius.
    """

    panels: Panels
    E_star: float
    delta: Array
    P: Array
    S: Array
    dS: Array
    factor: Array
    F: Array
    rounding: Array

    def density(self, n: int, adhesive_shift: float = 0.0) -> tuple[Array, Array, Array]:
        """Nodes, weights [m] and phi [m] there, at radius n, for the displacement delta_H - ``adhesive_shift`` [m]."""
        stop = int(self.panels.stops[n])
        x, w, factor = self.panels.x[:stop], self.panels.w[:stop], self.factor[:stop, :stop]
        right = 2 / math.pi * np.sqrt(w) * (self.delta[n] - adhesive_shift - self.F[:stop])
        half = solve_triangular(factor, right, lower=True, check_finite=False)
        phi = solve_triangular(factor, half, lower=True, trans="T", check_finite=False) / np.sqrt(w)
        return x, w, phi


@dataclass(frozen=True)
class AbelImage:
    """F(x) [m] of an indenter, the radii ``breaks`` [m] of its kinks, and ``inner`` nodes per panel for its means."""

    F: Callable[[Array], Array]
    breaks: tuple[float, ...] = ()
    inner: int = 20

    @classmethod
    def of(cls, indenter: Indenter, inner: int = 20) -> AbelImage:
        knots = indenter.knots if isinstance(indenter, TableProfile) else (indenter.a0,)
        return cls(indenter.abel, tuple(float(b) for b in knots if b > 0), inner)


def solve(kernel: Kernel, panels: Panels, image: AbelImage, E_star: float, singular: Array | None = None) -> Nested:
    """Nonadhesive contact of an indenter with the Abel image ``image`` at all radii of ``panels``.

    ``singular``: what is to be added to the smooth ``kernel`` at the nodes and radii (``product_matrix``).
    Raises SolveError where the matrix is not positive definite, which means that the panels do not resolve the kernel.
    """
    n, root = panels.x.size, np.sqrt(panels.w)
    F = panel_means(image, panels)
    K = kernel.square(np.concatenate([panels.x, panels.radii]))
    K = 2 / math.pi * (K if singular is None else K + singular)
    A = root[:, None] * K[:n, :n] * root + np.eye(n)
    try:
        factor = np.linalg.cholesky(A)
    except np.linalg.LinAlgError:
        raise SolveError(
            f"contact equation: {n} nodes up to a = {panels.radii[-1]:g} m do not resolve the kernel "
            "(matrix not positive definite)"
        ) from None
    right = np.column_stack([root, root * F, root[:, None] * K[:n, n:]])
    forward = solve_triangular(factor, right, lower=True, check_finite=False, overwrite_b=True)
    delta, P, S, dS = _running_sums(panels, forward, image.F(panels.radii))
    scale = 2 * E_star
    return Nested(panels, E_star, delta, scale * P, scale * S, scale * dS, factor, F, _rounding(panels, K, S))


def _running_sums(panels: Panels, forward: Array, F_edge: Array) -> tuple[Array, Array, Array, Array]:
    """delta, and P, S, S' for 2 E* = 1."""
    y, z, columns = forward[:, 0], forward[:, 1], forward[:, 2:]
    last, each = panels.stops - 1, np.arange(panels.radii.size)
    y_edge = 1 - np.cumsum(y[:, None] * columns, axis=0)[last, each]
    z_edge = F_edge - np.cumsum(z[:, None] * columns, axis=0)[last, each]
    if not (y_edge > 0).all():
        raise SolveError(
            f"contact equation: S' is not positive at a = {panels.radii[np.argmin(y_edge)]:g} m: nodes too coarse"
        )
    delta = z_edge / y_edge
    S, products = np.cumsum(y**2)[last], np.cumsum(y * z)[last]
    return delta, delta * S - products, S, y_edge**2


def _rounding(panels: Panels, K: Array, S: Array) -> Array:
    """Rounding of the entries of K, counted against the smallest eigenvalue, which a/S bounds (S for 2 E* = 1)."""
    a = panels.radii
    entries = a * np.max(np.abs(np.diag(K)))
    return 4 * np.finfo(float).eps * (8 + entries) * np.maximum(S / a, 1)


def panel_means(image: AbelImage, panels: Panels) -> Array:
    """F at the nodes, replaced on each panel by its projection on polynomials of degree order - 1 [m].

    Sums of w F q over the nodes are then exact integrals of F q for such polynomials q, whatever kinks F has: only
    the kernel limits the accuracy. The integrals cut panels at the breaks of F and place nodes quadratically above each
    left end, where F may begin like (x - b)^(3/2) or x^d.
    """
    edges, order = panels.edges, panels.order
    cuts = np.unique(np.concatenate([edges, [b for b in image.breaks if 0 < b < edges[-1]]]))
    lo, hi = cuts[:-1], cuts[1:]
    owner = np.searchsorted(edges, lo, side="right") - 1
    u, v = rule(image.inner)
    u, v = (u + 1) / 2, v / 2
    x = lo[:, None] + (hi - lo)[:, None] * u**2
    w = (hi - lo)[:, None] * (2 * u * v)
    width = np.diff(edges)
    local = np.clip(2 * (x - edges[owner][:, None]) / width[owner][:, None] - 1, -1, 1)
    moments = np.einsum("pq,pqn->pn", w * image.F(x), np.polynomial.legendre.legvander(local, order - 1))
    per_panel = np.zeros((width.size, order))
    np.add.at(per_panel, owner, moments)
    nodes, _ = rule(order)
    basis = np.polynomial.legendre.legvander(nodes, order - 1) * (2 * np.arange(order) + 1)
    return np.ravel(per_panel @ basis.T / width[:, None])

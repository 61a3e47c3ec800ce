"""Contact without slip on a layered specimen: it grows while it sticks, from the flat ends of all radii.

A disc of radius b that sticks and is pressed down by d(delta) moves the surface outside; a point is touched when it has
come up to the profile, and keeps its radial displacement. In the densities below, with E_j(s; b) what an end of
radius b lacks at s > b to its own displacement, and F the Abel image of the profile,

    D_j(s) = int_0^s E_j(s; b) delta'(b) db,         F(x) = (1/Lambda) int_0^x (Z_1(x, s) D_1(s) + Z_2(x, s) D_2(s)) ds,

a Volterra equation for delta_H; then P_H = int S d(delta_H). Z gives back what lies on top of each other in the rings'
fields of a compressible half-space: with s = x tanh(tau), Z_1 ds = 2 eta sin(2 eta tau) d(tau), Z_2 ds = -2 eta
tanh(tau) cos(2 eta tau) d(tau), each as the limit of a decaying exponential (eta = 0: F = D_1).

It is collocated: the unknown is q = d(delta)/dF, which is smooth where F is not, a polynomial on each of some pieces.
With the right ends of the pieces among the nodes (Radau) errors do not grow from piece to piece, as they would with
Gauss nodes (Brunner, Collocation Methods for Volterra Integral Equations, Sec. 2.4).

The spectra are those of a layered specimen: the minors of the stack hold the whole surface compliance, F_rr and F_rz
beside F_zz. An elastic indenter adds its own, a half-space's or that of its layers, with F_rz of the opposite sign:
both bodies squeeze towards the same side.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from typing import TypeAlias

import numpy as np
from numpy.polynomial import legendre, polynomial

from ...base.errors import Refusal
from ...base.numerics import ROUNDED, Array
from ...bodies.indenters import Indenter
from ...bodies.problem import AnyGraded, AnyTransverse, Coated, Material, Specimen
from ..integral import fredholm
from ..integral.density import DENSITY_WIDEST
from .contact import LAYERED_MOST_FLOPS, IndenterOnLayers
from .spectrum import LayeredSpectrum, LayerMedium, minors_of, resolved, shear_moduli

# --------------------------------------------------------------------------------------------------
# Regular Coulomb waves of order zero, which take the place of sine and cosine where the edge of a contact oscillates.
#
# F(eta, rho) obeys F'' = (2 eta/rho - 1) F, F(0) = 0, F'(0) = C, C^2 = 2 pi eta/(exp(2 pi eta) - 1) (Abramowitz and
# Stegun 14.1). F(0, rho) = sin rho. Power series at the origin, Taylor series from step to step beyond it.

# Series of the waves.
COULOMB_FIRST = 4.0  # rho up to which the series at the origin is summed; theory: its terms stay below exp(4)
COULOMB_FIRST_TERMS = 40  # theory: 4^40/40! is below rounding
COULOMB_TERMS = 18  # of each centre beyond, 1 from the next; theory: 1/18! is below rounding


def amplitude(eta: float) -> float:
    """C = F'(eta, 0)."""
    return math.sqrt(2 * math.pi * eta / math.expm1(2 * math.pi * eta)) if eta else 1.0


def coulomb_waves(eta: float, rho: Array) -> tuple[Array, Array]:
    """F(eta, rho) and F'(eta, rho) for rho >= 0; |eta| < 1/2. Absolute error about 1e-14 per hundred rho."""
    if eta == 0:
        return np.sin(rho), np.cos(rho)
    F, slope = np.empty_like(rho), np.empty_like(rho)
    near = rho < COULOMB_FIRST
    series = coulomb_series(eta)
    F[near] = polynomial.polyval(rho[near], series)
    slope[near] = polynomial.polyval(rho[near], polynomial.polyder(series))
    if not near.all():
        # Taylor's coefficients (terms, i) of F about centres rho_i, each row from the end of the one before
        centres = COULOMB_FIRST + np.arange(math.ceil(float(rho.max()) - COULOMB_FIRST) + 1)
        start = [float(polynomial.polyval(centres[0], s)) for s in (series, polynomial.polyder(series))]
        rows = [_taylor(eta, float(centres[0]), *start)]
        for centre in centres[1:]:
            value, rate = rows[-1].sum(), rows[-1] @ np.arange(rows[-1].size)
            rows.append(_taylor(eta, float(centre), float(value), float(rate)))
        table = np.array(rows).T
        row = np.rint(rho[~near] - centres[0]).astype(int)
        ahead = rho[~near] - centres[row]
        for wave, terms in ((F, table), (slope, polynomial.polyder(table))):  # sums of terms[m, row] ahead^m
            total = terms[-1][row]
            for term in terms[-2::-1]:
                total *= ahead
                total += term[row]
            wave[~near] = total
    return F, slope


def coulomb_series(eta: float) -> Array:
    """Coefficients of F at the origin."""
    c = [0.0, amplitude(eta)]
    for m in range(2, COULOMB_FIRST_TERMS):
        c.append((2 * eta * c[m - 1] - c[m - 2]) / (m * (m - 1)))
    return np.array(c)


def _taylor(eta: float, rho: float, F: float, slope: float) -> Array:
    """Taylor coefficients of F about ``rho``, from (rho + d) F'' = (2 eta - rho - d) F."""
    t = [F, slope]
    for m in range(2, COULOMB_TERMS + 1):
        before = t[m - 3] if m > 2 else 0.0
        t.append(((2 * eta - rho) * t[m - 2] - before - (m - 1) * (m - 2) * t[m - 1]) / (rho * m * (m - 1)))
    return np.array(t)


# --------------------------------------------------------------------------------------------------
# The contact equation of a disc that sticks: two densities, for the pressure and for the shear.
#
# With the Hankel transforms p_hat of the pressure and q_hat of the shear on the surface, the displacements are
#
#     u_z^ = 2/(E* k) (g_zz p_hat + g_zr q_hat),     u_r^ = 2/(E* k) (g_zr p_hat + g_rr q_hat),
#
# and deep inside the top material g_zz = g_rr = 1, g_zr = beta (Dundurs's constant; 0 at nu = 1/2). Where beta = 0
# let p_hat = (E*/2) int phi cos(kt) dt, q_hat = (E*/2) int psi sin(kt) dt over (0, a). Else the half-space's own
# equation is singular and its solution oscillates at the edge; it is solved in closed form by Coulomb waves F(eta,
# kt) in place of sine and cosine, with tanh(pi eta) = beta and X+- = (F'(-+eta) , +-F(-+eta))/sqrt(1 +- beta) for
# (phi, psi):
#
#     p_hat = (E*/2) int (C phi_1 + C psi_2),  C = (X+ + X-)/2,       q_hat likewise with Q = (X+ - X-)/2.
#
# These fields of rings do no work on each other in a half-space (they stick inside their ring, and the outer ring's
# displacements vanish there), so that for any body, with d_zz = g_zz - 1, d_zr = g_zr - beta, d_rr = g_rr - 1 that
# decay,
#
#     xi + (2/pi) int K xi dt = (2/pi) (Lambda, 0),     K = int (d_zz C C^T + d_zr (C Q^T + Q C^T) + d_rr Q Q^T) dk
#
# for a unit displacement, Lambda^2 = pi eta coth(pi eta). S = pi E* Lambda int xi_1, S' = (pi^2 E*/2) |xi(a)|^2. The
# matrices are nested as those of ``fredholm``, with two rows for each node.

Pair: TypeAlias = tuple[Array, Array]


@dataclass(frozen=True, eq=False)
class StuckKernel:
    """The no-slip kernel, of both densities: ``weights`` (3, k) are those of quadrature at the wave numbers ``k`` [1/m]
    times d_zz, d_zr, d_rr; ``beta``: Dundurs's constant."""

    k: Array
    weights: Array
    beta: float

    @property
    def eta(self) -> float:
        """Oscillation index of the edge."""
        return math.atanh(self.beta) / math.pi

    @property
    def Lambda(self) -> float:
        """Root of the half-space's stiffness over that of the sliding one."""
        return math.sqrt(math.pi * self.eta / math.tanh(math.pi * self.eta)) if self.eta else 1.0

    def square(self, x: Array) -> Array:
        """K (2n, 2n) at the nodes ``x`` (n,) [m]: both densities of the first node, both of the second, ..."""
        n, K = x.size, np.zeros((2, 2, x.size, x.size))
        zz, zr, rr = self.weights
        if self.eta == 0:
            sine, cosine = coulomb_waves(0.0, np.outer(x, self.k))
            K[0, 0], K[1, 1] = (cosine * zz) @ cosine.T, (sine * rr) @ sine.T
            K[0, 1] = (cosine * zr) @ sine.T
            K[1, 0] = K[0, 1].T
        elif self.k.size:
            rho = np.outer(x, self.k)
            C, Q = ring_transforms(self.beta, coulomb_waves(-self.eta, rho), coulomb_waves(self.eta, rho))
            for i in range(2):
                left = C[i] * zz + Q[i] * zr, C[i] * zr + Q[i] * rr
                for j in range(2):
                    K[i, j] = left[0] @ C[j].T + left[1] @ Q[j].T
        return K.transpose(2, 0, 3, 1).reshape(2 * n, 2 * n)


def ring_transforms(beta: float, minus: Pair, plus: Pair) -> tuple[Pair, Pair]:
    """C and Q of either density from F and F' of -eta and of +eta."""
    (Fm, sm), (Fp, sp) = minus, plus
    first, second = 0.5 / math.sqrt(1 + beta), 0.5 / math.sqrt(1 - beta)
    C = first * sm + second * sp, first * Fm - second * Fp
    Q = first * sm - second * sp, first * Fm + second * Fp
    return C, Q


@dataclass(frozen=True, eq=False)
class StuckDisc:
    """Flat ends that stick, pressed by a unit displacement, of all radii of the ``panels``.

    ``S`` [m], ``dS`` [-]: S and S' over 2 E*; ``residual`` (radii b, radii x, 2): what the displacements of the end of
    radius b lack at x to the unit one, as the equation has them (0 inside b in the first place; the formula goes on).
    """

    panels: fredholm.Panels
    Lambda: float
    eta: float
    S: Array
    residual: Array
    largest: float

    @classmethod
    def of(cls, kernel: StuckKernel, panels: fredholm.Panels) -> StuckDisc:
        """Solve; SolveError where the panels do not resolve the kernel."""
        n, root = 2 * panels.x.size, np.repeat(np.sqrt(panels.w), 2)
        K = 2 / math.pi * kernel.square(panels.places)
        factor = fredholm.nested_factor(K[:n, :n], root, panels, "the kernel of contact without slip")
        unit = np.zeros(n)
        unit[::2] = kernel.Lambda
        right = np.column_stack([root * unit, root[:, None] * K[:n, n:]])
        forward = fredholm.forward_substitution(factor, right)
        y, last = forward[:, 0], 2 * panels.stops - 1
        sums = np.cumsum(y[:, None] * forward[:, 1:], axis=0)[last].reshape(last.size, last.size, 2)
        residual = np.array([kernel.Lambda, 0.0]) - sums
        largest = float(np.max(np.abs(np.diag(K)), initial=0.0))
        return cls(panels, kernel.Lambda, kernel.eta, np.cumsum(y**2)[last], residual, largest)

    @property
    def dS(self) -> Array:
        each = np.arange(self.S.size)
        return np.sum(self.residual[each, each] ** 2, axis=1)

    @property
    def rounding(self) -> Array:
        """Relative error that the rounding of K lets expect at each radius, as that of ``EquationResult``."""
        return fredholm.rounding_error(self.panels, self.largest, self.S)


# Integrals of the ring fields Z.
GROWTH_LAST = 19.0  # largest tau; theory: 1 - tanh^2 is then below rounding
GROWTH_FIRST = (0.25, 0.5)  # cuts of the first piece; choice: a fourth of a coating's thickness


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
            edges += list(plain[:-1]) if lo > 0 else [0.0, *plain[1] * np.array(GROWTH_FIRST), *plain[1:-1]]
        crowd = np.isin(edges, [b for b in kinks if b > 0])
        return cls(np.append(edges, largest), crowd, count)

    @property
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
        t, w = fredholm.crowded(self.edges[piece], x, inner)
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
        if self.disc.eta == 0:
            matrix = D[0]
        else:
            # Z_1 D_1 + Z_2 D_2 at the nodes, from the matrices D that give D_j there
            rows = [self._rings(x) for x in self.pieces.nodes]
            matrix = sum(np.array([row[j] for row in rows]) @ (D[j] / F[:, None]) for j in (0, 1)) * np.ones_like(D[0])
        return np.linalg.solve(matrix / F[:, None], np.full(F.size, self.disc.Lambda))

    def _rings(self, x: float) -> tuple[Array, Array]:
        """Rows (n,) that give Z_1 D_1 and Z_2 D_2 at the node ``x`` [m] from D_1/F and D_2/F at the nodes.

        D(x) is taken out of the integrals, as the limit of a decaying exponential gives it.
        """
        eta, edges = self.disc.eta, self.pieces.edges
        inside = np.append(edges[edges < x * (1 - 1e-12)], [])
        ends = np.append(np.arctanh(inside / x), GROWTH_LAST)
        lo, hi = fredholm.split(ends[:-1], ends[1:], np.maximum(np.ceil(np.diff(ends) / DENSITY_WIDEST), 1).astype(int))
        tau, w = fredholm.gauss(lo, hi, *fredholm.rule(fredholm.EXACT))
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


# --------------------------------------------------------------------------------------------------
# One indenter that sticks to one layered specimen: its spectra, and contact at any radii.

# How the growing contact is discretised for an accuracy.
# widest, over the kernel's scale; tuned on bodies, by `make constants`: with half of it the same accuracy takes
# twice as long
STUCK_PIECE = 1.4
# Points on each piece: at the accuracy 1, and more for each decade:
# tuned on bodies, by `make constants`: with ``per_decade`` paraboloids on bonded layers err by less than a tenth of
# the accuracy
STUCK_POINTS = 4
# tuned on bodies, by `make constants`: with half as many they err by ten times the accuracy 1e-6
STUCK_PER_DECADE = 1.0
STUCK_MOST_POINTS = 16  # tuned on bodies, by `make constants`: beyond, narrower pieces are as cheap
STUCK_NARROWER = 0.9  # pieces of the second discretisation; choice: other nodes
STUCK_MOST_NODES = 5000  # choice: a matrix of 200 MB; a bonded layer up to a/h = 45


@dataclass(frozen=True)
class StuckPlan:
    """``quadrature`` of the densities and of integrals over dF, ``widest`` piece [m] and ``points`` on each of the
    growth, ``order``: Gauss nodes on every panel in k."""

    quadrature: fredholm.Quadrature
    widest: float
    points: int
    order: int = 24

    @property
    def nodes(self) -> int:
        """Rows of the system."""
        return 2 * self.quadrature.nodes

    def finer(self) -> StuckPlan:
        """A plan that is more accurate in every part and shares no node with this one."""
        widest, order = self.widest * STUCK_NARROWER, 20 if self.order == 24 else 24
        return StuckPlan(self.quadrature.finer(), widest, self.points + 1, order)


@dataclass(frozen=True, eq=False)
class StuckSpectrum(LayeredSpectrum):
    """Spectra g_zz - 1, g_zr - beta, g_rr - 1 of one pair of bodies that stick to each other."""

    def __call__(self, k: Array) -> Array:
        """The largest of the three, by size."""
        return np.max(np.abs(self.deviations(k)), axis=0)

    @property
    def tail(self) -> None:
        """None: these spectra decay exponentially."""
        return None

    @property
    def beta(self) -> float:
        """Dundurs's constant of the materials that touch, g_zr for k -> infinity."""
        zz, zr, rr = self._half_spaces
        return zr / math.sqrt(zz * rr)

    @property
    def _half_spaces(self) -> tuple[float, float, float]:
        """Compliances F_zz, F_zr, F_rr of the half-spaces of both materials that touch [1/Pa]."""
        zz, zr, rr = half_space_compliances(self.specimen.materials[0])
        if self.indenter is not None:
            outermost = self.indenter.layers[0].material if isinstance(self.indenter, Coated) else self.indenter
            own_zz, own_zr, own_rr = half_space_compliances(outermost)
            zz, zr, rr = zz + own_zz, zr - own_zr, rr + own_rr
        return zz, zr, rr

    def deviations(self, k: Array) -> Array:
        """g_zz - 1, g_zr - beta, g_rr - 1 (3, k) at the wave numbers ``k`` [1/m]."""
        total = np.zeros((3, k.size))
        for body, _ in self.bodies:
            layer = body.layers[0]
            half_space = np.array(half_space_compliances(layer.material))
            m = minors_of(body, np.maximum(k, 1e-30 / layer.thickness))
            own = m[[2, 3, 1]] / m[0] / shear_moduli(layer)[0] - half_space[:, None]
            total += own if body is self.specimen else own * np.array([[1], [-1], [1]])
        zz, _, rr = self._half_spaces
        return total / np.array([[zz], [math.sqrt(zz * rr)], [rr]])

    @cached_property
    def panels(self) -> tuple[Array, Array, Array]:
        """Ends lo, hi [1/m] of panels that resolve all three, and the largest value on each (panels, 1)."""
        thinnest = min((body.layers[0].thickness for body, _ in self.bodies), default=math.inf)

        def acting(row: int, k: Array) -> Array:
            """A positive compliance less 1: g_zz, g_rr, or what acts on pressure and shear together.

            F_rr over a sliding base goes like 1/k, and acts times k^2 for small k.
            """
            zz, zr, rr = self.deviations(k) + np.array([[1.0], [self.beta], [1.0]])
            share = k * thinnest / np.sqrt(1 + (k * thinnest) ** 2)
            return (zz, zz + 2 * share * zr + share**2 * rr, share**2 * rr)[row] - 1

        ends = [resolved(partial(acting, row), *self.octaves)[:2] for row in range(3)]
        edges = fredholm.distinct(np.concatenate([np.ravel(pair) for pair in ends]))
        return edges[:-1], edges[1:], self((edges[1:] + edges[:-1]) / 2)[:, None]

    def stuck_kernel(self, reach: float, order: int) -> StuckKernel:
        """Kernel for all x, t with x + t <= ``reach`` [m], from ``order`` Gauss nodes in k on every panel."""
        k, w, _ = self.nodes(reach, order)
        return StuckKernel(k, w * self.deviations(k), self.beta)


def half_space_compliances(material: Material) -> tuple[float, float, float]:
    """Compliances F_zz, F_zr, F_rr of a half-space [1/Pa] of the material at the top."""
    if isinstance(material, AnyTransverse):
        medium, G = LayerMedium.transverse(material), material.top.G_z
    else:
        medium, G = LayerMedium.isotropic(material.nu), material.surface.G
    _, rr, zz, zr, _ = medium.half_space
    return zz / G, zr / G, rr / G


@dataclass(frozen=True, eq=False)
class StuckLayeredContact(IndenterOnLayers):
    """An indenter that sticks to a layered specimen, solved at given radii."""

    what = " of contact without slip"

    @cached_property
    def spectrum(self) -> StuckSpectrum:
        return StuckSpectrum(self.specimen, self.indenter.material)

    def plan(self, radii: Array, tolerance: float) -> StuckPlan:
        """The plan expected to be accurate to ``tolerance`` up to the last of the ``radii`` [m]."""
        points = STUCK_POINTS + math.ceil(-STUCK_PER_DECADE * math.log10(tolerance))
        points, widest = min(points, STUCK_MOST_POINTS), STUCK_PIECE * self.scale
        count = points * math.ceil(float(radii[-1]) / widest) if math.isfinite(widest) else points
        if count > STUCK_MOST_NODES:  # more than is solved: counted, not laid out
            return StuckPlan(fredholm.Quadrature(points, widest, count), widest, points)
        nodes = self._pieces(float(radii[-1]), widest, points).nodes
        quadrature = fredholm.Quadrature.cheapest(nodes, self.indenter.a0, self.scale, tolerance)
        return StuckPlan(replace(quadrature, inner=fredholm.EXACT), widest, points)

    def _pieces(self, largest: float, widest: float, points: int) -> Pieces:
        return Pieces.of(self.indenter, largest, min(widest, largest), points)

    def flops(self, radii: Array, plan: StuckPlan) -> float:
        """Floating-point operations of one solve, about."""
        waves = 200 + 0.7 * self.spectrum.bandwidth(self.spectrum.floor) * 2 * radii[-1]
        rows = plan.nodes + 2 * plan.points * math.ceil(radii[-1] / min(plan.widest, radii[-1]))
        waves *= 1 if self.spectrum.beta == 0 else 4
        return float(rows**2 * waves + rows**3 / 3)

    def guard(self, radii: Array, plan: StuckPlan) -> None:
        """Refuse what would take minutes or gigabytes."""
        if plan.nodes > STUCK_MOST_NODES or self.flops(radii, plan) > LAYERED_MOST_FLOPS:
            raise Refusal(
                f"layered: a = {radii[-1]:g} m is {radii[-1] / self.scale:.4g} times the length over which the layers "
                f"act and needs {plan.nodes} equations without slip (limit {STUCK_MOST_NODES}); use a "
                f"smaller contact{' or use method fem' if self.indenter.material is None else ''}"
            )

    def solved(self, radii: Array, plan: StuckPlan) -> fredholm.ContactResult:
        """Contact at the increasing ``radii`` [m]."""
        self.guard(radii, plan)
        a0, factor = self.indenter.a0, 2 * self.E_star
        beyond = radii > a0 * (1 + 1e-12)
        pieces = self._pieces(float(radii[-1]), plan.widest, plan.points) if beyond.all() else None
        ends = radii if pieces is None else pieces.nodes
        panels = fredholm.Panels.through(ends, plan.quadrature, a0)
        disc = StuckDisc.of(self.spectrum.stuck_kernel(2 * float(radii[-1]), plan.order), panels)
        if pieces is None:  # the flat end itself
            nothing = np.zeros_like(radii)
            return fredholm.ContactResult(panels, nothing, nothing, factor * disc.S, factor * disc.dS, disc.rounding)
        growth = Growth(self.indenter, disc, pieces, plan.quadrature.inner)
        S, dS = growth.stiffness(radii)
        worst = np.full_like(radii, disc.rounding.max())
        columns = growth.displacement(radii), factor * growth.load(radii), factor * S, factor * dS
        return fredholm.ContactResult(replace(panels, radii=radii), *columns, worst)


def why_unsupported(indenter: Indenter, specimen: Specimen) -> str | None:
    """Why surfaces that stick are not solved for the two bodies; None where they are."""
    if isinstance(specimen.materials[0], AnyGraded):
        return (
            "under a modulus that varies right below the contact the spectra of no slip decay slowly, "
            "which is not implemented: use method fem, or cut the top layer into a few homogeneous ones"
        )
    if indenter.a0 > 0 and StuckSpectrum(specimen, indenter.material).beta != 0:
        return (
            "round a flat end that sticks to a compressible body the surface oscillates, so that the growth of the "
            "contact is not smooth there: use method fem, or a profile that is round at its tip"
        )
    return None

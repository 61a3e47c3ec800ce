"""Adhesion of finite range on any body: the contact equation with a constant tension around the contact.

Maugis (J. Colloid Interface Sci. 150 (1992) 243) on a half-space: in contact for r <= a, and in a < r < c a tension
sigma attracts, up to the separation delta_t. With p_hat(k) = (E*/2) int_0^c phi(t) cos(kt) dt the density is known
beyond a, phi(t) = -(2/pi) s sqrt(c^2 - t^2), s = 2 sigma/E*, and on any body whose kernel K is known

    phi(x) = (2/pi) (delta - F(x) - int_0^c K(x,t) phi(t) dt),                           0 <= x <= a
    phi is continuous at a:                                                              delta(a, c)
    gap(r) = (2/pi) int_a^r (F(x) - delta - s sqrt(c^2 - x^2) + int_0^c K phi)/sqrt(r^2 - x^2) dx,
    gap(c) = delta_t:                                                                    c(a)
    P = pi E* int_0^c phi dt.

With K on polynomials b, K_ij = int int b_i K b_j, and G the integrals of their products over the disc, the part of the
kernel is int_0^c K phi = b M (delta beta - F_b - s rho), M = (pi/2 K^-1 + G)^-1, where beta, F_b, rho are the integrals
of b, of b F over the disc and of b sqrt(c^2 - t^2) over the annulus.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Protocol

import numpy as np

from ...base.errors import Refusal, SolveError
from ...base.numerics import MOST_STEPS, ROUNDED, SAME, SETTLED, Array
from ...base.units import show
from ...bodies.indenters import Indenter
from ...formulas import lagging, shift
from .density import DENSITY_PIECE, Density, panel_pieces
from .fredholm import AbelMoments, LegendrePanels, Panels, Quadrature, angle, gauss, rule, tension_moments, to_legendre

# How the edge of the attracted annulus is found.
# nodes in the integrals of F; tuned on bodies, by `make constants`: as in the equation without attraction
ATTRACTION_INNER = 20
ATTRACTION_HALVINGS = 40  # of the rest to the profile's end, cut there; theory: F of a sphere is singular at it
# nodes in separations; tuned on bodies, by `make constants`: half as many move displacements around a contact by
# 1e-8
ATTRACTION_ARC = 24
# polynomials on a panel; tuned on bodies, by `make constants`: beyond, narrower panels are as cheap
ATTRACTION_MOST_ORDER = 16
ATTRACTION_MOST_NODES = 800  # choice: some seconds, half a gigabyte
ATTRACTION_UNSMOOTH_ORDER = 8  # on a panel under a kernel with a logarithm; choice: more gain little
# Of the annulus and beyond, to look at; choice: for a warning
ATTRACTION_FRACTIONS = (0.1, 0.25, 0.5, 0.75)
ATTRACTION_NARROWEST = 1e-13  # theory: of c, the width of an annulus of which c - a still knows two digits
ATTRACTION_ROUNDING = 1e-12  # theory: of states in double precision
# Search for the width of the annulus, in logarithms:
ATTRACTION_POWER = 1.3  # theory: of the width, with which the separation grows: 1 to 2; of the first step
ATTRACTION_FAR = 1.5  # tuned on ranges, by `make constants`: longest step
# smallest separation over the wanted one that is distinguished; theory: below exp(-2 far) = 0.05 steps are as long
# as they may be
ATTRACTION_LEAST = 1e-3


@dataclass(frozen=True, eq=False)
class Rims:
    """Equilibria with a tension around the contact, arrays of one shape: contact radius ``a``, radius ``c`` to which
    the surfaces attract, displacement ``delta`` [m], load ``P`` [N], and the separation ``gap`` [m] at c."""

    a: Array
    c: Array
    delta: Array
    P: Array
    gap: Array


@dataclass(frozen=True, eq=False)
class ContactDiscs(ABC):
    """Contact discs of the radii ``a`` [m] on one body, for any annulus around them, however they are discretised."""

    E_star: float
    a: Array

    @abstractmethod
    def F(self, x: Array) -> Array:
        """F of the contact equation [m] at ``x`` [m]."""

    @property
    @abstractmethod
    def sides(self) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """The flat end of each radius pressed by 1, (pi/2) phi at its edge [-], positive, and S/(2 E*) [m]; and
        the counterparts for the right-hand side F."""

    @abstractmethod
    def rims(self, b: Array, s: Array | float) -> Rims:
        """The states in which the attracted annulus is ``b`` [m] wide, for the tension s = 2 sigma/E*; separations as
        they come."""

    @abstractmethod
    def separations(self, rims: Rims, s: float, r: Array) -> Array:
        """Separations [m] at the radii ``r`` [m] of each state in ``rims``, (discs, radii), between a and the reach."""

    @abstractmethod
    def inside(self, rims: Rims, s: float, x: Array) -> Array:
        """int_0^c K phi dt [m] at ``x`` [m] inside the only contact."""

    @property
    def nonadhesive(self) -> tuple[Array, Array, Array, Array]:
        """delta_H [m], P_H [N], S [N/m], S' [N/m^2]."""
        ((edge, S), (z, Q)), factor = self.sides, 2 * self.E_star
        delta = z / edge
        return delta, factor * (delta * S - Q), factor * S, factor * edge**2

    def equilibria(self, s: float, gap: float, reach: float, near: Array | None = None) -> Rims:
        """Maugis closure: the states in which the separation at c is ``gap`` [m]; beyond it at ``reach`` [m] (see
        ``rims``), so that there is one. ``near``: radii c [m] from which the search begins."""

        def excess(b: Array) -> Array:
            return np.log(np.maximum(self.rims(b, s).gap / gap, ATTRACTION_LEAST))

        widest = reach - self.a
        if near is None:
            # Widths [m] about those of a half-space: where the surfaces are drawn apart by the tension or by
            # their shapes, of which nothing is known beyond reach [m]
            F, a = self.F, self.a
            by_tension = gap * math.pi / 2 / s
            scale = np.minimum(np.maximum(a, 1e-3 * by_tension), reach / (1 + 1e-3))
            slope = (F(scale * (1 + 1e-3)) - F(scale * (1 - 1e-3))) / (2e-3 * scale)
            by_shape = np.cbrt((gap * 3 * math.pi / 4) ** 2 * scale / 2 / np.maximum(slope, 1e-100) ** 2)
            first = 1 / (1 / by_tension + 1 / np.maximum(by_shape, 1e-3 * by_tension))
        else:
            first = np.maximum(near - self.a, ATTRACTION_LEAST * widest)
        return self.rims(_rising_root(excess, np.minimum(first, widest / 2), widest), s)

    def doubt(self, rims: Rims, s: float, gap: float, reach: float) -> str | None:
        """What speaks against the states ``rims``: the separation must rise to ``gap`` [m] at c and stay above it up to
        ``reach`` [m], and c be the only such radius; None where nothing does."""
        inside = self.a[:, None] + (rims.c - self.a)[:, None] * np.array([*ATTRACTION_FRACTIONS, 1 - ROUNDED])
        outside = rims.c[:, None] + (reach - rims.c)[:, None] * np.array([*ATTRACTION_FRACTIONS, 1.0])
        within = self.separations(rims, s, inside)
        overlap, slack = within[:, 0] < -SAME * gap, SAME * gap
        if (overlap | (np.diff(within, axis=1) < -slack).any(axis=1)).any():
            return "the gap around the contact does not grow with the radius where the surfaces attract each other"
        if (self.separations(rims, s, outside) < gap - slack).any():
            return "the surfaces come nearer than the range again beyond the radius to which they attract each other"
        if any((self.rims(r - self.a, s).gap < gap - slack).any() for r in outside.T):
            return "there is more than one radius to which the surfaces may attract each other"
        return None


class AbelImage(Protocol):
    """What stands for F in the contact equation: see ``AbelMoments``."""

    @property
    def F(self) -> Callable[[Array], Array]: ...

    def moments(self, a: Array) -> Array: ...

    def arcs(self, a: Array, b: Array) -> Array: ...


@dataclass(frozen=True, eq=False)
class Discs(ContactDiscs):
    """Contact discs on the polynomials of a ``basis``.

    ``schur[p]``: M of a disc of the p lowest panels; ``partial``: for each disc G (I + M G)^-1 of the panel that it
    cuts. ``beta``: integrals of the polynomials over the disc; ``ends``: their values at a.
    """

    basis: LegendrePanels
    abel: AbelImage
    panel: Array
    schur: list[Array]
    partial: Array
    beta: Array
    ends: Array

    def F(self, x: Array) -> Array:
        return self.abel.F(x)

    @cached_property
    def phi_F(self) -> Array:
        """Integrals of the polynomials times F over the disc."""
        return self.abel.moments(self.a)

    def applied(self, vectors: Array) -> Array:
        """M of each disc times a vector each, (discs, size)."""
        result = np.empty_like(vectors)
        for p in np.unique(self.panel):
            rows, M = self.panel == p, self.schur[p]
            block = slice(p * self.basis.order, (p + 1) * self.basis.order)
            whole = vectors[rows] @ M
            cut = np.einsum("nij,nj->ni", self.partial[rows], whole[:, block])
            result[rows] = whole - cut @ M[block]
        return result

    @cached_property
    def _applied(self) -> tuple[Array, Array]:
        return self.applied(self.beta), self.applied(self.phi_F)

    @cached_property
    def sides(self) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        M_beta, M_F = self._applied
        edge = 1 - np.sum(self.ends * M_beta, axis=1)
        inside = self.basis.integral(self.phi_F) - np.sum(self.beta * M_F, axis=1)
        z = self.abel.F(self.a) - np.sum(self.ends * M_F, axis=1)
        return (edge, self.a - np.sum(self.beta * M_beta, axis=1)), (z, inside)

    def rims(self, b: Array, s: Array | float) -> Rims:
        (rho, kappa), ((edge, S), (z, Q)) = tension_moments(self.basis, self.a, b), self.sides
        (M_beta, M_F), M_rho = self._applied, self.applied(rho)
        delta = (z - s * (np.sum(self.ends * M_rho, axis=1) + np.sqrt(b * (2 * self.a + b)))) / edge
        smooth = delta[:, None] * M_beta - M_F - np.reshape(s, (-1, 1)) * M_rho
        gap = self.abel.arcs(self.a, b) - delta * angle(b, self.a + b) - s * b + np.sum(kappa * smooth, axis=1)
        pulled = np.sum(self.beta * M_rho, axis=1) - self.basis.integral(rho)
        P = 2 * self.E_star * (delta * S - Q + s * pulled)
        return Rims(self.a, self.a + b, delta, P, 2 / math.pi * gap)

    def smooth(self, rims: Rims, s: float) -> Array:
        """int_0^c K phi of each state on the polynomials, (discs, size)."""
        M_beta, M_F = self._applied
        rho, _ = tension_moments(self.basis, self.a, rims.c - self.a)
        return rims.delta[:, None] * M_beta - M_F - s * self.applied(rho)

    def inside(self, rims: Rims, s: float, x: Array) -> Array:
        return self.basis.at(x) @ self.smooth(rims, s)[0]

    def separations(self, rims: Rims, s: float, r: Array) -> Array:
        smooth, separations = self.smooth(rims, s), np.empty_like(r)
        for i, x in enumerate(r.T):
            _, kappa = tension_moments(self.basis, self.a, x - self.a)
            pulled = tension_arc(self.a, rims.c, x)
            beyond = self.abel.arcs(self.a, x - self.a) - rims.delta * angle(x - self.a, x)
            separations[:, i] = beyond - s * pulled + np.sum(kappa * smooth, axis=1)
        return 2 / math.pi * separations


def refuse_narrow(rims: Rims) -> None:
    """Refuse annuli that rounding does not tell from the edge of the contact."""
    widths = (rims.c - rims.a) / rims.c
    if (widths < ATTRACTION_NARROWEST).any():
        a = show(float(rims.a[np.argmin(widths)]), "length")
        raise Refusal(
            f"adhesion of finite range: around the contact radius {a} the surfaces attract each other over less than "
            f"{ATTRACTION_NARROWEST:g} of it, which is adhesion without a range: leave stress and range out"
        )


def tension_arc(a: Array, c: Array, r: Array) -> Array:
    """int sqrt(c^2 - x^2)/sqrt(r^2 - x^2) dx [m] from a to the smaller of c and r, by x = that times cos(psi)."""
    near, far = np.minimum(r, c)[:, None], np.maximum(r, c)[:, None]
    nodes, weights = rule(ATTRACTION_ARC)
    half = angle(near[:, 0] - a, near[:, 0]) / 2
    psi = half[:, None] * (nodes + 1)
    root = np.sqrt((far - near + 2 * near * np.sin(psi / 2) ** 2) * (far + near * np.cos(psi)))
    return half * (np.where((r < c)[:, None], root, (near * np.sin(psi)) ** 2 / root) @ weights)


def _rising_root(excess: Callable[[Array], Array], first: Array, widest: Array) -> Array:
    """Widths b in (0, ``widest``] where each ``excess`` rises through 0: secants in log b, bracketed."""
    low, high = np.zeros_like(first), widest.copy()
    b, power = first, np.full_like(first, ATTRACTION_POWER)
    here = excess(b)
    for _ in range(MOST_STEPS):
        low, high = np.where(here <= 0, b, low), np.where(here >= 0, b, high)
        aimed = b * np.exp(np.clip(-here / power, -ATTRACTION_FAR, ATTRACTION_FAR))
        between = np.where(low > 0, np.sqrt(low) * np.sqrt(high), high * math.exp(-ATTRACTION_FAR))
        aimed = np.where((aimed > low) & (aimed < high), aimed, between)
        aimed = np.where(high == low, b, aimed)
        if np.max(np.abs(aimed / b - 1)) < SETTLED:
            break
        there = excess(aimed)
        with np.errstate(invalid="ignore", divide="ignore"):
            secant = (there - here) / np.log(aimed / b)
        power, b, here = np.where((secant > 0) & np.isfinite(secant), secant, power), aimed, there
    return b


@dataclass(frozen=True, eq=False)
class Attraction:
    """A body whose kernel is known, ready for a tension of any strength and range up to the radius ``reach`` [m].

    ``kernel``: (2/pi) int int b_i K b_j of the polynomials of ``basis``. ``rounding``: relative, from one radius to the
    next.
    """

    indenter: Indenter
    E_star: float
    basis: LegendrePanels
    kernel: Array
    rounding: ClassVar[float] = ATTRACTION_ROUNDING

    @classmethod
    def of(cls, indenter: Indenter, E_star: float, panels: Panels, matrix: Array) -> Attraction:
        """From the ``matrix`` of K at the nodes of the ``panels``, or at all their places [1/m]."""
        basis, n = LegendrePanels(panels), panels.x.size
        kernel = 2 / math.pi * (basis.projection @ matrix[:n, :n] @ basis.projection.T)
        return cls(indenter, E_star, basis, (kernel + kernel.T) / 2)

    @property
    def reach(self) -> float:
        return float(self.basis.panels.edges[-1])

    @property
    def is_half_space(self) -> bool:
        """Whether K = 0."""
        return not self.kernel.any()

    @cached_property
    def _abel(self) -> AbelMoments:
        return AbelMoments(self.indenter.abel, profile_kinks(self.indenter, self.reach), self.basis, ATTRACTION_INNER)

    @cached_property
    def _schur(self) -> list[Array]:
        """M of discs of the 0, 1, 2, ... lowest panels."""
        complements, order = [self.kernel], self.basis.order
        for p in range(self.basis.count - 1):
            M, block = complements[-1], slice(p * order, (p + 1) * order)
            try:
                root = np.linalg.cholesky(np.eye(order) + M[block, block])
            except np.linalg.LinAlgError:
                raise SolveError("contact equation: the nodes do not resolve the kernel") from None
            half = np.linalg.solve(root, M[block])
            complements.append(M - half.T @ half)
        return complements

    def discs(self, a: Array, profile: AbelImage | None = None) -> Discs:
        """Contact discs of the radii ``a`` >= 0 [m] below ``reach``, under the indenter or another ``profile``."""
        basis, panel = self.basis, self.basis.panel_of(a)
        lo = basis.panels.edges[panel]
        x, w = gauss(lo, a, *rule(basis.order))
        values = basis.local(x.reshape(a.size, -1), np.broadcast_to(panel[:, None], (a.size, basis.order)))
        w = w.reshape(a.size, -1)
        inside = (w[:, :, None] * values).transpose(0, 2, 1) @ values
        starts = range(0, self.basis.size, self.basis.order)
        ends = [slice(start, start + self.basis.order) for start in starts]
        blocks = np.array([M[end, end] for M, end in zip(self._schur, ends, strict=True)])[panel]
        partial = np.linalg.solve(np.eye(basis.order) + inside @ blocks, inside)
        width = np.sqrt(np.diff(basis.panels.edges))
        beta = np.zeros((a.size, basis.count, basis.order))
        beta[:, :, 0] = np.where(np.arange(basis.count) < panel[:, None], width, 0.0)
        beta[np.arange(a.size), panel] = np.einsum("nq,nqi->ni", w, values)
        own = (self.E_star, a, basis, profile or self._abel, panel, self._schur, partial)
        return Discs(*own, beta.reshape(a.size, -1), basis.at(a))

    def apart(self, c: Array, s: float, gap: float) -> Rims:
        """The states in which nothing touches and the surfaces attract within the radii ``c`` > 0 [m], nearer than
        ``gap`` [m]."""
        zero = np.zeros_like(c)
        rho, kappa = tension_moments(self.basis, zero, c)
        pull = 2 / math.pi * s * (c + np.sum(kappa * (rho @ self.kernel), axis=1))
        P = -math.pi * self.E_star * s / 2 * c**2
        return Rims(zero, c, self.indenter.f(c) - pull - gap, P, np.full_like(c, gap))


def profile_kinks(indenter: Indenter, reach: float) -> Array:
    """Radii [m] up to ``reach`` at which the integrals of F are cut, more and more of them towards the profile's
    end."""
    towards_end = indenter.r_max * (1 - 0.5 ** np.arange(1, ATTRACTION_HALVINGS))
    kinks = np.unique([indenter.a0, *indenter.joints, *towards_end])
    return kinks[(kinks > 0) & (kinks < reach)]


def panels_for(reach: float, a0: float, scale: float, tolerance: float, crowding: float) -> Panels:
    """Panels up to ``reach`` [m] on whose polynomials a kernel that varies over ``scale`` [m] holds to ``tolerance``;
    ``crowding``: how many times narrower, for one that is not smooth. Refusal where they are too many.

    Gauss quadrature is accurate to the square of what polynomials through its nodes are.
    """
    end, orders = np.array([reach]), range(1, ATTRACTION_MOST_ORDER + 1)
    plan = Quadrature.cheapest(end, a0, scale, tolerance**2, orders)
    if crowding > 1:
        order = ATTRACTION_UNSMOOTH_ORDER
        plan = Quadrature(order, scale / crowding, math.ceil(reach / scale * crowding) * order)
    if plan.nodes > ATTRACTION_MOST_NODES:
        raise Refusal(
            f"adhesion of finite range: it reaches out to {show(reach, 'length')}, {reach / scale:.3g} times the "
            f"length scale of the specimen, and needs {plan.nodes} polynomials (limit {ATTRACTION_MOST_NODES}); "
            "use a smaller contact, or a larger stress (a shorter range)"
        )
    return Panels.through(end, plan, a0)


# ---------------------------------------------------------------------- pressure and surface around a contact
@dataclass(frozen=True, eq=False)
class AttractedSurface:
    """Pressure [Pa], compression positive, and gap [m] at the requested radii; ``own``: displacement of a half-space of
    the modulus E* under that pressure [m].

        p(r) = -(E*/2) int_r^a phi'(t)/sqrt(t^2 - r^2) dt - (2 sigma/pi) arccos sqrt((a^2 - r^2)/(c^2 - r^2)),   r < a

    and p = -sigma in a < r < c: both parts are continuous at a. Without a range p has (E*/2) phi(a)/sqrt(a^2 - r^2)
    more and c = a.
    """

    rims: Rims
    pressure: Array
    gap: Array
    own: Array


class ReadyBody(Protocol):
    """A body ready for any tension up to ``reach`` [m], however its contacts are discretised."""

    @property
    def indenter(self) -> Indenter: ...

    @property
    def E_star(self) -> float: ...

    @property
    def reach(self) -> float: ...

    def discs(self, a: Array) -> ContactDiscs: ...


def attracted_surface(
    attraction: ReadyBody, a: float, stress: float, length: float, r: Array, scale: float
) -> AttractedSurface:
    """Fields at the radii ``r`` > 0 [m] of a contact of radius ``a`` [m] under a tension ``stress`` [Pa] up to the
    separation ``length`` [m], on a body whose kernel varies over ``scale`` [m]."""
    discs = attraction.discs(np.array([a]))
    rims = discs.equilibria(2 * stress / attraction.E_star, length, attraction.reach)
    return _surface(attraction, discs, rims, stress, r, scale)


def adhesive_surface(attraction: ReadyBody, a: float, w: float, r: Array, scale: float) -> AttractedSurface:
    """Fields at the radii ``r`` > 0 [m] up to ``reach`` for a work of adhesion ``w`` [J/m^2] without a range,
    on a body whose kernel varies over ``scale`` [m]."""
    discs = attraction.discs(np.array([a]))
    delta, P, S, dS = discs.nonadhesive
    rims = Rims(discs.a, discs.a, *lagging(delta, P, S, shift(w, a, dS)), np.zeros(1))
    return _surface(attraction, discs, rims, 0.0, r, scale)


def _surface(
    attraction: ReadyBody, discs: ContactDiscs, rims: Rims, stress: float, r: Array, scale: float
) -> AttractedSurface:
    """Fields at the radii ``r`` [m] of the one state of ``rims``."""
    s, a, c = 2 * stress / attraction.E_star, float(rims.a[0]), float(rims.c[0])
    # The density up to a, its smooth part on equal pieces
    edges, x = panel_pieces(a, scale, DENSITY_PIECE)
    smooth = (2 / math.pi * discs.inside(rims, s, x)).reshape(-1, DENSITY_PIECE)
    phi = Density(attraction.indenter, a, float(rims.delta[0]), edges, smooth @ to_legendre(DENSITY_PIECE))
    edge = 0.0 if stress else float(phi(rims.a)[0])
    inside, beyond = r < a, r >= a
    ratio = np.clip((a**2 - r[inside] ** 2) / (c**2 - r[inside] ** 2), 0.0, 1.0)
    pressure = np.where(r < c, -stress, 0.0)
    pressure[inside] = attraction.E_star / 2 * phi.pressures(edge, r[inside])
    pressure[inside] -= 2 * stress / math.pi * np.arccos(np.sqrt(ratio))
    gap = np.zeros_like(r)
    gap[beyond] = discs.separations(rims, s, r[None, beyond])[0]
    own = np.array([phi.arc(0.0, min(a, float(x)), float(x)) for x in r])
    outer = r[beyond]
    own[beyond] -= 2 / math.pi * s * tension_arc(np.full_like(outer, a), np.full_like(outer, c), outer)
    return AttractedSurface(rims, pressure, gap, own)

"""Density phi of the contact equation at one contact radius, inside the contact and beyond it, and what it means there.

    p(r)   = (E*/2) [ phi(a)/sqrt(a^2 - r^2) - int_r^a phi'(t)/sqrt(t^2 - r^2) dt ]          r < a
    gap(r) = - int_a^r phi(x)/sqrt(r^2 - x^2) dx                                              r > a

where phi beyond a means the contact equation solved for phi(x) there; for K = 0 this is Sneddon (1965). The second
line is free of cancellation at the edge.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.polynomial import legendre

from ...base.errors import JkrError, Refusal
from ...base.numerics import SAME, Array
from ...base.units import show
from ...bodies.indenters import Indenter
from ...bodies.problem import AnyGraded, Specimen, stacks
from . import fredholm

# Nodes for phi between those of the equation.
# On each piece of the smooth part, one kernel scale wide:
DENSITY_PIECE = 18  # tuned on reference bodies, by `make tuning`
DENSITY_MORE = 6  # than that on each panel of an integral over phi; tuned on reference bodies, by `make tuning`
DENSITY_WIDEST = 1.5  # panel in an angle [rad]; tuned on reference bodies, by `make tuning`


@dataclass(frozen=True, eq=False)
class Density:
    """Density phi(x) = (2/pi) (delta - F(x)) - (2/pi) int_0^a K(x,t) phi(t) dt [m] for 0 <= x <= ``reach``.

    The last term is smooth; it is kept as Legendre series ``coefficients`` (pieces, order) on the equal pieces between
    ``edges`` [m].
    """

    indenter: Indenter
    a: float
    delta: float
    edges: Array
    coefficients: Array

    @classmethod
    def of(
        cls, kernel: fredholm.FredholmKernel, result: fredholm.EquationResult, shift: float, reach: float
    ) -> Density:
        """Density at the first radius of ``result`` for the displacement delta_H - ``shift`` [m], up to ``reach``
        [m]."""
        return next(cls.each(kernel, result, reach, shift))

    @classmethod
    def each(
        cls,
        kernel: fredholm.FredholmKernel,
        result: fredholm.EquationResult,
        reach: float,
        shift: float = 0.0,
        order: int = DENSITY_PIECE,
    ) -> Iterator[Density]:
        """Densities at all radii, from one evaluation of the kernel; ``order``: nodes on each piece."""
        edges, x = panel_pieces(reach, kernel.scale, order)
        sources = np.zeros((result.panels.x.size, result.panels.radii.size))
        for n in range(result.panels.radii.size):
            t, weights, phi = result.density(n, shift)
            sources[: t.size, n] = 2 / math.pi * weights * phi
        smooth = kernel.times(x, result.panels.x, sources)
        for a, delta, values in zip(result.panels.radii.tolist(), result.delta.tolist(), smooth.T, strict=True):
            yield cls(result.indenter, a, delta - shift, edges, values.reshape(-1, order) @ fredholm.to_legendre(order))

    def anchored(self) -> Density:
        """Density with phi(a) = 0 not only to rounding: that is what decides on the gap next to a nonadhesive edge."""
        return replace(self, delta=self.delta - math.pi / 2 * float(self(np.array([self.a]))[0]))

    def __call__(self, x: Array) -> Array:
        """Value phi(x) [m]."""
        return 2 / math.pi * (self.delta - self.indenter.abel(x)) - self._smooth(x, self.coefficients)

    def slope(self, x: Array) -> Array:
        """Slope phi'(x) [-], x > 0."""
        derivative = legendre.legder(self.coefficients, axis=1) * (2 / self.edges[1])
        return -2 / math.pi * self.indenter.abel_slope(x) - self._smooth(x, derivative)

    def _smooth(self, x: Array, coefficients: Array) -> Array:
        piece = np.clip(np.searchsorted(self.edges, x, side="right") - 1, 0, self.edges.size - 2)
        local = 2 * (x - self.edges[piece]) / self.edges[1] - 1
        return legendre.legval(local, coefficients[piece].T, tensor=False)

    def nodes(self, lo: float, hi: float, angle: Callable[[Array], Array]) -> tuple[Array, Array]:
        """Quadrature nodes and weights in ``angle(x)`` for x from ``lo`` to ``hi``.

        Panels end at pieces and breaks, and nodes crowd quadratically at each left end, where F may have a kink.
        """
        inner = np.concatenate([self.edges, self.indenter.joints])
        inner = inner[(inner > lo) & (inner < hi)]
        theta = angle(fredholm.distinct(np.concatenate([[lo], inner, [hi]])))
        pieces = np.maximum(np.ceil(np.diff(theta) / DENSITY_WIDEST), 1).astype(int)
        left, right = fredholm.split(theta[:-1], theta[1:], pieces)
        x, w = fredholm.crowded(left, right, self.coefficients.shape[1] + DENSITY_MORE)
        return x.ravel(), w.ravel()

    def arc(self, lo: float, hi: float, r: float) -> float:
        """Abel integral int_lo^hi phi(x)/sqrt(r^2 - x^2) dx [m] for hi <= r."""
        theta, weights = self.nodes(lo, hi, lambda x: np.arcsin(np.minimum(x / r, 1.0)))
        return float(weights @ self(np.minimum(r * np.sin(theta), hi)))

    def pressures(self, edge: float, r: Array) -> Array:
        """Pressures 2 p/E* [-] at the radii 0 < r < a [m], for the value phi(a) = ``edge`` [m], by t = r
        cosh(theta)."""
        if not r.size:
            return r

        def inverse(x: float, t: Array) -> Array:
            """theta at t [m]."""
            return np.arccosh(np.maximum(t / x, 1.0))

        parts = [self.nodes(x, self.a, partial(inverse, x)) for x in r.tolist()]
        sizes = [theta.size for theta, _ in parts]
        theta, weights = np.concatenate(parts, axis=1)
        slopes = self.slope(np.minimum(np.repeat(r, sizes) * np.cosh(theta), self.a))
        starts = np.cumsum([0, *sizes[:-1]])
        return edge / np.sqrt((self.a - r) * (self.a + r)) - np.add.reduceat(weights * slopes, starts)

    def gaps(self, r: Array) -> Array:
        """Distance of the surfaces [m] at any r, 0 inside, by x = r sin(theta)."""
        return np.array([-self.arc(self.a, float(x), float(x)) if x > self.a else 0.0 for x in r])


def panel_pieces(reach: float, scale: float, order: int) -> tuple[Array, Array]:
    """Edges [m] of equal pieces from 0 to ``reach`` [m], no wider than ``scale`` [m], and the ``order`` Gauss nodes on
    each."""
    edges = np.linspace(0, reach, max(math.ceil(reach / scale), 1) + 1)
    return edges, fredholm.gauss(edges[:-1], edges[1:], *fredholm.rule(order))[0]


def nonsmooth_part(specimen: Specimen) -> str | None:
    """Why pressures and gaps on the ``specimen`` cannot be found from its density; None where they can."""
    if specimen.surface_tension:
        return "profile: pressures under surface tension are not implemented: leave specimen.surface_tension out"
    if isinstance(specimen.materials[0], AnyGraded):
        return (
            "profile: under a modulus that varies right below the contact phi is not smooth at the edge, and its "
            "pressures are not implemented; cut the top layer into a few homogeneous ones"
        )
    return None


# --------------------------------------------------------------------------------------------------
# Whether the nonadhesive contact is a full disc: pressed together everywhere inside it, and open outside.
#
# The contact equation takes the disc for granted. On a coating stiffer than what lies below it bends like a plate,
# and a profile that is not curved enough at its tip loses touch there, or the plate touches again beyond the edge.

# Where a contact is looked at, and what counts as more than the rounding of the quadrature.
DISC_FRACTIONS = (0.1, 0.25, 0.5, 1.0)  # of the largest contact radius; choice: for a warning
# Over each radius, to look at; choice: for a warning
DISC_PLACES = (0.03, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 0.95, 1.02, 1.1, 1.3, 2.0)
DISC_PULL = 1e-3  # least tension over the mean pressure; tuned on stiff coatings, by `make failures`
DISC_OVERLAP = 1e-5  # least overlap over the displacement; tuned on stiff coatings, by `make failures`


PLACES = np.array(DISC_PLACES)


def refuse_shrinking(a: Array, delta: Array) -> None:
    """Refusal where the displacement [m] does not grow with the radius ``a`` [m]: a plate that lies on its rim."""
    falls = np.flatnonzero(np.diff(delta) <= 0)
    if falls.size:
        raise Refusal(
            f"the displacement falls beyond the contact radius {show(float(a[falls[0]]), 'length')}: under a "
            "coating so much stiffer than its substrate the contact is no longer a growing disc; use a smaller radius"
        )


def disc_warnings(
    contact: fredholm.Contact, specimen: Specimen, largest: float, kernel: Callable[[float], fredholm.FredholmKernel]
) -> tuple[str, ...]:
    """What is wrong with discs up to ``largest`` [m] as the ``contact`` with ``specimen``; () where nothing is.

    ``kernel(reach)``: K for x + t <= ``reach`` [m]; outside, the surface is looked at no farther than it is known.
    """
    bodies = (specimen, *stacks(specimen, contact.indenter.material))
    moduli = [[material.surface.E_star for material in body.materials] for body in bodies]
    on_softer = any(below < above for E in moduli for above, below in itertools.pairwise(E))
    if not on_softer and all(body.radius is None for body in bodies):  # nor is a side near
        return ()
    a0 = contact.indenter.a0
    radii = a0 + np.array(DISC_FRACTIONS) * (largest - a0)
    try:
        if reason := nonsmooth_part(specimen):
            raise Refusal(reason)
        result = contact.solved(radii, contact.plan(radii, SAME))
    except JkrError as error:
        return (f"it was not checked whether the contact is a full disc ({error})",)
    end = min(DISC_PLACES[-1] * largest, contact.indenter.r_max, contact.limit)
    densities = Density.each(kernel(largest + end), result, end, order=fredholm.EXACT)
    for phi, P in zip(densities, result.P.tolist(), strict=True):
        phi = phi.anchored()
        inside, outside = phi.a * PLACES[PLACES < 1], phi.a * PLACES[PLACES > 1]
        pull = contact.E_star / 2 * float(phi.pressures(0.0, inside).min()) / (P / (math.pi * phi.a**2))
        overlap = -float(phi.gaps(outside[outside <= end]).min(initial=0.0)) / phi.delta
        words = ""
        if pull < -DISC_PULL:
            words = f"tension in the middle of the contact, {-pull:.2g} of the mean pressure"
        elif overlap > DISC_OVERLAP:
            words = f"the surfaces overlap outside the contact, by {overlap:.2g} of the displacement"
        if words:
            return (
                f"at the contact radius {show(phi.a, 'length')} {words}: the contact without adhesion is not a full "
                "disc there, the adhesive curve is right only where adhesion holds it together; use a smaller load, or "
                "see jkr profile",
            )
    return ()

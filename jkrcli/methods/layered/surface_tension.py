"""One indenter on one layered specimen whose surface has a tension Ups: its spectrum, and contact at any radii.

The tension adds Ups k^2 to the surface stiffness in Hankel space: g becomes g/(1 + kappa g k), kappa = 2 Ups/E*, and
the contact equation one of the first kind, with the kernel

    k(s) = int_0^inf g/(1 + kappa g k) cos(ks) dk = A(s/kappa)/kappa + int_0^inf (g - 1)/((1 + kappa g k)(1 + kappa k))
    cos(ks) dk

(``formulas/__init__.py: displacement``). With phi = psi(tau)/sqrt(a^2 - t^2), t = a cos(tau), psi(0) is a load
on the ring of the edge, Ups times the jump of the slope there, and the energy of the field, a positive quadratic form,
gives for the solutions psi_1 of the right side 1 and psi_F of F

    S = pi E* int psi_1,   S' = pi^3 E* psi_1(0)^2/(4 a kappa),   delta_H = Q'/S' = psi_F(0)/psi_1(0),
    P_H = S delta_H - Q,   Q = pi E* int psi_1 F.

psi_F is as rough as F'. So it is not solved for: Q' = pi E* int (psi_1 F)' needs the derivative of psi_1 over a alone,
which is the solution for the right side -K' psi_1, and F enters in integrals only.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from ... import formulas
from ...base.errors import Refusal, counted
from ...base.numerics import Array, EvenCubic, PiecewiseCubic, cubic_spline
from ...base.units import show
from ...bodies.problem import AnyGraded, Specimen, stacks
from ..integral.fredholm import (
    ContactResult,
    Panels,
    Quadrature,
    crowded,
    crowded_rule,
    gauss,
    lagrange,
    panel_means,
    phase_allowed,
    rule,
)
from .contact import LAYERED_MOST_FLOPS, LAYERED_MOST_NODES, IndenterOnLayers, LayeredContact, logarithms
from .spectrum import COUNT, LayeredSpectrum, Tail, compliance, divided, regularised, resolved, surface_series

# --------------------------------------------------------------------------------------------------
# Product integration of a logarithmic kernel of the first kind on panels in the angle tau, t = a cos(tau).
#
#     int_0^(pi/2) (k(x - t) + k(x + t))/2 psi(tau) dtau = right side at x = a cos(theta)
#
# psi is finite at the edge tau = 0 with tau^2 ln(tau) behind it: panels are halved towards it, and psi(0) is found
# from the first of them by what it begins with. Where a panel is near theta its part is integrated with points that
# crowd at theta, or at its nearer end, as the fifth power: they follow a kernel over many decades. The part of x + t
# is that of x - t on the panels mirrored at pi/2.

Function = Callable[[Array], Array]

# Points near a singularity, and what psi begins with.
# of the crowding; tuned on bodies, by `make constants`: 28 points and more then follow a kernel over the decades of
# a/kappa
ANGLES_POWER = 5
# widths of a panel, within which it is; tuned on bodies, by `make constants`: ten nodes then err by 1e-10
ANGLES_NEAR = 1.0
# panels at the edge from which psi(0) is found; tuned on bodies, by `make constants`: with five it errs by 1e-6
ANGLES_FIRST = 3
ANGLES_TERMS = 2  # theory: psi = c0 + sum tau^2n (c_n + d_n ln(tau)), n up to this


@dataclass(frozen=True, eq=False)
class Angles:
    """Nodes ``tau`` and weights ``w`` (n,) on panels between ``edges`` from 0 to pi/2, ``order`` on each.

    ``edge`` (n,): psi(0) = edge . psi. Distances are those for a = 1: ``apart, across`` (n, n): |x - t|, x + t, with
    weights ``plain, mirrored``, zero where a panel is near; ``distance`` (m, points) of the m near panels, with
    ``weights`` (m, points, order), for the node ``row`` and the panel ``column``. ``nearest``: the least distance at
    which a singular kernel counts; ``below``: the pairs of nodes i >= j, and ``pair`` (n, n): the number of each in
    either order among them.
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
    nearest: float
    below: tuple[Array, Array]
    pair: Array

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
        near = np.maximum(np.maximum(lo - tau, tau - hi), 0) < ANGLES_NEAR * (hi - lo)
        far = np.repeat(~near, order, axis=0).reshape(2, tau.size, tau.size)
        apart = _apart(tau[:, None], tau[:, None] - tau)
        across = np.add.outer(np.cos(tau), np.cos(tau))
        plain, mirrored = far[0].T * w, far[1, ::-1].T * w
        # Distances, weights, rows and columns of the near (panels, n) among the panels between both; a panel that
        # holds the node is cut there
        panel, node = np.nonzero(near)
        theta, lo, hi = tau[node], both[panel], both[panel + 1]
        inside = (lo < theta) & (theta < hi)
        start, end = np.clip(theta, lo, hi), np.where(theta >= hi, lo, hi)
        start, end = np.append(start, theta[inside]), np.append(end, lo[inside])
        panel, node, lo, hi = (np.append(x, x[inside]) for x in (panel, node, lo, hi))
        u, v = crowded_rule(points, ANGLES_POWER)
        offset = (end - start)[:, None] * u
        local = (start[:, None] + offset - lo[:, None]) / (hi - lo)[:, None]
        panels = (both.size - 1) // 2
        beyond = panel >= panels
        local = np.where(beyond[:, None], 1 - local, local)
        distance = _apart(tau[node][:, None], (tau[node] - start)[:, None] - offset)
        weights = lagrange(order, local) * (np.abs(end - start)[:, None] * v)[..., None]
        rest = distance, weights, node, np.where(beyond, 2 * panels - 1 - panel, panel)
        # The row that takes psi at the nodes to psi(0): least squares on the first panels by what psi begins with.
        n = ANGLES_FIRST * order
        t, root = tau[:n] / edges[ANGLES_FIRST], np.sqrt(w[:n])
        powers = [t ** (2 * i) for i in range(1, ANGLES_TERMS + 1)]
        basis = np.stack([np.ones(n), *powers, *(power * np.log(t) for power in powers)], axis=1)
        to_edge = np.zeros(tau.size)
        to_edge[:n] = np.linalg.pinv(basis * root[:, None])[0] * root
        nearest = float(min(distance.min(), apart[plain > 0].min(initial=np.inf)))
        below, pair = np.tril_indices(tau.size), np.empty((tau.size, tau.size), dtype=int)
        pair[below] = pair.T[below] = np.arange(below[0].size)
        return cls(edges, order, tau, w, to_edge, apart, across, plain, mirrored, *rest, nearest, below, pair)

    def matrices(self, singular: Function, smooth: Function, a: float) -> Array:
        """Matrices (m, n, n) of the sums of two kernels k(s) [1/m] of s [m], which give m values each, at the contact
        radius ``a`` [m]."""
        apart, across = a * self.apart[self.below], a * self.across[self.below]  # the same of t and x
        K = self.plain * singular(np.maximum(apart, a * self.nearest))[:, self.pair]
        K += self.mirrored * singular(across)[:, self.pair]
        K += self.w * (smooth(apart) + smooth(across))[:, self.pair]
        near = np.einsum("kmq,mqj->kmj", singular(a * self.distance), self.weights)
        for one, part in zip(K.reshape(*K.shape[:2], -1, self.order), near, strict=True):
            np.add.at(one, (self.row, self.column), part)
        return K / 2


def _apart(tau: Array, difference: Array) -> Array:
    """|cos(tau) - cos(tau - difference)| without cancellation."""
    return 2 * np.abs(np.sin(difference / 2) * np.sin(tau - difference / 2))


# How the equation of the first kind is discretised for an accuracy.
# the least; tuned on bodies by layered, by `make constants`: rounding leaves some 1e-9 on thin incompressible
# layers
TENSE_TOLERANCE = 5e-8
# halvings towards the edge for a = kappa; tuned on bodies, by `make constants`: one less moves depths by 2e-5
TENSE_LEVELS = 7
# nodes on a panel at the accuracy 1e-4, one more for each decade; tuned on bodies, by `make constants`: one less
# moves S by 2e-5
TENSE_LEAST_ORDER = 6
TENSE_MOST_ORDER = 14  # tuned on bodies, by `make constants`: half of it moves S by 2e-5, beyond it rounding counts
# of a/kappa, points near a singularity, beside 2.5 times the order; tuned on bodies, by `make constants`: one less
# moves S by 3e-6
TENSE_PER_DECADE = 5
TENSE_FREQUENCY = 5.0  # times the scale of the layers: highest wave number noticed; theory: as for ``Quadrature``
# of the smooth part, per scale; tuned on bodies, by `make constants`: half as many move S by 4e-9
TENSE_KNOTS = 60
TENSE_STENCIL = 12  # theory: knots of a polynomial between them; it errs by (TENSE_FREQUENCY/TENSE_KNOTS)^12 = 1e-13
# of the cubic that stands for it, ten times as fast; tuned on bodies, by `make constants`: half as many move S by
# 4e-9
TENSE_FINER = 12
TENSE_LEAST = 1e-6  # kappa/a of layers; choice: below, tension changes nothing by 1e-5
# nodes per panel in integrals of F; tuned on bodies, by `make constants`: half as many move depths by 1e-9
TENSE_INNER = 20
TENSE_PER_ENTRY = 60  # operations per entry of the matrix; tuned on half-spaces and layers, by `make bench`


@dataclass(frozen=True)
class TensePlan:
    """``order`` nodes on panels in the angle no wider than ``widest`` [m] at the edge's radius, halved ``extra`` times
    more than needed; ``accuracy``: up to which a slight tension is a correction; ``nodes`` at the largest radius."""

    order: int
    widest: float
    accuracy: float
    nodes: int
    extra: int = 0

    def finer(self) -> TensePlan:
        """A plan that is more accurate in every part and shares no node with this one."""
        order, widest = self.order + 2, self.widest * 0.9
        return TensePlan(order, widest, self.accuracy / 10, self.nodes // self.order * order, self.extra + 1)


@dataclass(frozen=True, eq=False)
class TenseSpectrum(LayeredSpectrum):
    """The part (g - 1)/((1 + kappa g k)(1 + kappa k)) that layers add to the kernel, less its ``tail``."""

    def __call__(self, k: Array) -> Array:
        (g, excess), y = compliance(self.specimen, k), self.kappa * k
        added = excess / ((1 + y * g) * (1 + y))
        return added if self.tail is None else added - self.tail(k)

    @property
    def kappa(self) -> float:
        """2 Ups/E* [m]."""
        return self.specimen.tension_length

    @cached_property
    def tail(self) -> Tail | None:
        """What is left of the tail of g - 1: it decays like 1/k^3."""
        plain, top = Tail.of(self.specimen), self.specimen.materials[0]
        if plain is None or not isinstance(top, AnyGraded):
            return None
        # Coefficients [m^-n], n = 1, 2, ..., of (g - 1)/((1 + kappa g k)(1 + kappa k)) for g = sum c_n/k^n, n >= 0.
        c = surface_series(top, COUNT)
        y = np.eye(1, c.size, 1)[0]
        quotient = divided(divided(np.append(c[1:], 0.0), self.kappa * c + y), self.kappa * np.eye(1, c.size)[0] + y)
        c = np.concatenate([[0.0, 0.0], quotient[:-1]])
        rate = float(np.max(np.abs(c) ** (1 / np.arange(1, c.size + 1))))
        return Tail(regularised(c, rate), rate, min(plain.finest, 1 / rate))

    @cached_property
    def scan(self) -> tuple[Array, Array]:
        """Wave numbers [1/m], decreasing, and the rest there over what the tension alone leaves, 1/(1 + kappa k)."""
        k, rest = super().scan
        return k, rest * (1 + self.kappa * k)

    @cached_property
    def panels(self) -> tuple[Array, Array, Array]:
        rest = (lambda k: 0 * k) if self.tail is None else self.tail
        return resolved(self, *self.octaves, lambda k: rest(k) - self.kappa * k / (1 + self.kappa * k))

    def singular(self, s: Array) -> Array:
        """The part of the kernel [1/m] with a logarithm at s = 0, s > 0 [m]."""
        plain = formulas.displacement(s / self.kappa) / self.kappa
        return plain if self.tail is None else plain + self.tail.transform(s)

    def tabulated(self, smallest: float, largest: float) -> Function:
        """Splines in place of ``singular`` and its s d/ds (2, ...) between these s [m]."""
        ln_s = logarithms(smallest, largest)
        plain = cubic_spline(ln_s, self.singular(np.exp(ln_s)))
        both = EvenCubic(ln_s[0], ln_s[1] - ln_s[0], np.stack([plain.c, cubic_spline(ln_s, plain(ln_s, 1)).c], axis=1))
        return lambda s: both(np.log(s))

    def smooth(self, reach: float, order: int) -> Function:
        """The rest of the kernel [1/m] for 0 <= s <= ``reach`` [m], and its s d/ds (2, ...), from ``order`` Gauss nodes
        in k on every panel."""
        if self.bandwidth(self.floor) == 0:
            return lambda s: np.zeros((2, *s.shape))
        step, half = self.scale / TENSE_KNOTS, TENSE_STENCIL // 2
        knots = step * np.arange(1 - half, math.ceil(reach / step) + 1 + half)
        kernel = self.kernel(float(knots[-1]), order)
        parts = np.array_split(knots, knots.size // 256 + 1)
        values = np.concatenate([np.cos(np.outer(part, kernel.k)) @ kernel.weights for part in parts])

        # Between two knots the polynomial through those nearest, x in steps from the middle between the two
        x, at = np.arange(TENSE_STENCIL) - half + 0.5, np.arange(TENSE_FINER) / TENSE_FINER - 0.5
        others = [np.delete(x, j) for j in range(TENSE_STENCIL)]
        basis = [np.poly(rest) / np.prod(own - rest) for own, rest in zip(x, others, strict=True)]
        near = np.lib.stride_tricks.sliding_window_view(values, TENSE_STENCIL)
        f, slope, bend = (
            np.ravel(near @ np.array([np.polyval(np.polyder(one, n), at) for one in basis])) / step**n for n in range(3)
        )
        s = step / TENSE_FINER * np.arange(f.size)
        both = PiecewiseCubic(s, np.stack([f, s * slope], axis=1), np.stack([slope, slope + s * bend], axis=1))
        return EvenCubic(0.0, s[1], np.moveaxis(both.c, 1, -1))


@dataclass(frozen=True, eq=False)
class SurfaceTensionSolver(IndenterOnLayers):
    """A rigid indenter on a layered specimen with surface tension, solved at given radii."""

    what = " of contact under surface tension"

    @cached_property
    def spectrum(self) -> TenseSpectrum:
        return _spectrum(self.specimen)

    @property
    def kappa(self) -> float:
        """2 Ups/E* [m]."""
        return self.specimen.tension_length

    def plan(self, radii: Array, tolerance: float) -> TensePlan:
        """The plan expected to be accurate to ``tolerance`` up to the last of the ``radii`` [m]."""
        order = TENSE_LEAST_ORDER + math.ceil(max(-math.log10(tolerance) - 4, 0))
        order = min(order, TENSE_MOST_ORDER)
        widest = float(phase_allowed(order, tolerance)) * self.scale / TENSE_FREQUENCY
        plan = TensePlan(order, widest, tolerance, 0)
        levels, cuts = self._panels(float(radii[-1]), plan)
        return TensePlan(order, widest, tolerance, order * (2**cuts + levels - cuts))

    def _panels(self, a: float, plan: TensePlan) -> tuple[int, int]:
        """Halvings towards the edge, and of the quarter circle into equal panels, at the radius ``a`` [m]."""
        cuts = max(math.ceil(math.log2(math.pi / 2 * a / plan.widest)), 0) if math.isfinite(plan.widest) else 0
        halvings = math.ceil(max(math.log2(a / self.kappa), 0.0) / 2)
        return max(TENSE_LEVELS + halvings, cuts) + plan.extra, cuts

    def flops(self, radii: Array, plan: TensePlan) -> float:
        """Floating-point operations of one solve, about."""
        waves = self.spectrum.bandwidth(self.spectrum.floor) * 2 * radii[-1]
        table = 0.0 if waves == 0 else 20 * (400 + waves) * TENSE_KNOTS * 2 * radii[-1] / self.scale
        return float(radii.size * plan.nodes**2 * (plan.nodes + TENSE_PER_ENTRY * plan.order) + table)

    def guard(self, radii: Array, plan: TensePlan) -> None:
        """Refuse what would take minutes or gigabytes, and layers on which tension is too slight to be solved for."""
        slight = self.kappa / float(radii[-1])
        if self.specimen.layers and slight < TENSE_LEAST:
            raise Refusal(
                f"layered: the surface tension acts over 2 Ups/E* = {show(self.kappa, 'length')}, {slight:.0e} of the "
                f"contact radius, and changes the solution by less than {10 * TENSE_LEAST:.0e}: leave "
                "specimen.surface_tension out"
            )
        flops = self.flops(radii, plan)
        if plan.nodes > LAYERED_MOST_NODES or flops > LAYERED_MOST_FLOPS:
            raise Refusal(
                f"layered: a = {radii[-1]:g} m is {radii[-1] / self.scale:.4g} times the length over which the layers "
                f"act and needs {plan.nodes} nodes under surface tension for {counted(radii.size, 'radius', 'radii')}, "
                f"{flops:.1e} operations (limits {LAYERED_MOST_NODES} and {LAYERED_MOST_FLOPS:.0e}); use a smaller "
                "contact or fewer points, or use method fem"
            )

    def solved(self, radii: Array, plan: TensePlan) -> ContactResult:
        """Contact at the increasing ``radii`` [m]."""
        self.guard(radii, plan)
        half_space = not self.specimen.layers
        slight = half_space & ((self.kappa / radii * formulas.logarithm(radii, self.kappa)) ** 2 <= plan.accuracy)
        columns = np.empty((4, radii.size))
        for n in np.flatnonzero(slight):
            columns[:, n] = self._slight(float(radii[n]))
        if not slight.all():
            # Rows delta, P, S, S' from the contact equation
            discs = [(a, self._angles(a, plan)) for a in radii[~slight].tolist()]
            reach = 2 * discs[-1][0]
            singular = self.spectrum.tabulated(min(a * grid.nearest for a, grid in discs) / 2, 1.01 * reach)
            smooth = self.spectrum.smooth(reach, plan.order + 14)
            columns[:, ~slight] = np.stack([self._at(a, grid, singular, smooth) for a, grid in discs], axis=1)
        delta, P, S, dS = columns
        # The nodes at the largest radius, from the axis outwards
        a, grid = float(radii[-1]), self._angles(float(radii[-1]), plan)
        x, w = a * np.cos(grid.tau[::-1]), a * (np.sin(grid.tau) * grid.w)[::-1]
        of_largest = Panels(a * np.cos(grid.edges[::-1]), grid.order, radii, x, w, np.searchsorted(x, radii))
        return ContactResult(of_largest, delta, P, S, dS, np.zeros_like(radii))

    def _angles(self, a: float, plan: TensePlan) -> Angles:
        points = 5 * plan.order // 2 + math.ceil(TENSE_PER_DECADE * max(math.log10(a / self.kappa), 0.0))
        return Angles.of(*self._panels(a, plan), plan.order, points + points % 2)

    def _at(self, a: float, grid: Angles, singular: Function, smooth: Function) -> Array:
        """Delta, P, S, S' at the radius ``a`` [m] from the two parts of the kernel and their s d/ds."""
        K, rate = grid.matrices(singular, smooth, a)
        one = np.linalg.solve(K, np.ones(grid.tau.size))
        grown = -np.linalg.solve(K, rate @ one)  # a d(psi_1)/da
        # F and x F' [m] at the nodes, their means on the panels.
        joints = np.array([joint for joint in self.indenter.joints if joint < a])
        edges = math.pi / 2 - grid.edges[::-1]  # angles from the axis: F begins at its kinks
        cuts = edges, grid.order, TENSE_INNER
        F = panel_means(lambda x: self.indenter.abel(a * np.sin(x)), np.arcsin(joints / a), *cuts)
        slope = panel_means(lambda x: self.indenter.abel_slope(a * np.sin(x)), np.arcsin(joints / a), *cuts)
        F, steep = np.array([F[::-1], a * np.cos(grid.tau) * slope[::-1]])
        scale = math.pi * self.E_star
        S, dS = scale * (grid.w @ one), scale * (math.pi * float(grid.edge @ one)) ** 2 / (4 * a * self.kappa)
        Q, dQ = scale * ((grid.w * one) @ F), scale / a * ((grid.w * grown) @ F + (grid.w * one) @ steep)
        return np.array([dQ / dS, S * dQ / dS - Q, S, dS])

    def _slight(self, a: float) -> Array:
        """Delta, P, S, S' on a half-space at the radius ``a`` [m] >> kappa: the solution without tension and what it
        adds to first order, any profile:

            Q = 2 E* {int_0^a F dx + (kappa/pi) [(l + 1) F(a) - 2 int_0^a a (F(a) - F)/(a^2 - x^2) dx]},
            delta_H = Q'/S'.
        """
        cuts = np.array([joint / a for joint in self.indenter.joints if joint < a])
        cuts = np.union1d(np.linspace(0.0, 1.0, 3), cuts)
        u, w = (part.ravel() for part in crowded(cuts[:-1], cuts[1:], TENSE_INNER))
        F, slope = self.indenter.abel(a * u), self.indenter.abel_slope(a * u)
        (F_a,), (slope_a,) = self.indenter.abel(np.array([a])), self.indenter.abel_slope(np.array([a]))
        ring, share = formulas.logarithm(np.array(a), self.kappa) + 1, self.kappa / math.pi
        S, dS = formulas.stiffness(np.array(a), self.E_star, self.kappa)
        inner = 2 * (w @ ((F_a - F) / (1 - u**2))), 2 * (w @ ((slope_a - u * slope) / (1 - u**2)))
        Q = 2 * self.E_star * (a * (w @ F) + share * (ring * F_a - inner[0]))
        dQ = 2 * self.E_star * (F_a + share * (ring * slope_a + F_a / a - inner[1]))
        delta = dQ / dS
        return np.array([delta, S * delta - Q, S, dS])


@lru_cache(maxsize=8)
def _spectrum(specimen: Specimen) -> TenseSpectrum:
    return TenseSpectrum(specimen)


# --------------------------------------------------------------------------------------------------
# An elastic or coated tip on such a surface: its compliance 2 g_i/(E*_i k) adds to that of the specimen.
#
# Over many wave numbers the tip alone gives way: with E*_i in front
#
#     g = g_i + (E*_i/E*) g_s/(1 + kappa g_s k) = 1 + (E*_i/E*)/(1 + kappa k) + what decays with the layers,
#
# the equation is one of the second kind again with a logarithm in its kernel, as under a graded modulus, of which
# S, S', delta_H and P_H are found: no tension acts at the edge itself, within some 2 Ups/E*_i of it.

# The least tolerance, and nodes on a panel; tuned on tips as stiff as the specimen to 1e4 times, by `make constants`
ELASTIC_TIP_TOLERANCE, ELASTIC_TIP_ORDERS = 1e-5, range(8, 11)


@dataclass(frozen=True)
class TensionTail:
    """The share ``ratio``/(1 + kappa k) of a surface under tension, E*_i/E* the ``ratio``; ``finest``: the length [m]
    over which it varies."""

    ratio: float
    kappa: float
    finest: float

    @property
    def strength(self) -> float:
        """The factor of the kernel's logarithm [1/m]."""
        return self.ratio / self.kappa

    def __call__(self, k: Array) -> Array:
        return self.ratio / (1 + self.kappa * k)

    def transform(self, s: Array) -> Array:
        """int_0^inf cos(ks) dk of it [1/m] at s > 0 [m]."""
        return self.strength * formulas.displacement(s / self.kappa)


@dataclass(frozen=True, eq=False)
class TenseTipSpectrum(LayeredSpectrum):
    """Spectrum g - 1 of a surface under tension and an elastic tip, by the E* of the tip."""

    def __call__(self, k: Array) -> Array:
        (g, excess), y = compliance(self.specimen, k), self.tail.kappa * k
        of_tip = stacks(self.specimen, self.indenter)[bool(self.specimen.layers) :]  # its coating, where it has one
        own = self.tail.ratio * excess / ((1 + y * g) * (1 + y))
        return sum((compliance(body, k)[1] for body in of_tip), own)

    @property
    def tail(self) -> TensionTail:  # type: ignore[override]
        assert self.indenter is not None
        kappa, surface = self.specimen.tension_length, self.specimen.surface
        return TensionTail(self.indenter.E_star / surface.E_star, kappa, min(kappa, self.specimen.top_thickness))


class TenseTipSolver(LayeredContact):
    """An elastic tip on a layered specimen with surface tension, solved at given radii."""

    @property
    def E_star(self) -> float:
        """That of the tip [Pa]."""
        assert self.indenter.material is not None
        return self.indenter.material.E_star

    @cached_property
    def spectrum(self) -> TenseTipSpectrum:
        return TenseTipSpectrum(self.specimen, self.indenter.material)

    def together(self, radii: Array, tolerance: float) -> Quadrature:
        own = radii, self.indenter.a0, self.scale, tolerance, self.spectrum.tail.strength
        return Quadrature.crowded(*own, ELASTIC_TIP_ORDERS, math.inf)

"""An indenter on a body whose kernel finite elements compute: refined until the contact meets a tolerance."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from ..base.errors import Refusal, SolveError
from ..base.numerics import AT_ONCE, MOST_SOLVES, NO_CLAIM, TINY, Array
from ..base.process import duration
from ..base.units import show
from ..bodies.indenters import Indenter
from ..bodies.problem import AnyGraded, Coated, HalfSpace, Specimen, contact_modulus
from ..methods.integral.finite_range import Attraction, panels_for
from ..methods.integral.fredholm import EquationResult, Panels, Quadrature, rule, solve, tolerance_remedy
from ..methods.layered.contact import GRADED, LayeredContact
from ..series import KeptKernel
from .correction import (
    LINE_EXTRA,
    REGION_LEAST,
    REGION_SHRINK,
    Correction,
    LineElements,
    Region,
    closest_cut,
    correction,
    lines,
    side_correction,
)

# --------------------------------------------------------------------------------------------------
# The kernel K(x, t) of a body of revolution as even polynomials in x and t, from finite-element corrections.

STEP = 2  # in the degree, from level to level; tuned on bodies by hybrid, by `make constants`: odd ones gain little

# Rates of one core for forecasts.
COST_BEGIN = 5e-3  # s; tuned on bodies, by `make guards`: for forecasts
# s, to integrate and factorise, per entry of the stiffness; tuned on bodies, by `make guards`: for forecasts
COST_PER_ENTRY = 1e-7
# s, to solve, per entry and right-hand side; tuned on bodies, by `make guards`: for forecasts
COST_PER_ENTRY_AND_SIDE = 1.2e-9
# s, for the half-space's field, per Gauss point and parameter t; tuned on bodies, by `make guards`: for forecasts
COST_PER_POINT = 2e-7
# s, for their works in one another, per pair of t; tuned on bodies, by `make guards`: for forecasts
COST_PER_POINT_AND_PAIR = 2e-9
# s, for a field towards its ring under a graded top; tuned on bodies, by `make guards`: for forecasts
COST_AROUND = 8e-3
# entries of the factor beside elements graded to a corner, per unknown; tuned on bodies, by `make guards`: for
# forecasts
COST_FILL = 4.5
COST_OPERATIONS = 1.2e10  # on them, per s; tuned on bodies, by `make guards`: for forecasts
COST_BYTES_PER_ENTRY = 40.0  # of the stiffness and its factor; tuned on bodies, by `make guards`: for forecasts
# of the unknowns of one parameter t; tuned on bodies, by `make guards`: for forecasts
COST_BYTES_PER_VALUE = 100.0


@dataclass(frozen=True, eq=False)
class PolynomialKernel:
    """Kernel K [1/m] for 0 <= x, t <= ``reach`` [m]: sum of c_ij P_2i(x/reach) P_2j(t/reach), Legendre polynomials.

    ``scale``: the length over which K varies [m].
    """

    coefficients: Array
    reach: float
    scale: float

    def times(self, x: Array, t: Array, values: Array) -> Array:
        count = len(self.coefficients)
        waves: Array = self.coefficients @ (_even(t / self.reach, count).T @ values)
        return _even(x / self.reach, count) @ waves

    def square(self, x: Array) -> Array:
        even = _even(x / self.reach, len(self.coefficients))
        return even @ self.coefficients @ even.T

    def shorter(self) -> PolynomialKernel:
        """Kernel without the highest polynomial in x and in t."""
        return replace(self, coefficients=self.coefficients[:-1, :-1])


def _even(x: Array, count: int) -> Array:
    """Even Legendre polynomials P_0, P_2, ... at ``x``, (x.size, count)."""
    return legendre.legvander(x, 2 * count - 1)[:, ::2]


def convergence(region: Region) -> float:
    """The factor by which one more even polynomial in t reduces the error of K.

    K is analytic but for images of the contact: they lie twice the depth d of the nearest interface above, at
    t = x +- 2 i d, and at the side. The factor is rho^2, rho: sum of the half axes of the ellipse through the nearest
    singularity (Trefethen 2013, Ch. 8).
    """
    growth = 2 * region.first + math.hypot(1, 2 * region.first)
    if not region.cut_beside:
        growth = min(growth, region.width + math.sqrt(region.width**2 - 1))
    return growth**2


def count_for(region: Region, error: float) -> int:
    """How many even polynomials leave about ``error``."""
    falls = math.log(convergence(region))  # 0 to rounding where the contact is beyond all sizes of the body
    return max(3, math.ceil(min(math.log(1 / error) / max(falls, 1 / AT_ONCE), AT_ONCE)) + 1)


class CorrectionCost(NamedTuple):
    """CPU ``seconds``, peak ``memory_mib`` [MiB] and ``unknowns`` of one correction."""

    seconds: float
    memory_mib: float
    unknowns: int


def cost_of(region: Region, count: int, degree: int) -> CorrectionCost:
    """Cost of the correction for ``count`` parameters t: operations counted, with rates of one core."""
    r, z = lines(region, degree)
    pressures = 1 + any(region.mixed) / 3
    unknowns = 2 * pressures * (r.degrees.sum() + 1.0) * (z.degrees.sum() + 1.0)
    entries = 4 * pressures**2 * _pairs(r) * _pairs(z)
    points = float((r.degrees + LINE_EXTRA).sum() * (z.degrees + LINE_EXTRA).sum())
    fill = 0.0
    if region.corners or region.free_edges:
        fill = COST_FILL * unknowns * 2 * pressures * min(r.degrees.sum(), z.degrees.sum())
    seconds = COST_BEGIN + COST_PER_ENTRY * entries + COST_PER_ENTRY_AND_SIDE * count * (entries + fill)
    seconds += fill * (fill + 2 * entries) / unknowns / COST_OPERATIONS
    fields = (COST_PER_POINT + COST_PER_POINT_AND_PAIR * count) * points * count
    seconds += fields + COST_AROUND * count * region.changing
    memory = (COST_BYTES_PER_ENTRY * (entries + fill / 2) + COST_BYTES_PER_VALUE * unknowns * count) / 2**20
    return CorrectionCost(float(seconds), float(memory), int(unknowns))


def _pairs(line: LineElements) -> float:
    """How many pairs of functions overlap."""
    return float(np.sum((line.degrees + 1.0) ** 2))


def _below(degree: int) -> int:
    """The degree of elements that tell what a cut changes."""
    return max(degree - STEP, REGION_LEAST)


@dataclass(frozen=True, eq=False)
class KernelLevels:
    """Kernels of one ``region`` of growing degree, each computed once, from ``count`` parameters t.

    ``factor``: share of the specimen in the compliance of the half-spaces of both bodies. ``wide``: the laterally
    unbounded body of the same layers, where K is what the side adds to that.
    """

    region: Region
    count: int
    factor: float
    wide: Region | None = None
    _corrections: dict[tuple[int, bool], Correction] = field(default_factory=dict, init=False)

    def correction(self, degree: int, nearer: bool = False) -> Correction:
        """The correction with elements of ``degree``; ``nearer``: after the second cut of an unbounded body."""
        key = (degree, nearer)
        if key not in self._corrections:
            t = rule(2 * self.count)[0][self.count :]
            region = self.region.nearer() if nearer else self.region
            if self.wide is None:
                self._corrections[key] = correction(region, t, degree)
            else:
                self._corrections[key] = side_correction(region, self.wide, t, degree)
        return self._corrections[key]

    def cost(self, degree: int) -> CorrectionCost:
        """Cost of a level with its estimates of the error, the coarser levels left out."""
        costs = [cost_of(region, self.count, degree) for region in (self.region, self.wide) if region is not None]
        if self.region.cut_beside:
            costs.append(cost_of(self.region.nearer(), self.count, _below(degree)))
        seconds, memory, unknowns = zip(*costs, strict=True)
        return CorrectionCost(sum(seconds), max(memory), max(unknowns))

    def cut(self, degree: int) -> PolynomialKernel:
        """K of the body after its first cut where extrapolating goes on from there, or else after the second one."""
        K = self.correction(degree).K
        return self._kernel(K if self.region.algebraic else K - self._by_cut(degree))

    def kernel(self, degree: int, coarser: int = 0) -> PolynomialKernel:
        """K of the whole body by elements of ``degree``, or so many levels ``coarser``; extrapolated, where what the
        cut costs falls with the square of its distance."""
        K = self.correction(degree - STEP * coarser).K
        if self.region.algebraic:
            K = K + self._by_cut(degree) / (REGION_SHRINK**2 - 1)
        return self._kernel(K)

    def _by_cut(self, degree: int) -> Array:
        """What the first cut leaves of K beyond the second one, by elements of about one level below ``degree``."""
        below = _below(degree)
        return self.correction(below).K - self.correction(below, nearer=True).K

    def rounded(self, degree: int) -> PolynomialKernel:
        """K of the whole body by elements of ``degree`` with the error that rounding leaves: in the longest and in the
        shortest waves, as it is at random."""
        i = np.arange(self.count)
        error = self._kernel(self.correction(degree).rounding * (1 + (-1.0) ** np.add.outer(i, i)))
        kernel = self.kernel(degree)
        return replace(kernel, coefficients=kernel.coefficients + error.coefficients)

    def _kernel(self, K: Array) -> PolynomialKernel:
        t, w = (half[self.count :] for half in rule(2 * self.count))
        even = _even(t, self.count) * w[:, None] * (4 * np.arange(self.count) + 1)
        unit = self.region.unit
        return PolynomialKernel(self.factor / unit * (even.T @ K @ even), unit, unit * closest_cut(self.region))


# How the tolerance is shared out, how errors are judged from what they change, and when refinement ends.
HYBRID_EDGE = 0.98  # largest contact radius over the radius of the body; choice: a side so near needs other means
HYBRID_ROUGH = 1e-3  # accuracy of the kernel with which radii are searched; choice: what costs least
# Shares of the tolerance:
# Planned for the number of t; conditioning takes the rest:
HYBRID_PARAMETERS = 1e-2  # tuned on reference bodies, by `make tuning`
HYBRID_CUT = 0.1  # of an unbounded body; choice: a tenth
HYBRID_NO_CLAIM = 0.01  # smaller errors are not distinguished; tuned on random bodies, by `make bounds`
HYBRID_FINEST = 1e-7  # accuracy of K where the modulus changes from the contact on; choice: below ``GRADED``
# Errors from what a step changes, at some radii:
HYBRID_SAMPLES = 13  # radii; tuned on random bodies, by `make bounds`
HYBRID_SMALLEST = 0.02  # of the largest, the first of them; tuned on random bodies, by `make bounds`
# more near the largest, where polynomials err in their shortest waves: one radius alone may lie at a node of them
HYBRID_NEAR = (0.84, 0.92, 0.97)  # of it; tuned on random bodies, by `make bounds`
# On the error that the last step of the degree leaves:
HYBRID_SAFETY = 3.0  # tuned on random bodies, by `make bounds`
# Of the largest change that of a column, from which on it tells how fast errors fall:
HYBRID_TELLING = 0.1  # tuned on random bodies, by `make bounds`
HYBRID_SLOWEST = 3.0  # what a step divides it by, at least; tuned on random bodies, by `make failures`
HYBRID_FASTEST = 300.0  # at most; tuned on random bodies, by `make bounds`
HYBRID_UNPROVEN = 50.0  # at most, after one step from the lowest; tuned on random bodies, by `make bounds`
HYBRID_CORNERED = 8.0  # at most, with singular corners; tuned on random bodies, by `make bounds`
HYBRID_IRREGULAR = 2  # elements, up to which no fall is trusted; tuned on random bodies, by `make bounds`
# Of a last step that is as much smaller than the one before as that of the other radii and columns:
HYBRID_ACCIDENT = 0.8  # tuned on random bodies, by `make bounds`
HYBRID_PLAUSIBLE = 100.0  # so much smaller, of irregular elements; tuned on random bodies, by `make bounds`
# Times what is small by accident, at pull-off points, after one step from the lowest:
HYBRID_AT_POINTS = 2.0  # tuned on random bodies, by `make bounds`
HYBRID_STEEPER = 2.0  # error of S' over that of the others, at least; tuned on random bodies, by `make failures`
HYBRID_ALLOWED = 0.5  # of the tolerance, up to which ``steeper`` asks for no finer elements; choice: half
HYBRID_UNSEEN = 3.0  # times the last polynomial's change / (convergence - 1): its error; theory: geometric series
HYBRID_LEAST = 0.5  # of that change, at least; tuned on random bodies, by `make failures`
# Error of S' by the cut over that of S, at least; theory: the next order changes S by a^3 relative to S ~ a
HYBRID_STEEPER_CUT = 3.0
# Of the largest change by extrapolating the cut, where the order that it rests on vanishes and others may cancel
HYBRID_CANCELLED = 1.5  # tuned on random bodies, by `make bounds`
# Of what the second cut changes where fields decay exponentially:
HYBRID_DECAYED = 0.05  # tuned on random bodies, by `make failures`
# Refinement:
HYBRID_LOWEST = 4  # degree; tuned on reference bodies, by `make tuning`
HYBRID_HIGHEST = 16  # degree; choice: rounding sets the limit beyond
# Of the tolerance, to which parameters and cut are brought:
HYBRID_SHARE = 0.25  # tuned on reference bodies, by `make tuning`
HYBRID_AGAIN = 2  # times that parameters are added, and that the cut is moved out; choice: each costs a solve
HYBRID_STALLS = 1  # times that a step may bring next to nothing; choice: corners need one
HYBRID_HOPELESS = 30.0  # times the tolerance, where none is forgiven; tuned on random bodies, by `make failures`
# Forecasts of the degree, in steps from the lowest:
HYBRID_PER_DECADE = 0.4  # of moduli; tuned on bodies, by `make guards`: for forecasts
HYBRID_PER_DECADE_WIDE = 0.2  # of contact radius over depth; tuned on bodies, by `make guards`: for forecasts
# more for nearly incompressible layers with sides; tuned on bodies, by `make guards`: for forecasts
HYBRID_AT_SIDES = 0.5
# Limits of one level:
HYBRID_MOST_SECONDS = 60.0  # CPU time; choice: what a user waits for
HYBRID_MOST_MIB = 4096.0  # choice: what a laptop has
HYBRID_FAR = 10.0  # times them, beyond which costs are not told apart; choice: for messages


ALL = np.ones(4)  # of delta, P, S, S' alike


@dataclass(frozen=True, eq=False)
class KernelContact:
    """An indenter on a body of the known ``kernel``, up to the radius ``limit`` [m]."""

    indenter: Indenter
    E_star: float
    kernel: PolynomialKernel
    limit: float

    @property
    def scale(self) -> float:
        return self.kernel.scale

    def plan(self, radii: Array, tolerance: float) -> Quadrature:
        """A quadrature accurate to ``tolerance`` at the increasing ``radii`` [m]."""
        return Quadrature.cheapest(radii, self.indenter.a0, self.scale, tolerance)

    def solved(self, radii: Array, plan: Quadrature) -> EquationResult:
        """Nonadhesive contact at the increasing ``radii`` [m]."""
        panels = Panels.through(radii, plan, self.indenter.a0)
        return solve(self.matrix(panels), panels, self.indenter, self.E_star, plan.inner)

    def matrix(self, panels: Panels) -> Array:
        """K [1/m] at the places of the ``panels``."""
        return self.kernel.square(panels.places)

    def attraction(self, reach: float, tolerance: float) -> Attraction:
        """The pair of bodies ready for adhesion of finite range up to ``reach`` <= ``limit`` [m]."""
        panels = self.attraction_panels(reach, tolerance)
        return Attraction.of(self.indenter, self.E_star, panels, self.matrix(panels))

    def attraction_panels(self, reach: float, tolerance: float) -> Panels:
        """The panels of ``attraction``; Refusal where they are too many."""
        return panels_for(reach, self.indenter.a0, self.scale, tolerance, 1.0)

    def settled(self, radii: Array, tolerance: float) -> tuple[EquationResult, Array]:
        """Contact at ``radii`` [m] by quadratures ever finer until they agree to the ``tolerance``, and the last change
        of the columns (4, radii), relative: a profile that ends close by is no polynomial."""
        plan = self.plan(radii, tolerance)
        result, change = self.solved(radii, plan), np.inf * np.ones((4, radii.size))
        for _ in range(MOST_SOLVES):
            if change.max() <= tolerance:
                break
            plan = plan.finer()
            before, result = result, self.solved(radii, plan)
            change = np.abs(before.columns / result.columns - 1)
        return result, change

    def columns(self, radii: Array, tolerance: float) -> Array:
        """Rows delta, P, S, S' at ``radii`` [m]."""
        return self.solved(radii, self.plan(radii, tolerance)).columns


@dataclass(frozen=True, eq=False)
class SideContact(KernelContact):
    """An indenter on a body whose ``kernel`` is only what the side adds to the K of the ``wide`` body, which is known
    exactly."""

    wide: LayeredContact

    @property
    def scale(self) -> float:
        return min(self.kernel.scale, self.wide.scale)

    def plan(self, radii: Array, tolerance: float) -> Quadrature:
        plan = self.wide.together(radii, max(tolerance, HYBRID_FINEST))
        return replace(plan, widest=plan.widest * min(self.kernel.scale / self.wide.scale, 1.0))

    def solved(self, radii: Array, plan: Quadrature) -> EquationResult:
        self.wide.guard(radii, plan)
        return super().solved(radii, plan)

    def matrix(self, panels: Panels) -> Array:
        return self.wide.matrix(panels) + super().matrix(panels)

    def attraction_panels(self, reach: float, tolerance: float) -> Panels:
        return self.wide.attraction_panels(reach, tolerance)


@dataclass(frozen=True, eq=False)
class ErrorModes:
    """A ``contact`` beside others with one of the ``kernels``, each without one thing: finer elements, the last
    polynomial, digits, the cut's distance; found to the relative ``accuracy``. ``weights``: the part of each change
    that is left as an error, of each column; ``least``: relative errors that nothing tells apart."""

    contact: KernelContact
    kernels: tuple[PolynomialKernel, ...]
    accuracy: float
    weights: tuple[Array, ...] = ()
    least: float = 0.0

    def changes(self, radii: Array) -> Array:
        """Relative changes, with their signs, of delta, P, S, S' (kernels, 4, radii) at ``radii`` [m]; infinite where
        the equation is not positive definite."""
        best = self.contact.columns(radii, self.accuracy)
        changes = []
        for kernel in self.kernels:
            try:
                changes.append(replace(self.contact, kernel=kernel).columns(radii, self.accuracy) / best - 1)
            except SolveError:
                changes.append(np.full_like(best, np.inf))
        return np.array(changes)

    def __call__(self, radii: Array) -> Array:
        """What is left, relative errors (n, 4, radii), those of one companion alike from radius to radius."""
        changes = self.changes(radii)
        return np.array(self.weights)[:, :, None] * np.where(np.isfinite(changes), changes, 0.0)


@dataclass(frozen=True, eq=False)
class ErrorEstimates:
    """Estimated relative errors (columns, radii) at ``radii`` [m]: of elements, of the parameters t, of the cut; and
    the ``companions`` that show them."""

    radii: Array
    elements: Array
    parameters: Array
    cut: Array
    companions: ErrorModes | None = None

    @property
    def total(self) -> Array:
        return self.elements + self.parameters + self.cut

    def at(self, radii: Array) -> Array:
        """Total errors (columns, radii) at any radii: never less than at a smaller one."""
        rising = np.maximum.accumulate(self.total, axis=1)
        return np.array([np.interp(radii, self.radii, row) for row in rising])

    @property
    def kept(self) -> KeptKernel:
        """The kernel of the ``companions`` with them and these errors; coefficients that one lacks are 0."""
        assert self.companions is not None
        contact, kernel = self.companions.contact, self.companions.contact.kernel
        kernels = (kernel, *self.companions.kernels)
        missing = [len(kernel.coefficients) - len(each.coefficients) for each in kernels]
        return KeptKernel(
            np.array([np.pad(each.coefficients, (0, n)) for each, n in zip(kernels, missing, strict=True)]),
            kernel.reach,
            kernel.scale,
            isinstance(contact, SideContact),
            np.array(self.companions.weights),
            self.companions.accuracy,
            self.companions.least,
            self.radii,
            np.array([self.elements, self.parameters, self.cut]),
        )


@dataclass(frozen=True)
class Refinement:
    """State of a refinement: elements of ``degree``, ``more`` parameters t than planned, and the cut planned for an
    error that is ``sharper`` times as small; how often parameters were ``added``, the cut was ``widened``, and a higher
    degree ``stalled``: left more than half of the ``least`` error so far, last seen ``at`` a lower degree."""

    degree: int = field(default_factory=lambda: HYBRID_LOWEST + STEP)
    more: int = 0
    sharper: float = 1.0
    added: int = 0
    widened: int = 0
    stalled: int = 0
    least: float = math.inf
    at: int = field(default_factory=lambda: HYBRID_HIGHEST)

    def after(self, errors: ErrorEstimates, tolerance: float, region: Region) -> Refinement | None:
        """The next refinement, which lessens the largest of the ``errors``; None where nothing does."""
        total = float(errors.total.max())
        stalled = self.stalled + (self.degree > self.at and total > self.least / 2)
        if stalled > (self.stalled if total > HYBRID_HOPELESS * tolerance else HYBRID_STALLS):
            return None
        here = replace(self, stalled=stalled, least=min(self.least, total), at=self.degree)
        elements, parameters, cut = (float(e.max()) for e in (errors.elements, errors.parameters, errors.cut))
        goal = HYBRID_SHARE * tolerance
        fuller = here
        if math.inf > parameters > goal and self.added < HYBRID_AGAIN:
            missing = math.ceil(math.log(parameters / goal) / math.log(convergence(region)))
            fuller = replace(here, more=self.more + max(missing, 1), added=self.added + 1)
            if parameters > max(elements, cut):
                return fuller
        if math.inf > cut > max(elements, parameters, goal) and region.algebraic:
            wider = replace(here, sharper=self.sharper * cut / goal, widened=self.widened + 1)
            return wider if wider.widened <= HYBRID_AGAIN else None
        if self.degree >= HYBRID_HIGHEST:
            return None
        # what is missing at every degree is not computed anew at a higher one
        return replace(fuller if parameters > (1 - HYBRID_SHARE) * tolerance else here, degree=self.degree + STEP)


@dataclass(frozen=True, eq=False)
class AdaptiveKernel:
    """Kernel of a ``specimen`` under an ``indenter``, refined until delta, P, S, S' meet a relative ``tolerance``."""

    indenter: Indenter
    specimen: Specimen
    tolerance: float

    @property
    def E_star(self) -> float:
        return contact_modulus(self.specimen.surface, self.indenter.material)

    @property
    def limit(self) -> float:
        """Largest contact radius [m]."""
        return np.inf if self.specimen.radius is None else HYBRID_EDGE * self.specimen.radius

    @property
    def attainable(self) -> float:
        """The tolerance that holds for this body."""
        return max(self.tolerance, 2 * GRADED) if isinstance(self.specimen.materials[0], AnyGraded) else self.tolerance

    @cached_property
    def wide(self) -> LayeredContact:
        """Contact with the body without its sides, solved exactly."""
        return LayeredContact(self.indenter, replace(self.specimen, radius=None, side=None))

    def levels(self, reach: float, step: Refinement | None = None) -> KernelLevels:
        """Levels for contact radii up to ``reach`` [m], as far as ``step`` has refined what was planned."""
        step = step or Refinement()
        cut = HYBRID_CUT * self.tolerance / step.sharper
        region = Region.of(self.specimen, reach, cut)
        error = HYBRID_PARAMETERS * self.tolerance / math.sqrt(_stiffening(region))
        count = count_for(region, error) + step.more
        # of a coated indenter the exact part has the layers of both bodies
        apart = region.changing or isinstance(self.indenter.material, Coated)
        wide = Region.of(self.wide.specimen, reach, cut) if apart else None
        return KernelLevels(region, count, self.E_star / self.specimen.surface.E_star, wide)

    def guard(self, levels: KernelLevels, degree: int) -> None:
        """Refuse what would take minutes or gigabytes."""
        cost, unit = levels.cost(degree), levels.region.unit
        away = show(closest_cut(levels.region) * unit, "length")
        if cost.seconds > HYBRID_MOST_SECONDS or cost.memory_mib > HYBRID_MOST_MIB:
            raise Refusal(
                f"hybrid: contact radii up to {show(unit, 'length')} need elements of degree {degree} with about "
                f"{cost.unknowns} unknowns for {levels.count} right-hand sides, "
                f"{cost_words(cost.seconds, cost.memory_mib)} (limits {HYBRID_MOST_SECONDS:g} s, {HYBRID_MOST_MIB:g} "
                f"MiB): the contact is large against the nearest interface or side ({away} away); use a smaller "
                f"contact or a larger hybrid.tolerance, or use method {instead(self.indenter, self.specimen)}"
            )

    def expected_steps(self, levels: KernelLevels) -> float:
        """How many steps of the degree from the lowest on the tolerance will need."""
        moduli = [modulus for layer in self.specimen.layers for modulus in layer.moduli]
        if isinstance(self.specimen.base, HalfSpace):
            moduli.append(self.specimen.base.material.surface.E)
        contrast = math.log10(max(moduli) / min(moduli))
        wide = math.log10(max(1 / levels.region.first, 1.0))
        steps = -math.log10(self.tolerance) - 3 + HYBRID_PER_DECADE * contrast + HYBRID_PER_DECADE_WIDE * wide
        if any(levels.region.mixed) and not levels.region.cut_beside:
            steps += HYBRID_AT_SIDES
        return min(max(steps, 1.0), (HYBRID_HIGHEST - HYBRID_LOWEST) / STEP)

    def expected_cost(self, levels: KernelLevels) -> tuple[float, CorrectionCost]:
        """CPU seconds of all levels up to the one that the tolerance is expected to need, and the cost of that one."""
        steps = self.expected_steps(levels)
        degrees = range(HYBRID_LOWEST, HYBRID_LOWEST + STEP * math.ceil(steps) + 1, STEP)
        costs = [levels.cost(degree) for degree in degrees]
        shares = np.clip(steps - np.arange(len(costs)) + 1, 0, 1)  # the last level is needed in some of such bodies
        return float(shares @ [cost.seconds for cost in costs]), costs[-1]

    def rough(self, reach: float) -> KernelContact:
        """Contact for finding radii: by the first level from the second on that gives a positive definite equation."""
        levels = replace(self, tolerance=max(self.tolerance, HYBRID_ROUGH)).levels(reach)
        for degree in range(HYBRID_LOWEST + STEP, HYBRID_HIGHEST, STEP):
            contact = self._contact(levels, degree)
            try:
                contact.columns(np.array([reach]), HYBRID_ROUGH)
            except SolveError:
                continue
            return contact
        return self._contact(levels, HYBRID_HIGHEST)

    def _contact(self, levels: KernelLevels, degree: int) -> KernelContact:
        self.guard(levels, degree)
        return self._with(levels.kernel(degree), levels.wide is not None)

    def _with(self, kernel: PolynomialKernel, of_side: bool) -> KernelContact:
        own = (self.indenter, self.E_star, kernel, kernel.reach)
        return SideContact(*own, self.wide) if of_side else KernelContact(*own)

    def from_kept(self, kept: KeptKernel) -> tuple[KernelContact, ErrorEstimates]:
        """The contact and its errors with a kernel of this body that was ``kept``: as ``accurate`` gave them."""
        kernel, *others = (PolynomialKernel(each, kept.reach, kept.scale) for each in kept.coefficients)
        contact = self._with(kernel, kept.of_side)
        companions = ErrorModes(contact, tuple(others), kept.accuracy, tuple(kept.weights), kept.least)
        elements, parameters, cut = kept.errors
        return contact, ErrorEstimates(kept.radii, elements, parameters, cut, companions)

    def accurate(self, reach: float) -> tuple[KernelContact, ErrorEstimates, KernelLevels, int]:
        """The contact for radii up to ``reach`` [m] that meets the tolerance, its errors, and its degree."""
        levels = self.levels(reach)
        # The lowest degree that is judged, by the two below it: of one element the lowest may be right by
        # accident, so that the next two differ by no more than it errs
        higher = HYBRID_LOWEST + 2 * STEP
        is_one = levels.cost(higher).unknowns < 3 * (higher + 1) ** 2  # two unknowns a node and pressures; of two: 4
        first = higher if is_one else HYBRID_LOWEST + STEP
        step: Refinement | None = Refinement(degree=first)
        while step is not None:
            tried = step
            contact = self._contact(levels, step.degree)
            try:
                errors = self._judge(contact, levels, step.degree)
            except SolveError:  # not positive definite: too coarse for a great contrast of moduli
                if step.degree == HYBRID_HIGHEST:
                    raise
                step = replace(step, degree=step.degree + STEP)
                continue
            if errors.total.max() <= self.attainable:
                return contact, errors, levels, step.degree
            step = step.after(errors, self.attainable, levels.region)
            if step is not None and (step.more, step.sharper) != (tried.more, tried.sharper):
                levels = self.levels(reach, step)
        remedy = tolerance_remedy("hybrid", float(errors.total.max()))
        raise Refusal(
            f"hybrid: the estimated relative error is {errors.total.max():.1e} with elements of degree {tried.degree}, "
            f"above the tolerance {self.tolerance:.1e}; {remedy}use a smaller contact radius or use method "
            f"{instead(self.indenter, self.specimen)}"
        )

    def _judge(self, contact: KernelContact, levels: KernelLevels, degree: int) -> ErrorEstimates:
        """Errors at some radii, from what lower levels, one polynomial less and the cut change."""
        a0, end = self.indenter.a0, levels.region.unit
        radii = a0 + (end - a0) * np.union1d(np.geomspace(HYBRID_SMALLEST, 1, HYBRID_SAMPLES), HYBRID_NEAR)
        region, precise = levels.region, NO_CLAIM * self.tolerance
        shorter = contact.kernel.shorter()
        kernels = [levels.kernel(degree, coarser=1), levels.kernel(degree, coarser=2), shorter, shorter.shorter()]
        kernels += [levels.rounded(degree)]
        kernels += [levels.cut(degree)] if region.cut_beside else []
        companions = ErrorModes(contact, tuple(kernels), precise)
        last, before, wave, other, rounding, *cuts = np.abs(companions.changes(radii))
        fastest = HYBRID_CORNERED if region.corners else HYBRID_FASTEST
        after_lowest = degree - 2 * STEP < HYBRID_LOWEST
        fastest = min(fastest, HYBRID_UNPROVEN) if after_lowest else fastest
        known = bool(np.isfinite(before).all())
        fast = known and levels.correction(degree).elements > HYBRID_IRREGULAR
        falls = np.full(radii.size, HYBRID_SLOWEST)
        smaller = np.full(radii.size, HYBRID_PLAUSIBLE)
        if fast:
            falls = _falls(before, last, fastest)
            smaller = _falls(before, last, HYBRID_CORNERED if region.corners else HYBRID_FASTEST)
        # Two levels may agree by accident at some radii in some columns: what the step before says of the last counts
        by_accident = HYBRID_ACCIDENT * known / (smaller * falls)
        accident = by_accident * (before if known else 0.0)
        left = max(HYBRID_UNSEEN / (convergence(region) - 1), HYBRID_LEAST)
        # The polynomial that is missing goes in waves: the last one shows one phase of them, the last but one another:
        parameters = left * np.hypot(wave, other / convergence(region))
        # What the cut leaves: of the next order, or, of fields that decay exponentially, the second cut
        cut = _of_cut(region)[:, None] * cuts[0] if cuts else np.zeros_like(last)
        if cuts and region.algebraic:
            cut[-1] = np.maximum(cut[-1], HYBRID_STEEPER_CUT * cut[2])
            cut = np.maximum(cut, cut[:-1].max()) if region.higher_order else cut
        least = HYBRID_NO_CLAIM * self.tolerance + (GRADED if region.changing else 0.0)
        elements = np.hypot(HYBRID_SAFETY / falls * last, accident) + rounding + least
        steeper = np.minimum(HYBRID_STEEPER * elements[:-1].max(axis=0), HYBRID_ALLOWED * self.attainable)
        elements[-1] = np.maximum(elements[-1], steeper)
        at_points = float(by_accident[-1]) * (HYBRID_AT_POINTS if after_lowest else 1.0)
        parts = (HYBRID_SAFETY / float(falls[-1]), at_points, left, left / convergence(region), 1.0)
        weights = (*(part * ALL for part in parts), _of_cut(region))[: len(kernels)]
        companions = replace(companions, weights=weights, least=least + precise)
        return ErrorEstimates(radii, elements, parameters, cut, companions)


def _falls(before: Array, last: Array, fastest: float) -> Array:
    """By what a step of the degree divides the error up to each of the radii, as the step ``before`` and the ``last``
    one (4, radii) changed the column that falls least, as another may seem to fall fast by accident; one that hardly
    changes tells nothing. At smaller radii less than at the largest, where errors fall first."""
    before, last = (np.maximum.accumulate(changes, axis=1) for changes in (before, last))
    each = np.where(last >= HYBRID_TELLING * last.max(axis=0), before / np.maximum(last, TINY), np.inf)
    falls: Array = np.clip(each.min(axis=0) - 1, HYBRID_SLOWEST, fastest)
    return np.minimum(falls, falls[-1])


def _of_cut(region: Region) -> Array:
    """What is left of such a change of delta, P, S, S'; of P all, which the spring that extrapolating adds leaves."""
    if not region.algebraic:
        return np.full(4, HYBRID_DECAYED)
    if region.higher_order:
        return np.full(4, HYBRID_CANCELLED)
    return np.where([False, True, False, False], 1.0, region.next_order)


def cost_words(seconds: float, memory_mib: float) -> str:
    """Time and memory in words, up to some times the limits: what is far beyond them is not to be had, however far."""
    far = HYBRID_FAR * HYBRID_MOST_SECONDS, HYBRID_FAR * HYBRID_MOST_MIB
    time = duration(seconds) if seconds <= far[0] else f"more than {duration(far[0])}"
    return f"{time} and {memory_mib:.0f} MiB" if memory_mib <= far[1] else f"{time} and more than {far[1]:.0f} MiB"


def instead(indenter: Indenter, specimen: Specimen) -> str:
    """Another method as a remedy: ``layered`` without sides, else ``fem``."""
    return "layered" if specimen.radius is None else fem_for(indenter)


def fem_for(indenter: Indenter) -> str:
    """The method ``fem`` as a remedy: it knows no elastic indenter on the bodies that belong here."""
    return "fem" if indenter.material is None else "fem (with a rigid indenter)"


def _stiffening(region: Region) -> float:
    """Contact stiffness of a wide contact over that of the half-space, about, at least 1: relative errors of K count so
    many times in S.

    Layers in series, each of the compliance h/(pi a^2 M) where it is compressed, M its oedometric modulus, and
    2 h^3/(3 pi G a^4) where it is squeezed out between bonded surfaces; a sliding base does not hold it.
    """
    compliance = 0.0
    layers = region.thicknesses[:-1] if region.far is not None else region.thicknesses
    for h, material in zip(layers, region.materials, strict=False):
        surface, nu = material.surface, material.surface.nu
        if region.base[0]:
            oedometric = surface.E_star * (1 - nu) ** 2 / (1 - 2 * nu) if nu < 0.5 else math.inf
            compliance += h / (math.pi * oedometric) + 2 * h**3 / (3 * math.pi * surface.G)
        else:
            compliance += h / (math.pi * surface.E_star)
    if region.far is not None:
        compliance += 1 / (2 * region.far.E_star)
    return max(1 / (2 * region.reference.E_star * compliance), 1.0)

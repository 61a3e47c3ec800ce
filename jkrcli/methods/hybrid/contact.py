"""One indenter on one body: the kernel that an accuracy needs, and what it leaves."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...base.errors import Refusal, SolveError
from ...base.units import show
from ...bodies.indenters import Indenter
from ...bodies.materials import Graded, contact_modulus
from ...bodies.problem import HalfSpace, Specimen
from ..guards import duration
from ..integral.equation import DiscreteEquation, EquationResult, solve
from ..integral.quadrature import Panels, Quadrature
from ..layered.contact import LayeredContact
from ..layered.layered import GRADED
from .kernel import STEP, Levels, PolynomialKernel, convergence, count_for
from .refinement import HIGHEST, LOWEST, Judged, Step
from .region import Region, nearest

Array = np.ndarray

EDGE = 0.98  # largest contact radius over the radius of the body
QUADRATURE = 1e-3  # of the tolerance: error of the quadrature of the contact equation
PARAMETERS = 1e-2  # of the tolerance, planned for the number of parameters t; conditioning takes the rest
CUT = 0.1  # of the tolerance, for cutting an unbounded body
SAMPLES = 6  # radii at which errors are judged
NO_CLAIM = 0.05  # errors below this part of the tolerance are not told apart: quadratures, rounding
SAFETY = 2.5  # on the error that the last step of the degree leaves
STEEPER = 2.0  # S' errs so many times as much as the others, whatever the last step happens to change,
ALLOWED = 0.5  # but that alone, up to this part of the tolerance, asks for no finer elements
SLOWEST, FASTEST = 3.0, 15.0  # what a step divides it by
CORNERED = 8.0  # at most, with singular corners
UNSEEN, LEAST = 3.0, 0.5  # of the last polynomial's change times 1/(convergence - 1): the error left; at least
EXTRAPOLATED = 0.5  # at most, of what extrapolating the cut changes: the error left
DECAYED = 0.05  # of what the second cut changes where the field decays exponentially: more than the first one does
ROUGH = 1e-3  # relative accuracy of the kernel with which radii are looked for
LOOSEST = 1e-2  # of the tolerances
PER_DECADE, PER_DECADE_WIDE = 0.5, 0.6  # steps of the degree per decade of moduli, and of contact radius over depth
AT_SIDES = 1.0  # more of them for nearly incompressible layers with sides
FINEST = 1e-7  # relative accuracy of K where the modulus changes from the contact on
MAX_SECONDS, MAX_MIB = 60.0, 4096.0  # CPU time and memory of one level


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
        """Solve at the increasing ``radii`` [m]."""
        equation = DiscreteEquation.of(self.kernel, Panels.through(radii, plan, self.indenter.a0))
        return solve(equation, self.indenter, self.E_star)

    def columns(self, radii: Array, tolerance: float) -> Array:
        """delta, P, S, S' at ``radii`` [m] as rows."""
        return self.solved(radii, self.plan(radii, tolerance)).columns


@dataclass(frozen=True, eq=False)
class SideContact(KernelContact):
    """The same where ``kernel`` is only what the side adds to the K of the ``wide`` body, which is known exactly."""

    wide: LayeredContact

    @property
    def scale(self) -> float:
        return min(self.kernel.scale, self.wide.scale)

    def plan(self, radii: Array, tolerance: float) -> Quadrature:
        plan = self.wide.plan(radii, max(tolerance, FINEST))
        return replace(plan, widest=plan.widest * min(self.kernel.scale / self.wide.scale, 1.0))

    def solved(self, radii: Array, plan: Quadrature) -> EquationResult:
        return self.wide.solved(radii, plan, added=self.kernel)


@dataclass(frozen=True, eq=False)
class Body:
    """An indenter on a ``specimen``; ``tolerance``: relative error of delta, P, S and S' to reach."""

    indenter: Indenter
    specimen: Specimen
    tolerance: float

    @property
    def E_star(self) -> float:
        return contact_modulus(self.specimen.surface, self.indenter.material)

    @property
    def limit(self) -> float:
        """Largest contact radius [m]."""
        return np.inf if self.specimen.radius is None else EDGE * self.specimen.radius

    @property
    def attainable(self) -> float:
        """The tolerance that holds for this body."""
        return max(self.tolerance, 2 * GRADED) if isinstance(self.specimen.materials[0], Graded) else self.tolerance

    @property
    def _wide(self) -> Specimen:
        return replace(self.specimen, radius=None, side=None)

    @cached_property
    def _layered(self) -> LayeredContact:
        return LayeredContact(self.indenter, self._wide)

    def levels(self, reach: float, step: Step | None = None) -> Levels:
        """For contact radii up to ``reach`` [m], as far as ``step`` has refined what was planned."""
        step = step or Step()
        cut = CUT * self.tolerance / step.sharper
        region = Region.of(self.specimen, reach, cut)
        count = count_for(region, PARAMETERS * self.tolerance) + step.more
        wide = Region.of(self._wide, reach, cut) if region.changing else None
        return Levels(region, count, self.E_star / self.specimen.surface.E_star, wide)

    def expected_levels(self, reach: float) -> Levels:
        """The same with as many parameters t as will be needed, about: more than planned where the body is stiff."""
        levels = self.levels(reach)
        return replace(levels, count=count_for(levels.region, PARAMETERS * self.tolerance / _stiffening(levels.region)))

    def guard(self, levels: Levels, degree: int) -> None:
        """Refuse what would take minutes or gigabytes."""
        cost, unit = levels.cost(degree), levels.region.unit
        if cost.seconds > MAX_SECONDS or cost.memory_mib > MAX_MIB:
            raise Refusal(
                f"hybrid: contact radii up to {show(unit, 'length')} need elements of degree {degree} with about "
                f"{cost.unknowns} unknowns for {levels.count} right-hand sides, {duration(cost.seconds)} and "
                f"{cost.memory_mib:.0f} MiB (limits {MAX_SECONDS:g} s, {MAX_MIB:g} MiB): the contact is large against "
                f"the nearest interface or side ({show(nearest(levels.region) * unit, 'length')} away); ask for a "
                f"smaller contact or a larger hybrid.tolerance, or use method {self._instead}"
            )

    @property
    def _instead(self) -> str:
        return "layered" if self.specimen.radius is None else fem_for(self.indenter)

    def expected_steps(self, levels: Levels) -> float:
        """How many steps of the degree from ``LOWEST`` on the tolerance will need."""
        moduli = [modulus for layer in self.specimen.layers for modulus in layer.moduli]
        if isinstance(self.specimen.base, HalfSpace):
            moduli.append(self.specimen.base.material.surface.E)
        contrast = math.log10(max(moduli) / min(moduli))
        wide = math.log10(max(1 / levels.region.first, 1.0))
        steps = -math.log10(self.tolerance) - 3 + PER_DECADE * contrast + PER_DECADE_WIDE * wide
        if any(levels.region.mixed) and not levels.region.cut_beside:
            steps += AT_SIDES
        return min(max(steps, 1.0), (HIGHEST - LOWEST) / STEP)

    def rough(self, reach: float) -> KernelContact:
        """For finding radii: the first level from the second on that gives a positive definite equation."""
        levels = replace(self, tolerance=max(self.tolerance, ROUGH)).levels(reach)
        for degree in range(LOWEST + STEP, HIGHEST, STEP):
            contact = self._contact(levels, degree)
            try:
                contact.columns(np.array([reach]), ROUGH)
            except SolveError:
                continue
            return contact
        return self._contact(levels, HIGHEST)

    def _contact(self, levels: Levels, degree: int) -> KernelContact:
        self.guard(levels, degree)
        own = (self.indenter, self.E_star, levels.kernel(degree), levels.region.unit)
        return KernelContact(*own) if levels.wide is None else SideContact(*own, self._layered)

    def accurate(self, reach: float) -> tuple[KernelContact, Judged, Levels, int]:
        """The contact for radii up to ``reach`` [m] that meets the tolerance, how it was judged, and its degree."""
        step: Step | None = Step()
        levels = self.levels(reach)
        while step is not None:
            tried = step
            contact = self._contact(levels, step.degree)
            try:
                judged = self._judge(contact, levels, step.degree)
            except SolveError:  # not positive definite: too coarse for a great contrast of moduli
                if step.degree == HIGHEST:
                    raise
                step = replace(step, degree=step.degree + STEP)
                continue
            if judged.total.max() <= self.attainable:
                return contact, judged, levels, step.degree
            step = step.after(judged, self.attainable, levels.region)
            if step is not None and step.degree == tried.degree:
                levels = self.levels(reach, step)
        enough = 2 * float(judged.total.max())
        remedy = f"set hybrid.tolerance to {enough:.0e}, or " if enough <= LOOSEST else ""
        raise Refusal(
            f"hybrid: the estimated relative error is {judged.total.max():.1e} with elements of degree {tried.degree}, "
            f"above the tolerance {self.tolerance:.1e}; {remedy}ask for a smaller contact radius or use method "
            f"{self._instead}"
        )

    def _judge(self, contact: KernelContact, levels: Levels, degree: int) -> Judged:
        """What levels less, one polynomial less and the cut change at some radii."""
        a0, end = self.indenter.a0, levels.region.unit
        radii = a0 + (end - a0) * np.arange(1, SAMPLES + 1) / SAMPLES
        precise = QUADRATURE * self.tolerance
        best = contact.columns(radii, precise)

        def change(kernel: PolynomialKernel) -> Array:
            try:
                return np.abs(replace(contact, kernel=kernel).columns(radii, precise) / best - 1)
            except SolveError:
                return np.full_like(best, np.inf)

        last, before = (change(levels.coarser(degree, steps)) for steps in (1, 2))
        fastest = CORNERED if levels.region.corners else FASTEST
        known = np.isfinite(before).all()
        fall = float(np.clip(before.max() / last.max() - 1, SLOWEST, fastest)) if known else SLOWEST
        left = UNSEEN / (convergence(levels.region) - 1)
        if not levels.region.cut_beside:
            cut = np.zeros_like(best)
        elif levels.region.algebraic:
            cut = min(EXTRAPOLATED, levels.region.next_order) * change(levels.plain(degree))
        else:
            cut = DECAYED * change(levels.nearer(degree))
        parameters = max(left, LEAST) * change(contact.kernel.shorter())
        least = NO_CLAIM * self.tolerance + (GRADED if levels.wide is not None else 0.0)
        elements = SAFETY / fall * last + least
        steeper = np.minimum(STEEPER * elements[:-1].max(axis=0), ALLOWED * self.attainable)
        elements[-1] = np.maximum(elements[-1], steeper)
        return Judged(radii, elements, parameters, cut)


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
        if region.supports.base_r:
            oedometric = surface.E_star * (1 - nu) ** 2 / (1 - 2 * nu) if nu < 0.5 else math.inf
            compliance += h / (math.pi * oedometric) + 2 * h**3 / (3 * math.pi * surface.G)
        else:
            compliance += h / (math.pi * surface.E_star)
    if region.far is not None:
        compliance += 1 / (2 * region.far.E_star)
    return max(1 / (2 * region.reference.E_star * compliance), 1.0)

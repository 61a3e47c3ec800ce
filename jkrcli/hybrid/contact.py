"""One indenter on one body: the kernel that an accuracy needs, and what it leaves."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..errors import Refusal, SolveError
from ..indenters import Indenter
from ..integral.contact import COLUMNS, LayeredContact, Plan, cheapest
from ..integral.layered import GRADED
from ..integral.solver import AbelImage, Nested, Panels, solve
from ..materials import Graded, contact_modulus
from ..problem import Specimen
from .kernel import STEP, Levels, PolynomialKernel, convergence, count_for
from .region import Region, nearest

Array = np.ndarray

LOWEST, HIGHEST = 4, 16  # degrees
EDGE = 0.98  # largest contact radius over the radius of the body
QUADRATURE = 1e-3  # of the tolerance: error of the quadrature of the contact equation
PARAMETERS = 1e-2  # of the tolerance, planned for the number of parameters t; conditioning takes the rest
MORE = 3  # parameters, if they are too few
CUT = 0.1  # of the tolerance, for cutting an unbounded body
SAMPLES = 6  # radii at which errors are judged
SAFETY = 2.5  # on the error that the last step of the degree leaves
SLOWEST, FASTEST = 3.0, 15.0  # what a step divides it by
CORNERED = 8.0  # at most, with singular corners
UNSEEN, LEAST = 3.0, 0.5  # of the last polynomial's change times 1/(convergence - 1): the error left; at least
EXTRAPOLATED = 0.5  # at most, of what extrapolating the cut changes: the error left
DECAYED = 0.05  # of what the second cut changes where the field decays exponentially: more than the first one does
FINEST = 1e-7  # relative accuracy of K where the modulus changes from the contact on
MAX_UNKNOWNS = 100_000


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

    def plan(self, radii: Array, tolerance: float) -> Plan:
        """A quadrature accurate to ``tolerance`` at the increasing ``radii`` [m]."""
        return cheapest(radii, self.indenter.a0, self.scale, tolerance)

    def nested(self, radii: Array, plan: Plan) -> Nested:
        """Solve at the increasing ``radii`` [m]."""
        breaks = (self.indenter.a0,) if self.indenter.a0 > 0 else ()
        panels = Panels.through(radii, plan.order, plan.widest, breaks)
        return solve(self.kernel, panels, AbelImage.of(self.indenter), self.E_star)

    def columns(self, radii: Array, tolerance: float) -> Array:
        """delta, P, S, S' at ``radii`` [m] as rows."""
        nested = self.nested(radii, self.plan(radii, tolerance))
        return np.array([getattr(nested, name) for name in COLUMNS])


@dataclass(frozen=True, eq=False)
class SideContact(KernelContact):
    """The same where ``kernel`` is only what the side adds to the K of the ``wide`` body, which is known exactly."""

    wide: LayeredContact

    @property
    def scale(self) -> float:
        return min(self.kernel.scale, self.wide.scale)

    def plan(self, radii: Array, tolerance: float) -> Plan:
        plan = self.wide.plan(radii, max(tolerance, FINEST))
        return replace(plan, widest=plan.widest * min(self.kernel.scale / self.wide.scale, 1.0))

    def nested(self, radii: Array, plan: Plan) -> Nested:
        return self.wide.nested(radii, plan, added=self.kernel)


@dataclass(frozen=True, eq=False)
class Judged:
    """Estimated relative errors (columns, radii) at ``radii`` [m]: of elements, of the parameters t, of the cut."""

    radii: Array
    elements: Array
    parameters: Array
    cut: Array

    @property
    def total(self) -> Array:
        return self.elements + self.parameters + self.cut

    def at(self, radii: Array) -> Array:
        """The total (columns, radii) at any radii: never less than at a smaller one."""
        rising = np.maximum.accumulate(self.total, axis=1)
        return np.array([np.interp(radii, self.radii, row) for row in rising])


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

    def levels(self, reach: float, more: int = 0) -> Levels:
        """For contact radii up to ``reach`` [m], with ``more`` parameters t than planned."""
        region = Region.of(self.specimen, reach, CUT * self.tolerance)
        count = count_for(region, PARAMETERS * self.tolerance) + more
        wide = Region.of(self._wide, reach, CUT * self.tolerance) if region.changing else None
        return Levels(region, count, self.E_star / self.specimen.surface.E_star, wide)

    def guard(self, levels: Levels, degree: int) -> None:
        """Refuse what would take minutes."""
        unknowns = levels.unknowns(degree)
        if unknowns > MAX_UNKNOWNS:
            raise Refusal(
                f"hybrid: contact radii up to {levels.region.unit:g} m need about {unknowns} unknowns (limit "
                f"{MAX_UNKNOWNS}): the contact is large against the nearest interface or side "
                f"({nearest(levels.region) * levels.region.unit:.3g} m away); ask for a smaller contact or a larger "
                "hybrid.tolerance, or use method fem"
            )

    def rough(self, reach: float) -> KernelContact:
        """For finding radii: the first level from the second on that gives a positive definite equation."""
        levels = self.levels(reach)
        for degree in range(LOWEST + STEP, HIGHEST, STEP):
            contact = self._contact(levels, degree)
            try:
                contact.columns(np.array([reach]), 1e-3)
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
        more, degree = 0, LOWEST + STEP
        levels = self.levels(reach)
        while True:
            contact = self._contact(levels, degree)
            try:
                judged = self._judge(contact, levels, degree)
            except SolveError:  # not positive definite: too coarse for a great contrast of moduli
                if degree == HIGHEST:
                    raise
                degree += STEP
                continue
            if judged.total.max() <= self.attainable:
                return contact, judged, levels, degree
            if judged.parameters.max() > self.tolerance / 4 and more < 4 * MORE:
                more += MORE
                levels = self.levels(reach, more)
            elif degree < HIGHEST:
                degree += STEP
            else:
                break
        raise Refusal(
            f"hybrid: the estimated relative error is {judged.total.max():.1e} with elements of degree {degree}, above "
            f"the tolerance {self.tolerance:.1e}; set hybrid.tolerance to {2 * judged.total.max():.0e}, or ask for a "
            "smaller contact radius"
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
        elements = SAFETY / fall * last + (GRADED if levels.wide is not None else 0.0)
        return Judged(radii, elements, parameters, cut)

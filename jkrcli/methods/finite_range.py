"""A problem's bodies with their kernel as far as adhesion of finite range reaches.

Wide bodies have the exact kernel of ``layered``, cylinders that of ``hybrid``. It is computed anew for each reach that
the kernel of the series does not cover: how far the attraction reaches is known only with its range.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.errors import Refusal
from ..base.numerics import MOST_STEPS, NOTICEABLE, ROUNDED, UNSEEN, Array
from ..base.units import show
from ..bodies.problem import Problem, alone, without_side_walls
from ..series import KeptKernel
from .integral.finite_range import Attraction
from .layered.contact import GRADED, LayeredContact
from .layered.spectrum import spectrum_seconds
from .protocol import HybridOptions

if TYPE_CHECKING:
    from .hybrid.kernel import AdaptiveKernel, ErrorEstimates, KernelContact  # finite elements: of cylinders alone

# Accuracy of the kernel and how far it is needed.
# of K by its polynomials; tuned on ranges, by `make constants`: far below what is stated, at no cost
ATTRACTED_TOLERANCE = 1e-10
ATTRACTED_CHECKED = 0.01  # of that, of the second panels with which results are compared; choice: two digits more
ATTRACTED_OTHER_ORDER = 20  # Gauss nodes in k on the second panels; choice: shares nothing with the first's 24

# of a reach over the one expected; tuned on ranges, by `make constants`: what is looked at beyond c
ATTRACTED_ROOM = 1.15
# of the next reach over one that was too short; tuned on ranges, by `make constants`: each is a small solve
ATTRACTED_FURTHER = 1.5
# CPU seconds of a curve, for forecasts, beside those of resolving the stack:
ATTRACTED_CURVE = 0.06  # tuned on half-spaces, by `make bench`
ATTRACTED_POLYNOMIALS = 2.8e-6  # by the square of their number; tuned on 30 to 700 of them, by `make bench`
ATTRACTED_STACK = 0.25  # of what a solve needs for the spectrum; tuned on 1 to 1000 layers, by `make bench`


TOLERANCES = (HybridOptions.tolerance, UNSEEN, NOTICEABLE)  # of cylinders, the first that is met; its error is stated


@dataclass(frozen=True, eq=False)
class AttractedBody:
    """The bodies of a ``problem`` for adhesion of finite range, as far as it reaches; ``tolerance``: of K by its
    polynomials; ``kept``: the kernel of these bodies that their series was found with, where it has one."""

    problem: Problem
    tolerance: float = ATTRACTED_TOLERANCE
    kept: KeptKernel | None = None

    @cached_property
    def _wide(self) -> LayeredContact:
        problem = without_side_walls(self.problem)
        return LayeredContact(problem.indenter, problem.specimen)

    @cached_property
    def _half_space(self) -> LayeredContact:
        half_spaces = alone(self.problem)
        return LayeredContact(half_spaces.indenter, half_spaces.specimen)

    @cached_property
    def _cylinder(self) -> AdaptiveKernel | None:
        if self.problem.specimen.radius is None:
            return None
        from .hybrid.kernel import AdaptiveKernel

        return AdaptiveKernel(self.problem.indenter, self.problem.specimen, TOLERANCES[0])

    @property
    def limit(self) -> float:
        """The radius [m] to which attraction may reach: the end of the profile, or near the side of a cylinder."""
        end = self.problem.indenter.r_max * (1 - ROUNDED)
        return end if self._cylinder is None else min(end, self._cylinder.limit)

    @property
    def scale(self) -> float:
        """The length over which the kernel varies [m]."""
        return self._wide.scale

    @cached_property
    def _made(self) -> dict[str, tuple[float, Any]]:
        return {}

    def _latest(self, name: str, reach: float, make: Callable[[], Any]) -> Any:
        """What ``make`` gave for this ``reach`` if it was the last one."""
        if name not in self._made or self._made[name][0] != reach:
            self._made[name] = reach, make()
        return self._made[name][1]

    def attraction(self, reach: float) -> Attraction:
        """The bodies ready for any tension up to ``reach`` [m]."""
        return self._kernel(reach)[0]

    def check(self, reach: float) -> Attraction:
        """The attraction up to the radius ``reach`` [m] on other panels than those of ``attraction``, for an estimate
        of the error that they leave."""
        cylinder, finer = self._kernel(reach)[1], self.tolerance * ATTRACTED_CHECKED
        body = replace(self._wide, order=ATTRACTED_OTHER_ORDER) if cylinder is None else cylinder
        return self._latest("check", reach, lambda: body.attraction(reach, finer))

    def kernel_error(self, reach: float, radii: Array) -> Array:
        """Relative error that the kernel itself leaves in delta and P up to ``radii`` [m]: that of nonadhesive contact,
        and of the density at its edge, whose square is S'."""
        estimates = self._kernel(reach)[2]
        if estimates is None:
            return np.full(radii.size, GRADED if self.problem.specimen.is_graded else 0.0)
        *columns, dS = estimates.at(np.asarray(radii))
        largest: Array = np.max([*columns, dS / 2], axis=0)
        return largest

    def _kernel(self, reach: float) -> tuple[Attraction, KernelContact | None, ErrorEstimates | None]:
        def made() -> tuple[Attraction, KernelContact | None, ErrorEstimates | None]:
            if self._cylinder is None:
                return self._wide.attraction(reach, self.tolerance), None, None
            contact, errors = _met(self._cylinder, reach, self.kept)
            return contact.attraction(reach, self.tolerance), contact, errors

        return self._latest("kernel", reach, made)

    def seconds(self, a: float, s: float, gap: float) -> float:
        """CPU seconds, about, of the states up to the contact radius ``a`` [m] (see ``reach``), from the polynomials
        that a wide body needs; Refusal where they are too many."""
        wide = self._wide
        expected = ATTRACTED_ROOM * self._edge(self._half_space.attraction, 2 * a + math.sqrt(gap * a), a, s, gap)
        count = wide.attraction_panels(min(expected, self.limit), ATTRACTED_TOLERANCE).x.size
        stack = ATTRACTED_STACK * spectrum_seconds(self.problem)
        sides = 0.0
        if self._cylinder is not None:
            sides, _ = self._cylinder.expected_cost(self._cylinder.levels(min(expected, self.limit)))
        return ATTRACTED_CURVE + ATTRACTED_POLYNOMIALS * count**2 + stack + sides

    def reach(self, a: float, s: float, gap: float) -> float:
        """A radius [m] beyond that to which the tension s = 2 sigma/E* acts around a contact of the radius ``a`` [m],
        where the separation is ``gap`` [m]. Refusal where it lies beyond a side or the profile."""
        expected = self._edge(self._half_space.attraction, 2 * a + math.sqrt(gap * a), a, s, gap)
        expected = self._edge(self._wide.attraction, ATTRACTED_ROOM * expected, a, s, gap)
        reach = min(ATTRACTED_ROOM * expected, self.limit)
        if self._cylinder is None:
            return reach
        edge = self._edge(lambda reach, _: self.attraction(reach), reach, a, s, gap)
        return max(reach, min(ATTRACTED_ROOM * edge, self.limit)) if edge > reach else reach

    def _edge(self, ready: Callable[[float, float], Attraction], start: float, a: float, s: float, gap: float) -> float:
        """The radius c [m] for the contact radius ``a``, by the body that ``ready`` gives for a reach and a tolerance,
        sought beyond ``start`` [m] where need be."""
        reach, radii = start, np.array([a])
        for _ in range(MOST_STEPS):
            reach = min(max(reach, a * (1 + 1e-6)), self.limit)
            discs = ready(reach, ATTRACTED_TOLERANCE).discs(radii)
            if discs.rims(reach - radii, s).gap[0] >= gap:
                return float(discs.equilibria(s, gap, reach).c[0])
            if reach == self.limit:
                raise Refusal(self._too_far(a))
            reach *= ATTRACTED_FURTHER
        raise Refusal(self._too_far(a))

    def _too_far(self, a: float) -> str:
        at_end = self.limit == self.problem.indenter.r_max * (1 - ROUNDED)
        end = "the end of the profile" if at_end else "the side of the cylinder"
        return (
            f"adhesion of finite range: around a contact of a = {show(a, 'length')} the surfaces attract each other "
            f"beyond {end} (at {show(self.limit, 'length')} the separation is still within the range): load less, or "
            "give a larger stress (a shorter range)"
        )


def _met(
    cylinder: AdaptiveKernel, reach: float, kept: KeptKernel | None = None
) -> tuple[KernelContact, ErrorEstimates]:
    """The contact up to ``reach`` [m] at the first tolerance that is met, and its errors; with the kernel that was
    ``kept`` where that reaches and meets it."""
    if kept is not None and reach <= kept.reach and kept.errors.sum(axis=0).max() <= TOLERANCES[0]:
        return cylinder.from_kept(kept)
    for tolerance in TOLERANCES:
        with contextlib.suppress(Refusal):
            return replace(cylinder, tolerance=tolerance).accurate(reach)[:2]
    raise Refusal(
        f"adhesion of finite range: the kernel of the cylinder is not known to {TOLERANCES[-1]:g} up to "
        f"{show(reach, 'length')}, about as far as the surfaces attract each other: load less, or give a larger stress "
        "(a shorter range)"
    )

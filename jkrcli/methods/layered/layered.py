"""The exact method for laterally unbounded layered specimens (named ``layered``), and contact radii for any loading."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from ...base import Array, Refusal, StageClock
from ...bodies import Loading, Problem, Specimen, stacks, unbounded
from ...series import ErrorBudget, Solution
from .. import integral
from ..protocol import Forecast
from .options import LayeredOptions
from .spectrum import spectrum_seconds
from .stack import GRADED, TUNING, LayeredContact, checked
from .stuck import StuckLayeredContact, unable
from .tense import TUNING as TENSE
from .tense import TenseContact

SEARCH = 1e-10  # relative accuracy to which a prescribed depth or load is met; choice: finer than any tolerance in use
QUICK = 20.0  # choice: sqrt(a^2 - a0^2) over the kernel's scale up to which a solve takes a fraction of a second
SEARCHES = 4  # solves in which all radii of prescribed depths or loads are found; choice: for forecasts
SolvedContact = LayeredContact | StuckLayeredContact | TenseContact


@dataclass(frozen=True)
class Layered(LayeredOptions):
    """Fredholm equation of the contact problem, all radii from one Cholesky factor; no mesh, S and S' exact.

    Valid for any stack of bonded layers, isotropic (-1 < nu <= 1/2), graded over depth or transversely isotropic,
    on a rigid base, bonded or frictionless, or on an elastic half-space, wider than the contact by so much that its
    sides do not matter, with surface tension or without; any convex indenter, rigid, elastic or coated.
    ``tolerance``: relative error of delta, P, S and S' at every radius, estimated by a second quadrature; no
    smaller than ``GRADED`` where any layer is graded, or ``TenseTuning.tolerance`` under surface tension.
    """

    def refusal(self, problem: Problem) -> str | None:
        """Why the problem is none of a laterally unbounded stack, with the remedy; None where it is one."""
        radius = problem.specimen.radius
        if radius is not None:
            other = "fem" if problem.sticks or problem.specimen.surface_tension else "hybrid"
            return (
                f"the specimen has a finite radius of {radius:g} m, this method knows only laterally "
                f"unbounded ones; use the method {other}, or leave the radius out"
            )
        return unable(problem.indenter, problem.specimen) if problem.sticks else None

    def attainable(self, specimen: Specimen) -> float:
        """The tolerance that holds for ``specimen``."""
        least = max(GRADED if specimen.is_graded else 0.0, TENSE.tolerance if specimen.surface_tension else 0.0)
        return max(self.tolerance, least)

    def forecast(self, problem: Problem) -> Forecast:
        """Seconds and memory of the solve, from its node counts; finding the largest radius is part of the forecast.

        Refusal of what takes more nodes than the solve accepts.
        """
        contact = _contact(problem)
        radii = np.linspace(problem.indenter.a0, largest_radius(problem), max(problem.loading.points, 1) + 1)[1:]
        plan: Any = contact.plan(radii, self.attainable(problem.specimen) / TUNING.margin)
        contact.guard(radii, plan)
        seconds = spectrum_seconds(problem) + self._operations(contact, problem, radii) / integral.FLOPS_PER_SECOND
        memory = 8 * 6 * (plan.nodes + radii.size / getattr(plan, "groups", 1)) ** 2 / 2**20
        return Forecast(seconds, 5 + memory, self.attainable(problem.specimen), f"{plan.nodes} nodes, no mesh")

    def _operations(self, contact: Any, problem: Problem, radii: Array) -> float:
        """Floating-point operations: of the solve, of its check at some of the ``radii``, and of finding them all where
        depths or loads are prescribed."""
        tolerance, loading = self.attainable(problem.specimen), problem.loading
        plan: Any = contact.plan(radii, tolerance / TUNING.margin)
        main = float(contact.flops(radii, plan))
        some = radii[checked(radii, getattr(plan, "groups", 1), problem.specimen.is_graded)]
        check = contact.flops(some, contact.plan(some, tolerance / TUNING.margin**3).finer())
        each_is_looked_for = loading.spacing == "depth" or (loading.to != "radius" and loading.values)
        return main * (SEARCHES if each_is_looked_for else 1) + float(check)

    def __call__(self, problem: Problem) -> Solution:
        """Solve; errors: Refusal outside the validity, SolveError where the tolerance is not reached."""
        reason = self.refusal(problem)
        if reason is not None:
            raise Refusal(reason)
        clock = StageClock()
        contact = _contact(problem)
        with clock("spectrum"):
            _ = contact.spectrum.panels  # now rather than at the first solve
        tolerance = self.attainable(problem.specimen)
        with clock("radii"):
            radii = integral.search(contact, problem.loading, max(SEARCH, 0.01 * tolerance)).radii
        with clock("solve"):
            result, errors = contact.refined(radii, tolerance)
            S0 = integral.first_stiffness(contact, 1e-12)
        with clock("full disc"):
            integral.refuse_shrinking(radii, result.delta)
            warnings = _disc_warnings(contact, problem.specimen, float(radii[-1]))
        series = integral.series_of(result, errors, problem.indenter.a0, S0)
        budget = ErrorBudget(discretisation=float(errors.max()), truncation=0.0, radius=0.0)
        told: dict[str, Any] = {"facts": _facts(contact, result), "timings": clock.seconds, "warnings": warnings}
        return Solution(problem, series, budget, "layered", **told).widened()


def largest_radius(problem: Problem) -> float:
    """The largest contact radius [m] that the loading reaches, for forecasts; ``specimen.radius`` is not looked at.

    For a finite body this is the forecast that a mesh needs: its sides change it little unless the contact is near.
    Contacts so wide that the search would take long are extrapolated by the power with which they grow.
    """
    return _largest(unbounded(problem))


@lru_cache(maxsize=8)  # several methods forecast by it, and solve
def _largest(problem: Problem) -> float:
    return expected_radius(_contact(problem), problem.loading, SEARCH)


def expected_radius(contact: SolvedContact, loading: Loading, accuracy: float) -> float:
    """The contact radius [m] at which ``loading`` ends, extrapolated where it is many times the layers' length."""
    limit = math.hypot(contact.indenter.a0, QUICK * contact.scale)
    return integral.search(replace(contact, limit=limit), loading, accuracy).largest


def _contact(problem: Problem) -> SolvedContact:
    kind: Any = StuckLayeredContact if problem.sticks else LayeredContact
    kind = TenseContact if problem.specimen.surface_tension else kind
    return kind(problem.indenter, problem.specimen)


def _disc_warnings(contact: SolvedContact, specimen: Specimen, largest: float) -> tuple[str, ...]:
    """What is wrong with the contact as a disc; one that sticks has been refused where it does not grow."""
    if isinstance(contact, StuckLayeredContact):
        return ()
    return integral.disc_warnings(contact, specimen, largest, contact.spectrum.kernel)


def _facts(contact: SolvedContact, result: integral.ContactResult) -> dict[str, float | int]:
    panels = result.panels
    facts: dict[str, float | int] = {"nodes": panels.x.size, "panels": panels.edges.size - 1, "order": panels.order}
    if contact.specimen.layers:
        facts["a_over_h"] = float(panels.radii[-1]) / contact.specimen.top_thickness
    if stacks(contact.specimen, contact.indenter.material):
        facts["a_over_scale"] = float(panels.radii[-1]) / contact.spectrum.scale
    return facts

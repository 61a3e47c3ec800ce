"""The exact method for laterally unbounded layered specimens (named ``layered``), and contact radii for any loading."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...base.clock import StageClock
from ...base.errors import Refusal
from ...bodies.problem import Problem, Specimen
from ...series import ErrorBudget, Series, Solution
from .. import Forecast
from .contact import COLUMNS, MARGIN, LayeredContact
from .options import LayeredOptions
from .search import largest_for_contact, radii_for_contact
from .solver import Nested

Array = np.ndarray

SEARCH = 1e-10  # relative accuracy to which a prescribed depth or load is met
FLOPS_PER_SECOND = 5e9
GRADED = 1e-5  # the least tolerance under a modulus that varies over depth
GRADED_SECONDS = 0.3  # to resolve the spectrum then


@dataclass(frozen=True)
class Layered(LayeredOptions):
    """Fredholm equation of the contact problem, all radii from one Cholesky factor; no mesh, S and S' exact.

    Valid for any stack of bonded layers, isotropic (-1 < nu <= 1/2), graded over depth or transversely isotropic, on a
    rigid base, bonded or frictionless, or on an elastic half-space, wider than the contact by so much that its sides do
    not matter; any convex indenter, rigid or elastic. ``tolerance``: relative error of delta, P, S and S' at every
    radius, estimated by a second quadrature; no smaller than ``GRADED`` where any layer is graded.
    """

    def refusal(self, problem: Problem) -> str | None:
        """Why the problem is none of a laterally unbounded stack, with the remedy; None where it is one."""
        radius = problem.specimen.radius
        if radius is not None:
            return (
                f"the specimen has a finite radius of {radius:g} m, this method knows only laterally "
                "unbounded ones; use the method hybrid, or leave the radius out"
            )
        return None

    def attainable(self, specimen: Specimen) -> float:
        """The tolerance that holds for ``specimen``."""
        return max(self.tolerance, GRADED) if specimen.is_graded else self.tolerance

    def forecast(self, problem: Problem) -> Forecast:
        """Seconds and memory of the solve, from its node counts; finding the largest radius is part of the forecast."""
        contact = _contact(problem)
        radii = np.linspace(problem.indenter.a0, largest_radius(problem), max(problem.loading.points, 1) + 1)[1:]
        tolerance = self.attainable(problem.specimen)
        plan = contact.plan(radii, tolerance / MARGIN)
        rounds = 5 if problem.loading.to != "radius" or problem.loading.spacing == "depth" else 2
        start = GRADED_SECONDS if problem.specimen.is_graded else 0.02
        seconds = start + rounds * contact.flops(radii, plan) / FLOPS_PER_SECOND
        memory = 8 * 6 * (plan.nodes + radii.size) ** 2 / 2**20
        return Forecast(seconds, 5 + memory, tolerance, f"{plan.nodes} nodes, no mesh")

    def __call__(self, problem: Problem) -> Solution:
        """Solve; errors: Refusal outside the validity, SolveError where the tolerance is not reached."""
        reason = self.refusal(problem)
        if reason is not None:
            raise Refusal(reason)
        from .disc import disc_warnings, refuse_shrinking  # fields rest on this very method

        clock = StageClock()
        contact = _contact(problem)
        with clock("spectrum"):
            contact.prepare()
        tolerance = self.attainable(problem.specimen)
        with clock("radii"):
            radii = radii_for_contact(contact, problem.loading, max(SEARCH, 0.01 * tolerance))
        with clock("solve"):
            nested, errors = contact.refined(radii, tolerance)
        with clock("full disc"):
            refuse_shrinking(radii, nested.delta)
            warnings = disc_warnings(contact, problem.specimen, float(radii[-1]), contact.spectrum.kernel)
        return Solution(
            _series(contact, nested, errors),
            ErrorBudget(discretisation=float(errors.max()), truncation=0.0, radius=0.0),
            "layered",
            facts=_facts(contact, nested),
            timings=clock.seconds,
            warnings=warnings,
        )


def largest_radius(problem: Problem) -> float:
    """The largest contact radius [m] that the loading reaches; ``specimen.radius`` is not looked at.

    For a finite body this is the forecast that a mesh needs: its sides change it little unless the contact is near.
    """
    return largest_for_contact(_contact(unbounded(problem)), problem.loading, SEARCH)


def unbounded(problem: Problem) -> Problem:
    """The same problem without the sides of the specimen."""
    return replace(problem, specimen=Specimen(problem.specimen.layers, problem.specimen.base))


def _contact(problem: Problem) -> LayeredContact:
    return LayeredContact(problem.indenter, problem.specimen)


def _series(contact: LayeredContact, nested: Nested, errors: Array) -> Series:
    columns = {name: getattr(nested, name) for name in COLUMNS}
    return Series(
        a=nested.panels.radii,
        **columns,
        errors={name: errors * columns[name] for name in COLUMNS} | {"a": 0 * nested.panels.radii},
        a0=contact.indenter.a0,
        S0=contact.first_stiffness(),
    )


def _facts(contact: LayeredContact, nested: Nested) -> dict[str, float | int]:
    panels = nested.panels
    facts: dict[str, float | int] = {"nodes": panels.x.size, "panels": panels.edges.size - 1, "order": panels.order}
    if contact.specimen.layers:
        facts["a_over_h"] = float(panels.radii[-1]) / contact.specimen.top_thickness
        facts["a_over_scale"] = float(panels.radii[-1]) / contact.spectrum.scale
    return facts

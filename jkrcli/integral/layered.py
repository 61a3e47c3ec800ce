"""The exact method for laterally unbounded layered specimens (named ``layered``), and contact radii for any loading."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..clock import StageClock
from ..errors import InputError, Refusal
from ..methods import Forecast
from ..problem import Loading, Problem, Specimen
from ..radii import Response, Responses, half_space_guess, largest_of_loading, radii_of_loading
from ..series import ErrorBudget, Series, Solution
from .contact import COLUMNS, MARGIN, LayeredContact, Plan
from .solver import Nested

Array = np.ndarray

ROUGH = 1e-5  # accuracy of the first part of every search
SEARCH = 1e-10  # relative accuracy to which a prescribed depth or load is met
FLOPS_PER_SECOND = 5e9


@dataclass(frozen=True)
class Layered:
    """Fredholm equation of the contact problem, all radii from one Cholesky factor; no mesh, S and S' exact.

    Valid for any stack of bonded isotropic layers (-1 < nu <= 1/2) on a rigid base, bonded or frictionless, or on an
    elastic half-space, wider than the contact by so much that its sides do not matter; any convex indenter, rigid or
    elastic. ``tolerance``: relative error of delta, P, S and S' at every radius, estimated by a second quadrature.
    """

    tolerance: float = 1e-8

    def __post_init__(self) -> None:
        if not 1e-12 <= self.tolerance <= 1e-2:
            raise InputError(f"layered.tolerance: must be between 1e-12 and 1e-2, got {self.tolerance:g}")

    def refusal(self, problem: Problem) -> str | None:
        """Why the problem is none of a laterally unbounded stack, with the remedy; None where it is one."""
        radius = problem.specimen.radius
        if radius is not None:
            return (
                f"the specimen has a finite radius of {radius:g} m, this method knows only laterally "
                "unbounded ones; use the method fem, or leave the radius out"
            )
        return None

    def forecast(self, problem: Problem) -> Forecast:
        """Seconds and memory of the solve, from its node counts; finding the largest radius is part of the forecast."""
        contact = _contact(problem)
        radii = np.linspace(problem.indenter.a0, largest_radius(problem), max(problem.loading.points, 1) + 1)[1:]
        plan = contact.plan(radii, self.tolerance / MARGIN)
        rounds = 5 if problem.loading.to != "radius" or problem.loading.spacing == "depth" else 2
        seconds = 0.02 + rounds * contact.flops(radii, plan) / FLOPS_PER_SECOND
        memory = 8 * 6 * (plan.nodes + radii.size) ** 2 / 2**20
        return Forecast(seconds, 5 + memory, self.tolerance, f"{plan.nodes} nodes, no mesh")

    def __call__(self, problem: Problem) -> Solution:
        """Solve; errors: Refusal outside the validity, SolveError where the tolerance is not reached."""
        reason = self.refusal(problem)
        if reason is not None:
            raise Refusal(reason)
        clock = StageClock()
        contact = _contact(problem)
        with clock("spectrum"):
            contact.prepare()
        with clock("radii"):
            radii = _radii(contact, problem.loading, max(SEARCH, 0.01 * self.tolerance))
        with clock("solve"):
            nested, errors = contact.refined(radii, self.tolerance)
        return Solution(
            _series(contact, nested, errors),
            ErrorBudget(discretisation=float(errors.max()), truncation=0.0, radius=0.0),
            "layered",
            facts=_facts(contact, nested),
            timings=clock.seconds,
        )


def largest_radius(problem: Problem) -> float:
    """The largest contact radius [m] that the loading reaches; ``specimen.radius`` is not looked at.

    For a finite body this is the forecast that a mesh needs: its sides change it little unless the contact is near.
    """
    return _largest(_contact(unbounded(problem)), problem.loading, SEARCH)


def unbounded(problem: Problem) -> Problem:
    """The same problem without the sides of the specimen."""
    return replace(problem, specimen=Specimen(problem.specimen.layers, problem.specimen.base))


def _contact(problem: Problem) -> LayeredContact:
    return LayeredContact(problem.indenter, problem.specimen)


def _radii(contact: LayeredContact, loading: Loading, tolerance: float) -> Array:
    return radii_of_loading(
        loading, contact.indenter, _responses(contact), _guess(contact, loading), (ROUGH, tolerance)
    )


def _largest(contact: LayeredContact, loading: Loading, tolerance: float) -> float:
    start = _guess(contact, loading)
    return largest_of_loading(loading, contact.indenter, _responses(contact), start, (ROUGH, tolerance))


def _guess(contact: LayeredContact, loading: Loading) -> float:
    return half_space_guess(loading, contact.indenter, contact.E_star, contact.spectrum.scale)


def _responses(contact: LayeredContact) -> Responses:
    return lambda quantity, accuracy: _response(contact, quantity, accuracy)


def _response(contact: LayeredContact, to: str, accuracy: float) -> Response:
    """delta_H or P_H at given radii, with a quadrature planned for ``accuracy``."""
    name = {"depth": "delta", "load": "P"}[to]

    def response(radii: Array) -> Array:
        plan: Plan = contact.plan(radii, accuracy / 4)
        return getattr(contact.nested(radii, plan), name)

    return response


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

"""The method ``fem``: axisymmetric finite elements with contact on the condensed surface, sliding or sticking."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from ...base import Refusal, StageClock, Unknown, one_thread
from ...bodies import HalfSpace, Problem
from ...series import ErrorBudget, Solution
from ..protocol import Forecast, without_coating
from .budget import Assessment, assessed, truncation_of
from .cost import forecast
from .edge import finest_spacing
from .grid import Grid
from .layout import Layout, layout_for
from .model import Run, expected_reach, run
from .options import DOUBLED, FEMOptions
from .refinement import adapted, first
from .report import finished


@dataclass(frozen=True)
class FEM(FEMOptions):
    """Finite elements for any stack of layers on a rigid base or a half-space, wide or of finite radius.

    Layers are isotropic, graded over depth or transversely isotropic. Geometrically linear; any convex
    indenter, rigid (or elastic on a homogeneous half-space that slides). Surfaces that stick by "nested" only.

    The default solves a paraboloid on a half-space to about 1e-4 in P(delta). Contact radii are those of vertices,
    corrected to the edge of the contact (``edge_correction``): exact for a paraboloid on a half-space, else about 1e-3
    off. Increments have the radius at which their outermost vertex was touched, so corrected; without the correction
    all keep the vertex's radius, up to half a spacing too large.
    """

    def refusal(self, problem: Problem) -> str | None:
        if reason := self._unable(problem):
            return reason
        try:
            self._first_layout(problem)
        except Refusal as refusal:
            return "; ".join(refusal.lines)
        return None

    def _unable(self, problem: Problem) -> str | None:
        """Why no mesh can represent the problem."""
        specimen = problem.specimen
        if reason := without_coating(problem):
            return reason
        if problem.sticks and (reason := self._unable_to_stick(problem)):
            return reason
        if self.tolerance is not None and (self.spacing, self.growth) != (FEMOptions.spacing, FEMOptions.growth):
            return (
                "mesh.spacing and mesh.growth follow from mesh.tolerance: leave them out, or leave out the tolerance "
                "(--tolerance)"
            )
        if problem.indenter.material is not None and not specimen.is_half_space:
            other = "layered" if specimen.radius is None else "hybrid"
            return (
                "an elastic indenter on a layered or finite body is not represented by a rigid profile: "
                f"use method {other}, or a rigid indenter"
            )
        if specimen.radius is not None and isinstance(specimen.base, HalfSpace):
            return "a body of finite radius needs a rigid base: give the depth as a layer's thickness"
        if any(material.surface.nu == 0.5 for material in specimen.materials):
            if self.order == 1:
                return "nu = 0.5 needs second-order elements: set mesh.order = 2"
            if self.formulation == "displacement":
                return 'nu = 0.5 needs a pressure unknown: set mesh.formulation = "mixed", or leave it out'
        a0 = problem.indenter.a0
        if self.contact_radius is not None and self.contact_radius <= a0:
            return (
                f"mesh.contact_radius: {self.contact_radius:g} m must be larger than the flat end of the indenter "
                f"({a0:g} m): give more or leave it out"
            )
        return None

    def _unable_to_stick(self, problem: Problem) -> str | None:
        if problem.indenter.material is not None:
            other = "layered" if problem.specimen.radius is None else "a rigid indenter"
            return f"an elastic indenter without slip is not represented by a rigid profile: use {other}"
        if self.contact == "incremental":
            return 'increments do not remember where points stuck: set contact.algorithm = "nested"'
        least = finest_spacing(problem.specimen.materials[0])
        if self.layout == "scaled" and self.tolerance is None and self.spacing < least:
            other = " or use method layered" if problem.specimen.radius is None else ""
            return (
                f"nodes {self.spacing:g} of the radius apart cannot follow how the edge of a contact that sticks "
                f"oscillates: give mesh.spacing = {math.ceil(100 * least) / 100:g} or more{other}"
            )
        return None

    def _refuse(self, problem: Problem) -> None:
        if reason := self._unable(problem):
            raise Refusal(reason)

    def reach(self, problem: Problem) -> float:
        """Radius out to which the mesh is fine and nodes are candidates [m]."""
        return expected_reach(self, problem)

    def _first_layout(self, problem: Problem) -> Layout:
        return layout_for(first(self, problem), problem, self.reach(problem))

    def mesh(self, problem: Problem) -> Grid:
        """The mesh that a solve would begin with."""
        self._refuse(problem)
        return self._first_layout(problem).grid()

    def forecast(self, problem: Problem) -> Forecast:
        """Cost and error from the expected number of elements, by measured ones; of the first mesh to a tolerance."""
        expected = forecast(self, problem, self._first_layout(problem))
        return expected if self.tolerance is None else replace(expected, error=self.tolerance)

    def __call__(self, problem: Problem) -> Solution:
        """Solve; errors: Refusal (contact leaves the candidates, body not representable, tolerance not reached),
        SolveError."""
        if self.tolerance is None:
            return self.solve(problem)[1]
        self._refuse(problem)
        with one_thread():
            return adapted(self, problem, StageClock())

    def solve(self, problem: Problem) -> tuple[Run, Solution]:
        """Solve on the mesh of the given sizes; the run holds mesh, factor and contact problem."""
        self._refuse(problem)
        clock = StageClock()
        with one_thread():
            solved = run(self, problem, clock)
            return solved, finished(self, solved, self._assessed(solved, clock), clock)

    def _assessed(self, solved: Run, clock: StageClock) -> Assessment:
        if not self.estimate_error:
            reason = Unknown("not estimated: estimate_error is off")
            return Assessment(ErrorBudget(reason, reason, reason))
        with clock("error estimate"):
            larger = [solved.companion(ratio) for ratio in (DOUBLED, DOUBLED**2)]
            return assessed(solved, larger, DOUBLED, truncation_of(solved, larger[0]))

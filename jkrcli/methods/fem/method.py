"""The method ``fem``: axisymmetric finite elements with frictionless contact on the condensed surface."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from ...base.clock import StageClock
from ...base.errors import JkrError, Refusal
from ...base.unknown import Unknown
from ...bodies.problem import HalfSpace, Problem
from ...series import ErrorBudget, Solution
from .. import Forecast
from .budget import Assessment
from .contact import Events, Increment, SurfaceContact, nested_events, solve_depths, solve_loads
from .domain import cut_out
from .ending import nested_columns
from .factor import one_thread
from .forecast import forecast
from .grid import Grid
from .increments import depths_of, needed_radius
from .layout import MAX_CELLS, Layout, scaled_layout, zones_layout
from .level import SPARE, Level
from .model import Model, Recipe
from .options import FEMOptions
from .run import Run, finished

NEARLY_INCOMPRESSIBLE = 0.49
ATTEMPTS = 5
DOUBLED = 2.0  # element sizes of the mesh for the error estimate
ROOM = 1.05  # for what a finite body or a coarse mesh changes


@dataclass(frozen=True)
class FEM(FEMOptions):
    """Finite elements for any stack of isotropic layers on a rigid base or a half-space, wide or of finite radius.

    Geometrically linear, frictionless; any convex indenter, rigid (or elastic on a homogeneous half-space).
    The default solves a paraboloid on a half-space to about 1e-4 in P(delta). Contact radii are those of vertices,
    corrected to the edge of the contact (``edge_correction``): exact for a paraboloid on a half-space, else about 1e-3
    off. Increments, and "nested" without the correction, keep the vertex's radius, up to half a spacing too large.
    """

    # ------------------------------------------------------------------ what it can do
    def refusal(self, problem: Problem) -> str | None:
        if reason := self._unable(problem):
            return reason
        try:
            begun = self if self.tolerance is None else self._first(problem)
            begun._layout(problem, begun.reach(problem))
        except Refusal as refusal:
            return "; ".join(refusal.lines)
        return None

    def _unable(self, problem: Problem) -> str | None:
        """Why no mesh can represent the problem."""
        specimen = problem.specimen
        if problem.indenter.material is not None and not specimen.is_half_space:
            other = "layered" if specimen.radius is None else "hybrid"
            return (
                "an elastic indenter on a layered or finite body is not represented by a rigid profile: "
                f"use method {other}, or a rigid indenter"
            )
        if specimen.radius is not None and isinstance(specimen.base, HalfSpace):
            return "a body of finite radius needs a rigid base: give the depth as a layer's thickness"
        if any(nu == 0.5 for nu in self._poisson(problem)):
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

    def _refuse_too_many(self, layout: Layout) -> Layout:
        """The layout, or a Refusal that names the key to change."""
        cells = layout.expected_cells()
        if cells <= MAX_CELLS:
            return layout
        if self.tolerance is not None:
            remedy = "ask for a larger mesh.tolerance, or use the method layered where it represents the body"
        else:
            size = "mesh.element_size" if self.layout == "zones" else "mesh.spacing or mesh.smallest"
            fewer = self.element == "quadrilateral" and replace(layout, element="triangle").expected_cells() < cells
            remedy = f"take a larger {size}, or {'triangles' if fewer else 'a larger mesh.growth'}"
        raise Refusal(
            f"mesh: about {cells:.1e} elements expected, too many {self.element}s (at most {MAX_CELLS}): {remedy}"
        )

    def forecast(self, problem: Problem) -> Forecast:
        """From the expected number of elements and the measured cost per unknown; of the first mesh to a tolerance."""
        if self.tolerance is not None:
            return replace(self._without_tolerance(problem).forecast(problem), error=self.tolerance)
        layout = self._layout(problem, self.reach(problem))
        return forecast(self, problem, layout, bool(self._mixed(problem)))

    # ------------------------------------------------------------------ meshes
    def mesh(self, problem: Problem) -> Grid:
        """The mesh that a solve would begin with."""
        self._refuse(problem)
        if self.tolerance is not None:
            return self._without_tolerance(problem).mesh(problem)
        return self._layout(problem, self.reach(problem)).grid()

    def _first(self, problem: Problem) -> FEM:
        """With the sizes that the tolerance begins with."""
        from .adapt import first

        return first(self, problem)

    def _without_tolerance(self, problem: Problem) -> FEM:
        return replace(self._first(problem), tolerance=None)

    def reach(self, problem: Problem) -> float:
        """Radius out to which the mesh is fine and nodes are candidates [m]."""
        from ..layered.layered import largest_radius

        largest = self.contact_radius if self.contact_radius is not None else largest_radius(problem)
        return self._bounded(problem, self.margin * largest)

    @staticmethod
    def _bounded(problem: Problem, reach: float) -> float:
        edge = problem.specimen.radius if problem.specimen.radius is not None else math.inf
        return min(reach, edge, problem.indenter.r_max * (1 - 1e-9))

    def _layout(self, problem: Problem, reach: float) -> Layout:
        body = cut_out(problem, reach, self.depth, self.width)
        a0 = problem.indenter.a0
        if self.layout == "scaled":
            smallest = self.smallest * (reach - a0)
            layout = scaled_layout(body, self.element, reach, a0, smallest, self.spacing, self.growth_of_sizes)
            return self._refuse_too_many(layout)
        R = problem.indenter.tip_radius or 6 * reach
        halves = 2 if self.order == 2 and self.element == "triangle" else 1
        sizes = tuple(halves * size for size in self.zone_sizes)
        layout = zones_layout(body, self.element, reach, a0, self.element_size, R, sizes, self.growth_of_sizes)
        return self._refuse_too_many(layout)

    def _poisson(self, problem: Problem) -> list[float]:
        return [material.surface.nu for material in problem.specimen.materials]

    def _mixed(self, problem: Problem) -> tuple[int, ...]:
        """Layers that get a pressure unknown."""
        if self.order == 1 or self.formulation == "displacement":
            return ()
        limit = NEARLY_INCOMPRESSIBLE if self.formulation == "auto" else 0.0
        return tuple(i for i, nu in enumerate(self._poisson(problem)) if nu > limit)

    def _refuse(self, problem: Problem) -> None:
        if reason := self._unable(problem):
            raise Refusal(reason)

    # ------------------------------------------------------------------ solve
    def __call__(self, problem: Problem) -> Solution:
        """Solve; errors: Refusal (contact leaves the candidates, body not representable, tolerance not reached),
        SolveError."""
        if self.tolerance is None:
            return self.solve(problem)[1]
        from .adapt import adapted

        self._refuse(problem)
        with one_thread():
            return adapted(self, problem, StageClock())

    def solve(self, problem: Problem) -> tuple[Run, Solution]:
        """Solve on the mesh of the given sizes; the run holds mesh, factor and contact problem."""
        self._refuse(problem)
        clock = StageClock()
        with one_thread():
            run = self.run(problem, clock)
            return run, finished(self, run, self._assessed(run, clock), clock)

    def run(self, problem: Problem, clock: StageClock, reach: float | None = None) -> Run:
        """Solve on one mesh; ``reach``: radius to mesh finely, where it is known [m]."""
        model, contact, touches = self._solve_large_enough(problem, clock, reach or self.reach(problem))
        by_increments = self.contact == "incremental" or not touches.valid
        level = Level(model, problem.indenter, contact, touches, self.edge_correction and not by_increments)
        if by_increments:
            with clock("contact"):
                return Run.of_increments(problem, level, self._increments(problem, contact, touches))
        with clock("edge correction"):
            events = level.events
        return Run(problem, level, nested_columns(problem.loading, events, problem.indenter.a0))

    def _solve_large_enough(
        self, problem: Problem, clock: StageClock, reach: float
    ) -> tuple[Model, SurfaceContact, Events]:
        """Solve on meshes for growing contact radii until the loading's end lies within the candidates."""
        loading = problem.loading
        for _ in range(ATTEMPTS):
            recipe = Recipe(self._layout(problem, reach), self.order, self._mixed(problem), reach, self.solver)
            model = recipe.build(clock)
            with clock("contact"):
                contact = model.contact(problem.indenter)
                events = nested_events(contact, problem.indenter.a0, loading.to, loading.maximum, SPARE)
            needed = needed_radius(problem, events, reach)
            if needed is None:
                return model, contact, events
            if self.contact_radius is not None:
                raise Refusal(
                    f"contact leaves the refined zone: mesh.contact_radius is {self.contact_radius:g} m, "
                    f"this loading needs about {_enough(problem, needed):.2g} m: give that or leave it out"
                )
            wider = self._bounded(problem, self.margin * needed)
            if wider <= reach:
                break
            reach = wider
        raise Refusal(
            f"contact reaches the edge of the body or of the indenter's profile, {reach:g} m, before the "
            f"{loading.to} reaches {loading.maximum:g}: load less"
        )

    def _increments(self, problem: Problem, contact: SurfaceContact, events: Events) -> list[Increment]:
        loading = problem.loading
        if loading.spacing == "given" and loading.to == "load":
            return solve_loads(contact, loading.values)
        return solve_depths(contact, depths_of(problem, events))

    def _assessed(self, run: Run, clock: StageClock) -> Assessment:
        if not self.estimate_error:
            reason = Unknown("not estimated: estimate_error is off")
            return Assessment(ErrorBudget(reason, reason, reason))
        with clock("error estimate"):
            recipe = run.level.model.recipe.coarser(DOUBLED)
            coarse = Level.of(recipe, run.problem.indenter, run.level.correct, run.deepest)
            return run.assessed(coarse, DOUBLED, run.truncation(coarse))


def _enough(problem: Problem, needed: float) -> float:
    """A contact radius [m] to provide for: ``needed``, which a mesh too small has shown, or that of the wide body."""
    from ..layered.layered import largest_radius

    try:
        expected = largest_radius(problem)
    except JkrError:
        expected = 0.0
    return ROOM * max(needed, expected)

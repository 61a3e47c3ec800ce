"""The method ``FEM``: axisymmetric finite elements with contact on the condensed surface, sliding or sticking."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..base.errors import Estimate, Refusal, Unknown
from ..base.numerics import MOST_SOLVES
from ..base.process import StageClock, one_thread
from ..bodies.problem import HalfSpace, Problem
from ..methods.protocol import Forecast, by_equation, without_coating
from ..series import ErrorBudget, Solution
from . import mesh
from .mesh import Grid, Layout
from .options import DOUBLED, FEMOptions

if TYPE_CHECKING:
    from .model import Run


# --------------------------------------------------------------------------------------------------
# What a solve by ``fem`` costs and how accurate it is, before it is begun.

# Cost and accuracy as measured.
FORECAST_START = 0.03  # CPU seconds of any model; tuned on the cases of `make bench`, by `make bench`
FORECAST_PER_UNKNOWN = 2.5e-5  # and per unknown of a small one; tuned on the same, by `make bench`
FORECAST_LARGE = 1e5  # unknowns, from which they grow like the power 3/2; tuned on the same, by `make bench`
FORECAST_PER_ROW = 1.5e-4  # and per depth, load or radius of a list; tuned on lists of 1e5, by `make guards`
FORECAST_MIB_PER_ROW = 8e-3  # memory of one; tuned on the same, by `make guards`
FORECAST_MIB = 100.0  # memory of any model; tuned on the same, by `make bench`
FORECAST_MIB_PER_UNKNOWN = 5e-3  # tuned on the same, by `make bench`
FORECAST_LOAD = 3e-4  # error of the default spacing, second order; tuned on the bodies of `make chart`, by it
FORECAST_LOAD_ORDER = 2.3  # by which it falls; tuned on the same, by `make chart`
FORECAST_LOAD_FIRST = 1e-2  # error with first-order elements; tuned on the same, by `make chart`
FORECAST_GRADED = 0.15  # of what a graded top leaves unresolved; tuned on power laws of depth, by `make bounds`
FORECAST_RADIUS = 6e-4  # error of calibrated radii; tuned on the same, by `make chart`
# and without slip, per contact radius over the thickness of the top layer:
FORECAST_STUCK = 2e-4  # choice: on layers and films of a/h 5 to 40, 0.3 to 4 times as much is stated


def forecast(options: FEMOptions, problem: Problem, layout: Layout) -> Forecast:
    """Cost and error from the expected number of elements of ``layout``."""
    elsewhere = options.edge_correction and not problem.specimen.is_half_space
    error = _error(options, layout, elsewhere)
    if problem.sticks:
        error += FORECAST_STUCK * layout.law.reach * layout.unit / problem.top_thickness
    # Unknowns per element of large meshes: a triangle has half a vertex, and two displacements per node.
    per_cell = (1.0 if options.element == "triangle" else 2.0) * (1.0 if options.order == 1 else 4.2)
    per_cell *= 1.1 if mesh.mixed_layers(options, problem) else 1.0
    cells = layout.expected_cells()
    seconds = _seconds(options, cells * per_cell)
    if elsewhere:  # the edge correction needs a mesh of its own
        half_space = mesh.homogenised_half_space(layout.body, layout.law.reach * layout.unit)
        seconds += _seconds(options, layout.on(half_space).expected_cells() * per_cell)
    rows = len(problem.loading.values)
    seconds += FORECAST_PER_ROW * rows
    memory = FORECAST_MIB + cells * per_cell * FORECAST_MIB_PER_UNKNOWN + FORECAST_MIB_PER_ROW * rows
    return Forecast(seconds, memory, error, f"about {float(f'{cells:.2g}'):.0f} elements")


def _seconds(options: FEMOptions, unknowns: float) -> float:
    """CPU seconds to mesh, assemble, factorise and condense a model, and its companion for the error estimate."""
    models = (unknowns, unknowns / DOUBLED**2) if options.estimate_error else (unknowns,)
    return sum(FORECAST_START + FORECAST_PER_UNKNOWN * n * (1 + (n / FORECAST_LARGE) ** 0.5) for n in models)


def _error(options: FEMOptions, layout: Layout, calibrated: bool) -> float:
    """Expected relative error of loads and radii together; zones leave no less than the default's, however small."""
    spacing = layout.law.slope or layout.law.floor / layout.law.reach
    coarseness = spacing / FEMOptions.spacing if options.layout == "scaled" else max(spacing / FEMOptions.spacing, 1.0)
    load = (
        FORECAST_LOAD * coarseness**FORECAST_LOAD_ORDER if options.order == 2 else FORECAST_LOAD_FIRST * coarseness**2
    )
    load += FORECAST_GRADED * layout.unresolved
    if options.contact == "incremental" or not options.edge_correction:
        return load + spacing
    return load + (FORECAST_RADIUS * coarseness if calibrated else 0.0)


# --------------------------------------------------------------------------------------------------
# Meshes refined until a tolerance is reached, each from what the one before leaves.

# Spacings from a tolerance, and from one mesh to the next. The spacing of the first mesh is guessed from the
# tolerance. Every finer mesh is judged against the one before, so that each is solved once; the first against a
# companion whose sizes are not doubled as for a single series: what a smaller step changes tells the error more
# closely where meshes converge faster than to first order, which the estimate assumes.
REFINEMENT_COARSEST = 0.12  # spacing of the first mesh; tuned on the bodies of `make tuning`, by `make tuning`
REFINEMENT_FINEST = 5e-4  # of any; choice: more unknowns than machines have memory for
REFINEMENT_USUAL_SPACING = 0.04  # theory: the default, whose usual error is
REFINEMENT_USUAL = 4e-4  # tuned on the bodies of `make failures`, by `make failures`
REFINEMENT_ORDER = 1.7  # by which it falls with the spacing; tuned on the same, by `make failures`
REFINEMENT_AIM = 0.6  # of the tolerance; tuned on the bodies of `make tuning`, by `make tuning`
REFINEMENT_LEAST = 0.4  # by what the spacing may shrink at once; tuned on the same, by `make tuning`
REFINEMENT_MOST = 0.75  # and must; tuned on the same, by `make tuning`
REFINEMENT_STEEPEST = 0.4  # growth; tuned on the same, by `make tuning`
REFINEMENT_COMPANION = 2**0.5  # element sizes the first mesh is judged against; tuned on the same, by `make tuning`


def refine_to_tolerance(options: FEMOptions, problem: Problem, clock: StageClock) -> Solution:
    """Solve ``problem`` to the tolerance; Refusal with the error reached where that is not possible."""
    from . import model

    tolerance = options.tolerance
    assert tolerance is not None
    options = first(options, problem)
    spacing, ratio = options.spacing, REFINEMENT_COMPANION
    solved = model.run(options, problem, clock)
    with clock("error estimate"):
        coarse = solved.companion(ratio)
        truncation = model.truncation_of(solved, coarse)
    for _ in range(MOST_SOLVES):
        with clock("error estimate"):
            judged = model.assessed(solved, [coarse], ratio, truncation)
        reached = judged.budget.series
        if isinstance(reached, float) and reached <= tolerance:
            return model.to_solution(sized(options, spacing), solved, judged, clock)
        # Factor by which the spacing is to shrink; what the truncation takes of the tolerance is lost
        if isinstance(reached, Unknown) or isinstance(truncation, Unknown) or truncation >= tolerance:
            shrinkage = REFINEMENT_LEAST
        else:
            wanted = (REFINEMENT_AIM * (tolerance - truncation) / (reached - truncation)) ** (1 / REFINEMENT_ORDER)
            shrinkage = min(max(wanted, REFINEMENT_LEAST), REFINEMENT_MOST)
        finer = spacing * shrinkage
        if finer < _finest(problem) or (isinstance(truncation, float) and truncation >= tolerance):
            break
        coarse, ratio, spacing = solved.level, spacing / finer, finer
        try:  # the next mesh, for the contact radius found on the one before
            solved = model.run(sized(options, spacing), problem, clock, solved.level.model.discretisation.reach)
        except Refusal as refusal:
            raise Refusal([*_unreached(tolerance, reached, solved).lines, *refusal.lines]) from None
    raise _unreached(tolerance, reached, solved)


def first(options: FEMOptions, problem: Problem) -> FEMOptions:
    """The options with the sizes of the first mesh: their own, or what the tolerance begins with."""
    if options.tolerance is None:
        return options
    guess = REFINEMENT_USUAL_SPACING * (REFINEMENT_AIM * options.tolerance / REFINEMENT_USUAL) ** (1 / REFINEMENT_ORDER)
    spacing = max(min(REFINEMENT_COARSEST, guess), _finest(problem))
    # Fraction of the reach down to which the spacing follows the radius: half the width at the least depth judged.
    reach = mesh.expected_reach(options, problem)
    width = np.geomspace(1e-4, 1, 400) * (reach - problem.indenter.a0)
    depths = problem.indenter.abel(problem.indenter.a0 + width)
    judged = np.interp(np.log(mesh.BUDGET_JUDGED_DEPTH * depths[-1]), np.log(depths), np.log(width))
    smallest = min(options.smallest, 0.5 * float(np.exp(judged)) / (reach - problem.indenter.a0))
    return sized(replace(options, smallest=smallest), spacing)


def _finest(problem: Problem) -> float:
    """Least spacing that the problem is solved with."""
    follows = mesh.finest_spacing(problem.specimen.materials[0]) if problem.sticks else 0.0
    return max(REFINEMENT_FINEST, follows)


def sized(options: FEMOptions, spacing: float) -> FEMOptions:
    """The options with elements in proportion to ``spacing``, as far as the growth may go."""
    growth = min(options.growth_of_sizes * spacing / options.spacing, REFINEMENT_STEEPEST)
    return replace(options, spacing=spacing, growth=growth)


def _unreached(tolerance: float, reached: Estimate, solved: Run) -> Refusal:
    error = reached if isinstance(reached, Unknown) else f"the estimated error is {reached:.1e}"
    unknowns = solved.level.model.system.free.size
    return Refusal(
        f"mesh.tolerance: {tolerance:g} is not reached: with {unknowns} unknowns {error}; use a larger one, leave "
        "out mesh.depth and mesh.width, or use the method layered where it represents the body"
    )


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
        packages = self._packages
        if reason := self._unable(problem):
            return reason
        try:
            self._first_layout(problem)
        except Refusal as refusal:
            return "; ".join(refusal.lines)
        return mesh.missing_packages(*packages)

    @property
    def _packages(self) -> tuple[str, ...]:
        """Modules of finite elements that a solve needs: structured quadrilaterals need no mesher."""
        return ("gmsh", "skfem") if self.element == "triangle" else ("skfem",)

    def _unable(self, problem: Problem) -> str | None:
        """Why no mesh can represent the problem."""
        specimen = problem.specimen
        if reason := without_coating(problem):
            return reason
        if problem.indenter.rim < math.inf:
            return (
                "contact radii of nodes do not meet the sharp edge of a flat punch: use method "
                f"{by_equation(specimen)}, or give indenter.flat_radius and edge_radius"
            )
        if problem.sticks and (reason := self._unable_to_stick(problem)):
            return reason
        if self.tolerance is not None and (self.spacing, self.growth) != (FEMOptions.spacing, FEMOptions.growth):
            return (
                "mesh.spacing and mesh.growth follow from mesh.tolerance: leave them out, or leave out the tolerance "
                "(--tolerance)"
            )
        if problem.indenter.material is not None and (not specimen.is_half_space or specimen.surface_tension):
            body = "surface under tension" if specimen.surface_tension else "layered or finite body"
            return (
                f"an elastic indenter on a {body} is not represented by a rigid profile: "
                f"use method {by_equation(specimen)}, or a rigid indenter"
            )
        if specimen.radius is not None and isinstance(specimen.base, HalfSpace):
            return "a body of finite radius needs a rigid substrate: give the depth as a layer's thickness"
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
            return 'algorithm incremental does not follow which points stick: set contact.algorithm = "nested"'
        least = mesh.finest_spacing(problem.specimen.materials[0])
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
        return mesh.expected_reach(self, problem)

    def _first_layout(self, problem: Problem) -> Layout:
        return mesh.layout_for(first(self, problem), problem, self.reach(problem))

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
            return replace(self.solve(problem)[1], solver=self)
        self._refuse(problem)
        mesh.require(*self._packages)
        with one_thread():
            return replace(refine_to_tolerance(self, problem, StageClock()), solver=self)

    def solve(self, problem: Problem) -> tuple[Run, Solution]:
        """Solve on the mesh of the given sizes; the run holds mesh, factor and contact problem."""
        self._refuse(problem)
        mesh.require(*self._packages)
        from . import model

        clock = StageClock()
        with one_thread():
            solved = model.run(self, problem, clock)
            runs = [solved] if solved.at_touches is None else [solved, solved.at_touches]
            if self.estimate_error:
                with clock("error estimate"):
                    larger = [solved.companion(ratio) for ratio in (DOUBLED, DOUBLED**2)]
                    truncation = model.truncation_of(solved, larger[0])
                    judged, *others = [model.assessed(each, larger, DOUBLED, truncation) for each in runs]
            else:
                reason = Unknown("not estimated: estimate_error is off")
                judged, *others = [model.Assessment(ErrorBudget(reason, reason, reason)) for _ in runs]
            touches = model.series_of(runs[1], others[0]) if others else None
            return solved, model.to_solution(self, solved, judged, clock, touches)

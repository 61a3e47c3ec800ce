"""A series to a given tolerance: meshes are refined until the estimated error meets it.

The spacing of the first mesh is guessed from the tolerance. Every finer mesh is judged against the one before, so that
each is solved once; the first against a companion whose sizes are not doubled as for a single series: what a smaller
step changes tells the error more closely where meshes converge faster than to first order, which the estimate assumes.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...base.clock import StageClock
from ...base.errors import Refusal
from ...base.unknown import Estimate, Unknown
from ...bodies.indenters import Indenter
from ...bodies.problem import Problem
from ...series import Solution
from .budget import JUDGED_DEPTH
from .level import Level
from .run import Run, finished

if TYPE_CHECKING:
    from .method import FEM

COARSEST, FINEST = 0.12, 5e-4  # spacings: of the first mesh, and of any
USUAL_SPACING, USUAL, ORDER = 0.04, 4e-4, 1.7  # a spacing, the error it usually leaves, and how that falls with it
AIM, LEAST, MOST = 0.6, 0.4, 0.75  # of the tolerance, and by what the spacing may shrink at once
STEEPEST = 0.4  # growth
MESHES = 8
COMPANION = 2**0.5  # element sizes of the mesh that the first is judged against


def adapted(method: FEM, problem: Problem, clock: StageClock) -> Solution:
    """Solve ``problem`` to ``method.tolerance``; Refusal with the error reached where that is not possible."""
    tolerance = method.tolerance
    assert tolerance is not None
    method = first(method, problem)
    spacing = method.spacing
    run = method.run(problem, clock)
    with clock("error estimate"):
        recipe, ratio = run.level.model.recipe, COMPANION
        coarse = Level.of(recipe.coarser(ratio), problem.indenter, run.level.correct, run.deepest)
        truncation = run.truncation(coarse)
    for _ in range(MESHES):
        with clock("error estimate"):
            judged = run.assessed(coarse, ratio, truncation)
        reached = judged.budget.series
        if isinstance(reached, float) and reached <= tolerance:
            return finished(sized(method, spacing), run, judged, clock)
        finer = spacing * _shrinkage(tolerance, reached, truncation)
        if finer < FINEST or (isinstance(truncation, float) and truncation >= tolerance):
            break
        coarse, ratio, spacing = run.level, spacing / finer, finer
        run = _run(sized(method, spacing), problem, clock, run, reached)
    raise _unreached(tolerance, reached, run)


def first(method: FEM, problem: Problem) -> FEM:
    """The method with the sizes to begin with."""
    assert method.tolerance is not None
    spacing = min(COARSEST, USUAL_SPACING * (AIM * method.tolerance / USUAL) ** (1 / ORDER))
    smallest = _smallest(method, problem.indenter, method.reach(problem))
    return sized(replace(method, smallest=smallest), max(spacing, FINEST))


def _smallest(method: FEM, indenter: Indenter, reach: float) -> float:
    """Fraction of the reach down to which the spacing follows the radius: half the width at the least depth judged."""
    width = np.geomspace(1e-4, 1, 400) * (reach - indenter.a0)
    depths = indenter.abel(indenter.a0 + width)
    judged = np.interp(np.log(JUDGED_DEPTH * depths[-1]), np.log(depths), np.log(width))
    return min(method.smallest, 0.5 * float(np.exp(judged)) / (reach - indenter.a0))


def sized(method: FEM, spacing: float) -> FEM:
    """The method with its elements in proportion to ``spacing``, as far as the growth may go."""
    growth = min(method.growth_of_sizes * spacing / method.spacing, STEEPEST)
    return replace(method, spacing=spacing, growth=growth)


def _shrinkage(tolerance: float, reached: Estimate, truncation: Estimate) -> float:
    """By what the spacing is to shrink; what the truncation takes of the tolerance is lost."""
    if isinstance(reached, Unknown) or isinstance(truncation, Unknown) or truncation >= tolerance:
        return LEAST
    wanted = (AIM * (tolerance - truncation) / (reached - truncation)) ** (1 / ORDER)
    return min(max(wanted, LEAST), MOST)


def _run(method: FEM, problem: Problem, clock: StageClock, before: Run, reached: Estimate) -> Run:
    """The next mesh, for the contact radius found on the one before."""
    try:
        return method.run(problem, clock, before.level.model.recipe.reach)
    except Refusal as refusal:
        raise Refusal([str(_unreached(method.tolerance or 0.0, reached, before)), *refusal.lines]) from None


def _unreached(tolerance: float, reached: Estimate, run: Run) -> Refusal:
    error = reached if isinstance(reached, Unknown) else f"the estimated error is {reached:.1e}"
    unknowns = run.level.model.system.free.size
    return Refusal(
        f"mesh.tolerance: {tolerance:g} is not reached: with {unknowns} unknowns {error}; ask for a larger one, leave "
        "out mesh.depth and mesh.width, or use the method layered where it represents the body"
    )

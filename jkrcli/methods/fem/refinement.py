"""Meshes refined until a tolerance is reached, each from what the one before leaves."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...base import MOST_SOLVES, Estimate, Refusal, StageClock, Unknown
from ...bodies import Indenter, Problem
from ...series import Solution
from .budget import TUNING as BUDGET
from .budget import assessed, truncation_of
from .edge import finest_spacing
from .model import Run, expected_reach, run
from .options import FEMOptions
from .report import finished


@dataclass(frozen=True)
class RefinementTuning:
    """Spacings from a tolerance, and from one mesh to the next.

    The spacing of the first mesh is guessed from the tolerance. Every finer mesh is judged against the one before, so
    that each is solved once; the first against a companion whose sizes are not doubled as for a single series: what a
    smaller step changes tells the error more closely where meshes converge faster than to first order, which the
    estimate assumes.
    """

    coarsest: float = 0.12  # spacing of the first mesh; tuned on the bodies of `make tuning`, by `make tuning`
    finest: float = 5e-4  # of any; choice: more unknowns than machines have memory for
    usual_spacing: float = 0.04  # theory: the default, whose usual error is
    usual: float = 4e-4  # tuned on the bodies of `make failures`, by `make failures`
    order: float = 1.7  # by which it falls with the spacing; tuned on the same, by `make failures`
    aim: float = 0.6  # of the tolerance; tuned on the bodies of `make tuning`, by `make tuning`
    least: float = 0.4  # by what the spacing may shrink at once; tuned on the same, by `make tuning`
    most: float = 0.75  # and must; tuned on the same, by `make tuning`
    steepest: float = 0.4  # growth; tuned on the same, by `make tuning`
    companion: float = 2**0.5  # element sizes the first mesh is judged against; tuned on the same, by `make tuning`


TUNING = RefinementTuning()


def adapted(options: FEMOptions, problem: Problem, clock: StageClock) -> Solution:
    """Solve ``problem`` to the tolerance; Refusal with the error reached where that is not possible."""
    tolerance = options.tolerance
    assert tolerance is not None
    options = first(options, problem)
    spacing, ratio = options.spacing, TUNING.companion
    solved = run(options, problem, clock)
    with clock("error estimate"):
        coarse = solved.companion(ratio)
        truncation = truncation_of(solved, coarse)
    for _ in range(MOST_SOLVES):
        with clock("error estimate"):
            judged = assessed(solved, [coarse], ratio, truncation)
        reached = judged.budget.series
        if isinstance(reached, float) and reached <= tolerance:
            return finished(sized(options, spacing), solved, judged, clock)
        finer = spacing * _shrinkage(tolerance, reached, truncation)
        if finer < _finest(problem) or (isinstance(truncation, float) and truncation >= tolerance):
            break
        coarse, ratio, spacing = solved.level, spacing / finer, finer
        solved = _finer(sized(options, spacing), problem, clock, solved, _unreached(tolerance, reached, solved))
    raise _unreached(tolerance, reached, solved)


def first(options: FEMOptions, problem: Problem) -> FEMOptions:
    """The options with the sizes of the first mesh: their own, or what the tolerance begins with."""
    if options.tolerance is None:
        return options
    guess = TUNING.usual_spacing * (TUNING.aim * options.tolerance / TUNING.usual) ** (1 / TUNING.order)
    spacing = max(min(TUNING.coarsest, guess), _finest(problem))
    smallest = _smallest(options, problem.indenter, expected_reach(options, problem))
    return sized(replace(options, smallest=smallest), spacing)


def _finest(problem: Problem) -> float:
    """Least spacing that the problem is solved with."""
    follows = finest_spacing(problem.specimen.materials[0]) if problem.sticks else 0.0
    return max(TUNING.finest, follows)


def _smallest(options: FEMOptions, indenter: Indenter, reach: float) -> float:
    """Fraction of the reach down to which the spacing follows the radius: half the width at the least depth judged."""
    width = np.geomspace(1e-4, 1, 400) * (reach - indenter.a0)
    depths = indenter.abel(indenter.a0 + width)
    judged = np.interp(np.log(BUDGET.judged_depth * depths[-1]), np.log(depths), np.log(width))
    return min(options.smallest, 0.5 * float(np.exp(judged)) / (reach - indenter.a0))


def sized(options: FEMOptions, spacing: float) -> FEMOptions:
    """The options with elements in proportion to ``spacing``, as far as the growth may go."""
    growth = min(options.growth_of_sizes * spacing / options.spacing, TUNING.steepest)
    return replace(options, spacing=spacing, growth=growth)


def _shrinkage(tolerance: float, reached: Estimate, truncation: Estimate) -> float:
    """Factor by which the spacing is to shrink; what the truncation takes of the tolerance is lost."""
    if isinstance(reached, Unknown) or isinstance(truncation, Unknown) or truncation >= tolerance:
        return TUNING.least
    wanted = (TUNING.aim * (tolerance - truncation) / (reached - truncation)) ** (1 / TUNING.order)
    return min(max(wanted, TUNING.least), TUNING.most)


def _finer(options: FEMOptions, problem: Problem, clock: StageClock, before: Run, unreached: Refusal) -> Run:
    """The next mesh, for the contact radius found on the one before."""
    try:
        return run(options, problem, clock, before.level.model.discretisation.reach)
    except Refusal as refusal:
        raise Refusal([*unreached.lines, *refusal.lines]) from None


def _unreached(tolerance: float, reached: Estimate, solved: Run) -> Refusal:
    error = reached if isinstance(reached, Unknown) else f"the estimated error is {reached:.1e}"
    unknowns = solved.level.model.system.free.size
    return Refusal(
        f"mesh.tolerance: {tolerance:g} is not reached: with {unknowns} unknowns {error}; ask for a larger one, leave "
        "out mesh.depth and mesh.width, or use the method layered where it represents the body"
    )

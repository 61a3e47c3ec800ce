"""How far JKR holds: by what fraction the pull-off force would differ if adhesion had the range z0.

The Tabor number answers it for a half-space alone. Here the same body is solved with a constant tension up to z0,
unless the annulus in which it would act, pi z0^2 E*/(4 w) wide, is so narrow that nothing can differ.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..adhesion import LOAD_CONTROL, CriticalPoint, Equilibrium, EquilibriumCurve, Range
from ..base import Estimate, JkrError, Unknown
from ..bodies import Problem
from ..series import Series


@dataclass(frozen=True)
class RangeEffectTuning:
    """When the effect of a range is computed, and when it is reported."""

    # Width of the annulus over the contact radius and the top layer, below which the force differs by less than is
    # reported:
    narrow: float = 0.03  # choice: there a half-space differs by 0.5 %, layers by less
    points: int = 40  # contact radii of the solution; choice: a tenth of a second


TUNING = RangeEffectTuning()


def effect_of_range(problem: Problem, series: Series, w: float, z0: float, point: Equilibrium) -> Estimate:
    """The pull-off force under load control at the range ``z0`` [m] over that of JKR at ``point``, less 1; 0 where it
    must be next to nothing.

    ``series``: its radii are the ones solved for; ``w``: work of adhesion [J/m^2].
    """
    if problem.sticks:
        return Unknown("adhesion of finite range is implemented for frictionless contact alone")
    if problem.specimen.surface_tension:
        return Unknown("adhesion of finite range is not derived with surface tension")
    h = min(point.a, problem.top_thickness)
    if math.pi * z0**2 * problem.E_star / (4 * w) < TUNING.narrow * h:
        return 0.0
    try:
        pull_off = ranged(problem, series, w, z0).pull_off(LOAD_CONTROL)
    except JkrError as error:
        return Unknown(str(error))
    return pull_off.P / point.P - 1 if isinstance(pull_off, CriticalPoint) else Unknown(pull_off.reason)


def ranged(problem: Problem, series: Series, w: float, z0: float) -> EquilibriumCurve:
    """The adhesive curve at some of the radii of ``series``, of the range ``z0`` [m] and the work of adhesion ``w``
    [J/m^2]."""
    from ..adhesion import FiniteRangeBody
    from ..methods.attraction import AttractedBody

    some = np.unique(np.linspace(0, len(series) - 1, TUNING.points).astype(int))
    body = FiniteRangeBody(problem, Series(series.a[some], series.delta[some], series.P[some]), AttractedBody(problem))
    return body.curve(Range.of(w, length=z0))

"""From which surface tension on an answer would change: the same body solved roughly with a slight one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..adhesion import LOAD_CONTROL, AdhesiveCurve, CriticalPoint, Nonadhesive
from ..adhesion.slopes.exact import exact
from ..base import Estimate, JkrError, Unknown
from ..bodies import Problem
from ..methods.layered.layered import Layered, unbounded
from ..series import Series
from .again import again


@dataclass(frozen=True)
class TensionEffectTuning:
    """The trial, and what is worth a word."""

    # kappa over the largest radius; tuned on bodies, by `make constants`: the change is then in proportion to within a
    # fifth
    slight: float = 0.01
    # tuned on bodies, by `make constants`: of the load at equal depth or a pull-off force, as for a range
    changed: float = 0.01
    radii: int = 40  # tuned on bodies, by `make constants`: a tenth of a second
    # of the largest radius; tuned on bodies, by `make constants`: pull-off below is not looked for
    smallest: float = 0.02
    accuracy: float = 1e-6  # tuned on bodies, by `make constants`: far below the change


TUNING = TensionEffectTuning()


def noticed_tension(problem: Problem, largest: float, works: Sequence[float]) -> Estimate:
    """The surface tension [N/m] at which the load at equal depth, up to the contact radius ``largest`` [m], or the
    pull-off force of one of ``works`` [J/m^2] is another by ``TUNING.changed``; or why it is not known."""
    if problem.specimen.surface_tension or problem.sticks or problem.indenter.material is not None:
        return Unknown("computed for rigid indenters and frictionless contact without surface tension alone")
    a0 = problem.indenter.a0
    radii = a0 + (largest - a0) * np.geomspace(TUNING.smallest, 1.0, TUNING.radii)
    trial = TUNING.slight * largest * problem.E_star / 2
    body, method = unbounded(problem), Layered(TUNING.accuracy)
    tense = replace(body.specimen, surface_tension=trial, relaxation=None)
    try:
        plain, other = (again(body, radii, method, specimen=one).series for one in (body.specimen, tense))
        changes = [_load(other, float(plain.delta[-2])) / float(plain.P[-2]) - 1]
        changes += [_pull_off(other, w) / _pull_off(plain, w) - 1 for w in works if w > 0]
    except JkrError as error:
        return Unknown(str(error))
    largest_change = np.nanmax(np.abs(changes))
    return float(trial * TUNING.changed / largest_change)


def _load(series: Series, depth: float) -> float:
    return float(np.exp(np.interp(np.log(depth), np.log(series.delta), np.log(series.P))))


def _pull_off(series: Series, w: float) -> float:
    """The force [N], nan where it lies outside the series."""
    found = AdhesiveCurve(Nonadhesive(series, exact(series)), w).pull_off(LOAD_CONTROL)
    return found.P if isinstance(found, CriticalPoint) else np.nan

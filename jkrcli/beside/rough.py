"""What the formulas of a half-space make of a record at a glance: a rough modulus, before anything is fitted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Estimate, Unknown
from ..bodies import Indenter
from .reach import half_space_radii, work_on_half_space


@dataclass(frozen=True)
class Rough:
    """``E_star`` [Pa] by the formula without adhesion at the largest load, its contact radius ``a`` [m], and ``w``
    [J/m^2] by the pull-off force of JKR with that modulus: of a half-space, without an error."""

    E_star: float
    a: float
    w: Estimate


def rough(tip: Indenter, load: float, depth: float, adhesion: Estimate) -> Rough | Unknown:
    """A glance at the ``load`` [N] that holds the ``tip`` at a ``depth`` [m], and at the force of ``adhesion`` [N]."""
    if not (load > 0 and depth > 0):
        return Unknown("the largest load or its depth is not positive")
    a, delta, P = half_space_radii(tip, 1.0)
    if not delta[0] < depth < delta[-1]:
        return Unknown("the depth lies beyond the indenter")
    radius, unit = (float(np.exp(np.interp(np.log(depth), np.log(delta), np.log(column)))) for column in (a, P))
    E_star = load / unit
    w = adhesion if isinstance(adhesion, Unknown) else work_on_half_space(tip, E_star, adhesion)
    return Rough(E_star, radius, w)

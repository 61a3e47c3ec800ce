"""The exact solution of the bodies that a measured or computed series is said to be of."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..base.arrays import Array
from ..base.errors import JkrError
from ..bodies.problem import Loading, Problem
from ..methods import method_class
from ..series import Series

EXACT = ("closed-form", "layered")  # exact ones that cost next to nothing


@dataclass(frozen=True)
class OwnBodyTuning:
    """The radii of the solution, and how long it may take."""

    radii: int = 80  # choice: in equal steps of log(a - a0); log delta of a layer is then interpolated to 1e-7
    longest: float = 5.0  # choice: CPU seconds by its forecast, of the wait for a curve
    below: float = 2.5  # choice: of log(a - a0), how far below the least radius it reaches, as far as a fit does


TUNING = OwnBodyTuning()


def own_solution(problem: Problem, a: Array) -> Series | None:
    """The solution over the radii ``a`` (n,) [m] and some way below; None where no exact method represents them, or
    not soon."""
    beyond = a - problem.indenter.a0
    steps = np.geomspace(beyond.min() * np.exp(-TUNING.below), beyond.max(), TUNING.radii)
    alone = replace(problem, loading=Loading.given("radius", tuple(problem.indenter.a0 + steps)))
    for name in EXACT:
        method = method_class(name)()
        try:
            if method.refusal(alone) is None and method.forecast(alone).seconds < TUNING.longest:
                return method(alone).series
        except JkrError:
            continue
    return None

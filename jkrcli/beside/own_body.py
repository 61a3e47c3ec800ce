"""The exact solution of the bodies that a measured or computed series is claimed to be of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import PATIENCE, Array, JkrError
from ..bodies import Problem
from ..series import Series
from .again import again


@dataclass(frozen=True)
class OwnBodyTuning:
    """The radii of the solution, and how long it may take."""

    # in equal steps of log(a - a0); tuned on bodies, by `make constants`: half move the radius of a jump by 2e-5
    radii: int = 80
    # of log(a - a0), how far below the least radius it reaches, as far as a fit does; tuned on bodies,
    # by `make constants`: half of it moves the radius of a jump by 2 %
    below: float = 2.5


TUNING = OwnBodyTuning()


def own_solution(problem: Problem, a: Array) -> Series | None:
    """The solution over the radii ``a`` (n,) [m] and some way below; None where no exact method represents them, or
    not soon."""
    beyond = a - problem.indenter.a0
    steps = np.geomspace(beyond.min() * np.exp(-TUNING.below), beyond.max(), TUNING.radii)
    try:
        return again(problem, problem.indenter.a0 + steps, longest=PATIENCE).series
    except JkrError:
        return None

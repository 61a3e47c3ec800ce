"""The one way in which a body is solved again: over other radii, by another method, with other surfaces; and the exact
solution of the bodies that a measured or computed series is claimed to be of."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from ..base.errors import JkrError, Refusal
from ..base.numerics import Array
from ..base.process import PATIENCE, duration
from ..bodies.problem import Loading, Problem
from ..case.models import method_of
from ..case.reading import Case
from ..methods.protocol import METHODS, Method, method_class
from ..series import Series, Solution

# The radii of the solution, and how long it may take.
# in equal steps of log(a - a0); tuned on bodies, by `make constants`: half move the radius of a jump by 2e-5
OWN_BODY_RADII = 80
# of log(a - a0), how far below the least radius it reaches, as far as a fit does; tuned on bodies,
# by `make constants`: half of it moves the radius of a jump by 2 %
OWN_BODY_BELOW = 2.5


def resolve_with(
    problem: Problem, radii: Array | None = None, method: Method | None = None, longest: float = math.inf,
    **otherwise: Any,
) -> Solution:  # fmt: skip
    """A body solved again: the solution of a ``problem`` with ``otherwise`` in place of its fields, over ``radii`` [m]
    (default: as it is loaded), by ``method`` or the first exact one that represents it; JkrError where none does, or
    not within ``longest`` [CPU s]."""
    if radii is not None:
        otherwise["loading"] = Loading.given("radius", tuple(radii.tolist()))
    changed = replace(problem, **otherwise)
    failed: JkrError = Refusal("no exact method represents these bodies")
    for each in exact() if method is None else (method,):
        try:
            if reason := each.refusal(changed):
                raise Refusal(reason)
            if longest < math.inf and (seconds := each.forecast(changed).seconds) >= longest:
                raise Refusal(f"the coarse solution would take about {duration(seconds)}")
            return each(changed)
        except JkrError as error:
            failed = error
    raise failed


def exact() -> list[Method]:
    """The methods that are exact and cost next to nothing, least effort first."""
    return [method_class(name)() for name, method in METHODS.items() if method.exact]


def method_behind(solution: Solution) -> Method | None:
    """The method that made ``solution``, with the options of its case and the kernel that it has found."""
    name, case = solution.method, solution.record.case
    if name not in METHODS:
        return None
    method: Any = method_of(case.model, name) if isinstance(case, Case) else method_class(name)()
    found: Method = method if solution.kernel is None else replace(method, known=solution)
    return found


def own_solution(problem: Problem, a: Array) -> Series | None:
    """The solution over the radii ``a`` (n,) [m] and some way below; None where no exact method represents them, or
    not soon."""
    beyond = a - problem.indenter.a0
    steps = np.geomspace(beyond.min() * np.exp(-OWN_BODY_BELOW), beyond.max(), OWN_BODY_RADII)
    try:
        return resolve_with(problem, problem.indenter.a0 + steps, longest=PATIENCE).series
    except JkrError:
        return None

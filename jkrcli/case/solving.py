"""A validated case to a solution, by the method that it names or needs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ..base.errors import JkrError
from ..base.threads import one_thread
from ..methods import Method
from ..methods.choose import Choice, choose
from ..methods.guards import Limits, admit
from ..series import Solution
from . import Case
from .numerics import method_of
from .store import record_of

Announce = Callable[[str], None]


@one_thread
def solve(
    case: Case, method: str | None = None, limits: Limits | None = None, announce: Announce | None = None
) -> tuple[Choice, Solution]:
    """Solve ``case`` by ``method`` (None: the case's own); under "auto" the next one where the first fails.

    Refusal where it would cost more than ``limits``; ``announce`` is told what it will cost where that is much.
    """

    def build(name: str) -> Method:
        return method_of(case.model, name)

    problem = case.model.problem()
    choice: Choice | None = choose(problem, method or case.model.method, build)
    while True:
        assert choice is not None
        cost = admit(f"method {choice.name}", choice.forecast(problem), limits or Limits())
        if cost and announce:
            announce(cost)
        try:
            return choice, replace(choice.method(problem), record=record_of(case))
        except JkrError as error:
            choice = choice.after_failure(error, build)
            if choice is None:
                raise

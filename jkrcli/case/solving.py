"""A validated case, or a problem made in Python, to a solution, by the method that it names or needs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from ..base import JkrError, one_thread
from ..bodies import Problem
from ..methods import Choice, Limits, Method, admit, choose_method, long_look, method_class
from ..series import Record, Solution
from .numerics import method_of
from .reading import Case
from .store import record_of

Announce = Callable[[str], None]


@one_thread()
def solve(
    source: Case | Problem,
    method: str | Method | None = None,
    limits: Limits | None = None,
    announce: Announce | None = None,
) -> tuple[Choice, Solution]:
    """Solve by ``method`` (None: the case's own, "auto" for a problem); under "auto" the next one where one fails.

    Refusal where it would cost more than ``limits``; ``announce`` gets the forecast of its cost where that is much.
    """
    problem, record, named, build = _parts(source)
    if announce and (words := long_look(problem)):
        announce(words)
    choice: Choice | None = choose_method(problem, method or named, build)
    while True:
        assert choice is not None
        cost = admit(f"method {choice.name}", choice.forecast(problem), limits or Limits())
        if cost and announce:
            announce(cost)
        try:
            return choice, replace(choice.method(problem), record=record)
        except JkrError as error:
            choice = choice.after_failure(error, build)
            if choice is None:
                raise


def _parts(source: Case | Problem) -> tuple[Problem, Record, str, Callable[[str], Method]]:
    """The problem, what goes with it into a file, the method's name and how methods are configured."""
    if isinstance(source, Problem):
        return source, Record(), "auto", lambda name: method_class(name)()
    return source.model.problem(), record_of(source), source.model.method, partial(method_of, source.model)

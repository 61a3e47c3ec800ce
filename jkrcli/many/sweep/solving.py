"""One group of cases solved, the work that goes to a worker; what took long is kept, by what it depends on."""

from __future__ import annotations

import contextlib
import hashlib
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from ... import __version__
from ...adhesion import Nonadhesive
from ...base import InputError, JkrError, Unknown, check_target
from ...beside import adhesive, nonadhesive
from ...bodies import Problem
from ...case import CaseModel, method_of, read_solution, write_solution
from ...methods import Choice, Method, choose_method, least_first, survey
from ...series import Record, Solution
from .plan import Cases, Recipe, at_unit_modulus
from .quantities import Value

OK, FAILED = "ok", "failed"


@dataclass(frozen=True)
class SolvingTuning:
    """Which solves are kept."""

    worth_keeping: float = 0.1  # choice: CPU seconds; reading a file takes a tenth of it


TUNING = SolvingTuning()


@dataclass(frozen=True)
class Row:
    """One row of the table: ``values`` per column, None where there is none; ``reason``: why it failed, or why values
    are missing; ``seconds``: CPU time of the case, its share of a common solve included."""

    number: int
    status: str
    reason: str
    values: tuple[Value | None, ...]
    seconds: float


def solve_group(recipe: Recipe, folder: Path | None, cases: Cases) -> list[Row]:
    """Solve what ``cases`` share, and read off each what is wanted; failures become rows.

    ``folder``: of expensive solves of earlier runs.
    """
    start = time.process_time()
    try:
        model = recipe.model(cases[0][1])
        solution = _solved(at_unit_modulus(model.problem())[0], model, folder)
        body = nonadhesive(solution, recipe.wanted.slopes)
    except Exception as error:
        share = (time.process_time() - start) / len(cases)
        return [failed(recipe, number, error, share) for number, _ in cases]
    share = (time.process_time() - start) / len(cases)
    return [_row(recipe, solution, body, number, values, share) for number, values in cases]


def _solved(body: Problem, model: CaseModel, folder: Path | None) -> Solution:
    """The solution by the case's method; where "auto" has the choice and a method fails, by the next one."""
    build = partial(method_of, model)
    choice: Choice | None = least(body, model)
    while choice is not None:
        try:
            return _once(body, choice.method, folder)
        except JkrError as error:
            if model.method != "auto":
                raise
            failure, options = error, choice.options or choose_method(body, "auto", build).options
            choice = replace(choice, options=options).after_failure(error, build)
    raise failure


def _key(problem: Problem, method: Method) -> str:
    """A hash of all that a solve depends on: the physics, the method with its options, the release."""
    return hashlib.sha256(f"{problem.key}\n{method!r}\n{__version__}".encode()).hexdigest()[:24]


def _once(problem: Problem, method: Method, folder: Path | None = None) -> Solution:
    """The solution of ``problem`` by ``method``: from ``folder`` where it is kept there, else solved, and kept there
    where that was expensive (``SolvingTuning``)."""
    key = _key(problem, method)
    path = None if folder is None else folder / f"{key}.h5"
    if path is not None and (stored := _kept(path, problem, key)) is not None:
        return stored
    start = time.process_time()
    solution = replace(method(problem), record=Record(path=Path("series")))
    expensive = time.process_time() - start > TUNING.worth_keeping
    if path is not None and expensive and solution.raw is None and path.parent.is_dir():
        with contextlib.suppress(JkrError):  # no room, or a shape that no case can say: it is solved every time
            check_target(path, force=True)  # also what is damaged
            write_solution(path, solution, _made_by(key))
    return solution


def _made_by(key: str) -> str:
    """What a kept file says of its origin: its name alone proves nothing."""
    return f"jkr sweep, solve {key}"


def _kept(path: Path, problem: Problem, key: str) -> Solution | None:
    """A solution that was kept; None where there is none, its file is damaged, or it holds another solve."""
    try:
        solution = read_solution(path, problem) if path.exists() else None
    except InputError:
        return None
    return solution if solution is not None and solution.record.command_line == _made_by(key) else None


def least(body: Problem, model: CaseModel) -> Choice:
    """What ``choose`` chooses, without asking the methods behind the first that will do: that would cost more."""
    build = partial(method_of, model)
    for name in least_first() if model.method == "auto" else ():
        (option,) = survey(body, build, [name])
        if option.is_accurate and option.is_quick:
            return Choice(name, build(name), "the simplest method for this body")
    return choose_method(body, model.method, build)


def _row(
    recipe: Recipe, solution: Solution, body: Nonadhesive, number: int, values: Mapping[str, Any], share: float
) -> Row:
    """What is wanted of one case; ``solution``, ``body``: at unit modulus, which all cases of the group share."""
    start = time.process_time()
    try:
        model = recipe.model(values)
        works, z0 = model.adhesion.w, model.adhesion.z0
        factor = at_unit_modulus(model.problem())[1]
        solution = replace(solution, record=replace(solution.record, z0=z0))
        result = adhesive(solution, body, works[0] if works else 0.0, factor)
        wanted = recipe.wanted.values(result)
    except Exception as error:
        return failed(recipe, number, error, share + time.process_time() - start)
    reasons = dict.fromkeys(value.reason for value in wanted if isinstance(value, Unknown) and value.reason)
    cells = tuple(None if isinstance(value, Unknown) else value for value in wanted)
    return Row(number, OK, "; ".join(reasons), cells, share + time.process_time() - start)


def failed(recipe: Recipe, number: int, why: str | Exception, seconds: float = 0.0) -> Row:
    """The row of a case without a result; errors that are no message for users are bugs: their type tells so."""
    if isinstance(why, Exception) and not isinstance(why, JkrError):
        why = f"unexpected {type(why).__name__}: {why}"
    return Row(number, FAILED, " ".join(str(why).split()), (None,) * len(recipe.wanted.columns), seconds)

"""A sweep as it will be run: which cases there are, what each holds, which of them share a solve, and that solve.

Bodies that differ by one factor of all moduli share one: P, S and S' scale with the moduli and delta(a) does not, so
that every problem is solved at unit modulus, E = 1 Pa at its surface. The result depends on the problem alone, never on
which of several cases asked for it first.
"""

from __future__ import annotations

import contextlib
import hashlib
import itertools
import math
import shlex
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, TypeAlias

from ... import __version__
from ...adhesion import Nonadhesive, checked_rule
from ...base import MOST_CELLS, InputError, JkrError, Unknown, check_target
from ...beside import adhesive, nonadhesive
from ...bodies import Problem
from ...case import (
    MOST_CASES,
    Case,
    CaseModel,
    SweepModel,
    load_sweep,
    method_of,
    model_of,
    read_solution,
    write_solution,
)
from ...methods import Choice, Method, choose_method, least_first, survey
from ...series import Record, Solution
from ...tables.text_table import MOST_COLUMNS
from .axes import Axis, W, resolve
from .paths import LAYER_COUNT, Tables, unit_of, with_values
from .quantities import ALONG, POINT, Value, Wanted, names_of

FIRM = ("radius", "thickness", "nu")  # how keys end whose values tell bodies apart
PHYSICS = {"title", "indenter", "specimen", "loading", "adhesion"}
OK, FAILED = "ok", "failed"
Cases: TypeAlias = Sequence[tuple[int, Mapping[str, Any]]]  # by their numbers and values, which share one solve


@dataclass(frozen=True)
class SharingTuning:
    """How solves are distinguished and which are kept."""

    digits: int = 13  # of numbers at unit modulus, theory: of the 16 of a double quotients lose the last ones
    worth_keeping: float = 0.1  # choice: CPU seconds; reading a file takes a tenth of it


TUNING = SharingTuning()


@dataclass(frozen=True)
class Recipe:
    """What a worker needs to know to make a case of given values: the base case's ``tables``, what is wanted."""

    tables: Tables
    wanted: Wanted
    folder: Path

    def model(self, values: Mapping[str, Any]) -> CaseModel:
        """The case with the given values, validated; InputError where they make none."""
        model = model_of(with_values(self.tables, values), "", self.folder)
        if len(model.adhesion.w) > 1:
            raise InputError(f"{W}: a case of a sweep takes one value, got {list(model.adhesion.w)}")
        if ranged := [name for name in ("range", "stress", "capillary") if getattr(model.adhesion, name) is not None]:
            raise InputError(f"adhesion.{ranged[0]}: sweep has no adhesion of finite range: leave it out")
        return model


@dataclass(frozen=True)
class Plan:
    """All cases of a sweep: the product of its ``axes``, the last one running fastest."""

    source: str
    title: str
    recipe: Recipe
    axes: tuple[Axis, ...]

    @property
    def keys(self) -> tuple[str, ...]:
        """All keys that vary."""
        return tuple(key for axis in self.axes for key in axis.keys)

    @cached_property
    def key_columns(self) -> tuple[str, ...]:
        """The names of their columns: the key and its SI unit."""
        tables, folder = self.recipe.tables, self.recipe.folder
        return tuple(f"{key}_{unit_of(tables, key, x, folder)}".removesuffix("_") for key, x in self.values(0).items())

    @property
    def count(self) -> int:
        return math.prod(len(axis.rows) for axis in self.axes)

    def values(self, number: int) -> dict[str, Any]:
        """The values of case ``number`` (from 0) by key, in SI."""
        rows = []
        for axis in reversed(self.axes):
            number, i = divmod(number, len(axis.rows))
            rows.append(zip(axis.keys, axis.rows[i], strict=True))
        return dict(itertools.chain.from_iterable(reversed(rows)))

    @property
    def least_solves(self) -> int:
        """Solves that all cases together need at least: values that may cancel (w, moduli, a load over them) or be cut
        off with their layer count as none."""
        cut = LAYER_COUNT in self.keys
        return math.prod(len({repr(_firm(axis.keys, row, cut)) for row in axis.rows}) for axis in self.axes)

    def identity(self, number: int) -> str:
        """A hash of everything that the row of a case depends on: what journals know it by."""
        digest = self._head.copy()
        digest.update(f"\n{self.values(number)!r}".encode())
        return digest.hexdigest()[:20]

    @cached_property
    def _head(self) -> Any:
        return hashlib.sha256(f"{__version__}\n{self.recipe.tables!r}\n{self.recipe.wanted!r}".encode())

    def command(self, number: int) -> str:
        """What solves one case alone and prints its row."""
        return shlex.join(["jkr", "sweep", self.source, "--only", str(number)])

    def case(self, number: int) -> Case:
        """Case ``number`` as a case of its own."""
        return Case(self.recipe.model(self.values(number)), f"{self.source}: case {number}")

    def groups(self, numbers: Iterable[int], most: int = 1000) -> tuple[list[Cases], list[tuple[int, str]]]:
        """The cases ``numbers`` by shared solves, and those that are none, each with its reason.

        Cases share a solve where they differ in the work of adhesion, or by one factor of all moduli, alone; at most
        ``most`` make one piece of work.
        """
        shared: dict[Any, list[tuple[int, dict[str, Any]]]] = {}
        wrong = []
        for number in numbers:
            values = self.values(number)
            try:
                model = self.recipe.model(values)
                body = at_unit_modulus(model.problem())[0]
            except InputError as error:
                wrong.append((number, "; ".join(line.removeprefix(": ") for line in error.lines)))
                continue
            solve = f"{body.key}{model.model_dump(exclude=PHYSICS)!r}"  # the body and how it is to be solved
            shared.setdefault(hashlib.sha256(solve.encode()).digest(), []).append((number, values))
        pieces = (cases[first : first + most] for cases in shared.values() for first in range(0, len(cases), most))
        return list(pieces), wrong


def at_unit_modulus(problem: Problem) -> tuple[Problem, float]:
    """The problem with all moduli (and a load, where one is prescribed) over the surface's E, and that E [Pa]."""
    factor = problem.specimen.surface.E
    return _rounded(problem.scaled(1 / factor)), factor


def _rounded(value: Any) -> Any:
    """``value`` rounded throughout (``SharingTuning``): quotients that are equal on paper become equal."""
    if isinstance(value, float):
        return float(f"{value:.{TUNING.digits - 1}e}")
    if isinstance(value, tuple):
        return tuple(_rounded(item) for item in value)
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{item.name: _rounded(getattr(value, item.name)) for item in fields(value) if item.init})
    return value


def _firm(keys: Sequence[str], row: Sequence[Any], cut: bool) -> list[Any]:
    """Those values of a row of an axis that make another body, whatever the moduli and the number of layers are."""
    return [value for key, value in zip(keys, row, strict=True) if key.endswith(FIRM) and not (cut and "layers" in key)]


def load_plan(path: Path) -> Plan:
    """The plan of the sweep file at ``path``; InputError with a line per mistake."""
    model, tables, folder = load_sweep(path)
    source = str(path)
    wanted = _wanted(model, source)
    axes, first = resolve(model, tables, folder, source)
    if wanted.needs_w and not any(first.adhesion.w):
        raise InputError(
            f"{source}: the quantities asked for need a work of adhesion: vary adhesion.w, or set it in the base case"
        )
    plan = Plan(source, model.title, Recipe(_self_contained(tables, first, axes), wanted, folder), axes)
    if plan.count > MOST_CASES:
        raise InputError(f"{source}: makes {plan.count:,} cases, at most {MOST_CASES:,} are allowed in one sweep")
    if (cells := plan.count * len(wanted.columns)) > MOST_CELLS:
        raise InputError(
            f"{source}: makes {plan.count:,} cases of {len(wanted.columns):,} columns, {cells:,} cells, at most "
            f"{MOST_CELLS:,} are written; ask for fewer cases, quantities, radii or devices"
        )
    return plan


def _wanted(model: SweepModel, source: str) -> Wanted:
    outputs = model.outputs
    columns = len(ALONG) * len(outputs.radii) + len(POINT) * len(outputs.stiffness)
    if columns > MOST_COLUMNS:
        raise InputError(
            f"{source}: outputs.radii and outputs.stiffness make {columns:,} columns, at most {MOST_COLUMNS:,} are "
            "written; ask for fewer"
        )
    rule = checked_rule(outputs.slopes, f"{source}: outputs.slopes")
    return Wanted(names_of(outputs.quantities, source), outputs.radii, outputs.stiffness, rule)


def _self_contained(tables: Tables, first: CaseModel, axes: Sequence[Axis]) -> Tables:
    """The base case with a profile's points in place of the name of their file, so that workers need no file."""
    indenter = tables.get("indenter", {})
    if "file" not in indenter or any(key == "indenter.file" for axis in axes for key in axis.keys):
        return tables
    points = {key: first.model_dump()["indenter"][key] for key in ("r", "f")}
    rest = {key: value for key, value in indenter.items() if key != "file"}
    return {**tables, "indenter": rest | points}


# ---------------------------------------------------------------------- the work that goes to a worker
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
            return solved_once(body, choice.method, folder)
        except JkrError as error:
            if model.method != "auto":
                raise
            failure, options = error, choice.options or choose_method(body, "auto", build).options
            choice = replace(choice, options=options).after_failure(error, build)
    raise failure


def _key(problem: Problem, method: Method) -> str:
    """A hash of all that a solve depends on: the physics, the method with its options, the release."""
    return hashlib.sha256(f"{problem.key}\n{method!r}\n{__version__}".encode()).hexdigest()[:24]


def solved_once(problem: Problem, method: Method, folder: Path | None = None) -> Solution:
    """The solution of ``problem`` by ``method``: from ``folder`` where it is kept there, else solved, and kept there
    where that was expensive (``SharingTuning``)."""
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

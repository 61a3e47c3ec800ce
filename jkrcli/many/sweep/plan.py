"""A sweep as it will be run: which cases there are, what each holds, which of them share a solve.

Bodies that differ by one factor of all moduli share one: P, S and S' scale with the moduli and delta(a) does not, so
that every problem is solved at unit modulus, E = 1 Pa at its surface. The result depends on the problem alone, never on
which of several cases asked for it first.
"""

from __future__ import annotations

import hashlib
import itertools
import math
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

from ... import __version__
from ...adhesion.slopes import checked_rule
from ...base import MOST_CELLS, InputError
from ...bodies import Problem
from ...case import Case, CaseModel, model_of, sweep
from ...data.text_table import MOST_COLUMNS
from .axes import Axis, W, resolve
from .paths import LAYER_COUNT, Tables, unit_of, with_values
from .quantities import ALONG, POINT, Wanted, names_of

FIRM = ("radius", "thickness", "nu")  # how keys end whose values tell bodies apart
PHYSICS = {"title", "indenter", "specimen", "loading", "adhesion"}
DIGITS = 13  # theory: of numbers at unit modulus; of the 16 of a double quotients lose the last ones
Cases: TypeAlias = Sequence[tuple[int, Mapping[str, Any]]]  # by their numbers and values, which share one solve


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
    """``value`` rounded throughout (``DIGITS``): quotients that are equal on paper become equal."""
    if isinstance(value, float):
        return float(f"{value:.{DIGITS - 1}e}")
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
    model, tables, folder = sweep.load_sweep(path)
    source = str(path)
    wanted = _wanted(model, source)
    axes, first = resolve(model, tables, folder, source)
    if wanted.needs_w and not any(first.adhesion.w):
        raise InputError(
            f"{source}: the quantities asked for need a work of adhesion: vary adhesion.w, or set it in the base case"
        )
    plan = Plan(source, model.title, Recipe(_self_contained(tables, first, axes), wanted, folder), axes)
    if plan.count > sweep.MOST_CASES:
        raise InputError(f"{source}: makes {plan.count:,} cases, at most {sweep.MOST_CASES:,} are allowed in one sweep")
    if (cells := plan.count * len(wanted.columns)) > MOST_CELLS:
        raise InputError(
            f"{source}: makes {plan.count:,} cases of {len(wanted.columns):,} columns, {cells:,} cells, at most "
            f"{MOST_CELLS:,} are written; ask for fewer cases, quantities, radii or devices"
        )
    return plan


def _wanted(model: sweep.SweepModel, source: str) -> Wanted:
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

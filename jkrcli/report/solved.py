"""Solved cases and imported tables: how far they go, by what method, how exactly."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..adhesion.validity import judge_solution
from ..base.errors import AT_LEVEL, LEVEL, Estimate, Unknown, accuracy, counted
from ..base.numerics import Array
from ..base.registry import Result
from ..base.units import reached
from ..bodies.problem import relaxing
from ..methods.protocol import Choice
from ..resolve.sticking import StickingEffect, sticking, sticking_warnings
from ..series import COLUMNS, Series, Solution


def end_of(series: Series) -> dict[str, Any]:
    """How far a series goes, for machines."""
    return {"points": len(series)} | dict(zip(("a_m", "delta_m", "P_N"), series.end, strict=True))


@dataclass(frozen=True, eq=False)
class SeriesFile(Result):
    """A ``solution`` and the ``file`` that holds it."""

    file: Path
    solution: Solution

    @property
    def columns(self) -> Mapping[str, Array]:  # type: ignore[override]
        units = {name: column.unit.replace("/", "_per_").replace("^", "") for name, column in COLUMNS.items()}
        columns = {f"{name}_{unit}": getattr(self.solution.series, name) for name, unit in units.items()}
        return {name: column for name, column in columns.items() if column is not None}

    @property
    def _reached(self) -> str:
        return reached(*self.solution.series.end)


@dataclass(frozen=True, eq=False)
class Solved(SeriesFile):
    """A case solved by the method of a ``choice`` in CPU ``seconds``; ``sticking``: what it matters whether surfaces
    stick; ``tolerance``: what was asked for; ``remarks`` on the case."""

    choice: Choice
    sticking: StickingEffect | Unknown
    seconds: float
    tolerance: float | None = None
    remarks: Sequence[str] = ()

    @property
    def warnings(self) -> list[str]:
        problem, series = self.solution.problem, self.solution.series
        missing = missed(self.tolerance, self.solution.budget.total)
        # Without a work of adhesion: a/R, delta/h, a/L, and too few points to go on with
        geometry = judge_solution(problem, series, self.solution.facts).warnings
        few = [f"only {counted(len(series), 'point')}: adhesive curves need at least 5"] if len(series) < 5 else []
        return [
            *missing, *self.remarks,
            *relaxing(problem.specimen.relaxation), *self.solution.warnings,
            *geometry, *few, *sticking_warnings(problem, self.sticking),
        ]  # fmt: skip

    def summary(self) -> dict[str, Any]:
        return {
            "file": str(self.file),
            "method": self.choice.name,
            "reason": self.choice.reason,
            "surface": self.solution.problem.surface,
            **end_of(self.solution.series),
            "level": LEVEL,
            "errors": self.solution.budget.as_dict(),
            "warnings": self.warnings,
            "cpu_s": self.seconds,
            "sticking": sticking(self.sticking),
        }

    def words(self) -> list[str]:
        error = accuracy(self.solution.budget.total, self.solution.problem.indenter.error_name)
        return [
            f"{self._reached} in {counted(len(self.solution.series), 'point')}; {error}",
            f"  body      {self.solution.problem.words}",
            f"  method    {self.choice.name}: {self.choice.reason}",
            f"  written   {self.file} ({self.seconds:.2f} s CPU)",
        ]


@dataclass(frozen=True, eq=False)
class Imported(SeriesFile):
    """A series that another program computed, read from a ``table``."""

    table: Path

    @property
    def warnings(self) -> list[str]:
        return [f"{self.table}: {warning}" for warning in self.solution.warnings]

    def summary(self) -> dict[str, Any]:
        return {
            "file": str(self.file),
            "method": self.solution.method,
            **end_of(self.solution.series),
            "facts": dict(self.solution.facts),
            "level": LEVEL,
            "errors": self.solution.budget.as_dict(),
            "warnings": list(self.solution.warnings),
        }

    def words(self) -> list[str]:
        facts = self.solution.facts
        errors = f"; ± at {AT_LEVEL}" * ("±" in f"{facts['loads']} {facts['radii']}")
        return [
            f"{self._reached}; {facts['rows']} rows, {len(self.solution.series)} different contact radii{errors}",
            f"  loads     {facts['loads']}",
            f"  radii     {facts['radii']}",
            *([f"  contact   {facts['contact_shape']}: compared with no disc"] if "contact_shape" in facts else []),
            f"  body      {self.solution.problem.words}",
            f"  columns   {facts['columns']}; separated by: {facts['separator']}",
            f"  written   {self.file}",
        ]


def missed(tolerance: float | None, error: Estimate) -> list[str]:
    """A warning where the ``error`` of a solution is not known to be what was asked for."""
    if tolerance is None or (not isinstance(error, Unknown) and error <= tolerance):
        return []
    words = error.reason if isinstance(error, Unknown) else f"{error:.1e}"
    return [f"--tolerance: {tolerance:g} was requested, and the error is {words}"]

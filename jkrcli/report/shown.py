"""What files hold, for people and machines: series with their errors, facts and case; archives of fits and sweeps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..base import accuracy, show
from ..series import COLUMNS, Solution
from . import archive
from .result import Several


@dataclass(frozen=True, eq=False)
class Shown(Several):
    """What each file holds: a series, or the summary of an archive."""

    contents: Sequence[Solution | Mapping[str, Any]]

    def summary(self) -> dict[str, Any]:
        return {"files": [_as_dict(item) if isinstance(item, Solution) else item for item in self.contents]}

    @property
    def parts(self) -> Sequence[Sequence[str]]:
        return [_words(item) if isinstance(item, Solution) else archive.words(item) for item in self.contents]


def _as_dict(solution: Solution) -> dict[str, Any]:
    raw = solution.increments
    return {
        "file": str(solution.record.path),
        "method": solution.method,
        "problem_key": solution.problem.key,
        "surface": solution.problem.surface,
        "command_line": solution.record.command_line,
        "rows": raw.a.size,
        "columns": _columns(solution),
        "range": {"a_m": _ends(raw.a), "delta_m": _ends(raw.delta), "P_N": _ends(raw.P)},
        "errors": solution.budget.as_dict(),
        "facts": {name: _plain(value) for name, value in solution.facts.items()},
        "timings_s": dict(solution.timings),
        "versions": dict(solution.record.versions),
        "warnings": list(solution.warnings),
    }


def _words(solution: Solution) -> list[str]:
    raw = solution.increments
    lines = [
        f"{raw.a.size} rows by method {solution.method}, {accuracy(solution.budget.total)}: {solution.record.path}",
        f"  columns   {', '.join(_columns(solution))}",
        f"  a         {show(raw.a[0], 'length')} to {show(raw.a[-1], 'length')}",
        f"  delta     {show(raw.delta[0], 'length')} to {show(raw.delta[-1], 'length')}",
        f"  P         {show(raw.P[0], 'load')} to {show(raw.P[-1], 'load')}",
        f"  surface   {solution.problem.surface}",
        f"  written   by: {solution.record.command_line or 'unknown'}",
    ]
    lines += [f"  warning   {warning}" for warning in solution.warnings]
    lines += [f"  error     {name}: {_number(value)}" for name, value in solution.budget.as_dict().items()]
    lines += [f"  fact      {name}: {_number(_plain(value))}" for name, value in solution.facts.items()]
    lines += [f"  time      {name}: {_seconds(seconds)} s CPU" for name, seconds in solution.timings.items()]
    lines += [f"  version   {name} {version}" for name, version in solution.record.versions.items()]
    return [*lines, "  case", *(f"    {line}" for line in solution.record.toml.splitlines() if line)]


def _columns(solution: Solution) -> list[str]:
    return [name for name in COLUMNS if getattr(solution.filtered, name) is not None]


def _ends(values: Any) -> list[float]:
    return [float(values[0]), float(values[-1])]


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else value


def _seconds(value: Any) -> str:
    return f"{value:.3f}" if isinstance(value, int | float) else str(value)


def _number(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)

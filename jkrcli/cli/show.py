"""``jkr show``: what a series file, an archive of fits or the table of a sweep holds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..base import accuracy
from ..base import show as quantity
from ..case import plain_toml
from ..report import archive
from ..series import COLUMNS, Solution
from .output import answer, json_option
from .series import announce_files, read_series, series_file
from .verb import Verb
from .voice import present, warn


@click.command(cls=Verb)
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--case", "case_only", is_flag=True, help="Print the resolved case alone: a case file that runs again.")
@json_option
def show(files: tuple[Path, ...], case_only: bool, as_json: bool) -> None:
    """Print what each series FILE holds: method, range, error budget, mesh and solver facts, timings, versions.

    Archives of fits and tables of sweeps (.h5) are shown too, checked against the digest they were written under.

    \b
    jkr show data.h5
    jkr show --case data.h5 > again.toml
    """
    announce_files("show", files)
    held = [_held(path, case_only) for path in files]
    if as_json:
        answer({"files": [_as_dict(item) if isinstance(item, Solution) else item for item in held]})
        return
    if case_only:
        click.echo("\n".join(plain_toml(item.record.toml).rstrip() for item in held if isinstance(item, Solution)))
        return
    present(*(_words(item) if isinstance(item, Solution) else archive.words(item) for item in held))


def _held(path: Path, case_only: bool) -> Solution | dict[str, Any]:
    """The series in a file, or the summary of an archive, which has no case."""
    if case_only or not archive.is_archive(path):
        return read_series(series_file(path))
    found = archive.read(path)
    if not found.is_protected:
        warn(f"{path}: {archive.DOUBT}")
    return archive.summary(found)


def _as_dict(solution: Solution) -> dict[str, Any]:
    raw = solution.increments
    return {
        "file": str(solution.record.path),
        "method": solution.method,
        "problem_key": solution.key,
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
        f"  a         {quantity(raw.a[0], 'length')} to {quantity(raw.a[-1], 'length')}",
        f"  delta     {quantity(raw.delta[0], 'length')} to {quantity(raw.delta[-1], 'length')}",
        f"  P         {quantity(raw.P[0], 'load')} to {quantity(raw.P[-1], 'load')}",
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

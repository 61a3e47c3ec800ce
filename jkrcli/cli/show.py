"""``jkr show``: what a series file holds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..base.units import show as quantity
from ..case import store
from ..case.store import Stored
from .output import answer, json_option


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--case", "case_only", is_flag=True, help="Print the resolved case alone: a case file that runs again.")
@json_option
def show(files: tuple[Path, ...], case_only: bool, as_json: bool) -> None:
    """Print what each series FILE holds: method, range, error budget, mesh and solver facts, timings, versions.

    \b
    jkr show data.h5
    jkr show --case data.h5 > again.toml
    """
    held = [store.read(path) for path in files]
    if as_json:
        answer({"files": [_as_dict(stored) for stored in held]})
        return
    for stored in held:
        click.echo(stored.case.rstrip() if case_only else _text(stored))


def _as_dict(stored: Stored) -> dict[str, Any]:
    raw = stored.raw
    return {
        "file": str(stored.path),
        "method": stored.method,
        "problem_key": stored.key,
        "command_line": stored.command_line,
        "rows": raw.a.size,
        "columns": list(stored.columns),
        "range": {"a_m": _ends(raw.a), "delta_m": _ends(raw.delta), "P_N": _ends(raw.P)},
        "errors": stored.budget.as_dict(),
        "facts": {name: _plain(value) for name, value in stored.facts.items()},
        "timings_s": dict(stored.timings),
        "versions": dict(stored.versions),
        "warnings": list(stored.warnings),
    }


def _text(stored: Stored) -> str:
    raw = stored.raw
    lines = [
        f"{stored.path}: {raw.a.size} rows by method {stored.method}, columns {', '.join(stored.columns)}",
        f"  a         {quantity(raw.a[0], 'length')} to {quantity(raw.a[-1], 'length')}",
        f"  delta     {quantity(raw.delta[0], 'length')} to {quantity(raw.delta[-1], 'length')}",
        f"  P         {quantity(raw.P[0], 'load')} to {quantity(raw.P[-1], 'load')}",
        f"  written   by: {stored.command_line or 'unknown'}",
    ]
    lines += [f"  error     {name}: {_number(value)}" for name, value in stored.budget.as_dict().items()]
    lines += [f"  fact      {name}: {_number(_plain(value))}" for name, value in stored.facts.items()]
    lines += [f"  time      {name}: {seconds:.3f} s CPU" for name, seconds in stored.timings.items()]
    lines += [f"  version   {name} {version}" for name, version in stored.versions.items()]
    lines += [f"  warning   {warning}" for warning in stored.warnings]
    lines += ["  case", *(f"    {line}" for line in stored.case.splitlines() if line)]
    return "\n".join(lines)


def _ends(values: Any) -> list[float]:
    return [float(values[0]), float(values[-1])]


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else value


def _number(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)

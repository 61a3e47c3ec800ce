"""``jkr compare``: two results of the same problem."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..base.errors import InputError
from ..report import tables
from ..report.output import PICTURES, Output
from ..series.differences import Difference, curve_differences, series_differences
from .measured import begin_reading
from .options import NumberRange
from .output import answer, output_options
from .series import read_files
from .verb import Verb
from .voice import present

COLUMNS = ("P", "a", "S", "dS")


@click.command(cls=Verb)
@click.argument("first", type=click.Path(path_type=Path))
@click.argument("second", type=click.Path(path_type=Path))
@click.option("--rtol", type=NumberRange(min=0), default=1e-3, show_default=True, help="Largest relative difference.")
@click.option("--column", "columns", multiple=True, type=click.Choice(COLUMNS), help="What counts [default: P].")
@click.option("--overlap", type=NumberRange(0, 1), default=0.9, show_default=True, help="Least common range.")
@click.option("--plot", type=click.Path(path_type=Path), help="Draw the differences (.png or .svg).")
@output_options(force="Replace an existing plot that jkr did not write.", json="Print as JSON.")
@click.pass_context
def compare(
    ctx: click.Context,
    first: Path,
    second: Path,
    rtol: float,
    columns: tuple[str, ...],
    overlap: float,
    plot: Path | None,
    output: Output,
) -> None:
    """Compare two series files (P and a at equal displacement, S and S' at equal radius), or two CSV curves.

    Exit code 1 where a column that counts differs by more than --rtol (CSV curves: every shared column counts).

    \b
    jkr compare fem.h5 layered.h5 --rtol 1e-3
    jkr compare today.h5 yesterday.h5 --rtol 1e-12 --column P --column a
    """
    if plot is not None:
        if plot.suffix not in PICTURES:
            raise InputError(f"--plot: must end in .png or .svg, got {plot}")
        output.file(plot, [first, second])
    found = _curves(first, second) if first.suffix == ".csv" else _series(first, second)
    counting = columns or ("P",)
    judged = [d for d in found if first.suffix == ".csv" or d.column in counting]
    if missing := set(columns) - {d.column for d in found}:
        raise InputError(f"compare: column {sorted(missing)[0]} is not in both files")
    for d in judged:
        if d.coverage < overlap:
            raise InputError(
                f"compare: {first} and {second} share only {d.coverage:.0%} of their range of {d.over}; "
                f"load both as far, or allow it with --overlap {d.coverage:.2f}"
            )
    agree = all(d.worst <= rtol for d in judged)
    if output.json:
        answer(_as_dict(first, second, rtol, found, judged, agree))
    else:
        _print(first, second, rtol, found, judged, agree)
    if plot is not None:
        from ..report import plots
        from ..report.plots.study import differences_figure

        plots.save(differences_figure(found, rtol), [plot])
    ctx.exit(0 if agree else 1)


def _series(first: Path, second: Path) -> list[Difference]:
    _, held = read_files("compare", (first, second))
    one, two = (solution.problem for solution in held)
    for name in ("indenter", "specimen"):
        if getattr(one, name) != getattr(two, name):
            raise InputError(f"{second}: its {name} is not that of {first}; compare results of the same problem")
    return series_differences(*(solution.filtered for solution in held))


def _curves(first: Path, second: Path) -> list[Difference]:
    begin_reading("compare", [first, second])
    return curve_differences(*(tables.read_curve(path) for path in (first, second)))


def _as_dict(
    first: Path, second: Path, rtol: float, found: list[Difference], judged: list[Difference], agree: bool
) -> dict[str, Any]:
    return {
        "first": str(first),
        "second": str(second),
        "rtol": rtol,
        "agree": agree,
        "columns": {
            d.column: {"worst": d.worst, "over": d.over, "at": float(d.x[d.worst_row]), "counts": d in judged}
            for d in found
        },
    }


def _print(
    first: Path, second: Path, rtol: float, found: list[Difference], judged: list[Difference], agree: bool
) -> None:
    lines = [f"{first} against {second}: {'agree' if agree else 'DIFFER'} at rtol {rtol:g}"]
    for d in found:
        counts = "" if d in judged else "  (not counted)"
        where = f"at {d.over} = {d.x[d.worst_row]:.6g}, {d.x.size} rows of {first.name}"
        lines.append(f"  {d.column:<16} worst {d.worst:.3e} {where}{counts}")
    present(lines)

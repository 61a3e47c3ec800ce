"""``jkr sweep``: many cases from one file, to one table."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

from ..base import InputError
from ..case import plain_toml
from ..many.sweep import plan as plans
from ..many.sweep import result as results
from ..many.sweep import running
from ..report import PICTURES, Files, Output
from .options import NumberRange, Parallel, into_folder, output_options, parallel_options
from .verb import verb
from .voice import answer, give, note, progress


@verb("sweep")
@into_folder("Folder [default: <sweep>-results here].")
@parallel_options
@click.option("--hours", type=NumberRange(min=0), default=10.0, show_default=True, help="Most core hours to begin.")
@click.option("--retry-failed", is_flag=True, help="Try the failed cases of an earlier run again.")
@click.option("--only", type=click.IntRange(min=0), metavar="CASE", help="Solve this case alone and print its row.")
@click.option("--show-case", type=click.IntRange(min=0), metavar="CASE", help="Print this case as a case file.")
@output_options(plots="Draw nothing.", json="Print the summary (or the row) as JSON.")
def sweep(
    sweep: Path, output: Output, parallel: Parallel, hours: float, retry_failed: bool, only: int | None,
    show_case: int | None,
) -> None:  # fmt: skip
    """Solve all cases that SWEEP (TOML) makes of a base case; a table with a row per case: CSV, HDF5, Parquet.

    Draws forces (else the first results) over the longest axis, a line per value of the next: table.png, .svg. Run
    again after an interruption it goes on where it stopped; cases that share a solve are solved once.

    \b
    jkr sweep cases/sweeps/gel.toml -o results
    jkr sweep my-sweep.toml -o results --scheduler tcp://node1:8786
    jkr sweep my-sweep.toml --only 17
    jkr sweep my-sweep.toml --show-case 17 > case-17.toml
    """
    plan = plans.load_plan(sweep)
    if show_case is not None:
        click.echo(plain_toml(plan.case(_number(plan, show_case, "--show-case")).to_toml()), nl=False)
    elif only is not None:
        row = running.alone(plan, _number(plan, only, "--only"))
        answer(row.summary()) if output.json else click.echo(str(row))
    else:
        folder = replace(output, where=output.where or Path(f"{sweep.stem}-results")).folder(Path())
        pictures = output.files(folder / results.STEM, PICTURES)
        means = running.Means(*parallel, hours, retry_failed, progress)
        result = running.sweep(plan, folder, means, output.force, note)
        if output.plots and _draw(result, pictures):
            result = replace(result, files=(*result.files, *(pictures[ending] for ending in PICTURES)))
        give(result, output.json, f"  written   {', '.join(map(str, result.files))}")


def _draw(result: results.Swept, pictures: Files) -> bool:
    """Whether the table has a picture; it is written."""
    from ..many.sweep.figure import sweep_figure

    figure = sweep_figure(result.plan, result.columns)
    pictures.write(figure=figure)
    return figure is not None


def _number(plan: plans.Plan, number: int, option: str) -> int:
    if number >= plan.count:
        raise InputError(f"{option}: the cases of {plan.source} are numbered 0 to {plan.count - 1}, got {number}")
    return number

"""``jkr study failures``: where each method is right, refuses, or errs."""

from __future__ import annotations

import datetime
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import click

from ..base.files import check_target, make_folder, write_text
from ..base.table import write_csv
from ..many.study.failures import BUGS, OUTCOMES, TOO_SLOW, Verdict, counts, failures, random_cells
from ..many.study.failures_cells import Cell
from ..methods import METHODS
from ..report import tables
from .parallel import parallel_options, pool_for

PER_CELL = 1.0  # CPU seconds, on average
FIRST = ("method", "outcome", "nu", "a_over_h")


@click.command("failures")
@click.option("--cells", type=click.IntRange(1, 1_000_000), default=2000, show_default=True, help="Random cells.")
@click.option("--seed", type=click.IntRange(0), help="Of the cells [default: today's date as a number].")
@click.option("--methods", multiple=True, type=click.Choice([*METHODS, "slopes"]), help="Only these [default: all].")
@parallel_options
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False), default=Path(), help="Folder.")
@click.option("--no-plots", is_flag=True, help="Write CSV and JSON only.")
@click.option("--force", is_flag=True, help="Replace existing files that jkr did not write.")
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
@click.pass_context
def study_failures(
    ctx: click.Context,
    cells: int,
    seed: int | None,
    methods: tuple[str, ...],
    workers: int | None,
    scheduler: str | None,
    output: Path,
    no_plots: bool,
    force: bool,
    as_json: bool,
) -> None:
    """Solve random problems, from the ordinary to the absurd, and compare each with the exact solution.

    Poisson's ratio to 1/2, contact from a thousandth to a hundred layer thicknesses, contrasts, indenters, few and many
    points, nodes and increments, noise, any units. A cell is right within its stated error, wrong and said so (refused,
    warned, error unknown), too slow (60 CPU s), or silently wrong: that is a bug, and the exit code is then 1.
    Writes failures.csv, .json and per method failures-<method>.png; 2,000 cells take about half an hour.

    \b
    jkr study failures --cells 100 --methods layered
    jkr study failures --seed 1 -o results
    """
    make_folder(output)
    drawn = () if no_plots else (methods or (*METHODS, "slopes"))
    pictures = {method: output / f"failures-{method}.png" for method in drawn}
    targets = {ending: output / f"failures{ending}" for ending in (".csv", ".json")}
    for target in (*targets.values(), *pictures.values()):
        check_target(target, force)
    seed = int(f"{datetime.date.today():%Y%m%d}") if seed is None else seed
    with pool_for(PER_CELL * cells, workers, scheduler) as pool:
        verdicts = failures(random_cells(cells, seed, methods), pool)
    data = as_dict(verdicts, seed)
    write_csv(targets[".csv"], _columns(verdicts))
    write_text(targets[".json"], tables.as_json(data))
    _draw(verdicts, pictures)
    if as_json:
        click.echo(tables.as_json(data).rstrip())
    else:
        _print(verdicts, seed)
        click.echo(f"  written   {output / 'failures'}{{.csv,.json{'' if no_plots else ',-<method>.png'}}}")
    if any(verdict.outcome in BUGS for verdict in verdicts):
        ctx.exit(1)


def _draw(verdicts: Sequence[Verdict], pictures: dict[str, Path]) -> None:
    if not pictures:
        return
    from ..many.study.plots_failures import failures_figure
    from ..report import plots

    seen = {verdict.cell.method for verdict in verdicts}
    for method, target in pictures.items():
        if method in seen:
            plots.save(failures_figure(verdicts, method), target)


def as_dict(verdicts: Sequence[Verdict], seed: int) -> dict[str, Any]:
    """The study as JSON: how many of each outcome by method, and every silently wrong cell with all that makes it."""
    return {
        "format": "jkr-failures",
        "version": 1,
        "seed": seed,
        "counts": counts(verdicts),
        "too_slow": [vars(v.cell) for v in verdicts if v.outcome == TOO_SLOW],
        "bugs": [{"outcome": v.outcome, "words": v.words, "cell": vars(v.cell)} for v in verdicts if v.outcome in BUGS],
    }


def _columns(verdicts: Sequence[Verdict]) -> dict[str, list[Any]]:
    names = [*FIRST, *(field.name for field in fields(Cell) if field.name not in FIRST), "error", "stated", "words"]
    return {name: [_value(verdict, name) for verdict in verdicts] for name in names}


def _value(verdict: Verdict, name: str) -> Any:
    return getattr(verdict, name) if hasattr(verdict, name) else getattr(verdict.cell, name)


def _print(verdicts: Sequence[Verdict], seed: int) -> None:
    click.echo(f"{len(verdicts)} random cells, seed {seed}")
    click.echo(f"  {'method':<13}" + "".join(f"{outcome:>10}" for outcome in OUTCOMES))
    for method, found in counts(verdicts).items():
        click.echo(f"  {method:<13}" + "".join(f"{found[outcome]:>10}" for outcome in OUTCOMES))
    for verdict in verdicts:
        if verdict.outcome in (*BUGS, TOO_SLOW):
            click.echo(f"  {verdict.outcome}: {verdict.words}: {verdict.cell}")

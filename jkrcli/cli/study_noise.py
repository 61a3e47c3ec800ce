"""``jkr study noise``: what noise in the data does to the adhesive curve."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

import click

from ..base.files import check_target, make_folder
from ..base.table import write_csv
from ..many.study.noise import BODIES, METHODS, NOISE, POINTS, Cell, noise_study
from ..report import plots
from .parallel import parallel_options, pool_for

PER_RUN = 0.1  # CPU seconds of one fit


@click.command("noise")
@click.option("--seeds", type=click.IntRange(1, 10_000), default=200, show_default=True, help="Runs per cell.")
@click.option(
    "--body", "bodies", multiple=True, type=click.Choice([body.name for body in BODIES]), help="[default: all]"
)
@click.option("--points", "points", multiple=True, type=click.IntRange(5, 10_000), help=f"[default: {POINTS}]")
@parallel_options
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False), default=Path(), help="Folder.")
@click.option("--force", is_flag=True, help="Replace existing files that jkr did not write.")
def study_noise(
    seeds: int,
    bodies: tuple[str, ...],
    points: tuple[int, ...],
    workers: int | None,
    scheduler: str | None,
    output: Path,
    force: bool,
) -> None:
    """Error of the pull-off force, and coverage of the 90 % band, over noise, points, bodies and slopes.

    Independent relative Gaussian noise on contact radius, displacement and load of exact series.
    Writes noise-study.csv, .png and .svg; 200 seeds take about twenty minutes.

    \b
    jkr study noise --seeds 10 -o results
    """
    make_folder(output)
    targets = {ending: output / f"noise-study{ending}" for ending in (".csv", ".png", ".svg")}
    for target in targets.values():
        check_target(target, force)
    chosen = [body for body in BODIES if not bodies or body.name in bodies]
    runs = seeds * len(chosen) * len(points or POINTS) * len(NOISE) * len(METHODS)
    with pool_for(PER_RUN * runs, workers, scheduler) as pool:
        cells = noise_study(chosen, points or POINTS, NOISE, METHODS, seeds, pool)
    write_csv(targets[".csv"], {item.name: [getattr(cell, item.name) for cell in cells] for item in fields(Cell)})
    from ..many.study.plots_noise import noise_figure

    figure = noise_figure(cells)
    for ending in (".png", ".svg"):
        plots.save(figure, targets[ending])
    _print(cells)
    click.echo(f"  written {output / 'noise-study'}{{.csv,.png,.svg}}")


def _known(value: object) -> bool:
    """Whether there is a figure: not for a band that a method lacks, nor for errors where every run failed."""
    return value is not None and value != math.inf


def _print(cells: Sequence[Cell]) -> None:
    click.echo(
        f"  {'body':<14}{'points':>7}{'noise':>8} {'slopes':<9}{'median':>9}{'worst':>9}{'band':>7}{'failed':>8}"
    )
    for cell in cells:
        band = "" if cell.band is None else f"{cell.band:.0%}"
        median, worst = (f"{error:.1e}" if _known(error) else "-" for error in (cell.median, cell.worst))
        click.echo(
            f"  {cell.body:<14}{cell.points:>7}{cell.noise:>8g} {cell.method:<9}{median:>9}{worst:>9}"
            f"{band:>7}{cell.failures:>8.0%}"
        )

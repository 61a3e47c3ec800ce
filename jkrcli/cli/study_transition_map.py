"""``jkr study transition-map``: the pull-off force on a layer between JKR and DMT."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from ..base.arrays import Array
from ..base.executors import executor
from ..many.study.transition_map import forecast, transition_columns, transition_map
from ..report.output import PICTURES, Output
from .options import check_nu, parallel_options
from .output import answer, into_folder, output_options
from .verb import Verb
from .voice import progress, say, warn

if TYPE_CHECKING:
    from ..report.plots import Figure

SHOWN = ("nu", "w_R2_over_Estar_h3", "mu", "minus_P_over_pi_w_R", "jkr_minus_P_over_pi_w_R", "a_over_h", "c_over_h")

QS, MUS = tuple(np.geomspace(1e-2, 1e2, 13).tolist()), tuple(np.geomspace(0.1, 30, 17).tolist())  # choice: of a map


@click.command("transition-map", cls=Verb)
@click.option("--nu", "nus", type=float, multiple=True, default=(0.499,), show_default=True, help="Repeatable.")
@click.option("--base", type=click.Choice(["bonded", "frictionless"]), default="bonded", show_default=True)
@click.option("--q", "qs", type=float, multiple=True,
              help="Values of w R^2/(E* h^3)  [default: 13 from 0.01 to 100].")  # fmt: skip
@click.option("--mu", "mus", type=float, multiple=True,
              help="Values of stress (R/(E*^2 w))^(1/3)  [default: 17 from 0.1 to 30].")  # fmt: skip
@parallel_options
@into_folder("Folder [default: .].", default=Path())
@output_options(plots="Write the CSV only.", json="Print the table as JSON.")
def study_transition_map(
    nus: tuple[float, ...],
    base: str,
    qs: tuple[float, ...],
    mus: tuple[float, ...],
    workers: int | None,
    scheduler: str | None,
    output: Output,
) -> None:
    """Map the pull-off force of a paraboloid on a layer on a rigid base, in pi w R, over the range of adhesion.

    mu is the Tabor number of that range; the limits are JKR's force on the same layer, and 2 of a long range. Writes
    transition-map.csv, .png and .svg: filled over both axes where there are four values or more of each, else as lines.

    \b
    jkr study transition-map --nu 0.3 --q 1 --mu 0.3 --mu 3 -o map
    """
    check_nu(*nus)
    qs, mus = qs or QS, mus or MUS
    files = output.files(output.folder(Path()) / "transition-map", (".csv", *PICTURES))
    with executor(workers, scheduler, progress, forecast(nus, qs, mus)) as pool:
        points = transition_map(nus, base == "bonded", qs, mus, pool)
    columns = transition_columns(points)
    unknown = [point.reason for point in points if point.reason]
    if unknown:
        warn(f"{len(unknown)} points are not known, the first: {unknown[0]}")
    files.write(columns, figure=files.draw(lambda: _figure(columns)))
    if output.json:
        answer({name: [_known(value) for value in values.tolist()] for name, values in columns.items()})
        return
    say(f"{base} layer on a rigid base, paraboloid: pull-off force in pi w R")
    say(f"  {'nu':>6} {'w R^2/(E* h^3)':>15} {'mu':>6} {'force':>8} {'JKR':>8} {'a/h':>9} {'c/h':>9}")
    for nu, q, mu, pulled, jkr, a, c in zip(*(columns[name] for name in SHOWN), strict=True):
        say(f"  {nu:>6g} {q:>15.4g} {mu:>6g} {pulled:>8.4f} {jkr:>8.4f} {a:>9.4g} {c:>9.4g}")
    say(f"  written {files}")


def _known(value: float | str) -> float | str | None:
    """A number or a word for machines; None for NaN."""
    return None if isinstance(value, float) and math.isnan(value) else value


def _figure(columns: dict[str, Array]) -> Figure:
    from ..report.plots.zones import transition_figure

    return transition_figure(columns)

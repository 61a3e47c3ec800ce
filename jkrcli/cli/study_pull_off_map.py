"""``jkr study pull-off-map``: what layers do to the pull-off force."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from ..base.arrays import Array
from ..base.executors import executor
from ..many.study.pull_off_map import forecast, map_columns, pull_off_map
from ..report.output import PICTURES, Output
from .options import check_nu, parallel_options
from .output import answer, into_folder, output_options
from .verb import Verb
from .voice import progress, say

if TYPE_CHECKING:
    from ..report.plots import Figure

SHOWN = ("nu", "w_R2_over_Estar_h3", "minus_P_over_pi_w_R", "a_over_h")


@click.command("pull-off-map", cls=Verb)
@click.option("--nu", "nus", type=float, multiple=True, default=(0.3, 0.499), show_default=True, help="Repeatable.")
@click.option("--base", type=click.Choice(["bonded", "frictionless"]), default="bonded", show_default=True)
@click.option("--q", "qs", type=float, multiple=True, help="Values of w R^2/(E* h^3) [default: 1e-3 to 1e4].")
@click.option("--beta", type=float, default=0.0, show_default=True,
              help="Surface tension Ups/(E* a0), a0 = (w R^2/E*)^(1/3).")  # fmt: skip
@parallel_options
@into_folder("Folder [default: .].", default=Path())
@output_options(plots="Write the CSV only.", json="Print the table as JSON.")
def study_pull_off_map(
    nus: tuple[float, ...],
    base: str,
    qs: tuple[float, ...],
    beta: float,
    workers: int | None,
    scheduler: str | None,
    output: Output,
) -> None:
    """Map the pull-off force of a paraboloid on a layer on a rigid base, in pi w R, over w R^2/(E* h^3).

    Exact slopes throughout. Writes pull-off-map.csv, .png and .svg.

    \b
    jkr study pull-off-map --nu 0.3 --nu 0.5 -o map
    jkr study pull-off-map --nu 0.45 --q 0.02 --base frictionless
    jkr study pull-off-map --nu 0.5 --q 1 --q 10 --beta 0.1
    """
    check_nu(*nus)
    files = output.files(output.folder(Path()) / "pull-off-map", (".csv", *PICTURES))
    wanted = qs or tuple(10.0 ** (np.arange(-12, 17) / 4))
    with executor(workers, scheduler, progress, forecast(nus, wanted, beta)) as pool:
        columns = map_columns(pull_off_map(nus, base == "bonded", wanted, pool, beta))
    files.write(columns, figure=files.draw(lambda: _figure(columns)))
    if output.json:
        answer({name: values.tolist() for name, values in columns.items()})
        return
    tension = f", surface tension {beta:g} E* a0" if beta else ""
    say(f"{base} layer on a rigid base, paraboloid{tension}: pull-off force in pi w R")
    say(f"  {'nu':>6} {'w R^2/(E* h^3)':>15} {'force':>8} {'a/h':>9}")
    for nu, q, pulled, a in zip(*(columns[name] for name in SHOWN), strict=True):
        say(f"  {nu:>6g} {q:>15.4g} {pulled:>8.4f} {a:>9.4g}")
    say(f"  written {files}")


def _figure(columns: dict[str, Array]) -> Figure:
    from ..report.plots.study import map_figure

    return map_figure(columns)

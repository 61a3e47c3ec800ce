"""``jkr study sticking-map``: what sticking changes on a layer."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..base.arrays import Array
from ..base.executors import executor
from ..many.study.sticking_map import forecast, sticking_map
from ..report.output import PICTURES, Output
from .options import check_nu, parallel_options
from .output import answer, into_folder, output_options
from .verb import Verb
from .voice import progress, say

if TYPE_CHECKING:
    from ..report.plots import Figure

NUS = (0.0, 0.3, 0.45, 0.49, 0.499, 0.5)
RATIOS = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 10 / 3, 5.0, 10.0)


@click.command("sticking-map", cls=Verb)
@click.option("--nu", "nus", type=float, multiple=True, default=NUS, show_default=True, help="Repeatable.")
@click.option("--ratio", "ratios", type=float, multiple=True, help="Values of a/h [default: 0.05 to 10].")
@parallel_options
@into_folder("Folder [default: .].", default=Path())
@output_options(plots="Write the CSV only.", json="Print the table as JSON.")
def study_sticking_map(
    nus: tuple[float, ...], ratios: tuple[float, ...], workers: int | None, scheduler: str | None, output: Output
) -> None:
    """Map what sticking changes under a paraboloid on a layer that is bonded to a rigid base, over a/h.

    S at equal contact radius, and the load at the depth where the sliding contact has that radius; sticking over
    sliding. Writes sticking-map.csv, .png and .svg.

    \b
    jkr study sticking-map -o map
    jkr study sticking-map --nu 0.499 --ratio 3.333
    """
    check_nu(*nus)
    files = output.files(output.folder(Path()) / "sticking-map", (".csv", *PICTURES))
    ratios = ratios or RATIOS
    with executor(workers, scheduler, progress, forecast(nus, ratios)) as pool:
        columns = sticking_map(nus, ratios, pool)
    files.write(columns, figure=files.draw(lambda: _figure(columns)))
    if output.json:
        answer({name: values.tolist() for name, values in columns.items()})
        return
    say("paraboloid on a bonded layer: sticking over sliding")
    say(f"  {'nu':>6} {'a/h':>8} {'S':>8} {'load at equal depth':>20}")
    for nu, ratio, S, load in zip(*(columns[n] for n in ("nu", "a_over_h", "S_ratio", "load_ratio")), strict=True):
        say(f"  {nu:>6g} {ratio:>8.4g} {S:>8.4f} {load:>20.4f}")
    say(f"  written {files}")


def _figure(columns: dict[str, Array]) -> Figure:
    from ..report.plots.study import sticking_figure

    return sticking_figure(columns)

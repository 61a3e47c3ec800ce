"""``jkr study rate-map``: what speed does to pull-off on a half-space and on layers."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..adhesion.rate.laws import rate_law_of
from ..base.arrays import Array
from ..base.errors import InputError
from ..base.executors import executor
from ..many.study.rate_map import forecast, rate_columns, rate_map
from ..report.output import PICTURES, Output
from .cycle_rate import PairsType
from .options import check_nu, parallel_options
from .output import answer, into_folder, output_options
from .verb import Verb
from .voice import progress, say

if TYPE_CHECKING:
    from ..report.plots import Figure


SPEEDS = tuple(10.0 ** (i / 2) for i in range(-8, 5))


@click.command("rate-map", cls=Verb)
@click.option("--rate", type=PairsType(), default="n=0.6", show_default=True,
              help="The law in units of w0 and v0: n=0.6; law=log,b=0.3.")  # fmt: skip
@click.option("--thickness", "thicknesses", type=float, multiple=True, default=(0.3,), show_default=True,
              help="Of a bonded layer on a rigid base, in R; repeatable.")  # fmt: skip
@click.option("--nu", type=float, default=0.3, show_default=True, help="Poisson's ratio of the layers.")
@click.option("--stiffness", "stiffnesses", multiple=True, default=("rigid", "1"), show_default=True,
              help='Of the device, in E* R; "rigid"; repeatable.')  # fmt: skip
@click.option("--speed", "speeds", type=float, multiple=True, help="Of the device, in v0 [default: 1e-4 to 100].")
@parallel_options
@into_folder("Folder [default: .].", default=Path())
@output_options(plots="Write the CSV only.", json="Print the table as JSON.")
def study_rate_map(
    rate: dict[str, str],
    thicknesses: tuple[float, ...],
    nu: float,
    stiffnesses: tuple[str, ...],
    speeds: tuple[float, ...],
    workers: int | None,
    scheduler: str | None,
    output: Output,
) -> None:
    """Map pull-off force and energy lost over the device's speed, its stiffness and the body.

    A paraboloid with E* = R = w0 = v0 = 1 goes back from equilibrium at no load: on a half-space, and beside it on
    bonded layers of the given thickness (in R). Writes rate-map.csv, .png and .svg.

    \b
    jkr study rate-map --rate n=0.6 --thickness 0.3 -o map
    jkr study rate-map --rate law=log,b=0.3 --stiffness rigid --speed 0.01 --speed 1
    """
    check_nu(nu)
    law = rate_law_of({"v0": 1.0} | rate, "--rate")
    devices = [_stiffness(text) for text in stiffnesses]
    files = output.files(output.folder(Path()) / "rate-map", (".csv", *PICTURES))
    speeds = speeds or SPEEDS
    with executor(workers, scheduler, progress, forecast(thicknesses, devices, speeds)) as pool:
        columns = rate_columns(rate_map(law, thicknesses, nu, devices, speeds, pool))
    files.write(columns, figure=files.draw(lambda: _figure(columns)))
    if output.json:
        answer({name: [x if math.isfinite(x) else None for x in values.tolist()] for name, values in columns.items()})
        return
    say("paraboloid, E* = R = w0 = v0 = 1: pull-off force in pi w0 R, energy in w0 pi a^2 at no load")
    say(f"  {'h/R':>8} {'k/(E* R)':>9} {'V/v0':>10} {'force':>9} {'energy':>9}")
    for row in zip(*list(columns.values())[:5], strict=True):
        h, k, V, force, energy = row
        say(f"  {h:>8.3g} {k:>9.3g} {V:>10.4g} {force:>9.4f} {energy:>9.4g}")
    say(f"  written {files}")


def _stiffness(text: str) -> float:
    try:
        value = math.inf if text == "rigid" else float(text)
    except ValueError:
        value = math.nan
    if not value > 0:
        raise InputError(f'--stiffness: must be a number > 0 in E* R, or "rigid", got "{text}"')
    return value


def _figure(columns: dict[str, Array]) -> Figure:
    from ..report.plots.rate import rate_map_figure

    return rate_map_figure(columns)

"""``jkr study adhesion-map``: which model of adhesion holds on a layer, over range and load."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from ..base.executors import executor
from ..many.study.adhesion_map import ZONES, AdhesionMap, adhesion_map, forecast
from ..report.output import PICTURES, Output
from .options import check_nu
from .output import answer, into_folder, output_options
from .verb import Verb
from .voice import progress, say

if TYPE_CHECKING:
    from ..report.plots import Figure

MUS, LOADS = (0.02, 50.0, 29), (0.1, 100.0, 31)  # choice: ends and number of the values on logarithmic axes


@click.command("adhesion-map", cls=Verb)
@click.option("--nu", type=float, default=0.499, show_default=True)
@click.option("--base", type=click.Choice(["bonded", "frictionless"]), default="bonded", show_default=True)
@click.option("--q", type=float, default=1.0, show_default=True, help="w R^2/(E* h^3); 1e-4: a half-space.")
@click.option("--mu", "mus", type=float, multiple=True,
              help="Values of stress (R/(E*^2 w))^(1/3)  [default: 29 from 0.02 to 50].")  # fmt: skip
@click.option("--load", "loads", type=float, multiple=True, help="Loads over pi w R  [default: 31 from 0.1 to 100].")
@into_folder("Folder [default: .].", default=Path())
@output_options(plots="Write the CSV only.", json="Print the table as JSON.")
def study_adhesion_map(
    nu: float, base: str, q: float, mus: tuple[float, ...], loads: tuple[float, ...], output: Output
) -> None:
    """Map which model of adhesion holds for a paraboloid on a layer on a rigid base: Hertz, JKR, DMT, rigid bodies, or
    the transition that needs a finite range.

    After Johnson and Greenwood: 5 % is little, 20 times the range is far. Writes adhesion-map.csv, .png and .svg.

    \b
    jkr study adhesion-map --nu 0.499 --q 100 -o map
    """
    check_nu(nu)
    if not 0 < q < np.inf:
        raise click.BadParameter(f"must be > 0, got {q:g}", param_hint="--q")
    files = output.files(output.folder(Path()) / "adhesion-map", (".csv", *PICTURES))
    mus = mus or _log(MUS)
    with executor(1, progress=progress, seconds=forecast(mus)) as pool:
        found = adhesion_map(nu, base == "bonded", q, mus, loads or _log(LOADS), pool)
    files.write(found.columns(), figure=files.draw(lambda: _figure(found)))
    if output.json:
        answer({name: values.tolist() for name, values in found.columns().items()})
        return
    say(f"{base} layer on a rigid base, paraboloid, nu = {nu:g}, w R^2/(E* h^3) = {q:g}: what holds")
    say("  load over pi w R | mu: " + ", ".join(f"{mu:.3g}" for mu in found.mus))
    letters = np.array([zone[0] for zone in ZONES])
    for load, row in zip(found.loads[::-1], found.zone[::-1], strict=True):
        say(f"  {load:>16.3g} | {''.join(letters[row])}")
    say("  " + ", ".join(f"{zone[0]}: {zone}" for zone in ZONES))
    say(f"  written {files}")


def _log(ends: tuple[float, float, int]) -> tuple[float, ...]:
    return tuple(np.geomspace(*ends).tolist())


def _figure(found: AdhesionMap) -> Figure:
    from ..report.plots.zones import adhesion_figure

    return adhesion_figure(found.mus, found.loads, found.zone, ZONES, f"ν = {found.nu:g}, w R²/(E* h³) = {found.q:g}")

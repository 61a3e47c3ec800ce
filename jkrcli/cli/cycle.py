"""``jkr cycle``: the trace that a device of given stiffness records."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import click

from ..adhesion.device import control
from ..adhesion.law import AskedRange
from ..adhesion.stability import cycle as run_cycle
from ..adhesion.stability import trace, turning_radius
from ..base.errors import InputError
from ..base.units import show
from ..base.unknown import Unknown
from ..beside.analysis import Analysis, analyse, with_solved_points
from ..methods.guards import Limits
from ..report import cycle as report
from ..report.output import PICTURES, Files, Output
from .cycle_rate import RateOptions, Turn, rate_options, run
from .measured import TUNING, begin_reading
from .options import (
    ControlType,
    LengthType,
    LoadType,
    WorkType,
    limits_options,
    modulus_factor_option,
    range_options,
    slopes_option,
)
from .output import answer, into_folder, output_options
from .series import begin_curves, read_series, series_file, works_of
from .verb import Verb
from .voice import say


@click.command(cls=Verb)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--w-approach", type=WorkType(), help="While the contact grows [default: the case's first w].")
@click.option("--w-retract", type=WorkType(), help="While it shrinks, not smaller [default: that of approach].")
@click.option(
    "--stiffness", type=ControlType(), default="rigid", show_default=True, help='"0.2 N/m", "rigid" or "load".'
)
@click.option("--to-load", type=LoadType(), help="Turn at this load [default: at the end of the series].")
@click.option("--to-depth", type=LengthType(), help="Turn at this displacement delta.")
@rate_options
@click.option("--points", type=click.IntRange(2, 100_000), default=200, show_default=True, help="Rows per branch.")
@range_options
@slopes_option
@modulus_factor_option
@limits_options
@into_folder()
@output_options(plots="Write the CSV only.", json="Print the figures as JSON.")
def cycle(
    file: Path,
    w_approach: float | None,
    w_retract: float | None,
    stiffness: float,
    to_load: float | None,
    to_depth: float | None,
    points: int,
    stress: float | None,
    length: float | None,
    slopes: str,
    modulus_factor: float,
    rates: RateOptions,
    limits: Limits,
    output: Output,
) -> None:
    """Trace what a device records that presses the bodies of FILE, a case or a series, together and pulls them apart
    again.

    JKR forces have no range: contact jumps in where the undeformed gap closes (delta = 0) and out where
    d(delta + P/stiffness)/da = 0. A rigid device is displacement control. With --rate over time: the edge recedes as
    fast as G/w0 says, rests between the works of adhesion, advances at once (--stress is then the cohesive stress of
    the dissipating zone). Else with --stress or --range the surfaces attract each other before they touch. Writes
    <stem>-cycle.csv, .png and .svg.

    \b
    jkr cycle data.h5 --stiffness "10 kN/m"
    jkr cycle gel.h5 --w-approach "35 mJ/m^2" --w-retract "45 mJ/m^2" --to-load "0.5 mN"
    jkr cycle gel.h5 --rate v0="1 um/s",n=0.6 --speed "10 um/s" --to-load "0.5 mN"
    """
    if to_load is not None and to_depth is not None:
        raise InputError("cycle: give at most one of --to-load and --to-depth")
    file = series_file(file)
    solution = read_series(file)
    approach = works_of(solution, "--w-approach")[0] if w_approach is None else w_approach
    works = approach, approach if w_retract is None else w_retract
    if rates.rate is not None:  # there the stress is that of the zone in which energy is lost
        rates, stress = replace(rates, stress=stress), None
    asked = AskedRange.of(solution.record, stress, length)
    if asked and rates.rate is not None:
        raise InputError("cycle: --rate goes with adhesion without a range: leave --range and the case's out")
    if asked and works[0] != works[1]:
        raise InputError(
            "cycle: adhesion of finite range loses energy in its jumps alone: give one work of adhesion, got "
            f"{show(works[0], 'work')} on approach and {show(works[1], 'work')} on retraction"
        )
    if rates.program is not None:
        per_row = TUNING.cycle_per_row + TUNING.cycle_per_point * points
        begin_reading("cycle --program", [rates.program], limits, "fewer rows of the program, or fewer --points",
                      per_row=per_row, mib_per_row=TUNING.cycle_mib_per_row)  # fmt: skip
    stem = output.folder(file.parent) / f"{file.stem}-cycle{asked.suffix}"
    targets = output.files(stem, (".csv", *PICTURES), [file])
    begin_curves("cycle", [solution], [works], [asked], limits)
    curves = analyse(solution, works, slopes, modulus_factor, asked)
    results = [with_solved_points(curve, stiffness) for curve in curves]
    if rates.rate is not None:
        run(file, results, stiffness, Turn(to_load, to_depth), points, rates, targets, output)
        return
    _quasi_static(file, results, stiffness, Turn(to_load, to_depth), points, targets, output)


def _quasi_static(
    file: Path, curves: Sequence[Analysis], stiffness: float, turn: Turn, points: int, targets: Files, output: Output
) -> None:
    """Trace, figure and summary of equilibrium states; ``curves``: those of approach and of retraction."""
    inwards, outwards = (result.curve for result in curves)
    radius = None
    if turn.load is not None or turn.depth is not None:
        radius = turning_radius(inwards, stiffness, load=turn.load, depth=turn.depth)
    found = run_cycle(inwards, outwards, stiffness, radius)
    if isinstance(found, Unknown):
        raise InputError(f"{file}: {found.reason}")
    columns = trace(found, points)
    figure = None
    if output.plots:
        from ..report.plots.curve import cycle_figure

        figure = cycle_figure(columns, control(stiffness))
    targets.write(columns, figure=figure)
    if output.json:
        answer(report.summary(file, found))
    else:
        say("\n".join([*report.words(file, found), f"  written {targets}"]))

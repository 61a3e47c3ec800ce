"""``jkr cycle``: the trace that a device of given stiffness records."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

from ..adhesion import AskedRange
from ..base import InputError, show
from ..beside.analysis import Analysis, analyse, with_solved_points
from ..methods.guards import Limits
from ..report.cycle import Cycled, CycledByProgram
from ..report.output import PICTURES, Files, Output
from ..report.result import Result
from ..series import Solution
from .cycle_rate import RateOptions, Turn, rate_options, read_program, run
from .cycle_relaxing import limits_of
from .cycle_relaxing import run as run_relaxing
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
from .voice import present, warn


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
    the dissipating zone). Else with --stress or --range the surfaces attract each other before they touch. A specimen
    that relaxes is followed over time without adhesion (w = 0); with adhesion its limits are traced, very fast and
    very slow cycles. Writes <stem>-cycle.csv, .png and .svg.

    \b
    jkr cycle data.h5 --stiffness "10 kN/m"
    jkr cycle gel.h5 --w-retract "45 mJ/m^2" --to-load "0.5 mN"
    jkr cycle gel.h5 --rate v0="1 um/s",n=0.6 --speed "10 um/s"
    jkr cycle relaxing-gel.h5 --w-approach 0 --speed "10 um/s" --hold "30 s"
    """
    turn = _turn(to_load, to_depth, rates)
    file = series_file(file)
    solution = read_series(file)
    law = solution.problem.specimen.relaxation
    if law is None:
        rates.refuse_without_time()
    works = _works(solution, w_approach, w_retract)
    shares = limits_of(law, rates) if law is not None and any(works) else {"": 1.0}
    if rates.rate is not None:  # there the stress is that of the zone in which energy is lost
        rates, stress = replace(rates, stress=stress), None
    asked = AskedRange.of(solution.record, stress, length)
    if asked:
        _refuse_range(rates, works)
    if rates.program is not None:
        per_row = TUNING.cycle_per_row + TUNING.cycle_per_point * points
        begin_reading("cycle --program", [rates.program], limits, "fewer rows of the program, or fewer --points",
                      per_row=per_row, mib_per_row=TUNING.cycle_mib_per_row)  # fmt: skip
    stem = output.folder(file.parent) / f"{file.stem}-cycle{asked.suffix}"
    named = [stem.with_name("-".join([stem.name, *name.split()])) for name in shares]
    targets = [output.files(one, (".csv", *PICTURES), [file]) for one in named]
    begin_curves("cycle", [solution], [works], [asked], limits)
    told: list[Result] = []
    for share, files in zip(shares.values(), targets, strict=True):
        curves = analyse(solution, works, slopes, modulus_factor * share, asked)
        results = [with_solved_points(curve, stiffness) for curve in curves]
        if law is not None and not any(works):
            told.append(run_relaxing(results[0], law, stiffness, turn, points, rates))
        else:
            told.append(_traced(results, stiffness, turn, points, rates))
        files.write(told[-1].columns, figure=files.draw(told[-1].figure))
    _tell(file, dict(zip(shares.items(), told, strict=True)), targets, output.json)


def _turn(to_load: float | None, to_depth: float | None, rates: RateOptions) -> Turn:
    """Where the device turns; InputError where that is said twice."""
    if rates.program is not None and not to_load is to_depth is None:
        raise InputError("cycle: give either --program or a turn (--to-load, --to-depth)")
    if to_load is not None and to_depth is not None:
        raise InputError("cycle: give at most one of --to-load and --to-depth")
    return Turn(to_load, to_depth)


def _refuse_range(rates: RateOptions, works: tuple[float, float]) -> None:
    """InputError where adhesion of finite range is asked to lose energy otherwise than in its jumps."""
    if rates.rate is not None:
        raise InputError("cycle: --rate has no adhesion of finite range: leave --range and the case's out")
    if works[0] != works[1]:
        raise InputError(
            "cycle: adhesion of finite range loses energy in its jumps alone: give one work of adhesion, got "
            f"{show(works[0], 'work')} on approach and {show(works[1], 'work')} on retraction"
        )


def _traced(results: list[Analysis], stiffness: float, turn: Turn, points: int, rates: RateOptions) -> Result:
    """The trace of bodies that do not relax: with speeds, by a table, or there and back."""
    if rates.rate is not None:
        return run(results, stiffness, turn, points, rates)
    if rates.program is not None:
        return CycledByProgram.of(results, stiffness, read_program(rates.program, stiffness), points)
    return Cycled.of(results, stiffness, turn.load, turn.depth, points)


def _works(solution: Solution, approach: float | None, retract: float | None) -> tuple[float, float]:
    """The works of adhesion [J/m^2] of approach and retraction; of a specimen that relaxes 0 where none is named."""
    if approach is None:
        free = solution.problem.specimen.relaxation is not None and not solution.record.w
        approach = 0.0 if free else works_of(solution, "--w-approach")[0]
    return approach, approach if retract is None else retract


def _tell(file: Path, told: dict[tuple[str, float], Result], targets: list[Files], json: bool) -> None:
    """Print what was found: once, or for each limit by its name and its share of the moduli."""
    found = {name: {"moduli": share} | item.summary() for (name, share), item in told.items()}
    if json:
        answer(next(iter(told.values())).summary() if "" in found else {"file": str(file), "limits": found})
    for ((name, share), item), files in zip(told.items(), targets, strict=True):
        if not json:
            head = [f"limit of {name} cycles, the moduli times {share:.4g}:"] if name else []
            present([*head, *item.words()], last=f"  written {files}")
        for line in item.warnings:
            warn(f"{file}: {line}")

"""``jkr cycle``: the trace that a device of given stiffness records."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

from ..adhesion import DISPLACEMENT_CONTROL, LOAD_CONTROL, LoadingHistory, Rest
from ..base import InputError, show
from ..beside import Analysis, analyse, curves_from_rest, rest_of, with_solved_points
from ..methods import Limits
from ..report import PICTURES, Cycled, CycledByProgram, CycledInLimits, Output, Result, traced_histories
from ..series import Solution
from .cycle_rate import RateOptions, rate_options, read_program, run, run_relaxing
from .measured import TUNING, begin_reading
from .options import (
    CONTROL,
    LENGTH,
    LOAD,
    WORK,
    CurveOptions,
    curve_options,
    into_folder,
    limits_options,
    output_options,
)
from .series import begin_curves, read_series, series_file, works_of
from .verb import verb
from .voice import give


@verb("file")
@click.option("--w-approach", type=WORK, help="While the contact grows [default: the case's first w].")
@click.option("--w-retract", type=WORK, help="While it shrinks, not smaller [default: that of approach].")
@click.option("--stiffness", type=CONTROL, default="rigid", show_default=True,
              help='"0.2 N/m", "rigid" or "load".')  # fmt: skip
@rate_options
@click.option("--rest-load", type=LOAD, help="Viscoelastic specimens: at rest under this load, then pulled at once "
              "[default: at the turn of --to-load or --to-depth, else at P = 0].")  # fmt: skip
@click.option("--rest-depth", type=LENGTH, help="The same at this displacement delta.")
@click.option("--points", type=click.IntRange(2, 100_000), default=200, show_default=True, help="Rows per branch.")
@curve_options
@limits_options
@into_folder()
@output_options(plots="Write the CSV only.", json="Print the figures as JSON.")
def cycle(
    file: Path, w_approach: float | None, w_retract: float | None, stiffness: float, points: int, how: CurveOptions,
    rates: RateOptions, rest_load: float | None, rest_depth: float | None, limits: Limits, output: Output,
) -> None:  # fmt: skip
    """Trace what a device records that presses the bodies of FILE, a case or a series, together and pulls them apart
    again.

    JKR forces have no range: contact jumps in where the undeformed gap closes (delta = 0) and out where
    d(delta + P/stiffness)/da = 0. A rigid device is displacement control. With --rate over time: the edge recedes as
    fast as G/w0 says, rests between the works of adhesion, advances at once (--stress is then the cohesive stress of
    the dissipating zone). Else with --stress or --range the surfaces attract each other before they touch. A specimen
    that relaxes is followed over time without adhesion (w = 0); with adhesion very fast and very slow cycles are
    traced, and one that is loaded slowly, rests and is pulled at once. Writes <stem>-cycle.csv, .png and .svg; the
    options that are given are added to the name in SI, as in <stem>-cycle-w-retract0.045-to-load0.0005.csv.

    \b
    jkr cycle data.h5 --stiffness "10 kN/m"
    jkr cycle gel.h5 --w-retract "45 mJ/m^2" --to-load "0.5 mN"
    jkr cycle gel.h5 --rate v0="1 um/s",n=0.6 --speed "10 um/s"
    jkr cycle relaxing-gel.h5 --w-approach 0 --speed "10 um/s" --hold "30 s"
    """
    rates.refuse_wrong(stiffness)
    output.folder(Path())
    file = series_file(file)
    solution = read_series(file)
    law = solution.problem.specimen.relaxation
    if law is None:
        rates.refuse_without_time()
    works = _works(solution, w_approach, w_retract)
    in_limits = law is not None and any(works)
    if in_limits:
        rates.refuse_in_limits()
    if rates.rate is not None:  # there the stress is that of the zone in which energy is lost
        rates, how = replace(rates, stress=how.stress), replace(how, stress=None)
    ranged = how.of(solution)
    if ranged:
        _refuse_range(rates, works)
    _begin_program(rates.program, points, limits)
    rest, known = rest_of(rest_load, rest_depth), tuple[LoadingHistory, ...]()
    if in_limits:
        rests = rates.rate is None and not ranged
        known = traced_histories(solution, rest, rates.to_load, rates.to_depth, rests)
    elif rest is not None:
        raise InputError(
            "cycle: --rest-load and --rest-depth are for adhesion on a specimen that relaxes: leave them out"
        )
    names = [one.name for one in known] or [""]
    ends = f"{_told(w_approach, w_retract, stiffness)}{rates.suffix(stiffness)}{_told_rest(rest)}{ranged.suffix}"
    if rates.stress is not None:
        ends += f"-stress{rates.stress:g}"
    factor = "" if how.modulus_factor == 1 else f"-modulus{how.modulus_factor:g}"
    stem = output.folder(file.parent) / f"{file.stem}-cycle{ends}{factor}"
    named = [stem.with_name("-".join([stem.name, *name.split()])) for name in names]
    targets = [output.files(one, (".csv", *PICTURES), [file]) for one in named]
    begin_curves("cycle", [solution], [works], limits, [ranged])

    def after(history: LoadingHistory) -> Result:
        if history.rest is None:
            return cycled(history.moduli, history.words)
        curves = curves_from_rest(solution, works, history, how.slopes, how.modulus_factor, stiffness)
        return Cycled.from_rest(solution.record.path, *curves, stiffness, points, history.words)

    def cycled(share: float = 1.0, history: str = "") -> Result:
        curves = analyse(solution, works, how.slopes, how.modulus_factor * share, ranged)
        results = [with_solved_points(curve, stiffness) for curve in curves]
        if law is not None and not in_limits:
            return run_relaxing(results[0], law, stiffness, points, rates)
        return _traced(results, stiffness, points, rates, history)

    result = CycledInLimits.of(file, known, after) if known else cycled()
    cycles = [one for _, one in result.limits.values()] if isinstance(result, CycledInLimits) else [result]
    for one, files in zip(cycles, targets, strict=True):
        files.write(one.columns, figure=files.draw(one.figure))
    give(result, output.json, f"  written {', '.join(map(str, targets))}", file)


def _told(approach: float | None, retraction: float | None, stiffness: float) -> str:
    """What distinguishes names of files, of works of adhesion [J/m^2] and a ``stiffness`` [N/m] that were given."""
    works = (("approach", approach), ("retract", retraction))
    parts = [f"-w-{name}{w:g}" for name, w in works if w is not None]
    if stiffness == LOAD_CONTROL:
        parts.append("-stiffness-load")
    elif stiffness != DISPLACEMENT_CONTROL:
        parts.append(f"-stiffness{stiffness:g}")
    return "".join(parts)


def _told_rest(rest: Rest | None) -> str:
    """The same of a rest."""
    if rest is None:
        return ""
    return f"-rest-load{rest.load:g}" if rest.depth is None else f"-rest-depth{rest.depth:g}"


def _begin_program(program: Path | None, points: int, limits: Limits) -> None:
    """Say what it takes to follow a ``program``, if there is one, with so many rows for each of its own."""
    if program is not None:
        per_row = TUNING.cycle_per_row + TUNING.cycle_per_point * points
        begin_reading("cycle --program", [program], limits, "fewer rows of the program, or fewer --points",
                      per_row=per_row, mib_per_row=TUNING.cycle_mib_per_row)  # fmt: skip


def _refuse_range(rates: RateOptions, works: tuple[float, float]) -> None:
    """InputError where adhesion of finite range would lose energy otherwise than in its jumps."""
    if rates.rate is not None:
        raise InputError("cycle: --rate has no adhesion of finite range: leave --range and the case's out")
    if works[0] != works[1]:
        raise InputError(
            "cycle: adhesion of finite range loses energy in its jumps alone: give one work of adhesion, got "
            f"{show(works[0], 'work')} on approach and {show(works[1], 'work')} on retraction"
        )


def _traced(results: list[Analysis], stiffness: float, points: int, rates: RateOptions, history: str) -> Result:
    """The trace of bodies that do not relax: with speeds, by a table, or there and back."""
    if rates.rate is not None:
        return run(results, stiffness, points, rates, history)
    if rates.program is not None:
        return CycledByProgram.of(results, stiffness, read_program(rates.program, stiffness), points)
    return Cycled.of(results, stiffness, rates.to_load, rates.to_depth, points, history)


def _works(solution: Solution, approach: float | None, retract: float | None) -> tuple[float, float]:
    """The works of adhesion [J/m^2] of approach and retraction; of a specimen that relaxes 0 where none is named."""
    if approach is None:
        free = solution.problem.specimen.relaxation is not None and not solution.record.w
        approach = 0.0 if free else works_of(solution, "--w-approach")[0]
    return approach, approach if retract is None else retract

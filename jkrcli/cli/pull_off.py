"""``jkr pull-off``: where contact is lost, under every control; and the work of adhesion behind a measured pull-off."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import click

from ..adhesion import DISPLACEMENT_CONTROL, LOAD_CONTROL, Rest
from ..base import InputError
from ..beside import (
    checked_histories,
    effect_on,
    lost_by_history,
    rest_of,
    seconds_of_histories,
    sticking_warnings,
    where_lost,
)
from ..bodies import relaxing
from ..methods import Limits
from ..report import MeasuredByHistory, MeasuredPullOff, PullOff, Result, Results
from ..series import Solution
from .body import Flags, body_options, by_flags, case_of
from .options import CONTROL, LENGTH, LOAD, NAMED, WORK, CurveOptions, curve_options, json_option, limits_options
from .series import begin_curves, read_files, without_range, works_of
from .verb import verb
from .voice import give

SEARCHED = (0.05,) * 10  # works of adhesion [J/m^2] that are tried for that of a measured force; choice: for forecasts


@verb("[files...]", "pull-off")
@body_options
@click.option("--w", "works", multiple=True, type=WORK, help='J/m^2 or "35 mJ/m^2" [default: the case\'s].')
@click.option("--stiffness", "stiffnesses", multiple=True, type=CONTROL,
              help='Of the machine or cantilever, "0.2 N/m"; also "load" and "rigid" [default: these two].'
)  # fmt: skip
@click.option("--load", "force", type=LOAD, help='A measured pull-off force, "12 uN": which w does it mean?')
@click.option("--uncertain", multiple=True, type=NAMED,
              help="With --load: standard deviation of load, R, E, h, nu or E:LAYER, such as load=5%, h=1um."
)  # fmt: skip
@click.option("--rest-load", type=LOAD, help="Viscoelastic specimens: at rest under this load, then pulled at once "
              "[default: at rest at P = 0].")  # fmt: skip
@click.option("--rest-depth", type=LENGTH, help="The same at this displacement delta.")
@curve_options
@limits_options
@json_option
def pull_off(
    files: tuple[Path, ...], works: tuple[float, ...], stiffnesses: tuple[float, ...], force: float | None,
    uncertain: tuple[tuple[str, str], ...], rest_load: float | None, rest_depth: float | None, how: CurveOptions,
    limits: Limits, flags: Flags, as_json: bool,
) -> None:  # fmt: skip
    """Say where contact is lost in each FILE, a case or a series, or on the body by flags (--radius, --E, --nu,
    --thickness ...): under load control, displacement control, devices of a stiffness.

    For each work of adhesion and control: pull-off, jump-in at first touch, every other critical point, energy lost
    per approach-retract cycle and work of separation. With --load the other way round: the work of adhesion that a
    measured pull-off force means on this body (under load control, or of each --stiffness). A viscoelastic specimen has
    several: very fast and very slow cycles, at rest and then pulled at once, and the most after any other history.

    \b
    jkr pull-off my.toml --w "50 mJ/m^2" --stiffness "10 N/m"
    jkr pull-off --radius "5 um" --E "1 MPa" --nu 0.5 --thickness "8 um" \\
            --w "50 mJ/m^2"
    jkr pull-off gel.h5 --load "1.2 mN" --uncertain load=3% --uncertain R=1%
    """
    if force is not None and works:
        raise InputError("pull-off: give either --w or --load, not both")
    if uncertain and force is None:
        raise InputError("pull-off: --uncertain says how well a measured force and its body are known: give --load too")
    if force is not None and (how.stress, how.length) != (None, None):
        raise InputError("pull-off: --load asks for the w of JKR: give neither --stress nor --range with it")
    if force == 0:
        raise InputError("pull-off: --load must not be 0; give the measured pull-off force")
    rest = rest_of(rest_load, rest_depth)
    if by_flags("pull-off", flags, files):
        solutions = [_by_flags(flags, works, force, stiffnesses, how)]
    elif files:
        _, solutions = read_files("pull-off", files)
    else:
        raise InputError("pull-off: give FILES, a case or a series, or the body by flags: --radius, --E, --nu")
    if force is not None:
        give(_means(solutions, abs(force), stiffnesses, uncertain, rest, how, limits), as_json)
        return
    for solution in solutions:
        checked_histories(solution, rest)
    ranges = list(map(how.of, solutions))
    wanted = [works or works_of(solution) for solution in solutions]
    histories = sum(seconds_of_histories(*each, len(stiffnesses)) for each in zip(solutions, wanted, strict=True))
    begin_curves("pull-off", solutions, wanted, limits, ranges, devices=len(stiffnesses), beside=histories)
    curves = [one for solution, some, ranged in zip(solutions, wanted, ranges, strict=True)
             for one in where_lost(solution, some, stiffnesses, how.slopes, how.modulus_factor, ranged)]  # fmt: skip
    controls = stiffnesses or (LOAD_CONTROL, DISPLACEMENT_CONTROL)
    results = [PullOff(*one, lost_by_history(one[0], controls, rest, how.slopes)) for one in curves]
    give(Results(results, list(dict.fromkeys(text for one in results for text in one.warnings))), as_json)


def _means(
    solutions: Sequence[Solution], force: float, stiffnesses: Sequence[float], uncertain: Sequence[tuple[str, str]],
    rest: Rest | None, how: CurveOptions, limits: Limits,
) -> Results:  # fmt: skip
    """The work of adhesion that a measured ``force`` [N] means on each body under each control."""
    from ..identification.work_of_adhesion import measured_work, seconds_of_inputs, works_by_history

    controls, names = stiffnesses or (LOAD_CONTROL,), [name for name, _ in uncertain]
    for solution in solutions:
        without_range(solution.record, "pull-off: --load")
    seconds = len(controls) * sum(seconds_of_inputs(solution, names) for solution in solutions)
    tried = [SEARCHED * len(controls) * (1 + 2 * len(names))] * len(solutions)
    begin_curves("pull-off --load", solutions, tried, limits, beside=seconds)
    results, warnings = list[Result](), list[str]()
    for solution in solutions:
        settings = how.slopes, how.modulus_factor, uncertain
        by_history = [works_by_history(solution, force, one, rest, *settings) for one in controls]
        if all(isinstance(one, list) for one in by_history):
            for k, found in zip(controls, by_history, strict=True):
                assert isinstance(found, list)
                results.append(MeasuredByHistory.of(solution, force, k, found, how.slopes, how.modulus_factor))
            continue
        warnings += [f"{solution.record.path}: {text}" for text in relaxing(solution.problem.specimen.relaxation)]
        means = [measured_work(solution, force, one, *settings) for one in controls]
        effect = effect_on(solution, [means[0].work.w])
        warnings += [f"{solution.record.path}: {text}" for text in sticking_warnings(solution.problem, effect)]
        measured = [MeasuredPullOff(one) for one in means]
        warnings += dict.fromkeys(text for one in measured for text in one.warnings)
        results += measured
    return Results(results, warnings)


def _by_flags(
    flags: Flags, works: Sequence[float], force: float | None, stiffnesses: Sequence[float], how: CurveOptions
) -> Solution:  # fmt: skip
    """The body by flags, solved as far as the question needs; no file is written."""
    from ..beside.reach import solved_for, solved_for_force

    problem = case_of("pull-off", flags, "a case or series file", loading={"radius": 1.0}).model.problem()
    if force is not None:
        solution = solved_for_force(problem, abs(force), stiffnesses, how.slopes, how.modulus_factor)
    elif works and not (w := max(works)) > 0:
        raise InputError(f"pull-off: --w must be > 0 to ask where contact is lost, got {w:g} J/m^2")
    elif works:
        solution = solved_for(problem, works, how.slopes, how.modulus_factor)
    else:
        raise InputError("pull-off: give --w, or --load with a measured pull-off force")
    called = f"{problem.indenter.words} on {problem.specimen.words}"
    return replace(solution, record=replace(solution.record, path=Path(called)))

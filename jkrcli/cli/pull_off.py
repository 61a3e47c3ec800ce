"""``jkr pull-off``: where contact is lost, under every control; and the work of adhesion behind a measured pull-off."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import click

from ..adhesion import LOAD_CONTROL
from ..base import InputError
from ..beside import effect_on, sticking_warnings, where_lost
from ..methods import Limits
from ..report import MeasuredPullOff, PullOff, Result, Results
from ..series import Solution
from .body import Flags, body_options, by_flags, case_of
from .options import CONTROL, LOAD, NAMED, WORK, CurveOptions, curve_options, json_option, limits_options
from .series import begin_curves, read_files, warn_of_constant_moduli, without_range, works_of
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
@curve_options
@limits_options
@json_option
def pull_off(
    files: tuple[Path, ...], works: tuple[float, ...], stiffnesses: tuple[float, ...], force: float | None,
    uncertain: tuple[tuple[str, str], ...], how: CurveOptions, limits: Limits, flags: Flags, as_json: bool,
) -> None:  # fmt: skip
    """Say where contact is lost in each FILE, a case or a series, or on the body by flags (--radius, --E, --nu,
    --thickness ...): under load control, displacement control, devices of a stiffness.

    For each work of adhesion and control: pull-off, jump-in at first touch, every other critical point, energy lost
    per approach-retract cycle and work of separation. With --load the other way round: the work of adhesion that a
    measured pull-off force means on this body (under load control, or of each --stiffness).

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
    if by_flags("pull-off", flags, files):
        solutions = [_by_flags(flags, works, force, stiffnesses, how)]
    elif files:
        _, solutions = read_files("pull-off", files)
        warn_of_constant_moduli(*solutions)
    else:
        raise InputError("pull-off: give FILES, a case or a series, or the body by flags: --radius, --E, --nu")
    if force is not None:
        give(_means(solutions, abs(force), stiffnesses, uncertain, how, limits), as_json)
        return
    ranges = list(map(how.of, solutions))
    wanted = [works or works_of(solution) for solution in solutions]
    begin_curves("pull-off", solutions, wanted, limits, ranges, devices=len(stiffnesses))
    curves = [one for solution, some, ranged in zip(solutions, wanted, ranges, strict=True)
             for one in where_lost(solution, some, stiffnesses, how.slopes, how.modulus_factor, ranged)]  # fmt: skip
    give(Results([PullOff(*one) for one in curves]), as_json)


def _means(
    solutions: Sequence[Solution], force: float, stiffnesses: Sequence[float], uncertain: Sequence[tuple[str, str]],
    how: CurveOptions, limits: Limits,
) -> Results:  # fmt: skip
    """The work of adhesion that a measured ``force`` [N] means on each body under each control."""
    from ..identification.work_of_adhesion import measured_work, seconds_of_inputs

    controls, names = stiffnesses or (LOAD_CONTROL,), [name for name, _ in uncertain]
    for solution in solutions:
        without_range(solution.record, "pull-off: --load")
    seconds = len(controls) * sum(seconds_of_inputs(solution, names) for solution in solutions)
    tried = [SEARCHED * len(controls) * (1 + 2 * len(names))] * len(solutions)
    begin_curves("pull-off --load", solutions, tried, limits, beside=seconds)
    results, warnings = list[Result](), list[str]()
    for solution in solutions:
        means = [measured_work(solution, force, one, how.slopes, how.modulus_factor, uncertain) for one in controls]
        effect = effect_on(solution, [means[0].work.w])
        warnings += [f"{solution.record.path}: {text}" for text in sticking_warnings(solution.problem, effect)]
        results += map(MeasuredPullOff, means)
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

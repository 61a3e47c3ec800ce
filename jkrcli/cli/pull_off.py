"""``jkr pull-off``: where contact is lost, under every control; and the work of adhesion behind a measured pull-off."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import click

from ..adhesion import LOAD_CONTROL, AskedRange
from ..base import InputError
from ..beside import effect_on, sticking_warnings, where_lost
from ..methods.guards import Limits
from ..report.pull_off import MeasuredPullOff, PullOff
from ..report.result import Result
from ..series import Solution
from .body import body_options, by_flags, case_of
from .options import (
    ControlType,
    LoadType,
    NamedType,
    WorkType,
    limits_options,
    modulus_factor_option,
    range_options,
    slopes_option,
)
from .output import answer, json_option
from .series import begin_curves, read_files, without_range, works_of
from .verb import Verb
from .voice import present, warn

SEARCHED = (0.05,) * 10  # works of adhesion [J/m^2] that are tried for that of a measured force; choice: for forecasts


@click.command("pull-off", cls=Verb)
@click.argument("files", nargs=-1, type=click.Path(path_type=Path))
@body_options
@click.option("--w", "works", multiple=True, type=WorkType(), help='J/m^2 or "35 mJ/m^2" [default: the case\'s].')
@click.option(
    "--stiffness",
    "stiffnesses",
    multiple=True,
    type=ControlType(),
    help='Of the machine or cantilever, "0.2 N/m"; also "load" and "rigid" [default: these two].',
)
@click.option("--load", "force", type=LoadType(), help='A measured pull-off force, "12 uN": which w does it mean?')
@click.option(
    "--uncertain",
    multiple=True,
    type=NamedType(),
    help="With --load: standard deviation of load, R, E, h, nu or E:LAYER, such as load=5%, h=1um.",
)
@range_options
@slopes_option
@modulus_factor_option
@limits_options
@json_option
def pull_off(
    files: tuple[Path, ...],
    works: tuple[float, ...],
    stiffnesses: tuple[float, ...],
    force: float | None,
    uncertain: tuple[tuple[str, str], ...],
    stress: float | None,
    length: float | None,
    slopes: str,
    modulus_factor: float,
    limits: Limits,
    as_json: bool,
    **flags: str | None,
) -> None:
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
    if force is not None and (stress is not None or length is not None):
        raise InputError("pull-off: --load asks for the w of JKR: give neither --stress nor --range with it")
    if force is not None and force == 0:
        raise InputError("pull-off: --load must not be 0; give the measured pull-off force")
    if uncertain and force is None:
        raise InputError("pull-off: --uncertain says how well a measured force and its body are known: give --load too")
    if by_flags("pull-off", flags, files):
        held = [_by_flags(flags, works, force, stiffnesses, slopes, modulus_factor)]
    elif files:
        _, held = read_files("pull-off", files)
    else:
        raise InputError("pull-off: give FILES, a case or a series, or the body by flags: --radius, --E, --nu")
    if force is not None:
        for solution in held:
            without_range(solution.record, "pull-off: --load")
    asked = [AskedRange.of(solution.record, stress, length) if force is None else AskedRange() for solution in held]
    if force is None:
        wanted = [works or works_of(solution) for solution in held]
        begin_curves("pull-off", held, wanted, asked, limits, devices=len(stiffnesses))
    else:
        wanted, beside = _searched(held, len(stiffnesses) or 1, [name for name, _ in uncertain])
        begin_curves("pull-off --load", held, wanted, asked, limits, beside=beside)
    results, warnings = list[Result](), list[str]()
    for solution, some, ranged in zip(held, wanted, asked, strict=True):
        if force is None:
            curves = where_lost(solution, some, stiffnesses, slopes, modulus_factor, ranged)
            results += [PullOff(*each) for each in curves]
            continue
        from ..identification.work_of_adhesion import measured_work

        means = [
            measured_work(solution, abs(force), stiffness, slopes, modulus_factor, uncertain)
            for stiffness in stiffnesses or (LOAD_CONTROL,)
        ]
        effect = effect_on(solution, [means[0].found.w])
        warnings += [f"{solution.record.path}: {text}" for text in sticking_warnings(solution.problem, effect)]
        results += map(MeasuredPullOff, means)
    if as_json:
        answer({"results": [result.summary() for result in results]})
    else:
        present(*(result.words() for result in results))
    for text in warnings:
        warn(text)


def _by_flags(
    flags: Mapping[str, str | None], works: Sequence[float], force: float | None, stiffnesses: Sequence[float],
    slopes: str, modulus_factor: float,
) -> Solution:  # fmt: skip
    """The body by flags, solved as far as the question needs; no file is written."""
    from ..beside.reach import solved_for, solved_for_force

    problem = case_of("pull-off", flags, "a case or series file", {"radius": 1.0}).model.problem()
    if force is not None:
        solution = solved_for_force(problem, abs(force), stiffnesses, slopes, modulus_factor)
    elif works and not (w := max(works)) > 0:
        raise InputError(f"pull-off: --w must be > 0 to ask where contact is lost, got {w:g} J/m^2")
    elif works:
        solution = solved_for(problem, works, slopes, modulus_factor)
    else:
        raise InputError("pull-off: give --w, or --load with a measured pull-off force")
    called = f"{problem.indenter.words} on {problem.specimen.words}"
    return replace(solution, record=replace(solution.record, path=Path(called)))


def _searched(
    held: Sequence[Solution], controls: int, uncertain: Sequence[str]
) -> tuple[list[tuple[float, ...]], float]:
    """Works of adhesion that are tried on each body under so many ``controls`` with ``uncertain`` inputs, and the CPU
    seconds of the bodies that are solved for these."""
    from ..identification.work_of_adhesion import seconds_of_inputs

    seconds = controls * sum(seconds_of_inputs(solution, uncertain) for solution in held)
    return [SEARCHED * controls * (1 + 2 * len(uncertain))] * len(held), seconds

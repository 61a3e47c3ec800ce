"""``jkr pull-off``: where contact is lost, under every control; and the work of adhesion behind a measured pull-off."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..adhesion.analysis import Analysis, analyse, error_of_point, with_solved_points
from ..adhesion.critical import Errors
from ..adhesion.curve import Equilibrium
from ..adhesion.device import DISPLACEMENT_CONTROL, LOAD_CONTROL, control
from ..adhesion.law import AskedRange
from ..adhesion.sharp import resolved, yielding
from ..adhesion.stability import Behaviour, behaviour
from ..adhesion.sticking import effect_on, sticking_warnings
from ..adhesion.validity import check
from ..base.errors import InputError
from ..base.units import show
from ..base.unknown import Estimate, Unknown, known
from ..methods.guards import Limits
from ..report import tables
from ..series import Solution
from .options import (
    LoadType,
    NamedType,
    QuantityType,
    WorkType,
    limits_options,
    modulus_factor_option,
    range_options,
    slopes_option,
)
from .output import answer, json_option
from .series import attracted, begin_curves, read_series, series_file, without_range, works_of
from .voice import say, warn

if TYPE_CHECKING:
    from ..identification.work_of_adhesion import MeasuredWork

SEARCHED = (0.05,) * 10  # works of adhesion [J/m^2] that are tried for that of a measured force; choice: for forecasts
TINY = Unknown("it would be one of a contact smaller than atoms")
SIZES = {"a/R": "a_over_R", "a/R at pull-off": "a_over_R_pull_off", "a/h": "a_over_h", "a/L": "a_over_L"}
Answer = tuple[dict[str, Any], list[str]]  # for machines, for people


class ControlType(QuantityType):
    """A stiffness > 0, or "rigid" (displacement control) or "load" (load control)."""

    name = "STIFFNESS"
    dimension = "stiffness"
    least = 0.0
    words = {"rigid": DISPLACEMENT_CONTROL, "load": LOAD_CONTROL}  # noqa: RUF012 - a constant of the class

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        if value in self.words:
            return self.words[value]
        found = super().convert(value, param, ctx)
        if found == 0:
            self.fail(f'must be > 0, or "load" for load control, or "rigid", got {value}', param, ctx)
        return found


@click.command("pull-off")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
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
) -> None:
    """Say where contact is lost in each FILE, a case or a series: under load control, displacement control, devices of
    a stiffness.

    For each work of adhesion and control: pull-off, jump-in at first touch, every other critical point, energy lost
    per approach-retract cycle and work of separation. With --load the other way round: the work of adhesion that a
    measured pull-off force means on this body (under load control, or of each --stiffness).

    \b
    jkr pull-off my.toml --w "50 mJ/m^2" --stiffness "10 N/m"
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
    files = tuple(map(series_file, files))
    held = [read_series(path) for path in files]
    if force is not None:
        for solution in held:
            without_range(solution.record, "pull-off: --load")
    wanted = [works or works_of(solution) if force is None else SEARCHED for solution in held]
    asked = [AskedRange.of(solution.record, stress, length) if force is None else AskedRange() for solution in held]
    begin_curves("pull-off", held, wanted, asked, limits)
    results: list[Answer] = []
    for solution, some, ranged in zip(held, wanted, asked, strict=True):
        if force is None:
            controls = stiffnesses or (LOAD_CONTROL, DISPLACEMENT_CONTROL)
            analyses = analyse(solution, some, slopes, modulus_factor, ranged)
            results += [_forward(with_solved_points(result, *stiffnesses), controls) for result in analyses]
        else:
            told = partial(_inverse, solution, abs(force), slopes, modulus_factor, uncertain)
            answers = [told(stiffness) for stiffness in stiffnesses or (LOAD_CONTROL,)]
            effect = effect_on(solution, [answers[0][0]["w_J_per_m2"]])
            for warning in sticking_warnings(solution.problem, effect):
                warn(f"{solution.record.path}: {warning}")
            results += answers
    if as_json:
        answer({"results": [data for data, _ in results]})
        return
    for _, lines in results:
        say("\n".join(lines))


def _forward(result: Analysis, stiffnesses: Sequence[float]) -> Answer:
    found = [_above_atoms(behaviour(result.curve, stiffness), result) for stiffness in stiffnesses]
    errors = [_error(result, item) for item in found]
    lines = [f"{result.path}: w = {show(result.w, 'work')}{attracted(result)}"]
    for item, error in zip(found, errors, strict=True):
        lines += _text(item, error)
    lines += _validity(result)
    controls = []
    for item, error in zip(found, errors, strict=True):
        told = tables.control(item)
        told["pull_off"] |= tables.errors(error)
        controls.append({"control": item.control, "stiffness_N_per_m": _finite(item.stiffness), **told})
    data = {
        "file": str(result.path),
        "w_J_per_m2": result.w,
        **tables.law(result),
        "modulus_factor": result.modulus_factor,
        "controls": controls,
        "validity": tables.validity(result),
        "errors": result.budget.as_dict() | {"between_rows": result.curve.interpolation_error},
    }
    return data, lines


def _above_atoms(found: Behaviour, result: Analysis) -> Behaviour:
    """What was read off without what would happen at radii below atoms."""
    point = resolved(found.pull_off, result.curve, found.stiffness, result.solution.record.z0)
    if point is found.pull_off or not isinstance(point, Unknown):
        return found
    return replace(found, critical=(), pull_off=point, jump_in=TINY, energy_lost=TINY, separation=TINY)


def _error(result: Analysis, found: Behaviour) -> Errors | Unknown | None:
    """Half-widths of the pull-off point; None where there is none."""
    if isinstance(found.pull_off, Unknown):
        return None
    return error_of_point(result.curve, found.pull_off, found.stiffness)


def _inverse(
    solution: Solution,
    force: float,
    slopes: str,
    modulus_factor: float,
    uncertain: Sequence[tuple[str, str]],
    stiffness: float,
) -> Answer:
    from ..identification.work_of_adhesion import measured_work, uncertain_inputs

    path = solution.record.path
    inputs = uncertain_inputs(solution, uncertain)
    try:
        told = measured_work(solution, force, stiffness, slopes, modulus_factor, inputs)
    except InputError as error:
        raise InputError([f"{path}: {line}" for line in error.lines]) from None
    found = told.found
    data = {
        "file": str(path),
        "load_N": force,
        "control": control(stiffness),
        "stiffness_N_per_m": _finite(stiffness),
        "w_J_per_m2": found.w,
        "w_err_J_per_m2": known(told.error),
        "w_err_by_input_J_per_m2": dict(told.parts),
        "w_err_of_series_J_per_m2": known(told.series),
        "w_half_space_J_per_m2": found.half_space,
        "pull_off": tables.point(found.point),
        "validity": tables.validity(told.result),
    }
    if isinstance(told.error, Unknown):
        data["error"] = told.error.reason
    return data, _inverse_text(path, told)


def _inverse_text(path: Path, told: MeasuredWork) -> list[str]:
    found = told.found
    error = "?" if isinstance(told.error, Unknown) else show(told.error, "work")
    lines = [
        f"{path}: a pull-off force of {show(found.load, 'load')} means w = {show(found.w, 'work')} ± {error} "
        f"({control(found.stiffness)}, a = {show(found.point.a, 'length')})"
    ]
    if told.parts:
        parts = (f"{name} {show(part, 'work')}" for name, part in told.parts.items())
        lines.append(f"  standard error from {', '.join(parts)}; that of the series {_part(told.series)}")
    else:
        lines.append("  90 % half-width from the error of the series alone; --uncertain load=5% and others add theirs")
    if found.half_space is None:
        lines.append("  no tip radius: classical JKR has no answer for this indenter")
    else:
        lines.append(
            f"  1.5 pi w R of a half-space would have given {show(found.half_space, 'work')}, "
            f"{found.half_space / found.w:.3g} times this body's"
        )
    return [*lines, *_validity(told.result)]


def _part(value: Estimate) -> str:
    return str(value) if isinstance(value, Unknown) else show(value, "work")


def _text(found: Behaviour, error: Errors | Unknown | None) -> list[str]:
    lines = [f"  {found.control}", f"    pull-off            {_point(found.pull_off)}"]
    if isinstance(error, Unknown):
        lines.append(f"    its error           {error}")
    elif error is not None:
        words = f"P within {show(error['P'], 'load')}, delta within {show(error['delta'], 'length')}"
        lines.append(f"    its error           {words} (90 %)")
    others = [point for point in found.critical if point != found.pull_off]
    if not found.critical and not isinstance(found.pull_off, Unknown):
        lines.append("    critical points     none in the series")
    lines += [f"    other {point.kind:<14}{_point(point)}" for point in others]
    lines += [
        f"    jumps back          {_point(jump.start)}  to  {_point(jump.end)}" for jump in found.partial if jump.end
    ]
    lines.append(f"    jump-in{', delta = 0  ' if found.onset == 0 else ', attracted  '}{_point(found.jump_in)}")
    lines.append(f"    energy lost         {_energy(found.energy_lost)}")
    if found.separation != found.energy_lost:
        lines.append(f"    work of separation  {_energy(found.separation)}")
    return lines


def _point(point: Equilibrium | Unknown) -> str:
    if isinstance(point, Unknown):
        return f"none: {point.reason}"
    c = "" if point.c is None else f"  c = {show(point.c, 'length')}"
    return f"P = {show(point.P, 'load'):<12} delta = {show(point.delta, 'length'):<12} a = {show(point.a, 'length')}{c}"


def _energy(value: Estimate) -> str:
    return f"none: {value}" if isinstance(value, Unknown) else f"{value:.4g} J"


def _validity(result: Analysis) -> list[str]:
    """JKR holds, is doubtful or does not: by every number that the body has, then the other warnings."""
    judged = tables.validity(result)
    lines = []
    if isinstance(judged["tabor"], float):
        lines.append(f"  Tabor number {judged['tabor']:.3g}: {judged['regime']}")
    sizes = ((name, judged[key]) for name, key in SIZES.items())
    lines.append("  " + ", ".join(f"{name} = {value:.3g}" for name, value in sizes if isinstance(value, float)))
    stands_above = "Tabor", "at the range"
    said = [warning for warning in check(result.validity) if not warning.startswith(stands_above)]
    said += yielding(result.problem, result.curve)
    return [line for line in [*lines, *(f"  {warning}" for warning in said)] if line.strip()]


def _finite(stiffness: float) -> float | None:
    """JSON has no infinity: null for a rigid device."""
    return None if stiffness == DISPLACEMENT_CONTROL else stiffness

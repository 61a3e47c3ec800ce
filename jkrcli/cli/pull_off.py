"""``jkr pull-off``: where contact is lost, under every control; and the work of adhesion behind a measured pull-off."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from ..adhesion.analysis import Analysis, analyse
from ..adhesion.curve import Equilibrium
from ..adhesion.device import DISPLACEMENT_CONTROL, LOAD_CONTROL, control
from ..adhesion.stability import Behaviour, behaviour
from ..adhesion.stability_inverse import FoundWork, work_from_pull_off
from ..adhesion.validity import check
from ..base.errors import InputError
from ..base.units import show
from ..base.unknown import Estimate, Unknown
from ..report import tables
from .options import LoadType, QuantityType, WorkType, modulus_factor_option, slopes_option
from .output import answer, json_option
from .series import read_series, works_of

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
@slopes_option
@modulus_factor_option
@json_option
def pull_off(
    files: tuple[Path, ...],
    works: tuple[float, ...],
    stiffnesses: tuple[float, ...],
    force: float | None,
    slopes: str,
    modulus_factor: float,
    as_json: bool,
) -> None:
    """Say where each series FILE's contact is lost: under load control, displacement control, devices of a stiffness.

    For each work of adhesion and control: pull-off, jump-in at first touch, every other critical point, energy lost
    per approach-retract cycle and work of separation. With --load the other way round: the work of adhesion that a
    measured pull-off force means on this body (under load control, or of each --stiffness).

    \b
    jkr pull-off data.h5 --w 50 --stiffness "10 kN/m"
    jkr pull-off gel.h5 --load "1.2 mN"
    """
    if force is not None and works:
        raise InputError("pull-off: give either --w or --load, not both")
    if force is not None and force == 0:
        raise InputError("pull-off: --load must not be 0; give the measured pull-off force")
    held = [read_series(path) for path in files]
    results: list[Answer] = []
    for solution in held:
        wanted = (works or works_of(solution)) if force is None else (0.0,)
        analyses = analyse(solution, wanted, slopes, modulus_factor)
        if force is None:
            results += [_forward(result, stiffnesses or (LOAD_CONTROL, DISPLACEMENT_CONTROL)) for result in analyses]
        else:
            results += [_inverse(analyses[0], abs(force), stiffness) for stiffness in stiffnesses or (LOAD_CONTROL,)]
    if as_json:
        answer({"results": [data for data, _ in results]})
        return
    for _, lines in results:
        click.echo("\n".join(lines))


def _forward(result: Analysis, stiffnesses: Sequence[float]) -> Answer:
    found = [behaviour(result.curve, stiffness) for stiffness in stiffnesses]
    lines = [f"{result.path}: w = {show(result.w, 'work')}"]
    for item in found:
        lines += _text(item)
    lines += _validity(result)
    data = {
        "file": str(result.path),
        "w_J_per_m2": result.w,
        "modulus_factor": result.modulus_factor,
        "controls": [
            {"control": item.control, "stiffness_N_per_m": _finite(item.stiffness), **tables.control(item)}
            for item in found
        ],
        "validity": tables.validity(result),
    }
    return data, lines


def _inverse(result: Analysis, force: float, stiffness: float) -> Answer:
    R, path = result.problem.indenter.tip_radius, result.path
    try:
        found = work_from_pull_off(result.curve.nonadhesive, force, stiffness, R)
    except InputError as error:
        raise InputError([f"{path}: {line}" for line in error.lines]) from None
    data = {
        "file": str(path),
        "load_N": force,
        "control": control(stiffness),
        "stiffness_N_per_m": _finite(stiffness),
        "w_J_per_m2": found.w,
        "w_half_space_J_per_m2": found.half_space,
        "pull_off": tables.point(found.point),
    }
    return data, _inverse_text(path, found)


def _inverse_text(path: Path, found: FoundWork) -> list[str]:
    lines = [
        f"{path}: a pull-off force of {show(found.load, 'load')} means w = {show(found.w, 'work')} "
        f"({control(found.stiffness)}, a = {show(found.point.a, 'length')})"
    ]
    if found.half_space is None:
        return [*lines, "  no tip radius: classical JKR has no answer for this indenter"]
    return [
        *lines,
        f"  1.5 pi w R of a half-space would have given {show(found.half_space, 'work')}, "
        f"{found.half_space / found.w:.3g} times this body's",
    ]


def _text(found: Behaviour) -> list[str]:
    lines = [f"  {found.control}", f"    pull-off            {_point(found.pull_off)}"]
    others = [point for point in found.critical if point != found.pull_off]
    if not found.critical:
        lines.append("    critical points     none in the series")
    lines += [f"    other {point.kind:<14}{_point(point)}" for point in others]
    lines += [
        f"    jumps back          {_point(jump.start)}  to  {_point(jump.end)}" for jump in found.partial if jump.end
    ]
    lines.append(f"    jump-in, delta = 0  {_point(found.jump_in)}")
    lines.append(f"    energy lost         {_energy(found.energy_lost)}")
    if found.separation != found.energy_lost:
        lines.append(f"    work of separation  {_energy(found.separation)}")
    return lines


def _point(point: Equilibrium | Unknown) -> str:
    if isinstance(point, Unknown):
        return f"none: {point.reason}"
    return f"P = {show(point.P, 'load'):<12} delta = {show(point.delta, 'length'):<12} a = {show(point.a, 'length')}"


def _energy(value: Estimate) -> str:
    return f"none: {value}" if isinstance(value, Unknown) else f"{value:.4g} J"


def _validity(result: Analysis) -> list[str]:
    """JKR holds, is doubtful or does not: by every number that the body has, then the other warnings."""
    judged = tables.validity(result)
    lines = []
    if isinstance(judged["tabor"], float):
        lines.append(f"  Tabor number {judged['tabor']:.3g}: {judged['regime']}")
    if isinstance(judged.get("tabor_thin_layer"), float):
        lines.append(f"  its thin-layer counterpart {judged['tabor_thin_layer']:.3g}: {judged['regime_thin_layer']}")
    if isinstance(judged.get("tabor_of_coating"), float):
        numbers = f"{judged['tabor_of_coating']:.3g} with the coating's E*, {judged['tabor_of_substrate']:.3g}"
        lines.append(f"  Tabor number {numbers} with the substrate's: {judged['regime_coated']}")
    sizes = ((name, judged[key]) for name, key in SIZES.items())
    lines.append("  " + ", ".join(f"{name} = {value:.3g}" for name, value in sizes if isinstance(value, float)))
    said = (warning for warning in check(result.validity) if not warning.startswith("Tabor"))  # stands above
    return [line for line in [*lines, *(f"  {warning}" for warning in said)] if line.strip()]


def _finite(stiffness: float) -> float | None:
    """JSON has no infinity: null for a rigid device."""
    return None if stiffness == DISPLACEMENT_CONTROL else stiffness

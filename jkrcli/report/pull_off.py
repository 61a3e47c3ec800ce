"""Where contact is lost, and the work of adhesion behind a measured pull-off, in words and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..adhesion import LOAD_CONTROL, Behaviour, Equilibrium, Errors, control, yielding
from ..base import Estimate, Unknown, accuracy, known, show
from ..beside import Analysis, Lost, is_solved
from . import tables
from .result import Result

if TYPE_CHECKING:
    from ..identification.work_of_adhesion import MeasuredWork

SIZES = {"a/R": "a_over_R", "a/R at pull-off": "a_over_R_pull_off", "a/h": "a_over_h", "a/L": "a_over_L",
         "theta": "edge_angle"}  # fmt: skip
OF_INPUTS = "load and body taken as exact: --uncertain load=5% and others give w its standard error"
ABOVE = "Tabor", "at the range"  # how the warnings begin that say again what the line of the Tabor number says


@dataclass(frozen=True, eq=False)
class PullOff(Result):
    """What is read off one curve under each control."""

    result: Analysis
    lost: Sequence[Lost]

    def summary(self) -> dict[str, Any]:
        result, lost = self.result, self.lost
        controls = []
        for found, error in lost:
            told = tables.control(found)
            told["pull_off"] |= tables.errors(error)
            if error is not None:
                told["pull_off"]["interpolated"] = not _solved(result, found)
            controls.append({"control": found.control, "stiffness_N_per_m": tables.stiffness(found.stiffness), **told})
        return {
            "file": str(result.path),
            "w_J_per_m2": result.w,
            **tables.law(result),
            "modulus_factor": result.modulus_factor,
            "controls": controls,
            "validity": tables.validity(result),
            "errors": result.budget.as_dict() | {"between_rows": result.curve.interpolation_error},
        }

    def words(self) -> list[str]:
        result, lost = self.result, self.lost
        points = {found.control: (found.pull_off, error) for found, error in lost}
        lines = [*tables.lost_words(result, points), *_validity(result)]
        return lines + [line for found, error in lost for line in _control(found, error, _solved(result, found))]


@dataclass(frozen=True, eq=False)
class MeasuredPullOff(Result):
    """What a measured pull-off force means."""

    told: MeasuredWork

    def summary(self) -> dict[str, Any]:
        told = self.told
        found = told.work
        data = {
            "file": str(told.result.path),
            "load_N": found.load,
            "control": control(found.stiffness),
            "stiffness_N_per_m": tables.stiffness(found.stiffness),
            "w_J_per_m2": found.w,
            "w_err_J_per_m2": known(told.error),
            "w_err_by_input_J_per_m2": dict(told.parts),
            "w_err_of_series_J_per_m2": known(told.series),
            "w_half_space_J_per_m2": found.half_space,
            "pull_off": tables.point(found.point),
            "validity": tables.validity(told.result),
        }
        return data | ({"error": told.error.reason} if isinstance(told.error, Unknown) else {})

    def words(self) -> list[str]:
        told = self.told
        found = told.work
        error = "" if isinstance(told.error, Unknown) or not told.parts else f" ± {show(told.error, 'work', 3)}"
        lines = [
            f"w = {show(found.w, 'work')}{error}: the pull-off force {show(found.load, 'load')} of {told.result.path} "
            f"({control(found.stiffness)}, a = {show(found.point.a, 'length')})"
        ]
        if told.parts:
            parts = (f"{name} {show(part, 'work')}" for name, part in told.parts.items())
            lines.append(f"  standard error from {', '.join(parts)}")
        else:
            lines.append(f"  {OF_INPUTS}")
        series = told.series if isinstance(told.series, Unknown) else told.series / found.w
        lines.append(f"  {accuracy(series)} (90 %)")
        if found.half_space is None:
            lines.append("  no tip radius: 1.5 pi w R is not defined for this indenter")
        else:
            under = "" if found.stiffness == LOAD_CONTROL else " under load control"
            lines.append(
                f"  1.5 pi w R of a half-space{under} would have given {show(found.half_space, 'work')}, "
                f"{found.half_space / found.w:.3g} times this body's"
            )
        return lines + _validity(told.result)


def _solved(result: Analysis, found: Behaviour) -> bool:
    return isinstance(found.pull_off, Equilibrium) and is_solved(result.curve, found.pull_off)


def _control(found: Behaviour, error: Errors | Unknown | None, solved: bool) -> list[str]:
    """Points, jumps and energies under one control; the pull-off point ``solved`` or read off between the rows."""
    between = "; interpolated" if not solved and error and not isinstance(error, Unknown) else ""
    lines = [f"  {found.control}", f"    pull-off            {_point(found.pull_off)}{between}"]
    if isinstance(error, Unknown):
        lines.append(f"    its error           {error}")
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
    said = [warning for warning in result.validity.warnings if not warning.startswith(ABOVE)]
    said += yielding(result.problem, result.curve)
    return [line for line in [*lines, *(f"  {warning}" for warning in said)] if line.strip()]

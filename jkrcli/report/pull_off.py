"""Where contact is lost, and the work of adhesion behind a measured pull-off, in words and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..adhesion import LOAD_CONTROL, Behaviour, CriticalPoint, Equilibrium, Errors, control, faces, yielding
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
        for behaviour, error in lost:
            numbers = tables.under_control(behaviour)
            numbers["pull_off"] |= tables.errors(error)
            if error is not None:
                numbers["pull_off"]["interpolated"] = not _solved(result, behaviour)
            controls.append(tables.device(behaviour.stiffness) | numbers)
        return {
            "file": str(result.path),
            "w_J_per_m2": result.w,
            **tables.law(result),
            "modulus_factor": result.modulus_factor,
            "controls": controls,
            "validity": tables.validity(result, *self._points),
            "errors": result.budget.as_dict() | {"between_rows": result.curve.interpolation_error},
        }

    @property
    def _points(self) -> list[CriticalPoint | Unknown]:
        """Where contact is lost under each of the controls that were asked for."""
        return [means.pull_off for means, _ in self.lost]

    def words(self) -> list[str]:
        result, points = self.result, {control(means.stiffness): (means.pull_off, error) for means, error in self.lost}
        lines = [*tables.lost_words(result, points), *_validity(result, *self._points)]
        return lines + [line for means, error in self.lost for line in _control(means, error, _solved(result, means))]


@dataclass(frozen=True, eq=False)
class MeasuredPullOff(Result):
    """What a measured pull-off force means."""

    means: MeasuredWork

    def summary(self) -> dict[str, Any]:
        means, work = self.means, self.means.work
        data = {
            "file": str(means.result.path),
            "load_N": work.load,
            **tables.device(work.stiffness),
            "w_J_per_m2": work.w,
            "w_err_J_per_m2": known(means.error),
            "w_err_by_input_J_per_m2": dict(means.parts),
            "w_err_of_series_J_per_m2": known(means.series),
            "w_half_space_J_per_m2": work.half_space,
            "pull_off": tables.point(work.point),
            "validity": tables.validity(means.result, work.point),
        }
        return data | ({"error": means.error.reason} if isinstance(means.error, Unknown) else {})

    def words(self) -> list[str]:
        means, work = self.means, self.means.work
        error = "" if isinstance(means.error, Unknown) or not means.parts else f" ± {show(means.error, 'work', 3)}"
        lines = [
            f"w = {show(work.w, 'work')}{error}: the pull-off force {show(work.load, 'load')} of "
            f"{means.result.path} ({control(work.stiffness)}, {tables.state_words(work.point, 'a')})"
        ]
        if means.parts:
            parts = (f"{name} {show(part, 'work')}" for name, part in means.parts.items())
            lines.append(f"  standard error from {', '.join(parts)}")
        else:
            lines.append(f"  {OF_INPUTS}")
        series = means.series if isinstance(means.series, Unknown) else means.series / work.w
        lines.append(f"  {accuracy(series)} (90 %)")
        if work.half_space is None:
            lines.append("  no tip radius: 1.5 pi w R is not defined for this indenter")
        else:
            under = "" if work.stiffness == LOAD_CONTROL else " under load control"
            lines.append(
                f"  1.5 pi w R of a half-space{under} would have given {show(work.half_space, 'work')}, "
                f"{work.half_space / work.w:.3g} times this body's"
            )
        return lines + _validity(means.result, work.point)


def _solved(result: Analysis, behaviour: Behaviour) -> bool:
    return isinstance(behaviour.pull_off, Equilibrium) and is_solved(result.curve, behaviour.pull_off)


def _control(behaviour: Behaviour, error: Errors | Unknown | None, solved: bool) -> list[str]:
    """Points, jumps and energies under one control; the pull-off point ``solved`` or read off between the rows."""
    between = "; interpolated" if not solved and error and not isinstance(error, Unknown) else ""
    lines = [f"  {control(behaviour.stiffness)}", f"    pull-off            {_point(behaviour.pull_off)}{between}"]
    if isinstance(error, Unknown):
        lines.append(f"    its error           {error}")
    others = [point for point in behaviour.critical if point != behaviour.pull_off]
    if not behaviour.critical and not isinstance(behaviour.pull_off, Unknown):
        lines.append("    critical points     none in the series")
    lines += [f"    other {point.kind:<14}{_point(point)}" for point in others]
    lines += [
        f"    jumps back          {_point(jump.start)}  to  {_point(jump.end)}"
        for jump in behaviour.partial
        if jump.end
    ]
    onset = ", delta = 0  " if behaviour.onset == 0 else ", attracted  "
    lines += [
        f"    jump-in{onset}{_point(behaviour.jump_in)}",
        f"    energy lost         {_energy(behaviour.energy_lost)}",
    ]
    if behaviour.separation != behaviour.energy_lost:
        lines.append(f"    work of separation  {_energy(behaviour.separation)}")
    return lines


def _point(point: Equilibrium | Unknown) -> str:
    if isinstance(point, Unknown):
        return f"none: {point.reason}"
    c = "" if point.c is None else f"  c = {show(point.c, 'length')}"
    return f"P = {show(point.P, 'load'):<12} delta = {show(point.delta, 'length'):<12} a = {show(point.a, 'length')}{c}"


def _energy(value: Estimate) -> str:
    return f"none: {value}" if isinstance(value, Unknown) else f"{value:.4g} J"


def _validity(result: Analysis, *points: CriticalPoint | Unknown) -> list[str]:
    """JKR holds, is doubtful or does not: by every number that the body has, with pull-off at ``points``, then the
    other warnings."""
    judged = result.validity_at(*points)
    tabor = [f"Tabor number {judged.tabor:.3g}: {judged.regime}"] if isinstance(judged.tabor, float) else []
    warnings = [warning for warning in judged.warnings if not warning.startswith(ABOVE)]
    warnings += yielding(result.problem, result.curve)
    warnings += faces(result.problem.indenter, result.w, bool(result.problem.specimen.layers))
    lines = [*tabor, ", ".join(tables.size_words(judged, SIZES)), *warnings]
    return [f"  {line}" for line in lines if line.strip()]

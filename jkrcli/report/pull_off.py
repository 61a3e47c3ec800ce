"""Where contact is lost, and the work of adhesion behind a measured pull-off, in words and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..adhesion import (
    LOAD_CONTROL,
    AdhesiveCurve,
    Behaviour,
    CriticalPoint,
    Equilibrium,
    Errors,
    FromRest,
    LoadingHistory,
    control,
    faces,
    strain_words,
    yielding,
)
from ..adhesion.from_rest import AT_MOST, FROM_REST
from ..base import InputError, Unknown, accuracy, implausible_work, known, show
from ..beside import Analysis, Lost, LostByHistory, analyse, is_solved, strains_after
from ..bodies import relaxing
from ..series import Solution
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
    histories: Sequence[LostByHistory] | Unknown | None = None  # of a viscoelastic specimen

    def summary(self) -> dict[str, Any]:
        result, lost = self.result, self.lost
        controls = []
        for behaviour, error in lost:
            numbers = tables.under_control(behaviour)
            numbers["pull_off"] |= tables.errors(error)
            if isinstance(behaviour.pull_off, CriticalPoint):
                numbers["pull_off"] |= tables.strains(result.large_strains(behaviour.pull_off))
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
            **self._histories_as_json(),
        }

    def _histories_as_json(self) -> dict[str, Any]:
        if self.histories is None:
            return {}
        if isinstance(self.histories, Unknown):
            return {"histories": None, "histories_reason": self.histories.reason}
        return {"histories": [
            _history_as_json(one.history, one.curve)
            | {"controls": [
                tables.device(k) | {"pull_off": tables.point(point) | tables.errors(error) | _no_depth(one.history)}
                for k, (point, error) in one.lost.items()
            ]}
            for one in self.histories
        ]}  # fmt: skip

    @property
    def warnings(self) -> list[str]:
        """What the moduli of a viscoelastic specimen mean where no history is solved."""
        law = self.result.problem.specimen.relaxation
        return [f"{self.result.path}: {text}" for text in relaxing(law)] if isinstance(self.histories, Unknown) else []

    @property
    def _points(self) -> list[CriticalPoint | Unknown]:
        """Where contact is lost under each of the controls that were asked for."""
        return [means.pull_off for means, _ in self.lost]

    def words(self) -> list[str]:
        result, points = self.result, {control(means.stiffness): (means.pull_off, error) for means, error in self.lost}
        lines = [*tables.lost_words(result, points), *_validity(result, *self._points)]
        if isinstance(self.histories, Unknown):
            lines.insert(1, f"  after other histories: none: {self.histories}")
        elif self.histories:
            lines = [*_by_history(result, self.histories), *_validity(result, *self._points)]
            lines.append(f"  {self.histories[0].history.words}:")
        return lines + [line for means, error in self.lost for line in _control(result, means, error)]


def _by_history(result: Analysis, found: Sequence[LostByHistory]) -> list[str]:
    """The verdict on a viscoelastic specimen by its history, and what is lost after each under every control."""
    controls = list(found[0].lost)
    forces = []
    for one in found:
        point, name = one.lost[controls[0]][0], one.history.name
        if isinstance(point, CriticalPoint):
            force = show(-point.P, "load")
            forces.append(f"at most {force}" if name == AT_MOST else f"{force} ({name})")
    lines = [
        f"pull-off force {', '.join(forces) or 'not in the series'} at w = {show(result.w, 'work')}, "
        f"{control(controls[0])}: {result.path}"
    ]
    errors = []
    for one in found:
        further = "" if one.solved_to is None else f"; solved on to a = {show(one.solved_to, 'length')}"
        words = one.history.words + ": at most" * (one.history.name == AT_MOST)
        rest = f" (there {tables.state_words(one.curve.rest)})" if isinstance(one.curve, FromRest) else ""
        lines.append(f"  {words}{rest}{further}")
        for k, (point, error) in one.lost.items():
            shown = _point(point) if one.history.name != AT_MOST or isinstance(point, Unknown) else _bound(point)
            lines.append(f"    {control(k):<21} {shown}")
            if isinstance(point, CriticalPoint) and error is not None:
                errors.append(error if isinstance(error, Unknown) else error["P"] / abs(point.P))
    changes = []
    for one in found:
        point = one.lost[controls[0]][0]
        if isinstance(point, CriticalPoint):
            change = strains_after(result.problem, result.w, one.history, point, controls[0] == LOAD_CONTROL)
            changes += [f"{strain_words(change)} ({one.history.name})"] if change else []
    lines += [f"  model: {'; '.join(changes)}"] if changes else []
    unknown = [error for error in errors if isinstance(error, Unknown)]
    worst = unknown[0] if unknown else max((error for error in errors if isinstance(error, float)), default=None)
    return lines + ([] if worst is None else [f"  pull-off: {accuracy(worst)} (90 %)"])


def _no_depth(history: LoadingHistory) -> dict[str, Any]:
    """The displacement of the largest force of any history, which depends on it."""
    return {"delta_m": None, "delta_err_m": None} if history.name == AT_MOST else {}


def _history_as_json(history: LoadingHistory, curve: AdhesiveCurve | FromRest | Unknown) -> dict[str, Any]:
    """A history, its share of the moduli and of the profile, and the state at rest."""
    rest = {"rest": tables.point(curve.rest)} if isinstance(curve, FromRest) else {}
    shares = {"moduli": history.moduli, "profile": history.profile}
    return {"history": history.name, "words": history.words, **shares, **rest}


@dataclass(frozen=True, eq=False)
class MeasuredByHistory(Result):
    """What a measured pull-off force of a viscoelastic specimen means after each history."""

    load: float
    stiffness: float
    result: Analysis
    found: Sequence[tuple[LoadingHistory, MeasuredWork | Unknown]]

    @classmethod
    def of(
        cls, solution: Solution, load: float, stiffness: float,
        found: Sequence[tuple[LoadingHistory, MeasuredWork | Unknown]], slopes: str = "auto",
        modulus_factor: float = 1.0,
    ) -> MeasuredByHistory:  # fmt: skip
        """What was ``found`` of the pull-off force ``load`` [N] by a device of ``stiffness`` [N/m]; where the theory
        holds is judged with the largest w."""
        works = [one.work.w for _, one in found if not isinstance(one, Unknown)]
        if not works:
            raise InputError([f"{solution.record.path}: {history.words}: {one}" for history, one in found])
        return cls(load, stiffness, analyse(solution, [max(works)], slopes, modulus_factor)[0], found)

    @property
    def _works(self) -> dict[str, float]:
        """w [J/m^2] by the name of the history, of those that have one."""
        return {history.name: one.work.w for history, one in self.found if not isinstance(one, Unknown)}

    @property
    def range(self) -> tuple[float | None, float | None]:
        """The least and the largest w [J/m^2] of these histories; the least only where it is that of any history."""
        works = self._works
        return works.get(AT_MOST), max(works.values(), default=None)

    def summary(self) -> dict[str, Any]:
        rows = []
        for history, one in self.found:
            row = _history_as_json(history, Unknown("") if isinstance(one, Unknown) else one.work.curve)
            if isinstance(one, Unknown):
                row |= {"w_J_per_m2": None, "reason": one.reason}
            else:
                measured = _measured_as_json(one)
                row |= measured | {"pull_off": measured["pull_off"] | _no_depth(history)}
            rows.append(row)
        return {
            "file": str(self.result.path),
            "load_N": self.load,
            **tables.device(self.stiffness),
            "w_J_per_m2": self._works.get(FROM_REST),
            "w_range_J_per_m2": list(self.range),
            "histories": rows,
            "validity": tables.validity(self.result),
        }

    def words(self) -> list[str]:
        low, high = (None if w is None else show(w, "work") for w in self.range)
        span = low if low == high else f"at least {low}" if high is None else f"{low or 'unknown'} to {high}"
        lines = [
            f"w = {span}, by the history of the specimen: the pull-off force {show(self.load, 'load')} of "
            f"{self.result.path} ({control(self.stiffness)})"
        ]
        for history, one in self.found:
            words = history.words + ": at least" * (history.name == AT_MOST)
            if isinstance(one, Unknown):
                lines.append(f"  {words}: none: {one}")
                continue
            error = "" if isinstance(one.error, Unknown) or not one.parts else f" ± {show(one.error, 'work', 3)}"
            series = one.series if isinstance(one.series, Unknown) else one.series / one.work.w
            lines.append(
                f"  {words}: w = {show(one.work.w, 'work')}{error}, {tables.state_words(one.work.point, 'a')}; "
                f"{tables.error_words(series, one.large_strains)}"
            )
        if not any(one.parts for _, one in self.found if not isinstance(one, Unknown)):
            lines.append(f"  {OF_INPUTS}")
        return lines + _validity(self.result)


def _measured_as_json(means: MeasuredWork) -> dict[str, Any]:
    """w and its errors [J/m^2], and where contact is lost with it."""
    data = {
        "w_J_per_m2": means.work.w,
        "w_err_J_per_m2": known(means.error),
        "w_err_by_input_J_per_m2": dict(means.parts),
        "w_err_of_series_J_per_m2": known(means.series),
        "pull_off": tables.point(means.work.point),
        **tables.strains(means.large_strains),
    }
    return data | ({"error": means.error.reason} if isinstance(means.error, Unknown) else {})


@dataclass(frozen=True, eq=False)
class MeasuredPullOff(Result):
    """What a measured pull-off force means."""

    means: MeasuredWork

    @property
    def warnings(self) -> list[str]:
        means = self.means
        doubt = implausible_work(means.work.w, means.result.problem.E_star)
        return [f"{means.result.path}: {doubt}"] if doubt else []

    def summary(self) -> dict[str, Any]:
        means, work = self.means, self.means.work
        return {
            "file": str(means.result.path),
            "load_N": work.load,
            **tables.device(work.stiffness),
            **_measured_as_json(means),
            "w_half_space_J_per_m2": work.half_space,
            "validity": tables.validity(means.result, work.point),
        }

    def words(self) -> list[str]:
        means, work = self.means, self.means.work
        error = "" if isinstance(means.error, Unknown) or not means.parts else f" ± {show(means.error, 'work', 3)}"
        change = means.large_strains
        lines = [
            f"w = {show(work.w, 'work', tables.digits(work.w, change))}{error}: the pull-off force "
            f"{show(work.load, 'load')} of {means.result.path} ({control(work.stiffness)}, "
            f"{tables.state_words(work.point, 'a')})"
        ]
        if means.parts:
            parts = (f"{name} {show(part, 'work')}" for name, part in means.parts.items())
            lines.append(f"  standard error from {', '.join(parts)}")
        else:
            lines.append(f"  {OF_INPUTS}")
        series = means.series if isinstance(means.series, Unknown) else means.series / work.w
        lines.append(f"  {tables.error_words(series, change)}")
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


def _control(result: Analysis, behaviour: Behaviour, error: Errors | Unknown | None) -> list[str]:
    """Points, jumps and energies under one control."""
    point = behaviour.pull_off
    digits = tables.digits(point.P, result.large_strains(point)) if isinstance(point, CriticalPoint) else 4
    between = "; interpolated" if not _solved(result, behaviour) and error and not isinstance(error, Unknown) else ""
    if isinstance(point, CriticalPoint) and result.law is None and result.curve.series.a0 > 0:
        between = "; at the rim of the flat end" if point.a == result.curve.series.a[0] else between
    lines = [f"  {control(behaviour.stiffness)}", f"    pull-off            {_point(point, digits)}{between}"]
    if isinstance(error, Unknown):
        lines.append(f"    its error           {error}")
    others = [other for other in behaviour.critical if other != point]
    if not behaviour.critical and not isinstance(point, Unknown):
        lines.append("    critical points     none in the series")
    lines += [f"    other {other.kind:<14}{_point(other)}" for other in others]
    lines += [
        f"    jumps back          {_point(jump.start)}  to  {_point(jump.end)}"
        for jump in behaviour.partial
        if jump.end
    ]
    onset = ", delta = 0  " if behaviour.onset == 0 else ", attracted  "
    lines += [
        f"    jump-in{onset}{_point(behaviour.jump_in)}",
        f"    energy lost         {tables.energy_words(behaviour.energy_lost, tables.energy_lost_error(behaviour))}",
    ]
    if behaviour.separation != behaviour.energy_lost:
        separation = tables.energy_words(behaviour.separation, tables.separation_error(behaviour))
        lines.append(f"    work of separation  {separation}")
    return lines


def _point(point: Equilibrium | Unknown, digits: int = 4) -> str:
    if isinstance(point, Unknown):
        return f"none: {point.reason}"
    c = "" if point.c is None else f"  c = {show(point.c, 'length')}"
    P = show(point.P, "load", digits)
    return f"P = {P:<12} delta = {show(point.delta, 'length'):<12} a = {show(point.a, 'length')}{c}"


def _bound(point: Equilibrium) -> str:
    """The largest force of any history, whose displacement depends on it."""
    return f"P = {show(point.P, 'load'):<12} {'':<20} a = {show(point.a, 'length')}"


def _validity(result: Analysis, *points: CriticalPoint | Unknown) -> list[str]:
    """JKR holds, is doubtful or does not: by every number that the body has, with pull-off at ``points``, then the
    other warnings."""
    judged = result.validity_at(*points)
    tabor = [f"Tabor number {judged.tabor:.3g}: {judged.regime}"] if isinstance(judged.tabor, float) else []
    warnings = [warning for warning in judged.warnings if not warning.startswith(ABOVE)]
    warnings += [*yielding(result.problem, result.curve), *getattr(result.curve, "doubts", ())]
    warnings += faces(result.problem.indenter, result.w, bool(result.problem.layers))
    lines = [*tabor, ", ".join(tables.size_words(judged, SIZES)), *warnings]
    return [f"  {line}" for line in lines if line.strip()]

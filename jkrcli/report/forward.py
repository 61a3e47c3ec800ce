"""Results of solved bodies as tables, summaries, words and figures: curves, pull-off, cycles, comparisons, fields."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from ..adhesion import device_path
from ..adhesion.curve import CriticalPoint, Equilibrium, EquilibriumCurve, control
from ..adhesion.device_path import Jump, Program, cycle, trace
from ..adhesion.finite_range import RangeRequest
from ..adhesion.pull_off_error import Errors
from ..adhesion.validity import Strains, faces, strain_words, yield_warning
from ..base.errors import AT_LEVEL, LEVEL, Estimate, InputError, Unknown, accuracy
from ..base.files import lists
from ..base.numerics import ROWS, Array
from ..base.registry import FIGURES, Result
from ..base.units import show
from ..base.wings import absent, offered
from ..resolve.analysis import Analysis, Lost, analyse, error_of_point, with_solved_points
from ..series import Difference, Solution, curve_differences, series_differences
from . import tables
from .result import Figure
from .tables import Scales, format_state, is_refined, quantities, read_curve, transpose_rows


@FIGURES.register(Analysis)
def draw_curve(curve: Analysis, scales: Scales | None = None) -> Figure:
    """The picture of an adhesive curve, its axes in units of ``scales``."""
    from .plots.forward import curve_figure, physical_units

    return curve_figure(curve, scales or physical_units(curve.curve))


# --------------------------------------------------------------------------------------------------
# Where contact is lost, in words and as JSON.

SIZES = {"a/R": "a_over_R", "a/R at pull-off": "a_over_R_pull_off", "a/h": "a_over_h", "a/L": "a_over_L",
         "theta": "edge_angle"}  # fmt: skip
# How warnings begin that repeat the line of the Tabor number.
ABOVE = "Tabor", "JKR does not hold", "JKR is doubtful"


@dataclass(frozen=True, eq=False)
class PullOff(Result):
    """What is read off one curve under each control."""

    first_lines = 16

    result: Analysis
    lost: Sequence[Lost]

    def summary(self) -> dict[str, Any]:
        result, lost = self.result, self.lost
        controls = []
        for behaviour, error in lost:
            numbers = tables.under_control(behaviour)
            numbers["pull_off"] |= tables.errors(error)
            numbers["pull_off"] |= tables.strains(result.large_strains(behaviour.pull_off))
            if isinstance(end := behaviour.lost, CriticalPoint):
                numbers["contact_lost"] |= tables.errors(error_of_point(result.curve, end, behaviour.stiffness))
            if error is not None:
                numbers["pull_off"]["interpolated"] = not _solved(result, behaviour)
            controls.append(tables.device(behaviour.stiffness) | numbers)
        return {
            "file": str(result.path),
            "level": LEVEL,
            "w_J_per_m2": result.w,
            **tables.law(result),
            "modulus_factor": result.modulus_factor,
            "controls": controls,
            "validity": tables.validity(result, *self._points),
            "errors": result.budget.as_dict() | {"between_rows": result.curve.interpolation_error},
        }

    @property
    def warnings(self) -> list[str]:
        """Doubts of the roughness."""
        return [f"{self.result.path}: {text}" for text in self.result.rough_warnings]

    @property
    def _points(self) -> list[CriticalPoint | Unknown]:
        """Where contact is lost under each of the controls that were asked for."""
        return [means.pull_off for means, _ in self.lost]

    @property
    def verdict(self) -> list[str]:
        """The pull-off force under each control, and its error."""
        points = {control(means.stiffness): (means.pull_off, error) for means, error in self.lost}
        return tables.format_pull_off(self.result, points)

    @property
    def under_controls(self) -> list[str]:
        """Points, jumps and energies under each control."""
        return [line for means, error in self.lost for line in _control(self.result, means, error)]

    def words(self) -> list[str]:
        return [*self.verdict, *validity_lines(self.result, *self._points), *self.under_controls]


def _solved(result: Analysis, behaviour: device_path.Stability) -> bool:
    return isinstance(behaviour.pull_off, Equilibrium) and is_refined(result.curve, behaviour.pull_off)


def _control(result: Analysis, behaviour: device_path.Stability, error: Errors | Unknown | None) -> list[str]:
    """Points, jumps and energies under one control."""
    point = behaviour.pull_off
    digits = tables.digits(point.P, result.large_strains(point)) if isinstance(point, CriticalPoint) else 4
    between = "; interpolated" if not _solved(result, behaviour) and error and not isinstance(error, Unknown) else ""
    if isinstance(point, CriticalPoint) and result.law is None:
        series = result.curve.series
        rims = (series.rim, *series.a[:1] * (series.a0 > 0))
        between = "; at the rim of the flat end" if point.a in rims else between
    lines = [f"  {control(behaviour.stiffness)}", f"    pull-off            {point_words(point, digits)}{between}"]
    if isinstance(error, Unknown):
        lines.append(f"    its error           {error}")
    if isinstance(lost := behaviour.lost, CriticalPoint) and lost != point:
        off = error_of_point(result.curve, lost, behaviour.stiffness)
        part = off if isinstance(off, Unknown) else off["P"] / abs(lost.P)
        noticed = isinstance(part, Unknown) or part >= tables.PRINTED
        lines.append(f"    contact lost        {point_words(lost)}{f'; {accuracy(part)}' if noticed else ''}")
    others = [other for other in behaviour.critical if other not in (point, lost)]
    lines += [f"    other {other.kind:<14}{point_words(other)}" for other in others]
    lines += [
        f"    jumps back          {point_words(jump.start)}  to  {point_words(jump.end)}"
        for jump in behaviour.partial
        if jump.end
    ]
    onset = ", delta = 0  " if behaviour.onset == 0 else ", attracted  "
    lines.append(f"    jump-in{onset}{point_words(behaviour.jump_in)}")
    if behaviour.energy_lost != device_path.UNBOUNDED:
        lines.append(
            f"    energy lost         {tables.energy_words(behaviour.energy_lost, behaviour.energy_lost_error)}"
        )
    if behaviour.separation not in (behaviour.energy_lost, device_path.UNBOUNDED):
        separation = tables.energy_words(behaviour.separation, behaviour.separation_error)
        lines.append(f"    work of separation  {separation}")
    return lines


def point_words(point: Equilibrium | Unknown, digits: int = 4) -> str:
    if isinstance(point, Unknown):
        return f"none: {point.reason}"
    c = "" if point.c is None else f"  c = {show(point.c, 'length')}"
    P = show(point.P, "load", digits)
    return f"P = {P:<12} delta = {show(point.delta, 'length'):<12} a = {show(point.a, 'length')}{c}"


def validity_lines(result: Analysis, *points: CriticalPoint | Unknown) -> list[str]:
    """JKR holds, is doubtful or does not: by every number that the body has, with pull-off at ``points``, then the
    other warnings."""
    judged = result.validity_at(*points)
    warnings = [warning for warning in judged.warnings if not warning.startswith(ABOVE)]
    warnings += [*yield_warning(result.problem, result.curve.series), *getattr(result.curve, "doubts", ())]
    warnings += faces(result.problem, result.w)
    lines = [judged.verdict, ", ".join(tables.size_words(judged, SIZES)), *warnings]
    return [f"  {line}" for line in lines if line.strip()]


# --------------------------------------------------------------------------------------------------
# The cycle of a device in equilibrium: its trace, in words and as JSON.


@dataclass(frozen=True, eq=False)
class Cycled(Result):
    """What a device records that presses bodies together and pulls them apart, however slowly; ``points``: rows of a
    branch; ``remark``: for its title; ``large_strains``: of the pull-off force."""

    file: Path
    cycle: device_path.Cycle
    points: int = ROWS
    remark: str = ""
    large_strains: Strains = None

    @classmethod
    def of(
        cls, curves: Sequence[Analysis], stiffness: float, load: float | None = None, depth: float | None = None,
        points: int = ROWS,
    ) -> Cycled:  # fmt: skip
        """The cycle on the ``curves`` of approach and retraction that turns at a ``load`` [N] or ``depth`` [m]."""
        inwards, outwards = (result.curve for result in curves)
        whole = load is None and depth is None
        turn = None if whole else device_path.turning_radius(inwards, stiffness, load=load, depth=depth)
        found = cls.on(curves[0].path, inwards, outwards, stiffness, turn, points)
        return replace(found, large_strains=curves[1].large_strains(outwards.pull_off(stiffness)))

    @classmethod
    def on(
        cls, file: Path, inwards: EquilibriumCurve, outwards: EquilibriumCurve, stiffness: float, turn: float | None,
        points: int,
    ) -> Cycled:  # fmt: skip
        """The cycle on one curve and back on another from the radius ``turn`` [m] (None: the end of the series)."""
        traced = cycle(inwards, outwards, stiffness, turn)
        if isinstance(traced, Unknown):
            raise InputError(f"{file}: {traced.reason}")
        return cls(file, traced, points)

    @cached_property
    def columns(self) -> dict[str, Array]:  # type: ignore[override]
        return trace(self.cycle, self.points)

    def figure(self) -> Figure:
        from .plots.forward import cycle_figure

        contact = self.cycle.contact
        title = tables.cycle_title(control(self.cycle.stiffness), contact.advancing.w, contact.receding.w, self.remark)
        return cycle_figure(self.columns, title)

    @cached_property
    def _energies(self) -> tuple[tuple[str, Estimate, Estimate], ...]:
        """Both energies [J] by their names, with their half-widths."""
        cycle = self.cycle
        return (
            ("energy lost per cycle", cycle.energy_lost, device_path.energy_lost_error(cycle)),
            ("work of separation", cycle.separation, device_path.separation_error(cycle.retraction)),
        )

    def summary(self) -> dict[str, Any]:
        """Jumps, turn and energies of a trace, SI."""
        cycle = self.cycle
        return {
            "file": str(self.file),
            **tables.device(cycle.stiffness),
            "level": LEVEL,
            "w_approach_J_per_m2": cycle.contact.advancing.w,
            "w_retract_J_per_m2": cycle.contact.receding.w,
            "jump_in": tables.point(cycle.begin),
            "turn_a_m": cycle.contact.advancing.point(cycle.turn).a,
            "jumps_on_approach": [tables.jump(jump) for jump in cycle.approach.jumps],
            "jumps_on_retraction": [tables.jump(jump) for jump in cycle.retraction.jumps],
            "contact_lost": cycle.retraction.ends == "lost",
            **tables.energies(energy_lost=self._energies[0][1:], work_of_separation=self._energies[1][1:]),
            **(tables.strains(self.large_strains) if cycle.retraction.ends == "lost" else {}),
        }

    def words(self) -> list[str]:
        """In the order in which the device passes its events."""
        cycle, inwards, outwards = self.cycle, self.cycle.contact.advancing, self.cycle.contact.receding
        begin, onset = cycle.begin, inwards.onset
        jump_in = f"jump-in at delta = {show(onset, 'length') if onset else 0} to"
        start = jump_in if inwards.w > 0 else "contact begins at a point; first computed state:"
        # Each energy [J] by its name, with its half-width; those of one reason why there are none together
        known = [one for one in self._energies if not isinstance(one[1], Unknown)]
        parts = [f"{name} {tables.energy_words(energy, error)}" for name, energy, error in known]
        unknown = {name: energy.reason for name, energy, _ in self._energies if isinstance(energy, Unknown)}
        for reason in dict.fromkeys(unknown.values()):
            parts.append(f"{' and '.join(name for name, why in unknown.items() if why == reason)}: none, {reason}")
        energy_words = "; ".join(parts)
        lines = [
            f"{energy_words}{f' ({AT_LEVEL} confidence)' * ('±' in energy_words)}: {self.file}",
            _device_words(cycle.stiffness, inwards.w, outwards.w),
            f"  {start} {tables.format_state(begin, 'P a')}",
            f"  reversal at {tables.format_state(inwards.point(cycle.turn), 'a')}",
            *(f"  {_jump(jump)}" for jump in (*cycle.approach.jumps, *cycle.retraction.jumps)),
        ]
        if cycle.retraction.ends != "lost":
            lines.append("  contact is not lost within the solution: the trace ends at its smallest radius")
        else:
            lines += _strain_lines(self.large_strains)
        return lines


def _strain_lines(change: Strains) -> list[str]:
    """The line of a cycle on what large strains ``change`` of its pull-off force; none where that is negligible."""
    return [] if change is None else [f"  {strain_words(change)} of the pull-off force (model)"]


@dataclass(frozen=True, eq=False)
class CycledByProgram(Result):
    """What a device records that does what a table says, however slowly, with turns anywhere; ``points``: rows of a
    piece; ``large_strains``: of the pull-off force, where contact is lost."""

    file: Path
    trace: device_path.Path
    points: int = ROWS
    large_strains: Strains = None

    @classmethod
    def of(cls, curves: Sequence[Analysis], stiffness: float, program: Program, points: int = ROWS) -> CycledByProgram:
        """The path on the ``curves`` of approach and retraction under ``program``; a step would have no way."""
        if (steps := np.flatnonzero(np.diff(program.t) == 0)).size:
            raise InputError(f"program: row {int(steps[0]) + 2}: a jump needs a duration: a later time, or --rate")
        inwards, outwards = (result.curve for result in curves)
        traced = device_path.path(device_path.QuasiStatic(inwards, outwards, stiffness), program)
        if traced.out_of_series is not None:
            raise InputError(f"{curves[0].path}: {traced.out_of_series}")
        lost = any(jump.end is None for jump in traced.jumps)
        change = curves[1].large_strains(outwards.pull_off(stiffness)) if lost else None
        return cls(curves[0].path, traced, points, change)

    @cached_property
    def columns(self) -> dict[str, Array]:  # type: ignore[override]
        return {name: column for name, column in self.trace.rows(self.points).items() if name != "G_J_per_m2"}

    def figure(self) -> Figure:
        from .plots.forward import history_figure

        inwards, outwards = self.trace.contact.advance.curve, self.trace.contact.recede.curve
        title = tables.cycle_title(self.trace.control, inwards.w, outwards.w)
        return history_figure(self.columns, self.trace.jumps, title)

    def summary(self) -> dict[str, Any]:
        trace = self.trace
        return {
            "file": str(self.file),
            **tables.device(trace.contact.stiffness),
            "w_approach_J_per_m2": trace.contact.advance.curve.w,
            "w_retract_J_per_m2": trace.contact.recede.curve.w,
            "jumps": list(map(tables.timed_jump, trace.jumps)),
            "contact_lost": trace.pieces[-1].ends == "lost" or trace.pieces[-1].phase == device_path.FREE,
            "work_of_device_J": trace.work,
            **tables.strains(self.large_strains),
        }

    def words(self) -> list[str]:
        trace = self.trace
        works = (edge.curve.w for edge in (trace.contact.advance, trace.contact.recede))
        return [
            f"work of the instrument {show(trace.work, 'energy')}: {self.file}",
            _device_words(trace.contact.stiffness, *works),
            *(f"  t = {show(jump.t, 'time')}: {_jump(jump)}" for jump in trace.jumps),
            *_strain_lines(self.large_strains),
        ]


def _device_words(stiffness: float, approach: float, retraction: float) -> str:
    """The control, and the works of adhesion [J/m^2]."""
    return f"  {control(stiffness)}, w = {show(approach, 'work')} on approach, {show(retraction, 'work')} on retraction"


def _jump(jump: Jump) -> str:
    start = tables.format_state(jump.start)
    if jump.end is None:
        return f"contact is lost at {start}"
    return f"contact jumps from {start} to {tables.format_state(jump.end, 'P a')}"


# --------------------------------------------------------------------------------------------------
# Two results of the same problem: how far they lie apart, column by column.


@dataclass(frozen=True, eq=False)
class Compared(Result):
    """Differences of the ``second`` from the ``first``; they ``agree`` where none of the columns that are ``counting``
    differs by more than ``rtol``."""

    first: Path
    second: Path
    differences: Sequence[Difference]
    rtol: float
    counting: Collection[str]

    @classmethod
    def of(
        cls, files: tuple[Path, Path], solutions: Callable[[], Sequence[Solution]], rtol: float,
        counting: Iterable[str], overlap: float,
    ) -> Compared:  # fmt: skip
        """Two CSV ``files`` of adhesive curves, of which all columns count where none is named, or else the series that
        ``solutions`` gives, of which P does. InputError where a column is not in both, or where less than ``overlap``
        of their range is."""
        if files[0].suffix == ".csv":
            differences = curve_differences(*map(read_curve, files))
            counts = set(counting) or {column.column for column in differences}
        else:
            one, two = solutions()
            for name in ("indenter", "specimen"):
                if getattr(one.problem, name) != getattr(two.problem, name):
                    raise InputError(
                        f"{files[1]}: its {name} is not that of {files[0]}; compare results of the same problem"
                    )
            differences, counts = series_differences(one.filtered, two.filtered), set(counting) or {"P"}
        if missing := counts - {difference.column for difference in differences}:
            raise InputError(f"compare: column {sorted(missing)[0]} is not in both files")
        for column in differences:
            if column.column in counts and column.coverage < overlap:
                raise InputError(
                    f"compare: {files[0]} and {files[1]} share only {column.coverage:.0%} of their range of "
                    f"{column.over}; load both as far, or allow it with --overlap {column.coverage:.2f}"
                )
        return cls(*files, differences, rtol, counts)

    @property
    def agree(self) -> bool:
        return all(one.worst <= self.rtol for one in self.differences if one.column in self.counting)

    @property
    def _rows(self) -> Mapping[str, Mapping[str, Any]]:
        return {
            one.column: {
                "worst": one.worst,
                "over": one.over,
                "at": float(one.x[one.worst_row]),
                "counts": one.column in self.counting,
            }
            for one in self.differences
        }

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        return transpose_rows([{"column": name, **row} for name, row in self._rows.items()])

    def summary(self) -> dict[str, Any]:
        files = {"first": str(self.first), "second": str(self.second)}
        return files | {"rtol": self.rtol, "agree": self.agree, "columns": dict(self._rows)}

    def words(self) -> list[str]:
        lines = [f"{self.first} against {self.second}: {'agree' if self.agree else 'DIFFER'} at rtol {self.rtol:g}"]
        for one in self.differences:
            counts = "" if one.column in self.counting else "  (not counted)"
            where = f"at {one.over} = {one.x[one.worst_row]:.6g}, {one.x.size} rows of {self.first.name}"
            lines.append(f"  {one.column:<16} worst {one.worst:.3e} {where}{counts}")
        return lines

    def figure(self) -> Figure:
        from .plots.forward import differences_figure

        return differences_figure(self.differences, self.rtol)


# --------------------------------------------------------------------------------------------------
# One state of a contact as a result: pressure and shape of its surface, displacement and stress in the body.


@dataclass(frozen=True, eq=False)
class Profile(Result):
    """Pressure, displacement and gap over r around a contact of radius ``a`` [m] with ``w`` [J/m^2]."""

    path: Path
    a: float
    w: float
    columns: Mapping[str, Array]

    def summary(self) -> dict[str, Any]:
        return {"file": str(self.path), **quantities(self, "a w"), **lists(self.columns)}

    def words(self) -> list[str]:
        r, pressure = self.columns["r_m"], self.columns["pressure_Pa"]
        pulled = r[(r < self.a) & (pressure < 0)]
        tension = f"; tension from r = {show(float(pulled[0]), 'length')} to the edge" if pulled.size else ""
        return [
            f"{format_state(self, 'a w')}: {self.path}",
            f"  pressure at the axis {show(float(pressure[0]), 'modulus')}{tension}",
        ]

    def figure(self) -> Figure:
        from .plots.forward import profile_figure

        return profile_figure(self.columns, self.a, self.w)


@dataclass(frozen=True)
class AskedCycle:
    """A cycle asked for on a ``solution``, with the ``works`` of adhesion [J/m^2] on approach and retraction, by a
    device of a ``stiffness`` [N/m] that turns at a load [N] or depth [m], or follows a ``program``."""

    solution: Solution
    works: tuple[float, float]
    stiffness: float
    ranged: RangeRequest
    slopes: str = "auto"
    modulus_factor: float = 1.0
    to_load: float | None = None
    to_depth: float | None = None
    program: Program | None = None
    points: int = ROWS

    def quasi_static(self) -> Cycled | CycledByProgram:
        """The trace."""
        analysed = analyse(self.solution, self.works, self.slopes, self.modulus_factor, self.ranged)
        curves = [with_solved_points(curve, self.stiffness) for curve in analysed]
        if self.program is not None:
            return CycledByProgram.of(curves, self.stiffness, self.program, self.points)
        return Cycled.of(curves, self.stiffness, self.to_load, self.to_depth, self.points)


# --------------------------------------------------------------------------------------------------
# The contact of a specimen that relaxes, which a wing knows.


class ByHistory(Protocol):
    """How a specimen that relaxes lets go, after each history of its loading for which that is known."""

    def seconds(self, works: Sequence[float], devices: int) -> float:
        """CPU seconds of the pull-offs by so many ``devices``, for each of the ``works`` [J/m^2], beside the curve."""

    def pull_off(self, result: Analysis, lost: Sequence[Lost], controls: Sequence[float], slopes: str) -> PullOff:
        """Where contact is lost under ``controls``, beside what is ``lost`` with the moduli as they are."""

    def cycle(self, asked: AskedCycle) -> Result:
        """The cycle that is ``asked`` for."""

    def work(
        self, load: float, stiffness: float, slopes: str, modulus_factor: float, uncertain: Sequence[tuple[str, str]]
    ) -> Result | None:
        """Which works of adhesion a pull-off force means (``measured``); None where no history is known."""


def by_history(
    solution: Solution, rest_load: float | None = None, rest_depth: float | None = None,
    called: Callable[[str], str] = str,
) -> ByHistory | None:  # fmt: skip
    """What is known of the specimen of ``solution`` if it relaxes, at rest under a load [N] or at a depth [m] before it
    is pulled; None where it is elastic. InputError, options as they are ``called``, where a rest makes no sense, or
    where the wing is not there."""
    if solution.problem.specimen.relaxation is None and rest_load is None and rest_depth is None:
        return None
    if (known := offered("how a specimen that relaxes lets go")) is None:
        refused = f"contact of a viscoelastic specimen over time {absent('contact over time')}"
        raise InputError(f"{solution.record.path}: {refused}")
    found: ByHistory = known(solution, rest_load, rest_depth, called)
    return found

"""The cycle of a device in equilibrium: its trace, in words and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..adhesion import (
    CriticalPoint,
    Cycle,
    EquilibriumCurve,
    FromRest,
    Jump,
    Program,
    Strains,
    control,
    cycle,
    energy_lost_error,
    path,
    separation_error,
    strain_words,
    trace,
    turning_radius,
)
from ..base import ROWS, Array, Estimate, InputError, Unknown, show
from ..beside import Analysis
from . import tables
from .result import Figure, Result


@dataclass(frozen=True, eq=False)
class Cycled(Result):
    """What a device records that presses bodies together and pulls them apart, however slowly; ``points``: rows of a
    branch; ``history``: of a viscoelastic specimen, in words; ``large_strains``: of the pull-off force."""

    file: Path
    cycle: Cycle
    points: int = ROWS
    history: str = ""
    large_strains: Strains = None

    @classmethod
    def of(
        cls, curves: Sequence[Analysis], stiffness: float, load: float | None = None, depth: float | None = None,
        points: int = ROWS, history: str = "",
    ) -> Cycled:  # fmt: skip
        """The cycle on the ``curves`` of approach and retraction that turns at a ``load`` [N] or ``depth`` [m]."""
        inwards, outwards = (result.curve for result in curves)
        whole = load is None and depth is None
        turn = None if whole else turning_radius(inwards, stiffness, load=load, depth=depth)
        found = cls.on(curves[0].path, inwards, outwards, stiffness, turn, points, history)
        lost = outwards.pull_off(stiffness)
        return replace(found, large_strains=curves[1].large_strains(lost)) if isinstance(lost, CriticalPoint) else found

    @classmethod
    def from_rest(
        cls, file: Path, relaxed: EquilibriumCurve, pulled: FromRest, stiffness: float, points: int = ROWS,
        history: str = "",
    ) -> Cycled:  # fmt: skip
        """The cycle of a viscoelastic specimen that is loaded slowly to the rest of ``pulled``, then pulled at once."""
        try:
            return cls.on(file, relaxed, pulled, stiffness, pulled.rest.a, points, history)
        except InputError as error:
            raise InputError(
                [line if line.startswith(str(file)) else f"{file}: {line}" for line in error.lines]
            ) from None

    @classmethod
    def on(
        cls, file: Path, inwards: EquilibriumCurve, outwards: EquilibriumCurve, stiffness: float, turn: float | None,
        points: int, history: str = "",
    ) -> Cycled:  # fmt: skip
        """The cycle on one curve and back on another from the radius ``turn`` [m] (None: the end of the series)."""
        traced = cycle(inwards, outwards, stiffness, turn)
        if isinstance(traced, Unknown):
            raise InputError(f"{file}: {traced.reason}")
        return cls(file, traced, points, history)

    @cached_property
    def columns(self) -> dict[str, Array]:  # type: ignore[override]
        return trace(self.cycle, self.points)

    def figure(self) -> Figure:
        from .plots.curve import cycle_figure

        contact = self.cycle.contact
        title = tables.cycle_title(control(self.cycle.stiffness), contact.advancing.w, contact.receding.w, self.history)
        return cycle_figure(self.columns, title)

    @cached_property
    def _energies(self) -> tuple[tuple[str, Estimate, Estimate], ...]:
        """Both energies [J] by their names, with their half-widths."""
        cycle = self.cycle
        return (
            ("energy lost per cycle", cycle.energy_lost, energy_lost_error(cycle)),
            ("work of separation", cycle.separation, separation_error(cycle.retraction)),
        )

    def summary(self) -> dict[str, Any]:
        """Jumps, turn and energies of a trace, SI."""
        cycle = self.cycle
        return {
            "file": str(self.file),
            **tables.device(cycle.stiffness),
            "w_approach_J_per_m2": cycle.contact.advancing.w,
            "w_retract_J_per_m2": cycle.contact.receding.w,
            "jump_in": tables.point(cycle.begin),
            "turn_a_m": cycle.contact.advancing.point(cycle.turn).a,
            "jumps_on_approach": [tables.jump(jump) for jump in cycle.approach.jumps],
            "jumps_on_retraction": [tables.jump(jump) for jump in cycle.retraction.jumps],
            "contact_lost": cycle.retraction.ends == "lost",
            **tables.energies(energy_lost=self._energies[0][1:], work_of_separation=self._energies[1][1:]),
            **tables.strains(self.large_strains),
        }

    def words(self) -> list[str]:
        """In the order in which the device passes its events."""
        cycle, inwards, outwards = self.cycle, self.cycle.contact.advancing, self.cycle.contact.receding
        begin, onset = cycle.begin, inwards.onset
        jump_in = f"jump-in at delta = {show(onset, 'length') if onset else 0} to"
        start = jump_in if inwards.w > 0 else "contact grows from a point; first of the series:"
        lines = [
            f"{_energy_words(self._energies)}: {self.file}",
            _device_words(cycle.stiffness, inwards.w, outwards.w),
            f"  {start} {tables.state_words(begin, 'P a')}",
            f"  turn at {tables.state_words(inwards.point(cycle.turn), 'a')}",
            *(f"  {_jump(jump)}" for jump in (*cycle.approach.jumps, *cycle.retraction.jumps)),
        ]
        if cycle.retraction.ends != "lost":
            lines.append("  contact is not lost within the series: the trace ends at its smallest radius")
        elif self.large_strains is not None:
            lines.append(f"  {strain_words(self.large_strains)} of the pull-off force (model)")
        return lines


@dataclass(frozen=True, eq=False)
class CycledByProgram(Result):
    """What a device records that does what a table says, however slowly, with turns anywhere; ``points``: rows of a
    piece."""

    file: Path
    trace: path.Path
    points: int = ROWS

    @classmethod
    def of(cls, curves: Sequence[Analysis], stiffness: float, program: Program, points: int = ROWS) -> CycledByProgram:
        """The path on the ``curves`` of approach and retraction under ``program``; a step would have no way."""
        if (steps := np.flatnonzero(np.diff(program.t) == 0)).size:
            raise InputError(f"program: row {int(steps[0]) + 2} is a step: without --rate give it the time of a way")
        inwards, outwards = (result.curve for result in curves)
        traced = path.path(path.QuasiStatic(inwards, outwards, stiffness), program)
        if traced.out_of_series is not None:
            raise InputError(f"{curves[0].path}: {traced.out_of_series}")
        return cls(curves[0].path, traced, points)

    @cached_property
    def columns(self) -> dict[str, Array]:  # type: ignore[override]
        return {name: column for name, column in self.trace.rows(self.points).items() if name != "G_J_per_m2"}

    def figure(self) -> Figure:
        from .plots.rate import history_figure

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
            "contact_lost": trace.pieces[-1].ends == "lost" or trace.pieces[-1].phase == path.FREE,
            "work_of_device_J": trace.work,
        }

    def words(self) -> list[str]:
        trace = self.trace
        works = (edge.curve.w for edge in (trace.contact.advance, trace.contact.recede))
        return [
            f"work of the device {trace.work:.4g} J: {self.file}",
            _device_words(trace.contact.stiffness, *works),
            *(f"  t = {show(jump.t, 'time')}: {_jump(jump)}" for jump in trace.jumps),
        ]


def _energy_words(energies: Sequence[tuple[str, Estimate, Estimate]]) -> str:
    """Each energy [J] by its name, with its half-width; those of one reason why there are none together."""
    known = [one for one in energies if not isinstance(one[1], Unknown)]
    parts = [f"{name} {tables.energy_words(energy, error)}" for name, energy, error in known]
    unknown = {name: energy.reason for name, energy, _ in energies if isinstance(energy, Unknown)}
    for reason in dict.fromkeys(unknown.values()):
        parts.append(f"{' and '.join(name for name, why in unknown.items() if why == reason)}: none, {reason}")
    return "; ".join(parts)


def _device_words(stiffness: float, approach: float, retraction: float) -> str:
    """The control, and the works of adhesion [J/m^2]."""
    return f"  {control(stiffness)}, w = {show(approach, 'work')} on approach, {show(retraction, 'work')} on retraction"


def _jump(jump: Jump) -> str:
    start = tables.state_words(jump.start)
    if jump.end is None:
        return f"contact is lost at {start}"
    return f"contact jumps from {start} to {tables.state_words(jump.end, 'P a')}"

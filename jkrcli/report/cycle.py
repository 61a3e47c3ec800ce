"""The cycle of a device in equilibrium: its trace, in words and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..adhesion import Cycle, Jump, Program, control, cycle, path, trace, turning_radius
from ..base import ROWS, Array, InputError, Unknown, show
from ..beside import Analysis
from . import tables
from .result import Figure, Result


@dataclass(frozen=True, eq=False)
class Cycled(Result):
    """What a device records that presses bodies together and pulls them apart, however slowly; ``points``: rows of a
    branch."""

    file: Path
    found: Cycle
    points: int = ROWS

    @classmethod
    def of(
        cls, curves: Sequence[Analysis], stiffness: float, load: float | None = None, depth: float | None = None,
        points: int = ROWS,
    ) -> Cycled:  # fmt: skip
        """The cycle on the ``curves`` of approach and retraction that turns at a ``load`` [N] or ``depth`` [m]."""
        inwards, outwards = (result.curve for result in curves)
        whole = load is None and depth is None
        turn = None if whole else turning_radius(inwards, stiffness, load=load, depth=depth)
        found = cycle(inwards, outwards, stiffness, turn)
        if isinstance(found, Unknown):
            raise InputError(f"{curves[0].path}: {found.reason}")
        return cls(curves[0].path, found, points)

    @cached_property
    def columns(self) -> dict[str, Array]:  # type: ignore[override]
        return trace(self.found, self.points)

    def figure(self) -> Figure:
        from .plots.curve import cycle_figure

        return cycle_figure(self.columns, control(self.found.stiffness))

    def summary(self) -> dict[str, Any]:
        """Jumps, turn and energies of a trace, SI."""
        found = self.found
        return {
            "file": str(self.file),
            "control": control(found.stiffness),
            "stiffness_N_per_m": tables.stiffness(found.stiffness),
            "w_approach_J_per_m2": found.contact.advancing.w,
            "w_retract_J_per_m2": found.contact.receding.w,
            "jump_in": tables.point(found.begin),
            "turn_a_m": found.contact.advancing.point(found.turn).a,
            "jumps_on_approach": [tables.jump(jump) for jump in found.approach.jumps],
            "jumps_on_retraction": [tables.jump(jump) for jump in found.retraction.jumps],
            "contact_lost": found.retraction.ends == "lost",
            **tables.energies(energy_lost=found.energy_lost, work_of_separation=found.separation),
        }

    def words(self) -> list[str]:
        """In the order in which the device passes its events."""
        found, inwards = self.found, self.found.contact.advancing
        works = [show(curve.w, "work") for curve in (inwards, found.contact.receding)]
        begin, onset = found.begin, inwards.onset
        jump_in = f"jump-in at delta = {show(onset, 'length') if onset else 0} to"
        start = jump_in if inwards.w > 0 else "contact grows from a point; first of the series:"
        energies = {"energy lost per cycle": found.energy_lost, "work of separation": found.separation}
        told = [item if isinstance(item, Unknown) else f"{name} {item:.4g} J" for name, item in energies.items()]
        lines = [
            f"{'; '.join(dict.fromkeys(map(str, told)))}: {self.file}",
            f"  {control(found.stiffness)}, w = {works[0]} on approach, {works[1]} on retraction",
            f"  {start} P = {show(begin.P, 'load')}, a = {show(begin.a, 'length')}",
            f"  turn at a = {show(inwards.point(found.turn).a, 'length')}",
            *(f"  {_jump(jump)}" for jump in (*found.approach.jumps, *found.retraction.jumps)),
        ]
        if found.retraction.ends != "lost":
            lines.append("  contact is not lost within the series: the trace ends at its smallest radius")
        return lines


@dataclass(frozen=True, eq=False)
class CycledByProgram(Result):
    """What a device records that does what a table says, however slowly, with turns anywhere; ``points``: rows of a
    piece."""

    file: Path
    found: path.Path
    points: int = ROWS

    @classmethod
    def of(cls, curves: Sequence[Analysis], stiffness: float, program: Program, points: int = ROWS) -> CycledByProgram:
        """The path on the ``curves`` of approach and retraction under ``program``; a step would have no way."""
        if (steps := np.flatnonzero(np.diff(program.t) == 0)).size:
            raise InputError(f"program: row {int(steps[0]) + 2} is a step: without --rate give it the time of a way")
        inwards, outwards = (result.curve for result in curves)
        found = path.path(path.QuasiStatic(inwards, outwards, stiffness), program)
        if found.out_of_series is not None:
            raise InputError(f"{curves[0].path}: {found.out_of_series}")
        return cls(curves[0].path, found, points)

    @cached_property
    def columns(self) -> dict[str, Array]:  # type: ignore[override]
        return {name: column for name, column in self.found.rows(self.points).items() if name != "G_J_per_m2"}

    def figure(self) -> Figure:
        from .plots.rate import history_figure

        return history_figure(self.columns, self.found.jumps, self.found.control)

    def summary(self) -> dict[str, Any]:
        found, k = self.found, self.found.contact.stiffness
        return {
            "file": str(self.file),
            "control": found.control,
            "stiffness_N_per_m": tables.stiffness(k),
            "w_approach_J_per_m2": found.contact.advance.equilibrium.curve.w,
            "w_retract_J_per_m2": found.contact.recede.equilibrium.curve.w,
            "jumps": list(map(tables.timed_jump, found.jumps)),
            "contact_lost": found.pieces[-1].ends == "lost" or found.pieces[-1].phase == path.FREE,
            "work_of_device_J": found.work,
        }

    def words(self) -> list[str]:
        told = self.summary()
        works = [show(told[name], "work") for name in ("w_approach_J_per_m2", "w_retract_J_per_m2")]
        return [
            f"work of the device {told['work_of_device_J']:.4g} J: {self.file}",
            f"  {told['control']}, w = {works[0]} on approach, {works[1]} on retraction",
            *(f"  t = {show(jump.t, 'time')}: {_jump(jump)}" for jump in self.found.jumps),
        ]


def _jump(jump: Jump) -> str:
    start = f"P = {show(jump.start.P, 'load')}, delta = {show(jump.start.delta, 'length')}, "
    start += f"a = {show(jump.start.a, 'length')}"
    if jump.end is None:
        return f"contact is lost at {start}"
    return f"contact jumps from {start} to P = {show(jump.end.P, 'load')}, a = {show(jump.end.a, 'length')}"

"""The trace of a device, in words and as JSON."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..adhesion.device import control
from ..adhesion.path import Jump
from ..adhesion.stability import Cycle
from ..base.units import show
from ..base.unknown import Unknown
from . import tables


def summary(file: Path, found: Cycle) -> dict[str, Any]:
    """Jumps, turn and energies of a trace, SI."""
    return {
        "file": str(file),
        "control": control(found.stiffness),
        "stiffness_N_per_m": tables.stiffness(found.stiffness),
        "w_approach_J_per_m2": found.contact.advancing.w,
        "w_retract_J_per_m2": found.contact.receding.w,
        "jump_in": tables.point(found.begin),
        "turn_a_m": found.contact.advancing.point(found.turn).a,
        "jumps_on_approach": [tables.jump(jump) for jump in found.jumps_in],
        "jumps_on_retraction": [tables.jump(jump) for jump in found.jumps_out],
        "contact_lost": found.retraction.ends == "lost",
        **tables.energies(found.energy_lost, found.separation),
    }


def words(file: Path, found: Cycle) -> list[str]:
    """A trace as lines of text, in the order in which the device passes its events."""
    works = [show(curve.w, "work") for curve in (found.contact.advancing, found.contact.receding)]
    begin, onset = found.begin, found.contact.advancing.onset
    jump_in = f"jump-in at delta = {show(onset, 'length') if onset else 0} to"
    start = jump_in if found.contact.advancing.w > 0 else "contact grows from a point; first of the series:"
    energies = {"energy lost per cycle": found.energy_lost, "work of separation": found.separation}
    told = [f"{name} {value if isinstance(value, Unknown) else f'{value:.4g} J'}" for name, value in energies.items()]
    lines = [
        f"{'; '.join(told)}: {file}",
        f"  {control(found.stiffness)}, w = {works[0]} on approach, {works[1]} on retraction",
        f"  {start} P = {show(begin.P, 'load')}, a = {show(begin.a, 'length')}",
        f"  turn at a = {show(found.contact.advancing.point(found.turn).a, 'length')}",
        *(f"  {_jump(jump)}" for jump in (*found.jumps_in, *found.jumps_out)),
    ]
    if found.retraction.ends != "lost":
        lines.append("  contact is not lost within the series: the trace ends at its smallest radius")
    return lines


def _jump(jump: Jump) -> str:
    start = f"P = {show(jump.start.P, 'load')}, delta = {show(jump.start.delta, 'length')}, "
    start += f"a = {show(jump.start.a, 'length')}"
    if jump.end is None:
        return f"contact is lost at {start}"
    return f"contact jumps from {start} to P = {show(jump.end.P, 'load')}, a = {show(jump.end.a, 'length')}"

"""The history of a contact that relaxes as a summary and in words."""

from __future__ import annotations

from typing import Any

from ..adhesion.path import TimedState
from ..adhesion.relaxation.history import HISTORY, RelaxedHistory
from ..base.units import SI, show
from ..bodies.relaxation import RELAXATIONS, Relaxation
from .tables import point, stiffness

NEGLECTED = (
    "one relaxation function for all layers, and for the half-space below them, at constant Poisson's ratios; no "
    "adhesion, inertia or friction"
)


def law_summary(law: Relaxation) -> dict[str, Any]:
    """The law and its parameters, times in s."""
    name, values = RELAXATIONS.keys_in_file(law)
    units = {key: SI["time"] for key in values if key.startswith("time")}
    return {"law": name} | {f"{key}_{units[key]}" if key in units else key: value for key, value in values.items()}


def summary(history: RelaxedHistory) -> dict[str, Any]:
    """What stands in the JSON of ``jkr cycle``."""
    return {
        "control": history.control,
        "stiffness_N_per_m": stiffness(history.contact.stiffness),
        "relaxation": law_summary(history.contact.law),
        "largest_load": _state(history.peak),
        "turn_t_s": history.turn,
        "corners": [_state(corner) for corner in history.corners],
        "contact_lost": history.lost is not None,
        "lost_t_s": history.lost,
        "load_relative_error": history.error,
        "neglected": NEGLECTED,
    }


def words(history: RelaxedHistory) -> list[str]:
    """Lines for people."""
    peak, lost = history.peak, history.lost
    lines = [
        f"largest load {show(peak.P, 'load')} at t = {show(peak.t, 'time')}, delta = {show(peak.delta, 'length')}, "
        f"a = {show(peak.a, 'length')}",
        f"  {history.control}, no adhesion; {history.contact.law}",
    ]
    for corner in history.corners:
        if corner.t > peak.t:
            lines.append(
                f"  at t = {show(corner.t, 'time')} P = {show(corner.P, 'load')}, delta = "
                f"{show(corner.delta, 'length')}, a = {show(corner.a, 'length')}"
            )
    ends = "contact is not lost" if lost is None else f"contact is lost at t = {show(lost, 'time')}"
    return [*lines, f"  {ends}; it stopped to grow at t = {show(history.turn, 'time')}"]


def warnings_of(history: RelaxedHistory) -> list[str]:
    """What a reader should know, each with its number."""
    return [f"the loads err by about {history.error:.1g} of the largest"] if history.error > HISTORY.accurate else []


def _state(state: TimedState) -> dict[str, Any]:
    return point(state) | {"t_s": state.t}

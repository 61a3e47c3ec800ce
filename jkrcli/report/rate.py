"""A history of rate-dependent adhesion as a summary and in words."""

from __future__ import annotations

from typing import Any

from ..adhesion.device import LOAD_CONTROL
from ..adhesion.path import Jump, TimedState
from ..adhesion.rate.history import History
from ..adhesion.rate.laws import RateLaw, parameters_of, rate_parameters
from ..adhesion.rate.validity import NEGLECTED, Zone
from ..base.units import SI, show
from ..base.unknown import Unknown, known
from ..identification.rate.through import LawThrough
from .tables import point, stiffness

ACCURATE = 1e-6  # choice: error of the integration beyond which a reader is warned
VAGUE = 1.0  # choice: relative standard error beyond which a parameter is not told
BALANCED = 1e-4  # choice: the same of the balance of energies


def law_words(law: RateLaw) -> str:
    """The law and its parameters as people write them."""
    name, values = parameters_of(law)
    ranges = rate_parameters(name)
    told = ", ".join(f"{key} = {show(value, ranges[key].dimension)}" for key, value in values.items())
    return f"{name} law, {told}"


def law_summary(law: RateLaw | None) -> dict[str, Any] | None:
    """The law and its parameters, keys with their units."""
    if law is None:
        return None
    name, values = parameters_of(law)
    units = {key: SI[ranged.dimension].replace("/", "_per_").replace("^", "")
             for key, ranged in rate_parameters(name).items()}  # fmt: skip
    return {"law": name} | {f"{key}_{units[key]}".rstrip("_"): value for key, value in values.items()}


def summary(history: History, zone: Zone) -> dict[str, Any]:
    """What stands in the JSON of ``jkr cycle --rate``."""
    contact = history.contact
    error, lost = history.error, history.lost
    return {
        "control": history.control,
        "stiffness_N_per_m": stiffness(contact.stiffness),
        "w_approach_J_per_m2": contact.w_advance,
        "w_retract_J_per_m2": contact.w0,
        "rate": law_summary(contact.law),
        "rate_advance": law_summary(contact.law_advance),
        "pull_off": _state(history.pull_off)
        | {f"{name}_relative_error": known(error[name]) for name in ("P", "t")}
        | {"edge_speed_m_per_s": history.fastest},
        "turn_t_s": history.turn,
        "jumps": [_jump(jump) for jump in history.jumps],
        "contact_lost": lost is not None,
        "lost_t_s": None if lost is None else lost.t,
        "lost_t_relative_error": known(error["lost"]),
        "waited_s": history.waited,
        "energy_lost_J": known(history.energy_lost),
        "energy_lost_reason": history.energy_lost if isinstance(history.energy_lost, Unknown) else None,
        "dissipated_at_edge_J": history.dissipated,
        "balance_relative_error": history.balance,
        "zone": {
            "width_m": known(zone.width),
            "over_a": known(zone.over_a),
            "over_h": known(zone.over_h),
            "reason": zone.width if isinstance(zone.width, Unknown) else None,
        },
        "neglected": NEGLECTED,
    }


def warnings_of(history: History, zone: Zone) -> list[str]:
    """What a reader should know, each with its number."""
    worst = max(value for name in ("P", "t", "lost") if (value := known(history.error[name])) is not None)
    found = [f"the integration errs by about {worst:.1g}"] if worst > ACCURATE else []
    if history.balance > BALANCED:
        found.append(
            f"the energies balance to {history.balance:.1g} only: the series' P_H, S and S' contradict each other"
        )
    return [*found, *zone.warnings]


def words(history: History, zone: Zone) -> list[str]:
    """Lines for people."""
    contact, pulled, lost = history.contact, history.pull_off, history.lost
    works = show(contact.w_advance, "work"), show(contact.w0, "work")
    lines = [
        f"pull-off force {show(-pulled.P, 'load')} at t = {show(pulled.t, 'time')}, delta = "
        f"{show(pulled.delta, 'length')}, a = {show(pulled.a, 'length')}; edge up to {show(history.fastest, 'speed')}",
        f"  {history.control}, w = {works[0]} on approach, from {works[1]} on retraction; {law_words(contact.law)}",
    ]
    for jump in history.jumps:
        if jump.end is not None:
            lines.append(
                f"  contact jumps at t = {show(jump.t, 'time')} from a = {show(jump.start.a, 'length')} to "
                f"a = {show(jump.end.a, 'length')}, P = {show(jump.end.P, 'load')}"
            )
    told = "contact is not lost" if lost is None else f"contact is lost at t = {show(lost.t, 'time')}"
    if lost is not None and history.waited is not None:
        held = (
            f"at P = {show(lost.start.P, 'load')}" if contact.stiffness == LOAD_CONTROL else "with the device at rest"
        )
        told += f", after {show(history.waited, 'time')} {held}"
    lines.append(f"  {told}; the contact stopped to grow at t = {show(history.turn, 'time')}")
    energy = history.energy_lost
    lines.append(f"  energy lost: {energy if isinstance(energy, Unknown) else f'{energy:.4g} J'}")
    lines.append(f"  dissipating zone at the edge: {zone.words}")
    return lines


def _state(state: TimedState) -> dict[str, Any]:
    return point(state) | {"t_s": state.t}


def _jump(jump: Jump) -> dict[str, Any]:
    return {"t_s": jump.t, "from": point(jump.start), "to": None if jump.end is None else point(jump.end)}


def through_summary(found: LawThrough | Unknown | None) -> dict[str, Any] | None:
    """The law through points of w over speed, or why there is none; None where no time was recorded."""
    if found is None or isinstance(found, Unknown):
        return None if found is None else {"law": None, "reason": found.reason}
    return {
        **(law_summary(found.law) or {}),
        "w0_J_per_m2": found.w0,
        "relative_standard_errors": found.errors,
        "speeds_m_per_s": list(found.speeds),
        "told": not found.narrow and found.inner is not None and all((e or 1) < VAGUE for e in found.errors.values()),
    }


def through_words(found: LawThrough | Unknown) -> str:
    """The law through points of w over the speed in a line; where no parameter is told within its limit, that none."""
    if isinstance(found, Unknown):
        return f"no law over speed: {found.reason}"
    low, high = (show(v, "speed", 3) for v in found.speeds)
    known = {name: error for name, error in found.errors.items() if error is not None and error <= VAGUE}
    if not known:
        return f"no law over speed: {low} to {high} tell none of {', '.join(found.names)}"
    told = {name: f"± {100 * known[name]:.2g} %" if name in known else "not told" for name in found.names}
    errors = ", ".join(f"{name} {word}" for name, word in told.items())
    doubt = "; less than a decade of speeds, or none of its exponents, tells v0 and n apart" if found.narrow else ""
    return f"w0 = {show(found.w0, 'work')}, {law_words(found.law)} ({errors}) between {low} and {high}{doubt}"

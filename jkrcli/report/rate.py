"""The cycle of a device while adhesion depends on speed: its trace, in words and as JSON."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from .. import adhesion
from ..adhesion.validity import NEGLECTED, Zone, zone
from ..base import ROWS, SAME, UNSEEN, Array, InputError, SolveError, Unknown, known, show
from ..beside import Analysis
from ..identification.rate.through import LawThrough
from .result import Figure, Result, as_result
from .tables import cycle_title, device, speed_words, state_words, timed, timed_jump, with_unit

VAGUE = 1.0  # relative standard error, theory: one as large as the parameter does not tell it from zero


def law_words(law: adhesion.RateLaw) -> str:
    """The law and its parameters as people write them."""
    name, values = adhesion.parameters_of(law)
    ranges = adhesion.rate_parameters(name)
    parameters = ", ".join(f"{key} = {show(value, ranges[key].dimension)}" for key, value in values.items())
    return f"{name} law, {parameters}"


def law_summary(law: adhesion.RateLaw | None) -> dict[str, Any] | None:
    """The law and its parameters, keys with their units."""
    if law is None:
        return None
    name, values = adhesion.parameters_of(law)
    ranges = adhesion.rate_parameters(name)
    return {"law": name} | {with_unit(key, ranges[key].dimension): value for key, value in values.items()}


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class CycledAtSpeed(adhesion.History, Result):
    """A history as a result; ``body``: the curve of retraction, ``stress`` [Pa] in the zone at the edge,
    ``points``: rows of a piece, ``history``: of a
    viscoelastic specimen, in words."""

    body: Analysis
    program: adhesion.Program
    stress: float | None = None
    points: int = ROWS
    history: str = ""

    @classmethod
    def of(cls, contact: adhesion.RateContact, program: adhesion.Program, body: Analysis, **more: Any) -> CycledAtSpeed:
        """What happens to ``contact`` under ``program``; InputError where it leaves the series."""
        try:
            history = contact.history(program)
        except SolveError as error:
            raise InputError(f"{body.path}: {error}") from None
        if history.out_of_series is not None:
            raise InputError(f"{body.path}: {history.out_of_series}")
        return as_result(cls, history, body=body, program=program, **more)

    @cached_property
    def columns(self) -> dict[str, Array]:  # type: ignore[override]
        return self.table(self.points)

    @cached_property
    def zone(self) -> Zone:
        """The dissipating zone at pull-off."""
        pulled, contact, problem = self.pull_off, self.contact, self.body.problem
        x = adhesion.position(pulled.delta, pulled.P, contact.stiffness)
        G = float(contact.states(np.array([pulled.a]), np.array([x])).G[0])
        z0 = self.body.solution.record.z0
        return zone(G, contact.w0, problem.E_star, pulled.a, problem.top_thickness, self.stress, z0)

    def figure(self) -> Figure:
        from .plots.rate import history_figure

        contact = self.contact
        how = f"{self.control}, {speed_words(self.program, contact.stiffness)}"
        title = cycle_title(how, contact.w_advance, contact.w0, law_words(contact.law), self.history)
        return history_figure(self.columns, self.jumps, title)

    def summary(self) -> dict[str, Any]:
        contact, zone = self.contact, self.zone
        error, lost, energy = self.error, self.lost, self.energy_lost
        return {
            "file": str(self.body.path),
            **device(contact.stiffness),
            "w_approach_J_per_m2": contact.w_advance,
            "w_retract_J_per_m2": contact.w0,
            "rate": law_summary(contact.law),
            "rate_advance": law_summary(contact.law_advance),
            "pull_off": timed(self.pull_off)
            | {f"{name}_relative_error": known(error[name]) for name in ("P", "t")}
            | {"edge_speed_m_per_s": self.fastest},
            "turn_t_s": self.turn,
            "jumps": list(map(timed_jump, self.jumps)),
            "contact_lost": lost is not None,
            "lost_t_s": None if lost is None else lost.t,
            "lost_t_relative_error": known(error["lost"]),
            "waited_s": self.waited,
            "energy_lost_J": known(energy),
            "energy_lost_reason": energy if isinstance(energy, Unknown) else None,
            "dissipated_at_edge_J": self.dissipated,
            "balance_relative_error": self.balance,
            "zone": {
                "width_m": known(zone.width),
                "over_a": known(zone.over_a),
                "over_h": known(zone.over_h),
                "reason": zone.width if isinstance(zone.width, Unknown) else None,
            },
            "neglected": NEGLECTED,
            "warnings": self.warnings,
        }

    @property
    def warnings(self) -> list[str]:
        """What a reader should know, each with its number."""
        worst = max(value for name in ("P", "t", "lost") if (value := known(self.error[name])) is not None)
        inexact = [f"the integration errs by about {worst:.1g}"] if worst > SAME else []
        balance = f"the energies balance to {self.balance:.1g} only: the series' P_H, S and S' contradict each other"
        return [*inexact, *[balance] * (self.balance > UNSEEN), *self.zone.warnings]

    def words(self) -> list[str]:
        contact, pulled, lost = self.contact, self.pull_off, self.lost
        works = show(contact.w_advance, "work"), show(contact.w0, "work")
        lines = [
            f"pull-off force {show(-pulled.P, 'load')} at {state_words(pulled, 't delta a')}; "
            f"edge up to {show(self.fastest, 'speed')}: {self.body.path}",
            f"  {self.control}, w = {works[0]} on approach, from {works[1]} on retraction; {law_words(contact.law)}",
            *(f"  contact jumps at t = {show(jump.t, 'time')} from {state_words(jump.start, 'a')} to "
              f"{state_words(jump.end, 'a P')}" for jump in self.jumps if jump.end is not None),
        ]  # fmt: skip
        end = "contact is not lost" if lost is None else f"contact is lost at t = {show(lost.t, 'time')}"
        if lost is not None and self.waited is not None:
            loaded = contact.stiffness == adhesion.LOAD_CONTROL
            where = f"at {state_words(lost.start, 'P')}" if loaded else "with the device at rest"
            end += f", after {show(self.waited, 'time')} {where}"
        lines.append(f"  {end}; the contact stopped growing at t = {show(self.turn, 'time')}")
        energy = self.energy_lost
        lines.append(f"  energy lost: {energy if isinstance(energy, Unknown) else f'{energy:.4g} J'}")
        lines.append(f"  dissipating zone at the edge: {self.zone.words}")
        return lines


def through_summary(through: LawThrough | Unknown | None) -> dict[str, Any] | None:
    """The law through points of w over speed, or why there is none; None where no time was recorded."""
    if through is None or isinstance(through, Unknown):
        return None if through is None else {"law": None, "reason": through.reason}
    return {
        **(law_summary(through.law) or {}),
        "w0_J_per_m2": through.w0,
        "relative_standard_errors": through.errors,
        "speeds_m_per_s": list(through.speeds),
        "told": not through.narrow
        and through.inner is not None
        and all((error or 1) < VAGUE for error in through.errors.values()),
    }


def through_words(through: LawThrough | Unknown) -> str:
    """The law through points of w over the speed in a line, or that the points determine none of its parameters."""
    if isinstance(through, Unknown):
        return f"no law over speed: {through.reason}"
    low, high = (show(v, "speed", 3) for v in through.speeds)
    known = {name: error for name, error in through.errors.items() if error is not None and error <= VAGUE}
    if not known:
        return f"no law over speed: {low} to {high} tell none of {', '.join(through.names)}"
    determined = {name: f"± {100 * known[name]:.2g} %" if name in known else "not told" for name in through.names}
    errors = ", ".join(f"{name} {word}" for name, word in determined.items())
    doubt = "; less than a decade of speeds does not separate v0 and n" if through.narrow else ""
    return f"w0 = {show(through.w0, 'work')}, {law_words(through.law)} ({errors}) between {low} and {high}{doubt}"

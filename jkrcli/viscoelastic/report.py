"""The cycle of a device while adhesion depends on speed: its trace, in words and as JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..adhesion.curve import LOAD_CONTROL, CriticalPoint, Nonadhesive, control, position
from ..adhesion.device_path import Program
from ..adhesion.finite_range import RangeRequest
from ..base.errors import AT_LEVEL, LEVEL, NOTICEABLE, Estimate, InputError, SolveError, Unknown, known
from ..base.numerics import ROWS, SAME, UNSEEN, Array
from ..base.registry import Result
from ..base.units import show
from ..bodies.problem import RELAXATIONS, Relaxation
from ..report.result import Figure
from ..report.tables import cycle_title, device, energies, format_state, timed, timed_jump, with_unit
from ..resolve.analysis import Analysis, analyse, nonadhesive
from ..series import Solution
from .by_history import curves_from_rest, solved_on
from .edge_zone import NEGLECTED, Zone, zone
from .from_rest import FAST, FROM_REST, SLOW, LoadingHistory
from .rate import History, RateContact, RateLaw, parameters_of, rate_parameters
from .relaxation import RelaxedHistory, RelaxingContact
from .relaxing_adhesion import AdhesiveHistory, RateLawCourse, RelaxingAdhesion, follow_crack_law

RATE_REACH = 1.3  # choice: of the largest contact, to which the relaxed specimen is known for a law w(v)


def law_words(law: RateLaw) -> str:
    """The law and its parameters as people write them."""
    name, values = parameters_of(law)
    ranges = rate_parameters(name)
    parameters = ", ".join(f"{key} = {show(value, ranges[key].dimension)}" for key, value in values.items())
    return f"{name} law, {parameters}"


def law_summary(law: RateLaw | None) -> dict[str, Any] | None:
    """The law and its parameters, keys with their units."""
    if law is None:
        return None
    name, values = parameters_of(law)
    ranges = rate_parameters(name)
    return {"law": name} | {with_unit(key, ranges[key].dimension): value for key, value in values.items()}


def _fields(history: Any) -> dict[str, Any]:
    """The fields of a dataclass by their names, without what it has cached."""
    return {item.name: getattr(history, item.name) for item in fields(history)}


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class CycledAtSpeed(History, Result):
    """A history as a result; ``body``: the curve of retraction, ``stress`` [Pa] in the zone at the edge,
    ``points``: rows of a piece, ``history``: of a
    viscoelastic specimen, in words."""

    body: Analysis
    program: Program
    stress: float | None = None
    points: int = ROWS
    history: str = ""

    @classmethod
    def of(cls, contact: RateContact, program: Program, body: Analysis, **more: Any) -> CycledAtSpeed:
        """What happens to ``contact`` under ``program``; InputError where it leaves the series."""
        try:
            history = contact.history(program)
        except SolveError as error:
            raise InputError(f"{body.path}: {error}") from None
        if history.out_of_series is not None:
            raise InputError(f"{body.path}: {history.out_of_series}")
        return cls(**_fields(history), body=body, program=program, **more)

    @property
    def columns(self) -> dict[str, Array]:  # type: ignore[override]
        return self.table(self.points)

    @cached_property
    def zone(self) -> Zone:
        """The dissipating zone at pull-off."""
        pulled, contact, problem = self.pull_off, self.contact, self.body.problem
        x = position(pulled.delta, pulled.P, contact.stiffness)
        G = float(contact.states(np.array([pulled.a]), np.array([x])).G[0])
        z0 = self.body.solution.record.z0
        return zone(G, contact.w0, problem.E_star, pulled.a, problem.top_thickness, self.stress, z0)

    def figure(self) -> Figure:
        from ..report.plots.forward import history_figure

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
        balance = f"the energies balance to {self.balance:.1g} only: the P_H, S and S' contradict each other"
        return [*inexact, *[balance] * (self.balance > UNSEEN), *self.zone.warnings]

    def words(self) -> list[str]:
        contact, pulled, lost = self.contact, self.pull_off, self.lost
        works = show(contact.w_advance, "work"), show(contact.w0, "work")
        lines = [
            f"pull-off force {show(-pulled.P, 'load')} at {format_state(pulled, 't delta a')}; "
            f"contact line up to {show(self.fastest, 'speed')}: {self.body.path}",
            f"  {self.control}, w = {works[0]} on approach, from {works[1]} on retraction; {law_words(contact.law)}",
            *(f"  contact jumps at t = {show(jump.t, 'time')} from {format_state(jump.start, 'a')} to "
              f"{format_state(jump.end, 'a P')}" for jump in self.jumps if jump.end is not None),
        ]  # fmt: skip
        end = "contact is not lost" if lost is None else f"contact is lost at t = {show(lost.t, 'time')}"
        if lost is not None and self.waited is not None:
            loaded = contact.stiffness == LOAD_CONTROL
            where = f"at {format_state(lost.start, 'P')}" if loaded else "with the machine at rest"
            end += f", after {show(self.waited, 'time')} {where}"
        lines.append(f"  {end}; the contact stopped growing at t = {show(self.turn, 'time')}")
        energy = self.energy_lost
        lines.append(f"  energy lost: {energy if isinstance(energy, Unknown) else show(energy, 'energy')}")
        lines.append(f"  dissipating zone at the edge: {self.zone.words}")
        return lines


# --------------------------------------------------------------------------------------------------
# The cycle of a device whose specimen relaxes: its trace, in words and as JSON.

ADHESION_NEGLECTED = (
    "one relaxation function for all layers, and for the half-space below them, at constant Poisson's ratios; one "
    "cohesive stress up to its range, whatever the speed; no inertia or friction"
)
RELAXATION_NEGLECTED = (
    "one relaxation function for all layers, and for the half-space below them, at constant Poisson's ratios; no "
    "adhesion, inertia or friction"
)


def relaxation_law_summary(law: Relaxation) -> dict[str, Any]:
    """The law and its parameters, times in s."""
    keys = RELAXATIONS.keys_in_file(law).items()
    return {with_unit(key, "time") if key.startswith(("time", "onset")) else key: value for key, value in keys}


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class CycledRelaxing(RelaxedHistory, Result):
    """A history as a result; ``points``: rows of a piece."""

    file: Path
    points: int = ROWS

    @classmethod
    def of(cls, contact: RelaxingContact, program: Program, file: Path, points: int = ROWS) -> CycledRelaxing:
        """What happens to ``contact`` under ``program``."""
        try:
            whole = cls(**_fields(contact.history(program)), file=file, points=points)
            whole.summary()  # may find that the contact is loaded again
        except InputError as error:
            raise InputError([f"{file}: {line}" for line in error.lines]) from None
        return whole

    @property
    def columns(self) -> dict[str, Array]:  # type: ignore[override]
        return self.table(self.points)

    def figure(self) -> Figure:
        from ..report.plots.forward import history_figure

        how = f"{self.control}, {speed_words(self.program, self.contact.stiffness)}"
        return history_figure(self.columns, [], cycle_title(how, 0.0, 0.0, str(self.contact.law)))

    def summary(self) -> dict[str, Any]:
        return {
            "file": str(self.file),
            **device(self.contact.stiffness),
            "relaxation": relaxation_law_summary(self.contact.law),
            "largest_load": timed(self.peak),
            "turn_t_s": self.turn,
            "corners": list(map(timed, self.corners)),
            "contact_lost": self.lost is not None,
            "lost_t_s": self.lost,
            **energies(energy_lost=(self.energy_lost, Unknown("not estimated for viscoelastic specimens"))),
            "load_relative_error": self.error,
            "neglected": RELAXATION_NEGLECTED,
            "warnings": self.warnings,
        }

    def words(self) -> list[str]:
        peak, lost = self.peak, self.lost
        lines = [
            f"largest load {show(peak.P, 'load')} at {format_state(peak, 't delta a')}: {self.file}",
            f"  {control(self.contact.stiffness)}, no adhesion; {self.contact.law}",
            *(f"  at {format_state(one, 't')} {format_state(one)}" for one in self.corners if one.t > peak.t),
        ]
        ends = "contact is not lost" if lost is None else f"contact is lost at t = {show(lost, 'time')}"
        energy = (
            ""
            if isinstance(self.energy_lost, Unknown)
            else f"; energy lost per cycle {show(self.energy_lost, 'energy')}"
        )
        shrinks = f"it shrinks from t = {show(self.turn, 'time')} on{', at the end of the solution' * self.whole}"
        return [*lines, f"  {ends}; {shrinks}{energy}"]

    @property
    def warnings(self) -> list[str]:
        """What a reader should know, each with its number."""
        return [f"the loads err by about {self.error:.1g} of the largest"] if self.error > UNSEEN else []


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class CycledAdhering(AdhesiveHistory, Result):
    """A history with adhesion as a result; ``limits``: pull-off points of very fast and very slow cycles and of one
    pulled at once from rest, by their names, ``points``: rows of a piece; ``relaxed``: the specimen
    relaxed, where it is asked what a law w(v) on it says."""

    file: Path
    limits: Mapping[str, CriticalPoint | Unknown]
    points: int = ROWS
    relaxed: Nonadhesive | None = None

    @classmethod
    def of(
        cls, contact: RelaxingAdhesion, program: Program, file: Path, limits: Mapping[str, CriticalPoint | Unknown],
        points: int = ROWS, relaxed: Nonadhesive | None = None,
    ) -> CycledAdhering:  # fmt: skip
        """What happens to ``contact`` under ``program``."""
        try:
            history = contact.history(program)
        except InputError as error:
            raise InputError([f"{file}: {line}" for line in error.lines]) from None
        return cls(**_fields(history), file=file, limits=limits, points=points, relaxed=relaxed)

    @property
    def columns(self) -> dict[str, Array]:  # type: ignore[override]
        columns, rate = self.table(self.points), self.rate
        return columns | (rate.columns(columns["t_s"]) if isinstance(rate, RateLawCourse) else {})

    @cached_property
    def rate(self) -> RateLawCourse | Unknown | None:
        """What a law w(v) on the relaxed specimen would have said; None where it is not asked for."""
        return None if self.relaxed is None else follow_crack_law(self, self.relaxed)

    def figure(self) -> Figure:
        from ..report.plots.forward import history_figure

        contact = self.contact
        how = f"{self.control}, {speed_words(self.program, contact.stiffness)}"
        more = f"cohesive stress {show(contact.law.stress, 'modulus')}"
        title = cycle_title(how, contact.law.w, contact.law.w, str(contact.relaxation), more)
        marks = {name: point for name, point in self.limits.items() if not isinstance(point, Unknown)}
        return history_figure(self.columns, self.jumps, title, marks)

    def summary(self) -> dict[str, Any]:
        contact, error, lost = self.contact, self.error, self.lost
        return {
            "file": str(self.file),
            **device(contact.stiffness),
            "level": LEVEL,
            "w_J_per_m2": contact.law.w,
            "stress_Pa": contact.law.stress,
            "range_m": contact.law.length,
            "relaxation": relaxation_law_summary(contact.relaxation),
            "pull_off": timed(self.pull_off) | {"P_relative_error": known(error["P"])},
            "at_rest_at_the_begin": contact.rests,
            "limits": {
                f"pull_off_{'_'.join(name.split())}_P_N": None if isinstance(point, Unknown) else point.P
                for name, point in self.limits.items()
            },
            "largest_load": timed(self.peak),
            "turn_t_s": self.turn,
            "corners": list(map(timed, self.corners)),
            "jumps": list(map(timed_jump, self.jumps)),
            "contact_lost": lost is not None,
            "lost_t_s": None if lost is None else lost.t,
            "lost_t_relative_error": known(error["lost"]),
            **energies(
                energy_lost=(self.energy_lost, self._half_width(self.energy_lost)),
                dissipated_in_body=(self.in_body, self._half_width(self.energy_lost)),
                radiated_in_jumps=(self.at_edge, self._half_width(self.energy_lost)),
            ),
            "balance_relative_error": self.balance,
            **({} if self.rate is None else {"rate_law": effective_summary(self.rate)}),
            "neglected": ADHESION_NEGLECTED,
            "warnings": self.warnings,
        }

    def _half_width(self, energy: Estimate) -> Estimate:
        error = self.error["energy"]
        return error if isinstance(error, Unknown) or isinstance(energy, Unknown) else error * energy

    def words(self) -> list[str]:
        pulled, lost, contact, error = self.pull_off, self.lost, self.contact, self.error["P"]
        known_to = "" if isinstance(error, Unknown) else f" ± {100 * error:.1g} % ({AT_LEVEL} confidence)"
        zone = show(pulled.c - pulled.a, "length") if pulled.c is not None else "unknown"
        lines = [
            f"pull-off force {show(-pulled.P, 'load')}{known_to} at {format_state(pulled, 't delta a')}, "
            f"cohesive zone {zone} wide: {self.file}",
            f"  {self.control}, w = {show(contact.law.w, 'work')}, cohesive stress "
            f"{show(contact.law.stress, 'modulus')}; {contact.relaxation}",
            *(f"  at {format_state(one, 't')} {format_state(one)}" for one in self.corners if one.t < pulled.t),
        ]
        found = {name: point for name, point in self.limits.items() if not isinstance(point, Unknown)}
        ranged = {FROM_REST: f"{FROM_REST}, JKR"}
        forces = [f"{show(-point.P, 'load')} ({ranged.get(name, name)})" for name, point in found.items()]
        if forces:
            lines.append(f"  limits: {', '.join(forces)}")
        ends = "contact is not lost" if lost is None else f"contact is lost at t = {show(lost.t, 'time')}"
        law = [] if self.rate is None else effective_words(self.rate)
        spent = self.at_edge
        if isinstance(self.energy_lost, Unknown) or isinstance(self.in_body, Unknown) or isinstance(spent, Unknown):
            return [*lines, f"  {ends}", *law]
        parts = f"{show(self.in_body, 'energy')} in the body, {show(spent, 'energy')} in jumps"
        return [*lines, f"  {ends}; energy lost {show(self.energy_lost, 'energy')}, {parts}", *law]

    @property
    def warnings(self) -> list[str]:
        """What a reader should know, each with its number."""
        error = self.error["P"]
        if isinstance(error, Unknown) or error <= NOTICEABLE:
            return []
        return [f"the pull-off force errs by about {100 * error:.1g} %"]


def followed_with_limits(
    solution: Solution, contact: RelaxingAdhesion, program: Program, limits: Mapping[str, CriticalPoint | Unknown],
    slopes: str, modulus_factor: float = 1.0, points: int = ROWS, *, compare_rate: bool = False,
) -> CycledAdhering:  # fmt: skip
    """What happens to ``contact`` under ``program``; ``compare_rate``: with what a law w(v) on the relaxed specimen of
    ``solution`` says."""
    followed = CycledAdhering.of(contact, program, solution.record.path, limits, points)
    if not compare_rate:
        return followed
    radius = RATE_REACH * float(followed.rows[:, 1].max())
    relaxation = solution.problem.specimen.relaxation
    if relaxation is None or not relaxation.relaxed:
        raise InputError("cycle: --compare-rate needs a relaxed modulus above zero: a fluid has none")
    unit = nonadhesive(solution, slopes).scaled(modulus_factor)
    _, unit = solved_on(solution.scaled(modulus_factor), unit, lambda body: bool(body.a[-1] > radius), slopes)
    return replace(followed, relaxed=unit.scaled(relaxation.relaxed))


def effective_summary(rate: RateLawCourse | Unknown) -> dict[str, Any]:
    """What a law w(v) would have said, keys with their units; or why there is none."""
    if isinstance(rate, Unknown):
        return {"pull_off": None, "reason": rate.reason}
    lost = rate.history.lost
    return {
        "pull_off": timed(rate.history.pull_off),
        "lost_t_s": None if lost is None else lost.t,
        "P_relative_difference": rate.force_difference,
        "delta_difference_m": rate.depth_difference,
        "enough": rate.enough,
    }


def effective_words(rate: RateLawCourse | Unknown) -> list[str]:
    """The same as a table of both courses."""
    if isinstance(rate, Unknown):
        return [f"  the law w(v) of the same material is not compared: {rate.reason}"]
    rows: list[tuple[str, AdhesiveHistory | History]] = [("full solution", rate.course), ("the law w(v)", rate.history)]
    table = [
        f"    {name:<14}{show(-one.pull_off.P, 'load'):>12}  at {format_state(one.pull_off, 't delta a')}"
        + ("" if one.lost is None else f"; lost at t = {show(one.lost.t, 'time')}")
        for name, one in rows
    ]
    verdict = "a rate law is sufficient" if rate.enough else "a rate law does not apply"
    return [
        "  compared with a relaxed bulk and the rate law w(v) of the same material at the crack tip:",
        *table,
        f"    force {100 * rate.force_difference:+.2g} %, displacement at pull-off off by "
        f"{show(abs(rate.depth_difference), 'length')} of a retraction of {show(rate.stroke, 'length')}: {verdict}",
    ]


def pull_off_in_limits(
    solution: Solution, w: float, range_: RangeRequest, history: LoadingHistory | None, slopes: str = "auto",
    modulus_factor: float = 1.0,
) -> dict[str, CriticalPoint | Unknown]:  # fmt: skip
    """The pull-off points under load of what a viscoelastic specimen is between, for a work of adhesion ``w``
    [J/m^2]: very fast and very slow cycles with adhesion of finite range, and, without a range, the ``history`` from
    rest (None: nothing is at rest)."""
    relaxation = solution.problem.specimen.relaxation
    shares = {FAST: 1.0} | ({SLOW: relaxation.relaxed} if relaxation and relaxation.relaxed else {})
    points = {
        name: analyse(solution, [w], slopes, modulus_factor * share, range_)[0].curve.pull_off(LOAD_CONTROL)
        for name, share in shares.items()
    }
    if history is not None:
        try:
            _, curve, _ = curves_from_rest(solution, (w, w), history, slopes, modulus_factor, LOAD_CONTROL)
            points[FROM_REST] = curve.pull_off(LOAD_CONTROL)
        except InputError as error:
            points[FROM_REST] = Unknown(str(error))
    return points


def speed_words(program: Program, stiffness: float) -> str:
    """How fast a device of ``stiffness`` [N/m] goes in and out under ``program``; steps have no speed."""
    lasts, ways = np.diff(program.t), np.diff(program.x)
    rates = np.append(ways[lasts > 0] / lasts[lasts > 0], program.rate or 0.0)
    dimension = "load rate" if stiffness == LOAD_CONTROL else "speed"
    words = list[str]()
    for sense in (1, -1):
        there = np.abs(rates[sense * rates > 0])
        if there.size:
            most = "" if np.ptp(there) <= SAME * there.max() else "up to "
            words.append(f"{most}{show(float(there.max()), dimension, 3)}")
    return " in, ".join(words) + " out" if len(set(words)) > 1 else words[0] if words else "at rest"

"""Where the contact lets go under load control, displacement control and a device of given stiffness.

The curve (a, delta, P) is what JKR theory gives; a device shows the part of it that is stable under its own control,
with jumps in between. Energies are those of quasi-static cycles: what the device puts in and does not get back.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..base.errors import Estimate, InputError, JkrError, SolveError, Unknown, counted
from ..base.numerics import MOST_SOLVES, ROUNDED, SAME, Array, zeros_between
from ..base.units import show
from .curve import (
    DISPLACEMENT_CONTROL,
    LOAD_CONTROL,
    NO_ADHESION,
    AdhesiveCurve,
    CriticalPoint,
    Equilibrium,
    EquilibriumCurve,
    control,
    position,
)
from .device_path import ADVANCE, RECEDE, REST, Follow, Jump, Path, QuasiStatic, grow, largest_stable, shrink
from .from_rest import FAST, FromRest, LoadingHistory
from .interpolation import Nonadhesive
from .pull_off_error import larger_elements

STABLE, GRIPPED, UNSTABLE = "stable", "displacement-control", "unstable"
UNBOUNDED = Unknown("not defined under load control")
PHASES = {ADVANCE: "approach", REST: "turn", RECEDE: "retraction"}  # in the trace of a cycle


def branch(curve: EquilibriumCurve) -> Array:
    """The stability of each point of ``curve``, shape (n,): one of three words.

    "stable": dP/da > 0, under load control and then under any other, since d(delta)/da = (dP/da + S' t)/S;
    "displacement-control": d(delta)/da > 0 only, held by a device that is stiff enough; "unstable": held by none.
    """
    if curve.w == 0:
        return np.full(curve.places.size, STABLE)
    ddelta, dP = curve.rates(curve.places)
    return np.where(dP > 0, STABLE, np.where(ddelta > 0, GRIPPED, UNSTABLE))


@dataclass(frozen=True, eq=False)
class Cycle:
    """Approach, turn at the place ``turn`` of the curve [m], retraction, in equilibrium all the way.

    At the turn the contact keeps its radius, as a flat punch would, until the energy release rate has risen from the
    work of adhesion of the approach to that of the retraction: the first piece of the ``retraction``.
    """

    contact: QuasiStatic
    approach: Path
    turn: float
    retraction: Path

    @property
    def path(self) -> Path:
        """The whole, from first contact on."""
        return replace(self.retraction, pieces=(*self.approach.pieces, *self.retraction.pieces))

    @property
    def stiffness(self) -> float:
        """Stiffness of the device [N/m]: 0 load control, infinite displacement control."""
        return self.contact.stiffness

    @property
    def begin(self) -> Equilibrium:
        """The first state in contact: jumped into at delta = 0, or the first of the series at w = 0."""
        return first_contact(self.approach)

    @cached_property
    def energy_lost(self) -> Estimate:
        """Energy lost per cycle [J]: the area of the loop of P over the device's position, the same over delta.

        At w = 0 on approach the unknown piece below the first radius is its chord.
        """
        missing = self._no_energy()
        if missing is not None:
            return missing
        # Work [J] along a straight line from no contact to the first state without adhesion
        k, first = self.stiffness, self.begin
        first_chord = first.P / 2 * float(position(first.delta, first.P, k)) if self.contact.advancing.w == 0 else 0.0
        return self.approach.work + first_chord + self.retraction.work

    @cached_property
    def separation(self) -> Estimate:
        """Work of separation [J]: done by the device on retraction, from the last zero load to loss of contact."""
        return separation_work(self.retraction)

    def _no_energy(self) -> Unknown | None:
        return _no_energy(self.retraction)


def separation_work(retraction: Path) -> Estimate:
    """Work of separation [J]: done by the device on a ``retraction`` from the last zero load to loss of contact."""
    missing = _no_energy(retraction)
    if missing is not None:
        return missing
    work = retraction.unloaded_work
    none = Unknown("no state of zero load is passed on retraction: increase [loading] radius")
    return none if work is None else work


def _no_energy(retraction: Path) -> Unknown | None:
    """Why there are no energies of a ``retraction``; None where there are."""
    if retraction.contact.stiffness == LOAD_CONTROL:
        return UNBOUNDED
    if retraction.ends != "lost":
        first = retraction.stretches[-1].curve.point(retraction.last)
        where = f"c = {show(first.place, 'length')}" if first.a == 0 else f"a = {show(first.a, 'length')}"
        return Unknown(f"contact is not lost within the solution, which begins at {where}")
    return None


@dataclass(frozen=True, eq=False)
class Stability:
    """What an adhesive curve means under one control: all that is read off it for a device of ``stiffness`` [N/m].

    ``critical``: all points of the series where the controlled quantity is stationary. ``pull_off``: where contact is
    lost. ``jump_in``: the stable state after first contact at delta = ``onset`` [m], 0 where adhesion has no range.
    ``partial``: jumps to smaller stable radii on the way from the end of the series to pull-off. Energies in J, or why
    there is none; ``whole`` and ``retraction``: the cycle and the path that they are of.
    """

    stiffness: float
    critical: tuple[CriticalPoint, ...]
    pull_off: CriticalPoint | Unknown
    jump_in: Equilibrium | Unknown
    partial: tuple[Jump, ...]
    energy_lost: Estimate
    separation: Estimate
    onset: float = 0.0
    whole: Cycle | Unknown = NO_ADHESION
    retraction: Path | None = None

    @property
    def control(self) -> str:
        """The control in words."""
        return control(self.stiffness)

    @property
    def energy_lost_error(self) -> Estimate:
        """90 % half-width of the energy lost per cycle [J], or why there is none."""
        return self.whole if isinstance(self.whole, Unknown) else energy_lost_error(self.whole)

    @property
    def separation_error(self) -> Estimate:
        """90 % half-width of the work of separation [J], or why there is none."""
        if self.retraction is None or isinstance(self.separation, Unknown):
            return self.separation
        return separation_error(self.retraction)


def behaviours(curve: EquilibriumCurve, devices: Sequence[float]) -> list[Stability]:
    """The behaviour of ``curve`` under each of the ``devices`` of a stiffness [N/m]."""
    if curve.w > 0:
        curve.find_critical(devices)
        curve.find_radii_at([(float(position(curve.onset, 0.0, stiffness)), stiffness) for stiffness in devices])
    return [stability_under(curve, stiffness) for stiffness in devices]


def stability_under(curve: EquilibriumCurve, stiffness: float) -> Stability:
    """The behaviour of ``curve`` under a device of ``stiffness`` [N/m] (0: load control, infinite: displacement)."""
    if curve.w == 0:
        return Stability(stiffness, (), NO_ADHESION, NO_ADHESION, (), NO_ADHESION, NO_ADHESION)
    critical, pull_off = curve.critical(stiffness), curve.pull_off(stiffness)
    start, whole = largest_stable(curve, stiffness), cycle(curve, curve, stiffness)
    if isinstance(whole, Cycle) and whole.turn == start:
        retraction: Path | None = whole.retraction
    else:
        retraction = None if start is None else shrink(QuasiStatic(curve, curve, stiffness), start)
    partial = () if retraction is None else retraction.jumps
    if isinstance(whole, Unknown):  # the jump-in leads out of the series; contact may be lost within it
        energies: tuple[Estimate, Estimate] = (whole, whole if retraction is None else separation_work(retraction))
        jump_in: Equilibrium | Unknown = whole
    else:
        energies, jump_in = (whole.energy_lost, whole.separation), whole.begin
    if isinstance(pull_off, Unknown) and stiffness != LOAD_CONTROL:
        energies = (pull_off, pull_off)
    between = tuple(jump for jump in partial if jump.end is not None)
    return Stability(stiffness, critical, pull_off, jump_in, between, *energies, curve.onset, whole, retraction)


def cycle(
    approach: EquilibriumCurve, retraction: EquilibriumCurve, stiffness: float, turn: float | None = None
) -> Cycle | Unknown:
    """The cycle of a device of ``stiffness`` [N/m] that turns at the place ``turn`` [m], by default the last one.

    ``approach`` and ``retraction`` are curves of one series; w must not be smaller on retraction. Unknown where the
    first stable contact is not in the series.
    """
    contact = QuasiStatic(approach, retraction, stiffness)
    inwards = grow(contact)
    if isinstance(inwards, Unknown):
        return inwards
    turn = inwards.last if turn is None else turn
    return Cycle(contact, inwards.up_to(turn), turn, shrink(contact, turn))


def turning_radius(
    curve: EquilibriumCurve, stiffness: float, *, load: float | None = None, depth: float | None = None
) -> float:
    """The place [m] where the approach first meets a ``load`` [N] or a ``depth`` delta [m]; else the last."""
    inwards = grow(QuasiStatic(curve, curve, stiffness))
    if isinstance(inwards, Unknown):
        raise InputError(f"cycle: {inwards.reason}")
    controlled, value = (LOAD_CONTROL, load) if depth is None else (DISPLACEMENT_CONTROL, depth)
    if value is None:
        return inwards.last
    met = [a for a in curve.radii_at(value, controlled) if inwards.holds(a)]
    if not met:
        first, last = first_contact(inwards), curve.point(inwards.last)
        name, unit = ("P", "load") if depth is None else ("delta", "length")
        raise InputError(
            f"cycle: the reversal at {name} = {show(value, unit)} is not reached on approach, which in this solution "
            "goes "
            f"from {show(getattr(first, name), unit)} to {show(getattr(last, name), unit)}"
        )
    return met[0]


def first_contact(approach: Path) -> Equilibrium:
    """The first state of an approach; the device's position there is exactly that of the free bodies."""
    curve, k = approach.stretches[0].curve, approach.contact.stiffness
    first = curve.point(approach.stretches[0].place)
    if curve.w == 0:
        return first
    if k == LOAD_CONTROL:
        return replace(first, P=0.0)
    return replace(first, delta=curve.onset) if k == DISPLACEMENT_CONTROL else first


def trace(cycle: Cycle, points: int) -> dict[str, Array]:
    """What the device records over the cycle, row by row, ``points`` (>= 2) to each stretch, even in radius.

    Columns: "a_m" (0 out of contact), "delta_m" (minus the gap out of contact), "P_N", "device_m" (delta + P/stiffness;
    left out under load control, where there is no such length), "phase" in words and "part", a number: jumps lie
    between two parts; "c_m" where adhesion has a range.
    """
    # Positions [m] before contact and after it is lost; they reach a quarter beyond where it is lost
    curve = cycle.contact.receding
    lost = curve.point(cycle.retraction.last)
    D = lost.delta if cycle.stiffness == LOAD_CONTROL else position(lost.delta, lost.P, cycle.stiffness)
    furthest = -1.25 * max(abs(D), abs(curve.onset))
    before, after = np.linspace(furthest, cycle.contact.advancing.onset, points), np.array([])
    if cycle.retraction.ends == "lost" and cycle.stiffness != LOAD_CONTROL:
        after = np.linspace(D, furthest, points)
    along = {name: column for name, column in cycle.path.rows(points).items() if name not in ("t_s", "G_J_per_m2")}
    words = np.array([PHASES[phase] for phase in along["phase"]])
    around = {"phase": ("free approach", "free retraction"), "part": (0, along["part"][-1] + 1),
              "delta_m": (before, after), "device_m": (before, after)}  # fmt: skip
    columns = {}
    for name, column in (along | {"phase": words}).items():
        first, last = around.get(name, (0.0, 0.0))
        columns[name] = np.concatenate([np.full(before.size, first), column, np.full(after.size, last)])
    return columns | {"part": columns["part"] + 1}


def stable_radius(curve: EquilibriumCurve, load: float) -> float:
    """The largest place [m] on the curve at which ``load`` [N] is carried stably under load control (dP/da > 0)."""
    stable = [a for a in curve.radii(P=load) if curve.rates(np.array(a))[1] > 0]
    if not stable:
        P = curve.at(curve.places)[1]
        raise InputError(
            f"load: {show(load, 'load')} is not carried by a stable contact of this solution, whose loads go from "
            f"{show(float(P.min()), 'load')} to {show(float(P.max()), 'load')}"
        )
    return stable[-1]


# --------------------------------------------------------------------------------------------------
# The work of adhesion that a measured pull-off force means on a given body.

ELASTIC = LoadingHistory(FAST, "elastic")
STEP = math.log(4.0)  # of log w, beyond what the radii of the series give; choice: time alone depends on it


@dataclass(frozen=True, eq=False)
class FoundWork:
    """``w`` [J/m^2] whose pull-off force is the measured ``load`` [N, > 0] on this body.

    ``curve``: the adhesive curve for it, ``point``: its pull-off. ``half_space``: load/(1.5 pi R), what classical JKR
    would have given under load control, None where the indenter has no tip radius.
    """

    load: float
    stiffness: float
    w: float
    curve: AdhesiveCurve | FromRest
    point: CriticalPoint
    half_space: float | None


def work_from_pull_off(
    body: Nonadhesive,
    load: float,
    stiffness: float = LOAD_CONTROL,
    R: float | None = None,
    history: LoadingHistory = ELASTIC,
) -> FoundWork:
    """The w at which contact is lost at P = -``load`` [N] by a device of ``stiffness`` [N/m]; ``R``: tip radius [m],
    ``history``: of a viscoelastic ``body`` (its moduli at t = 0).

    At every radius of the series there is at most one w whose curve is stationary there; the pull-off force grows with
    w, so the ends of the series bound the forces that it can tell. Refused outside them.
    """
    if not (math.isfinite(load) and load > 0):
        raise InputError(f"load: the measured pull-off force must be > 0 N, got {load:g}")

    def point(w: float) -> CriticalPoint | Unknown:
        curve = history.curve(body, w)
        return curve if isinstance(curve, Unknown) else curve.pull_off(stiffness)

    def force(log_w: float) -> float:
        tear_off = point(math.exp(log_w))
        if isinstance(tear_off, Unknown):
            raise SolveError(f"load: w lies beyond the range of the solution: {tear_off.reason}")
        return -tear_off.P

    def excess(log_w: float) -> float:
        return force(log_w) / load - 1

    def inside(works: Array) -> float:
        """The log of the first of ``works`` whose pull-off lies in the series."""
        for w in works:
            if isinstance(point(float(w)), CriticalPoint):
                return math.log(w)
        raise InputError("load: this solution holds no pull-off for any work of adhesion: increase [loading] radius")

    def widened(log_w: float, step: float) -> float:
        """``log_w`` moved step by step: beyond the last stationary radius the pull-off may lie between two points."""
        while excess(log_w) * step < 0 and isinstance(point(math.exp(log_w + step)), CriticalPoint):
            log_w += step
        return log_w

    # The works of adhesion > 0 whose curves are stationary at radii across the series, increasing
    own = history.body(body)
    a = own.a.copy()
    a[0], a[-1] = a[0] * (1 + SAME), a[-1] * (1 - SAME)
    here, rates = own.with_rates(a)
    nonadhesive = position(rates.delta_H, rates.P_H, stiffness)
    adhesive = position(rates.t, rates.S * here.t + here.S * rates.t, stiffness)
    root = np.divide(nonadhesive, adhesive, out=np.zeros_like(a), where=adhesive > 0)
    works = np.sort(root[root > 0] ** 2)
    low, high = widened(inside(works), -STEP), widened(inside(works[::-1]), STEP)
    if not excess(low) <= 0 <= excess(high):
        least, greatest = force(low), force(high)
        remedy = "increase [loading] radius" if load > greatest else "begin the solution at a smaller radius"
        raise InputError(
            f"load: a pull-off force of {show(load, 'load')} lies outside the solution, which covers forces from "
            f"{show(least, 'load')} to {show(greatest, 'load')}: {remedy}"
        )
    if low < high:
        low = float(zeros_between(np.vectorize(excess, otypes=[float]), np.array([low]), np.array([high]), 1e-14)[0])
    w = math.exp(low)
    tear_off = point(w)
    if isinstance(tear_off, Unknown) or abs(-tear_off.P / load - 1) > ROUNDED:
        raise InputError(
            f"load: no work of adhesion gives a pull-off force of {show(load, 'load')}: where the last stable branch "
            f"changes, at w = {show(w, 'work')}, the force jumps past it"
        )
    curve = history.curve(body, w)
    assert not isinstance(curve, Unknown)  # it has a point
    half_space = None if R is None else load / (1.5 * math.pi * R)
    return FoundWork(load, stiffness, float(w), curve, tear_off, half_space)


# --------------------------------------------------------------------------------------------------
# Errors of the energies of a cycle: of the energy lost, and of the work of separation.

LEFT = 3.0  # of what doubling elements changes, over (ratio - 1); tuned on random bodies of `make point-bounds`
TABULATED = 1e-10  # theory: share of an energy that cubics between the tabulated functions leave (``interpolation.py``)
Change = Callable[[EquilibriumCurve], EquilibriumCurve]  # to another curve of the same body


def energy_lost_error(whole: Cycle) -> Estimate:
    """90 % half-width of the energy lost per cycle [J], or why it is unknown."""
    advancing, receding, k = whole.contact.advancing, whole.contact.receding, whole.stiffness
    low, high = whole.retraction.last, whole.approach.stretches[0].place
    above = 1 - math.sqrt(advancing.w / receding.w) if receding.w > 0 else 1.0  # of the errors, what does not cancel
    parts = [(low, max(high, low), 1.0), (high, max(whole.turn, high), above)]

    def again(change: Change) -> Estimate:
        turn = None if whole.turn == advancing.places[-1] else whole.turn
        other = cycle(change(advancing), change(receding), k, turn)
        return other if isinstance(other, Unknown) else other.energy_lost

    return _error(whole.energy_lost, receding, again, _by_points(whole.retraction, parts))


def separation_error(retraction: Path) -> Estimate:
    """90 % half-width of the work of separation [J] of a ``retraction``, or why it is unknown."""
    contact, parts = retraction.contact, list[tuple[float, float, float]]()
    assert isinstance(contact, QuasiStatic)
    for piece in reversed(retraction.pieces):
        last = piece.unloaded()
        follow = last or piece
        if isinstance(follow, Follow):
            parts.append((follow.end, follow.place, 1.0))
        if last is not None:
            break

    def again(change: Change) -> Estimate:
        other = QuasiStatic(change(contact.advancing), change(contact.receding), contact.stiffness)
        return separation_work(shrink(other, min(retraction.stretches[0].place, float(other.receding.places[-1]))))

    return _error(separation_work(retraction), contact.receding, again, _by_points(retraction, parts))


def _error(
    energy: Estimate, curve: EquilibriumCurve, again: Callable[[Change], Estimate], by_points: Estimate
) -> Estimate:
    """The half-width of an ``energy`` [J] that ``again`` finds on other curves: what leaving out every second point
    changes, and what larger elements do, else what the errors of the points make of it, ``by_points``."""
    if isinstance(energy, Unknown):
        return energy
    thinned = [_tried(again, lambda one, half=half: one.halves[half]) for half in (0, 1)]  # type: ignore[misc]
    between = [abs(other - energy) for other in thinned if not isinstance(other, Unknown)]
    if not between:
        return Unknown("not estimated: without every second row contact is not lost in the solution")
    by_mesh = _by_mesh(energy, curve, again)
    of_points = by_points if by_mesh is None else by_mesh
    if isinstance(of_points, Unknown):
        return of_points
    return max(between) / curve.thinning + of_points + TABULATED * abs(energy)


def _by_mesh(energy: float, curve: EquilibriumCurve, again: Callable[[Change], Estimate]) -> float | None:
    """What is left of an ``energy`` [J] by the changes to larger and larger elements; None where there are none."""
    coarser = curve.series.coarser
    if not isinstance(curve, AdhesiveCurve) or coarser is None:
        return None

    def on(level: int) -> Change:
        def change(one: EquilibriumCurve) -> EquilibriumCurve:
            assert isinstance(one, AdhesiveCurve)
            return AdhesiveCurve(larger_elements(one.nonadhesive)[level], one.w)

        return change

    others = [_tried(again, on(level)) for level in range(len(larger_elements(curve.nonadhesive)))]
    known = [energy, *itertools.takewhile(lambda other: not isinstance(other, Unknown), others)]
    if len(known) < 2:
        return None
    changes = np.diff(np.array(known, dtype=float)) / coarser.ratio ** (2.0 * np.arange(len(known) - 1))
    return LEFT / (coarser.ratio - 1) * float(np.sqrt(np.mean(changes**2)))


def _tried(again: Callable[[Change], Estimate], change: Change) -> Estimate:
    """The energy [J] on other curves, Unknown where they do not have it."""
    try:
        return again(change)
    except JkrError as error:
        return Unknown(str(error))


def _by_points(retraction: Path, parts: Sequence[tuple[float, float, float]]) -> Estimate:
    """What the errors of the points make of the work [J] on ``parts`` of a curve, each from one place to another [m]
    and counted by a factor, and where contact is lost."""
    contact = retraction.contact
    curve, k = contact.recede.curve, contact.stiffness
    if not curve.errors:
        return Unknown(f"unknown: {curve.slopes.error}")
    total = 0.0
    for low, high, factor in parts:
        if high > low:
            places, weights = curve.path(low, high)
            e, (ddelta, dP) = curve.error_at(places), curve.rates(places)
            total += factor * float(np.sum(weights * (e["P"] * np.abs(ddelta) + e["delta"] * np.abs(dP))))
    last = np.array(retraction.last)
    e = curve.error_at(last)
    return total + abs(float(curve.at(last)[1])) * float(position(e["delta"], e["P"], k))


# --------------------------------------------------------------------------------------------------
# The contact law that a particle code needs: load and contact radius over the overlap, on the branch that is stable
# under displacement control, with the points where contact begins and is lost.

# How finely the law is tabulated.
DEM_FEWEST = 65  # tuned on contact laws, by `make constants`: rows to begin with, doubled until the law is met
# tuned on contact laws, by `make constants`: of the interpolation, relative to the largest load or radius
DEM_ERROR = 1e-6


@dataclass(frozen=True, eq=False)
class DemLaw:
    """A contact law as a table over x = sqrt(delta - delta_tear), in which P and a are smooth: at the tear-off their
    slopes over delta are infinite.

    ``delta, P, a`` [m, N, m]: rows at equal steps of x, from the tear-off on. ``tear_off``: where contact is lost under
    displacement control; ``load``: under load control, None where the table ends before; ``jump_in``: the state after
    first touch at delta = 0. ``error``: the largest of the cubic interpolation, relative to the largest |P| and a.
    ``vectors`` (12, 3): delta, P, a of the curve itself between the rows, with which an implementation is checked.
    """

    delta: Array
    P: Array
    a: Array
    tear_off: CriticalPoint
    load: CriticalPoint | None
    jump_in: Equilibrium
    error: float
    vectors: Array

    @classmethod
    def of(cls, curve: EquilibriumCurve) -> DemLaw:
        """The law of an adhesive curve; InputError where it is none of one branch."""
        stiff, soft = (stability_under(curve, stiffness) for stiffness in (DISPLACEMENT_CONTROL, LOAD_CONTROL))
        if isinstance(stiff.pull_off, Unknown):
            raise InputError(f"tear-off under displacement control is needed: {stiff.pull_off}")
        if stiff.partial:
            raise InputError(
                f"contact shrinks by {counted(len(stiff.partial), 'jump')} before it is lost: no law of one branch"
            )
        if isinstance(stiff.jump_in, Unknown):
            raise InputError(f"the state after first touch is needed: {stiff.jump_in}")
        load = None if isinstance(soft.pull_off, Unknown) else soft.pull_off
        for rows in ((DEM_FEWEST - 1) * 2**step + 1 for step in range(MOST_SOLVES)):
            delta, P, a = _branch(curve, stiff.pull_off, np.linspace(0, 1, rows))
            between = (np.arange(rows - 1) + 0.5) / (rows - 1)
            exact = _branch(curve, stiff.pull_off, between)
            error = max(float(np.abs(interpolated(column, between) - values).max() / np.abs(values).max())
                        for column, values in zip((P, a), exact[1:], strict=True))  # fmt: skip
            if error <= DEM_ERROR:
                break
        else:
            raise InputError(f"{rows} rows meet the law within {error:.1g} only: give a solution of more radii")
        chosen = np.linspace(0, between.size - 1, 12).round().astype(int)
        return cls(delta, P, a, stiff.pull_off, load, stiff.jump_in, error, np.column_stack(exact)[chosen])


def interpolated(column: Array, x: Array) -> Array:
    """The column of rows at equal steps of x in 0 ... 1 at ``x`` (n,), by the cubic through the four next rows."""
    last = column.size - 1
    first = np.clip(np.floor(x * last).astype(int) - 1, 0, last - 3)
    s = x * last - first
    weights: Sequence[Array] = (
        -(s - 1) * (s - 2) * (s - 3) / 6,
        s * (s - 2) * (s - 3) / 2,
        -s * (s - 1) * (s - 3) / 2,
        s * (s - 1) * (s - 2) / 6,
    )
    return np.asarray(sum(weight * column[first + i] for i, weight in enumerate(weights)))


def _branch(curve: EquilibriumCurve, tear_off: CriticalPoint, x: Array) -> tuple[Array, Array, Array]:
    """delta, P and a of the stable branch at fractions ``x`` of sqrt(delta - delta_tear)."""
    first, last = tear_off.place, float(curve.places[-1])
    span = float(curve.at(np.array([last]))[0][0]) - tear_off.delta
    delta = tear_off.delta + span * x**2
    ends = np.full_like(x, first), np.full_like(x, last)
    places = np.where(x == 0, first, zeros_between(lambda place: curve.at(place)[0] - delta, *ends, 0.0))
    return delta, curve.at(places)[1], curve.contact_radii(places)

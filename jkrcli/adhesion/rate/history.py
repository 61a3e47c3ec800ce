"""The history of a contact under a device's program: it forms, grows, rests, recedes at its own speed, is lost."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from ...base.arrays import Array
from ...base.errors import InputError, positive
from ...base.units import show
from ...base.unknown import Estimate, Unknown
from ..curve import AdhesiveCurve, Equilibrium
from ..device import DISPLACEMENT_CONTROL, LOAD_CONTROL, control, position
from ..nonadhesive import Nonadhesive
from ..stability import UNBOUNDED
from .edge import Edge
from .laws import RateLaw
from .motion import Driven, Motion, move
from .pieces import Follow, Free, Piece, Rest
from .program import Program, Ramp


@dataclass(frozen=True)
class HistoryTuning:
    """Accuracy of the motions, and how it is told."""

    tolerance: float = 3e-11  # choice: relative, of a step of the integrator; leaves 3e-9 of the energies
    evaluations: int = 100_000  # choice: guard, six times what the slowest pull in tests takes
    coarser: float = 4.0  # choice: factor of the tolerance of the second run, from whose distance the error is told
    floor: float = 0.5  # choice: of the tolerance, no smaller error is stated; true ones are 0.01 to 1.7 of it
    rests: float = 1e-11  # theory: of positions, what round-off of times and radii leaves
    beside: float = 1e-7  # choice: of a radius, where a branch is asked whether it goes on
    looked_at: int = 400  # choice: states of a piece among which a load or the largest speed is looked for
    restarts: int = 1_000  # choice: guard, pieces of one program


TUNING = HistoryTuning()


@dataclass(frozen=True, eq=False)
class RateContact:
    """A contact whose edge recedes by ``law`` above ``w0`` [J/m^2], in a device of ``stiffness`` [N/m].

    It advances where G is below ``w_advance`` <= w0 [J/m^2]: by ``law_advance``, or, None, at once to equilibrium.
    ``tolerance``: relative, of the integrator's steps; ``evaluations`` of the edge's speed, the most of one motion.
    """

    body: Nonadhesive
    law: RateLaw
    w0: float
    w_advance: float
    stiffness: float = DISPLACEMENT_CONTROL
    law_advance: RateLaw | None = None
    tolerance: float = TUNING.tolerance
    evaluations: int = TUNING.evaluations

    def __post_init__(self) -> None:
        positive("J/m^2", w0=self.w0)
        if not 0 <= self.w_advance <= self.w0:
            raise InputError(
                f"the work of adhesion of the receding edge must be >= that of the advancing one, got "
                f"{show(self.w0, 'work')} after {show(self.w_advance, 'work')}"
            )
        if self.law_advance is not None and self.w_advance == 0:
            raise InputError("a law of advance needs a work of adhesion > 0 on approach, got 0 J/m^2")

    @cached_property
    def edge(self) -> Edge:
        return Edge(self.body, self.stiffness)

    @cached_property
    def advancing(self) -> AdhesiveCurve:
        """The equilibria of the advancing edge."""
        return AdhesiveCurve(self.body, self.w_advance)

    @cached_property
    def least(self) -> float:
        """What the device holds when contact begins: 0, without adhesion that at the first radius of the series."""
        first = float(self.edge.held_at(self.body.a[:1], self.w_advance)[0])
        if self.w_advance == 0:
            return first
        if first > 0 and self.law_advance is None:
            raise InputError(
                f"contact at delta = 0 settles below the smallest radius of the series, a = {self.body.a[0]:.4g} m: "
                "the series would have to begin at a smaller radius"
            )
        return 0.0

    def history(self, program: Program, start: float | None = None) -> History:
        """What happens under ``program``; ``start``: the radius [m] of a contact that is there already."""
        return replace(self.once(program, start), beside=self.coarser.once(program, start))

    def once(self, program: Program, start: float | None = None) -> History:
        """What happens over time under ``program`` from the radius ``start`` [m] on, without its error."""
        return _history(self, program, start)

    @property
    def coarser(self) -> RateContact:
        """The same contact followed less exactly."""
        return replace(self, tolerance=self.tolerance * TUNING.coarser)

    def turning(self, a: float) -> tuple[float, float, float]:
        """What the device holds where the edge at ``a`` [m] begins to recede, and to advance, and their round-off."""
        recedes, advances, lag = (float(self.edge.held_at(np.array(a), w)) for w in (self.w0, self.w_advance, 0.0))
        return recedes, advances, TUNING.rests * (abs(lag - recedes) + abs(lag))

    def settled(self, a: float, x: float) -> float | None:
        """The radius [m] beyond ``a`` at which an advancing edge comes to equilibrium while ``x`` is held."""
        radii = self.advancing.radii_at(x, self.stiffness)
        return next((r for r in radii if r > a and self.rises(r)), None)

    def followed(self, a: float, x: float) -> float | None:
        """The radius [m] up to which equilibrium is followed from ``a`` on while the device goes on to ``x``: there, or
        at the end of the stable branch; None: it leaves the series."""
        tops = [point.a for point in self.advancing.critical(self.stiffness) if point.kind == "maximum"]
        top = next((r for r in tops if r > a), None)
        ends = [r for r in self.advancing.radii_at(x, self.stiffness) if a <= r <= (top or math.inf)]
        return min(ends, default=top)

    def rises(self, a: float) -> bool:
        """Whether the equilibrium of advance at ``a`` [m] is stable in the device."""
        inside = np.clip(np.array(a), *self.body.a[[0, -1]])
        return float(position(*self.advancing.rates(inside), self.stiffness)) > 0


@dataclass(frozen=True)
class TimedJump:
    """A jump of the contact radius at the time ``t`` [s]; ``end = None``: contact is lost."""

    t: float
    start: Equilibrium
    end: Equilibrium | None


@dataclass(frozen=True, kw_only=True)
class TimedState(Equilibrium):
    """A state at the time ``t`` [s]."""

    t: float


@dataclass(frozen=True, eq=False)
class History:
    """The ``pieces`` of what happened to ``contact``, in order, and how it ``ends``: "program", "series" (the contact
    grows beyond its radii, or shrinks below them at x > 0) or "lost". ``beside``: the same, integrated less exactly."""

    contact: RateContact
    pieces: tuple[Piece, ...]
    ends: str
    beside: History | None = None

    @cached_property
    def jumps(self) -> tuple[TimedJump, ...]:
        """Where the radius changes while no time goes by, and where contact is lost."""
        return tuple(self._jumps())

    @property
    def out_of_series(self) -> str | None:
        """Why and where the contact left its series; None where it did not."""
        if self.ends != "series":
            return None
        if self.pieces[-1].phase == "recede":
            return (
                "the contact shrinks below the smallest radius of the series, a = "
                f"{show(self.pieces[-1].last[1], 'length')}, while pressed: ask for smaller radii, "
                'loading.spacing = "log"'
            )
        return "the contact grows beyond the largest radius of the series: increase [loading] radius, or turn before"

    @cached_property
    def turn(self) -> float:
        """The time [s] at which the contact last stopped to grow; that of the begin where it never grew."""
        grew = [piece.last[0] for piece in self.pieces if piece.phase == "advance"]
        return max(grew, default=self.pieces[0].first[0])

    @cached_property
    def pull_off(self) -> TimedState:
        """The state of least load since the contact last grew."""
        after = [piece for piece in self.pieces if piece.phase in ("rest", "recede") and piece.last[0] >= self.turn]
        found = [self._state(piece, *piece.lowest()) for piece in after or self.pieces]
        return min(found, key=lambda state: state.P)

    @property
    def lost(self) -> TimedJump | None:
        """The last loss of contact."""
        return next((jump for jump in reversed(self.jumps) if jump.end is None), None)

    @property
    def waited(self) -> float | None:
        """How long [s] the device stood still before contact was lost; None where it moved, or it was not lost."""
        ramp = next((piece.ramp for piece in reversed(self.pieces) if _lost(piece)), None)
        return None if ramp is None or self.lost is None or ramp.rate != 0 else self.lost.t - ramp.t

    @cached_property
    def error(self) -> dict[str, Estimate]:
        """Relative error of the integration of "P" and "t" at pull-off and of the time at which contact is "lost", both
        counted from the turn, and of the "balance": work of the device against stored energy and work of the edge."""
        if self.beside is None:
            return dict.fromkeys(("P", "t", "lost", "balance"), Unknown("integrated once only"))
        both = (self, self.beside)
        lost = [(history.lost.t if history.lost else math.nan) - history.turn for history in both]
        return {
            "P": self._stated(*(history.pull_off.P for history in both)),
            "t": self._stated(*(history.pull_off.t - history.turn for history in both)),
            "lost": Unknown("contact is not lost") if math.isnan(sum(lost)) else self._stated(*lost),
            "balance": self.balance,
        }

    def _stated(self, here: float, there: float) -> float:
        """Relative error of ``here``: errors are proportional to the tolerance."""
        size = max(abs(here), abs(there))
        changed = abs(here - there) / size / (TUNING.coarser - 1) if size else 0.0
        return max(changed, TUNING.floor * self.contact.tolerance)

    @cached_property
    def fastest(self) -> float:
        """The largest speed [m/s] of the receding edge up to pull-off."""
        end, found = self.pull_off, [0.0]
        for piece in self.pieces:
            if piece.phase == "recede" and piece.first[0] <= end.t:
                t, a = piece.rows(TUNING.looked_at)
                t, a = np.append(t[t <= end.t], end.t), np.append(a[t <= end.t], end.a)
                t, a = t[t <= piece.last[0]], a[t <= piece.last[0]]
                found.append(float(np.max(-piece.speeds(a, states(self.contact.edge, a, _held(piece, t))[2]))))
        return max(found)

    def first_held(self, quantity: str, value: float) -> float | None:
        """What the device holds where "P" [N] or "delta" [m] first rises to ``value``; None: it never does."""

        def excess(piece: Piece, t: Array) -> Array:
            delta, P, _ = states(self.contact.edge, piece.at(t), _held(piece, t))
            return (P if quantity == "P" else delta) - value

        for piece in self.pieces:
            t = piece.rows(TUNING.looked_at)[0]
            met = np.flatnonzero(np.diff(np.sign(excess(piece, t))) > 0)
            if met.size and piece.phase == "advance":
                i = int(met[0])
                when = brentq(lambda x, piece=piece: excess(piece, np.array([x]))[0], t[i], t[i + 1], rtol=1e-14)
                return float(piece.ramp.at(when))
        return None

    @property
    def dissipated(self) -> float:
        """Work of the receding edge, int G dA [J]."""
        return sum(piece.dissipated for piece in self.pieces if piece.phase == "recede")

    @cached_property
    def energy_lost(self) -> Estimate:
        """Work that the device does over the whole program [J]: the area of the loop where contact is lost."""
        if self.contact.stiffness == LOAD_CONTROL:
            return UNBOUNDED
        if self.ends != "lost" and self.pieces[-1].phase != "free":
            return Unknown("contact is not lost")
        return sum(piece.work for piece in self.pieces)

    @cached_property
    def balance(self) -> float:
        """The energy that is missing, |work of the device - stored - int G dA| over the largest of the three [-]:
        that of the motion with the largest share."""
        return max((self._defect(piece) for piece in self.pieces if isinstance(piece, Motion)), default=0.0)

    def _defect(self, piece: Piece) -> float:
        (t, a), (t_end, a_end) = piece.first, piece.last
        stored = self.contact.edge.stored((a, piece.ramp.at(t)), (a_end, piece.ramp.at(t_end)))
        scale = max(abs(piece.dissipated), abs(stored), abs(piece.work))
        return abs(piece.work - stored - piece.dissipated) / scale if scale else 0.0

    def _jumps(self) -> Iterator[TimedJump]:
        for one, two in zip(self.pieces[:-1], self.pieces[1:], strict=True):
            gone = one.phase != "free" and two.phase == "free"
            if gone or (abs(two.first[1] - one.last[1]) > 1e-9 * one.last[1]):
                yield self._jump(one, None if gone else self._state(two, *two.first))
        if self.ends == "lost":
            yield self._jump(self.pieces[-1], None)

    def _jump(self, piece: Piece, end: TimedState | None) -> TimedJump:
        start = piece.parting if isinstance(piece, Motion) else piece.last
        return TimedJump(piece.last[0], self._state(piece, *start), end)

    def _state(self, piece: Piece, t: float, a: float) -> TimedState:
        x = _held(piece, np.array([t]))
        delta, P, *_ = states(self.contact.edge, np.array([a]), x)
        return TimedState(a=a, delta=float(delta[0]), P=float(P[0]), t=t)

    def table(self, points: int) -> dict[str, Array]:
        """Rows of the whole history, at most ``points`` to a piece: "t_s", "a_m" (0 out of contact), "delta_m", "P_N",
        "device_m" (not under load control), "speed_m_per_s" (da/dt), "G_J_per_m2", "phase", "part"."""
        parts = []
        for number, piece in enumerate(self.pieces, start=1):
            t, a = piece.rows(points)
            parts.append((number, piece, t, a, _held(piece, t)))
        t, a, x = (np.concatenate([part[i] for part in parts]) for i in (2, 3, 4))
        t = np.maximum.accumulate(np.maximum(t, self.pieces[0].ramp.t))  # pieces meet but for round-off
        delta, P, G = states(self.contact.edge, a, x)
        numbers = np.repeat([part[0] for part in parts], [part[2].size for part in parts])
        columns = {"t_s": t, "a_m": a, "delta_m": delta, "P_N": P}
        if self.contact.stiffness != LOAD_CONTROL:
            columns["device_m"] = x
        speeds = [piece.speeds(a[numbers == i], G[numbers == i]) for i, piece, *_ in parts]
        columns |= {"speed_m_per_s": np.concatenate(speeds), "G_J_per_m2": G}
        phases = np.array([piece.phase for piece in self.pieces])[numbers - 1]
        return columns | {"phase": phases, "part": numbers}

    @property
    def control(self) -> str:
        return control(self.contact.stiffness)


def states(edge: Edge, a: Array, x: Array) -> tuple[Array, Array, Array]:
    """delta [m], P [N], G [J/m^2] at the radii ``a`` [m], 0 out of contact, while the device holds ``x``."""
    touching = a > 0
    found = edge.state(np.where(touching, a, edge.body.a[0]), x)
    free = np.zeros_like(x) if edge.stiffness == LOAD_CONTROL else x
    return (np.where(touching, found.delta, free), np.where(touching, found.P, 0.0), np.where(touching, found.G, 0.0))


def _held(piece: Piece, t: Array) -> Array:
    """What the device holds at the times ``t`` of a piece."""
    ramp = piece.ramp
    if ramp.is_step:
        return np.linspace(ramp.x, ramp.x_end, t.size) if t.size > 1 else np.array([ramp.x_end])
    return np.asarray(ramp.at(t))


# ---------------------------------------------------------------------- one piece after the other
@dataclass(frozen=True)
class _Now:
    """Time [s], radius [m] (0: no contact) and what is held, between two pieces; ``rests``: G has just come to w."""

    t: float
    a: float
    x: float
    rests: bool = False


def _history(contact: RateContact, program: Program, start: float | None) -> History:
    pieces: list[Piece] = []
    ends, a = "program", start or 0.0
    for ramp in program.ramps():
        found, ends = _on_ramp(contact, ramp, a, program)
        pieces += found
        if ends != "program":
            break
        a = pieces[-1].last[1] if not _lost(pieces[-1]) else 0.0
    if not pieces:
        raise InputError(
            "program: the contact grows beyond the largest radius of the series: increase [loading] radius"
        )
    return History(contact, tuple(pieces), ends)


def _on_ramp(contact: RateContact, ramp: Ramp, a: float, program: Program) -> tuple[list[Piece], str]:
    """The pieces of one ramp, and how it ends: "program", "series", or "lost" where no contact forms anew."""
    now, pieces = _Now(ramp.t, a, ramp.x), list[Piece]()
    for _ in range(TUNING.restarts):
        piece = _next(contact, ramp, now)
        if piece is None:
            return pieces, "series"
        pieces.append(piece)
        now = _after(ramp, piece)
        if isinstance(piece, Motion) and (piece.ends == "last" or (piece.ends == "first" and now.x > 0)):
            return pieces, "series"
        if _lost(piece) and not program.highest(now.t) > contact.least:
            return pieces, "lost"
        if now.t >= ramp.t_end:
            return pieces, "program"
    raise InputError(f"program: more than {TUNING.restarts} changes between rest and motion on one ramp")


def _lost(piece: Piece) -> bool:
    return isinstance(piece, Motion) and piece.ends == "first"


def _after(ramp: Ramp, piece: Piece) -> _Now:
    """The state behind a piece."""
    t, a = piece.last
    if math.isfinite(ramp.t_end) and ramp.t_end - t <= TUNING.rests * (ramp.t_end - ramp.t):
        t = ramp.t_end
    x = piece.x_end if isinstance(piece, Rest) else ramp.x_end if t >= ramp.t_end else float(ramp.at(t))
    return _Now(t, 0.0 if _lost(piece) else a, x, isinstance(piece, Motion) and piece.ends == "rest")


def _next(contact: RateContact, ramp: Ramp, now: _Now) -> Piece | None:
    """What happens from ``now`` on; None where it is not in the series."""
    if now.a == 0:
        return _form(contact, ramp, now)
    if ramp.is_step:
        return Rest(contact.edge, ramp, now.a, now.t, now.t, ramp.x, ramp.x_end)
    recedes, advances, slack = contact.turning(now.a)
    beyond = now.x - recedes
    if not now.rests and (beyond <= slack if ramp.rate < 0 else beyond < -slack):
        driven = Driven(contact.law, contact.w0, True)
        return move(contact.edge, ramp, driven, now.t, now.a, contact.tolerance, contact.evaluations)
    if not now.rests and (now.x > advances + slack or (ramp.rate > 0 and now.x >= advances - slack)):
        return _grow(contact, ramp, now)
    target = {1: advances, -1: recedes, 0: now.x}[int(np.sign(ramp.rate))]
    ends = max(ramp.when(target), now.t)
    if ends >= ramp.t_end:
        ends, target = ramp.t_end, ramp.x_end
    return Rest(contact.edge, ramp, now.a, now.t, ends, now.x, target)


def _grow(contact: RateContact, ramp: Ramp, now: _Now) -> Piece | None:
    """The edge advances: by its law, or at once to equilibrium and on along it."""
    if contact.law_advance is not None:
        driven = Driven(contact.law_advance, contact.w_advance, False)
        return move(contact.edge, ramp, driven, now.t, now.a, contact.tolerance, contact.evaluations)
    _, advances, slack = contact.turning(now.a)
    stands = abs(advances - now.x) <= slack and contact.rises(now.a * (1 + TUNING.beside))
    a = now.a if stands else contact.settled(now.a, now.x)
    if a is None:
        return None
    if ramp.rate <= 0:
        instant = Ramp(now.t, now.x, now.t, now.x, 0.0)
        return Follow(contact.edge, contact.advancing, instant, a, a)
    end = contact.followed(a, ramp.x_end)
    return None if end is None else Follow(contact.edge, contact.advancing, ramp, a, end)


def _form(contact: RateContact, ramp: Ramp, now: _Now) -> Piece | None:
    """No contact until the device comes to where the undeformed gap closes; then the first radius."""
    least = contact.least
    if ramp.is_step or now.x < least or (now.x == least and ramp.rate <= 0):
        comes = ramp.rate > 0 and ramp.x_end > least and not ramp.is_step
        return Free(ramp, now.t, max(ramp.when(least), now.t) if comes else ramp.t_end)
    first = float(contact.body.a[0])
    if contact.law_advance is not None or contact.w_advance == 0:
        return _next(contact, ramp, replace(now, a=first))
    return _grow(contact, ramp, replace(now, a=first * (1 - TUNING.beside)))

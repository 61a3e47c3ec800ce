"""The history of a contact whose edge moves at its own speed: its path under a device's program, over time."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from ...base import LOOKED_AT, Array, Estimate, InputError, SolveError, Unknown, positive, show
from ..curve import DISPLACEMENT_CONTROL, LOAD_CONTROL, AdhesiveCurve
from ..edge import Edge
from ..nonadhesive import Nonadhesive
from ..path import ADVANCE, FREE, RECEDE, REST, Contact, EdgeRule, Jump, Path, Piece, TimedState, path
from ..program import Program
from ..stability import UNBOUNDED, turning_radius
from .laws import RateLaw
from .motion import ByLaw, Motion


@dataclass(frozen=True)
class HistoryTuning:
    """Accuracy of the motions, and how their error is estimated."""

    tolerance: float = 3e-11  # choice: relative, of a step of the integrator; leaves 3e-9 of the energies
    evaluations: int = 100_000  # choice: guard, six times what the slowest pull in tests takes
    # tuned on curves, by `make constants`: factor of the tolerance of the second run, from whose distance the error is
    # told
    coarser: float = 4.0
    # tuned on curves, by `make constants`: of the tolerance, no smaller error is stated; true ones are 0.01 to 1.7 of
    # it
    floor: float = 0.5


TUNING = HistoryTuning()


@dataclass(frozen=True, eq=False)
class RateContact(Contact):
    """A contact whose edge recedes by ``law`` above ``w0`` [J/m^2], in a device of ``stiffness`` [N/m].

    It advances where G is below ``w_advance`` <= w0 [J/m^2]: by ``law_advance``, or, None, at once to equilibrium.
    ``tolerance``: relative, of the integrator's steps; ``evaluations`` of the edge's speed, the most of one motion;
    ``slow``: excess of w up to which a moving edge is in equilibrium.
    """

    body: Nonadhesive
    law: RateLaw
    w0: float
    w_advance: float
    stiffness: float = DISPLACEMENT_CONTROL
    law_advance: RateLaw | None = None
    tolerance: float = TUNING.tolerance
    evaluations: int = TUNING.evaluations
    slow: float = TUNING.tolerance  # theory: equilibrium then errs as a step of the integrator does

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
    def advance(self) -> EdgeRule:
        if self.law_advance is None:
            return EdgeRule(self.advancing, self.stiffness, True)
        return self._by(self.law_advance, self.advancing, True)

    @cached_property
    def recede(self) -> EdgeRule:
        return self._by(self.law, AdhesiveCurve(self.body, self.w0), False)

    def _by(self, law: RateLaw, curve: AdhesiveCurve, grows: bool) -> ByLaw:
        return ByLaw(curve, self.stiffness, grows, self.edge, law, self.tolerance, self.evaluations, self.slow)

    def history(self, program: Program, start: float | None = None) -> History:
        """What happens under ``program``; ``start``: the radius [m] of a contact that is there already."""
        return replace(self.once(program, start), beside=self.coarser.once(program, start))

    def once(self, program: Program, start: float | None = None) -> History:
        """What happens over time under ``program`` from the radius ``start`` [m] on, without its error."""
        return History(**vars(path(self, program, start or 0.0)))

    @property
    def coarser(self) -> RateContact:
        """The same contact followed less exactly."""
        return replace(self, tolerance=self.tolerance * TUNING.coarser)

    def turning(self, load: float | None, depth: float | None, speed: float) -> float:
        """The device's position where the approach comes to ``load`` [N] or ``depth`` [m]; both None: to the end of the
        series. ``speed`` of the approach [m/s, under load control N/s], on which it depends where the edge advances by
        a law. InputError where it does not come there."""

        if self.law_advance is None:
            place = turning_radius(self.advancing, self.stiffness, load=load, depth=depth)
            return self.advance.position(place)
        quantity, value = ("P", load) if depth is None else ("delta", depth)
        if value is None:
            raise InputError("cycle: an edge that advances by a law needs a turn: --to-load or --to-depth")
        try:
            x = self.once(Program.on(self.least, speed)).position_where(quantity, value)
        except SolveError as error:
            raise InputError(f"cycle: {error}") from None
        if x is None:
            turn = f"{quantity} = {show(value, 'load' if quantity == 'P' else 'length')}"
            raise InputError(f"cycle: the turn at {turn} is not passed on approach within the series")
        return x

    def within(self, _: Callable[[float], Program], x: float) -> float:
        """The turn ``x``: the body does not creep."""
        return x


@dataclass(frozen=True, eq=False)
class History(Path):
    """What happened to ``contact`` over time; ``beside``: the same, integrated less exactly."""

    contact: RateContact
    beside: History | None = None

    @cached_property
    def turn(self) -> float:
        """The time [s] at which the contact last stopped to grow; that of the begin where it never grew."""
        grew = [piece.last[0] for piece in self.pieces if piece.phase == ADVANCE]
        return max(grew, default=self.pieces[0].first[0])

    @cached_property
    def pull_off(self) -> TimedState:
        """The state of least load since the contact last grew."""
        after = [piece for piece in self.pieces if piece.phase in (REST, RECEDE) and piece.last[0] >= self.turn]
        lows = [self.state(piece, *piece.lowest()) for piece in after or self.pieces]
        return min(lows, key=lambda state: state.P)

    @property
    def lost(self) -> Jump | None:
        """The last loss of contact."""
        return next((jump for jump in reversed(self.jumps) if jump.end is None), None)

    @property
    def waited(self) -> float | None:
        """How long [s] the device stood still before contact was lost; None where it moved, or it was not lost."""
        ramp = next((piece.ramp for piece in reversed(self.pieces) if piece.ends == "lost"), None)
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
        end, speeds = self.pull_off, [0.0]
        for piece in self.pieces:
            if piece.phase == RECEDE and piece.first[0] <= end.t:
                t, a = piece.rows(LOOKED_AT)
                t, a = np.append(t[t <= end.t], end.t), np.append(a[t <= end.t], end.a)
                t, a = t[t <= piece.last[0]], a[t <= piece.last[0]]
                speeds += (-piece.speeds(a, self.states(piece, t, a).G)).tolist()
        return max(speed for speed in speeds if math.isfinite(speed))  # where it jumps it has none

    def position_where(self, quantity: str, value: float) -> float | None:
        """The device's position where "P" [N] or "delta" [m] first rises to ``value``; None: it never does."""

        def excess(piece: Piece, t: Array) -> Array:
            _, delta, P, _ = self.states(piece, t, piece.at(t))
            return (P if quantity == "P" else delta) - value

        for piece in self.pieces:
            t = piece.rows(LOOKED_AT)[0]
            met = np.flatnonzero(np.diff(np.sign(excess(piece, t))) > 0)
            if met.size and piece.phase == ADVANCE:
                i = int(met[0])
                when = brentq(lambda x, piece=piece: excess(piece, np.array([x]))[0], t[i], t[i + 1], rtol=1e-14)
                return float(piece.ramp.at(when))
        return None

    @property
    def dissipated(self) -> float:
        """Work of the receding edge, int G dA [J]."""
        return sum(piece.dissipated for piece in self.pieces if piece.phase == RECEDE)

    @cached_property
    def energy_lost(self) -> Estimate:
        """Work that the device does over the whole program [J]: the area of the loop where contact is lost."""
        if self.contact.stiffness == LOAD_CONTROL:
            return UNBOUNDED
        if self.ends != "lost" and self.pieces[-1].phase != FREE:
            return Unknown("contact is not lost")
        return self.work

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

    def table(self, points: int) -> dict[str, Array]:
        """Rows of the whole history, at most ``points`` to a piece: "t_s", "a_m" (0 out of contact), "delta_m", "P_N",
        "device_m" (not under load control), "speed_m_per_s" (da/dt), "G_J_per_m2", "phase", "part"."""
        columns = self.rows(points)
        a, G, part = (columns[name] for name in ("a_m", "G_J_per_m2", "part"))
        speeds = [piece.speeds(a[part == i], G[part == i]) for i, piece in enumerate(self.pieces, start=1)]
        last = {name: columns.pop(name) for name in ("G_J_per_m2", "phase", "part")}
        return columns | {"speed_m_per_s": np.concatenate(speeds)} | last

"""The path of a device: what a contact does while the device presses, waits and goes back, turning wherever it may.

The contact is free, or its crack closes, is pinned, or opens; it jumps where no stable state goes on. A device of
stiffness k holds D = delta + P/k (load control: P). At fixed D the contact at radius a is stable where dD/da > 0, the
energy release rate then falls as the contact shrinks (Maugis, J. Phys. D 18 (1985) 293). A rule that can be exchanged
says how the edge moves each way: in equilibrium with a curve, G = w_a or w_r, or of finite range (``EdgeRule``), or at
a speed (a subclass). Between the two it rests: P over delta is a straight line of slope S.
"""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np

from ..base.arguments import read, read_fields, reader
from ..base.errors import Estimate, InputError, JkrError, Unknown
from ..base.numerics import MOST_STEPS, ROUNDED, SAME, Array, numbers_of, zeros_between
from ..base.units import AnyForce, AnyLength, Ranged, Time, show
from .curve import (
    DISPLACEMENT_CONTROL,
    LOAD_CONTROL,
    NO_ADHESION,
    AdhesiveCurve,
    CriticalPoint,
    Equilibrium,
    EquilibriumCurve,
    Nonadhesive,
    control,
    position,
)
from .pull_off_error import larger_elements

# --------------------------------------------------------------------------------------------------
# The edge of a contact in a device: its energy release rate at every radius and position of the device.
#
# A device of stiffness k prescribes its position x = delta + P/k (load control: x = P). With the lag L of Eq. 13
# (``formulas``) x = x_H - c L with c = 1 + S/k (load control: c = S), at once for every radius, in equilibrium or not.


class EdgeState(NamedTuple):
    """Displacement ``delta`` [m], load ``P`` [N], energy release rate ``G`` [J/m^2] and lag [m] at some radii."""

    delta: Array
    P: Array
    G: Array
    lag: Array


@dataclass(frozen=True, eq=False)
class Edge:
    """The edge of the contact of a ``body`` in a device of ``stiffness`` [N/m] (0: load control, infinite: rigid)."""

    body: Nonadhesive
    stiffness: float

    def state(self, a: Array, x: Array) -> EdgeState:
        """The state at the radii ``a`` [m] and the device's positions ``x``."""
        here = self.body.parts(a)
        lag = (position(here.delta_H, here.P_H, self.stiffness) - x) / self._give(here.S)
        delta, P = here.lagging(lag)
        P = P if self.stiffness != LOAD_CONTROL else np.broadcast_to(x, lag.shape)
        return EdgeState(delta, P, here.dS * lag**2 / (4 * math.pi * self.body.contact_radii(a)), lag)

    def position_at(self, a: Array, G: float) -> Array:
        """The device's position where the edge at radius ``a`` [m] has the energy release rate ``G``."""
        here = self.body.parts(a)
        return position(here.delta_H, here.P_H, self.stiffness) - self._give(here.S) * math.sqrt(G) * here.t

    def _give(self, S: Array) -> Array:
        """c = -dx/dL at constant radius: 1 + S/k, under load control S [N/m]."""
        return position(np.ones_like(S), S, self.stiffness)

    def stored(self, first: tuple[float, float], last: tuple[float, float]) -> float:
        """Change of the elastic energy [J] of body and device from one state (a, x) to another.

        U = int P_H d(delta_H) - P_H L + S L^2/2, as dU = P d(delta) + G d(pi a^2); the device's spring has P^2/(2 k).
        """
        return self.free.work(first[0], last[0]) + self._beside(*last) - self._beside(*first)

    @cached_property
    def free(self) -> AdhesiveCurve:
        """The contact without adhesion."""
        return AdhesiveCurve(self.body, 0.0)

    def _beside(self, a: float, x: float) -> float:
        here, state = self.body.parts(np.array(a)), self.state(np.array(a), np.array(x))
        spring = 0.0 if self.stiffness in (LOAD_CONTROL, math.inf) else float(state.P) ** 2 / (2 * self.stiffness)
        return float(-here.P_H * state.lag + here.S * state.lag**2 / 2) + spring

    def at(self, u: float, x: float) -> tuple[tuple[float, ...], float, float, float]:
        """The ``pointwise`` functions at one radius, log a = ``u``, the lag [m] (none below 0), c and G [J/m^2] there
        at the device's position ``x``: ``state`` in plain floats."""
        here = self.pointwise(u)
        delta_H, P_H, S, dS, *_ = here
        loaded = self.stiffness == LOAD_CONTROL
        c = S if loaded else 1 + S * self.give
        lag = max(((P_H if loaded else delta_H + P_H * self.give) - x) / c, 0.0)
        return here, lag, c, dS * lag * lag / (4 * math.pi * math.exp(u))

    @cached_property
    def give(self) -> float:
        """1/k [m/N] of the device; 0 where it is rigid, or prescribes the load."""
        return 0.0 if self.stiffness in (LOAD_CONTROL, math.inf) else 1 / self.stiffness

    @cached_property
    def pointwise(self) -> Pointwise:
        """The functions of the body at one radius at a time."""
        return Pointwise.of(self.body)


@dataclass(frozen=True, eq=False)
class Pointwise:
    """delta_H [m], P_H [N], S [N/m], S' [N/m^2] at one radius, in plain floats: the rule of ``Nonadhesive.parts``, at a
    thirtieth of the cost of arrays of one. ``a0``: radius of first contact [m]."""

    nodes: list[float]
    starts: list[float]
    cubics: Array
    a0: float
    known: dict[int, list[list[float]]] = field(default_factory=dict)  # those used by now, as lists

    @classmethod
    def of(cls, body: Nonadhesive) -> Pointwise:
        columns, slopes = body.logs
        cubics = np.concatenate([columns.c, slopes.c], axis=2)  # (order, interval, function)
        return cls(slopes.x.tolist(), columns.x.tolist(), cubics.transpose(1, 2, 0), body.series.a0)

    def __call__(self, u: float) -> tuple[float, float, float, float, float, float]:
        """The four functions at log a = ``u``, and d(delta_H)/du [m] and d(log S')/du; the outer cubics go on beyond
        the ends."""
        i = min(max(bisect_right(self.nodes, u) - 1, 0), len(self.cubics) - 1)
        if i not in self.known:
            self.known[i] = self.cubics[i].tolist()
        y, beyond = u - self.nodes[i], math.exp(u) - self.a0
        z = (math.log(beyond) if self.a0 else u) - self.starts[i]
        delta, P, S, dS = self.known[i]
        delta_H = _exp(delta, z)
        rate = delta_H * _slope(delta, z) * (1 + self.a0 / beyond)
        return delta_H, _exp(P, z), _exp(S, y), _exp(dS, y), rate, _slope(dS, y)


def _exp(cubic: list[float], x: float) -> float:
    c3, c2, c1, c0 = cubic
    return math.exp(((c3 * x + c2) * x + c1) * x + c0)


def _slope(cubic: list[float], x: float) -> float:
    c3, c2, c1, _ = cubic
    return (3 * c3 * x + 2 * c2) * x + c1


# --------------------------------------------------------------------------------------------------
# What a device does over time: it moves to and fro, waits, steps; under load control the same of the load. A course
# is the usual way there and back by turn, speeds and hold; on a contact it becomes a program.


@dataclass(frozen=True)
class Ramp:
    """The device's position [m], under load control the load [N], linear from ``x`` at the time ``t`` [s] to ``x_end``
    at ``t_end``. ``rate``: dx/dt [m/s or N/s]; equal times are a step."""

    t: float
    x: float
    t_end: float
    x_end: float
    rate: float

    @classmethod
    def between(cls, t: float, x: float, t_end: float, x_end: float) -> Ramp:
        """The ramp between two points."""
        rate = (x_end - x) / (t_end - t) if t_end > t else math.copysign(math.inf, x_end - x)
        return cls(t, x, t_end, x_end, rate)

    @property
    def is_step(self) -> bool:
        return self.t_end == self.t

    def at(self, t: Any) -> Any:
        """The positions at the times ``t`` [s] of a ramp that is no step."""
        return self.x + self.rate * (t - self.t)

    def positions(self, t: Array) -> Array:
        """The positions at the times ``t`` [s]; a step goes evenly from row to row."""
        if self.is_step:
            return np.linspace(self.x, self.x_end, t.size) if t.size > 1 else np.array([self.x_end])
        return np.asarray(self.at(t))

    def when(self, x: float) -> float:
        """The time [s] of the position ``x``; where it stands, the end."""
        return self.t_end if self.rate == 0 else self.t + (x - self.x) / self.rate


@dataclass(frozen=True, eq=False)
class Program:
    """The points ``t`` [s] (never falling), ``x`` [m, or N] between which the device moves evenly, SI or text with
    units, and its ``rate`` [m/s, or N/s] after the last, for as long as there is contact; None: it ends there. Two
    points at one time: a step.
    """

    t: Array
    x: Array
    rate: Annotated[float, Ranged("speed")] | Annotated[float, Ranged("load rate")] | None = None

    def __post_init__(self) -> None:
        read_fields(self, "program", t=Any, x=Any)
        for name, kind in (("t", Time), ("x", AnyLength | AnyForce)):
            given = getattr(self, name)
            if isinstance(given, list | tuple) and any(isinstance(one, str) for one in given):
                given = read(f"program: {name}", reader(tuple.__class_getitem__((kind, ...))), given)
            values = read(f"program: {name}", numbers_of, given)
            values.setflags(write=False)
            object.__setattr__(self, name, values)
            if values.ndim != 1 or not np.isfinite(values).all():
                raise InputError(f"program: {name} must be a column of finite numbers")
        if self.t.size != self.x.size or self.t.size < (1 if self.rate else 2):
            raise InputError(f"program: needs two or more points, and as many times as positions, got {self.t.size}")
        if (falls := np.flatnonzero(np.diff(self.t) < 0)).size:
            row = int(falls[0])
            raise InputError(
                f"program: time must not fall, got t = {self.t[row + 1]:g} s after {self.t[row]:g} s in row {row + 2}"
            )

    @classmethod
    def on(cls, x: float, rate: float) -> Program:
        """From ``x`` on at a ``rate``."""
        return cls(np.zeros(1), np.array([x]), rate)

    def dwelling(self, x: float, lasts: float) -> Program:
        """The same, but going on back only as far as ``x``, where the device stays for the time ``lasts`` [s]."""
        turn, rate = float(self.x[-1]), self.rate or math.nan
        if not x < turn:
            raise InputError(f"program: the dwell must lie before the reversal at {turn:g}, got {x:g}")
        if not lasts > 0:
            raise InputError(f"program: the dwell must last > 0 s, got {lasts:g}")
        reached = float(self.t[-1]) + (x - turn) / rate
        return Program(np.append(self.t, [reached, reached + lasts]), np.append(self.x, [x, x]))

    def highest(self, t: float) -> float:
        """The largest position after the time ``t`` [s]."""
        return math.inf if (self.rate or 0) > 0 else float(np.max(self.x[self.t > t], initial=-math.inf))

    def ramps(self) -> Iterator[Ramp]:
        """The ramps in order; the last has no end where the program has a ``rate``."""
        for one, two in itertools.pairwise(zip(self.t.tolist(), self.x.tolist(), strict=True)):
            yield Ramp.between(*one, *two)
        if self.rate is not None:
            end = math.copysign(math.inf, self.rate)
            yield Ramp(float(self.t[-1]), float(self.x[-1]), math.inf, end, self.rate)


@dataclass(frozen=True)
class Course:
    """The device presses to ``to_load`` [N] or ``to_depth`` [m], both None to the end of the series, and goes back; or
    does what a ``tabulated`` program says."""

    to_load: float | None = None
    to_depth: float | None = None
    tabulated: Any = None

    def refuse_idle(self, called: Callable[[str], str] = str) -> None:
        """InputError, options as they are ``called``, where one that was given would have no effect."""
        others = [item.name for item in fields(self) if getattr(self, item.name) is not None]
        if self.tabulated is not None and len(others) > 1:
            others.remove("tabulated")
            raise InputError(f"cycle: give either {called(others[0])} or {called('program')}")
        if self.to_load is not None and self.to_depth is not None:
            raise InputError(f"cycle: give at most one of {called('to_load')} and {called('to_depth')}")


RESTS = 1e-11  # theory: of positions, what round-off of times and radii leaves
ADVANCE, REST, RECEDE, FREE = "advance", "rest", "recede", "free"


# ---------------------------------------------------------------------- what a path is made of
@dataclass(frozen=True, eq=False, kw_only=True)
class Piece(ABC):
    """What the contact does on one ``ramp``, from ``first`` to ``last``: time [s] and place [m], 0 out of contact.

    ``ends``: "ramp"; "rest", G has come to w; "fold", from where it jumps to the place ``lands``; "fast", too fast for
    equilibrium; "series", at the end of the data; "jump", out of the data; "lost". ``phase``: a word for it; ``work``
    [J] of the device, under load control of the load; ``dissipated``: - int G d(pi a^2) [J].
    """

    phase: str
    ramp: Ramp
    ends: str = "ramp"
    lands: float | None = None
    if TYPE_CHECKING:

        @property
        def first(self) -> tuple[float, float]: ...
        @property
        def last(self) -> tuple[float, float]: ...
        @property
        def work(self) -> float: ...

    @property
    def dissipated(self) -> float:
        return 0.0

    @property
    def parting(self) -> tuple[float, float]:
        """The last state that is reported."""
        return self.last

    @abstractmethod
    def rows(self, points: int) -> tuple[Array, Array]:
        """Times [s] and places [m] of at most ``points`` states."""

    @abstractmethod
    def at(self, t: Array) -> Array:
        """Places [m] at the times ``t`` [s] of the piece."""

    @abstractmethod
    def lowest(self) -> tuple[float, float]:
        """Time [s] and place [m] at the least load."""

    @abstractmethod
    def speeds(self, a: Array, G: Array) -> Array:
        """da/dt [m/s] at places ``a`` [m] and energy release rates ``G`` [J/m^2] of the piece."""

    def unloaded(self) -> Piece | None:
        """The piece from its last state without load on; None where it has none."""
        return None


class Now(NamedTuple):
    """Time [s], place [m] (0: no contact) and the device's position ``x`` between two pieces; ``rests``: G has just
    come to w; ``stands``: the edge is in equilibrium, and moves with the device."""

    t: float
    place: float
    x: float
    rests: bool = False
    stands: bool = False


@dataclass(frozen=True, eq=False)
class Rest(Piece):
    """The crack is pinned between two times: P, delta and x lie on one straight line. At the place 0 there is no
    contact."""

    contact: Contact
    first: tuple[float, float]
    last: tuple[float, float]
    x: float
    x_end: float

    @property
    def _ends(self) -> States:
        return self.contact.states(np.full(2, self.last[1]), np.array([self.x, self.x_end]))

    @property
    def work(self) -> float:
        ends = self._ends
        moved = ends.delta if self.contact.stiffness == LOAD_CONTROL else np.array([self.x, self.x_end])
        return float((ends.P[0] + ends.P[1]) / 2 * (moved[1] - moved[0]))

    def rows(self, points: int) -> tuple[Array, Array]:
        return np.linspace(self.first[0], self.last[0], points), np.full(points, self.last[1])

    def at(self, t: Array) -> Array:
        return np.full(t.shape, self.last[1])

    def lowest(self) -> tuple[float, float]:
        return self.first if self.x < self.x_end else self.last

    def speeds(self, a: Array, G: Array) -> Array:
        return np.zeros_like(a)

    def unloaded(self) -> Rest | None:
        high, low = self._ends.P.tolist()
        if not high > 0 >= low:
            return None
        return replace(self, x=self.x_end - low * (self.x - self.x_end) / (high - low))


@dataclass(frozen=True, eq=False)
class Follow(Piece):
    """Equilibria of a ``curve`` from ``place`` to ``end`` [m] along a stable branch, as fast as the device moves. On a
    step, an instant: the edge comes to equilibrium at ``place``."""

    curve: EquilibriumCurve
    stiffness: float
    place: float
    end: float

    @cached_property
    def first(self) -> tuple[float, float]:
        return self._time(self.place), self.place

    @cached_property
    def last(self) -> tuple[float, float]:
        return self._time(self.end), self.end

    @property
    def work(self) -> float:
        along, k = self.curve.work(self.place, self.end), self.stiffness
        P = self.curve.at(np.array([self.place, self.end]))[1]
        return along + (0.0 if k in (LOAD_CONTROL, math.inf) else float(P[1] ** 2 - P[0] ** 2) / (2 * k))

    @property
    def dissipated(self) -> float:
        a = self.curve.contact_radii(np.array([self.place, self.end]))
        return -float(np.pi * self.curve.w * (a[1] ** 2 - a[0] ** 2))

    def rows(self, points: int) -> tuple[Array, Array]:
        if self.ramp.is_step or self.place == self.end:
            return np.array([self.first[0]]), np.array([self.place])
        places = self.curve.spaced(self.place, self.end, points)
        return self.ramp.t + (self._position(places) - self.ramp.x) / self.ramp.rate, places

    def at(self, t: Array) -> Array:
        if self.ramp.is_step:
            return np.full(t.shape, self.place)
        low, high = (np.full(t.shape, place) for place in sorted((self.place, self.end)))
        x = np.clip(self.ramp.at(t), self._position(low), self._position(high))
        return zeros_between(lambda places: self._position(places) - x, low, high, 0.0)

    def lowest(self) -> tuple[float, float]:
        inner = [point.place for point in self.curve.critical(LOAD_CONTROL) if self.holds(point.place)]
        places = np.array([self.place, *inner, self.end])
        best = float(places[np.argmin(self.curve.at(places)[1])])
        return self._time(best), best

    def speeds(self, a: Array, G: Array) -> Array:
        rising = position(*self.curve.rates(a), self.stiffness)
        rate = 0.0 if self.ramp.is_step else self.ramp.rate
        return np.divide(rate, rising, out=np.full_like(a, np.copysign(np.inf, rate)), where=rising > 0)

    def unloaded(self) -> Follow | None:
        places = [place for place in self.curve.radii_at(0.0, LOAD_CONTROL) if place > 0 and self.holds(place)]
        return replace(self, place=places[0]) if places else None

    def holds(self, place: float) -> bool:
        """Whether the ``place`` [m] is passed through."""
        return min(self.place, self.end) <= place <= max(self.place, self.end)

    def _position(self, places: Array) -> Array:
        return position(*self.curve.at(places), self.stiffness)

    def _time(self, place: float) -> float:
        return self.ramp.when(float(self._position(np.array(place))))


# ---------------------------------------------------------------------- how an edge moves
@dataclass(frozen=True, eq=False)
class EdgeRule:
    """The edge rule of a contact one way in a device of ``stiffness`` [N/m]: in equilibrium with ``curve`` whenever it
    moves, up a stable branch to its maximum of D, if the contact ``grows``, else down to its minimum, and on from there
    by a jump at that D to the next stable radius. A subclass moves otherwise."""

    curve: EquilibriumCurve
    stiffness: float
    grows: bool

    @property
    def begins(self) -> float:
        """Without adhesion contact begins at a point and the path at the first radius of the series."""
        return float(self.curve.places[0]) if self.curve.w == 0 else 0.0

    @property
    def forms(self) -> float:
        """The place [m] from which a contact forms."""
        return self.begins

    @property
    def free(self) -> float:
        """The device's position where the free bodies begin to attract each other."""
        return float(position(self.curve.onset, 0.0, self.stiffness))

    def position(self, place: float) -> float:
        """The device's position in equilibrium at a ``place`` [m]."""
        return float(position(*self.curve.at(np.array(place)), self.stiffness))

    def rises(self, place: float) -> float:
        """dD/da at a ``place`` [m], > 0 where it is stable."""
        return float(position(*self.curve.rates(np.array(place)), self.stiffness))

    def slack(self, place: float) -> float:
        """Round-off of the position there."""
        return RESTS * (abs(self.position(place)) + place * abs(self.rises(place)))

    def move(self, ramp: Ramp, now: Now) -> Piece | None:
        """What it does ``now``; None where that is not in the series."""
        place = now.place if self.stands(now) else self.settled(now.place, now.x)
        if place is None:
            return None
        if ramp.rate * (1 if self.grows else -1) <= 0:
            return self._piece(Ramp(now.t, now.x, now.t, now.x, 0.0), place, place)
        return self.along(ramp, place)

    def stands(self, now: Now) -> bool:
        """Whether the edge is in equilibrium ``now``."""
        return now.stands or bool(now.place and abs(self.position(now.place) - now.x) <= self.slack(now.place))

    def along(self, ramp: Ramp, place: float) -> Follow:
        """From an equilibrium at a ``place`` [m] on as far as the ``ramp``, or the stable branch, goes."""
        whole = self._branch(ramp, place)
        if not math.isfinite(ramp.x_end):
            return whole
        stops = [r for r in self.curve.radii_at(ramp.x_end, self.stiffness) if whole.holds(r)]
        if stops:
            return self._piece(ramp, place, self._next(stops))
        there = abs(self.position(whole.end) - ramp.x_end) <= self.slack(whole.end)
        return self._piece(ramp, place, whole.end) if there else whole

    def settled(self, place: float, x: float) -> float | None:
        """The next stable place [m] beyond ``place`` at the device's position ``x``; None: there is none."""
        stable = [r for r in self.curve.radii_at(x, self.stiffness) if self._beyond(place, r) and self.rises(r) > 0]
        return self._next(stable) if stable else None

    def first(self) -> float | Unknown:
        """The place [m] of first contact, where the free bodies begin to attract each other.

        JKR forces have no range: nothing happens before the undeformed gap closes (D = delta = 0), and there the
        contact spreads to the first stable radius. Surfaces that attract each other may come together without a jump,
        under a cone."""
        if self.begins:
            return self.begins
        curve = self.curve
        if curve.complete and self.rises(least := SAME * float(curve.places[1])) > 0:
            return least
        if not curve.complete and self.position(float(curve.places[0])) > self.free:
            smallest = show(float(curve.contact_radii(curve.places[:1])[0]), "length")
            if curve.ranged:
                return Unknown(f"the surfaces jump to contact radii below {smallest}, where the curve begins")
            return Unknown(
                "contact at delta = 0 is in equilibrium below the smallest radius of the solution, a = "
                f"{smallest}: begin at smaller radii"
            )
        if (place := self.settled(0.0, self.free)) is not None:
            return place
        largest = show(float(curve.contact_radii(curve.places[-1:])[0]), "length")
        return Unknown(
            f"contact at delta = {curve.onset:.4g}{' m' if curve.onset else ''} spreads beyond the largest radius of "
            f"the solution, a = {largest}: increase [loading] radius"
        )

    def _branch(self, ramp: Ramp, place: float) -> Follow:
        """The rest of the stable branch, and how it ends. Contact is lost only where the free bodies do not attract
        each other (without range: overlap, D > 0): else a smaller contact outside the data remains."""
        # Where the stable branch that a place lies on ends; the place itself where it is not stable
        critical, kind = self.curve.critical(self.stiffness), "maximum" if self.grows else "minimum"
        here = next((point.kind for point in critical if point.place == place), None)
        if here == kind or (here is None and self.rises(place) <= 0):
            fold: float | None = place
        else:
            ahead = [point.place for point in critical if point.kind == kind and self._beyond(place, point.place)]
            fold = self._next(ahead) if ahead else None
        if fold is None:
            begin, end = self.curve.places[[0, -1]].tolist()
            gone = self.curve.complete and not self.grows
            return self._piece(ramp, place, end if self.grows else begin, "lost" if gone else "series")
        x, others = self.position(fold), self.curve.critical(self.stiffness)
        lands = self.settled(fold, x) if any(self._beyond(fold, point.place) for point in others) else None
        if lands is not None:
            return self._piece(ramp, place, fold, "fold", lands)
        lost = not self.grows and x <= self.free
        return self._piece(ramp, place, fold, "lost" if lost else "jump")

    def _piece(self, ramp: Ramp, place: float, end: float, ends: str = "ramp", lands: float | None = None) -> Follow:
        phase = ADVANCE if self.grows else RECEDE
        return Follow(self.curve, self.stiffness, place, end, phase=phase, ramp=ramp, ends=ends, lands=lands)

    def _beyond(self, place: float, other: float) -> bool:
        return other > place if self.grows else other < place

    def _next(self, increasing: list[float]) -> float:
        return increasing[0] if self.grows else increasing[-1]


class States(NamedTuple):
    """Contact radius, displacement [m], load [N] and energy release rate [J/m^2]."""

    a: Array
    delta: Array
    P: Array
    G: Array


class Contact:
    """A contact in a device of ``stiffness`` [N/m], whose edge moves by two rules, ``advance`` and ``recede``."""

    stiffness: float
    if TYPE_CHECKING:  # fields of some, properties of others

        @property
        def advance(self) -> EdgeRule: ...
        @property
        def recede(self) -> EdgeRule: ...

    @cached_property
    def edge(self) -> Edge | None:
        """What gives the states between equilibria; None where attraction has a range: there are none."""
        curve = self.recede.curve
        return None if curve.ranged else Edge(curve.nonadhesive, self.stiffness)

    @cached_property
    def least(self) -> float:
        """The device's position when contact begins: where the free bodies begin to attract each other, without
        adhesion that at the first radius."""
        begins = self.advance.begins
        return self.advance.position(begins) if begins else self.advance.free

    def states(self, places: Array, x: Array) -> States:
        """The states at ``places`` [m], 0 out of contact, and positions ``x`` of the device."""
        curve, touching = self.recede.curve, places > 0
        inside = np.where(touching, places, curve.places[0])
        if self.edge is None:
            delta, P, G = *curve.at(inside), np.full_like(inside, curve.w)
        else:
            free = position(curve.onset, 0.0, self.stiffness)  # of what the dent leaves, the edge counts from there
            delta, P, G, _ = self.edge.state(inside, x - free)
            delta = delta + curve.onset
        free = np.zeros_like(x) if self.stiffness == LOAD_CONTROL else x
        a, P, G = (np.where(touching, column, 0.0) for column in (curve.contact_radii(inside), P, G))
        return States(a, np.where(touching, delta, free), P, G)

    def limits(self, place: float) -> tuple[float, float, float]:
        """The device's positions where the edge at ``place`` [m] begins to recede, and to advance, and their
        round-off."""
        recede, advance = self.recede, self.advance
        return recede.position(place), advance.position(place), max(recede.slack(place), advance.slack(place))


@dataclass(frozen=True, eq=False)
class QuasiStatic(Contact):
    """A contact in equilibrium with one curve while it grows, and with another of no smaller w while it shrinks."""

    advancing: EquilibriumCurve
    receding: EquilibriumCurve
    stiffness: float

    def __post_init__(self) -> None:
        if self.receding.w < self.advancing.w:
            raise InputError(
                "cycle: w on retraction must be >= w on approach, got "
                f"{show(self.receding.w, 'work')} and {show(self.advancing.w, 'work')}"
            )

    @cached_property
    def advance(self) -> EdgeRule:
        return EdgeRule(self.advancing, self.stiffness, True)

    @cached_property
    def recede(self) -> EdgeRule:
        return EdgeRule(self.receding, self.stiffness, False)


# ---------------------------------------------------------------------- one piece after the other
@dataclass(frozen=True)
class Jump:
    """A jump from ``start`` to ``end`` at standing device, at the time ``t`` [s]; ``end = None``: contact is lost."""

    start: Equilibrium
    end: Equilibrium | None
    t: float = 0.0


@dataclass(frozen=True, kw_only=True)
class TimedState(Equilibrium):
    """A state at the time ``t`` [s]."""

    t: float


@dataclass(frozen=True, eq=False)
class Path:
    """The path of a device: the ``pieces`` of what happened to ``contact``, in order.

    It ``ends``: "program", "series" (the contact grows beyond its radii, or shrinks below them), "jump" (out of them),
    or "lost".
    """

    contact: Contact
    pieces: tuple[Piece, ...]
    ends: str

    @property
    def last(self) -> float:
        """The place [m] at its end."""
        return self.pieces[-1].last[1]

    @property
    def work(self) -> float:
        """Work of the device [J]; at jumps, the device standing still, it does none."""
        return sum(piece.work for piece in self.pieces)

    @property
    def stretches(self) -> tuple[Follow, ...]:
        """The pieces in equilibrium."""
        return tuple(piece for piece in self.pieces if isinstance(piece, Follow))

    @property
    def out_of_series(self) -> str | None:
        """Why and where the contact left its series; None where it did not."""
        if self.ends not in ("series", "jump"):
            return None
        if self.pieces[-1].phase == RECEDE:
            return (
                "the contact shrinks below the smallest radius of the solution, a = "
                f"{show(self.pieces[-1].last[1], 'length')}, under growing load: use smaller radii, "
                'loading.spacing = "log"'
            )
        return (
            "the contact grows beyond the largest radius of the solution: increase [loading] radius, or reverse before"
        )

    def holds(self, place: float) -> bool:
        """Whether equilibrium at the ``place`` [m] is passed through."""
        return any(piece.holds(place) for piece in self.stretches)

    def up_to(self, place: float) -> Path:
        """The path that ends in equilibrium at the ``place`` [m]."""
        for i, piece in enumerate(self.pieces):
            if isinstance(piece, Follow) and piece.holds(place):
                return replace(self, pieces=(*self.pieces[:i], replace(piece, end=place, ends="ramp")), ends="program")
        raise InputError(
            f"cycle: the reversal at a = {show(place, 'length')} is not reached by stable contact on approach"
        )

    @cached_property
    def jumps(self) -> tuple[Jump, ...]:
        """Where the radius changes while no time goes by, and where contact is lost."""
        jumps = []
        after = (*self.pieces[1:], None) if self.ends == "lost" else self.pieces[1:]
        for one, two in zip(self.pieces, after, strict=False):
            if two is None or (two.phase == FREE and one.phase != FREE):
                jumps.append(Jump(self.state(one, *one.parting), None, one.last[0]))
            elif abs(two.first[1] - one.last[1]) > ROUNDED * one.last[1]:
                jumps.append(Jump(self.state(one, *one.parting), self.state(two, *two.first), one.last[0]))
        return tuple(jumps)

    @property
    def control(self) -> str:
        return control(self.contact.stiffness)

    def state(self, piece: Piece, t: float, place: float) -> TimedState:
        """The state of a ``piece`` at the time ``t`` [s] and ``place`` [m]."""
        if isinstance(piece, Follow):
            return TimedState(**vars(piece.curve.point(place)), t=t)
        a, delta, P, _ = (float(column[0]) for column in self.states(piece, np.array([t]), np.array([place])))
        return TimedState(a=a, delta=delta, P=P, t=t)

    def states(self, piece: Piece, t: Array, places: Array) -> States:
        """The states of a ``piece`` at times [s] and ``places`` [m] of it."""
        if not isinstance(piece, Follow):
            return self.contact.states(places, piece.ramp.positions(t))
        curve = piece.curve
        return States(curve.contact_radii(places), *curve.at(places), np.full_like(places, curve.w))

    def rows(self, points: int) -> dict[str, Array]:
        """Rows of the whole path, at most ``points`` to a piece: "t_s", "a_m" (0 out of
        contact), "delta_m", "P_N", "device_m" (not under load control), "G_J_per_m2", "phase", "part", "c_m" where
        attraction has a range."""
        parts = [piece.rows(points) for piece in self.pieces]
        both = list(zip(self.pieces, parts, strict=True))
        a, delta, P, G = map(np.concatenate, zip(*(self.states(piece, *part) for piece, part in both), strict=True))
        t, places = map(np.concatenate, zip(*parts, strict=True))
        t = np.maximum.accumulate(np.maximum(t, self.pieces[0].ramp.t))  # pieces meet but for round-off
        columns = {"t_s": t, "a_m": a, "delta_m": delta, "P_N": P}
        if self.contact.stiffness != LOAD_CONTROL:
            columns["device_m"] = np.concatenate([piece.ramp.positions(part[0]) for piece, part in both])
        sizes = [part[0].size for part in parts]
        phases = np.repeat([piece.phase for piece in self.pieces], sizes)
        columns |= {"G_J_per_m2": G, "phase": phases, "part": np.repeat(np.arange(len(parts)) + 1, sizes)}
        curve = self.contact.recede.curve
        return columns | ({"c_m": curve.attracted_radii(places)} if curve.ranged else {})


def path(contact: Contact, program: Program, start: float = 0.0, stands: bool = False) -> Path:
    """What happens under ``program``; ``start``: the place [m] of a contact that is there already, else 0; ``stands``:
    in equilibrium, moving with the device."""
    pieces: list[Piece] = []
    ends, now = "program", Now(0.0, start, 0.0, stands=stands)
    for ramp in program.ramps():
        on_ramp, ends = _on_ramp(contact, ramp, now, program)
        pieces += on_ramp
        if ends != "program":
            break
        now = Now(0.0, _after(ramp, pieces[-1]).place, 0.0)
    if not pieces:
        raise InputError(
            "program: the contact grows beyond the largest radius of the solution: increase [loading] radius"
        )
    return Path(contact, tuple(pieces), ends)


def _on_ramp(contact: Contact, ramp: Ramp, now: Now, program: Program) -> tuple[list[Piece], str]:
    """The pieces of one ramp, and how it ends: "program", "series", "jump", or "lost" where no contact forms anew."""
    now, pieces = now._replace(t=ramp.t, x=ramp.x), list[Piece]()
    most = 10 * MOST_STEPS  # a wavy tip jumps at every wave
    for _ in range(most):
        piece = _next(contact, ramp, now)
        if piece is None:
            return pieces, "series"
        pieces.append(piece)
        now = _after(ramp, piece)
        if piece.ends in ("series", "jump") or (piece.ends == "lost" and not program.highest(now.t) > contact.least):
            return pieces, piece.ends
        if now.t >= ramp.t_end:
            return pieces, "program"
    raise InputError(f"program: more than {most} changes between rest and motion on one ramp")


def _after(ramp: Ramp, piece: Piece) -> Now:
    """The state behind a piece."""
    t, place = piece.last
    if math.isfinite(ramp.t_end) and ramp.t_end - t <= RESTS * (ramp.t_end - ramp.t):
        t = ramp.t_end
    x = piece.x_end if isinstance(piece, Rest) else ramp.x_end if t >= ramp.t_end else float(ramp.at(t))
    place = 0.0 if piece.ends == "lost" else place if piece.lands is None else piece.lands
    return Now(t, place, x, piece.ends == "rest", piece.ends == "fold")


def _next(contact: Contact, ramp: Ramp, now: Now) -> Piece | None:
    """What happens from ``now`` on; None where it is not in the series."""
    if now.place == 0:
        # No contact until the device comes to where the free bodies attract each other; then the first place.
        least = contact.least
        if ramp.is_step or now.x < least or (now.x == least and ramp.rate <= 0):
            comes = ramp.rate > 0 and ramp.x_end > least and not ramp.is_step
            end = max(ramp.when(least), now.t) if comes else ramp.t_end
            x = least if comes else ramp.x_end
            return Rest(contact, (now.t, 0.0), (end, 0.0), now.x, x, phase=FREE, ramp=ramp)
        return contact.advance.move(ramp, now._replace(place=contact.advance.forms))
    if ramp.is_step:
        here = now.t, now.place
        return Rest(contact, here, here, ramp.x, ramp.x_end, phase=REST, ramp=ramp)
    if now.stands:
        return (contact.advance if ramp.rate > 0 else contact.recede).move(ramp, now)
    recedes, advances, slack = contact.limits(now.place)
    beyond = now.x - recedes
    if not now.rests and (beyond <= slack if ramp.rate < 0 else beyond < -slack):
        return contact.recede.move(ramp, now)
    if not now.rests and (now.x > advances + slack or (ramp.rate > 0 and now.x >= advances - slack)):
        return contact.advance.move(ramp, now)
    target = {1: advances, -1: recedes, 0: now.x}[int(np.sign(ramp.rate))]
    ends = max(ramp.when(target), now.t)
    if ends >= ramp.t_end:
        ends, target = ramp.t_end, ramp.x_end
    return Rest(contact, (now.t, now.place), (ends, now.place), now.x, target, phase=REST, ramp=ramp)


# ---------------------------------------------------------------------- one way
def grow(contact: QuasiStatic) -> Path | Unknown:
    """The states passed on approach, from where the free bodies begin to attract each other to the end of the series;
    Unknown where the first of them is not in it."""
    first = contact.advance.first()
    return first if isinstance(first, Unknown) else path(contact, Program.on(contact.least, 1.0), first, True)


def shrink(contact: QuasiStatic, begin: float) -> Path:
    """The states passed on retraction from an equilibrium of the advancing edge at the place ``begin`` [m] on, stable
    there or not."""
    recedes, advances, slack = contact.limits(begin)
    return path(contact, Program.on(advances, -1.0), begin, abs(recedes - advances) <= slack)


def largest_stable(curve: EquilibriumCurve, stiffness: float) -> float | None:
    """The largest place [m] of the curve from which a device can retract; None where no branch in it is stable."""
    last = float(curve.places[-1])
    if EdgeRule(curve, stiffness, False).rises(last) > 0:
        return last
    return max((point.place for point in curve.critical(stiffness) if point.kind == "maximum"), default=None)


# --------------------------------------------------------------------------------------------------
# Where the contact lets go under load control, displacement control and a device of given stiffness.
#
# The curve (a, delta, P) is what JKR theory gives; a device shows the part of it that is stable under its own control,
# with jumps in between. Energies are those of quasi-static cycles: what the device puts in and does not get back.

STABLE, GRIPPED, UNSTABLE = "stable", "displacement-control", "unstable"
UNBOUNDED = Unknown("not defined under load control")
PHASES = {ADVANCE: "approach", REST: "turn", RECEDE: "retraction"}  # in the trace of a cycle


def branch(curve: EquilibriumCurve) -> Array:
    """The stability of each point of ``curve``, shape (n,): one of three words.

    "stable": dP/da > 0, under load control and then under any other, since d(delta)/da = (dP/da + S' t)/S;
    "displacement-control": d(delta)/da > 0 only, held by a device that is stiff enough; "unstable": held by none.
    """
    if curve.w == 0:
        return np.full(curve.delta.size, STABLE)
    ddelta, dP = curve.rates(curve.places[: curve.delta.size])
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
        if (missing := _no_energy(self.retraction)) is not None:
            return missing
        # Work [J] along a straight line from no contact to the first state without adhesion
        k, first = self.stiffness, self.begin
        first_chord = first.P / 2 * float(position(first.delta, first.P, k)) if self.contact.advancing.w == 0 else 0.0
        return self.approach.work + first_chord + self.retraction.work

    @cached_property
    def separation(self) -> Estimate:
        """Work of separation [J]: done by the device on retraction, from the last zero load to loss of contact."""
        return separation_work(self.retraction)


def separation_work(retraction: Path) -> Estimate:
    """Work of separation [J]: done by the device on a ``retraction`` from the last zero load to loss of contact."""
    if (missing := _no_energy(retraction)) is not None:
        return missing
    total = 0.0
    for piece in reversed(retraction.pieces):
        if (part := piece.unloaded()) is not None:
            return total + part.work
        total += piece.work
    return Unknown("no state of zero load is passed on retraction: increase [loading] radius")


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
    there is none; ``whole`` and ``retraction``: the cycle and the path that they are of. Of a full end ``pull_off`` is
    where the tension is largest, and ``lost`` where contact is.
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
    lost: CriticalPoint | Unknown | None = None

    @property
    def control(self) -> str:
        """The control in words."""
        return control(self.stiffness)

    @property
    def energy_lost_error(self) -> Estimate:
        """Half-width of the energy lost per cycle [J], or why there is none."""
        return self.whole if isinstance(self.whole, Unknown) else energy_lost_error(self.whole)

    @property
    def separation_error(self) -> Estimate:
        """Half-width of the work of separation [J], or why there is none."""
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
    lost, most = (None, pull_off) if curve.series.rim == math.inf else (pull_off, curve.pull_off(LOAD_CONTROL))
    return Stability(stiffness, critical, most, jump_in, between, *energies, curve.onset, whole, retraction, lost)


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
            f"goes from {show(getattr(first, name), unit)} to {show(getattr(last, name), unit)}"
            f"{': increase [loading] radius' if value > getattr(last, name) else ''}"
        )
    return met[0]


def first_contact(approach: Path) -> Equilibrium:
    """The first state of an approach; the device's position there is exactly that of the free bodies."""
    curve, k = approach.stretches[0].curve, approach.contact.stiffness
    first = curve.point(approach.stretches[0].place)
    if curve.w == 0:
        return first
    if first.a == curve.series.rim:
        return replace(first, delta=0.0, P=0.0)
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
        rising = curve.rates(curve.places)[1] > 0
        if not rising.any():
            raise InputError(
                "load: no contact of this solution is stable under load control: increase [loading] radius"
            )
        P = curve.at(curve.places[rising])[1]
        remedy = ": increase [loading] radius" if load > P.max() else ""
        raise InputError(
            f"load: {show(load, 'load')} is not carried by a stable contact of this solution, whose loads go from "
            f"{show(float(P.min()), 'load')} to {show(float(P.max()), 'load')}{remedy}"
        )
    return stable[-1]


# --------------------------------------------------------------------------------------------------
# Errors of the energies of a cycle: of the energy lost, and of the work of separation.

LEFT = 3.0  # of what doubling elements changes, over (ratio - 1); tuned on random bodies of `make point-bounds`
# theory: share of an energy, the nonadhesive one among them, that cubics between the tabulated functions leave
TABULATED = 1e-10
Change = Callable[[EquilibriumCurve], EquilibriumCurve]  # to another curve of the same body


def energy_lost_error(whole: Cycle) -> Estimate:
    """Half-width of the energy lost per cycle [J], or why it is unknown."""
    advancing, receding, k = whole.contact.advancing, whole.contact.receding, whole.stiffness
    first = whole.approach.stretches[0].place
    above = 1 - math.sqrt(advancing.w / receding.w) if receding.w > 0 else 1.0  # of the errors, what does not cancel
    parts = list[tuple[float, float, float]]()
    for piece in whole.retraction.stretches:  # between the jumps
        parts += [(piece.end, min(piece.place, first), 1.0), (max(piece.end, first), piece.place, above)]

    def again(change: Change) -> Estimate:
        turn = None if whole.turn == advancing.places[-1] else whole.turn
        other = cycle(change(advancing), change(receding), k, turn)
        return other if isinstance(other, Unknown) else other.energy_lost

    return _error(whole.energy_lost, receding, again, _by_points(whole.retraction, parts))


def separation_error(retraction: Path) -> Estimate:
    """Half-width of the work of separation [J] of a ``retraction``, or why it is unknown."""
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
    changes, and what larger elements do, else what the errors of the points make of it, ``by_points``, which tell those
    between the points of a smooth curve, too."""
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
    among_them = isinstance(curve, AdhesiveCurve) and curve.smooth and by_mesh is None
    return (0.0 if among_them else max(between) / curve.thinning) + of_points + TABULATED * abs(energy)


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
    """What the errors of the points, and of a smooth curve those between them, make of the work [J] on ``parts`` of a
    curve, each from one place to another [m] and counted by a factor, and where contact is lost."""
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
            if isinstance(curve, AdhesiveCurve):
                between = curve.work_between(low, high) if curve.smooth else 0.0
                if isinstance(between, Unknown):
                    return between
                delta_H, P_H, *_ = curve.nonadhesive.parts(np.array([low, high]))
                total += factor * (between + TABULATED * float(P_H[1] * (delta_H[1] - delta_H[0])))
    # A jump comes too late by what the position errs by there: the loads before and after it differ over so long
    for jump in retraction.jumps:
        if jump.start.place > max(high for _, high, _ in parts):
            continue
        place = np.array(jump.start.place)
        e = curve.error_at(place)
        off = float(position(e["delta"], e["P"], k))
        if isinstance(curve, AdhesiveCurve) and curve.smooth:  # 0 where pull-off is solved
            here = curve.interpolation_at(place)
            if isinstance(here, Unknown):
                return here
            off += float(position(here["delta"], here["P"], k))
        total += abs(jump.start.P - (0.0 if jump.end is None else jump.end.P)) * off
    return total

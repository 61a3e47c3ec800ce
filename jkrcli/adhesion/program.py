"""What a device does over time: it moves to and fro, waits, steps; under load control the same of the load. A course
is the usual way there and back by turn, speeds and hold; on a contact it becomes a program."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..base import Array, InputError, parse
from .curve import LOAD_CONTROL


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
    """The points ``t`` [s] (never falling), ``x`` [m, or N] between which the device moves evenly, and its ``rate``
    [m/s, or N/s] after the last, for as long as there is contact; None: it ends there. Two points at one time: a step.
    """

    t: Array
    x: Array
    rate: float | None = None

    def __post_init__(self) -> None:
        for name in ("t", "x"):
            values = np.array(getattr(self, name), dtype=float)
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
            raise InputError(f"program: the dwell must lie before the turn at {turn:g}, got {x:g}")
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


def there_and_back(turn: float, inwards: float, outwards: float, hold: float = 0.0, start: float = 0.0) -> Program:
    """From ``start`` on at the speed ``inwards`` up to ``turn``, ``hold`` [s], then back at the speed ``outwards``."""
    for name, speed in (("approach", inwards), ("retraction", outwards)):
        if not (speed > 0 and math.isfinite(speed)):
            raise InputError(f"program: the speed of {name} must be > 0, got {speed:g}")
    if not hold >= 0:
        raise InputError(f"program: the hold must last >= 0 s, got {hold:g}")
    reached = abs(turn - start) / inwards
    return Program(np.array([0.0, reached, reached + hold]), np.array([start, turn, turn]), -outwards)


# ---------------------------------------------------------------------- there and back
class Turning(Protocol):
    """A contact in a device of ``stiffness`` [N/m]: where it begins, and where an approach comes to its turn."""

    @property
    def stiffness(self) -> float: ...
    @property
    def least(self) -> float: ...
    def turning(self, load: float | None, depth: float | None, speed: float) -> float: ...
    def within(self, program: Callable[[float], Program], x: float) -> float: ...


class Moves(NamedTuple):
    """Speeds ``there`` and ``back``, the time of a ``hold``, the position of a ``dwell`` on the way back (None: there
    is none) and its ``dwell_time``; SI."""

    there: float
    back: float
    hold: float
    dwell: float | None = None
    dwell_time: float = 0.0


@dataclass(frozen=True)
class Course:
    """The device presses at ``speed_approach`` (default: ``speed``) to ``to_load`` [N] or ``to_depth`` [m], both None
    to the end of the series, waits for ``hold`` and goes back at ``speed``, as far as ``dwell`` where it then stays for
    ``dwell_time``. Numbers are SI, text carries its unit; under load control speeds are N/s and ``dwell`` is a load.
    """

    speed: float | str
    speed_approach: float | str | None = None
    to_load: float | None = None
    to_depth: float | None = None
    hold: float | str | None = None
    dwell: float | str | None = None
    dwell_time: float | str | None = None

    def moves(self, loaded: bool, called: Callable[[str], str] = str) -> Moves:
        """The fields in SI, under load control where ``loaded``; InputError that names one as it is ``called``."""

        length, speed = ("load", "load rate") if loaded else ("length", "speed")
        back = self._si("speed", called, speed)
        there = back if self.speed_approach is None else self._si("speed_approach", called, speed)
        hold = 0.0 if self.hold is None else self._si("hold", called, "time", least=0.0)
        if self.dwell is None:
            return Moves(there, back, hold)
        dwell = self._si("dwell", called, length, least=-math.inf)
        return Moves(there, back, hold, dwell, self._si("dwell_time", called, "time"))

    def program(self, contact: Turning, called: Callable[[str], str] = str) -> Program:
        """What the device does to ``contact``; InputError that names the field as it is ``called``."""
        if self.to_load is not None and self.to_depth is not None:
            raise InputError("cycle: give the turn as a load or as a depth, not both")
        moves = self.moves(contact.stiffness == LOAD_CONTROL, called)
        x = contact.turning(self.to_load, self.to_depth, moves.there)

        def turned(x: float) -> Program:
            whole = there_and_back(x, moves.there, moves.back, moves.hold, contact.least)
            return whole if moves.dwell is None else whole.dwelling(moves.dwell, moves.dwell_time)

        has_turn = self.to_load is not None or self.to_depth is not None
        return turned(x if has_turn else contact.within(turned, x))

    def _si(self, field: str, called: Callable[[str], str], dimension: str, least: float | None = None) -> float:
        """A field in SI, of a number or text with its unit; > 0 where no ``least`` is given."""
        entry, name = getattr(self, field), called(field)
        try:
            value = parse(entry, dimension) if isinstance(entry, str) else float(entry)
        except ValueError as error:
            raise InputError(f"{name}: {error}") from None
        wrong = value <= 0 if least is None else value < least
        if wrong or not math.isfinite(value):
            raise InputError(f"{name}: must be {'> 0' if least is None else f'>= {least:g}'}, got {entry}")
        return value

"""What a device does there and back, as people say it: speeds, times and places, from which its program is made."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from ..base import InputError, parse
from .device import LOAD_CONTROL
from .program import Program, there_and_back


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

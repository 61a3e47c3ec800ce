"""The course of a device over time: there and back at its speeds, with a hold at the turn and a dwell on the way."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol, cast

import numpy as np

from ..adhesion import device_path
from ..adhesion.curve import LOAD_CONTROL
from ..adhesion.device_path import Program
from ..base.arguments import read
from ..base.errors import InputError
from ..base.units import Ranged


def there_and_back(turn: float, inwards: float, outwards: float, hold: float = 0.0, start: float = 0.0) -> Program:
    """From ``start`` on at the speed ``inwards`` up to ``turn``, ``hold`` [s], then back at the speed ``outwards``."""
    for name, speed in (("approach", inwards), ("retraction", outwards)):
        if not (speed > 0 and math.isfinite(speed)):
            raise InputError(f"program: the speed of {name} must be > 0, got {speed:g}")
    if not hold >= 0:
        raise InputError(f"program: the hold must last >= 0 s, got {hold:g}")
    reached = abs(turn - start) / inwards
    return Program(np.array([0.0, reached, reached + hold]), np.array([start, turn, turn]), -outwards)


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
class Course(device_path.Course):
    """The device presses at ``speed_approach`` (default: ``speed``), waits for ``hold`` and goes back at ``speed``, as
    far as ``dwell`` where it then stays for ``dwell_time``; or what a ``tabulated`` program says. Numbers are SI, text
    carries its unit; under load control speeds are N/s and ``dwell`` is a load.
    """

    speed: float | str | None = None
    speed_approach: float | str | None = None
    hold: float | str | None = None
    dwell: float | str | None = None
    dwell_time: float | str | None = None

    def refuse_idle(self, called: Callable[[str], str] = str) -> None:
        """InputError, options as they are ``called``, where one that was given would have no effect."""
        super().refuse_idle(called)
        if (self.dwell is None) != (self.dwell_time is None):
            raise InputError(f"cycle: {called('dwell')} and {called('dwell_time')} go together")

    def refuse_before_rest(self, called: Callable[[str], str] = str) -> None:
        """The same where the device pulls at once, from rest."""
        before = ("to_load", "to_depth", "speed_approach", "hold", "tabulated")
        for name in before:
            if getattr(self, name) is not None:
                word = called("program" if name == "tabulated" else name)
                raise InputError(f"cycle: a retraction from rest has its {called('speed')} only: leave {word} out")
        if self.speed is None:
            raise InputError(f"cycle: a retraction from rest needs its speed: give {called('speed')}")

    def moves(self, loaded: bool, called: Callable[[str], str] = str) -> Moves:
        """The fields in SI, under load control where ``loaded``; InputError that names one as it is ``called``."""

        length, speed = ("load", "load rate") if loaded else ("length", "speed")
        back = self._si("speed", called, Ranged(speed, above=0))
        there = back if self.speed_approach is None else self._si("speed_approach", called, Ranged(speed, above=0))
        hold = 0.0 if self.hold is None else self._si("hold", called, Ranged("time", least=0))
        if self.dwell is None:
            return Moves(there, back, hold)
        dwell = self._si("dwell", called, Ranged(length))
        return Moves(there, back, hold, dwell, self._si("dwell_time", called, Ranged("time", above=0)))

    def program(self, contact: Turning, called: Callable[[str], str] = str) -> Program:
        """What the device does to ``contact``; InputError that names the field as it is ``called``."""
        self.refuse_idle(called)
        if self.tabulated is not None:
            return cast(Program, self.tabulated)
        if self.speed is None:
            raise InputError(f"cycle: give the motion of the instrument: {called('speed')} or {called('program')}")
        moves = self.moves(contact.stiffness == LOAD_CONTROL, called)
        x = contact.turning(self.to_load, self.to_depth, moves.there)

        def turned(x: float) -> Program:
            whole = there_and_back(x, moves.there, moves.back, moves.hold, contact.least)
            return whole if moves.dwell is None else whole.dwelling(moves.dwell, moves.dwell_time)

        has_turn = self.to_load is not None or self.to_depth is not None
        return turned(x if has_turn else contact.within(turned, x))

    def _si(self, field: str, called: Callable[[str], str], ranged: Ranged) -> float:
        """A field in SI, of a number or text with its unit."""
        return read(called(field), ranged.read, getattr(self, field))

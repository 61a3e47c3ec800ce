"""What a device records over time that presses a body that relaxes: programs, turns, and the table of it all."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...base import (
    LOOKED_AT,
    MOST_STEPS,
    NOTICEABLE,
    SAME,
    Array,
    Estimate,
    InputError,
    Unknown,
    composite_gauss,
    show,
    zeros_between,
)
from ...bodies import Modes, Relaxation
from ..curve import DISPLACEMENT_CONTROL, LOAD_CONTROL, control, position
from ..nonadhesive import Nonadhesive
from ..path import TimedState
from ..program import Program
from .driven import TUNING as DRIVEN
from .driven import Drive
from .path import TUNING, Depths, RelaxedPath, depth_controlled


@dataclass(frozen=True, eq=False)
class RelaxingContact:
    """A contact without adhesion whose moduli relax by ``law``, in a device of ``stiffness`` [N/m]; ``coarser``: how
    many of its steps are joined; ``grows``: see ``RelaxedPath``."""

    body: Nonadhesive
    law: Relaxation
    stiffness: float = DISPLACEMENT_CONTROL
    coarser: int = 1
    grows: float = SAME

    least = 0.0  # the device's position at first contact

    @cached_property
    def depths(self) -> Depths:
        return Depths(self.body)

    def history(self, program: Program) -> RelaxedHistory:
        """What happens under ``program`` of positions [m], of loads [N] under load control."""
        path, most = self._path(program), self.depths.most
        if path.deepest > most * (1 + SAME):
            raise InputError(
                f"program: the contact comes {show(path.deepest - most, 'length')} beyond the largest depth of the "
                f"series, {show(most, 'length')}: turn before, or increase [loading] radius"
            )
        return RelaxedHistory(self, program, path)

    def within(self, program: Callable[[float], Program], x: float) -> float:
        """The turn ``x``, or before it that after which the contact creeps no farther than the series goes."""
        for _ in range(MOST_STEPS):
            beyond = self._path(program(x)).deepest / self.depths.most
            if beyond <= 1 + SAME:
                return x
            x *= (1 - NOTICEABLE) / beyond  # theory: the depth grows no faster than the position
        raise InputError("cycle: no turn keeps the contact within the series: say where it turns, --to-depth")

    def _path(self, program: Program) -> RelaxedPath:
        t, x = _in_contact(*_ended(program), self.stiffness == LOAD_CONTROL)
        modes = self._modes(t)
        if math.isinf(self.stiffness):
            return depth_controlled(self.depths, modes, t, x, TUNING.ratio**self.coarser, self.grows)
        return Drive(self.depths, modes, self.stiffness, t, x, DRIVEN.ratio**self.coarser, self.grows).path()

    def _modes(self, t: Array) -> Modes:
        return self.law.modes(float(t[-1] - t[0]))

    def turning(self, load: float | None, depth: float | None, speed: float) -> float:
        """The device's position where an approach at ``speed`` [m/s, under load control N/s] comes to ``load`` [N] or
        ``depth`` [m]; both None: to the end of the series."""

        if self.stiffness == (DISPLACEMENT_CONTROL if load is None else LOAD_CONTROL):
            return (depth or self.depths.most) if load is None else load
        path = self._approach(speed)
        if load is None and depth is None:
            return speed * path.turn
        name, wanted, unit = ("P", load, "load") if load is not None else ("delta", depth or 0.0, "length")

        def reached(places: Array) -> Array:
            loads = path.load.integral(places, path.load.times(places))
            return np.asarray((loads if load is not None else path.depth.values(places)) - wanted)

        places = np.linspace(0, path.last, LOOKED_AT)
        met = np.flatnonzero(reached(places) >= 0)[:1]
        if not met.size or met[0] == 0:
            raise InputError(
                f"cycle: the turn at {name} = {show(wanted or 0.0, unit)} is not passed on approach, which in this "
                f"series ends at {show(float(reached(places[-1:])[0]) + (wanted or 0.0), unit)}"
            )
        return speed * float(path.load.times(zeros_between(reached, places[met - 1], places[met], 0.0))[0])

    def _approach(self, speed: float) -> RelaxedPath:
        """An approach at ``speed`` to the end of the series."""
        most = self.depths.most
        P = float(self.depths.loads(np.array([most]))[0])
        lasting = float(position(most, P, self.stiffness)) / speed
        for _ in range(MOST_STEPS):
            t, x = np.array([0.0, lasting]), np.array([0.0, speed * lasting])
            if math.isinf(self.stiffness):
                return depth_controlled(self.depths, self._modes(t), t, x)
            grown = Drive(self.depths, self._modes(t), self.stiffness, t, x).grown(most)
            if grown is not None:
                return grown
            lasting *= 2
        raise InputError("cycle: the approach does not come to the end of the series")


def _ended(program: Program) -> tuple[Array, Array]:
    """Times and positions of a program; one that goes on backwards ends at the position 0."""
    if program.rate is None:
        return program.t, program.x
    if program.rate > 0 or program.x[-1] <= 0:
        raise InputError("program: the way back must begin in contact")
    return np.append(program.t, program.t[-1] - program.x[-1] / program.rate), np.append(program.x, 0.0)


def _in_contact(t: Array, x: Array, loaded: bool) -> tuple[Array, Array]:
    """The program from first contact on, where it holds 0; loads up to where they come to 0 again."""
    pressed = np.flatnonzero(x > 0)
    if not pressed.size:
        raise InputError(f"program: never presses: its largest value is {np.max(x):g}, contact begins at 0")
    first = int(pressed[0])
    begin = t[0] if first == 0 else t[first] - x[first] / (x[first] - x[first - 1]) * (t[first] - t[first - 1])
    t, x = np.append(begin, t[first:]), np.append(0.0, x[first:])
    if loaded and (pulled := np.flatnonzero((x[1:] <= 0) & (x[:-1] > 0))).size:
        i = int(pulled[0])
        part = x[i] / (x[i] - x[i + 1])
        t, x = np.append(t[: i + 1], t[i] + part * (t[i + 1] - t[i])), np.append(x[: i + 1], 0.0)
    if not t[-1] > t[0]:
        raise InputError("program: must last longer than no time in contact")
    return t, x


@dataclass(frozen=True, eq=False)
class RelaxedHistory:
    """What happened to ``contact`` under ``program``, on the ``path``."""

    contact: RelaxingContact
    program: Program
    path: RelaxedPath

    @property
    def control(self) -> str:
        """The control in words."""
        return control(self.contact.stiffness)

    @property
    def lost(self) -> float | None:
        """When contact is lost [s]; None where it is not."""
        return self.path.lost if math.isfinite(self.path.lost) else None

    @property
    def turn(self) -> float:
        """When the contact stopped to grow [s]."""
        return self.path.turn

    @property
    def whole(self) -> bool:
        """Whether it grew up to the end of the series."""
        return self.path.deepest >= (1 - NOTICEABLE) * self.path.depths.most

    @cached_property
    def peak(self) -> TimedState:
        """The state of the largest load, to a part of a program's piece."""
        t = np.sort(np.append(self._times(LOOKED_AT), self.turn))
        return max(self._timed(t), key=lambda state: state.P)

    @cached_property
    def corners(self) -> tuple[TimedState, ...]:
        """The states at the corners of the program while there is contact."""
        t = np.unique(self._pieces)
        return self._timed(t[(t > self.path.begin) & (t < self.path.lost)])

    def _timed(self, t: Array) -> tuple[TimedState, ...]:
        rows = np.stack([*self.path.states(t), t], axis=1).tolist()
        return tuple(TimedState(a=a, delta=delta, P=P, t=when) for a, delta, P, when in rows)

    @cached_property
    def error(self) -> float:
        """Largest error of the loads over the largest load [-], of steps in time: what joining each two of them
        changes, an upper limit."""
        if self.contact.coarser > 1:
            return math.nan
        t = self._times(TUNING.degree)
        beside = replace(self.contact, coarser=2).history(self.program)
        P, other = self.path.states(t)[2], beside.path.states(t)[2]
        return float(np.max(np.abs(P - other)) / np.max(P))

    @cached_property
    def energy_lost(self) -> Estimate:
        """Work of the device from first contact to its loss [J], which the body does not give back."""
        if self.lost is None:
            return Unknown("contact is not lost")
        path, places, turn = self.path, np.arange(self.path.last + 1), int(self.path.last)
        steps = (np.diff(path.depth.t) == 0) & (np.abs(path.depth.p[:, 1:].sum(axis=1)) > SAME * path.depths.most)
        if steps[turn:].any():
            return Unknown("the device steps back")
        y, weights = composite_gauss(places)
        P = path.load.integral(y.ravel(), path.load.times(y.ravel()))
        t = path.depth.t[turn:]
        parts = 1 - np.geomspace(1.0, 1e-4, math.ceil(TUNING.intervals / t.size))
        t = np.minimum(np.append(t[:-1, None] + np.diff(t)[:, None] * parts, t[-1]), path.lost)
        later, lasts = composite_gauss(np.unique(np.append(t, path.lost)))
        work = weights.ravel() * path.depth.rates(y.ravel())
        h = np.diff(path.depth.t)[path.depth.places(later.ravel()).astype(int)]
        left = lasts.ravel() * path.depth.rates(path.depth.places(later.ravel())) / h
        return float(P @ work + path.states(later.ravel())[2] @ left)

    @property
    def _pieces(self) -> Array:
        """Ends of the pieces of the program from first contact on."""
        t = _ended(self.program)[0]
        return np.append(self.path.begin, t[t > self.path.begin])

    def _times(self, points: int) -> Array:
        """Times in contact, ``points`` to a piece of the program."""
        ends = np.unique(np.minimum(self._pieces, self.path.lost))
        return np.unique([np.linspace(a, b, points + 1) for a, b in itertools.pairwise(ends)])

    def table(self, points: int) -> dict[str, Array]:
        """Rows of the whole program, ``points`` to a piece: "t_s", "a_m" (0 out of contact), "delta_m", "P_N",
        "device_m" (not under load control), "phase", "part"; at a step the state behind it."""
        ends, x = _ended(self.program)
        parts = [np.linspace(a, b, points) for a, b in itertools.pairwise(ends) if b > a]
        t, number = np.concatenate(parts), np.repeat(np.arange(1, len(parts) + 1), points)
        once = np.append(True, np.diff(t) > 0)  # where pieces meet
        t, number = t[once], number[once]
        a, delta, P = self.states(t)
        columns = {"t_s": t, "a_m": a, "delta_m": delta, "P_N": P}
        if self.contact.stiffness != LOAD_CONTROL:
            columns["device_m"] = np.interp(t, ends, x)
        phases = np.where(a == 0, "free", np.where(t <= self.turn, "advance", "recede"))
        return columns | {"phase": phases, "part": number}

    def states(self, t: Array) -> tuple[Array, Array, Array]:
        """a [m], delta [m], P [N] at the rising times ``t`` [s] of the program; out of contact a = P = 0, and the tip
        is where the device is."""
        loaded, touches = self.contact.stiffness == LOAD_CONTROL, (t >= self.path.begin) & (t < self.path.lost)
        a, P = np.zeros_like(t), np.zeros_like(t)
        delta = np.zeros_like(t) if loaded else np.interp(t, *_ended(self.program))  # of equal times the last
        if touches.any():
            a[touches], delta[touches], P[touches] = self.path.states(t[touches])
        return a, delta, P

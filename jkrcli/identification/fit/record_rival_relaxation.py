"""Rivals of relaxation in a raw record: moduli that fall over the time since the strain, where the contact was and is.

A body whose moduli are r(t) times those at once, under a contact that grows and then shrinks (Ting, J. Appl. Mech. 33
(1966) 845): while it grows P = int r(t - t') dP_H, and while it shrinks P = int_0^t1 r(t - t') dP_H + S int_t1^t r(t -
t') d(delta), t1 the time at which the radius was the same, S the contact stiffness there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import cast

import numpy as np
from scipy.interpolate import CubicSpline

from ...adhesion import Nonadhesive, Program, RelaxingContact
from ...base import REMEMBERED, Array, InputError
from ...bodies import Relaxation
from ...data import APPROACH
from .fitted_record import FittedRecord
from .force_curve import ForceCurveModel, base_line
from .force_curve_readings import DirectionReadings
from .record_change import AMOUNT, Change, Loads, Values
from .record_change import TUNING as CHANGES


@dataclass(frozen=True)
class RelaxationRivalTuning:
    """How finely histories are followed."""

    pieces: int = 60  # choice: of the way of the tip in each direction, for the history of a body that relaxes
    coarser: int = 2  # choice: steps joined in histories, 1e-5 of the loads
    grows: float = 0.02  # choice: of the depth, by which a contact may grow again: noise of the deflection
    times: int = 50  # choice: instants of each direction at which those loads are solved; splines between them
    smooth: float = 2 / 3  # theory: power of the load in which they are drawn, at first contact it is delta^1.5
    instants: int = 100  # choice: at which hereditary integrals are taken


TUNING = RelaxationRivalTuning()
TIME = "relaxation_time"
Memory = Callable[[Array], Array]  # phi of r = 1 - amount phi, of time over that of the record


def relaxing(
    record: FittedRecord, memory: Memory, law: Callable[[Values, float], Relaxation], search: Change
) -> Change | Array | None:
    """Moduli that fall as r(t) = 1 - amount phi(t), phi the ``memory``. In full, where nothing adheres, by a ``law`` of
    the unknowns and of how long the record lasts, ``search`` their names, starts and limits."""
    column = _first_order(record, memory)
    adheres = any(part.tension for part in record.model.stretches)
    timed = np.ptp(record.model.stretches[0].t) > 0
    if column is None or adheres or not timed or record.model.positions:
        return column
    duration = record.duration
    loads = _loads_of_history(record, lambda values: law(values, duration))
    return replace(search, loads=loads, coupled=True, column=column, quantities=partial(_fall_and_time, duration))


def _fall_and_time(duration: float, values: Values) -> dict[str, float]:
    time = {TIME: duration * values[TIME]} if TIME in values else {}
    return {"fall": values[AMOUNT]} | time


@dataclass(frozen=True, eq=False)
class _History:
    """Rows in contact in order of time ``t``, over that of the record: ``delta`` [m], ``a`` [m], load ``P_H`` [N] and
    contact stiffness ``S`` [N/m] without adhesion."""

    t: Array
    delta: Array
    a: Array
    P_H: Array
    S: Array

    def ordered(self, rows: slice | Array) -> _History:
        return _History(*(column[rows] for column in (self.t, self.delta, self.a, self.P_H, self.S)))

    @property
    def thinned(self) -> _History:
        return self.ordered(np.unique(np.linspace(0, self.t.size - 1, TUNING.instants).astype(int)))


def _first_order(record: FittedRecord, memory: Memory) -> Array | None:
    """dP/d(amount) of all rows; None where there are not two directions or next to no contact."""
    if len(record.model.stretches) < 2:
        return None
    touching = [a > 0 for a, _ in record.radii]
    if min(map(np.count_nonzero, touching)) < 4:
        return None
    growing, shrinking = (_history(record, part) for part in record.model.stretches)
    into, out = _ting(memory, growing, shrinking.ordered(slice(None, None, -1)))
    column = np.zeros(record.a.size)
    column[np.concatenate(touching)] = np.concatenate([into, out[::-1]])
    return column * record.at_fixed_position


def _history(record: FittedRecord, part: DirectionReadings) -> _History:
    """The rows of a stretch in contact, in order of position; the base line is the mean of the free rows."""
    rows, (a, _) = record.rows(part), record.radii_of(part)
    P, touching = part.P + record.residuals[rows], a > 0
    base = P[~touching].mean() if (~touching).any() else 0.0
    t, delta = record.time(part), record.model.depth(part, record.values) - (P - base) / record.model.k
    P_H, S = (column[rows] for column in record.nonadhesive)
    return _History(-t if part.kind == APPROACH else t, delta, a, P_H, S).ordered(touching)


def _ting(memory: Memory, growing: _History, shrinking: _History) -> tuple[Array, Array]:
    """Changes of load per amount at the rows of both, in order of time."""
    into, out = growing.thinned, shrinking.thinned
    middle, dP = np.append(into.t[0], (into.t[1:] + into.t[:-1]) / 2), np.diff(into.P_H, prepend=0.0)
    ages = into.t[:, None] - middle
    grown = -np.where(ages >= 0, memory(np.maximum(ages, 0)), 0.0) @ dP
    first = np.interp(out.a, np.maximum.accumulate(into.a), into.t)  # t1
    before = np.where(middle <= first[:, None], memory(out.t[:, None] - middle), 0.0) @ dP
    times = np.concatenate([middle, (out.t + np.append(0.0, out.t[:-1])) / 2])
    steps = np.diff(np.concatenate([into.delta, out.delta]), prepend=into.delta[0])
    ages = out.t[:, None] - times
    since = np.where((times > first[:, None]) & (ages >= 0), memory(np.maximum(ages, 0)), 0.0) @ steps
    shrunk = -(before + out.S * since)
    return np.interp(growing.t, into.t, grown), np.interp(shrinking.t, out.t, shrunk)


def _loads_of_history(record: FittedRecord, law: Callable[[Values], Relaxation]) -> Loads:
    """Loads [N] of all rows of a stretch of a body that relaxes by a ``law`` of the unknowns, by its whole history."""
    t, x = _program(record)
    body = record.body.to_depth(CHANGES.beyond * record.reach)
    nonadhesive = Nonadhesive(body.series, body.slopes)

    @lru_cache(maxsize=REMEMBERED)
    def history(z0: float, moduli: Hashable) -> Sequence[CubicSpline]:
        contact = RelaxingContact(nonadhesive, cast(Relaxation, moduli), coarser=TUNING.coarser, grows=TUNING.grows)
        try:
            path = contact.history(Program(t, x - z0)).path
            lost = min(path.lost, float(t.max()))
            times = [_dense_at_ends(*ends) for ends in ((path.begin, path.turn), (path.turn, lost))]
            return [CubicSpline(one, path.states(one)[2] ** TUNING.smooth) for one in times]
        except InputError:  # there is no such history
            return [CubicSpline([t.min(), t.max()], [0.0, 0.0])] * 2

    def loads(model: ForceCurveModel, part: DirectionReadings, values: Values) -> Array:
        spline = history(values["z0"], cast(Hashable, law(values)))[int(part.kind != APPROACH)]
        first, last = spline.x[[0, -1]]
        P: Array = np.maximum(spline(np.clip(part.t, first, last)), 0.0) ** (1 / TUNING.smooth)
        return math.exp(values["ln_s"]) * np.where((part.t >= first) & (part.t <= last), P, 0.0)

    return loads


def _program(record: FittedRecord) -> tuple[Array, Array]:
    """Times since the turn [s] and positions of the tip [m], about ``TUNING.pieces`` of each direction and the turn."""
    way, back = record.model.stretches
    tips = [part.z - (part.P - base_line(part, record.values)[0]) / record.model.k for part in (way, back)]
    some = slice(None, None, max(way.P.size // TUNING.pieces, 1))
    t = np.concatenate([way.t[some], [0.0], back.t[::-1][some]])
    x = np.concatenate([tips[0][some], [record.tip_turn], tips[1][::-1][some]])
    order = np.argsort(t, kind="stable")
    return t[order], x[order]


def _dense_at_ends(first: float, last: float) -> Array:
    place: Array = (1 - np.cos(math.pi * np.linspace(0, 1, TUNING.times))) / 2
    return first + (last - first) * place

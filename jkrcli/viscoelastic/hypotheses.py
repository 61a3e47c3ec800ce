"""Hypotheses over time in a raw record: w over the speed of the edge, and moduli that fall over the time since the
strain, where the contact was and is.

A body whose moduli are r(t) times those at once, under a contact that grows and then shrinks (Ting, J. Appl. Mech.
33 (1966) 845): while it grows P = int r(t - t') dP_H, and while it shrinks P = int_0^t1 r(t - t') dP_H + S int_t1^t
r(t - t') d(delta), t1 the time at which the radius was the same, S the contact stiffness there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any, TypeAlias, cast

import numpy as np

from ..adhesion.curve import Nonadhesive
from ..adhesion.device_path import Program
from ..base.errors import InputError
from ..base.numerics import Array, PiecewiseCubic, cubic_spline, median
from ..base.process import REMEMBERED
from ..bodies.problem import PowerRelaxation, Relaxation, StandardSolid
from ..measured.branches import rest
from ..measured.choices import Values
from ..measured.curve import APPROACH
from ..measured.fitted_record import FittedRecord
from ..measured.force_curve import DirectionReadings, ForceCurveModel, Loads, base_line, load_at, receding
from ..measured.model_changes import (
    ADHESION,
    AMOUNT,
    CHANGE_BEYOND,
    LITTLE,
    MEMORY,
    AlternativeModel,
    Change,
    LoadsChange,
    root_of,
)

# Which laws of w over the speed are searched.
# choice: rise of w at the usual speed of the edge and power of the speed, to begin with
ADHESION_SPEEDS = ((0.3, 0.3), (0.3, 0.8), (1.0, 0.3), (1.0, 0.8))
# choice: of the speed of the edge, that are searched; measured 0.1 to 1
ADHESION_POWERS = (0.1, 1.5)


POWER = "n"

# How finely histories are followed.
RELAXATION_PIECES = 60  # choice: of the way of the tip in each direction, for the history of a viscoelastic body
RELAXATION_COARSER = 2  # choice: steps joined in histories, 1e-5 of the loads
RELAXATION_GROWS = 0.02  # choice: of the depth, by which a contact may grow again: noise of the deflection
RELAXATION_TIMES = 50  # choice: instants of each direction at which those loads are solved; splines between them
RELAXATION_SMOOTH = 2 / 3  # theory: power of the load in which they are drawn, at first contact it is delta^1.5
RELAXATION_INSTANTS = 60  # choice: at which hereditary integrals are taken; 400 change columns by 2e-3 (rms)


TIME = "relaxation_time"
Memory: TypeAlias = Callable[[Array], Array]  # phi of r = 1 - amount phi, of time over that of the record


def work_over_speed(record: FittedRecord) -> Change | None:
    """w of the retraction over the speed v of its edge. The column is that of w (v/v_m)^amount, dP/d(ln w) ln(v/v_m)
    with v_m the median; in full w = w0 (1 + amount (v/v_m)^n)."""
    part = record.retraction
    name = "" if part is None else f"q:{part.kind}"
    if part is None or name not in record.fit.names:
        return None
    a, rests = record.radii[-1]
    moves = (a > 0) & ~rests
    if (speeds := _log_speeds(part.z[moves], a[moves])) is None:
        return None
    middle, logs = speeds
    typical, log = math.exp(middle), np.zeros(record.a.size)  # v_m over the speed of the device
    log[record.rows(part, moves)] = logs

    def loads(model: ForceCurveModel, part: DirectionReadings, values: Values) -> Array:
        s, q = math.exp(values["ln_s"]), max(values[f"q:{part.kind}"], LITTLE**3 * model.most)
        turn, n = part.turn - values["z0"], values[POWER]
        resting = rest(model.family, s, root_of(values, model.stretches[0].kind), math.sqrt(q), model.k, turn)
        law = max(values[AMOUNT], LITTLE**2) * typical**-n, n
        path = receding(model.family, s, q, model.k, law, resting, turn)
        return np.where(part.touching, load_at(path, resting, turn, model.depth(part, values)), 0.0)

    return LoadsChange(
        loads=loads, where="last", coupled=True, column=record.by_unknown(name) * record.values[name] * log,
        names=(AMOUNT, POWER), starts=ADHESION_SPEEDS, limits={AMOUNT: (0.0, 1e3), POWER: ADHESION_POWERS},
        quantities=lambda values: {name: values[name] for name in (AMOUNT, POWER)},
    )  # fmt: skip


def _log_speeds(z: Array, a: Array) -> tuple[float, Array] | None:
    """Logs of the speed of the edge over that of the device, da/dz as the device moves evenly: their median, and those
    of all rows less it; None where no position has a neighbour on either side."""
    steps, positions = np.diff(z), z
    if repeats := not (steps > 0).all():  # readings of a position
        positions, rows = np.unique(z, return_index=True)
        a, steps = a[rows], np.diff(positions)
    if positions.size < 3:
        return None
    # slopes of the parabolas through three neighbours, at the ends of the straight lines through two
    secants = np.diff(a) / steps
    inner = (steps[1:] * secants[:-1] + steps[:-1] * secants[1:]) / (steps[1:] + steps[:-1])
    log = np.log(np.maximum(np.abs(np.concatenate([secants[:1], inner, secants[-1:]])), 1e-9))
    middle = median(log)
    log -= middle
    return middle, np.interp(z, positions, log) if repeats else log


# ---------------------------------------------------------------------- relaxation
@dataclass(frozen=True, eq=False, kw_only=True)
class MemoryChange(LoadsChange):
    """Moduli that fall as r(t) = 1 - amount phi(t), phi the ``memory``, which is 0 of no age."""

    memory: Memory

    @staticmethod
    def columns(asked: Sequence[tuple[FittedRecord, Any]]) -> list[Array | None]:
        histories = {record: _history(record) for record in {record for record, _ in asked}}
        found = list[Array | None]()
        for record, change in asked:
            column = np.zeros(record.a.size)
            for rows, at, t, ages, counts in histories[record]:
                column[rows] = np.interp(at, t, -np.sum(change.memory(ages) * counts, axis=1))
            found.append(column * record.at_fixed_position)
        return found


def relaxing(
    record: FittedRecord, memory: Memory, law: Callable[[Values, float], Relaxation], **search: Any
) -> Change | None:
    """Moduli that fall with a ``memory``. In full, where nothing adheres, by a ``law`` of the unknowns and of how long
    the record lasts; ``search``: their names, starts and limits."""
    model, duration = record.model, record.model.stretches[0].lasting
    if len(model.stretches) < 2 or min(np.count_nonzero(a) for a, _ in record.radii) < 4:
        return None  # not two directions, or next to no contact
    timed, adheres = np.ptp(model.stretches[0].t) > 0, any(part.tension for part in model.stretches)
    if adheres or not timed or model.positions:
        return MemoryChange(memory=memory)

    def quantities(values: Values) -> dict[str, float]:
        return {"fall": values[AMOUNT]} | ({TIME: duration * values[TIME]} if TIME in values else {})

    loads = _loads_of_history(record, lambda values: law(values, duration))
    return MemoryChange(memory=memory, loads=loads, coupled=True, quantities=quantities, **search)


def _history(record: FittedRecord) -> list[tuple[Array, Array, Array, Array, Array]]:
    """What memories act on, of each direction: the rows in contact in order of time, when they were, some of these
    instants over the time of the record, the ages of the changes of the strain before each (instants, changes), and
    what each change counts [N]. Ting: on the way out what came before t1, when the radius was the same, as load, the
    rest as displacement."""
    (rows, at, (t, depth, a, P_H)), (rows_out, at_out, (t_out, depth_out, a_out, _)) = (
        _instants(record, which) for which in (0, 1)
    )
    middle = np.append(t[0], (t[1:] + t[:-1]) / 2)
    times = np.concatenate([middle, (t_out + np.append(0.0, t_out[:-1])) / 2])
    t1 = np.interp(a_out, np.maximum.accumulate(a), t)
    _, T, _, V = record.model.family.values(np.log(a_out))

    # what each change counts: dP_H up to t1, S d(delta) later
    steps = np.diff(np.append(depth, depth_out), prepend=depth[0])
    dP = np.append(np.diff(P_H, prepend=0.0), np.zeros(t_out.size))
    counts = np.where(times > t1[:, None], (record.modulus * V / T)[:, None] * steps, dP)
    return [
        (rows, at, t, np.maximum(t[:, None] - middle, 0.0), dP[: t.size]),
        (rows_out, at_out, t_out, np.maximum(t_out[:, None] - times, 0.0), counts),
    ]


def _instants(record: FittedRecord, which: int) -> tuple[Array, Array, Array]:
    """The rows in contact of a stretch in order of time, when they were, and at some of them that time, the depth, the
    contact radius and P_H, (4, instants)."""
    part, a = record.model.stretches[which], record.radii[which][0]
    rows = slice(record.model.ends[which], record.model.ends[which + 1])
    touching, t = a > 0, record.time(part) * (-1 if part.kind == APPROACH else 1)
    inside = np.flatnonzero(touching)[:: 1 if which == 0 else -1]
    thin = inside[np.unique(np.linspace(0, inside.size - 1, RELAXATION_INSTANTS).astype(int))]
    P = part.P + record.residuals[rows]
    base = P[~touching].mean() if inside.size < a.size else 0.0
    depth = record.depth[rows][thin] - (P[thin] - base) / record.model.k
    return inside + rows.start, t[inside], np.array([t[thin], depth, a[thin], record.P_H[rows][thin]])


def _loads_of_history(record: FittedRecord, law: Callable[[Values], Relaxation]) -> Loads:
    """Loads [N] of all rows of a stretch of a viscoelastic body by a ``law`` of the unknowns, by its whole history."""
    # Times since the turn [s] and positions of the tip [m], about ``RELAXATION_PIECES`` of each direction and the turn
    way, back = record.model.stretches
    bent = [(part.P - base_line(part, record.values)[0]) / record.model.k for part in (way, back)]
    tips, turn = (way.z - bent[0], back.z - bent[1]), way.turn - bent[0][int(np.argmax(way.z))]
    some = slice(None, None, max(way.P.size // RELAXATION_PIECES, 1))
    t = np.concatenate([way.t[some], [0.0], back.t[::-1][some]])
    x = np.concatenate([tips[0][some], [turn], tips[1][::-1][some]])
    order = np.argsort(t, kind="stable")
    t, x = t[order], x[order]
    from .relaxation import RelaxingContact

    body = record.body.to_depth(CHANGE_BEYOND * record.reach)
    nonadhesive = Nonadhesive(body.series, body.slopes)

    @lru_cache(maxsize=REMEMBERED)
    def history(z0: float, moduli: Relaxation) -> Sequence[PiecewiseCubic]:
        contact = RelaxingContact(nonadhesive, moduli, coarser=RELAXATION_COARSER, grows=RELAXATION_GROWS)
        try:
            path = contact.history(Program(t, x - z0)).path
            lost = min(path.lost, float(t.max()))
            place = (1 - np.cos(math.pi * np.linspace(0, 1, RELAXATION_TIMES))) / 2
            times = [a + (b - a) * place for a, b in ((path.begin, path.turn), (path.turn, lost))]
            return [cubic_spline(one, path.states(one)[2] ** RELAXATION_SMOOTH) for one in times]
        except InputError:  # there is no such history
            return [cubic_spline(np.array([t.min(), t.max()]), np.zeros(2))] * 2

    def loads(model: ForceCurveModel, part: DirectionReadings, values: Values) -> Array:
        spline = history(values["z0"], cast(Hashable, law(values)))[int(part.kind != APPROACH)]
        first, last = spline.x[[0, -1]]
        P: Array = np.maximum(spline(np.clip(part.t, first, last)), 0.0) ** (1 / RELAXATION_SMOOTH)
        return math.exp(values["ln_s"]) * np.where((part.t >= first) & (part.t <= last), P, 0.0)

    return loads


HYPOTHESES: tuple[AlternativeModel, ...] = (
    AlternativeModel(
        "w over the speed of the edge", ADHESION, "relative rise per factor e of the speed", work_over_speed),
    AlternativeModel("relaxation over a factor of time", MEMORY, "fall per factor e", partial(
        relaxing, memory=lambda t: np.log(1 + 100 * t),
        law=lambda values, duration: PowerRelaxation(duration, values[AMOUNT]),
        starts=((0.1,), (0.3,)), limits={AMOUNT: (1e-4, 0.9)})),
    AlternativeModel("relaxation of one time", MEMORY, "fall", partial(
        relaxing, memory=lambda t: 1 - np.exp(-4 * t),
        law=lambda values, duration: StandardSolid(1 - values[AMOUNT], duration * values[TIME]),
        names=(AMOUNT, TIME), starts=((0.3, 0.03), (0.3, 0.2), (0.6, 0.5)),
        limits={AMOUNT: (1e-4, 0.999), TIME: (1e-3, 10.0)})),
)  # fmt: skip

"""Rivals of the device in a raw record, and of one direction against the other: stiffness, positions, flow."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...base import Array
from ...data import APPROACH
from .device_path import grid
from .family import Family
from .fitted_record import FittedRecord
from .force_curve_readings import DirectionReadings
from .record_change import AMOUNT, LITTLE, Change, change_of_body, of_body


def stiffness(record: FittedRecord) -> Change | None:
    """k (1 + amount) of the device, its loads as they are: rows and the turn are deeper by amount P/k."""
    model = record.model
    if not math.isfinite(model.k):
        return None
    column, part = record.by_position * record.loads, model.stretches[-1]
    resting = model.rest(part, record.values)
    if resting is not None and "z0" in record.fit.names:
        by_turn = -record.by_unknown("z0") - record.by_position
        column = column + by_turn * float(resting.at(np.array(part.turn - record.values["z0"]))[0])
    return Change(
        limits={AMOUNT: (LITTLE - 1, math.inf)},
        model=lambda plain, part, values: replace(plain, k=plain.k * (1 + values[AMOUNT])),
        quantities=lambda values: {"stiffness": model.k * (1 + values[AMOUNT])},
        column=column / model.k,
    )


def misplaced(record: FittedRecord, error: Callable[[DirectionReadings], Array], name: str = AMOUNT) -> Change | None:
    """Rows that stand deeper than their positions say by the amount times an ``error`` [m], which results call by a
    ``name``: the column is P' error."""
    if len(record.model.stretches) < 2 or name in record.model.positions:
        return None
    return Change(
        shift=lambda part, values: values[AMOUNT] * error(part),
        quantities=lambda values: {name: values[AMOUNT]},
        column=record.by_position * np.concatenate([error(part) for part in record.model.stretches]),
    )


def drift(record: FittedRecord) -> Change | None:
    """Depths that drift by the amount times the way in contact over the time of the record, 0 at the turn."""
    if "drift" in record.model.positions:
        return None
    signs = {part.kind: 1.0 if part.kind == APPROACH else -1.0 for part in record.model.stretches}
    return misplaced(record, lambda part: signs[part.kind] * record.time(part) * record.reach)


def misplaced_back(
    error: Callable[[FittedRecord, DirectionReadings], Array], name: str = AMOUNT
) -> Callable[[FittedRecord], Change | None]:
    """The same of the retraction alone."""

    def effect(record: FittedRecord) -> Change | None:
        return misplaced(
            record, lambda part: error(record, part) if part.kind != APPROACH else np.zeros(part.z.size), name
        )

    return effect


def another_modulus(record: FittedRecord) -> Change | None:
    """E* (1 + amount) on the way back."""
    if len(record.model.stretches) < 2 or "ln_s" not in record.fit.names or record.retraction is None:
        return None

    def changes(family: Family, amount: float) -> Array:
        same = np.zeros_like(grid(family))
        return of_body(family, same, same + math.log1p(amount))

    column = np.where(record.rows(record.retraction), record.by_unknown("ln_s"), 0.0)
    return replace(change_of_body(changes, (LITTLE - 1, math.inf), last=True), column=column)


def slope_at_rest(record: FittedRecord) -> Array | None:
    """S (1 + amount) of the line on which the edge rests, about the turn."""
    part = record.retraction
    if part is None:
        return None
    rests = record.radii_of(part)[1]
    if np.count_nonzero(rests) < 3:
        return None
    column, rows = np.zeros(record.a.size), record.rows(part, rests)
    column[rows] = (record.by_position * record.at_fixed_position)[rows] * (part.z[rests] - part.turn)
    return column

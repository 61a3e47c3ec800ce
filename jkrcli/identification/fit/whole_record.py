"""Which curves are fitted as whole raw records, and which of their directions."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...base import FEWEST_ROWS, InputError, Unknown
from ...data import APPROACH, RETRACT, TURNED, Curve, ForceCurve, examine
from ..parameters import POSITIONS
from .points import third_differences
from .positions import TIMED
from .settings import AUTO, CALIBRATED, Settings


@dataclass(frozen=True)
class WholeRecordTuning:
    """When a record is taken as a whole."""

    placed: float = 0.3  # choice: scatter of positions over that of loads, both over their range, of a table


TUNING = WholeRecordTuning()

PARAMETERS = frozenset({"modulus", "w", "delta0", "P0", *POSITIONS})  # of a whole record; others need prepared readings
FREE = (-math.inf, math.inf)
ZEROS = frozenset({"delta0", "P0", "compliance"})  # always fitted, or known by the stiffness of the device


def whole_record(curve: Curve, settings: Settings) -> ForceCurve | None:
    """The record taken apart, where base line and contact are to be fitted together; None: the readings as they are.

    By itself that is so for records of a device whose deflection is known, or of both directions with a base line each;
    without a base line the zero of the load is that of the file.
    """
    prepared = settings.contact == "as-is"
    only = [f"--base-line {settings.base_line}"] * (settings.base_line != "straight") + list(settings.positions)
    only += [f"--model {settings.model}"] * (settings.model == AUTO)
    required = settings.contact == "fitted" or bool(only)
    if prepared or curve.a is not None or curve.delta is None or curve.P is None:
        if required:
            what = next(iter(only), "--contact fitted")
            raise InputError(f"{what} is for raw records of displacement and load, with --contact fitted or auto")
        return None
    try:
        record = examine(curve)
    except InputError:
        if required:
            raise
        return None
    if not (required or _raw(record)):
        if settings.contact != "auto" or not _as_read(record, settings):
            return None
        _refuse_wrong_way(record)
        return record
    idle = [name for name in settings.uncertain if name in CALIBRATED and curve.stiffness in (None, math.inf)]
    if idle:
        raise InputError(f"{curve.where}: --uncertain {idle[0]}: the record has no stiffness, so it has no effect here")
    _refuse_wrong_way(record)
    _check_positions(curve, settings)
    return record


def _refuse_wrong_way(record: ForceCurve) -> None:
    """InputError where the displacement counts the other way round."""
    if reason := record.flags.get("wrong way"):
        if any(TURNED in flag for flag in record.curve.flags):  # --flip is of the sign in the file
            reason = reason.replace("--flip delta", "its sign was turned when it was read: --factor delta=-1")
        raise InputError(f"{record.curve.where}: {reason}")


def _check_positions(curve: Curve, settings: Settings) -> None:
    """InputError where an error of positions is to be fitted that the record, or another option, does not determine."""
    for name in settings.positions:
        if settings.segment not in (None, "both"):
            raise InputError(f"{curve.where}: {name} needs approach and retraction together: leave --segment out")
        if name in TIMED and (curve.t is None or not np.ptp(curve.t) > 0):
            raise InputError(f"{curve.where}: {name} needs a column of time, there is none: leave {name} out")
        if beyond_the_record(settings):
            raise InputError(
                f"{curve.where}: {name} is told by a whole record, which knows no range, stress, compliance, "
                "layers' own parameters, --branch, --noise, --start and --bound: leave these or it out"
            )


def _raw(record: ForceCurve) -> bool:
    """Whether it is an instrument's record, and no prepared readings: a base line is there, or no contact at all, and
    the scatter is in the load."""
    sides = [kind for kind in (APPROACH, RETRACT) if usable(record, kind)]
    delta, P = record.curve.device, record.curve.P
    assert P is not None
    if third_differences(delta) * np.ptp(P) > TUNING.placed * third_differences(P) * np.ptp(delta):
        return False
    if len(sides) > 1 or (sides and record.curve.stiffness is not None):
        return True
    return len(record.directions) > 1 and bool({"no contact", "no force curve"} & set(record.flags))


def _as_read(record: ForceCurve, settings: Settings) -> bool:
    """Whether a record without a base line is that of a device, on which an edge rests where it turns."""
    return record.curve.stiffness is not None and bool(record.directions) and not beyond_the_record(settings)


def beyond_the_record(settings: Settings) -> bool:
    """Whether the settings have an option that the model of a whole record does not know."""
    named = any(p.name not in PARAMETERS or p.value is not None for p in settings.free)
    bound = any(p.name != "modulus" and (p.low, p.high) != FREE for p in settings.free)
    fixed = any(p.name in ZEROS & settings.named and not p.free for p in settings.parameters)
    return settings.range is not None or named or bound or fixed or settings.branch != "all" or bool(settings.noise)


def usable(record: ForceCurve, kind: str) -> bool:
    side = record.direction(kind)
    if side is None or isinstance(side.touch, Unknown):
        return False
    return side.begins_free and side.base.rows >= FEWEST_ROWS


def requested(settings: Settings) -> tuple[str, ...]:
    """The requested directions."""
    return (APPROACH, RETRACT) if settings.segment in (None, "both") else (str(settings.segment),)


def directions_of(record: ForceCurve, settings: Settings) -> tuple[str, ...]:
    """The directions to fit: those requested that can be fitted."""
    wanted = requested(settings)
    kinds = tuple(kind for kind in wanted if usable(record, kind))
    if not kinds and settings.contact == "auto" and record.curve.stiffness is not None:
        kinds = tuple(kind for kind in wanted if record.direction(kind) is not None)
    if not kinds:
        reasons = [f"{kind}: {reason_not(record, kind)}" for kind in wanted]
        raise InputError(f"no direction can be fitted ({'; '.join(reasons)})")
    return kinds


def reason_not(record: ForceCurve, kind: str) -> str:
    """Why a direction cannot be fitted."""
    side = record.direction(kind)
    if side is None:
        return "not in the record"
    return side.touch.reason if isinstance(side.touch, Unknown) else "it has no base line"

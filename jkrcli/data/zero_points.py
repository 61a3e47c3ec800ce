"""Zero points of a recorded approach, by its base line and the row at which the load leaves that for good."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..base import SAME, InputError, Unknown, show
from .measured.curve import APPROACH, Curve
from .record import TUNING as RECORDS
from .record import Direction, examine, in_succession

GIVE = "give --zero P=... and --zero delta=..."


@dataclass(frozen=True)
class FirstTouchTuning:
    """What separates contact from the free part of an approach."""

    sigmas: float = 5.0  # theory: standard deviations of normal noise that no row of a million reaches


TUNING = FirstTouchTuning()


def with_zero_points(curve: Curve) -> Curve:
    """The curve with the load's straight base line subtracted (tilt too) and displacement 0 at first touch.

    By the positions of the device, whose deflection by the load that is left is subtracted where its stiffness is
    known.

    First touch is where the load of the approach leaves the base line for good: in JKR contact forces have no range,
    so that is delta = 0, with a jump into contact or without. Between two rows: half a step of uncertainty. An
    estimate to start from, not a measurement. InputError where the approach holds no free part.
    """
    side = _approach(curve)
    z, P = curve.device[side.segment.rows], curve.load[side.segment.rows]
    off, free = np.abs(P - side.base(z)), side.base.rows
    scatter = RECORDS.normal * float(np.median(off[:free]))
    away = off > max(TUNING.sigmas * scatter, SAME * float(np.ptp(P)))  # the latter in records without noise
    first = max(int(np.argmax(in_succession(away))), 1)
    touch, half = float(z[first - 1] + z[first]) / 2, abs(float(z[first] - z[first - 1])) / 2
    flag = (
        f"zero points estimated from {free} free rows: first touch at {show(touch, 'length')} (within "
        f"{show(half, 'length')}), baseline {show(float(side.base(np.array(touch))), 'load')} with a tilt of "
        f"{side.base.tilt:.3g} N/m"
    )
    P = curve.load - side.base(curve.device)
    delta = curve.device - touch - (0.0 if curve.stiffness is None else P / curve.stiffness)
    return replace(curve, delta=delta, P=P, flags=(*curve.flags, flag))


def _approach(curve: Curve) -> Direction:
    """The approach of a curve; InputError where it shows no zero points."""
    side = examine(curve).direction(APPROACH)
    if side is None:
        segments = f" (segments: {', '.join(curve.segments())})" if curve.segment is not None else ""
        raise InputError(f"{curve.where}: has no approach{segments}: zero points cannot be estimated")
    if isinstance(side.touch, Unknown):
        raise InputError(f"{curve.where}: the load of the approach never leaves its baseline: no contact was made")
    if not side.begins_free:
        raise InputError(f"{curve.where}: the approach has no free part, which zero points are estimated from; {GIVE}")
    return side

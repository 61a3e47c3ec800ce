"""Zero points of a recorded approach, estimated from its free part; a detector at its limit."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ...base import Array, InputError, show
from .curve import APPROACH, Curve

GIVE = "give --zero P=... and --zero delta=..."


@dataclass(frozen=True)
class FirstTouchTuning:
    """Limits that tell the free part of an approach from contact."""

    free: float = 0.1  # choice: of the approach, by displacement: the part that must be free of contact
    fewest: int = 10  # choice: rows in it
    sigmas: float = 5.0  # theory: standard deviations of normal noise that no row of a million reaches
    least_rise: float = 1e-6  # choice: of the range of the load, for records without noise
    normal: float = 1.4826  # theory: standard deviation over median deviation of normal noise
    run: int = 3  # choice: rows in succession that must agree
    saturated: int = 5  # choice: rows in succession at the very same largest load that are said
    moved: float = 2e-3  # choice: of the way, how far the device must move on meanwhile
    levels: float = 10.0  # choice: of a converter, by which the load must have come there within as many rows


TUNING = FirstTouchTuning()


def with_zero_points(curve: Curve) -> Curve:
    """The curve with the load's straight baseline subtracted (tilt too) and displacement 0 at first touch.

    By the positions of the device, whose deflection by the load that is left is subtracted where its stiffness is
    known.

    First touch is where the load of the approach leaves the baseline for good: in JKR contact forces have no range,
    so that is delta = 0, with a jump into contact or without. Between two rows: half a step of uncertainty. An
    estimate to start from, not a measurement. InputError where the approach holds no free part.
    """
    if curve.delta is None or curve.P is None:
        raise InputError(f"{curve.where}: zero points are estimated from displacement and load, it holds "
                         f"{', '.join(curve.measured)}")  # fmt: skip
    rows, device = _approach(curve), curve.device
    z, P = device[rows], curve.P[rows]
    end = free = _end_of_free_part(curve, z)
    line = np.polynomial.Polynomial.fit(z[:end], P[:end], 1)
    _refuse_contact(curve, (P - line(z))[:end], float(np.ptp(P)))
    for _ in range(2):  # once more with the whole free part
        first = _first_touch(z, P, line, end)
        if first is None:
            raise InputError(f"{curve.where}: the load of the approach never leaves its baseline: no contact was made")
        if first < free:
            raise InputError(f"{curve.where}: row {first + 1} of the approach lies off the baseline of its first "
                             f"{TUNING.free:.0%}: no zero points without a free part; {GIVE}")  # fmt: skip
        end = max(first - TUNING.run, end)
        line = np.polynomial.Polynomial.fit(z[:end], P[:end], 1)
    assert first is not None
    touch = float(z[first - 1] + z[first]) / 2
    rate = float(line.deriv()(touch))
    said = (
        f"zero points estimated from {end} free rows: first touch at {show(touch, 'length')} "
        f"(within {show(abs(float(z[first] - z[first - 1])) / 2, 'length')}), baseline "
        f"{show(float(line(touch)), 'load')} with a tilt of {rate:.3g} N/m"
    )
    P = curve.P - line(device)
    delta = device - touch - (0.0 if curve.stiffness is None else P / curve.stiffness)
    return replace(curve, delta=delta, P=P, flags=(*curve.flags, said))


def saturation(curve: Curve) -> tuple[str, ...]:
    """A sentence where the load stands still at its largest or smallest value while the device moves on, as it does at
    a detector's limit."""
    if curve.P is None or curve.delta is None:
        return ()
    z = curve.device
    for name, end in (("largest", curve.P.max()), ("smallest", curve.P.min())):
        count = _standing_still(curve.P, z, float(end))
        if count:
            return (f"{count} rows in succession hold the same {name} load, {show(float(end), 'load')}: "
                    "is the detector at its limit?",)  # fmt: skip
    return ()


def _standing_still(P: Array, z: Array, end: float) -> int:
    """Rows of the longest run at the load ``end``, where it came there by more than some steps of the converter."""
    held = np.flatnonzero(np.diff(np.concatenate([[False], end == P, [False]]).astype(int)))
    first, last = held[::2], held[1::2]
    i = int(np.argmax(last - first))
    count = int(last[i] - first[i])
    levels = np.diff(np.unique(P))
    moved = np.abs(z[first[i] : last[i]] - z[first[i]]).max()
    if count < TUNING.saturated or count == P.size or moved < TUNING.moved * np.ptp(z):
        return 0
    near = P[max(first[i] - count, 0) : last[i] + count]
    return count if float(np.ptp(near)) > TUNING.levels * float(levels.min()) else 0


def _approach(curve: Curve) -> Array:
    """Rows of the approach, in order: those the file names so, else those before the largest displacement."""
    if curve.segment is None:
        return np.arange(int(np.argmax(curve.device)) + 1)
    rows = np.flatnonzero(curve.segment == APPROACH)
    if not rows.size:
        raise InputError(f'{curve.where}: has no rows of segment "{APPROACH}" (segments: {", ".join(curve.segments())}'
                         "): zero points cannot be estimated")  # fmt: skip
    return rows


def _end_of_free_part(curve: Curve, z: Array) -> int:
    """How many rows at the beginning of the approach are taken to be free."""
    beyond = z > z.min() + TUNING.free * np.ptp(z)
    end = int(np.argmax(beyond))
    if end < TUNING.fewest:
        raise InputError(
            f"{curve.where}: the first {TUNING.free:.0%} of the approach hold {end} rows, at least {TUNING.fewest} are "
            f"needed to estimate zero points; {GIVE}, or --flip delta if it begins in contact"
        )
    return end


def _refuse_contact(curve: Curve, off: Array, span: float) -> None:
    """Refuse a beginning that is no straight line: its deviations ``off`` [N] are not those from row to row."""
    noise = float(np.median(np.abs(np.diff(off, 2)))) * TUNING.normal / math.sqrt(6)
    scatter = float(np.sqrt(np.mean(off**2)))
    if scatter > max(TUNING.sigmas * noise, TUNING.least_rise * span):
        raise InputError(
            f"{curve.where}: the first {TUNING.free:.0%} of the approach are no straight baseline: loads scatter by "
            f"{show(scatter, 'load')} about it, by {show(noise, 'load')} from row to row; if contact begins there, "
            f"{GIVE}"
        )


def _first_touch(z: Array, P: Array, line: np.polynomial.Polynomial, end: int) -> int | None:
    """The first of ``run`` rows in succession whose load lies off the baseline."""
    off = np.abs(P - line(z))
    noise = TUNING.normal * float(np.median(off[:end]))
    away = off > max(TUNING.sigmas * noise, TUNING.least_rise * float(np.ptp(P)))
    runs = np.convolve(away, np.ones(TUNING.run, dtype=int), "valid") == TUNING.run
    return int(np.argmax(runs)) if runs.any() else None

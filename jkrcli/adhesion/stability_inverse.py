"""The work of adhesion that a measured pull-off force means on a given body."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..base import ROUNDED, SAME, Array, InputError, SolveError, Unknown, show, zeros_between
from .curve import LOAD_CONTROL, AdhesiveCurve, CriticalPoint, position
from .from_rest import FAST, FromRest, LoadingHistory
from .nonadhesive import Nonadhesive

ELASTIC = LoadingHistory(FAST, "elastic")
STEP = math.log(4.0)  # of log w, beyond what the radii of the series give; choice: time alone depends on it


@dataclass(frozen=True, eq=False)
class FoundWork:
    """``w`` [J/m^2] whose pull-off force is the measured ``load`` [N, > 0] on this body.

    ``curve``: the adhesive curve for it, ``point``: its pull-off. ``half_space``: load/(1.5 pi R), what classical JKR
    would have given under load control, None where the indenter has no tip radius.
    """

    load: float
    stiffness: float
    w: float
    curve: AdhesiveCurve | FromRest
    point: CriticalPoint
    half_space: float | None


def work_from_pull_off(
    body: Nonadhesive,
    load: float,
    stiffness: float = LOAD_CONTROL,
    R: float | None = None,
    history: LoadingHistory = ELASTIC,
) -> FoundWork:
    """The w at which contact is lost at P = -``load`` [N] by a device of ``stiffness`` [N/m]; ``R``: tip radius [m],
    ``history``: of a viscoelastic ``body`` (its moduli at t = 0).

    At every radius of the series there is at most one w whose curve is stationary there; the pull-off force grows with
    w, so the ends of the series bound the forces that it can tell. Refused outside them.
    """
    if not (math.isfinite(load) and load > 0):
        raise InputError(f"load: the measured pull-off force must be > 0 N, got {load:g}")

    def point(w: float) -> CriticalPoint | Unknown:
        curve = history.curve(body, w)
        return curve if isinstance(curve, Unknown) else curve.pull_off(stiffness)

    def force(log_w: float) -> float:
        tear_off = point(math.exp(log_w))
        if isinstance(tear_off, Unknown):
            raise SolveError(f"load: the search for w left the series: {tear_off.reason}")
        return -tear_off.P

    def excess(log_w: float) -> float:
        return force(log_w) / load - 1

    def inside(works: Array) -> float:
        """The log of the first of ``works`` whose pull-off lies in the series."""
        for w in works:
            if isinstance(point(float(w)), CriticalPoint):
                return math.log(w)
        raise InputError("load: this series holds no pull-off for any work of adhesion: increase [loading] radius")

    def widened(log_w: float, step: float) -> float:
        """``log_w`` moved step by step: beyond the last stationary radius the pull-off may lie between two points."""
        while excess(log_w) * step < 0 and isinstance(point(math.exp(log_w + step)), CriticalPoint):
            log_w += step
        return log_w

    works = _stationary(history.body(body), stiffness)
    low, high = widened(inside(works), -STEP), widened(inside(works[::-1]), STEP)
    if not excess(low) <= 0 <= excess(high):
        raise InputError(_out_of_reach(load, force(low), force(high)))
    if low < high:
        low = float(zeros_between(np.vectorize(excess, otypes=[float]), np.array([low]), np.array([high]), 1e-14)[0])
    w = math.exp(low)
    tear_off = point(w)
    if isinstance(tear_off, Unknown) or abs(-tear_off.P / load - 1) > ROUNDED:
        raise InputError(
            f"load: no work of adhesion gives a pull-off force of {show(load, 'load')}: where the last stable branch "
            f"changes, at w = {show(w, 'work')}, the force jumps past it"
        )
    curve = history.curve(body, w)
    assert not isinstance(curve, Unknown)  # it has a point
    half_space = None if R is None else load / (1.5 * math.pi * R)
    return FoundWork(load, stiffness, float(w), curve, tear_off, half_space)


def _stationary(body: Nonadhesive, stiffness: float) -> Array:
    """The works of adhesion > 0 whose curves are stationary at radii across the series, increasing."""
    a = body.a.copy()
    a[0], a[-1] = a[0] * (1 + SAME), a[-1] * (1 - SAME)
    here, rates = body.with_rates(a)
    nonadhesive = position(rates.delta_H, rates.P_H, stiffness)
    adhesive = position(rates.t, rates.S * here.t + here.S * rates.t, stiffness)
    root = np.divide(nonadhesive, adhesive, out=np.zeros_like(a), where=adhesive > 0)
    return np.sort(root[root > 0] ** 2)


def _out_of_reach(load: float, least: float, greatest: float) -> str:
    remedy = "increase [loading] radius" if load > greatest else "begin the series at a smaller radius"
    return (
        f"load: a pull-off force of {show(load, 'load')} lies outside the series, which can tell forces from "
        f"{show(least, 'load')} to {show(greatest, 'load')}: {remedy}"
    )

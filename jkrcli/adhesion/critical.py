"""The error of a critical point: that of the curve at its radius, and that of the place where the curve is stationary.

At fixed radius a the curve errs by d(delta), dP. The stationary point of F(a) = d(delta)/da + (dP/da)/k moves by
-dF/F'(a), and takes along what varies there: P under displacement control, delta under load control. F holds the rates
d(delta_H)/da and S'', so that their errors count too (``Slopes.joint``).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ..base import SAME, UNSEEN, Array, InputError, Unknown
from .coarser import error_by_mesh
from .curve import NO_ADHESION, TUNING, AdhesiveCurve, CriticalPoint, Equilibrium, transform
from .device import position
from .slopes import slopes_function

Errors = Mapping[str, float]


def point_error(curve: AdhesiveCurve, point: CriticalPoint, stiffness: float) -> Errors | Unknown:
    """90 % half-widths of "delta" [m] and "P" [N] at the lowest ``point`` under control by a device of ``stiffness``
    [N/m] (0: load, inf: displacement), or why they are unknown."""
    if curve.w == 0:
        return Unknown(f"unknown: {NO_ADHESION}")
    here = curve.interpolation_at(np.array(point.a))
    if isinstance(here, Unknown):
        return here
    if not curve.errors:
        return Unknown(f"unknown: {curve.slopes.error}")
    rest = _beyond_gaps(curve, point, stiffness)
    if isinstance(rest, Unknown):
        return rest
    return {name: float(here[name]) + more for name, more in zip(("delta", "P"), rest.tolist(), strict=True)}


def _beyond_gaps(curve: AdhesiveCurve, point: CriticalPoint, stiffness: float) -> Array | Unknown:
    """The part (2,) of the half-widths that lies not in what is interpolated between the points."""
    by_mesh = error_by_mesh(curve, point, stiffness)
    if by_mesh is not None:
        return by_mesh + _scatter(curve, point, stiffness) if curve.slopes.method == "exact" else by_mesh
    further, at_radius = curve.nonadhesive.further, np.zeros(2)
    nearest = None if further is None else int(np.argmin(np.abs(further.a - point.a)))
    settled = further is None or abs(further.a[nearest] - point.a) <= SAME * (point.a - curve.series.a0)
    joint = further.slopes.joint if further is not None and settled else None
    if joint is not None:  # what was solved for the point counts
        moved = _propagated(curve, point, stiffness, joint[nearest])
    elif curve.slopes.joint is not None:
        joint = curve.nonadhesive.between(curve.slopes.joint, np.array(point.a))
        moved = _propagated(curve, point, stiffness, joint)
    else:
        moved = _by_others(curve, point, stiffness)
        at_radius = np.stack(list(curve.error_at(np.array(point.a)).values()))
    if isinstance(moved, Unknown) or further is None or settled:
        return moved if isinstance(moved, Unknown) else at_radius + moved
    # where the search for a point that is solved has not settled on it, its last steps halve at best
    return at_radius + moved + 2 * _off(curve.point(float(further.a[nearest])), point)


def _off(other: Equilibrium, point: Equilibrium) -> Array:
    """How far delta and P of two states lie apart, (2,)."""
    return np.abs([other.delta - point.delta, other.P - point.P])


def _propagated(curve: AdhesiveCurve, point: CriticalPoint, stiffness: float, covariance: Array) -> Array | Unknown:
    """First-order propagation of the joint ``covariance`` of the columns and of their rates."""
    slopes, a = curve.slopes, np.array(point.a)
    delta, P, delta_rate, P_rate = _gradients(curve, a)
    along = np.clip(a * (1 + np.array([-1e-3, 1e-3])), curve.a[0], curve.a[-1])
    F, controlled = position(delta_rate, P_rate, stiffness), position(*curve.rates(along), stiffness)
    rise = float(controlled[1] - controlled[0])
    if rise == 0:
        return Unknown("unknown: the curve is flat there")
    place = -F * float(along[1] - along[0]) / rise
    rates = [float(rate) for rate in curve.rates(a)]
    total = delta + rates[0] * place, P + rates[1] * place
    return np.array([slopes.quantile * math.sqrt(max(g @ covariance @ g, 0.0)) for g in total])


def _gradients(curve: AdhesiveCurve, a: Array) -> tuple[Array, Array, Array, Array]:
    """Gradients of delta, P, d(delta)/da and dP/da by (delta_H, P_H, S, S', d(delta_H)/da, S''), each (6,)."""
    (_, _, S, dS, t), rates = curve.nonadhesive.with_rates(a)
    t, t_rate = math.sqrt(curve.w) * t, math.sqrt(curve.w) * rates.t
    by_dS = -t / (2 * dS)  # of t; of its rate: the two below
    rate_by_dS = -t / (4 * dS) * (1 / a - 3 * rates.dS / dS)
    rate_by_bend = by_dS
    delta = np.array([1, 0, 0, -by_dS, 0, 0])
    P = np.array([0, 1, -t, -S * by_dS, 0, 0])
    delta_rate = np.array([0, 0, 0, -rate_by_dS, 1, -rate_by_bend])
    P_rate = np.array([0, 0, rates.delta_H - t_rate, -t - dS * by_dS - S * rate_by_dS, S, -S * rate_by_bend])
    return delta, P, delta_rate, P_rate


def _by_others(curve: AdhesiveCurve, point: CriticalPoint, stiffness: float) -> Array | Unknown:
    """How far the point moves where every second row is left out: scatter from row to row moves it as much, a smooth
    rule eight times as much as it errs. The functions are interpolated each for itself, which shows the scatter: what
    belongs to one energy smooths it away, but not what neighbouring rows share. Smoothing splines do not see what rows
    share: their point is also compared with that of the slopes "integral"."""
    slopes = curve.slopes
    smooth = not isinstance(slopes.error, Unknown) and slopes.error <= UNSEEN
    others = [
        (other, 2**TUNING.order if smooth else 1)
        for other in (_pull_off(half, curve, stiffness) for half in _apart(curve).halves)
        if not isinstance(other, Unknown)
    ]
    if slopes.method != "exact":
        by_integral = _by_integral(curve)
        if isinstance(by_integral, Unknown):
            return by_integral
        other = _pull_off(by_integral, curve, stiffness)
        if isinstance(other, Unknown):
            return Unknown("unknown: by the slopes 'integral' the point lies outside the series")
        others.append((other, 1))
    if not others:
        return Unknown("unknown: with every second row left out the point lies outside the series")
    moved: Array = np.max([_off(other, point) / factor for other, factor in others], axis=0)
    return moved + _scatter(curve, point, stiffness) if slopes.method == "exact" and not smooth else moved


def _scatter(curve: AdhesiveCurve, point: CriticalPoint, stiffness: float) -> Array:
    """How far delta and P, (2,), lie off those of the ``point`` where a device may stand as low as there."""
    there = np.stack(curve.at(_as_low(curve, point, stiffness)))
    return np.abs(there - [[point.delta], [point.P]]).max(axis=1)


def _as_low(curve: AdhesiveCurve, point: CriticalPoint, stiffness: float) -> Array:
    """Radii [m] of the neighbouring rows at which the scatter of the rows does not tell whether a device stands lower
    than at the ``point``, and that of the point."""

    def x(other: AdhesiveCurve, a: Array) -> Array:
        return np.asarray(position(*other.at(a), stiffness))

    rows = curve.a[(curve.a > point.a / TUNING.widest) & (curve.a < point.a * TUNING.widest)]
    away, here = np.abs(rows - point.a), float(x(curve, np.array(point.a)))
    scatter = max(np.max(np.abs(x(half, rows) - x(curve, rows))[away <= np.sort(away)[min(4, rows.size - 1)]])
                  for half in _apart(curve).halves)  # fmt: skip
    return np.append(rows[x(curve, rows) < here + 2 * scatter], point.a)


def _pull_off(other: AdhesiveCurve, curve: AdhesiveCurve, stiffness: float) -> CriticalPoint | Unknown:
    """The pull-off of the ``other`` curve; those under all ``devices`` of ``curve`` are computed with it."""
    other.find_critical(curve.devices)
    return other.pull_off(stiffness)


@lru_cache(maxsize=2)
def _apart(curve: AdhesiveCurve) -> AdhesiveCurve:
    """The same curve with its functions interpolated each for itself."""
    return AdhesiveCurve(replace(curve.nonadhesive, together=False), curve.w)


@lru_cache(maxsize=2)
def _by_integral(curve: AdhesiveCurve) -> AdhesiveCurve | Unknown:
    """The same curve by the slopes "integral", or why there is none."""
    try:
        return transform(curve.series, slopes_function("integral")(curve.series), curve.w)
    except InputError as error:
        return Unknown(f"unknown: {error}")

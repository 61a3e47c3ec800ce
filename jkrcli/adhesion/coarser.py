"""The error of a critical point of finite elements: what larger ones change of the curve around it.

Curves are fitted alike and compared at equal nonadhesive displacement: radii of meshes err by more than their loads,
and a wrong radius that nothing is read at does no harm. d(x), x = log(a - a0), is how far the device's position lies
off: it moves the value by d and the place by -d'/x'', x'' being the bend of the position, and along with the place what
varies there. At one place d passes through zero by accident, and so it does all over where two meshes err alike: it is
averaged, squared, around the place, and with what the doubling before it changed, which second order makes the square
of the ratio as large. Elements err in proportion to what they compute, and a load grows severalfold within the radii of
the average: d counts there over the two parts of Eq. 13.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ..base import Array, InputError
from ..series import Series
from .curve import AdhesiveCurve, Equilibrium
from .device import position
from .nonadhesive import Nonadhesive
from .slopes import slopes_function


@dataclass(frozen=True)
class CoarserTuning:
    """Where curves are compared, and what is concluded."""

    # of what doubling changes, over (ratio - 1), at the end of the series; tuned on random bodies, by `make bounds`
    left: float = 2.2
    # Powers of a - a0 over that at the end, with which it falls towards first contact, where larger elements have few
    # nodes: of values, and of places
    powers: tuple[float, float] = (0.6, 0.3)  # tuned on random bodies, by `make bounds`
    # of log(a - a0) on either side, over which values are averaged
    values: float = 0.35  # tuned on random bodies, by `make bounds`
    rates: float = 0.2  # and their rates; tuned on random bodies, by `make bounds`
    bend: float = 0.15  # and over which the bend is that of a parabola; tuned on random bodies, by `make bounds`
    spacing: float = 0.01  # theory: of log(a - a0), far below what meshes resolve
    points: int = 1000  # theory: of the whole series, as close


TUNING = CoarserTuning()


def error_by_mesh(curve: AdhesiveCurve, point: Equilibrium, stiffness: float) -> Array | None:
    """90 % half-widths (2,) of delta [m] and P [N] at a critical ``point`` under a device of ``stiffness`` [N/m]; None
    where no larger elements tell them."""
    coarser, series = curve.series.coarser, curve.series
    others = () if coarser is None else _fitted_alike(curve.nonadhesive)
    if coarser is None or not others:
        return None
    steps = np.arange(-TUNING.values, TUNING.values + TUNING.spacing / 2, TUNING.spacing)
    a = series.a0 + (point.a - series.a0) * np.exp(steps)
    inside = (a >= max(curve.a[0], others[0].a[0])) & (a <= curve.a[-1])
    a, x = a[inside], steps[inside]
    near, around = np.abs(x) <= TUNING.bend, np.abs(x) <= TUNING.rates
    if np.count_nonzero(near) * TUNING.spacing < TUNING.bend:
        return None
    values, changes = np.stack(curve.at(a)), _changes(curve, others, a, coarser.ratio)
    bend = 2 * np.polyfit(x[near], position(values[0], values[1], stiffness)[near], 2)[0]
    along = np.polyfit(x[near], values[:, near].T, 2)[1]
    rates = np.gradient(np.asarray(position(changes[0], changes[1], stiffness)), x, axis=-1)
    moved = _mean(rates[:, around]) / abs(bend)
    of_value, of_place = ((point.a - series.a0) / (series.a[-1] - series.a0)) ** np.array(TUNING.powers)
    relative = np.array([_mean(change) for change in changes / _sizes(curve, a)[:, None]])
    wrong = np.hypot(of_value * relative * _sizes(curve, np.array(point.a)), of_place * along * moved)
    of_mesh = TUNING.left / (coarser.ratio - 1) * wrong
    shift, slope = _by_profile(curve, point.a)
    return np.sqrt(of_mesh**2 + shift**2 + (along * float(position(slope[0], slope[1], stiffness)) / bend) ** 2)


def _by_profile(curve: AdhesiveCurve, a: float) -> tuple[Array, Array]:
    """Errors of delta [m] and P [N] at the radius ``a`` [m], and of their slopes over log(a - a0), by a profile that is
    known at points only."""
    series = curve.series
    if series.unresolved is None:
        return np.zeros(2), np.zeros(2)
    shift, slope = (np.interp(a, series.a, values) for values in series.unresolved)
    unit = np.array([1.0, float(curve.nonadhesive.parts(np.array(a)).S)])
    return shift * unit, (a - series.a0) * slope * unit


def _sizes(curve: AdhesiveCurve, a: Array) -> Array:
    """What delta [m] and P [N] are differences of, (2, ...) at the radii ``a`` [m]: without adhesion, and by it."""
    here, root_w = curve.nonadhesive.parts(a), np.sqrt(curve.w)
    pulled = root_w * here.t
    return np.stack([here.delta_H + pulled, here.P_H + here.S * pulled])


def _mean(values: Array) -> float:
    """The root of the mean square of what is known."""
    return float(np.sqrt(np.nanmean(values**2)))


def _changes(curve: AdhesiveCurve, others: Sequence[Nonadhesive], a: Array, ratio: float) -> Array:
    """What each step to elements ``ratio`` times as large changes of delta [m] and P [N] at the radii ``a`` [m],
    (2, steps, n), over what second order makes it larger than the first; NaN below the first radius of the larger."""
    off = np.full((len(others) + 1, 2, a.size), np.nan)
    off[0] = 0.0
    for level, other in enumerate(others, start=1):
        reached = a >= other.a[0]
        off[level][:, reached] = _off(curve, other, a[reached])
    second_order = ratio ** (2.0 * np.arange(len(others)))
    return np.moveaxis(np.diff(off, axis=0) / second_order[:, None, None], 0, 1)


def _off(curve: AdhesiveCurve, other: Nonadhesive, a: Array) -> Array:
    """How far delta [m] and P [N], (2, n), of the ``other`` functions' curve lie off that of ``curve`` at its radii
    ``a`` [m], at equal nonadhesive displacement."""
    body, root_w, a0 = curve.nonadhesive, np.sqrt(curve.w), other.series.a0
    here = body.parts(a)
    first, last = other.a[[0, -1]]
    radii = np.clip(a0 + np.geomspace(first - a0, last - a0, TUNING.points), first, last)
    there = other.parts(np.interp(here.delta_H, other.parts(radii).delta_H, radii))
    P_H = there.P_H + there.S * (here.delta_H - there.delta_H)  # what the table leaves of equal displacement
    pulled = there.S * there.t - here.S * here.t
    return np.stack([-root_w * (there.t - here.t), P_H - here.P_H - root_w * pulled])


@lru_cache(maxsize=2)
def _fitted_alike(body: Nonadhesive) -> tuple[Nonadhesive, ...]:
    """The functions by larger and larger elements, with slopes by the same rule: their columns err by as much more as
    second order says; as far as the rule finds them."""
    fits, more, coarser = [], 1.0, body.series.coarser
    while coarser is not None:
        more *= coarser.ratio**2
        try:
            fits.append(_fitted(coarser.series, body, more))
        except InputError:
            break
        coarser = coarser.series.coarser
    return tuple(fits)


def _fitted(coarse: Series, body: Nonadhesive, more: float) -> Nonadhesive:
    """The functions of the ``coarse`` series, which errs ``more`` times as much as that of the ``body``, by its rule;
    InputError where this finds none."""
    series, rule = body.series, body.slopes.method
    errors = {
        name: more * getattr(coarse, name) * np.interp(coarse.a, series.a, series.errors[name] / getattr(series, name))
        for name in ("a", "P")
    }
    S, dS = (coarse.S, coarse.dS) if rule == "exact" else (None, None)
    coarse = replace(coarse, S=S, dS=dS, S0=series.S0, errors=errors, kinks=series.kinks, bends=series.bends)
    return Nonadhesive(coarse, slopes_function(rule)(coarse))

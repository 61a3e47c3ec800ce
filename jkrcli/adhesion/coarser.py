"""The error of a critical point of finite elements: what larger ones change of the curve around it.

Both curves are fitted alike and compared at equal nonadhesive displacement: radii of meshes err by more than their
loads, and a wrong radius that nothing is read at does no harm. d(x), x = log(a - a0), is how far what the device holds
lies off: it moves the value by d and the place by -d'/x'', x'' being the bend of what is held, and along with the place
what varies there. At one place d passes through zero by accident; it is averaged, squared, around it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ..base import Array, InputError
from .curve import AdhesiveCurve, Equilibrium
from .device import position
from .nonadhesive import Nonadhesive
from .slopes import slopes_function


@dataclass(frozen=True)
class CoarserTuning:
    """Where curves are compared, and what is concluded."""

    left: float = 1.1  # of what doubling changes; tuned on random bodies, by `make bounds`
    # of log(a - a0) on either side, over which values are averaged
    values: float = 0.5  # tuned on random bodies, by `make bounds`
    rates: float = 0.35  # and their rates; tuned on random bodies, by `make bounds`
    bend: float = 0.15  # and over which the bend is that of a parabola; tuned on random bodies, by `make bounds`
    spacing: float = 0.01  # theory: of log(a - a0), far below what meshes resolve
    points: int = 1000  # theory: of the whole series, as close


TUNING = CoarserTuning()


def error_by_mesh(curve: AdhesiveCurve, point: Equilibrium, stiffness: float) -> Mapping[str, float] | None:
    """90 % half-widths of "delta" [m] and "P" [N] at a critical ``point`` under a device of ``stiffness`` [N/m]; None
    where no larger elements tell them."""
    coarser, series = curve.series.coarser, curve.series
    other = None if coarser is None else _fitted_alike(curve.nonadhesive)
    if coarser is None or other is None:
        return None
    steps = np.arange(-TUNING.values, TUNING.values + TUNING.spacing / 2, TUNING.spacing)
    a = series.a0 + (point.a - series.a0) * np.exp(steps)
    inside = (a >= max(curve.a[0], other.a[0])) & (a <= curve.a[-1])
    a, x = a[inside], steps[inside]
    near, around = np.abs(x) <= TUNING.bend, np.abs(x) <= TUNING.rates
    if np.count_nonzero(near) * TUNING.spacing < TUNING.bend:
        return None
    values, off = np.stack(curve.at(a)), _off(curve, other, a)
    bend = 2 * np.polyfit(x[near], position(values[0], values[1], stiffness)[near], 2)[0]
    along = np.polyfit(x[near], values[:, near].T, 2)[1]
    moved = _mean(np.gradient(position(off[0], off[1], stiffness), x)[around]) / abs(bend)
    errors = TUNING.left / (coarser.ratio - 1) * np.hypot(_mean(off), along * moved)
    return dict(zip(("delta", "P"), errors.tolist(), strict=True))


def _mean(values: Array) -> Array:
    """The root of the mean square."""
    mean: Array = np.sqrt(np.mean(values**2, axis=-1))
    return mean


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
def _fitted_alike(body: Nonadhesive) -> Nonadhesive | None:
    """The functions by larger elements, with slopes by the same rule: their columns err by as much more as second
    order says; None where the rule finds none."""
    series, rule = body.series, body.slopes.method
    assert series.coarser is not None
    coarse, more = series.coarser.series, series.coarser.ratio**2
    errors = {
        name: more * getattr(coarse, name) * np.interp(coarse.a, series.a, series.errors[name] / getattr(series, name))
        for name in ("a", "P")
    }
    S, dS = (coarse.S, coarse.dS) if rule == "exact" else (None, None)
    coarse = replace(coarse, S=S, dS=dS, S0=series.S0, errors=errors, kinks=series.kinks, bends=series.bends)
    try:
        return Nonadhesive(coarse, slopes_function(rule)(coarse))
    except InputError:
        return None

"""Sensitivity of a cantilever's deflection from force curves on a rigid specimen.

On a rigid specimen the tip stands still in contact: the cantilever bends by what the piezo moves, s dV/dz = 1. The
slope of the readings over the position of the piezo is the inverse of the sensitivity s; where the readings are loads
or lengths already, it tells by which factor the sensitivity behind them is off.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..base.errors import InputError, counted
from ..base.numerics import Array
from ..base.units import show
from .batch import CONSTANT
from .curve import ARBITRARY
from .segmentation import ForceCurve

CONTACT = (0.2, 0.95)  # choice: of the largest load, between which the contact is taken to be straight
LEAST_ROWS = 8  # choice: rows of a direction for its slope
BENT = 0.03  # choice: relative difference of the slopes of halves of a contact, of directions: no rigid specimen


@dataclass(frozen=True)
class Sensitivity:
    """The ``factor`` by which the sensitivity in the loads is to be multiplied, with its standard ``error``, half of
    the difference between directions included; ``value`` [m/V], None where the readings were no volts; ``straight``:
    whether the contact has one slope, as on a rigid specimen."""

    factor: float
    error: float
    value: float | None
    straight: bool

    def words(self) -> str:
        """What to type."""
        doubt = "" if self.straight else "; the contact is curved: the specimen is not rigid, or slides"
        relative = f"{100 * self.error / self.factor:.2g}%"
        if self.value is None:
            return f"rigid specimen: loads times {self.factor:.4g} ± {relative} (--factor P={self.factor:.4g}){doubt}"
        number = show(self.value, "length", 4)
        return f'rigid specimen: --sensitivity "{number}/V" --uncertain sensitivity={relative}{doubt}'


def sensitivity_of(record: ForceCurve) -> Sensitivity:
    """The sensitivity from a force curve on a rigid specimen; InputError where it holds no contact."""
    curve, slopes, halves = record.curve, list[tuple[float, float]](), list[float]()
    known = {name: float(value) for flag in curve.flags for name, value in CONSTANT.findall(flag)}
    k = known.get("stiffness", curve.stiffness)
    k = 1.0 if k is None or not math.isfinite(k) else k
    for item in record.directions:
        z, P = (values[item.segment.rows] for values in (curve.device, curve.load))
        bent = (P - item.base(z)) / k  # with a sensitivity of s_0, or of 1 m/V
        inside = (bent > CONTACT[0] * bent.max()) & (bent < CONTACT[1] * bent.max())
        if item.based and np.count_nonzero(inside) >= LEAST_ROWS:
            slopes.append(_slope(bent[inside], z[inside]))
            middle = float(np.median(bent[inside]))
            parts = [_slope(bent[inside & half], z[inside & half])[0] for half in (bent < middle, bent >= middle)]
            halves.append(abs(parts[1] / parts[0] - 1))
    if not slopes:
        raise InputError(
            f"{curve.where}: no contact from which the sensitivity follows: it needs a base line and a load"
        )
    values = [value for value, _ in slopes]
    halves.append(max(values) / min(values) - 1)
    error = math.hypot(max(size for _, size in slopes), (max(values) - min(values)) / 2)
    of_volts = "sensitivity" in known or any(ARBITRARY in flag and "--sensitivity" in flag for flag in curve.flags)
    factor = float(np.mean(values))
    return Sensitivity(factor, error, factor * known.get("sensitivity", 1.0) if of_volts else None, max(halves) < BENT)


def _slope(x: Array, z: Array) -> tuple[float, float]:
    """dz/dx by least squares of x over z, whose errors are those of x, and its standard error."""
    dz = z - z.mean()
    slope = float(dz @ x / (dz @ dz))
    left = x - x.mean() - slope * dz
    error = math.sqrt(float(left @ left) / (x.size - 2) / float(dz @ dz))
    return 1 / slope, error / slope**2


def mean(found: Sequence[Sensitivity]) -> Sensitivity:
    """The mean over several force curves, of sensitivities or else of factors; its error is their scatter where that is
    larger than each one's own. InputError where some hold volts and others none."""
    factors, values = [one.factor for one in found], [one.value for one in found if one.value is not None]
    if 0 < len(values) < len(found):
        of = f"{len(values)} of {counted(len(found), 'force curve')}"
        raise InputError(f"rigid specimen: {of} hold volts, the others loads or lengths: look at each kind by itself")
    told = np.array(values or factors)
    scatter = float(told.std(ddof=1) / told.mean()) if told.size > 1 else 0.0
    factor, error = float(np.mean(factors)), max(scatter, *(one.error / one.factor for one in found))
    value = float(told.mean()) if values else None
    return Sensitivity(factor, error * factor, value, all(one.straight for one in found))

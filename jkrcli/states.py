"""States on an adhesive curve: the contact radii at which it carries a load, takes a displacement or meets a device."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from scipy.optimize import brentq

from .adhesion import AdhesiveCurve
from .errors import InputError
from .series import Array
from .units import show

SAMPLES = 16  # per interval of the series
LOAD_CONTROL, DISPLACEMENT_CONTROL = 0.0, math.inf  # as stiffness of the device [N/m]


@dataclass(frozen=True)
class State:
    """One equilibrium: contact radius ``a`` [m], displacement ``delta`` [m], load ``P`` [N]."""

    a: float
    delta: float
    P: float


def state(curve: AdhesiveCurve, a: float) -> State:
    """The equilibrium at contact radius ``a`` [m] within the series."""
    delta, P = curve.at(np.array(a))
    return State(a, float(delta), float(P))


def position(delta: Any, P: Any, stiffness: float) -> Any:
    """What a device of ``stiffness`` [N/m] prescribes: delta + P/stiffness [m]; the load itself [N] at stiffness 0."""
    return P if stiffness == LOAD_CONTROL else delta + P / stiffness


def radii_at_position(curve: AdhesiveCurve, stiffness: float, value: float) -> list[float]:
    """All contact radii [m] in the series at which the device's ``position`` has the ``value``, increasing."""

    def mismatch(a: Array) -> Array:
        return position(*curve.at(a), stiffness) - value

    steps = np.linspace(0, 1, SAMPLES, endpoint=False)
    a = np.append((curve.a[:-1, None] + np.diff(curve.a)[:, None] * steps).ravel(), curve.a[-1])
    return _roots(mismatch, a)


def radii_at(curve: AdhesiveCurve, quantity: Literal["load", "displacement"], value: float) -> list[float]:
    """All contact radii [m] in the series at which P [N] or delta [m] has the ``value``, increasing; maybe none."""
    return radii_at_position(curve, LOAD_CONTROL if quantity == "load" else DISPLACEMENT_CONTROL, value)


def stable_radius(curve: AdhesiveCurve, load: float) -> float:
    """The largest contact radius [m] at which ``load`` [N] is carried stably under load control (dP/da > 0)."""
    stable = [a for a in radii_at(curve, "load", load) if curve.rates(np.array(a))[1] > 0]
    if not stable:
        P = curve.at(curve.a)[1]
        raise InputError(
            f"load: {show(load, 'load')} is not carried by a stable contact of this series, whose loads go from "
            f"{show(float(P.min()), 'load')} to {show(float(P.max()), 'load')}"
        )
    return stable[-1]


def _roots(function: Callable[[Array], Array], x: Array) -> list[float]:
    values = function(x)
    roots = [float(x[i]) for i in np.flatnonzero(values == 0)]
    for i in np.flatnonzero(values[:-1] * values[1:] < 0):
        root = brentq(lambda t: float(function(np.array(t))), x[i], x[i + 1], xtol=1e-15 * x[i], rtol=1e-14)
        roots.append(float(root))
    return sorted(roots)

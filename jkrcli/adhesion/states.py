"""States on an adhesive curve: the contact radii at which it carries a load, takes a displacement or meets a device."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.errors import InputError
from ..base.units import show
from .curve import AdhesiveCurve

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

    return [a for a, _ in curve.zeros(lambda a: position(*curve.at(a), stiffness) - value)]


def stable_radius(curve: AdhesiveCurve, load: float) -> float:
    """The largest contact radius [m] at which ``load`` [N] is carried stably under load control (dP/da > 0)."""
    stable = [a for a in curve.radii(P=load) if curve.rates(np.array(a))[1] > 0]
    if not stable:
        P = curve.at(curve.a)[1]
        raise InputError(
            f"load: {show(load, 'load')} is not carried by a stable contact of this series, whose loads go from "
            f"{show(float(P.min()), 'load')} to {show(float(P.max()), 'load')}"
        )
    return stable[-1]

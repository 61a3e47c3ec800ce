"""States on an adhesive curve: the contact radii at which it carries a load or takes a displacement."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
from scipy.optimize import brentq

from .adhesion import AdhesiveCurve
from .errors import InputError
from .series import Array
from .units import show

SAMPLES = 16  # per interval of the series


def radii_at(curve: AdhesiveCurve, quantity: Literal["load", "displacement"], value: float) -> list[float]:
    """All contact radii [m] in the series at which P [N] or delta [m] has the ``value``, increasing; maybe none."""
    column = 1 if quantity == "load" else 0

    def mismatch(a: Array) -> Array:
        return curve.at(a)[column] - value

    steps = np.linspace(0, 1, SAMPLES, endpoint=False)
    a = np.append((curve.a[:-1, None] + np.diff(curve.a)[:, None] * steps).ravel(), curve.a[-1])
    return _roots(mismatch, a)


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

"""Displacements that were computed as z - P/k from the position z of a device: they hold the noise of the load.

In contact delta and P then err together, and beside the free rows, whose noise is that of P alone, delta looks noisy.
The position delta + P/k is smooth, and k follows from the noise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ...base import Array, show
from .curve import AS_DEPTH, NOT_SUBTRACTED, Curve


@dataclass(frozen=True)
class TipPositionTuning:
    """When the noise of a displacement is that of the load."""

    # theory: rows; third differences are correlated, and leave so many as 100/2.3 apart: by chance the noise of two
    # columns has the ``share`` at 4.7 standard deviations
    fewest: int = 100
    share: float = 0.5  # theory: of the variance of delta: more of it follows P than does not
    usual: float = 4.0  # theory: medians, 2.7 standard deviations of normal noise: beyond is a jump or a turn


TUNING = TipPositionTuning()
SUBTRACTED_TWICE = "the displacement has its deflection subtracted already: leave --stiffness out"


def of_its_device(curve: Curve) -> Curve:
    """The curve with the stiffness of its device where the noise of its displacement shows one."""
    if curve.delta is None or curve.P is None or curve.a is not None:
        return curve
    k = stiffness_of_noise(curve.delta, curve.P)
    if k is None:
        return curve
    flags = tuple(flag for flag in curve.flags if flag not in (NOT_SUBTRACTED, AS_DEPTH))
    flag = f"the displacement is that of the tip, with the noise of the load: the device has {show(k, 'stiffness')}"
    return replace(curve, stiffness=k, flags=(*flags, flag))


def stiffness_of_noise(delta: Array, P: Array) -> float | None:
    """Stiffness k [N/m] for which the noise of ``delta`` [m] is that of -P/k, by the third differences of rows in
    their order; None where less than half of it is, or where differences are those of a smooth curve."""
    if delta.size < TUNING.fewest:
        return None
    x, y = np.diff(delta, 3), np.diff(P, 3)
    usual = np.all([np.abs(column) <= TUNING.usual * np.median(np.abs(column)) for column in (x, y)], axis=0)
    x, y = x * usual, y * usual
    xx, yy, xy = float(x @ x), float(y @ y), float(x @ y)
    smooth = float(y[1:] @ y[:-1]) > 0  # neighbours correlate by 1 on a smooth curve, by -0.75 in white noise
    if xy >= 0 or xy**2 <= TUNING.share * xx * yy or smooth:
        return None
    return -yy / xy if math.isfinite(yy / xy) else None

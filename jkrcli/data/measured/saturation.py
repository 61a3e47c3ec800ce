"""A detector at its limit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...base import NOTICEABLE, Array, show
from .curve import Curve


@dataclass(frozen=True)
class SaturationTuning:
    """What no load of a contact does."""

    saturated: int = 5  # choice: rows in succession at the very same largest load that count
    levels: float = 10.0  # choice: of a converter, by which the load must have come there within as many rows


TUNING = SaturationTuning()


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
    edges = np.flatnonzero(np.diff(np.concatenate([[False], end == P, [False]]).astype(int)))
    first, last = edges[::2], edges[1::2]
    i = int(np.argmax(last - first))
    count = int(last[i] - first[i])
    levels = np.diff(np.unique(P))
    moved = np.abs(z[first[i] : last[i]] - z[first[i]]).max()
    if count < TUNING.saturated or count == P.size or moved < NOTICEABLE * np.ptp(z):
        return 0
    near = P[max(first[i] - count, 0) : last[i] + count]
    return count if float(np.ptp(near)) > TUNING.levels * float(levels.min()) else 0

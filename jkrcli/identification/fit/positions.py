"""Errors of the positions of a device, each as one unknown of a raw record; all are 0 where the device turns.

``drift`` is a steady motion of the zero [m/s]. ``hysteresis`` and ``creep`` are those of a piezo without a sensor, on
the way back: it stands deeper than its positions say, by a parabola that is 0 at both ends of the travel, or by the
logarithm of the time since the turn (Devasia, Eleftheriou and Moheimani, IEEE Trans. Control Syst. Technol. 15, 802,
2007). Their amounts are fractions of the travel: the largest separation of the ways, and the creep per decade of time
from a hundredth of the record on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...base import Array


@dataclass(frozen=True)
class PositionTuning:
    """How creep begins."""

    onset: float = 0.01  # choice: of the time of a record, from which on it goes by decades


TUNING = PositionTuning()
TIMED = ("drift", "creep")  # that need a column of time


def hysteresis(way: Array) -> Array:
    """The share of the largest separation at shares ``way`` of the travel from the turn on."""
    return 4 * way * (1 - way)


def creep(time: Array) -> Array:
    """Decades of the ``time`` since the turn, over that of the record."""
    return np.log10(1 + time / TUNING.onset)

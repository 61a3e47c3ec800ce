"""The device that presses: its stiffness decides what it prescribes, a load, a displacement or its own position."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..base import Array, InputError, show

LOAD_CONTROL, DISPLACEMENT_CONTROL = 0.0, math.inf  # as stiffness of the device [N/m]
CONTROLS = {"load": LOAD_CONTROL, "displacement": DISPLACEMENT_CONTROL}


def position(delta: Any, P: Any, stiffness: float) -> Any:
    """The position delta + P/stiffness [m] that a device of ``stiffness`` [N/m] prescribes; the load [N] at 0."""
    if math.isnan(stiffness) or stiffness < 0:
        raise InputError(f"stiffness: must be >= 0 N/m (0: load control, infinite: displacement), got {stiffness:g}")
    return P if stiffness == LOAD_CONTROL else delta + P / stiffness


def positions(delta: Array, P: Array, stiffness: Array) -> Array:
    """The ``position`` of each of several devices."""
    loaded = stiffness == LOAD_CONTROL
    return np.where(loaded, 0.0, delta) + P / np.where(loaded, 1.0, stiffness)


def controlled(stiffness: float) -> str:
    """The quantity that a device prescribes: ``load``, ``displacement`` or ``device position``."""
    return {value: name for name, value in CONTROLS.items()}.get(stiffness, "device position")


def control(stiffness: float) -> str:
    """The control in words: ``load control``, ``displacement control`` or ``device of 0.2 N/m``."""
    name = controlled(stiffness)
    return f"{name} control" if name in CONTROLS else f"device of {show(stiffness, 'stiffness')}"

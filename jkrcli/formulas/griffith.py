"""Griffith's balance at the contact edge: energy release rate = work of adhesion."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..base import Array


def shift(w: float, a: Array | float, dS: Array | float) -> Any:
    """The shift t = sqrt(4 pi w a/S') [m]: how far adhesion moves the indenter back at contact radius ``a`` [m].

    The contact moves back as a flat punch does, with the slope S [N/m]; its energy release rate S' t^2/(4 pi a) is then
    the work of adhesion ``w`` [J/m^2] (Eq. 13). ``dS``: S' = dS/da > 0 [N/m^2].
    """
    return np.sqrt(4 * math.pi * w * a / dS)

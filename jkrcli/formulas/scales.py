"""Units of load, displacement and contact radius that make an adhesive curve dimensionless."""

from __future__ import annotations

import math


def scales_half_space(R: float, E_star: float, w: float) -> tuple[float, float, float]:
    """Units of P [N], delta [m] and a [m] for a half-space (Eq. 15 corrected)."""
    P = math.pi * w * R
    delta = (9 * math.pi**2 * w**2 * R / (16 * E_star**2)) ** (1 / 3)
    a = (3 * math.pi * w * R**2 / (4 * E_star)) ** (1 / 3)
    return P, delta, a


def scales_thin_layer(R: float, K: float, w: float) -> tuple[float, float, float]:
    """Units of P [N], delta [m] and a [m] for a thin layer of Winkler stiffness K [Pa/m] (Eq. 19 corrected)."""
    return 2 * math.pi * w * R, math.sqrt(2 * w / K), (8 * w * R**2 / K) ** 0.25

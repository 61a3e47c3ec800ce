"""Thin-layer formulae: leading order for a contact radius much larger than the thickness of a layer on a rigid base.

A compressible layer is a bed of springs (Winkler) of stiffness K [Pa/m]; its contact does not know Poisson's ratio but
through K. A nearly incompressible layer is neither: K of Eq. 22 diverges and Eq. 20 is wrong there. Plain functions of
SI values; ``jkrcli.methods.closed_form`` checks each use against the exact layer.
"""

from __future__ import annotations

import numpy as np

from ..base import Array


def foundation_modulus(E: float, nu: float, h: float) -> float:
    """Foundation modulus K [Pa/m] of a compressible bonded layer (Eq. 22)."""
    return E * (1 - nu) / (h * (1 + nu) * (1 - 2 * nu))


def thin_layer(a: Array, K: float, R: float) -> tuple[Array, Array]:
    """Thin-layer formula, compressible (Eq. 20): delta_H = a^2/(2R) [m], P_H = pi K a^4/(4R) [N]."""
    return a**2 / (2 * R), np.pi * K * a**4 / (4 * R)


def thin_layer_slopes(a: Array, K: float) -> tuple[Array, Array]:
    """S = pi K a^2 [N/m] and S' [N/m^2] of a compressible layer."""
    return np.pi * K * a**2, 2 * np.pi * K * a


def thin_layer_dimensionless(a_bar: Array) -> tuple[Array, Array]:
    """Thin compressible layer with adhesion in the units of Eq. 19 (Eq. 21): delta_bar and P_bar."""
    return a_bar**2 - 1, a_bar**4 - 2 * a_bar**2


def thin_incompressible_layer(a: Array, G: float, h: float, R: float) -> tuple[Array, Array]:
    """Thin-layer limit at nu = 1/2: delta_H = a^2/(4R) [m], P_H = pi G a^6/(32 R h^3) [N]."""
    return a**2 / (4 * R), np.pi * G * a**6 / (32 * R * h**3)


def thin_incompressible_slopes(a: Array, G: float, h: float) -> tuple[Array, Array]:
    """S = 3 pi G a^4/(8 h^3) [N/m] and S' [N/m^2] of a layer at nu = 1/2."""
    S = 3 * np.pi * G * a**4 / (8 * h**3)
    return S, 4 * S / a

"""Elastic half-space whose surface has the constant tension Ups [N/m]: kappa = 2 Ups/E* [m].

Hui, Liu, Salez, Raphael, Jagota, Proc. R. Soc. A 471 (2015) 20140727. Plain functions of SI values.
"""

from __future__ import annotations

import math

import numpy as np

from ..base import Array


def displacement(z: Array) -> Array:
    """A(z) = int_0^inf cos(z t)/(1 + t) dt, z > 0 [-]: like -ln(z) near 0, 1/z^2 far away (Abramowitz and Stegun
    5.2.13)."""
    from scipy.special import sici

    sine, cosine = sici(z)
    return -cosine * np.cos(z) - (sine - math.pi / 2) * np.sin(z)


def logarithm(a: Array, kappa: float) -> Array:
    """The factor l = ln(2 a/kappa) + 0.5772... of a slight tension, kappa << a [-]."""
    return np.log(2 * a / kappa) + np.euler_gamma


def stiffness(a: Array, E_star: float, kappa: float) -> tuple[Array, Array]:
    """S [N/m] and S' [N/m^2] of the contact radius ``a`` [m] under a slight tension, kappa << a, to the relative
    (kappa l/a)^2."""
    dS = 2 * E_star * (1 + kappa / (math.pi * a))
    return 2 * E_star * (a + kappa / math.pi * (logarithm(a, kappa) + 1)), dS


def wetting_radius(R: float, w: float, tension: float) -> float:
    """Contact radius [m] at pull-off of a paraboloid from a body that tension alone holds together, kappa >> a; the
    load is -pi w R there."""
    return R * math.sqrt(w / (2 * tension))


def edge_angle(w: float, tension: float) -> float:
    """Angle theta = sqrt(2 w/Ups) [rad] between the surfaces at the adhesive edge (G = Ups theta^2/2 = w, small
    slopes of Young and Dupre's law)."""
    return math.sqrt(2 * w / tension)

"""Incompressible elastic half-space under its own weight, touched by a paraboloid.

What is pushed up weighs rho g u_z and what is pushed down is buoyant, so that in Hankel space the pressure is
(E* k/2 + rho g) u_z at nu = 1/2; before contact the weight is a hydrostatic pressure and changes nothing else. To first
order in e = 2 eps a/pi, eps = 2 rho g/E* [1/m], with l = -ln(2 eps a) - 0.5772...:

    S = 2 E* a [1 + e (3/2 + l)],  S' = 2 E* [1 + 2 e (1 + l)],  P_H = 4 E* a^3/(3 R) [1 + 3 e/4]   at equal radius,
    P_H = Hertz's P(delta) [1 + e (19/12 + l)]                                                     at equal depth.

Derived for this program; the tests hold it to the integral equation with that kernel. Plain functions of SI values.
"""

from __future__ import annotations

import math

import numpy as np

g = 9.80665  # theory: standard acceleration of gravity [m/s^2], by definition


def over_hertz(a: float, E_star: float, density: float) -> tuple[float, float]:
    """Change of the load and of S = dP/d(delta) at the depth a^2/R by a ``density`` [kg/m^3], relative, good to their
    squares; ``a`` [m]: Hertz's contact radius."""
    x = 4 * density * g * a / E_star
    e = x / math.pi
    load = e * (19 / 12 - math.log(x) - np.euler_gamma)
    return load, 4 / 3 * load - e / 3


def over_jkr(a: float, E_star: float, density: float) -> float:
    """Change of the pull-off force under load control at JKR's radius ``a`` [m] of pull-off, relative: e/4, since
    S sqrt(4 pi w a/S') grows by e/2."""
    return density * g * a / (math.pi * E_star)

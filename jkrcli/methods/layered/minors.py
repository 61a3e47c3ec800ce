"""Compliance of what lies below a depth, as minors, and their way up through a homogeneous layer.

The material below a depth is described by its compliance matrix F: displacements (u_r, u_z) = F (T_r, T_z)/(G k), with
T the tractions on it. Upwards through a layer, zeta = k z, F obeys a Riccati equation; its five minors

    m = m_0 (1, F_rr, F_zz, F_rz, det F)

obey a linear one, dm/dzeta = B m (the delta-matrix method, Dunkin 1965). B has the eigenvalues 0 (triple), 2 and -2, so

    exp(B y) = I + B y + B^2 y^2/2 + B^3 (sinh 2y - 2y)/8 + B^4 (cosh 2y - 1 - 2 y^2)/16,        y = k h,

which is used with the factor exp(-2 y) throughout: nothing overflows, nothing cancels at small y, and nu = 1/2 is an
ordinary value. A rigid base that allows sliding has infinite F_rr, but ordinary minors.
"""

from __future__ import annotations

import math

import numpy as np

from ...bodies.materials import Elastic, TransverselyIsotropic
from ...bodies.problem import HalfSpace, Rigid
from .transverse import Medium

Array = np.ndarray

SMALL = 1.0  # below this y the functions of y are summed as power series
_ODD = 1 / np.array([float(math.factorial(n)) for n in range(3, 28, 2)])
_EVEN = 1 / np.array([float(math.factorial(n)) for n in range(4, 29, 2)])


def base(base: Rigid | HalfSpace, size: int) -> tuple[Array, float]:
    """Minors of the base, and the shear modulus [Pa] in whose units they are (any, for a rigid base)."""
    match base:
        case HalfSpace(material=Elastic(nu=nu, G=G)):
            minors = [1.0, 1 - nu, 1 - nu, nu - 0.5, (3 - 4 * nu) / 4]
        case HalfSpace(material=TransverselyIsotropic(G_z=G) as material):
            minors = Medium.of(material).half_space
        case Rigid(bonded=bonded):
            minors, G = [1.0, 0, 0, 0, 0] if bonded else [0.0, 1, 0, 0, 0], 1.0
    return np.repeat(np.array(minors)[:, None], size, axis=1), G


def rescaled(m: Array, ratio: Array | float) -> Array:
    """The minors when F is counted in units of a modulus ``ratio`` times larger; largest entry 1."""
    m = m * np.array([np.ones_like(ratio), ratio, ratio, ratio, ratio**2]).reshape(5, -1)
    return m / np.max(np.abs(m), axis=0)


def through(m: Array, y: Array, nu: float) -> Array:
    """exp(B y) m exp(-2 y): the minors (5, n) one layer of y = k h further up."""
    b1, b2, b3, b4 = powers(m, nu)
    once = np.exp(-2 * y)
    return once * m + (once * y) * b1 + (once * y**2 / 2) * b2 + (_odd(y) / 8) * b3 + (_even(y) / 16) * b4


def powers(m: Array, nu: float) -> tuple[Array, Array, Array, Array]:
    """B m, B^2 m, B^3 m, B^4 m."""
    b1 = _generator(m, nu)
    b2 = _generator(b1, nu)
    b3 = _generator(b2, nu)
    return b1, b2, b3, _generator(b3, nu)


def _generator(m: Array, nu: float) -> Array:
    """B m for one isotropic material: c = lambda/(lambda + 2 G), beta = G/(lambda + 2 G), e = 4 (lambda + G) beta/G."""
    c, beta, e = nu / (1 - nu), (1 - 2 * nu) / (2 * (1 - nu)), 2 / (1 - nu)
    out = np.empty_like(m)
    out[0] = e * m[1]
    out[1] = m[0] - 2 * m[3]
    out[2] = beta * m[0] + 2 * c * m[3] + e * m[4]
    out[3] = c * m[1] - m[2]
    out[4] = beta * m[1] + m[2]
    return out


def _odd(y: Array) -> Array:
    """(sinh 2y - 2y) exp(-2y)."""
    x = 2 * y
    series = x**3 * np.polynomial.polynomial.polyval(np.minimum(x, 2 * SMALL) ** 2, _ODD) * np.exp(-x)
    return np.where(y < SMALL, series, -np.expm1(-2 * x) / 2 - x * np.exp(-x))


def _even(y: Array) -> Array:
    """(cosh 2y - 1 - 2 y^2) exp(-2y)."""
    x = 2 * y
    series = x**4 * np.polynomial.polynomial.polyval(np.minimum(x, 2 * SMALL) ** 2, _EVEN) * np.exp(-x)
    return np.where(y < SMALL, series, (1 + np.exp(-2 * x)) / 2 - (1 + x**2 / 2) * np.exp(-x))

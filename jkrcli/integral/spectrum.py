"""Surface compliance of a stack of layers in Hankel space, C(k) = 2 g(k)/(E* k).

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

from ..materials import Elastic, contact_modulus
from ..problem import HalfSpace, Rigid, Specimen

Array = np.ndarray

TINY = 1e-30  # k h that stands for 0
SMALL = 1.0  # below this y the functions of y are summed as power series
_ODD = 1 / np.array([float(math.factorial(n)) for n in range(3, 28, 2)])
_EVEN = 1 / np.array([float(math.factorial(n)) for n in range(4, 29, 2)])


def deviation(specimen: Specimen, k: Array, indenter: Elastic | None = None) -> Array:
    """g(k) - 1 at the wave numbers ``k`` >= 0 [1/m], shape of ``k``; small values keep their relative accuracy.

    With an elastic ``indenter`` g belongs to both bodies together, normalised by E* of both: its own half-space adds a
    constant to the compliance, so that only the factor E*/E*_top remains.
    """
    k = np.asarray(k, dtype=float)
    if not specimen.layers:
        return np.zeros_like(k)
    top = specimen.surface
    factor = contact_modulus(top, indenter) / top.E_star
    return (factor * _deviation_of_stack(specimen, _positive(specimen, k))).reshape(k.shape)


def compliance_ratio(specimen: Specimen, k: Array, indenter: Elastic | None = None) -> Array:
    """g(k), the surface compliance over that of a half-space of the top material: 1 for k h -> infinity [-].

    Relative accuracy also where g is small (rigid base, k -> 0), except that an elastic ``indenter`` adds its constant.
    """
    k = np.asarray(k, dtype=float)
    if not specimen.layers:
        return np.ones_like(k)
    top = specimen.surface
    m = _minors(specimen, _positive(specimen, k))
    g = (m[2] / ((1 - top.nu) * m[0])).reshape(k.shape)
    if indenter is None:
        return g
    return contact_modulus(top, indenter) * (g / top.E_star + 1 / indenter.E_star)


def _positive(specimen: Specimen, k: Array) -> Array:
    """``k``, flat, with zero replaced by next to nothing: the minors over a frictionless base vanish at zero itself."""
    return np.maximum(np.ravel(k), TINY / specimen.top_thickness)


def _deviation_of_stack(specimen: Specimen, k: Array) -> Array:
    top = specimen.layers[0]
    below = _below(specimen, k)
    y = k * top.thickness
    dev = np.empty_like(k)
    small = y < SMALL
    dev[small] = _near(below[:, small], y[small], top.material.nu)
    dev[~small] = _far(below[:, ~small], y[~small], top.material.nu)
    return dev


def _near(m: Array, y: Array, nu: float) -> Array:
    """g - 1 for a thin top layer: from g itself."""
    m = _through(m, y, nu)
    return m[2] / ((1 - nu) * m[0]) - 1


def _far(m: Array, y: Array, nu: float) -> Array:
    """g - 1 for a thick top layer: its growing part, a half-space, is taken out of exp(B y) before any subtraction."""
    b1, b2, b3, b4 = _powers(m, nu)
    once = np.exp(-2 * y)
    twice = once * once

    def excess(v: Array) -> Array:
        return v[2] - (1 - nu) * v[0]

    decaying = once * (
        excess(m) + y * (excess(b1) - excess(b3) / 4) + y**2 * (excess(b2) / 2 - excess(b4) / 8) - excess(b4) / 16
    ) + twice * (excess(b4) / 32 - excess(b3) / 16)
    return decaying / ((1 - nu) * _through(m, y, nu)[0])


def _minors(specimen: Specimen, k: Array) -> Array:
    """Minors (5, n) of the whole stack at its surface, up to a positive factor, in units of the top layer."""
    top = specimen.layers[0]
    return _through(_below(specimen, k), k * top.thickness, top.material.nu)


def _below(specimen: Specimen, k: Array) -> Array:
    """Minors of everything below the top layer, in units of the top layer's shear modulus."""
    m, G = _base(specimen.base, k.size)
    for layer in reversed(specimen.layers[1:]):
        m = _through(_rescaled(m, layer.material.G / G), k * layer.thickness, layer.material.nu)
        G = layer.material.G
    return _rescaled(m, specimen.layers[0].material.G / G)


def _base(base: Rigid | HalfSpace, size: int) -> tuple[Array, float]:
    """Minors of the base, and the shear modulus [Pa] in whose units they are (any, for a rigid base)."""
    if isinstance(base, HalfSpace):
        nu = base.material.nu
        minors = [1.0, 1 - nu, 1 - nu, nu - 0.5, (3 - 4 * nu) / 4]
        return np.repeat(np.array(minors)[:, None], size, axis=1), base.material.G
    minors = [1.0, 0, 0, 0, 0] if base.bonded else [0.0, 1, 0, 0, 0]
    return np.repeat(np.array(minors)[:, None], size, axis=1), 1.0


def _rescaled(m: Array, ratio: float) -> Array:
    """The minors when F is counted in units of a modulus ``ratio`` times larger; largest entry 1."""
    powers = np.array([1.0, ratio, ratio, ratio, ratio**2])[:, None]
    m = m * powers
    return m / np.max(np.abs(m), axis=0)


def _through(m: Array, y: Array, nu: float) -> Array:
    """exp(B y) m exp(-2 y): the minors (5, n) one layer of y = k h further up."""
    b1, b2, b3, b4 = _powers(m, nu)
    once = np.exp(-2 * y)
    return once * m + (once * y) * b1 + (once * y**2 / 2) * b2 + (_odd(y) / 8) * b3 + (_even(y) / 16) * b4


def _powers(m: Array, nu: float) -> tuple[Array, Array, Array, Array]:
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

"""Closed-form solutions of axisymmetric contact. Plain functions of SI values; every parameter is required.

Hertz and JKR (Eqs. 2, 7, 17, 18 of Jiang et al.), Sneddon's exact sphere, power laws (Galin), thin layers.
"""

from __future__ import annotations

import numpy as np

from ..bodies.indenters import Indenter, Paraboloid, PowerLaw, RoundedFlat, Sphere

Array = np.ndarray


def hertz(a: Array, E_star: float, R: float) -> tuple[Array, Array]:
    """Paraboloid on a half-space (Eq. 2): delta_H [m] and P_H [N] at contact radius ``a`` [m]."""
    a = np.asarray(a, dtype=float)
    return a**2 / R, 4 * E_star * a**3 / (3 * R)


def sneddon_sphere(a: Array, E_star: float, R: float) -> tuple[Array, Array]:
    """Exact sphere on a half-space (Sneddon 1965): delta_H [m], P_H [N].

    P = E* [(R^2 + a^2) artanh(a/R) - a R]; a series where the difference would cancel.
    """
    a = np.asarray(a, dtype=float)
    x = a / R
    closed = (1 + x**2) * np.arctanh(x) - x
    n = np.arange(1, 12)
    series = x**3 * np.polynomial.polynomial.polyval(np.minimum(x, 0.2) ** 2, 1 / (2 * n + 1) + 1 / (2 * n - 1))
    return a * np.arctanh(x), E_star * R**2 * np.where(x < 0.2, series, closed)


def power_law(a: Array, E_star: float, B: float, d: float) -> tuple[Array, Array]:
    """f = B r^d on a half-space: delta_H = c_d B a^d [m], P_H = 2 E* c_d B a^(d+1) d/(d+1) [N]."""
    delta = PowerLaw(B, d).abel(a)
    return delta, 2 * E_star * delta * np.asarray(a, dtype=float) * d / (d + 1)


def rounded_flat(a: Array, E_star: float, b: float, edge_radius: float) -> tuple[Array, Array]:
    """Flat end with parabolic edge on a half-space: delta_H = F(a) [m], P_H = 2 E* int_0^a (F(a) - F(x)) dx [N].

    With s = sqrt(a^2 - b^2) the integral is [s^3/(3 edge_radius) + a F(a)]/2: a sum, which does not cancel.
    """
    a = np.asarray(a, dtype=float)
    delta = RoundedFlat(b, edge_radius).abel(a)
    s = np.sqrt((a - b) * (a + b))
    return delta, E_star * (s**3 / (3 * edge_radius) + a * delta)


def half_space(a: Array, E_star: float, indenter: Indenter) -> tuple[Array, Array] | None:
    """delta_H and P_H of ``indenter`` on a half-space where a closed form exists, else None; S = 2 E* a, S' = 2 E*."""
    match indenter:
        case Sphere(R=R):
            return sneddon_sphere(a, E_star, R)
        case Paraboloid(R=R):
            return hertz(a, E_star, R)
        case PowerLaw(B=B, d=d):
            return power_law(a, E_star, B, d)
        case RoundedFlat(b=b, edge_radius=edge_radius):
            return rounded_flat(a, E_star, b, edge_radius)
    return None


def jkr(a: Array, E_star: float, R: float, w: float) -> tuple[Array, Array]:
    """Classical JKR (Eq. 7 corrected): delta [m] and P [N] of a paraboloid on a half-space."""
    a = np.asarray(a, dtype=float)
    delta, P = hertz(a, E_star, R)
    return delta - np.sqrt(2 * np.pi * w * a / E_star), P - np.sqrt(8 * np.pi * w * E_star * a**3)


def jkr_dimensionless(a_bar: Array) -> tuple[Array, Array]:
    """Classical JKR in the units of Eq. 15 (Eq. 18 corrected): delta_bar and P_bar."""
    a_bar = np.asarray(a_bar, dtype=float)
    return a_bar**2 - 2 / 3 * np.sqrt(6 * a_bar), a_bar**3 - np.sqrt(6 * a_bar**3)


def adhesive_half_space(a: Array, E_star: float, indenter: Indenter, w: float) -> tuple[Array, Array] | None:
    """Eq. 13 with S = 2 E* a for any indenter with a closed form: delta [m] and P [N], else None."""
    nonadhesive = half_space(a, E_star, indenter)
    if nonadhesive is None:
        return None
    delta, P = nonadhesive
    shift = np.sqrt(2 * np.pi * w * np.asarray(a, dtype=float) / E_star)
    return delta - shift, P - 2 * E_star * a * shift


def foundation_modulus(E: float, nu: float, h: float) -> float:
    """Winkler stiffness K of a thin compressible bonded layer [Pa/m] (Eq. 22)."""
    return E * (1 - nu) / (h * (1 + nu) * (1 - 2 * nu))


def thin_layer(a: Array, K: float, R: float) -> tuple[Array, Array]:
    """Leading order for a/h -> infinity, compressible (Eq. 20): delta_H = a^2/(2R), P_H = pi K a^4/(4R)."""
    a = np.asarray(a, dtype=float)
    return a**2 / (2 * R), np.pi * K * a**4 / (4 * R)


def thin_incompressible_layer(a: Array, G: float, h: float, R: float) -> tuple[Array, Array]:
    """Leading order for a/h -> infinity at nu = 1/2: delta_H = a^2/(4R), P_H = pi G a^6/(32 R h^3)."""
    a = np.asarray(a, dtype=float)
    return a**2 / (4 * R), np.pi * G * a**6 / (32 * R * h**3)


def tabor(R: float, w: float, E_star: float, z0: float) -> float:
    """Tabor number (Eq. 1 corrected): (R w^2/(E*^2 z0^3))^(1/3)."""
    return float((R * w**2 / (E_star**2 * z0**3)) ** (1 / 3))

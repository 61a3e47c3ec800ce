"""Axisymmetric contact with a homogeneous half-space in closed form. Plain functions of SI values.

Hertz and JKR (Eqs. 2, 7, 17, 18 of Jiang et al.), Sneddon's exact sphere, power laws (Galin), the rounded flat end.
Everywhere S = 2 E* a and S' = 2 E*.
"""

from __future__ import annotations

import math

import numpy as np

from ..base import Array
from .griffith import shift


def effective_radius(R_1: float, R_2: float) -> float:
    """Effective radius R [m] of two spheres in contact (Eq. 4): 1/R = 1/R_1 + 1/R_2; ``R_2`` < 0: a cavity."""
    return 1 / (1 / R_1 + 1 / R_2)


def hertz(a: Array, E_star: float, R: float) -> tuple[Array, Array]:
    """Paraboloid on a half-space (Eq. 2): delta_H [m] and P_H [N] at contact radius ``a`` [m]."""
    return a**2 / R, 4 * E_star * a**3 / (3 * R)


def sneddon_sphere(a: Array, E_star: float, R: float) -> tuple[Array, Array]:
    """Exact sphere on a half-space (Sneddon 1965): delta_H [m], P_H [N].

    P = E* [(R^2 + a^2) artanh(a/R) - a R]; a series where the difference would cancel.
    """
    x = a / R
    closed = (1 + x**2) * np.arctanh(x) - x
    n = np.arange(1, 12)
    series = x**3 * np.polynomial.polynomial.polyval(np.minimum(x, 0.2) ** 2, 1 / (2 * n + 1) + 1 / (2 * n - 1))
    return a * np.arctanh(x), E_star * R**2 * np.where(x < 0.2, series, closed)


def power_law(a: Array, E_star: float, B: float, d: float) -> tuple[Array, Array]:
    """f = B r^d on a half-space: delta_H = c_d B a^d [m], P_H = 2 E* c_d B a^(d+1) d/(d+1) [N]."""
    with np.errstate(over="ignore"):  # infinite is what it is then, and what a search for a radius can tell
        delta = B * (abel_factor(d) * a**d)
    return delta, 2 * E_star * delta * a * d / (d + 1)


def abel_factor(n: float) -> float:
    """Factor c_n of a power r^n, n > 0, whose F is c_n x^n: sqrt(pi) Gamma(n/2 + 1)/Gamma((n + 1)/2)."""
    z = (n + 1) / 2
    if z < 150:  # beyond, Gamma overflows soon, and the first term left out of its asymptotic series is below 1e-16
        return math.sqrt(math.pi) * math.gamma(z + 0.5) / math.gamma(z)
    terms = (1, -1 / 8, 1 / 128, 5 / 1024, -21 / 32768, -399 / 262144)
    return math.sqrt(math.pi * z) * sum(term / z**k for k, term in enumerate(terms))


def rounded_flat(a: Array, E_star: float, b: float, edge_radius: float) -> tuple[Array, Array]:
    """Flat end with parabolic edge on a half-space: delta_H = F(a) [m], P_H = 2 E* int_0^a (F(a) - F(x)) dx [N].

    With s = sqrt(a^2 - b^2) the integral is [s^3/(3 edge_radius) + a F(a)]/2: a sum, which does not cancel.
    """
    s = np.sqrt((a - b) * (a + b))
    delta = a * b * tangent_minus_angle(s / b) / edge_radius
    return delta, E_star * (s**3 / (3 * edge_radius) + a * delta)


def rounded_cone(a: Array, E_star: float, R: float, b: float) -> tuple[Array, Array]:
    """Cone of slope b/R with a parabolic end of radius R up to r = b: delta_H = F(a) [m], P_H [N]; Hertz up to a = b.

    The sums of positive parts, with s = sqrt(a^2 - b^2) and a - s = b^2/(a + s), do not cancel.
    """
    s, angle = beyond(a, b)
    least = np.minimum(a, b)
    rest = np.where(s > 0, least**2 / (a + s + (a == 0)), a)  # a - s
    delta = a * (rest + b * angle) / R
    return delta, E_star * (4 * a**2 * rest + s * least**2 + 3 * a**2 * b * angle) / (3 * R)


def sphere_capped_cone(a: Array, E_star: float, R: float, b: float) -> tuple[Array, Array]:
    """Cone with a spherical end of radius R up to r = b < R, tangent there: delta_H = F(a) [m], P_H [N].

    F = a [L + cot(alpha) arccos(b/a)], L = ln[(R + a)/(s + q)], s = sqrt(R^2 - b^2), q = sqrt(a^2 - b^2), cot(alpha) =
    b/s; P = 2 E* int_0^a f' r^2/sqrt(a^2 - r^2) dr (Sneddon 1965). Up to a = b that of a sphere.
    """
    a = np.asarray(a, dtype=float)
    L, inner, s, q = _cap(a, R, b)
    _, angle = beyond(a, b)
    cot = b / math.sqrt((R - b) * (R + b))

    # int_0^b r^3/[sqrt(R^2 - r^2) sqrt(a^2 - r^2)] dr in closed form, by r = a sin(t) where its terms would cancel
    closed = ((R**2 + a**2) * L + s * q - R * a) / 2
    nodes, weights = np.polynomial.legendre.leggauss(20)
    top = np.arctan2(inner, q)
    r = a[..., None] * np.sin(top[..., None] * (nodes + 1) / 2)
    small = np.minimum(r, 0.5 * R)  # of the larger ones the closed form is taken
    end = top / 2 * np.sum(weights * small**3 / np.sqrt((R - small) * (R + small)), axis=-1)

    cap = np.where(inner < 0.2 * R, end, closed)
    return a * (L + cot * angle), 2 * E_star * cap + E_star * cot * (a**2 * angle + b * beyond(a, b)[0])


def sphere_capped_cone_rate(x: Array, R: float, b: float) -> Array:
    """F' [-] of the cone with a spherical end: L + cot(alpha) arccos(b/x) + R^2/[s (s + q)] - R/(R + x), as a sum."""
    L, inner, s, q = _cap(x, R, b)
    _, angle = beyond(x, b)
    rest = R * inner**2 * (1 + (R**2 + x**2 - inner**2) / (R * x + s * q)) / (s * (s + q) * (R + x))
    return L + b / math.sqrt((R - b) * (R + b)) * angle + rest


def _cap(a: Array, R: float, b: float) -> tuple[Array, Array, Array, Array]:
    """L = ln[(R + a)/(s + q)] as a sum that does not cancel, the radius of the spherical end within the contact [m],
    s and q [m]."""
    inner = np.minimum(a, b)
    s, q = np.sqrt((R - inner) * (R + inner)), np.sqrt((a - inner) * (a + inner))
    rest = inner**2 / (R + s) + np.where(q > 0, inner**2 / (a + q + (a == 0)), a)  # R - s + a - q
    return np.log1p(rest / (s + q)), inner, s, q


def beyond(a: Array, b: float) -> tuple[Array, Array]:
    """sqrt(a^2 - b^2) [m] and arccos(b/a) of radii ``a`` beyond ``b`` [m]; 0 within."""
    a = np.maximum(a, b)
    s = np.sqrt((a - b) * (a + b))
    return s, np.arctan2(s, b)


def tangent_minus_angle(u: Array) -> Array:
    """u - arctan(u) for u >= 0 [-], by u^3/3 - u^5/5 + ... where the difference would cancel."""
    orders = np.arange(26)  # the first term left out is 2^-52/55 at u = 1/2
    square = np.minimum(u, 0.5) ** 2
    series = u**3 * np.polynomial.polynomial.polyval(square, (-1.0) ** orders / (2 * orders + 3))
    return np.where(u < 0.5, series, u - np.arctan(u))


def jkr(a: Array, E_star: float, R: float, w: float) -> tuple[Array, Array]:
    """Classical JKR (Eq. 7 corrected): delta [m] and P [N] of a paraboloid on a half-space."""
    delta, P = hertz(a, E_star, R)
    return delta - np.sqrt(2 * np.pi * w * a / E_star), P - np.sqrt(8 * np.pi * w * E_star * a**3)


def jkr_dimensionless(a_bar: Array) -> tuple[Array, Array]:
    """Classical JKR in the units of Eq. 15 (Eq. 18 corrected): delta_bar and P_bar."""
    return a_bar**2 - 2 / 3 * np.sqrt(6 * a_bar), a_bar**3 - np.sqrt(6 * a_bar**3)


def adhesive_half_space(a: Array, delta_H: Array, P_H: Array, E_star: float, w: float) -> tuple[Array, Array]:
    """Adhesion with S = 2 E* a: delta [m] and P [N] of the indenter whose nonadhesive contact is delta_H, P_H."""
    t = shift(w, a, 2 * E_star)
    return delta_H - t, P_H - 2 * E_star * a * t


def tabor(R: float, w: float, E_star: float, z0: float) -> float:
    """Tabor number (Eq. 1 corrected): (R w^2/(E*^2 z0^3))^(1/3), of ``R`` [m], ``w`` [J/m^2], ``E_star`` [Pa] and the
    range of the forces ``z0`` [m]."""
    return float((R * w**2 / (E_star**2 * z0**3)) ** (1 / 3))

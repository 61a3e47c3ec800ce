"""Closed forms: one equation, one function, all parameters required."""

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.numerics import Array

# --------------------------------------------------------------------------------------------------
# Thin-layer formulae: leading order for a contact radius much larger than the thickness of a layer on a rigid base.
#
# A compressible layer is a bed of springs (Winkler) of stiffness K [Pa/m]; its contact does not know Poisson's ratio
# but through K. A nearly incompressible layer is neither: K of Eq. 22 diverges and Eq. 20 is wrong there. Plain
# functions of SI values; ``jkrcli.methods.closed_form`` checks each use against the exact layer.


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


# --------------------------------------------------------------------------------------------------
# Pull-off of a rigid sphere from a thick incompressible body at large strains.
#
# With wc = (w/(E* R))^(1/3), -P_min = 1.5 pi w R [1 + 0.046 wc + O(wc^2)] on a neo-Hookean half-space, nu = 1/2: the
# cubic energy U3 = mu sum c_k D^(3-k) X^k, D = a^2/R, X = D - delta, c = -0.11569, 0.34707, -0.43430, 0.2002, as a
# perturbation of JKR's; finite elements agree (0.003 at wc = 0.06). Under displacement control the same energy gives
# 0.116 wc. The second order depends on what w is the energy of: + 0.7 wc^2 per undeformed area, -4.5 wc^2 per
# deformed area.

BY_LOAD, BY_DISPLACEMENT = 0.046, 0.116  # theory: of wc, the cubic energy at pull-off under either control
PER_DEFORMED, PER_UNDEFORMED = -4.5, 0.7  # theory: of wc^2, neo-Hookean finite elements
EXPANDED = 0.15  # theory: wc up to which the expansion is as good as the elements
MEASURED, LEAST, MOST = 0.3, -0.27, 0.06  # theory: the largest wc of the elements, and the changes there
SPHERE = 0.9  # theory: of wc^2, by which the exact sphere's pull-off in linear theory is below the paraboloid's


def strained_pull_off(wc: float, first: float = BY_LOAD, sphere: bool = False) -> tuple[float, float] | None:
    """Least and largest relative change of the pull-off force by large strains at ``wc``; None beyond 0.3.

    ``first``: coefficient of wc of the control. Linear between the end of the expansion and the last elements.
    ``sphere``: of the linear theory of the exact sphere, else of the paraboloid.
    """
    if wc > MEASURED:
        return None
    at, ends = min(wc, EXPANDED), (LEAST, MOST + (first - BY_LOAD) * MEASURED)
    expanded = (PER_DEFORMED * at**2, first * at + PER_UNDEFORMED * at**2)
    low, high = (float(np.interp(wc, (at, MEASURED), pair)) for pair in zip(expanded, ends, strict=True))
    own = 1 - SPHERE * wc**2 if sphere else 1.0
    return (1 + low) / own - 1, (1 + high) / own - 1


# --------------------------------------------------------------------------------------------------
# A force on the surface of an isotropic elastic half-space (Boussinesq; Johnson 1985, Sec. 3.2).


def point_force(r: Array, z: Array, E: float, nu: float) -> tuple[Array, Array]:
    """Displacements u_r, u_z [m/N] at the radius ``r`` and the depth ``z`` [m] under a unit force at the origin, u_z as
    the force into the half-space of the modulus ``E`` [Pa]."""
    rho = np.hypot(r, z)
    factor = (1 + nu) / (2 * np.pi * E * rho)
    return factor * (r * z / rho**2 - (1 - 2 * nu) * r / (rho + z)), factor * (z**2 / rho**2 + 2 * (1 - nu))


# --------------------------------------------------------------------------------------------------
# Units of load, displacement and contact radius that make an adhesive curve dimensionless.


def scales_half_space(R: float, E_star: float, w: float) -> tuple[float, float, float]:
    """Units of P [N], delta [m] and a [m] for a half-space (Eq. 15 corrected)."""
    P = math.pi * w * R
    delta = (9 * math.pi**2 * w**2 * R / (16 * E_star**2)) ** (1 / 3)
    a = (3 * math.pi * w * R**2 / (4 * E_star)) ** (1 / 3)
    return P, delta, a


def scales_thin_layer(R: float, K: float, w: float) -> tuple[float, float, float]:
    """Units of P [N], delta [m] and a [m] for a thin layer of Winkler stiffness K [Pa/m] (Eq. 19 corrected)."""
    return 2 * math.pi * w * R, math.sqrt(2 * w / K), (8 * w * R**2 / K) ** 0.25


# --------------------------------------------------------------------------------------------------
# Eq. 13: the symbols of adhesive curves, of an edge in a device, and of fits.
#
# Without adhesion a contact of radius a has the displacement delta_H, the load P_H, the stiffness S = dP/d(delta) and
# its slope S' = dS/da. One that lags by L behind delta_H is that of a flat punch moved back, with the energy release
# rate G = S' L^2/(4 pi a):
#
#     delta = delta_H - L        P = P_H - S L
#
# By Griffith's balance G = w in equilibrium, so that L = sqrt(w) t, t = sqrt(4 pi a/S'). Fits tabulate D = delta_H,
# T = t, H = P_H and V = S t: with all moduli times s, and v = sqrt(w/s),
#
#     delta = D - v T        P = s (H - v V)


class Parts(NamedTuple):
    """The functions without w at some contact radii, or their derivatives; ``t``: the shift at w = 1 J/m^2."""

    delta_H: Array
    P_H: Array
    S: Array
    dS: Array
    t: Array

    def lagging(self, L: Array) -> tuple[Array, Array]:
        """delta [m] and P [N] of contacts that lag by ``L`` [m]."""
        return lagging(self.delta_H, self.P_H, self.S, L)

    def lagging_rates(self, rates: "Parts", L: Array, dL: Array) -> tuple[Array, Array]:
        """Their derivatives, by those of the functions and ``dL`` of the lag."""
        return rates.delta_H - dL, rates.P_H - self.S * dL - rates.S * L


def lagging(delta_H: Array, P_H: Array, S: Array, L: Array) -> tuple[Array, Array]:
    """delta [m] and P [N] of contacts whose displacement lags by ``L`` [m] behind ``delta_H``."""
    return delta_H - L, P_H - S * L


def adhesive(functions: Array | tuple[Array, ...], s: Any, v: Any) -> tuple[Array, Array]:
    """delta [m] and P [N] by ``functions`` (D, T, H, V), or derivatives of them, for moduli times ``s`` and ``v`` =
    sqrt(w/s)."""
    D, T, H, V = functions
    return D - v * T, s * (H - v * V)


def device_factors(s: Array, v: Array, k: Array) -> Array:
    """What D, T, H, V count in the position delta + P/k of devices of stiffness ``k`` [N/m], and in P: (n, 2, 4)."""
    zero = np.zeros_like(s)
    factors = np.array([[zero + 1, -v, s / k, -s * v / k], [zero, zero, s, -s * v]])
    return np.ascontiguousarray(factors.transpose(2, 0, 1))


def shift(w: float, a: Array | float, dS: Array | float) -> Any:
    """The shift t = sqrt(4 pi w a/S') [m]: how far adhesion moves the indenter back at contact radius ``a`` [m].

    The contact moves back as a flat punch does, with the slope S [N/m]; its energy release rate S' t^2/(4 pi a) is then
    the work of adhesion ``w`` [J/m^2] (Eq. 13). ``dS``: S' = dS/da > 0 [N/m^2].
    """
    return np.sqrt(4 * math.pi * w * a / dS)


# --------------------------------------------------------------------------------------------------
# Axisymmetric contact with a homogeneous half-space in closed form. Plain functions of SI values.
#
# Hertz and JKR (Eqs. 2, 7, 17, 18 of Jiang et al.), Sneddon's exact sphere, power laws (Galin), the rounded flat end.
# Everywhere S = 2 E* a and S' = 2 E*.


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
    return lagging(delta_H, P_H, 2 * E_star * a, shift(w, a, 2 * E_star))


def punch_of_range(R: float, w: float, E_star: float, z0: float) -> float:
    """Pull-off force [N] of a rigid flat punch of radius ``R`` [m] on a half-space, with a tension w/z0 in an annulus
    at its rim (Maugis and Dugdale): Kendall's where that is narrow, pi R^2 w/z0 where it covers the end.

    Inside a the end is in contact, and the stress is finite at a = R cos(theta); the gap at the rim is z0 at pull-off:

        z0 = 4 sigma R/(pi E*) [theta sin(theta) + cos(theta) - 1],  F = 2 sigma R^2 [theta + sin(theta) cos(theta)].
    """
    sigma, low, high = w / z0, 0.0, math.pi / 2
    while (theta := (low + high) / 2) not in (low, high):
        # cos(theta) - 1 without cancellation
        gap = 4 * sigma * R / (math.pi * E_star) * (theta * math.sin(theta) - 2 * math.sin(theta / 2) ** 2)
        low, high = (theta, high) if gap < z0 else (low, theta)
    return 2 * sigma * R**2 * (theta + math.sin(theta) * math.cos(theta))


def tabor(R: float, w: float, E_star: float, z0: float) -> float:
    """Tabor number (Eq. 1 corrected): (R w^2/(E*^2 z0^3))^(1/3), of ``R`` [m], ``w`` [J/m^2], ``E_star`` [Pa] and the
    range of the forces ``z0`` [m]."""
    return float((R * w**2 / (E_star**2 * z0**3)) ** (1 / 3))


# --------------------------------------------------------------------------------------------------
# Incompressible elastic half-space under its own weight, touched by a paraboloid.
#
# What is pushed up weighs rho g u_z and what is pushed down is buoyant, so that in Hankel space the pressure is (E*
# k/2 + rho g) u_z at nu = 1/2; before contact the weight is a hydrostatic pressure and changes nothing else. To first
# order in e = 2 eps a/pi, eps = 2 rho g/E* [1/m], with l = -ln(2 eps a) - 0.5772...:
#
#     S = 2 E* a [1 + e (3/2 + l)],  S' = 2 E* [1 + 2 e (1 + l)],  P_H = 4 E* a^3/(3 R) [1 + 3 e/4]   at equal radius,
#     P_H = Hertz's P(delta) [1 + e (19/12 + l)]                                                     at equal depth.
#
# Derived for this program; the tests hold it to the integral equation with that kernel. Plain functions of SI values.

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


# --------------------------------------------------------------------------------------------------
# The capillary bridge of a wetting liquid at fixed humidity: a constant tension over a fixed height.
#
# Maugis and Gauthier-Manuel (J. Adhesion Sci. Technol. 8 (1994) 1311): the Laplace pressure gamma/r_K acts wherever
# the gap is narrower than the height r_K (cos theta_1 + cos theta_2) of the meniscus, r_K the Kelvin radius; their
# product, the work of adhesion, does not depend on the humidity. Valid where the meniscus is much wider than high.

GAS_CONSTANT = 8.31446261815324  # theory: J/(mol K), exact in the SI
WATER = 18.05e-6  # theory: m^3/mol, the molar volume of water at 20 degrees Celsius
ROOM = 293.15  # theory: K, the 20 degrees Celsius of ``WATER``


def kelvin_radius(surface_tension: float, humidity: float) -> float:
    """The Kelvin radius [m] of water at 20 degrees Celsius for a ``surface_tension`` [N/m] and a relative ``humidity``
    between 0 and 1 (Thomson 1871)."""
    return -surface_tension * WATER / (GAS_CONSTANT * ROOM * math.log(humidity))


def capillary(surface_tension: float, radius: float, angles: tuple[float, float]) -> tuple[float, float]:
    """Tension [Pa] and work of adhesion [J/m^2] of a bridge of the Kelvin ``radius`` [m] and two contact ``angles``
    [rad]."""
    wetting = math.cos(angles[0]) + math.cos(angles[1])
    return surface_tension / radius, surface_tension * wetting


# --------------------------------------------------------------------------------------------------
# Elastic half-space whose surface has the constant tension Ups [N/m]: kappa = 2 Ups/E* [m].
#
# Hui, Liu, Salez, Raphael, Jagota, Proc. R. Soc. A 471 (2015) 20140727. Plain functions of SI values.

NEAR_ORIGIN = 2.0  # choice: |x| up to which E1(x) is summed from its series, whose terms do not cancel there yet
SERIES_TERMS = 24  # theory: 2^24/(24 24!), the first term left out up to there, is below 1e-18
FRACTION_STEPS = 100  # theory: of the continued fraction; beyond it 60 leave 4e-13, 100 round-off


def displacement(z: Array) -> Array:
    """A(z) = int_0^inf cos(z t)/(1 + t) dt, z > 0 [-]: like -ln(z) near 0, 1/z^2 far away. The real part of
    exp(x) E1(x), x = i z (Abramowitz and Stegun 5.2.13, 5.1.11 and 5.1.22)."""
    near, far = 1j * np.minimum(z, NEAR_ORIGIN), 1j * np.maximum(z, NEAR_ORIGIN)
    power: Array = np.ones_like(near)
    series: Array = -np.euler_gamma - np.log(near)
    for k in range(1, SERIES_TERMS):
        power = power * -near / k
        series = series - power / k
    fraction: Array = far + 2 * FRACTION_STEPS + 1
    for k in range(FRACTION_STEPS, 0, -1):
        fraction = far + 2 * k - 1 - k * k / fraction
    return np.where(z < NEAR_ORIGIN, (np.exp(near) * series).real, (1 / fraction).real)


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

"""Every formula under its own name, against an integral, a derivative or a published value that no formula shares."""

import ast
import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.optimize import brentq, minimize_scalar
from scipy.special import ellipk, sici

from jkrcli import formulas

E_STAR, R = 7.0e5, 2e-3
AT = np.array([0.05, 0.15, 0.3, 0.45]) * R


def load_of(slope: Callable[[float], float], a: float, kink: float | None = None) -> tuple[float, float]:
    """delta_H [m] and P_H [N] of a profile with the ``slope`` f'(r), by Sneddon's integrals with r = a sin(t)."""
    at = [math.asin(kink / a)] if kink is not None and kink < a else None

    def integral(function: Callable[[float], float]) -> float:
        return quad(function, 0, math.pi / 2, epsabs=0, epsrel=1e-10, points=at, limit=200)[0]

    delta = integral(lambda t: a * slope(a * math.sin(t)))
    return delta, 2 * E_STAR * integral(lambda t: (a * math.sin(t)) ** 2 * slope(a * math.sin(t)))


def test_each_formula_has_a_test_of_its_name() -> None:
    source = Path(formulas.__file__).read_text(encoding="utf-8")
    names = [node.name for node in ast.parse(source).body if isinstance(node, ast.FunctionDef)]
    tests = [node.name for node in ast.parse(Path(__file__).read_text(encoding="utf-8")).body
             if isinstance(node, ast.FunctionDef)]  # fmt: skip
    assert [name for name in names if not name.startswith("_") and f"test_{name}" not in tests] == []


# ---------------------------------------------------------------------- thin layers
def test_foundation_modulus() -> None:
    """E/h at nu = 0, and the oedometric modulus over the thickness: K h = lambda + 2 G."""
    assert formulas.foundation_modulus(3e6, 0.0, 2e-4) == pytest.approx(3e6 / 2e-4)
    lame, G = 3e6 * 0.3 / (1.3 * 0.4), 3e6 / 2.6
    assert formulas.foundation_modulus(3e6, 0.3, 2e-4) == pytest.approx((lame + 2 * G) / 2e-4)


def test_thin_layer() -> None:
    """A bed of springs under a paraboloid: P = int K (delta - r^2/2R) 2 pi r dr."""
    a, K = 1e-4, 3e12
    delta, P = formulas.thin_layer(np.array(a), K, R)
    springs = quad(lambda r: K * (a**2 - r**2) / (2 * R) * 2 * math.pi * r, 0, a)[0]
    assert (float(delta), float(P)) == pytest.approx((a**2 / (2 * R), springs))


def test_thin_layer_slopes() -> None:
    S, dS = formulas.thin_layer_slopes(AT, 3e12)
    (d1, P1), (d2, P2) = (formulas.thin_layer(AT * (1 + e), 3e12, R) for e in (-1e-6, 1e-6))
    assert_allclose(S, (P2 - P1) / (d2 - d1), rtol=1e-8)
    assert_allclose(dS, 2 * S / AT)


def test_thin_layer_dimensionless() -> None:
    """The bed of springs, moved back by sqrt(2 w/K): springs that break at K u^2/2 = w."""
    K, w = 3e12, 0.05
    P0, delta0, a0 = formulas.scales_thin_layer(R, K, w)
    delta_bar, P_bar = formulas.thin_layer_dimensionless(AT / a0)
    delta, P = formulas.thin_layer(AT, K, R)
    back = math.sqrt(2 * w / K)
    assert_allclose(delta_bar * delta0, delta - back)
    assert_allclose(P_bar * P0, P - math.pi * AT**2 * K * back)


def test_thin_incompressible_layer() -> None:
    """Lubrication: u_z h = -(h^3/12 G) laplacian p with p(a) = 0 and, at the edge, no flow; p = C (a^2 - r^2)^2."""
    a, G, h = 1e-4, 1e5, 1e-5
    delta, P = formulas.thin_incompressible_layer(np.array(a), G, h, R)
    # p = C (a^2 - r^2)^2: laplacian p = C (16 r^2 - 8 a^2); squeezed volume: u(r) = (h^3/3 G) C (8 a^2 - 16 r^2)
    C = 3 * G / (16 * 2 * R * h**3)
    assert float(delta) == pytest.approx(h**3 / (3 * G) * C * 8 * a**2)
    assert float(P) == pytest.approx(quad(lambda r: C * (a**2 - r**2) ** 2 * 2 * math.pi * r, 0, a)[0])


def test_thin_incompressible_slopes() -> None:
    S, dS = formulas.thin_incompressible_slopes(AT, 1e5, 1e-5)
    (d1, P1), (d2, P2) = (formulas.thin_incompressible_layer(AT * (1 + e), 1e5, 1e-5, R) for e in (-1e-6, 1e-6))
    assert_allclose(S, (P2 - P1) / (d2 - d1), rtol=1e-8)
    assert_allclose(dS, 4 * S / AT)


# ---------------------------------------------------------------------- large strains and a point force
def test_strained_pull_off() -> None:
    assert formulas.strained_pull_off(0.1) == (pytest.approx(-0.045), pytest.approx(0.046 * 0.1 + 0.7 * 0.01))
    assert formulas.strained_pull_off(0.3) == (pytest.approx(-0.27), pytest.approx(0.06))
    assert formulas.strained_pull_off(0.301) is None
    widths = np.array([formulas.strained_pull_off(wc) for wc in np.linspace(0, 0.3, 61)])
    assert (np.diff(widths[:, 0]) < 0).all()
    assert (np.diff(widths[:, 1]) > 0).all()
    low, high = formulas.strained_pull_off(0.1, sphere=True)  # its linear theory is 0.9 wc^2 below the paraboloid's
    assert (1 + low) * (1 - 0.009) == pytest.approx(1 - 0.045)
    assert (1 + high) * (1 - 0.009) == pytest.approx(1 + 0.0116)


def test_point_force() -> None:
    """Boussinesq: the surface sinks by (1 - nu^2)/(pi E r); the traction on a deep plane carries the whole force."""
    E, nu = 2e6, 0.3
    _, sunk = formulas.point_force(np.array(1e-3), np.array(0.0), E, nu)
    assert float(sunk) == pytest.approx((1 - nu**2) / (math.pi * E * 1e-3))
    G, lame, z, e = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu)), 1e-3, 1e-7

    def pressure(r: float) -> float:
        x, y = np.array([r - e, r, r + e, r, r]), np.array([z, z - e, z, z + e, z])
        u_r, u_z = formulas.point_force(x, y, E, nu)
        radial, axial = (u_r[2] - u_r[0]) / (2 * e) + u_r[4] / r, (u_z[3] - u_z[1]) / (2 * e)
        return -float(lame * (radial + axial) + 2 * G * axial)

    assert quad(lambda s: 2 * math.pi * s * z**2 * pressure(s * z), 1e-6, 200, limit=200)[0] == pytest.approx(1, 2e-4)


# ---------------------------------------------------------------------- units, Eq. 13, radii
def test_scales_half_space() -> None:
    """The units of Eq. 15 turn JKR's curve into Eq. 18."""
    P, delta, a = formulas.scales_half_space(R, E_STAR, 0.05)
    curve = formulas.jkr(AT, E_STAR, R, 0.05)
    assert_allclose((curve[0] / delta, curve[1] / P), formulas.jkr_dimensionless(AT / a), rtol=1e-12, atol=1e-12)


def test_scales_thin_layer() -> None:
    """Pull-off of a bed of springs is -2 pi w R at one unit of a, by load."""
    P, delta, a = formulas.scales_thin_layer(R, 3e12, 0.05)
    assert P == pytest.approx(2 * math.pi * 0.05 * R)
    assert a**2 / (2 * R) == pytest.approx(delta)


def test_shift() -> None:
    """The energy release rate of a flat punch moved back by t, S' t^2/(4 pi a), is w."""
    t = formulas.shift(0.05, AT, 3.0)
    assert_allclose(3.0 * t**2 / (4 * math.pi * AT), 0.05)


def test_effective_radius() -> None:
    assert formulas.effective_radius(2.0, 2.0) == 1.0
    assert formulas.effective_radius(1.0, -2.0) == 2.0  # in a cavity
    assert formulas.effective_radius(3.0, math.inf) == 3.0


# ---------------------------------------------------------------------- half-spaces
def test_hertz() -> None:
    for a in AT:
        assert [float(x) for x in formulas.hertz(a, E_STAR, R)] == pytest.approx(load_of(lambda r: r / R, a))


def test_sneddon_sphere() -> None:
    for a in AT:
        expected = load_of(lambda r: r / math.sqrt(R**2 - r**2), a)
        assert [float(x) for x in formulas.sneddon_sphere(np.array(a), E_STAR, R)] == pytest.approx(expected)


@pytest.mark.parametrize("d", [1.0, 1.7, 4.0])
def test_power_law(d: float) -> None:
    for a in AT:
        expected = load_of(lambda r: 0.3 * d * r ** (d - 1), a)
        assert [float(x) for x in formulas.power_law(a, E_STAR, 0.3, d)] == pytest.approx(expected)


@pytest.mark.parametrize("n", [0.5, 1.0, 2.0, 7.0, 149.0, 151.0, 400.0])
def test_abel_factor(n: float) -> None:
    """c_n = n int_0^(pi/2) sin^(n-1) t dt: pi/2 of a cone, 2 of a paraboloid."""
    wallis = quad(lambda t: math.sin(t) ** (n - 1), 0, math.pi / 2, epsabs=0, epsrel=1e-11, limit=200)[0]
    assert formulas.abel_factor(n) == pytest.approx(n * wallis, rel=1e-9)


def test_rounded_flat() -> None:
    b, edge = 3e-4, 1e-3
    for a in (3.2e-4, 5e-4, 9e-4):
        expected = load_of(lambda r: max(r - b, 0.0) / edge, a, b)
        assert [float(x) for x in formulas.rounded_flat(np.array(a), E_STAR, b, edge)] == pytest.approx(expected)


def test_rounded_cone() -> None:
    b = 4e-4
    for a in (2e-4, 5e-4, 9e-4):
        expected = load_of(lambda r: min(r, b) / R, a, b)
        assert [float(x) for x in formulas.rounded_cone(np.array(a), E_STAR, R, b)] == pytest.approx(expected)


def capped(r: float, b: float) -> float:
    return min(r, b) / math.sqrt(R**2 - min(r, b) ** 2)


def test_sphere_capped_cone() -> None:
    b = 1.2e-3
    for a in (4e-4, 1.3e-3, 3e-3):
        expected = load_of(lambda r: capped(r, b), a, b)
        found = formulas.sphere_capped_cone(np.array(a), E_STAR, R, b)
        assert [float(x) for x in found] == pytest.approx(expected)


def test_sphere_capped_cone_rate() -> None:
    x, b = np.array([4e-4, 1.3e-3, 3e-3]), 1.2e-3
    above, below = (formulas.sphere_capped_cone(x * (1 + e), E_STAR, R, b)[0] for e in (1e-6, -1e-6))
    assert_allclose(formulas.sphere_capped_cone_rate(x, R, b), (above - below) / (2e-6 * x), rtol=1e-7)


def test_beyond() -> None:
    s, angle = formulas.beyond(np.array([1.0, 3.0, 5.0]), 3.0)
    assert_allclose(s, [0, 0, 4])
    assert_allclose(angle, [0, 0, math.acos(0.6)])


def test_tangent_minus_angle() -> None:
    u = np.array([1e-3, 0.1, 0.49, 0.51, 3.0])
    expected = [quad(lambda t: t**2 / (1 + t**2), 0, end, epsabs=0, epsrel=1e-13)[0] for end in u]
    assert_allclose(formulas.tangent_minus_angle(u), expected, rtol=1e-12)


# ---------------------------------------------------------------------- adhesion
def test_jkr() -> None:
    """Johnson, Kendall and Roberts' own form: a^3 = (3 R/4 E*) [P + 3 pi w R + sqrt(6 pi w R P + (3 pi w R)^2)]."""
    w, a = 0.05, AT[1:]  # the branch that is stable under load
    P = formulas.jkr(a, E_STAR, R, w)[1]
    rest = 3 * math.pi * w * R
    assert_allclose(3 * R / (4 * E_STAR) * (P + rest + np.sqrt(2 * rest * P + rest**2)), a**3)


def test_jkr_dimensionless() -> None:
    lowest = minimize_scalar(lambda a: formulas.jkr_dimensionless(np.array(a))[1], bounds=(0.5, 2), method="bounded")
    assert lowest.fun == pytest.approx(-1.5)


def test_adhesive_half_space() -> None:
    hertzian = formulas.hertz(AT, E_STAR, R)
    assert_allclose(formulas.adhesive_half_space(AT, *hertzian, E_STAR, 0.03), formulas.jkr(AT, E_STAR, R, 0.03))


def test_lagging() -> None:
    """A flat punch moved back by the shift of JKR."""
    delta, P = formulas.lagging(
        *formulas.hertz(AT, E_STAR, R), 2 * E_STAR * AT, np.sqrt(2 * np.pi * 0.03 * AT / E_STAR)
    )
    assert_allclose((delta, P), formulas.jkr(AT, E_STAR, R, 0.03))


def test_adhesive() -> None:
    """D, T, H, V of a paraboloid at unit modulus, with all moduli times E*."""
    (D, H), T = formulas.hertz(AT, 1.0, R), np.sqrt(2 * np.pi * AT)
    adhesive = formulas.adhesive((D, T, H, 2 * AT * T), E_STAR, math.sqrt(0.03 / E_STAR))
    assert_allclose(adhesive, formulas.jkr(AT, E_STAR, R, 0.03))


def test_device_factors() -> None:
    four, s, v, k = (
        np.array([3e-6, 2e-6, 4e-3, 5e-3]),
        np.array([2.0, 3.0]),
        np.array([0.1, 0.0]),
        np.array([40.0, 7.0]),
    )
    delta, P = formulas.adhesive(four[:, None], s, v)
    assert_allclose(formulas.device_factors(s, v, k) @ four, np.stack([delta + P / k, P], 1))


def test_punch_of_range() -> None:
    """The stress of Dugdale's annulus, sigma on a < r < R and (2 sigma/pi) arctan(sqrt((R^2 - a^2)/(a^2 - r^2))) within
    a, leaves the end flat, z0 open at the rim, and carries the force; at the ends Kendall's, and w/z0 everywhere."""
    R, a, sigma, E_star = 1.0, 0.7, 3.0, 50.0

    def stress(s: float) -> float:
        return sigma if s >= a else 2 * sigma / math.pi * math.atan(math.sqrt((R**2 - a**2) / (a**2 - s**2)))

    def raised(r: float) -> float:
        """4/(pi E*) int p s/(r + s) K(m) ds, m = 4 r s/(r + s)^2."""
        parts = sorted({0.0, r, a, R})
        whole = sum(quad(lambda s: stress(s) * s / (r + s) * ellipk(4 * r * s / (r + s) ** 2), low, high, limit=200)[0]
                    for low, high in pairwise(parts))  # fmt: skip
        return 4 / (math.pi * E_star) * whole

    inside = [raised(r) for r in (0.1, 0.4, 0.65)]
    assert inside == pytest.approx([inside[0]] * 3, rel=1e-6)
    gap = inside[0] - raised(R)
    force = quad(lambda s: 2 * math.pi * s * stress(s), 0, a)[0] + sigma * math.pi * (R**2 - a**2)
    assert formulas.punch_of_range(R, sigma * gap, E_star, gap) == pytest.approx(force, rel=1e-6)
    kendall = math.sqrt(8 * math.pi * 0.05 * E_star * R**3)
    assert formulas.punch_of_range(R, 0.05, E_star, 1e-8) == pytest.approx(kendall, rel=1e-6)
    assert formulas.punch_of_range(R, 0.05, E_star, 10.0) == pytest.approx(math.pi * R**2 * 0.05 / 10.0, rel=1e-12)


def test_tabor() -> None:
    """Tabor's own: the neck at pull-off over the range, of a neck (w^2 R/E*^2)^(1/3)."""
    assert formulas.tabor(R, 0.05, E_STAR, 3e-10) == pytest.approx((0.05**2 * R / E_STAR**2) ** (1 / 3) / 3e-10)


# ---------------------------------------------------------------------- gravity
def test_over_hertz() -> None:
    """What a heavier body changes is proportional to its density, but for its logarithm; nothing without weight."""
    load, slope = formulas.over_hertz(1e-4, 1e3, 1000.0)
    x = 4 * 1000 * 9.80665 * 1e-4 / 1e3
    assert load == pytest.approx(x / math.pi * (19 / 12 - math.log(x) - 0.5772156649))
    assert slope == pytest.approx(4 / 3 * load - x / (3 * math.pi))
    assert formulas.over_hertz(1e-4, 1e3, 1e-9)[0] < 1e-10


def test_over_jkr() -> None:
    """A fourth of e = 4 rho g a/(pi E*)."""
    assert formulas.over_jkr(1e-4, 1e3, 1000.0) == pytest.approx(1000 * 9.80665 * 1e-4 / (math.pi * 1e3))


# ---------------------------------------------------------------------- capillary bridges
def test_kelvin_radius() -> None:
    """Water at 20 degrees and a relative humidity of 0.5: 0.77 nm (Israelachvili)."""
    assert formulas.kelvin_radius(0.0728, 0.5) == pytest.approx(0.78e-9, rel=0.02)


def test_capillary() -> None:
    """Between wetting plates w = 2 gamma, the force of a sphere 4 pi gamma R at contact (Israelachvili)."""
    tension, work = formulas.capillary(0.0728, 1e-9, (0.0, 0.0))
    assert (tension, work) == pytest.approx((0.0728 / 1e-9, 2 * 0.0728))
    assert formulas.capillary(0.0728, 1e-9, (math.pi / 3, math.pi / 3))[1] == pytest.approx(0.0728)


def test_displacement() -> None:
    """-Ci(z) cos(z) - (Si(z) - pi/2) sin(z), from first contact of the edge to far away."""
    z = np.append(np.geomspace(1e-9, 1e6, 4001), [math.nextafter(2, 0), 2.0])
    sine, cosine = sici(z)
    assert_allclose(
        formulas.displacement(z), -cosine * np.cos(z) - (sine - math.pi / 2) * np.sin(z), rtol=0, atol=4e-15
    )
    far = z[z > 300]  # there the sum of both cancels; 1/z^2 - 6/z^4 + 120/z^6
    assert_allclose(formulas.displacement(far), (1 - 6 / far**2 * (1 - 20 / far**2)) / far**2, rtol=1e-11)


def test_logarithm() -> None:
    assert float(formulas.logarithm(np.array(1.0), 2 / math.e)) == pytest.approx(1 + np.euler_gamma)


def test_stiffness() -> None:
    a, kappa, e = 1e-4, 1e-6, 1e-6
    (S, dS), (above, _), (below, _) = (formulas.stiffness(a * (1 + x), E_STAR, kappa) for x in (0, e, -e))
    assert dS == pytest.approx((above - below) / (2 * e * a), rel=1e-7)
    assert formulas.stiffness(a, E_STAR, 1e-20)[0] == pytest.approx(2 * E_STAR * a)
    assert S > 2 * E_STAR * a


def test_wetting_radius() -> None:
    """The lowest load of a drop: P(a) = 2 pi Ups (a^2/R ... ) is least, -pi w R, where a^2 = w R^2/(2 Ups)."""
    a = formulas.wetting_radius(R, 0.05, 0.02)
    assert 2 * 0.02 * a**2 / R**2 == pytest.approx(0.05)


def test_edge_angle() -> None:
    """Young and Dupre: w = Ups (1 - cos(theta)) for small angles."""
    theta = brentq(lambda x: 0.02 * (1 - math.cos(x)) - 1e-6, 1e-6, 1)
    assert formulas.edge_angle(1e-6, 0.02) == pytest.approx(theta, rel=1e-4)

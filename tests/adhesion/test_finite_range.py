"""Adhesion of finite range: Maugis' closed form, values of layers, identities, limits, refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from maugis import Maugis

import jkrcli as jkr
from jkrcli.adhesion.finite_range import FiniteRangeBody, FiniteRangeCurve, finite_range_curve
from jkrcli.adhesion.law import Range
from jkrcli.adhesion.stability import behaviour, branch
from jkrcli.methods.integral.equation import DiscreteEquation
from jkrcli.methods.integral.quadrature import Panels
from jkrcli.methods.layered.contact import LayeredContact

HALF_SPACE = jkr.Specimen((), jkr.HalfSpace(jkr.Elastic(1 - 0.3**2, 0.3)))  # E* = 1
LOAD, DISPLACEMENT = 0.0, math.inf


def layer(nu: float, bonded: bool = True) -> jkr.Specimen:
    """One layer, h = 1, E* = 1."""
    return jkr.Specimen((jkr.Layer(jkr.Elastic(1 - nu**2, nu), 1.0),), jkr.Rigid(bonded))


COATING = jkr.Specimen((jkr.Layer(jkr.Elastic(1 - 0.4**2, 0.4), 1.0),), jkr.HalfSpace(jkr.Elastic(10.0, 0.25)))


def solved(specimen: jkr.Specimen, R: float, a: float, points: int = 100) -> jkr.Solution:
    return jkr.solve(jkr.Problem(jkr.Paraboloid(R), specimen, jkr.Loading("radius", a, points)), "layered")


def curve_of(specimen: jkr.Specimen, R: float, a: float, w: float, mu: float, points: int = 100) -> FiniteRangeCurve:
    """The curve of a body of E* = 1 for mu = sigma (R/(E*^2 w))^(1/3)."""
    return finite_range_curve(solved(specimen, R, a, points), w, stress=mu * (w / R) ** (1 / 3))


def force(curve: FiniteRangeCurve, R: float) -> float:
    """-P_min/(pi w R) under load control."""
    point = curve.pull_off(LOAD)
    assert not isinstance(point, jkr.Unknown), point
    return -point.P / (math.pi * curve.w * R)


@pytest.mark.parametrize("lam", [0.01, 0.1, 1.0, 7.0, 50.0])
def test_half_space_is_the_closed_form_of_maugis(lam: float) -> None:
    exact = Maugis(1.0, 1.0, 1e-6, lam, 1 + np.geomspace(1e3, 1e-6, 41))
    problem = jkr.Problem(jkr.Paraboloid(1.0), HALF_SPACE, jkr.Loading.given("radius", tuple(exact.a)))
    curve = finite_range_curve(jkr.solve(problem, "layered"), exact.w, stress=exact.stress)
    rows = np.searchsorted(curve.touching.a, exact.a * (1 - 1e-12))
    for name in ("a", "c", "delta", "P"):
        ours, theirs = getattr(curve.touching, name)[rows], getattr(exact, name)
        assert np.max(np.abs(ours - theirs)) < 1e-12 * np.max(np.abs(theirs)), name  # measured: 8e-15


VALUES = {0.05: 1.981444, 0.1: 1.950595, 0.2: 1.880474, 0.5: 1.718245, 1.0: 1.600735, 2.0: 1.534603, 5.0: 1.506350}


@pytest.mark.parametrize("lam", VALUES)
def test_pull_off_of_the_half_space_between_dmt_and_jkr(lam: float) -> None:
    R, w, K = 1.0, 1e-6, 4 / 3
    curve = finite_range_curve(
        solved(HALF_SPACE, R, 3 * (math.pi * w * R**2 / K) ** (1 / 3)),
        w,
        stress=lam / 2 * (math.pi * w * K**2 / R) ** (1 / 3),
    )
    assert force(curve, R) == pytest.approx(VALUES[lam], abs=6e-7)


LAYERS = [  # nu, q = w R^2/(E* h^3), mu, -P_min/(pi w R), a/h, c/h: three computations agree on these digits
    (0.3, 1, 0.3, 1.982055, 0.554, 2.6195),
    (0.3, 1, 1, 1.893768, 1.113, 1.66494),
    (0.3, 1, 3, 1.811069, 1.387, 1.46900),
    (0.3, 1, 10, 1.795308, 1.434, 1.44182),
    (0.499, 100, 1, 2.089937, 1.844, 6.80848),
    (0.499, 100, 3, 2.360242, 3.469, 4.51138),
    (0.499, 100, 10, 2.336444, 4.254, 4.29213),
]


@pytest.mark.parametrize(("nu", "q", "mu", "pulled", "a", "c"), LAYERS)
def test_pull_off_of_bonded_layers(nu: float, q: float, mu: float, pulled: float, a: float, c: float) -> None:
    R = 1000.0
    curve = curve_of(layer(nu), R, 5.0, q / R**2, mu)
    point = curve.pull_off(LOAD)
    assert isinstance(point.c, float)
    assert force(curve, R) == pytest.approx(pulled, abs=6e-7)
    assert point.a == pytest.approx(a, abs=6e-4)
    assert point.c == pytest.approx(c, abs=6e-5)
    assert curve.doubts == ()


def test_incompressible_layer_pulls_harder_than_either_limit() -> None:
    short, middle, long = (force(curve_of(layer(0.499), 1000.0, 5.0, 1e-4, mu), 1000.0) for mu in (60, 3, 0.3))
    assert middle > max(short, long) + 0.02


BODIES = {"half-space": HALF_SPACE, "nu = 0.3": layer(0.3), "nu = 1/2": layer(0.5), "coating": COATING}


@pytest.mark.parametrize("name", BODIES)
def test_short_range_goes_to_jkr_like_one_over_the_tabor_number_squared(name: str) -> None:
    solution = solved(BODIES[name], 100.0, 4.0)
    w = 1e-4
    jkr_force = -jkr.transform(solution, w).pull_off["load"].P
    excess = []
    for mu in (8.0, 16.0, 32.0):
        point = finite_range_curve(solution, w, stress=mu * (w / 100.0) ** (1 / 3)).pull_off(LOAD)
        excess.append(abs(-point.P / jkr_force - 1))
    slopes = np.diff(np.log(excess)) / math.log(2)
    assert excess[-1] < 2e-3
    assert (slopes < -1.0).all(), slopes


@pytest.mark.parametrize("name", BODIES)
def test_long_range_goes_to_a_rigid_sphere(name: str) -> None:
    """P_H - 2 pi w R at every radius, and with it the pull-off force, in proportion to mu."""
    w, R = 1e-5, 100.0
    whole, off = 2 * math.pi * w * R, []
    for mu in (0.04, 0.01):
        curve = curve_of(BODIES[name], R, 1.0, w, mu)
        off.append(float(np.max(np.abs(curve.touching.P - curve.parts.P_H + whole)) / whole))
    assert force(curve, R) == pytest.approx(2.0, rel=2e-3)  # measured: 1e-3 on the half-space
    assert off[1] < 0.3 * off[0] < 0.06, off


@pytest.mark.parametrize("name", BODIES)
def test_load_and_displacement_change_together_as_a_flat_end_and_its_annulus_say(name: str) -> None:
    """dP = S d(delta) - 2 pi c sigma (1 - u_a(c)) dc along the curve; u_a of a flat end by other nodes."""
    R, w, specimen = 100.0, 1e-4, BODIES[name]
    curve = curve_of(specimen, R, 3.0, w, 1.0)
    for a in (0.4, 1.1, 2.3):
        c = curve.place_of(a)
        ddelta, dP = curve.rates(np.array(c))
        S, outside = flat_end(specimen, R, a, c)
        bulk, rim = S * ddelta, 2 * math.pi * c * curve.law.stress * outside
        assert abs(dP - (bulk - rim)) < 1e-8 * (abs(bulk) + abs(rim)), (a, c)  # measured: 3e-9


def flat_end(specimen: jkr.Specimen, R: float, a: float, c: float) -> tuple[float, float]:
    """S [N/m] of a flat end of radius a, and 1 - u(c) of the surface outside where it is pressed by 1."""
    contact = LayeredContact(jkr.Paraboloid(R), specimen)
    radii = np.array([a])
    panels = Panels.through(radii, contact.plan(radii, 1e-10))
    kernel = contact.spectrum.kernel(a + c)
    equation = DiscreteEquation.of(kernel, panels)
    phi = equation.density(0, np.ones(panels.x.size))
    x, v = np.polynomial.legendre.leggauss(40)
    psi = math.acos(a / c) * (x + 1) / 2
    beyond = 2 / math.pi * (1 - kernel(c * np.cos(psi), panels.x) @ (panels.w * phi))
    return math.pi * contact.E_star * panels.w @ phi, math.acos(a / c) / 2 * v @ beyond


@pytest.mark.parametrize("name", BODIES)
def test_curve_is_smooth_where_the_surfaces_first_touch(name: str) -> None:
    curve = curve_of(BODIES[name], 100.0, 2.0, 1e-4, 0.5)
    c0 = float(curve.touching.c[0])
    before, after = (np.array(curve.at(np.array(c0 * x))) for x in (1 - 1e-7, 1 + 1e-7))
    assert np.allclose(before, after, rtol=1e-5)
    left, right = (np.array(curve.rates(np.array(c0 * x))) for x in (1 - 1e-4, 1 + 1e-4))
    assert np.allclose(left, right, rtol=2e-2)
    assert curve.point(0.0).delta == -curve.law.length


def test_change_of_units() -> None:
    length, load = 1e-6, 1e-3
    near = curve_of(layer(0.4), 100.0, 2.0, 1e-4, 1.0)
    modulus = load / length**2
    specimen = jkr.Specimen((jkr.Layer(jkr.Elastic((1 - 0.4**2) * modulus, 0.4), length),), jkr.Rigid())
    far = finite_range_curve(solved(specimen, 100 * length, 2 * length), 1e-4 * load / length,
                             stress=near.law.stress * modulus)  # fmt: skip
    assert np.allclose(far.places, near.places * length, rtol=1e-9, atol=0)
    assert np.allclose(far.delta, near.delta * length, rtol=1e-8, atol=1e-12 * length)
    assert np.allclose(far.P, near.P * load, rtol=1e-7, atol=1e-10 * load)


def test_bodies_jump_together_before_they_touch() -> None:
    """At delta = -range; a compliant body is drawn into contact, a stiff one into an attraction without touch."""
    near, far = (behaviour(curve_of(layer(0.3), 1000.0, 5.0, 1e-6, mu), DISPLACEMENT).jump_in for mu in (10, 0.3))
    assert near.a > 0
    assert far.a == 0
    assert far.c > 0
    assert far.delta == pytest.approx(-1e-6 / (0.3 * 1e-9 ** (1 / 3)), rel=1e-14)


def test_branches_begin_unstable_and_end_stable() -> None:
    words = branch(curve_of(layer(0.3), 1000.0, 5.0, 1e-6, 1.0))
    assert (words[1], words[-1]) == ("unstable", "stable")


def test_interpolation_between_the_points_stays_within_what_is_stated() -> None:
    R, w = 1000.0, 1e-6
    coarse, fine = (curve_of(layer(0.3), R, 5.0, w, 1.0, points) for points in (30, 240))
    for ours, theirs in zip(coarse.at(fine.places), fine.at(fine.places), strict=True):
        unit = np.maximum(np.abs(theirs), abs(theirs.min()))
        assert np.max(np.abs(ours - theirs) / unit) < coarse.interpolation_error + fine.interpolation_error


def test_one_of_stress_and_range_is_given_and_positive() -> None:
    with pytest.raises(jkr.InputError, match="give either stress or range"):
        Range.of(0.1, stress=1e6, length=1e-9)
    with pytest.raises(jkr.InputError, match="give either stress or range"):
        Range.of(0.1)
    with pytest.raises(jkr.InputError, match=r"^w: must be > 0 J/m\^2, got 0$"):
        Range.of(0.0, stress=1e6)
    with pytest.raises(jkr.InputError, match=r"^stress: must be > 0 Pa, got -1e\+06$"):
        Range.of(0.1, stress=-1e6)
    assert Range.of(0.1, length=1e-9).stress == pytest.approx(1e8)


def test_finite_elements_have_no_kernel() -> None:
    problem = jkr.Problem(jkr.Paraboloid(1.0), HALF_SPACE, jkr.Loading("radius", 0.1, 10))
    with pytest.raises(jkr.Refusal, match="the method fem does not have: solve the case with the method layered"):
        FiniteRangeBody.of(jkr.solve(problem, "fem"))


def test_attraction_beyond_the_side_of_a_cylinder_is_refused() -> None:
    specimen = jkr.Specimen((jkr.Layer(jkr.Elastic(1e6, 0.3), 5e-6),), jkr.Rigid(), 5e-6, "free")
    problem = jkr.Problem(jkr.Paraboloid(10e-6), specimen, jkr.Loading("radius", 4e-6, 10))
    with pytest.raises(jkr.Refusal, match=r"beyond the side of the cylinder .* give a larger stress"):
        finite_range_curve(jkr.solve(problem), 0.05, stress=1e4)


def test_python_interface_takes_a_tension() -> None:
    solution = solved(layer(0.3), 1000.0, 5.0)
    result = jkr.transform(solution, 1e-6, stress=1e-3)
    assert -result.pull_off["load"].P / (math.pi * 1e-6 * 1000.0) == pytest.approx(1.893768, abs=6e-7)
    assert list(jkr.table(result))[-1] == "c_m"

"""Adhesion of finite range: Maugis' closed form, values of layers, identities, limits, refusals."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from maugis import Maugis, finite_range_curve
from scipy.optimize import brentq
from uncontacted import Uncontacted

import jkrcli as jkr
from jkrcli.adhesion.curve import CriticalPoint, Equilibrium, position
from jkrcli.adhesion.device_path import Jump, cycle, stability_under
from jkrcli.adhesion.finite_range import AttractedBody, FiniteRangeBody, FiniteRangeCurve, Range
from jkrcli.base.units import show
from jkrcli.methods.integral.finite_range import AttractedSurface, Rims, attracted_surface
from jkrcli.series import Solution

HALF_SPACE = jkr.Specimen((), jkr.HalfSpace(jkr.Elastic(1 - 0.3**2, 0.3)))  # E* = 1
LOAD, DISPLACEMENT = 0.0, math.inf


def layer(nu: float, bonded: bool = True) -> jkr.Specimen:
    return jkr.Specimen((jkr.Layer(jkr.Elastic(1 - nu**2, nu), 1.0),), jkr.Rigid(bonded))


COATING = jkr.Specimen((jkr.Layer(jkr.Elastic(1 - 0.4**2, 0.4), 1.0),), jkr.HalfSpace(jkr.Elastic(10.0, 0.25)))


@cache
def solved(specimen: jkr.Specimen, R: float, a: float, points: int = 100) -> Solution:
    return jkr.solve(jkr.Problem(jkr.Paraboloid(R), specimen, jkr.Loading("radius", a, points)), "layered")


@cache
def curve_of(specimen: jkr.Specimen, R: float, a: float, w: float, mu: float, points: int = 100) -> FiniteRangeCurve:
    """The curve of a body of E* = 1 for mu = sigma (R/(E*^2 w))^(1/3)."""
    return finite_range_curve(solved(specimen, R, a, points), w, stress=mu * (w / R) ** (1 / 3))


def force(curve: FiniteRangeCurve, R: float) -> float:
    point = curve.pull_off(LOAD)
    assert not isinstance(point, jkr.Unknown), point
    return -point.P / (math.pi * curve.w * R)


@pytest.mark.parametrize("lam", [0.1, 7.0])
def test_half_space_is_the_closed_form_of_maugis(lam: float) -> None:
    exact = Maugis(1.0, 1.0, 1e-6, lam, 1 + np.geomspace(1e3, 1e-6, 41))
    problem = jkr.Problem(jkr.Paraboloid(1.0), HALF_SPACE, jkr.Loading.given("radius", tuple(exact.a)))
    curve = finite_range_curve(jkr.solve(problem, "layered"), exact.w, stress=exact.stress)
    rows = np.searchsorted(curve.touching.a, exact.a * (1 - 1e-12))
    for name in ("a", "c", "delta", "P"):
        ours, theirs = getattr(curve.touching, name)[rows], getattr(exact, name)
        assert np.max(np.abs(ours - theirs)) < 1e-12 * np.max(np.abs(theirs)), name  # measured: 8e-15


LAYERS = [  # nu, q = w R^2/(E* h^3), mu, -P_min/(pi w R), a/h, c/h: three computations agree on these digits
    (0.3, 1, 0.3, 1.982055, 0.554, 2.6195),
    (0.499, 100, 3, 2.360242, 3.469, 4.51138),
    (0.3, 1, 1, 1.893768, 1.113, 1.66494),
    (0.3, 1, 3, 1.811069, 1.387, 1.46900),
    (0.3, 1, 10, 1.795308, 1.434, 1.44182),
    (0.499, 100, 1, 2.089937, 1.844, 6.80848),
    (0.499, 100, 10, 2.336444, 4.254, 4.29213),
]


@pytest.mark.first(2)
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


def attracted(curve: FiniteRangeCurve, nu: float, R: float) -> Uncontacted:
    return Uncontacted(nu, R, curve.law.stress, curve.law.length)


def test_surfaces_on_the_ridge_come_together_without_contact() -> None:
    curve = curve_of(layer(0.499), 1000.0, 8.0, 1e-4, 3.4)
    jump_in, exact = stability_under(curve, DISPLACEMENT).jump_in, attracted(curve, 0.499, 1000.0)
    assert not isinstance(jump_in, jkr.Unknown)
    assert jump_in.a == 0
    c = brentq(lambda c: exact.delta(c) - curve.onset, 1.5, 3.0)
    assert jump_in.c == pytest.approx(c, rel=1e-7)
    assert jump_in.P == pytest.approx(exact.P(c), rel=1e-7)


def test_contact_on_the_ridge_is_lost_next_to_where_radii_of_attraction_leap() -> None:
    """Where c falls as the contact grows the gap opens no more: delta, P and c are stationary together."""
    curve = curve_of(layer(0.499), 1000.0, 8.0, 1e-4, 3.6)
    point = curve.pull_off(DISPLACEMENT)
    assert isinstance(point, CriticalPoint), point
    assert (point.a, point.delta) == (pytest.approx(1.612, abs=2e-3), pytest.approx(-4.801e-3, rel=2e-4))
    step = np.array([-1e-3, 0.0, 1e-3]) * point.a + point.place
    delta, P = curve.at(step)
    for column in (delta, P, curve.attracted_radii(step)):
        assert np.max(np.abs(np.diff(column))) < 1e-4 * np.abs(column[1]), column


def test_contact_on_the_ridge_that_shrinks_to_nothing_lets_go_later() -> None:
    curve = curve_of(layer(0.499), 1000.0, 8.0, 1e-4, 3.4)
    lost, exact = curve.pull_off(DISPLACEMENT), attracted(curve, 0.499, 1000.0)
    assert isinstance(lost, jkr.Unknown)
    c = brentq(lambda c: exact.rate(c, math.inf), 0.2, 0.7)
    words = f"ends at P = {show(exact.P(c), 'load')}, delta = {show(exact.delta(c), 'length')}"
    assert words in lost.reason
    assert "lost without a jump" in lost.reason


def test_several_radii_of_attraction_are_told() -> None:
    """At first touch of a layer on the ridge three radii c belong to a = 0; further in there is one."""
    law = Range.of(1e-4, stress=3.5 * (1e-4 / 1000) ** (1 / 3))
    held = FiniteRangeBody.of(solved(layer(0.499), 1000.0, 8.0)).body
    attraction, s = held.attraction(held.reach(8.0, 2 * law.stress, law.length)), 2 * law.stress
    found = []
    for a in (0.0, 4.0):
        discs = attraction.discs(np.array([a]))
        rims = discs.equilibria(s, law.length, attraction.reach)
        found.append(discs.doubt(rims, s, law.length, attraction.reach))
    assert found == ["there is more than one radius to which the surfaces may attract each other", None]


BODIES = {"half-space": HALF_SPACE, "nu = 0.3": layer(0.3), "nu = 1/2": layer(0.5), "coating": COATING}


@pytest.mark.first(1)
@pytest.mark.parametrize("name", BODIES)
def test_short_range_goes_to_jkr_like_one_over_the_tabor_number_squared(name: str) -> None:
    solution, w = solved(BODIES[name], 100.0, 4.0), 1e-4
    sharp = jkr.transform(solution, w).curve
    beyond = sharp.a > 1.0
    off = []
    for mu in (16.0, 32.0, 64.0):
        curve = finite_range_curve(solution, w, stress=mu * (w / 100.0) ** (1 / 3))
        rows = np.searchsorted(curve.touching.a, sharp.a * (1 - 1e-12))
        changes = [np.max(np.abs(getattr(curve.touching, name)[rows] - getattr(sharp, name))[beyond]
                          / np.max(np.abs(getattr(sharp, name)))) for name in ("delta", "P")]  # fmt: skip
        off.append([*changes, abs(curve.pull_off(LOAD).P / sharp.pull_off(LOAD).P - 1)])
    rates = np.diff(np.log(off), axis=0) / math.log(2)
    assert np.allclose(rates, -2, atol=0.03), rates  # measured: within 0.02
    assert np.max(off[-1]) < 3e-4


@pytest.mark.first(1)
@pytest.mark.parametrize("name", BODIES)
def test_ranges_that_are_next_to_none_are_solved_up_to_rounding(name: str) -> None:
    """Separations were differences of nearly equal numbers and became 0/0: a gel at a range of 0.1 nm was refused."""
    solution, w = solved(BODIES[name], 100.0, 4.0), 1e-4
    sharp = jkr.transform(solution, w).curve
    curve = finite_range_curve(solution, w, stress=3e5 * (w / 100.0) ** (1 / 3))
    assert curve.pull_off(LOAD).P == pytest.approx(sharp.pull_off(LOAD).P, rel=2e-9)  # measured: 4e-10
    assert not curve.doubts
    for mu in (1e8, 1e20):
        with pytest.raises(jkr.Refusal, match="which is adhesion without a range: leave stress and range out"):
            finite_range_curve(solution, w, stress=mu * (w / 100.0) ** (1 / 3))


def test_long_range_goes_to_a_rigid_sphere_while_it_ends_on_a_cylinder() -> None:
    """2 pi w R, and P_H - 2 pi w R as far as a is small against c, which comes near the side."""
    L, R, w, off = 1.3, 100.0, 3.5e-8, []
    specimen = replace(layer(0.3), radius=L, side="free")
    solution = jkr.solve(jkr.Problem(jkr.Paraboloid(R), specimen, jkr.Loading("radius", 0.05, 20)), "hybrid")
    whole = 2 * math.pi * w * R
    for mu in (0.04, 0.01):
        curve = finite_range_curve(solution, w, stress=mu * (w / R) ** (1 / 3))
        held = float(np.max(np.abs(curve.touching.P - curve.parts.P_H + whole)) / whole)
        off.append([held, 2 - force(curve, R)])
    assert 0.7 * L < curve.touching.c[-1] < L
    assert np.all(np.array(off[0]) < 0.02)  # measured: 0.013 and 0.015, then 0.0046 and 0.0012
    assert np.all(np.array(off[1]) < 0.45 * np.array(off[0])), off
    with pytest.raises(jkr.Refusal, match="beyond the side of the cylinder"):
        finite_range_curve(solution, w, stress=0.004 * (w / R) ** (1 / 3))


@pytest.mark.first(2)
@pytest.mark.parametrize("stiffness", [0.7, DISPLACEMENT])
@pytest.mark.parametrize("name", BODIES)
def test_energy_of_a_loop_is_what_its_jumps_lose(name: str, stiffness: float) -> None:
    """Elastic, interface and device's energy before and after each jump, by pressure and gap on the surface."""
    curve = curve_of(BODIES[name], 100.0, 4.0, 1e-4, 3.0)
    loop = cycle(curve, curve, stiffness)
    lost = 0.0
    for jump in (
        Jump(Equilibrium(0.0, curve.onset, 0.0, 0.0), loop.begin),
        *loop.approach.jumps,
        *loop.retraction.jumps,
    ):
        lost += energy(curve, jump.start, stiffness) - (0.0 if jump.end is None else energy(curve, jump.end, stiffness))
    assert len(loop.retraction.jumps) == 1
    assert lost == pytest.approx(loop.energy_lost, rel=1e-7)  # measured: 4e-9


def energy(curve: FiniteRangeCurve, state: Equilibrium, stiffness: float) -> float:
    """int p u/2 over the surface, interface and spring of a state; 0 where nothing attracts."""
    if state.c == 0:
        return 0.0
    r, weights, found = surface_of(curve, state)
    u = state.delta - curve.problem.indenter.f(r) + found.gap
    touching, law = r < state.a, curve.law
    assert weights @ found.pressure == pytest.approx(state.P, rel=1e-8)
    interface = np.where(touching, law.w, law.stress * (law.length - found.gap))
    return float(weights @ (found.pressure * u / 2 - interface)) + state.P**2 / (2 * stiffness)


def surface_of(curve: FiniteRangeCurve, state: Equilibrium) -> tuple[np.ndarray, np.ndarray, AttractedSurface]:
    """Radii on disc and annulus, weights of integrals over the surface, pressure and gap there."""
    x, v = np.polynomial.legendre.leggauss(60)
    x, v = (x + 1) / 2, v / 2
    a, c = state.a, state.c
    inner, outer = a * (1 - x**2)[::-1], a + (c - a) * x**2  # both have a root at a
    weights = 4 * math.pi * np.concatenate([(inner[::-1] * a * x * v)[::-1], outer * (c - a) * x * v])
    r, body = np.concatenate([inner, outer]), AttractedBody(curve.problem)
    return r, weights, attracted_surface(body.attraction(1.3 * c), a, curve.law.stress, curve.law.length, r, body.scale)


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


def test_attraction_up_to_the_end_of_a_profile_is_refused_in_words() -> None:
    table = jkr.TableProfile((0.0, 4e-6, 8e-6, 8.2e-6), (0.0, 0.4e-6, 1.6e-6, 1.681e-6))
    body = jkr.Specimen((jkr.Layer(jkr.Elastic(1e6, 0.3), 5e-6),), jkr.Rigid())
    solution = jkr.solve(jkr.Problem(table, body, jkr.Loading("radius", 8.1e-6, 20)))
    with pytest.raises(jkr.Refusal, match=r"beyond the end of the profile .* give a larger stress"):
        finite_range_curve(solution, 0.05, length=1e-7)


@pytest.mark.first(1)
@pytest.mark.parametrize("length", [2e-8, 2e-9])
def test_a_flat_end_has_its_kinks_where_contact_or_attraction_reach_its_edge(length: float) -> None:
    """Against states on panels half as wide, and in the least of a polynomial through such."""
    edge = 4e-6
    body = jkr.Specimen((jkr.Layer(jkr.Elastic(1e6, 0.45), 8e-6),), jkr.Rigid())
    solution = jkr.solve(jkr.Problem(jkr.RoundedFlat(edge, 1e-6), body, jkr.Loading("radius", 8e-6, 60)), "layered")
    curve = finite_range_curve(solution, 0.05, length=length)
    s, exact = 2 * curve.law.stress / curve.problem.E_star, FiniteRangeBody.of(solution).body.check(1.2e-5)

    def at(a: np.ndarray) -> Rims:
        return exact.discs(a).equilibria(s, length, exact.reach)

    lost = curve.pull_off(math.inf)
    assert [point.kind for point in curve.critical(math.inf)] == ["minimum"]
    beside = lost.a * (1 + 1e-4 * np.array([-1.0, 0.0, 1.0]))
    states, stated = at(beside), curve.point_error(lost, math.inf)
    assert states.delta[1] == min(states.delta)
    assert abs(states.delta[1] - lost.delta) <= stated["delta"] < 1e-7 * abs(lost.delta)
    assert abs(states.P[1] - lost.P) <= stated["P"] + 1e-9 * abs(lost.P)
    assert stated["P"] < 1e-6 * abs(lost.P)
    pulled = curve.pull_off(0.0)
    x = 1e-3 * np.cos(np.pi * np.arange(7) / 6)
    fit = np.polynomial.Chebyshev.fit(x, at(np.sort(pulled.a * (1 + x))).P[::-1], 6)
    least = float(fit(np.real(fit.deriv().roots()[np.argmin(np.abs(fit.deriv().roots()))])))
    assert abs(pulled.P - least) <= curve.point_error(pulled, 0.0)["P"] + 1e-9 * abs(least)
    assert curve.point_error(pulled, 0.0)["P"] < 1e-6 * abs(least)


def test_pull_off_where_the_attracted_radius_falls_as_the_contact_grows() -> None:
    """Flat ends whose attraction reaches beyond their rounded edges: against the least of states on other panels."""
    bodies = (
        (jkr.RoundedFlat(1e-6, 0.6e-6), jkr.Elastic(1e6, 0.45), 1e-6, True, 1.4e-6, (40354.7, 621.4465e-9)),
        (jkr.RoundedFlat(1.12031242e-3, 0.010270514374), jkr.Elastic(11708.980728416, 0.49823320984), 1.34594297868e-4,
         False, 1.3433535877e-3, (3.62506637, 4.74949053e-7 / 3.62506637)),
    )  # fmt: skip
    for indenter, material, h, bonded, a, (stress, length) in bodies:
        body = jkr.Specimen((jkr.Layer(material, h),), jkr.Rigid(bonded))
        solution = jkr.solve(jkr.Problem(indenter, body, jkr.Loading("radius", a, 60)), "layered")
        ranged, law = FiniteRangeBody.of(solution), Range(stress, length)
        curve = ranged.curve(law, 10.0)
        assert curve.complete
        exact = ranged.body.check(ranged.body.reach(a, 2 * stress / curve.problem.E_star, length))
        for control in (LOAD, DISPLACEMENT, 10.0):
            point = curve.pull_off(control)
            assert isinstance(point, CriticalPoint), point
            beside = point.a * (1 + np.array([-0.02, -1e-3, 0.0, 1e-3, 0.02]))
            states = exact.discs(beside).equilibria(2 * stress / curve.problem.E_star, length, exact.reach)
            held = position(states.delta, states.P, control)
            assert held[2] == min(held)
            stated = curve.point_error(point, control)
            assert abs(states.P[2] - point.P) <= stated["P"] < 1e-7 * abs(point.P)
            assert abs(states.delta[2] - point.delta) <= stated["delta"]


WITHOUT = [(0.1, 10.0, 0.499, math.inf), (0.03, 3.0, 0.5, 0.5), (0.3, 1.0, 0.0, math.inf), (0.1, 100.0, 0.3, 8.0)]


@pytest.mark.first(2)
@pytest.mark.parametrize(("mu", "q", "nu", "stiffness"), WITHOUT)
def test_pull_off_without_contact_is_that_of_a_constant_tension(
    mu: float, q: float, nu: float, stiffness: float
) -> None:
    """Tabor numbers mu, q = w R^2/(E* h^3); against an explicit formula; first touch, too."""
    R, w = 100.0, q / 100.0**2
    length = (R * w**2 / mu**3) ** (1 / 3)
    exact = Uncontacted(nu, R, w / length, length)
    curve = FiniteRangeBody.of(solved(layer(nu), R, 2.0, 60)).curve(Range.of(w, length=length), stiffness)
    assert curve.touching.c[0] == pytest.approx(exact.touch, rel=1e-10)
    point, (_, delta, P) = curve.pull_off(stiffness), exact.lost(stiffness)
    assert point.a == 0
    stated = curve.point_error(point, stiffness)
    assert abs(point.P - P) <= stated["P"] < 1e-7 * abs(P)
    assert abs(point.delta - delta) <= stated["delta"] < 1e-7 * abs(delta)


def test_a_jump_to_no_contact_is_pull_off_although_the_surfaces_then_part_smoothly() -> None:
    """A cone in a soft device jumps from a = 154 nm to a = 0, where a weak attraction is left that goes to zero."""
    body = jkr.Specimen((jkr.Layer(jkr.Elastic(1e6, 0.45), 1e-6),), jkr.Rigid())
    cone = jkr.PowerLaw(1 / math.tan(math.radians(75)), 1.0)
    law, k = Range.of(0.0085802509, length=3.8301361e-7), 0.40626957
    solution = jkr.solve(jkr.Problem(cone, body, jkr.Loading("radius", 1.2e-6, 60)), "layered")
    means = stability_under(FiniteRangeBody.of(solution).curve(law, k), k)
    assert means.pull_off.P == pytest.approx(-174.77e-9, rel=1e-4)
    assert means.pull_off.a == pytest.approx(154.4e-9, rel=1e-3)
    lost = means.partial[-1]
    assert lost.end.a == 0
    assert means.jump_in.delta == pytest.approx(-law.length, rel=1e-5)
    assert 0 < means.energy_lost < means.separation


def test_what_a_table_leaves_open_is_part_of_the_error() -> None:
    """Of a sphere at 20 points: 1.4 to 12 times the true error where contact is lost."""
    body = jkr.Specimen((jkr.Layer(jkr.Elastic(1e6, 0.45), 8e-6),), jkr.Rigid())
    sphere, r = jkr.Sphere(2e-5), np.linspace(0, 1.8e-5, 20)
    table = jkr.TableProfile(tuple(r.tolist()), tuple(sphere.f(r).tolist()))
    loading = jkr.Loading("radius", 1e-5, 20)
    solution = jkr.solve(jkr.Problem(table, body, loading), "layered")
    law = Range.of(0.05, length=2e-8)
    curve, exact = (
        FiniteRangeBody(problem, solution.series, AttractedBody(problem)).curve(law)
        for problem in (jkr.Problem(table, body, loading), jkr.Problem(sphere, body, loading))
    )
    for control in (LOAD, DISPLACEMENT):
        found, true = curve.pull_off(control), exact.pull_off(control)
        assert isinstance(found, CriticalPoint)
        assert isinstance(true, CriticalPoint)
        stated = curve.point_error(found, control)
        for name in ("delta", "P"):
            off = abs(getattr(found, name) - getattr(true, name))
            assert 1e-7 * abs(getattr(true, name)) < off <= stated[name] <= 20 * off, (control, name)


def test_the_gap_is_no_strain() -> None:
    """Displacement control, contact lost while nothing touches: delta is the gap there, the surface moves little."""
    specimen = jkr.Specimen((jkr.Layer(jkr.Elastic(1e6, 0.499), 1e-6),), jkr.Rigid())
    problem = jkr.Problem(jkr.Paraboloid(1e-4), specimen, jkr.Loading("radius", 4e-6, 60))
    result = jkr.transform(jkr.solve(problem), 1.3315597e-3, length=464.1589e-9)
    point = result.pull_off["displacement"]
    assert point.a == 0
    assert point.delta == pytest.approx(-464.4e-9, rel=1e-3)
    assert abs(result.curve.surface_displacement(point)) < 1e-9
    assert result.large_strains(point) is None

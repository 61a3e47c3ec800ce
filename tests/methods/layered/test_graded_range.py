"""Adhesion of finite range where the modulus changes over depth, against elasticity solved another way."""

import math

import numpy as np
import pytest
from graded_annulus import Contact, Stack, apart
from maugis import Maugis
from scipy.special import k0

import jkrcli as jkr
from jkrcli.adhesion.finite_range import AttractedBody, FiniteRangeBody, Range
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.methods.integral.finite_range import attracted_surface
from jkrcli.methods.integral.logarithm import LogarithmicAttraction
from jkrcli.methods.layered.spectrum import compliance
from studies.graded_judge import graded_ranged

R, S = 20.0, 0.1


def linear(top: float, bottom: float, h: float = 1.0):
    return lambda z: top + (bottom - top) * z / h


def body(tau, reach: float, widest: float = 0.5) -> LogarithmicAttraction:
    return LogarithmicAttraction(Paraboloid(R), 1.0, tau, reach, 10, widest)


def test_the_compliance_is_that_of_elasticity() -> None:
    k = np.geomspace(1e-2, 300, 7)
    below = jkr.Specimen(
        (jkr.Layer(jkr.Elastic(1.0, 0.4), 1.0), jkr.Layer(jkr.Graded(jkr.Linear(3.0, 1.0, 1.0), 0.3), 1.0)),
        jkr.HalfSpace(jkr.Elastic(5.0, 0.25)),
    )
    stack = Stack([(1.0, np.ones_like, 0.4), (1.0, linear(3, 1), 0.3)], (5.0, 0.25))
    assert compliance(below, k)[0] == pytest.approx(stack.compliance_ratio(k), rel=1e-10)  # 1e-11 was seen


@pytest.mark.parametrize(("a", "c"), [(0.3, 0.32), (2.0, 3.0)])
def test_states_under_a_logarithm_are_those_of_another_discretisation(a: float, c: float) -> None:
    def tau(s):
        return -2.0 * k0(np.maximum(3.0 * s, 1e-13))

    found = body(tau, 1.2 * c).discs(np.array([a])).rims(np.array([c - a]), S)
    exact = Contact(R, 1.0, tau, a, 32).state(c, S)
    assert [found.delta[0], found.P[0], found.gap[0]] == pytest.approx(exact, rel=1e-8)  # 1e-9 was seen


def test_without_a_kernel_it_is_maugis() -> None:
    exact = Maugis(R, 1.0, 1e-3, 0.5, np.array([1.01, 1.3, 2.0]))
    discs = body(np.zeros_like, 1.2 * float(exact.c.max())).discs(exact.a)
    rims = discs.equilibria(2 * exact.stress, exact.w / exact.stress, discs.body.reach)
    for name in ("c", "delta", "P"):
        assert getattr(rims, name) == pytest.approx(getattr(exact, name), rel=1e-10)


def test_nothing_touches_under_a_logarithm() -> None:
    def tau(s):
        return -2.0 * k0(np.maximum(3.0 * s, 1e-13))

    found = body(tau, 1.0).apart(np.array([0.7]), S, 0.03)
    assert [found.delta[0], found.P[0]] == pytest.approx(apart(R, 1.0, tau, 0.7, S, 0.03), rel=1e-8)


def curve(top: float, bottom: float, radius: float, *devices: float):
    specimen = jkr.Specimen((jkr.Layer(jkr.Graded(jkr.Linear(top, bottom, 1e-6), 0.4), 1e-6),), jkr.Rigid())
    problem = jkr.Problem(jkr.Paraboloid(20e-6), specimen, jkr.Loading("radius", radius, 40))
    found = FiniteRangeBody(problem, jkr.solve(problem).series, AttractedBody(problem))
    return found.curve(Range.of(5e-3, length=30e-9), *devices)


@pytest.mark.slow
def test_the_load_at_a_fold_does_not_depend_on_the_largest_radius() -> None:
    found = [curve(1e6, 3e6, radius).pull_off(math.inf) for radius in (0.6e-6, 1e-6, 4e-6)]
    assert [point.P for point in found] == pytest.approx([-71.784e-9] * 3, abs=0.004e-9)


@pytest.mark.slow
def test_the_pressure_adds_up_to_the_load_beyond_two_thicknesses() -> None:
    a, state = 2.5e-6, curve(1e6, 3e6, 2.6e-6)
    held = AttractedBody(state.problem)
    u, weights = np.polynomial.legendre.leggauss(60)
    angle = (u + 1) * math.pi / 4  # r = a sin(angle): crowded at the edge
    law, r = state.law, a * np.sin(angle)
    surface = attracted_surface(held.ready(3.5e-6), a, law.stress, law.length, r, held.scale)
    inside = math.pi / 4 * weights @ (2 * math.pi * a**2 * np.sin(angle) * np.cos(angle) * surface.pressure)
    around = math.pi * law.stress * (surface.rims.c[0] ** 2 - a**2)
    assert inside - around == pytest.approx(surface.rims.P[0], rel=2e-4)  # 4e-5 was seen at 2 um


@pytest.mark.slow
def test_a_steep_law_is_solved() -> None:
    found = curve(1e6, 10e6, 3e-6)
    assert np.max(found.errors["P"]) < 1e-7 * np.max(np.abs(found.P))  # 4e-9 was seen


@pytest.mark.slow
@pytest.mark.parametrize("number", [0, 1])
def test_stated_errors_of_graded_bodies_hold(number: int) -> None:
    found = graded_ranged(np.random.default_rng(number))
    assert len(found) > 4
    for name, ratio, stated, _ in found:
        assert ratio <= 1, name
        assert stated < 1e-6 or name == "graded seconds"

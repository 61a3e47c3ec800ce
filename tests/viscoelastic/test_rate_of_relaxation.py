"""The law w(v) of a crack in a solid that relaxes, and the course that it gives."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jkrcli as jkr
from jkrcli.bodies.problem import Prony, StandardSolid
from jkrcli.viscoelastic.relaxing_adhesion import CrackRate, RateLawCourse, creep

PRONY = Prony((0.4, 0.3), (0.2, 3.0))


def test_the_creep_function_of_a_standard_solid() -> None:
    J_inf, c, q = creep(StandardSolid(0.1, 2.0).modes(1.0))
    assert (J_inf, c[0], q[0]) == (pytest.approx(10), pytest.approx(9), pytest.approx(0.05))


def test_creep_undoes_relaxation() -> None:
    """int_0^t r(t - s) dJ(s) = 1."""
    modes = PRONY.modes(1.0)
    J_inf, c, q = creep(modes)
    x, weights = np.polynomial.legendre.leggauss(60)
    for t in (0.1, 1.0, 7.0):
        s = t / 2 * (x + 1)
        rate = np.exp(-np.multiply.outer(s, q)) @ (c * q)
        whole = modes(t) * (J_inf - c.sum()) + t / 2 * weights @ (modes(t - s) * rate)
        assert whole == pytest.approx(1.0, rel=1e-10)


@pytest.mark.parametrize("law", [StandardSolid(0.1, 2.0), PRONY], ids=["sls", "prony"])
def test_the_law_rises_from_w_to_w_over_the_ratio(law: StandardSolid | Prony) -> None:
    """And its speed is the inverse of its work; with times tau times as long speeds are tau times less."""
    crack = CrackRate(0.05, 3.0, 10.0, law.modes(1.0))
    ratio = law.relaxed
    assert ratio is not None
    ends = crack.work(0.05, np.array([1e-15, 1e15]))
    np.testing.assert_allclose(ends, [0.05, 0.05 / ratio], rtol=1e-4)
    v = np.geomspace(1e-6, 10, 30)
    w = crack.work(0.05, v)
    assert (np.diff(w) > 0).all()
    np.testing.assert_allclose([crack.speed(0.05, x - 0.05) for x in w], v, rtol=1e-6)
    assert crack.speed(0.05, 1.0) == math.inf


def test_a_slow_crack_of_a_standard_solid() -> None:
    """w/G against the integral of the opening by another rule."""
    crack, ratio = CrackRate(0.05, 3.0, 10.0, StandardSolid(0.1, 2.0).modes(1.0)), 0.1
    for v in (1e-3, 0.1, 3.0):
        G = float(crack.work(0.05, v))
        L = math.pi * ratio * 10.0 * G / (4 * 9.0)
        theta = (np.arange(20_000) + 0.5) / 20_000 * math.pi / 2
        y = np.sin(theta) ** 2
        opens = np.arctanh(np.sqrt(y)) * 2 * np.sin(theta) * np.cos(theta)
        behind = 1 - (1 - ratio) * np.exp(-(1 - y) * L / v * ratio / 2.0)
        assert 0.05 / G == pytest.approx(float(np.mean(opens * behind)) * math.pi / 2, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("speed", "force", "deeper"), [(0.1, 0.25, 4.0), (1.0, 0.05, 6.0)])
def test_a_rate_law_tells_the_force_and_not_the_depth(speed: float, force: float, deeper: float) -> None:
    """The withdrawal from rest of the published values, lambda = 3: the depth is several times too large."""
    half_space = jkr.Specimen((), jkr.HalfSpace(jkr.Elastic(10.0, 0.0)), relaxation=StandardSolid(0.1, 1.0))
    solved = jkr.solve(jkr.Problem(jkr.Paraboloid(1.0), half_space, jkr.Loading("radius", 2.0, 60, "log")))
    cycled = jkr.cycle_relaxing(solved, speed=speed, w=0.05, stress=0.98, rest_depth=0.0, compare_rate=True)
    law = cycled.rate
    assert isinstance(law, RateLawCourse), law
    assert abs(law.force_difference) < force
    assert law.history.pull_off.delta < deeper * cycled.pull_off.delta < 0
    assert not law.enough
    assert "a rate law does not apply" in "\n".join(cycled.words())
    assert {"rate_a_m", "rate_delta_m", "rate_P_N"} <= set(cycled.columns)
    assert cycled.summary()["rate_law"]["P_relative_difference"] == law.force_difference

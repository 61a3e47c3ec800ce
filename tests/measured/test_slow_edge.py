"""The slow edge of a retraction against the values of a time integration made apart, and its limits."""

import math

import numpy as np
import pytest

from jkrcli.adhesion.slopes import slopes
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Loading, Problem, Specimen
from jkrcli.measured.branches import Branches, branch, rest
from jkrcli.measured.force_curve import load_at, receding
from jkrcli.measured.forward_model import FittedBody
from jkrcli.methods.layered.solver import Layered


@pytest.fixture(scope="module")
def family():
    """Half-space and paraboloid of E* = R = 1."""
    problem = Problem(Paraboloid(1.0), Specimen((), HalfSpace(Elastic(0.75, 0.5))), Loading("radius", 3.0, 200))
    series = Layered()(problem).series
    return FittedBody.of(problem, series, slopes(series), extensible=True).family


# w0 = v0 = 1, the device moved back at the speed V from equilibrium at P = 0: -P_min/pi (Runge and Kutta over time).
@pytest.mark.parametrize(
    ("n", "k", "V", "expected"),
    [(0.6, math.inf, 1e-3, 1.515478), (0.6, math.inf, 0.1, 1.733807), (0.6, math.inf, 10.0, 4.196531),
     (0.6, 1.0, 1e-2, 1.556731), (0.6, 1.0, 1.0, 2.153421), (0.25, math.inf, 1e-2, 1.887319),
     (0.25, math.inf, 1.0, 2.681615)],
)  # fmt: skip
def test_pull_off_at_a_speed(family, n, k, V, expected):
    a = (4.5 * math.pi) ** (1 / 3)  # JKR at P = 0
    turn = a**2 - math.sqrt(2 * math.pi * a)
    held = rest(family, 1.0, 1.0, 1.0, k, turn)
    assert math.exp(held.u) == pytest.approx(a, rel=1e-7)
    z, P = receding(family, 1.0, 1.0, k, (V**n, n), held, turn)
    i = int(np.argmin(P))
    lowest = np.polynomial.Polynomial.fit(z[i - 2 : i + 3], P[i - 2 : i + 3], 4)
    assert -lowest(lowest.deriv().roots().real).min() / math.pi == pytest.approx(expected, rel=5e-4)
    assert (np.diff(z) > 0).all()


def test_a_very_slow_edge_is_that_of_jkr_and_a_resting_one_rests(family):
    advanced, w, k, turn = 0.5, 1.0, 2.0, 6.0
    held = rest(family, 1.0, advanced, math.sqrt(w), k, turn)
    path = receding(family, 1.0, w, k, (1e-9, 0.5), held, turn)
    jkr = branch(family, 1.0, w, k)
    z = np.linspace(jkr.fold + 0.05, held.end - 0.01, 50)
    moving = Branches.of([(family, 1.0, w, k)]).at(np.zeros(z.size, dtype=int), z, np.zeros(1))
    np.testing.assert_allclose(load_at(path, held, turn, z), moving[0], atol=2e-3)
    above = np.linspace(held.end, turn, 5)
    np.testing.assert_allclose(load_at(path, held, turn, above), held.at(above)[0], rtol=1e-12)
    assert load_at(path, held, turn, np.array([path[0][0] - 1.0])) == 0


def test_loads_are_smooth_where_the_edge_begins(family):
    """Rows that pass from rest to motion as w grows would make minima where there are none."""
    turn, z = 6.0, np.linspace(0, 6.0, 400)
    works = 1.2 + 0.1 * np.linspace(0, 1, 41)
    held = [rest(family, 1.0, 1.0, math.sqrt(w), 2.0, turn) for w in works]
    loads = [load_at(receding(family, 1.0, w, 2.0, (0.5, 0.4), one, turn), one, turn, z)
             for w, one in zip(works, held, strict=True)]  # fmt: skip
    bends = np.diff(np.sum(np.square(loads), axis=1), 2)
    assert np.abs(np.diff(bends)).max() < 0.05 * np.abs(bends).max()

"""Piecewise cubics, bracketed zeros, distributions and the median against SciPy and NumPy."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly, CubicHermiteSpline, CubicSpline, PchipInterpolator
from scipy.optimize import brentq
from scipy.special import fdtrc, fdtri, stdtrit

from jkrcli.base.numerics import (
    Array,
    PiecewiseCubic,
    PiecewiseQuintic,
    cubic_spline,
    f_quantile,
    f_tail,
    median,
    pchip,
    rising_slopes,
    zeros_between,
)

few = settings(max_examples=25, deadline=None)
steps = st.lists(st.floats(0.02, 50.0), min_size=1, max_size=30)


@few
@given(steps, st.integers(0, 2**32 - 1))
def test_the_cubic_spline_is_that_of_scipy(step: list[float], seed: int) -> None:
    x = np.cumsum([0.0, *step])
    y = np.random.default_rng(seed).normal(size=x.size)
    at, theirs = np.linspace(x[0], x[-1], 7), CubicSpline(x, y)
    ours = cubic_spline(x, y)
    assert ours(at) == pytest.approx(theirs(at), rel=1e-9, abs=1e-9 * np.max(np.abs(theirs(at))))
    assert float(ours(at[3])) == ours(at)[3]  # at one place, too


def test_splines_side_by_side_are_those_of_each_column() -> None:
    x, y = np.cumsum([0.0, 1.0, 0.2, 3.0, 0.5]), np.random.default_rng(1).normal(size=(5, 2, 3))
    ours, at = cubic_spline(x, y), np.linspace(-0.1, 5.0, 9)
    for order in range(3):
        assert ours(at, order) == pytest.approx(CubicSpline(x, y)(at, order), rel=1e-12, abs=1e-12)
        assert ours.derivative(order)(at) == pytest.approx(ours(at, order), rel=1e-15)


@few
@given(steps, st.integers(0, 2**32 - 1), st.sampled_from([np.array, np.sort, np.round, np.exp]))
@example([16.0, 0.02, 16.0], 0, np.array)
def test_monotone_cubics_are_those_of_scipy(step: list[float], seed: int, shape: Callable[[Array], Array]) -> None:
    x = np.cumsum([0.0, *step])
    y = shape(np.random.default_rng(seed).normal(size=x.size))
    at = np.linspace(x[0] - 0.01, x[-1] + 0.01, 17)
    inside = np.concatenate([x[:-1] + 1e-9 * np.diff(x), x[1:] - 1e-9 * np.diff(x)])  # round-off is of the largest
    for order in range(3):
        expected, ends = (PchipInterpolator(x, y)(places, order) for places in (at, inside))
        size = max(np.abs(expected).max(), np.abs(ends).max())
        assert pchip(x, y)(at, order) == pytest.approx(expected, rel=1e-9, abs=1e-10 * size)


@few
@given(steps, st.integers(0, 2**32 - 1))
def test_values_and_slopes_between_and_beyond_the_knots(step: list[float], seed: int) -> None:
    chance = np.random.default_rng(seed)
    x = np.cumsum([0.0, *step])
    y, dydx = chance.normal(size=(2, x.size, 2))
    ours, theirs = PiecewiseCubic(x, y, dydx), CubicHermiteSpline(x, y, dydx)
    wanted = chance.uniform(x[0] - 0.01, x[-1] + 0.01, (4, 3))
    for order in (0, 1):
        assert ours(wanted, order) == pytest.approx(theirs(wanted, order), rel=1e-9, abs=1e-10)
        assert ours(x[0], order) == pytest.approx((y, dydx)[order][0])
    assert ours.c == pytest.approx(theirs.c)


@few
@given(steps, st.integers(0, 2**32 - 1))
def test_quintics_and_their_two_derivatives(step: list[float], seed: int) -> None:
    chance = np.random.default_rng(seed)
    x = np.cumsum([0.0, *step])
    y = chance.normal(size=(3, x.size))
    ours, theirs = PiecewiseQuintic(x, *y), BPoly.from_derivatives(x, y.T)
    wanted = chance.uniform(x[0], x[-1], 5)
    for order in range(3):
        expected = theirs(wanted, order)
        assert ours(wanted, order) == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(theirs(x, order)).max())


def test_slopes_between_close_knots_do_not_hold_the_errors_of_values() -> None:
    x = np.array([0.7, 0.7 + 1e-6])
    y = np.sin(x) + np.array([1e-12, -1e-12])
    quintic = PiecewiseQuintic(x, y, np.cos(x), -np.sin(x), close=1e-3)
    for order, expected in ((1, np.cos), (2, lambda x: -np.sin(x))):
        assert quintic(x.mean(), order) == pytest.approx(expected(x.mean()), abs=1e-9)
    assert quintic(x[0]) == pytest.approx(y[0], abs=1e-15)


def test_between_close_knots_are_quartics_whatever_the_values() -> None:
    x, y = np.array([-0.3, 0.9]), np.array([0.2, -7.0])
    quintic = PiecewiseQuintic(x, y, 4 * x**3 - x, 12 * x**2 - 1, close=2.0)
    inside = np.linspace(-0.3, 0.89, 7)
    assert quintic(inside, 1) == pytest.approx(4 * inside**3 - inside, abs=1e-13)
    assert quintic(inside, 2) == pytest.approx(12 * inside**2 - 1, abs=1e-12)


HARD: dict[str, tuple[Callable[[Array], Array], float, float]] = {
    "smooth": (lambda x: np.cos(x) - x**3, 0.0, 5.0),
    "steep": (lambda x: np.exp(50 * x) - 3, -1.0, 1.3),
    "flat": (lambda x: (x - 0.5) ** 9, 0.0, 1.3),
    "vertical": (lambda x: np.sign(x - 0.3) * np.abs(x - 0.3) ** 0.2, 0.0, 1.0),
    "a jump": (lambda x: np.where(x < 1 / 3, -1.0, 2.0), 0.0, 1.0),
    "falling": (lambda x: 1e-12 * (math.pi - x), 0.0, 100.0),
    "at an end": (lambda x: x - 1.0, 0.0, 1.0),
}


@pytest.mark.parametrize("name", HARD)
def test_a_zero_is_found_to_the_tolerance(name: str) -> None:
    function, low, high = HARD[name]
    expected = brentq(lambda x: float(function(np.array(x))), low, high, xtol=1e-15, rtol=1e-14, maxiter=1000)
    assert zeros_between(function, np.array([low]), np.array([high]), 1e-14)[0] == pytest.approx(expected, abs=1e-13)


def test_many_zeros_are_found_at_once() -> None:
    asked = []

    def function(x: Array) -> Array:
        asked.append(x.size)
        return np.sin(x)

    edges = math.pi * (np.arange(100) + 0.3)
    found = zeros_between(function, edges[:-1], edges[1:], 1e-14)
    assert found == pytest.approx(math.pi * np.arange(1, 100), rel=1e-14)
    assert len(asked) < 20
    alone = [zeros_between(np.sin, edges[i : i + 1], edges[i + 1 : i + 2], 1e-14)[0] for i in (0, 40, 98)]
    assert found[[0, 40, 98]].tolist() == alone  # whatever else is sought beside it


@few
@given(st.lists(st.tuples(st.floats(1e-6, 1e3), st.floats(1e-6, 1e3), st.floats(-1e6, 1e6)), min_size=3, max_size=20))
def test_a_cubic_with_rising_slopes_rises_whatever_the_slopes_were(steps: list[tuple[float, float, float]]) -> None:
    width, height, slopes = np.array(steps).T
    x, y = np.cumsum(width), np.cumsum(height)
    cubic = CubicHermiteSpline(x, y, rising_slopes(x, y, slopes))
    between = cubic((x[:-1, None] + np.diff(x)[:, None] * np.linspace(0, 1, 21)).ravel())
    assert (np.diff(between) >= -1e-9 * (y[-1] - y[0])).all()


DOF = [1.0, 2.0, 3.5, 10.0, 57.0, 300.0, 2000.3, 1e5]
LOST = 1e-9  # theory: of a difference of gamma functions' logs of 1e5, 1e6 epsilon


@pytest.mark.parametrize("k", [1, 7])
@pytest.mark.parametrize("dof", DOF)
def test_tails_of_f(k: int, dof: float) -> None:
    F = np.concatenate([[0.0], np.geomspace(1e-8, 600, 40), [math.inf, math.nan]])
    assert f_tail(k, dof, F) == pytest.approx(fdtrc(k, dof, F), rel=LOST, abs=1e-290, nan_ok=True)


@pytest.mark.parametrize(("dof", "F"), [(0.0, 1.0), (-1.0, 1.0), (math.nan, 1.0), (10.0, 1e-320), (10.0, 1e308)])
def test_ends_of_the_range(dof: float, F: float) -> None:
    assert float(f_tail(1, dof, F)) == pytest.approx(float(fdtrc(1, dof, F)), nan_ok=True)
    assert math.isnan(f_quantile(1, dof, 0.95)) == (not dof > 0)


def test_degrees_of_freedom_of_each() -> None:
    dof, F = np.array([3.0, 10.0, 1000.0]), np.array([2.0, math.nan, 4.0])
    assert f_tail(1, dof, F) == pytest.approx(fdtrc(1, dof, F), rel=LOST, nan_ok=True)


@pytest.mark.parametrize("level", [0.5, 0.95, 1 - 1e-9])
@pytest.mark.parametrize("dof", DOF)
def test_quantiles(dof: float, level: float) -> None:
    for k in (1, 2, 7, 30):
        assert f_quantile(k, dof, level) == pytest.approx(fdtri(k, dof, level), rel=LOST)
    # 1 - level has round-off in the one-sided chance
    assert math.sqrt(f_quantile(1, dof, level)) == pytest.approx(stdtrit(dof, (1 + level) / 2), rel=1e-6)


@few
@given(st.lists(st.floats(-1e9, 1e9), min_size=1, max_size=40))
def test_the_median_is_that_of_numpy(values: list[float]) -> None:
    x = np.array(values)
    assert median(x) == pytest.approx(float(np.median(x)), rel=1e-15, abs=0)
    assert x.tolist() == values
    assert math.isnan(median(np.zeros(0)))

"""The banded smoothing spline against brute force, SciPy and its own definition."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline, make_smoothing_spline

from jkrcli.adhesion.slopes.loocv import linear_fit, smoothing_spline
from jkrcli.base.errors import InputError


def uneven(n: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Uneven abscissae, a noisy curve and random weights."""
    generator = np.random.default_rng(seed)
    x = np.cumsum(0.3 + generator.random(n))
    return x, np.sin(6 * x / x[-1]) + 0.05 * generator.standard_normal(n), 0.5 + generator.random(n)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("exact_start", [False, True])
def test_left_out_residuals_are_those_of_refits(seed: int, exact_start: bool) -> None:
    x, y, weights = uneven(25, seed)
    if exact_start:
        weights[0] = np.inf
    spline = smoothing_spline(x, y, weights)
    width = np.ptp(x) / (x.size - 1)
    for i in range(1, x.size - 1):  # at the ends the refit extrapolates
        rest = np.arange(x.size) != i
        ratio = width / (np.ptp(x[rest]) / (x.size - 2))  # lambda is in units of the mean spacing, cubed
        refit = smoothing_spline(x[rest], y[rest], weights[rest], spline.smoothing_lambda * ratio**3)
        assert y[i] - refit(x[i]) == pytest.approx(spline.left_out[i], abs=1e-12)  # round-off; ordinates are of size 1


def test_score_is_the_mean_square_of_the_left_out_residuals() -> None:
    x, y, weights = uneven(30, 5)
    spline = smoothing_spline(x, y, weights)
    assert spline.score * np.ptp(y) ** 2 == pytest.approx(np.mean(weights * spline.left_out**2), rel=1e-12)


@pytest.mark.parametrize("criterion", ["loocv", "gcv"])
def test_lambda_minimises_the_score_on_a_continuous_range(criterion: str) -> None:
    x, y, weights = uneven(40, 1)
    best = smoothing_spline(x, y, weights, criterion=criterion)
    for factor in (0.8, 0.95, 1.05, 1.25):  # well above the tolerance 1e-4 of log(lambda)
        other = smoothing_spline(x, y, weights, best.smoothing_lambda * factor, criterion)
        assert other.score > best.score


def test_same_spline_as_scipy_for_a_given_lambda() -> None:
    x, y, weights = uneven(50, 2)
    width = np.ptp(x) / (x.size - 1)
    ours = smoothing_spline(x, y, weights, smoothing_lambda=3.0)
    theirs = make_smoothing_spline(x / width, y, weights, lam=3.0)
    assert np.allclose(ours.g, theirs(x / width), rtol=0, atol=1e-10)  # SciPy's normal equations cost it some digits
    assert np.allclose(ours(x, 1) * width, theirs(x / width, 1), rtol=0, atol=1e-9)


def test_tiny_lambda_interpolates_and_huge_lambda_fits_a_line() -> None:
    x, y, weights = uneven(30, 3)
    natural = CubicSpline(x, y, bc_type="natural")
    between = np.linspace(x[0], x[-1], 97)
    assert np.allclose(smoothing_spline(x, y, weights, 1e-8)(between), natural(between), atol=1e-6)  # O(lambda)
    line = np.polyfit(x, y, 1, w=np.sqrt(weights))
    assert np.allclose(smoothing_spline(x, y, weights, 1e13).g, np.polyval(line, x), atol=1e-6)  # O(n^4/lambda)


def test_infinite_weight_is_met_exactly() -> None:
    x, y, weights = uneven(20, 4)
    weights[[0, 7]] = np.inf
    spline = smoothing_spline(x, y, weights)
    assert spline(x[[0, 7]]) == pytest.approx(y[[0, 7]], rel=1e-14)


def test_derivatives_are_those_of_the_values() -> None:
    x, y, weights = uneven(20, 6)
    spline = smoothing_spline(x, y, weights)
    at, step = np.linspace(x[0] - 1, x[-1] + 1, 41), 1e-5
    slope = (spline(at + step) - spline(at - step)) / (2 * step)
    bend = (spline(at + step, 1) - spline(at - step, 1)) / (2 * step)
    assert np.allclose(slope, spline(at, 1), atol=1e-9)  # second-order difference of step 1e-5
    assert np.allclose(bend, spline(at, 2), atol=1e-4)  # first order where the third derivative jumps


def test_linear_fit_repeats_the_spline() -> None:
    x, y, weights = uneven(20, 7)
    spline = smoothing_spline(x, y, weights)
    g, slope = linear_fit(spline, weights, np.column_stack([y, -2 * y]))
    assert np.allclose(g[:, 1], -2 * spline.g, atol=1e-13)
    assert np.allclose(slope[:, 0], spline(x, 1), atol=1e-12)


@settings(max_examples=20, deadline=None)
@given(st.floats(-12, 12), st.floats(-12, 12))
def test_change_of_units(log_length: float, log_force: float) -> None:
    length, force = 10.0**log_length, 10.0**log_force
    x, y, weights = uneven(25, 8)
    plain, scaled = smoothing_spline(x, y, weights), smoothing_spline(x * length, y * force, weights)
    # lambda comes from a minimum: round-off in the score moves it by the root of round-off, the fit by less
    assert scaled.smoothing_lambda == pytest.approx(plain.smoothing_lambda, rel=1e-5)
    assert np.allclose(scaled.g / force, plain.g, rtol=0, atol=1e-7)


@pytest.mark.parametrize(
    ("x", "y", "message"),
    [
        ([1, 2, 3], [1, 2, 3], "needs at least 4 points, got 3"),
        ([1, 2, 2, 3], [1, 2, 3, 4], "x must increase, point 3 is 2 after 2"),
        ([1, 2, 3, 4], [1, 2, np.nan, 4], "must be finite"),
    ],
)
def test_wrong_data_are_refused(x: list[float], y: list[float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        smoothing_spline(np.array(x, dtype=float), np.array(y, dtype=float))


def test_bounds_of_the_smoothing_parameter() -> None:
    """A noisy straight line takes all smoothing there is, a smooth curve without noise takes none."""
    x, noise = np.arange(40.0), np.random.default_rng(1).standard_normal(40)
    assert smoothing_spline(x, 2 * x + noise).at_bound == "upper"
    assert smoothing_spline(x, np.sin(x / 4) ** 3).at_bound == "lower"
    assert smoothing_spline(x, np.sin(x / 6) + 0.1 * noise).at_bound is None

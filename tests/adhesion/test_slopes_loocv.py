"""The paper's slopes: what they give on exact series, what they refuse, and the choice between methods."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, make_smoothing_spline

from jkrcli.adhesion.curve import transform
from jkrcli.adhesion.rules import slopes_function
from jkrcli.adhesion.slopes import slopes
from jkrcli.adhesion.slopes.loocv import linear_fit, loocv, smoothing_spline
from jkrcli.base.errors import InputError, Refusal
from jkrcli.formulas import hertz, thin_incompressible_layer, thin_incompressible_slopes, thin_layer
from jkrcli.series import Series
from studies.noise_cells import noisy

E_STAR, R, W = 5e9 / 0.84, 1e-4, 50.0


def half_space(points: int, exact: bool = False) -> Series:
    a = np.linspace(0, 1.73e-5, points + 1)[1:]
    delta, P = hertz(a, E_STAR, R)
    return Series(a, delta, P, *((2 * E_STAR * a, np.full(points, 2 * E_STAR)) if exact else ()))


def test_exact_slopes_are_those_of_the_series() -> None:
    series = half_space(10, exact=True)
    found = slopes(series)
    assert found.method == "exact"
    assert found.reason == "the solution carries exact slopes"
    assert np.array_equal(found.S, series.S)
    assert np.array_equal(found.dS, series.dS)
    with pytest.raises(Refusal, match="carries no exact S and dS/da; use the slopes 'integral' or 'loocv'"):
        slopes(half_space(10), "exact")


def test_pull_off_of_the_papers_half_space() -> None:
    found = transform(half_space(60), slopes(half_space(60), "loocv"), W).pull_off(0.0)
    # noise-free: only the spline through P(delta) errs, where P ~ delta^1.5 begins
    assert abs(found.P / (-1.5 * np.pi * W * R) - 1) < 1e-6


@pytest.mark.parametrize("rule", ["loocv", "gcv"])
def test_kept_slopes_are_those_of_the_cubic_spline(rule: str) -> None:
    """The paper's default keeps S = dP/d(delta) of the interpolating spline; S' is the same either way."""
    exact = half_space(60)
    raw = noisy(exact, 1e-4, 3)
    series = Series(raw.a, raw.delta, raw.P)
    kept, smooth = slopes_function(f"{rule}-kept")(series), slopes_function(rule)(series)
    ours = CubicSpline(np.append(0, series.delta), np.append(0, series.P), bc_type="not-a-knot")(series.delta, 1)
    np.testing.assert_allclose(kept.S, ours, rtol=1e-9)
    np.testing.assert_array_equal(kept.dS, smooth.dS)
    assert np.max(np.abs(kept.S / smooth.S - 1)) > 1e-4
    assert "S kept from the cubic spline" in kept.reason
    assert "S re-evaluated by the smoothing spline" in smooth.reason


def test_between_the_rows_kept_slopes_add_nothing_to_the_rows() -> None:
    """S of the cubic spline is not the integral of S': what lies between rows must not be bent to make it so."""
    exact = half_space(60)
    raw = noisy(exact, 1e-5, 1)
    series = Series(raw.a, raw.delta, raw.P)
    curve = transform(series, slopes_function("loocv-kept")(series), W)
    assert curve.pull_off(0.0).P == pytest.approx(curve.P.min(), rel=1e-3)


def test_kept_slopes_err_within_their_own_band_on_noise() -> None:
    """95 % bands of the pull-off force: at least 6 of 10 noisy series, judged without "integral" beside them."""
    exact, held = half_space(60), 0
    truth = -1.5 * np.pi * W * R
    for seed in range(10):
        raw = noisy(exact, 1e-5, seed)
        series = Series(raw.a, raw.delta, raw.P)
        curve = transform(series, slopes(series, "loocv-kept"), W)
        point = curve.pull_off(0.0)
        held += abs(point.P - truth) <= float(curve.error_at(np.array(point.a))["P"])
    assert held >= 6


def test_a_smoothing_parameter_at_a_bound_is_told() -> None:
    """S of a half-space is a straight line: cross-validation ends at the largest lambda."""
    assert "its upper bound: S(a) is a straight line" in slopes(half_space(60), "loocv").reason
    a = np.linspace(0, 1.73e-5, 61)[1:]
    bent = Series(a, *thin_incompressible_layer(a, 1e9, 1e-6, R))
    assert "its lower bound: S(a) is interpolated, not smoothed" in slopes(bent, "loocv").reason


def test_natural_end_is_flagged_with_its_size() -> None:
    a = np.linspace(0, 1.73e-5, 61)[1:]
    for law, exponent in ((thin_layer(a, 1e15, R), 2), (thin_incompressible_layer(a, 1e9, 1e-6, R), 4)):
        series = Series(a, *law)
        S = exponent * series.P / series.delta * (1 if exponent == 2 else 0.75)
        found = loocv(series)
        error = found.dS[-1] / (exponent * S[-1] / a[-1]) - 1
        assert -0.02 < error < -0.003  # the bias of the natural spline
        assert found.dS_err[-1] > abs(error * found.dS[-1])
        assert len(found.flags) == 1
        flagged = float(found.flags[0].split("about ")[1].split(" %")[0]) / 100
        assert flagged == pytest.approx(abs(error), rel=0.3)  # an estimate from the spline's own curvature
    assert loocv(half_space(60)).flags == ()


def test_slopes_that_are_not_positive_are_refused_with_the_radii() -> None:
    a = np.linspace(0, 1.73e-5, 31)[1:]
    delta, P = hertz(a, E_STAR, R)
    with pytest.raises(
        InputError, match=r"not positive at \d+ of 30 radii \([-+.e0-9, ]+(, \.\.\.)? m\), where Eq. 13"
    ):
        loocv(Series(a, delta, P * (1 + 2e-2 * np.sin(np.pi / 4 * np.arange(30)))))


def test_an_unknown_slope_at_first_touch_is_not_imposed() -> None:
    series = half_space(60)
    free = Series(series.a, series.delta, series.P, S0=None)
    assert loocv(free).S[20] == pytest.approx(2 * E_STAR * series.a[20], rel=1e-2)


def test_estimate_is_no_smaller_than_the_distance_from_the_integral_fit() -> None:
    """A smoothing spline's own estimate misses what the derivative before it did to noisy data."""
    exact = half_space(60)
    raw = noisy(exact, 1e-4, 3)
    series = Series(raw.a, raw.delta, raw.P)
    alone, judged, fitted = slopes_function("loocv")(series), slopes(series, "loocv"), slopes(series, "integral")
    distance = np.quantile(np.abs(np.sqrt(judged.dS / fitted.dS) - 1), 0.9)
    assert judged.error >= distance >= alone.error
    np.testing.assert_array_equal(judged.dS, alone.dS)
    assert slopes(series, "auto").method == "integral"


def test_smoothing_the_slope_of_s_further_takes_a_third_of_its_error_on_a_thin_layer() -> None:
    """S' of an incompressible layer grows as a^4; loads with noise, 10 series, and the stated errors hold."""
    a = half_space(60).a[15:]
    exact = Series(a, *thin_incompressible_layer(a, 1e9, 1e-6, R))
    _, slope = thin_incompressible_slopes(a, 1e9, 1e-6)
    off = {"loocv": list[float](), "loocv-smoothed": list[float]()}
    held = 0
    for seed in range(10):
        raw = noisy(exact, 1e-5, seed)
        for rule, errors in off.items():
            found = slopes_function(rule)(Series(raw.a, raw.delta, raw.P))
            errors.append(float(np.sqrt(np.mean((found.dS / slope - 1)[10:] ** 2))))
            if rule == "loocv-smoothed":
                held += np.count_nonzero(np.abs(found.dS - slope) <= 2 * np.sqrt(found.covariance[:, 3, 3]))
    assert np.median(off["loocv-smoothed"]) < 0.4 * np.median(off["loocv"])  # measured: 0.29
    assert held >= 0.95 * 450


def uneven(n: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    generator = np.random.default_rng(seed)
    x = np.cumsum(0.3 + generator.random(n))
    return x, np.sin(6 * x / x[-1]) + 0.05 * generator.standard_normal(n), 0.5 + generator.random(n)


@pytest.mark.parametrize("exact_start", [False, True])
def test_left_out_residuals_are_those_of_refits(exact_start: bool) -> None:
    x, y, weights = uneven(25, 0)
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


def test_infinite_weight_is_met_exactly() -> None:
    x, y, weights = uneven(20, 4)
    weights[[0, 7]] = np.inf
    spline = smoothing_spline(x, y, weights)
    assert spline(x[[0, 7]]) == pytest.approx(y[[0, 7]], rel=1e-14)


def test_linear_fit_repeats_the_spline() -> None:
    x, y, weights = uneven(20, 7)
    spline = smoothing_spline(x, y, weights)
    g, slope = linear_fit(spline, weights, np.column_stack([y, -2 * y]))
    assert np.allclose(g[:, 1], -2 * spline.g, atol=1e-13)
    assert np.allclose(slope[:, 0], spline(x, 1), atol=1e-12)

"""The transformation and what is read off its curve, against classical JKR and its thin-layer limits."""

import itertools
import math
import re

import numpy as np
import pytest

from jkrcli.adhesion.curve import transform
from jkrcli.adhesion.slopes import Slopes, slopes
from jkrcli.base.errors import InputError, Unknown
from jkrcli.formulas import adhesive_half_space, hertz, rounded_flat, sneddon_sphere
from jkrcli.series import Series

E_STAR, R, W = 5e9 / 0.84, 1e-4, 50.0


def half_space(points: int, largest: float = 1.73e-5, errors: dict | None = None) -> Series:
    a = np.linspace(0, largest, points + 1)[1:]
    delta, P = hertz(a, E_STAR, R)
    return Series(a, delta, P, 2 * E_STAR * a, np.full(points, 2 * E_STAR), errors or {})


def curve(series: Series, w: float = W):
    return transform(series, slopes(series), w)


def test_rates_are_derivatives_of_the_curve() -> None:
    a0 = 1e-6
    a = np.linspace(1.1e-6, 6e-6, 12)
    delta, P = rounded_flat(a, 1e9, a0, 1e-5)
    ours = curve(Series(a, delta, P, 2e9 * a, np.full(12, 2e9), a0=a0, S0=2e9 * a0), 0.5)
    at, step = np.linspace(1.2e-6, 5.9e-6, 31), 1e-11
    higher, lower = ours.at(at + step), ours.at(at - step)
    for rate, up, down in zip(ours.rates(at), higher, lower, strict=True):
        np.testing.assert_allclose(rate, (up - down) / (2 * step), rtol=1e-6)  # difference over 1e-5 of a


def test_several_or_no_critical_points_are_reported_as_such() -> None:
    small = curve(half_space(20, largest=4e-6))
    assert small.critical(0.0) == ()
    reason = small.pull_off(0.0).reason
    assert (
        "the load is lowest at the largest radius of the solution, a = 4 um (P = -16.8 mN, delta = -299.5 nm)" in reason
    )
    assert "increase [loading] radius" in reason
    a = np.linspace(0, 1.73e-5, 301)[1:]
    dS = 2 * E_STAR * (1 + 0.9 * np.sin(a / 4e-7))  # a wavy slope: many minima
    delta, P = hertz(a, E_STAR, R)
    series = Series(a, delta, P, 2 * E_STAR * a, dS)
    wavy = curve(series)
    points = wavy.critical(0.0)
    kinds = [point.kind for point in points]
    assert kinds.count("minimum") >= 3
    assert all(first != second for first, second in itertools.pairwise(kinds))
    assert wavy.pull_off(0.0) == min(points, key=lambda point: point.P)


def test_errors_propagate_to_first_order() -> None:
    series = half_space(30)
    covariance = np.zeros((30, 4, 4))
    plain = Slopes(series.S, series.dS, "exact", 0.0)
    rough = 1e-4 * np.stack([series.delta, series.P, series.S, series.dS])
    generator = np.random.default_rng(0)
    mix = generator.standard_normal((4, 4))
    covariance = np.einsum("in,ik,jk,jn->nij", rough, mix, mix, rough)
    known = transform(series, Slopes(series.S, series.dS, "exact", 0.0, covariance=covariance), W)
    draws = np.einsum("in,ik,kd->ind", rough, mix, generator.standard_normal((4, 4000)))
    samples = []
    for d in range(4000):
        moved = Series(series.a, series.delta + draws[0, :, d], series.P + draws[1, :, d])
        samples.append(transform(moved, Slopes(series.S + draws[2, :, d], series.dS + draws[3, :, d], "x", 0.0), W).P)
    spread = np.std(samples, axis=0)
    # 4000 draws: 1/sqrt(8000) = 1.1 %, 30 points
    np.testing.assert_allclose(known.errors["P"], 1.96 * spread, rtol=0.06)
    assert transform(series, plain, W).errors == {}


def test_errors_of_the_series_reach_the_curve() -> None:
    series = half_space(30)
    rough = half_space(30, errors={"P": 1e-3 * series.P, "dS": 2e-3 * series.dS})
    known = transform(rough, slopes(rough, "exact"), W)
    t = series.delta - known.delta
    expected = np.hypot(1e-3 * series.P, series.S * t * 1e-3)  # dP = S t/2 dS'/S'
    np.testing.assert_allclose(known.errors["P"], expected, rtol=1e-12)
    np.testing.assert_allclose(known.errors["delta"], 1e-3 * t, rtol=1e-12)
    assert known.error_at(series.a[4:5])["P"] == pytest.approx(known.errors["P"][4:5])


def sphere_curve(a: np.ndarray):
    delta, P = sneddon_sphere(a, E_STAR, R)
    return curve(Series(a, delta, P, 2 * E_STAR * a, np.full(a.size, 2 * E_STAR)))


def true_interpolation_error(ours) -> float:
    between = np.linspace(ours.a[0], ours.a[-1], 500)
    true = []
    for found, exact in zip(
        ours.at(between), adhesive_half_space(between, *sneddon_sphere(between, E_STAR, R), E_STAR, W), strict=True
    ):
        unit = np.maximum(np.abs(exact), abs(np.min(exact)))
        true.append(float(np.max(np.abs(found - exact) / unit)))
    return max(true)


@pytest.mark.parametrize("points", [5, 6, 7, 10, 20, 40, 41])
@pytest.mark.parametrize("power", [1.0, 0.5])  # even radii, even depths
def test_interpolation_error_is_of_the_size_of_the_true_one(points: int, power: float) -> None:
    ours = sphere_curve(2.2e-5 * (np.arange(1, points + 1) / points) ** power)
    true = true_interpolation_error(ours)
    assert true / 2.5 < ours.interpolation_error < 80 * true  # 75 of five: no reduction is assumed for few


@pytest.mark.parametrize("points", [20, 21, 40])
def test_interpolation_error_is_told_at_the_last_interval_too(points: int) -> None:
    ours = sphere_curve(np.geomspace(2.2e-9, 2.2e-5, points))  # the widest interval is the last
    assert true_interpolation_error(ours) / 1.2 < ours.interpolation_error


def test_interpolation_error_of_power_laws_is_round_off_and_unknown_for_few_points() -> None:
    assert curve(half_space(30)).interpolation_error < 1e-13
    assert curve(half_space(30), 0.0).interpolation_error < 1e-13
    assert curve(half_space(4)).interpolation_error == Unknown("unknown: fewer than 5 points")
    wide = sphere_curve(np.geomspace(2e-9, 2e-5, 8)).interpolation_error
    assert wide == Unknown("unknown where neighbouring radii differ by more than a factor of 2.7")
    some = sphere_curve(np.append(2e-7, np.linspace(2e-6, 2.2e-5, 60))).interpolation_error
    assert isinstance(some, Unknown)
    assert re.fullmatch(r"unknown where .* of 2\.7 \(up to a = 2 um\), \d\.\de-\d\d elsewhere", some.reason)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: curve(half_space(10), -1.0), "w: must be >= 0 J/m\\^2, got -1"),
        (lambda: curve(half_space(10), math.nan), "w: must be >= 0"),
        (lambda: curve(half_space(10)).critical(-2.0), "stiffness: must be >= 0 N/m .*got -2"),
        (
            lambda: curve(half_space(10)).at(np.array([1.0])),
            "contact radius 1 m lies outside the solution, 1.73e-06 to",
        ),
        (lambda: curve(half_space(1)).at(np.array([1.73e-5])), "a solution of one point has no values between points"),
    ],
)
def test_wrong_requests_are_refused(call, message: str) -> None:
    with pytest.raises(InputError, match=message):
        call()


def test_slopes_that_are_not_positive_are_refused_with_the_radius() -> None:
    series = half_space(10)
    bad = Slopes(series.S, np.where(np.arange(10) == 3, -1.0, series.dS), "exact", 0.0)
    with pytest.raises(InputError, match=r"not positive at 1 radii, first at a = 6\.92e-06 m"):
        transform(series, bad, W)

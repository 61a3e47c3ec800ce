"""Slopes by integration: exact laws, layered bodies, noise, few and many points, quantised radii, flat ends."""

import numpy as np
import pytest

from jkrcli.adhesion.curve import transform
from jkrcli.adhesion.slopes import slopes, smoothed
from jkrcli.adhesion.slopes.integral import LogSplineModel, Shape, correlation_length, integral
from jkrcli.adhesion.slopes.loocv import loocv
from jkrcli.adhesion.slopes.nodes import node_radii
from jkrcli.base.errors import InputError, Refusal
from jkrcli.bodies.problem import Elastic, HalfSpace, Loading, Problem, Specimen
from jkrcli.formulas import hertz, power_law, rounded_flat, thin_incompressible_layer, thin_layer
from jkrcli.methods.layered.solver import Layered
from jkrcli.series import RawSeries, Series
from studies.failures_cells import indenter_of, specimen_of
from studies.noise_cells import BODIES, cell, noisy

E_STAR, R, W = 5e9 / 0.84, 1e-4, 50.0
LAYERS = {body.name: body for body in BODIES[1:]}


def half_space(points: int) -> Series:
    a = np.linspace(0, 1.73e-5, points + 1)[1:]
    return Series(a, *hertz(a, E_STAR, R))


@pytest.mark.parametrize(("S0", "shaped"), [(0.0, True), (0.3, False), (None, True)])
def test_model_jacobian_is_the_derivative(S0: float | None, shaped: bool) -> None:
    x, coating = np.log(np.linspace(0, 1, 16)[1:]), LAYERS["stiff-coating"].series(15)
    model = LogSplineModel(x, 6, S0, Shape.of(coating, float(coating.a[-1])) if shaped else None)
    c = model.straight((0.7, 1.0), (0.3, 0.5), -1.6) + 0.1 * np.random.default_rng(0).standard_normal(model.parameters)
    at, basis, step = model.interpolation(x), model.design(x), 1e-6
    here = model.columns(c, at, basis)
    for j in range(model.parameters):
        change = step * (np.arange(model.parameters) == j)
        up, down = model.columns(c + change, at, basis), model.columns(c - change, at, basis)
        for row in range(4):
            difference = (up.logs[row] - down.logs[row]) / (2 * step)
            assert np.allclose(here.jacobian[row, :, j], difference, rtol=0, atol=2e-8)  # round-off over the step


@pytest.mark.parametrize(
    "law",
    [
        lambda a: (*hertz(a, E_STAR, R), 1),
        lambda a: (*power_law(a, E_STAR, 0.1, 1.0), 1),
        lambda a: (*thin_layer(a, 1e15, R), 2),
        lambda a: (*thin_incompressible_layer(a, 1e9, 1e-6, R), 4),
    ],
    ids=["paraboloid", "cone", "thin", "thin-incompressible"],
)
def test_power_laws_are_exact_at_every_point(law) -> None:
    a = np.linspace(0, 1.73e-5, 6)[1:]
    delta, P, exponent = law(a)
    found = integral(Series(a, delta, P))
    # quadrature of the model; first and last point too
    np.testing.assert_allclose(a * found.dS / found.S, exponent, rtol=1e-9)
    slope = np.log(P[-1] / P[-2]) / np.log(delta[-1] / delta[-2])
    np.testing.assert_allclose(found.S, slope * P / delta, rtol=1e-9)


@pytest.mark.first(2)
@pytest.mark.parametrize("name", LAYERS)
def test_noise_free_layers_beat_the_papers_slopes(name: str) -> None:
    exact = LAYERS[name].series(60)
    truth = transform(exact, slopes(exact, "exact"), LAYERS[name].w)
    ours, paper = (transform(exact, method(exact), LAYERS[name].w) for method in (integral, loocv))
    unit = abs(truth.pull_off(0.0).P)
    assert abs(ours.pull_off(0.0).P - truth.pull_off(0.0).P) < 3e-7 * unit  # measured up to 1.8e-7: the model's floor
    worst = np.max(np.abs(ours.P - truth.P))
    assert worst < 2e-4 * unit  # measured up to 1.2e-4, at the end points
    assert worst < 0.1 * np.max(np.abs(paper.P - truth.P))  # measured 0.001 to 0.02
    assert np.mean(np.abs(ours.P - truth.P) <= ours.errors["P"]) > 0.9


@pytest.mark.parametrize("S0_known", [True, False])
def test_flat_end_with_known_and_unknown_first_slope(S0_known: bool) -> None:
    b, E_star = 1e-6, 1e9
    a = b + np.linspace(0, 4e-6, 31)[1:]
    delta, P = rounded_flat(a, E_star, b, 1e-5)
    found = integral(Series(a, delta, P, a0=b, S0=2 * E_star * b if S0_known else None))
    np.testing.assert_allclose(found.S, 2 * E_star * a, rtol=1e-6)  # noise-free: measured 1e-8
    np.testing.assert_allclose(found.dS, 2 * E_star, rtol=1e-6)


def covered(exact: Series, noise: float, w: float) -> tuple[float, float]:
    """Share of the curve's points within the stated 95 % error, and stated over true error (medians), of 12 seeds."""
    truth = transform(exact, slopes(exact, "exact"), w)
    inside, stated, true = [], [], []
    for seed in range(12):
        ours = transform(*smoothed(noisy(exact, noise, seed)), w)
        common = (ours.a >= truth.a[0]) & (ours.a <= truth.a[-1])
        distance = np.abs(ours.P[common] - truth.at(ours.a[common])[1])
        inside.append(np.mean(distance <= ours.errors["P"][common]))
        stated.append(np.median(ours.errors["P"]))
        true.append(np.median(distance))
    return float(np.mean(inside)), float(np.median(stated) / np.median(true))


@pytest.mark.slow
@pytest.mark.parametrize(("contrast", "points", "noise"), [(434.0, 77, 1.6e-2), (0.16, 400, 1e-4)])
def test_band_holds_where_a_layer_bends_the_curve_at_its_end(contrast: float, points: int, noise: float) -> None:
    """A cone on a layer whose substrate is felt at the last radii only; the prior spreads curvature evenly."""
    problem = Problem(indenter_of("cone", 0.29, 0.1), specimen_of("coating", 0.11, contrast, 1.0, 1.0),
                      Loading("radius", 0.29, points))  # fmt: skip
    inside, ratio = covered(Layered()(problem).series, noise, 1e-4)
    assert inside >= 0.75  # measured 0.80, 0.82, 0.89, 0.98; with the likeliest lambdas alone 0.61 on the first
    assert ratio < 6


def test_band_holds_where_the_curvature_of_the_profile_has_steps() -> None:
    problem = Problem(indenter_of("table", 1e-6, 0.05), Specimen((), HalfSpace(Elastic(1e9, 0.3))),
                      Loading("radius", 1e-6, 500))  # fmt: skip
    exact = Layered()(problem).series
    w = 2e-3
    truth = transform(exact, slopes(exact, "exact"), w)
    ours = transform(*smoothed(noisy(exact, 1e-5, 0)), w)
    inside = (ours.a >= truth.a[0]) & (ours.a <= truth.a[-1])
    distance = np.abs(ours.P[inside] - truth.at(ours.a[inside])[1]) / ours.errors["P"][inside]
    assert np.quantile(distance, 0.9) < 2.5  # half-widths: 1.2 to 1.5; with the first knots and no allowance 5 and 9


def test_correlation_length_of_residuals() -> None:
    white = np.random.default_rng(0).standard_normal((2, 2000))
    assert correlation_length(white) == 1
    assert correlation_length(-white) == 1
    averaged = np.array([np.convolve(row, np.ones(10) / 10, "valid") for row in white])
    # the sum of a triangle of ten: 10; its estimate from 2000 values scatters by a fifth
    assert 7 < correlation_length(averaged) < 14
    alternating = white[:, 1:] - white[:, :-1]
    assert correlation_length(alternating) == 1  # negative correlations do not narrow the band


def test_few_points_count_as_many_as_the_columns_that_scatter() -> None:
    """Student's quantile for 25 values in two columns is 2.06, for the 13 in one, or of a radius alone, 2.16."""
    exact, raw = half_space(15), noisy(half_space(15), 1e-2, 0)
    in_all = smoothed(raw)[1].quantile
    of_radius = smoothed(RawSeries(raw.a, exact.delta, exact.P))[1].quantile
    of_load = smoothed(RawSeries(exact.a, exact.delta, raw.P))[1].quantile
    assert in_all == pytest.approx(2.06, abs=0.01)
    assert (of_radius, of_load) == pytest.approx((2.16, 2.16), abs=0.02)


def test_a_slope_that_is_not_monotonic_is_found() -> None:
    a = np.linspace(0, 1, 81)[1:]
    t = np.linspace(0, 1, 200_001)
    dS = 1 + 2 * np.exp(-(((t - 0.4) / 0.12) ** 2))
    S = np.concatenate([[0], np.cumsum((dS[1:] + dS[:-1]) / 2 * np.diff(t))])
    P = np.concatenate([[0], np.cumsum((S[1:] * 2 * t[1:] + S[:-1] * 2 * t[:-1]) / 2 * np.diff(t))])
    found = integral(Series(a, a**2, np.interp(a, t, P)))
    np.testing.assert_allclose(found.dS, np.interp(a, t, dS), rtol=5e-3)  # measured 1e-3, at the first points


def test_errors_of_the_series_are_used_as_weights() -> None:
    series = half_space(40)
    P = series.P.copy()
    P[10:13] *= 1.0 + np.array([0.02, 0.03, 0.02])
    error = 1e-5 * P
    error[10:13] = 0.05 * P[10:13]
    weighed = integral(Series(series.a, series.delta, P, errors={"P": error}))
    np.testing.assert_allclose(weighed.dS, 2 * E_STAR, rtol=2e-4)
    assert np.all(np.abs(weighed.dS - 2 * E_STAR) <= weighed.dS_err)


@pytest.mark.first(1)
@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_five_points_give_a_band_that_holds_the_truth(noise: float) -> None:
    for name in ("layer-0.4", "stiff-coating"):
        exact = LAYERS[name].series(5)
        truth = transform(exact, slopes(exact, "exact"), LAYERS[name].w)
        result = cell(LAYERS[name], truth, noise, "integral", 12 if noise else 1)
        assert result.failures == 0
        assert result.coverage >= 0.8


def test_points_that_are_not_positive_are_refused_by_number() -> None:
    series = half_space(10)
    P = series.P.copy()
    P[2] = -1e-3
    with pytest.raises(InputError, match=r"point 3 has a = .* P = -0\.001 N; all must be positive: drop it"):
        smoothed(RawSeries(series.a, series.delta, P))


def quantised(offset: float) -> RawSeries:
    """100 increments even in depth with the radius of the outermost node in contact, of 20 that are shifted by a
    fraction of their spacing: exact but for that."""
    a, step = 1.73e-5 * np.sqrt(np.linspace(0, 1, 101)[1:]), 1.73e-5 / 20
    radii = (np.floor(a / step - offset) + offset) * step
    delta, P = hertz(a, E_STAR, R)
    return RawSeries(radii[radii > 0], delta[radii > 0], P[radii > 0])


def test_touch_events_lie_between_their_increments() -> None:
    nodes = node_radii(quantised(0.3))
    assert nodes.spacing == pytest.approx(1.73e-5 / 20)
    assert node_radii(noisy(half_space(30), 1e-2, 0)) is None
    touches = nodes.touches()
    events = touches.rows
    a, P = np.sqrt(events.delta * R), hertz(np.sqrt(events.delta * R), E_STAR, R)[1]
    assert np.all(np.diff(events.a) > 0)
    assert np.all(np.abs(a - events.a) < 1.2 * touches.errors / 0.9)  # half an increment, linearised
    np.testing.assert_allclose(events.P, P, rtol=1e-9)  # Hertz is straight in its logs


def test_increments_before_contact_and_too_few_nodes() -> None:
    raw = quantised(0.3)
    before = RawSeries(*(np.concatenate([[0.0, 0.0], values]) for values in (raw.a, raw.delta, raw.P)))
    assert node_radii(RawSeries(raw.a[:1], raw.delta[:1], raw.P[:1])) is None
    with_nothing, without = node_radii(before), node_radii(raw)
    assert np.array_equal(with_nothing.touches().rows.delta, without.touches().rows.delta)
    with pytest.raises(Refusal, match=r"needs at least 5 points .* got 3"):
        smoothed(RawSeries(raw.a[-20:], raw.delta[-20:], raw.P[-20:]))

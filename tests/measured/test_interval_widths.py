"""Intervals and bands of what is fitted: neither doubled nor halved, and closed forms for what they are made of.

Seeds are such that the means of a few z^2 lie well within their limits, whatever processor draws the last digits.
"""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from fit_data import coating, half_space, sphere, thin_layer, usual
from force_curves import Instrument, record
from raw_records import BODY, R
from raw_records import usual as of_record
from retractions import GEL, body
from retractions import record as retraction
from scipy.fft import dct
from scipy.signal import lfilter
from scipy.stats import t as student
from widths import assert_neither_doubled_nor_halved, mean_squares

from jkrcli.adhesion.curve import transform
from jkrcli.adhesion.slopes import slopes
from jkrcli.bodies.problem import Elastic, HalfSpace, Loading, Specimen
from jkrcli.measured.curve import Curve
from jkrcli.measured.forward_model import FittedBody
from jkrcli.measured.least_squares import (
    Intervals,
    LeastSquares,
    Spectrum,
    State,
    chi2_increase,
    covariance,
    covariance_coloured,
    covariance_of_uneven,
    in_time,
    larger,
    t_quantile,
    taken_by_line,
    variance_factor,
    wider,
)
from jkrcli.measured.parameters import ONE_SIDED, ROOT, FittedValue, Parameter
from jkrcli.measured.procedure import fit, preferences
from jkrcli.measured.report import estimate_words, with_errors
from jkrcli.methods.closed_form import ClosedForm
from jkrcli.methods.layered.solver import Layered
from jkrcli.viscoelastic.rate import PowerRate
from jkrcli.viscoelastic.rate_fit import law_along_records, rate_fit, rate_settings


# ---------------------------------------------------------------------- closed forms
@pytest.mark.parametrize("level", [0.5, 0.9, 0.95])
def test_quantiles_have_two_sides(level: float) -> None:
    """Closed forms of Student's distribution at 1 and 2 degrees of freedom, and of F at 2 and any."""
    assert t_quantile(level, 1) == pytest.approx(math.tan(math.pi * level / 2), rel=1e-9)
    assert t_quantile(level, 2) == pytest.approx(level * math.sqrt(2 / (1 - level**2)), rel=1e-9)
    assert chi2_increase(level, 7) == pytest.approx(t_quantile(level, 7) ** 2 / 7, rel=1e-9)
    assert chi2_increase(level, 7, 2) == pytest.approx((1 - level) ** (-2 / 7) - 1, rel=1e-9)


def test_covariances_of_two_means_by_hand() -> None:
    # Three readings of one number and four of another, and twice as many residuals where two columns are read.
    r = np.array([1.0, -2.0, 1.0, 3.0, -1.0, -1.0, -1.0])
    J = np.repeat(np.eye(2), [3, 4], axis=0)
    assert variance_factor(r, 5, "linear", 1.0) == pytest.approx(18 / 5)
    assert covariance(J, 18 / 5) == pytest.approx(np.diag([18 / 5 / 3, 18 / 5 / 4]))
    uneven = [6 / (1 - 1 / 3) ** 2 / 9, 12 / (1 - 1 / 4) ** 2 / 16]  # sum of r^2/(1 - leverage)^2 over n^2
    assert covariance_of_uneven(J, r[None]) == pytest.approx(np.diag(uneven))
    twice = [4 * 6 / (1 - 1 / 3) ** 2 / 36, 4 * 12 / (1 - 1 / 4) ** 2 / 64]
    assert covariance_of_uneven(np.vstack([J, J]), np.stack([r, r])) == pytest.approx(np.diag(twice))
    assert larger(np.diag([4.0, 1.0]), np.diag([1.0, 9.0])) == pytest.approx(np.diag([4.0, 9.0]))
    # Huber's loss that turns at 2: psi is 1, -1/2, 1/2 and, of the outlier, 1; three slopes of four are 1.
    r = np.array([2.0, -1.0, 1.0, 8.0])
    assert variance_factor(r, 3, "huber", 2.0) == pytest.approx((1 + 0.25 + 0.25 + 1) / 3 * 4 / 0.75**2)
    item = wider(FittedValue("delta0", 1.0, True, "length", 3.0, -5.0, 7.0), {"nu": 4.0, "R": 12.0}, 2.0)
    assert item.error == 13.0
    assert (item.low, item.high) == pytest.approx((1 - 2 * 13.0, 1 + 2 * 13.0))


@pytest.mark.parametrize(("value", "parts", "words"), [
    (55.001e-3, (4e-6, 7.053e-3), "55.0 ± 0.004 ± 7.1 mJ/m^2"), (55.001e-3, (1.42e-3, 11.4e-3), "55 ± 1 ± 11 mJ/m^2"),
    (55.001e-3, (0.56e-3, 0.15e-3), "55.00 ± 0.56 ± 0.15 mJ/m^2"), (1e-18, (29.166e-6,), "0 ± 29 uJ/m^2"),
    (-3e-9, (29.166e-6,), "0 ± 29 uJ/m^2"), (3e-6, (29.166e-6,), "3 ± 29 uJ/m^2"),
])  # fmt: skip
def test_a_value_has_the_digits_that_its_whole_error_leaves(value: float, parts: tuple[float, ...], words: str) -> None:
    """Near zero in the unit of its error."""
    each = dict(zip(("statistical", "model"), parts, strict=False))
    assert with_errors(FittedValue("w", value, True, "work"), each, named=False) == words


def test_a_value_whose_error_is_beyond_it_has_its_interval_alone() -> None:
    item = FittedValue("stress", 0.9e6, True, "modulus", error=24e6, low=31e3, high=47.3e6)
    assert with_errors(item, {"statistical": 47e6}, named=False) == "31 kPa to 47 MPa"
    assert estimate_words(item, 0.95) == "31 kPa to 47 MPa"
    beside = FittedValue("E_star", 131e3, True, "modulus", error=200.0, low=130.6e3, high=131.4e3)
    assert with_errors(beside, {"statistical": 400.0, "model": 140e3}, named=False) == "131 ± 0.4 ± 140 kPa"


def test_limit_of_a_root_that_a_curve_bends_in() -> None:
    """Of a reading 0.1 ± 0.3 of tanh r, r the signed root of w: the profile ends as many errors off in tanh r."""

    def model(x: np.ndarray) -> State:
        return State((np.tanh(x) - 0.1) / 0.3, lambda: np.diag(1 / np.cosh(x) ** 2 / 0.3))

    least = LeastSquares(model, (np.array([-9.0]), np.array([9.0]))).least(np.array([0.1]))
    quantity, variance = Parameter("w", True, scale=ROOT), np.array([[(0.3 / 0.99) ** 2]])
    (item,) = Intervals(least, [quantity], lambda x: {"w": float(x[0])}, variance, 1.96, 0.95).estimates()
    assert item.value == pytest.approx(math.atanh(0.1) ** 2, rel=1e-6)
    assert (item.low, item.high) == (0.0, pytest.approx(math.atanh(0.1 + 0.3 * 1.96 * ONE_SIDED) ** 2, rel=1e-2))
    assert item.error == item.high / (2 * 1.96)


# ---------------------------------------------------------------------- noise that has a colour
@pytest.mark.parametrize("rows", [64, 65])
def test_white_noise_through_the_coloured_covariance_is_white(rows: int) -> None:
    i = np.arange(rows)
    J = np.stack([np.ones(rows), (-1.0) ** i, i / rows], axis=1)
    off = np.random.default_rng(3).standard_normal(rows)
    off -= J @ np.linalg.lstsq(J, off, rcond=None)[0]
    found, white = covariance_coloured(off, J, (), Spectrum(1.0)), np.linalg.inv(J.T @ J)
    size = found.covariance[0, 0] / white[0, 0]
    np.testing.assert_allclose(found.covariance, size * white, rtol=0, atol=1e-9 * size * white.max())
    assert size == pytest.approx(off @ off / (rows - 3), rel=0.1)  # 0.04 measured: by octaves
    assert found.tau == pytest.approx(1)


def test_lines_through_coloured_noise() -> None:
    """Level and slope of a straight line, and a wave of two periods; neighbours correlate by 0.8."""
    x = np.linspace(-1, 1, 256)
    J = np.stack([np.ones_like(x), x, np.sin(2 * np.pi * x)], axis=1)
    noise = np.random.default_rng(1).standard_normal((60, 356))
    noise = lfilter([1.0], [1.0, -0.8], noise, axis=1)[:, 100:]
    off, widths = np.linalg.lstsq(J, noise.T, rcond=None)[0].T, []
    for row, unknowns in zip(noise, off, strict=True):
        widths.append(np.sqrt(np.diag(covariance_coloured(row - J @ unknowns, J, (), Spectrum(1.0)).covariance)))
    assert_neither_doubled_nor_halved(mean_squares(off, widths))


@pytest.mark.parametrize("rows", [3, 4, 41, 900])
def test_what_a_line_takes_of_each_wave(rows: int) -> None:
    """The squares of the cosine transforms of an orthonormal base of straight lines, in closed form."""
    line = np.linalg.qr(np.stack([np.ones(rows), np.arange(rows)], axis=1))[0]
    assert taken_by_line(rows) == pytest.approx(np.sum(dct(line, axis=0, norm="ortho") ** 2, axis=1), abs=1e-14)


def test_noise_of_one_over_f_at_the_lowest_frequencies_of_runs_that_lost_a_line() -> None:
    f = np.fft.rfftfreq(8192)
    true = 1 / np.maximum(f, f[1])
    waves = np.fft.rfft(np.random.default_rng(5).standard_normal((300, 8192)), axis=1) * np.sqrt(true)
    line = np.stack([np.ones(900), np.arange(900)], axis=1)
    ratios = []
    for row in np.fft.irfft(waves, axis=1)[:, :900]:
        off = row - line @ np.linalg.lstsq(line, row, rcond=None)[0]
        noise = covariance_coloured(off, line, [off[:300], off[600:]], Spectrum(1.0)).noise
        ratios.append(float(noise(np.array(1 / 300))) / 300)
    assert np.mean(ratios) == pytest.approx(1, abs=0.07)


def test_weighted_lines_through_noise_of_one_over_f() -> None:
    x = np.linspace(-1, 1, 900)
    J = np.stack([np.ones_like(x), x, np.maximum(1 - 9 * x**2, 0)], axis=1)
    f = np.fft.rfftfreq(8192)
    waves = np.fft.rfft(np.random.default_rng(2).standard_normal((80, 8192)), axis=1) * np.sqrt(1 + 0.1 / (f + 1e-4))
    runs, errors, widths = (x < -1 / 3, x > 1 / 3), [], []
    for row in np.fft.irfft(waves, axis=1)[:, :900]:
        plain = np.linalg.lstsq(J, row, rcond=None)[0]
        off = row - J @ plain
        noise = covariance_coloured(off, J, [off[rows] for rows in runs], Spectrum(1.0)).noise
        best = np.linalg.lstsq(noise.whitened(J), noise.whitened(row), rcond=None)[0]
        off = row - J @ best
        errors.append(best[2])
        widths.append(np.sqrt(covariance_coloured(off, J, [off[rows] for rows in runs], noise).covariance[2, 2]))
    assert_neither_doubled_nor_halved(mean_squares(np.array(errors)[:, None], np.array(widths)[:, None]))


def test_noise_slower_than_the_free_rows_are_long_shows_in_all_rows() -> None:
    """A random walk as large as 0.2 of the white noise, of which two runs of a thousand free rows tell too little in
    every third record: its colour is that of all rows. Waves in contact of half of the noise are none of it."""
    rng, x = np.random.default_rng(7), np.linspace(-1, 1, 3000)
    hump = np.maximum(1 - 9 * x**2, 0)
    J = np.stack([x < 0, x * (x < 0), x >= 0, x * (x >= 0), hump * (x < 0), hump * x], axis=1).astype(float)
    white = rng.standard_normal((40, 3000))
    walks = np.cumsum(rng.standard_normal((40, 3000)), axis=1)
    slow = {"walk": 0, "waves": 0}
    for one, walk in zip(white, walks, strict=True):
        for name, more in (("walk", 0.2 * walk / np.std(walk)), ("waves", 0.5 * np.sin(9 * np.pi * x) * (hump > 0))):
            off = one + more - J @ np.linalg.lstsq(J, one + more, rcond=None)[0]
            slow[name] += bool(covariance_coloured(off, J, [off[:1000], off[2000:]], Spectrum(1.0)).noise.slow)
    assert slow["walk"] >= 30  # 26 by the free rows alone
    assert slow["waves"] <= 6  # 4 are taken for slow by chance


def test_rows_that_are_missing_are_bridged() -> None:
    """A straight line goes on through a gap of 40 rows, whatever their order, where the noise is slow; where it is
    white, missing rows say nothing."""
    rows = np.r_[5:40, 80:120]
    columns = np.stack([rows, np.ones(rows.size)], axis=1).astype(float)
    slow, white = (
        in_time(columns[::-1], rows[::-1], noise) for noise in (Spectrum(0.0, ((1.0, 1.0, 2.0),)), Spectrum(1.0))
    )
    assert slow[:, 1] == pytest.approx(np.ones(115))
    assert np.diff(slow[35:75, 0]) == pytest.approx(np.full(39, (99.5 - 22) / 41))
    assert not white[35:75].any()


# ---------------------------------------------------------------------- fits
GLASS = replace(half_space().problem, specimen=Specimen((), HalfSpace(Elastic(1.5e6, 0.5))))
BODIES = {  # body and w; the moduli are those of the data
    "half-space": (GLASS, 0.1),
    "gel": (thin_layer(), 0.04),
    "coating": (coating(), 0.05),
}
COLUMNS = {"delta, P": (1, 2), "a, P": (0, 2), "a, delta, P": (0, 1, 2)}


@cache
def body_and_curve(name: str) -> tuple[FittedBody, np.ndarray]:
    """The body, and a, delta, P (3, 100) from pull-off to three times its force."""
    problem, w = BODIES[name]
    method = Layered(1e-10) if problem.specimen.layers else ClosedForm()
    fine = method(replace(problem, loading=Loading("radius", problem.loading.maximum, 400))).series
    curve = transform(fine, slopes(fine, "exact"), w)
    lost = curve.pull_off(float("inf"))
    a = np.linspace(lost.a, curve.radii(P=3 * abs(lost.P))[-1], 100)
    series = method(problem).series
    return FittedBody.of(problem, series, slopes(series, "exact")), np.stack([a, *curve.at(a)])


def noise_of(exact: np.ndarray, kind: str) -> np.ndarray:
    """Standard deviations: even along the curve, about 1 % of pull-off and of the radius; or 1 % of each reading."""
    size = np.ptp(exact, axis=1, keepdims=True)
    return 0.01 * (np.array([[1.0], [0.1], [0.1]]) * size if kind == "even" else np.abs(exact) + 1e-3 * size)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["even", "relative"])
@pytest.mark.parametrize("columns", COLUMNS)
@pytest.mark.parametrize("name", BODIES)
def test_intervals_hold(name: str, columns: str, kind: str) -> None:
    """Of a thousand fits (a few: ``test_interval_widths``). E* used to lie in its interval in 73 to 80 of 100 where
    a is measured: its noise was not told from the curve. 0.942 to 0.974 measured; right fits are seldom warned of."""
    (body, exact), truth = body_and_curve(name), {"modulus": 1.0, "w": BODIES[name][1], "delta0": 0.0}
    names, sigma, held, told = ("a", "delta", "P"), noise_of(exact, kind), [], []
    for seed in range(30000, 31000):
        readings = exact + sigma * np.random.default_rng(seed).standard_normal(exact.shape)
        found = fit(body, Curve(name, **{names[i]: readings[i] for i in COLUMNS[columns]}), usual())
        pairs = [(found.estimate(parameter), truth[parameter]) for parameter in found.free]
        held.append([item.low <= true <= item.high for item, true in pairs])
        told.append(any("model rejected" in text or "are structured" in text for text in found.warnings))
    shares = np.mean(held, axis=0)
    assert (shares >= 0.925).all(), shares
    assert (shares <= 0.975).all(), shares
    assert np.mean(told) <= 0.05  # 0.025 measured


@pytest.mark.first(3)
@pytest.mark.parametrize(
    ("name", "columns", "kind", "asked", "first"),
    [
        ("half-space", "delta, P", "relative", {}, 15),
        ("half-space", "a, delta, P", "even", {"noise": True}, 40),
        ("gel", "a, P", "even", {"loss": "soft_l1"}, 8),
    ],
    ids=["uneven noise", "noise told", "robust"],
)
def test_fits_of_prepared_readings(name: str, columns: str, kind: str, asked: dict[str, object], first: int) -> None:
    (held, exact), truth = body_and_curve(name), {"modulus": 1.0, "w": BODIES[name][1], "delta0": 0.0}
    sigma, chosen = noise_of(exact, kind), COLUMNS[columns]
    told = {("a", "delta", "P")[i]: float(sigma[i].mean()) for i in chosen}
    settings = usual(**asked | ({"noise": told} if "noise" in asked else {}))
    off, widths = [], []
    for seed in range(30000 + first, 30008 + first):
        readings = exact + sigma * np.random.default_rng(seed).standard_normal(exact.shape)
        found = fit(held, Curve(name, **dict(zip(told, readings[list(chosen)], strict=True))), settings)
        items = [found.estimate(parameter) for parameter in found.free]
        off.append([item.value - truth[item.name] for item in items])
        widths.append([item.error for item in items])
    assert_neither_doubled_nor_halved(mean_squares(off, widths))
    assert found.dof == 100 * (len(chosen) - 1) - len(items)
    quantile = student.ppf(0.975, found.dof)
    for item in items:
        ends = [item.low - item.value, item.high - item.value]
        if item.name == "modulus":
            ends = [item.value * math.log(end / item.value) for end in (item.low, item.high)]
        assert ends == pytest.approx([-quantile * item.error, quantile * item.error], rel=1e-9)


@cache
def clean_record(w_approach: float) -> dict[str, np.ndarray]:
    """A record without noise, E* = 20 kPa, w = 0.1 mJ/m^2, offset and tilt of its base line a force and 0.1 N/m."""
    return record(20e3, R, w_approach, 1e-4, Instrument(0.05, 150, 3e-6, 4 * FORCE, 0.0, FORCE, 1e5 * FORCE), 0)


FORCE = 1.5 * math.pi * 1e-4 * R
TRUTH = {"E_star": 20e3, "w": 1e-4, "delta0": -FORCE / 0.05, "P0": FORCE, "tilt": 1e5 * FORCE}
RECORDS = {  # what is asked, and what is in the record beside the truth: colour of the noise, a wave, a drift; seeds
    "coloured": ({}, 0.8, {}, range(107, 112)),
    "sine": ({"base_line": "sine"}, 0.0, {"wave_period": 0.5e-6, "wave_amplitude": 0.2 * FORCE}, range(32, 38)),
    "drift": ({"segment": "both", "free": ["drift"]}, 0.0, {"drift": 1e-9, "w_approach": 6e-5}, range(48, 54)),
}


@pytest.mark.parametrize("name", RECORDS)
def test_fits_of_raw_records(name: str) -> None:
    """The load at the contact point, too, which tells the row about which the base line tilts."""
    asked, follows, more, seeds = RECORDS[name]
    clean, truth = clean_record(more.get("w_approach", 0.0)), TRUTH | more
    wave = more.get("wave_amplitude", 0.0) * np.sin(2 * math.pi * clean["z"] / more.get("wave_period", 1.0))
    drift, off, widths, scatter = more.get("drift", 0.0) * clean["t"], [], [], []
    for seed in seeds:
        white = np.random.default_rng(seed).standard_normal(clean["z"].size)
        noise = lfilter([math.sqrt(1 - follows**2)], [1, -follows], white)
        P = clean["P"] + wave + 0.01 * FORCE * noise
        delta = clean["z"] + drift - P / 0.05
        curve = Curve("made", delta=delta, P=P, t=clean["t"], segment=clean["segment"], stiffness=0.05)
        found = fit(BODY, curve, of_record(**asked))
        items = {item.name: item for item in found.estimates}
        off.append([items[key].value - value for key, value in truth.items()])
        widths.append([items[key].error for key in truth])
        scatter.append(found.scales["P"] / (0.01 * FORCE))
    assert_neither_doubled_nor_halved(mean_squares(off, widths))
    assert np.mean(scatter) == pytest.approx(1, abs=0.1)
    for item in (items[key] for key in truth if key != "drift"):
        above = item.high - item.value if item.name != "E_star" else item.value * math.log(item.high / item.value)
        assert 1.96 < above / item.error < 2.06  # of Student's distribution with 30 or more degrees of freedom


def test_rows_that_follow_each_other_speak_less_for_an_assumption() -> None:
    """Akaike's criterion of residuals whose neighbours correlate by 1/2: a third of 57 degrees of freedom count."""
    found = fit(half_space(), sphere(60, 0.01), usual())
    order = replace(found.structure, lag1=0.5)
    one, other = (replace(found, surface=surface, structure=order) for surface in ("sliding", "sticking"))
    (said,) = preferences([replace(one, scatter=2 * other.scatter), other])
    assert f"Akaike's criterion lower by {2 * 57 / 3 * math.log(2):.0f}); frictionless contact: " in said


# ---------------------------------------------------------------------- laws over speed
def test_a_law_through_points() -> None:
    law, v, known = PowerRate(2e-6, 0.5), np.geomspace(1e-8, 1e-4, 320), {"w0": 0.04, "v0": 2e-6, "n": 0.5}
    at, off, widths = np.array([1e-8, 1e-6, 1e-4]), [], []
    for seed in range(12, 36):
        noise = np.repeat(np.random.default_rng(seed).standard_normal(80), 4)
        found = law_along_records("power", v, law.work(0.04, v) * np.exp(0.03 * noise), 4)
        w, low, high = found.band(at, 0.8)
        of_band = np.log(high / low) / 2 / student.ppf(0.9, 80 - 3)
        off.append([*np.log(w / law.work(0.04, at)), *(math.log(found.values[key] / known[key]) for key in known)])
        widths.append([*of_band, *(found.errors[key] for key in known)])
    assert_neither_doubled_nor_halved(mean_squares(off, widths))


def test_a_law_of_records() -> None:
    known = [("modulus", "1"), ("delta0", "5 um"), ("n", "0.5")]
    settings = rate_settings(body("gel"), "power", fix=known, start=[("w0", "0.04"), ("v0", "2e-6")])
    off, widths, truth = [], [], dict(zip(("w0", "v0"), GEL, strict=False))
    for seed in range(2, 6):
        curve = retraction("gel", 1e-5, 250, np.random.default_rng(seed), 5e-6)
        found = rate_fit(body("gel"), [curve], settings)
        items = [next(item for item in found.estimates if item.name == key) for key in truth]
        off.append([math.log(item.value / truth[item.name]) for item in items])
        widths.append([item.error / item.value for item in items])
    assert_neither_doubled_nor_halved(mean_squares(off, widths))
    quantile = student.ppf(0.975, found.dof)
    for item, error in zip(items, np.sqrt(np.diag(found.covariance)), strict=True):
        assert np.log([item.value / item.low, item.high / item.value]) == pytest.approx(quantile * error, rel=1e-9)
    w, low, high = found.band(np.array([items[1].value]))
    by = np.array([1.0, -0.5 / 2])  # of log w = log w0 + log(1 + (v/v0)^n) at v = v0, n = 1/2, by log w0 and log v0
    half_width = quantile * math.sqrt(by @ found.covariance @ by)
    assert np.log([w / low, high / w]).ravel() == pytest.approx(half_width, rel=1e-6)

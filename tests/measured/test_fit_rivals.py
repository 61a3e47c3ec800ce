"""What the nearest other models leave of a fit: misfits are warned of or held by the second part of the uncertainty."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from fit_data import (
    A_C,
    A_END,
    DELTA_C,
    E_STAR,
    P_C,
    R,
    W,
    adhesive,
    body_of,
    coating,
    half_space,
    measured,
    sphere,
    thin_layer,
    usual,
)
from maugis import Maugis
from raw_records import inside

from jkrcli.adhesion.slopes import slopes
from jkrcli.bodies.indenters import Sphere
from jkrcli.bodies.problem import Elastic, HalfSpace, Specimen
from jkrcli.measured.curve import Curve
from jkrcli.measured.forward_model import Drift, FittedBody
from jkrcli.measured.parameters import Parameter
from jkrcli.measured.procedure import OF_STRAINS, fit
from jkrcli.measured.range_alternative import ALTERNATIVES, RANGE, AddedTerm
from jkrcli.measured.result import Fit
from jkrcli.measured.rows import Readings
from jkrcli.measured.settings import settings_of
from jkrcli.methods.closed_form import ClosedForm

SEEDS = [5, pytest.param(100, marks=pytest.mark.slow)]


def noisy(exact: Curve, size: float, seed: int) -> Curve:
    """Noise of ``size`` times the pull-off force and its displacement, at least a fifth of the range."""
    random = np.random.default_rng(seed)
    deep = max(abs(float(exact.delta.min())), 0.2 * float(np.ptp(exact.delta)))
    delta, P = (size * scale * random.standard_normal(exact.P.size) for scale in (deep, abs(float(exact.P.min()))))
    return replace(exact, delta=exact.delta + delta, P=exact.P + P)


def with_rising_w(rise: float) -> Curve:
    """The sphere of ``fit_data`` whose w rises by ``rise`` on the way from the largest contact to pull-off."""
    a = np.linspace(A_C, A_END, 200)
    delta, P = adhesive(a, E_STAR, W * (1 + rise * (A_END - a) / (A_END - A_C)))
    return Curve("rising", delta=delta, P=P)


def of_range(tabor: float, end: str, points: int = 200) -> Curve:
    """The sphere of ``fit_data`` with adhesion of finite range by Maugis' closed form, from where a load or a
    displacement ("P", "delta") loses contact to three times the pull-off force."""
    lam = 2 * (9 / (16 * math.pi)) ** (1 / 3) * tabor  # of the tension w/range, K = 4 E*/3
    exact = Maugis(R, E_STAR, W, lam, 1 + np.geomspace(1e3, 1e-5, 4000))
    a, first = exact.a, int(np.argmin(getattr(exact, end)))
    last = int(np.argmax(exact.P > 3 * abs(exact.P.min())))
    places = np.linspace(a[first], a[last], points)
    return Curve("ranged", delta=np.interp(places, a, exact.delta), P=np.interp(places, a, exact.P))


def coating_as_half_space() -> FittedBody:
    problem = replace(coating(), specimen=Specimen((), HalfSpace(Elastic(20e6, 0.45))))
    series = ClosedForm()(problem).series
    return FittedBody.of(problem, series, slopes(series, "exact"), True)


def warned(found: Fit) -> bool:
    return any("model rejected" in text or "are structured" in text for text in found.warnings)


def held(found: Fit, name: str, truth: float) -> bool:
    """Whether the truth lies within the statistical and the model's part together."""
    item = found.estimate(name)
    model = math.hypot(*(item.model or {}).values())
    return item.low - model <= truth <= item.high + model


def sphere_of_more() -> FittedBody:
    return half_space(reach=3 * A_END)


# The body that is fitted, the data, and w and E* that they were made with (a coating has no one E*)
MISFITS: dict[str, tuple[Callable[[], FittedBody], Callable[[], Curve], float, float | None]] = {
    "w rises by 10 %": (half_space, lambda: with_rising_w(0.1), 1.1 * W, E_STAR),
    "w rises by 30 %": (half_space, lambda: with_rising_w(0.3), 1.3 * W, E_STAR),
    "w rises by 100 %": (half_space, lambda: with_rising_w(1.0), 2.0 * W, E_STAR),
    "a coating as a half-space": (coating_as_half_space, lambda: measured(coating(), 0.05), 0.05, None),
    "Tabor number 0.3, load": (sphere_of_more, lambda: of_range(0.3, "P"), W, E_STAR),
    "Tabor number 1, load": (sphere_of_more, lambda: of_range(1.0, "P"), W, E_STAR),
    "Tabor number 0.3, displacement": (sphere_of_more, lambda: of_range(0.3, "delta"), W, E_STAR),
    "Tabor number 1, displacement": (sphere_of_more, lambda: of_range(1.0, "delta"), W, E_STAR),
}


@pytest.mark.first(3)
@pytest.mark.parametrize("seeds", SEEDS)
@pytest.mark.parametrize("name", MISFITS)
def test_a_misfit_is_warned_of_or_held(name: str, seeds: int) -> None:
    """w is that where contact is lost; without the second part it used to be off by up to 80 half-widths, unsaid."""
    make, data, *truth = MISFITS[name]
    body, exact = make(), data()
    found = [fit(body, noisy(exact, 0.01, seed), usual()) for seed in range(seeds)]
    for what, true in zip(("w", "E_star"), truth, strict=True):
        if true is not None:
            assert np.mean([warned(one) or held(one, what, true) for one in found]) >= (0.95 if seeds >= 100 else 0.8)
    if name != "w rises by 10 %":  # there w at pull-off is what is found
        assert np.mean([inside(one, "w", truth[0]) for one in found]) < 0.95


@pytest.mark.first(1)
@pytest.mark.parametrize("seeds", SEEDS)
@pytest.mark.parametrize(
    ("body", "exact"),
    [(half_space, sphere), (lambda: body_of(coating()), lambda: measured(coating(), 0.05)),
     (lambda: body_of(thin_layer()), lambda: measured(thin_layer(), 0.04))],
    ids=["half-space", "coating", "gel"],
)  # fmt: skip
def test_good_fits_are_seldom_warned_of(body: Callable[[], FittedBody], exact: Callable[[], Curve], seeds: int) -> None:
    wanted, right = body(), exact()
    found = [fit(wanted, noisy(right, 0.01, seed), usual()) for seed in range(seeds)]
    assert np.mean([warned(one) for one in found]) <= (0.05 if seeds >= 100 else 0.1)
    assert all(item.model for one in found for item in one.estimates if item.name in ("E_star", "w"))


def test_the_second_part_is_that_of_an_interval() -> None:
    # What is told of a change c along the record, of standard deviation s, and t s beyond: over many records |c| is
    # 0.8 s in the mean and once next to 0. Half the interval would leave 0.55 for the ratio, twice as much 0.83.
    found = [fit(half_space(), sphere(60, 1e-3, seed), usual()).estimate("E_star") for seed in range(12)]
    parts = np.array([[item.model[ALTERNATIVES[name][0]] for name in ("w", "modulus")] for item in found])
    share = 2 / (2 + math.sqrt(2 / math.pi))
    assert parts.min(axis=0) / parts.mean(axis=0) == pytest.approx(share, abs=0.06)
    parts = []
    for size in (1e-2, 1e-4):
        found = fit(half_space(), sphere(200, size, 3), usual()).estimate("w")
        parts.append(math.hypot(*(found.model[name] for name in found.model.keys() - {OF_STRAINS})) / found.value)
    assert parts[1] < 0.1 * parts[0] < 0.03


@pytest.mark.parametrize("name", ["w", "modulus"])
def test_derivatives_of_a_drifting_curve(name: str) -> None:
    values = {p.name: 0.1 if p.value is None else p.value for p in usual().parameters}
    drift = Drift(name, 0.4, 0.5, A_C, A_END)
    readings = Readings(half_space().family, values, ("delta", "P"), np.array([DELTA_C, P_C]), drift)
    u, step = np.log(np.linspace(1.1 * A_C, 0.9 * A_END, 7)), 1e-5
    _, first, second = readings.along(u)
    above, below = readings.along(u + step), readings.along(u - step)
    assert first == pytest.approx((above[0] - below[0]) / (2 * step), rel=1e-5)
    assert second == pytest.approx((above[1] - below[1]) / (2 * step), rel=1e-3, abs=1e-3)


def test_parts_of_what_follows_and_words_of_large_changes() -> None:
    # E* used to get its part times the factor of the case's moduli.
    found = fit(half_space(), sphere(200, 0.01, 3), usual())  # whose moduli are twice those of the data
    factor, E_star = found.estimate("modulus"), found.estimate("E_star")
    assert factor.value == pytest.approx(0.5, rel=0.02)
    for name, part in factor.model.items():
        assert E_star.model[name] / E_star.value == pytest.approx(part / factor.value, rel=1e-12)
    assert AddedTerm("w", 0.3, {}).words == "a change of w along the curve by +30%"
    assert AddedTerm("w", -53.5, {}).words == "a change of w along the curve by more than -70%"
    assert AddedTerm("modulus", 9.0, {}).words == "a change of E* along the curve by more than +120%"


def test_a_range_counts_up_to_the_longest_that_is_likely() -> None:
    curve, body = sphere(200, 0.01, 3), half_space()
    usually = fit(body, curve, usual())
    ten, long = (fit(body, curve, settings_of(body, uncertain={"range": most})) for most in ("10 nm", "1 um"))
    assert usually.range_left > 1e-6  # which the data leave
    assert ten.range_left == 10e-9
    assert max(one.estimate("w").model[RANGE] for one in (usually, ten)) < 1e-4 * W  # Tabor number 46
    assert long.estimate("w").model[RANGE] > 0.03 * W


def test_rungs_are_near_the_fits_with_their_range() -> None:
    """Moves of w by two Gauss-Newton steps on coarse, rounded curves against fits with that range fixed."""
    curve = noisy(of_range(1.0, "P"), 0.01, 1)
    found = fit(sphere_of_more(), curve, usual(range_at_most=2e-7))
    settings = replace(usual(), parameters=(*usual().parameters, Parameter("range", False, 2e-7)))
    there = fit(sphere_of_more(), curve, settings)
    move = found.value("w") - there.value("w")
    assert found.estimate("w").model[RANGE] == pytest.approx(move, rel=0.05)  # 0.01 measured


# ---------------------------------------------------------------------- the compressive part alone (Borodich, Galanov)
A_ZERO = 4 ** (1 / 3) * A_C  # the radius at P = 0


def test_the_compressive_part_alone_has_a_sensitivity_to_changes_and_no_error_by_them() -> None:
    """Nothing in it tests a change of w or E* along the record. Against exact data whose w rises by 1 % from the
    smallest radius to the largest, fitted with a constant one."""
    told = fit(half_space(), sphere(noise=0.01, seed=3, shift=0.2, first=A_ZERO), usual())
    modulus = told.estimate("E_star")
    assert math.sqrt(sum(part**2 for part in (modulus.model or {}).values())) < 2 * (modulus.error or 0.0)
    assert set(told.estimate("w").model or {}) <= {RANGE}
    (words,) = [text for text in told.warnings if "no pull-off in the data" in text]
    by_w = (
        float(words.split("not in the errors: a change by 1% along the curve of w moves w by ")[1].split("%")[0]) / 100
    )
    a = np.linspace(A_ZERO, A_END, 200)
    delta, P = adhesive(a, E_STAR, W * (1 + 0.01 * (a - a[0]) / (a[-1] - a[0])))
    found = fit(half_space(), Curve("rising", delta=delta, P=P), usual())
    assert abs(found.value("w") / W - 1) == pytest.approx(by_w, rel=0.25)


def test_both_profiles_are_told_where_they_differ_by_more_than_the_error() -> None:
    data = sphere(noise=0.01, seed=3, first=A_ZERO)
    body = half_space(extensible=True)
    exact = body.under(Sphere(R), A_END)
    found = fit(exact, data, usual())
    assert "the paraboloid of the same radius would give E* = " in found.tip
    by_words = float(found.tip.split("w = ")[1].split(" mJ")[0]) * 1e-3
    assert by_words == pytest.approx(fit(body, data, usual()).value("w"), rel=1e-3)
    assert abs(found.value("w") - by_words) > 2 * (found.estimate("w").error or 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.01, 0.03])
def test_the_example_of_perepelkin_and_others(noise: float) -> None:
    """Nanomaterials 10 (2020) 15: 20 noisy sets of the compressive part with a shifted origin; E* = 1 MPa and
    w = 100 mJ/m^2 came out as 0.9987 MPa and 101.2 mJ/m^2 there."""
    pairs = []
    for seed in range(20):
        shift = np.random.default_rng(1000 + seed).uniform(-0.5, 0.5)
        found = fit(half_space(), sphere(noise=noise, seed=seed, shift=shift, first=A_ZERO), usual())
        pairs.append((found.value("E_star") / E_STAR, found.value("w") / W))
    E, w = np.mean(pairs, axis=0)
    assert E == pytest.approx(1.0, abs=0.2 * noise)
    assert w == pytest.approx(1.0, abs=1.5 * noise)


@pytest.mark.parametrize(("wc", "size"), [(0.2, 0.17), (0.02, 0.0), (0.4, None)])
def test_large_strains_at_pull_off_are_a_part_of_w(wc: float, size: float | None) -> None:
    """Of a soft incompressible half-space as far as they are known, -4.5 wc^2 up to 0.15 and -27 % at 0.3; where they
    are less than a tenth of the interval, not a word; beyond, a warning."""
    w = wc**3 * E_STAR * R
    a = np.linspace(1.0, 3.0, 100) * (9 * np.pi * w * R**2 / (8 * E_STAR)) ** (1 / 3)
    delta, P = adhesive(a, w=w)
    random = np.random.default_rng(1)
    P = P + 1e-3 * np.ptp(P) * random.standard_normal(a.size)
    found = fit(half_space(reach=1.5 * float(a[-1])), Curve("soft", delta=delta, P=P), usual())
    part = (found.work.model or {}).get(OF_STRAINS, 0.0)
    said = [line for line in found.warnings if "large strains beyond the estimate" in line]
    if size is None:
        assert "0.4" in said[0]
        assert part == 0
    else:
        assert not said
        assert part / found.work.value == pytest.approx(size, rel=0.3, abs=1e-9)

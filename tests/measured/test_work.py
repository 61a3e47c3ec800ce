"""The work of adhesion along measured data: exact on synthetic curves, one root or none, errors, the edge's speed."""

import functools
from dataclasses import replace

import numpy as np
import pytest
from fit_data import adhesive
from hypothesis import given, settings
from hypothesis import strategies as st
from stated_errors import in_units
from widths import assert_neither_doubled_nor_halved, mean_squares

from jkrcli.adhesion.curve import Nonadhesive, transform
from jkrcli.adhesion.slopes import slopes, smoothed
from jkrcli.base.errors import InputError
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.measured.curve import Curve
from jkrcli.measured.work import ABOVE, BELOW, NONE, OK, PAIRS, rate, work_along
from jkrcli.methods.layered.solver import Layered
from jkrcli.series import RawSeries

R, H = 1e-3, 50e-6
W = 0.08
BODIES = {
    "half-space": (Specimen((), HalfSpace(Elastic(1e6, 0.4))), 2e-4),
    "thin layer": (Specimen((Layer(Elastic(1e6, 0.499), H),), Rigid(True)), 8 * H),
    "coating": (Specimen((Layer(Elastic(1e7, 0.4), H),), HalfSpace(Elastic(1e6, 0.25))), 4 * H),
}


@functools.cache
def body(name: str, points: int = 100) -> Nonadhesive:
    specimen, a_max = BODIES[name]
    problem = Problem(Paraboloid(R), specimen, Loading("radius", a_max, points))
    series = Layered()(problem).series
    return Nonadhesive(series, slopes(series))


def synthetic(name: str, rows: np.ndarray | slice = slice(None), w: float | np.ndarray = W) -> Curve:
    """Exact adhesive contact at radii of the series."""
    held = body(name)
    series, exact = held.series, held.slopes
    lag = np.sqrt(4 * np.pi * w * series.a / exact.dS)
    return Curve("c", a=series.a[rows], delta=(series.delta - lag)[rows], P=(series.P - exact.S * lag)[rows])


# ---------------------------------------------------------------------- exactness
@pytest.mark.parametrize("use", PAIRS, ids="-".join)
@pytest.mark.parametrize("name", BODIES)
def test_noise_free_data_give_w_back(name: str, use: tuple[str, str]) -> None:
    curve = synthetic(name)
    found = work_along(body(name), curve, use)
    assert found.ok.all()
    # Round-off of delta_H - delta, P_H - P, at radii where delta_H is up to 300 times the shift.
    np.testing.assert_allclose(found.w, W, rtol=2e-10)  # 2e-11 measured
    np.testing.assert_allclose(found.a, curve.a, rtol=1e-12)  # 1e-13


@pytest.mark.first(4)
@pytest.mark.parametrize("use", PAIRS, ids="-".join)
@pytest.mark.parametrize("name", BODIES)
def test_between_the_points_of_the_series_w_errs_by_its_interpolation_alone(name: str, use: tuple[str, str]) -> None:
    """Radii of another exact solve, that of 457 points: the rule's 4th-order error, 4e-6 at worst with 100 points."""
    specimen, a_max = BODIES[name]
    series = Layered()(Problem(Paraboloid(R), specimen, Loading("radius", a_max, 457))).series
    lag = np.sqrt(4 * np.pi * W * series.a / series.dS)
    curve = Curve("c", a=series.a, delta=series.delta - lag, P=series.P - series.S * lag).rows(series.a > a_max / 20)
    near = 1e-11 if name == "half-space" else 1e-5  # 2e-12: quintics over close logs
    np.testing.assert_allclose(work_along(body(name), curve, use).w, W, rtol=near)


def test_pull_off_of_the_classical_theory() -> None:
    """P = -1.5 pi w R at a^3 = 9 pi w R^2/(8 E*) (Johnson, Kendall and Roberts 1971) means w, wherever it is looked."""
    E_star = 1e6 / (1 - 0.4**2)
    a = (9 * np.pi * W * R**2 / (8 * E_star)) ** (1 / 3)
    delta, _ = adhesive(np.array([a]), E_star, W, R)
    curve = Curve("c", a=np.array([a]), delta=delta, P=np.array([-1.5 * np.pi * W * R]))
    for use in PAIRS:
        found = work_along(body("half-space"), curve, use)
        # (delta, P): round-off of P_H - P - S (delta_H - delta), of three terms that nearly cancel
        np.testing.assert_allclose(found.w, W, rtol=1e-13)  # 3e-15 measured
        np.testing.assert_allclose(found.a, a, rtol=1e-13)


@settings(deadline=None, max_examples=40)
@given(
    name=st.sampled_from(sorted(BODIES)),
    part=st.lists(st.floats(0.02, 1.0), min_size=1, max_size=5),
    w=st.floats(1e-4, 10.0),
)
def test_displacement_and_load_have_one_adhesive_radius(name: str, part: list[float], w: float) -> None:
    held = body(name)
    a = np.array(part) * held.series.a[-1]
    delta, P = transform(held.series, held.slopes, w).at(a)
    found = work_along(held, Curve("c", delta=delta, P=P))
    assert found.ok.all()
    # The lag may be 1e-3 of delta_H, which itself stands on 1e-16 of the loads' cancelling terms.
    np.testing.assert_allclose(found.a, a, rtol=1e-10)  # 3e-13 measured
    np.testing.assert_allclose(found.w, w, rtol=1e-8)  # 2e-10


def test_units_do_not_matter() -> None:
    length, force = 3.7e3, 2.9e-5
    held = body("coating")
    d, scaled = held.slopes, in_units(held.series, length, force)
    c = synthetic("coating")
    curve = Curve("c", a=c.a * length, delta=c.delta * length, P=c.P * force)
    for use in PAIRS:
        found = work_along(Nonadhesive(scaled, slopes(scaled)), curve, use)
        np.testing.assert_allclose(found.w, W * force / length, rtol=5e-12)  # 3e-13 measured
    assert d.method == "exact"


# ---------------------------------------------------------------------- rows without a work of adhesion
def test_rows_that_have_none_are_told_apart() -> None:
    held = body("half-space")
    series = held.series
    nonadhesive = Curve("c", delta=series.delta[20:30] * 0.999, P=series.P[20:30])  # above the load of that depth
    adhesive = synthetic("half-space", slice(20, 30))
    deep = Curve("c", delta=series.delta[-1:] * 1.5, P=series.P[-1:])
    free = Curve("c", delta=np.array([-1e-7]), P=np.array([0.0]))
    mixed = Curve("c", *[None], *(np.concatenate([getattr(part, name) for part in (adhesive, nonadhesive, deep, free)])
                                  for name in ("delta", "P")))  # fmt: skip
    found = work_along(held, mixed)
    assert found.state.tolist() == [OK] * 10 + [NONE] * 10 + [ABOVE, BELOW]
    assert (found.w[10:] == 0).all()
    assert (found.a[10:] == 0).all()
    held = body("thin layer")
    series = held.series
    curve = Curve("c", a=np.array([series.a[0] / 2, series.a[50], series.a[50], series.a[-1] * 1.1]),
                  P=np.array([0.0, series.P[50] * 1.001, series.P[50] * 0.9, 1.0]))  # fmt: skip
    assert work_along(held, curve).state.tolist() == [BELOW, NONE, OK, ABOVE]


def test_curves_that_tell_no_w_are_refused() -> None:
    held = body("half-space")
    curve = Curve("c", delta=np.array([1e-6, 1.0, 1.0]), P=np.array([1.0, 0.0, 0.0]))
    said = "none of its 3 rows gives .*: 1 at or above the nonadhesive load, 2 at contact radii above 200 um"
    with pytest.raises(InputError, match=said):
        work_along(held, curve)
    with pytest.raises(InputError, match=r"^c: w follows from a and P, it holds delta, P$"):
        work_along(body("half-space"), Curve("c", delta=np.zeros(3), P=np.zeros(3)), ("a", "P"))
    with pytest.raises(InputError, match=r"^c: w follows from two of a, delta, P, it holds P$"):
        work_along(body("half-space"), Curve("c", P=np.zeros(3)))


# ---------------------------------------------------------------------- errors
@pytest.mark.parametrize("use", PAIRS, ids="-".join)
@pytest.mark.parametrize("name", BODIES)
def test_noise_is_carried_as_by_differences(name: str, use: tuple[str, str]) -> None:
    """Half-widths 1.96 sigma |dw/dx|, against central differences of the whole evaluation."""
    held, rows = body(name), slice(10, 95, 5)
    curve = synthetic(name, rows)
    noise = {"a": 1e-9, "delta": 1e-12, "P": 1e-11}
    found = work_along(held, curve, use, noise)
    squares = np.zeros((2, len(curve)))
    for quantity in use:
        step = 10 * noise[quantity]
        sides = []
        for sign in (1, -1):
            moved = {key: getattr(curve, key) + sign * step * (key == quantity) for key in ("a", "delta", "P")}
            sides.append(work_along(held, Curve("c", **moved), use))
        squares += [(0.1 * (getattr(sides[0], key) - getattr(sides[1], key)) / 2) ** 2 for key in ("w", "a")]
    np.testing.assert_allclose(found.w_err, 1.959964 * np.sqrt(squares[0]), rtol=2e-4)  # differences: of 2nd order
    if use == ("delta", "P"):
        np.testing.assert_allclose(found.a_err, 1.959964 * np.sqrt(squares[1]), rtol=2e-4)
    else:
        assert found.a_err is None


@pytest.mark.parametrize("use", PAIRS[1:], ids="-".join)
def test_the_noise_of_the_load_is_in_the_deflection_too(use: tuple[str, str]) -> None:
    """Displacements z - P/k err with the load: half-widths against central differences."""
    held, k, sigma = body("half-space"), 50.0, 1e-11
    curve = replace(synthetic("half-space", slice(10, 95, 5)), stiffness=k)
    found = work_along(held, curve, use, {"P": sigma})
    up, down = (work_along(held, replace(curve, P=curve.load + step, delta=curve.depth - step / k), use)
                for step in (10 * sigma, -10 * sigma))  # fmt: skip
    np.testing.assert_allclose(found.w_err, 1.959964 * np.abs(up.w - down.w) / 20, rtol=2e-4)  # of 2nd order


@functools.cache
def noisy_body(seed: int) -> Nonadhesive:
    """The thin layer by a series with relative noise of 3e-3 in every column, smoothed."""
    rng, exact = np.random.default_rng(seed), body("thin layer").series
    noisy = [getattr(exact, key) * (1 + 3e-3 * rng.normal(size=100)) for key in ("a", "delta", "P")]
    return Nonadhesive(*smoothed(RawSeries(*noisy)))


@pytest.mark.parametrize("use", PAIRS, ids="-".join)
def test_errors_of_the_slopes_are_those_of_w(use: tuple[str, str]) -> None:
    """A noisy series, smoothed: w off the truth in standard errors, over its radii and seeds; 0.6 to 1.0 measured."""
    curve = synthetic("thin layer", slice(8, 96, 4))
    squares = []
    for seed in range(8):
        along = work_along(noisy_body(seed), curve, use)
        assert along.w_err is None  # as the noise of the readings is not known
        assert set(along.shares) == {"slopes"}
        half = along.shares["slopes"][along.ok]
        squares.append(mean_squares((along.w - W)[along.ok], half, noisy_body(seed).slopes.quantile))
    assert_neither_doubled_nor_halved(np.mean(squares))


# ---------------------------------------------------------------------- speed
def test_the_rate_of_parabolas_and_of_what_bends_more() -> None:
    rng = np.random.default_rng(3)
    t = np.cumsum(rng.uniform(0.01, 1.0, 40)) + 1e4
    y = 3e-6 - 2e-7 * (t - 1e4) + 5e-9 * (t - 1e4) ** 2
    found, error = rate(t, y, 7)
    np.testing.assert_allclose(found, -2e-7 + 1e-8 * (t - 1e4), rtol=0, atol=2e-20)  # m/s: 1e-21 measured
    assert error.max() < 1e-14  # m/s
    # An edge that runs faster and faster: the cubic, and an error that holds what it leaves.
    t = np.linspace(0, 3, 60)
    found, error = rate(t, np.exp(t), 11)
    off = np.abs(found - np.exp(t))
    assert off.max() < 2e-3 * np.exp(3)  # 1.1e-3 measured; of the parabola 2e-2
    assert (off <= error).all()


def test_the_error_of_the_rate_holds_the_truth_nineteen_times_in_twenty() -> None:
    rng = np.random.default_rng(0)
    t = np.arange(4000) * 0.1
    found, error = rate(t, 2e-6 * t + rng.normal(0, 1e-7, t.size), 11)
    assert 0.93 < (np.abs(found - 2e-6) <= error).mean() < 0.97  # 360 independent windows: 0.95 within two sigmas
    held = body("half-space")
    curve = synthetic("half-space", slice(10, 50))
    P = curve.P.copy()
    P[6] = 1.0  # no adhesion: rows 0 to 5 are too few for a window of 7
    found = work_along(held, Curve("c", a=curve.a, P=P, t=np.arange(40.0)), window=7)
    assert found.timed.tolist() == [False] * 7 + [True] * 33


def test_rate_dependent_adhesion_is_read_back() -> None:
    """A retraction with w = w0 (1 + (v/v0)^n): both w and v come back at each row, receding negative."""
    held = body("thin layer")
    t = np.linspace(0, 20, 400)
    a = held.series.a[-1] * (0.3 + 0.6 * np.exp(-t / 8))
    v = -held.series.a[-1] * 0.6 / 8 * np.exp(-t / 8)
    w = 0.05 * (1 + (-v / 1e-6) ** 0.6)
    one, none = transform(held.series, held.slopes, 1.0), transform(held.series, held.slopes, 0.0)
    delta, P = (x - np.sqrt(w) * (x - y) for x, y in zip(none.at(a), one.at(a), strict=True))
    segment = np.repeat(["retract", "hold"], [250, 150])
    found = work_along(held, Curve("c", delta=delta, P=P, t=t, segment=segment))
    np.testing.assert_allclose(found.w, w, rtol=2e-11)  # 1e-12 measured
    assert found.timed.all()
    np.testing.assert_allclose(found.speed, v, rtol=1e-4)  # cubics over 11 rows of e^(-t/8)
    backwards = Curve("c", delta=delta[::-1], P=P[::-1], t=t)
    assert (work_along(held, backwards).speed > 0).all()

"""Fits of E*, w and the range of adhesion: to curves of Maugis' closed form, with noise, and where there is none."""

import math
import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from conftest import write_table
from maugis import Maugis
from raw_records import inside, read

from jkrcli.adhesion.finite_range import FiniteRangeBody, Range
from jkrcli.adhesion.slopes import slopes
from jkrcli.base.errors import InputError, Refusal
from jkrcli.bodies.indenters import Paraboloid, RoundedFlat, Sphere
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.measured.curve import Curve
from jkrcli.measured.forward_model import FittedBody, Member, body_of
from jkrcli.measured.procedure import _meaning, fit
from jkrcli.measured.result import Fit
from jkrcli.measured.rows import Minimum, Objective, points_of
from jkrcli.measured.settings import settings_of
from jkrcli.methods.layered.solver import Layered

R, E_STAR, W = 20e-9, 2e9, 0.05
LENGTH = (math.pi * W * R**2 * 3 / 4 / E_STAR) ** (1 / 3)
UNITS = {"a": LENGTH, "delta": LENGTH**2 / R, "P": math.pi * W * R}


@cache
def tip(factor: float = 1.5) -> FittedBody:
    """A body whose moduli are ``factor`` times those of the data."""
    specimen = Specimen((), HalfSpace(Elastic(factor * E_STAR * (1 - 0.3**2), 0.3)))
    problem = Problem(Paraboloid(R), specimen, Loading("radius", 3 * LENGTH, 100))
    series = Layered(1e-9)(problem).series
    return FittedBody.of(problem, series, slopes(series, "exact"), True)


def states(lam: float) -> Maugis:
    return Maugis(R, E_STAR, W, lam, 1 + np.geomspace(3e3, 1e-4, 4000))


def record(
    lam: float, noise: float, columns: tuple[str, ...] = ("delta", "P"), points: int = 300, seed: int = 1
) -> Curve:
    """Readings evenly along the curve from pull-off under displacement control to 2.5 pi w R, ``noise`` in UNITS."""
    exact, random = states(lam), np.random.default_rng(seed)
    kept = (np.arange(exact.a.size) >= np.argmin(exact.delta)) & (exact.P < 2.5 * UNITS["P"])
    steps = np.hypot(*(np.diff(getattr(exact, name)[kept]) / UNITS[name] for name in ("delta", "P")))
    along = np.append(0, np.cumsum(steps))
    places = np.linspace(0, along[-1], points)
    return Curve("tip", **{
        name: np.interp(places, along, getattr(exact, name)[kept])
        + noise * UNITS[name] * random.standard_normal(points) for name in columns
    })  # fmt: skip


def truth(lam: float) -> dict[str, float]:
    stress = states(lam).stress
    return {"E_star": E_STAR, "w": W, "range": W / stress, "stress": stress, "delta0": 0.0}


def missed(found: Fit, lam: float, names: tuple[str, ...] = ("E_star", "w", "range", "stress", "delta0")) -> list[str]:
    """The values whose interval does not hold the true one."""
    return [name for name in names if not inside(found, name, truth(lam)[name])]


def curve_of(body: FittedBody, lam: float, **changes: float) -> Member:
    factor = E_STAR / body.problem.E_star
    return body.attracted.member({"modulus": factor, "w": W, "range": truth(lam)["range"]} | changes)


@pytest.mark.parametrize("lam", [0.3, 3.0])
def test_coarse_curves_are_near_the_fine_ones(lam: float) -> None:
    body = tip()
    fine, coarse = (curve_of(one, lam) for one in (body, body.coarse))
    u = np.linspace(*fine.ends(0, 0, None), 300)[:-20]
    for exact, near in zip(fine.along(u)[0][1:], coarse.along(u)[0][1:], strict=True):
        assert np.abs(near - exact).max() < 1e-4 * abs(exact.min())  # 4e-5 measured


def test_what_is_no_range() -> None:
    # Its logarithm used to end fits by profiles, on whose way w may be 0.
    body, curve = tip(), record(1.0, 0.01, points=20)
    settings = settings_of(body, free=["range"])
    objective = Objective(body, settings.parameters, points_of(curve, None, "all", 4, 0.0), np.ones(2))
    values = {"modulus": 1.0, "w": 0.0, "range": 1e-9, "delta0": 0.0, "P0": 0.0, "compliance": 0.0}
    minimum = Minimum(objective, objective.scaled(values), least=None)
    assert _meaning(minimum, objective.unknowns.at(values))["stress"] == -math.inf
    # Derivatives by it were 0/0.
    for law in (("range", "1e-25 m"), ("stress", "1e29 Pa")):
        with pytest.raises(InputError, match="which is adhesion without a range: leave stress and range out"):
            fit(tip(), record(1.0, 0.0, points=60), settings_of(tip(), fix=[law]))
    for free, fix, said in (
        (["range", "stress"], [], "range and stress are one quantity"),
        (["range", "E:base"], [], "E:base cannot be free together with a range of adhesion: fix E:base"),
        ([], [("range", "0")], "range: must be > 0, got 0"),
        (["range"], [("w", "0")], "needs w > 0"),
    ):
        with pytest.raises(InputError, match=said):
            settings_of(tip(), free, fix=fix)
    with pytest.raises(Refusal, match="give --surface sliding"):
        _ = tip().on_surface("sticking").attracted


@pytest.mark.parametrize("lam", [0.05, 1.0, 30.0])
def test_curves_are_those_of_maugis(lam: float) -> None:
    exact, body = states(lam), tip()
    kept = exact.a < 2.9 * LENGTH
    member = curve_of(body, lam)
    found = member.along(np.log(np.hypot(member.states.c0, exact.a[kept])))[0]
    for name, values in zip(("a", "delta", "P"), found, strict=True):
        theirs = getattr(exact, name)[kept]
        assert np.max(np.abs(values - theirs)) < 1e-6 * np.max(np.abs(theirs)), name  # measured: 3e-7


@pytest.mark.parametrize("lam", [0.05, 1.0, 30.0])
def test_derivatives_of_curves(lam: float) -> None:
    body = tip()
    member = curve_of(body, lam)
    u = np.linspace(*member.ends(0, 0, None), 100)[2:-2]
    _, first, _ = member.along(u)
    h = 1e-5
    by_place = (member.along(u + h)[0] - member.along(u - h)[0]) / (2 * h)
    assert np.allclose(by_place[1:], first[1:], rtol=0, atol=1e-7 * np.abs(first).max(axis=1)[1:, None])
    factor, rates = E_STAR / body.problem.E_star, member.rates(u)
    unit = np.max([np.abs(rates["w"][1:] * W).max(axis=1), np.abs(rates["range"][1:]).max(axis=1)], axis=0)[:, None]
    for name, middle in {"modulus": factor, "w": W, "range": truth(lam)["range"]}.items():
        high, low = (curve_of(body, lam, **{name: middle * math.exp(side)}).along(u)[0] for side in (1e-3, -1e-3))
        rate = rates[name][1:] * (W if name == "w" else 1)
        assert np.allclose((high - low)[1:] / 2e-3, rate, rtol=0, atol=1e-4 * unit), name  # measured: 2e-5


def test_a_curve_ends_where_the_profile_does_in_any_unit() -> None:
    """Rows whose annulus would reach beyond a sphere of nanometres used to stay, as 1e-8 m apart counted as equal."""
    ends = []
    for R in (1.0, 1e-8):
        problem = Problem(Sphere(R), Specimen((), HalfSpace(Elastic(1e6, 0.3))), Loading("radius", 0.6 * R, 60))
        series = Layered(1e-9)(problem).series
        found = FittedBody.of(problem, series, slopes(series, "exact")).attracted.states(0.1, 0.6 * R)
        ends.append((found.c0 / R, found.ends[1]))
    assert ends[0] == pytest.approx(ends[1], rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("columns", [("delta", "P"), ("a", "P"), ("a", "delta", "P")])
def test_exact_readings_give_all_three_back(columns: tuple[str, ...]) -> None:
    found = fit(tip(), record(0.3, 1e-5, columns), settings_of(tip(), ["range"]))
    for name in ("E_star", "w", "range"):
        assert found.value(name) == pytest.approx(truth(0.3)[name], rel=2e-4)  # measured: 4e-5
    assert found.jkr.rms > 100 * found.jkr.rms_of_range
    assert any("the best JKR curve" in line and "times the residuals" in line for line in found.warnings)


@pytest.mark.slow
def test_data_of_short_range_tell_none() -> None:
    found = fit(tip(), record(10.0, 0.01, points=120), settings_of(tip(), ["range"]))
    item = found.estimate("range")
    assert item.low == 0
    assert item.error is None
    assert item.high > truth(10.0)["range"]
    assert missed(found, 10.0) == []
    (line,) = (line for line in found.warnings if "a range is not significant" in line)
    assert re.search(r"significant \(it is at most .*\): the best JKR curve, .* leaves 1 times the residuals$", line)


def test_a_layer_on_which_surfaces_leap_together() -> None:
    layer = Specimen((Layer(Elastic(1 - 0.499**2, 0.499), 1.0),), Rigid())
    problem = Problem(Paraboloid(1000.0), layer, Loading("radius", 8.0, 100))
    solution = Layered(1e-9)(problem)
    body = FittedBody.of(problem, solution.series, slopes(solution.series, "exact"), True)
    w, law = 1e-4, Range.of(1e-4, stress=3.5 * (1e-4 / 1000) ** (1 / 3))
    exact = FiniteRangeBody.of(solution).curve(law)
    member = body.attracted.member({"modulus": 1.0, "w": w, "range": law.length})
    a = exact.touching.a[exact.touching.a > 2.5]
    found = member.along(np.log(np.hypot(member.states.c0, a)))[0]
    for name, values in zip(("delta", "P"), found[1:], strict=True):
        theirs = getattr(exact.touching, name)[exact.touching.a > 2.5]
        assert np.max(np.abs(values - theirs)) < 1e-4 * np.max(np.abs(theirs))
    low, high = member.ends(0, 0, None)
    assert math.log(member.states.c0) == pytest.approx(math.log(exact.touching.c[0]), abs=0.1)
    assert low < math.log(np.hypot(member.states.c0, a[0])) < math.log(np.hypot(member.states.c0, a[-1])) < high


@pytest.mark.first(1)
@pytest.mark.parametrize("length", [0.62, 0.1])
def test_a_flat_end_on_which_the_attraction_shrinks_as_contact_grows(length: float) -> None:
    """c falls with a at 0.62 um: such a range was refused; at 0.1 um splines through the rim erred by 0.5 %."""
    layer = Specimen((Layer(Elastic(1e6, 0.45), 1e-6),), Rigid())
    problem = Problem(RoundedFlat(1e-6, 0.6e-6), layer, Loading("radius", 1.4e-6, 60))
    solution = Layered(1e-9)(problem)
    body = FittedBody.of(problem, solution.series, slopes(solution.series, "exact"), True)
    exact = FiniteRangeBody.of(solution).curve(Range.of(0.025, length=length * 1e-6))
    member = body.attracted.member({"modulus": 1.0, "w": 0.025, "range": length * 1e-6})
    assert (np.diff(exact.touching.c) < 0).any() == (length > 0.1)
    a = exact.touching.a
    found = member.along(np.log(np.hypot(member.states.c0, a)))[0]
    for name, values in zip(("delta", "P"), found[1:], strict=True):
        theirs = getattr(exact.touching, name)
        assert np.max(np.abs(values - theirs)) < 1e-4 * np.max(np.abs(theirs)), name  # measured: 1.3e-5


def test_a_known_range_is_fixed_and_one_that_is_not_is_asked_for() -> None:
    length = truth(0.3)["range"]
    found = fit(tip(), record(0.3, 1e-3, points=120), settings_of(tip(), fix=[("range", repr(length))]))
    assert missed(found, 0.3, ("E_star", "w", "stress", "delta0")) == []
    assert found.estimate("w").error < 0.01 * W
    assert found.jkr.rms > 1.5 * found.jkr.rms_of_range
    found = fit(tip(), record(0.3, 1e-3, points=80), settings_of(tip()))
    assert any("Tabor number" in line and "fit with --free range" in line for line in found.warnings)


@pytest.mark.slow
def test_bounds_far_from_what_the_data_say_are_kept() -> None:
    """They were laid beside the reach of the search, which had no room left."""
    exact = record(1.0, 0.0, points=60)
    found = fit(tip(), exact, settings_of(tip(), ["range"], bound=[("range", "1 um..2 um")]))
    assert 0.999e-6 < found.estimate("range").value < 2.001e-6
    for name, ends in (("E_star", "1e18 Pa..1e19 Pa"), ("w", "..1e-20 J/m^2")):
        with pytest.raises(InputError, match=r"tip: (no curve of this body|the data reach|the best fit leaves)"):
            fit(tip(), exact, settings_of(tip(), bound=[(name, ends)]))


CASE = f"""
indenter = {{ shape = "paraboloid", radius = "20 nm" }}
specimen.half_space = {{ E = "{1.5 * E_STAR * 0.91} Pa", nu = 0.3 }}
loading.radius = "10 nm"
adhesion.w = "40 mJ/m^2"
"""


def written(curve: Curve) -> None:
    write_table("tip.csv", "delta_m,P_N", curve.delta, curve.P)


@pytest.mark.slow
def test_a_case_with_a_range_is_fitted_with_it(jkr) -> None:
    Path("afm.toml").write_text(CASE + f'adhesion.range = "{truth(0.3)["range"]!r} m"\n')
    written(record(0.3, 1e-3, points=120))
    estimates = jkr("fit", "afm.toml", "tip.csv", "--no-plots", "--json").told["curves"][0]["estimates"]
    assert estimates["range"]["free"] is False
    assert estimates["w"]["low"] < W < estimates["w"]["high"]
    jkr("fit", "afm.toml", "tip.csv", "--law", "power").refused("")
    free = jkr("fit", "afm.toml", "tip.csv", "--free", "range", "--no-plots", "--json", "--force")
    assert "the best JKR curve" in free.err
    (found,) = free.told["curves"]
    assert found["estimates"]["range"]["low"] < truth(0.3)["range"] < found["estimates"]["range"]["high"]
    assert (found["estimates"]["range"]["unit"], found["jkr"]["misfit"] > 1.5) == ("m", True)


def test_series_of_finite_elements_have_no_curves_of_finite_range(jkr) -> None:
    Path("afm.toml").write_text('method = "fem"\n' + CASE)
    written(record(0.3, 1e-3, points=120))
    assert jkr("run", "afm.toml", "-q").code == 0
    jkr("fit", "afm.h5", "tip.csv", "--free", "range", "--no-plots").refused("which the method fem does not have")


# ---------------------------------------------------------------------- raw records
RADIUS = 5e-6  # of the tip [m]


@dataclass(frozen=True, eq=False)
class Ranged:
    """Positions ``z`` [m] and loads ``P`` [N] of approach and retraction by a lever ``k`` [N/m], and the truth."""

    z: np.ndarray
    P: np.ndarray
    k: float
    tabor: float
    length: float
    truth: dict[str, float]


def both_sides(E: float, w: float, sigma: float) -> tuple[np.ndarray, np.ndarray]:
    """Displacements [m] and loads [N] from the first attraction on: without contact, then with it."""
    # A disc of tension sigma draws the surface up by 4 sigma c/(pi E*) at its rim and by 2 sigma c/E* in the middle,
    # until the gap at the rim is w/sigma; contact begins where the one in the middle is closed.
    c = np.linspace(0, 1, 4000) * 3 * math.sqrt(2 * RADIUS * w / sigma)
    before = c**2 / (2 * RADIUS) - 4 * sigma * c / (math.pi * E) - w / sigma, -math.pi * c**2 * sigma
    apart = -before[0] - 2 * sigma * c / E > 0
    end = int(np.argmin(apart)) if not apart.all() else c.size

    lam = 2 * sigma * (RADIUS / (math.pi * w * (4 * E / 3) ** 2)) ** (1 / 3)
    held = Maugis(RADIUS, E, w, lam, 1 + np.geomspace(1e5, 1e-9, 20000))
    return np.append(before[0][:end], held.delta), np.append(before[1][:end], held.P)


def drawn(seed: tuple[int, ...], tabor: float | None = None) -> Ranged:
    rng = np.random.default_rng(seed)
    tabor = 10 ** rng.uniform(-1, 2) if tabor is None else tabor
    E, radius = 10 ** rng.uniform(4, 6), RADIUS * rng.uniform(0.03, 0.12)
    w = 8 * E * radius**3 / (9 * math.pi * RADIUS**2)  # pulled off at that contact radius, if of no range
    length = (RADIUS * w**2 / E**2) ** (1 / 3) / tabor
    force, k = 1.5 * math.pi * w * RADIUS, 2 * E * radius * 10 ** rng.uniform(-1, 1)
    delta, P = both_sides(E, w, w / length)
    position, largest = delta + P / k, force * rng.uniform(1, 8)
    end = int(np.argmax(P > largest))
    position, P = position[:end], P[:end]
    # On the way in the first state of each position, on the way out the last one.
    reach, back = np.maximum.accumulate(position), np.minimum.accumulate(position[::-1])[::-1]
    turn, rows = float(position[-1]), int(10 ** rng.uniform(2.5, 3.5))
    far = min(float(position[0]), float(back[0])) - rng.uniform(0.5, 2) * (turn - float(back.min()))
    way = np.linspace(far, turn, rows)
    into = np.searchsorted(reach, way).clip(1, end - 1)
    out = np.searchsorted(back, way, side="right").clip(1, end - 1)

    def at(i: np.ndarray) -> np.ndarray:
        share = (way - position[i - 1]) / (position[i] - position[i - 1])
        return P[i - 1] + share.clip(0, 1) * (P[i] - P[i - 1])

    loads = [np.where(way < position[0], 0.0, at(into)), np.where(way < back[0], 0.0, at(out))]
    z = np.append(way, way[::-1])
    noise = force * 10 ** rng.uniform(-3, -1.5)
    read = np.append(loads[0], loads[1][::-1]) + noise * rng.normal(size=z.size)
    read += force * rng.uniform(-2, 2) + force / (turn - far) * rng.uniform(-0.1, 0.1) * z
    return Ranged(z, read, k, tabor, length, {"E_star": E, "w": w})


@pytest.fixture(name="body", scope="module")
def _body() -> FittedBody:
    specimen = Specimen((), HalfSpace(Elastic(1e5, 0.5)))
    return body_of(Problem(Paraboloid(RADIUS), specimen, Loading("depth", RADIUS / 10)))


def fitted(body: FittedBody, record: Ranged, **settings: object) -> Fit:
    return fit(body, read({"z": record.z, "P": record.P}, record.k), settings_of(body, **settings))


def half_widths_off(found: Fit, record: Ranged) -> float:
    """How many stated half-widths E* or w is off, whichever is more; 0 where none is stated."""
    most = 0.0
    for name, true in record.truth.items():
        value = found.estimate(name)
        if value.low is not None and value.high is not None:
            half = (value.high - value.low) / 2 + math.hypot(*(value.model or {}).values())
            most = max(most, abs(value.value - true) / half)
    return most


@pytest.mark.parametrize("tabor", [100.0, 0.3])
def test_a_known_range_of_a_raw_record_gives_e_and_w(body: FittedBody, tabor: float) -> None:
    """w was 0.13 to 0.21 of the true one, "fitted": the records took the road of tables' rows."""
    record = drawn((1, round(10 * tabor)), tabor)
    found = fitted(body, record, fix=[("range", repr(record.length))])
    assert found.value("w") == pytest.approx(record.truth["w"], rel=0.03)
    assert found.value("E_star") == pytest.approx(record.truth["E_star"], rel=0.03)


@pytest.mark.first(1)
@pytest.mark.parametrize("tabor", [0.5, 30.0])
def test_a_free_range_of_a_raw_record_is_flagged_or_right(body: FittedBody, tabor: float) -> None:
    record = drawn((2, round(10 * tabor)), tabor)
    found = fitted(body, record, free=["range"])
    assert found.flags or half_widths_off(found, record) < 3
    assert found.jkr is not None  # beside it, with what it leaves


def test_two_ranges_that_the_data_do_not_tell_apart_are_in_the_error(body: FittedBody) -> None:
    """One minimum leaves 0.3 of chi^2 more than the other, with w 10 % apart: only the other's error was stated."""
    record = drawn((3, 15))
    assert half_widths_off(fitted(body, record, free=["range"]), record) < 2

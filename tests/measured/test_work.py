"""The work of adhesion along measured data: exact on synthetic curves, one root or none, errors, the edge's speed."""

import csv
import functools
import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import described_body
import numpy as np
import pytest
from conftest import Outcome, write_table
from fit_data import adhesive
from hypothesis import given, settings
from hypothesis import strategies as st
from stated_errors import in_units
from widths import assert_neither_doubled_nor_halved, mean_squares

import jkrcli
from jkrcli.adhesion.curve import DISPLACEMENT_CONTROL, Nonadhesive, transform
from jkrcli.adhesion.device_path import cycle
from jkrcli.adhesion.slopes import slopes, smoothed
from jkrcli.base.errors import InputError
from jkrcli.bodies.indenters import FlatPunch, Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.case import store
from jkrcli.measured.curve import NOT_SUBTRACTED, Curve
from jkrcli.measured.work import ABOVE, BELOW, NONE, OK, PAIRS, rate, work_along
from jkrcli.methods.layered.solver import Layered
from jkrcli.resolve.analysis import analyse
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


def test_pull_off_of_the_classical_theory_in_any_units() -> None:
    # P = -1.5 pi w R at a^3 = 9 pi w R^2/(8 E*) (Johnson, Kendall and Roberts 1971) means w, wherever it is looked.
    E_star = 1e6 / (1 - 0.4**2)
    a = (9 * np.pi * W * R**2 / (8 * E_star)) ** (1 / 3)
    delta, _ = adhesive(np.array([a]), E_star, W, R)
    curve = Curve("c", a=np.array([a]), delta=delta, P=np.array([-1.5 * np.pi * W * R]))
    for use in PAIRS:
        found = work_along(body("half-space"), curve, use)
        # (delta, P): round-off of P_H - P - S (delta_H - delta), of three terms that nearly cancel
        np.testing.assert_allclose(found.w, W, rtol=1e-13)  # 3e-15 measured
        np.testing.assert_allclose(found.a, a, rtol=1e-13)
    length, force = 3.7e3, 2.9e-5
    held = body("coating")
    d, scaled = held.slopes, in_units(held.series, length, force)
    c = synthetic("coating")
    curve = Curve("c", a=c.a * length, delta=c.delta * length, P=c.P * force)
    for use in PAIRS:
        found = work_along(Nonadhesive(scaled, slopes(scaled)), curve, use)
        np.testing.assert_allclose(found.w, W * force / length, rtol=5e-12)  # 3e-13 measured
    assert d.method == "exact"


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
    curve = Curve("c", delta=np.array([1e-6, 1.0, 1.0]), P=np.array([1.0, 0.0, 0.0]), flags=(NOT_SUBTRACTED,))
    said = f"none of its 3 rows gives .*: 1 at or above .*, 2 at contact radii above 200 um.*; {NOT_SUBTRACTED}$"
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


# ---------------------------------------------------------------------- ``jkr work`` from files to files
CASE = """
indenter = { shape = "sphere", radius = "1 mm" }
specimen.layers = [{ thickness = "50 um", E = "1 MPa", nu = 0.499 }]
loading = { radius = "0.2 mm", points = 40 }
"""
GEL_W = 0.05
Run = Callable[..., Outcome]


@pytest.fixture(name="measured")
def _measured(jkr: Run) -> Path:
    """A series and the table of a retraction on it, in the folder of the test."""
    Path("gel.toml").write_text(CASE)
    assert jkr("run", "gel.toml", "--method", "layered").code == 0
    series = store.read_solution("gel.h5").series
    curve = transform(series, slopes(series), GEL_W)
    t = np.arange(len(series)) * 0.5
    table = np.stack([t, curve.a * 1e6, curve.delta * 1e6, curve.P * 1e3], axis=1)[::-1]
    table[:, 0] = t
    path = Path("m.csv")
    return write_table(path, "t_s,a_um,delta_um,P_mN", *table.T)


def table(path: str) -> dict[str, list[str]]:
    rows = list(csv.DictReader(Path(path).read_text().splitlines()))
    return {name: [row[name] for row in rows] for name in rows[0]}


@pytest.mark.first(1)
@pytest.mark.parametrize("use", ["delta,P", "a,P", "a,delta"])
def test_a_table_comes_back_with_w_and_speed(jkr: Run, measured: Path, use: str) -> None:
    done = jkr("work", "gel.h5", measured, "--use", use, "--noise", "P=1 nN", "--noise", "a=1 nm", "--no-plots")
    assert (done.code, done.out[:13]) == (0, "w = 50 mJ/m^2")
    assert done.out.splitlines()[0].endswith(", 40 of 40 rows: m.csv")
    found = table("m-work.csv")
    assert list(found)[:6] == ["curve", "segment", "state", "a_m", "w_J_per_m2", "w_err_J_per_m2"]
    np.testing.assert_allclose(np.array(found["w_J_per_m2"], float), GEL_W, rtol=5e-12)  # 3e-13
    np.testing.assert_allclose(np.array(found["speed_m_per_s"], float), -1e-5, rtol=1e-12)  # 5 um in 0.5 s
    summary = json.loads(Path("m-work.json").read_text())
    assert summary["curves"][0]["from"] == use.split(",")
    assert summary["curves"][0]["w"]["advancing"] is None
    assert summary["curves"][0]["w"]["receding"]["rows"] == 40
    assert summary["curves"][0]["w"]["all"]["err_by_noise_J_per_m2"] > 0
    assert summary["errors"]["smoothing"] < 1e-2
    assert not Path("m-work.png").exists()


def test_where_the_noise_is_not_known_and_rows_without_w(jkr: Run, measured: Path) -> None:
    done = jkr("work", "gel.h5", measured, "--no-plots")
    assert "no error of w: the noise is not known, give --noise" in done.out
    assert set(table("m-work.csv")["w_err_J_per_m2"]) == {""}
    spread = json.loads(Path("m-work.json").read_text())["curves"][0]["w"]["all"]
    assert spread["err_J_per_m2"] is None
    assert spread["err_by_slopes_J_per_m2"] > 0
    rows = measured.read_text().splitlines()
    rows[20] = "9.5,400,0,0"  # beyond the series
    measured.write_text("\n".join(rows) + "\n")
    assert jkr("work", "gel.h5", measured, "--no-plots").code == 0
    found = table("m-work.csv")
    assert found["state"][19] == "above the solution"
    assert (found["w_J_per_m2"][19], found["speed_m_per_s"][19], found["a_m"][19]) == ("", "", "0.0004")
    assert "nan" not in Path("m-work.csv").read_text()


def test_rows_of_a_segment_and_their_factors(jkr: Run, measured: Path) -> None:
    words = ("--factor", "P=2", "--modulus-factor", "2", "--no-plots", "--json")
    (summary,) = jkr("work", "gel.h5", measured, *words).told["results"]
    assert summary["modulus_factor"] == 2
    np.testing.assert_allclose(summary["curves"][0]["w"]["all"]["quartiles_J_per_m2"], 2 * GEL_W, rtol=5e-14)  # 2e-15
    header, *rows = measured.read_text().splitlines()
    told = [f"{row},{'approach' if i < 10 else 'retract'}" for i, row in enumerate(rows)]
    measured.write_text("\n".join([header + ",segment", *told]) + "\n")
    done = jkr("work", "gel.h5", measured, "--segment", "retract", "--no-plots").ok
    assert "30 of 30 rows" in done.out
    assert set(table("m-work.csv")["segment"]) == {"retract"}


def test_bad_curves_and_bad_files_among_many(jkr: Run, measured: Path) -> None:
    rows = measured.read_text().splitlines()
    lines = ["curve," + rows[0], *("good," + row for row in rows[1:]), *(f"bad,{i},900,1,1" for i in range(4))]
    Path("map.csv").write_text("\n".join(lines) + "\n")
    done = jkr("work", "gel.h5", "map.csv", "--no-plots").ok
    (skipped,) = json.loads(Path("map-work.json").read_text())["skipped"]
    assert skipped.startswith(
        'map.csv: curve "bad": none of its 4 rows gives a work of adhesion: 4 at contact radii above'
    )
    assert f"jkr: warning: skipped: {skipped}\n" in done.err
    assert set(table("map-work.csv")["curve"]) == {"good"}
    Path("lame.csv").write_text("\n".join([lines[0], *lines[-4:]]) + "\n")
    jkr("work", "gel.h5", "lame.csv", "--no-plots").refused(skipped.replace("map.csv", "lame.csv"))


MISTAKES = {
    ("--window", "4"): "--window: must be an odd number of rows, at least 5, got 4",
    ("--noise", "w=1"): 'must be KEY=VALUE with a key of a, delta, P, got "w=1"',
    ("--zero", "a=1"): 'must be KEY=VALUE with a key of delta, P, got "a=1"',
    ("--stiffness", "0"): 'must be > 0 or "rigid", got 0',
    ("m.csv",): "m-work.csv: would be written twice",
}


@pytest.mark.parametrize("flags", MISTAKES, ids=" ".join)
def test_mistakes_of_the_command_are_told_in_one_line(jkr: Run, measured: Path, flags: tuple[str, ...]) -> None:
    jkr("work", "gel.h5", measured, *flags).refused(MISTAKES[flags])
    assert not list(Path().glob("m-work*"))


RAW = Path(__file__).parents[2] / "cases" / "measured" / "raw-force-curve.txt"


def test_a_raw_record_is_zeroed_by_its_fit(jkr: Run) -> None:
    """Read as it stands, the record says 102 J/m^2; w is 1 mJ/m^2 on its way out and 0.2 mJ/m^2 on its way in."""
    Path("gel.toml").write_text(
        described_body.CASE.format(shape="sphere").replace("1 um", "2 um").replace("100 kPa", "150 kPa")
    )
    assert jkr("run", "gel.toml").code == 0
    for segment, w, other in (("retract", 1e-3, "advancing"), ("approach", 0.2e-3, "receding")):
        (found,) = jkr("work", "gel.h5", str(RAW), "--segment", segment, "--json", "--no-plots", "-o", segment).told[
            "results"
        ]
        assert found["curves"][0]["w"]["all"]["median_J_per_m2"] == pytest.approx(w, rel=0.05)
        assert found["curves"][0]["w"][other] is None
        rows = table(f"{segment}/raw-force-curve-work.csv")
        off, half = (np.array(rows[name], float) for name in ("w_J_per_m2", "w_err_J_per_m2"))
        z = 1.96 * (off - np.median(off)) / half  # the noise of the base line is that of the rows
        assert 0.6 < np.sqrt(np.mean(z**2)) < 1.5


# ---------------------------------------------------------------------- a sharp-edged flat punch
PUNCH = ("--shape", "flat", "--radius", "1 mm", "--E", "1 MPa")


def works(jkr: Callable, *options: str, load: str = "50 mN") -> dict:
    return jkr("pull-off", *PUNCH, "--load", load, *options, "--json").told["results"][0]


@pytest.mark.first(1)
@pytest.mark.parametrize("device", ["load", "1e4 N/m", "rigid"])
def test_work_of_a_pull_off_force_is_the_same_by_any_device(jkr: Callable, device: str) -> None:
    """Whatever holds a full end measures the load at which G = w at its rim."""
    options = () if device == "load" else ("--stiffness", device)
    layer = works(jkr, "--nu", "0.49", "--thickness", "100 um", *options)
    assert layer["pull_off"]["a_m"] == 1e-3
    assert layer["w_J_per_m2"] == pytest.approx(1.692e-3, rel=1e-3)
    half_space = works(jkr, "--nu", "0.5", *options)
    assert half_space["w_J_per_m2"] == pytest.approx(0.05**2 / (8 * math.pi * 1e6 / 0.75 * 1e-9), rel=1e-9)


def test_uncertain_radii_and_records_of_a_punch(jkr: Callable) -> None:
    # w = P^2/(8 pi E* R^3): 3 times the error of R, 2 times that of the load.
    found = works(jkr, "--nu", "0.5", "--uncertain", "R=1%", "--uncertain", "load=1%")
    w, parts = found["w_J_per_m2"], found["w_err_by_input_J_per_m2"]
    assert parts["R"] / w == pytest.approx(3 * 1.96 * 0.01, rel=5e-3)
    assert parts["load"] / w == pytest.approx(2 * 1.96 * 0.01, rel=5e-3)
    Path("record.csv").write_text("delta (um),P (mN)\n" + "".join(f"{i},{i * 0.1}\n" for i in range(1, 30)))
    err = jkr("fit", "record.csv", "--shape", "flat", "--radius", "1 mm", "--nu", "0.5").err
    assert "records of a flat punch are not fitted" in err
    assert "jkr pull-off --load" in err


@pytest.mark.parametrize("names", [("a_m", "P_N"), ("delta_m", "P_N"), ("a_m", "delta_m")])
def test_work_along_a_punch_leaves_the_pinned_edge_out(jkr: Callable, names: tuple[str, ...]) -> None:
    """The receding edge has G = w; while it is pinned at the rim G <= w, which only bounds w from below."""
    specimen = jkrcli.Specimen((jkrcli.Layer(jkrcli.Elastic(1e6, 0.5), 1e-3),))
    solution = jkrcli.solve(
        jkrcli.Problem(FlatPunch(5e-3), specimen, jkrcli.Loading("radius", 5e-3, 100, "log")), "layered"
    )
    curve = analyse(solution, [0.05])[0].curve
    rows = cycle(curve, curve, DISPLACEMENT_CONTROL).path.rows(50)
    pressed = rows["delta_m"] > 0.5 * np.max(rows["delta_m"])  # as far under compression as pulled: left out
    rows = {name: column[~pressed] for name, column in rows.items()}
    jkrcli.save(solution, "punch.h5")
    stretches = {"whole": np.full(rows["a_m"].size, True), "pinned": rows["a_m"] == 5e-3}
    for file, chosen in stretches.items():
        header = ",".join(name.replace("_m", " (m)").replace("_N", " (N)") for name in names)
        np.savetxt(f"{file}.csv", np.column_stack([rows[name][chosen] for name in names]), "%.17g", ",", header=header,
                   comments="")  # fmt: skip
    found = jkr("work", "punch.h5", "whole.csv", "--no-plots", "--json").told["results"][0]["curves"][0]
    assert found["rows"]["pinned at the rim"] >= np.count_nonzero(stretches["pinned"])
    assert found["w_least_J_per_m2"] == pytest.approx(0.05, rel=1e-6)
    assert found["w"]["all"]["quartiles_J_per_m2"] == pytest.approx([0.05, 0.05], rel=1e-6)
    jkr("work", "punch.h5", "pinned.csv", "--no-plots").refused("pinned at the rim: G <= w, at least 50 mJ/m^2")
    assert not Path("pinned-work.csv").exists()


@pytest.mark.first(1)
@pytest.mark.parametrize("stiffness", ["1 kN/m", "load", "rigid"])
def test_w_from_pull_off_from_a_layer_is_the_one_that_makes_it(jkr: Callable, stiffness: str) -> None:
    layer = ["--thickness", "0.5 mm", "--stiffness", stiffness]
    found = jkr("pull-off", *PUNCH, "--nu", "0.5", *layer, "--w", "0.05", "--json").told["results"][0]
    force = -found["controls"][0]["pull_off"]["P_N"]
    assert works(jkr, "--nu", "0.5", *layer, load=f"{force!r} N")["w_J_per_m2"] == pytest.approx(0.05, rel=1e-7)

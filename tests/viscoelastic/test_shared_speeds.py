"""Force curves at several speeds fitted together, w over the speed of the edge among the unknowns, to records of other
equations (``adhesive_curves.py``); names of spring and dashpot models."""

import csv
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import described_body
import numpy as np
import pytest
from adhesive_curves import Made, cycle, sampled, solid
from conftest import write_table

import jkrcli as jkr
from jkrcli.adhesion.finite_range import AttractedBody
from jkrcli.base.errors import InputError
from jkrcli.measured.curve import Curve
from jkrcli.measured.forward_model import FittedBody, body_of
from jkrcli.viscoelastic import rheology, shared_speeds
from jkrcli.viscoelastic.edge_speed import EdgeLaws, law_over
from jkrcli.viscoelastic.lockstep_march import March, Trial
from jkrcli.viscoelastic.shared_speeds import shared_speeds_fit
from jkrcli.viscoelastic.timed_record import UNSETTLED, relaxation_settings
from jkrcli.viscoelastic.whole_record import recovers

CASE = described_body.UNIT.format(depth=0.15)
W, STRESS, STIFFNESS, ZERO = 0.01, 0.3, 2.0, 0.03
RATE = jkr.PowerRate(2.0, 0.4)
TRUE = {"E_star": 1.0, "ratio": 0.4, "time": 1.0, "w": W, "stress": STRESS, "v0": 2.0, "n": 0.4}
TRIAL = Trial(W, STRESS, STIFFNESS, jkr.StandardSolid(0.4, 1.0).modes(3.0))
CORNERS = ((0.0, -0.15), (0.5, 0.1), (1.5, 0.1), (3.5, -0.9))


@pytest.fixture(scope="module", name="body")
def _body() -> FittedBody:
    return body_of(jkr.parse_case(CASE)).to_depth(0.4)


def marched(body: FittedBody, trial: Trial) -> object:
    t, z = np.array(CORNERS).T
    return March(body.problem, AttractedBody(body.problem), [trial], (t, z), 0.005).run()[0]


def record(speed: float, hold: float, seed: int, noise: float = 0.01, rows: int = 400) -> Curve:
    """The readings at one speed of the device, with free rows before and behind."""
    corners = [(0.0, -0.15), (0.25 / speed, 0.1), (0.25 / speed + hold, 0.1), (2.85 / speed + hold, -2.5)]
    corners = corners if hold else [corners[0], corners[1], corners[3]]
    made = cycle(W, STRESS, solid(0.4, 1.0), corners, STIFFNESS, fine=0.5, rate=(RATE.v0, RATE.n))
    lasting = made.lost - made.begun
    before = min(0.3, 0.1 / speed / lasting)
    t = made.begun + lasting / rows * np.arange(-int(before * rows), int(1.3 * rows))
    z = np.interp(t, *np.array(corners).T)
    P = sampled(made, t) - noise * made.P.min() * np.random.default_rng(seed).standard_normal(t.size)
    return Curve(f"v{speed:g}", t=t - t[0], delta=z - P / STIFFNESS + ZERO, P=P, stiffness=STIFFNESS)


# --------------------------------------------------------------------------------------------------
def test_a_march_with_w_over_speed_is_that_of_other_equations(body: FittedBody) -> None:
    made: Made = cycle(W, STRESS, solid(0.4, 1.0), CORNERS, STIFFNESS, fine=0.5, rate=(RATE.v0, RATE.n))
    found = marched(body, with_rate(RATE))
    apart = (np.abs(made.t - made.begun) > 0.01) & (made.t < made.lost - 0.03)
    off = np.abs(found.load(made.t) - made.P)[apart] / -made.P.min()
    assert np.sqrt(np.mean(off**2)) < 1e-3  # found: 1e-4 to 4e-4
    assert found.lost == pytest.approx(made.lost, abs=3e-3)
    assert made.P.min() < 1.3 * marched(body, TRIAL).rows[:, 4].min()  # the law matters
    slow, even = marched(body, with_rate(jkr.PowerRate(1e30, 1.0))), marched(body, TRIAL)
    t = np.linspace(0.3, 1.9, 50)
    np.testing.assert_allclose(slow.load(t), even.load(t), rtol=1e-3, atol=1e-6)


def with_rate(rate: object) -> Trial:
    return Trial(W, STRESS, STIFFNESS, TRIAL.modes, 0.0, rate)


@pytest.mark.parametrize("law", [jkr.PowerRate(0.3, 0.4), jkr.LogRate(0.3, 0.02)])
def test_tables_of_laws_are_the_laws(law: object) -> None:
    laws, v, rows = EdgeLaws.of([law], np.array([W]), 1.0), np.geomspace(1e-3, 1e6, 40), np.zeros(40, dtype=int)
    found, by = laws.at(rows, v)
    np.testing.assert_allclose(found, np.log(law.work(W, v) / W), rtol=1e-3)
    np.testing.assert_allclose(by * v, (laws.at(rows, v * 1.03)[0] - laws.at(rows, v / 1.03)[0]) / 0.0591, rtol=0.03)
    assert not laws.at(rows, -v)[0].any()  # an edge that closes


def test_a_curve_without_an_approach(body: FittedBody) -> None:
    curve = record(2.0, 0.0, 1)
    half = replace(curve.rows(np.arange(int(np.argmax(curve.device)), len(curve))), name="half")
    with pytest.raises(InputError, match="half: force curves with approach and retraction are fitted together"):
        shared_speeds_fit(body, [curve, half], relaxation_settings("sls", rate="power"))


def test_what_is_shared_by_default_and_laws_over_the_modulus() -> None:
    assert relaxation_settings("sls", rate="power").own == ("delta0", "P0", "tilt")
    assert "w" in relaxation_settings("sls", free=["w"], shared=["E_star", "ratio", "time", "stress"]).own
    assert relaxation_settings("sls", rate="power", fix=[("w0", "2 J/m^2")]).fixed["w"] == 2.0
    assert law_over("log", {"v0": 2.0, "b": 6.0}, 3.0) == jkr.LogRate(2.0, 2.0)
    assert law_over("power", {"v0": 2.0, "n": 0.5}, 3.0) == jkr.PowerRate(2.0, 0.5)
    t = np.arange(6.0)
    assert recovers(t, np.array([0, 1, -4.0, -4.0, 0, 0]), 4.0) == pytest.approx(3.5)
    assert math.isinf(recovers(t, np.array([0, 1, 0, -4.0, -4.0, -4.0]), 4.0))
    assert math.isinf(recovers(t, np.zeros(6), 0.0))


# --------------------------------------------------------------------------------------------------
@pytest.mark.slow
def test_three_speeds_together(body: FittedBody) -> None:
    curves = [record(speed, hold, i) for i, (speed, hold) in enumerate([(0.1, 0.0), (0.8, 1.0), (6.0, 0.0)])]
    fit = shared_speeds_fit(body, curves, relaxation_settings("sls", rate="power"))
    for name, value in TRUE.items():
        assert abs(fit.value(name) - value) < 3.5 * (fit.estimate(name).error or 0), name
        assert (fit.estimate(name).error or 1) < 0.2 * value, name
    assert 0.9 < fit.scatter < 1.1
    found = rheology.rheology(fit.fits[0])
    assert found["E_inf"][1] < 0.4 < found["E_inf"][2]
    assert found["retardation_time"][1] < 2.5 < found["retardation_time"][2]


@pytest.fixture(scope="module", name="two")
def _two() -> list[Curve]:
    return [record(speed, 1.0, i) for i, speed in enumerate((0.2, 2.0))]


@pytest.mark.slow
def test_a_search_that_is_cut_short_says_so(
    body: FittedBody, two: list[Curve], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("APPROACHED", "SEARCHED", "FOLLOWED", "ROUNDS"):
        monkeypatch.setattr(shared_speeds, name, 1)
    monkeypatch.setattr(shared_speeds, "FINE", (*shared_speeds.FINE[:2], 1))
    said = list[str]()
    fit = shared_speeds_fit(body, two, relaxation_settings("sls", rate="power"), lambda what, _: said.append(what))
    assert said == ["fit of 2 force curves together"]
    assert any(UNSETTLED in line for line in fit.warnings)
    assert all(UNSETTLED in one.doubts for one in fit.fits)
    assert "doubtful" in fit.words()[0]


@pytest.mark.slow
def test_the_command(jkr: Callable, tmp_path: Path, two: list[Curve]) -> None:
    (tmp_path / "gel.toml").write_text(CASE)
    for i, curve in enumerate(two):
        write_table(f"v{i}.csv", "t_s,delta_m,P_N", curve.time, curve.depth, curve.load)
    found = jkr("fit", "gel.toml", "v0.csv", "v1.csv", "--relaxation", "sls", "--law", "power", "--fix", "n=0.4",
               "--json").told  # fmt: skip
    assert found["rate"]["law"] == "power"
    w = found["estimates"]["w"]
    assert abs(w["value"] - W) < 4 * w["standard_error"]
    assert set(found["fits"][0]["rheology"]) == {"E_inf", "Maxwell_E2", "Maxwell_eta", "KelvinVoigt_E2",
                                                 "KelvinVoigt_eta", "retardation_time"}  # fmt: skip
    with (tmp_path / "gel-fit.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["curve"] for row in rows] == ["v0.csv", "v1.csv"]
    for name in ("w_J_per_m2", "v0_m_per_s"):
        assert rows[0][name] == rows[1][name]
    assert float(rows[0]["Maxwell_eta_Pa_s"]) > 0


# ---------------------------------------------------------------------- names of spring and dashpot models
def test_names_of_springs_and_dashpots() -> None:
    # The modulus of one form times the compliance of the other is 1 at any rate s.
    E_inf, E2, eta, series, viscosity, retardation = rheology.values_of("sls", {"ratio": 0.25, "time": 3.0}, 2.0)
    assert (E_inf, E2, eta, retardation) == pytest.approx((0.5, 1.5, 4.5, 12.0))
    for s in (0.01, 0.3, 20.0):
        modulus = E_inf + E2 * s / (s + E2 / eta)
        assert modulus * (1 / 2.0 + 1 / (series + viscosity * s)) == pytest.approx(1)
    assert rheology.values_of("power", {"time": 0.01, "exponent": 0.2}, 5.0) == [pytest.approx(5 * 0.01**0.2), 0.2]
    p = {"weight1": 0.25, "time1": 2.0, "weight2": 0.5, "time2": 8.0}
    assert rheology.values_of("prony", p, 4.0) == pytest.approx([1, 1, 2, 2, 16])


@pytest.mark.parametrize("ratio", [0.0, 1.0])
def test_a_body_that_relaxes_altogether_or_not_at_all_has_no_kelvin_voigt_element(ratio: float) -> None:
    left, lost, eta, *element = rheology.values_of("sls", {"ratio": ratio, "time": 3.0}, 2.0)
    assert (left, lost, eta) == pytest.approx((2 * ratio, 2 - 2 * ratio, 6 - 6 * ratio))
    assert all(map(math.isnan, element))

"""Fits of whole force curves that adhere on bodies that relax, to records of other equations
(``adhesive_curves.py``)."""

import csv
import math
import pickle
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import described_body
import numpy as np
import pytest
from adhesive_curves import Law, Made, cycle, power, sampled, solid
from conftest import write_table
from scipy.special import dawsn

import jkrcli as jkr
from jkrcli.adhesion.finite_range import AttractedBody, RangeRequest
from jkrcli.base.errors import InputError, SolveError
from jkrcli.bodies.problem import Modes
from jkrcli.measured.curve import SUBTRACTED_TWICE, Curve
from jkrcli.measured.forward_model import FittedBody, body_of
from jkrcli.measured.procedure import fit
from jkrcli.measured.report import alternatives_table, verdict_words
from jkrcli.measured.result import Fit
from jkrcli.measured.settings import settings_of
from jkrcli.viscoelastic import adhesive_fit, fits, lockstep_march, timed_record
from jkrcli.viscoelastic.adhesive_fit import ElasticLimits
from jkrcli.viscoelastic.law_posterior import Nearby
from jkrcli.viscoelastic.lockstep_march import March, Marched, Trial, passing
from jkrcli.viscoelastic.relaxation_fit import relaxation_fit
from jkrcli.viscoelastic.relaxing_adhesion import creep
from jkrcli.viscoelastic.relaxing_alternative import RELAXING
from jkrcli.viscoelastic.timed_record import RelaxationFit, relaxation_at, relaxation_settings
from jkrcli.viscoelastic.whole_record import Cycle

W, STRESS, SOLID = 0.01, 0.3, solid(0.3, 1.0)
CORNERS = ((0.0, -0.15), (0.5, 0.1), (1.5, 0.1), (2.6, -0.45))
ROOT = Path(__file__).parents[2]
CASE = described_body.UNIT.format(depth=0.15)


@pytest.fixture(scope="module", name="body")
def _body() -> FittedBody:
    return body_of(jkr.parse_case(CASE))


def layered(h: float = 0.5) -> FittedBody:
    specimen = jkr.Specimen((jkr.Layer(jkr.Elastic(0.75, 0.5), h),), jkr.Rigid(True))
    return body_of(jkr.solve(jkr.Problem(jkr.Paraboloid(1.0), specimen, jkr.Loading("depth", 0.15))))


def march(body: FittedBody, law: Law, stress: float, stiffness: float, width: float = 0.005) -> tuple[Made, np.ndarray]:
    """A cycle by the other equations, and its loads by a march, over its pull-off force at most so far apart."""
    nu, h = (None, 1.0) if not body.problem.specimen.layers else (0.5, 0.5)
    made = cycle(W, stress, law, CORNERS, stiffness, nu, h)
    t, z = np.array(CORNERS).T
    trial = Trial(W, stress, stiffness, jkr.StandardSolid(law.relaxed, 1 / law.rates[0]).modes(3.0))
    (found,) = March(body.problem, AttractedBody(body.problem), [trial], (t, z), width).run()
    apart = (np.abs(made.t - made.begun) > 0.01) & (np.abs(made.t - made.lost) > 0.01)
    assert found.begun == pytest.approx(made.begun, abs=1e-6)
    assert found.lost == pytest.approx(made.lost, abs=2e-3)
    return made, np.abs(found.load(made.t) - made.P)[apart] / -made.P.min()


def readings(
    made: Made, before: float, behind: float, noise: float = 0.01, k: float = math.inf, rows: int = 400
) -> Curve:
    """The readings of a cycle with base lines, lengths over the time in contact; its noise is always that."""
    lasting = made.lost - made.begun
    dt = lasting / rows
    n, m = int(before * rows), int(behind * rows)
    t = made.begun + dt * (np.arange(-n, rows + m) + 0.5)
    ends, z = np.array(CORNERS).T
    speed = z[1:] - z[:-1]
    slopes = speed / np.diff(ends)
    z = np.interp(t, ends, z) + np.minimum(t - ends[0], 0) * slopes[0] + np.maximum(t - ends[-1], 0) * slopes[-1]
    size = noise * -float(made.P.min())
    P = sampled(made, t) + np.concatenate([
        size * np.random.default_rng(seed).standard_normal(count) for seed, count in ((2, n), (3, rows), (4, m))
    ])  # fmt: skip
    stiffness = None if math.isinf(k) else k
    return Curve("made", t=t - t[0], delta=z - P / k + 0.03, P=P, stiffness=stiffness)


@cache
def usual() -> Made:
    return cycle(W, STRESS, SOLID, CORNERS, 2.0)


def off(fit: RelaxationFit, **true: float) -> float:
    """The largest distance from the truth in standard errors."""
    return max(abs(fit.value(name) - value) / (fit.estimate(name).error or 0) for name, value in true.items())


# --------------------------------------------------------------------------------------------------
def test_a_march_is_that_of_other_equations(body: FittedBody) -> None:
    _, missed = march(body, SOLID, STRESS, 2.0)
    assert np.sqrt(np.mean(missed**2)) < 1e-3  # found: 2e-4
    # JKR: 1.5 pi w R, whatever the modulus.
    elastic = ElasticLimits(body.to_depth(0.4).nonadhesive)
    assert elastic.work(3.0, 1.5 * np.pi * 1e-3) == pytest.approx(1e-3, rel=0.01)


@pytest.mark.first(1)
@pytest.mark.parametrize(("width", "most"), [(0.01, 0.01), (0.005, 0.0072)])
def test_a_narrow_zone_is_made_up_for(body: FittedBody, width: float, most: float) -> None:
    """The zone followed is a dozen times as wide as the true one; half as wide it errs by half as much."""
    _, missed = march(body, SOLID, 2.0, 2.0, width)
    assert np.sqrt(np.mean(missed**2)) < most  # found: 9e-3


def test_loads_between_steps_are_smooth_but_at_corners() -> None:
    """Twice as many steps err an eighth as much or less; before contact and behind its end loads rest."""

    def error(steps: int) -> float:
        t = np.concatenate([np.linspace(0, 1, steps), np.linspace(1, 3, steps)[1:]])
        P = np.where(t < 1, np.exp(t), math.e * np.exp(2 * (1 - t)))  # a corner at 1
        rows = np.stack([t, t, t, t, P], axis=1)
        found = Marched(rows, 0.0, math.inf, np.array([0.0, 1.0, 3.0]), False).load(between)
        return float(np.max(np.abs(found - np.where(between < 1, np.exp(between), math.e * np.exp(2 * (1 - between))))))

    between = np.linspace(0, 3, 997)
    assert error(21) < 2e-3
    assert error(41) < error(21) / 7
    outside = Marched(np.array([[1.0, 0, 0, 0, 2.0], [2.0, 0, 0, 0, 5.0]]), 1.0, math.inf, np.array([0.0, 3.0]), False)
    assert outside.load(np.array([0.5, 1.5, 2.5])).tolist() == [0.0, 3.5, 5.0]
    assert replace(outside, rows=np.array([[math.inf, 0, 0, 0, 0.0]])).load(np.ones(2)).tolist() == [0.0, 0.0]


@pytest.mark.parametrize("stress", [STRESS, 8 * STRESS])  # of a zone that is followed, and of a narrower one
def test_a_solid_that_keeps_all_of_its_modulus_is_elastic(body: FittedBody, stress: float) -> None:
    t, z = np.array(CORNERS).T
    modes = [jkr.StandardSolid(1.0, time).modes(3.0) for time in (0.1, 7.0)]
    one, other = (
        March(body.problem, AttractedBody(body.problem), [Trial(W, stress, 2.0, mode)], (t, z)).run()[0]
        for mode in modes
    )
    np.testing.assert_array_equal(one.rows, other.rows)
    assert len(one.rows) > 50


def test_names_of_settings() -> None:
    # J = 1 + (1/ratio - 1)(1 - exp(-t/retardation)) over that at t = 0; the element alone is E_0 ratio/(1 - ratio).
    modes = jkr.KelvinVoigtSolid(ratio=0.4, retardation=5.0).modes(1.0)
    rest, weights, rates = creep(modes)
    assert (rest, *weights, *rates) == pytest.approx((2.5, 1.5, 0.2))
    assert (modes.relaxed, *modes.rates) == pytest.approx((0.4, 0.5))
    assert relaxation_settings("kelvin-voigt", free=["w"]) == relaxation_settings("sls", free=["w"])
    settings = relaxation_settings("sls", free=["w"], ranged=RangeRequest(None, 1e-9))
    assert settings.fixed == {"range": 1e-9}
    assert relaxation_settings("sls", free=["w", "stress"], ranged=RangeRequest(None, 1e-9)).fixed == {}


def test_cracks_pass_at_both_ends_of_speeds() -> None:
    # Nothing of exp(-q t) is gone of a zone that passes at once, all of a slow one; between both the opening is by
    # quadrature of (2/y) int D.
    fast, slow = passing(np.array([1e-9])), passing(np.array([1e9]))
    assert [float(one[0]) for one in fast] == pytest.approx([1e-9 / 3, 1e-9, 2e-9 / 3], rel=1e-6)
    assert [float(one[0]) for one in slow] == pytest.approx([1, 1, 1], abs=1e-3)
    q = np.linspace(0, 2, 20001)
    assert passing(np.array([4.0]))[0][0] == pytest.approx(1 - 0.5 * np.trapezoid(dawsn(q), q), rel=1e-4)
    for one in passing(np.array([0.5 - 1e-9, 0.5 + 1e-9])):
        assert one[1] == pytest.approx(one[0], rel=1e-5)
    # Nothing is gone of a crack at once, however much the body relaxes in the end: J_inf = 1000 here.
    _, c, q = creep(Modes(1e-3, np.array([0.999]), np.array([1.0])))
    assert c.sum() == pytest.approx(999, rel=1e-6)
    opening = passing(np.multiply.outer(np.geomspace(1e-7, 1e-3, 50), q))[0] @ c
    assert (np.diff(opening) > 0).all()
    assert opening[0] == pytest.approx(1e-7 / 3, rel=2e-3)


def test_laws_at_many_parameters_are_those_of_each(monkeypatch: pytest.MonkeyPatch) -> None:
    t = np.geomspace(0.1, 3, 5)
    laws = {
        "sls": ({"ratio": 0.3, "time": 0.5}, jkr.StandardSolid(0.3, 0.5)),
        "power": ({"exponent": 0.2, "time": 1.0, "onset": 0.01}, jkr.PowerRelaxation(1.0, 0.2, 0.01)),
        "prony": ({"weight1": 0.2, "time1": 0.5, "weight2": 0.3, "time2": 2.0}, jkr.Prony((0.2, 0.3), (0.5, 2.0))),
    }
    for name, (values, law) in laws.items():
        np.testing.assert_allclose(relaxation_at(t, name, values), law.modes(3.0)(t), rtol=1e-8)

    @dataclass(frozen=True)
    class Own:
        time: float

        def modes(self, lasting: float) -> Modes:
            return Modes(0.0, np.ones(1), np.array([1 / self.time]))

    monkeypatch.setattr(timed_record, "RELAXATIONS", {"own": Own})
    t, times = np.geomspace(0.1, 3, 5), np.array([0.5, 2.0, 7.0])
    np.testing.assert_allclose(relaxation_at(t, "own", {"time": times}), np.exp(-t / times[:, None]), rtol=1e-12)


@pytest.mark.parametrize(("before", "behind"), [(0.3, 0.3), (2.0, 0.5)])
def test_free_rows_are_found_with_jumps(before: float, behind: float) -> None:
    made = usual()
    found = Cycle.of(readings(made, before, behind, k=2.0))
    dt = (made.lost - made.begun) / 400
    assert found.jumps[0] == pytest.approx(before * 400 * dt, abs=2 * dt)
    assert found.jumps[1] - found.jumps[0] == pytest.approx(400 * dt, abs=2 * dt)
    assert found.base[0] == pytest.approx(0, abs=0.01 * -made.P.min())
    np.testing.assert_allclose(np.diff(found.program[1]), [0.1 - found.z[0] + 0.03, 0, found.z[-1] - 0.13], atol=1e-6)


def test_unloadings_in_contact_and_levers_of_the_tip() -> None:
    whole = readings(usual(), 0.5, 0.5, k=2.0)
    assert Cycle.of(whole.rows(np.arange(200 + 300))).held
    assert not Cycle.of(whole).held
    assert Cycle.of(replace(whole, stiffness=None)).stiffness == pytest.approx(2.0, rel=1e-3)


@pytest.mark.parametrize(("law", "asked", "line"), [
    ("sls", {"fix": [("stress", "2 Pa")]}, "stress: of a relaxing body it goes with w"),
    ("power", {"fix": [("modulus", "2")], "free": ["w"]}, "modulus: of a power law it is free with w"),
    ("power", {"fix": [("onset", "1 s")]}, "onset: what jumps of the contact show: it goes with w"),
    ("sls", {"fix": [("stress", "2 Pa"), ("range", "1 um")], "free": ["w"]}, "stress and range are one parameter"),
    ("sls", {"free": ["w", "streess"]}, 'unknown parameter "streess", did you mean "stress"'),
    ("sls", {"fix": [("w", "20 mJ/m^2")], "free": ["w"]}, "w is both free and fixed"),
    ("sls", {"free": ["w"], "confidence": "profile"}, "--confidence profile: intervals of force curves that adhere"),
    ("sls", {"free": ["w"], "shared": ["delta0"]}, "delta0: is each force curve's own"),
    ("sls", {"free": ["w"], "shared": ["w"], "own": ["w"]}, "w: is each force curve's own"),
    ("sls", {"free": ["w"], "shared": ["wo"]}, 'unknown parameter "wo"'),
    ("sls", {"shared": ["E_star"]}, "--shared: force curves are fitted together with w: add --free w"),
    ("sls", {"rate": "power", "segment": "retract"}, "--segment retract: whole force curves are fitted together"),
])  # fmt: skip
def test_what_is_not_asked_so(law: str, asked: dict, line: str) -> None:
    with pytest.raises(InputError, match=line):
        relaxation_settings(law, **asked)


def test_records_without_adhesion_or_of_a_prescribed_load(body: FittedBody) -> None:
    t, noise = np.linspace(0, 3, 120), 1e-3 * np.random.default_rng(1).standard_normal(120)
    depth = np.interp(t, [0, 1, 2, 3], [-0.1, 0.1, 0.1, -0.1])
    for delta, P, said in (
        (depth, np.maximum(depth, 0) ** 1.5 + noise, "w: no adhesion shows"),
        (0.1 * np.sin(t) + noise, np.interp(t, [0, 1, 3], [0, 0.05, -0.02]), "here the load is prescribed"),
    ):
        with pytest.raises(InputError, match=said):
            relaxation_fit(body, Curve("made", t=t, delta=delta, P=P), relaxation_settings("sls", free=["w"]))
    t = np.linspace(0, 6, 600)
    z = -0.2 * np.cos(math.pi / 3 * t)
    P = np.where(z > 0, z, 0) ** 1.5 + 1e-4 * np.random.default_rng(1).standard_normal(t.size)
    assert not Cycle.of(Curve("made", t=t, delta=z, P=P)).load_is_prescribed


def test_marches_that_find_no_state(body: FittedBody, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where it is cut, and beyond its grid: extrapolated far it once asked for a radius that this does not hold."""
    t, z = np.array(CORNERS).T
    trial = Trial(W, STRESS, 2.0, jkr.StandardSolid(0.3, 1.0).modes(3.0))
    one = March(body.problem, AttractedBody(body.problem), [trial], (t, z))
    one.run()
    rows = np.array([0])
    one._step(rows, np.zeros(1))
    for place in (-1e3, 1e3):
        assert not one._leap(rows, np.array([place]), np.zeros(1), True)[-1].any()
    monkeypatch.setattr(lockstep_march, "MOST_ITERATIONS", 30)
    (found,) = March(body.problem, AttractedBody(body.problem), [trial], (t, z)).run()
    assert found.given_up


# --------------------------------------------------------------------------------------------------
@pytest.fixture(scope="module", name="fit")
def _fit(body: FittedBody) -> RelaxationFit:
    """Of a whole force curve with free rows, on a lever, with a hold: all in one."""
    made = replace(readings(usual(), 0.3, 0.3, k=2.0), flags=(SUBTRACTED_TWICE,))
    return relaxation_fit(body, made, relaxation_settings("sls", free=["w"]))


def test_a_whole_force_curve_with_free_rows(fit: RelaxationFit) -> None:
    assert off(fit, E_star=1.0, ratio=0.3, time=1.0, w=W, stress=STRESS, delta0=0.03) < 3.5
    assert 0.8 < fit.scatter < 1.2
    assert fit.warnings == (SUBTRACTED_TWICE,)  # of how it was read
    E, true = fit.modulus(t := np.array([0.1, 0.5, 2.0])), SOLID(t)
    assert (E[:, 1] < true).all()
    assert (true < E[:, 2]).all()


@pytest.mark.slow
def test_a_power_law_with_its_onset(body: FittedBody) -> None:
    law = power(0.15, 0.02, 4.0)
    fit = relaxation_fit(body, readings(cycle(W, STRESS, law, CORNERS, 2.0), 0.3, 0.3, k=2.0),
                         relaxation_settings("power", free=["w"]))  # fmt: skip
    assert off(fit, w=W, exponent=0.15) < 3.5
    E, true = fit.modulus(t := np.array([0.1, 0.5, 2.0])), law(t)
    assert (E[:, 1] < true).all()
    assert (true < E[:, 2]).all()
    assert any("compare with --relaxation prony" in line for line in fit.warnings)


def test_derivatives_through_r_are_those_of_steps_of_the_law(body: FittedBody) -> None:
    """Loads near the loss of contact follow r only as far as short steps; the onset changes it most at short times."""
    made = cycle(W, STRESS, power(0.25, 0.02, 10.0), CORNERS, 2.0)
    settings = relaxation_settings("power", [], ["w", "stress", "delta0", "P0", "tilt"], 1.0)
    model = adhesive_fit.prepared(body, readings(made, 0.5, 0.5, k=2.0), settings)
    known = {"w": W, "stress": STRESS, "delta0": 0.03, "P0": 0.0, "tilt": 0.0}
    x = model.unknowns.at({"modulus": 0.02**0.25, "time": 1.0, "exponent": 0.25, "onset": 0.02} | known)
    near, i = Nearby.of(model, x), model.unknowns.names.index("onset")
    ends = [x + step * np.eye(x.size)[i] for step in (0.05, -0.05)]
    _, *there = model.march([model.trial(one) for one in (x, *ends)], [0, 0, 0])
    steps = np.subtract(*(model.off(*pair) for pair in zip(ends, there, strict=True))) / 0.1
    by_r = near.state.jacobian[: steps.size, i]
    assert np.linalg.norm(steps - by_r) < 0.25 * np.linalg.norm(steps)


@pytest.mark.slow
def test_a_record_whose_searches_begin_with_a_wrong_time() -> None:
    """The end of contact, told to a thousandth, holds a search on a thin valley where wide zones do not know it so."""
    t, z, P = np.loadtxt(ROOT / "cases/measured/relaxing-slow.csv", delimiter=",", skiprows=2).T
    specimen = jkr.Specimen((), jkr.HalfSpace(jkr.Elastic(1e6, 0.5)))
    solution = jkr.solve(jkr.Problem(jkr.Paraboloid(100e-9), specimen, jkr.Loading("depth", 5e-9)))
    curve = Curve("made", t=t, delta=z - P / 2.0, P=P, stiffness=2.0)
    fit = relaxation_fit(body_of(solution), curve, relaxation_settings("sls", [], ["w"], 1.0))
    assert off(fit, E_star=1e8, ratio=0.4, time=0.03, w=0.03) < 2.5
    assert not fit.warnings


@pytest.mark.slow
def test_values_are_a_point_of_the_valley(body: FittedBody) -> None:
    """Ratio and time are known by their slope alone: that of the values is that of the truth, terms by their times."""
    made = readings(cycle(W, STRESS, solid(0.5, 30.0), CORNERS, 2.0), 0.3, 0.3, k=2.0)
    fit = relaxation_fit(body, made, relaxation_settings("prony", free=["w"]))
    assert fit.value("time1") < fit.value("time2")
    E = fit.modulus(t := np.array([0.5, 2.0]))
    r = fit.relaxation.modes(3.0)(t) * fit.value("E_star")
    assert ((E[:, 1] < r) & (r < E[:, 2])).all()


@pytest.mark.slow
def test_a_cycle_on_a_layer() -> None:
    made = cycle(W, 0.5, SOLID, CORNERS, 2.0, 0.5, 0.5)
    fit = relaxation_fit(layered(), readings(made, 0.5, 0.5, k=2.0), relaxation_settings("sls", free=["w"]))
    assert off(fit, E_star=1.0, ratio=0.3, time=1.0, w=W, delta0=0.03) < 3.5


@pytest.mark.slow
def test_the_command(jkr: Callable, tmp_path: Path) -> None:
    made = readings(usual(), 0.5, 0.5, k=2.0)
    (tmp_path / "gel.toml").write_text(CASE)
    write_table("cycle.csv", "t_s,delta_m,P_N", made.time, made.depth, made.load)
    found = jkr("fit", "gel.toml", "cycle.csv", "--relaxation", "sls", "--free", "w", "--json").told["fits"][0]
    assert found["estimates"]["w"]["value"] == pytest.approx(W, rel=0.05)
    assert found["estimates"]["stress"]["free"] is True
    at = found["modulus_over_time"]
    assert [row["low_Pa"] < 0.3 + 0.7 * math.exp(-row["t_s"]) < row["high_Pa"] for row in at] == [True] * len(at)
    with (tmp_path / "gel-fit.csv").open() as file:
        assert float(next(csv.DictReader(file))["w_J_per_m2"]) == pytest.approx(W, rel=0.05)


def test_a_record_that_finds_no_history_does_not_cost_the_others(
    jkr: Callable, fit: RelaxationFit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def one(_: FittedBody, curve: Curve, *__: object) -> RelaxationFit:
        if curve.name.startswith("a"):
            raise SolveError(f"{curve.name}: no history")
        return fit

    monkeypatch.setattr(fits, "relaxation_fit", one)
    (tmp_path / "gel.toml").write_text(CASE)
    for name in ("a.csv", "b.csv"):
        write_table(name, "t_s,delta_m,P_N", *[np.arange(1.0, 30)] * 3)
    done = jkr("fit", "gel.toml", "a.csv", "b.csv", "--relaxation", "sls", "--free", "w", "--json")
    assert (len(done.told["fits"]), "no history" in done.err) == (1, True)
    assert jkr("fit", "gel.toml", "a.csv", "--relaxation", "sls", "--free", "w", "--force").code == 1


# ---------------------------------------------------------------------- relaxation among the alternatives
R, E_STAR = 5e-6, 100e3
W_R = 0.002  # over R and E*


@dataclass(frozen=True)
class Specimen:
    """What is pressed and how, in units of R and E*."""

    ratio: float
    time: float = 1.0
    w: float = W_R
    stress: float = 0.1
    stiffness: float = 1.0
    way: tuple[tuple[float, float], ...] = ((0.0, -0.03), (0.5, 0.02), (1.7, -0.1))


@cache
def made_of(one: Specimen) -> Made:
    found: Made = cycle(one.w, one.stress, solid(one.ratio, one.time), one.way, one.stiffness)
    return found


def curve_of(one: Specimen, noise: float = 0.01, time: bool = True) -> Curve:
    """A record with free rows as long as its contact on both sides, an offset, and noise over the pull-off force."""
    whole = made_of(one)
    lasting = whole.lost - whole.begun
    t = whole.begun + lasting * (np.arange(-600, 1200) + 0.5) / 600
    ends, places = np.array(one.way).T
    slopes = np.diff(places) / np.diff(ends)
    z = np.interp(t, ends, places) + np.minimum(t - ends[0], 0) * slopes[0] + np.maximum(t - ends[-1], 0) * slopes[-1]
    size = noise * -float(whole.P.min())
    P = sampled(whole, t) + size * (5 + np.random.default_rng(1).standard_normal(t.size))
    delta = (z - P / one.stiffness) * R
    P, k = P * E_STAR * R**2, one.stiffness * E_STAR * R
    return Curve("made_of", t=t - t[0] if time else None, delta=delta, P=P, stiffness=k)


@cache
def elastic() -> FittedBody:
    specimen = jkr.Specimen((), jkr.HalfSpace(jkr.Elastic(0.75 * E_STAR, 0.5)))
    problem = jkr.Problem(jkr.Paraboloid(R), specimen, jkr.Loading("depth", 0.05 * R))
    return replace(body_of(jkr.solve(problem)), moduli_known=False)


def fitted(one: Curve, **how: object) -> Fit:
    return fit(elastic(), one, settings_of(elastic(), **how))  # type: ignore[arg-type]


def test_a_relaxing_record_that_adheres_is_named_first() -> None:
    """By one modulus E* or w is off by more than its statistical error; the cause is named with what it would give."""
    plain = fitted(curve_of(Specimen(0.4)))
    assert plain.verdict.alternatives.named[0].name == RELAXING
    off = {name: abs(plain.value(name) / true - 1) for name, true in (("E_star", E_STAR), ("w", W_R * E_STAR * R))}
    assert max(off.values()) > 0.05
    sentence = next(line for line in plain.warnings if line.startswith(RELAXING))
    assert "--relaxation sls --free w" in sentence
    for name, true in (("E_star", E_STAR), ("w", W_R * E_STAR * R)):
        low, high = plain.estimate(name).whole
        assert low < true < high
    assert RELAXING in "\n".join(alternatives_table(plain))


@pytest.mark.slow
def test_the_model_of_the_answer_is_the_viscoelastic_one() -> None:
    auto = fitted(curve_of(Specimen(0.4)), model="auto")
    assert auto.verdict.tied[0].name == RELAXING
    assert auto.value("E_star") == pytest.approx(E_STAR, rel=0.03)
    assert auto.value("E:base") == pytest.approx(0.75 * auto.value("E_star"))
    assert auto.value("w") == pytest.approx(W_R * E_STAR * R, rel=0.03)
    assert auto.value("ratio") == pytest.approx(0.4, abs=0.05)
    assert f"by {RELAXING}" in "\n".join(verdict_words(auto))
    assert pickle.loads(pickle.dumps(auto)).verdict.tied == auto.verdict.tied  # from other processes
    # what it leaves is noise, but where a jump lies between two rows
    size = 0.01 * -float(made_of(Specimen(0.4)).P.min()) * E_STAR * R**2
    assert float(np.median(np.abs(auto.residuals))) * auto.scales["P"] == pytest.approx(0.6745 * size, rel=0.1)


def test_a_misfit_that_nothing_else_explains_asks_for_it() -> None:
    one = Specimen(0.762, 0.442, 0.00293, 0.473, 2.13, ((0.0, -0.05), (0.5, 0.0273), (2.63, -0.2)))
    plain = fitted(curve_of(one, 0.00734))
    (named,) = plain.verdict.alternatives.named
    assert named.name == RELAXING
    assert plain.value("E_star") * math.exp(named.change("E_star")) == pytest.approx(E_STAR, rel=0.05)
    assert plain.estimate("w").whole[0] < one.w * E_STAR * R


@pytest.mark.slow
def test_a_search_that_ends_in_another_valley_begins_again() -> None:
    """The first ends with 0.87 of the modulus and half of its share at rest."""
    one = Specimen(0.28, 0.39, 0.0028, 0.434, 0.76, ((0.0, -0.05), (0.5, 0.015), (2.5, -0.2)))
    settings = relaxation_settings("sls", [], ["w"], elastic().problem.E_star)
    found = relaxation_fit(elastic(), curve_of(one, 0.015), settings)
    assert found.warnings == ()
    assert off(found, E_star=E_STAR, w=one.w * E_STAR * R, ratio=one.ratio) < 3
    assert found.value("E_star") == pytest.approx(E_STAR, rel=0.04)


@pytest.mark.slow
def test_of_a_long_range_attraction_without_contact_is_told() -> None:
    """The pull of such rows is taken for a larger w, by far more than its error."""
    one = Specimen(0.87, 1.28, 0.0068, 0.117, 1.0, ((0.0, -0.05), (0.5, 0.02), (2.0, -0.2)))
    settings = relaxation_settings("sls", [], ["w"], elastic().problem.E_star)
    found = relaxation_fit(elastic(), curve_of(one, 0.01), settings)
    assert re.search("Tabor number 0.[67].* is below 0.75", found.warnings[0])
    assert timed_record.LONG_RANGE in found.doubts


def test_records_to_which_relaxation_is_no_alternative() -> None:
    auto = fitted(curve_of(Specimen(1.0)), model="auto")
    assert RELAXING not in {one.name for one in (*auto.verdict.alternatives.scores, *auto.verdict.fitted)}
    plain = fitted(curve_of(Specimen(0.4), time=False))
    assert RELAXING not in {one.name for one in plain.verdict.alternatives.scores}

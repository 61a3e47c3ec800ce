"""Pulled at once from rest: closed forms on half-spaces, elastic solves of the profile that is left."""

import dataclasses
import json
import math
import subprocess
from collections.abc import Callable
from operator import attrgetter
from pathlib import Path
from shutil import which

import numpy as np
import pytest
from conftest import CASES
from scipy.optimize import brentq

import jkrcli as jkr
from jkrcli.adhesion.curve import LOAD_CONTROL, CriticalPoint
from jkrcli.many.explorer import payload
from jkrcli.resolve.analysis import analyse
from jkrcli.series import Solution
from jkrcli.viscoelastic.by_history import LostByHistory, lost_by_history
from jkrcli.viscoelastic.from_rest import AT_MOST, FAST, FROM_REST, SLOW, Rest

R, E_INF, W, RHO = 1.0, 1.0, 0.05, 0.1
A0 = (W * R**2 / E_INF) ** (1 / 3)  # w/(Einf R) = 0.05


def half_space(scale: float = 1.0, force: float = 1.0) -> Solution:
    """The half-space of the published values, its lengths and forces in other units."""
    E = force / scale**2 * E_INF / RHO
    specimen = jkr.Specimen((), jkr.HalfSpace(jkr.Elastic(E, 0.0)), relaxation=jkr.StandardSolid(RHO, 1.0))
    return jkr.solve(jkr.Problem(jkr.Paraboloid(R * scale), specimen, jkr.Loading("radius", 3.0 * scale, 120, "log")))


def lost(solved: Solution, w: float, rest: Rest | None = None, *stiffnesses: float) -> dict[str, LostByHistory]:
    """What is lost after each history, by its name."""
    found = lost_by_history(analyse(solved, [w])[0], stiffnesses or (LOAD_CONTROL,), rest)
    assert isinstance(found, list)
    return {one.history.name: one for one in found}


def force(one: LostByHistory, stiffness: float = LOAD_CONTROL) -> float:
    point, _ = one.lost[stiffness]
    assert isinstance(point, CriticalPoint), point
    return -point.P


@pytest.mark.parametrize(("delta0", "published", "at"), [(0.0, 9.9824, 1.8453), (1.5, 12.4526, 2.3030)])
def test_from_rest_on_a_half_space(delta0: float, published: float, at: float) -> None:
    """-P_min/(pi w R) pulled from rest at delta0, over a0^2/R: closed, and to the digits of two other computations."""
    a_s = brentq(lambda a: a**2 - math.sqrt(2 * math.pi * a) - delta0, 1.5, 3.0, xtol=1e-15)
    closed = (math.sqrt(8 * math.pi * a_s**3 / RHO) - 4 / 3 * a_s**3) / math.pi
    one = lost(half_space(), W, Rest(depth=delta0 * A0**2 / R))[FROM_REST]
    assert force(one) / (math.pi * W * R) == pytest.approx(closed, rel=1e-10)
    assert closed == pytest.approx(published, abs=6e-5)
    point, error = one.lost[LOAD_CONTROL]
    assert point.a / A0 == pytest.approx(at, abs=6e-5)
    assert abs(force(one) / (math.pi * W * R) / closed - 1) <= error["P"] / force(one) + 1e-12


def test_any_history_on_a_half_space() -> None:
    # The largest force is E0/Einf times JKR's; the limits of very fast and very slow cycles are JKR's and equal.
    found = lost(half_space(), W)
    jkr_force = 1.5 * math.pi * W * R
    assert force(found[FAST]) == pytest.approx(jkr_force, rel=1e-10)
    assert force(found[SLOW]) == pytest.approx(jkr_force, rel=1e-10)
    assert force(found[AT_MOST]) == pytest.approx(jkr_force / RHO, rel=1e-10)
    assert jkr_force < force(found[FROM_REST]) < jkr_force / RHO
    scale, by = 2e-6, 3e-9
    here, there = lost(half_space(), W), lost(half_space(scale, by), W * by / scale)
    for name, one in here.items():
        assert force(there[name]) == pytest.approx(by * force(one), rel=1e-9), name


def gel(R: float, E: float, relaxation: jkr.StandardSolid | None = None) -> jkr.Problem:
    """A bonded incompressible layer."""
    layer = jkr.Layer(jkr.Elastic(E, 0.5), 0.8)
    specimen = jkr.Specimen((layer,), jkr.Rigid(), relaxation=relaxation)
    return jkr.Problem(jkr.Paraboloid(R), specimen, jkr.Loading("radius", 1.6, 100, "log"))


@pytest.mark.parametrize("stiffness", [LOAD_CONTROL, 3.0, math.inf])
def test_from_rest_on_a_layer_is_an_elastic_contact_under_the_profile_that_is_left(stiffness: float) -> None:
    """At the radius of rest, and where the contact is lost inside it: solved for E0 under R/rho, by Eq. 13."""
    w, rho, method = 0.002, 0.1, jkr.Layered(tolerance=1e-11)
    relaxed, frozen = jkr.solve(gel(1.0, rho), method), jkr.solve(gel(1.0 / rho, 1.0), method)
    curve = jkr.transform(relaxed, w)
    solved = jkr.solve(gel(1.0, 1.0, jkr.StandardSolid(rho, 1.0)), method)

    def shifted(solution: Solution, i: int) -> tuple[float, float]:
        series = solution.series
        t = math.sqrt(4 * math.pi * w * series.a[i] / series.dS[i])
        return series.delta[i] - t, series.P[i] - series.S[i] * t

    cut, ends = 0, [curve.pull_off["load"].a, jkr.transform(frozen, w).pull_off["load"].a]
    first, last = np.searchsorted(relaxed.series.a, ends)
    for i in (first + 1, (first + last) // 2, last + 2):
        delta0, P0 = shifted(relaxed, i)
        one = lost(solved, w, Rest(P0), stiffness)[FROM_REST]
        delta, P = np.array([shifted(frozen, j) for j in range(i + 1)]).T
        held = P if stiffness == LOAD_CONTROL else (1 - rho) * delta0 + delta + P / stiffness
        lowest = int(np.argmin(held))
        if lowest == i:
            cut += 1
            assert force(one, stiffness) == pytest.approx(-P[i], rel=1e-10)
            point, _ = one.lost[stiffness]
            assert point.delta == pytest.approx((1 - rho) * delta0 + delta[i], rel=1e-9)
        else:
            (other, _), *_ = jkr.pull_off(frozen, w, stiffness=[stiffness]).lost
            assert force(one, stiffness) == pytest.approx(-other.pull_off.P, rel=1e-10)
    assert cut or stiffness == math.inf


@pytest.fixture(name="relaxing_gel", scope="module")
def _relaxing_gel() -> Solution:
    """The shipped case, loaded to 300 um."""
    return jkr.solve(jkr.parse_case((CASES / "relaxing-gel.toml").read_text().replace('"100 um"', '"300 um"')))


@pytest.mark.parametrize(("rest", "expected"), [(Rest(depth=2e-4), 545.4), (Rest(depth=0.0), 499.8)])
def test_the_relaxing_gel(relaxing_gel: Solution, rest: Rest | None, expected: float) -> None:
    found = lost(relaxing_gel, 0.02, rest)
    assert force(found[FROM_REST]) * 1e6 == pytest.approx(expected, abs=0.06)
    assert force(found[FAST]) * 1e6 == pytest.approx(188.8, abs=0.06)
    assert force(found[SLOW]) * 1e6 == pytest.approx(189.4, abs=0.06)
    assert force(found[AT_MOST]) >= force(found[FROM_REST]) * (1 - 1e-9)


def test_a_series_that_ends_before_the_rest_and_the_error_at_its_radius(relaxing_gel: Solution) -> None:
    # Relaxed at a depth of 300 um the contact is larger than that of 300 um without adhesion.
    further = lost(relaxing_gel, 0.02, Rest(depth=3e-4))[FROM_REST]
    assert further.solved_to > relaxing_gel.series.a[-1]
    assert force(further) * 1e6 == pytest.approx(545.4, abs=0.06)
    imported = dataclasses.replace(relaxing_gel, method="import")
    point, _ = lost(imported, 0.02, Rest(depth=3e-4))[FROM_REST].lost[LOAD_CONTROL]
    assert "increase [loading] radius" in point.reason
    point, _ = lost(relaxing_gel, 0.02, Rest(depth=-1e-4))[FROM_REST].lost[LOAD_CONTROL]
    assert "no contact rests at delta = -100 um" in point.reason
    law = jkr.StandardSolid(0.1, 1.0)
    coarse, fine = (jkr.solve(gel(1.0, 1.0, law), jkr.Layered(tolerance=t)) for t in (1e-4, 1e-11))
    ours, right = (lost(one, 0.002)[FROM_REST] for one in (coarse, fine))
    (point, error), (exact, _) = ours.lost[LOAD_CONTROL], right.lost[LOAD_CONTROL]
    assert point.a == pytest.approx(ours.curve.rest.a, rel=1e-6)
    assert abs(point.P - exact.P) <= error["P"]
    assert abs(point.delta - exact.delta) <= error["delta"]


def test_a_force_means_a_range_of_w(relaxing_gel: Solution) -> None:
    """500 uN on the gel: 18.35 mJ/m^2 from rest at P = 0, once 52.8 "below 1e-11"; each gives that force back."""
    result = jkr.pull_off(relaxing_gel, load="500 uN")
    found = result.summary()
    assert found["w_J_per_m2"] == pytest.approx(18.35e-3, abs=6e-6)
    low, high = found["w_range_J_per_m2"]
    assert (low, high) == (pytest.approx(18.35e-3, abs=6e-6), pytest.approx(52.8e-3, abs=6e-5))
    for row in found["histories"]:
        again = lost(relaxing_gel, row["w_J_per_m2"])[row["history"]]
        assert force(again) == pytest.approx(500e-6, rel=1e-8), row["history"]
    verdict = str(result).splitlines()[0]
    assert "w = 18.35 mJ/m^2 to 52.8" in verdict
    assert "by the history" in verdict
    deep = jkr.pull_off(relaxing_gel, load="500 uN", rest_depth=0.0)
    assert {h.name: m.work.w for h, m in deep.found}[FROM_REST] > low


@pytest.fixture(name="jkr_")
def _jkr(jkr: Callable) -> Callable:
    return jkr


def test_pull_off_names_each_history(jkr_: Callable, relaxing_gel: Solution) -> None:
    jkr.save(relaxing_gel, "gel.h5")
    done = jkr_("pull-off", "gel.h5", "--w", "20 mJ/m^2", "-v")
    assert (done.code, done.err) == (0, "")
    verdict = done.out.split(":")[0]
    for part in ("188.8 uN (very fast)", "189.4 uN (very slow)", "545.4 uN (from rest)", "at most 545.4 uN"):
        assert part in " ".join(verdict.split())
    assert "at rest at P = 0, then pulled instantly" in done.out
    other = json.loads(jkr_("pull-off", "gel.h5", "--w", 0.02, "--rest-depth", 0, "--json").out)["results"][0]
    rest = {one["history"]: one for one in other["histories"]}[FROM_REST]
    assert rest["controls"][0]["pull_off"]["P_N"] == pytest.approx(-499.8e-6, abs=6e-8)
    assert rest["rest"]["delta_m"] == 0
    assert jkr_("pull-off", "gel.h5", "--w", 0.02, "--rest-depth", 0, "--rest-load", 0).code == 2
    (warning,) = (text for text in jkr.transform(relaxing_gel, 0.02).warnings if "relaxes" in text)
    assert "between" not in warning
    assert "no bound" in warning
    for out in (done.out, jkr_("cycle", "gel.h5", "--w-approach", 0.02, "--no-plots").out):
        assert "between" not in out


def test_no_rest_without_a_relaxed_modulus(jkr_: Callable) -> None:
    # A fluid never comes to rest: the limit of very fast cycles alone is known, and this is said.
    specimen = jkr.Specimen((), jkr.HalfSpace(jkr.Elastic(1e4, 0.5)), relaxation=jkr.StandardSolid(0.0, 1.0))
    solved = jkr.solve(jkr.Problem(jkr.Paraboloid(1e-3), specimen, jkr.Loading("radius", 5e-4, 60, "log")))
    found = jkr.pull_off(solved, 0.02)
    assert "no contact is in equilibrium" in found.histories.reason
    assert "relaxes" in found.warnings[0]
    assert set(jkr.cycle(solved, 0.02).limits) == {FAST}
    case = str(CASES / "halfspace.toml")
    assert jkr_("run", case, "--method", "closed-form", "-o", "half.h5").code == 0
    for verb, option in (("pull-off", "--w"), ("cycle", "--w-approach")):
        jkr_(verb, "half.h5", option, 0.02, "--rest-depth", 0).refused("--rest-depth")


@pytest.mark.parametrize("stiffness", [math.inf, 50.0])
def test_the_cycle_from_rest(relaxing_gel: Solution, stiffness: float) -> None:
    """Rests at P = 0, goes back on a straight line of slope S, lets go where pull-off says; the loop is its energy."""
    traced = jkr.cycle(relaxing_gel, 0.02, stiffness=stiffness)
    _, cycle = traced.limits[FROM_REST]
    point, _ = lost(relaxing_gel, 0.02, None, stiffness)[FROM_REST].lost[stiffness]
    end = cycle.cycle.retraction.jumps[-1].start
    assert (end.P, end.delta) == (pytest.approx(point.P, rel=1e-7), pytest.approx(point.delta, rel=1e-6))
    columns = cycle.columns
    a, delta, P, phase = (columns[name] for name in ("a_m", "delta_m", "P_N", "phase"))
    turn = phase == "turn"
    body = np.interp(a[turn][0], relaxing_gel.series.a, relaxing_gel.series.S)
    slope = (P[turn][-1] - P[turn][0]) / (delta[turn][-1] - delta[turn][0])
    assert P[turn][0] == pytest.approx(0.0, abs=1e-9 * abs(P.min()))
    assert slope == pytest.approx(body, rel=1e-4)
    assert P.min() == pytest.approx(-545.4e-6, rel=1e-4)
    x, touching = columns["device_m"], a > 0
    loop = np.trapezoid(P[touching], x[touching])
    assert cycle.cycle.energy_lost == pytest.approx(loop, rel=1e-3)
    with pytest.raises(jkr.InputError, match="no contact rests"):
        jkr.cycle(relaxing_gel, 0.02, stiffness=stiffness, rest_load=-1.0)


@pytest.mark.skipif(which("node") is None, reason="needs node")
@pytest.mark.parametrize("stiffness", [LOAD_CONTROL, 20.0])
def test_the_page_of_explore_has_the_same_numbers(relaxing_gel: Solution, stiffness: float) -> None:
    held = payload(analyse(relaxing_gel, [0.02])[0], [])
    assert held["relaxed"] == 0.35
    script = (Path(jkr.__file__).parent / "many" / "explorer" / "curve.js").read_text()
    k = "Infinity" if stiffness == math.inf else stiffness
    text = (
        f"{script}\nconst content = {json.dumps(held, default=attrgetter('reason'))};\n"
        f"console.log(JSON.stringify(byHistory(new Table(content), 0.02, 1, content.relaxed, 0, {k})))"
    )
    done = subprocess.run(["node"], input=text, capture_output=True, text=True, check=True)
    found, theirs = json.loads(done.stdout), lost(relaxing_gel, 0.02, None, stiffness)
    for name, history in (("slow", SLOW), ("rest", FROM_REST), ("most", AT_MOST)):
        assert -found[name]["P"] == pytest.approx(force(theirs[history], stiffness), rel=1e-7)
    assert found["rest"]["delta"] == pytest.approx(theirs[FROM_REST].lost[stiffness][0].delta, rel=1e-6)

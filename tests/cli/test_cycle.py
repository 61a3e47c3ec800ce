"""Approach-retract cycles with one and with two works of adhesion, against closed forms and energy balances."""

import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import CASES

from jkrcli.adhesion.curve import AdhesiveCurve, transform
from jkrcli.adhesion.device_path import UNBOUNDED, Cycle, cycle, trace, turning_radius
from jkrcli.adhesion.slopes import slopes
from jkrcli.base.errors import InputError, Unknown
from jkrcli.formulas import hertz
from jkrcli.series import Series

E_STAR, R = 5e9 / 0.84, 1e-4
RIGID = math.inf


def half_space(w: float, first: float = 1e-7, last: float = 1.73e-5, points: int = 60) -> AdhesiveCurve:
    a = np.geomspace(first, last, points)
    delta, P = hertz(a, E_STAR, R)
    series = Series(a, delta, P, 2 * E_STAR * a, np.full(points, 2 * E_STAR))
    return transform(series, slopes(series), w)


def balance(found: Cycle) -> float:
    """Hysteresis over the largest area, and what both jumps dissipate: U_E + spring - w pi a^2 before minus after."""

    def stored(curve: AdhesiveCurve, a: float) -> float:
        """U_H - P_H t + S t^2/2 + P^2/(2 k), with U_H = (2/5) P_H delta_H of Hertz."""
        here = curve.point(a)
        delta, P = (float(value) for value in hertz(np.array(a), E_STAR, R))
        t = delta - here.delta
        return 0.4 * P * delta - P * t + E_STAR * a * t**2 + here.P**2 / (2 * found.stiffness)

    into, out = found.begin.a, found.retraction.jumps[-1].start.a
    w1, w2 = found.contact.advancing.w, found.contact.receding.w
    jump_in = math.pi * w1 * into**2 - stored(found.contact.advancing, into)
    jump_out = stored(found.contact.receding, out) - math.pi * w2 * out**2
    return math.pi * (w2 - w1) * found.turn**2 + jump_in + jump_out


@pytest.mark.parametrize("stiffness", [2e4, 3e5, RIGID])
@pytest.mark.parametrize("w", [(50.0, 50.0), (20.0, 80.0), (1e-3, 50.0)])
def test_the_energy_lost_is_the_balance_of_energies(w: tuple[float, float], stiffness: float) -> None:
    found = cycle(half_space(w[0]), half_space(w[1]), stiffness, turn=1.4e-5)
    assert isinstance(found, Cycle)
    # Gauss over a hundredfold range of radii, measured 3e-15
    assert found.energy_lost == pytest.approx(balance(found), rel=1e-12, abs=0)


@pytest.mark.parametrize("stiffness", [2e4, RIGID])
@pytest.mark.parametrize("w", [(50.0, 50.0), (20.0, 80.0)])
def test_the_energy_lost_is_the_area_of_the_trace(w: tuple[float, float], stiffness: float) -> None:
    found = cycle(half_space(w[0]), half_space(w[1]), stiffness)
    columns = trace(found, 4000)
    D, P = columns["device_m"], columns["P_N"]
    area = float(np.sum((P[1:] + P[:-1]) / 2 * np.diff(D)))
    assert found.energy_lost == pytest.approx(
        area, rel=1e-5, abs=0
    )  # trapezoids: 4000 per stretch, 1e-7 of a loop 1e-2 wide


def test_trace_of_a_device() -> None:
    stiffness, points = 1e5, 50
    found = cycle(half_space(50.0), half_space(100.0), stiffness)
    columns = trace(found, points)
    assert list(columns) == ["a_m", "delta_m", "P_N", "device_m", "phase", "part"]
    phases = ["free approach", "approach", "turn", "retraction", "free retraction"]
    assert list(dict.fromkeys(columns["phase"])) == phases
    assert [int(np.sum(columns["phase"] == phase)) for phase in phases] == [points] * 5
    assert all(np.isfinite(columns[name]).all() for name in ("a_m", "delta_m", "P_N", "device_m"))
    D = columns["device_m"]
    scale = np.max(np.abs(D))
    assert np.allclose(D, columns["delta_m"] + columns["P_N"] / stiffness, rtol=0, atol=1e-15 * scale)
    last = np.flatnonzero(np.diff(columns["part"])) + 1
    for jump in last[[0, 3]]:  # in and out: the device stands still
        assert D[jump] == pytest.approx(D[jump - 1], abs=1e-12 * scale)
    turned = last[1]
    assert np.all(np.diff(D[:turned]) >= -1e-12 * scale)  # one way in
    assert np.all(np.diff(D[turned - 1 :]) <= 1e-12 * scale)  # and one way out
    held = columns["phase"] == "turn"
    assert set(columns["a_m"][held]) == {found.turn}
    slope = np.diff(columns["P_N"][held]) / np.diff(columns["delta_m"][held])
    assert slope == pytest.approx(2 * E_STAR * found.turn, rel=1e-12, abs=0)  # a flat punch of that radius
    out = columns["phase"] == "free retraction"
    assert set(columns["P_N"][out]) == set(columns["a_m"][out]) == {0.0}
    assert D[-1] == pytest.approx(D[0], rel=1e-12, abs=0)  # closed


def test_no_adhesion_on_approach_follows_hertz_from_the_first_radius() -> None:
    found = cycle(half_space(0.0, first=1e-8), half_space(50.0, first=1e-8), RIGID, 1e-5)
    assert found.begin.a == 1e-8
    assert found.energy_lost == pytest.approx(balance(found), rel=1e-12, abs=0)  # measured 9e-15
    columns = trace(found, 20)
    approach = columns["phase"] == "approach"
    expected = hertz(columns["a_m"][approach], E_STAR, R)
    np.testing.assert_allclose(columns["P_N"][approach], expected[1], rtol=1e-12)


def test_no_adhesion_on_approach_takes_the_chord_below_the_first_radius() -> None:
    late = cycle(half_space(0.0, first=3e-6), half_space(50.0, first=3e-6), RIGID, 1e-5)
    chord = late.begin.P * late.begin.delta / 2  # the balance leaves out the work up to the first radius
    assert chord > 1e-3 * late.energy_lost  # seen by the tolerance below
    assert late.energy_lost == pytest.approx(balance(late) + chord, rel=1e-12, abs=0)  # measured 3e-15


def test_work_of_separation_from_the_zero_load_within_the_turn() -> None:
    """With strong hysteresis the load falls through zero at held radius: the straight line is cut there."""
    soft, strong = half_space(10.0), half_space(200.0)
    found = cycle(soft, strong, 1e5, turn=1.2e-5)
    high, low = soft.point(1.2e-5), strong.point(1.2e-5)
    assert high.P > 0 > low.P
    assert found.retraction.stretches[0].place == 1.2e-5
    columns = trace(found, 20_000)
    rows = (columns["phase"] == "turn") | (columns["phase"] == "retraction")
    D, P = columns["device_m"][rows], np.minimum(columns["P_N"][rows], 0)
    area = float(np.sum((P[1:] + P[:-1]) / 2 * np.diff(D)))
    assert found.separation == pytest.approx(area, rel=1e-6, abs=0)  # trapezoids


def test_a_turn_below_zero_load_has_no_work_of_separation() -> None:
    found = cycle(half_space(50.0), half_space(50.0), RIGID, turn=8.5e-6)
    assert found.separation == Unknown("no state of zero load is passed on retraction: increase [loading] radius")
    assert isinstance(found.energy_lost, float)


def test_contact_that_is_lost_at_the_turn() -> None:
    """The work of adhesion on retraction is so high that no radius up to the turn is stable: flat-punch separation."""
    found = cycle(half_space(0.5, last=1e-5), half_space(500.0, last=1e-5), 1e4)
    (jump,) = found.retraction.jumps
    assert jump.start.a == found.turn == pytest.approx(1e-5)
    assert jump.end is None
    assert found.energy_lost == pytest.approx(balance(found), rel=1e-12, abs=0)  # measured 2e-16
    assert int(np.sum(trace(found, 10)["phase"] == "retraction")) == 1


def test_load_control() -> None:
    found = cycle(half_space(50.0), half_space(50.0), 0.0)
    assert found.energy_lost == found.separation == UNBOUNDED
    assert found.begin.P == 0
    assert found.retraction.jumps[-1].start.P == pytest.approx(-1.5 * math.pi * 50.0 * R, rel=1e-12, abs=0)
    columns = trace(found, 30)
    assert "device_m" not in columns
    assert list(dict.fromkeys(columns["phase"])) == ["free approach", "approach", "retraction"]


@pytest.mark.parametrize(("quantity", "value"), [("load", 0.05), ("load", -0.01), ("depth", 1e-6)])
def test_turning_at_a_load_or_a_depth(quantity: str, value: float) -> None:
    curve = half_space(50.0)
    a = turning_radius(curve, RIGID, **{quantity: value})
    here = curve.point(a)
    assert (here.P if quantity == "load" else here.delta) == pytest.approx(value, rel=1e-10, abs=0)
    assert a > cycle(curve, curve, RIGID).begin.a


def refused(call) -> str:
    with pytest.raises(InputError) as caught:
        call()
    return str(caught.value)


def test_turns_that_are_not_passed_are_refused_with_the_range() -> None:
    """From -4/3 pi w R up to 4 E* a^3/(3 R) - sqrt(8 pi w E* a^3) = (410.9 - 196.8) mN at a = 17.3 um."""
    curve = half_space(50.0)
    said = refused(lambda: turning_radius(curve, RIGID, load=-0.022))
    assert "P = -22 mN is not reached on approach, which in this solution goes from -20.94 mN to 214.1 mN" in said
    assert "goes from 0 m to 2.037 um" in refused(lambda: turning_radius(curve, RIGID, depth=5e-6))
    said = refused(lambda: turning_radius(half_space(50.0, last=4e-6), RIGID, load=1.0))
    assert "contact at delta = 0 spreads beyond the largest radius of the solution, a = 4 um" in said


def test_a_turn_that_is_not_on_the_path_is_refused() -> None:
    curve = half_space(50.0)
    said = refused(lambda: cycle(curve, curve, RIGID, turn=1e-6))
    assert "reversal at a = 1 um is not reached by stable contact on approach" in said


def test_energies_say_why_there_are_none(jkr: Callable) -> None:
    """Once "energy lost per cycle contact is not lost within the series ...; work of separation contact ...", then "not
    defined under load control: gel.h5"."""
    assert jkr("run", CASES / "gel.toml", "-o", "gel.h5", "-q").code == 0
    done = jkr("cycle", "gel.h5", "--w-approach", "0", "--no-plots")
    none = "energy lost per cycle and work of separation: none"
    lost = f"{none}, contact is not lost within the solution, which begins at a = 12 um: gel.h5"
    assert done.out.splitlines()[0] == lost
    done = jkr("cycle", "gel.h5", "--stiffness", "load", "--no-plots", "--force")
    assert done.out.splitlines()[0] == f"{none}, not defined under load control: gel.h5"


SOFT = """
indenter = {{ shape = "sphere", radius = "5 um" }}
specimen.half_space = {{ E = "5 {unit}", nu = {nu} }}
loading = {{ radius = "3 um", points = 60, spacing = "log" }}
adhesion.w = "0.1 mJ/m^2"
{relaxation}
"""


def test_large_strains_stand_beside_a_program_that_parts_the_surfaces(jkr: Callable, tmp_path: Path) -> None:
    """The same as of the cycle there and back, once nothing; a program that stays in contact has no such force."""
    case = tmp_path / "ball.toml"
    case.write_text(SOFT.format(unit="kPa", nu=0.5, relaxation=""))
    for name, end in (("parts", "-3 um"), ("stays", "0.2 um")):
        (tmp_path / f"{name}.csv").write_text(f"t,x\ns,um\n0,-0.5\n1,0.5\n2,{end.split()[0]}\n")
    whole = jkr("cycle", case, "--no-plots", "--json", "-o", tmp_path).told
    assert len(whole["large_strains"]) == 2
    done = jkr("cycle", case, "--program", tmp_path / "parts.csv", "--no-plots", "--json", "-o", tmp_path).ok
    assert json.loads(done.out)["large_strains"] == whole["large_strains"]
    printed = jkr("cycle", case, "--program", tmp_path / "parts.csv", "--no-plots", "-o", tmp_path, "--force").out
    assert "of the pull-off force (model)" in printed
    printed = jkr("cycle", case, "--program", tmp_path / "stays.csv", "--no-plots", "-o", tmp_path).out
    assert "large strains" not in printed


def test_large_strains_stand_beside_a_cycle_from_rest(jkr: Callable, tmp_path: Path) -> None:
    """On a dent that is kept they are not estimated: a/R at pull-off is 0.2 and more; once nothing."""
    case = tmp_path / "ball.toml"
    relaxation = '[specimen.relaxation]\nlaw = "sls"\nratio = 0.35\ntime = "1 s"'
    case.write_text(SOFT.format(unit="kPa", nu=0.5, relaxation=relaxation))
    limits = jkr("cycle", case, "--no-plots", "--json", "-o", tmp_path).told["limits"]
    assert [len(limits[name]["large_strains"]) for name in ("very fast", "very slow")] == [2, 2]
    assert "not estimated, a/R" in limits["from rest"]["large_strains_reason"]

"""One path of a device: infinitely slow edges, turns anywhere, holds, any edge rule, against exact statements."""

import math
from functools import cache

import numpy as np
import pytest

import jkrcli as python
from jkrcli.adhesion.curve import LOAD_CONTROL, AdhesiveCurve, Nonadhesive, position
from jkrcli.adhesion.device_path import Program, QuasiStatic, path
from jkrcli.adhesion.slopes import slopes
from jkrcli.formulas import hertz
from jkrcli.series import Series
from jkrcli.viscoelastic.course import there_and_back
from jkrcli.viscoelastic.rate import PowerRate, RateContact

RIGID = math.inf
LAYER = """
indenter = {{ shape = "paraboloid", radius = "1 mm" }}
specimen.layers = [{{ thickness = "1 um", E = "5 GPa", nu = 0.4 }}]
loading = {{ radius = "20 um", points = {points}, spacing = "log" }}
"""


@cache
def half_space() -> Nonadhesive:
    a = np.geomspace(1e-3, 6, 80)
    delta, P = hertz(a, 1.0, 1.0)
    series = Series(a, delta, P, 2 * a, np.full(80, 2.0))
    return Nonadhesive(series, slopes(series))


def contact(w_in: float, w_out: float, stiffness: float) -> QuasiStatic:
    return QuasiStatic(AdhesiveCurve(half_space(), w_in), AdhesiveCurve(half_space(), w_out), stiffness)


def test_an_infinitely_slow_edge_is_that_of_the_transform() -> None:
    """The same S' and pull-off, of a thin layer of few rows too, under each control; measured 0."""
    solved = python.solve(python.parse_case(LAYER.format(points=20)))
    told = python.transform(solved, 1.0)
    slow = {
        stiffness: python.cycle_at_speed(solved, 1.0, PowerRate(1.0, 0.6), 1e-29, to_load=0.1, stiffness=stiffness)
        for stiffness in (RIGID, LOAD_CONTROL)
    }
    rigid, loaded = slow.values()
    for ours, control in ((rigid.pull_off, "load"), (rigid.lost.start, "displacement"), (loaded.pull_off, "load")):
        theirs = told.pull_off[control]
        assert (ours.P, ours.delta, ours.a) == pytest.approx((theirs.P, theirs.delta, theirs.a), rel=1e-9)
    dS = [rigid.contact.edge.pointwise(math.log(a))[3] for a in told.curve.a]
    assert dS == pytest.approx(told.columns["dS_da_N_per_m2"], rel=1e-9)


def test_the_least_load_of_a_slow_edge_goes_with_its_speed() -> None:
    """At n = 1 what is beyond equilibrium is proportional to it, down to where the state's own G is round-off too."""

    def beyond(V: float) -> float:
        found = RateContact(half_space(), PowerRate(1.0, 1.0), 1.0, 1.0).once(there_and_back(3.0, V, V))
        return -found.pull_off.P / (1.5 * math.pi) - 1

    rate = beyond(1e-6) / 1e-6
    for V in (1e-8, 1e-10):
        assert beyond(V) == pytest.approx(rate * V, abs=1e-10)  # measured 2e-11
    assert beyond(1e-7) == pytest.approx(rate * 1e-7, rel=1e-3)  # measured 1e-5


@pytest.mark.parametrize("stiffness", [RIGID, 3.0, LOAD_CONTROL])
def test_up_and_down_and_up_again(stiffness: float) -> None:
    """Rests at each turn, at one radius and slope S, until G is the other w; then as if it had not turned."""
    here = contact(0.5, 1.0, stiffness)
    advance, recede = here.advance.position, here.recede.position
    x = [here.least, advance(3.0), advance(2.5), recede(2.0), advance(4.0), -20.0]
    found = path(here, Program(np.arange(6.0), np.array(x)))
    phases = [piece.phase for piece in found.pieces]
    ends = [piece.last[1] for piece in found.pieces]
    assert found.ends == "lost"
    rests = [piece for piece in found.pieces if piece.phase == "rest"]
    for rest in rests:
        _, delta, P, G = found.states(rest, *rest.rows(3))
        assert np.diff(P) == pytest.approx(2 * rest.last[1] * np.diff(delta), rel=1e-9)  # S = 2 E* a
        assert ((G > 0.5 - 1e-9) & (G < 1 + 1e-9)).all()
    assert phases == ["advance", "rest", "recede", "recede", "rest", "advance", "rest", "recede"]
    assert max(ends) == pytest.approx(4.0)
    whole = path(here, Program(np.arange(3.0), np.array([here.least, x[4], -20.0])))
    assert found.jumps[-1].start.P == pytest.approx(whole.jumps[-1].start.P, rel=1e-12)


def test_the_work_of_a_path_is_what_its_edge_and_its_jumps_lose() -> None:
    """Closed inner loops of the edge cost (w_r - w_a) times the area that was passed back and forth."""
    here = contact(0.5, 1.0, RIGID)
    turns = [here.advance.position(3.0), here.recede.position(2.0), here.advance.position(3.0)]
    once = path(here, Program(np.arange(3.0), np.array([here.least, turns[0], -20.0])))
    twice = path(here, Program(np.arange(5.0), np.array([here.least, *turns, -20.0])))
    assert twice.work - once.work == pytest.approx(0.5 * math.pi * (3.0**2 - 2.0**2), rel=1e-10)


def test_after_a_loss_contact_forms_anew() -> None:
    here = contact(1.0, 1.0, RIGID)
    found = path(here, Program(np.arange(5.0), np.array([-1.0, 2.0, -5.0, 2.0, 2.0])))
    assert [piece.phase for piece in found.pieces] == ["free", "advance", "recede", "free", "free", "advance", "rest"]
    first, second = (jump for jump in found.jumps if jump.end is not None)
    assert (first.end.a, first.end.delta) == pytest.approx((second.end.a, second.end.delta))
    assert position(first.end.delta, first.end.P, RIGID) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("turn", [5.0, 2.0])
def test_a_rule_of_speed_and_one_of_equilibrium_are_one_path(turn: float) -> None:
    program = Program(np.arange(3.0), np.array([0.0, turn, -1.0]))
    quiet = path(contact(0.5, 1.0, 3.0), program)
    fast = RateContact(half_space(), PowerRate(1.0, 0.6), 1.0, 0.5, 3.0).once(program)
    for one, two in zip(quiet.pieces[:2], fast.pieces[:2], strict=True):
        assert (one.phase, *one.first, *one.last) == pytest.approx((two.phase, *two.first, *two.last))
        assert one.work == pytest.approx(two.work, rel=1e-12)


def test_attraction_of_finite_range_follows_a_program_too() -> None:
    """Without two works of adhesion there is no rest between: it goes back on the way that it came, and holds."""
    solved = python.solve(python.parse_case(LAYER.format(points=60)))
    way = python.Program([0.0, 1.0, 2.0, 3.0, 4.0, 5.0], [-1e-7, 2e-8, 2e-8, 1e-8, 2e-8, -1e-6])
    found = python.cycle(solved, 1.0, program=way, length="3 nm")
    c, phase, part, P = (found.columns[name] for name in ("c_m", "phase", "part", "P_N"))
    assert list(dict.fromkeys(phase)) == ["free", "advance", "rest", "recede"]
    back, forth = (np.sort(P[part == number]) for number in (4, 5))
    assert back == pytest.approx(forth, rel=1e-9)
    assert np.ptp(P[phase == "rest"]) == 0
    assert c[-1] < c.max()
    assert found.summary()["contact_lost"]

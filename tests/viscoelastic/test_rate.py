"""Adhesion that depends on speed: a table of pull-off forces, asymptotes, balances, exact pieces, refusals."""

import math
import re
from collections.abc import Callable
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

import jkrcli as jkr_
from jkrcli.adhesion.curve import AdhesiveCurve, Nonadhesive
from jkrcli.adhesion.device_path import Program, cycle
from jkrcli.adhesion.slopes import slopes
from jkrcli.base.errors import InputError, Unknown
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.formulas import hertz
from jkrcli.methods.layered.solver import Layered
from jkrcli.series import Series
from jkrcli.viscoelastic.course import there_and_back
from jkrcli.viscoelastic.edge_zone import zone
from jkrcli.viscoelastic.rate import HISTORY_TOLERANCE, History, LogRate, PowerRate, RateContact

RIGID = math.inf
# a at P = 0, G = 1 of the half-space with E* = R = 1: 4 a^3/3 = sqrt(8 pi a^3).
UNLOADED = (4.5 * math.pi) ** (1 / 3)
# -P_min/pi with E* = R = w0 = v0 = 1, by another program's integrator steps, read off a parabola: good to 1e-6.
SPEEDS = (1e-3, 1e-2, 0.1, 1.0, 10.0)
TABLE = {
    (0.6, RIGID): (1.515478, 1.560937, 1.733807, 2.348038, 4.196531),
    (0.6, 1.0): (1.515086, 1.556731, 1.700427, 2.153421, 3.419229),
    (0.25, RIGID): (1.720007, 1.887319, 2.178502, 2.681615, 3.539316),
}


@cache
def half_space(length: float = 1.0, force: float = 1.0) -> Nonadhesive:
    """E* = R = 1, in units of ``length`` and ``force``."""
    a = np.geomspace(1e-3, 6, 80) * length
    E_star = force / length**2
    delta, P = hertz(a, E_star, length)
    series = Series(a, delta, P, 2 * E_star * a, np.full(80, 2 * E_star))
    return Nonadhesive(series, slopes(series))


@cache
def gel() -> Nonadhesive:
    """A thin nearly incompressible layer under a paraboloid, exact slopes."""
    specimen = Specimen((Layer(Elastic(15e3, 0.499), 0.36e-3),), Rigid(True))
    radii = tuple(np.geomspace(5e-6, 1.2e-3, 160))
    series = Layered(1e-9)(Problem(Paraboloid(6e-3), specimen, Loading.given("radius", radii))).series
    return Nonadhesive(series, slopes(series))


def pulled(V: float, n: float, stiffness: float = RIGID, tolerance: float = HISTORY_TOLERANCE) -> History:
    """Back at the speed ``V`` from equilibrium at no load."""
    contact = RateContact(half_space(), PowerRate(1.0, n), 1.0, 1.0, stiffness, tolerance=tolerance)
    x = float(contact.edge.position_at(np.array(UNLOADED), 1.0))
    return contact.history(Program(np.array([0.0]), np.array([x]), -V), UNLOADED)


def force(V: float, n: float, stiffness: float = RIGID) -> float:
    return -pulled(V, n, stiffness).pull_off.P / math.pi


@pytest.mark.parametrize(("n", "stiffness"), TABLE)
def test_the_table_of_pull_off_forces(n: float, stiffness: float) -> None:
    found = [force(V, n, stiffness) for V in SPEEDS]
    assert found == pytest.approx(TABLE[n, stiffness], rel=1e-5)  # measured 1.5e-6: the table's own


@pytest.mark.first(1)
@pytest.mark.parametrize(("n", "V", "stiffness"), [(1.0, 1e-6, RIGID), (1.0, 1e-6, 0.3), (0.6, 1e-10, RIGID)])
def test_a_very_slow_edge_is_followed(n: float, V: float, stiffness: float) -> None:
    """Its excess G/w0 - 1 of 1e-6 is the difference of large numbers."""
    one, two = (force(speed, n, stiffness) - 1.5 for speed in (V, 100 * V))
    assert math.log10(two / one) / 2 == pytest.approx(n, rel=0.002)


def test_a_held_displacement_agrees_with_the_quadrature_over_the_radius() -> None:
    """While the device stands where G began at 2 w0, t = int da/v(G(a)) is exact."""
    contact = RateContact(half_space(), PowerRate(1.0, 0.6), 1.0, 1.0)
    x = float(contact.edge.position_at(np.array(2.0), 2.0))
    history = contact.history(Program(np.array([0.0, 50.0]), np.array([x, x])), 2.0)
    (piece,) = history.pieces
    radius = float(piece.at(np.array([3.0]))[0])

    def slowness(a: float) -> float:
        return 1 / PowerRate(1.0, 0.6).speed(1.0, float(contact.edge.state(np.array(a), np.array(piece.ramp.x)).G) - 1)

    assert quad(slowness, radius, 2.0, epsrel=1e-12)[0] == pytest.approx(3.0, rel=1e-8)  # measured 2e-10


@pytest.mark.parametrize(("V", "stiffness"), [(1e-3, 0.0), (1.0, 0.3), (1e3, RIGID)])
def test_the_work_of_the_device_is_stored_or_done_by_the_edge(V: float, stiffness: float) -> None:
    history = pulled(V, 0.6, stiffness)
    assert history.balance < 1e-8
    assert history.ends == "lost"


def test_it_agrees_with_another_integrator_on_a_layer() -> None:
    body, law, w0 = gel(), PowerRate(2e-6, 0.4), 0.04
    contact = RateContact(body, law, w0, w0, 500.0)
    a0, V = 5e-4, 3e-6
    x0 = float(contact.edge.position_at(np.array(a0), w0))

    def rate(t: float, a: np.ndarray) -> np.ndarray:
        here = body.parts(np.clip(a, *body.a[[0, -1]]))
        lag = (here.delta_H + here.P_H / 500.0 - x0 + V * t) / (1 + here.S / 500.0)
        G = here.dS * lag**2 / (4 * math.pi * a)
        return -law.v0 * np.maximum(G / w0 - 1, 0) ** (1 / law.n)

    times = np.array([1.0, 5.0, 10.0])
    there = solve_ivp(rate, (0, 10.0), [a0], method="DOP853", rtol=1e-11, atol=1e-16, t_eval=times).y[0]
    history = contact.history(Program(np.array([0.0]), np.array([x0]), -V), a0)
    assert history.pieces[0].at(times) == pytest.approx(there, rel=1e-8)  # measured 2e-10


@pytest.mark.slow
def test_the_stated_error_holds_and_is_not_much_too_large() -> None:
    """Against a hundred thousandth of the tolerance; single errors are small by chance, so their median counts."""
    ratios = []
    for V, n, stiffness in ((1e-2, 0.6, RIGID), (1.0, 0.6, 1.0), (10.0, 0.25, RIGID), (0.3, 0.4, 0.2)):
        exact = pulled(V, n, stiffness, 1e-13).pull_off.P
        for tolerance in (1e-6, 1e-7, 1e-8):
            history = pulled(V, n, stiffness, tolerance)
            error = abs(history.pull_off.P / exact - 1)
            stated = history.error["P"]
            assert error < 3 * stated
            ratios.append(stated / max(error, 1e-14))
    assert np.median(ratios) < 10


def test_a_change_of_units_scales_everything() -> None:
    length, unit = 1e-5, 1e-9
    work, speed = unit / length, 3e-6
    small = RateContact(half_space(length, unit), PowerRate(speed, 0.6), work, 0.7 * work, unit / length)
    one = RateContact(half_space(), PowerRate(1.0, 0.6), 1.0, 0.7, 1.0)
    V = 0.1
    there = small.history(there_and_back(6.0 * length, V * speed, V * speed)).pull_off
    here = one.history(there_and_back(6.0, V, V)).pull_off
    assert there.P / unit == pytest.approx(here.P, rel=1e-8)
    assert there.t * speed / length == pytest.approx(here.t, rel=1e-7)


def test_slow_cycles_and_rests() -> None:
    contact = RateContact(half_space(), PowerRate(1.0, 0.6), 1.0, 0.6, 3.0)
    slow = contact.history(there_and_back(8.0, 1e-8, 1e-8))
    approach = AdhesiveCurve(half_space(), 0.6)
    turn = next(a for a in approach.radii_at(8.0, 3.0))
    quiet = cycle(approach, AdhesiveCurve(half_space(), 1.0), 3.0, turn)
    assert not isinstance(quiet, Unknown)
    assert slow.energy_lost == pytest.approx(quiet.energy_lost, rel=3e-4)  # the excess ~ V^0.46 is 2e-4 there
    assert slow.pull_off.P == pytest.approx(-1.5 * math.pi, rel=3e-4)
    contact = RateContact(half_space(), PowerRate(1.0, 0.6), 1.0, 0.5)
    history = contact.history(there_and_back(5.0, 1.0, 1.0, 2.0))
    assert [piece.phase for piece in history.pieces] == ["advance", "rest", "rest", "recede"]
    rest = history.pieces[2]
    t, a = rest.last
    state = contact.edge.state(np.array(a), np.array(5.0 - (t - 7.0)))
    assert float(state.G) == pytest.approx(1.0, rel=1e-12)
    assert contact.advancing.at(np.array(a))[0] == pytest.approx(5.0, rel=1e-12)
    assert history.turn == pytest.approx(5.0)


def test_a_program_of_steps_waits_and_ways_back() -> None:
    contact = RateContact(half_space(), PowerRate(1.0, 0.6), 1.0, 0.5, 3.0)
    t = np.array([0, 1, 2, 2, 3, 3, 4, 6, 8, 20, 30], dtype=float)
    x = np.array([-1, 1, 1, 2, 2, -1, -1, 3, 1, -10, 3], dtype=float)
    history = contact.history(Program(t, x))
    phases = [piece.phase for piece in history.pieces]
    assert phases == ["free", "advance", "rest", "rest", "advance", "rest", "rest", "recede", "recede", "rest",
                      "advance", "rest", "rest", "recede", "free", "free", "advance"]  # fmt: skip
    assert 8 < history.lost.t < 20
    table = history.table(50)
    assert (np.diff(table["t_s"]) >= 0).all()
    assert all(np.isfinite(table[name]).all() for name in ("t_s", "a_m", "delta_m", "P_N", "device_m", "G_J_per_m2"))
    assert table["device_m"] == pytest.approx(table["delta_m"] + table["P_N"] / 3.0, abs=1e-12)


def test_under_constant_load_contact_is_lost_after_a_while() -> None:
    contact = RateContact(half_space(), PowerRate(1.0, 0.6), 1.0, 0.5, 0.0)
    waits = []
    for load in (-5.0, -6.0):
        history = contact.history(there_and_back(5.0, 1e3, 1e3).dwelling(load, 1e4))
        assert history.ends == "lost"
        waits.append(history.waited)
        assert history.pull_off.P == load
        assert history.pull_off.t == pytest.approx(5.0 * 1e-3 + (5 - load) * 1e-3, rel=1e-12)  # when it is reached
    assert 0 < waits[1] < waits[0]
    stays = contact.history(there_and_back(5.0, 1e3, 1e3).dwelling(-4.5, 1e4))  # less than 3/2 pi
    assert (stays.lost, stays.waited) == (None, None)
    assert isinstance(stays.error["lost"], Unknown)


def test_the_time_of_loss_under_constant_load_its_error_and_the_end_of_the_trace() -> None:
    """While the load stands, t = int da/v(G(a)) is exact."""
    contact = RateContact(half_space(), PowerRate(1.0, 0.6), 1.0, 0.5, 0.0)
    history = contact.history(there_and_back(5.0, 1e3, 1e3).dwelling(-5.0, 1e4))
    piece = history.pieces[-1]

    def slowness(u: float) -> float:
        G = float(contact.edge.state(np.exp(u), np.array(-5.0)).G)
        return math.exp(u) / PowerRate(1.0, 0.6).speed(1.0, G - 1)

    begin, end = math.log(piece.first[1]), math.log(piece.last[1])
    exact = sum(quad(slowness, *ends, epsrel=1e-12)[0] for ends in pairwise(np.linspace(end, begin, 20)))
    stated = history.error["lost"]
    assert abs(history.waited / exact - 1) < 3 * stated < 1e-7  # measured 1e-10
    # Under load the displacement of a contact that runs away grows without bound; that is no state of it.
    table, lost = history.table(500), history.lost
    assert table["a_m"][-1] == pytest.approx(lost.start.a)
    assert lost.start.a > 20 * half_space().a[0]
    assert 0 < lost.t - table["t_s"][-1] < 1e-5 * lost.t
    assert (table["phase"] != "free").all()


def test_a_law_of_advance_delays_the_growth() -> None:
    at_once = RateContact(half_space(), PowerRate(1.0, 0.6), 1.0, 0.5)
    delayed = RateContact(half_space(), PowerRate(1.0, 0.6), 1.0, 0.5, law_advance=PowerRate(1.0, 0.6))
    program = there_and_back(5.0, 1.0, 1.0, 2.0)
    slow, quick = delayed.history(program), at_once.history(program)
    before = [history.table(100)["a_m"].max() for history in (slow, quick)]
    assert before[0] < before[1]
    nearly = delayed.history(there_and_back(5.0, 1e-6, 1.0)).table(100)["a_m"].max()
    assert nearly == pytest.approx(before[1], rel=1e-3)


@pytest.mark.parametrize("law", [PowerRate(2e-6, 0.3), LogRate(2e-6, 0.02)])
def test_a_law_and_its_inverse(law: PowerRate | LogRate) -> None:
    for v in (1e-9, 1e-6, 1e-4):
        assert law.speed(0.05, float(law.work(0.05, v)) - 0.05) == pytest.approx(v, rel=1e-7)
    assert float(law.work(0.05, 0.0)) == 0.05


@pytest.mark.parametrize(("make", "words"), [
    (lambda: PowerRate(1.0, 0.0), "power.n: must be > 0 and <= 100, got 0.0"),
    (lambda: LogRate(1.0, 0.0), "log.b: must be > 0, got 0.0 J/m^2"),
    (lambda: there_and_back(1.0, 1.0, 0.0), "program: the speed of retraction must be > 0, got 0"),
    (lambda: there_and_back(1.0, 1.0, 1.0, -2.0), "program: the hold must last >= 0 s, got -2"),
    (lambda: there_and_back(1.0, 1.0, 1.0).dwelling(2.0, 1.0), "the dwell must lie before the reversal at 1, got 2"),
    (lambda: there_and_back(1.0, 1.0, 1.0).dwelling(-2.0, 0.0), "program: the dwell must last > 0 s, got 0"),
    (lambda: RateContact(half_space(), PowerRate(1.0, 0.5), 1.0, 0.0, law_advance=PowerRate(1.0, 0.5)),
     "a law of closing needs a work of adhesion > 0 on approach, got 0 J/m^2"),
])  # fmt: skip
def test_bad_input_is_one_clear_line(make: Callable[[], object], words: str) -> None:
    with pytest.raises(InputError, match=re.escape(words)):
        make()


# ---------------------------------------------------------------------- the dissipating zone at the edge
def test_the_width_is_dugdales_and_its_shares_are_said() -> None:
    found = zone(2.0, 1.0, 1e6, 1e-3, 1e-4, 1e5, None)
    assert found.width == pytest.approx(math.pi * 1e6 * 2 / (4 * 1e10))
    assert found.over_a == pytest.approx(found.width / 1e-3)
    assert found.over_h == pytest.approx(found.width / 1e-4)
    assert found.words == "160 um, 0.16 of the contact radius and 1.6 of the layer's thickness"
    assert ["contact radius" in line or "layer" in line for line in found.warnings] == [True, True]
    # A half-space has no share of a layer, less than an atom is no size, and without a stress there is none.
    found = zone(1.0, 0.05, 1e9, 1e-4, math.inf, None, 1e-9)  # 50 MPa
    assert isinstance(found.over_h, Unknown)
    assert found.words == "310 nm, 0.0031 of the contact radius"
    assert found.warnings == []
    unknown = "unknown: no cohesive stress or range of adhesion is known: --stress"
    assert zone(1.0, 1.0, 1e6, 1e-3, 1e-4, None, None).words == unknown
    found = zone(0.07, 0.035, 2e4, 1e-3, 1e-4, None, 3e-10)
    for size in (found.width, found.over_a, found.over_h):
        assert isinstance(size, Unknown)
    assert "116.7 MPa, its size would be 0.081 pm, less than an atom" in found.words
    assert found.warnings == []


# ---------------------------------------------------------------------- ``jkr cycle --rate``
CASE = """
indenter = { shape = "paraboloid", radius = 1.0 }
specimen.half_space = { E = 0.75, nu = 0.5 }
loading = { radius = 5.0, points = 60, spacing = "log" }
adhesion.w = 1.0
"""
RATE = ("--rate", "v0=1,n=0.6")


@pytest.fixture(name="series")
def _series(jkr: Callable, tmp_path: Path) -> Path:
    (tmp_path / "unit.toml").write_text(CASE)
    assert jkr("run", "unit.toml", "-q").ok
    return tmp_path / "unit.h5"


def answer(jkr: Callable, *words: object) -> dict:
    return jkr("cycle", *words, "--json", "--no-plots").told


def test_pull_off_at_a_speed_under_a_dwell_and_by_a_table(jkr: Callable, series: Path) -> None:
    # The table's value at V = 0.1, n = 0.6, a rigid device, from equilibrium at no load.
    found = answer(jkr, series, *RATE, "--speed", "0.1 m/s", "--to-load", "0 N")
    assert -found["pull_off"]["P_N"] / math.pi == pytest.approx(1.733807, rel=1e-5)
    assert found["contact_lost"]
    assert found["rate"] == {"law": "power", "v0_m_per_s": 1.0, "n": 0.6}
    assert found["turn_t_s"] < found["pull_off"]["t_s"] < found["lost_t_s"]
    found = answer(jkr, series, *RATE, "--speed", "1 N/s", "--stiffness", "load", "--dwell", "-5 N", "--dwell-time",
                   "1000 s")  # fmt: skip
    assert found["contact_lost"]
    assert found["pull_off"]["P_N"] == pytest.approx(-5.0)
    Path("way.csv").write_text("t_s,x_m\n0,-1\n10,1\n12,1\n12,0\n40,-20\n")
    found = answer(jkr, series, *RATE, "--program", "way.csv", "--rate-advance", "law=log,v0=1,b=0.2")
    assert found["contact_lost"]
    assert found["rate_advance"] == {"law": "log", "v0_m_per_s": 1.0, "b_J_per_m2": 0.2}


@pytest.mark.parametrize(("words", "said"), [
    (("--rate", "v0=0,n=0.6", "--speed", "1"), "--rate: v0: must be > 0, got 0"),
    (("--rate", "v0=1", "--speed", "1"), '--rate: the law "power" needs n too, such as v0="1 um/s"'),
    (("--rate", "v0=1,m=2", "--speed", "1"), '--rate: the law "power" has no parameter "m" (it has: v0, n)'),
    (("--rate", "law=powr,v0=1", "--speed", "1"), 'unknown law "powr", did you mean "power"? (laws: power, log)'),
    (("--rate", "v0=1 kg,n=1", "--speed", "1"), '--rate: v0: must be a speed, got "1 kg": unknown unit "kg"'),
    ((*RATE, "--speed", "1", "--speed-approach", "0 m/s"), "--speed-approach: must be > 0, got 0 m/s"),
    (RATE, 'cycle: --rate needs the motion of the instrument: --speed "10 um/s", or --program TABLE'),
    (("--speed", "1"), "cycle: --speed needs --rate: without it nothing depends on time"),
    ((*RATE, "--speed", "1", "--dwell", "1"), "cycle: --dwell and --dwell-time go together"),
    ((*RATE, "--program", "x.csv", "--hold", "1"), "cycle: give either --hold or --program"),
    (("--program", "step.csv"), "program: row 3: a jump needs a duration: a later time, or --rate"),
    (("--program", "step.csv", "--to-load", "1"), "cycle: give either --to-load or --program"),
    ((*RATE, "--program", "bad.csv"), "program: time must not fall, got t = 1 s after 2 s in row 3"),
    ((*RATE, "--program", "units.csv"), 'units.csv: column 2 is to be a length, got the unit "mN"'),
    ((*RATE, "--speed", "1", "--w-approach", "2 J/m^2", "--w-retract", "1 J/m^2"), "must be >= that of the"),
])  # fmt: skip
def test_what_is_wrong_is_one_line(jkr: Callable, series: Path, words: tuple[str, ...], said: str) -> None:
    Path("step.csv").write_text("t_s,x_m\n0,0\n1,2\n1,1\n2,-4\n")
    Path("bad.csv").write_text("t_s,x_m\n0,0\n2,5\n1,4\n")
    Path("units.csv").write_text("t_s,x_mN\n0,0\n2,5\n3,4\n")
    jkr("cycle", series, *words).refused(said)


def test_an_edge_beyond_all_numbers_is_one_line(jkr: Callable, tmp_path: Path) -> None:
    (tmp_path / "l.toml").write_text("""
indenter = { shape = "paraboloid", radius = "1 mm" }
specimen.layers = [{ thickness = "0.2 mm", E = "1 MPa", nu = 0.3 }]
loading = { radius = "0.1 mm", points = 20 }
adhesion = { w = "50 mJ/m^2" }
""")
    said = "l.h5: the motion of the contact line could not be integrated beyond a = 0.0001 m: look at v0"
    jkr("cycle", "l.toml", "--rate", "law=log,v0=1e-30,b=1", "--speed", "1e30", "-q").refused(said)


def test_runs_of_cycle_that_differ_in_an_option_have_files_of_their_own(jkr: Callable, series: Path) -> None:
    """Once each overwrote the one before."""
    runs = [
        (*RATE, "--speed", "0.1 m/s"), (*RATE, "--speed", "0.2 m/s"), ("--rate", "v0=2,n=0.6", "--speed", "0.2"),
        ("--to-depth", "0.2"), (), ("--w-retract", "1.5"), ("--stiffness", "2 N/m"), ("--modulus-factor", "2"),
    ]  # fmt: skip
    for words in runs:
        assert jkr("cycle", series, *words, "--no-plots", "--points", 20).ok
    names = sorted(path.name for path in series.parent.glob("*-cycle*"))
    assert len(names) == len(runs)
    assert {"unit-cycle.csv", "unit-cycle-to-depth0.2.csv", "unit-cycle-rate-power-1-0.6-speed0.1.csv"} <= set(names)


def test_the_pictures_of_cycle_say_w_and_speed(series: Path) -> None:
    title = jkr_.cycle(series, 1.5, w_approach=1.0).figure().get_suptitle()
    assert "w = 1 J/m² on approach, 1.5 J/m² on retraction" in title
    history = jkr_.cycle_at_speed(series, 1.0, {"v0": 1.0, "n": 0.6}, 0.1, speed_approach=0.2, to_load=0.0)
    title = history.figure().get_suptitle()
    assert "200 mm/s in, 100 mm/s out" in title
    assert "w = 1 J/m²\n" in title

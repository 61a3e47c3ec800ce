"""``jkr cycle --rate``: the files, the figures for machines, and one clear line for what is wrong."""

import math
from collections.abc import Callable
from pathlib import Path

import pytest

import jkrcli as jkr_

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

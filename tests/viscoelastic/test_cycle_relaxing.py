"""``jkr cycle`` of a specimen that relaxes: over time without adhesion, in its limits with it."""

import csv
import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import CASES

import jkrcli as jkr_
from jkrcli.adhesion.curve import DISPLACEMENT_CONTROL, CriticalPoint
from jkrcli.adhesion.device_path import Program
from jkrcli.adhesion.finite_range import Range
from jkrcli.base.errors import Unknown
from jkrcli.viscoelastic.relaxing_adhesion import RelaxingAdhesion
from jkrcli.viscoelastic.report import CycledAdhering

CASE = """
indenter = { shape = "paraboloid", radius = 1.0 }
loading = { depth = 1.0, points = 60, spacing = "log" }
[specimen]
relaxation = { law = "sls", ratio = 0.25, time = 1.0 }
half_space = { E = 1.0, nu = 0.0 }
"""


@pytest.fixture(name="series")
def _series(jkr: Callable, tmp_path: Path) -> Path:
    (tmp_path / "gel.toml").write_text(CASE)
    assert jkr("run", "gel.toml", "-q").ok
    return tmp_path / "gel.h5"


def answer(jkr: Callable, *words: object) -> dict:
    return jkr("cycle", *words, "--json", "--no-plots").told


def test_the_trace_over_time_holds_and_programs(jkr: Callable, series: Path) -> None:
    done = jkr("cycle", series, "--speed", "1 m/s", "--points", 101).ok
    assert "no adhesion; standard linear solid, ratio = 0.25, time = 1 s" in done.out
    assert "contact is lost at t = 1.624 s; it shrinks from t = 1 s on" in done.out
    with (series.parent / "gel-cycle-speed1.csv").open() as file:
        rows = list(csv.DictReader(file))
    t, P = (np.array([float(row[name]) for row in rows]) for name in ("t_s", "P_N"))
    np.testing.assert_allclose(np.interp([0.5, 1.25, 1.5], t, P), [0.40976766, 0.45146169, 0.08167490], atol=1e-7)
    assert {row["phase"] for row in rows} == {"free", "advance", "recede"}
    assert (series.parent / "gel-cycle-speed1.svg").exists()
    history = jkr_.cycle_relaxing(series, speed=1.0)
    assert history.lost == pytest.approx(1.62384979, abs=1e-7)
    np.testing.assert_allclose(history.table(101)["P_N"], P, rtol=1e-8, atol=1e-12)
    assert history.error < 1e-6  # 4e-8, of steps twice as long
    held = answer(jkr, series, "--speed", "1", "--hold", "5 s")
    Path("way.csv").write_text("t_s,x_m\n0,-1\n1,0\n2,1\n7,1\n8,0\n")
    told = answer(jkr, series, "--program", "way.csv")
    assert [corner["P_N"] for corner in told["corners"]] == pytest.approx([c["P_N"] for c in held["corners"]])
    assert held["corners"][1]["P_N"] == pytest.approx(1 / 3 + (1.02621407 - 1 / 3) * math.exp(-5), rel=1e-7)
    Path("creep.csv").write_text("t_s,P_N\n0,0\n0,0.1\n9,0.1\n")
    crept = answer(jkr, series, "--program", "creep.csv", "--stiffness", "load")
    creep = 0.1 * (4 - 3 * math.exp(-9 / 4))
    assert crept["corners"][-1]["delta_m"] == pytest.approx((0.75 * creep) ** (2 / 3), rel=1e-9)
    assert not crept["contact_lost"]


@pytest.mark.slow
@pytest.mark.parametrize("stiffness", ["rigid", "2 N/m", "load"])
def test_a_turn_at_a_load_or_depth(jkr: Callable, series: Path, stiffness: str) -> None:
    speed = ("--speed", "1", "--stiffness", stiffness)
    found = answer(jkr, series, *speed, "--to-load", "0.2 N")
    assert found["largest_load"]["P_N"] == pytest.approx(0.2, rel=1e-7)
    deep = answer(jkr, series, *speed, "--to-depth", found["corners"][0]["delta_m"])
    assert deep["largest_load"]["P_N"] == pytest.approx(0.2, rel=1e-6)
    assert found["load_relative_error"] < 1e-4  # 2e-5 of the spring, of steps twice as long
    assert found["contact_lost"]


@pytest.mark.parametrize("stiffness", ["10 N/m", "rigid"])
def test_the_end_of_the_series_is_where_it_turns(jkr: Callable, tmp_path: Path, stiffness: str) -> None:
    """Where nothing is said of the turn; at 10 N/m it is found 2e-9 beyond."""
    assert jkr("run", CASES / "relaxing-gel.toml", "-o", tmp_path / "gel.h5", "-q").code == 0
    found = answer(jkr, tmp_path / "gel.h5", "--speed", "1 um/s", "--stiffness", stiffness)
    assert found["corners"][0]["delta_m"] == pytest.approx(1e-4, rel=1e-7)


@pytest.mark.parametrize(
    ("stiffness", "hold"), [("1 N/m", 0), ("10 N/m", 20), pytest.param("load", 20, marks=pytest.mark.slow)]
)
def test_creep_after_a_turn_stays_within_the_series(jkr: Callable, tmp_path: Path, stiffness: str, hold: float) -> None:
    """Once "the contact comes 2.6 um beyond the largest depth of the series", without anything said of the turn."""
    assert jkr("run", CASES / "relaxing-gel.toml", "-o", tmp_path / "gel.h5", "-q").code == 0
    speed = "1 mN/s" if stiffness == "load" else "1 um/s"
    done = jkr("cycle", "gel.h5", "--speed", speed, "--stiffness", stiffness, "--hold", f"{hold} s", "--no-plots").ok
    assert ", at the end of the solution; energy lost" in done.out
    (table,) = Path().glob("gel-cycle-*.csv")
    deepest = float(np.max(np.genfromtxt(table, delimiter=",", names=True, dtype=None)["delta_m"]))
    assert 0.998e-4 < deepest < 1.0000001e-4


@pytest.mark.parametrize("words", [("export", "--dem", "--w", 0.1), ("explore", "--w", 1), ("profile", "--a", 0.3)])
def test_verbs_of_constant_moduli_say_so(jkr: Callable, series: Path, words: tuple[object, ...]) -> None:
    """What ``transform`` warns of, ``run`` and the others do: these are the moduli at t = 0. Once only it did."""
    verb, *options = words
    done = jkr(verb, series, *options).ok
    (warning,) = (text for text in jkr_.transform(series, 1.0).warnings if "relaxes" in text)
    assert f"{series}: {warning}" in " ".join(done.err.split())
    assert warning in " ".join(jkr("run", "gel.toml", "-o", "again.h5").err.split())


@pytest.mark.slow
def test_limits_where_surfaces_adhere(jkr: Callable, series: Path) -> None:
    work = ("--w-approach", "10 mJ/m^2")
    found = answer(jkr, series, *work)
    (series.parent / "hard.toml").write_text(CASE.replace('relaxation = { law = "sls", ratio = 0.25, time = 1.0 }', ""))
    hard = answer(jkr, "hard.toml", *work)
    soft = answer(jkr, "hard.toml", *work, "--modulus-factor", 0.25)
    for name, beside in (("very fast", hard), ("very slow", soft)):
        lost = found["limits"][name]["jumps_on_retraction"][-1]["from"]
        assert lost == pytest.approx(beside["jumps_on_retraction"][-1]["from"])
    rest = found["limits"]["from rest"]
    assert (rest["profile"], rest["moduli"]) == (0.25, 1.0)
    rated = answer(jkr, series, *work, "--rate", "v0=1,n=0.5", "--speed", "1", "--to-depth", "0.2")
    assert (set(rated["limits"]), rated["limits"]["very slow"]["moduli"]) == ({"very fast", "very slow"}, 0.25)
    said = jkr("cycle", series, *work, "--no-plots").out
    assert "very slow cycle, the moduli times 0.25:" in said
    assert "at rest at P = 0, then pulled instantly:" in said
    for name in ("very-slow", "from-rest"):
        assert (series.parent / f"gel-cycle-w-approach0.01-{name}.csv").exists()


@pytest.mark.parametrize(("words", "line"), [
    (("cycle", "gel.toml", "--speed", "1 um/s", "--hold", "-1 s"), "--hold: must be >= 0, got -1 s"),
    (("cycle", "gel.toml", "--speed", "1 um/s", "--stiffness", "load"), 'a rate of loading, got "1 um/s": unknown'),
    (("explore", "gel.toml", "-o", "."), ".: is a folder, cannot be written as a file"),
    (("profile", "gel.toml", "--a", "0.5", "-o", "gel.toml/in"), "cannot be made a folder (Not a directory)"),
])  # fmt: skip
def test_what_is_wrong_is_refused_before_a_solve(jkr: Callable, tmp_path: Path, words: tuple, line: str) -> None:
    (tmp_path / "gel.toml").write_text(CASE)
    jkr(*words).refused(line)
    assert [path.name for path in tmp_path.iterdir()] == ["gel.toml"]


ADHERES = ("--w-approach", "50 mJ/m^2", "--speed", "1 m/s")
WIDE = ("--stress", "0.15 Pa", "--to-depth", "0.05 m")
REFUSED = [
    ((), 'cycle: viscoelastic specimen: give the motion, --speed "10 um/s" or --program TABLE'),
    (("--rate", "v0=1,n=0.5", "--speed", "1"), "cycle: --rate needs adhesion: give --w-approach, or leave it out"),
    (("--w-approach", "1 mJ/m^2", "--speed", "1"), "needs a cohesive stress or range: add --stress or --range"),
    (("--speed", "1", "--to-depth", "2 m"), "comes 1 m beyond the largest depth of the solution, 1 m: reverse before"),
    (
        ("--speed", "1", "--to-load", "5 N"),
        "at P = 5 N is not reached on approach, which in this solution ends at 1.026",
    ),
    (
        ("--speed", "1", "--dwell", "0.8", "--dwell-time", "1 s"),
        "is loaded again before its dent recovers, which is not",
    ),
    (("--program", "way.csv"), "program: never presses: its largest value is -1, contact begins at 0"),
    ((*ADHERES, *WIDE, "--rest-depth", "0.1 m"), "a retraction from rest has its --speed only: leave --to-depth out"),
    ((*ADHERES, "--stress", "30 Pa", "--to-depth", "0.1 m"), "is too narrow beside"),
    ((*ADHERES, *WIDE, "--w-retract", "60 mJ/m^2"), "give one work of adhesion"),
    ((*ADHERES, "--stress", "1 Pa", "--stiffness", "1 N/m"), "give the reversal, --to-load or --to-depth"),
]


@pytest.mark.parametrize(("words", "line"), REFUSED)
def test_what_is_refused(jkr: Callable, series: Path, words: tuple[str, ...], line: str) -> None:
    Path("way.csv").write_text("0,-1\n1,-2\n")
    jkr("cycle", series.name, *words).refused(line)
    assert not (series.parent / "gel-cycle.csv").exists()


WRONG = [
    ("sls", "sld", 'law must be one of sls, kelvin-voigt, power, prony, got sld, did you mean "sls"?'),
    ("0.25", "1.5", "specimen.relaxation.ratio: must be >= 0 and <= 1, got 1.5"),
    ("time = 1.0", 'time = "1 um"', 'specimen.relaxation.time: must be a time, got "1 um": unknown unit "um"'),
    ("ratio = 0.25, ", "", "specimen.relaxation.ratio: is required"),
    ('{ law = "sls", ratio = 0.25, time = 1.0 }', "0.25", 'must be a table, such as { law = "sls"'),
    (
        'law = "sls", ratio = 0.25, time = 1.0',
        'law = "prony", weights = [0.7, 0.7], times = [1, 2]',
        "the weights must be",
    ),
    ("radius = 1.0", "radius = 1.0, E = 1.0, nu = 0.3", "needs a rigid indenter: an elastic one does not relax with"),
    (
        "[specimen]",
        '[specimen]\nsurface = "sticking"',
        "specimen.relaxation: is for frictionless contact only: leave out",
    ),
]


@pytest.mark.parametrize(("old", "new", "line"), WRONG)
def test_wrong_cases(old: str, new: str, line: str) -> None:
    with pytest.raises(jkr_.InputError) as error:
        jkr_.parse_case(CASE.replace(old, new))
    assert line in str(error.value)


def test_laws_and_their_files_and_limits(tmp_path: Path, jkr: Callable) -> None:
    half = jkr_.Specimen((), jkr_.HalfSpace(jkr_.Elastic(1.0, 0.0)))
    for law in (jkr_.StandardSolid(0.5, 2.0), jkr_.PowerRelaxation(1.0, 0.2), jkr_.Prony((0.2, 0.3), (1.0, 2.0))):
        specimen = jkr_.Specimen(half.layers, half.base, relaxation=law)
        problem = jkr_.Problem(jkr_.Paraboloid(1.0), specimen, jkr_.Loading("depth", 1.0))
        solved = jkr_.solve(problem)
        jkr_.save(solved, tmp_path / "gel.h5", force=True)
        assert jkr_.read(tmp_path / "gel.h5").problem.specimen.relaxation == law
        assert "the specimen relaxes: " in jkr_.transform(solved, 0.01).warnings[0]
    power = '{ law = "power", time = 1.0, exponent = 0.2 }'
    (tmp_path / "power.toml").write_text(CASE.replace('{ law = "sls", ratio = 0.25, time = 1.0 }', power))
    jkr("cycle", "power.toml", "--w-approach", "1 mJ/m^2", "-q").refused("a power law has neither an")


def test_what_is_said_of_a_specimen_that_relaxes(jkr: Callable, series: Path) -> None:
    done = jkr("check", series.with_suffix(".toml"))
    assert "  moduli    standard linear solid, ratio = 0.25, time = 1 s; loads here are those at t = 0" in done.out
    found = jkr_.cycle(series, 0.01)
    for history, result in found.limits.values():
        title = result.figure().get_suptitle()
        assert "w = 10 mJ/m²" in title
        assert history.words in title


def test_adhesion_over_time_in_words() -> None:
    half_space = jkr_.Specimen((), jkr_.HalfSpace(jkr_.Elastic(1.0, 0.0)))
    solved = jkr_.solve(jkr_.Problem(jkr_.Paraboloid(1.0), half_space, jkr_.Loading("depth", 0.1)))
    law = jkr_.StandardSolid(0.25, 1.0)
    contact = RelaxingAdhesion.of(solved, Range.of(0.05, stress=0.1), law, DISPLACEMENT_CONTROL)
    program = Program(np.array([0.0, 0.1]), np.array([contact.least, 0.02]), -1.0)
    limits = {"very fast": CriticalPoint(0.5, -0.1, -0.2, "minimum"), "very slow": Unknown("there is none")}
    found = CycledAdhering.of(replace(contact, tolerance=0.05), program, Path("gel.h5"), limits, 20)
    text, summary, rows = "\n".join(found.words()), found.summary(), found.columns
    assert "contact is lost at t" in text
    assert "J in the body" in text
    assert "limits: 200 mN (very fast)" in text
    assert summary["limits"] == {"pull_off_very_fast_P_N": -0.2, "pull_off_very_slow_P_N": None}
    assert summary["pull_off"]["P_N"] == pytest.approx(rows["P_N"][rows["t_s"] > 0.1].min())
    assert summary["range_m"] == pytest.approx(0.5)
    assert list(rows) == ["t_s", "a_m", "delta_m", "P_N", "device_m", "phase", "part", "c_m"]
    assert {"advance", "recede"} <= set(rows["phase"])
    assert (rows["c_m"] >= rows["a_m"]).all()
    parts = summary["dissipated_in_body_J"] + summary["radiated_in_jumps_J"]
    assert summary["energy_lost_J"] == pytest.approx(parts, rel=0.05)
    json.dumps(summary)


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [('law = "sls", ratio = 0.25', 'law = "power", exponent = 0.2', "a power law has no instantaneous modulus"),
     ("[specimen]", '[specimen]\nsurface_tension = "10 mN/m"', "surface_tension")],
)  # fmt: skip
def test_adhesion_over_time_is_not_for_every_body(
    jkr: Callable, tmp_path: Path, old: str, new: str, line: str
) -> None:  # fmt: skip
    (tmp_path / "other.toml").write_text(CASE.replace(old, new))
    jkr("cycle", "other.toml", *ADHERES, *WIDE, "-q").refused(line)


def test_cycles_with_adhesion_begin_at_rest_and_state_their_limits(jkr: Callable, series: Path) -> None:
    """Pulled at once the force falls short of the third limit, which is stated beside the other two; from Python, too.
    Once --rest-depth with --speed was refused, and cycle_relaxing had no adhesion."""
    work = ("--w-approach", 0.05, "--stress", 0.3, "--speed", 1e4)
    found = answer(jkr, series, *work, "--rest-depth", 0.0)
    forces = {name: -P for name, P in found["limits"].items()}
    assert forces["pull_off_from_rest_P_N"] > -found["pull_off"]["P_N"] > 1.5 * forces["pull_off_very_fast_P_N"]
    assert found["at_rest_at_the_begin"]
    assert found["energy_lost_J"] is None
    history = jkr_.cycle_relaxing(series, speed=1e4, w=0.05, stress=0.3, rest_depth=0.0)
    assert history.pull_off.P == pytest.approx(found["pull_off"]["P_N"], rel=1e-6)
    labels = [text.get_text() for text in history.figure().legends[0].get_texts()]
    assert {"pull-off very fast", "pull-off very slow", "pull-off from rest"} <= set(labels)
    jkr("cycle", series, *work, "--rest-depth", 0.0, "--hold", 1).refused("--hold")
    with pytest.raises(jkr_.InputError, match="stress or length"):
        jkr_.cycle_relaxing(series, speed=1.0, w=0.05)

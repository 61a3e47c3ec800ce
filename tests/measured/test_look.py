"""``jkr look``: any measured file drawn and told, before any body is thought of."""

import json
import math
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import CASES, Outcome, write_table
from force_curves import Instrument, record

from jkrcli.bodies.indenters import Pyramid, RoundedCone, Sphere

E_STAR, R, W, K = 20e3, 5e-6, 1e-4, 0.05
FORCE = 1.5 * np.pi * W * R


@pytest.fixture
def table(tmp_path: Path) -> Path:
    device = Instrument(K, 1000, 3e-6, 4 * FORCE, 0.01 * FORCE, FORCE, pause=100)
    columns = record(E_STAR, R, 0.0, W, device, 1)
    rounded = [np.round(values, digits) for values, digits in
               ((columns["t"], 6), (columns["z"] * 1e9, 4), (columns["P"] * 1e9, 6))]  # fmt: skip
    return write_table(tmp_path / "probe.csv", "t_s,delta_nm,P_nN", *rounded)


def test_a_table_is_told_and_drawn(jkr: Callable[..., Outcome], table: Path, tmp_path: Path) -> None:
    done = jkr("look", str(table), "--stiffness", "0.05 N/m").ok
    assert done.out.startswith("adhesion force 2.37 nN, largest load 9.43 nN: ")
    assert done.out.splitlines()[1].startswith("  2100 rows of displacement, load, time; approach 100")
    assert ", dwell " in done.out
    assert "no jump into contact" in done.out
    assert "by one jump at -" in done.out
    assert {path.name for path in table.parent.iterdir()} == {"probe.csv", "probe-look.png", "probe-look.svg"}
    a = np.concatenate([np.linspace(3e-4, 7e-4, 30), np.linspace(7e-4, 3e-4, 30)])
    names = "contact radius (um),displacement (um),load (mN)"
    file = write_table(tmp_path / "lens.csv", names, 1e6 * a, 1e6 * a**2 / 1e-2, 1e3 * 2e9 * a**3)
    printed = jkr("look", str(file), "--no-plots").out
    assert "loading-unloading table" in printed
    assert "contact radius 300 um to 700 um" in printed
    assert "base line of" not in printed


def test_a_rough_w_is_that_of_the_adhesion_force(jkr: Callable[..., Outcome], table: Path) -> None:
    words = ("look", str(table), "--stiffness", "0.05 N/m", "--no-plots")
    done = jkr(*words, "--shape", "paraboloid", "--radius", "5 um")
    assert re.search(
        r"^  rough: E\* = \d+ kPa \(half-space without adhesion, largest load, a = .*\), w = ", done.out, re.M
    )
    found = jkr(*words, "--shape", "paraboloid", "--radius", "5 um", "--json").told["files"][0]["curves"][0]
    force = found["retract"]["adhesion_force_N"]
    assert found["rough"]["w_J_per_m2"] == pytest.approx(force / (1.5 * np.pi * R), rel=1e-4)
    assert "rough:" not in jkr(*words).out
    jkr(*words, "--shape", "cone").refused("look: --half-angle missing")
    volts = jkr("look", str(table), "--unit", "P=V", "--no-plots", "--radius", "5 um")
    first, _, second, *_ = volts.out.splitlines()
    assert first.startswith("adhesion force unknown, loads in arbitrary units: ")
    assert second.endswith("loads in arbitrary units, give --sensitivity and --stiffness")
    assert "no rough modulus: loads are in arbitrary units" in volts.out


@pytest.mark.parametrize("shape", ["sphere", "pyramid", "rounded-cone"])
def test_a_tip_gives_a_rough_modulus(jkr: Callable[..., Outcome], tmp_path: Path, shape: str) -> None:
    """The load of a contact of 60 kPa pressed to 300 nm, over the formula's at the depth beyond where touch is seen."""
    flags, tip = {
        "sphere": (("--radius", "5 um"), Sphere(5e-6)),
        "pyramid": (("--shape", "pyramid", "--half-angle", "35 deg"), Pyramid.of(4, math.radians(35))),
        "rounded-cone": (("--shape", "rounded-cone", "--radius", "50 nm", "--half-angle", "35 deg"),
                         RoundedCone(50e-9, math.radians(35))),
    }[shape]  # fmt: skip
    a = np.geomspace(1e-10, 5e-6 if shape == "sphere" else 1e-6, 4000)[:-1]
    delta, P = tip.half_space(a, 60e3)
    z = np.concatenate([way := np.linspace(-700, 300, 2001), way[::-1]])
    load = np.interp(z * 1e-9, delta, P, left=0.0) * 1e9
    noise = np.random.default_rng(0).normal(0, 1e-4 * load.max(), z.size)
    write_table(tmp_path / "tip.csv", "delta_nm,P_nN", z, load + noise)
    (curve,) = jkr("look", "tip.csv", *flags, "--stiffness", "rigid", "--json", "--no-plots").told["files"][0]["curves"]
    depth = 300e-9 - curve["approach"]["touch_m"]
    held, there = np.interp([300e-9, depth], delta, P)
    assert curve["rough"]["E_star_Pa"] == pytest.approx(60e3 * held / there, rel=1e-3)
    assert curve["rough"]["a_m"] == pytest.approx(np.interp(depth, delta, a), rel=1e-3)
    assert curve["rough"]["w_J_per_m2"] is None


def test_no_base_line_leaves_nothing_that_is_told_over_it(jkr: Callable[..., Outcome], tmp_path: Path) -> None:
    z = np.concatenate([way := np.linspace(0.2, 1.0, 500), way[::-1]])
    path = write_table(tmp_path / "deep.csv", "delta_um,P_nN", z, 30 * z**1.5)
    done = jkr("look", str(path), "--no-plots")
    words = "no straight base line: where contact"
    assert f"approach  {words} begins and the largest load are unknown" in done.out
    assert f"retract   {words} ends and the adhesion force are unknown" in done.out
    assert done.out.count("base line") == 4  # that there is none: the verdict, of each direction and of the record
    told = jkr("look", str(path), "--json", "--no-plots").told["files"][0]["curves"][0]["retract"]
    assert told["base_line"] is None
    assert told["touch_m"] is None
    assert told["adhesion_force_N_unknown"] == "there is no base line"


def test_a_radius_of_metres_is_remarked(jkr: Callable[..., Outcome], table: Path) -> None:
    done = jkr("fit", "--radius", "5", "--nu", "0.5", str(table), "--no-plots", "--stiffness", "0.05 N/m")
    assert done.err.startswith('jkr: warning: --radius 5 without a unit is 5 m: give its unit, --radius "5 um"\n')


@pytest.mark.parametrize(("words", "said"), [
    (("--radius", "5 um"), "fit: needs a case or solution file, or the specimen from options: --nu missing"),
    ((), "fit: needs --radius and --nu (specimen from options), or a case: jkr fit CASE MEASURED"),
    (("sphere.toml", "--radius", "5 um", "--nu", "0.5"), "from options, not both: sphere.toml and --radius, --nu"),
    (("gel.h5", "--radius", "5 um"), "from options, not both: gel.h5 and --radius"),
])  # fmt: skip
def test_a_body_is_a_file_or_flags(jkr: Callable[..., Outcome], table: Path, words: tuple[str, ...], said: str) -> None:
    """A series file was read as a measured one: "--nu missing"."""
    if "gel.h5" in words:
        assert jkr("run", CASES / "soft-gel.toml", "-o", "gel.h5", "-q").code == 0
    jkr("fit", *words, str(table)).refused(said)


def test_a_file_without_any_usable_curve_leaves_table_and_picture(jkr: Callable, tmp_path: Path) -> None:
    z = np.concatenate([np.linspace(-3, 0, 200), np.linspace(0, -3, 200)])
    path = write_table(tmp_path / "free.csv", "delta_um,P_nN", z, np.random.default_rng(1).normal(size=400))
    words = ("fit", "--radius", "5 um", "--nu", "0.5", "--contact", "fitted", str(path))
    for _ in range(2):
        jkr(*words).refused(f"{path}: no contact: the load never leaves its base line")
    assert json.loads((tmp_path / "free-fit.json").read_text())["curves"][0]["status"] == "unusable"
    assert (tmp_path / "free-fit-free.png").exists()


def test_what_is_no_measurement_is_said_to_be_none(jkr: Callable[..., Outcome], table: Path) -> None:
    """A case was told to "give --separator and --decimal", a series was "no file that afmformats reads"."""
    (table.parent / "gel.toml").write_bytes((CASES / "soft-gel.toml").read_bytes())
    assert jkr("run", "gel.toml", "-o", "gel.h5", "-q").code == 0
    for words, line in {
        ("look", "gel.toml"): "gel.toml: is a case file, no measurement",
        ("fit", "gel.toml", "gel.h5"): "gel.h5: was written by jkr (jkr-series), is no measurement",
        ("run", "gel.h5", "-o", "other.h5"): "gel.h5: is not a text file (byte 0 is not UTF-8); for the case of a "
        "solution file use jkr show --case",
    }.items():
        jkr(*words).refused(line)


def test_columns_that_are_not_what_they_should_be(jkr: Callable[..., Outcome], tmp_path: Path) -> None:
    # P_mn was left out without a word, and E* with it.
    rows = "".join(f"{i},{i * i},{i**3}\n" for i in range(1, 30))
    (tmp_path / "probe.csv").write_text(f"a_um,delta_nm,P_mn\n{rows}")
    done = jkr("fit", "--radius", "1 mm", "--nu", "0.5", "probe.csv", "--no-plots")
    line = 'column 3 "P_mn" left out: it ends in no unit of load; if it is the load: --column P=P_mn --unit P=mN'
    assert f"jkr: warning: probe.csv: {line}\n" in done.err
    assert jkr("look", "probe.csv").err.endswith(f"jkr: error: probe.csv: {line}\n")
    rows = "".join(f"{i},{i * i},{i**3}\n" for i in range(1, 12))
    (tmp_path / "probe.csv").write_text(f"a_um,delta_nm,P_nN\n{rows}")
    jkr("look", "probe.csv", "--sensitivity", "45 nm/V").refused("this file holds no volts", "--unit P=V")


def test_no_row_and_no_file_is_dropped_silently(jkr: Callable[..., Outcome], table: Path, tmp_path: Path) -> None:
    for flags in ((), ("--json",)):
        done = jkr("look", "missing.txt", table, "--no-plots", *flags)
        assert (done.code, "missing.txt" in done.err, "probe" in done.out) == (2, True, True)
    z = np.linspace(1.0, -3.0, 400)
    load = 30 * np.maximum(z, 0) ** 1.5 + 0.05 * np.random.default_rng(1).normal(size=400)
    rows = [f"{x},{P}" for x, P in zip(z, load, strict=True)]
    path = tmp_path / "back.csv"
    told = [f"{rows[0]},approach", *(f"{row},retract" for row in rows)]
    path.write_text("\n".join(["delta_um,P_nN,segment", *told]) + "\n")
    done = jkr("look", str(path), "--no-plots")
    assert "401 rows of displacement, load; approach 1, retract 400" in done.out
    assert "no approach: 1 of its rows, at least 20 are needed" in done.out
    path.write_text("\n".join(["delta_um,P_nN", *rows]) + "\n")
    assert "400 rows of displacement, load; retract 400; " in jkr("look", str(path), "--no-plots").out
    path.write_text("\n".join(["delta_um,P_nN", rows[1], *rows]) + "\n")
    assert "401 rows of displacement, load; retract 400, 1 of neither" in jkr("look", str(path), "--no-plots").out

"""The contact law for particle codes: its points, its table, and the C that reads it."""

from __future__ import annotations

import json
import math
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from jkrcli.report.export import DemLaw, interpolated

CASE = """
indenter = {{ shape = "paraboloid", radius = "10 um" }}
specimen{specimen}
loading = {{ radius = "3 um", points = 100 }}
adhesion.w = 0.05
"""
HALF_SPACE = '.half_space = { E = "75 MPa", nu = 0.5 }'
LAYER = ' = { base = "bonded", layers = [{ E = "75 MPa", nu = 0.5, thickness = "1 um" }] }'
E_STAR, R, W = 1e8, 1e-5, 0.05


def exported(jkr, specimen: str, *words: str) -> dict:
    Path("x.toml").write_text(CASE.format(specimen=specimen))
    assert jkr("run", "x.toml").code == 0
    done = jkr("export", "x.h5", "--dem", "--json", *words)
    assert done.code == 0, done.err
    return json.loads(done.out)


def test_points_of_a_half_space_are_those_of_jkr(jkr) -> None:
    """Johnson, Kendall and Roberts (1971): -5/6 and -3/2 pi w R; at first touch -4/3 pi w R."""
    found = exported(jkr, HALF_SPACE)
    unit = math.pi * W * R
    for name, part in (("tear_off", -5 / 6), ("load_control", -3 / 2), ("touch", -4 / 3)):
        assert found[name]["P_N"] == pytest.approx(part * unit, rel=1e-9)
    for name, control in (("tear_off", "displacement"), ("load_control", "load")):
        told = {key: found[name][key] for key in ("delta_m", "P_N")}
        assert told == pytest.approx(found["half_space"][control], rel=1e-9)
    assert found["tear_off"]["delta_m"] == pytest.approx(
        -0.75 * (math.pi**2 * W**2 * R / E_STAR**2) ** (1 / 3), rel=1e-9
    )


def test_the_table_is_the_curve_where_it_is_stable(jkr) -> None:
    found = exported(jkr, LAYER)
    rows = np.loadtxt("x-dem.csv", delimiter=",", skiprows=1)
    assert rows.shape == (found["rows"], 4)
    assert rows[0, 1:] == pytest.approx([found["tear_off"][key] for key in ("delta_m", "P_N", "a_m")], rel=1e-12)
    assert (np.diff(rows[:, 1:], axis=0)[:, [0, 2]] > 0).all()
    assert found["error"] < 1e-6
    assert found["tear_off"]["delta_m"] < found["load_control"]["delta_m"]
    assert found["half_space"]["load"]["P_N"] != pytest.approx(found["load_control"]["P_N"], rel=0.05)  # 8 % apart


def test_cubics_are_met_exactly() -> None:
    x = np.linspace(0, 1, 9)
    between = np.array([0.0, 0.01, 0.4, 0.77, 1.0])
    np.testing.assert_allclose(interpolated(x**3 - x, between), between**3 - between, atol=1e-15)


@pytest.mark.parametrize("specimen", [HALF_SPACE, LAYER], ids=["half-space", "layer"])
def test_the_header_compiles_and_meets_its_vectors(jkr, specimen: str) -> None:
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        pytest.skip("no C compiler on this machine")
    exported(jkr, specimen)
    command = [
        compiler,
        "-std=c99",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-DJKR_CHECK",
        "-x",
        "c",
        "x-dem.h",
        "-lm",
        "-o",
        "x",
    ]
    made = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (made.returncode, made.stderr) == (0, "")
    done = subprocess.run(["./x"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    assert float(done.stdout) < 1e-6


REFUSED = {
    "for nothing": ((), "export: say for what: --dem, for particle codes"),
    "no adhesion": (("--dem", "--w", "0"), "a contact without adhesion needs no table of what holds it: give --w"),
    "too short": (("--dem", "--w", "5000 J/m^2"), "tear-off under displacement control is needed: "),
}


@pytest.mark.parametrize("why", REFUSED)
def test_what_is_no_law_is_refused_in_one_line(jkr, why: str) -> None:
    words, said = REFUSED[why]
    Path("x.toml").write_text(CASE.format(specimen=HALF_SPACE))
    assert jkr("run", "x.toml").code == 0
    done = jkr("export", "x.h5", *words)
    assert (done.code, done.err.count("\n")) == (2, 1)
    assert said in done.err
    assert not Path("x-dem.h").exists()


def test_python_has_the_same_law() -> None:
    import jkrcli as jkr

    problem = jkr.Problem(jkr.Paraboloid(R), jkr.Specimen((), jkr.HalfSpace(jkr.Elastic(7.5e7, 0.5))),
                          jkr.Loading("radius", 3e-6, 100))  # fmt: skip
    law = DemLaw.of(jkr.transform(jkr.solve(problem), W).curve)
    assert law.tear_off.P == pytest.approx(-5 / 6 * math.pi * W * R, rel=1e-9)

"""The contact law for particle codes: its points, its table, and the C that reads it."""

import math
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

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
    return jkr("export", "x.h5", "--dem", "--json", *words).told


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
    assert float(compiled("x", "cc", "-std=c99", "-DJKR_X_CHECK", "-x", "c", "x-dem.h")) < 1e-6


def test_the_table_is_the_curve_where_it_is_stable(jkr) -> None:
    found = exported(jkr, LAYER)
    rows = np.loadtxt("x-dem.csv", delimiter=",", skiprows=1)
    assert rows.shape == (found["rows"], 4)
    assert rows[0, 1:] == pytest.approx([found["tear_off"][key] for key in ("delta_m", "P_N", "a_m")], rel=1e-12)
    assert (np.diff(rows[:, 1:], axis=0)[:, [0, 2]] > 0).all()
    assert found["error"] < 1e-6
    assert found["tear_off"]["delta_m"] < found["load_control"]["delta_m"]
    assert found["half_space"]["load"]["P_N"] != pytest.approx(found["load_control"]["P_N"], rel=0.05)  # 8 % apart
    assert float(compiled("x", "cc", "-std=c99", "-DJKR_X_CHECK", "-x", "c", "x-dem.h")) < 1e-6


def compiled(name: str, *words: str) -> str:
    compiler = shutil.which(words[0])
    if compiler is None:
        pytest.skip(f"no {words[0]} on this machine")
    command = [compiler, "-Wall", "-Wextra", "-Werror", *words[1:], "-lm", "-o", name]
    made = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (made.returncode, made.stderr) == (0, "")
    done = subprocess.run([f"./{name}"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    return done.stdout


TWO_LAWS = """
#include <stdio.h>
#include "x-dem.h"
#include "film-2-dem.h"
#include "x-dem.h"
int main(void)
{
    double force, radius;
    jkr_x_contact(5e-8, 1, &force, &radius);
    printf("%.12e ", force);
    jkr_film_2_contact(5e-8, 1, &force, &radius);
    printf("%.12e\\n", force);
    return jkr_x_contact(NAN, 1, &force, &radius); /* an overlap that is no number is no contact */
}
"""


def test_two_laws_in_one_program(jkr) -> None:
    exported(jkr, LAYER, "--name", "film-2")
    exported(jkr, HALF_SPACE)
    Path("two.cpp").write_text(TWO_LAWS)
    found = [float(word) for word in compiled("two", "c++", "two.cpp").split()]
    forces = []
    for name in ("x-dem.csv", "film-2-dem.csv"):
        _, delta, P, _ = np.loadtxt(name, delimiter=",", skiprows=1).T
        forces.append(float(CubicSpline(np.sqrt(delta - delta[0]), P)(math.sqrt(5e-8 - delta[0]))))
    assert found == pytest.approx(forces, rel=1e-5)  # 1e-6 of the largest force
    assert abs(found[1] / found[0] - 1) > 0.05


def test_another_law_of_one_name_does_not_compile(jkr) -> None:
    if shutil.which("cc") is None:
        pytest.skip("no cc on this machine")
    exported(jkr, LAYER, "--name", "film")
    Path("film-dem.h").rename("first.h")
    exported(jkr, HALF_SPACE, "--name", "film")
    Path("two.c").write_text('#include "first.h"\n#include "film-dem.h"\n')
    made = subprocess.run(["cc", "-c", "two.c"], capture_output=True, text=True, check=False)
    assert made.returncode != 0
    assert "another contact law named jkr_film is included already" in made.stderr


@pytest.mark.parametrize("words", [("--dem",), ("--nanite",)])
def test_head_of_what_is_exported_says_that_it_may_be_distributed(jkr, words: tuple[str, ...]) -> None:
    Path("x.toml").write_text(CASE.format(specimen=LAYER))
    assert jkr("run", "x.toml").code == 0
    assert jkr("export", "x.h5", *words, "--name", "Soft").code == 0
    head = Path("Soft-dem.h" if words == ("--dem",) else "model_jkr_soft.py").read_text()[:1000]
    assert "not under jkr's licence (LICENSE-EXCEPTION.md" in head
    assert (Path(__file__).parents[2] / "LICENSE-EXCEPTION.md").exists()


REFUSED = {
    "for nothing": ((), "export: say for what: --dem, for particle codes"),
    "no name": (("--dem", "--name", "a/b"), "export: --name takes letters, digits, - and _, got 'a/b'"),
    "no adhesion": (("--dem", "--w", "0"), "a contact without adhesion needs no table of what holds it: give --w"),
    "too short": (("--dem", "--w", "5000 J/m^2"), "tear-off under displacement control is needed: "),
}


@pytest.mark.parametrize("why", REFUSED)
def test_what_is_no_law_is_refused_in_one_line(jkr, why: str) -> None:
    words, said = REFUSED[why]
    Path("x.toml").write_text(CASE.format(specimen=HALF_SPACE))
    assert jkr("run", "x.toml").code == 0
    jkr("export", "x.h5", *words).refused(said)
    assert not Path("x-dem.h").exists()

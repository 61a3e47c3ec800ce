"""The contact law of particles of all sizes: against the law of each size, in C, in collisions, and in LAMMPS."""

import csv
import json
import math
import shutil
import subprocess
from ctypes.util import find_library
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import write_table
from fit_data import adhesive

import jkrcli as python
from jkrcli.base.errors import InputError, Unknown
from jkrcli.bodies.problem import Problem
from jkrcli.many.particles import ExportedSizes, SizesLaw
from jkrcli.methods.layered.solver import Layered
from jkrcli.series import Solution

LOADING = '[loading]\nradius = "3 um"\n[adhesion]\nw = 0.05\n'
HALF_SPACE = '[indenter]\nshape = "paraboloid"\nradius = "10 um"\n[specimen.half_space]\nE = "75 MPa"\nnu = 0.5\n'
LAYER = HALF_SPACE.replace(
    "[specimen.half_space]", '[specimen]\nbase = "bonded"\n[[specimen.layers]]\nthickness = "1 um"'
)
PAIR = """
[indenter]
shape = "paraboloid"
radius = "{R}"
E = "70 GPa"
nu = 0.2
layers = [{{ thickness = "0.5 um", E = "20 MPa", nu = 0.45 }}]
[specimen]
half_space = {{ E = "2 GPa", nu = 0.3 }}
layers = [{{ thickness = "1 um", E = "75 MPa", nu = 0.49 }}]
"""
E_STAR, W = 1e8, 0.05
ROOT = Path(__file__).parents[2]


def exported(jkr, case: str, sizes: str, *words: str) -> dict[str, Any]:
    Path("x.toml").write_text(case)
    done = jkr("export", "x.toml", "--dem", "--sizes", sizes, "--json", *words).ok
    return json.loads(done.out)


def program(body: str, *laws: str) -> str:
    headers = "".join(f'#include "{law}-dem.h"\n' for law in laws or ("x",))
    return f"#include <stdio.h>\n{headers}int main(void)\n{{\n{body}    return 0;\n}}\n"


def printed(source: str, *words: str, compiler: str = "cc", name: str = "two.c") -> list[list[float]]:
    """The numbers in the lines that a program prints, which must compile without a warning."""
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler} on this machine")
    Path(name).write_text(source)
    command = [compiler, "-Wall", "-Wextra", "-Werror", "-I.", name, *words, "-lm", "-o", "two"]
    made = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (made.returncode, made.stderr) == (0, "")
    done = subprocess.run(["./two"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, (done.returncode, done.stdout)
    return [[float(word) for word in line.split()] for line in done.stdout.splitlines()]


SIZES = """
    const double radius[3][3] = { /* R1, R2 or a wall, w */
        { 8e-6, 8e-6, 0.05 }, { 30e-6, INFINITY, 0.05 }, { 60e-6, 20e-6, 0.08 } };
    jkr_x_points p;
    int i, found;
    for (i = 0; i < 3; i++) {
        const double R = 1 / (1 / radius[i][0] + 1 / radius[i][1]);
        found = jkr_x_points_of(R, radius[i][2], &p);
        printf("%.17g %.17g %.12e %.12e %.12e %.12e %d\\n", R, radius[i][2], p.force_load, p.force_tear, p.delta_tear,
               p.energy_lost, found);
    }
"""


@pytest.fixture(name="pair", scope="module")
def _pair() -> SizesLaw:
    problem = python.parse_case(PAIR.format(R="10 um") + LOADING).model.problem()
    return SizesLaw.of(problem, W, 4e-6, 30.1e-6, 0.3)


def test_sizes_of_a_coated_pair_pull_off_as_each_solved_for_itself(pair, tmp_path, monkeypatch) -> None:
    """Coatings on both sides, particle on particle and on a wall, another w: w R^2/(E* h^3) is all that counts."""
    monkeypatch.chdir(tmp_path)
    Path("x-dem.h").write_text(ExportedSizes(pair, Path("x.h5"), "jkr_x").code)
    head = Path("x-dem.h").read_text().partition("*/")[0]
    assert [words in head for words in ("h = 500 nm", "h = 1 um", "R = 10 um")] == [True, True, False]
    for R, w, load, tear, delta, lost, found in printed(program(SIZES)):
        case = python.parse_case(PAIR.format(R=f"{R!r} m") + LOADING.replace("3 um", f"{0.3 * R!r} m"))
        controls = {one["control"]: one for one in python.pull_off(python.solve(case), w).summary()["controls"]}
        assert found == 1
        for control, force in (("load control", load), ("displacement control", tear)):
            assert force == pytest.approx(controls[control]["pull_off"]["P_N"], rel=1e-3)
            assert abs(force - controls[control]["pull_off"]["P_N"]) < (pair.errors["points"] + 1e-6) * math.pi * w * R
        assert delta == pytest.approx(controls["displacement control"]["pull_off"]["delta_m"], rel=1e-3)
        assert lost == pytest.approx(controls["displacement control"]["energy_lost_J"], rel=1e-3)


@pytest.fixture(name="half", scope="module")
def _half() -> SizesLaw:
    problem = python.parse_case(HALF_SPACE + LOADING).model.problem()
    return SizesLaw.of(problem, W, 2e-6, 50e-6, 0.3)


def test_one_row_serves_a_half_space(half: SizesLaw) -> None:
    """JKR (1971): -5/6, -3/2, -4/3 pi w R; lost 7.09 (w^5 R^4/E*^2)^(1/3) (Johnson and Pollock, J. Adhesion Sci.
    Technol. 8 (1994) 1323)."""
    for row in half.rows:
        assert row.columns[4:6] == pytest.approx([-3 / 2, -4 / 3], rel=1e-6)
        assert row.force[0] == pytest.approx(-5 / 6, rel=1e-6)
        tear = 0.75 * (math.pi**2 * W**2 * row.R / E_STAR**2) ** (1 / 3)
        assert row.delta[0] == pytest.approx(-tear, rel=1e-6)
        lost = row.columns[6] * math.pi * W * row.R * tear
        assert lost == pytest.approx(7.09 * (W**5 * row.R**4 / E_STAR**2) ** (1 / 3), rel=1e-3)


def test_the_stated_error_holds_between_sizes_and_rows(half: SizesLaw) -> None:
    rng = np.random.default_rng(3)
    for y in rng.uniform(0, 1, 20).tolist():
        R = half.low * (half.high / half.low) ** y
        a = rng.uniform(0.1, 0.3, 30) * R
        delta, P = adhesive(a, E_STAR, W, R)
        _, force, radius = half.at(y, delta * R / half.h**2)
        expected = P / (math.pi * W * R)
        assert (np.abs(force - expected) <= half.errors["force"] * (np.abs(expected) + 1)).all()
        assert np.abs(radius * half.h / a - 1).max() <= half.errors["radius"]


TENSE = HALF_SPACE.replace("[specimen.half_space]", '[specimen]\nsurface_tension = "0.5 N/m"\n[specimen.half_space]')
STUCK = LAYER.replace("[specimen]", '[specimen]\nsurface = "sticking"').replace("nu = 0.5", "nu = 0.3")


@pytest.mark.first(1)
@pytest.mark.parametrize("case", [STUCK, TENSE], ids=["no slip", "surface tension"])
def test_tension_and_no_slip_have_a_law_of_sizes(case: str) -> None:
    """Both are linear in the profile: S does not depend on R, delta_H and P_H go like 1/R."""
    law = SizesLaw.of(python.parse_case(case + LOADING).model.problem(), W, 8e-6, 13e-6, 0.3)
    row = law.rows[-1]
    text = case.replace("10 um", f"{row.R!r} m") + LOADING.replace("3 um", f"{0.3 * row.R!r} m")
    load, tear = (
        one["pull_off"] for one in python.pull_off(python.solve(python.parse_case(text)), W).summary()["controls"][:2]
    )
    found = row.columns[4], row.force[0], row.delta[0]
    unit = math.pi * W * row.R
    assert found == pytest.approx((load["P_N"] / unit, tear["P_N"] / unit, tear["delta_m"]), rel=1e-6)
    assert found[0] != pytest.approx(-1.5, rel=0.01)


COLLISION = """
    const double R1 = 10e-6, R2 = 30e-6, density = 2500, R = R1 * R2 / (R1 + R2), dt = 1e-11;
    const double m1 = density * 4 / 3 * JKR_X_PI * R1 * R1 * R1, m2 = m1 * pow(R2 / R1, 3);
    double x1 = 0, x2 = 1.0001 * (R1 + R2), v1 = 0.2, v2 = 0, force = 0, radius, before = m1 * v1 * v1 / 2, deepest = 0;
    int touching = 0, steps;
    jkr_x_points points;
    jkr_x_points_of(R, JKR_X_W, &points);
    for (steps = 0; steps < 200000; steps++) {
        v1 -= force / m1 * dt / 2; v2 += force / m2 * dt / 2;
        x1 += v1 * dt; x2 += v2 * dt;
        touching = jkr_x_contact(R, JKR_X_W, R1 + R2 - (x2 - x1), touching, &force, &radius);
        if (touching < 0) return 4;
        deepest = fmax(deepest, R1 + R2 - (x2 - x1));
        v1 -= force / m1 * dt / 2; v2 += force / m2 * dt / 2;
    }
    printf("%.12e %.12e %.6e %d\\n", before - m1 * v1 * v1 / 2 - m2 * v2 * v2 / 2, points.energy_lost, deepest,
           touching);
"""


def test_two_particles_lose_in_a_collision_what_cycle_says(jkr, pair: SizesLaw) -> None:
    Path("x-dem.h").write_text(ExportedSizes(pair, Path("x.h5"), "jkr_x").code)
    ((lost, of_header, deepest, touching),) = printed(program(COLLISION))
    Path("one.toml").write_text(PAIR.format(R="7.5 um") + LOADING.replace("3 um", "2.2 um"))
    done = jkr("cycle", "one.toml", "--no-plots", "--json")
    cycle = json.loads(done.out)["energy_lost_J"]
    assert touching == 0
    assert deepest > 5e-8  # well compressed
    assert of_header == pytest.approx(cycle, rel=1e-4)
    assert lost == pytest.approx(cycle, rel=1e-3)


TWO_LAWS = """
    double force, radius;
    printf("%d ", jkr_x_contact(1e-5, 0.05, 2e-8, 1, &force, &radius));
    printf("%.12e ", force);
    printf("%d ", jkr_film_2_contact(1e-5, 0.05, 2e-8, 1, &force, &radius));
    printf("%.12e\\n", force);
    printf("%d %d %d %d\\n", jkr_x_contact(1e-5, 0.05, 1e-4, 1, &force, &radius), /* too deep, too small, apart */
           jkr_x_contact(1e-7, 0.05, 1e-9, 1, &force, &radius), jkr_x_contact(1e-5, 0.05, -1e-9, 0, &force, &radius),
           jkr_x_contact(1e-5, 0.05, -1e-6, 1, &force, &radius));
"""


@pytest.mark.first(1)
@pytest.mark.parametrize(("compiler", "name"), [("cc", "two.c"), ("c++", "two.cpp")])
def test_two_laws_in_one_program(jkr, compiler: str, name: str) -> None:
    exported(jkr, LAYER + LOADING, "5 um..20 um", "--name", "film-2")
    exported(jkr, HALF_SPACE + LOADING, "5 um..20 um")
    (found, force, other, of_film), codes = printed(program(TWO_LAWS, "x", "film-2", "x"), compiler=compiler, name=name)
    assert (found, other) == (1, 1)
    assert of_film != pytest.approx(force, rel=0.05)
    for at, law in ((force, "x"), (of_film, "film-2")):
        rows = columns_of(f"{law}-dem.csv")
        there = (rows["R_m"] == rows["R_m"][np.abs(rows["R_m"] - 1e-5).argmin()]) & (rows["branch"] != "unstable")
        nearest = np.interp(2e-8, rows["delta_m"][there], rows["P_N"][there])
        assert at == pytest.approx(nearest, abs=0.2 * math.pi * W * 1e-5)
    assert codes == [-1, -2, 0, 0]


NO_NUMBERS = """
    const double R[6] = { 1e-5, 0, -1e-5, NAN, 1e-3, INFINITY };
    double force, radius;
    jkr_x_points p;
    int i, found;
    for (i = 0; i < 6; i++) {
        found = jkr_x_contact(R[i], 0.05, 2e-8, 1, &force, &radius);
        printf("%d %d ", found, jkr_x_points_of(R[i], 0.05, &p));
        printf("%d\\n", (i >= 1 && i <= 3) == (force == 0 && radius == 0 && p.force_tear == 0 && p.force_load == 0));
    }
    found = jkr_x_contact(1e-5, 0.05, NAN, 1, &force, &radius);
    printf("%d %d %g\\n", found, jkr_x_contact(1e-5, 0.05, NAN, 0, &force, &radius), force);
"""


def test_what_is_no_number_or_no_radius_is_no_contact(jkr) -> None:
    """No force then; above the sizes that of the nearest stands in."""
    exported(jkr, HALF_SPACE + LOADING, "5 um..20 um")
    *radii, overlap = printed(program(NO_NUMBERS))
    assert radii == [[1, 1, 1], *[[-2, -2, 1]] * 5]
    assert overlap == [0, 0, 0]


def columns_of(path: str) -> dict[str, Any]:
    rows = list(csv.DictReader(Path(path).read_text().splitlines()))
    return {name: np.array([row[name] for row in rows], dtype=None if name == "branch" else float) for name in rows[0]}


def test_the_table_has_both_branches_of_each_size(jkr) -> None:
    summary = exported(jkr, HALF_SPACE + LOADING, "5 um..20 um")
    rows = columns_of("x-dem.csv")
    assert set(rows["branch"]) == {"unstable", "unloading", "loading and unloading"}
    for R in np.unique(rows["R_m"]):
        one = {name: column[rows["R_m"] == R] for name, column in rows.items()}
        upper = one["branch"] != "unstable"
        assert (np.diff(one["a_m"]) > 0).all()
        assert (np.diff(one["delta_m"][upper]) > 0).all()
        assert (np.diff(one["delta_m"][~upper]) < 0).all()
        assert ((one["delta_m"] >= 0) == (one["branch"] == "loading and unloading"))[upper].all()
        np.testing.assert_allclose(one["P_N"], adhesive(one["a_m"], E_STAR, W, R)[1], atol=1e-5 * math.pi * W * R)
    assert summary["w_R2_over_Estar_h3"][1] / summary["w_R2_over_Estar_h3"][0] == pytest.approx(16)


@pytest.mark.parametrize("law", ["half", "pair"])
def test_the_header_checks_itself(law, request, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("x-dem.h").write_text(ExportedSizes(request.getfixturevalue(law), Path("x.h5"), "jkr_x").code)
    ((force, radius),) = printed(Path("x-dem.h").read_text(), "-std=c99", "-DJKR_X_CHECK", "-x", "c", name="check.c")
    assert max(force, radius) <= 2e-4


@pytest.mark.slow
def test_two_particles_collide_in_lammps(jkr) -> None:
    """The example of the guide, where LAMMPS' library is installed."""
    library = find_library("lammps")
    if library is None:
        pytest.skip("no LAMMPS on this machine")
    exported(jkr, LAYER + LOADING, "1 um..100 um", "--name", "all")
    source = (ROOT / "docs/examples/two_particles_lammps.c").read_text()
    ((lost, of_header, lowest, touching),) = printed(source, f"-l:{library}")
    assert (lost, touching) == (pytest.approx(of_header, rel=1e-3), 0)
    assert lowest < -1.5 * math.pi * W * 7.5e-6


REFUSED = {
    "another shape": (HALF_SPACE.replace("paraboloid", "sphere"), "1 um..9 um", 'give shape = "paraboloid"'),
    "too small": (HALF_SPACE, "1 nm..9 um", "R = 1 nm: adhesion alone makes a/R"),
    "one size": (HALF_SPACE, "9 um", "must be two radii that rise"),
    "sides": (
        LAYER.replace("[specimen]", '[specimen]\nradius = "0.1 mm"\nside = "free"'),
        "1 um..9 um",
        "finite radius",
    ),
}


@pytest.mark.parametrize("why", REFUSED)
def test_sizes_without_a_law_are_refused_in_one_line(jkr, why: str) -> None:
    case, sizes, said = REFUSED[why]
    Path("x.toml").write_text(case + LOADING)
    jkr("export", "x.toml", "--dem", "--sizes", sizes, "-q").refused(said)
    assert not Path("x-dem.h").exists()


def test_an_imported_solution_has_no_law_of_sizes(jkr) -> None:
    """Its numbers, here loads 1.5 times those of the bodies, would be ignored."""
    a = np.linspace(0.2e-6, 3e-6, 40)
    write_table("table.csv", "a (m),delta (m),P (N)", a, a**2 / 1e-5, 1.5 * 4 * E_STAR * a**3 / (3 * 1e-5))
    Path("x.toml").write_text(HALF_SPACE + LOADING)
    assert jkr("import", "table.csv", "--case", "x.toml", "-o", "imp.h5").code == 0
    assert jkr("export", "imp.h5", "--dem").code == 0
    jkr("export", "imp.h5", "--dem", "--sizes", "5 um..20 um", "--force").refused(
        "numbers of this solution (method import)"
    )


def test_a_solution_of_unknown_error_has_no_law_of_known_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def solved(self: Layered, problem: Problem) -> Solution:
        solution = solve(self, problem)
        return replace(solution, budget=replace(solution.budget, discretisation=Unknown("not estimated")))

    solve = Layered.__call__
    monkeypatch.setattr(Layered, "__call__", solved)
    with pytest.raises(InputError, match=r"error of the solution is not known \(not estimated\)"):
        SizesLaw.of(python.parse_case(HALF_SPACE + LOADING).model.problem(), W, 5e-6, 20e-6, 0.3)

"""What fuzzing found, each kept as a test of its own: the whole line that the user is told now."""

import os
import shutil
import subprocess
import sys
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from fuzzing import bounded
from series_files import edit, lengthened

from jkrcli.base.errors import InputError
from jkrcli.base.units import parse
from jkrcli.bodies.indenters import TableProfile
from jkrcli.case import store
from jkrcli.case.models import parse_case
from jkrcli.methods.layered.solver import Layered

CASES = Path(__file__).parents[2] / "cases"
GOOD = """
[indenter]
shape = "sphere"
radius = "100 um"
[specimen.half_space]
E = "5 GPa"
nu = 0.4
[loading]
depth = "3 um"
"""


def lines_of(content: str) -> tuple[str, ...]:
    with pytest.raises(InputError) as caught:
        parse_case(content.encode(), "x.toml")
    return caught.value.lines


FOUND = {
    "number with thousands of digits": (
        GOOD + "points = " + "9" * 5000,
        "x.toml: is not valid TOML: a number has thousands of digits",
    ),
    "brackets without end": (
        GOOD + "points = " + "[" * 5000,
        "x.toml: is not valid TOML: brackets are nested too deeply",
    ),
    "key of many parts": (GOOD + "a" + ".a" * 5000 + " = 1", "x.toml: line 10: a key must not have more than 50 parts"),
    "line end in a key": (
        '"a\\nb" = 1' + GOOD,
        "x.toml: a\\nb: unknown key (allowed: title, method, indenter, specimen, loading, adhesion, mesh, contact, "
        "layered, hybrid)",
    ),
    "escape sequence in a value": (
        GOOD.replace('"100 um"', '"\\u001b[31m"'),
        'x.toml: indenter.radius: must be a length, such as "100 um", got "\\x1b[31m"',
    ),
    "size beyond what exists": (
        GOOD.replace('"100 um"', "1e300"),
        "x.toml: indenter.radius: must lie between 1e-30 and 1e+30 in SI units, got 1e+300 m",
    ),
    "size below what exists": (
        GOOD.replace('"3 um"', '"1e-300 um"'),
        "x.toml: loading.depth: must lie between 1e-30 and 1e+30 in SI units, got 1e-300 um",
    ),
    "exponent that overflows": (
        GOOD.replace('"sphere"', '"power"').replace('radius = "100 um"', "coefficient = 1.0\nexponent = 1e6"),
        "x.toml: indenter.exponent: must be >= 1 and <= 20, got 1000000.0",
    ),
    "null character in a file name": (
        GOOD.replace('"sphere"', '"table"').replace('radius = "100 um"', 'file = "a\\u0000b"'),
        "x.toml: indenter: a\\x00b: profile file cannot be read (embedded null byte)",
    ),
}


@pytest.mark.parametrize("name", FOUND)
def test_found_in_case_files(name: str) -> None:
    content, line = FOUND[name]
    assert lines_of(content) == (line,)


def test_long_text_with_blanks_is_refused_at_once() -> None:
    """The pattern of quantities takes the square of the length: minutes, where the length is not looked at first."""
    with bounded(), pytest.raises(ValueError, match="must be a length"):
        parse("1" + " " * 1_000_000 + "x", "length")


def test_check_of_an_expensive_body_says_so(jkr: Callable) -> None:
    text = (CASES / "gel.toml").read_text(encoding="utf-8").replace("0.36 mm", "2 um")
    Path("x.toml").write_text(text, encoding="utf-8")
    done = jkr("check", "x.toml").ok
    assert "  reaches   unknown: the coarse solution would take about " in done.out


def test_a_profile_is_looked_for_beside_the_case_and_its_place_is_shown(jkr: Callable) -> None:
    text = GOOD.replace('"sphere"', '"table"').replace('radius = "100 um"', 'file = "../p.csv"')
    Path("deep").mkdir()
    Path("deep/x.toml").write_text(text, encoding="utf-8")
    assert jkr("check", "deep/x.toml").err == (
        "jkr: error: deep/x.toml: indenter: deep/../p.csv: profile file not found\n"
    )
    Path("p.csv").write_text("r_m,f_m\n0,0\n1e-5,1e-7\n5e-5,25e-7\n1e-4,1e-5\n", encoding="utf-8")
    assert jkr("check", "deep/x.toml").code == 0


def _list_of_facts(file: h5py.File) -> None:
    file["facts"].attrs["nodes"] = np.arange(3)


def _absurd(file: h5py.File) -> None:
    file["series/P"][3] = 1e308


SERIES = {
    _list_of_facts: "attribute facts.nodes must be a number or a text, got ndarray",
    _absurd: "series/P: row 4 must be a number up to 1e+60, got 1e+308",
}


@pytest.mark.parametrize("change", SERIES, ids=lambda change: change.__name__.strip("_"))
def test_found_in_series_files(change: Callable[[h5py.File], None], series: Path) -> None:
    edit(series, change)
    with pytest.raises(InputError, check=lambda error: error.lines == (f"{series}: {SERIES[change]}",)):
        store.read_solution(series)


@pytest.mark.parametrize(
    ("r", "pressure", "line"),
    [
        (None, np.ones((2, 2)), 'dataset "contact/r" is missing'),
        (np.ones(2), None, 'dataset "contact/pressure" is missing'),
        (np.ones(3), np.ones((2, 2)), "contact/pressure: must be rows of 3 numbers, got float64 of shape (2, 2)"),
        (np.ones(2), np.array([[1, np.nan]]), "contact/pressure: row 1 must be a finite number, got nan"),
    ],
)
def test_found_in_pressures(r: np.ndarray | None, pressure: np.ndarray | None, line: str, series: Path) -> None:
    def change(file: h5py.File) -> None:
        for name, values in (("r", r), ("pressure", pressure)):
            if values is not None:
                file[f"contact/{name}"] = values

    edit(series, change)
    with pytest.raises(InputError, check=lambda error: error.lines == (f"{series}: {line}",)):
        store.read_solution(series, with_pressure=True)


ROWS = "".join(f"{i}e-6,{i**2}e-9,{i**3}e-9\n" for i in range(1, 9))
BODY = ("--radius", "1 mm", "--E", "1 MPa", "--nu")
BASE = """[base.indenter]\nshape = "sphere"\nradius = 1e-4
[base.specimen.half_space]\nE = 5e9\nnu = 0.4\n[base.loading]\ndepth = 3e-6\n"""
AXIS = "[[axes]]\nkey = 'adhesion.w'\nfrom = 1\nto = 2\ncount = "
DRAWS = "[samples.of]\n'adhesion.w' = {distribution = 'uniform', from = 1, to = 2}\n"
MANY = "x.toml: makes 1,000,000,000 cases, at most 2,000,000 are allowed in one sweep"
LINES = {  # a file, what is asked of it, and what is said
    "a number beyond what exists": (f"a_m,delta_m,P_N\n{ROWS}9e-6,8e-8,1e300\n", ("import", "x.csv", *BODY, "0.5"),
                                    "x.csv: line 10: load must be up to 1e+30, got 1e+300"),
    "words in a column that no row has": (f"a_m,delta_m,P_N,segment\n{ROWS}", ("look", "x.csv"), "x.csv: "),
    "an import by a flag that is no text": (f"a_m,delta_m,P_N\n{ROWS}", ("import", "x.csv", *BODY, "\udcff"), ""),
    "a fit by a flag that is no text": (f"a_m,delta_m,P_N\n{ROWS}", ("fit", "x.csv", *BODY, "\udcff"), ""),
    "too many cases of axes": (f"{BASE}{AXIS}1000000000", ("sweep", "x.toml"), MANY),  # counted before they are made
    "too many cases of samples": (f"{BASE}[samples]\ncount = 1000000000\n{DRAWS}", ("sweep", "x.toml"), MANY),
    "a count beyond an index": (f"{BASE}{AXIS}9223372036854775808", ("sweep", "x.toml"), ""),
}  # fmt: skip


@pytest.mark.parametrize("name", LINES)
def test_found_in_tables_and_sweeps(jkr: Callable, name: str) -> None:
    content, words, said = LINES[name]
    Path(words[1]).write_text(content, encoding="utf-8")
    jkr(*words).refused(said)


def test_arithmetic_that_overflows_is_told_in_one_line(jkr: Callable, series: Path) -> None:
    def change(file: h5py.File) -> None:
        file["series/S"][5] = 1e59
        file["series/dS_da"][6] = 1e-59
        file["series/P"][7] = 1e59

    edit(series, change)
    done = jkr("transform", series, "--w", "0.05", "--no-plots")
    assert done.code in (1, 2)
    assert done.err.count("\n") == 1


def test_output_in_a_poor_encoding(tmp_path: Path, series: Path) -> None:
    shutil.copy(series, tmp_path / "δ.h5")
    words = [sys.executable, "-m", "jkrcli", "show", "δ.h5"]
    environment = os.environ | {"PYTHONIOENCODING": "latin-1"}
    done = subprocess.run(words, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines()[0].endswith(": \\u03b4.h5")


def test_a_long_stretch_of_equal_elements_does_not_overflow() -> None:
    """Found by many_cases: more than 709 points of one size on a line."""
    from jkrcli.fem.mesh import graded_points

    points = graded_points(0.0, 1.0, lambda x: np.full_like(x, 1e-3))
    assert points.size == 1001
    np.testing.assert_allclose(np.diff(points), 1e-3, rtol=1e-9)


@pytest.mark.first(2)
@pytest.mark.parametrize("lost", ["P", "dS_da", "a", "delta", "S"])
def test_series_that_state_errors_of_some_columns_only_are_transformed(jkr: Callable, series: Path, lost: str) -> None:
    """A stated error that was missing ended transform in a KeyError."""
    edit(series, lambda file: file["errors"].__delitem__(lost))
    assert jkr("transform", series, "--w", "0.05", "--no-plots").code == 0


@pytest.mark.slow
def test_points_that_do_not_fit_between_the_rows_are_left_out(jkr: Callable, tmp_path: Path) -> None:
    """Rows closer to each other than their errors: what is solved between them breaks their order."""
    case = (
        'method = "layered"\nindenter = { shape = "paraboloid", radius = "1 mm" }\nadhesion.w = 0.05\n'
        'specimen.layers = [{ thickness = "0.2 mm", E = "1 MPa", nu = 0.3 }]\nloading = { radius = "0.1 mm" }\n'
    )
    (tmp_path / "s.toml").write_text(case, encoding="utf-8")
    assert jkr("run", "s.toml").code == 0

    lengthened(tmp_path / "s.h5", 5000)
    assert jkr("pull-off", "s.h5").code == 0


@pytest.mark.slow
@pytest.mark.parametrize("stress", ["1 kPa", "10 kPa"])
def test_a_range_beyond_the_sphere_is_refused_in_its_own_words(jkr: Callable, stress: str) -> None:
    """The first guess of its width asked for the profile beyond its end: "numbers leave the range of arithmetic"."""
    assert jkr("run", CASES / "thin-layer.toml", "-o", "s.h5").code == 0
    done = jkr("transform", "s.h5", "--w", "0.04", "--stress", stress, "--no-plots")
    assert done.code == 2
    assert done.err.startswith("jkr: error: adhesion of finite range: it reaches out to ")


def test_curves_of_finite_range_without_dimensions(jkr: Callable, series: Path) -> None:
    words = ("--w", "0.05", "--stress", "100 MPa", "--dimensionless", "half-space", "--no-plots", "-o", ".")
    assert jkr("transform", series, *words).code == 0
    (table,) = Path().glob("*.csv")
    assert ",a_bar,delta_bar,P_bar,delta_H_bar,P_H_bar" in table.read_text(encoding="utf-8").splitlines()[0]


def test_a_sticking_layer_thinner_than_anything_is_refused_before_it_is_laid_out(jkr: Callable) -> None:
    text = (CASES / "gel.toml").read_text(encoding="utf-8").replace("[specimen]", '[specimen]\nsurface = "sticking"')
    Path("x.toml").write_text(text.replace("0.36 mm", "1e-9 um"), encoding="utf-8")
    done = jkr("run", "x.toml")
    assert done.code == 2
    assert "equations without slip (limit " in done.err or "would need about" in done.err, done.err
    assert jkr("check", "x.toml").code in (0, 2)


def test_a_formula_is_not_checked_by_a_long_solve(jkr: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    """``check`` took 23 s without a word: the exact layer under a contact of 600 times its thickness."""
    solved = []
    original = Layered.__call__
    monkeypatch.setattr(Layered, "__call__", lambda self, problem: solved.append(problem) or original(self, problem))
    text = (CASES / "thin-layer.toml").read_text(encoding="utf-8").replace("0.15 um", "189 um")
    Path("x.toml").write_text(text, encoding="utf-8")
    assert jkr("check", "x.toml").code == 0
    assert [problem.loading.maximum < 1e-5 for problem in solved] == [True]


@pytest.mark.fem  # listed as a method
def test_a_mesh_of_more_points_than_fit_is_refused_and_other_methods_are_told(jkr: Callable) -> None:
    """The surface of a thin layer, on which sizes end to grow, was laid out to count its elements."""
    text = (CASES / "thin-layer.toml").read_text(encoding="utf-8").replace("30 um", "1e20 m")
    Path("x.toml").write_text(text, encoding="utf-8")
    done = jkr("check", "x.toml", "-v").ok
    assert "fem          not applicable: mesh: " in done.out


@pytest.mark.slow
def test_a_profile_of_many_points_takes_little_memory(jkr: Callable) -> None:
    """2,000 points took 10 GB and 35 s, 100,000 asked for 2 TB."""
    r = np.linspace(0, 2e-5, 601)
    profile = TableProfile(tuple(r), tuple(r**2 / 2e-3))
    tracemalloc.start()
    try:
        F = profile.abel(np.linspace(0, 2e-5, 100_000))
        assert tracemalloc.get_traced_memory()[1] < 100 << 20  # bytes; 1 GB when all pairs are held at once
    finally:
        tracemalloc.stop()
    np.testing.assert_allclose(F, np.linspace(0, 2e-5, 100_000) ** 2 / 1e-3, rtol=1e-9, atol=1e-18)
    with pytest.raises(InputError, match="profile table: has 5,001 points, at most 5,000 are taken; leave out points"):
        TableProfile(tuple(range(5001)), tuple(range(5001)))


def test_a_contact_beyond_all_sizes_of_the_body_is_refused(jkr: Callable) -> None:
    """Polynomials that do not converge to rounding: a division by zero where they were counted."""
    text = (CASES / "coating.toml").read_text(encoding="utf-8").replace('"8 um"', '"9e16 um"')
    Path("x.toml").write_text(text, encoding="utf-8")
    for verb in ("check", "run"):
        done = jkr(verb, "x.toml")
        assert done.code in (0, 2), done.err
        assert done.err.count("\n") == (done.code == 2)

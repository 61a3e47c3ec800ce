"""Tables of other programs: the same Hertz series in many guises, contact areas, and whole lines for what is wrong."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jkrcli.base.errors import InputError, Unknown
from jkrcli.bodies.indenters import Indenter, Paraboloid, PowerLaw, RoundedFlat, Sphere, TableProfile
from jkrcli.bodies.problem import Elastic, HalfSpace, Loading, Problem, Specimen
from jkrcli.formulas import hertz
from jkrcli.resolve.analysis import analyse
from jkrcli.resolve.foreign import SeriesReading, radius_from_area, read_series, surface_area
from jkrcli.tables import split_name

R, E_STAR = 1e-3, 2e6
BALL = Paraboloid(R)


def on_a_half_space(indenter: Indenter) -> Problem:
    return Problem(indenter, Specimen((), HalfSpace(Elastic(1e6, 0.3))), Loading("depth", 1.0))


A = np.array([2.0, 3.0, 3.0, 5.0, 8.0, 9.0]) * 1e-5  # the radius repeats, as node-based radii do
DELTA = A**2 / R * np.array([1, 1, 1.05, 1, 1, 1])
P = hertz(A, E_STAR, R)[1] * np.array([1, 1, 1.02, 1, 1, 1])
KEPT = [0, 1, 3, 4, 5]


def rows(*columns: np.ndarray, mark: str = ",", decimal: str = ".", form: str = ".17e") -> str:
    lines = [
        mark.join(format(value, form).replace(".", decimal) for value in row) for row in zip(*columns, strict=True)
    ]
    return "\n".join(lines) + "\n"


AREA = surface_area(A, BALL)
TIME = np.linspace(0, 1, A.size + 1)[1:]
GUISES = {
    "our own names": ("a_m,delta_m,P_N\n" + rows(A, DELTA, P), SeriesReading()),
    "units in brackets, other order": (
        "P [mN], contact radius [um], depth [nm]\n" + rows(P * 1e3, A * 1e6, DELTA * 1e9),
        SeriesReading(),
    ),
    "Abaqus report: blanks, zero frame, negative, no units": (
        "\n               X        RF2 N: 1        U2 N: 1        CAREA    \n\n"
        + rows([0.0], [0.0], [0.0], [0.0], mark="     ")
        + rows(TIME, -P * 1e3, -DELTA * 1e3, AREA * 1e6, mark="    "),
        SeriesReading(units={"delta": "mm", "P": "mN", "area": "mm^2"}),
    ),
    "Abaqus history names": (
        "Time, RF:RF2 PI: TOOL-1 N: 1, U:U2 PI: TOOL-1 N: 1, Contact area\n" + rows(TIME, -P, -DELTA, AREA),
        SeriesReading(units={"delta": "m", "P": "N", "area": "m2"}),
    ),
    "semicolons, decimal comma, units line, byte order mark": (
        "\ufeffSchritt;Displacement;Force;Contact area\ns;µm;uN;µm²\n"
        + rows(TIME, DELTA * 1e6, P * 1e6, AREA * 1e12, mark=";", decimal=","),
        SeriesReading(),
    ),
    "CalculiX: force on a wedge of 2 degrees, comments": (
        "time,u2 (um),RF2 (uN),contact radius (um)\n# step 1\n" + rows(TIME, -DELTA * 1e6, -P * 1e6 / 180, A * 1e6),
        SeriesReading(factors={"P": 180}),
    ),
    "tabs, no header, Fortran exponents": (
        rows(P, DELTA, A, mark="\t").replace("e", "D"),
        SeriesReading(columns={"P": "1", "delta": "2", "a": "3"}, units={"P": "N", "delta": "m", "a": "m"}),
    ),
    "commented header, blanks": ("# a (m)  delta (m)  P (N)\n" + rows(A, DELTA, P, mark=" "), SeriesReading()),
    "projected area, displacement from elsewhere": (
        "area/um^2,disp/um,force/N\n" + rows(math.pi * A**2 * 1e12, DELTA * 1e6 + 7, P),
        SeriesReading(area="projected", zero={"delta": 7e-6}),
    ),
    "quoted names with commas": (
        '"Contact radius, um","Displacement, nm","Force, uN"\n' + rows(A * 1e6, DELTA * 1e9, P * 1e6),
        SeriesReading(),
    ),
    "rows in another order": ("a_m,delta_m,P_N\n" + rows(A[::-1], DELTA[::-1], P[::-1]), SeriesReading(sort=True)),
}


@pytest.mark.parametrize(("text", "reading"), GUISES.values(), ids=GUISES.keys())
def test_every_guise_gives_the_same_series(tmp_path: Path, text: str, reading: SeriesReading) -> None:
    path = tmp_path / "t.csv"
    path.write_text(text, encoding="utf-8")
    solution = read_series(path, on_a_half_space(BALL), reading)
    assert solution.raw is not None
    raw = solution.raw
    touching = raw.a > 0
    # Powers of ten, area and back: some units of the last place; 7 um added and taken off leave 1e-16 * 7 um / 0.4 um.
    for found, exact in ((raw.a, A), (raw.delta, DELTA), (raw.P, P)):
        np.testing.assert_allclose(found[touching], exact, rtol=1e-14)
    np.testing.assert_allclose(solution.series.a, A[KEPT], rtol=1e-14)
    assert (solution.method, solution.facts["dropped"]) == ("import", raw.a.size - 5)
    assert solution.budget.total == Unknown("unknown: imported data")


LENGTHS, LOADS = st.sampled_from(["m", "mm", "um", "nm", "cm"]), st.sampled_from(["N", "kN", "mN", "uN", "nN"])


@pytest.mark.parametrize("first", ["", "0,0,0\n", "0,-1e-7,0\n0,0,0\n"])
def test_states_before_contact_leave_the_pull_off_force_that_of_jkr(tmp_path: Path, first: str) -> None:
    a, w = np.linspace(1, 20, 20) * 1e-5, 0.02
    (tmp_path / "t.csv").write_text("a_m,delta_m,P_N\n" + first + rows(a, a**2 / R, hertz(a, E_STAR, R)[1]))
    (found,) = analyse(read_series(tmp_path / "t.csv", on_a_half_space(BALL), SeriesReading()), [w])
    point = found.pull_off["load"]
    assert point.P == pytest.approx(-1.5 * math.pi * w * R, rel=1e-8)  # measured: 1e-11


@pytest.mark.parametrize(
    ("title", "parts"),
    [("P (mN)", ("P", "mN")), ("u2 [um]", ("u2", "um")), ("a/mm", ("a", "mm")), ("P_H_N", ("P_H", "N")),
     ("contact_radius", ("contact_radius", "")), ("RF2", ("RF2", "")), ("RF2 N: 1", ("RF2 N: 1", "")),
     ("P, mN", ("P", "mN")), ("RF/total", ("RF/total", "")), ("area / µm^2", ("area", "µm^2")), ("a ()", ("a", ""))],
)  # fmt: skip
def test_names_and_units_of_header_cells(title: str, parts: tuple[str, str]) -> None:
    assert split_name(title) == parts


def test_area_of_the_sphere_is_eq_a2_and_its_inverse_eq_a3() -> None:
    a = np.array([1e-6, 0.1, 0.5, 0.999])
    area = 2 * np.pi * (1 - np.sqrt(1 - a**2))
    np.testing.assert_allclose(surface_area(a, Sphere(1.0))[1:], area[1:], rtol=1e-14)  # a = 1e-6 cancels in A2
    np.testing.assert_allclose(radius_from_area(area[1:], Sphere(1.0)), a[1:], rtol=1e-14)
    half = radius_from_area(np.array([2 * np.pi]), Sphere(1.0))
    np.testing.assert_allclose(half, 1.0, rtol=1e-15)  # the hemisphere


def test_area_of_paraboloid_and_cone_in_closed_form() -> None:
    a = np.array([1e-4, 0.1, 0.7, 3.0])
    exact = 2 * np.pi * 2.0**2 / 3 * np.expm1(1.5 * np.log1p((a / 2.0) ** 2))
    np.testing.assert_allclose(surface_area(a, Paraboloid(2.0)), exact, rtol=1e-14)
    np.testing.assert_allclose(surface_area(a, PowerLaw(0.75, 1.0)), np.pi * a**2 * 1.25, rtol=1e-14)


def test_a_tabulated_sphere_has_the_sphere_s_area() -> None:
    r = np.linspace(0, 0.5, 201)
    table = TableProfile(tuple(r), tuple(1 - np.sqrt(1 - r**2)))
    a = np.array([0.05, 0.2, 0.4])
    np.testing.assert_allclose(surface_area(a, table), surface_area(a, Sphere(1.0)), rtol=2e-7)  # 2e-8 measured


def flat_rows(mark: float, lag: float = 0.0) -> tuple[Problem, str]:
    """A flat end with a parabolic edge on a half-space, in closed form, and its table: contact areas that are pi a^2
    (``mark`` 0), or those of the surface (1), of radii that lag by a part of elements of 1/60 of the last."""
    b, R, E_star, a = 1.0, 0.5, 2.0, np.linspace(1.0, 1.35, 72)[1:]
    angle, root = np.arccos(b / a), np.sqrt(a**2 - b**2)
    delta, P = (
        a / R * (root - b * angle),
        2 * E_star / R * (a**2 * root - root**3 / 3 - b * (a**2 * angle + b * root) / 2),
    )
    problem = Problem(RoundedFlat(b, R), Specimen((), HalfSpace(Elastic(2.0 * 0.75, 0.5))), Loading("depth", 1.0, 2))
    reported = a - lag / 60 * np.random.default_rng(1).uniform(0, 1, a.size)
    reported = np.maximum.accumulate(np.maximum(reported, 1.0001))
    area = np.pi * reported**2 if not mark else surface_area(reported, problem.indenter)
    return problem, "delta_m,P_N,area_m2\n" + rows(delta, P, area)


@pytest.mark.parametrize(("mark", "meaning"), [(0, "projected"), (1, "surface")])
def test_bodies_say_what_a_contact_area_is(tmp_path: Path, mark: float, meaning: str) -> None:
    problem, text = flat_rows(mark)
    (tmp_path / "t.csv").write_text(text)
    read = read_series(tmp_path / "t.csv", problem, SeriesReading())
    assert read.warnings == ()
    assert read.series.a[-1] == pytest.approx(1.35, rel=1e-12)
    assert f"({meaning}: --area)" in read.facts["radii"]
    assert read.facts["loads_factor"] == pytest.approx(1.0, abs=1e-6)
    assert read.facts["loads_factor_error"] < 1.01e-4


def test_radii_that_lag_are_no_projected_areas(tmp_path: Path) -> None:
    problem, text = flat_rows(1, lag=1.0)
    (tmp_path / "t.csv").write_text(text)
    assert "surface" in read_series(tmp_path / "t.csv", problem, SeriesReading(sort=True)).facts["radius_from"]


def test_an_area_that_is_misread_is_named_where_loads_agree(tmp_path: Path) -> None:
    problem, text = flat_rows(0)
    (tmp_path / "t.csv").write_text(text)
    (warning,) = read_series(tmp_path / "t.csv", problem, SeriesReading(area="surface")).warnings
    assert re.search(r"contact radii are off those of these bodies by -1\.\d%, where loads agree: .*--area", warning)


@settings(max_examples=30, deadline=None)
@given(
    fraction=st.floats(1e-6, 0.999),
    indenter=st.sampled_from(
        [Sphere(2.0), Paraboloid(2.0), PowerLaw(0.5, 4.0), PowerLaw(3.0, 1.0), RoundedFlat(0.2, 1.0)]
    ),
)
def test_radius_and_area_are_inverse(fraction: float, indenter) -> None:
    a = np.array([2.0 * fraction])
    # 1e-14: a and A amplify each other's rounding by at most A'a/A, which r^4 at slope 16 makes 5.
    np.testing.assert_allclose(radius_from_area(surface_area(a, indenter), indenter), a, rtol=1e-14)


HEAD = "a_um,delta_um,P_mN\n"
GOOD = [(1, 1, 1), (2, 4, 8), (3, 9, 27), (4, 16, 64), (5, 25, 125), (6, 36, 216)]


def table_of(numbers) -> str:
    return HEAD + "".join(",".join(map(str, row)) + "\n" for row in numbers)


WRONG = {  # tables, and parts of what is said of them
    "unsorted": (table_of([GOOD[0], GOOD[2], GOOD[1], *GOOD[3:]]), [
        "t.csv: line 4: contact radius must not fall from row to row, it falls from 3e-06 to 2e-06 (SI)",
        "t.csv: line 4: displacement must rise from row to row, it falls", "t.csv: line 4: load must rise",
        "t.csv: the rows are not in the order of loading: --sort orders them by displacement",
    ]),
    "unloading": (table_of([*GOOD, GOOD[4]]), ["t.csv: the rows after the largest displacement are unloading"]),
    "many falls": (table_of([*GOOD, *GOOD[4::-1]]), ["t.csv: line 9: displacement", "... and 10 more like these"]),
    "repeated row": (table_of([*GOOD[:3], GOOD[2], *GOOD[3:]]), [
        "t.csv: line 5: displacement must rise from row to row, it stays at 9e-06 (SI)",
        "t.csv: remove the rows that repeat a displacement",
    ]),
    "radius falls": (table_of([*GOOD[:3], (2.5, 10, 30), *GOOD[3:]]), ["falling ones are not a growing contact"]),
    "too few": (table_of([(0, -1, 0), (0, 0, 0), *GOOD[:3]]), ["3 rows in contact (lines 4, 5, 6), at least 5 are"]),
    "none in contact": (table_of([(0, 1, 0)] * 6), ["t.csv: holds 0 rows in contact, at least 5 are needed"]),
    "too few radii": (table_of([(min(a, 3), d, p) for a, d, p in GOOD]), [
        "t.csv: holds 3 different contact radii (lines 2, 3, 4; 3 rows repeat them), at least 5 are needed: ",
    ]),
    "a word among the numbers": (table_of([*GOOD[:3], (4, "n/a", 64), *GOOD[4:]]), [
        't.csv: line 5 must hold 3 numbers, got "4,n/a,64": correct it, or put # before it',
    ]),
    "a short row": (table_of([*GOOD[:3], (4, 16), *GOOD[4:]]), ['t.csv: line 5 must hold 3 numbers, got "4,16"']),
    "nan": (table_of([*GOOD[:3], (4, "nan", 64), *GOOD[4:]]), ['line 5 must hold finite numbers, got "4,nan,64"']),
    "no table": ("some words\n1 2\n", ["t.csv: holds no row of at least 3 numbers; give --separator and --decimal"]),
    "empty": ("\n \n", ["t.csv: is empty"]),
    "beyond the sphere": (table_of([*GOOD, (7e6, 49, 343)]), [
        "t.csv: line 8: contact radius 7 m lies beyond the end of the indenter's profile, 0.001 m; is the unit right?",
    ]),
    "no unit": (table_of(GOOD).replace("P_mN", "RF2"), ['column 3 "RF2" (load) names no unit: give --unit P=mN, or']),
    "wrong unit": (table_of(GOOD).replace("P_mN", "RF2 [kPa]"), ['unit must be one of load, such as mN, got "kPa"']),
    "no load": (table_of(GOOD).replace("P_mN", "F_tot (mN)"), [
        "t.csv: no column is recognised as the load: say which, --column P=NAME (columns: 1 \"a_um\", 2",
    ]),
    "two loads": ("a_m,delta_m,P_N,force_N\n" + "".join(f"{a},{d},{p},{p}\n" for a, d, p in GOOD), [
        "t.csv: 2 columns are recognised as the load: say which, --column P=NAME (columns: ",
    ]),
}  # fmt: skip


@pytest.mark.parametrize(("text", "lines"), WRONG.values(), ids=WRONG.keys())
def test_wrong_tables_are_reported_by_line(tmp_path: Path, monkeypatch, text: str, lines: list[str]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("t.csv").write_text(text)
    with pytest.raises(InputError) as caught:
        read_series(Path("t.csv"), on_a_half_space(Sphere(R)), SeriesReading())
    for part in lines:
        assert any(part in line for line in caught.value.lines), caught.value.lines


CHOICES = {
    "unknown name": (SeriesReading(columns={"P": "dleta"}), 'no single column "dleta" for P, did you mean "delta"? ('),
    "number too large": (SeriesReading(columns={"P": "4"}), 'no single column "4" for P (columns: 1 "a_um", 2 "del'),
    "radius and area": (SeriesReading(columns={"a": "1", "area": "2"}), "for the contact area, not for both"),
    "one column twice": (SeriesReading(columns={"P": "2"}), "one column cannot be two quantities, got P = column 2 "),
    "comma twice": (SeriesReading(separator="comma", decimal=","), 'separator "comma" and decimal "," exclude each '),
    "area beyond the sphere": (SeriesReading(columns={"area": "1"}, units={"area": "m^2"}),
                               "line 2: contact area 1 m^2 is larger than the indenter's surface, 6.28318e-06 m^2; is"),
}  # fmt: skip


@pytest.mark.parametrize(("reading", "line"), CHOICES.values(), ids=CHOICES.keys())
def test_wrong_choices_name_the_columns(tmp_path: Path, monkeypatch, reading: SeriesReading, line: str) -> None:
    monkeypatch.chdir(tmp_path)
    Path("t.csv").write_text(table_of(GOOD))
    with pytest.raises(InputError, check=lambda error: line in str(error) and len(error.lines) == 1):
        read_series(Path("t.csv"), on_a_half_space(Sphere(R)), reading)


def test_a_sign_is_left_alone_when_asked(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    path.write_text(table_of([(a, -d, p) for a, d, p in GOOD]))
    assert read_series(path, on_a_half_space(Sphere(R)), SeriesReading()).series.delta[0] == 1e-6
    with pytest.raises(InputError, match="line 2: displacement must be positive in contact, got -1e-06"):
        read_series(path, on_a_half_space(Sphere(R)), SeriesReading(sign="as-is"))

"""Series with the contact radii of nodes: where the edge is, what the loads are, and bands that hold."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from node_series import BODIES, LENGTH, MODULUS, NodeBody, NodeSeries, many, node_series

from jkrcli.adhesion.pull_off_error import error_of_rows
from jkrcli.adhesion.slopes import smoothed
from jkrcli.adhesion.slopes.nodes import Ahead, node_radii
from jkrcli.base.errors import Unknown
from jkrcli.base.numerics import HALF_WIDTH
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Loading, Problem, Specimen
from jkrcli.resolve.analysis import analyse
from jkrcli.resolve.foreign import SeriesReading, read_series
from jkrcli.resolve.node_radii import check_against_solution, compared
from jkrcli.series import RawSeries, Solution

CALCULIX = Path(__file__).parents[1] / "references" / "calculix"
NAMED = {body.name: body for body in BODIES}
LAYER, HALF_SPACE = NAMED["bonded 0.45"], NAMED["half-space"]


def read(given: NodeSeries, path: Path, compare: bool = True, load: float = 1.0, problem=None) -> Solution:
    reading = SeriesReading(area="projected" if given.area else "auto", compare=compare)
    return read_series(given.write(path / "t.csv", load), problem or given.body.problem, reading)


def judged(given: NodeSeries, solution: Solution, control: str = "load", rule: str = "auto") -> tuple[float, float]:
    """Relative error of the pull-off force, and the half-width that is stated; NaN where there is none."""
    result = analyse(solution, [given.w], rule)[0]
    true = given.exact(control)[2]
    half, point = result.pull_off_errors.get(control), result.pull_off[control]
    if half is None or isinstance(half, Unknown) or isinstance(point, Unknown):
        return np.nan, np.nan
    return point.P / true - 1, half["P"] / abs(true)


def test_touches_hold_the_radius() -> None:
    given = node_series(HALF_SPACE, 30, 200, 0.2)
    nodes = node_radii(RawSeries(*given.columns))
    touches = nodes.touches(0.2)
    exact = np.sqrt(touches.rows.delta * HALF_SPACE.R * LENGTH)
    assert np.all(np.abs(touches.rows.a - exact)[1:] <= 1.3 * touches.errors[1:] / 0.9)
    assert np.all(np.diff(touches.rows.delta) > 0)


@pytest.mark.parametrize(
    ("body", "node", "behind"),
    [(LAYER, "outermost", 0.0), (NAMED["stack on half-space"], "nearest", 0.5), (LAYER, "next", 1.0)],
)
def test_the_edge_is_found_beside_the_body_and_about_by_the_tip(body: NodeBody, node: str, behind: float) -> None:
    for ahead in (0.0, 0.3):
        given = node_series(body, 40, 200, ahead, node)
        raw = RawSeries(*given.columns)
        found = compared(body.problem, raw).ahead
        assert found.source == "body"
        assert abs(found.elements - (ahead - behind)) < 1.5 * found.error
        assert found.error < 0.08
    on_half_space = RawSeries(*node_series(HALF_SPACE, 40, 200, 0.15, node).columns)
    by_tip = compared(HALF_SPACE.problem, on_half_space, False).ahead
    assert by_tip.source == "tip"
    assert abs(by_tip.elements - (0.15 - behind)) < by_tip.error < 0.25


@pytest.mark.parametrize(
    ("name", "elements", "increments", "ahead"),
    [("bonded 0.45", 61, 59, 0.3), ("stiff coating", 52, 52, 0.27)],
)
def test_nodes_that_increments_pass_evenly_are_told_by_the_body(
    name: str, elements: int, increments: int, ahead: float, tmp_path: Path
) -> None:
    """Nothing in such radii tells them from those that were asked for: 7, 2, 5 % of the force, 2 % stated."""
    given = node_series(NAMED[name], elements, increments, ahead, spacing="radius")
    solution = read(given, tmp_path)
    assert solution.warnings == ()
    error, stated = judged(given, solution)
    assert abs(error) < min(stated, 0.005)


def test_even_radii_of_the_bodies_own_solution_stay_as_they_are() -> None:
    for factor in (1.0, 1.01):  # of displacements: a tip of another radius
        a = LENGTH * 1.5 * np.arange(1, 51) / 50
        delta, P = LAYER.columns(a / LENGTH)[:2]
        given = RawSeries(a, factor * delta * LENGTH, P * MODULUS * LENGTH**2)
        assert compared(LAYER.problem, given).nodes is None


def test_a_modulus_does_not_move_the_edge_and_a_radius_of_the_tip_little() -> None:
    given = node_series(LAYER, 40, 200, 0.15)
    plain = compared(LAYER.problem, RawSeries(*given.columns)).ahead
    a, delta, P = given.columns
    stiffer = compared(LAYER.problem, RawSeries(a, delta, 3 * P)).ahead
    assert stiffer.elements == pytest.approx(plain.elements, abs=1e-12)
    other = compared(replace(LAYER.problem, indenter=Paraboloid(10 * LAYER.R * LENGTH)), RawSeries(a, delta, P)).ahead
    assert other.elements == pytest.approx(plain.elements, abs=0.05)


@pytest.mark.parametrize(("ahead", "node"), [(0.3, "outermost"), (0.0, "next")])
def test_bands_of_the_pull_off_force_hold(ahead: float, node: str, tmp_path: Path) -> None:
    given = node_series(LAYER, 60, 200, ahead, node)
    known, stated = judged(given, read(given, tmp_path))
    assert abs(known) < stated < 0.01
    alone, wider = judged(given, read(given, tmp_path, compare=False))
    assert abs(alone) < wider
    assert stated < wider < 0.06


def test_each_point_has_its_own_error(tmp_path: Path) -> None:
    given = node_series(NAMED["bonded 0.49 sphere"], 60, 200, 0.15)
    solution = read(given, tmp_path)
    for control in ("load", "displacement"):
        error, stated = judged(given, solution, control)
        assert abs(error) < stated < 0.05


@pytest.mark.first(1)
@pytest.mark.parametrize("rule", ["loocv-kept", "loocv", "gcv"])
def test_the_papers_rules_are_held_by_their_own_bands(rule: str, tmp_path: Path) -> None:
    given = node_series(LAYER, 40, 200, 0.3)
    error, stated = judged(given, read(given, tmp_path), rule=rule)
    assert abs(error) < stated


@pytest.mark.parametrize(("name", "rows", "compare"), [("bonded 0.45", 40, True), ("soft coating", 60, False)])
def test_rows_without_noise_that_are_doubled_raise_no_error_of_a_point(
    name: str, rows: int, compare: bool, tmp_path: Path
) -> None:
    """Errors by the rows at the pull-off points that there are, and the fit's own; every row is solved by itself: what
    a spline between some leaves is noise."""
    body, stated = NAMED[name], []
    w = body.work(0.4 * body.a_max)
    for number in (rows, 2 * rows):
        a = body.a_max * np.arange(1, number + 1) / number
        a = a[a > 0.0101 * body.a_max]
        columns = np.append([a], np.transpose([body._contact(each)[:2] for each in a]), axis=0)
        units = np.array([[LENGTH], [LENGTH], [MODULUS * LENGTH**2]])
        given = NodeSeries(body, 0, number, 0.0, "", False, 0.0, w * MODULUS * LENGTH, columns * units)
        result = analyse(read(given, tmp_path, compare), [given.w])[0]
        errors = []
        for control, stiffness in (("load", 0.0), ("displacement", np.inf)):
            point = result.pull_off[control]
            half = point if isinstance(point, Unknown) else error_of_rows(result.curve, point, stiffness)
            errors.append([np.nan] * 2 if isinstance(half, Unknown) else [*half.values()])
        stated.append(np.append(errors, result.curve.slopes.error))
    ratio = stated[1] / stated[0]
    assert (ratio[np.isfinite(ratio)] < 1.2).all()


@pytest.mark.first(1)
@pytest.mark.parametrize("compare", [True, False], ids=["beside the body", "alone"])
def test_a_part_of_the_node_study(compare: bool, tmp_path: Path) -> None:
    errors = np.array([judged(given, read(given, tmp_path, compare)) for given in many(10, seed=3)])
    held = np.abs(errors[:, 0]) <= errors[:, 1]
    assert held.sum() >= 8
    assert np.median(errors[:, 1] / np.abs(errors[:, 0])) < 9  # beside the body 10, with what is left of the edge added


def zones(increments: int, ahead: float = 0.15) -> tuple[RawSeries, float, float]:
    """A paraboloid on a half-space of E* = 1 MPa, on 30 elements and on those thrice as large beyond; loads straight
    from touch to touch. With R [m] and E* [Pa]."""
    R, E_star = 1e-3, 1e6
    nodes = np.cumsum(np.append(np.full(30, 1e-6), np.full(40, 3e-6)))
    edges = nodes[:-1] + ahead * np.diff(nodes)
    touch, load = edges**2 / R, 4 / 3 * E_star * edges**3 / R
    delta = np.linspace(0, touch[45], increments + 1)[1:]
    reached = np.searchsorted(touch, delta, side="right")
    radii = np.append(0.0, nodes)[reached]
    P = np.interp(delta, np.append(0.0, touch), np.append(0.0, load))
    return RawSeries(radii[reached > 2], delta[reached > 2], P[reached > 2]), R, E_star


def test_loads_at_touches_are_those_of_the_contact_and_not_of_the_chords_between() -> None:
    """A load that is straight from touch to touch lies above that of the contact; 0.2 % were left."""
    raw, R, E_star = zones(400)
    nodes = node_radii(raw)
    rows = nodes.touches(0.15).rows.only(nodes.touches(0.15).rows.a > 15e-6)
    exact = 4 / 3 * E_star * np.sqrt(R) * rows.delta**1.5
    np.testing.assert_allclose(rows.P, exact, rtol=5e-4)


def test_an_error_that_radii_share_is_what_other_radii_make_of_the_fit() -> None:
    """By a first derivative, beside fits with the edge so much farther ahead, and less."""
    raw, *_ = zones(400)
    at = 0.15, 0.0, "tip"
    alone, shared = (smoothed(raw, ahead=Ahead(*at, left))[1] for left in (0.0, 0.1))
    (series, more), (_, less) = (smoothed(raw, ahead=Ahead(0.15 + step, 0.0, "tip", 0.0)) for step in (0.05, -0.05))
    moved = np.sqrt(shared.joint[:, 3, 3] - alone.joint[:, 3, 3]) * HALF_WIDTH
    refitted = np.abs(more.dS - np.interp(series.a, smoothed(raw, ahead=Ahead(0.1, 0.0, "tip", 0.0))[0].a, less.dS))
    inner = slice(5, -5)
    assert np.median(moved[inner] / refitted[inner]) == pytest.approx(1, abs=0.2)


def test_zones_raise_no_error_under_control_of_the_displacement(tmp_path: Path) -> None:
    """A shift in proportion to the elements jumps where they do; the fit does not follow the jump."""
    raw, R, E_star = zones(150)
    np.savetxt(tmp_path / "t.csv", np.transpose([raw.a, raw.delta, raw.P]), header="a_m,delta_m,P_N", delimiter=",")
    problem = Problem(Paraboloid(R), Specimen((), HalfSpace(Elastic(0.75 * E_star, 0.5))), Loading("depth", 1e-6, 10))
    solution = read_series(tmp_path / "t.csv", problem, SeriesReading(compare=False))
    for a in np.array([20.0, 25.0, 30.0, 35.0]) * 1e-6:  # where contact is lost
        w = 8 * E_star * a**3 / (np.pi * R**2)
        result = analyse(solution, [w])[0]
        point, half = result.pull_off["displacement"], result.pull_off_errors["displacement"]
        assert point.a == pytest.approx(a, rel=0.1)
        true = 5 / 6 * np.pi * w * R
        assert abs(point.P + true) < half["P"] < 0.03 * true


@pytest.mark.parametrize(
    ("factor", "cause"),
    [(1.3, "--factor P="), (0.5, "half of the body"), (1 / 180, "--factor P=180"), (1000, "a unit")],
)
def test_a_factor_of_the_loads_is_warned_of(factor: float, cause: str, tmp_path: Path) -> None:
    given = node_series(LAYER, 40, 100, 0.15)
    solution = read(given, tmp_path, load=factor)
    assert solution.facts["loads_factor"] == pytest.approx(factor, rel=1e-3)
    assert cause in solution.warnings[0]
    assert f"{factor:#.4g}".rstrip(".") in solution.warnings[0]


def test_loads_that_are_right_are_a_number_without_a_warning(tmp_path: Path) -> None:
    for factor in (1.0, 1.03):
        for body in (LAYER, NAMED["stiff coating"]):
            given = node_series(body, 40, 100, 0.15)
            solution = read(given, tmp_path, load=factor)
            assert solution.warnings == ()
            assert solution.facts["loads_factor"] == pytest.approx(factor, rel=2e-3)
            assert f"{factor:.3f}" in solution.facts["loads"]
            assert "±" in solution.facts["loads"]


def test_a_radius_or_thickness_in_another_unit_is_warned_of(tmp_path: Path) -> None:
    given, factor = node_series(LAYER, 40, 100, 0.15), 10.0
    problem = LAYER.problem
    R = LAYER.R * LENGTH
    solution = read(given, tmp_path, problem=replace(problem, indenter=Paraboloid(factor * R)))
    assert "is R right" in solution.warnings[0]
    (layer,) = problem.specimen.layers
    specimen = replace(problem.specimen, layers=(replace(layer, thickness=factor * layer.thickness),))
    solution = read(given, tmp_path, problem=replace(problem, specimen=specimen))
    assert "the thickness" in solution.warnings[0]


def test_the_comparison_may_be_left_out(tmp_path: Path) -> None:
    given = node_series(LAYER, 40, 100, 0.15)
    solution = read(given, tmp_path, compare=False, load=1.3)
    assert solution.facts["loads"] == "not compared with these bodies"
    assert solution.warnings == ()


@pytest.mark.parametrize("nodes", [50, 100, 200])
def test_bands_of_calculix_tables_hold(nodes: int) -> None:
    """Closed forms; at 200 nodes displacements at equal radii are 0.28 % too small, for no known reason,
    and the force as much too large: without it 0.14 to 0.39 % were stated."""
    E, nu, R, a_max = 5e9, 0.4, 0.01, 17.3205e-6
    problem = Problem(Paraboloid(R), Specimen((), HalfSpace(Elastic(E, nu))), Loading("depth", 1e-6, 10))
    solution = read_series(CALCULIX / f"halfspace-{nodes}.csv", problem, SeriesReading(factors={"P": 180}))
    works = 8 * E / (1 - nu**2) * (np.array([0.2, 0.3, 0.4, 0.5, 0.6]) * a_max) ** 3 / (9 * np.pi * R**2)
    for w, result in zip(works, analyse(solution, works.tolist()), strict=True):
        point, half = result.pull_off["load"], result.pull_off_errors["load"]
        true = 1.5 * np.pi * w * R
        assert abs(point.P + true) < half["P"] < 0.014 * true


def test_coarse_radii_are_no_drift_and_drifts_of_the_load_are_told(tmp_path: Path) -> None:
    for name, elements, increments, ahead, node in (
        ("bonded 0.3", 12, 53, 0.23, "outermost"),
        ("sliding 0.4", 13, 95, 0.3, "nearest"),
        ("sphere on half-space", 14, 252, 0.15, "outermost"),
    ):
        given = node_series(NAMED[name], elements, increments, ahead, node)
        assert not check_against_solution(compared(given.body.problem, RawSeries(*given.columns)))
        a, delta, P = given.columns
        drifting = P * np.linspace(0.95, 1.05, P.size)
        assert "drifts" in check_against_solution(compared(given.body.problem, RawSeries(a, delta, drifting)))[0]

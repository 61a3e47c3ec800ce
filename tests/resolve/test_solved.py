"""Pull-off points of exact methods: solved at their own radii, with an error near the true one."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from stated_errors import assert_pull_off_within, stationary

from jkrcli import transform
from jkrcli.adhesion.curve import AdhesiveCurve
from jkrcli.bodies.indenters import Indenter, Paraboloid, Sphere, TableProfile
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Spacing, Specimen
from jkrcli.case.models import load_case
from jkrcli.case.store import solve
from jkrcli.methods.closed_form import ClosedForm
from jkrcli.methods.layered.solver import Layered
from jkrcli.methods.protocol import method_class
from jkrcli.report.tables import is_refined
from jkrcli.resolve.analysis import analyse, error_of_point, nonadhesive, seconds_of_points, with_solved_points

CASES = Path(__file__).parents[2] / "cases"


def test_the_cost_is_asked_for_at_the_radii_of_the_series() -> None:
    specimen = Specimen((Layer(Elastic(1e6, 0.45), 1e-5),), Rigid())
    radii = (6e-4, 6.5e-4, 6.8e-4, 7e-4, 7.3e-4, 7.5e-4)
    solution = ClosedForm()(Problem(Paraboloid(0.1), specimen, Loading.given("radius", radii)))
    assert 0 < seconds_of_points(solution) < 1


def test_points_that_take_too_many_nodes_cost_nothing(tuned: Callable[[str, object], None]) -> None:
    model = load_case(CASES / "thin-layer.toml").model
    solution = Layered()(model.problem())
    tuned("jkrcli.methods.layered.contact.LAYERED_MOST_NODES", 10)
    assert seconds_of_points(solution) == 0
    (result,) = analyse(solution, [model.adhesion.w[0]])
    assert not is_refined(result.curve, result.pull_off["load"])
    assert 0 < result.pull_off_errors["load"]["P"] < 1e-2 * abs(result.pull_off["load"].P)


@pytest.mark.parametrize(("name", "points"), [("gel", 100), ("coating", 100), ("thin-layer", 40)])
def test_points_are_solved_and_their_errors_are_near_the_truth(name: str, points: int) -> None:
    model = load_case(CASES / f"{name}.toml").model
    problem = replace(model.problem(), loading=replace(model.problem().loading, points=points))
    result = analyse(solve(problem, "layered")[1], [model.adhesion.w[0]])[0]
    assert result.budget.total < 1e-8
    for control, point in result.pull_off.items():
        P, delta = stationary(problem, result.w, point.a, control)
        stated = result.pull_off_errors[control]
        held, other = ("P", "delta") if control == "load" else ("delta", "P")
        truth = {"P": P, "delta": delta}
        room = {held: 1e-11, other: 1e-7}  # how well the polynomial knows it: what is not held follows the radius
        for quantity, value in truth.items():
            error = abs(getattr(point, quantity) - value)
            assert error <= stated[quantity] + room[quantity] * abs(value)
        # columns scatter by 1e-11, and P, which does not follow the radius, was up to 2.4 times beyond 4e-12
        assert 1e-11 * abs(truth[held]) <= stated[held] <= 1e-8 * abs(truth[held])
        assert stated[other] <= 1e-6 * abs(truth[other])


NEAR_ITS_RIM = Problem(
    Sphere(1.0),
    Specimen((Layer(Elastic(1e6, 0.4), 0.27), Layer(Elastic(3e5, 0.3), 1.0)), Rigid()),
    Loading("radius", 0.95, 30),
)


@pytest.mark.parametrize("share", [0.75, 0.92])
def test_the_place_of_pull_off_is_known_less_well_near_the_rim_of_a_sphere(share: float) -> None:
    """The profile is singular there, which polynomials through seven radii find at a rate that slows down."""
    series = Layered()(NEAR_ITS_RIM).series
    rate = np.gradient(series.P, series.a) / np.gradient(
        series.S * np.sqrt(4 * math.pi * series.a / series.dS), series.a
    )
    result = analyse(solve(NEAR_ITS_RIM, "layered")[1], [float(np.interp(share * 0.95, series.a, rate) ** 2)])[0]
    for control, stated in result.pull_off_errors.items():
        point = result.pull_off[control]
        P, delta = stationary(NEAR_ITS_RIM, result.w, point.a, control)
        assert abs(point.P - P) <= stated["P"] + 1e-11 * abs(P)
        assert abs(point.delta - delta) <= stated["delta"] + 1e-11 * abs(delta)


@pytest.mark.parametrize(("method", "share"), [("layered", 1.03), ("hybrid", 1.0005)])
def test_points_are_solved_beyond_the_last_row(method: str, share: float) -> None:
    body = Specimen((Layer(Elastic(1e6, 0.45), 1e-6),), Rigid())
    problem = Problem(Paraboloid(1e-5), body, Loading("radius", share * 1.025412e-6, 40))
    result = analyse(method_class(method)()(problem), [4e-3])[0]
    point, stated = result.pull_off["load"], result.pull_off_errors["load"]
    assert abs(point.P - stationary(problem, result.w, point.a, "load")[0]) <= stated["P"] < 1e-5 * abs(point.P)
    assert isinstance(result.curve.interpolation_error, float)
    assert result.summary


@pytest.mark.parametrize(
    ("rows", "spacing", "w", "stiffness"), [(19, "log", 0.0174013, 1805.8), (12, "radius", 1.0639e-4, 15.5866)]
)
def test_a_point_beside_its_solved_radius_errs_by_the_bend_between(
    rows: int, spacing: Spacing, w: float, stiffness: float
) -> None:
    body = Specimen((Layer(Elastic(1e6, 0.45), 1e-5),), Rigid())
    problem = Problem(Paraboloid(1e-4), body, Loading("radius", 4e-5, rows, spacing))
    curve = with_solved_points(analyse(Layered()(problem), [w])[0], stiffness).curve
    point = curve.pull_off(stiffness)
    stated = error_of_point(curve, point, stiffness)
    P, delta = stationary(problem, w, point.a, stiffness)
    assert abs(point.P - P) <= stated["P"] + 1e-11 * abs(P) <= 1e-8 * abs(P)
    assert abs(point.delta - delta) <= stated["delta"] + 1e-11 * abs(delta)


def test_what_is_read_between_the_rows_has_its_own_error() -> None:
    model = load_case(CASES / "thin-layer.toml").model
    result = analyse(solve(model.problem(), "layered")[1], [model.adhesion.w[0]])[0]
    curve, a = result.curve, result.curve.a
    middle = np.sqrt(a[1:8] * a[:7])
    exact = Layered(1e-11)(replace(model.problem(), loading=Loading.given("radius", tuple(middle)))).series
    t = np.sqrt(4 * math.pi * result.w * middle / exact.dS)
    between = curve.interpolation_at(middle)
    for name, truth, found in zip(
        ("delta", "P"), (exact.delta - t, exact.P - exact.S * t), curve.at(middle), strict=True
    ):
        errors = np.abs(found - truth)
        assert (errors <= between[name]).all()  # measured: 0.9
        assert (between[name] <= 30 * errors.max()).all()
    knots = curve.nonadhesive.knots.a  # type: ignore[attr-defined]
    assert all((values == 0).all() for values in curve.interpolation_at(knots).values())  # type: ignore[union-attr]


@pytest.mark.parametrize(("method", "count"), [("layered", 20), ("hybrid", 20)])
def test_a_table_is_off_by_no_more_than_its_points_and_its_error_say(method: str, count: int) -> None:
    body = Specimen((Layer(Elastic(1e6, 0.45), 8e-6),), Rigid())
    sphere, r = Sphere(2e-5), np.linspace(0, 1.2e-5, 21)
    table = TableProfile(tuple(r), tuple(np.asarray(sphere.f(r)).tolist()))
    result, true = (
        analyse(one(Problem(indenter, body, Loading("radius", 9e-6, points))), [0.05])[0]
        for one, indenter, points in ((method_class(method)(), table, count), (Layered(), sphere, 60))
    )
    assert_pull_off_within(result, true, 2e-3, 20)  # measured: 5.2 to 15


def test_rows_stay_beside_solved_radii_whatever_a_table_leaves_open() -> None:
    """A parabola that goes on as a cone, by 21 points: all rows beyond the kink gave way."""
    r = np.linspace(0, 2e-5, 21)
    f = np.where(r < 1.05e-5, r**2 / 2e-4, 5e-7 + 0.13 * (r - 1e-5))
    table = TableProfile(tuple(r.tolist()), tuple(f.tolist()))
    problem = Problem(table, Specimen((), HalfSpace(Elastic(1e6, 0.4))), Loading("radius", 1.8e-5, 200))
    solution = Layered()(problem)
    rows = AdhesiveCurve(nonadhesive(solution), 0.0258).pull_off(0.0)
    found = analyse(solution, [0.0258])[0].pull_off["load"]
    assert found.a == pytest.approx(rows.a, rel=1e-3)
    assert found.P == pytest.approx(rows.P, rel=1e-6)


@pytest.mark.parametrize("nu", [0.3, 0.4995])
@pytest.mark.parametrize("indenter", [Paraboloid(2e-5), Sphere(4e-5)], ids=["paraboloid", "sphere"])
def test_what_the_profile_leaves_of_the_depth_is_no_spring_in_series(indenter: Indenter, nu: float) -> None:
    specimen = Specimen((Layer(Elastic(3e4, nu), 5.8e-6),), Rigid())
    result = analyse(Layered()(Problem(indenter, specimen, Loading("radius", 3.4e-6, 32, "log"))), [2e-9])[0]
    point, stated = result.pull_off["displacement"], result.pull_off_errors["displacement"]
    _, delta = stationary(result.problem, result.w, point.a, "displacement")
    assert abs(point.delta - delta) <= stated["delta"] < 1e-8 * abs(delta)


E, NU = 5e6, 0.45
E_STAR = E / (1 - NU**2)
CASE = """
specimen.half_space = {{ E = 5e6, nu = 0.45 }}
loading = {{ depth = 1e-6, spacing = "{spacing}" }}
adhesion.w = {w}
[indenter]
{indenter}
"""


def controls(jkr: Callable, indenter: str, w: float, spacing: str = "radius") -> list[dict]:
    Path("body.toml").write_text(CASE.format(indenter=indenter, w=w, spacing=spacing))
    return jkr("pull-off", "body.toml", "--json").told["results"][0]["controls"]


@pytest.mark.parametrize(("edge", "w", "spacing"), [(1e-9, 0.05, "radius"), (1e-8, 0.1, "log")])
def test_kendalls_punch_under_either_control(jkr: Callable, edge: float, w: float, spacing: str) -> None:
    b = 20e-6
    found = controls(jkr, f'shape = "flat"\nflat_radius = {b}\nedge_radius = {edge}', w, spacing)
    for one in found:
        point = one["pull_off"]
        assert point["P_N"] == pytest.approx(-math.sqrt(8 * math.pi * w * E_STAR * b**3), rel=1e-8)
        assert point["delta_m"] == pytest.approx(-math.sqrt(2 * math.pi * w * b / E_STAR), rel=1e-8)
        assert point["P_err_N"] < 1e-5 * abs(point["P_N"])
        assert len(one["critical_points"]) <= 1  # no second minimum, and no maximum


@pytest.mark.parametrize(("angle", "w"), [(45, 0.05), (85, 1e-3)])
def test_cones_have_a_pull_off_under_displacement_control(jkr: Callable, angle: float, w: float) -> None:
    """delta = (pi/2) a cot(alpha) - sqrt(2 pi w a/E*) is least at a = 2 w tan^2(alpha)/(pi E*), delta = -w
    tan(alpha)/E*; P at nine times that radius."""
    tan = math.tan(math.radians(angle))
    loaded, held = controls(jkr, f'shape = "cone"\nhalf_angle = "{angle} deg"', w)
    a = 2 * w * tan**2 / (math.pi * E_STAR)
    assert held["pull_off"]["a_m"] == pytest.approx(a, rel=1e-4)
    assert held["pull_off"]["delta_m"] == pytest.approx(-w * tan / E_STAR, rel=1e-8)
    assert loaded["pull_off"]["a_m"] == pytest.approx(9 * a, rel=1e-4)


def test_a_contact_lost_within_its_series_is_not_solved_on(jkr: Callable) -> None:
    controls(jkr, 'shape = "paraboloid"\nradius = 1e-4', 0.05)
    assert "rows_below" not in transform("body.toml", 0.05).solution.facts
    controls(jkr, 'shape = "cone"\nhalf_angle = "80 deg"', 1e-3)
    assert transform("body.toml", 1e-3).solution.facts["rows_below"] > 0


FILM = """
indenter = { shape = "paraboloid", radius = "100 um" }
specimen.layers = [{ thickness = "1 um", E = "1 MPa", nu = 0.5 }]
specimen.half_space = { E = "6 kPa", nu = 0.3 }
adhesion.w = 1.65e-4
"""


def test_a_stiff_film_has_a_fold_of_its_own_below_the_first_row(jkr: Callable) -> None:
    found = []
    for points in (8, 100):
        Path("body.toml").write_text(f"{FILM}loading = {{ radius = 13e-6, points = {points} }}")
        held = jkr("pull-off", "body.toml", "--json").told["results"][0]["controls"][1]
        found.append(held["pull_off"])
        assert len(held["jumps_before_pull_off"]) == 1
    assert found[0]["a_m"] == pytest.approx(8.1615e-7, rel=1e-4)
    assert found[0]["delta_m"] == pytest.approx(found[1]["delta_m"], rel=1e-9)


def test_a_stiff_film_without_a_fold_of_its_own_keeps_its_rows(jkr: Callable) -> None:
    Path("body.toml").write_text(f"{FILM.replace('1 MPa', '10 kPa')}loading = {{ radius = 16e-6, points = 4 }}")
    assert "at smaller radii" not in jkr("transform", "body.toml", "--no-plots", "-v").out

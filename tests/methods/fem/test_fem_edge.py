"""The edge of the contact between vertices: one strip for body and half-space, S and dS/da from the touches."""

from dataclasses import replace

import numpy as np
import pytest

from jkrcli.adhesion.curve import transform
from jkrcli.adhesion.slopes import slopes
from jkrcli.bodies.indenters import Paraboloid, PowerLaw, RoundedFlat, Sphere
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.case.store import read_solution, write_solution
from jkrcli.methods.fem import FEM
from jkrcli.methods.fem.mesh import Strip, homogenised_half_space, layout_for
from jkrcli.methods.fem.model import Discretisation, _in_step
from jkrcli.methods.layered.solver import Layered
from jkrcli.resolve.analysis import analyse
from jkrcli.series import Solution

UNIT = Problem(Paraboloid(10.0), Specimen((), HalfSpace(Elastic(1.0, 0.3))), Loading("radius", 1.0))
BONDED = Specimen((Layer(Elastic(1.0, 0.4), 1.0),), Rigid())
LAYER = Problem(Paraboloid(1000.0), BONDED, Loading("radius", 5.0))
COATING = replace(UNIT, specimen=Specimen((Layer(Elastic(10.0, 0.3), 0.3),), HalfSpace(Elastic(1.0, 0.4))))
FLAT = replace(UNIT, indenter=RoundedFlat(0.5, 20.0), specimen=Specimen((Layer(Elastic(1.0, 0.3), 1.0),), Rigid()))


def exactly(problem: Problem, a: np.ndarray):
    return Layered()(replace(problem, loading=Loading.given("radius", tuple(a)))).series


def test_a_strip_is_filled_by_its_triangles():
    r = np.array([0.0, 0.1, 0.25, 0.5])
    strip = Strip.below(r, 10.0, np.array([1.0, 2.0]), 0.8)
    x, z = strip.points.reshape(-1, 2)[strip.cells].transpose(2, 0, 1)
    areas = 0.5 * ((x[:, 1] - x[:, 0]) * (z[:, 2] - z[:, 0]) - (x[:, 2] - x[:, 0]) * (z[:, 1] - z[:, 0]))
    assert (areas > 0).all()
    depth = -strip.points[-1, :, 1]
    assert areas.sum() == pytest.approx(np.trapezoid(depth, r), rel=1e-14)
    assert depth == pytest.approx(2 * 0.8 * np.array([0.1, 0.1, 0.15, 0.25]))  # the smaller neighbouring step
    assert -Strip.below(r, 0.1, np.array([1.0, 2.0]), 0.8).points[-1, :, 1].min() == pytest.approx(
        0.1
    )  # no deeper than asked


@pytest.mark.parametrize("element", ["triangle", "quadrilateral"])
def test_body_and_calibration_share_their_surface(element):
    method = FEM(element=element, spacing=0.1, growth=0.3)
    reach = method.reach(LAYER)
    recipe = Discretisation(layout_for(method, LAYER, reach), 2, (), reach)
    other = recipe.on_half_space(homogenised_half_space(recipe.layout.body, reach))
    grids = [recipe.layout.grid(), other.layout.grid()]
    radii = [grid.surface_radii() for grid in grids]
    n = int(np.searchsorted(radii[0], reach * (1 + 1e-9)))
    np.testing.assert_array_equal(radii[0][:n], radii[1][:n])
    if element == "triangle":
        below = [grid.points[(grid.points[:, 0] < reach) & (grid.points[:, 1] > -0.05)] for grid in grids]
        ours, theirs = ({tuple(point) for point in points} for points in below)
        assert len(ours & theirs) > 1.5 * n  # the surface and its strip where that is shallower, to the last digit


def test_a_calibration_of_fine_thin_layers_stays_small():
    """Lines of the paper's uniform mesh are not carried through a whole half-space."""
    problem = replace(LAYER, loading=Loading("depth", 0.15))
    method = FEM(layout="zones", element="quadrilateral", order=1, width=30.0)
    layout = layout_for(method, problem, method.reach(problem))
    other = layout.on(homogenised_half_space(layout.body, layout.law.reach * layout.unit))
    assert other.expected_cells() < layout.expected_cells()  # 61,000 of 73,000; millions with the body's own law


def test_the_edge_keeps_step_where_nodes_are_close():
    """A half-space's mesh that is 1e-3 too stiff as a whole moves no edge: 0.8 of a spacing on the paper's layer."""
    vertices = np.arange(1, 901) * 0.02
    edges = vertices - 0.23 * 0.02 - 8e-4 * vertices * (vertices / vertices[-1]) ** 1.35
    kept = _in_step(edges, 0.0, vertices)
    assert np.abs((kept - vertices) / 0.02 + 0.23).max() < 0.02
    scaled = np.geomspace(0.01, 1, 40)
    np.testing.assert_array_equal(_in_step(0.98 * scaled, 0.0, scaled), 0.98 * scaled)


def lost_under_load(solution: Solution, rule: str = "auto") -> np.ndarray:
    """Relative errors of the pull-off force and their stated half-widths, (10, 2), for works of adhesion at which
    contact is lost at 0.25 to 0.7 of the largest radius."""
    a_max = float(solution.raw.a[-1])
    exact = Layered()(replace(solution.problem, loading=Loading("radius", a_max, 60))).series
    t = np.sqrt(4 * np.pi * exact.a / exact.dS)
    works = (np.gradient(exact.P, exact.a) / np.gradient(exact.S * t, exact.a)) ** 2
    works, rows = np.interp(np.linspace(0.25, 0.7, 10) * a_max, exact.a, works).tolist(), []
    for w, result in zip(works, analyse(solution, works, rule), strict=True):
        true = transform(exact, slopes(exact, "exact"), w).pull_off(0.0).P
        point = result.pull_off["load"]
        rows.append((abs(point.P / true - 1), result.pull_off_errors["load"]["P"] / abs(true)))
    return np.array(rows)


PAPERS = Problem(Sphere(1e-4), Specimen((), HalfSpace(Elastic(5e9, 0.4))), Loading("depth", 3e-6, 100, "depth"))
ZONES = FEM(layout="zones", element="quadrilateral", order=1, depth=2e-3, width=1.2e-3, contact="incremental")


@pytest.mark.slow
@pytest.mark.parametrize("spacing", ["depth", "radius"])
@pytest.mark.parametrize("element_size", [5e-7, 1e-6, 2e-6, None], ids=["0.005 R", "0.01 R", "0.02 R", "thin layer"])
def test_bands_of_the_papers_increments_hold(spacing, element_size):
    if element_size is None:
        layer = Specimen((Layer(Elastic(5e9, 0.4), 1e-6),), Rigid())
        problem = Problem(Sphere(1e-3), layer, Loading("depth", 1.5e-7, 100, spacing))
        method = FEM(layout="zones", element="quadrilateral", order=1, element_size=2e-8, width=3e-5,
                     contact="incremental")  # fmt: skip
    else:
        problem = replace(PAPERS, loading=replace(PAPERS.loading, spacing=spacing))
        method = replace(ZONES, element_size=element_size)
    solution = method(problem)
    error, stated = lost_under_load(solution).T
    assert (error <= stated).sum() >= 9
    # meshes of 0.01 R happen to be right to 1e-4
    assert np.median(stated / error) < (20 if element_size == 1e-6 else 5)
    for rule in ("loocv", "gcv", "loocv-kept"):
        error, stated = lost_under_load(solution, rule).T
        assert (error <= stated).sum() >= 9


def test_increments_and_their_file_tell_what_nested_contact_does(tmp_path):
    asked = replace(COATING, loading=Loading("radius", 1.0, 30))
    increments, nested = (FEM(spacing=0.1, growth=0.3, contact=by)(asked) for by in ("incremental", "nested"))
    write_solution(tmp_path / "series.h5", increments)
    w = 0.05 * float(nested.series.P[-1]) / (np.pi * 10)
    solutions = increments, read_solution(tmp_path / "series.h5"), increments.scaled(2.0).scaled(0.5), nested
    results = [analyse(solution, [w])[0] for solution in solutions]
    for result in results:
        assert result.pull_off["load"].P == pytest.approx(results[0].pull_off["load"].P, rel=1e-6)
        assert result.pull_off_errors["load"]["P"] == pytest.approx(results[0].pull_off_errors["load"]["P"], rel=0.01)
    assert results[0].dropped == 0
    assert "between increments" in results[0].curve.slopes.reason


def test_loads_of_increments_are_not_stated_many_times_too_large():
    """On a uniform mesh they err as the square of the element over the radius: shallow rows are no measure of deep."""
    problem = replace(UNIT, loading=Loading("depth", 0.1, 40, "depth"))
    zones = FEM(layout="zones", element="quadrilateral", order=1, element_size=0.07, contact="incremental")
    series = zones(problem).series
    exact = Layered()(replace(problem, loading=Loading.given("depth", tuple(series.delta)))).series
    error, deep = np.abs(series.P - exact.P), series.delta > 0.1 * series.delta[-1]
    assert (error <= series.errors["P"]).all()
    assert np.median(series.errors["P"][deep] / error[deep]) < 10  # 6; it was 18


@pytest.mark.first(1)
@pytest.mark.parametrize("problem", [UNIT, COATING, LAYER], ids=["half-space", "coating", "layer"])
def test_slopes_are_as_accurate_as_stated(problem):
    solution = FEM()(problem)
    series = solution.series
    use = series.delta >= solution.facts["judged_from_m"]
    exact = exactly(problem, series.a[use])
    S, dS = series.S[use] / exact.S - 1, series.dS[use] / exact.dS - 1
    assert np.abs(S).max() < 5e-4  # measured 3e-5 to 2e-4
    assert np.abs(dS).max() < 2e-3  # measured 2e-4 to 1e-3
    assert np.mean(np.abs(S) <= series.errors["S"][use] / series.S[use]) > 0.9
    assert np.mean(np.abs(dS) <= series.errors["dS"][use] / series.dS[use]) > 0.9


def test_the_error_of_the_stiffness_holds_that_of_the_radius():
    """Two meshes agree on S under a cone, which is wrong by four times what they differ by; their radii tell."""
    problem = Problem(PowerLaw(1e-2, 1.0), BONDED, Loading("radius", 0.08))
    series = FEM()(problem).series
    assert (np.abs(series.S - exactly(problem, series.a).S) <= series.errors["S"]).all()  # measured 0.75 of it


@pytest.mark.slow
def test_auto_smooths_what_a_fit_can_and_keeps_the_slopes_at_a_flat_end():
    quick = FEM(spacing=0.08, growth=0.3)
    series = quick(FLAT).series
    smooth, flat = slopes(quick(LAYER).series), slopes(series)
    assert smooth.method == "integral"
    assert "within their stated error" in smooth.reason
    assert flat.method == "exact"
    exact = exactly(FLAT, series.a)
    beyond = series.a > 1.02 * FLAT.indenter.a0
    errors = {name: np.abs(slopes(series, name).dS / exact.dS - 1)[beyond].max() for name in ("exact", "loocv")}
    assert errors["exact"] < errors["loocv"]


@pytest.mark.first(1)
@pytest.mark.parametrize("problem", [UNIT, COATING, FLAT], ids=["half-space", "coating", "flat end on a layer"])
def test_the_band_holds_the_exact_curve(problem):
    series = FEM()(problem).series
    exact = exactly(problem, series.a)
    w = 0.05 * exact.P[-1] / (np.pi * 10)
    found, curve = (transform(each, slopes(each), w) for each in (series, exact))
    for name in ("P", "delta"):
        inside = np.abs(getattr(found, name) - getattr(curve, name)) <= found.errors[name]
        assert inside.mean() >= 0.9  # half-widths of 95 %; measured 0.97 and more


def test_without_an_error_estimate_there_are_no_slopes():
    assert FEM(estimate_error=False, spacing=0.2)(UNIT).series.S is None
    assert FEM(edge_correction=False, spacing=0.2)(UNIT).series.S is None


def test_increments_are_even_in_load():
    asked = replace(COATING, loading=Loading("depth", 0.05, 25, "load"))
    other = replace(COATING, loading=Loading("depth", 0.05, 25, "depth"))
    by_load, by_depth = (FEM(spacing=0.1, growth=0.3, contact="incremental", estimate_error=False)(one).raw
                         for one in (asked, other))  # fmt: skip
    np.testing.assert_allclose(np.diff(by_load.P), by_load.P[0], rtol=1e-8)
    assert by_load.delta[-1] == pytest.approx(0.05, rel=1e-12)
    assert by_load.P[-1] == pytest.approx(by_depth.P[-1], rel=1e-9)
    between = np.exp(np.interp(np.log(by_load.delta[3:]), np.log(by_depth.delta), np.log(by_depth.P)))
    np.testing.assert_allclose(by_load.P[3:], between, rtol=2e-3)

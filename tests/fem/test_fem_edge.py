"""The edge of the contact between vertices: one strip for body and half-space, S and dS/da from the touches."""

from dataclasses import replace

import numpy as np
import pytest

from jkrcli.adhesion.slopes import slopes
from jkrcli.bodies.indenters import Paraboloid, PowerLaw, RoundedFlat
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.case.store import read_solution, write_solution
from jkrcli.fem.mesh import Strip, homogenised_half_space, layout_for
from jkrcli.fem.model import _in_step
from jkrcli.fem.solver import FEM
from jkrcli.methods.layered.solver import Layered
from jkrcli.resolve.analysis import analyse

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


def test_without_an_error_estimate_there_are_no_slopes():
    assert FEM(estimate_error=False, spacing=0.2)(UNIT).series.S is None
    assert FEM(edge_correction=False, spacing=0.2)(UNIT).series.S is None

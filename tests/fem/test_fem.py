"""The method ``fem`` against closed forms and the exact layer solution; its error estimates; what it refuses."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from jkrcli.base.errors import InputError, Refusal, SolveError
from jkrcli.base.process import StageClock
from jkrcli.bodies.indenters import Paraboloid, PowerLaw, RoundedFlat, Sphere
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.fem import elasticity
from jkrcli.fem.elasticity import assemble, factorise
from jkrcli.fem.mesh import MeshedBody, scaled_layout, triangles
from jkrcli.fem.model import Discretisation, nested_events
from jkrcli.fem.solver import FEM
from jkrcli.formulas import hertz
from jkrcli.methods.layered.solver import Layered

SUBSTRATE = Specimen((), HalfSpace(Elastic(5e9, 0.4)))
SPHERE = Sphere(1e-4)
PAPER = Problem(SPHERE, SUBSTRATE, Loading("depth", 3e-6))
CUT = {"depth": 2e-3, "width": 1.2e-3}  # the paper's 20 R x 12 R
QUICK = {"estimate_error": False, "edge_correction": False}


def closed_form_errors(solution, problem):
    series, indenter = solution.series, problem.indenter
    use = series.delta >= 0.1 * series.delta[-1]
    low = max(indenter.a0, 1e-12 * series.a[0]) * (1 + 1e-14)
    high = min(3 * series.a[-1], indenter.r_max * (1 - 1e-9))
    a = np.array([brentq(lambda x, d=d: float(indenter.abel(x)) - d, low, high, xtol=1e-18) for d in series.delta[use]])
    P = indenter.half_space(a, problem.E_star)[1]
    return series.P[use] / P - 1, series.a[use] / a - 1


def test_a_stiffness_that_elements_do_not_solve_is_refused_with_a_remedy(monkeypatch):
    monkeypatch.setattr(elasticity, "RESIDUAL_LIMIT", 1e-30)
    with pytest.raises(SolveError, match=r"allowed 1e-30: moduli or sizes differ .*; use method layered or hybrid"):
        FEM(**QUICK)(PAPER)


def test_default_settings_on_the_papers_half_space():
    solution = FEM()(PAPER)
    P, a = closed_form_errors(solution, PAPER)
    assert np.abs(P).max() < 2e-4  # measured 1e-4
    assert np.abs(a).max() < 2e-5  # measured 2e-6: the calibration's profile is not the sphere
    assert solution.facts["balance"] < 1e-9
    assert solution.facts["complementarity"] < 1e-9
    assert solution.facts["residual"] < 1e-10
    assert set(solution.timings) >= {"mesh", "assembly", "factorisation", "surface solves", "contact"}
    assert np.abs(P).max() < solution.budget.discretisation < 20 * np.abs(P).max()


def test_the_truncation_is_estimated():
    solution = FEM(**CUT)(PAPER)
    assert solution.budget.truncation == pytest.approx(
        2.2e-3, rel=0.1
    )  # known from fine meshes; one vertex further out
    P, _ = closed_form_errors(solution, PAPER)
    assert P[-1] == pytest.approx(solution.budget.truncation, rel=0.1)  # discretisation adds 1e-4


def test_incremental_and_nested_lie_on_the_same_curve():
    nested = FEM(contact_radius=1.8e-5, **QUICK)(PAPER).series
    touches = replace(PAPER, loading=Loading.given("depth", tuple(nested.delta[20:-1])))
    steps = FEM(contact_radius=1.8e-5, contact="incremental", **QUICK)(touches)
    np.testing.assert_allclose(steps.raw.P, nested.P[20:-1], rtol=1e-9)
    assert len(steps.raw.a) == len(nested.delta) - 21  # the last row is the loading's end, between two touches
    assert steps.pressure.p.shape == (len(steps.raw.a), steps.pressure.r.size)


def test_contact_pressure_is_hertzian():
    problem = Problem(Paraboloid(10.0), Specimen((), HalfSpace(Elastic(1.0, 0.3))), Loading("radius", 1.0))
    solution = FEM(**QUICK)(problem)
    delta, table = solution.series.delta[-1], solution.pressure
    a = np.sqrt(10 * delta)
    inside = (table.r > 0.1 * a) & (table.r < 0.8 * a)
    hertzian = 2 * problem.E_star / np.pi * np.sqrt(a**2 - table.r[inside] ** 2) / 10
    np.testing.assert_allclose(table.p[-1][inside], hertzian, rtol=0.02)  # nodal averages on elements of 0.04 r


@pytest.mark.parametrize(
    ("to", "end", "by"), [("load", 0.05, "radius"), ("load", 0.05, "depth"), ("depth", 0.025, "load")]
)
def test_increments_follow_the_loading(to, end, by):
    problem = Problem(Paraboloid(10.0), Specimen((), HalfSpace(Elastic(1.0, 0.3))), Loading(to, end, 8, by))
    raw = FEM(contact="incremental", **QUICK)(problem).raw
    last = (raw.P if to == "load" else raw.delta)[-1]
    assert last == pytest.approx(end, rel=1e-3)  # interpolated in the table of events
    steps = np.diff({"radius": np.sqrt(raw.delta), "depth": raw.delta, "load": raw.P}[by])  # delta = a^2/R
    assert steps == pytest.approx(steps[-1], rel=0.02 if by == "radius" else 1e-8)


def test_given_loads_are_met_exactly():
    loads = (0.01, 0.02, 0.05)
    problem = Problem(Paraboloid(10.0), Specimen((), HalfSpace(Elastic(1.0, 0.3))), Loading.given("load", loads))
    np.testing.assert_allclose(FEM(contact="incremental", **QUICK)(problem).raw.P, loads, rtol=1e-8)


def test_first_order_elements_converge_with_order_two():
    """Root mean square errors of P(delta) on the paraboloid, all sizes of a mesh refined together."""
    material, sizes, errors = Elastic(1.0, 0.3), (0.2, 0.1, 0.05), []
    body = MeshedBody((300.0,), (material,), 300.0, True, "free", True, True, completed=True)
    for h in sizes:
        layout = scaled_layout(body, "triangle", 1.1, 0.0, 0.2, h, h)
        layout = replace(layout, law=replace(layout.law, far_growth=h))
        model = Discretisation(layout, 1, (), 1.1).build(StageClock())
        events = nested_events(model.contact(Paraboloid(10.0)), 0.0, "radius", 1.0)
        use = events.delta > 0.01
        exact = hertz(np.sqrt(10 * events.delta), material.E_star, 10.0)[1]
        errors.append(np.sqrt(np.mean((events.P / exact - 1)[use] ** 2)))
    assert 1.8 < np.polyfit(np.log(sizes), np.log(errors), 1)[0] < 2.2  # measured 1.97
    assert errors[-1] < 3e-3


@pytest.mark.parametrize("indenter", [PowerLaw(0.1, 1.0), RoundedFlat(0.5, 20.0)], ids=["cone", "rounded flat"])
def test_other_profiles_on_the_half_space(indenter):
    problem = Problem(indenter, Specimen((), HalfSpace(Elastic(1.0, 0.3))), Loading("radius", 1.0))
    solution = FEM(estimate_error=False)(problem)
    P, a = closed_form_errors(solution, problem)
    assert np.abs(P).max() < 1e-3
    assert np.abs(a).max() < 1e-3
    if indenter.a0:
        assert solution.series.S0 == pytest.approx(2 * problem.E_star * indenter.a0, rel=1e-3)


def test_an_elastic_indenter_acts_through_the_reduced_modulus():
    rigid = Problem(Paraboloid(10.0), Specimen((), HalfSpace(Elastic(1.0, 0.3))), Loading("radius", 1.0))
    elastic = replace(rigid, indenter=Paraboloid(10.0, Elastic(2.0, 0.2)))
    P, _ = closed_form_errors(FEM(**QUICK)(elastic), elastic)
    assert elastic.E_star < 0.7 * rigid.E_star
    assert np.abs(P).max() < 2e-4


def test_contact_beyond_the_refined_zone_is_refused_with_the_value_to_give():
    with pytest.raises(Refusal, match=r"mesh.contact_radius is 1e-05 m, this loading needs about 1.\de-05 m") as error:
        FEM(contact_radius=1e-5, **QUICK)(PAPER)
    assert "give that or leave it out" in str(error.value)


def test_a_too_small_forecast_is_mended(monkeypatch):
    monkeypatch.setattr("jkrcli.fem.model.largest_radius", lambda problem: 1e-5)
    P, _ = closed_form_errors(FEM(**QUICK)(PAPER), PAPER)
    assert np.abs(P).max() < 2e-4


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"smallest": 1e-9}, "mesh.smallest: must be > 1e-07 and < 1, got 1e-09"),
        ({"element_size": 1e-7}, 'mesh: element_size belongs to layout "zones"; the layout "scaled" takes spacing'),
    ],
)
def test_wrong_options_are_refused(options, message):
    with pytest.raises(InputError, check=lambda error: error.lines == (message,)):
        FEM(**options)


UNIT = Problem(Paraboloid(10.0), Specimen((), HalfSpace(Elastic(1.0, 0.3))), Loading("radius", 1.0))


def bonded(nu):
    layer = Specimen((Layer(Elastic(1.0, nu), 1.0),), Rigid())
    return Problem(Paraboloid(1000.0), layer, Loading("radius", 5.0))


@pytest.mark.first(1)
@pytest.mark.parametrize(
    ("problem", "options"),
    [
        (UNIT, {}),
        (UNIT, {"order": 1, "element": "quadrilateral"}),
        (bonded(0.5), {}),
        (bonded(0.3), {}),
        (replace(UNIT, specimen=Specimen((Layer(Elastic(10.0, 0.3), 0.3),), HalfSpace(Elastic(1.0, 0.4)))), {}),
        (replace(UNIT, specimen=Specimen((Layer(Elastic(1.0, 0.4), 1.0),), Rigid(bonded=False))), {}),
    ],
    ids=["half-space", "first-order quadrilaterals", "incompressible layer", "layer", "coating", "sliding layer"],
)
def test_error_columns_bound_the_error_of_every_row(problem, options):
    solution = FEM(**options)(problem)
    series, nus = solution.series, [material.nu for material in problem.specimen.materials]
    assert solution.facts["formulation"].startswith("displacement and pressure") == (max(nus) > 0.49)
    exact = Layered()(replace(problem, loading=Loading.given("depth", tuple(series.delta)))).series
    P, a = np.abs(series.P / exact.P - 1), np.abs(series.a / exact.a - 1)
    bound_P, bound_a = series.errors["P"] / series.P, series.errors["a"] / series.a
    assert (P <= bound_P).all()
    assert (a <= bound_a + 1e-9).all()
    assert (np.diff(bound_P) <= 1e-15).all()
    judged = series.delta >= solution.facts["judged_from_m"]
    # the two meshes' errors change sign over the depth and may nearly vanish by luck: up to 26 was measured
    assert P[judged].max() < solution.budget.discretisation < 30 * P[judged].max()
    assert bound_P[0] > 5 * solution.budget.discretisation  # one vertex in contact
    assert 0.01 * series.delta[-1] <= solution.facts["judged_from_m"] < 0.012 * series.delta[-1]


@pytest.mark.first(1)
@pytest.mark.parametrize(("to", "maximum"), [("depth", 0.0931), ("load", 0.0417), ("radius", 0.973)])
@pytest.mark.parametrize("corrected", [True, False])
def test_nested_ends_where_the_loading_ends(to, maximum, corrected):
    problem = replace(UNIT, loading=Loading(to, maximum))
    solution = FEM(estimate_error=False, edge_correction=corrected)(problem)
    series = solution.series
    last = {"depth": series.delta, "load": series.P, "radius": series.a}[to][-1]
    assert last == pytest.approx(maximum, rel=1e-12)
    P, a = closed_form_errors(solution, problem)
    assert abs(P[-1]) < 2e-4
    assert abs(a[-1]) < (1e-5 if corrected else 0.02)
    assert solution.pressure.p.shape[0] == len(series)
    assert solution.facts["events"] >= len(series)
    assert "nested has one radius per node, where it first touches" in solution.facts["radii"]


@pytest.mark.first(1)
@pytest.mark.parametrize(
    ("to", "values"), [("depth", (0.002, 0.03, 0.1)), ("load", (0.001, 0.02)), ("radius", (0.2, 0.5, 0.9))]
)
def test_nested_gives_the_values_asked_for(to, values):
    problem = replace(UNIT, loading=Loading.given(to, values))
    series = FEM(estimate_error=False)(problem).series
    np.testing.assert_allclose({"depth": series.delta, "load": series.P, "radius": series.a}[to], values, rtol=1e-12)
    exact = Layered()(problem).series
    np.testing.assert_allclose(series.P, exact.P, rtol=3e-4)
    np.testing.assert_allclose(series.a, exact.a, rtol=2e-4)


def test_nested_refuses_values_below_its_first_event():
    with pytest.raises(Refusal, match=r"loading: radius 1e-05 m lies below the first .* take a smaller mesh.smallest"):
        FEM(**QUICK)(replace(UNIT, loading=Loading.given("radius", (1e-5, 1.0))))


def test_increments_by_logarithms_and_values_that_share_a_node():
    solution = FEM(contact="incremental", **QUICK)(replace(UNIT, loading=Loading("radius", 1.0, 41, "log")))
    np.testing.assert_allclose(
        np.diff(np.log(solution.raw.delta)), np.log(1e8) / 40, rtol=0.12
    )  # first vertices' radii are uncorrected
    dropped = solution.facts["dropped"]
    assert dropped == 41 - len(solution.series) > 0
    assert f"{dropped} of 41 requested values share a node with another or lie below" in solution.warnings[0]
    close = replace(UNIT, loading=Loading.given("radius", (0.9, 0.901, 0.902)))
    assert "2 of 3 requested values" in FEM(contact="incremental", **QUICK)(close).warnings[0]


@pytest.mark.slow
def test_the_forecast_is_near():
    for problem in (UNIT, replace(bonded(0.3), loading=Loading("radius", 17.0)), replace(UNIT, specimen=GEL)):
        forecast, solution = FEM().forecast(problem), FEM()(problem)
        assert float(forecast.note.split()[1]) == pytest.approx(solution.facts["elements"], rel=0.3)
        assert forecast.error / 3 < solution.budget.total < 3 * forecast.error
    wide = Problem(Paraboloid(1e5), GEL, Loading("radius", 100.0))
    assert 3 < FEM().forecast(wide).seconds < 40  # measured 12


GEL = Specimen((Layer(Elastic(1.0, 0.5), 1.0),), Rigid())


def test_the_check_sees_a_layer_that_changes_its_volume():
    """The layer of the one before, in a solution that is wrong there by a millionth of the largest displacement."""
    body = MeshedBody((1.0, 0.5), (Elastic(1.0, 0.3), Elastic(1.0, 0.5)), 2.0, True, "free", False, False)
    grid = triangles(np.linspace(0, 2.0, 9), body.depth, body.interfaces, "0.3")
    system = assemble(grid, body, 2, mixed=(1,))
    factor = factorise(system, system.normal[:5])
    loads = np.zeros(system.K.shape[0])
    loads[system.normal[2]] = -1.0
    solution = factor.solve(loads)
    assert factor.residual(solution, loads) < 1e-12
    N = len(system.nodes)
    inside = np.flatnonzero(system.nodes[:, 1] < 0.25)
    wrong = solution.copy()
    wrong[inside] += 1e-6 * np.abs(solution[: 2 * N]).max() * system.nodes[inside, 0]
    assert factor.residual(wrong, loads + system.K @ (wrong - solution) * (np.arange(loads.size) < 2 * N)) > 1e-8

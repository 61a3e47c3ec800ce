"""Finite elements to a tolerance: every true error below it, every estimate near its error, nothing solved twice."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import refused_by

from jkrcli.base.errors import Refusal
from jkrcli.bodies.indenters import Indenter, Paraboloid, RoundedFlat
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.case import store
from jkrcli.fem.solver import FEM
from jkrcli.methods.layered.solver import Layered
from jkrcli.series import Solution

CASES = Path(__file__).parents[2] / "cases"
HALF_SPACE = Specimen((), HalfSpace(Elastic(1.0, 0.3)))


def layer(E: float, nu: float, thickness: float) -> Layer:
    return Layer(Elastic(E, nu), thickness)


def problem(indenter: Indenter, specimen: Specimen, a: float) -> Problem:
    return Problem(indenter, specimen, Loading("radius", a))


PROBLEMS = {
    "half-space": problem(Paraboloid(10.0), HALF_SPACE, 1.0),
    "stiff coating": problem(Paraboloid(10.0), Specimen((layer(10.0, 0.3, 0.3),), HalfSpace(Elastic(1.0, 0.4))), 1.0),
    "layer, a/h = 5": problem(Paraboloid(1000.0), Specimen((layer(1.0, 0.4, 1.0),), Rigid()), 5.0),
    "gel": problem(Paraboloid(1000.0), Specimen((layer(1.0, 0.499, 1.0),), Rigid()), 3.0),
    "soft interlayer": problem(
        Paraboloid(10.0), Specimen((layer(1.0, 0.3, 0.3), layer(0.1, 0.5, 0.1), layer(5.0, 0.3, 1.0)), Rigid()), 1.0
    ),
    "flat on a layer": problem(RoundedFlat(0.5, 20.0), Specimen((layer(1.0, 0.3, 1.0),), Rigid()), 1.0),
}


def true_error(solution: Solution, asked: Problem) -> float:
    series = solution.series
    use = series.delta >= solution.facts["judged_from_m"]
    depths = Loading.given("depth", tuple(series.delta[use]))
    exact = Layered()(replace(asked, loading=depths)).series
    return float(max(np.abs(series.P[use] / exact.P - 1).max(), np.abs(series.a[use] / exact.a - 1).max()))


def test_the_error_is_below_the_tolerance() -> None:
    solution = FEM(tolerance=1e-3)(PROBLEMS["half-space"])
    error, stated = true_error(solution, PROBLEMS["half-space"]), solution.budget.series
    assert error < stated <= 1e-3
    assert stated < 20 * error


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
def test_six_bodies_at_three_tolerances(tolerance: float) -> None:
    near = 0
    for name, asked in PROBLEMS.items():
        solution = FEM(tolerance=tolerance)(asked)
        error, stated = true_error(solution, asked), solution.budget.series
        assert error < tolerance, name
        assert stated <= tolerance, name
        near += error <= stated <= 20 * error
    assert near >= 0.8 * len(PROBLEMS)


@pytest.mark.first(1)
@pytest.mark.parametrize(
    "options", [{"depth": 20.0, "width": 12.0}, {"contact": "incremental"}], ids=["truncation", "radii of nodes"]
)
def test_a_tolerance_out_of_reach_is_refused_with_what_was_reached(options, tuned) -> None:
    tuned("jkrcli.fem.solver.REFINEMENT_FINEST", 0.02)
    with pytest.raises(Refusal, match=r"mesh.tolerance: 0.001 is not reached: with \d+ unknowns the estimated error"):
        FEM(tolerance=1e-3, **options)(PROBLEMS["half-space"])


@pytest.mark.parametrize("options", [{"layout": "zones"}, {"estimate_error": False}])
def test_what_a_tolerance_needs(options) -> None:
    assert refused_by(FEM, tolerance=1e-3, **options) == (
        'mesh: tolerance needs the layout "scaled" and estimate_error = true',
    )


def test_the_forecast_states_the_tolerance() -> None:
    forecast = FEM(tolerance=1e-2).forecast(PROBLEMS["half-space"])
    assert forecast.error == 1e-2
    assert forecast.seconds < FEM(tolerance=1e-4).forecast(PROBLEMS["half-space"]).seconds / 10


def test_run_takes_a_tolerance_and_records_it(jkr, tmp_path: Path) -> None:
    case = CASES / "gel.toml"
    outcome = jkr("run", case, "--method", "fem", "--tolerance", "1e-2", "-o", "gel.h5").ok
    solved = store.read_solution(tmp_path / "gel.h5")
    assert "tolerance = 0.01" in solved.record.toml
    assert solved.budget.series < 1e-2
    assert set(solved.series.errors) == {"a", "P", "S", "dS"}
    jkr("run", case, "--method", "auto", "--tolerance", "5", "-o", "no.h5").refused(
        "layered takes >= 1e-12 and <= 0.01, ", "got 5"
    )
    outcome = jkr("run", case, "--method", "closed-form", "--tolerance", "1e-3")
    assert outcome.err.startswith("jkr: error: --tolerance: method closed-form has none")


@pytest.mark.parametrize("method", ["layered", "hybrid"])
def test_a_tolerance_is_of_every_method(jkr, tmp_path: Path, method: str) -> None:
    exact, _, found = (
        store.read_solution(tmp_path / f"{tolerance}.h5") if jkr(
            "run", CASES / "gel.toml", "--method", method, "--tolerance", tolerance, "-o", f"{tolerance}.h5"
        ).code == 0 else None
        for tolerance in ("1e-7", "1e-4", "1e-3")
    )  # fmt: skip
    assert f"[{method}]\ntolerance = 0.001" in found.record.toml
    distance = np.max(np.abs(found.series.P / exact.series.P - 1))
    assert 1e-10 < distance < 1e-3
    assert distance < found.budget.total <= 1e-3

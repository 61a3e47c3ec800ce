"""The paper's cases and their relatives by finite elements, against the exact layer or closed forms.

Tolerances are those asked of the method; what was measured stands beside them. P(delta) is compared, free of the error
of a node-based radius, and above a tenth of the depth, below which few nodes are in contact.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import CASES

from jkrcli.base.errors import InputError
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.case.models import load_case, parse_case
from jkrcli.fem.solver import FEM
from jkrcli.methods.layered.solver import Layered
from jkrcli.series import Array

PLAIN = FEM(estimate_error=False, edge_correction=False)  # where radii play no part: a quarter of the time
H = 1.0


def between(x: Array | float, xs: Array, ys: Array) -> Array:
    """Linear in logarithms: exact on power laws, a second-order error in the spacing otherwise."""
    return np.exp(np.interp(np.log(x), np.log(xs), np.log(ys)))


def exact_loads(problem: Problem, delta: Array) -> Array:
    return Layered()(replace(problem, loading=Loading.given("depth", tuple(delta.tolist())))).series.P


def test_thin_layer_load_at_default_mesh() -> None:
    problem = load_case(CASES / "thin-layer.toml").model.problem()
    series = replace(PLAIN, width=30e-6)(problem).series
    upper = series.delta > 0.5 * series.delta[-1]
    np.testing.assert_allclose(series.P[upper], exact_loads(problem, series.delta[upper]), rtol=2e-3)  # measured: 5e-6


def layer(nu: float) -> Specimen:
    return Specimen((Layer(Elastic(1.0, nu), H),), Rigid())


def test_first_order_elements_lock_and_say_so() -> None:
    """Why second order is the default: nu = 0.499 makes the load of first-order elements too large."""
    problem = Problem(Paraboloid(1000.0), layer(0.499), Loading("radius", 5.0, 50))
    first = replace(PLAIN, order=1, element="quadrilateral", layout="zones", element_size=0.1 * H)
    solution = first(problem)
    stiff = between(0.8 * solution.series.delta[-1], solution.series.delta, solution.series.P)
    exact = exact_loads(problem, np.array([0.8 * solution.series.delta[-1]]))[0]
    assert stiff / exact - 1 > 0.02  # measured: 8 %
    assert "first-order elements lock near incompressibility: nu = 0.499 > 0.45" in solution.warnings[0]
    assert 'mesh.integration = "reduced"' in solution.warnings[0]


def test_reduced_integration_does_not_lock() -> None:
    """The paper's CAX4R: one point and hourglass control. Loads of increments, free of what nodes make of radii."""
    problem = Problem(Paraboloid(1000.0), layer(0.499), Loading("radius", 5.0, 50))
    first = FEM(estimate_error=False, order=1, element="quadrilateral", layout="zones", element_size=0.1 * H,
                integration="reduced", contact="incremental")  # fmt: skip
    solution = first(problem)
    series = solution.series
    np.testing.assert_allclose(series.P[25:], exact_loads(problem, series.delta[25:]), rtol=5e-3)  # measured: 1e-4
    assert not any("lock" in words for words in solution.warnings)
    assert solution.pressure.p[-1][0] == pytest.approx(solution.pressure.p[-1][1], rel=0.02)  # no hourglass on the axis


def test_reduced_integration_converges_at_second_order() -> None:
    """Loads at twenty depths: where between two nodes the edge lies averages out."""
    problem = Problem(Paraboloid(100.0), layer(0.3), Loading("depth", 0.02, 40, "depth"))
    errors = []
    for size in (0.2, 0.05):
        method = FEM(estimate_error=False, order=1, element="quadrilateral", layout="zones", element_size=size,
                     integration="reduced", contact="incremental")  # fmt: skip
        rows = method(problem).increments
        exact = exact_loads(problem, rows.delta[-20:])
        errors.append(float(np.sqrt(np.mean((rows.P[-20:] / exact - 1) ** 2))))
    assert errors[0] > 8 * errors[1]  # measured: 14


def test_reduced_integration_is_for_linear_quadrilaterals() -> None:
    with pytest.raises(InputError, match='is for linear quadrilaterals: set element = "quadrilateral" and order = 1'):
        FEM(integration="reduced")


CYLINDER = """
[indenter]
shape = "paraboloid"
radius = 100
[specimen]
base = "frictionless"
radius = "2.5 m"
side = "roller"
[[specimen.layers]]
thickness = 1
E = 1
nu = 0.3
[loading]
radius = 1
points = 20
"""
WRONG = {
    "radius alone": ('side = "roller"\n', "", "specimen: a cylinder needs both radius and side (free, roller"),
    "side alone": ('radius = "2.5 m"\n', "", "specimen: a cylinder needs both radius and side (free, roller"),
    "negative": ('"2.5 m"', '"-2.5 m"', "specimen.radius: must be > 0, got -2.5 m"),
    "misspelt": ('"roller"', '"rolled"', 'specimen.side: must be one of free, roller, clamped, got "rolled", did you'),
    "half-space": ('base = "frictionless"', "half_space = { E = 1, nu = 0.3 }",
                   "specimen: a cylinder (radius and side) stands on a rigid substrate: leave out half_space"),
}  # fmt: skip


@pytest.mark.parametrize(("old", "new", "line"), WRONG.values(), ids=WRONG.keys())
def test_wrong_cylinders_in_case_files(old: str, new: str, line: str) -> None:
    assert old in CYLINDER
    with pytest.raises(InputError, check=lambda error: str(error).startswith(f"c.toml: {line}")):
        parse_case(CYLINDER.replace(old, new).encode(), "c.toml")


def test_a_cylinder_in_a_case_file_reads_back_and_goes_to_the_hybrid(jkr, tmp_path: Path) -> None:
    case = parse_case(CYLINDER.encode(), "c.toml")
    specimen = case.model.problem().specimen
    assert (specimen.radius, specimen.side, specimen.base) == (2.5, "roller", Rigid(bonded=False))
    assert parse_case(case.to_toml().encode(), "again").model == case.model
    (tmp_path / "c.toml").write_text(CYLINDER)
    outcome = jkr("run", "c.toml", "--json")
    assert (outcome.code, json.loads(outcome.out)["method"]) == (0, "hybrid")

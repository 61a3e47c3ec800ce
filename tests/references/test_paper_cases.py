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

from jkrcli.adhesion.curve import CriticalPoint, transform
from jkrcli.adhesion.slopes import slopes
from jkrcli.base.errors import InputError
from jkrcli.bodies.indenters import Indenter, Paraboloid
from jkrcli.bodies.problem import Elastic, Layer, Loading, Problem, Rigid, Side, Specimen
from jkrcli.case.models import load_case, parse_case
from jkrcli.methods.fem import FEM
from jkrcli.methods.layered.solver import Layered
from jkrcli.series import Array, Series

PLAIN = FEM(estimate_error=False, edge_correction=False)  # where radii play no part: a quarter of the time
CORRECTED = FEM(estimate_error=False)
H, R = 1.0, 100.0


def between(x: Array | float, xs: Array, ys: Array) -> Array:
    """Linear in logarithms: exact on power laws, a second-order error in the spacing otherwise."""
    return np.exp(np.interp(np.log(x), np.log(xs), np.log(ys)))


def exact_loads(problem: Problem, delta: Array) -> Array:
    """P of the exact layer at the displacements ``delta``."""
    return Layered()(replace(problem, loading=Loading.given("depth", tuple(delta.tolist())))).series.P


def load_errors(problem: Problem, method: FEM, above: float) -> Array:
    """Relative errors of P(delta) above a fraction of the depth."""
    series = method(problem).series
    delta = series.delta[series.delta > above * series.delta[-1]]
    return series.P[-delta.size :] / exact_loads(problem, delta) - 1


def pull_off(series: Series, w: float, name: str = "auto") -> CriticalPoint:
    point = transform(series, slopes(series, name), w).pull_off(0.0)
    assert isinstance(point, CriticalPoint)
    return point


def case_of(name: str) -> Problem:
    return load_case(CASES / f"{name}.toml").model.problem()


def layer(nu: float, thicknesses: tuple[float, ...] = (H,), **ends: object) -> Specimen:
    layers = tuple(Layer(Elastic(1.0, nu), t) for t in thicknesses)
    return Specimen(layers, Rigid(), **ends)  # type: ignore[arg-type]


# ---------------------------------------------------------------------- Sec. 4.2
THIN_WIDTH = 30e-6


def test_thin_layer_load_at_default_mesh() -> None:
    errors = load_errors(case_of("thin-layer"), replace(PLAIN, width=THIN_WIDTH), 0.5)
    assert np.abs(errors).max() < 2e-3  # measured: 5e-6


@pytest.mark.slow
def test_thin_layer_pull_off_on_twenty_meshes() -> None:
    """The quantised radius errs differently on every mesh: vertex spacings times 1.00 to 1.05."""
    problem = case_of("thin-layer")
    exact = pull_off(Layered()(problem).series, 10.0)
    method = replace(CORRECTED, width=THIN_WIDTH)
    errors: dict[str, list[float]] = {"auto": [], "integral": []}
    for factor in np.linspace(1, 1.05, 20):
        series = replace(method, spacing=factor * method.spacing)(problem).series
        for name, found in errors.items():
            found.append(abs(pull_off(series, 10.0, name).P / exact.P - 1))
    assert np.median(errors["auto"]) < 5e-3  # measured: 1.6e-3
    assert max(errors["auto"]) < 1e-2  # measured: 4.3e-3
    assert max(errors["integral"]) < 1e-3  # measured: 3e-4, median 9e-5


# ---------------------------------------------------------------------- Sec. 4.3
@pytest.mark.slow
def test_gel_load_and_pull_off() -> None:
    problem = case_of("gel")
    series = CORRECTED(problem).series
    upper = series.delta > 0.1 * series.delta[-1]
    np.testing.assert_allclose(series.P[upper], exact_loads(problem, series.delta[upper]), rtol=3e-3)  # measured: 2e-4
    point = pull_off(series, 40e-3)
    assert point.P == pytest.approx(-1.4833e-3, rel=5e-3)  # the exact sphere's; measured: 9e-4
    assert point.a == pytest.approx(0.565e-3, rel=2e-2)  # measured: 1e-3; the minimum is flat


# ---------------------------------------------------------------------- up to nu = 1/2
SWEEP = [(nu, x) for nu in (0.3, 0.45, 0.49, 0.499, 0.4999, 0.49999, 0.5) for x in (1.0, 5.0)]
FAST = [(0.5, 5.0)]


@pytest.mark.parametrize(
    ("nu", "a_over_h"), [pytest.param(*pair, marks=() if pair in FAST else pytest.mark.slow) for pair in SWEEP]
)
def test_no_locking_up_to_incompressible(nu: float, a_over_h: float) -> None:
    """Measured over the sweep: P(delta) 2e-4, S 9e-4."""
    problem = Problem(Paraboloid(1000.0), layer(nu), Loading("radius", 1.3 * a_over_h, 50))
    series = CORRECTED(problem).series
    exact = Layered()(replace(problem, loading=Loading.given("radius", (a_over_h,)))).series
    assert between(exact.delta[0], series.delta, series.P) == pytest.approx(exact.P[0], rel=5e-3)
    S = between(a_over_h, series.a, slopes(series).S)
    assert S == pytest.approx(exact.S[0], rel=5e-3)


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


# ---------------------------------------------------------------------- finite cylinders
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
    "radius alone": ('side = "roller"\n', "", "specimen: a cylinder needs both radius and side (free, roller or "
                     "clamped), leave both out for a wide body"),
    "side alone": ('radius = "2.5 m"\n', "", "specimen: a cylinder needs both radius and side (free, roller or "
                   "clamped), leave both out for a wide body"),
    "negative": ('"2.5 m"', '"-2.5 m"', "specimen.radius: must be > 0, got -2.5 m"),
    "misspelt": ('"roller"', '"rolled"', 'specimen.side: must be one of free, roller, clamped, got "rolled", '
                 'did you mean "roller"?'),
    "half-space": ('base = "frictionless"', "half_space = { E = 1, nu = 0.3 }",
                   "specimen: a cylinder (radius and side) stands on a rigid substrate: leave out half_space"),
}  # fmt: skip


@pytest.mark.parametrize(("old", "new", "line"), WRONG.values(), ids=WRONG.keys())
def test_wrong_cylinders_in_case_files(old: str, new: str, line: str) -> None:
    assert old in CYLINDER
    with pytest.raises(InputError, check=lambda error: list(error.lines) == [f"c.toml: {line}"]):
        parse_case(CYLINDER.replace(old, new).encode(), "c.toml")


def test_a_cylinder_in_a_case_file_reads_back_and_goes_to_the_hybrid(jkr, tmp_path: Path) -> None:
    case = parse_case(CYLINDER.encode(), "c.toml")
    specimen = case.model.problem().specimen
    assert (specimen.radius, specimen.side, specimen.base) == (2.5, "roller", Rigid(bonded=False))
    assert parse_case(case.to_toml().encode(), "again").model == case.model
    (tmp_path / "c.toml").write_text(CYLINDER)
    outcome = jkr("run", "c.toml", "--json")
    assert (outcome.code, json.loads(outcome.out)["method"]) == (0, "hybrid")


def excess_load(indenter: Indenter, nu: float, radius: float, side: Side) -> float:
    """By how much a cylinder's load exceeds the wide layer's at equal depth, relative, at the end of the series."""
    loading = Loading("radius", 1.0, 40)
    problem = Problem(indenter, layer(nu, radius=radius, side=side), loading)
    series = PLAIN(problem).series
    return float(series.P[-1] / exact_loads(replace(problem, specimen=layer(nu)), series.delta[-1:])[0] - 1)


@pytest.mark.slow
@pytest.mark.parametrize("nu", [0.3, 0.49])
@pytest.mark.parametrize("side", ["free", "roller", "clamped"])
def test_cylinders_of_every_side(side: Side, nu: float) -> None:
    found = np.array([excess_load(Paraboloid(R), nu, L, side) for L in (2.0, 2.5, 3.0, 4.0, 10.0)])
    sign = -1 if side == "free" else 1
    assert (sign * found[:3] > 0).all()
    assert (np.diff(np.abs(found[:4])) < 0).all()
    assert abs(found[-1]) < 3e-4  # the mesh's own error is 4e-5

"""Stated errors of finite elements: what each is compared at, and that it holds where the side or the rim is near."""

from dataclasses import replace

import h5py
import numpy as np
import pytest
from stated_errors import stationary

from jkrcli.adhesion.curve import AdhesiveCurve, Nonadhesive
from jkrcli.base.errors import Unknown
from jkrcli.bodies.indenters import Indenter, Paraboloid, PowerLaw, Sphere, TableProfile
from jkrcli.bodies.problem import Elastic, Graded, HalfSpace, Layer, Loading, Power, Problem, Rigid, Specimen
from jkrcli.case import store
from jkrcli.fem.solver import FEM
from jkrcli.formulas import jkr
from jkrcli.methods.layered.solver import Layered
from jkrcli.methods.protocol import method_class
from jkrcli.report.tables import format_pull_off
from jkrcli.resolve.analysis import analyse, error_of_point
from jkrcli.series import Series

COATING = Problem(
    PowerLaw(0.02, 4.0),
    Specimen((Layer(Elastic(1.0, 0.3), 1.0),), HalfSpace(Elastic(30.0, 0.2))),
    Loading("radius", 1.5, 60),
)
CYLINDER = Problem(
    Paraboloid(50.0), Specimen((Layer(Elastic(1e4, 0.499), 0.6),), Rigid(), 1.0, "free"), Loading("radius", 0.9, 60)
)
WIDE_SPHERE = Problem(Sphere(1.0), Specimen((), HalfSpace(Elastic(1e4, 0.3))), Loading("radius", 0.97, 60))


def worst(found: Series, exact: Series, name: str, errors: np.ndarray) -> float:
    rows = found.delta >= 0.01 * found.delta[-1]
    return float(np.max((np.abs(getattr(found, name) - getattr(exact, name)) / errors)[rows]))


def test_errors_of_load_and_depth_are_known_at_equal_radius_and_at_equal_depth(tmp_path) -> None:
    """P(a) was off by four times what was stated: that is the error of P(delta)."""
    solution = FEM()(COATING)
    found = solution.series
    at_depth = Layered()(replace(COATING, loading=Loading.given("depth", tuple(found.delta)))).series
    at_radius = Layered()(replace(COATING, loading=Loading.given("radius", tuple(found.a)))).series
    assert worst(found, at_depth, "P", found.errors["P"]) <= 1
    assert worst(found, at_depth, "a", found.errors["a"]) <= 1
    told = found.errors_at_radius
    assert worst(found, at_radius, "P", told["P"]) <= 1
    assert worst(found, at_radius, "delta", told["delta"]) <= 1
    assert worst(found, at_radius, "P", found.errors["P"]) > 1  # why both are told
    store.write_solution(tmp_path / "x.h5", solution)
    with h5py.File(tmp_path / "x.h5") as file:
        words = {name: data.attrs["description"].decode() for name, data in file["errors"].items()}
        np.testing.assert_array_equal(file["errors/P_at_equal_a"][()], told["P"])
    assert words["P"] == "estimated absolute error of P at equal displacement"
    assert words["dS_da"] == "estimated absolute error of dS_da at equal radius"
    assert words["delta_at_equal_a"] == "estimated absolute error of delta at equal radius"
    assert store.read_solution(tmp_path / "x.h5").series.errors.keys() == found.errors.keys()
    assert at_radius.errors_at_radius == {}  # exact radii: all errors are at equal radius


@pytest.mark.slow
def test_a_free_side() -> None:
    found = FEM()(CYLINDER).series
    exact = method_class("hybrid")()(replace(CYLINDER, loading=Loading.given("radius", tuple(found.a)))).series
    for name in ("S", "dS"):
        assert worst(found, exact, name, found.errors[name]) <= 1
    assert worst(found, exact, "P", found.errors_at_radius["P"]) <= 1


def test_loads_at_equal_depth() -> None:
    found = FEM()(WIDE_SPHERE).series
    exact = Layered()(replace(WIDE_SPHERE, loading=Loading.given("depth", tuple(found.delta)))).series
    assert worst(found, exact, "P", found.errors["P"]) <= 1


def graded(exponent: float, length: float) -> Problem:
    """A paraboloid on a half-space, nearly, whose modulus grows like a power of the depth, as deep as 100 contacts."""
    layer = Layer(Graded(Power(1e3 * (length / 1e-6) ** exponent, length, exponent), 0.3), 1.0)
    return Problem(Paraboloid(1.0), Specimen((layer,), Rigid()), Loading("radius", 0.01, 100))


@pytest.mark.first(1)
@pytest.mark.parametrize("exponent", [0.6, 0.2, 0.8])
def test_the_forecast_of_a_graded_body_is_what_the_run_says(exponent: float) -> None:
    problem = graded(exponent, 1e-6)
    foretold, said = FEM().forecast(problem).error, FEM()(problem).budget.series
    assert said / 3 < foretold < 3 * said


@pytest.mark.first(1)
@pytest.mark.parametrize("nu", [0.3, 0.49])
def test_pull_off_on_a_clamped_cylinder(nu: float) -> None:
    body, w = Specimen((Layer(Elastic(1e5, nu), 3e-4),), Rigid(), 4e-4, "clamped"), 0.2
    problem = Problem(Paraboloid(1e-3), body, Loading("radius", 2.2e-4, 20))
    found, exact = FEM()(problem), method_class("hybrid")(1e-6)
    curve = analyse(found, [w])[0].curve
    for stiffness in (np.inf, float(found.series.S[10]), 0.0):
        point, stated = curve.pull_off(stiffness), error_of_point(curve, curve.pull_off(stiffness), stiffness)
        P, delta = stationary(problem, w, point.a, stiffness or "load", exact, 0.2)
        assert abs(point.P - P) <= stated["P"] < 0.05 * abs(point.P)
        assert abs(point.delta - delta) <= stated["delta"]


R, E, NU = 1e-4, 5e9, 0.4
DEFAULT = Problem(Paraboloid(R), Specimen((), HalfSpace(Elastic(E, NU))), Loading("radius", 1.73e-5))


def table(a: float) -> TableProfile:
    r = 1.5 * a * np.linspace(0, 1, 15)
    return TableProfile(tuple(r), tuple(0.14 * a * (0.4 * (r / a) ** 2 + 0.05 * (r / a) ** 4)))


def stack(nu: float, base: Rigid | HalfSpace, thickness: float = 1.0) -> Specimen:
    return Specimen((Layer(Elastic(1.0, nu), thickness),), base)


SLIDING = Rigid(bonded=False)
HARD = [  # indenter, specimen, contact radius, surface spacing
    pytest.param(
        table(30.8), stack(0.5, Rigid()), 30.8, 0.22, id="table on an incompressible layer", marks=pytest.mark.slow
    ),
    pytest.param(PowerLaw(0.1 / (4 * 14.6**3), 4.0), stack(0.124, SLIDING), 14.6, 0.1, id="power on a sliding layer"),
    pytest.param(Paraboloid(2.0), stack(0.5, HalfSpace(Elastic(49.0, 0.3))), 0.339, 0.09, id="stiff below, once 1.5"),
]


@pytest.mark.parametrize(("indenter", "specimen", "a", "spacing"), HARD)
def test_loads_and_radii_lie_within_the_stated_errors(
    indenter: Indenter, specimen: Specimen, a: float, spacing: float
) -> None:
    asked = Problem(indenter, specimen, Loading("radius", a))
    solution = FEM(spacing=spacing)(asked)
    series = solution.series
    use = series.delta >= solution.facts["judged_from_m"]
    exact = Layered()(replace(asked, loading=Loading.given("depth", tuple(series.delta[use])))).series
    assert (np.abs(series.P[use] - exact.P) <= series.errors["P"][use]).all()
    assert (np.abs(series.a[use] - exact.a) <= series.errors["a"][use]).all()


PLATE = Problem(PowerLaw(0.1, 1.0), stack(0.3, HalfSpace(Elastic(0.007, 0.3))), Loading("radius", 13.0, 12, "depth"))


@pytest.mark.slow
def test_a_contact_that_is_no_disc_is_solved_estimated_and_said() -> None:
    coarse, fine = FEM(spacing=0.1)(PLATE), FEM(contact="incremental", spacing=0.04)(PLATE)
    assert coarse.facts["contact"] == "incremental"
    assert any("nested contact does not hold here" in line for line in coarse.warnings)
    assert any("increments the contact is no full disc: its middle lifts off" in line for line in coarse.warnings)
    assert set(coarse.series.errors) == {"a", "P"}
    P = np.interp(coarse.series.delta, fine.series.delta, fine.series.P)
    inside = coarse.series.delta <= fine.series.delta[-1]
    share = np.abs(coarse.series.P - P)[inside] / coarse.series.errors["P"][inside]
    assert (share[-4:] < 1).all()  # the deepest, where P is nearly linear from one increment to the next


@pytest.mark.first(1)
@pytest.mark.parametrize("contact", ["nested", "incremental"])
def test_a_mesh_whose_error_is_not_estimated_states_none_at_pull_off(contact: str) -> None:
    """What a smooth series leaves of a fit, 1e-4, tells nothing of its mesh, which is off by more."""
    plain = FEM(spacing=0.1, estimate_error=False, edge_correction=False, contact=contact)
    (result,), (other,) = (analyse(method(DEFAULT), [50.0]) for method in (plain, FEM(spacing=0.1, contact=contact)))
    point, stated = result.pull_off["load"], result.pull_off_errors["load"]
    assert abs(-point.P / (1.5 * np.pi * 50.0 * R) - 1) > 1e-3
    assert isinstance(stated, Unknown)
    assert "not estimated" in stated.reason
    assert not result.curve.errors
    assert isinstance(result.budget.total, Unknown)
    assert not any("that was estimated" in line for line in result.warnings)
    assert any("not estimated" in line for line in format_pull_off(result, {"load": (point, stated)}))
    assert isinstance(other.pull_off_errors["load"], dict)


def test_units_do_not_matter_to_nearly_incompressible_bodies() -> None:
    unit, modulus = 1e-6, 1e11
    method = FEM(spacing=0.15, estimate_error=False)
    plain = Problem(Paraboloid(10.0), stack(0.4999, Rigid()), Loading("radius", 1.0))
    layer = Specimen((Layer(Elastic(modulus, 0.4999), unit),), Rigid())
    other = Problem(Paraboloid(10.0 * unit), layer, Loading("radius", unit))
    found, expected = method(other).series, method(plain).series
    np.testing.assert_allclose(found.P / (modulus * unit**2), expected.P, rtol=1e-8)  # of the saddle point: 1e-10
    np.testing.assert_allclose(found.a / unit, expected.a, rtol=1e-8)
    np.testing.assert_allclose(found.delta / unit, expected.delta, rtol=1e-8)


def test_pull_off_of_the_half_space_is_jkrs() -> None:
    curve = Nonadhesive.of(FEM()(DEFAULT).series)
    for w in (50.0, 500.0, 5.0):
        point = AdhesiveCurve(curve, w).pull_off(0.0)
        assert -point.P == pytest.approx(1.5 * np.pi * w * R, rel=2e-4)
        delta, P = jkr(np.array(point.a), DEFAULT.E_star, R, w)
        assert (point.delta, point.P) == pytest.approx((delta, P), rel=2e-3)

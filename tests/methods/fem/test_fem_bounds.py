"""Stated errors of finite elements: what each is compared at, and that it holds where the side or the rim is near."""

from dataclasses import replace

import h5py
import numpy as np
import pytest
from stated_errors import stationary

from jkrcli.bodies.indenters import Paraboloid, PowerLaw, Sphere
from jkrcli.bodies.problem import Elastic, Graded, HalfSpace, Layer, Loading, Power, Problem, Rigid, Specimen
from jkrcli.case import store
from jkrcli.methods.fem import FEM
from jkrcli.methods.hybrid import Hybrid
from jkrcli.methods.layered.solver import Layered
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

# P(delta) was 4.4e-5 off where the doubled mesh, nearly as wrong, made it 3.0e-5; four times the sizes tell
STEEP = Problem(
    PowerLaw(0.24, 4.1055),
    Specimen((Layer(Elastic(1.88e8, 0.2173), 1.153),), Rigid(bonded=False)),
    Loading("radius", 1.0),
)

# S was 2.8e-4 off where the doubled mesh made it 1.5e-4
STACKED = Problem(
    PowerLaw(0.0612, 3.63874),
    Specimen(
        (Layer(Elastic(2.84063, 0.5), 5.0812166), Layer(Elastic(14.84838, 0.5), 4.6477713)), Rigid(), 3.0869513, "free"
    ),
    Loading("radius", 1.0, 40),
)


def worst(found: Series, exact: Series, name: str, errors: np.ndarray) -> float:
    """The true error of a column over the stated one, where that is worst."""
    rows = found.delta >= 0.01 * found.delta[-1]
    return float(np.max((np.abs(getattr(found, name) - getattr(exact, name)) / errors)[rows]))


def test_errors_of_load_and_depth_are_known_at_equal_radius_and_at_equal_depth() -> None:
    """P(a) was off by four times what was stated: that is the error of P(delta)."""
    found = FEM()(COATING).series
    at_depth = Layered()(replace(COATING, loading=Loading.given("depth", tuple(found.delta)))).series
    at_radius = Layered()(replace(COATING, loading=Loading.given("radius", tuple(found.a)))).series
    assert worst(found, at_depth, "P", found.errors["P"]) <= 1
    assert worst(found, at_depth, "a", found.errors["a"]) <= 1
    told = found.errors_at_radius
    assert worst(found, at_radius, "P", told["P"]) <= 1
    assert worst(found, at_radius, "delta", told["delta"]) <= 1
    assert worst(found, at_radius, "P", found.errors["P"]) > 1  # why both are told


def test_the_file_says_what_each_error_is_compared_at(tmp_path) -> None:
    solution = FEM(spacing=0.12)(COATING)
    store.write_solution(tmp_path / "x.h5", solution)
    with h5py.File(tmp_path / "x.h5") as file:
        words = {name: data.attrs["description"].decode() for name, data in file["errors"].items()}
        told = file["errors/P_at_equal_a"][()]
    assert words["P"] == "estimated absolute error of P at equal displacement"
    assert words["dS_da"] == "estimated absolute error of dS_da at equal radius"
    assert words["delta_at_equal_a"] == "estimated absolute error of delta at equal radius"
    np.testing.assert_array_equal(told, solution.series.errors_at_radius["P"])
    assert store.read_solution(tmp_path / "x.h5").series.errors.keys() == solution.series.errors.keys()
    assert Layered()(COATING).series.errors_at_radius == {}  # exact radii: all errors are at equal radius


@pytest.mark.slow
@pytest.mark.parametrize("body", [CYLINDER, STACKED], ids=["near the contact", "S agrees by accident"])
def test_a_free_side(body: Problem) -> None:
    found = FEM()(body).series
    exact = Hybrid()(replace(body, loading=Loading.given("radius", tuple(found.a)))).series
    for name in ("S", "dS"):
        assert worst(found, exact, name, found.errors[name]) <= 1
    assert worst(found, exact, "P", found.errors_at_radius["P"]) <= 1


@pytest.mark.parametrize("body", [WIDE_SPHERE, STEEP], ids=["the rim of a sphere", "two meshes that agree by accident"])
def test_loads_at_equal_depth(body: Problem) -> None:
    found = FEM()(body).series
    exact = Layered()(replace(body, loading=Loading.given("depth", tuple(found.delta)))).series
    assert worst(found, exact, "P", found.errors["P"]) <= 1


def graded(exponent: float, length: float) -> Problem:
    """A paraboloid on a half-space, nearly, whose modulus grows like a power of the depth, as deep as 100 contacts."""
    layer = Layer(Graded(Power(1e3 * (length / 1e-6) ** exponent, length, exponent), 0.3), 1.0)
    return Problem(Paraboloid(1.0), Specimen((layer,), Rigid()), Loading("radius", 0.01, 100))


@pytest.mark.parametrize(("exponent", "length", "unfinished"), [(0.4, 1e-8, 6e-4), (0.6, 1e-9, 1.7e-3)])
def test_pull_off_of_power_law_grading(exponent: float, length: float, unfinished: float) -> None:
    """(k + 3)/2 pi w R (Chen, Yan, Zhang and Gao 2009), less what a finite modulus at the surface takes off, about
    (length/a)^(1 - k): 1.2 % off in rows as high as the distance of vertices, in which the modulus grows a hundredfold.
    """
    problem, w = graded(exponent, length), 1e-3
    solution = FEM()(problem)
    curve = analyse(solution, [w])[0].curve
    point = curve.pull_off(0.0)
    stated = error_of_point(curve, point, 0.0)["P"] / abs(point.P)
    off = abs(-point.P / ((exponent + 3) / 2 * np.pi * w) - 1)
    assert off <= stated + unfinished
    assert stated < 2e-3


@pytest.mark.parametrize("exponent", [0.2, 0.6, 0.8])
def test_the_forecast_of_a_graded_body_is_what_the_run_says(exponent: float) -> None:
    """It was 9e-4 where the run said 2.3e-2."""
    problem = graded(exponent, 1e-6)
    foretold, said = FEM().forecast(problem).error, FEM()(problem).budget.series
    assert said / 3 < foretold < 3 * said


def test_pull_off_of_a_sphere_on_a_sliding_stack() -> None:
    """P was 1.35 times as far off as was stated: both larger meshes are as wrong, and differ by less."""
    layers = (Layer(Elastic(50639770979.42447, 0.3559037223906424), 0.012591549646555487),
              Layer(Elastic(541515749195.9683, 0.5), 0.10050109936886525))  # fmt: skip
    body, sphere, w = Specimen(layers, Rigid(bonded=False)), Sphere(0.5881750753166756), 154365.46151309117
    problem = Problem(sphere, body, Loading("radius", 0.029408753765833778, 100))
    curve = analyse(FEM()(problem), [w])[0].curve
    point, stated = curve.pull_off(0.0), error_of_point(curve, curve.pull_off(0.0), 0.0)
    P, delta = stationary(problem, w, point.a, "load", around=0.05)
    assert abs(point.P - P) <= stated["P"] < 3e-4 * abs(point.P)
    assert abs(point.delta - delta) <= stated["delta"]


@pytest.mark.parametrize("nu", [0.3, 0.49])
def test_pull_off_on_a_clamped_cylinder(nu: float) -> None:
    """Under displacement control P was 1.37 times as far off as was stated, with a spring 1.06 times."""
    body, w = Specimen((Layer(Elastic(1e5, nu), 3e-4),), Rigid(), 4e-4, "clamped"), 0.2
    problem = Problem(Paraboloid(1e-3), body, Loading("radius", 2.2e-4, 20))
    found = FEM()(problem)
    curve = analyse(found, [w])[0].curve
    for stiffness in (np.inf, float(found.series.S[10]), 0.0):
        point, stated = curve.pull_off(stiffness), error_of_point(curve, curve.pull_off(stiffness), stiffness)
        P, delta = stationary(problem, w, point.a, stiffness or "load", Hybrid(1e-6), 0.2)
        assert abs(point.P - P) <= stated["P"] < 0.05 * abs(point.P)
        assert abs(point.delta - delta) <= stated["delta"]

"""Stated errors near the end of a profile or a body, at few radii, at kinks and flat ends, against another method."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from stated_errors import assert_pull_off_within

from jkrcli.bodies.indenters import Paraboloid, RoundedFlat, Sphere, TableProfile
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.case.models import load_case
from jkrcli.formulas import shift
from jkrcli.hybrid.solver import Hybrid
from jkrcli.methods.fem import FEM
from jkrcli.methods.layered.solver import Layered
from jkrcli.resolve.analysis import analyse, nonadhesive

CASES = Path(__file__).parents[2] / "cases"


def given(indenter: Sphere | Paraboloid, specimen: Specimen, *radii: float) -> Problem:
    return Problem(indenter, specimen, Loading.given("radius", radii))


SOFT = Specimen((Layer(Elastic(90761.0, 0.5), 1.66e-6),), HalfSpace(Elastic(908806.0, 0.427)))


STIFF = Specimen((Layer(Elastic(8.292e9, 0.22305), 1.4194e-7), Layer(Elastic(6.71125e10, -0.74836), 4.3292e-8)),
                 HalfSpace(Elastic(1.31226e15, 0.5)))  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(
    ("R", "specimen", "radii"),
    [(4.307e-8, SOFT, (1.765e-8, 4.178e-8)), (1.69e-8, STIFF, (4.92e-9, 6.404e-9, 1.6393e-8))],
)
def test_fem_at_a_few_radii_up_to_the_equator_of_a_sphere(
    R: float, specimen: Specimen, radii: tuple[float, ...]
) -> None:
    """P at equal depth was 3.8e-3 and 3.9e-3 off at a/R = 0.97, 1.6e-3 and 1.8e-3 stated: two meshes agreed by
    accident at two radii."""
    problem = given(Sphere(R), specimen, *radii)
    series = FEM()(problem).series
    exact = Layered()(replace(problem, loading=Loading.given("depth", tuple(series.delta.tolist())))).series
    assert np.all(np.abs(series.P - exact.P) <= series.errors["P"])
    assert np.all(np.abs(series.a - exact.a) <= series.errors["a"])
    assert np.all(series.errors["P"] < 1e-2 * series.P)


def test_hybrid_near_the_equator_of_a_sphere() -> None:
    """P was 5.2e-7 off at a/R = 0.97, 2.6e-7 stated: the quadrature of F counted for nothing."""
    layers = (Layer(Elastic(143800.7, 0.5), 9.47e-8), Layer(Elastic(239.5, 0.3316), 2.97e-8),
              Layer(Elastic(2838.7, 0.00876), 7.78e-8))  # fmt: skip
    problem = given(Sphere(7.4236e-9), Specimen(layers, Rigid(bonded=False)), 7.2009e-9)
    series, exact = Hybrid()(problem).series, Layered(1e-10)(problem).series
    for name in ("delta", "P", "S", "dS"):
        assert abs(getattr(series, name) - getattr(exact, name)) <= series.errors[name]


def bent(points: int) -> tuple[Problem, float]:
    """A table whose f'' jumps tenfold at a radius [m] that it names, on a layer."""
    r = np.linspace(0, 12e-6, 25)
    b = float(r[10])
    f = np.where(r < b, r**2 / 4e-5, b**2 / 4e-5 + (r - b) * b / 2e-5 + (r - b) ** 2 / 4e-6)
    table = TableProfile(tuple(r.tolist()), tuple(f.tolist()), bends=(b,))
    body = Specimen((Layer(Elastic(1e6, 0.45), 8e-6),), Rigid())
    return Problem(table, body, Loading("radius", 9e-6, points)), b


def test_a_profile_that_bends_between_the_rows() -> None:
    """Where f'' jumps tenfold the curve between 20 rows was 2.4e-3 (delta) and 4.3e-3 (P) off."""
    problem, b = bent(20)
    curve = nonadhesive(Layered()(problem))
    assert b in curve.a
    a = np.sqrt(curve.a[1:] * curve.a[:-1])
    exact = Layered(1e-10)(replace(problem, loading=Loading.given("radius", tuple(a.tolist())))).series
    assert np.max(np.abs(curve.parts(a).delta_H / exact.delta - 1)) < 4e-4  # measured: 2.0e-4
    assert np.max(np.abs(curve.parts(a).P_H / exact.P - 1)) < 8e-4  # measured: 3.8e-4


@pytest.mark.slow
def test_the_curve_of_a_mesh_where_a_profile_bends() -> None:
    """Slopes that are a smooth fit left delta 4.4e-2 off there, 1.8e-2 stated."""
    problem, b = bent(40)
    curve = analyse(FEM()(problem), [0.01])[0].jkr
    assert curve.slopes.method == "exact"
    a = b * (1 + np.array([-0.05, -0.02, -0.01, -0.001, 0.001, 0.01, 0.02, 0.05]))
    exact = Layered(1e-10)(replace(problem, loading=Loading.given("radius", tuple(a.tolist())))).series
    assert exact.dS is not None
    t = shift(0.01, a, exact.dS)
    stated, between = curve.error_at(a), curve.interpolation_at(a)
    for name, found, true in zip(("delta", "P"), curve.at(a), (exact.delta - t, exact.P - exact.S * t), strict=True):
        error = np.abs(found - true)
        assert np.all(error <= stated[name] + between[name])  # measured: at most 0.56 times
        assert np.all(error < 0.05 * np.max(np.abs(true)))  # measured: 4.2e-2


@pytest.mark.slow
@pytest.mark.parametrize(("name", "factor"), [("thin-layer", 40), ("gel", 3)])  # measured: 22 and 2.5
def test_points_of_meshes_are_not_stated_far_too_large(name: str, factor: float) -> None:
    """The force at load pull-off was stated 200 and 45 times too large, that under displacement control 118 times:
    against the largest relative error among five works, as errors go through zero (at the case's w alone 15 and 2.7
    times, 24 and 38)."""
    model = load_case(CASES / f"{name}.toml").model
    works = [model.adhesion.w[0] * 10**x for x in (0.0, -0.5, -0.25, 0.25, 0.5)]
    found, exact = (analyse(method(model.problem()), works) for method in (FEM(), Layered()))
    for control, most in (("load", 10), ("displacement", factor)):  # load, measured: 3
        errors, stated = [], []
        for one, other in zip(found, exact, strict=True):
            point, truth, half = one.pull_off[control], other.pull_off[control], one.pull_off_errors[control]
            errors.append(abs(point.P / truth.P - 1))
            stated.append(half["P"] / abs(truth.P))
        assert np.all(np.array(errors) <= stated)
        assert stated[0] <= most * max(errors)


@pytest.mark.slow
def test_a_flat_end_says_how_far_scatter_leaves_its_pull_off() -> None:
    """The load of a finite-element series under displacement control was 5.6e-3 off, 1.4e-3 stated."""
    layers = (Layer(Elastic(14239.26, 0.49999), 2.0656e-8), Layer(Elastic(65486.3, 0.5), 6.9045e-9))
    body = Specimen(layers, HalfSpace(Elastic(15334.2, 0.5)))
    problem = Problem(RoundedFlat(1.08953e-9, 2.17907e-7), body, Loading("radius", 2.17907e-9, 100))
    found, exact = (analyse(method(problem), [9.5952e-11])[0] for method in (FEM(), Layered()))
    assert_pull_off_within(found, exact, 0.05)

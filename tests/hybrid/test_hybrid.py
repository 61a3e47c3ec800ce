"""The hybrid against exact layer solutions, its own limits and identities, and what it says about its error."""

from dataclasses import replace

import numpy as np
import pytest
from finite_bodies import FINITE, stack
from numpy.testing import assert_allclose
from scipy.interpolate import CubicSpline

from jkrcli.base.errors import Refusal
from jkrcli.bodies.indenters import Paraboloid, RoundedFlat, Sphere
from jkrcli.bodies.problem import (
    Coated,
    Elastic,
    Exponential,
    Graded,
    HalfSpace,
    Layer,
    Linear,
    Loading,
    Problem,
    Rigid,
    Specimen,
    TransverselyIsotropic,
    without_side_walls,
)
from jkrcli.fem.solver import FEM
from jkrcli.hybrid import correction
from jkrcli.hybrid.correction import Region
from jkrcli.hybrid.kernel import KernelLevels, count_for
from jkrcli.hybrid.solver import Hybrid
from jkrcli.methods.integral.fredholm import COLUMNS, rule
from jkrcli.methods.layered.solver import Layered
from jkrcli.methods.layered.spectrum import LayeredSpectrum
from jkrcli.resolve.analysis import profile_columns, solver_of
from jkrcli.series import Series, Solution

PARABOLOID = Paraboloid(1000.0)


WIDE = {  # body, largest contact radius
    "bonded, a/h = 1": (stack((1.0, 0.3, 1.0)), 1.0),
    "sliding": (stack((1.0, 0.3, 1.0), base=Rigid(False)), 2.0),
    "soft coating": (stack((1.0, 0.4, 1.0), base=HalfSpace(Elastic(10.0, 0.25))), 2.0),
    "stiff coating": (stack((1.0, 0.4, 1.0), base=HalfSpace(Elastic(0.1, 0.25))), 1.0),
    "1:10": (stack((1.0, 0.4, 1.0), (10.0, 0.3, 1.0)), 2.0),
    "nu = 0.499": (stack((1.0, 0.499, 1.0)), 5.0),
    "nu = 1/2 below": (stack((1.0, 0.3, 1.0), (2.0, 0.5, 1.0)), 2.0),
}


def solve(specimen: Specimen, a: float, tolerance: float, indenter: object = PARABOLOID) -> Solution:
    return Hybrid(tolerance)(Problem(indenter, specimen, Loading("radius", a, 20)))  # type: ignore[arg-type]


def exact(specimen: Specimen, a: float, indenter: object = PARABOLOID) -> Series:
    return Layered(1e-9)(Problem(indenter, specimen, Loading("radius", a, 20))).series  # type: ignore[arg-type]


def difference(series: Series, other: Series, names: tuple[str, ...] = COLUMNS) -> float:
    return max(float(np.abs(getattr(series, name) / getattr(other, name) - 1).max()) for name in names)


@pytest.mark.parametrize("name", ["soft coating", "nu = 0.499"])
def test_a_ten_thousandth_at_two_thousand_unknowns(name: str) -> None:
    specimen, a = WIDE[name]
    solution = solve(specimen, a, 1e-3)
    assert solution.facts["unknowns"] <= 2000
    # 1.02e-4 in S' of the soft coating by degree 6 however it is cut; all else 5e-5
    assert difference(solution.series, exact(specimen, a), ("P", "S", "dS")) < 1.1e-4


@pytest.mark.first(4)
@pytest.mark.parametrize("name", WIDE)
def test_wide_bodies_within_the_tolerance(name: str) -> None:
    specimen, a = WIDE[name]
    series = solve(specimen, a, 1e-4).series
    stated = max(float((series.errors[name] / getattr(series, name)).max()) for name in COLUMNS)
    assert difference(series, exact(specimen, a)) <= stated * 1.2 <= 1.2e-4  # an estimate, not a bound


def test_the_kernel_converges_exponentially_and_is_symmetric() -> None:
    specimen, a = WIDE["bonded, a/h = 1"]
    region = Region.of(specimen, a, 1e-10)
    levels = KernelLevels(region, count_for(region, 1e-9), 1.0)
    t = rule(2 * levels.count)[0][levels.count :]
    expected = LayeredSpectrum(specimen).kernel(2 * a).square(t * a) * a
    errors = [np.abs(levels.correction(p).K - expected).max() / np.abs(expected).max() for p in (4, 6, 8, 10)]
    assert (np.divide(errors[:-1], errors[1:]) > 5).all()
    assert errors[-1] < 1e-6
    assert levels.correction(10).asymmetry < 1e-7


def test_slabs_within_little_memory_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    body = stack((1.0, 0.4, 1.0), base=HalfSpace(Elastic(10.0, 0.25)))
    whole = solve(body, 1.0, 1e-3).series
    monkeypatch.setattr(correction, "AT_ONCE", 3000)
    assert difference(solve(body, 1.0, 1e-3).series, whole) < 1e-10


@pytest.mark.parametrize("indenter", [Sphere(3.0, Elastic(3.0, 0.3)), RoundedFlat(0.5, 9.0)])
def test_any_indenter(indenter: object) -> None:
    specimen = stack((1.0, 0.4, 1.0))
    solution = solve(specimen, 1.2, 1e-5, indenter)
    wanted = exact(specimen, 1.2, indenter)
    assert difference(solution.series, wanted) < 1e-5
    assert solution.series.S0 == pytest.approx(wanted.S0, rel=1e-5)


@pytest.mark.parametrize("loading", [Loading("depth", 0.05, 9, "depth"), Loading.given("load", (0.01, 0.1))])
def test_loadings_end_where_they_should(loading: Loading) -> None:
    series = Hybrid(1e-5)(Problem(Paraboloid(5.0), FINITE["free, tall"], loading)).series
    column = series.delta if loading.to == "depth" else series.P
    assert column[-1] == pytest.approx(loading.maximum, rel=1e-7)  # a hundredth of the tolerance
    if loading.spacing == "given":
        assert_allclose(column, loading.values, rtol=1e-7)


def test_graded_and_transversely_isotropic_layers_below_the_contact() -> None:
    top = Layer(Elastic(1.0, 0.3), 0.5)
    graded = Specimen((top, Layer(Graded(Linear(1.0, 5.0, 1.0), 0.4), 1.0)), Rigid())
    solution = solve(graded, 1.0, 1e-5)
    wanted = Layered(1e-5)(Problem(PARABOLOID, graded, Loading("radius", 1.0, 20))).series
    assert difference(solution.series, wanted) < 2e-5  # what both state
    isotropic = TransverselyIsotropic(2.0, 2.0, 0.25, 0.25, 0.8)
    same = Specimen((top, Layer(isotropic, 1.0)), Rigid())
    plain = Specimen((top, Layer(Elastic(2.0, 0.25), 1.0)), Rigid())
    assert difference(solve(same, 1.0, 1e-4).series, solve(plain, 1.0, 1e-4).series) < 1e-9  # the same matrices


def test_a_load_beyond_the_side_is_refused() -> None:
    problem = Problem(PARABOLOID, FINITE["free"], Loading("load", 1.0))
    with pytest.raises(Refusal, match="before a load of 1 N the contact comes too near to the side"):
        Hybrid(1e-3)(problem)


CORE, SKIN, GEL = Elastic(3e6, 0.4), Elastic(3e5, 0.4), Elastic(1e6, 0.45)
NARROW = Specimen((Layer(GEL, 3e-3),), Rigid(), radius=8e-3, side="free")
COLUMNS = ("delta", "P", "S", "dS")


def solved(material: object, specimen: Specimen = NARROW) -> object:
    return Hybrid()(Problem(Sphere(1e-2, material), specimen, Loading("radius", 1e-3, 20)))


def test_a_coating_of_the_core_is_no_coating() -> None:
    coated, plain = solved(Coated((Layer(CORE, 1e-4),), CORE)).series, solved(CORE).series
    for name in COLUMNS:
        one, other = getattr(coated, name), getattr(plain, name)
        assert one == pytest.approx(other, rel=1e-5)
        assert (abs(one - other) <= coated.errors[name] + plain.errors[name]).all()


def test_a_wide_cylinder_is_the_layer_without_sides_and_a_narrow_one_is_not() -> None:
    coated = Coated((Layer(SKIN, 1e-4),), CORE)
    wide, narrow = (solved(coated, replace(NARROW, radius=radius)) for radius in (3e-2, 5e-3))
    exact = Layered()(without_side_walls(wide.problem)).series
    for name in COLUMNS:
        off = abs(getattr(wide.series, name) - getattr(exact, name))
        assert (off <= wide.series.errors[name] + 1e-6 * getattr(exact, name)).all()
    assert abs(narrow.series.S[-1] / exact.S[-1] - 1) > 1e-4


def test_without_sides_and_for_profiles_it_is_refused() -> None:
    solution = solved(Coated((Layer(SKIN, 1e-4),), CORE))
    assert solver_of(solution) is not None
    with pytest.raises(Refusal, match="how a coated indenter and the specimen share the displacement is not derived"):
        profile_columns(solution, 5e-4, 0.05, None)
    assert "use method layered" in str(Hybrid().refusal(without_side_walls(solution.problem)))


GRADED = Specimen((Layer(Graded(Exponential(3.0, 1.0, 1.0), 0.4), 1.0),), Rigid(), 1.3, "clamped")
ROLLER = Specimen((Layer(Elastic(1.0, 0.3), 1.0),), Rigid(False), 30.0, "roller")


def at_depths(depths: np.ndarray, found: np.ndarray, delta: np.ndarray) -> np.ndarray:
    """A column at other depths: a cubic in logarithms through 80 points, good to 1e-7."""
    return np.exp(CubicSpline(np.log(delta), np.log(found))(np.log(depths)))


@pytest.mark.slow
@pytest.mark.parametrize("specimen", [*FINITE.values(), GRADED, ROLLER], ids=[*FINITE, "graded", "wide roller"])
def test_agreement_within_the_stated_errors(specimen: Specimen) -> None:
    """Loads and radii at equal depth, from a fifth of the largest radius on, where the finite elements are judged."""
    problem = Problem(Paraboloid(1000.0), specimen, Loading("radius", 0.9, 80))
    nodal, smooth = FEM()(problem), Hybrid(2e-5)(problem)
    both, a = nodal.series, smooth.series
    judged = (both.a > 0.2) & (both.delta < a.delta[-1])
    P, radius = (at_depths(both.delta[judged], column, a.delta) for column in (a.P, a.a))
    budget = nodal.budget
    own = smooth.budget.total
    assert np.abs(both.P[judged] / P - 1).max() < budget.discretisation + own
    assert np.abs(both.a[judged] / radius - 1).max() < budget.radius + own

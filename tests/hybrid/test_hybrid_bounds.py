"""Bodies on which two degrees agree by accident, or the cut is extrapolated in vain: the stated errors hold them."""

from dataclasses import replace

import numpy as np
import pytest
from stated_errors import stationary

from jkrcli.base.errors import Refusal
from jkrcli.bodies.indenters import Paraboloid, PowerLaw
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.hybrid.kernel import HYBRID_NO_CLAIM, AdaptiveKernel, _falls
from jkrcli.hybrid.solver import Hybrid
from jkrcli.methods.layered.solver import Layered
from jkrcli.methods.protocol import Method
from jkrcli.report.tables import is_refined
from jkrcli.resolve.analysis import analyse

COLUMNS = ("delta", "P", "S", "dS")
STACK = Specimen(
    (
        Layer(Elastic(143800.67, 0.5), 9.4687),
        Layer(Elastic(239.507, 0.3316), 2.972),
        Layer(Elastic(2838.711, 0.00876), 7.7812),
    ),
    Rigid(bonded=False),
)
ON_ITS_BASE = Specimen((Layer(Elastic(24416.76, 0.5), 2.993e-3),), HalfSpace(Elastic(1.544e10, 0.0166)))
SUBSTRATE_AT_A_HALF = Specimen(
    (Layer(Elastic(1911.0, 0.4738), 0.24597), Layer(Elastic(1171.0, 0.3267), 0.027916)),
    HalfSpace(Elastic(989.3, 0.499964)),
)
ROLLERS = Specimen(
    (
        Layer(Elastic(13676233938.0, 0.3279106544), 72.32306554),
        Layer(Elastic(304967330.86, 0.40997468965), 451.732026),
        Layer(Elastic(37808724.83, 0.14497936580), 351.650119),
    ),
    Rigid(),
    21.042172469,
    "roller",
)
THICK = Specimen((Layer(Elastic(1e6, 0.4), 1e-3),), Rigid())
AUXETIC_PLATE = Specimen(
    (
        Layer(Elastic(4325101526.7, -0.33123545770876833), 1.4733521060858853e-08),
        Layer(Elastic(370386.59275553667, 0.49991082142157056), 5.5270306491772145e-08),
    ),
    Rigid(),
)
SQUEEZED = Specimen((Layer(Elastic(1e6, 0.5), 1.0),), Rigid())
BODIES = {
    # 7e-5 and 9e-5 off in S and S' where 1.7e-6 and 3.4e-6 were stated: degrees 4 and 6 err alike
    "three layers": Problem(Paraboloid(10.0), STACK, Loading.given("radius", (0.36, 0.72))),
    # S 1.5e-6 and S' 3.1e-6 off where 4.3e-7 and 8.7e-7 were stated: three intervals along r, longer than they should
    # be, where degrees 4, 6 and 8 err by 8e-3, -7e-6 and 4e-5 of K
    "a thick layer": Problem(Paraboloid(1.0), THICK, Loading.given("radius", (1e-5, 2e-5, 3.6e-5))),
    # 2e-5 off where 5e-6 was stated: the plate's field goes on for tens of thicknesses, over which intervals grew, and
    # degree 8 erred no less than 6
    "a plate much stiffer than its layer": Problem(
        Paraboloid(1e-6), AUXETIC_PLATE, Loading.given("radius", (4e-9, 1.2e-8, 2.5e-8, 4.0554e-8))
    ),
    # S 1.4e-7 off where 5e-8 was stated: below the least radius that was looked at, and where the last polynomial has
    # a node by accident
    "first rows of a squeezed layer": Problem(
        Paraboloid(1000.0), SQUEEZED, Loading.given("radius", tuple(np.linspace(0.125, 5.0, 40).tolist()))
    ),
    # 2.9e-6 off in S' where 1.4e-6 was stated: the order that extrapolation takes for granted is none here
    "half-space at 1/2": Problem(PowerLaw(0.05, 2.0), SUBSTRATE_AT_A_HALF, Loading.given("radius", (0.3, 1.0))),
}


def ratios(problem: Problem, exact: Method, method: Method = Hybrid()) -> dict[str, float]:  # noqa: B008
    found, truth = method(problem).series, exact(problem).series
    return {
        name: float(np.max(np.abs(getattr(found, name) - getattr(truth, name)) / found.errors[name]))
        for name in COLUMNS
    }


@pytest.mark.parametrize("name", BODIES)
def test_the_stated_errors_hold(name: str) -> None:
    assert max(ratios(BODIES[name], Layered(1e-10)).values()) <= 1.0


def test_errors_fall_less_at_half_of_the_radius_than_at_the_largest() -> None:
    """Of P, with the rounding of a slender rod: thousands of times as soft as the contact."""
    d, a = 1.5944587619, 13.239209946
    radii = tuple(np.linspace(0.5, 1, 11) * a)
    problem = Problem(PowerLaw(0.1 * a ** (1 - d) / d, d), ROLLERS, Loading.given("radius", radii))
    assert max(ratios(problem, Hybrid(1e-7), Hybrid(1e-5)).values()) <= 1.0


def test_an_error_that_falls_slowly_at_small_radii_is_not_stated_by_the_largest() -> None:
    """A step divided the change by 5 at the small radius, by 101 at the large one: 4 and 100 of the error are left;
    one that falls faster at the small radius counts as at the large one."""
    slow_first = _falls(np.full((4, 2), [[5.0, 101.0]]), np.ones((4, 2)), 1e3)
    assert slow_first == pytest.approx([4.0, 100.0])
    fast_first = _falls(np.full((4, 2), [[50.0, 50.0]]), np.full((4, 2), [[0.1, 1.0]]), 1e3)
    assert fast_first == pytest.approx([49.0, 49.0])


def test_points_where_two_degrees_agree_by_accident_have_an_error() -> None:
    """With the lower degree in place of its finer one the last step shows nothing; the step before it does."""
    cylinder = Specimen((Layer(Elastic(7.6e7, 0.3), 3.48),), Rigid(), 3.0, "free")
    _, errors, _, _ = AdaptiveKernel(Paraboloid(18.0), cylinder, 1e-5).accurate(0.8)
    modes = errors.companions
    blind = replace(modes, kernels=(modes.contact.kernel, *modes.kernels[1:]))
    last, before, *_ = np.abs(blind(np.array([0.3, 0.6])))
    assert last.max() == 0
    assert (before > 0).all()


def test_rounding_in_a_slender_rod_is_far_below_the_kernel() -> None:
    levels = AdaptiveKernel(Paraboloid(1e3), ROLLERS, 1e-5).levels(13.2)
    high, higher = levels.correction(14), levels.correction(16)
    assert np.abs(high.K - higher.K).max() < 1e-12 * np.abs(higher.K).max()
    assert higher.rounding.max() < 1e-12 * np.abs(higher.K).max()


@pytest.mark.slow  # degree 14 on 53,000 unknowns
def test_a_soft_incompressible_layer_on_a_rock() -> None:
    """S 3.8e-5 and S' 6.9e-5 off, 5.7e-6 stated: now that tolerance is refused, with one that is met."""
    d, a = 5.0044, 19.7e-3
    problem = Problem(PowerLaw(0.1 * a ** (1 - d) / d, d), ON_ITS_BASE, Loading.given("radius", (4.63e-3, a)))
    with pytest.raises(Refusal, match=r"above the tolerance 1\.0e-05; set hybrid\.tolerance to"):
        Hybrid()(problem)


def test_a_small_contact_on_a_tall_cylinder() -> None:
    """One element of degree 4 is right by accident there: S was 1.6e-5 off at degree 6, 1.7e-6 stated."""
    cylinder = Specimen((Layer(Elastic(7.6e7, -0.206), 3.48),), Rigid(bonded=False), 1.0, "free")
    series = (Hybrid()(Problem(Paraboloid(18.0), cylinder, Loading.given("radius", radii))).series
              for radii in ((0.00545,), (0.00545, 0.45)))  # fmt: skip
    small, large = (one for one in series)
    for name in ("delta", "P", "S", "dS"):
        error = abs(getattr(small, name)[0] - getattr(large, name)[0])
        assert error <= small.errors[name][0] + large.errors[name][0]


def test_a_column_that_hardly_changes_tells_nothing_of_the_rest() -> None:
    """S' at small radii was stated by what degree 2 errs by, 344 times what it is, as P there falls by little."""
    specimen = Specimen((Layer(Elastic(1.0, 0.0), 1.0), Layer(Elastic(2.0, 0.5), 1.0)), Rigid())
    problem = Problem(Paraboloid(1e3), specimen, Loading("radius", 1.0, 20))
    found, truth = Hybrid(1e-4)(problem).series, Layered(1e-9)(problem).series
    least = HYBRID_NO_CLAIM * 1e-4  # below it nothing is told apart
    for name in COLUMNS:
        true = float(np.max(np.abs(getattr(found, name) / getattr(truth, name) - 1)))
        assert true <= float(np.max(found.errors[name] / getattr(found, name))) <= 20 * max(true, least)


def test_a_row_beside_a_solved_radius_does_not_disturb_it() -> None:
    """Between a row at 0.525 of the largest radius and one solved at 0.5252 the slope was that of their errors."""
    body = Specimen((Layer(Elastic(10.237e9, 0.2434), 1.46527e-3), Layer(Elastic(8.654e9, -0.2635), 1.555217e-3)),
                    Rigid(bonded=False))  # fmt: skip
    problem = Problem(PowerLaw(0.134605, 1.3366042), body, Loading("radius", 5.183125e-4, 40))
    result = analyse(Hybrid()(problem), [80.35715])[0]
    point, stated = result.pull_off["load"], result.pull_off_errors["load"]
    assert abs(point.P - stationary(problem, result.w, point.a, "load")[0]) <= stated["P"]


THREE_LAYERS = Problem(
    Paraboloid(8.18295e-05),
    Specimen((
        Layer(Elastic(483853044.4, 0.49676930166), 8.45955442e-06),
        Layer(Elastic(18047114.63, -0.121198479), 1.24901555e-05),
        Layer(Elastic(43616590.53, 0.104109833), 4.95907157e-06),
    ), Rigid()),
    Loading("radius", 2.32607519e-05, 29, "depth"),
)  # fmt: skip


def test_short_waves_of_a_kernel_of_polynomials_count_for_the_place() -> None:
    """S'' was 1.5e-5 off at the end of the kernel's reach, 4.8e-6 stated, where S' was right to 9e-7."""
    problem = THREE_LAYERS
    result = analyse(Hybrid()(problem), [28.0806614])[0]
    point, stated = result.pull_off["load"], result.pull_off_errors["load"]
    P, delta = stationary(problem, result.w, point.a, "load", Layered(1e-11))
    assert abs(point.P - P) <= stated["P"]
    assert abs(point.delta - delta) <= stated["delta"] < 1e-4 * abs(delta)


@pytest.mark.slow
def test_points_are_solved_where_that_takes_seconds() -> None:
    sliding = Specimen((Layer(Elastic(2.36e9, 0.5), 2.3e-6),), Rigid(bonded=False))
    problem = Problem(PowerLaw(0.231, 1.0), sliding, Loading("radius", 3e-5, 60))
    result, true = (analyse(method(problem), [1039.0])[0] for method in (Hybrid(), Layered()))
    for control, point in result.pull_off.items():
        exact, stated = true.pull_off[control], result.pull_off_errors[control]
        assert is_refined(result.curve, point)
        held, other = ("P", "delta") if control == "load" else ("delta", "P")
        errors = {name: abs(getattr(point, name) - getattr(exact, name)) for name in stated}
        assert errors[held] <= stated[held] < 1e-3 * abs(getattr(exact, held))
        assert errors[other] <= 2 * stated[other] < 2e-3 * abs(getattr(exact, other))  # measured 1.39

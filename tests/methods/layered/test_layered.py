"""The exact layer solution against published and independent values, exact limits, units, and its own estimate."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from jkrcli.base.errors import InputError, JkrError, Refusal, SolveError
from jkrcli.bodies.indenters import Paraboloid, PowerLaw, RoundedFlat, Sphere, TableProfile
from jkrcli.bodies.problem import (
    Elastic,
    HalfSpace,
    Layer,
    Loading,
    Problem,
    Rigid,
    Specimen,
    without_side_walls,
)
from jkrcli.methods.integral.fredholm import EquationResult, Quadrature
from jkrcli.methods.layered.contact import LayeredContact, _errors
from jkrcli.methods.layered.solver import Layered, largest_radius
from jkrcli.series import Solution

SHAPES = [
    Sphere(3.0), Paraboloid(20.0), PowerLaw(0.1, 1.0), PowerLaw(0.05, 1.5), PowerLaw(0.01, 4.0),
    RoundedFlat(0.5, 9.0),
]  # fmt: skip


def bonded(nu: float, h: float = 1.0, E: float = 1.0) -> Specimen:
    return Specimen((Layer(Elastic(E, nu), h),), Rigid())


def at(specimen: Specimen, indenter: object, *radii: float) -> Solution:
    return Layered()(Problem(indenter, specimen, Loading.given("radius", radii)))  # type: ignore[arg-type]


def columns(solution: Solution) -> np.ndarray:
    series = solution.series
    return np.array([series.delta, series.P, series.S, series.dS])


# Bonded layer h = 1, E = 1, paraboloid R = 1000: nu, a, delta_H, P_H, S, S'. An independent derivation and code agree
# with these to 4e-9, and to 1e-8 in the row nu = 0.499, a = 17.
BONDED = [
    (0.3, 1, 6.47622320e-4, 1.84464242e-3, 5.45829589, 9.44605887),
    (0.3, 10, 5.12936590e-2, 11.1026348, 433.311411, 85.6121336),
    (0.4, 5, 1.25071576e-2, 0.985685421, 161.406225, 65.6992864),
    (0.4, 17, 1.43251446e-1, 137.017051, 1920.29771, 227.381428),
    (0.499, 5, 9.07657701e-3, 2.17599480, 642.010619, 396.169639),
    (0.499, 17, 8.99039295e-2, 1145.31347, 34080.9813, 6469.41500),
    (0.5, 10, 3.12260204e-2, 73.0846865, 6743.95044, 2361.15699),
]


@pytest.mark.parametrize(("nu", "a", "delta", "P", "S", "dS"), BONDED)
def test_bonded_layer(nu: float, a: float, delta: float, P: float, S: float, dS: float) -> None:
    found = columns(at(bonded(nu), Paraboloid(1000.0), a))[:, 0]
    assert found == pytest.approx([delta, P, S, dS], rel=1.2e-8)  # nine digits, and the note above


def test_coated_half_space() -> None:
    specimen = Specimen((Layer(Elastic(1.0, 0.4), 1.0),), HalfSpace(Elastic(10.0, 0.25)))
    found = columns(at(specimen, Paraboloid(10.0), 1.0))[:, 0]
    assert found == pytest.approx([0.06695912, 0.20065158, 5.57071289, 9.04575131], rel=1e-7)  # seven digits


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_frictionless_base_is_the_same_for_any_poisson_ratio(nu: float) -> None:
    specimen = Specimen((Layer(Elastic(1.0, nu), 1.0),), Rigid(bonded=False))
    a = np.array([0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0])
    factor = at(specimen, Paraboloid(1000.0), *a).series.S / (2 * specimen.surface.E_star * a)
    expected = [1.07991, 1.17103, 1.50609, 2.19862, 3.72761, 8.42109, 16.2696]
    assert factor == pytest.approx(expected, rel=3.1e-6)  # half a unit of the last of six digits


@pytest.mark.parametrize(("indenter", "force"), [(Paraboloid(6e-3), -1.4887e-3), (Sphere(6e-3), -1.4833e-3)])
def test_pull_off_of_the_gel(indenter: Paraboloid | Sphere, force: float) -> None:
    """Gel of Jiang et al. Sec. 4.3, laterally unbounded, w = 40 mJ/m2, by Eq. 13 with the exact S and S'."""
    a = np.linspace(0.4e-3, 0.7e-3, 601)
    series = at(bonded(0.499, 0.36e-3, 15e3), indenter, *a).series
    P = series.P - series.S * np.sqrt(4 * np.pi * 0.04 * a / series.dS)
    assert P.min() == pytest.approx(force, abs=5e-8)  # five digits; the grid leaves 1e-11 N


@pytest.mark.parametrize("indenter", SHAPES)
def test_half_space(indenter: object) -> None:
    material, a = Elastic(2.0, 0.3), np.linspace(0.6, 2.0, 8)
    series = at(Specimen((), HalfSpace(material)), indenter, *a).series
    delta, P = indenter.half_space(a, material.E_star)  # type: ignore[arg-type, misc]
    assert series.delta == pytest.approx(delta, rel=1e-13)
    assert_allclose(series.P, P, rtol=1e-12)  # means of F over panels, in rounding
    assert_allclose(series.S, 2 * material.E_star * a, rtol=1e-13)
    assert series.dS == pytest.approx(2 * material.E_star + 0 * a, rel=1e-13)
    assert series.a0 == indenter.a0  # type: ignore[attr-defined]
    assert_allclose(series.S0, 2 * material.E_star * indenter.a0, rtol=1e-13)  # type: ignore[attr-defined]


@pytest.mark.parametrize("indenter", [PowerLaw(0.05, 1.0), RoundedFlat(0.5, 30.0)])
@pytest.mark.parametrize(
    "specimen", [bonded(0.5), Specimen((Layer(Elastic(1e3, 0.3), 1.0),), HalfSpace(Elastic(1.0, 0.5)))]
)
def test_loading_reaches_what_it_asks_for(indenter: object, specimen: Specimen) -> None:
    def solve(loading: Loading) -> Solution:
        return Layered()(Problem(indenter, specimen, loading))  # type: ignore[arg-type]

    series = solve(Loading("depth", 0.2, 20)).series
    assert series.delta[-1] == pytest.approx(0.2, rel=1e-8)
    a0 = indenter.a0  # type: ignore[attr-defined]
    assert series.a == pytest.approx(np.linspace(a0, series.a[-1], 21)[1:], rel=1e-13)
    load = float(series.P[-1])
    again = solve(Loading("load", load, 20, "depth")).series
    assert again.delta == pytest.approx(0.2 * np.arange(1, 21) / 20, rel=1e-8)
    assert again.P[-1] == pytest.approx(load, rel=1e-8)
    values = (1e-3 * load, 0.1 * load, load)
    assert_allclose(solve(Loading.given("load", values)).series.P, values, rtol=1e-8)
    assert solve(Loading("depth", 0.2, 1)).series.a == pytest.approx(series.a[-1:], rel=1e-9)


KINKED = TableProfile((0.0, 0.0158, 0.0176, 0.0233, 0.0678), (0.0, 0.000198, 0.000306, 0.00103, 0.00826))
SHARPER = TableProfile((0.0, 0.0265, 0.03165, 0.04129), (0.0, 0.000116, 0.00208, 0.005774))


@pytest.mark.parametrize(
    ("indenter", "loading"),
    [
        (KINKED, Loading("depth", 0.0104, 20, "depth")),
        (KINKED, Loading.given("depth", (1e-5, 1e-4, 2e-4, 3e-4, 1e-3, 2e-3, 5e-3, 0.0104))),
        (KINKED, Loading.given("load", (1e-3, 0.1, 1.0, 3.0, 5.0, 10.0, 30.0, 100.0))),
        (SHARPER, Loading.given("depth", tuple(np.geomspace(1.09e-6, 0.0109, 20)))),  # tangents out of order at first
    ],
    ids=["depth", "depths", "loads", "sharper"],
)
def test_targets_are_met_where_the_slope_of_a_profile_changes_at_once(indenter: TableProfile, loading: Loading) -> None:
    """Plain Newton steps over all targets cycle at its kinks. On a half-space F(a) is the depth."""
    series = Layered()(Problem(indenter, Specimen((), HalfSpace(Elastic(1e6, 0.3))), loading)).series
    values = loading.values or tuple(0.0104 * np.arange(1, 21) / 20)
    found = series.P if loading.to == "load" else series.delta  # with rows at the kinks where none were given
    nearest = found[np.abs(found[:, None] / values - 1).argmin(axis=0)]
    assert nearest == pytest.approx(values, rel=1e-9)
    assert indenter.abel(series.a) == pytest.approx(series.delta, rel=1e-12)


def test_largest_radius_ignores_the_sides() -> None:
    loading = Loading("depth", 0.01)
    free = Specimen(bonded(0.4).layers, Rigid(), radius=30.0, side="free")
    wanted = largest_radius(Problem(Paraboloid(1000.0), bonded(0.4), loading))
    assert largest_radius(Problem(Paraboloid(1000.0), free, loading)) == wanted
    assert Layered().refusal(without_side_walls(Problem(Paraboloid(1000.0), free, loading))) is None


@pytest.mark.parametrize(("loading", "rel"), [(Loading("depth", 1e-7, 3), 1e-9), (Loading("depth", 1e-6, 3), 2e-3)])
def test_flat_ends_wider_than_the_search_takes_a_round_contact(loading: Loading, rel: float) -> None:
    """A radius beyond the search's own is extrapolated by that beyond the flat end, not scaled back to below it."""
    problem = Problem(RoundedFlat(2e-5, 5e-5), Specimen((Layer(Elastic(1e6, 0.3), 1e-6),), Rigid()), loading)
    reached = Layered()(problem).series.a[-1]
    assert largest_radius(problem) == pytest.approx(reached, rel=rel)


def test_a_contact_within_the_flat_end_or_a_load_beyond_the_profile_is_refused() -> None:
    with pytest.raises(InputError, match="flat end of the indenter"):
        at(bonded(0.4), RoundedFlat(2.0, 5.0), 1.0)
    table, load = TableProfile((0.0, 1.0, 2.0), (0.0, 0.1, 0.4)), Loading("load", 1e3, spacing="depth")
    with pytest.raises(InputError, match="give a larger profile"):
        Layered()(Problem(table, bonded(0.4), load))


@pytest.mark.parametrize("points", [100, 1600])
def test_nodes_do_not_follow_the_points(points: int) -> None:
    problem = Problem(Paraboloid(1000.0), bonded(0.4), Loading("radius", 16.0, points))
    found = Layered()(problem)
    assert found.facts["nodes"] <= 250
    assert Layered().forecast(problem).note.startswith(f"{found.facts['nodes']} nodes")
    some = np.arange(points // 7, points, points // 7)
    alone = Layered()(replace(problem, loading=Loading.given("radius", tuple(found.series.a[some].tolist()))))
    for name in ("delta", "P", "S", "dS"):
        difference = np.abs(getattr(found.series, name)[some] - getattr(alone.series, name))
        assert (difference <= found.series.errors[name][some] + alone.series.errors[name]).all()


def test_a_second_quadrature_that_is_only_a_quarter_better_is_covered() -> None:
    """Errors of 1e-6 and 0.75e-6 differ by a quarter of the larger."""
    solved = LayeredContact(PowerLaw(0.01, 1.5), bonded(0.45)).refined(np.linspace(0.2, 1, 5), 1e-8)[0]
    main, other = (
        replace(solved, **{name: getattr(solved, name) * (1 + error) for name in ("delta", "P", "S", "dS")})
        for error in (1e-6, 0.75e-6)
    )
    assert (_errors(main, other, np.arange(5)) >= (1 - 1e-5) * 1e-6).all()


layers = st.builds(
    Layer,
    st.builds(
        Elastic, st.floats(-2, 2).map(lambda x: 10**x), st.sampled_from([-0.5, 0.0, 0.3, 0.45, 0.499, 0.4999, 0.5])
    ),
    st.floats(-1, 1).map(lambda x: 10**x),
)
bases = st.one_of(
    st.sampled_from([Rigid(), Rigid(bonded=False)]),
    st.builds(HalfSpace, st.builds(Elastic, st.floats(-2, 2).map(lambda x: 10**x), st.sampled_from([0.3, 0.5]))),
)
stacks = st.builds(Specimen, st.lists(layers, min_size=1, max_size=6).map(tuple), bases)


def estimate_bounds_the_error(specimen: Specimen, log_a: float, points: int, d: float) -> None:
    """Against twice the nodes per panel and twice the nodes in k; moduli differ by up to 1e4 from layer to layer."""
    a = specimen.top_thickness * 10**log_a
    contact = LayeredContact(PowerLaw(0.1 * a ** (1 - d), d), specimen)
    radii = np.linspace(0, a, points + 1)[1:]
    try:
        found, errors = contact.refined(radii, 1e-8)
    except JkrError:
        return
    assert errors.max() <= 1e-8
    plan = contact.plan(radii, 1e-8)
    exact = replace(contact, order=48).solved(radii, Quadrature(2 * found.panels.order, plan.widest, 0, inner=40))
    for name, stated in zip(("delta", "P", "S", "dS"), errors, strict=True):
        true = np.abs(getattr(found, name) / getattr(exact, name) - 1)
        assert (true <= stated).all(), f"{name}: {np.max(true / stated):.3g} times the estimate"


draw = given(
    stacks, st.floats(-3, np.log10(50)), st.sampled_from([1, 3, 20, 100]), st.sampled_from([1.0, 1.5, 2.0, 4.0])
)
quiet = (HealthCheck.too_slow, HealthCheck.data_too_large)
test_estimate_bounds_the_error = settings(max_examples=25, deadline=None, suppress_health_check=quiet)(
    draw(estimate_bounds_the_error)
)


@pytest.mark.parametrize("log_a", [1.34, 1.34375])
def test_estimate_bounds_the_error_where_differences_cross_zero(log_a: float) -> None:
    """Found by drawing: the load of the third of 100 radii, 1e-10 of itself off, was 1.7 times its estimate off."""
    estimate_bounds_the_error(Specimen((Layer(Elastic(1.0, -0.5), 1.0),), Rigid()), log_a, 100, 4.0)


def test_rounding_is_no_error_where_the_check_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    solved = LayeredContact.solved

    def failing(contact: LayeredContact, radii: np.ndarray, plan: Quadrature) -> EquationResult:
        if contact.order != 24:
            raise SolveError("the check fails")
        return solved(contact, radii, plan)

    monkeypatch.setattr(LayeredContact, "solved", failing)
    with pytest.raises(Refusal) as caught:
        at(bonded(0.5), Paraboloid(1000.0), 1.0)
    assert "do not resolve the kernel, the error is not known; use more points" in str(caught.value)

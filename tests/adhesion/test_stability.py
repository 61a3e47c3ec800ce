"""Pull-off, stability and energies under every control, against closed forms and exact slopes."""

import math
from dataclasses import fields
from functools import cache

import numpy as np
import pytest
from conftest import refused_by
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import cumulative_simpson, quad
from scipy.optimize import brentq

from jkrcli.adhesion.curve import NO_ADHESION, AdhesiveCurve, CriticalPoint, Nonadhesive, position, transform
from jkrcli.adhesion.device_path import (
    GRIPPED,
    STABLE,
    UNSTABLE,
    QuasiStatic,
    Stability,
    behaviours,
    branch,
    cycle,
    grow,
    largest_stable,
    shrink,
    stability_under,
)
from jkrcli.adhesion.slopes import Slopes, slopes
from jkrcli.adhesion.work_of_pull_off import work_from_pull_off
from jkrcli.base.errors import Unknown
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.formulas import hertz, scales_half_space, thin_incompressible_layer, thin_layer
from jkrcli.methods.layered.solver import Layered
from jkrcli.series import Series

E_STAR, R, W = 5e9 / 0.84, 1e-4, 50.0
P0, DELTA0, A0 = scales_half_space(R, E_STAR, W)
RIGID = math.inf


def half_space(points: int = 60, largest: float = 1.73e-5) -> Series:
    a = np.linspace(0, largest, points + 1)[1:]
    delta, P = hertz(a, E_STAR, R)
    return Series(a, delta, P, 2 * E_STAR * a, np.full(points, 2 * E_STAR))


def curve(series: Series, w: float = W) -> AdhesiveCurve:
    return transform(series, slopes(series), w)


@cache
def classical() -> AdhesiveCurve:
    return curve(half_space())


@cache
def stiff_coating(w: float) -> AdhesiveCurve:
    """A coating a hundred times stiffer than what it lies on: S' falls before it rises."""
    specimen = Specimen((Layer(Elastic(1e8, 0.4), 1e-6),), HalfSpace(Elastic(1e6, 0.4)))
    radii = tuple(np.geomspace(3e-8, 1.5e-5, 90))
    series = Layered(1e-7)(Problem(Paraboloid(1e-3), specimen, Loading.given("radius", radii))).series
    return curve(series, w)


def units(point) -> tuple[float, float, float]:
    """delta, P and a cubed in the units of Eq. 15."""
    return point.delta / DELTA0, point.P / P0, (point.a / A0) ** 3


# Eq. 18: P = a^3 - sqrt(6 a^3), delta = a^2 - (2/3) sqrt(6 a).
def bar(a: float) -> tuple[float, float]:
    return a**2 - 2 / 3 * math.sqrt(6 * a), a**3 - math.sqrt(6 * a**3)


PUBLISHED = [
    ("pull_off", 0.0, 1.5),  # P = -3/2
    ("pull_off", RIGID, 1 / 6),  # P = -5/6
    ("jump_in", 0.0, 6.0),  # P = 0
    ("jump_in", RIGID, 8 / 3),  # delta = 0, P = -4/3
]


@pytest.mark.parametrize(("what", "stiffness", "cube"), PUBLISHED)
def test_critical_values_of_the_paraboloid_on_a_half_space(what: str, stiffness: float, cube: float):
    found = stability_under(classical(), stiffness)
    delta, P = bar(cube ** (1 / 3))
    assert units(getattr(found, what)) == pytest.approx((delta, P, cube), rel=1e-6, abs=1e-6)  # 1e-6 of the unit


@pytest.mark.parametrize("stiffness", [2e4, 1e6])
def test_a_device_of_given_stiffness_against_the_closed_form(stiffness: float) -> None:
    """d(delta + P/k)/da = 0 with the derivatives of Eq. 18 written out, bracketed by the two pure controls."""
    soft = P0 / (stiffness * DELTA0)

    def rate(a: float) -> float:
        return 2 * a - math.sqrt(6 / a) / 3 + soft * (3 * a**2 - 1.5 * math.sqrt(6 * a))

    a = brentq(rate, (1 / 6) ** (1 / 3), 1.5 ** (1 / 3), xtol=1e-15)
    delta, P = bar(a)
    found = stability_under(classical(), stiffness)
    assert found.critical == (found.pull_off,)
    assert units(found.pull_off) == pytest.approx((delta, P, a**3), rel=1e-9)  # round-off of roots
    begin = found.jump_in
    assert position(begin.delta, begin.P, stiffness) == pytest.approx(0, abs=1e-12 * DELTA0)
    assert bar(begin.a / A0) == pytest.approx((begin.delta / DELTA0, begin.P / P0), rel=1e-9)


def test_what_many_devices_do_together_is_what_each_does_alone() -> None:
    devices = [0.0, *np.geomspace(1e3, 1e8, 6), RIGID]
    one = curve(half_space())
    alone = [stability_under(one, stiffness) for stiffness in devices]
    names = [field.name for field in fields(alone[0]) if field.name not in ("whole", "retraction")]  # paths

    def values(found: list[Stability]) -> list[list[object]]:
        return [[getattr(each, name) for name in names] for each in found]

    assert values(behaviours(curve(half_space()), devices)) == values(alone)


def test_energy_lost_per_cycle_is_the_published_one() -> None:
    """7.09 (w^5 R^4/E*^2)^(1/3): Thornton and Ning, Powder Technol. 99 (1998) 154, from delta = 0 to separation."""
    found = stability_under(classical(), RIGID)
    assert found.energy_lost / (W**5 * R**4 / E_STAR**2) ** (1 / 3) == pytest.approx(7.09, abs=0.005)  # as printed


@pytest.mark.parametrize("stiffness", [1e4, 1e5, RIGID])
def test_energies_equal_the_area_by_an_independent_quadrature(stiffness: float) -> None:
    """Adaptive quadrature of Eq. 18 between the radii of its own critical points, jumps included as straight lines."""
    found = stability_under(classical(), stiffness)
    off, begin, rest = found.pull_off.a / A0, found.jump_in.a / A0, 6 ** (1 / 3)

    def power(a: float) -> float:
        return bar(a)[1] * (2 * a - math.sqrt(6 / a) / 3)  # P d(delta)/da

    def area(first: float, last: float) -> float:
        along = quad(power, first, last, epsabs=0, epsrel=1e-12)[0] * P0 * DELTA0
        return along + (bar(last)[1] ** 2 - bar(first)[1] ** 2) * P0**2 / (2 * stiffness)

    assert found.energy_lost == pytest.approx(area(begin, off), rel=1e-9)
    assert found.separation == pytest.approx(area(rest, off), rel=1e-9)


@pytest.mark.parametrize(("law", "factor"), [("compressible", -2.0), ("incompressible", -3.0)])
def test_thin_limits(law: str, factor: float) -> None:
    found = stability_under(thin(law), 0.0)
    assert found.pull_off.P / (math.pi * thin(law).w * R) == pytest.approx(factor, rel=1e-9)  # power laws: round-off


def thin(law: str) -> AdhesiveCurve:
    a = np.linspace(0, 1.7e-5, 61)[1:]
    if law == "compressible":
        columns, S = thin_layer(a, 1e16, R), math.pi * 1e16 * a**2
        series = Series(a, *columns, S, 2 * S / a)
    else:
        columns, S = thin_incompressible_layer(a, 1e6, 1e-8, R), 3 * math.pi * 1e6 / (8 * 1e-24) * a**4
        series = Series(a, *columns, S, 4 * S / a)
    return curve(series, series.P[-1] / R / 40)


def test_a_thin_compressible_layer_is_not_lost_under_displacement_control() -> None:
    found = stability_under(thin("compressible"), RIGID)
    assert found.critical == ()
    assert isinstance(found.pull_off, Unknown)
    assert "the displacement is lowest at the smallest radius of the solution, a = 283.3 nm" in found.pull_off.reason
    assert 'use smaller radii: loading.spacing = "log", by fem a smaller mesh.smallest (or' in found.pull_off.reason
    assert found.energy_lost == found.separation == found.pull_off
    assert found.jump_in.delta == 0
    assert shrink(QuasiStatic(thin("compressible"), thin("compressible"), RIGID), 1.7e-5).ends == "series"


def test_a_series_that_ends_too_early_says_so() -> None:
    short = curve(half_space(20, largest=4e-6))
    for stiffness in (0.0, RIGID):
        found = stability_under(short, stiffness)
        assert found.jump_in == Unknown(
            "contact at delta = 0 spreads beyond the largest radius of the solution, a = 4 um: increase [loading] "
            "radius"
        )
    assert stability_under(short, 0.0).critical == ()
    assert "the load is lowest at the largest radius of the solution" in stability_under(short, 0.0).pull_off.reason
    assert isinstance(stability_under(short, RIGID).pull_off, CriticalPoint)  # that one lies inside
    assert largest_stable(short, 0.0) is None


def test_a_series_that_begins_too_late_says_so() -> None:
    a = np.linspace(9e-6, 1.7e-5, 30)
    delta, P = hertz(a, E_STAR, R)
    late = curve(Series(a, delta, P, 2 * E_STAR * a, np.full(30, 2 * E_STAR)))
    found = stability_under(late, RIGID)
    assert found.jump_in == Unknown(
        "contact at delta = 0 is in equilibrium below the smallest radius of the solution, a = 9 um: begin at smaller "
        "radii"
    )
    assert isinstance(found.pull_off, Unknown)


def test_a_stiff_coating_has_several_critical_points_and_jumps_back_before_it_lets_go() -> None:
    found = stability_under(stiff_coating(1.8e-4), RIGID)
    assert [point.kind for point in found.critical] == ["minimum", "maximum", "minimum"]
    (jump,) = found.partial
    first, hill, second = found.critical
    assert jump.start.a == second.a
    assert first.a < jump.end.a < hill.a
    assert jump.end.delta == pytest.approx(jump.start.delta, rel=1e-9)  # at standing device
    assert found.pull_off == first


@cache
def dipped(first: float, *dips: tuple[float, float, float]) -> AdhesiveCurve:
    """Hertz from radius ``first`` on with dips of S' (at, depth, width in log a): hills and valleys of D."""
    fine = np.geomspace(first, 1.7e-5, 299 * 40 + 1)
    delta, P = hertz(fine, E_STAR, R)
    dS = 2 * E_STAR * np.ones_like(fine)
    for at, depth, width in dips:
        dS *= 1 - depth * np.exp(-((np.log(fine / at) / width) ** 2))
    S = 2 * E_STAR * first + cumulative_simpson(dS, x=fine, initial=0)
    P = P[0] + cumulative_simpson(S * 2 * fine / R, x=fine, initial=0)
    a, delta, P, S, dS = (column[::40] for column in (fine, delta, P, S, dS))
    return transform(Series(a, delta, P), Slopes(S, dS, "exact", 0.0), 1.0)


BODIES = {
    "1.8e-4": lambda: stiff_coating(1.8e-4),
    "three radii at first contact": lambda: dipped(1e-7, (6e-6, 0.995, 0.08)),
    "several landings in": lambda: dipped(1e-7, (1.1e-5, 0.97, 0.03), (1.2e-5, 0.97, 0.03), (1.5e-5, 0.9, 0.05)),
    "several landings out": lambda: dipped(1e-7, (3e-6, 0.9, 0.05), (4e-6, 0.97, 0.05), (5e-6, 0.99, 0.05)),
}


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("stiffness", [30.0, RIGID])
def test_paths_are_the_envelope_of_the_device_position(body: str, stiffness: float) -> None:
    """Brute force: a growing contact passes a radius when D exceeds all D before it, a shrinking one when D lies below
    all D at larger radii; but for samples next to the ends of the stretches."""
    ours = BODIES[body]()
    a = np.geomspace(ours.a[0], ours.a[-1], 4001)[1:-1]
    D = position(*ours.at(a), stiffness)
    lowest, highest = np.minimum.accumulate(D[::-1])[::-1], np.maximum.accumulate(np.maximum(D, 0))
    back, forth = (
        shrink(QuasiStatic(ours, ours, stiffness), float(ours.a[-1])),
        grow(QuasiStatic(ours, ours, stiffness)),
    )
    assert back.ends == "lost"
    for path, passed in ((back, lowest == D), (forth, (highest == D) & (D > 0))):
        ends = np.array([end for stretch in path.stretches for end in (stretch.place, stretch.end)])
        clear = np.all(np.abs(np.log(a[:, None] / ends)) > np.log(a[1] / a[0]), axis=1)
        assert clear.sum() >= a.size - 2 * ends.size
        assert [path.holds(radius) for radius in a[clear]] == list(passed[clear])


def test_a_contact_pressed_together_is_not_lost_but_leaves_the_series() -> None:
    """Where S' dips delta has a minimum > 0: the free bodies would overlap, so a smaller contact must remain."""
    ours = dipped(8e-6, (1e-5, 0.97, 0.1))
    (lowest,) = (point for point in ours.critical(RIGID) if point.kind == "minimum")
    assert 0 < lowest.delta < ours.at(ours.a[:1])[0][0]
    found = stability_under(ours, RIGID)
    assert found.pull_off == ours.pull_off(RIGID)  # one rule, whoever asks
    assert isinstance(found.pull_off, Unknown)
    assert found.pull_off.reason.endswith(
        "a radius below the smallest of the solution, a = 8e-06 m, and is not lost: the solution must begin at a "
        "smaller radius"
    )
    path = shrink(QuasiStatic(ours, ours, RIGID), float(ours.a[-1]))
    assert (path.ends, path.last) == ("jump", lowest.a)


def test_work_of_separation_counts_from_the_last_of_several_zero_loads() -> None:
    """In the valley the load falls below zero, contact jumps back to a smaller radius and is pressed again."""
    ours = dipped(1e-7, (8e-6, 0.97, 0.05))
    whole = cycle(ours, ours, RIGID)
    zeros = [a for a in ours.radii(P=0.0) if whole.retraction.holds(a)]
    assert len(zeros) == 2
    assert len(whole.retraction.jumps) == 2
    a = np.geomspace(zeros[0], whole.retraction.jumps[-1].start.a, 20_001)
    delta, P = ours.at(a)
    assert whole.separation == pytest.approx(np.sum((P[1:] + P[:-1]) / 2 * np.diff(delta)), rel=1e-6)  # trapezoids


def test_an_approach_that_jumps_out_of_the_series_ends_there() -> None:
    whole = BODIES["several landings in"]()
    keep = whole.a < 1.12e-5  # just beyond the first valley
    series = whole.series
    cut = Series(*(getattr(series, name)[keep] for name in ("a", "delta", "P")))
    slopes_cut = Slopes(whole.slopes.S[keep], whole.slopes.dS[keep], "exact", 0.0)
    ours = transform(cut, slopes_cut, 1.0)
    path = grow(QuasiStatic(ours, ours, RIGID))
    assert path.ends == "jump"
    assert [point.a for point in ours.critical(RIGID) if point.kind == "maximum"] == [path.last]
    assert path.jumps == ()  # where it lands is not known


def test_branches_in_words() -> None:
    ours = classical()
    words = branch(ours)
    cubes = (ours.a / A0) ** 3
    assert list(words) == [STABLE if c > 1.5 else GRIPPED if c > 1 / 6 else UNSTABLE for c in cubes]
    assert set(branch(curve(half_space(), 0.0))) == {STABLE}


def test_no_adhesion() -> None:
    found = stability_under(curve(half_space(), 0.0), RIGID)
    nothing = NO_ADHESION
    assert vars(found) == vars(Stability(RIGID, (), nothing, nothing, (), NO_ADHESION, NO_ADHESION))


# ---------------------------------------------------------------------- w behind a measured pull-off force
@cache
def gel() -> Series:
    """nu = 0.499, R/h = 1000, a/h up to 15."""
    specimen = Specimen((Layer(Elastic(1e4, 0.499), 1e-6),), Rigid())
    loading = Loading.given("radius", tuple(np.geomspace(2e-7, 1.5e-5, 80)))
    return Layered(1e-7)(Problem(Paraboloid(1e-3), specimen, loading)).series


def work_behind(series: Series, load: float, stiffness: float = 0.0, R: float | None = None):
    return work_from_pull_off(Nonadhesive(series, slopes(series)), load, stiffness, R)


def test_on_a_half_space_it_is_the_classical_answer() -> None:
    answer = work_behind(half_space(), 0.02, R=R)
    assert answer.half_space == pytest.approx(0.02 / (1.5 * math.pi * R), rel=1e-15)
    assert answer.w == pytest.approx(answer.half_space, rel=1e-9)  # round-off of the minimum
    assert answer.point.P == pytest.approx(-0.02, rel=1e-9)
    grip = work_behind(half_space(), 0.02, math.inf)
    assert grip.w == pytest.approx(0.02 / (5 / 6 * math.pi * R), rel=1e-9)
    assert grip.half_space is None


def test_on_a_layer_the_half_space_misleads_by_the_map() -> None:
    """nu = 0.499, w R^2/(E* h^3) = 1e4: the map gives 2.6134."""
    E_star = 1e4 / (1 - 0.499**2)
    w = 1e4 * E_star * 1e-18 / 1e-6
    answer = work_behind(gel(), 2.6134 * math.pi * w * 1e-3, R=1e-3)
    assert answer.w == pytest.approx(w, rel=4e-5)  # five digits of the map
    assert answer.half_space / answer.w == pytest.approx(2.6134 / 1.5, rel=4e-5)


def test_where_the_pull_off_radius_hardly_moves_w_is_still_found() -> None:
    """On this gel the neck is highest at a/h = 0.46: under displacement control every strong w lets go just there."""
    series = gel()
    w = 1e-2
    point = transform(series, slopes(series), w).pull_off(math.inf)
    weak = transform(series, slopes(series), w / 100).pull_off(math.inf)
    assert point.a == pytest.approx(weak.a, rel=0.05)
    assert work_behind(series, -point.P, math.inf).w == pytest.approx(w, rel=1e-7)


@settings(max_examples=6, deadline=None)
@given(st.floats(-6.5, -3.5), st.sampled_from([0.0, 1.0, 10.0, math.inf]))
def test_forward_and_inverse_are_a_pair(log_w: float, stiffness: float) -> None:
    series = gel()
    point = transform(series, slopes(series), 10**log_w).pull_off(stiffness)
    assert work_behind(series, -point.P, stiffness).w == pytest.approx(
        10**log_w, rel=1e-7
    )  # a minimum: root of round-off


def test_a_force_outside_the_series_is_refused_with_the_range() -> None:
    """The ends: a^3 = 1.5 (3 pi w R^2/(4 E*)) at the first and last radius, times 1.5 pi w R: 2 E* a^3/(... R)."""
    least, greatest = (4 * E_STAR * a**3 / (3 * R) for a in (half_space().a[0], half_space().a[-1]))
    assert (least, greatest) == pytest.approx((1.9024e-6, 0.41092), rel=1e-4)
    for force, remedy in ((1.0, "increase [loading] radius"), (1e-7, "begin the solution at a smaller radius")):
        (said,) = refused_by(work_behind, half_space(), force)
        assert said.endswith(f"outside the solution, which covers forces from 1.902 uN to 410.9 mN: {remedy}")


def test_a_force_that_the_last_stable_branch_jumps_past_is_refused() -> None:
    """Under displacement control this coating lets go at 0.26 uN or at more than 0.38 uN, by no w in between."""
    (answer,) = refused_by(work_behind, stiff_coating(1.8e-4).series, 3.1e-7, math.inf)
    assert answer.startswith("load: no work of adhesion gives a pull-off force of 310 nN: where the last stable branch")
    assert "the force jumps past it" in answer


@pytest.mark.parametrize("load", [0.0, -1.0, math.nan])
def test_impossible_forces_are_refused(load: float) -> None:
    said = f"load: the measured pull-off force must be > 0 N, got {load:g}"
    assert refused_by(work_behind, half_space(), load) == (said,)

"""The work of adhesion behind a measured pull-off force."""

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from stated_errors import in_units

from jkrcli.adhesion.curve import Nonadhesive, transform
from jkrcli.adhesion.from_rest import work_from_pull_off
from jkrcli.adhesion.slopes import slopes
from jkrcli.base.errors import InputError
from jkrcli.bodies.indenters import Paraboloid, PowerLaw
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.formulas import hertz
from jkrcli.methods.layered.solver import Layered
from jkrcli.series import Series

E_STAR, R = 5e9 / 0.84, 1e-4


@cache
def half_space() -> Series:
    a = np.linspace(0, 1.73e-5, 61)[1:]
    delta, P = hertz(a, E_STAR, R)
    return Series(a, delta, P, 2 * E_STAR * a, np.full(60, 2 * E_STAR))


@cache
def gel() -> Series:
    """nu = 0.499, R/h = 1000, a/h up to 15."""
    specimen = Specimen((Layer(Elastic(1e4, 0.499), 1e-6),), Rigid())
    loading = Loading.given("radius", tuple(np.geomspace(2e-7, 1.5e-5, 80)))
    return Layered(1e-7)(Problem(Paraboloid(1e-3), specimen, loading)).series


@cache
def stiff_coating() -> Series:
    specimen = Specimen((Layer(Elastic(1e8, 0.4), 1e-6),), HalfSpace(Elastic(1e6, 0.4)))
    loading = Loading.given("radius", tuple(np.geomspace(3e-8, 1.5e-5, 90)))
    return Layered(1e-7)(Problem(Paraboloid(1e-3), specimen, loading)).series


def found(series: Series, load: float, stiffness: float = 0.0, R: float | None = None):
    return work_from_pull_off(Nonadhesive(series, slopes(series)), load, stiffness, R)


def test_on_a_half_space_it_is_the_classical_answer() -> None:
    answer = found(half_space(), 0.02, R=R)
    assert answer.half_space == pytest.approx(0.02 / (1.5 * math.pi * R), rel=1e-15)
    assert answer.w == pytest.approx(answer.half_space, rel=1e-9)  # round-off of the minimum
    assert answer.point.P == pytest.approx(-0.02, rel=1e-9)
    grip = found(half_space(), 0.02, math.inf)
    assert grip.w == pytest.approx(0.02 / (5 / 6 * math.pi * R), rel=1e-9)
    assert grip.half_space is None


def test_on_a_layer_the_half_space_misleads_by_the_map() -> None:
    """nu = 0.499, w R^2/(E* h^3) = 1e4: the map gives 2.6134."""
    E_star = 1e4 / (1 - 0.499**2)
    w = 1e4 * E_star * 1e-18 / 1e-6
    answer = found(gel(), 2.6134 * math.pi * w * 1e-3, R=1e-3)
    assert answer.w == pytest.approx(w, rel=4e-5)  # five digits of the map
    assert answer.half_space / answer.w == pytest.approx(2.6134 / 1.5, rel=4e-5)


def test_where_the_pull_off_radius_hardly_moves_w_is_still_found() -> None:
    """On this gel the neck is highest at a/h = 0.46: under displacement control every strong w lets go just there."""
    series = gel()
    w = 1e-2
    point = transform(series, slopes(series), w).pull_off(math.inf)
    weak = transform(series, slopes(series), w / 100).pull_off(math.inf)
    assert point.a == pytest.approx(weak.a, rel=0.05)
    assert found(series, -point.P, math.inf).w == pytest.approx(w, rel=1e-7)


@settings(max_examples=6, deadline=None)
@given(st.floats(-6.5, -3.5), st.sampled_from([0.0, 1.0, 10.0, math.inf]))
def test_forward_and_inverse_are_a_pair(log_w: float, stiffness: float) -> None:
    series = gel()
    point = transform(series, slopes(series), 10**log_w).pull_off(stiffness)
    assert found(series, -point.P, stiffness).w == pytest.approx(10**log_w, rel=1e-7)  # a minimum: root of round-off


@pytest.mark.parametrize("stiffness", [0.0, 0.1])
def test_change_of_units(stiffness: float) -> None:
    length, force = 1e6, 1e-3
    stiff, plain = force / length, gel()
    here = found(plain, 1e-7, stiffness, 1e-3)
    there = found(in_units(plain, length, force), 1e-7 * force, stiffness * stiff, 1e-3 * length)
    assert there.w == pytest.approx(here.w * stiff, rel=1e-8)
    assert there.half_space == pytest.approx(here.half_space * stiff, rel=1e-13)


def message(call) -> str:
    with pytest.raises(InputError) as caught:
        call()
    return str(caught.value)


def test_a_force_outside_the_series_is_refused_with_the_range() -> None:
    """The ends: a^3 = 1.5 (3 pi w R^2/(4 E*)) at the first and last radius, times 1.5 pi w R: 2 E* a^3/(... R)."""
    least, greatest = (4 * E_STAR * a**3 / (3 * R) for a in (half_space().a[0], half_space().a[-1]))
    assert (least, greatest) == pytest.approx((1.9024e-6, 0.41092), rel=1e-4)
    assert message(lambda: found(half_space(), 1.0)) == (
        "load: a pull-off force of 1 N lies outside the solution, which covers forces from 1.902 uN to 410.9 mN: "
        "increase [loading] radius"
    )
    assert message(lambda: found(half_space(), 1e-7)).endswith(
        "lies outside the solution, which covers forces from 1.902 uN to 410.9 mN: begin the solution at a smaller "
        "radius"
    )


def test_a_force_that_the_last_stable_branch_jumps_past_is_refused() -> None:
    """Under displacement control this coating lets go at 0.26 uN or at more than 0.38 uN, by no w in between."""
    answer = message(lambda: found(stiff_coating(), 3.1e-7, math.inf))
    assert answer.startswith("load: no work of adhesion gives a pull-off force of 310 nN: where the last stable branch")
    assert "the force jumps past it" in answer


def test_a_cone_has_no_half_space_answer() -> None:
    specimen = Specimen((), HalfSpace(Elastic(1e6, 0.3)))
    problem = Problem(PowerLaw(0.3, 1.0), specimen, Loading("radius", 1e-5, 40))
    answer = found(Layered()(problem).series, 1e-6)
    assert answer.half_space is None
    assert answer.point.P == pytest.approx(-1e-6, rel=1e-9)


@pytest.mark.parametrize("load", [0.0, -1.0, math.nan])
def test_impossible_forces_are_refused(load: float) -> None:
    assert (
        message(lambda: found(half_space(), load)) == f"load: the measured pull-off force must be > 0 N, got {load:g}"
    )

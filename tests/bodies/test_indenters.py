"""Indenters: f, f' and the Abel image of each shape agree with quadrature; tables keep convexity."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from jkrcli.base.errors import InputError
from jkrcli.bodies.indenters import (
    FlatPunch,
    Indenter,
    Paraboloid,
    PowerLaw,
    RoundedCone,
    RoundedFlat,
    Sphere,
    TableProfile,
)

R = 3e-5
GRID = np.linspace(0, 0.5 * R, 31)
SHAPES = [
    Sphere(R),
    Paraboloid(R),
    FlatPunch(R),
    PowerLaw(0.7, 1.0),
    PowerLaw(1e12, 3.3),
    RoundedFlat(0.1 * R, 0.3 * R),
    RoundedCone(0.2 * R, math.atan(2), cap="parabola"),  # a cone from 0.1 R on
    RoundedCone(0.2 * R, math.acos(0.5)),  # a cone from 0.1 R on
    TableProfile(tuple(GRID), tuple(R - np.sqrt(R**2 - GRID**2))),
    TableProfile((0, 0.1 * R, 0.2 * R, 0.4 * R, 0.5 * R), (0, 0, 0.01 * R, 0.2 * R, 0.35 * R)),
]


def name_of(indenter: object) -> str:
    return type(indenter).__name__


@pytest.mark.parametrize("indenter", SHAPES, ids=name_of)
def test_abel_image_is_its_integral(indenter) -> None:
    x = 0.37 * R
    breaks = [math.asin(b / x) for b in getattr(indenter, "knots", [0.1 * R]) if 0 < b < x]
    value, _ = quad(lambda t: x * float(indenter.slope(np.array(x * math.sin(t)))), 0, math.pi / 2, points=breaks,
                    epsrel=1e-11, limit=200)  # fmt: skip
    assert float(indenter.abel(np.array(x))) == pytest.approx(value, rel=1e-9)  # quad stops near 1e-10 at kinks


@pytest.mark.parametrize("indenter", SHAPES, ids=name_of)
def test_profile_is_the_integral_of_its_slope(indenter) -> None:
    r = np.linspace(0.01 * R, 0.49 * R, 50)
    step = 1e-6 * R
    central = (indenter.f(r + step) - indenter.f(r - step)) / (2 * step)
    # the difference quotient is good to step^2 f'''/6 plus round-off eps f/step, and first order at kinks of f''
    np.testing.assert_allclose(central, indenter.slope(r), rtol=1e-5, atol=1e-5 * float(indenter.slope(r[-1])))
    assert float(indenter.f(np.array(0.0))) == 0


def test_table_is_exact_for_a_paraboloid_at_any_spacing() -> None:
    r = R * np.array([0, 0.013, 0.05, 0.2, 0.21, 0.5])
    table, exact = TableProfile(tuple(r), tuple(r**2 / (2 * R))), Paraboloid(R)
    x = np.linspace(0, 0.5 * R, 40)
    np.testing.assert_allclose(table.f(x), exact.f(x), rtol=1e-12, atol=1e-20 * R)
    np.testing.assert_allclose(table.abel(x), exact.abel(x), rtol=1e-12)
    assert table.tip_radius == pytest.approx(R, rel=1e-12)


def through(indenter: Indenter, count: int, **keys: tuple[float, ...]) -> TableProfile:
    r = np.linspace(0, 0.5 * R, count)
    return TableProfile(tuple(r), tuple(np.asarray(indenter.f(r)).tolist()), **keys)


@pytest.mark.parametrize("indenter", [Sphere(R), PowerLaw(1e12, 3.3)], ids=name_of)
def test_tables_of_smooth_shapes_converge_without_kinks_and_state_their_error(indenter) -> None:
    errors, x = [], np.linspace(0.05 * R, 0.49 * R, 101)
    for count in (4, 6, 11, 21, 41, 81):
        table = through(indenter, count)
        errors.append(float(np.max(np.abs(table.abel(x) - indenter.abel(x)))))
        assert (
            max(table.kinks, default=0.0) < 0.4 * R if count == 4 else len(table.kinks) <= 3
        )  # curvature 0 at r^3.3's
        assert errors[-1] < np.max(table.resolution(x)[0])
        slope = np.max(np.abs(table.abel_slope(x[50:]) - indenter.abel_slope(x[50:])))
        assert slope < np.max(table.resolution(x)[1])
    assert -np.polyfit(np.log([10, 20, 40, 80]), np.log(errors[2:]), 1)[0] > 2.9  # the end's order; inside it is four


@pytest.mark.parametrize("power", [1.04, 1.5])
@pytest.mark.parametrize("count", [4, 25])
def test_next_to_a_tip_the_error_of_the_slope_is_stated(power: float, count: int) -> None:
    pointed = PowerLaw(0.2 * R ** (1 - power), power)
    table, r = through(pointed, count), np.array([1e-5 * R])
    wrong, (stated,) = np.abs(table.abel_slope(r) - pointed.abel_slope(r)), table.resolution(r)[1]
    assert wrong <= stated <= table.abel_slope(r) * (1 + 1e-12)
    cone = through(PowerLaw(0.2, 1.0), count)
    assert cone.resolution(r)[1] < 1e-12


def test_a_table_bends_where_it_is_said_to_and_where_a_straight_run_ends() -> None:
    blunt = RoundedFlat(0.1 * R, 0.3 * R)
    assert through(blunt, 41).kinks == pytest.approx([0.1 * R])
    assert through(blunt, 41).abel(np.array([0.3 * R])) == pytest.approx(blunt.abel(np.array([0.3 * R])), rel=1e-12)
    r, corner = np.linspace(0, 0.5 * R, 11), 0.25 * R
    f = tuple(r**2 / (2 * R) + 0.2 * np.maximum(r - corner, 0))
    rising = TableProfile((0, 1, 2, 3), (0, 1, 4, 10), bends=(1.0,))  # the parabolas on both sides would dip there
    assert (np.diff(rising.slope(np.linspace(0, 3, 301))) >= 0).all()
    bent, smooth = TableProfile(tuple(r), f, bends=(corner,)), TableProfile(tuple(r), f)
    x = np.array([0.24 * R, 0.3 * R, 0.45 * R])
    jump = np.where(x > corner, 0.2 * x * np.arccos(np.minimum(corner / x, 1)), 0.0)
    np.testing.assert_allclose(bent.abel(x), x**2 / R + jump, rtol=1e-10)
    assert bent.kinks == pytest.approx([corner])
    assert np.max(np.abs(smooth.abel(x) / bent.abel(x) - 1)) > 1e-3
    step = 1e-6 * R
    central = (bent.abel(x + step) - bent.abel(x - step)) / (2 * step)
    np.testing.assert_allclose(bent.abel_slope(x), central, rtol=1e-7)


@example([0.0, 1.0, 0.0078125, 0.0], [1.0] * 12)  # one interval between a flat end and a straight run
@example([1e-10, 1.0, 0.0], [1.0] * 12)  # a flat end that rises by less than rounding
@given(st.lists(st.floats(0, 1), min_size=3, max_size=12), st.lists(st.floats(0.05, 1), min_size=12, max_size=12))
@settings(max_examples=40, deadline=None)
def test_any_convex_table_keeps_its_points_and_stays_convex(growth: list[float], widths: list[float]) -> None:
    slopes = np.cumsum(growth)
    if slopes[-1] < 1e-3:
        return
    r = np.concatenate([[0], np.cumsum(widths[: slopes.size])])
    f = np.concatenate([[0], np.cumsum(slopes * np.diff(r))])
    f[f < 1e-25] = 0.0  # no length is so small
    table = TableProfile(tuple(r), tuple(f))
    # a forced kink is rounded, and a first rise of up to 1e-9 of the height belongs to the flat end
    np.testing.assert_allclose(table.f(r), f, rtol=1e-9, atol=1.1e-9 * f[-1])
    fine = np.linspace(0, r[-1], 500)
    rounding = 1e-12 * slopes[-1] + 8 * np.finfo(float).eps * f[-1] / np.diff(r).min()  # of heights, over a width
    assert (np.diff(table.slope(fine)) >= -rounding).all()
    assert (np.diff(table.abel(fine)) >= -rounding).all()


@pytest.mark.parametrize(
    ("build", "line"),
    [
        (lambda: TableProfile((0, 1), (0, 1)), "profile table: needs at least 3 points (r, f), got 2 and 2"),
        (lambda: TableProfile((0, 1, 1), (0, 1, 2)), "profile table: radii must increase, point 3 has r = 1 after 1"),
        (lambda: TableProfile((0.5, 1, 2), (0, 1, 2)), "profile table: must start at r = 0, f = 0, got (0.5, 0)"),
        (lambda: TableProfile((0, 1, 2), (0, 1, 4), bends=(2.0,)), "profile table: bends must be radii of the table "),
        (lambda: TableProfile((0, 1, 2), (0, 0, 0)), "profile table: is flat; a flat end needs a rounded edge"),
        (lambda: TableProfile((0, 1, math.nan), (0, 0, 0)), "r: entry 3 must be a finite number, got nan m"),
    ],
)
def test_wrong_shapes_are_refused(build, line: str) -> None:
    with pytest.raises(InputError, check=lambda error: str(error).startswith(line)):
        build()


def test_a0_and_tip_radius() -> None:
    flat, table = RoundedFlat(0.1 * R, 0.3 * R), SHAPES[-1]
    assert [shape.a0 for shape in SHAPES if shape not in (flat, table)] == [0.0] * (len(SHAPES) - 2)
    assert flat.a0 == pytest.approx(0.1 * R)
    assert 0.1 * R < table.a0 < 0.2 * R  # where the parabola through the last three points meets the flat end
    assert RoundedCone(R, 0.5).tip_radius == R
    assert Sphere(R).tip_radius == Paraboloid(R).tip_radius == R
    assert PowerLaw(1.0, 1.0).tip_radius is None
    assert PowerLaw(1 / (2 * R), 2.0).tip_radius == pytest.approx(R)
    assert RoundedFlat(R, R).tip_radius is None


def test_the_abel_image_of_a_table_is_smooth_at_its_knots() -> None:
    """F begins there like (x - knot)^(3/2): the next number after a knot has the knot's own value, to rounding."""
    r = np.linspace(0.0, 2.0, 12)
    profile = TableProfile(tuple(r), tuple(r**2 + 0.3 * r**3))
    inner = profile.knots[1:-1]
    at, after = profile.abel(inner), profile.abel(np.nextafter(inner, np.inf))
    np.testing.assert_allclose(after, at, rtol=1e-14)


FLAT, TOP = 60e-9, 300e-9  # of worn tips [m]
WORN = {  # profiles beyond the flat end, and their Abel images
    "paraboloid": (lambda r: (r**2 - FLAT**2) / 1e-6, lambda x: x * np.sqrt(x**2 - FLAT**2) / 5e-7),
    "sphere": (
        lambda r: np.sqrt(5e-7**2 - FLAT**2) - np.sqrt(5e-7**2 - r**2),
        lambda x: x * np.log((np.sqrt(5e-7**2 - FLAT**2) + np.sqrt(x**2 - FLAT**2)) / np.sqrt(5e-7**2 - x**2)),
    ),
    "cone": (lambda r: 0.3 * (r - FLAT), lambda x: 0.3 * x * np.arccos(FLAT / x)),
}


@pytest.mark.parametrize("points", [41, 61])
@pytest.mark.parametrize("name", WORN)
def test_a_worn_tip_ends_in_a_corner_between_the_points_or_on_one(name: str, points: int) -> None:
    beyond, image = WORN[name]
    r = np.linspace(0, TOP, points)
    table = TableProfile(tuple(r.tolist()), tuple(np.where(r > FLAT, beyond(np.maximum(r, FLAT)), 0.0).tolist()))
    x = np.linspace(1.1 * FLAT, TOP, 50)
    assert table.a0 == pytest.approx(FLAT, rel={"sphere": 2e-3}.get(name, 1e-9))
    assert (np.abs(table.abel(x) - image(x)) <= table.resolution(x)[0] + 1e-9 * image(x)).all()


@pytest.mark.parametrize("height", [1.65436e-24, 1e-19, 1e-17])
def test_heights_of_rounding_are_part_of_the_flat_end(height: float) -> None:
    r = np.linspace(0, TOP, 61)
    f = np.maximum(r**2 - FLAT**2, 0.0) / 1e-6
    f[12] = height  # at 60 nm
    assert TableProfile(tuple(r.tolist()), tuple(f.tolist())).a0 == pytest.approx(FLAT, rel=1e-8)


def test_no_corner_is_made_where_a_straight_run_goes_over_smoothly() -> None:
    for smooth in (RoundedFlat(0.1 * R, 0.3 * R), RoundedCone(0.2 * R, math.atan(2), cap="parabola")):
        for count in (12, 21, 50):
            table = through(smooth, count)
            slope = table.slope(np.linspace(0, 0.5 * R, 4001))
            assert np.diff(slope).max() < 0.05 * slope[-1]

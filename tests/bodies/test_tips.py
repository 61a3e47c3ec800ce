"""Blunt cones and pyramids against loads that know nothing of them: quadrature and boundary elements."""

import functools
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.fft import irfft2, rfft2
from scipy.integrate import quad

from jkrcli import (
    ClosedForm,
    Elastic,
    HalfSpace,
    InputError,
    Layered,
    Loading,
    Problem,
    Pyramid,
    RoundedCone,
    Specimen,
    Sphere,
    parse_case,
    pull_off,
    read,
    solve,
)
from jkrcli import check as check_case
from jkrcli.case.store import write_solution


def _love(n: int, h: float) -> np.ndarray:
    """Displacement of E* = 1 by a unit pressure on a square of side ``h`` (Love 1929), over the offsets of 2n cells."""
    x = np.arange(2 * n)
    x = np.where(x < n, x, x - 2 * n) * h
    X, Y = np.meshgrid(x, x, indexing="ij")

    def corner(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        return u * np.arcsinh(v / np.abs(u)) + v * np.arcsinh(u / np.abs(v))

    a, b, c, d = X + h / 2, X - h / 2, Y + h / 2, Y - h / 2
    return (corner(a, c) - corner(a, d) - corner(b, c) + corner(b, d)) / np.pi


@functools.cache
def load_and_area(faces: int, n: int, depth: float) -> tuple[float, float]:
    """Load over depth^2 and contact area over depth^2 of a pyramid of so many ``faces`` at 45 deg, 0: of a cone, on a
    half-space of E* = 1: conjugate gradients with p >= 0 (Polonsky and Keer 1999) on n x n squares of a 2 x 2 plane."""
    h = 2 / n
    x = (np.arange(n) + 0.5) * h - 1
    X, Y = np.meshgrid(x, x, indexing="ij")
    turns = 2 * np.pi * np.arange(max(faces, 1)) / max(faces, 1)
    f = np.max([X * np.cos(t) + Y * np.sin(t) for t in turns], axis=0) if faces else np.hypot(X, Y)
    kernel = rfft2(_love(n, h))

    def displaced(p: np.ndarray) -> np.ndarray:
        return irfft2(rfft2(p, s=(2 * n, 2 * n)) * kernel, s=(2 * n, 2 * n))[:n, :n]

    p, way, before, keep = np.maximum(depth - f, 0.0), np.zeros_like(f), 1.0, 0.0
    for _ in range(200):
        residual = np.where(p > 0, displaced(p) - (depth - f), 0.0)
        size = float(np.sum(residual**2))
        way = np.where(p > 0, residual + keep * size / before * way, 0.0)
        step = np.sum(residual * way) / np.sum(displaced(way) * way)
        moved = np.maximum(p - step * way, 0.0)
        apart = displaced(moved) - (depth - f)
        overlap = (moved == 0) & (apart < 0)
        moved[overlap] -= step * apart[overlap]
        change, p, before, keep = np.abs(moved - p).sum(), moved, size, 0.0 if overlap.any() else 1.0
        if change < 1e-8 * p.sum():
            break
    rim = np.concatenate([p[0], p[-1], p[:, 0], p[:, -1]])
    assert not rim.any()  # the contact ends within the plane
    return float(p.sum() * h**2 / depth**2), float((p > 0).sum() * h**2 / depth**2)


@pytest.mark.parametrize(("faces", "depth"), [(0, 1.2), (3, 0.55), (4, 1.1)])
def test_the_load_of_a_pyramid_is_that_of_boundary_elements(faces: int, depth: float) -> None:
    (coarse, wide), (fine, area) = (load_and_area(faces, n, depth) for n in (48, 96))
    load, area = fine + (fine - coarse) / 3, 2 * area - wide  # of second order in the cells, of first
    if not faces:  # the boundary elements themselves, against Sneddon's cone
        assert load == pytest.approx(2 / math.pi, rel=1e-4)
        assert area == pytest.approx(4 / math.pi, rel=2e-2)  # cells at the rim
        return
    tip = Pyramid.of(faces, math.pi / 4)
    a = np.array([1.0])
    delta, P = tip.half_space(a, 1.0)
    assert float(P[0] / delta[0] ** 2) == pytest.approx(load, rel=4e-4)
    assert tip.contact_share * float(math.pi / delta[0] ** 2) == pytest.approx(area, rel=2e-2)


@pytest.mark.parametrize(("sides", "face", "cone"), [(4, 68.0, 70.3), (3, 65.27, 70.3), (3, 35.26, 42.28)])
def test_pyramids_as_cones_of_equal_area(sides: int, face: float, cone: float) -> None:
    """Vickers, Berkovich, the corner of a cube: 70.3 deg, 70.3 deg and 42.28 deg (Fischer-Cripps, Nanoindentation,
    table 1.1); their sections 24.5 h^2, 24.5 h^2 and 2.60 h^2."""
    tip = Pyramid.of(sides, math.radians(face), equal="area")
    assert math.degrees(math.atan(1 / tip.B)) == pytest.approx(cone, abs=5e-3)  # as printed
    assert math.pi / tip.B**2 == pytest.approx({68.0: 24.5, 65.27: 24.5, 35.26: 2.60}[face], rel=2e-3)  # as printed


PYRAMID = """[indenter]\nshape = "{shape}"\nhalf_angle = "35 deg"\n[loading]\nradius = "{a}"
[adhesion]\nw = "10 mJ/m^2"\n[specimen.half_space]\nE = "1 MPa"\nnu = 0.5\n"""


def test_what_a_cone_leaves_open_of_a_pyramid_is_a_part_of_its_own() -> None:
    """Its contact area is a share of the cone's: w acts as that share of w, and pull-off of a cone goes with w^2."""
    case = parse_case(PYRAMID.format(shape="pyramid", a="100 nm"))
    share = Pyramid.of(4, math.radians(35)).contact_share
    assert share == pytest.approx(1.48 / 1.7092, rel=1e-3)
    (row,) = [one for one in check_case(case).summary()["left_out"] if one["name"] == "faces of the pyramid"]
    assert row["load"] == 0
    assert row["pull_off"][0]["change"] == pytest.approx(share**2 - 1, rel=1e-3)
    assert "0.87 w" in str(pull_off(solve(case), w=0.01))
    cone = parse_case(PYRAMID.format(shape="cone", a="100 nm"))
    assert "contact area" not in str(pull_off(solve(cone), w=0.01))


def cap_load(tip: RoundedCone, a: float) -> float:
    """P_H of E* = 1 by Sneddon's integral 2 int_0^a f' r^2/sqrt(a^2 - r^2) dr, r = a sin(t)."""
    breaks = [math.asin(tip.b / a)] if tip.b < a else []
    value, _ = quad(lambda t: 2 * float(tip.slope(np.array(a * math.sin(t)))) * (a * math.sin(t)) ** 2, 0, math.pi / 2,
                    points=breaks or None, epsrel=1e-12, epsabs=0.0, limit=200)  # fmt: skip
    return value


@pytest.mark.parametrize("angle", [0.5, 5.0, 20.0, 35.0, 70.0, 85.0, 89.5])
@pytest.mark.parametrize("cap", ["sphere", "parabola"])
@pytest.mark.parametrize("over_b", [1e-3, 0.3, 0.999, 1.0, 1.001, 3.0, 300.0])
def test_the_load_of_a_blunt_cone_is_its_integral(angle: float, cap: str, over_b: float) -> None:
    tip = RoundedCone(2e-8, math.radians(angle), cap=cap)  # type: ignore[arg-type]
    a = over_b * tip.b
    _, P = tip.half_space(np.array(a), 1.0)
    assert float(P) == pytest.approx(cap_load(tip, a), rel=2e-9)  # of the quadrature at the cone's edge


@pytest.mark.parametrize("angle", [20.0, 70.0, 89.0])
def test_the_spherical_cap_is_a_sphere_up_to_where_the_cone_is_tangent(angle: float) -> None:
    tip, sphere = RoundedCone(1.0, math.radians(angle)), Sphere(1.0)
    assert tip.b == pytest.approx(math.cos(math.radians(angle)))
    assert float(tip.slope(np.array(tip.b))) == pytest.approx(1 / math.tan(math.radians(angle)), rel=1e-12)
    r = np.linspace(0, 1, 9)[1:] * tip.b * (1 - 1e-9)
    for name in ("f", "slope", "abel", "abel_slope"):
        np.testing.assert_allclose(getattr(tip, name)(r), getattr(sphere, name)(r), rtol=1e-12, err_msg=name)
    np.testing.assert_allclose(tip.half_space(r, 3.0), sphere.half_space(r, 3.0), rtol=1e-12)
    far, step = np.array([1.01, 1.7, 40.0]) * tip.b, 1e-5
    central = (tip.abel(far * (1 + step)) - tip.abel(far * (1 - step))) / (2 * step * far)
    np.testing.assert_allclose(tip.abel_slope(far), central, rtol=1e-6)


BLUNT = """[indenter]\nshape = "rounded-cone"\nradius = "20 nm"\nhalf_angle = "20 deg"\n{}
[loading]\ndepth = "50 nm"\npoints = 5\n[specimen.half_space]\nE = 1e6\nnu = 0.5\n"""


def test_the_cap_is_a_key_of_the_case_and_is_told() -> None:
    plain, parabola = (parse_case(BLUNT.format(key)).model.problem() for key in ("", 'cap = "parabola"'))
    assert (plain.indenter.cap, parabola.indenter.cap) == ("sphere", "parabola")
    assert "spherical cap" in plain.words
    assert "parabolic cap" in parabola.words
    assert plain.key != parabola.key
    with pytest.raises(InputError, match=r'indenter\.cap: must be one of sphere, parabola, got "cone"'):
        parse_case(BLUNT.format('cap = "cone"'))


@pytest.mark.parametrize("tip", [RoundedCone(1e-6, 1.2), RoundedCone(1e-6, 0.35), Pyramid.of(3, 1.1)], ids=repr)
def test_layered_and_closed_form_agree_on_tips(tip: RoundedCone | Pyramid) -> None:
    problem = Problem(tip, Specimen((), HalfSpace(Elastic(1e6, 0.5))), Loading("radius", 2e-6, 20))
    exact, series = (solve(problem, method).series for method in (ClosedForm(), Layered()))
    np.testing.assert_allclose(series.delta, exact.delta, rtol=1e-7)
    np.testing.assert_allclose(series.P, exact.P, rtol=1e-7)


@pytest.mark.parametrize(
    ("keys", "before"),
    [
        ("radius = 2e-8\nhalf_angle = 0.35\nshape = 'rounded-cone'", RoundedCone(2e-8, 0.35, cap="parabola")),
        ("half_angle = 0.35\nshape = 'pyramid'", Pyramid.of(4, 0.35, equal="area")),
        ("half_angle = 0.35\nshape = 'three-sided-pyramid'", Pyramid.of(3, 0.35, equal="area")),
    ],
)
def test_a_series_file_of_before_keeps_the_tip_that_it_was_solved_for(
    tmp_path: Path, keys: str, before: RoundedCone | Pyramid
) -> None:
    """Its resolved case does not name the cap or the cone, of which there was one; a case file means those of today."""
    text = f"[indenter]\n{keys}\n[loading]\nradius = 1e-7\npoints = 4\n[specimen.half_space]\nE = 1e6\nnu = 0.5\n"
    now = parse_case(text)
    solution = solve(Problem(before, Specimen((), HalfSpace(Elastic(1e6, 0.5))), Loading("radius", 1e-7, 4)))
    record = replace(solution.record, case=replace(now, text=text))
    write_solution(tmp_path / "old.h5", replace(solution, record=record))
    stored = read(tmp_path / "old.h5")
    assert stored.problem.indenter == before
    assert now.model.problem().indenter != before
    write_solution(tmp_path / "new.h5", stored)  # and says so from now on
    assert read(tmp_path / "new.h5").problem.indenter == before
    assert ('cap = "parabola"' if isinstance(before, RoundedCone) else 'equal = "area"') in stored.record.toml

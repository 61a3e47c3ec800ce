"""Numbers that other programs print in their own tests: to the digits of their sources, or off for the reason named.

Sources: ContactMechanics and Adhesion (GitHub ContactEngineering), MOOSE (modules/contact/test/tests/hertz_spherical),
Code_Aster (V6.04.104, SSNV104), the biofilm code of K. Nam, Lethe (lethe-particles), AtomicJ (Hermanowicz et al., Rev.
Sci. Instrum. 85 (2014) 063703), nanite, PyFMRheo, CellMechLab; Maugis and Barquins 1981, Kendall 1971, Bilodeau 1992,
Chen et al. 2009.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from jkrcli import (
    Elastic,
    HalfSpace,
    Layer,
    Loading,
    Paraboloid,
    PowerLaw,
    PowerRelaxation,
    Problem,
    Pyramid,
    Rigid,
    RoundedCone,
    RoundedFlat,
    Specimen,
    Sphere,
    cycle_relaxing,
    parse_case,
    pull_off,
    solve,
)
from jkrcli.adhesion.curve import transform
from jkrcli.bodies.indenters import Indenter
from jkrcli.bodies.problem import Graded, Power


def half_space(E: float, nu: float) -> Specimen:
    return Specimen((), HalfSpace(Elastic(E, nu)))


def at(indenter: Indenter, specimen: Specimen, to: Any, value: float) -> dict[str, float]:
    series = solve(Problem(indenter, specimen, Loading.given(to, (value,)))).series
    return {name: float(getattr(series, name)[-1]) for name in ("a", "delta", "P", "S")}


def lost(indenter: Indenter, specimen: Specimen, w: float, a: float, **keys: Any) -> list[dict[str, Any]]:
    spacing = keys.pop("spacing", "radius")
    solution = solve(Problem(indenter, specimen, Loading("radius", a, 200, spacing)))
    found: list[dict[str, Any]] = pull_off(solution, w=w, **keys).summary()["controls"]
    return found


def test_hertz_of_contactmechanics() -> None:
    found = at(Paraboloid(4.0), half_space(3.75, 0.5), "load", 7.0)
    assert found["a"] == pytest.approx(1.6134286460245437, rel=1e-12)
    assert found["delta"] == pytest.approx(0.6507879989531481, rel=1e-12)


def test_two_spheres_of_moose() -> None:
    """Each of R = 2, E = 1.40625e7, nu = 0.25, under 1e4."""
    case = parse_case(
        "[indenter]\nshape = 'paraboloid'\nradius = 2\ncounter_radius = 2\nE = 1.40625e7\nnu = 0.25\n"
        "[specimen.half_space]\nE = 1.40625e7\nnu = 0.25\n[loading]\nload = 1e4\npoints = 1\n"
    )
    series = solve(case).series
    assert (series.a[-1], series.delta[-1]) == pytest.approx((0.1, 0.01), rel=1e-10)


def test_two_spheres_of_code_aster() -> None:
    """R = 50 mm, E = 20 GPa, nu = 0.3, brought 4 mm nearer: a = 10 mm, p0 = 2798.3 MPa as printed."""
    series = solve(
        Problem(Paraboloid(0.025, Elastic(20e9, 0.3)), half_space(20e9, 0.3), Loading.given("depth", (4e-3,)))
    )
    a, P = float(series.series.a[-1]), float(series.series.P[-1])
    assert a == pytest.approx(10e-3, rel=1e-10)
    assert 3 * P / (2 * math.pi * a**2) == pytest.approx(2798.3e6, rel=2e-5)


ATOMICJ = {  # nu = 1/2, bonded or not: R delta/h^2 and P R/(E* h^3) of AtomicJ's fit, and of an own Fredholm equation
    "bonded": ((0.1, 0.06581201, 0.065759078), (1.0, 6.8226373, 6.8204983), (5.0, 348.99206, 348.85081),
               (20.0, 15336.658, 15339.028)),
    "frictionless": ((0.1, 0.05525632, 0.055212468), (1.0, 3.3385724, 3.3393374), (20.0, 1257.7377, 1257.6306)),
}  # fmt: skip


@pytest.mark.first(3)
@pytest.mark.parametrize(("base", "depth", "peer", "exact"), [(b, *row) for b, rows in ATOMICJ.items() for row in rows])
def test_layers_of_atomicj(base: str, depth: float, peer: float, exact: float) -> None:
    """AtomicJ has polynomials fitted to its solution, up to 8e-4 off: ours is right."""
    R = 1e6
    layer = Specimen((Layer(Elastic(0.75, 0.5), 1.0),), Rigid(bonded=base == "bonded"))
    found = at(Paraboloid(R), layer, "depth", depth / R)
    assert found["P"] * R == pytest.approx(exact, rel=4e-8)  # its eight digits
    assert found["P"] * R == pytest.approx(peer, rel=9e-4)
    if (base, depth) == ("bonded", 20.0):
        assert found["a"] == pytest.approx(7.8265738, rel=2e-8)
        assert found["a"] == pytest.approx(7.83079, rel=6e-4)


@pytest.mark.parametrize(("nu", "peer", "exact"), [(0.1, 32.44093, 32.41556), (0.3, 38.9696, 38.9559)])
def test_stiffness_of_layers_of_atomicj(nu: float, peer: float, exact: float) -> None:
    """S/(2 E* a) at a/h = 20, where AtomicJ's fit is off most."""
    found = at(Paraboloid(1000.0), Specimen((Layer(Elastic(1.0, nu), 1.0),), Rigid()), "radius", 20.0)
    ratio = found["S"] * (1 - nu**2) / 40
    assert ratio == pytest.approx(exact, rel=2e-6)
    assert ratio == pytest.approx(peer, rel=9e-4)


@pytest.mark.parametrize(
    ("depth", "peer", "exact", "parabola"), [(1e-6, 17.211, 15.997, 17.778), (3e-6, 86.186, 82.423, 93.286)]
)
def test_blunt_cones_of_atomicj(depth: float, peer: float, exact: float, parabola: float) -> None:
    """R = 1 um, 35 deg, E = 10 kPa, nu = 1/2, in nN. AtomicJ's cap is not tangent to its cone: 7.6 and 4.6 % stiffer
    than the exact spherical one, which is ours."""
    P = [at(RoundedCone(1e-6, math.radians(35), cap=cap), half_space(10e3, 0.5), "depth", depth)["P"] * 1e9
         for cap in ("sphere", "parabola")]  # type: ignore[arg-type]  # fmt: skip
    assert P == pytest.approx([exact, parabola], abs=6e-4)
    assert 0.04 < peer / P[0] - 1 < 0.08


@pytest.mark.parametrize(("faces", "bilodeau", "more"), [(3, 0.8887, 0.007), (4, 0.7453, 0.010)])
def test_pyramids_of_nanite_and_atomicj(faces: int, bilodeau: float, more: float) -> None:
    """They take Bilodeau's approximation, 0.7 and 1.0 % above boundary elements (``tests/bodies/test_tips.py``)."""
    found = at(Pyramid.of(faces, math.radians(20)), half_space(0.75, 0.5), "depth", 1.0)
    ours = found["P"] / math.tan(math.radians(20))
    assert bilodeau / ours - 1 == pytest.approx(more, abs=6e-4)


def test_jkr_of_a_biofilm_code() -> None:
    """R = 0.8, E* = 3900, w = 200 (its gamma is half of that): a at delta = 0.1, and at P = 0."""
    body = half_space(2925.0, 0.5)
    series = solve(Problem(Paraboloid(0.8), body, Loading("radius", 1.0, 300, "log"))).series
    curve = transform(series, "exact", 200.0)
    assert float(curve.at(np.array(0.6726338308))[0]) == pytest.approx(0.1, rel=1e-8)
    jump = lost(Paraboloid(0.8), body, 200.0, 1.2)[0]["jump_in"]
    assert jump["a_m"] == pytest.approx(0.7741692485979158, rel=1e-9)


@pytest.mark.parametrize(("R", "peer", "digits"), [(0.05, 0.0107, 5e-3), (1.0, 0.0284, 2.4e-2)])
def test_overlap_at_rest_of_lethe(R: float, peer: float, digits: float) -> None:
    """Two spheres of R = 0.1, and one of R = 1 on a wall of its material, E = 1e5, nu = 0.3, w = 100. The wall's run
    ends while the particle still moves, 2.3 % from its rest a^2/(3R), a^3 = 9 pi w R^2/(2 E*)."""
    E_star = 1e5 / 0.91 / 2
    a = (9 * math.pi * 100 * R**2 / (2 * E_star)) ** (1 / 3)
    body = Problem(Paraboloid(R, Elastic(1e5, 0.3)), half_space(1e5, 0.3), Loading("radius", 1.5 * a, 200))
    rest = pull_off(solve(body), w=100.0).summary()["controls"][0]["jump_in"]["delta_m"]
    assert rest == pytest.approx(a**2 / (3 * R), rel=1e-9)
    assert rest == pytest.approx(peer, rel=digits)


LAMBDAS = {1.0: -1.6007349112541056, 0.1: -1.9505948921234293, 0.3: -1.815555827044848, 3.0: -1.5167639000369295}


@pytest.mark.first(2)
@pytest.mark.parametrize("lam", LAMBDAS)
def test_maugis_dugdale_of_adhesion(lam: float) -> None:
    """P/(pi w R) under load control; units of Maugis: E* = R = w = 1, K = 4/3."""
    K = 4 / 3
    stress = lam / 2 * (math.pi * K**2) ** (1 / 3)
    found = lost(Paraboloid(1.0), half_space(0.75, 0.5), 1.0, 3.0, stress=stress)[0]["pull_off"]
    assert found["P_N"] / math.pi == pytest.approx(LAMBDAS[lam], rel=1e-9)
    if lam == 1.0:
        unit = (math.pi / K) ** (2 / 3)  # a0^2/R
        assert found["delta_m"] / unit == pytest.approx(-0.48423656, rel=1e-6)


def test_the_exact_sphere_of_atomicj() -> None:
    load, depth = (row["pull_off"]["P_N"] for row in lost(Sphere(5e-6), half_space(10e3, 0.5), 5e-3, 4.5e-6))
    assert load == pytest.approx(-1.01533897380794e-07, rel=1e-9)
    assert depth == pytest.approx(-6.184025963e-08, rel=3e-8)  # of the minimiser that gave it


def test_the_cone_of_maugis_and_barquins() -> None:
    """-54 w^2 tan^3(alpha)/(pi E*)."""
    tip, E_star = PowerLaw(1 / math.tan(math.radians(70)), 1.0), 1e6 / 0.75
    exact = -54 * 0.05**2 * math.tan(math.radians(70)) ** 3 / (math.pi * E_star)
    found = lost(tip, half_space(1e6, 0.5), 0.05, 4e-6, spacing="log")[0]["pull_off"]["P_N"]
    assert exact == pytest.approx(-6.684171042172978e-07, rel=1e-12)
    assert found == pytest.approx(exact, rel=1e-9)


@pytest.mark.slow
def test_the_flat_punch_of_kendall() -> None:
    found = lost(RoundedFlat(20e-6, 1e-9), half_space(1e6, 0.5), 0.05, 20.01e-6, spacing="log")[0]["pull_off"]["P_N"]
    exact = -math.sqrt(8 * math.pi * 1e6 / 0.75 * 0.05 * 20e-6**3)
    assert exact == pytest.approx(-1.15776200729e-04, rel=1e-11)
    assert found == pytest.approx(exact, rel=1e-9)


def test_ting_of_pyfmrheo() -> None:
    """Paraboloid of 5 um, cone of 35 deg, at 10 um/s to 1 um on E = 1 kPa (t/s)^-0.2: load at the turn, time of lost
    contact."""
    body = Specimen((), HalfSpace(Elastic(1e3, 0.5)), relaxation=PowerRelaxation(time=1.0, exponent=0.2))
    round_, cone = (
        cycle_relaxing(solve(Problem(tip, body, Loading("depth", 1.2e-6, 200))), speed=1e-5, to_depth=1e-6)
        for tip in (Paraboloid(5e-6), PowerLaw(1 / math.tan(math.radians(35)), 1.0))
    )
    assert (round_.peak.P, cone.peak.P) == pytest.approx((8.3574488e-09, 1.3083175e-09), rel=1e-7)
    assert round_.lost == pytest.approx(0.172547, abs=2e-6)


@pytest.mark.parametrize("base", ["bonded", "frictionless"])
def test_cones_on_layers_of_atomicj(base: str) -> None:
    """AtomicJ fits its solution to 8e-4; against an own quadrature: on a layer at least a hundred times as thick as the
    contact is wide the load is that of the half-space, (2/pi) E* tan(alpha) delta^2."""
    tip = PowerLaw(1 / math.tan(math.radians(85)), 1.0)
    layer = Specimen((Layer(Elastic(0.75, 0.5), 1.0),), Rigid(bonded=base == "bonded"))
    found = [at(tip, layer, "radius", a) for a in (1e-4, 1.0)]
    plain = [2 / math.pi * math.tan(math.radians(85)) * one["delta"] ** 2 for one in found]
    assert found[0]["P"] == pytest.approx(plain[0], rel=1e-3)
    assert found[1]["P"] > 1.5 * plain[1]


def graded(k: float, length: float) -> float:
    """-P/(pi w R) at pull-off of a paraboloid on E = top (1 + z/length)^k, nu = 0.3, at contact radii about 1 mm."""
    R, modulus = 1.0, (1e-3 / length) ** k
    body = Specimen((Layer(Graded(Power(1.0, length, k), 0.3), 1.0),), Rigid())
    w = 8 * modulus * 1e-9 / (9 * math.pi * R**2)
    solution = solve(Problem(Paraboloid(R), body, Loading("radius", 8e-3, 60, "log")))
    point = pull_off(solution, w=w).summary()["controls"][0]["pull_off"]
    return -float(point["P_N"]) / (math.pi * w * R)


@pytest.mark.slow
@pytest.mark.parametrize("k", [0.3, 0.6])
def test_graded_half_spaces_of_chen(k: float) -> None:
    """(k + 3)/2 pi w R where E grows as z^k from none on: with a thousandth of the contact radius as the length of the
    law 0.2 and 0.9 % less, which vanishes with it."""
    far, near = ((k + 3) / 2 - graded(k, length) for length in (1e-5, 1e-6))
    assert 0 < near < 0.01 * (k + 3) / 2
    assert near < far / 2


def test_a_synthetic_record_of_cellmechlab(jkr: Callable, tmp_path: Path) -> None:
    """Hertz of E = 5.3 kPa, R = 3.4 um, k = 0.032 N/m, noise 1 nN, under its header."""
    delta = np.concatenate([np.linspace(-2e-6, 0, 300, endpoint=False), np.linspace(0, 2e-6, 300)])
    P = 16 / 9 * 5.3e3 * math.sqrt(3.4e-6) * np.maximum(delta, 0.0) ** 1.5
    read = P + 1e-9 * np.random.default_rng(1).standard_normal(P.size)
    rows = np.stack([1e9 * (delta + P / 0.032), 1e9 * read], axis=1)
    np.savetxt(tmp_path / "curve.txt", rows, header="k: 0.032\n#z [nm] #force [nN]", comments="#", fmt="%.4f")
    done = jkr("fit", str(tmp_path / "curve.txt"), "--radius", "3.4 um", "--nu", "0.5", "--fix", "w=0", "--shape",
               "paraboloid", "--no-plots", "--json")  # fmt: skip
    assert done.code == 0, done.err
    found = json.loads(done.out)["curves"][0]["estimates"]["E_star"]
    assert found["value"] * 0.75 == pytest.approx(5.3e3, rel=0.02)
    assert found["low"] <= 5.3e3 / 0.75 <= found["high"]


OFF = {0.27: 0.021, 0.42: 0.056, 0.75: 0.135}  # by how much the series is too small, as the theory of layers says


def test_the_series_is_too_small_by_what_the_page_says() -> None:
    """F = (16/9) E sqrt(R) d^1.5 (1 + 1.133 x + 1.283 x^2 + 0.769 x^3 + 0.0975 x^4), x = sqrt(R d)/h, nu = 1/2."""
    E, R, h = 1.0, 100.0, 1.0
    x = np.array(list(OFF))
    delta = (x * h) ** 2 / R
    layer = Specimen((Layer(Elastic(E, 0.5), h),), Rigid(bonded=True))
    loading = Loading.given("depth", tuple(delta.tolist()))
    exact = solve(Problem(Paraboloid(R), layer, loading)).series.P
    series = 16 / 9 * E * np.sqrt(R) * delta**1.5 * np.polyval([0.0975, 0.769, 1.283, 1.133, 1.0], x)
    assert 1 - series / exact == pytest.approx(list(OFF.values()), abs=5e-4)

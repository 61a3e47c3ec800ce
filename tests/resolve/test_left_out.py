"""What a case leaves out, against closed forms and identities."""

import math
from dataclasses import replace

import numpy as np
import pytest
from maugis import Maugis
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from jkrcli.adhesion.curve import LOAD_CONTROL, transform
from jkrcli.base.errors import Unknown
from jkrcli.bodies.indenters import Paraboloid, Sphere
from jkrcli.bodies.problem import GEL_TENSION, Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.formulas import over_hertz, over_jkr, sneddon_sphere
from jkrcli.methods.layered.solver import Layered
from jkrcli.resolve.neglected import LEFT_OUT_GLASS, NeglectedEffect, neglected_effects, preview_effects
from studies.stack_judge import _at

GLASS = Elastic(*LEFT_OUT_GLASS)
R, a = 1e-5, 2e-6
RUBBER = Elastic(1e6, 0.5)


def found(
    specimen: Specimen, w: float = 0.0, indenter: object = None, z0: float = 3e-10, **more: object
) -> dict[str, NeglectedEffect]:
    problem = Problem(indenter or Paraboloid(R), specimen, Loading("radius", a, 40), **more)
    works = (w,) if w else ()
    rows = neglected_effects(problem, preview_effects(problem, works, z0), works, z0)
    known = [abs(one.largest[1]) for one in rows if one.largest]
    assert known == sorted(known, reverse=True)
    assert [one.largest is None for one in rows] == sorted(one.largest is None for one in rows)  # what is unknown last
    return {" ".join(one.name.split()[:2]).rstrip(","): one for one in rows}


def half_space(material: Elastic = RUBBER) -> Specimen:
    return Specimen((), HalfSpace(material))


def layer(h: float, material: Elastic = RUBBER) -> Specimen:
    return Specimen((Layer(material, h),), Rigid())


def test_an_elastic_indenter_on_a_half_space_lowers_the_modulus_and_leaves_the_pull_off_force() -> None:
    stiff = Elastic(20e9, 0.3)
    one = found(half_space(stiff), 1.0)["elastic indenter"]
    expected = GLASS.E_star / (GLASS.E_star + stiff.E_star) - 1
    assert one.load == pytest.approx(expected, rel=1e-6)
    assert one.S == pytest.approx(expected, rel=1e-6)
    assert one.pull_off[1.0] == pytest.approx(0, abs=1e-5)


def test_an_exact_sphere_is_sneddons() -> None:
    one = found(half_space())["exact sphere"]
    at = brentq(lambda r: r * math.atanh(r / R) - a**2 / R, 0.5 * a, a, xtol=1e-15)
    expected = float(sneddon_sphere(np.array(at), RUBBER.E_star, R)[1]) / (4 * RUBBER.E_star * a**3 / (3 * R)) - 1
    assert one.load == pytest.approx(expected, rel=2e-3)  # 1e-5 of the load, measured
    assert one.S == pytest.approx(at / a - 1, rel=2e-3)
    assert "exact sphere" not in found(half_space(), indenter=Sphere(R))


@pytest.mark.parametrize(("E", "within"), [(1e6, 0.2), (1e9, 1e-3)], ids=["solved for", "first order"])
def test_a_slight_surface_tension_on_a_half_space(E: float, within: float) -> None:
    """At equal depth the logarithms of P_H and delta_H cancel: 3 kappa/(pi a), and 2 kappa/(pi a) of S."""
    one = found(half_space(Elastic(E, 0.5)))["surface tension"]
    kappa = 2 * GEL_TENSION / Elastic(E, 0.5).E_star
    assert one.load == pytest.approx(3 * kappa / (math.pi * a), rel=within)  # (kappa l/a)^2 beside it
    assert one.S == pytest.approx(2 * kappa / (math.pi * a), rel=within)


def of_many_radii(specimen: Specimen, w: float, radii: int = 120) -> tuple[float, float, float]:
    """What a tension changes of load and S at the depth of ``a``, and of the pull-off force for ``w``."""
    plain, tense = (
        Layered(1e-5)(Problem(Paraboloid(R), one, Loading("radius", a, radii, "log"))).series
        for one in (specimen, replace(specimen, surface_tension=GEL_TENSION))
    )
    load, S = (
        math.exp(float(CubicSpline(np.log(tense.delta), np.log(column))(math.log(plain.delta[-1])))) / end - 1
        for column, end in ((tense.P, plain.P[-1]), (tense.S, plain.S[-1]))
    )
    pulled = [transform(series, "exact", w).pull_off(LOAD_CONTROL).P for series in (tense, plain)]
    return load, S, pulled[0] / pulled[1] - 1


@pytest.mark.first(1)
@pytest.mark.parametrize(("E", "w"), [(1e6, 1e-3), (3e4, 2e-5)], ids=["near", "elsewhere"])
def test_a_surface_tension_on_a_layer_is_that_of_many_radii(E: float, w: float) -> None:
    """Solved around pull-off without it; over all radii where pull-off with it lies elsewhere."""
    specimen = layer(4e-6, Elastic(E, 0.45))
    one = found(specimen, w)["surface tension"]
    load, S, pulled = of_many_radii(specimen, w)
    assert one.load == pytest.approx(load, rel=1e-4)
    assert one.S == pytest.approx(S, rel=3e-4)
    assert one.pull_off[w] == pytest.approx(pulled, rel=5e-6)


def test_a_w_that_wets_has_no_pull_off_under_that_tension() -> None:
    one = found(half_space(), 0.061)["surface tension"]
    assert isinstance(one.load, float)
    assert "more than twice the surface tension, 30 mN/m" in str(one.pull_off[0.061])


def test_no_slip_on_a_half_space_changes_load_and_S_alike() -> None:
    """P = 2/3 S delta of every contact that is similar to itself; nothing changes at nu = 1/2."""
    w, nu = 0.01, 0.2
    one = found(half_space(Elastic(1e6, nu)), w)["no slip"]
    assert one.load == pytest.approx(one.S, rel=5e-3)
    # S = 2 E* sigma a and delta_H = c a^2/R: at equal depth S is sigma/sqrt(c) times as large, the pull-off force 1/c.
    sigma = (1 - nu) * math.log(3 - 4 * nu) / (1 - 2 * nu)
    assert one.S == pytest.approx(sigma * math.sqrt(1 + one.pull_off[w]) - 1, rel=0.01)
    none = found(half_space())["no slip"]
    assert (none.load, none.S) == pytest.approx((0, 0), abs=1e-4)


def test_slip_is_the_other_way_round() -> None:
    gel = layer(0.5 * a)
    without, with_ = found(gel)["no slip"], found(gel, sticks=True)["slip"]
    assert (1 + without.load) * (1 + with_.load) == pytest.approx(1, rel=1e-3)
    assert with_.key == 'specimen.surface = "sliding"'


def test_a_base_of_the_layers_own_material_is_the_half_space() -> None:
    rows = found(layer(a, GLASS), 1.0)
    base, formula = rows["elastic substrate"], rows["half-space formula"]
    assert formula.included
    assert formula.key == ""
    assert base.load == pytest.approx(formula.load, rel=1e-4)
    assert base.S == pytest.approx(formula.S, rel=1e-4)
    assert base.pull_off[1.0] == pytest.approx(formula.pull_off[1.0], rel=2e-3)


def test_large_strains_are_those_of_rubber() -> None:
    one = found(half_space())["large strains"]  # a/R = 0.2
    assert one.load == pytest.approx(1 / 1.015 - 1)
    assert one.S == pytest.approx(4 / 3 * one.load)
    assert isinstance(found(half_space(Elastic(1e6, 0.3)))["large strains"].load, Unknown)
    assert isinstance(found(layer(0.5 * R))["large strains"].load, Unknown)


def test_a_range_of_adhesion_is_maugis_own() -> None:
    w = 1e-4
    one = found(half_space(Elastic(1e5, 0.5)), w, z0=2e-8)["range of"]
    E = Elastic(1e5, 0.5).E_star
    lam = 2 * (w / 2e-8) * (R / (math.pi * w * (4 * E / 3) ** 2)) ** (1 / 3)
    states = Maugis(R, E, w, lam, 1 + np.geomspace(1e-4, 1e3, 40_000))
    assert one.pull_off[w] == pytest.approx(-states.P.min() / (1.5 * math.pi * w * R) - 1, rel=0.02)
    at = a**2 / R - math.sqrt(2 * math.pi * w * a / E)
    order = np.argsort(states.delta[states.a > a / 2])
    load = np.interp(at, states.delta[states.a > a / 2][order], states.P[states.a > a / 2][order])
    jkr = 4 * E * a**3 / (3 * R) - math.sqrt(8 * math.pi * w * E * a**3)
    assert one.load == pytest.approx((load - jkr) / (4 * E * a**3 / (3 * R)), rel=0.05)


def weighed(eps: float) -> tuple[float, ...]:
    """S/(2 E*), S'/(2 E*), delta_H and P_H/(2 E*) of the radius 1 under a paraboloid R = 1 on a half-space of the
    kernel g - 1 = -eps/(k + eps)."""
    edges = np.concatenate([[0.0], np.geomspace(1e-10, 1, 40), np.arange(2.0, 400.0)])
    x, w = np.polynomial.legendre.leggauss(16)
    half = np.diff(edges)[:, None] / 2
    k = np.ravel(edges[:-1, None] + half * (1 + x))
    delta, P, S, dS = _at(1.0, k, np.ravel(half * w) * -eps / (k + eps), 1.0, 0.5).tolist()
    return S, dS, delta, P


@pytest.mark.slow
def test_weight_of_a_half_space_against_its_integral_equation() -> None:
    eps, none = 1e-5, weighed(1e-12)
    S, dS, depth, P = (here / there for here, there in zip(weighed(eps), none, strict=True))
    density = eps / 2 / 9.80665
    load, stiffness = over_hertz(math.sqrt(none[2] * depth), 1.0, density)
    assert P / depth**1.5 - 1 == pytest.approx(load, rel=3e-3)
    assert S / math.sqrt(depth) - 1 == pytest.approx(stiffness, rel=3e-3)
    # JKR's P at its lowest, where Hertz carries 1/2 and adhesion 1 of 3/2: no logarithm is left.
    change = 0.5 * (P - 1) - (S / math.sqrt(dS) - 1)
    assert -change / 0.5 == pytest.approx(over_jkr(1.0, 1.0, density), rel=5e-3)


def test_weight_of_a_soft_half_space_alone_is_told() -> None:
    soft = Elastic(100.0, 0.5)
    one = found(half_space(soft), 1e-6)["weight of"]
    assert one.load > 0
    assert one.S > one.load
    assert "weight of" not in found(half_space(Elastic(100.0, 0.3)))
    assert "weight of" not in found(layer(R, soft))

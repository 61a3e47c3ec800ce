"""Judging a result by its numbers: published Tabor numbers, limits and reasons."""

import math

import pytest

from jkrcli.adhesion.validity import NO_TIP_RADIUS, SHARP_PRESSURE, judge, regime
from jkrcli.base.errors import Unknown
from jkrcli.bodies.indenters import PowerLaw
from jkrcli.bodies.problem import Elastic, Graded, HalfSpace, Layer, Linear, Loading, Problem, Rigid, Specimen
from jkrcli.case.store import solve
from jkrcli.resolve.analysis import analyse

SOUND = {"a": 1e-5, "delta": 1e-6, "E_star": 5e9 / 0.84, "w": 50.0, "R": 1e-4, "h": None, "L": None, "z0": 0.3e-9}


@pytest.mark.parametrize(("w", "R", "published"), [(50.0, 1e-4, 639), (10.0, 1e-3, 471)])
def test_tabor_numbers_of_the_paper(w: float, R: float, published: float) -> None:
    judged = judge(**{**SOUND, "w": w, "R": R})  # Secs. 4.1 and 4.2
    assert judged.tabor == pytest.approx(published, abs=0.5)  # printed as integers
    assert judged.regime == "JKR holds"
    assert judged.warnings == []


@pytest.mark.parametrize(
    ("number", "word"), [(639, "JKR holds"), (5.1, "holds"), (4.9, "Maugis"), (0.1, "Maugis"), (0.09, "DMT")]
)
def test_regimes_in_words(number: float, word: str) -> None:
    assert word in regime(number)


def test_every_limit_warns_with_its_number() -> None:
    judged = judge(a=4e-5, delta=2e-6, E_star=1e9, w=1e-5, R=1e-4, h=1e-5, L=2e-4, z0=1e-9, a_pull_off=1e-5)
    warnings = judged.warnings
    assert [line.split(" is ")[0].split(" at ")[0] for line in warnings] == [
        "a/R = 0.4",
        "delta/h = 0.2",
        "a/L = 0.2",
        "Tabor number 0.0215",
    ]
    assert "DMT" in warnings[-1]
    assert judged.a_over_R_pull_off == pytest.approx(0.1)
    assert judged.a_over_h == pytest.approx(4)


def test_the_side_of_a_finite_specimen_is_part_of_its_solution() -> None:
    judged = judge(**{**SOUND, "a": 0.2, "R": 10.0, "L": 1.0, "end_is_cut": False})
    assert judged.a_over_L == pytest.approx(0.2)
    assert not any("a/L" in line for line in judged.warnings)
    assert any("a/L = 0.2" in line for line in judge(**{**SOUND, "a": 0.2, "R": 10.0, "L": 1.0}).warnings)


def test_at_the_limits_nothing_is_said() -> None:
    w = 125**0.5 * (1 + 1e-9)
    judged = judge(a=0.3, delta=0.1, E_star=1.0, w=w, R=1.0, h=1.0, L=3.0, z0=1.0)  # Tabor (w^2)^(1/3) = 5
    assert judged.tabor == pytest.approx(5, rel=1e-9)
    assert judged.warnings == []
    rounded = judge(a=1e-6, delta=1e-6 * (1 + 1e-12), E_star=1e6, w=0.0, R=1e-4, h=1e-5, L=None, z0=None)
    assert rounded.warnings == []


def test_what_cannot_be_judged_says_why() -> None:
    judged = judge(**{**SOUND, "R": None})
    assert judged.tabor == judged.a_over_R == NO_TIP_RADIUS
    assert judged.regime == f"unknown: {NO_TIP_RADIUS}"
    assert judged.delta_over_h == judged.a_over_h == Unknown("no layer: the specimen is a half-space")
    assert judged.a_over_L == Unknown("the body is unbounded in this method")
    assert judged.warnings == []
    assert judge(**{**SOUND, "z0": None}).tabor == Unknown("no equilibrium distance z0 given")
    assert judge(**{**SOUND, "w": 0.0}).tabor == Unknown("no adhesion (w = 0)")


def test_a_stiff_skin_is_not_squeezed() -> None:
    """delta/h asks how far a layer is pressed against something stiffer: what lies under a skin gives way itself."""
    skin, soft, stiff = (Layer(Elastic(E, 0.4), 1e-6) for E in (20e6, 1e6, 5e6))
    depths = [Specimen(layers, base).yielding_depth for layers, base in (
        ((skin,), HalfSpace(Elastic(1e6, 0.4))), ((skin,), Rigid()), ((skin, soft), Rigid()), ((soft, stiff), Rigid()),
        ((skin, soft), HalfSpace(Elastic(0.9e6, 0.4))), ((), HalfSpace(Elastic(1e6, 0.4))))]  # fmt: skip
    assert depths == pytest.approx([math.inf, 1e-6, 1.05e-6, 1.2e-6, math.inf, math.inf])
    wafer = Layer(Elastic(100e9, 0.2), 1e-3)
    assert Specimen((soft, wafer), HalfSpace(Elastic(0.5e6, 0.4))).yielding_depth == pytest.approx(1e-6)
    judged = judge(**{**SOUND, "delta": 2e-6, "h": 1e-6, "depth": math.inf})
    assert isinstance(judged.delta_over_h, Unknown)
    assert judged.delta_over_h.reason == "no layer lies on anything stiffer"
    assert not any("delta/h" in text for text in judged.warnings)


def test_all_layers_of_a_stack_are_squeezed() -> None:
    """Of many layers the displacement is that of all of them, not of the first that lies on a stiffer one."""
    stack = [Layer(Elastic(E, 0.4), 1e-6) for E in (1e6, 2e6) * 500]
    assert Specimen(tuple(stack), Rigid()).yielding_depth == pytest.approx(750e-6)
    assert Specimen(tuple(stack), HalfSpace(Elastic(5e6, 0.4))).yielding_depth == pytest.approx(750e-6)
    graded = Layer(Graded(Linear(1e6, 3e6, 1e-6), 0.4), 1e-6)  # 1e6 int dz/E = h ln(3)/2
    squeezed = Specimen((graded,), Rigid()).yielding_depth * graded.mean_modulus
    assert squeezed / 1e6 == pytest.approx(2e-6 / math.log(3), rel=1e-9)


CONE = PowerLaw(1 / math.tan(math.radians(70)), 1.0)
W = 0.05


def pressed(indenter: object, E: float, depth: float = 50e-9, spacing: str = "log") -> Problem:
    body = Specimen((), HalfSpace(Elastic(E, 0.4)))
    return Problem(indenter, body, Loading("depth", depth, 100, spacing))  # type: ignore[arg-type]


def radius_of_cone(E: float) -> float:
    """Contact radius [m] at pull-off under load control: a length that w/E* alone gives, taken from a soft cone."""
    found = analyse(solve(pressed(CONE, 1e9, 5e-6))[1], [W])[0].pull_off["load"]
    return found.a * 1e9 / E  # a ~ w/E*


@pytest.mark.parametrize(("control", "spacing"), [("load", "log"), ("displacement", "radius")])
def test_a_stiff_cone_has_no_pull_off_at_picometres_and_no_advice_in_a_circle(control: str, spacing: str) -> None:
    assert radius_of_cone(70e9) < 0.1e-9
    found = analyse(solve(pressed(CONE, 70e9, spacing=spacing))[1], [W])[0].pull_off[control]
    assert isinstance(found, Unknown)
    assert "below the interatomic spacing, z0 = 300 pm" in found.reason
    assert "log" not in found.reason


def test_a_soft_cone_keeps_its_pull_off() -> None:
    found = analyse(solve(pressed(CONE, 1e7, 5e-6))[1], [W])[0].pull_off["load"]
    assert found.a == pytest.approx(radius_of_cone(1e7), rel=1e-3)  # measured: 1e-6


def said(E: float, half_angle: float, specimen: Specimen | None = None) -> bool:
    problem = pressed(PowerLaw(1 / math.tan(math.radians(half_angle)), 1.0), E)
    if specimen is not None:
        problem = Problem(problem.indenter, specimen, problem.loading)
    return any("flow plastically" in warning for warning in analyse(solve(problem)[1], [W])[0].warnings)


def test_plasticity_is_hinted_at_where_the_mean_pressure_exceeds_a_tenth_of_the_modulus() -> None:
    limit = math.degrees(math.atan(1 / (2 * SHARP_PRESSURE)))  # Sneddon's cone: mean pressure = E* cot(angle)/2
    assert said(70e9, limit - 1)
    assert not said(70e9, limit + 1)
    assert not said(1e6, limit - 1), "a gel does not flow"
    thin = Specimen((Layer(Elastic(70e9, 0.4), 20e-9),), Rigid())
    assert not said(70e9, limit - 1, thin), "confined"

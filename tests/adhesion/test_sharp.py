"""Tips too sharp for a continuum, and pressures at which bodies flow."""

import math

import pytest

from jkrcli.adhesion.validity import SHARP_PRESSURE
from jkrcli.base.errors import Unknown
from jkrcli.bodies.indenters import Paraboloid, PowerLaw
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.case.store import solve
from jkrcli.resolve.analysis import analyse

CONE = PowerLaw(1 / math.tan(math.radians(70)), 1.0)
W = 0.05


def pressed(indenter: object, E: float, depth: float = 50e-9, spacing: str = "log") -> Problem:
    body = Specimen((), HalfSpace(Elastic(E, 0.4)))
    return Problem(indenter, body, Loading("depth", depth, 100, spacing))  # type: ignore[arg-type]


def radius_of_cone(E: float) -> float:
    """Contact radius [m] at pull-off under load control: a length that w/E* alone gives, taken from a soft cone."""
    found = analyse(solve(pressed(CONE, 1e9, 5e-6))[1], [W])[0].pull_off["load"]
    return found.a * 1e9 / E  # a ~ w/E*


@pytest.mark.parametrize("spacing", ["log", "radius"])
@pytest.mark.parametrize("control", ["load", "displacement"])
def test_a_stiff_cone_has_no_pull_off_at_picometres_and_no_advice_in_a_circle(control: str, spacing: str) -> None:
    assert radius_of_cone(70e9) < 0.1e-9
    found = analyse(solve(pressed(CONE, 70e9, spacing=spacing))[1], [W])[0].pull_off[control]
    assert isinstance(found, Unknown)
    assert "below the interatomic spacing, z0 = 300 pm" in found.reason
    assert "log" not in found.reason


def test_a_soft_cone_keeps_its_pull_off() -> None:
    found = analyse(solve(pressed(CONE, 1e7, 5e-6))[1], [W])[0].pull_off["load"]
    assert found.a == pytest.approx(radius_of_cone(1e7), rel=1e-3)  # measured: 1e-6


def test_a_round_tip_far_above_atoms_is_left_alone() -> None:
    found = analyse(solve(pressed(Paraboloid(1e-7), 1e9, 1e-8, "radius"))[1], [W])[0]
    assert found.pull_off["load"].P == pytest.approx(-1.5 * math.pi * W * 1e-7, rel=1e-6)


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

"""Contact pressure, surface shape and the singular edge at one contact radius."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from jkrcli.base.errors import InputError, Refusal
from jkrcli.bodies.indenters import Paraboloid, PowerLaw, RoundedFlat, Sphere, TableProfile
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.methods.layered.solver import Profile, surface_profile

HALF_SPACE = Specimen((), HalfSpace(Elastic(1.0, 0.3)))
INCOMPRESSIBLE = Specimen((Layer(Elastic(1.0, 0.5), 1.0),), Rigid())
STIFF_COATING = Specimen((Layer(Elastic(1e3, 0.3), 1.0),), HalfSpace(Elastic(1.0, 0.5)))
SOFT_COATING = Specimen((Layer(Elastic(1.0, 0.45), 1.0), Layer(Elastic(9.0, 0.2), 0.5)), HalfSpace(Elastic(10.0, 0.25)))
BODIES = [HALF_SPACE, INCOMPRESSIBLE, STIFF_COATING, SOFT_COATING]
SHAPES = [Sphere(20.0), Paraboloid(50.0), PowerLaw(0.1, 1.0), PowerLaw(0.05, 1.5), RoundedFlat(1.0, 50.0)]


def at(specimen: Specimen, indenter: object, a: float, w: float = 0.0, **samples: np.ndarray) -> Profile:
    return surface_profile(Problem(indenter, specimen, Loading("radius", 1.0)), a, w, **samples)  # type: ignore[arg-type]


def integral_of_pressure(specimen: Specimen, indenter: object, a: float, w: float) -> tuple[float, float]:
    """P and int 2 pi r p dr by r = a sin(theta), panels graded to the axis and to a kink."""
    u, v = np.polynomial.legendre.leggauss(12)
    kink = np.arcsin(getattr(indenter, "a0", 0.0) / a)
    near = 0.5 * 0.4 ** np.arange(9)
    edges = np.unique([0, *near, kink, *(kink + near), *np.abs(kink - near), *np.linspace(0.6, np.pi / 2, 4)])
    theta = (edges[1:, None] + edges[:-1, None] + np.diff(edges)[:, None] * u).ravel() / 2
    weights = (np.diff(edges)[:, None] * v / 2).ravel()
    r = a * np.sin(theta)
    found = at(specimen, indenter, a, w, r=r)
    return found.P, float(np.sum(2 * np.pi * r * found.pressure * a * np.cos(theta) * weights))


def test_hertz_and_jkr_on_a_half_space() -> None:
    """p = 2 E* sqrt(a^2 - r^2)/(pi R) - sqrt(2 E* w a/pi)/sqrt(a^2 - r^2) (Johnson 1985, Eq. 5.48)."""
    E_star, R, a, w = Elastic(1.0, 0.3).E_star, 50.0, 2.0, 1e-3
    found = at(HALF_SPACE, Paraboloid(R), a, w)
    root = np.sqrt(a**2 - found.r**2)
    jkr = 2 * E_star * root / (np.pi * R) - np.sqrt(2 * E_star * w * a / np.pi) / root
    assert_allclose(found.pressure, jkr, rtol=1e-11, atol=1e-12)  # one sign change: relative to the larger part
    assert found.delta == pytest.approx(a**2 / R - np.sqrt(2 * np.pi * a * w / E_star), rel=1e-13)


def test_displacement_outside_a_hertz_contact() -> None:
    """u = [(2 a^2 - r^2) arcsin(a/r) + a sqrt(r^2 - a^2)]/(pi R) (Johnson 1985, Eq. 3.42a), and delta - f inside."""
    R, a = 50.0, 2.0
    r = np.array([2.0001, 2.5, 4.0, 30.0])
    u = ((2 * a**2 - r**2) * np.arcsin(a / r) + a * np.sqrt(r**2 - a**2)) / (np.pi * R)
    found = at(HALF_SPACE, Paraboloid(R), a, r_surface=np.concatenate([[0.0, 1.0, 2.0], r]))
    assert_allclose(found.displacement[3:], u, rtol=1e-11)  # at 30 m from terms a hundred times larger
    assert_allclose(found.displacement[:3], a**2 / R - np.array([0.0, 1.0, 4.0]) / (2 * R), rtol=1e-14)
    assert not found.gap[:3].any()


@pytest.mark.first(6)
@pytest.mark.parametrize("indenter", SHAPES)
@pytest.mark.parametrize("specimen", BODIES)
def test_pressure_integrates_to_the_load(specimen: Specimen, indenter: object) -> None:
    P, integral = integral_of_pressure(specimen, indenter, 2.0, 1e-4)
    assert integral == pytest.approx(P, rel=2e-9)  # the test's own quadrature near kinks and a cone's axis


@pytest.mark.first(4)
@pytest.mark.parametrize("specimen", BODIES)
@pytest.mark.parametrize("a", [0.1, 1.5, 10.0])
def test_edge_releases_the_work_of_adhesion(specimen: Specimen, a: float) -> None:
    """G = K_I^2/(2 E*) = w, with K_I from phi at the edge; and the pressure there has that K_I."""
    problem, w = Problem(Paraboloid(50.0), specimen, Loading("radius", a)), 1e-4
    s = 1e-9  # a - r over a: the next term of the pressure is smaller by sqrt(s), times the Hertz part
    found = surface_profile(problem, a, w, r=np.array([a * (1 - s)]))
    assert found.stress_intensity**2 / (2 * problem.E_star) == pytest.approx(w, rel=1e-9)
    without = surface_profile(problem, a, 0.0, r=np.array([a * (1 - s)]))
    assert without.stress_intensity == 0
    singular = (found.pressure[0] - without.pressure[0]) * np.sqrt(2 * np.pi * s * a)
    # the flat punch's own next term: 1e-9 times the amplification of a thin incompressible layer; a (1 - s) in rounding
    assert singular == pytest.approx(-found.stress_intensity, rel=1e-5)


def test_displacement_is_the_specimens_own() -> None:
    """Under an elastic indenter both half-spaces share the displacement as their compliances."""
    steel = Elastic(3.0, 0.2)
    r = np.array([0.0, 0.5, 1.0, 3.0])
    both = at(Specimen((), HalfSpace(Elastic(1.0, 0.3))), Paraboloid(50.0, steel), 1.0, r_surface=r)
    rigid = at(HALF_SPACE, Paraboloid(50.0), 1.0, r_surface=r)
    share = steel.E_star / (steel.E_star + Elastic(1.0, 0.3).E_star)
    assert_allclose(both.displacement, share * rigid.displacement, rtol=1e-11)
    assert_allclose(both.gap, rigid.gap, rtol=1e-11)


@pytest.mark.parametrize("indenter", [*SHAPES, TableProfile((0.0, 1.0, 2.0, 4.0), (0.0, 0.1, 0.3, 1.0))])
def test_abel_slope_is_the_derivative(indenter: object) -> None:
    x, step = np.array([0.3, 1.3, 2.7, 3.9]), 1e-5
    difference = (indenter.abel(x + step) - indenter.abel(x - step)) / (2 * step)  # type: ignore[attr-defined]
    assert_allclose(indenter.abel_slope(x), difference, rtol=1e-8, atol=1e-10)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"a": 0.0}, "contact radius must be between"),
        ({"a": 21.0}, "contact radius must be between"),
        ({"w": -1.0}, "work of adhesion must be >= 0"),
        ({"r": np.array([0.0])}, "0 < r < a"),
        ({"r": np.array([2.0])}, "0 < r < a"),
        ({"r_surface": np.array([25.0])}, "end of the profile"),
    ],
)
def test_wrong_requests_are_explained(arguments: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        at(INCOMPRESSIBLE, Sphere(20.0), **({"a": 2.0} | arguments))


def test_finite_specimens_are_refused() -> None:
    with pytest.raises(Refusal, match="finite radius"):
        at(Specimen(INCOMPRESSIBLE.layers, Rigid(), radius=9.0, side="free"), Sphere(20.0), 2.0)

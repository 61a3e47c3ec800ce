"""An elastic or coated tip on a surface under tension: a solution of its own in Hankel space, limits, identities."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import spherical_jn

from jkrcli.base.errors import InputError
from jkrcli.bodies.indenters import FlatPunch, Paraboloid, Sphere
from jkrcli.bodies.problem import Coated, Elastic, Graded, HalfSpace, Layer, Linear, Loading, Problem, Rigid, Specimen
from jkrcli.methods.layered.contact import LayeredContact
from jkrcli.methods.layered.solver import Layered
from jkrcli.methods.layered.spectrum import compliance
from jkrcli.methods.layered.surface_tension import TenseTipSolver
from jkrcli.methods.protocol import METHODS, method_class, refusal_of
from jkrcli.resolve.analysis import analyse

SOFT = Elastic(0.75, 0.5)  # E* = 1
RADII = np.linspace(0.05, 1.0, 20)


def under_tension(kappa: float, h: float | None = None, material: Elastic = SOFT) -> Specimen:
    """A half-space, or a bonded layer of the thickness ``h``, with 2 Ups/E* = ``kappa``."""
    tension = kappa * material.E_star / 2
    if h is None:
        return Specimen((), HalfSpace(material), surface_tension=tension)
    return Specimen((Layer(material, h),), Rigid(), surface_tension=tension)


def tip(ratio: float) -> Paraboloid:
    return Paraboloid(1.0, Elastic(0.75 * ratio, 0.5))


def columns(solver: object, tolerance: float = 1e-5) -> np.ndarray:
    result, errors = solver.refined(RADII, tolerance)
    assert errors.max() <= tolerance
    return result.columns


def stiffness(specimen: Specimen, ratio: float, terms: int = 60) -> float:
    """S of a flat end, a = 1: pressures of the Hankel transforms j_2n(k) make the energy stationary (Galerkin) under
    the compliance 2/(E*_i k) [1 + ratio g/(1 + kappa g k)]."""
    x, weights = np.polynomial.legendre.leggauss(40)
    edges = np.append(0.0, np.geomspace(1e-3, 4000.0, 400))
    k = (edges[:-1, None] + np.diff(edges)[:, None] * (x + 1) / 2).ravel()
    g = compliance(specimen, k)[0]
    symbol = (np.diff(edges)[:, None] * weights / 2).ravel() * ratio * g / (1 + specimen.tension_length * g * k)
    j = np.array([spherical_jn(2 * n, k) for n in range(terms)])
    A = np.diag(math.pi / (2 * (4 * np.arange(terms) + 1))) + (j * symbol) @ j.T
    return float(math.pi * ratio * np.linalg.inv(A)[0, 0])


@pytest.mark.parametrize(
    ("ratio", "kappa", "h", "rel"),
    [(1.0, 1.0, None, 2e-8), (0.1, 0.1, 1.0, 1e-7), (1.0, 30.0, 0.1, 1e-8)],
)
def test_stiffness_is_that_of_the_energy_in_hankel_space(
    ratio: float, kappa: float, h: float | None, rel: float
) -> None:
    """``rel``: what so many pressures leave, more where the tip is stiff and phi steep at the edge."""
    specimen = under_tension(kappa, h)
    S = columns(TenseTipSolver(tip(ratio), specimen))[2, -1]
    assert S == pytest.approx(stiffness(specimen, ratio), rel=rel)


def test_a_slight_tension_is_none() -> None:
    h = 1.0
    plain = replace(under_tension(1.0, h), surface_tension=0.0)
    expected = LayeredContact(tip(2.0), plain).refined(RADII, 1e-9)[0].columns
    off = [np.abs(columns(TenseTipSolver(tip(2.0), under_tension(kappa, h))) / expected - 1)[:, -1].max()
           for kappa in (1e-2, 1e-3)]  # fmt: skip
    assert off[0] < 0.05
    assert off[1] < 0.2 * off[0]


def test_loads_and_slopes_belong_to_one_energy() -> None:
    """dP_H = S d(delta_H), and S' is the slope of S."""
    a = 1.0 + 2e-3 * np.array([-2.0, -1, 0, 1, 2])
    result = TenseTipSolver(tip(5.0), under_tension(0.3, 1.0)).refined(a, 1e-5)[0]
    weights = np.array([1.0, -8, 0, 8, -1]) / (12 * 2e-3)
    delta, P, S = (weights @ column for column in (result.delta, result.P, result.S))
    assert P == pytest.approx(result.S[2] * delta, rel=1e-6)
    assert S == pytest.approx(result.dS[2], rel=1e-6)


def test_a_coating_of_the_core_is_no_coating_and_another_one_counts() -> None:
    core, specimen = Elastic(3.0, 0.3), under_tension(0.2, 1.0)
    same, softer = (Sphere(2.0, Coated((Layer(one, 0.3),), core)) for one in (core, Elastic(0.3, 0.3)))
    plain = columns(TenseTipSolver(Sphere(2.0, core), specimen))
    assert columns(TenseTipSolver(same, specimen)) == pytest.approx(plain, rel=1e-9)
    coated = columns(TenseTipSolver(softer, specimen))
    assert (coated[2] < 0.9 * plain[2]).all()
    alone = columns(TenseTipSolver(Sphere(2.0, Elastic(0.3, 0.3)), specimen))
    thick = Sphere(2.0, Coated((Layer(Elastic(0.3, 0.3), 300.0),), core))
    assert columns(TenseTipSolver(thick, specimen)) == pytest.approx(alone, rel=5e-3)  # like a/thickness


def test_the_stated_error_holds_the_true_one() -> None:
    solver = TenseTipSolver(tip(30.0), under_tension(0.1))
    result, errors = solver.refined(RADII, 1e-4)
    exact = solver.refined(RADII, 1e-7)[0].columns
    assert (np.abs(result.columns / exact - 1) <= errors).all()


def test_what_is_not_derived_is_refused_by_every_method() -> None:
    graded = Specimen((Layer(Graded(Linear(1.0, 2.0, 1.0), 0.3), 1.0),), surface_tension=0.1)
    cylinder = Specimen((Layer(SOFT, 1.0),), radius=5.0, side="free", surface_tension=0.1)
    for specimen in (graded, cylinder):
        problem = Problem(tip(2.0), specimen, Loading("radius", 0.5, 10))
        assert all(refusal_of(name, method_class(name)(), problem) for name in METHODS)
    with pytest.raises(InputError, match="without slip is not derived with surface tension"):
        Problem(tip(2.0), under_tension(0.1), Loading("radius", 0.5, 10), True)


def test_an_elastic_punch_lets_go_at_its_rim() -> None:
    """P = S sqrt(4 pi w R/S') with the S, S' of the flat end under tension."""
    problem = Problem(FlatPunch(1.0, Elastic(7.5, 0.5)), under_tension(0.3), Loading("radius", 1.0, 30))
    point = analyse(Layered()(problem), [1e-3])[0].pull_off["load"]
    S, dS = columns(TenseTipSolver(tip(10.0), under_tension(0.3)))[2:, -1]
    assert point.a == 1.0
    assert pytest.approx(-S * math.sqrt(4 * math.pi * 1e-3 / dS), rel=1e-5) == point.P

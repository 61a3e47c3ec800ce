"""The hybrid against node-based contact: two ways that share neither elements nor the contact problem."""

import numpy as np
import pytest
from finite_bodies import FINITE
from scipy.interpolate import CubicSpline

from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, Exponential, Graded, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.methods.fem import FEM
from jkrcli.methods.hybrid import Hybrid

GRADED = Specimen((Layer(Graded(Exponential(3.0, 1.0, 1.0), 0.4), 1.0),), Rigid(), 1.3, "clamped")
ROLLER = Specimen((Layer(Elastic(1.0, 0.3), 1.0),), Rigid(False), 30.0, "roller")


def at_depths(depths: np.ndarray, found: np.ndarray, delta: np.ndarray) -> np.ndarray:
    """A column at other depths: a cubic in logarithms through 80 points, good to 1e-7."""
    return np.exp(CubicSpline(np.log(delta), np.log(found))(np.log(depths)))


@pytest.mark.slow
@pytest.mark.parametrize("specimen", [*FINITE.values(), GRADED, ROLLER], ids=[*FINITE, "graded", "wide roller"])
def test_agreement_within_the_stated_errors(specimen: Specimen) -> None:
    """Loads and radii at equal depth, from a fifth of the largest radius on, where the finite elements are judged."""
    problem = Problem(Paraboloid(1000.0), specimen, Loading("radius", 0.9, 80))
    nodal, smooth = FEM()(problem), Hybrid(2e-5)(problem)
    both, a = nodal.series, smooth.series
    judged = (both.a > 0.2) & (both.delta < a.delta[-1])
    P, radius = (at_depths(both.delta[judged], column, a.delta) for column in (a.P, a.a))
    budget = nodal.budget
    own = smooth.budget.total
    assert np.abs(both.P[judged] / P - 1).max() < budget.discretisation + own
    assert np.abs(both.a[judged] / radius - 1).max() < budget.radius + own

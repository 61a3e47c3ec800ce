"""The method closed-form: refuses what it cannot represent, and thin layers where the exact solution disagrees."""

import numpy as np
import pytest

from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import Elastic, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.methods.closed_form import CLOSED_FORM_WORST, ClosedForm
from jkrcli.methods.layered.solver import Layered


@pytest.mark.parametrize(
    ("nu", "radii", "bonded"), [(0.3, (40.0, 48.0), True), (0.1, (35.0, 50.0), True), (0.49, (45.0, 50.0), False)]
)
def test_thin_layers_are_within_their_stated_error_of_the_exact_solution(nu, radii, bonded) -> None:
    stack = Specimen((Layer(Elastic(1.0, nu), 1.0),), Rigid(bonded))
    problem = Problem(Paraboloid(1000.0), stack, Loading.given("radius", radii))
    found, exact = ClosedForm()(problem), Layered(1e-6)(problem).series
    error = found.budget.discretisation
    assert 1e-3 < error <= CLOSED_FORM_WORST
    for name in ("delta", "P", "S", "dS"):
        ratio = getattr(found.series, name) / getattr(exact, name)
        assert np.max(np.abs(ratio - 1)) <= error * (1 + 1e-6)  # the check itself is good to 1e-6
    slope = np.gradient(np.log(found.series.S), np.log(found.series.a))
    np.testing.assert_allclose(found.series.dS * found.series.a / found.series.S, slope, rtol=1e-9)

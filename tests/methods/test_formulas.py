"""The method closed-form: refuses what it cannot represent, and thin layers where the exact solution disagrees."""

import numpy as np
import pytest

from jkrcli.base.errors import Refusal
from jkrcli.bodies.indenters import Paraboloid, PowerLaw, TableProfile
from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Rigid, Specimen
from jkrcli.methods.closed_form import CLOSED_FORM_WORST, ClosedForm
from jkrcli.methods.layered.solver import Layered

R, H = 1000.0, 1.0


def layer(nu: float, radii: tuple[float, ...], bonded: bool = True) -> Problem:
    stack = Specimen((Layer(Elastic(1.0, nu), H),), Rigid(bonded))
    return Problem(Paraboloid(R), stack, Loading.given("radius", radii))


@pytest.mark.parametrize(
    ("nu", "radii", "bonded"), [(0.3, (40.0, 48.0), True), (0.1, (35.0, 50.0), True), (0.49, (45.0, 50.0), False)]
)
def test_thin_layers_are_within_their_stated_error_of_the_exact_solution(nu, radii, bonded) -> None:
    problem = layer(nu, radii, bonded)
    found, exact = ClosedForm()(problem), Layered(1e-6)(problem).series
    error = found.budget.discretisation
    assert 1e-3 < error <= CLOSED_FORM_WORST
    for name in ("delta", "P", "S", "dS"):
        ratio = getattr(found.series, name) / getattr(exact, name)
        assert np.max(np.abs(ratio - 1)) <= error * (1 + 1e-6)  # the check itself is good to 1e-6
    slope = np.gradient(np.log(found.series.S), np.log(found.series.a))
    np.testing.assert_allclose(found.series.dS * found.series.a / found.series.S, slope, rtol=1e-9)


def test_thin_layers_outside_their_validity_are_refused_with_the_number() -> None:
    for nu, radii in ((0.4, (5.0, 17.0)), (0.499, (40.0, 50.0)), (0.5, (5.0, 17.0))):
        words = "the thin-layer formula (errs by|gives up to) .* between a/h = .*: use method layered"
        with pytest.raises(Refusal, match=words):
            ClosedForm()(layer(nu, radii))


def test_other_bodies_are_refused_with_the_remedy() -> None:
    two = Specimen((Layer(Elastic(1.0, 0.3), 1.0), Layer(Elastic(2.0, 0.3), 1.0)), Rigid())
    coated = Specimen((Layer(Elastic(1.0, 0.3), 1.0),), HalfSpace(Elastic(2.0, 0.3)))
    ground = Specimen((), HalfSpace(Elastic(1.0, 0.3)))
    loading = Loading("radius", 2.0)
    table = TableProfile((0.0, 2.0, 4.0), (0.0, 1.0, 4.0))
    layered = "solves homogeneous half-spaces and thin single isotropic layers only: use method"
    for problem, words in {
        Problem(Paraboloid(R), two, loading): layered,
        Problem(Paraboloid(R), coated, loading): layered,
        Problem(table, ground, loading): "there is no closed form for a tabulated profile: use method layered",
        Problem(PowerLaw(1.0, 1.0), layer(0.3, (1.0,)).specimen, loading): "the thin-layer formulae are for a rigid",
    }.items():
        reason = ClosedForm().refusal(problem)
        assert reason.startswith(words)

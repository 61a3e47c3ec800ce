"""The one search: what it does where its model has no state."""

import numpy as np
import pytest

from jkrcli.base.errors import SolveError
from jkrcli.measured.least_squares import LeastSquares, State
from jkrcli.measured.parameters import Answer, FittedValue


def test_a_step_to_where_nothing_can_be_solved_is_shortened() -> None:
    """From 3 the first step on atan(x) - 0.5 leads to -4.5."""

    def model(x: np.ndarray) -> State:
        if x[0] < 0:
            raise SolveError("no body")
        return State(np.arctan(x) - 0.5, lambda: (1 / (1 + x**2))[:, None])

    everywhere = np.array([-np.inf]), np.array([np.inf])
    found = LeastSquares(model, everywhere).least(np.array([3.0]))
    assert found.ended
    assert found.x[0] == pytest.approx(np.tan(0.5), rel=1e-6)
    with pytest.raises(SolveError):
        LeastSquares(model, everywhere).least(np.array([-1.0]))


def test_a_parameter_without_variance_correlates_with_none() -> None:
    """As a w of 0 whose root was fitted."""
    values = tuple(FittedValue(name, 1.0, True, "number", 0.1, 0.8, 1.2) for name in ("one", "two"))
    answer = Answer(estimates=values, free=("one", "two"), covariance=np.diag([0.01, 0.0]), dof=1)
    np.testing.assert_allclose(answer.correlation, [[1, 0], [0, 0]], rtol=1e-14)
    assert [*answer.hardly_apart] == []

"""The one search where its model has no state, and the cosine transform against SciPy's."""

from bisect import bisect_left

import numpy as np
import pytest
from scipy.fft import dct

from jkrcli.base.errors import SolveError
from jkrcli.measured.cosine import cosine_transform, fast_length
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
    values = tuple(FittedValue(name, 1.0, True, "number", 0.1, 0.8, 1.2) for name in ("one", "two"))
    answer = Answer(estimates=values, free=("one", "two"), covariance=np.diag([0.01, 0.0]), dof=1)
    np.testing.assert_allclose(answer.correlation, [[1, 0], [0, 0]], rtol=1e-14)
    assert [*answer.hardly_apart] == []


@pytest.mark.parametrize("rows", [1, 2, 3, 4, 5, 64, 1979])
def test_the_cosine_transform_is_that_of_scipy(rows: int) -> None:
    several = np.random.default_rng(rows).normal(size=(3, rows))
    expected = dct(several, norm="ortho")
    assert cosine_transform(several) == pytest.approx(expected, rel=1e-12, abs=1e-14)
    assert cosine_transform(several[0]) == pytest.approx(expected[0], rel=1e-12, abs=1e-14)


def test_fast_lengths_have_no_large_prime_factor() -> None:
    numbers = sorted(2**i * 3**j * 5**k for i in range(13) for j in range(9) for k in range(6))
    for n in range(1, 1000):
        assert fast_length(n) == numbers[bisect_left(numbers, n)]

"""The one search where its model has no state, the cosine transform against SciPy's, and flows that go on together:
one call of a kernel for all that wait, results in order, failures of their own only."""

from bisect import bisect_left
from typing import Any

import numpy as np
import pytest
from scipy.fft import dct

from jkrcli.base.errors import SolveError
from jkrcli.measured.cosine import cosine_transform, fast_length
from jkrcli.measured.least_squares import LeastSquares, State
from jkrcli.measured.lockstep import Flow, alone, ask, quiet, together
from jkrcli.measured.parameters import Answer, FittedValue


def test_searches_and_answers() -> None:
    # From 3 the first step on atan(x) - 0.5 leads to -4.5.
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


def squares(asked: list[float]) -> list[float | Exception]:
    calls.append(len(asked))
    return [SolveError("below 0") if x < 0 else x * x for x in asked]


def fragile(asked: list[float]) -> list[float | Exception]:
    return [1 / x for x in asked]


calls: list[int] = []


def powers(x: float, times: int) -> Flow[float]:
    for _ in range(times):
        x = yield from ask(squares, x)
    return x


def test_one_call_answers_all_that_wait_and_flows_that_end_leave() -> None:
    calls.clear()
    assert together([powers(2.0, times) for times in (3, 1, 2, 0)]) == [256.0, 4.0, 16.0, 2.0]
    assert calls == [3, 2, 1]
    assert alone(powers(3.0, 1)) == 9.0


def test_failures_are_of_their_own_flows_alone() -> None:
    def caught(x: float) -> Flow[float]:
        try:
            return (yield from ask(squares, x))
        except SolveError:
            return 0.0

    good, bad, mended = together([powers(2.0, 1), powers(-1.0, 1), caught(-1.0)])
    assert (good, mended) == (4.0, 0.0)
    assert isinstance(bad, SolveError)
    with pytest.raises(SolveError, match="below 0"):
        alone(powers(-1.0, 2))

    def inverse(x: float) -> Flow[Any]:
        return (yield from ask(fragile, x))

    good, bad = together([inverse(4.0), inverse(0.0)])
    assert good == 0.25
    assert isinstance(bad, ZeroDivisionError)

    def faulty(asked: list[float]) -> list[float]:
        return [{}[x] for x in asked]

    def flow() -> Flow[float]:
        return (yield from ask(faulty, 1.0))

    with pytest.raises(KeyError):
        together([flow(), flow()])


def test_warnings_of_arithmetic_are_off_while_a_quiet_flow_goes_on_and_on_while_it_waits() -> None:
    def steps() -> Flow[float]:
        lost = float(np.log(np.zeros(1))[0])
        x = yield from ask(watched, lost)
        return float(x / np.zeros(1)[0])

    def watched(asked: list[float]) -> list[float]:
        heard.append(np.geterr()["divide"])
        return [2.0] * len(asked)

    heard: list[str] = []
    with np.errstate(all="raise"):
        assert alone(quiet(steps())) == np.inf
        with pytest.raises(FloatingPointError):
            alone(steps())
    assert heard == ["raise"]

"""Flows that go on together: one call of a kernel for all that wait, results in order, failures of their own only."""

from typing import Any

import numpy as np
import pytest

from jkrcli.base.errors import SolveError
from jkrcli.measured.lockstep import Flow, alone, ask, quiet, together


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


def test_a_failure_is_of_its_own_flow_alone_and_can_be_caught_there() -> None:
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


def test_a_kernel_that_fails_as_a_whole_answers_each_question_alone() -> None:
    def inverse(x: float) -> Flow[Any]:
        return (yield from ask(fragile, x))

    good, bad = together([inverse(4.0), inverse(0.0)])
    assert good == 0.25
    assert isinstance(bad, ZeroDivisionError)


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


def test_a_fault_of_a_kernel_shows_itself() -> None:
    def faulty(asked: list[float]) -> list[float]:
        return [{}[x] for x in asked]

    def flow() -> Flow[float]:
        return (yield from ask(faulty, 1.0))

    with pytest.raises(KeyError):
        together([flow(), flow()])

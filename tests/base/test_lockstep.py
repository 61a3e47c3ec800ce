"""Flows that go on together: one call of a kernel for all that wait, results in order, failures of their own only."""

from __future__ import annotations

from typing import Any

import pytest

from jkrcli.base.errors import SolveError
from jkrcli.base.lockstep import Flow, alone, ask, together


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

"""The study of stated errors of adhesion of finite range: what counts as held, and its bodies."""

from __future__ import annotations

import pytest

from studies.range_bounds import RangeBound, judged, summary


@pytest.mark.parametrize(("beyond", "held"), [(0, True), (4, True), (5, False)])
def test_what_counts_as_held(beyond: int, held: bool) -> None:
    ratios = [1.5] * beyond + [0.3] * (200 - beyond)
    told = summary([RangeBound(i, "P", ratio, 1e-9, 0.1) for i, ratio in enumerate(ratios)], 200, 1)
    assert told["held"] is held
    assert told["beyond"] == beyond


def test_a_few_bodies_are_within_what_is_stated() -> None:
    found = [judged(number) for number in range(77000000, 77000004)]
    assert all(item is not None and 0 <= item.ratio <= 1 for item in found)


@pytest.mark.slow
def test_stated_errors_bound_the_true_ones() -> None:
    found = [item for number in range(1_000_000, 1_000_200) if (item := judged(number)) is not None]
    assert len(found) > 150
    assert summary(found, 200, 1)["held"]

"""The study of stated errors of adhesion of finite range: a few of its bodies."""

import pytest

from studies.bounds import summary
from studies.range_bounds import METHODS, judged


@pytest.mark.first(3)
@pytest.mark.parametrize("number", [77000001, 77000010, 77000002, 77000003])
def test_a_few_bodies_are_within_what_is_stated(number: int) -> None:
    found = judged(number)
    assert {item.method for item in found} <= {METHODS[number % 3]}
    assert all(0 <= item.ratio <= 1 for item in found)


@pytest.mark.slow
def test_stated_errors_bound_the_true_ones() -> None:
    found = [item for number in range(1_000_000, 1_000_100) for item in judged(number)]
    counts = summary(found, 100, 1)["all"]
    assert counts["compared"] > 500
    assert counts["beyond"] <= 0.01 * counts["compared"]
    assert not counts["beyond_three_times"]

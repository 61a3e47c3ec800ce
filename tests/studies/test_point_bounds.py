"""The study of stated errors of pull-off points by finite elements: a few of its bodies."""

import pytest

from studies.bounds import summary
from studies.point_bounds import judged


@pytest.mark.fem  # a body of which it is told counts as refused
@pytest.mark.first(1)
@pytest.mark.parametrize("number", [101000019, 101000004, 101000010])
def test_points_of_a_few_bodies_are_within_twice_what_is_stated(number: int) -> None:
    found = judged(number)
    assert len(found) > 30
    assert {item.column.split()[0] for item in found} == {"load", "displacement", "spring"}
    assert all(0 <= item.ratio <= 2 for item in found)


@pytest.mark.slow
def test_stated_errors_bound_the_true_ones() -> None:
    found = [item for number in range(1_000_000, 1_000_060) for item in judged(number)]
    counts = summary(found, 60, 1)["all"]
    assert counts["compared"] > 1000
    assert counts["beyond"] <= 0.02 * counts["compared"]
    assert not counts["beyond_three_times"]
    assert counts["stated_over_true"] <= 10

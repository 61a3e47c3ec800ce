"""The study of stated errors: what counts as held, and a few bodies of it."""

from __future__ import annotations

import numpy as np
import pytest

from studies.bounds import METHODS, Bound, body, judged, summary


def bounds(ratios: list[float], stated: float = 1e-5) -> list[Bound]:
    return [Bound(i, METHODS[i % 3], "P", ratio, stated) for i, ratio in enumerate(ratios)]


@pytest.mark.parametrize(
    ("ratios", "stated", "held"),
    [
        ([0.5] * 500, 1e-5, True),
        ([0.5] * 488 + [1.5] * 12, 1e-5, True),
        ([0.5] * 487 + [1.5] * 13, 1e-5, False),
        ([0.5] * 499 + [3.1], 1e-5, False),
        ([0.05] * 500, 1e-5, False),  # twenty times too large
        ([0.05] * 500, 1e-10, True),  # so small that it need not be near the truth
    ],
)
def test_what_counts_as_held(ratios: list[float], stated: float, held: bool) -> None:
    told = summary(bounds(ratios, stated), len(ratios), 1)
    assert told["held"] is held
    assert sum(told[method]["compared"] for method in METHODS) == told["all"]["compared"] == len(ratios)


def test_bodies_follow_from_their_number() -> None:
    assert body(np.random.default_rng(7)) == body(np.random.default_rng(7))


@pytest.mark.parametrize("number", [77000003, 77000008, 77000010])
def test_a_body_of_each_method_is_within_what_is_stated(number: int) -> None:
    found = judged(number)
    assert found is not None
    assert found.method == METHODS[number % 3]
    assert 0 <= found.ratio <= 1

"""Draws of a sweep's samples: limits and distributions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jkrcli.many.sweep_file import Distribution, draw


@settings(deadline=None)
@given(st.integers(0, 2**20), st.sampled_from(["random", "sobol", "latin-hypercube"]))
def test_draws_keep_their_limits(seed: int, method: str) -> None:
    items = [
        Distribution("uniform", {"from": -1.0, "to": 2.0}),
        Distribution("loguniform", {"from": 1e-3, "to": 1e3}),
        Distribution("normal", {"mean": 1.0, "sd": 0.5, "least": 0.9}),
        Distribution("lognormal", {"median": 2.0, "factor": 1.5, "most": 2.5}),
        Distribution("integer", {"from": 1, "to": 3}),
        Distribution("choice", {"values": ("a", "b")}),
    ]
    drawn = draw(items, 33, method, seed)
    assert drawn == draw(items, 33, method, seed)
    for uniform, log, normal, lognormal, integer, choice in drawn:
        assert -1 <= uniform <= 2
        assert 1e-3 * (1 - 1e-12) <= log <= 1e3 * (1 + 1e-12)
        assert normal >= 0.9
        assert 0 < lognormal <= 2.5
        assert integer in (1, 2, 3)
        assert choice in ("a", "b")


def test_draws_follow_their_distributions() -> None:
    """4096 Sobol points integrate smooth functions to about 1e-3: mean and sd of the normal, median of the lognormal,
    equal shares of three whole numbers."""
    items = [
        Distribution("normal", {"mean": 3.0, "sd": 0.2}),
        Distribution("lognormal", {"median": 2.0, "factor": 1.5}),
        Distribution("integer", {"from": 1, "to": 3}),
    ]
    normal, lognormal, integer = (np.array(values) for values in zip(*draw(items, 4096, "sobol", 0), strict=True))
    assert normal.mean() == pytest.approx(3.0, abs=1e-3)
    assert normal.std() == pytest.approx(0.2, rel=5e-3)
    assert np.median(lognormal) == pytest.approx(2.0, rel=2e-3)
    assert np.log(lognormal).std() == pytest.approx(np.log(1.5), rel=5e-3)
    assert [np.mean(integer == n) for n in (1, 2, 3)] == pytest.approx([1 / 3] * 3, abs=1e-3)

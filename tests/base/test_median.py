"""The median against NumPy's."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jkrcli.base.numerics import median


@given(st.lists(st.floats(-1e9, 1e9), min_size=1, max_size=40))
def test_the_median_is_that_of_numpy(values: list[float]) -> None:
    x = np.array(values)
    assert median(x) == pytest.approx(float(np.median(x)), rel=1e-15, abs=0)
    assert x.tolist() == values


def test_none_has_no_median() -> None:
    assert math.isnan(median(np.zeros(0)))

"""The cosine transform against SciPy's."""

from bisect import bisect_left

import numpy as np
import pytest
from scipy.fft import dct

from jkrcli.measured.cosine import cosine_transform, fast_length


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

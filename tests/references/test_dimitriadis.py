"""The series of Dimitriadis et al., Biophys. J. 82 (2002) 2798: a sphere on a bonded layer, beside the exact load."""

from __future__ import annotations

import numpy as np
import pytest

import jkrcli as python

OFF = {0.27: 0.021, 0.42: 0.056, 0.75: 0.135}  # by how much the series is too small, as the theory of layers says


def test_the_series_is_too_small_by_what_the_page_says() -> None:
    """F = (16/9) E sqrt(R) d^1.5 (1 + 1.133 x + 1.283 x^2 + 0.769 x^3 + 0.0975 x^4), x = sqrt(R d)/h, nu = 1/2."""
    E, R, h = 1.0, 100.0, 1.0
    x = np.array(list(OFF))
    delta = (x * h) ** 2 / R
    layer = python.Specimen((python.Layer(python.Elastic(E, 0.5), h),), python.Rigid(bonded=True))
    loading = python.Loading.given("depth", tuple(delta.tolist()))
    exact = python.solve(python.Problem(python.Paraboloid(R), layer, loading)).series.P
    series = 16 / 9 * E * np.sqrt(R) * delta**1.5 * np.polyval([0.0975, 0.769, 1.283, 1.133, 1.0], x)
    assert 1 - series / exact == pytest.approx(list(OFF.values()), abs=5e-4)

"""Fisher's and Student's distributions against SciPy's."""

import math

import numpy as np
import pytest
from scipy.special import fdtrc, fdtri, stdtrit

from jkrcli.base.numerics import f_quantile, f_tail

DOF = [1.0, 2.0, 3.5, 10.0, 57.0, 300.0, 2000.3, 1e5]
LOST = 1e-9  # theory: of a difference of gamma functions' logs of 1e5, 1e6 epsilon


@pytest.mark.parametrize("k", [1, 2, 3, 7, 30])
@pytest.mark.parametrize("dof", DOF)
def test_tails_of_f(k: int, dof: float) -> None:
    F = np.concatenate([[0.0], np.geomspace(1e-8, 600, 40), [math.inf, math.nan]])
    assert f_tail(k, dof, F) == pytest.approx(fdtrc(k, dof, F), rel=LOST, abs=1e-290, nan_ok=True)


@pytest.mark.parametrize(("dof", "F"), [(0.0, 1.0), (-1.0, 1.0), (math.nan, 1.0), (10.0, 1e-320), (10.0, 1e308)])
def test_ends_of_the_range(dof: float, F: float) -> None:
    assert float(f_tail(1, dof, F)) == pytest.approx(float(fdtrc(1, dof, F)), nan_ok=True)
    assert math.isnan(f_quantile(1, dof, 0.95)) == (not dof > 0)


def test_degrees_of_freedom_of_each() -> None:
    dof, F = np.array([3.0, 10.0, 1000.0]), np.array([2.0, math.nan, 4.0])
    assert f_tail(1, dof, F) == pytest.approx(fdtrc(1, dof, F), rel=LOST, nan_ok=True)


@pytest.mark.parametrize("level", [0.01, 0.5, 0.68, 0.95, 0.997, 1 - 1e-9])
@pytest.mark.parametrize("dof", DOF)
def test_quantiles(dof: float, level: float) -> None:
    for k in (1, 2, 7, 30):
        assert f_quantile(k, dof, level) == pytest.approx(fdtri(k, dof, level), rel=LOST)
    # 1 - level has round-off in the one-sided chance
    assert math.sqrt(f_quantile(1, dof, level)) == pytest.approx(stdtrit(dof, (1 + level) / 2), rel=1e-6)

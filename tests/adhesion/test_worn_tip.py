"""A worn tip by points: pull-off against the closed form of a truncated paraboloid."""

import math
import warnings

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from jkrcli import (
    Elastic,
    HalfSpace,
    Hybrid,
    Layer,
    Layered,
    Loading,
    Problem,
    Rigid,
    Specimen,
    TableProfile,
    pull_off,
    solve,
)

FLAT, R, E, NU, W = 60e-9, 500e-9, 10e6, 0.45, 0.05


def worn(points: int) -> TableProfile:
    """f = (r^2 - FLAT^2)/2R beyond the flat end, to 300 nm: of 61 points that at 60 nm is 1.7e-24 m high."""
    r = np.linspace(0, 300e-9, points)
    f = np.maximum(0.0, (r**2 - FLAT**2) / (2 * R))
    return TableProfile(tuple(r.tolist()), tuple(f.tolist()))


def load(a: float, w: float) -> float:
    """P(a) on a half-space: delta_H = a s/R, P_H = 2 E* (a delta_H - s^3/3R), s^2 = a^2 - FLAT^2, by Eq. 13."""
    s, E_star = math.sqrt(a**2 - FLAT**2), E / (1 - NU**2)
    return 2 * E_star * (a**2 * s / R - s**3 / (3 * R)) - math.sqrt(8 * math.pi * E_star * w * a**3)


def lowest(w: float) -> float:
    found = minimize_scalar(lambda x: 1e9 * load(x * 1e-9, w), bounds=(80, 250), method="bounded")
    return float(found.fun) * 1e-9


def pulled(tip: TableProfile, specimen: Specimen, method: Layered | Hybrid, w: float) -> tuple[float, float]:
    """Pull-off force under load control and its error [N]."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        solution = solve(Problem(tip, specimen, Loading("radius", 250e-9, 60)), method)
        point = pull_off(solution, w=w).summary()["controls"][0]["pull_off"]
    return point["P_N"], point["P_err_N"]


@pytest.mark.parametrize("points", [20, 61, 122, 400])
@pytest.mark.parametrize("w", [0.03, 0.05, 0.095])
def test_pull_off_of_a_worn_tip(points: int, w: float) -> None:
    """Of 61 points the numbers left the range of arithmetic."""
    P, error = pulled(worn(points), Specimen((), HalfSpace(Elastic(E, NU))), Layered(), w)
    true = lowest(w)
    assert true == pytest.approx(-118.94e-9, rel=1e-5) or w != 0.05
    assert abs(P - true) <= error + 1e-7 * abs(true)
    assert error < 1e-3 * abs(true)


@pytest.mark.parametrize("points", [20, pytest.param(61, marks=pytest.mark.slow)])
def test_a_wide_cylinder_under_a_worn_tip_is_nearly_its_half_space(points: int) -> None:
    body = Specimen((Layer(Elastic(E, NU), 2e-6),), Rigid(), radius=4e-6, side="free")
    P, error = pulled(worn(points), body, Hybrid(), W)
    assert error < 1e-3 * abs(P)
    assert P == pytest.approx(lowest(W), rel=1e-3)  # 3e-4 by the base and the side

"""The shipped case of a very soft gel: E* = 5 kPa, h = a0 = (w R^2/E*)^(1/3) = 2 um, Ups = E* a0."""

import math

import pytest
from conftest import CASES

from jkrcli.case.models import load_case
from jkrcli.case.store import solve
from jkrcli.resolve.analysis import analyse

FORCE = 1.212696  # -P_min/(pi w R) of q = 1, beta = 1, nu = 1/2: an integral equation and elements, apart from this


def test_its_pull_off_force():
    _, solution = solve(load_case(CASES / "soft-gel.toml"))
    (result,) = analyse(solution, [4e-4])
    assert -result.pull_off["load"].P / (math.pi * 4e-4 * 1e-5) == pytest.approx(FORCE, rel=1e-6)
    assert result.validity.edge_angle == pytest.approx(math.sqrt(0.08))

"""The study of stated errors of stacks whose thicknesses lie far apart: a few of its bodies."""

import numpy as np
import pytest

from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Rigid, Specimen
from studies.bounds import summary
from studies.stack_bounds import COLUMNS, judged
from studies.stack_judge import compliance_ratio, contact


@pytest.mark.first(2)
@pytest.mark.parametrize("number", [9, 19, 0, 10, 16, 5, 1])
def test_a_few_stacks_are_within_what_is_stated(number: int) -> None:
    found = judged(number)
    assert {item.column for item in found} == set(COLUMNS)
    assert all(item.ratio <= 1 for item in found)
    assert max(item.stated for item in found) < 1e-7


@pytest.mark.slow
def test_stated_errors_hold_whatever_the_thicknesses() -> None:
    found = [item for number in range(3_000_000, 3_000_060) for item in judged(number)]
    counts = summary(found, 60, 3)["all"]
    assert counts["compared"] == 240
    assert counts["beyond"] <= 2
    assert not counts["beyond_three_times"]
    assert max(item.stated for item in found) < 1e-6


def test_the_judge_knows_a_bonded_layer_in_closed_form() -> None:
    y = np.geomspace(1e-9, 20, 40)
    for nu in (0.3, 0.5):
        kappa = 3 - 4 * nu
        small = y < 1e-2  # there the closed form cancels
        above, below = 2 * kappa * np.sinh(2 * y) - 4 * y, 2 * kappa * np.cosh(2 * y) + 1 + kappa**2 + 4 * y**2
        g = compliance_ratio(Specimen((Layer(Elastic(1.0, nu), 1.0),), Rigid()), y)
        assert g[~small] == pytest.approx((above / below)[~small], rel=1e-11)
        leading = 2 / 3 * y**3 if nu == 0.5 else (1 - 2 * nu) / (1 - nu) ** 2 / 2 * y
        assert g[y < 1e-6] == pytest.approx(leading[y < 1e-6], rel=1e-10)


def test_the_judge_knows_the_published_values() -> None:
    coated = Specimen((Layer(Elastic(1.0, 0.4), 1.0),), HalfSpace(Elastic(10.0, 0.25)))
    expected = [0.06695912, 0.20065158, 5.57071289, 9.04575131]
    assert contact(coated, 10.0, np.array([1.0]))[:, 0] == pytest.approx(expected, rel=1e-7)
    layer = Specimen((Layer(Elastic(1.0, 0.499), 1.0),), Rigid())
    expected = [9.07657701e-3, 2.17599480, 642.010619, 396.169639]
    assert contact(layer, 1000.0, np.array([5.0]))[:, 0] == pytest.approx(expected, rel=1e-8)

"""The pull-off map of bonded and frictionless layers: its published values, limits and refusals."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from jkrcli.base.errors import InputError
from jkrcli.many.study.pull_off_map import MapPoint, map_columns, pull_off_map

QS = (1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0, 1e3, 1e4)
# -P_min/(pi w R) of a bonded layer on a rigid base over w R^2/(E* h^3), computed by two independent programs.
VALUES = {
    0.3: (1.5027, 1.5230, 1.6267, 1.7936, 1.8966, 1.9474, 1.9720, 1.9846),
    0.499: (1.5041, 1.5348, 1.6878, 1.9327, 2.1410, 2.3330, 2.4978, 2.6134),
}


@cache
def points(nu: float, bonded: bool = True, qs: tuple[float, ...] = QS) -> list[MapPoint]:
    return pull_off_map([nu], bonded, qs)


@pytest.mark.parametrize("nu", VALUES)
def test_values_of_the_map(nu: float) -> None:
    assert [round(point.force, 4) for point in points(nu)] == list(VALUES[nu])  # every digit


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3])
def test_thick_and_thin_compressible_limits(nu: float) -> None:
    (thick,), (thin,) = points(nu, True, (1e-6,)), points(nu, True, (1e6,))
    assert thick.force == pytest.approx(1.5, abs=1e-5)  # departs as q: 3e-6
    assert thick.a_over_h == pytest.approx((9 * np.pi * 1e-6 / 8) ** (1 / 3), rel=1e-4)
    c = (1 - nu) ** 2 / (1 - 2 * nu)  # K h/E*, Eq. 22
    assert thin.force == pytest.approx(2, abs=0.01)  # departs as h/a, 1/50
    assert thin.a_over_h == pytest.approx((8e6 / c) ** 0.25, rel=0.03)


def test_thin_incompressible_limit_is_approached_slowly() -> None:
    forces = [point.force for point in points(0.5, True, (1e3, 1e4, 1e5, 1e6))]
    assert forces == sorted(forces)
    gaps = 3 - np.array(forces)
    ratios = gaps[1:] / gaps[:-1]
    assert np.all((ratios > 0.64) & (ratios < 0.72))  # the gap falls as h/a: by 10^(-1/6) = 0.68 per decade of q


def test_forces_rise_with_q_and_with_nu() -> None:
    table = np.array([[point.force for point in points(nu)] for nu in VALUES])
    assert np.all(np.diff(table, axis=0) > 0)
    assert np.all(np.diff(table, axis=1) > 0)
    assert np.all((table > 1.5) & (table < 3))


def test_a_nearly_incompressible_layer_overshoots_and_comes_back_to_the_compressible_limit() -> None:
    forces = [point.force for point in points(0.45, True, (1.0, 1e2, 1e4, 1e6))]
    assert forces[0] < 2 < max(forces)
    assert forces[-1] < forces[-2]
    assert forces[-1] > 2


def test_on_a_frictionless_base_nu_does_not_matter() -> None:
    one, two = (points(nu, False) for nu in (0.0, 0.5))
    assert [point.force for point in one] == pytest.approx([point.force for point in two], rel=1e-10)  # E* alone counts
    assert {point.base for point in one} == {"frictionless"}
    assert max(point.force for point in one) < 2


def test_each_value_once_in_order() -> None:
    found = pull_off_map([0.3, 0.3], True, [1.0, 0.1, 1.0])
    assert [(point.nu, point.q) for point in found] == [(0.3, 0.1), (0.3, 1.0)]
    alone = pull_off_map([0.3], True, [1.0])
    assert alone[0].force == pytest.approx(found[1].force, rel=1e-6)  # other radii of the series


def test_columns() -> None:
    columns = map_columns(points(0.3))
    assert list(columns) == [
        "nu", "base", "w_R2_over_Estar_h3", "minus_P_over_pi_w_R", "a_over_h", "delta_R_over_h2", "solved_by",
    ]  # fmt: skip
    assert {len(values) for values in columns.values()} == {len(QS)}


@pytest.mark.parametrize(
    ("qs", "got"), [((1e-7, 1.0), "1e-07, 1"), ((1e8,), "1e+08"), ((), ""), ((-1.0,), "-1"), ((float("nan"),), "nan")]
)
def test_values_outside_the_range_are_refused(qs: tuple[float, ...], got: str) -> None:
    with pytest.raises(InputError) as caught:
        pull_off_map([0.3], True, qs)
    assert str(caught.value) == f"q: must be between 1e-06 and 1e+07, got {got}"


def test_a_wrong_poisson_ratio_is_refused() -> None:
    with pytest.raises(InputError, match=r"nu: must be > -1 and <= 0\.5, got 0\.6"):
        pull_off_map([0.6], True, [1.0])

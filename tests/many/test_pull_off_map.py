"""The pull-off map of bonded and frictionless layers: its published values, limits and refusals."""

from functools import cache

import numpy as np
import pytest

import jkrcli
from jkrcli import InputError

QS = (1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0, 1e3, 1e4)
# -P_min/(pi w R) of a bonded layer on a rigid base over w R^2/(E* h^3), computed by two independent programs.
VALUES = {
    0.3: (1.5027, 1.5230, 1.6267, 1.7936, 1.8966, 1.9474, 1.9720, 1.9846),
    0.499: (1.5041, 1.5348, 1.6878, 1.9327, 2.1410, 2.3330, 2.4978, 2.6134),
}


@cache
def columns(nu: float, base: str = "bonded", qs: tuple[float, ...] = QS) -> dict[str, np.ndarray]:
    return jkrcli.study_map("pull-off", nu=[nu], base=base, q=qs).columns


def forces(nu: float, base: str = "bonded", qs: tuple[float, ...] = QS) -> list[float]:
    return columns(nu, base, qs)["minus_P_over_pi_w_R"].tolist()


@pytest.mark.parametrize("nu", VALUES)
def test_values_of_the_map(nu: float) -> None:
    assert [round(force, 4) for force in forces(nu)] == list(VALUES[nu])  # every digit


@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3])
def test_thick_and_thin_compressible_limits(nu: float) -> None:
    found = columns(nu, qs=(1e-6, 1e6))
    (thick, thin), (narrow, wide) = found["minus_P_over_pi_w_R"], found["a_over_h"]
    assert thick == pytest.approx(1.5, abs=1e-5)  # departs as q: 3e-6
    assert narrow == pytest.approx((9 * np.pi * 1e-6 / 8) ** (1 / 3), rel=1e-4)
    c = (1 - nu) ** 2 / (1 - 2 * nu)  # K h/E*, Eq. 22
    assert thin == pytest.approx(2, abs=0.01)  # departs as h/a, 1/50
    assert wide == pytest.approx((8e6 / c) ** 0.25, rel=0.03)


def test_thin_incompressible_limit_is_approached_slowly() -> None:
    found = forces(0.5, qs=(1e3, 1e4, 1e5, 1e6))
    assert found == sorted(found)
    gaps = 3 - np.array(found)
    ratios = gaps[1:] / gaps[:-1]
    assert np.all((ratios > 0.64) & (ratios < 0.72))  # the gap falls as h/a: by 10^(-1/6) = 0.68 per decade of q


def test_forces_rise_with_q_and_with_nu() -> None:
    table = np.array([forces(nu) for nu in VALUES])
    assert np.all(np.diff(table, axis=0) > 0)
    assert np.all(np.diff(table, axis=1) > 0)
    assert np.all((table > 1.5) & (table < 3))


def test_a_nearly_incompressible_layer_overshoots_and_comes_back_to_the_compressible_limit() -> None:
    found = forces(0.45, qs=(1.0, 1e2, 1e4, 1e6))
    assert found[0] < 2 < max(found)
    assert found[-1] < found[-2]
    assert found[-1] > 2


def test_on_a_frictionless_base_nu_does_not_matter() -> None:
    one, two = (forces(nu, "frictionless") for nu in (0.0, 0.5))
    assert one == pytest.approx(two, rel=1e-10)  # E* alone counts
    assert set(columns(0.0, "frictionless")["base"]) == {"frictionless"}
    assert max(one) < 2


def test_each_value_once_in_order() -> None:
    found = jkrcli.study_map("pull-off", nu=[0.3, 0.3], q=[1.0, 0.1, 1.0]).columns
    assert (found["nu"].tolist(), found["w_R2_over_Estar_h3"].tolist()) == ([0.3, 0.3], [0.1, 1.0])
    assert forces(0.3, qs=(1.0,))[0] == pytest.approx(found["minus_P_over_pi_w_R"][1], rel=1e-6)  # other radii


def test_columns() -> None:
    found = columns(0.3)
    assert list(found) == [
        "nu", "base", "w_R2_over_Estar_h3", "minus_P_over_pi_w_R", "a_over_h", "delta_R_over_h2", "beta", "solved_by",
    ]  # fmt: skip
    assert {len(values) for values in found.values()} == {len(QS)}


@pytest.mark.parametrize("q", [1e-7, 1e8, -1.0])
def test_values_outside_the_range_are_refused(q: float) -> None:
    with pytest.raises(InputError) as caught:
        jkrcli.study_map("pull-off", q=[1.0, q])
    assert str(caught.value) == f"pull-off map: q must be >= 1e-06 and <= 1e+07, got {q}"


@pytest.mark.parametrize(
    ("axes", "said"),
    [
        ({"nu": [0.6]}, "pull-off map: nu must be > -1 and <= 0.5, got 0.6"),
        ({"q": [float("nan")]}, "pull-off map: q must be a finite number, got nan"),
        ({"base": "wet"}, 'pull-off map: base must be bonded or frictionless, got "wet"'),
        ({"mu": [1.0]}, 'pull-off map: has no axis "mu" (axes: nu, base, q, beta)'),
    ],
)
def test_what_the_map_has_not_is_refused(axes: dict, said: str) -> None:
    with pytest.raises(InputError) as caught:
        jkrcli.study_map("pull-off", **axes)
    assert str(caught.value) == said


def test_a_map_that_is_none_is_refused() -> None:
    with pytest.raises(InputError, match=r'unknown map "pulloff" \(maps: pull-off, sticking, '):
        jkrcli.study_map("pulloff")

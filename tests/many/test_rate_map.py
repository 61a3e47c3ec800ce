"""``jkr study rate-map``: the table of the half-space, and a layer beside it."""

import json
import math
from collections.abc import Callable

import numpy as np
import pytest

import jkrcli
from jkrcli.many.maps import RATE_MAP


@pytest.mark.slow
def test_the_half_space_has_the_known_forces_and_a_layer_stands_beside_it() -> None:
    found = jkrcli.study_map("rate", rate={"n": 0.6}, stiffness=["rigid"], speed=[1e-3, 1.0]).columns
    force = found["minus_P_over_pi_w0_R"]
    assert force[:2] == pytest.approx([1.515478, 2.348038], rel=1e-5)
    assert found["h_over_R"].tolist() == [math.inf, math.inf, 0.3, 0.3]
    assert force[2] > force[0]
    assert found["dissipated_over_w0_pi_a2"][2] == pytest.approx(1, rel=0.05)  # slow, rigid: w0 times the area


def test_both_logarithmic_panels_hold_their_lines() -> None:
    """Limits of a linear axis were kept: energies that span a decade were drawn above a panel of negative energies."""
    columns = {"V_over_v0": [1e-3, 1.0, 1e2], "h_over_R": [math.inf] * 3, "k_over_Estar_R": [math.inf] * 3,
               "minus_P_over_pi_w0_R": [1.5, 2.3, 8.3], "dissipated_over_w0_pi_a2": [1.0, 3.0, 40.0]}  # fmt: skip
    figure = RATE_MAP.draw({name: np.array(values) for name, values in columns.items()})
    for axes, (low, high) in zip(figure.axes, ((1.5, 8.3), (1.0, 40.0)), strict=True):
        assert 0 < axes.get_ylim()[0] < low
        assert axes.get_ylim()[1] > high


@pytest.mark.slow
def test_the_study_writes_table_and_figure(jkr: Callable) -> None:
    done = jkr("study", "rate-map", "--speed", "0.1", "--thickness", "1", "--stiffness", "rigid", "--workers", "1",
               "--json")  # fmt: skip
    assert done.code == 0, done.err
    found = json.loads(done.out)
    assert found["minus_P_over_pi_w0_R"][0] == pytest.approx(1.733807, rel=1e-5)
    for words, said in (
        (("--speed", "0"), "rate map: speed must be > 0, got 0.0"),
        (("--rate", "n=-1"), "--rate: n: must be > 0 and <= 100, got -1"),
    ):
        done = jkr("study", "rate-map", *words, "--force")
        assert (done.code, done.err.splitlines()[-1]) == (2, f"jkr: error: {said}")

"""The map of what sticking changes: against values of two independent computations, limits, the command."""

import json

import numpy as np
import pytest

import jkrcli


def test_the_map_meets_independent_values():
    """Tied finite elements and an integral equation of another make: 1.674 and 1.627 for the load, flat ends for S."""
    columns = jkrcli.study_map("sticking", nu=[0.5, 0.499], ratio=[1.0, 2.0, 10 / 3]).columns
    load = columns["load_ratio"].reshape(2, 3)[:, 2]
    np.testing.assert_allclose(load, [1.674, 1.627], atol=2e-3)
    np.testing.assert_allclose(columns["S_ratio"][:2], [3.929038 / 3.618736, 12.502665 / 9.149450], rtol=1e-5)


def test_narrow_contacts_have_the_half_space_factor():
    columns = jkrcli.study_map("sticking", nu=[0.0], ratio=[0.01]).columns
    assert columns["S_ratio"][0] == pytest.approx(1.0986, abs=2e-3)


def test_the_command_writes_table_and_pictures(jkr, tmp_path):
    done = jkr("study", "sticking-map", "--nu", "0.5", "--ratio", "0.5", "--ratio", "1", "-o", tmp_path, "--json")
    assert json.loads(done.out)["S_ratio"][1] == pytest.approx(1.0857, abs=1e-3)
    names = {path.name for path in tmp_path.glob("sticking-map.*")}
    assert names == {"sticking-map.csv", "sticking-map.png", "sticking-map.svg"}


def test_what_is_outside_is_refused():
    with pytest.raises(jkrcli.InputError, match=r"sticking map: ratio must be >= 0.01 and <= 12, got 50"):
        jkrcli.study_map("sticking", nu=[0.5], ratio=[50.0])

"""The adhesion map: zones of a thick layer by Maugis' closed form, and the command."""

import csv
from pathlib import Path

import numpy as np
import pytest
from maugis import Maugis

import jkrcli
from jkrcli.many.maps import ZONES


@pytest.mark.parametrize("mu", [0.03, 0.5, 20.0])
def test_a_thick_layer_is_a_half_space(mu: float) -> None:
    """delta_a = delta_H - delta and (P_H - P)/P_H at given loads; q = 1e-9 leaves a/h below 5e-3."""
    q, loads = 1e-9, (0.5, 2.0, 20.0)
    found = jkrcli.study_map("adhesion", nu=0.3, q=q, mu=(mu,), load=loads).columns
    lam = 2 * mu * (9 / 16 / np.pi) ** (1 / 3)  # K = 4 E*/3
    exact = Maugis(1.0, 1.0, q, lam, 1 + np.geomspace(1e4, 1e-9, 20_000))
    rising = slice(int(np.argmin(exact.P)), None)
    a = np.interp(np.array(loads) * np.pi * q, exact.P[rising], exact.a[rising])
    delta = np.interp(a, exact.a[rising], exact.delta[rising])
    length = q / exact.stress
    assert found["a_over_h"] == pytest.approx(a, rel=0.01)
    assert found["adhesive_over_range"] == pytest.approx((a**2 - delta) / length, rel=0.02)
    assert found["adhesive_share"] == pytest.approx(
        1 - np.array(loads) * np.pi * q / (4 / 3 * a**3), rel=0.03, abs=1e-3
    )


@pytest.mark.slow
def test_zones_follow_from_range_and_load() -> None:
    mus = (0.02, 1.0, 50.0)
    thick = jkrcli.study_map("adhesion", q=1e-4, mu=mus, load=(0.1, 1.0)).columns["zone"]
    assert thick[:3].tolist() == ["DMT", "Maugis", "JKR"]
    thin = jkrcli.study_map("adhesion", q=100.0, mu=mus, load=(0.1, 100.0)).columns["zone"]
    assert thin[:4].tolist() == ["rigid", "DMT", "Maugis", "Hertz"]  # a thin layer is a stiff one


def test_the_command(jkr) -> None:
    words = ("study", "adhesion-map", "--q", 1, "--mu", 0.1, "--mu", 1, "--mu", 10, "--load", 1, "--load", 10)
    outcome = jkr(*words)
    assert outcome.code == 0, outcome.err
    with Path("adhesion-map.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 6
    assert {row["zone"] for row in rows} <= set(ZONES)
    assert Path("adhesion-map.png").exists()
    for wrong in (("--q", 0), ("--mu", 1e4), ("--load", -1), ("--nu", 0.7)):
        refused = jkr("study", "adhesion-map", *wrong)
        assert (refused.code, len(refused.err.splitlines())) == (2, 1), refused.err

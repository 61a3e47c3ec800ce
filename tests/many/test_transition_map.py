"""The transition map on the values that three computations share, from the command to its table."""

import csv
from pathlib import Path

import pytest


@pytest.mark.slow
def test_map_holds_the_ridge_above_both_limits(jkr, tmp_path: Path) -> None:
    words = ("study", "transition-map", "--nu", 0.499, "--q", 100, "--mu", 1, "--mu", 3, "-o", tmp_path, "--workers", 1)
    outcome = jkr(*words)
    assert outcome.code == 0, outcome.err
    with (tmp_path / "transition-map.csv").open() as file:
        rows = list(csv.DictReader(file))
    found = [float(row["minus_P_over_pi_w_R"]) for row in rows]
    assert found == pytest.approx([2.089937, 2.360242], abs=6e-7)
    assert found[1] > max(2.0, float(rows[1]["jkr_minus_P_over_pi_w_R"])) + 0.02
    assert (tmp_path / "transition-map.png").exists()
    assert jkr(*words).code == 0  # its own files are replaced


def test_values_outside_the_map_are_refused(jkr) -> None:
    jkr("study", "transition-map", "--mu", 1000).refused("transition map: mu must be >= 0.05 and <= 50, got 1000.0")

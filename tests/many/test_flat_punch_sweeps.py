"""Sweeps over the radius of a sharp-edged flat punch, and the radius that gives a pull-off force (Kendall 1971)."""

import json
import math
from collections.abc import Callable
from pathlib import Path

import pytest
from sweep_files import axis, rows

HALF_SPACE = 'half_space = { E = "1 MPa", nu = 0.5 }'
CASE = """
indenter = { shape = "flat", radius = "1 mm" }
specimen = { half_space = { E = "1 MPa", nu = 0.5 } }
loading = { radius = "1 mm" }
adhesion = { w = 0.1 }
"""
SWEEP = 'base = "punch.toml"\n' + axis("indenter.radius", 'values = ["0.5 mm", 1e-3, "2 mm"]')


def kendall(R: float) -> float:
    return math.sqrt(8 * math.pi * 0.1 * 1e6 / 0.75 * R**3)


def test_contact_goes_to_the_rim_of_each_punch_of_a_sweep(jkr: Callable) -> None:
    Path("punch.toml").write_text(CASE)
    Path("sweep.toml").write_text(SWEEP)
    jkr("sweep", "sweep.toml", "--no-plots")
    for row, R in zip(rows(Path("sweep-results/table.csv")), (0.5e-3, 1e-3, 2e-3), strict=True):
        for name in ("load", "displacement"):
            assert float(row[f"pull_off.{name}.a_m"]) == R
            assert float(row[f"pull_off.{name}.P_N"]) == pytest.approx(-kendall(R), rel=1e-9)


@pytest.mark.first(1)
@pytest.mark.parametrize("specimen", ["half_space", "layer"])
def test_find_the_radius_of_a_punch_that_gives_a_force(jkr: Callable, specimen: str) -> None:
    """Whatever the device: the same force is measured."""
    body = HALF_SPACE if specimen == "half_space" else 'layers = [{ E = "1 MPa", nu = 0.5, thickness = "1 mm" }]'
    Path("punch.toml").write_text(CASE.replace(HALF_SPACE, body))
    found = []
    for device in ("load", "rigid"):
        answer = jkr("pull-off", "punch.toml", "--load", f"{kendall(1.7e-3)} N", "--find",
                     "indenter.radius=0.5 mm..3 mm", "--stiffness", device, "--json")  # fmt: skip
        (root,) = json.loads(answer.out)["solutions"]
        found.append(root["value"])
    assert found[0] == pytest.approx(found[1], rel=1e-9)
    if specimen == "half_space":
        assert found[0] == pytest.approx(1.7e-3, rel=1e-7)

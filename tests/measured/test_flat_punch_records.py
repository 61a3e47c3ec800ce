"""Probe tack with a flat punch: w from its pull-off force, and from P and a of the edge that recedes; no fits."""

import json
import math
from collections.abc import Callable
from pathlib import Path

import pytest

E_STAR = 1e6 / 0.75
PUNCH = ["--shape", "flat", "--radius", "1 mm", "--E", "1 MPa", "--nu", "0.5"]
CASE = """
indenter = { shape = "flat", radius = "5 mm" }
specimen.layers = [{ E = "1 MPa", nu = 0.5, thickness = "1 mm" }]
loading = { load = "20 N", spacing = "log" }
adhesion = { w = 0.05 }
"""


def w_of(jkr: Callable, *options: str) -> float:
    return json.loads(jkr("pull-off", *PUNCH, *options, "--json").out)["results"][0]["w_J_per_m2"]


def test_w_from_a_measured_pull_off_is_kendalls(jkr: Callable) -> None:
    force, R = 0.04, 1e-3
    assert w_of(jkr, "--load", f"{force} N") == pytest.approx(force**2 / (8 * math.pi * E_STAR * R**3), rel=1e-10)


@pytest.mark.parametrize("stiffness", ["load", "1 kN/m", "rigid"])
def test_w_from_pull_off_from_a_layer_is_the_one_that_makes_it(jkr: Callable, stiffness: str) -> None:
    layer = ["--thickness", "0.5 mm", "--stiffness", stiffness]
    found = json.loads(jkr("pull-off", *PUNCH, *layer, "--w", "0.05", "--json").out)["results"][0]
    force = -found["controls"][0]["pull_off"]["P_N"]
    assert w_of(jkr, *layer, "--load", f"{force!r} N") == pytest.approx(0.05, rel=1e-7)


def test_w_along_a_receding_edge(jkr: Callable) -> None:
    Path("punch.toml").write_text(CASE)
    assert jkr("cycle", "punch.toml", "--no-plots").code == 0
    header, *rows = (line.split(",") for line in Path("punch-cycle.csv").read_text().splitlines())
    a, P, phase = (header.index(name) for name in ("a_m", "P_N", "phase"))
    # 1 % within the rim an edge may be pinned
    edge = [row for row in rows if row[phase] == "retraction" and 0 < float(row[a]) < 4.95e-3]
    assert len(edge) > 50
    Path("record.csv").write_text("a (m),P (N)\n" + "".join(f"{row[a]},{row[P]}\n" for row in edge))
    curve = json.loads(jkr("work", "punch.toml", "record.csv", "--json").out)["results"][0]["curves"][0]
    assert curve["rows"]["ok"] == len(edge)
    assert curve["w"]["all"]["median_J_per_m2"] == pytest.approx(0.05, rel=1e-9)


def test_records_are_not_fitted(jkr: Callable) -> None:
    Path("record.csv").write_text("delta (um),P (mN)\n" + "".join(f"{i},{i * 0.1}\n" for i in range(1, 30)))
    err = jkr("fit", "record.csv", "--shape", "flat", "--radius", "1 mm", "--nu", "0.5").err
    assert "records of a flat punch are not fitted" in err
    assert "jkr pull-off --load" in err

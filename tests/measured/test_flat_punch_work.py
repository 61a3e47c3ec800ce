"""w of a sharp-edged flat punch from what was measured: w = P^2/(8 pi E* R^3) on a half-space, G = w on layers."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import jkrcli
from jkrcli.adhesion.curve import DISPLACEMENT_CONTROL
from jkrcli.adhesion.device_path import cycle
from jkrcli.bodies.indenters import FlatPunch
from jkrcli.resolve.analysis import analyse

PUNCH = ("--shape", "flat", "--radius", "1 mm", "--E", "1 MPa")


def works(jkr: Callable, *options: str, load: str = "50 mN") -> dict:
    return jkr("pull-off", *PUNCH, "--load", load, *options, "--json").told["results"][0]


@pytest.mark.first(1)
@pytest.mark.parametrize("device", ["load", "1e4 N/m", "rigid"])
def test_work_of_a_pull_off_force_is_the_same_by_any_device(jkr: Callable, device: str) -> None:
    """Whatever holds a full end measures the load at which G = w at its rim."""
    options = () if device == "load" else ("--stiffness", device)
    layer = works(jkr, "--nu", "0.49", "--thickness", "100 um", *options)
    assert layer["pull_off"]["a_m"] == 1e-3
    assert layer["w_J_per_m2"] == pytest.approx(1.692e-3, rel=1e-3)
    half_space = works(jkr, "--nu", "0.5", *options)
    assert half_space["w_J_per_m2"] == pytest.approx(0.05**2 / (8 * math.pi * 1e6 / 0.75 * 1e-9), rel=1e-9)


def test_an_uncertain_radius_of_a_punch_takes_its_edge_along(jkr: Callable) -> None:
    """w = P^2/(8 pi E* R^3): 3 times the error of R, 2 times that of the load."""
    found = works(jkr, "--nu", "0.5", "--uncertain", "R=1%", "--uncertain", "load=1%")
    w, parts = found["w_J_per_m2"], found["w_err_by_input_J_per_m2"]
    assert parts["R"] / w == pytest.approx(3 * 1.96 * 0.01, rel=5e-3)
    assert parts["load"] / w == pytest.approx(2 * 1.96 * 0.01, rel=5e-3)


@pytest.mark.parametrize("names", [("a_m", "P_N"), ("delta_m", "P_N"), ("a_m", "delta_m")])
def test_work_along_a_punch_leaves_the_pinned_edge_out(jkr: Callable, names: tuple[str, ...]) -> None:
    """The receding edge has G = w; while it is pinned at the rim G <= w, which only bounds w from below."""
    specimen = jkrcli.Specimen((jkrcli.Layer(jkrcli.Elastic(1e6, 0.5), 1e-3),))
    solution = jkrcli.solve(
        jkrcli.Problem(FlatPunch(5e-3), specimen, jkrcli.Loading("radius", 5e-3, 100, "log")), "layered"
    )
    curve = analyse(solution, [0.05])[0].curve
    rows = cycle(curve, curve, DISPLACEMENT_CONTROL).path.rows(50)
    pressed = rows["delta_m"] > 0.5 * np.max(rows["delta_m"])  # as far under compression as pulled: left out
    rows = {name: column[~pressed] for name, column in rows.items()}
    jkrcli.save(solution, "punch.h5")
    stretches = {"whole": np.full(rows["a_m"].size, True), "pinned": rows["a_m"] == 5e-3}
    for file, chosen in stretches.items():
        header = ",".join(name.replace("_m", " (m)").replace("_N", " (N)") for name in names)
        np.savetxt(f"{file}.csv", np.column_stack([rows[name][chosen] for name in names]), "%.17g", ",", header=header,
                   comments="")  # fmt: skip
    found = jkr("work", "punch.h5", "whole.csv", "--no-plots", "--json").told["results"][0]["curves"][0]
    assert found["rows"]["pinned at the rim"] >= np.count_nonzero(stretches["pinned"])
    assert found["w_least_J_per_m2"] == pytest.approx(0.05, rel=1e-6)
    assert found["w"]["all"]["quartiles_J_per_m2"] == pytest.approx([0.05, 0.05], rel=1e-6)
    jkr("work", "punch.h5", "pinned.csv", "--no-plots").refused("pinned at the rim: G <= w, at least 50 mJ/m^2")
    assert not Path("pinned-work.csv").exists()


@pytest.mark.first(1)
@pytest.mark.parametrize("stiffness", ["1 kN/m", "load", "rigid"])
def test_w_from_pull_off_from_a_layer_is_the_one_that_makes_it(jkr: Callable, stiffness: str) -> None:
    layer = ["--thickness", "0.5 mm", "--stiffness", stiffness]
    found = jkr("pull-off", *PUNCH, "--nu", "0.5", *layer, "--w", "0.05", "--json").told["results"][0]
    force = -found["controls"][0]["pull_off"]["P_N"]
    assert works(jkr, "--nu", "0.5", *layer, load=f"{force!r} N")["w_J_per_m2"] == pytest.approx(0.05, rel=1e-7)


def test_records_are_not_fitted(jkr: Callable) -> None:
    Path("record.csv").write_text("delta (um),P (mN)\n" + "".join(f"{i},{i * 0.1}\n" for i in range(1, 30)))
    err = jkr("fit", "record.csv", "--shape", "flat", "--radius", "1 mm", "--nu", "0.5").err
    assert "records of a flat punch are not fitted" in err
    assert "jkr pull-off --load" in err

"""Curves of real force microscopes against what another program finds in them."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import Outcome

TABLES = Path(__file__).parent / "afm"  # made by afm/thin.py
# E [Pa] by nanite 4.2.3, model hertz_para, R = 5 um, nu = 0.5, approach, all rows; compute_tip_position,
# correct_force_offset, correct_tip_offset (deviation from baseline), weight_cp = 0; and its misfit, the rms
# of residuals in contact over the range of the force.
NANITE = {"gel.csv": (348.0, 0.012), "spot.csv": (2.08e4, 0.024)}


@pytest.mark.parametrize("name", NANITE)
def test_modulus_of_a_measured_approach(jkr: Callable[..., Outcome], name: str) -> None:
    """Measured: 348.0 Pa and 20.29 kPa. Both stiffen with depth: of one a half-space is rejected, of the other any slow
    column takes some 60 % of the misfit, which names none and is in the error."""
    body = ("--shape", "paraboloid", "--radius", "5 um", "--nu", "0.5")
    asked = ("--segment", "approach", "--fix", "w=0", "--json", "--no-plots", "-o", "found")
    (curve,) = jkr("fit", *body, *asked, str(TABLES / name)).told["curves"]
    E, misfit = NANITE[name]
    assert curve["estimates"]["E:base"]["value"] == pytest.approx(E, rel=0.1)
    if name == "gel.csv":  # beside noise of 15 pN
        assert (curve["status"], curve["flags"]) == ("fitted", ["misfit"])
    else:
        assert (curve["status"], curve["flags"]) == ("doubtful", ["model rejected", "E* not determined"])
        assert "moduli that change with the contact radius" in curve["verdict"]["named"]
    assert curve["sizes"]["misfit"] < misfit
    assert curve["sizes"]["E_star_error"] > 0.15
    force = np.loadtxt(TABLES / name, delimiter=",", comments=("#", "height"), usecols=1) * 1e-9
    assert curve["scales"]["P"] < misfit * np.ptp(force)  # standard deviation of the residuals


@pytest.mark.parametrize("name", NANITE)
def test_a_measured_curve_is_told_without_complaint(jkr: Callable[..., Outcome], name: str) -> None:
    done = jkr("look", str(TABLES / name), "--json", "--no-plots")
    (curve,) = json.loads(done.out)["files"][0]["curves"]
    assert curve["flags"] == {}
    assert curve["approach"]["touch_m"] is not None
    assert curve["retract"]["largest_load_N"] > 0


@pytest.mark.slow
def test_estimated_zeros_and_fitted_ones_give_the_same(jkr: Callable[..., Outcome]) -> None:
    """The retraction of a record was read with its base line as rows in contact where zeros were to be estimated."""
    found = []
    for contact in ("auto", "estimate"):
        body = ("--radius", "5 um", "--nu", "0.5", "--contact", contact, "--segment", "retract")
        (curve,) = jkr("fit", *body, str(TABLES / "spot.csv"), "--json", "--no-plots", "-o", contact).told["curves"]
        found.append(curve["estimates"])
    assert found[0] == found[1]
    assert found[0]["E_star"]["value"] > 15e3  # of 21 kPa the model's error is more than all


def test_a_stiffness_against_that_of_the_file_is_warned_of(jkr: Callable[..., Outcome]) -> None:
    """A rigid device in the place of a lever makes E 2.4 times too small; only ``look`` used to say so."""
    body = ("--radius", "5 um", "--nu", "0.5", "--segment", "approach", "--fix", "w=0", "--stiffness", "rigid")
    done = jkr("fit", *body, str(TABLES / "spot.csv"), "--no-plots", "-o", "found").ok
    assert "stiffness rigid as specified, the header of the file says 0.0434937 N/m" in done.err

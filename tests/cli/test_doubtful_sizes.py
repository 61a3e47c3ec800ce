"""Numbers that are hardly meant, and names that options do not have, are answered with what is probably meant."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from jkrcli.cli.inputs import tables_of
from jkrcli.measured.parameters import implausible_work

BODY = {"shape": None, "half_angle": None, "cap": None, "thickness": None, "base": None, "radius": "10 um", "nu": "0.5"}


@pytest.mark.parametrize(("typed", "said"), [("2", "2 Pa"), ("5e13", "50 TPa")])
def test_a_modulus_without_unit_that_no_solid_has_is_remarked(
    typed: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    tables_of("fit", BODY | {"modulus": typed}, "", None)
    err = " ".join(capsys.readouterr().err.split())
    assert f"--E: {typed.replace('e', 'e+')} without a unit is {said}" in err
    for meant in ("5e4", "2 Pa", "0.5 MPa"):
        tables_of("fit", BODY | {"modulus": meant}, "", None)
        assert capsys.readouterr().err == ""


def test_symbols_of_the_field_are_answered_with_the_option(jkr: Callable) -> None:
    """--R was answered with --E and --w."""
    for symbol, option in {"R": "radius", "k": "stiffness", "h": "thickness", "alpha": "half-angle"}.items():
        jkr("fit", "x.csv", f"--{symbol}", "1").refused(f", did you mean '--{option}'?")
    assert "--radius" not in jkr("show", "x.h5", "--R", "1").err  # which has none


def test_a_work_of_adhesion_that_surfaces_hardly_have_is_remarked() -> None:
    assert "implausibly small for E* = 1.5 MPa" in implausible_work(61e-6, 1.5e6)
    assert implausible_work(61e-6, 1e4) == ""  # of a cell in a liquid
    assert implausible_work(1e-3, 1e9) == ""
    assert "is implausible" in implausible_work(50.0, 1e4)


CASE = """indenter = { shape = "paraboloid", radius = "10 mm" }
specimen.half_space = { E = "1 MPa", nu = 0.5 }
loading = { radius = "1 mm", spacing = "log" }
"""


def test_a_radius_of_millimetres_for_micrometres_shows_in_w(jkr: Callable) -> None:
    """A pull-off force of a tip of 10 um on a body of 10 mm: 61 uJ/m^2 were printed without a comment."""
    Path("gel.toml").write_text(CASE)
    done = jkr("pull-off", "gel.toml", "--load", "2.9 uN").ok
    assert "w = 61.54 uJ/m^2" in done.out
    assert "is implausibly small for E* = 1.333 MPa" in done.err
    assert "the radius of the indenter" in " ".join(done.err.split())


def test_a_fitted_w_far_below_that_of_surfaces_is_remarked(jkr: Callable) -> None:
    R, E, w = 10e-3, 4e6 / 3, 61e-6  # in truth 10 um and 61 mJ/m^2
    a = np.linspace(3e-5, 3e-4, 80)
    t = np.sqrt(2 * np.pi * w * a / E)
    rows = np.stack([1e6 * (a**2 / R - t), 1e6 * (4 * E * a**3 / (3 * R) - 2 * E * a * t)], axis=1)
    np.savetxt("x.csv", rows, delimiter=",", header="delta_um,P_uN", comments="")
    done = jkr("fit", "x.csv", "--radius", "10 mm", "--nu", "0.5", "--shape", "paraboloid", "--no-plots").ok
    assert "is implausibly small for E*" in done.err

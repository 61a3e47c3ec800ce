"""``jkr pull-off`` states errors: of the points, and of w from a measured force and uncertain inputs."""

import math
from pathlib import Path

import pytest

CASE = """
indenter = { shape = "paraboloid", radius = "50 um" }
specimen.half_space = { E = "1 MPa", nu = 0.3 }
loading = { radius = "10 um", points = 40 }
adhesion.w = "50 mJ/m^2"
"""
LAYER = CASE.replace("50 mJ", "5 mJ").replace(
    'half_space = { E = "1 MPa", nu = 0.3 }', 'layers = [{ name = "gel", thickness = "5 um", E = "1 MPa", nu = 0.45 }]'
)


def solved(jkr, text: str) -> None:
    Path("x.toml").write_text(text, encoding="utf-8")
    assert jkr("run", "x.toml").code == 0


def test_points_carry_their_errors(jkr) -> None:
    solved(jkr, CASE)
    assert jkr("pull-off", "x.h5", "--stiffness", "load", "--stiffness", "5 N/m").code == 0
    told = jkr("pull-off", "x.h5", "--json").told["results"][0]
    for control, exact in zip(told["controls"], (-1.5, -5 / 6), strict=True):
        point = control["pull_off"]
        error = abs(point["P_N"] / (exact * math.pi * 50e-3 * 50e-6) - 1)
        assert error <= point["P_err_N"] / abs(point["P_N"]) < 1e-7
    assert told["errors"]["total"] < 1e-9
    point = told["controls"][0]["pull_off"]
    back = inverse(jkr, "--load", f"{-point['P_N']!r} N")
    by_load = back["w_J_per_m2"] / -point["P_N"]  # w = F/(1.5 pi R)
    assert back["w_err_of_series_J_per_m2"] == pytest.approx(by_load * point["P_err_N"], rel=1e-2, abs=0)


@pytest.mark.parametrize("words", [("--stiffness", "rigid"), ("--stiffness", "rigid", "--load", "10 uN")])
def test_the_radius_at_pull_off_is_that_of_the_control(jkr, words: tuple[str, ...]) -> None:
    """Of a half-space 3^(-2/3) = 0.48 of that under load control."""
    solved(jkr, CASE)
    told = jkr("pull-off", "x.h5", "--json", *words).told["results"][0]
    point = told["pull_off"] if "--load" in words else told["controls"][0]["pull_off"]
    assert told["validity"]["a_over_R_pull_off"] == pytest.approx(point["a_m"] / 50e-6, rel=1e-12)
    assert f"a/R at pull-off = {point['a_m'] / 50e-6:.3g}" in jkr("pull-off", "x.h5", *words).out


def inverse(jkr, *words: str) -> dict:
    return jkr("pull-off", "x.h5", "--json", *words).told["results"][0]


@pytest.mark.slow
def test_uncertain_thickness_is_what_other_thicknesses_give(jkr) -> None:
    solved(jkr, LAYER)
    told = inverse(jkr, "--load", "1.5 uN", "--uncertain", "h=2%", "--uncertain", "nu:gel=0.01")
    works = []
    for h in (4.9, 5.1):
        solved(jkr, LAYER.replace('"5 um"', f'"{h} um"'))
        works.append(inverse(jkr, "--load", "1.5 uN")["w_J_per_m2"])
    assert told["w_err_by_input_J_per_m2"]["h:gel"] == pytest.approx(1.96 * abs(works[1] - works[0]) / 2, rel=1e-4)
    assert told["w_err_by_input_J_per_m2"]["nu:gel"] > 0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--uncertain", "load=3%"), "--uncertain says how well a measured force and its body are known: give --load"),
        (("--load", "1 uN", "--uncertain", "hh=3%"), 'unknown parameter "hh"'),
        (("--load", "1 uN", "--uncertain", "R=0"), "the uncertainty of R must be > 0, got 0"),
        (("--load", "1 uN", "--uncertain", "R=two"), "--uncertain R: "),
        (("--load", "1 uN", "--uncertain", "R=1%", "--uncertain", "R=2%"), "--uncertain: R is given twice"),
    ],
)
def test_mistakes_are_named(jkr, words: tuple[str, ...], message: str) -> None:
    solved(jkr, LAYER)
    jkr("pull-off", "x.h5", *words).refused(message)

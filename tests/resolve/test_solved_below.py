"""Pull-off below the first row of a series: exact methods solve on, and a flat end lets go at its rim."""

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from jkrcli import transform

E, NU = 5e6, 0.45
E_STAR = E / (1 - NU**2)
CASE = """
[indenter]
{indenter}
[specimen.half_space]
E = 5e6
nu = 0.45
[loading]
depth = 1e-6
spacing = "{spacing}"
[adhesion]
w = {w}
"""


def controls(jkr: Callable, indenter: str, w: float, spacing: str = "radius") -> list[dict]:
    Path("body.toml").write_text(CASE.format(indenter=indenter, w=w, spacing=spacing))
    return jkr("pull-off", "body.toml", "--json").told["results"][0]["controls"]


@pytest.mark.parametrize("spacing", ["radius", "log"])
@pytest.mark.parametrize(("edge", "w"), [(1e-9, 0.05), (1e-9, 0.2), (1e-10, 0.01), (1e-8, 0.1)])
def test_kendalls_punch_under_either_control(jkr: Callable, edge: float, w: float, spacing: str) -> None:
    b = 20e-6
    found = controls(jkr, f'shape = "flat"\nflat_radius = {b}\nedge_radius = {edge}', w, spacing)
    for one in found:
        point = one["pull_off"]
        assert point["P_N"] == pytest.approx(-math.sqrt(8 * math.pi * w * E_STAR * b**3), rel=1e-8)
        assert point["delta_m"] == pytest.approx(-math.sqrt(2 * math.pi * w * b / E_STAR), rel=1e-8)
        assert point["P_err_N"] < 1e-5 * abs(point["P_N"])
        assert len(one["critical_points"]) <= 1  # no second minimum, and no maximum


@pytest.mark.parametrize(("angle", "w"), [(45, 0.05), (70, 1e-3), (80, 1e-3), (85, 1e-3), (88, 1e-4)])
def test_cones_have_a_pull_off_under_displacement_control(jkr: Callable, angle: float, w: float) -> None:
    """delta = (pi/2) a cot(alpha) - sqrt(2 pi w a/E*) is least at a = 2 w tan^2(alpha)/(pi E*), delta = -w
    tan(alpha)/E*; P at nine times that radius."""
    tan = math.tan(math.radians(angle))
    loaded, held = controls(jkr, f'shape = "cone"\nhalf_angle = "{angle} deg"', w)
    a = 2 * w * tan**2 / (math.pi * E_STAR)
    assert held["pull_off"]["a_m"] == pytest.approx(a, rel=1e-4)
    assert held["pull_off"]["delta_m"] == pytest.approx(-w * tan / E_STAR, rel=1e-8)
    assert loaded["pull_off"]["a_m"] == pytest.approx(9 * a, rel=1e-4)


def test_a_contact_lost_within_its_series_is_not_solved_on(jkr: Callable) -> None:
    controls(jkr, 'shape = "paraboloid"\nradius = 1e-4', 0.05)
    assert "rows_below" not in transform("body.toml", 0.05).solution.facts
    controls(jkr, 'shape = "cone"\nhalf_angle = "80 deg"', 1e-3)
    assert transform("body.toml", 1e-3).solution.facts["rows_below"] > 0


FILM = """
indenter = { shape = "paraboloid", radius = "100 um" }
specimen.layers = [{ thickness = "1 um", E = "1 MPa", nu = 0.5 }]
specimen.half_space = { E = "6 kPa", nu = 0.3 }
adhesion.w = 1.65e-4
"""


def test_a_stiff_film_has_a_fold_of_its_own_below_the_first_row(jkr: Callable) -> None:
    """Eight rows from 1.6 um on gave the fold of the soft half-space below, at 2.2 um and -344 nm."""
    found = []
    for points in (8, 100):
        Path("body.toml").write_text(f"{FILM}loading = {{ radius = 13e-6, points = {points} }}")
        held = jkr("pull-off", "body.toml", "--json").told["results"][0]["controls"][1]
        found.append(held["pull_off"])
        assert len(held["jumps_before_pull_off"]) == 1
    assert found[0]["a_m"] == pytest.approx(8.1615e-7, rel=1e-4)
    assert found[0]["delta_m"] == pytest.approx(found[1]["delta_m"], rel=1e-9)


def test_a_stiff_film_without_a_fold_of_its_own_keeps_its_rows(jkr: Callable) -> None:
    Path("body.toml").write_text(f"{FILM.replace('1 MPa', '10 kPa')}loading = {{ radius = 16e-6, points = 4 }}")
    assert "at smaller radii" not in jkr("transform", "body.toml", "--no-plots", "-v").out

"""No line of a result contradicts the error of its headline: series that are not those of the bodies stated."""

from pathlib import Path

import numpy as np
import pytest
from meshed_series import draw

from jkrcli.adhesion.curve import LOAD_CONTROL, AdhesiveCurve, Nonadhesive
from jkrcli.adhesion.pull_off_error import error_of_rows, pull_off_error
from jkrcli.adhesion.slopes import slopes
from jkrcli.base.errors import Unknown
from jkrcli.resolve.analysis import Analysis, analyse
from jkrcli.resolve.foreign import SeriesReading, read_series
from jkrcli.series import Series

# Of radii and loads: what is wrong with the series, and what the cause is called
WRONG = {
    "right": (1.0, 1.0, ""),
    "radii of another unit": (1.08, 1.0, "contact radii are not"),
    "radii of another mesh": (0.97, 1.0, ""),
    "loads of another modulus": (1.0, 1.3, "the loads are 1.3"),
}


def imported(number: int, of_radii: float, of_loads: float, folder: Path) -> tuple[Analysis, dict[str, tuple]]:
    rng = np.random.default_rng(100 + number)
    series = draw("two zones" if number % 2 else "even", rng, False, True)
    while series.body.name.startswith("bonded layer 0.49"):
        series = draw("even", rng, False, True)
    a, delta, P = series.columns
    table = np.stack([of_radii * a, delta, of_loads / series.factor * P], axis=1)
    np.savetxt(folder / "t.csv", table, delimiter=",", header="a_m,delta_m,P_N", comments="", fmt="%.10g")
    solution = read_series(folder / "t.csv", series.body.problem, SeriesReading())
    return analyse(solution, [series.w])[0], series.body.pull_off(series.w)


@pytest.mark.parametrize("number", [0, pytest.param(1, marks=pytest.mark.slow)])
@pytest.mark.parametrize("what", WRONG)
def test_no_error_is_stated_below_what_the_exact_solution_is_off(what: str, number: int, tmp_path: Path) -> None:
    of_radii, of_loads, cause = WRONG[what]
    result, exact = imported(number, of_radii, of_loads, tmp_path)
    for control, (_, delta, P) in exact.items():
        point, half = result.pull_off[control], result.pull_off_errors.get(control)
        if isinstance(point, Unknown) or isinstance(half, Unknown) or half is None:
            continue
        assert abs(point.P - P) <= half["P"] + 2e-3 * abs(P)
        assert abs(point.delta - delta) <= half["delta"] + 2e-3 * abs(delta)
    assert cause in " ".join(result.warnings)
    comparison, half = result.comparison, result.pull_off_errors["load"]
    if comparison is not None and isinstance(comparison.pull_off, float) and not isinstance(half, Unknown):
        assert abs(comparison.pull_off) <= 1.01 * half["P"] / abs(exact["load"][2]) + 1e-4


def test_no_error_is_stated_below_what_another_rule_that_was_computed_is_off() -> None:
    """S and S' of a series 6 % above those of its own loads, by more than it states: by "integral" they are right."""
    R, E_star, a = 1e-3, 1e6, np.geomspace(2e-6, 1e-4, 60)
    delta, P, S, dS = a**2 / R, 4 / 3 * E_star * a**3 / R, 2.12 * E_star * a, np.full(a.size, 2.12 * E_star)
    errors = {"delta": 1e-6 * delta, "P": 1e-3 * P, "S": 1e-3 * S, "dS": 1e-3 * dS}
    series = Series(a, delta, P, S, dS, errors=errors)
    found, w = slopes(series), 8 * E_star * 4e-5**3 / (9 * np.pi * R**2)
    assert found.method == "exact"
    assert "deviates by more" in found.reason
    curve = AdhesiveCurve(Nonadhesive(series, found), w)
    point = curve.pull_off(LOAD_CONTROL)
    half, alone = pull_off_error(curve, point, LOAD_CONTROL), error_of_rows(curve, point, LOAD_CONTROL)
    off = abs(point.P + 1.5 * np.pi * w * R)
    assert alone["P"] < off / 5
    assert off * 0.99 < half["P"] < off * 1.01

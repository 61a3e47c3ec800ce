"""No line of a result contradicts the error of its headline: series that are not those of the bodies stated."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from meshed_series import draw

from jkrcli.base.errors import Unknown
from jkrcli.data.foreign import SeriesReading, read_series
from jkrcli.resolve.analysis import Analysis, analyse

# Of radii and loads: what is wrong with the series, and what the cause is called
WRONG = {
    "right": (1.0, 1.0, ""),
    "radii of another unit": (1.08, 1.0, "contact radii are not"),
    "radii of another mesh": (0.97, 1.0, ""),
    "loads of another modulus": (1.0, 1.3, "the loads are 1.3"),
}


def imported(number: int, of_radii: float, of_loads: float, folder: Path) -> tuple[Analysis, dict[str, tuple]]:
    """A drawn series, wrong by factors, and the exact pull-off points of the bodies that are stated."""
    rng = np.random.default_rng(100 + number)
    series = draw("two zones" if number % 2 else "even", rng, False, True)
    while series.body.name.startswith("bonded layer 0.49"):
        series = draw("even", rng, False, True)
    a, delta, P = series.columns
    table = np.stack([of_radii * a, delta, of_loads / series.factor * P], axis=1)
    np.savetxt(folder / "t.csv", table, delimiter=",", header="a_m,delta_m,P_N", comments="", fmt="%.10g")
    solution = read_series(folder / "t.csv", series.body.problem, SeriesReading())
    return analyse(solution, [series.w])[0], series.body.pull_off(series.w)


@pytest.mark.parametrize("number", [0, pytest.param(1, marks=pytest.mark.slow), pytest.param(2, marks=pytest.mark.slow),
                                    pytest.param(3, marks=pytest.mark.slow)])  # fmt: skip
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

"""Tables with noise become series by the fit: nothing is refused, outliers and drift are named."""

from pathlib import Path

import numpy as np
import pytest

from jkrcli.base.errors import InputError
from jkrcli.resolve.analysis import analyse
from jkrcli.resolve.foreign import SeriesReading, read_series
from jkrcli.series import Solution
from jkrcli.series.vocabulary import is_within_noise
from studies.disturbed import cell, disturbed
from studies.noise_cells import BODIES

HERTZ = BODIES[0]


def read(path: Path, columns: np.ndarray) -> Solution:
    np.savetxt(path, columns.T, delimiter=",", header="a_m,delta_m,P_N", comments="", fmt="%.17g")
    return read_series(path, HERTZ.problem(columns.shape[1]), SeriesReading())


@pytest.mark.parametrize(("noise", "points"), [(1e-2, 60), (3e-2, 15)])
def test_noise_is_not_refused(tmp_path: Path, noise: float, points: int) -> None:
    for seed in range(3):
        solution = read(tmp_path / "t.csv", disturbed(HERTZ.series(points), "independent", noise, seed))
        assert len(solution.series) == points
        assert (np.diff(solution.series.P) > 0).all()
        assert solution.warnings == ()


def test_outliers_are_named_by_their_lines(tmp_path: Path) -> None:
    columns = disturbed(HERTZ.series(60), "independent", 1e-2, 0)
    clean = analyse(read(tmp_path / "t.csv", columns), [50.0])[0]
    columns[2, 20] *= 1.5
    columns[1, 40] *= 0.7
    solution = read(tmp_path / "t.csv", columns)
    assert solution.warnings == ("2 of 60 rows are outliers and have little weight: 22, 42",)
    (spoiled,) = analyse(solution, [50.0])
    shift = spoiled.pull_off["load"].P / clean.pull_off["load"].P - 1
    assert abs(shift) < clean.pull_off_errors["load"]["P"] / abs(clean.pull_off["load"].P)
    assert spoiled.warnings.count(solution.warnings[0]) == 1


def test_a_drift_of_the_load_is_said(tmp_path: Path) -> None:
    solution = read(tmp_path / "t.csv", disturbed(HERTZ.series(60), "drift", 1e-3, 0))
    (words,) = solution.warnings
    assert words.startswith("the load drifts from the solution of these bodies at the same contact radii by +4.")


def test_errors_of_neighbours_that_go_together_are_said_and_few_rows_cannot_tell(tmp_path: Path) -> None:
    (many,) = analyse(read(tmp_path / "t.csv", disturbed(HERTZ.series(60), "AR(1) 0.9", 1e-2, 0)), [50.0])
    said = [words for words in many.warnings if words.startswith("errors of neighbouring rows are autocorrelated (")]
    assert len(said) == 1
    few = analyse(read(tmp_path / "t.csv", disturbed(HERTZ.series(15), "AR(1) 0.9", 1e-2, 0)), [50.0])[0]
    assert few.curve.slopes.reason.endswith("cannot be estimated from so few points")


def test_the_band_of_large_noise_that_goes_together_is_no_wider_than_it_need_be(tmp_path: Path) -> None:
    """It was 0.3 to 0.6: a correlation of 0.98 was believed by the residuals of a linearised fit six times as large."""
    solution = read(tmp_path / "t.csv", disturbed(HERTZ.series(500), "AR(1) 0.9", 3e-2, 3000))
    (found,) = analyse(solution, [50.0])
    assert 0.01 < found.pull_off_errors["load"]["P"] / abs(found.pull_off["load"].P) < 0.1  # 0.04 measured


def test_what_no_noise_does_is_refused_as_before(tmp_path: Path) -> None:
    columns = disturbed(HERTZ.series(60), "independent", 1e-3, 0)
    unloading = np.concatenate([exact_columns(), exact_columns()[:, 50:30:-1]], axis=1)
    with pytest.raises(InputError, match="unloading: remove them"):
        read(tmp_path / "t.csv", unloading)
    shuffled = columns[:, np.random.default_rng(0).permutation(60)]
    with pytest.raises(InputError, match="--sort orders them by displacement"):
        read(tmp_path / "t.csv", shuffled)
    assert not is_within_noise(*columns[:, :5])


def exact_columns() -> np.ndarray:
    exact = HERTZ.series(60)
    return np.stack([exact.a, exact.delta, exact.P])


def test_an_outlier_below_zero_costs_its_row_only(tmp_path: Path) -> None:
    columns = disturbed(HERTZ.series(60), "independent", 1e-2, 0)
    clean = analyse(read(tmp_path / "t.csv", columns), [50.0])[0]
    columns[2, 40] *= -0.1
    columns[0, 50] *= -1
    solution = read(tmp_path / "t.csv", columns)
    (words,) = solution.warnings
    assert words == "2 of 60 rows left out, whose radius, displacement or load is not positive: 42, 52"
    assert len(solution.series) == 58
    found = analyse(solution, [50.0])[0].pull_off["load"].P
    assert abs(found / clean.pull_off["load"].P - 1) < 4e-3  # 2.1e-3 measured; the band is 8e-3


@pytest.mark.parametrize(("near", "outlier"), [(3, 14), (2, 12)])
def test_an_outlier_below_zero_is_none_of_the_rows_near_first_touch(tmp_path: Path, near: int, outlier: int) -> None:
    columns = disturbed(HERTZ.series(60), "independent", 1e-2, 0)
    columns[2, :near] *= -1
    columns[2, outlier] *= -0.1
    solution = read(tmp_path / "t.csv", columns)
    assert solution.warnings[0] == f"{near} rows near first touch, where noise hides the contact, are left out"
    assert solution.warnings[1].endswith(f"whose radius, displacement or load is not positive: {outlier + 2}")
    assert len(solution.series) == 59 - near


def test_an_outlier_at_the_end_of_few_rows_is_no_other_order(tmp_path: Path) -> None:
    columns = disturbed(HERTZ.series(15), "independent", 1e-2, 0)
    columns[0, 14] = columns[0, 4]
    (words,) = read(tmp_path / "t.csv", columns).warnings
    assert words == "1 of 15 rows is an outlier and has little weight: 16"


def test_rows_in_order_keep_their_scatter_where_one_is_left_out(tmp_path: Path) -> None:
    columns = disturbed(HERTZ.series(15), "independent", 1e-2, 0)
    assert (np.diff(columns) > 0).all()
    columns[2, 14] *= -0.1
    (found,) = analyse(read(tmp_path / "t.csv", columns), [50.0])
    assert found.pull_off_errors["load"]["P"] / abs(found.pull_off["load"].P) > 5e-3  # 0.02 measured


@pytest.mark.first(2)
@pytest.mark.parametrize("factor", [1.2, 1.7])
@pytest.mark.parametrize("points", [60, 500])
def test_a_radius_beyond_all_others_is_an_outlier(tmp_path: Path, points: int, factor: float) -> None:
    columns = disturbed(HERTZ.series(points), "independent", 1e-2, 0)
    last, row = columns[0].max(), points * 23 // 25
    columns[0, row] *= factor
    (found,) = analyse(read(tmp_path / "t.csv", columns), [50.0])
    assert found.curve.series.a[-1] == last
    assert found.warnings == [f"1 of {points} rows is an outlier and has little weight: {row + 2}"]
    assert found.pull_off_errors["load"]["P"] / abs(found.pull_off["load"].P) < 0.01  # 0.008 and 0.002 measured


def test_rows_in_order_end_at_the_last_radius_that_is_no_outlier_too(tmp_path: Path) -> None:
    columns = disturbed(HERTZ.series(60), "independent", 1e-3, 0)
    last = columns[0, 58]
    columns[0, 59] *= 1.5
    columns[2, 30] *= -0.1
    assert read(tmp_path / "t.csv", columns).series.a[-1] == last


@pytest.mark.slow
@pytest.mark.parametrize("body", BODIES[:3:2], ids=lambda body: body.name)
@pytest.mark.parametrize("kind", ["independent", "AR(1) 0.5", "AR(1) 0.9", "outliers", "drift"])
def test_bands_of_the_pull_off_force_hold_or_the_data_are_doubted(body, kind: str) -> None:
    found = cell(body, 60, kind, 1e-2, range(100))
    assert found.refused == 0
    if kind == "independent":
        assert found.warned <= 0.08
    assert found.held >= 0.8 or found.warned > 0.95
    assert not found.unwarned_held < 0.8 or found.warned > 0.95


@pytest.mark.slow
def test_the_band_of_few_rows_is_no_wider_than_it_need_be() -> None:
    """An allowance for smoothing bias three times as large made it 6 % wider; it holds always, since what the exact
    solution of these bodies is off enters it."""
    for kind, most in (("independent", 3.75), ("outliers", 3.35)):
        found = cell(HERTZ, 15, kind, 1e-3, range(500))
        assert 2.9 < found.half_width / found.median < most  # 3.64, 3.26; 2.9 of normal errors


@pytest.mark.slow
def test_a_drift_as_large_as_the_noise_is_said_or_held() -> None:
    """Of 5 % and 3 %: 0.77 of the bands hold; those without a warning used to in 0.82, warned were 0.13."""
    found = cell(HERTZ, 60, "drift", 3e-2, range(100))
    assert found.warned > 0.35  # 0.5 of 200 measured
    assert found.unwarned_held > 0.8  # 0.90 of 200 measured

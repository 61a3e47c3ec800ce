"""``transform --points``: a table of so many rows, on the curve between the rows of the solution."""

import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import CASES
from every_verb import write_inputs

from jkrcli import load_case, solve, transform
from jkrcli.adhesion.curve import AdhesiveCurve
from jkrcli.base.errors import InputError
from jkrcli.case import store
from jkrcli.report.tables import curve_table
from jkrcli.resolve.analysis import analyse
from jkrcli.resolve.foreign import SeriesReading, read_series
from jkrcli.resolve.resolve import resolve_with


@pytest.fixture(name="gel")
def _gel(jkr: Callable, tmp_path: Path) -> Path:
    write_inputs(tmp_path, jkr)
    return Path("gel.h5")


def columns(path: str) -> dict[str, np.ndarray]:
    rows = list(csv.DictReader(Path(path).read_text().splitlines()))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0] if name != "branch"}


@pytest.mark.parametrize("points", [2, 7, 1000])
def test_so_many_rows_lie_on_the_curve(jkr: Callable, gel: Path, points: int) -> None:
    assert jkr("transform", gel, "--w", "35 mJ/m^2", "--points", points, "--no-plots").code == 0
    table = columns("gel-w0.035.csv")
    assert table["a_m"].size == points
    curve = analyse(store.read_solution(gel), [0.035])[0].curve
    delta, P = curve.at(table["a_m"])
    np.testing.assert_allclose(table["delta_m"], delta, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(table["P_N"], P, rtol=1e-6, atol=1e-12)
    assert table["a_m"][[0, -1]] == pytest.approx(curve.a[[0, -1]], rel=1e-15)
    assert (table["P_err_N"] > 0).all()


def test_the_points_of_the_solution_are_its_rows_and_pull_off_does_not_change(jkr: Callable, gel: Path) -> None:
    result = analyse(store.read_solution(gel), [0.035])[0]
    rows = len(result.curve.series)
    assert isinstance(result.curve, AdhesiveCurve)
    plain, same = curve_table(result), curve_table(result, points=rows)
    for name in ("a_m", "delta_m", "P_N", "S_N_per_m", "dS_da_N_per_m2"):
        np.testing.assert_allclose(same[name], plain[name], rtol=1e-7)
    few, many = (jkr("transform", gel, "--points", n, "--w", "0.035", "--no-plots", "--force").out for n in (5, 500))
    assert few == many


@pytest.mark.parametrize("rows", [6, 12])
def test_errors_hold_what_lies_between_few_points(rows: int) -> None:
    problem = load_case(CASES / "coating.toml").model.problem()
    few = solve(replace(problem, loading=replace(problem.loading, points=rows)), method="layered")
    table = curve_table(transform(few, 0.05), points=25)
    delta, P = transform(resolve_with(problem, table["a_m"]), 0.05).curve.at(table["a_m"])
    for found, true, error in ((table["delta_m"], delta, "delta_err_m"), (table["P_N"], P, "P_err_N")):
        off = np.abs(found - true) / table[error]
        assert off.max() < 3
        assert np.quantile(off, 0.9) < 1


def test_points_far_apart_have_no_errors_between_them(gel: Path) -> None:
    solution = store.read_solution(gel)
    rows = [getattr(solution.series, name)[[0, 20, 40, 60, 80, 99]] for name in ("a", "delta", "P")]
    np.savetxt("few.csv", np.column_stack(rows), delimiter=",", header="a_m,delta_m,P_N", comments="")
    few = analyse(read_series(Path("few.csv"), solution.problem, SeriesReading()), [0.035])[0]
    with pytest.raises(InputError, match="--points: the error between its points is unknown where neighbouring radii"):
        curve_table(few, points=50)


def test_curves_of_finite_range_are_refused(jkr: Callable, gel: Path) -> None:
    err = jkr("transform", gel, "--w", "0.035", "--range", "1 um", "--points", "50", "--no-plots").err
    assert "--points is of curves without range" in err

"""Series files: what is written comes back, and everything else is refused in one line."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from jkrcli.base.errors import InputError
from jkrcli.base.unknown import Unknown
from jkrcli.case import load_case, store
from jkrcli.methods.closed_form.method import ClosedForm
from jkrcli.series import ErrorBudget, PressureTable, RawSeries, Series, Solution

CASE = load_case(Path(__file__).parents[2] / "cases" / "halfspace.toml")


@pytest.fixture(name="path")
def _path(tmp_path: Path) -> Path:
    path = tmp_path / "data.h5"
    solution = ClosedForm()(CASE.model.problem())
    store.write(path, solution, CASE.to_toml(), CASE.model.problem().key, "jkr run halfspace.toml")
    return path


def test_round_trip(path: Path) -> None:
    solution, stored = ClosedForm()(CASE.model.problem()), store.read(path)
    series, dropped = stored.series()
    assert dropped == 0
    for name in ("a", "delta", "P", "S", "dS"):
        np.testing.assert_array_equal(getattr(series, name), getattr(solution.series, name))
        np.testing.assert_array_equal(series.errors[name], solution.series.errors[name])
    assert stored.budget == solution.budget
    assert (stored.case, stored.key, stored.method) == (CASE.to_toml(), CASE.model.problem().key, "closed-form")
    assert stored.command_line == "jkr run halfspace.toml"
    assert stored.versions["numpy"] == np.__version__


def test_raw_increments_pressure_and_reasons_come_back(tmp_path: Path) -> None:
    raw = RawSeries(np.array([0.0, 1, 1, 2]), np.array([1.0, 2, 3, 4]), np.array([1.0, 2, 3, 4]))
    series = Series(np.array([1.0, 2]), np.array([2.0, 4]), np.array([2.0, 4]), a0=0.5, S0=None)
    pressure = PressureTable(np.array([0.0, 1]), np.ones((4, 2)))
    budget = ErrorBudget(1e-3, Unknown("nobody asked"), 0.0)
    solution = Solution(
        series, budget, "fem", raw, pressure, {"nodes": 7, "solver": "SuperLU"}, {"mesh": 0.1}, ("mind",)
    )
    store.write(tmp_path / "x.h5", solution, "", "key", "")
    stored = store.read(tmp_path / "x.h5")
    kept, dropped = stored.series()
    assert dropped == 2
    np.testing.assert_array_equal(kept.a, [1, 2])
    np.testing.assert_array_equal(kept.delta, [2, 4])
    assert (kept.a0, kept.S0) == (0.5, None)
    assert stored.budget == budget
    assert stored.budget.total == Unknown("nobody asked")
    assert (stored.facts, stored.timings, stored.warnings) == (
        {"nodes": 7, "solver": "SuperLU"},
        {"mesh": 0.1},
        ("mind",),
    )
    found = store.read_pressure(tmp_path / "x.h5")
    assert found is not None
    np.testing.assert_array_equal(found.p, pressure.p)


def _edit(path: Path, change) -> None:
    with h5py.File(path, "r+") as file:
        change(file)


def _replace(name: str, values, unit: str | None = "m"):
    def change(file: h5py.File) -> None:
        del file[name]
        data = file.create_dataset(name, data=values)
        if unit is not None:
            data.attrs["unit"] = unit

    return change


def _nan_in_row_five(file: h5py.File) -> None:
    file["series/P"][4] = np.nan


def _delete(name: str):
    def change(file: h5py.File) -> None:
        del file[name]

    return change


def _attribute(name: str, value):
    def change(file: h5py.File) -> None:
        file.attrs[name] = value

    return change


WRONG = {
    "format": (
        _attribute("format", "nexus"),
        'format must be "jkr-series", got "nexus"; was this file written by jkr?',
    ),
    "no format": (
        lambda file: file.attrs.__delitem__("format"),
        'format must be "jkr-series", got ""; was this file written by jkr?',
    ),
    "version": (_attribute("version", 2), "version must be 1, got 2; this file needs another release of jkr"),
    "no series": (_delete("series"), 'group "series" is missing'),
    "no column": (_delete("series/delta"), 'dataset "series/delta" is missing'),
    "no errors": (_delete("errors"), 'group "errors" is missing'),
    "no case": (_delete("case"), 'dataset "case" is missing'),
    "text column": (
        _replace("series/a", np.array([b"x", b"y"])),
        "series/a: must be a column of numbers, got |S1 of shape (2,)",
    ),
    "matrix": (
        _replace("series/a", np.ones((2, 2))),
        "series/a: must be a column of numbers, got float64 of shape (2, 2)",
    ),
    "empty": (_replace("series/a", np.ones(0)), "series/a: must have 1 to 10000000 rows, got 0"),
    "unit": (_replace("series/a", np.ones(100), "um"), 'series/a: unit must be "m", got "um"'),
    "no unit": (_replace("series/a", np.ones(100), None), 'series/a: unit must be "m", got ""'),
    "nan": (_nan_in_row_five, "series/P: row 5 must be a finite number, got nan"),
    "lengths": (
        _replace("series/a", np.ones(3)),
        "series: all columns must have the same length, got {'a': 3, 'delta': 100, 'P': 100, 'S': 100, 'dS': 100}",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_content_gives_its_whole_line(path: Path, name: str) -> None:
    change, line = WRONG[name]
    _edit(path, change)
    with pytest.raises(InputError) as caught:
        store.read(path)
    assert caught.value.lines == (f"{path}: {line}",)


def test_falling_load_is_named(path: Path) -> None:
    def change(file: h5py.File) -> None:
        file["series/P"][4] = 0.0

    _edit(path, change)
    with pytest.raises(InputError) as caught:
        store.read(path).series()
    assert caught.value.lines == (f"{path}: series: P must be positive and increase, point 5 is 0",)


def test_foreign_truncated_missing(path: Path) -> None:
    whole = path.read_bytes()
    for content, line in {
        b"a_m,delta_m\n1,2\n": "is not an HDF5 file",
        b"": "is not an HDF5 file",
        whole[: len(whole) // 2]: "the HDF5 file is truncated and cannot be read; run the case again",
    }.items():
        path.write_bytes(content)
        with pytest.raises(InputError) as caught:
            store.read(path)
        assert caught.value.lines == (f"{path}: {line}",)
    path.unlink()
    with pytest.raises(InputError, match="series file not found"):
        store.read(path)


@pytest.mark.parametrize("trials", [100, pytest.param(10_000, marks=pytest.mark.slow)])
def test_damage_is_refused_in_one_line_or_did_not_touch_a_number(path: Path, trials: int) -> None:
    whole, rng = path.read_bytes(), np.random.default_rng(1)
    before, _ = store.read(path).series()
    refused = []
    for _ in range(trials):
        damaged = bytearray(whole)
        for place in rng.integers(0, len(whole), rng.integers(1, 20)):
            damaged[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(damaged[: rng.integers(len(whole) // 2, len(whole))] if rng.random() < 0.1 else damaged)
        try:
            series, _ = store.read(path).series()
        except InputError as error:
            refused.append(error.lines)
            continue
        for name in ("a", "delta", "P", "S", "dS"):
            np.testing.assert_array_equal(getattr(series, name), getattr(before, name))
    assert refused
    assert all(len(lines) == 1 and "\n" not in lines[0] for lines in refused)


def test_failed_write_leaves_the_old_file_and_no_other(path: Path) -> None:
    before = path.read_bytes()
    bad = Solution(ClosedForm()(CASE.model.problem()).series, ErrorBudget(0.0, 0.0, 0.0), "fem", facts={"x": object()})
    with pytest.raises(TypeError):
        store.write(path, bad, "", "", "")
    assert path.read_bytes() == before
    assert [p.name for p in path.parent.iterdir()] == [path.name]

"""Series files: what is written comes back, and everything else is refused in one line."""

import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from conftest import refused_by
from series_files import edit, one_byte_changed

from jkrcli.base import hdf5
from jkrcli.base.errors import InputError, Unknown
from jkrcli.case import store
from jkrcli.case.models import load_case, parse_case
from jkrcli.methods.closed_form import ClosedForm
from jkrcli.series import COLUMNS, CoarseSeries, ErrorBudget, PressureTable, RawSeries, Series, Solution

CASE = load_case(Path(__file__).parents[2] / "cases" / "halfspace.toml")
PROBLEM = CASE.model.problem()
# Written by release 0.1.0 (commit 80f3bba): `jkr run small.toml`; the case is what `jkr show --case` prints of it.
FORMAT_1 = Path(__file__).with_name("format-1.h5")
WIDER = 1.959964 / 1.644854  # half-widths of a normal error at 95 % over those at 90 %, which files of today state


@pytest.fixture(name="path")
def _path(tmp_path: Path) -> Path:
    path = tmp_path / "data.h5"
    store.write_solution(path, replace(ClosedForm()(PROBLEM), record=store.record_of(CASE)), "jkr run halfspace.toml")
    return path


def in_increments(**changes: Any) -> Solution:
    raw = RawSeries(np.array([0.0, 1, 1, 2]), np.array([1.0, 2, 3, 4]), np.array([1.0, 2, 3, 4]), np.arange(5, 9))
    coarser = Series(
        np.array([1.5, 3]), np.array([3.0, 6]), np.array([3.0, 7]), np.ones(2), np.ones(2), a0=0.5, S0=None
    )
    series = Series(
        np.array([1.0, 2]), np.array([2.0, 4]), np.array([2.0, 4]), errors={"P": np.ones(2)}, a0=0.5, S0=None,
        coarser=CoarseSeries(
            replace(coarser, coarser=CoarseSeries(replace(coarser, delta=coarser.delta + 1), 2.0)), 1.5
        ),
    )  # fmt: skip
    pressure = PressureTable(np.array([0.0, 1]), np.arange(8.0).reshape(4, 2))
    budget, facts = ErrorBudget(1e-3, Unknown("nobody asked"), 0.0), {"nodes": 7, "solver": "SuperLU", "fits": True}
    made = Solution(PROBLEM, series, budget, "fem", raw, pressure, facts, {"mesh": 0.1}, ("mind", "the gap"))
    return replace(made, record=store.record_of(CASE), **changes)


def assert_same_by_larger_elements(one: Series, other: Series) -> None:
    assert (one.coarser is None) == (other.coarser is None)
    if one.coarser is not None and other.coarser is not None:
        assert one.coarser.ratio == other.coarser.ratio
        for name in COLUMNS:
            np.testing.assert_array_equal(getattr(one.coarser.series, name), getattr(other.coarser.series, name))
        assert_same_by_larger_elements(one.coarser.series, other.coarser.series)


def assert_same(one: Solution, other: Solution) -> None:
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(one.series, name), getattr(other.series, name))
        np.testing.assert_array_equal(one.series.errors.get(name), other.series.errors.get(name))
    for name in ("a", "delta", "P", "rows"):
        np.testing.assert_array_equal(getattr(one.increments, name), getattr(other.increments, name))
    assert (one.raw is None) == (other.raw is None)
    assert_same_by_larger_elements(one.series, other.series)
    for name in ("problem", "budget", "method", "facts", "timings", "warnings", "key"):
        assert getattr(one, name) == getattr(other, name), name
    assert (one.series.a0, one.series.S0) == (other.series.a0, other.series.S0)
    assert one.record.toml == other.record.case.to_toml(other.method)
    for name in ("title", "w", "z0"):
        assert getattr(one.record, name) == getattr(other.record, name), name
    assert (one.pressure is None) == (other.pressure is None)
    if one.pressure is not None and other.pressure is not None:
        np.testing.assert_array_equal(one.pressure.p, other.pressure.p)
        np.testing.assert_array_equal(one.pressure.r, other.pressure.r)


@pytest.mark.parametrize("solution", [replace(ClosedForm()(PROBLEM), record=store.record_of(CASE)), in_increments()])
def test_what_a_method_returns_is_what_its_file_gives_back(solution: Solution, tmp_path: Path) -> None:
    path = tmp_path / "x.h5"
    store.write_solution(path, solution, "jkr run halfspace.toml")
    found = store.read_solution(path, with_pressure=True)
    assert_same(found, solution)
    assert found.record.command_line == "jkr run halfspace.toml"
    assert found.record.versions["numpy"] == np.__version__
    store.write_solution(path, found, "jkr again")
    again = store.read_solution(path, with_pressure=True)
    assert_same(again, solution)
    assert again.record.command_line == "jkr run halfspace.toml"


def root_of(path: Path) -> hdf5.Group:
    return hdf5.tree_of(path, path.read_bytes(), ())


def test_two_runs_of_a_case_have_one_digest(tmp_path: Path) -> None:
    roots = []
    for seconds in (1.0, 2.0):
        path = tmp_path / f"{seconds}.h5"
        store.write_solution(path, in_increments(timings={"solve": seconds}))
        assert store.read_solution(path).timings == {"solve": seconds}
        roots.append(root_of(path))
    assert roots[0].attributes[hdf5.SEAL] == roots[1].attributes[hdf5.SEAL]
    with h5py.File(path, "r+") as file:
        file["timings_s"].attrs["solve"] = 3.0
    assert "does not hold what was written" in refused_by(store.read_solution, path)[0]


def test_a_file_whose_times_are_under_its_digest_is_read(path: Path) -> None:
    before = store.read_solution(path).timings
    with h5py.File(path, "r+") as file:
        del file["timings_s"].attrs[hdf5.SEAL]
    with pytest.raises(InputError, match="does not hold what was written"):
        store.read_solution(path)
    digest = hdf5.digest(root_of(path))
    with h5py.File(path, "r+") as file:
        file.attrs[hdf5.SEAL] = np.bytes_(digest)
    assert store.read_solution(path).timings == before


def test_pressures_are_read_where_they_are_asked_for(tmp_path: Path) -> None:
    store.write_solution(tmp_path / "x.h5", in_increments())
    assert store.read_solution(tmp_path / "x.h5").pressure is None
    edit(tmp_path / "x.h5", lambda file: file["contact"].attrs.__setitem__("sha256", "0"))
    with h5py.File(tmp_path / "x.h5", "r+") as file:
        file["contact/pressure"][1, 1] = 9.0
    assert store.read_solution(tmp_path / "x.h5").facts["nodes"] == 7
    with pytest.raises(InputError, match="does not hold what was written"):
        store.read_solution(tmp_path / "x.h5", with_pressure=True)


def test_a_problem_without_a_case_is_written_as_one(tmp_path: Path) -> None:
    store.write_solution(tmp_path / "x.h5", ClosedForm()(PROBLEM))
    found = store.read_solution(tmp_path / "x.h5")
    assert (found.problem, found.record.w, found.record.title) == (PROBLEM, (), "")


def _replace(name: str, values, unit: str | None = "m"):
    def change(file: h5py.File) -> None:
        del file[name]
        data = file.create_dataset(name, data=values)
        if unit is not None:
            data.attrs["unit"] = hdf5._fixed(unit)

    return change


def _in_row_five(value: float):
    return lambda file: file["series/P"].__setitem__(4, value)


def _delete(name: str):
    return lambda file: file.__delitem__(name)


def _attribute(name: str, value):
    return lambda file: file.attrs.__setitem__(name, value)


WRONG = {
    "format": (_attribute("format", "nexus"), 'format must be "jkr-series", got "nexus"; was this file written by jkr'),
    "no format": (lambda file: file.attrs.__delitem__("format"), 'format must be "jkr-series", got ""; was this file'),
    "version": (_attribute("version", 3), "version must be 2, got 3; this file needs another release of jkr"),
    "no series": (_delete("series"), 'group "series" is missing'),
    "no column": (_delete("series/delta"), 'dataset "series/delta" is missing'),
    "no errors": (_delete("errors"), 'group "errors" is missing'),
    "no facts": (_delete("facts"), 'group "facts" is missing'),
    "no warnings": (_delete("warnings"), 'group "warnings" is missing'),
    "no case": (_delete("case"), 'dataset "case" is missing'),
    "text column": (_replace("series/a", np.array([b"x", b"y"])), "series/a: must be a column of numbers, got |S1 of "),
    "matrix": (_replace("series/a", np.ones((2, 2))), "series/a: must be a column of numbers, got float64 of shape "),
    "empty": (_replace("series/a", np.ones(0)), "series/a: must have 1 to 10000000 rows, got 0"),
    "unit": (_replace("series/a", np.ones(100), "um"), 'series/a: unit must be "m", got "um"'),
    "no unit": (_replace("series/a", np.ones(100), None), 'series/a: unit must be "m", got ""'),
    "nan": (_in_row_five(np.nan), "series/P: row 5 must be a finite number, got nan"),
    "level": (
        lambda file: file["errors"].attrs.__setitem__("level", np.nan),
        "errors: attribute level must be between 0 and 1, got",
    ),
    "falling load": (_in_row_five(0.0), "series: P must be positive and increase, point 5 is 0"),
    "lengths": (_replace("series/a", np.ones(3)), "series: all columns must have the same length, got {'a': 3, 'delta"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_content_is_told_in_one_line(path: Path, name: str) -> None:
    change, line = WRONG[name]
    edit(path, change)
    (found,) = refused_by(store.read_solution, path)
    assert found.startswith(f"{path}: {line}")


def test_foreign_truncated_missing(path: Path) -> None:
    whole = path.read_bytes()
    none, cut = "is not an HDF5 file", "the HDF5 file is truncated and cannot be read; run the case again"
    for content, line in {b"a_m,delta_m\n1,2\n": none, b"": none, whole[: len(whole) // 2]: cut}.items():
        path.write_bytes(content)
        assert refused_by(store.read_solution, path) == (f"{path}: {line}",)
    path.unlink()
    with pytest.raises(InputError, match="solution file not found"):
        store.read_solution(path)


def test_a_file_that_another_program_writes_is_not_called_damaged(path: Path) -> None:
    words = "import h5py, sys; f = h5py.File(sys.argv[1], 'r+'); f.attrs['x'] = 1; f.flush(); print('open'); input()"
    with subprocess.Popen([sys.executable, "-c", words, path], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        assert other.stdout.readline() == b"open\n"
        (said,) = refused_by(store.read_solution, path)
        other.communicate(b"\n")
    assert said == f"{path}: the HDF5 file is open in another program, which is writing it; try again later"


@pytest.mark.parametrize("trials", [50, pytest.param(10_000, marks=pytest.mark.slow)])
def test_one_changed_byte_is_refused_or_changes_nothing(tmp_path: Path, trials: int) -> None:
    path = tmp_path / "x.h5"
    store.write_solution(path, in_increments())
    before = store.read_solution(path, with_pressure=True)

    def same() -> None:
        found = store.read_solution(path, with_pressure=True)
        assert_same(found, before)
        assert found.record.command_line == before.record.command_line
        assert found.record.versions == before.record.versions

    assert one_byte_changed(path, trials, same) > trials / 10


def test_a_changed_letter_of_the_case_is_found(path: Path) -> None:
    content = path.read_bytes()
    assert content.count(b"w = [\n    50.0") == 1
    path.write_bytes(content.replace(b"w = [\n    50.0", b"w = [\n    70.0"))
    with pytest.raises(InputError, match="does not hold what was written"):
        store.read_solution(path)


def test_errors_without_a_level_are_half_widths_at_90_percent(path: Path) -> None:
    touches = Series(np.array([1.0, 2]), np.array([2.0, 4]), np.array([2.0, 4]), errors={"P": np.ones(2)}, a0=0.5)
    solution = in_increments(touches=touches)
    store.write_solution(path, solution)
    with h5py.File(path) as file:
        assert file["errors"].attrs["level"] == 0.95
    edit(path, lambda file: file["errors"].attrs.pop("level"))
    found = store.read_solution(path)
    np.testing.assert_allclose(found.series.errors["P"], WIDER * solution.series.errors["P"], rtol=1e-6)
    np.testing.assert_allclose(found.touches.errors["P"], WIDER * touches.errors["P"], rtol=1e-6)
    assert found.budget.discretisation == pytest.approx(WIDER * 1e-3, rel=1e-6)
    store.write_solution(path, found)  # which states its own
    np.testing.assert_array_equal(store.read_solution(path).series.errors["P"], found.series.errors["P"])


def test_format_1_reads_and_is_said_to_be_without_full_protection(jkr: Callable, tmp_path: Path) -> None:
    shutil.copy(FORMAT_1, tmp_path / "old.h5")
    found = store.read_solution("old.h5")
    case = parse_case(found.record.toml.encode(), "old")
    exact = ClosedForm()(case.model.problem())
    for name in ("a", "delta", "P", "S", "dS"):  # up to 3e-16 apart on another processor than the one that wrote it
        np.testing.assert_allclose(getattr(found.series, name), getattr(exact.series, name), rtol=1e-15)
        np.testing.assert_allclose(found.series.errors[name], WIDER * exact.series.errors[name], rtol=1e-6)
    record = found.record
    assert (record.title, record.w, record.versions["jkr"]) == ("A file of format 1", (50.0,), "0.1.0")
    assert (found.method, found.raw) == ("closed-form", None)
    assert found.budget.total == pytest.approx(WIDER * exact.budget.total, rel=1e-6)
    warning = f"jkr: warning: old.h5: {store.NO_DIGEST}\n"
    for verb in ("show", "transform --no-plots", "pull-off", "profile --a 5um", "cycle --no-plots", "compare old.h5"):
        assert jkr(*verb.split(), "old.h5").ok.err.count(warning) == 1, verb
    assert store.NO_DIGEST in jkr("show", "old.h5", "--json").out
    assert store.NO_DIGEST in (tmp_path / "old-w50.json").read_text()


def test_format_1_with_increments_is_filtered(tmp_path: Path) -> None:
    path = tmp_path / "old.h5"
    shutil.copy(FORMAT_1, path)
    with h5py.File(path, "r+") as file:
        a = file["series/a"][()]
        a[2] = a[1]  # a node-based radius stays while the load grows
        file["series/a"][...] = a
        del file["series/S"], file["series/dS_da"], file["errors/a"], file["facts"]
    found = store.read_solution(path)
    np.testing.assert_array_equal(found.raw.a, a)
    np.testing.assert_array_equal(found.series.a, np.delete(a, 2))
    assert (found.series.errors, found.facts) == ({}, {})


def test_failed_write_leaves_the_old_file_and_no_other(path: Path) -> None:
    before = path.read_bytes()
    with pytest.raises(TypeError):
        store.write_solution(path, in_increments(facts={"x": object()}))
    assert path.read_bytes() == before
    assert [p.name for p in path.parent.iterdir()] == [path.name]

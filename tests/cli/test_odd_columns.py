"""Tables with dates, words that begin with a digit, numbers that stand for none, and rows that stand alone; options
that would have no effect."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import jkrcli as python
from jkrcli.base import files
from jkrcli.base.errors import InputError
from jkrcli.measured.curve import Reading
from jkrcli.resolve.foreign import SeriesReading
from jkrcli.tables.text import read_table

DEPTH = np.linspace(-1.0, 0.3, 40)  # um
LOAD = np.maximum(DEPTH, 0) ** 1.5 * 4e3  # nN


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def write(first: Callable[[int], str] | None, name: str = "first", separator: str = ",") -> Path:
    rows = [[f"{d:.6f}", f"{P:.6f}"] for d, P in zip(DEPTH, LOAD, strict=True)]
    head = ["delta (um)", "P (nN)"]
    if first is not None:
        rows, head = [[first(i), *row] for i, row in enumerate(rows)], [name, *head]
    path = Path("t.csv")
    path.write_text("\n".join(map(separator.join, [head, *rows])) + "\n")
    return path


@pytest.mark.parametrize(("first", "separator"), [
    (lambda i: f"2024-03-05T12:00:00.{i:06d}", ","), (lambda i: f"05.03.20{i:02d}", ";"), (lambda i: f"{i}th", "\t"),
    (lambda i: f"3/{1 + i % 28}/2024", ","), (lambda i: f"20240305T12{i:04d}", ","),
])  # fmt: skip
def test_a_column_of_dates_or_words_that_begin_with_a_digit(jkr, tmp_path, first, separator) -> None:
    path = write(first, separator=separator)
    (curve,) = python.measured_curves(path)
    np.testing.assert_allclose(curve.load, LOAD * 1e-9, atol=1e-15)
    assert any('of its 3 columns column 1 "first" holds words' in flag for flag in curve.flags)
    said = jkr("look", path, "--no-plots").out
    assert "39 rows" in said or "40 rows" in said


def test_numbers_with_units_in_their_cells_are_no_numbers(tmp_path: Path) -> None:
    Path("u.csv").write_text("delta,P (nN),w\n" + "".join(f"{i}nm,{i},{i}\n" for i in range(1, 20)))
    table = read_table(Path("u.csv"), least=2)
    with pytest.raises(InputError, match='holds text, not numbers: line 2 has "1nm"'):
        table.numbers(0)


@pytest.mark.parametrize("number", [-999.0, 99999.0])
def test_a_number_of_nines_stands_for_none(tmp_path: Path, number: float) -> None:
    path = write(None)
    lines = path.read_text().splitlines()
    for n in (5, 6, 30, 31, 32, 33):  # more than a tenth of the rows
        lines[n] = f"{number:g},{lines[n].split(',')[1]}"
    path.write_text("\n".join(lines) + "\n")
    (curve,) = python.measured_curves(path)
    assert len(curve) == 34
    assert f'column 1 "delta (um)": {number:g} stands for no number' in curve.flags
    assert any(flag.startswith("6 of 40 rows without a number left out (lines 6, 7, 31") for flag in curve.flags)


def test_a_number_of_nines_among_others_is_one(tmp_path: Path) -> None:
    path = Path("n.csv")
    path.write_text("delta (nm),P (nN)\n" + "".join(f"{z},{max(z, 0)}\n" for z in range(-1100, 1000, 33)) + "999,999\n")
    (curve,) = python.measured_curves(path)
    assert curve.depth[-1] == pytest.approx(999e-9)


@pytest.mark.parametrize("first", [True, False])
def test_a_row_alone_beside_an_empty_line_is_left_out(tmp_path: Path, first: bool) -> None:
    path = write(None)
    head, *rows = path.read_text().splitlines()
    path.write_text("\n".join([head, "0.1,0.2", "", *rows] if first else [head, *rows, "", "0.1,0.2"]) + "\n")
    (curve,) = python.measured_curves(path)
    np.testing.assert_allclose(curve.depth, DEPTH * 1e-6, atol=1e-12)
    line = 2 if first else 43
    assert f'line {line} stands alone beside an empty line and is left out: "0.1,0.2"' in curve.flags
    path.write_text("\n".join([head, *(line for row in rows for line in (row, ""))]) + "\n")  # every other line empty
    assert len(python.measured_curves(path)[0]) == 40


@pytest.mark.parametrize("factor", [1e-300, 0.0, -1e13, float("inf")])
def test_a_factor_has_bounds(factor: float) -> None:
    said = r"--factor P: must lie between 1e-12 and 1e\+12|\"P\" must be a finite number"
    for reading in (Reading, SeriesReading):
        with pytest.raises(InputError, match=said):
            reading(factors={"P": factor})


KILLED = """
import os, signal, sys
from pathlib import Path
from jkrcli.base.files import atomic
with atomic(Path(sys.argv[1])) as temporary:
    temporary.write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_what_a_killed_command_left_goes_with_the_next(tmp_path: Path) -> None:
    target = tmp_path / "x.csv"
    done = subprocess.run([sys.executable, "-c", KILLED, str(target)], check=False)
    assert done.returncode == -signal.SIGKILL
    (left,) = tmp_path.glob(".jkr-*")
    with files.atomic(tmp_path / "other.csv") as mine:  # of a process that lives
        mine.write_text("being written")
        files._tidy.cache_clear()
        files.check_target(target)
        assert not left.exists()
        assert mine.exists()

"""The one writer of CSV: what is written is read back, to the last bit and the last comma."""

import csv
import math
from pathlib import Path

import numpy as np

from jkrcli.base.files import write_csv


def test_numbers_keep_every_bit_and_words_their_commas(tmp_path: Path) -> None:
    numbers, words = np.array([0.1 + 0.2, 1e-300, -5e22]), ["plain", "with, comma", 'with "quotes", ü and µ']
    write_csv(tmp_path / "t.csv", {"x_m": numbers, "words, all": words, "n": (1, 2, 3)})
    with (tmp_path / "t.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    assert header == ["x_m", "words, all", "n"]
    assert [float(row[0]) for row in rows] == numbers.tolist()
    assert [row[1] for row in rows] == words
    assert [row[2] for row in rows] == ["1", "2", "3"]


def test_cells_without_a_value_are_empty(tmp_path: Path) -> None:
    write_csv(tmp_path / "t.csv", {"a": [None, math.nan, math.inf, 0.0], "b": ["x", "", None, "y"]})
    assert (tmp_path / "t.csv").read_text() == "a,b\n,x\n,\n,\n0.0,y\n"


def test_a_table_without_rows_is_its_header(tmp_path: Path) -> None:
    write_csv(tmp_path / "t.csv", {"a": [], "b": []})
    assert (tmp_path / "t.csv").read_text() == "a,b\n"

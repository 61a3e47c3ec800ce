"""The table of a sweep, a row per case, as CSV, HDF5 and, where pyarrow is installed, Parquet."""

from __future__ import annotations

import importlib.util
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ... import __version__
from ...base import Array, atomic, write_csv
from ...base.hdf5 import Dataset, Group
from ...report import archive
from .journal import Journal
from .plan import Plan
from .solving import FAILED

STEM = "table"
MISSING = "NaN: there is no value; the column reason says why"


@dataclass(frozen=True)
class SweepTable:
    """Columns by name, all of one length; None where there is no value."""

    columns: dict[str, list[Any]]

    def __len__(self) -> int:
        return len(self.columns["case"])

    @classmethod
    def of(cls, plan: Plan, journal: Journal) -> SweepTable:
        """The finished cases of a plan in the order of their numbers."""
        names = ("case", "status", "reason", *plan.key_columns, *plan.recipe.wanted.columns)
        columns: dict[str, list[Any]] = {name: [] for name in names}
        for number in range(plan.count):
            row = journal.rows.get(plan.identity(number))
            if row is not None:
                cells = (number, row.status, row.reason, *map(_cell, plan.values(number).values()), *row.values)
                for column, cell in zip(columns.values(), cells, strict=True):
                    column.append(cell)
        return cls(columns)

    @property
    def failed(self) -> list[tuple[int, str]]:
        """Numbers and reasons of the cases without a result."""
        rows = zip(*(self.columns[name] for name in ("case", "status", "reason")), strict=True)
        return [(number, reason) for number, status, reason in rows if status == FAILED]


def _cell(value: Any) -> Any:
    """A value of a key as one cell: tables and lists as JSON."""
    return json.dumps(value) if isinstance(value, dict | list | tuple) else value


def endings() -> tuple[str, ...]:
    """The kinds of files that can be written here."""
    return (".csv", ".h5", ".parquet") if importlib.util.find_spec("pyarrow") else (".csv", ".h5")


def write(folder: Path, table: SweepTable) -> list[Path]:
    """Write the table in every form, each whole or not at all; returns the files."""
    writers = {".csv": write_csv, ".h5": _write_hdf5, ".parquet": _write_parquet}
    paths = [folder / f"{STEM}{ending}" for ending in endings()]
    for path in paths:
        writers[path.suffix](path, table.columns)
    return paths


def _is_numeric(values: list[Any]) -> bool:
    return all(value is None or (isinstance(value, int | float) and not isinstance(value, bool)) for value in values)


def _write_hdf5(path: Path, columns: dict[str, list[Any]]) -> None:
    table = {name: Dataset(_as_dataset(values, name == "case")) for name, values in columns.items()}
    archive.write(path, archive.SWEEP_TABLE, {"missing": MISSING}, {"table": Group({}, table)})


def _as_dataset(values: list[Any], whole: bool) -> Array | list[str]:
    """A column of whole numbers, numbers or words: NaN or an empty text where there is no value."""
    if whole:
        return np.array(values, dtype=np.int64)
    if _is_numeric(values):
        return np.array([np.nan if value is None else value for value in values], dtype=float)
    return ["" if value is None else str(value) for value in values]


def _write_parquet(path: Path, columns: dict[str, list[Any]]) -> None:
    import pyarrow
    from pyarrow import parquet

    arrays = [_arrow(values, name == "case") for name, values in columns.items()]
    metadata = {"format": archive.SWEEP_TABLE, "jkr": __version__}
    with atomic(path) as temporary:
        table = pyarrow.Table.from_arrays(arrays, names=list(columns), metadata=metadata)
        parquet.write_table(table, temporary)


def _arrow(values: list[Any], whole: bool) -> Any:
    """A column of whole numbers, numbers or words, null where there is no value.

    From buffers: pyarrow's other constructors import pandas, which costs more than everything else here.
    """
    import pyarrow

    valid = pyarrow.py_buffer(np.packbits([value is not None for value in values], bitorder="little"))
    if whole or _is_numeric(values):
        kind, dtype = (pyarrow.int64(), np.int64) if whole else (pyarrow.float64(), np.float64)
        data = np.array([0 if value is None else value for value in values], dtype=dtype)
        return pyarrow.Array.from_buffers(kind, len(values), [valid, pyarrow.py_buffer(data)])
    encoded = [b"" if value is None else str(value).encode() for value in values]
    ends = np.concatenate([[0], np.cumsum([len(word) for word in encoded])]).astype(np.int64)
    buffers = [valid, pyarrow.py_buffer(ends), pyarrow.py_buffer(b"".join(encoded))]
    return pyarrow.Array.from_buffers(pyarrow.large_string(), len(values), buffers)

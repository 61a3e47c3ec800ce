"""A sweep, and one case of it, as results; its table, a row per case, as CSV, HDF5 and, with pyarrow, Parquet."""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ... import __version__
from ...base import Array, Dataset, Group, InputError, atomic, printable, write_csv
from ...report import Figure, Result, archive
from .journal import Journal
from .plan import FAILED, Plan, Row

STEM = "table"
MISSING = "NaN: there is no value; the column reason says why"
Columns: TypeAlias = dict[str, list[Any]]  # of one length; None where there is no value


@dataclass(frozen=True, eq=False)
class Swept(Result):
    """All cases of a ``plan`` in a table of ``columns``, a row each, and the ``files`` that hold it."""

    plan: Plan
    columns: Columns
    files: Sequence[Path] = ()

    @property
    def failed(self) -> list[tuple[int, str]]:
        """Numbers and reasons of the cases without a result."""
        rows = zip(*(self.columns[name] for name in ("case", "status", "reason")), strict=True)
        return [(number, reason) for number, status, reason in rows if status == FAILED]

    @property
    def warnings(self) -> list[str]:
        failed = self.failed
        return [f"{len(failed):,} cases failed, the first because: {failed[0][1]}"] if failed else []

    def summary(self) -> dict[str, Any]:
        return {
            "format": "jkr-sweep-summary",
            "cases": self.plan.count,
            FAILED: len(self.failed),
            "columns": list(self.columns),
            "files": [str(path) for path in self.files],
        }

    def words(self) -> list[str]:
        plan, failed = self.plan, self.failed
        return [
            f"{plan.count:,} cases, {len(failed):,} of them failed: {plan.title or plan.source}",
            f"  one case  {plan.command(failed[0][0] if failed else 0)}",
        ]

    def figure(self) -> Figure:
        from .figure import sweep_figure

        if (figure := sweep_figure(self.plan, self.columns)) is None:
            raise InputError(f"{self.plan.source}: no axis or no result is a number: there is nothing to draw")
        return figure


@dataclass(frozen=True, eq=False)
class SweptCase(Result):
    """The ``row`` of one case of a ``plan``."""

    plan: Plan
    row: Row

    def summary(self) -> dict[str, Any]:
        row, plan = self.row, self.plan
        inputs = dict(zip(plan.key_columns, plan.values(row.number).values(), strict=True))
        outputs = dict(zip(plan.recipe.wanted.columns, row.values, strict=True))
        return {"case": row.number, "status": row.status, "reason": row.reason, **inputs, **outputs}

    def words(self) -> list[str]:
        cells = self.summary().items()
        return [printable(f"{name:<40} {'' if value is None else value}".rstrip()) for name, value in cells]


def table(plan: Plan, journal: Journal) -> Columns:
    """The finished cases of a plan in the order of their numbers."""
    names = ("case", "status", "reason", *plan.key_columns, *plan.recipe.wanted.columns)
    columns: Columns = {name: [] for name in names}
    for number in range(plan.count):
        row = journal.rows.get(plan.identity(number))
        if row is not None:
            cells = (number, row.status, row.reason, *map(_cell, plan.values(number).values()), *row.values)
            for column, cell in zip(columns.values(), cells, strict=True):
                column.append(cell)
    return columns


def _cell(value: Any) -> Any:
    """A value of a key as one cell: tables and lists as JSON."""
    return json.dumps(value) if isinstance(value, dict | list | tuple) else value


def endings() -> tuple[str, ...]:
    """The kinds of files that can be written here."""
    return (".csv", ".h5", ".parquet") if importlib.util.find_spec("pyarrow") else (".csv", ".h5")


def write(folder: Path, columns: Columns) -> list[Path]:
    """Write the table in every form, each whole or not at all; returns the files."""
    writers = {".csv": write_csv, ".h5": _write_hdf5, ".parquet": _write_parquet}
    paths = [folder / f"{STEM}{ending}" for ending in endings()]
    for path in paths:
        writers[path.suffix](path, columns)
    return paths


def _is_numeric(values: list[Any]) -> bool:
    return all(value is None or (isinstance(value, int | float) and not isinstance(value, bool)) for value in values)


def _write_hdf5(path: Path, columns: Columns) -> None:
    datasets = {name: Dataset(_as_dataset(values, name == "case")) for name, values in columns.items()}
    archive.write(path, archive.SWEEP_TABLE, {"missing": MISSING}, {"table": Group({}, datasets)})


def _as_dataset(values: list[Any], whole: bool) -> Array | list[str]:
    """A column of whole numbers, numbers or words: NaN or an empty text where there is no value."""
    if whole or _is_numeric(values):
        return np.array(values, dtype=np.int64 if whole else np.float64)
    return ["" if value is None else str(value) for value in values]


def _write_parquet(path: Path, columns: Columns) -> None:
    import pyarrow
    from pyarrow import parquet

    arrays = [_arrow(values, name == "case") for name, values in columns.items()]
    metadata = {"format": archive.SWEEP_TABLE, "jkr": __version__}
    with atomic(path) as temporary:
        parquet.write_table(pyarrow.Table.from_arrays(arrays, names=list(columns), metadata=metadata), temporary)


def _arrow(values: list[Any], whole: bool) -> Any:
    """A column of whole numbers, numbers or words, null where there is no value.

    From buffers: pyarrow's other constructors import pandas, which costs more than everything else here.
    """
    import pyarrow

    valid = pyarrow.py_buffer(np.packbits([value is not None for value in values], bitorder="little"))
    column = _as_dataset(values, whole)
    if isinstance(column, np.ndarray):
        kind = pyarrow.int64() if whole else pyarrow.float64()
        return pyarrow.Array.from_buffers(kind, len(values), [valid, pyarrow.py_buffer(column)])
    encoded = [word.encode() for word in column]
    ends = np.concatenate([[0], np.cumsum([len(word) for word in encoded])]).astype(np.int64)
    buffers = [valid, pyarrow.py_buffer(ends), pyarrow.py_buffer(b"".join(encoded))]
    return pyarrow.Array.from_buffers(pyarrow.large_string(), len(values), buffers)

"""Fits in HDF5: one table each of the rows, the fitted curves and the samples of all curves together, and summaries."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..base import Array, Dataset, Group, unit_column
from ..identification.fit import Failure, Fit
from . import archive
from .map import images_of, map_of

UNITS = {"a": "m", "delta": "m", "P": "N", "foot_a": "m", "row": "1", "curve": "1"}


def write(path: Path, outcomes: Sequence[Fit | Failure], summary: Mapping[str, Any]) -> None:
    """Write all fits to ``path`` with their ``summary``, in which a curve has its number from 0 in order."""
    fits = [(number, item) for number, item in enumerate(outcomes) if isinstance(item, Fit)]
    tables = {
        "data": [(number, _rows(item)) for number, item in fits],
        "fitted": [(number, dict(item.line)) for number, item in fits],
        "bootstrap": [(number, _samples(item)) for number, item in fits if item.samples is not None],
    }
    curves: dict[str, Group | Dataset] = {name: _joined(table) for name, table in tables.items() if table}
    curves["summary"] = Dataset([json.dumps(one) for one in summary["curves"]])
    images = {"map": images_of(scan)} if (scan := map_of(outcomes)) else {}
    archive.write(path, archive.FITS, {"body": summary["body"]}, {"curves": Group({}, curves), **images})


def _rows(item: Fit) -> dict[str, Array]:
    """The rows of a fit: readings, their numbers from 1, contact radii, and residuals in units of the scatter."""
    names = ["residuals"] if len(item.residuals) == 1 else [f"residuals_{name}" for name in item.scales]
    residuals = dict(zip(names, item.residuals, strict=True))
    return {**item.data, "row": item.rows + 1, "foot_a": item.a, **residuals}


def _samples(item: Fit) -> dict[str, Array]:
    assert item.samples is not None
    return dict(zip(item.free, item.samples.T, strict=True))


def _joined(tables: Sequence[tuple[int, Mapping[str, Array]]]) -> Group:
    """Tables of several curves as one, with a column of their numbers; NaN where a curve has no such column."""
    sizes = [next(iter(table.values())).size for _, table in tables]
    members = {"curve": unit_column(np.repeat([number for number, _ in tables], sizes), UNITS["curve"])}
    for name in dict.fromkeys(name for _, table in tables for name in table):
        parts = (table.get(name, np.full(size, np.nan)) for (_, table), size in zip(tables, sizes, strict=True))
        members[name] = unit_column(np.concatenate([*parts]), UNITS.get(name, "1" if "residuals" in name else "SI"))
    return Group({}, members)

"""Fits in HDF5: estimates, and for every curve its rows, foot points, residuals and fitted curve."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ... import __version__
from ...base.arrays import Array
from ...base.files import write_bytes
from ...base.hdf5 import Dataset, Group, column, image
from .fitting import Failure
from .report import FORMAT, VERSION, summary
from .result import Fit

UNITS = {"a": "m", "delta": "m", "P": "N"}


def write(path: Path, found: Sequence[Fit | Failure], body: str) -> None:
    """Write all fits to ``path``: one group per curve, numbered, its summary as JSON in an attribute."""
    told = summary(found, body)["curves"]
    curves = {
        f"{number:06d}": Group({"summary": json.dumps(words)}, _columns(item) if isinstance(item, Fit) else {})
        for number, (item, words) in enumerate(zip(found, told, strict=True))
    }
    identity = {"format": np.bytes_(FORMAT), "version": VERSION, "jkr": __version__, "body": body}
    write_bytes(path, image(Group(identity, {"curves": Group({}, curves)})))


def _columns(item: Fit) -> dict[str, Group | Dataset]:
    held: dict[str, Group | Dataset] = {
        "data": Group({}, {**_with_units(item.data), "row": column(item.rows + 1, "1")}),
        "fitted": Group({}, _with_units(item.line)),
        "foot_a": column(item.a, "m"),
        "residuals": column(item.residuals, "1"),
    }
    return held if item.samples is None else held | {"bootstrap": column(item.samples, "SI")}


def _with_units(columns: Mapping[str, Array]) -> dict[str, Dataset]:
    return {name: column(values, UNITS[name]) for name, values in columns.items()}

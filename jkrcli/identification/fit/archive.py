"""Fits in HDF5: estimates, and for every curve its rows, foot points, residuals and fitted curve."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ... import __version__
from ...base.files import hdf5
from .fitting import Failure
from .report import FORMAT, VERSION, summary
from .result import Fit

UNITS = {"a": "m", "delta": "m", "P": "N"}


def write(path: Path, found: Sequence[Fit | Failure], body: str) -> None:
    """Write all fits to ``path``: one group per curve, numbered, its summary as JSON in an attribute."""
    with hdf5(path) as file:
        file.attrs["format"], file.attrs["version"], file.attrs["jkr"] = np.bytes_(FORMAT), VERSION, __version__
        file.attrs["body"] = body
        for number, (item, told) in enumerate(zip(found, summary(found, body)["curves"], strict=True)):
            group = file.create_group(f"curves/{number:06d}")
            group.attrs["summary"] = json.dumps(told)
            if isinstance(item, Fit):
                _write(group, item)


def _write(group: Any, item: Fit) -> None:
    for name, values in item.data.items():
        _dataset(group, f"data/{name}", values, UNITS[name])
    for name, values in item.line.items():
        _dataset(group, f"fitted/{name}", values, UNITS[name])
    _dataset(group, "data/row", item.rows + 1, "1")
    _dataset(group, "foot_a", item.a, "m")
    _dataset(group, "residuals", item.residuals, "1")
    if item.samples is not None:
        _dataset(group, "bootstrap", item.samples, "SI")


def _dataset(group: Any, name: str, values: np.ndarray, unit: str) -> None:
    data = group.create_dataset(name, data=values, compression="gzip", shuffle=True)
    data.attrs["unit"] = unit

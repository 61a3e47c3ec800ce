"""The one form of all tables (CSV) and summaries (JSON) that are written."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable, Mapping
from operator import attrgetter
from pathlib import Path
from typing import Any

from .errors import printable
from .files import write_text

FORMULA = ("=", "+", "-", "@")  # how a cell begins that spreadsheets carry out


def write_csv(path: Path, columns: Mapping[str, Iterable[Any]]) -> None:
    """Write columns of one length: a line of their names, then a line per row.

    Numbers have full precision; cells without a value (None, NaN, infinite) are empty; words with commas are quoted;
    words that a spreadsheet would take for a formula are led by an apostrophe, control characters are escapes.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(_cell, columns))
    writer.writerows(zip(*(map(_cell, _plain(values)) for values in columns.values()), strict=True))
    write_text(path, text.getvalue())


def _plain(values: Any) -> Iterable[Any]:
    """The numbers of an array as Python's own, which are written alike everywhere."""
    plain: Iterable[Any] = values.tolist() if hasattr(values, "tolist") else values
    return plain


def lists(columns: Mapping[str, Iterable[Any]]) -> dict[str, list[Any]]:
    """Columns for JSON: None where a number is NaN or infinite."""
    return {name: [_finite(value) for value in _plain(values)] for name, values in columns.items()}


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _cell(value: Any) -> Any:
    if isinstance(value, str):
        return "'" * value.startswith(FORMULA) + printable(value)
    return _finite(value)


def as_json(data: Mapping[str, Any]) -> str:
    """JSON with no NaN or infinity in it, ever; a reason where a number is unknown."""
    return json.dumps(data, indent=2, allow_nan=False, default=attrgetter("reason")) + "\n"

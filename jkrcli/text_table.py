"""Tables of numbers in text, as other programs write them: separators, decimal marks, headers and units found out."""

from __future__ import annotations

import contextlib
import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .errors import InputError
from .files import read_bytes
from .series import Array
from .units import UNITS

BLANK = "blank"
SEPARATORS = {"tab": "\t", "semicolon": ";", "comma": ",", BLANK: None}
COMMENTS = ("#", "%", "//", "**", "!")
WRONG_LINES_SHOWN = 5
_NUMBER = re.compile(r"[+-]?(\d+[.]?\d*|[.]\d+)([eEdD][+-]?\d+)?\Z|[+-]?(nan|inf|infinity)\Z", re.IGNORECASE)


@dataclass(frozen=True)
class Dialect:
    """How a table is written: the ``separator`` (a key of ``SEPARATORS``), the ``decimal`` mark."""

    separator: str
    decimal: str

    def cells(self, line: str) -> list[str]:
        """The cells of a line, without surrounding blanks; a separator at the end of the line ends no empty cell."""
        mark = SEPARATORS[self.separator]
        parts = line.split(mark)
        if '"' in line and mark is not None:
            with contextlib.suppress(csv.Error):
                parts = next(csv.reader([line], delimiter=mark, skipinitialspace=True))
        cells = [cell.strip() for cell in parts]
        return cells[:-1] if len(cells) > 1 and not cells[-1] else cells

    def numbers(self, line: str) -> list[float] | None:
        """The numbers of a line, or None where one of its cells is none."""
        cells = self.cells(line)
        if self.decimal == ",":
            if any("." in cell for cell in cells):
                return None
            cells = [cell.replace(",", ".") for cell in cells]
        if not all(map(_NUMBER.match, cells)):
            return None
        return [float(re.sub("[dD]", "e", cell) if "n" not in cell.lower() else cell) for cell in cells]


@dataclass(frozen=True, eq=False)
class TextTable:
    """``values`` (rows, columns) with the ``lines`` they stand in (from 1), and the ``names`` of the columns."""

    path: Path
    names: tuple[str, ...]
    values: Array
    lines: Array
    dialect: Dialect


def read_table(path: Path, separator: str | None = None, decimal: str | None = None, least: int = 3) -> TextTable:
    """The table of at least ``least`` columns of numbers in a text file; what is None is found out.

    Raises InputError, a line per mistake, where there is no table or a row differs in its number of cells.
    """
    text = read_bytes(path, "table").decode("utf-8-sig", errors="replace")
    content = [(n, line) for n, line in enumerate(text.splitlines(), start=1) if line.strip()]
    dialect = _dialect(content, separator, decimal, least)
    rows = [] if dialect is None else list(_data(content, dialect, least))
    if dialect is None or not rows:
        raise InputError(
            f"{path}: holds no row of at least {least} numbers; "
            "give the separator and the decimal mark if they are unusual"
        )
    width = len(rows[0][1])
    first = rows[0][0]
    _check_rows(path, content, dialect, first, width)
    values = np.array([row for _, row in rows])
    header = [line for n, line in content if n < first]
    return TextTable(path, _names(header, dialect, width), values, np.array([n for n, _ in rows]), dialect)


def _dialect(content: list[tuple[int, str]], separator: str | None, decimal: str | None, least: int) -> Dialect | None:
    """Of all ways to read the lines the one that gives most rows of numbers."""
    found = [Dialect(s, d) for s in SEPARATORS for d in (".", ",") if (s, d) != ("comma", ",")]
    allowed = [d for d in found if separator in (None, d.separator) and decimal in (None, d.decimal)]
    if not allowed:
        raise InputError('separator "comma" and decimal "," exclude each other: say which one the comma is')
    counts = [(sum(1 for _ in _data(content, dialect, least)), dialect) for dialect in allowed]
    best = max(counts, key=lambda pair: pair[0])
    return best[1] if best[0] else None


def _data(content: list[tuple[int, str]], dialect: Dialect, least: int) -> Iterator[tuple[int, list[float]]]:
    """The rows of numbers, all as wide as the first."""
    width = 0
    for n, line in content:
        row = None if _is_comment(line) else dialect.numbers(line)
        if row is not None and len(row) >= least and len(row) == (width or len(row)):
            width = len(row)
            yield n, row


def _check_rows(path: Path, content: list[tuple[int, str]], dialect: Dialect, first: int, width: int) -> None:
    """Every line from the first row on is a row of numbers or a comment."""
    wrong = []
    for n, line in content:
        if n > first and not _is_comment(line):
            row = dialect.numbers(line)
            if row is None or len(row) != width:
                wrong.append(f'{path}: line {n} must hold {width} numbers, got "{line.strip()[:60]}"')
            elif not np.isfinite(row).all():
                wrong.append(f'{path}: line {n} must hold finite numbers, got "{line.strip()[:60]}"')
    if wrong:
        raise InputError(some(wrong))


def some(lines: list[str]) -> list[str]:
    """The first of many messages, and how many more there are."""
    more = len(lines) - WRONG_LINES_SHOWN
    return lines if more <= 0 else [*lines[:WRONG_LINES_SHOWN], f"... and {more} more like these"]


def _is_comment(line: str) -> bool:
    return line.lstrip().startswith(COMMENTS)


def _names(header: list[str], dialect: Dialect, width: int) -> tuple[str, ...]:
    """Column names from the last lines before the numbers, a line of units under them taken in; else empty names."""
    lines = [_header_cells(line, dialect, width) for line in header]
    titles = [cells for cells in lines if len(cells) == width]
    if not titles:
        return ("",) * width
    last = titles[-1]
    if len(titles) > 1 and all(map(_is_unit, last)):
        return tuple(f"{name} [{unit.strip('[]()')}]" for name, unit in zip(titles[-2], last, strict=True))
    return tuple(last)


def _header_cells(line: str, dialect: Dialect, width: int) -> list[str]:
    """Cells of a header line; names may contain single blanks where the columns are separated by several."""
    line = line.strip().lstrip("#%!*/ ")
    if dialect.separator != BLANK:
        return dialect.cells(line)
    wide = re.split(r"\s{2,}|\t", line)
    return wide if len(wide) == width else re.findall(r"\S+(?:\s+[\[(]\S+[\])])?", line)


def _is_unit(cell: str) -> bool:
    return cell.strip("[]()") in ("", "-", "1", "s") or unit_power(cell.strip("[]()")) is not None


def unit_power(unit: str) -> tuple[str, int] | None:
    """Dimension ("length", "area" or "load") and power of ten of a unit; None where it is neither."""
    unit = unit.strip().replace("µ", "u").replace("μ", "u").replace("²", "^2").replace("**", "^")
    for dimension in ("length", "load"):
        if unit in UNITS[dimension]:
            return dimension, UNITS[dimension][unit]
    base = re.sub(r"\^?2\Z", "", unit)
    if base != unit and base in UNITS["length"]:
        return "area", 2 * UNITS["length"][base]
    return None

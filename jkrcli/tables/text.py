"""Tables of numbers in text, as other programs write them: separators, decimal marks, headers and units detected."""

from __future__ import annotations

import codecs
import contextlib
import csv
import math
import re
from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeAlias

import numpy as np

from ..base import process
from ..base.errors import InputError, did_you_mean
from ..base.files import opened, packed, read_bytes
from ..base.numerics import AT_ONCE, LOOKED_AT, SHOWN, Array
from ..base.process import check_text
from . import BLANK, SEPARATORS, split_name, unit_power

Line: TypeAlias = tuple[int, str]  # with its number, from 1
Lines: TypeAlias = list[Line]
IsText: TypeAlias = Callable[[int, str], bool]  # whether a column, of its index (from 0) and header cell, holds words
COMMENTS = ("#", "%", "//", "**", "!")
SIGNS = "#%!*/ "  # with which a line of words, or a name in it, may begin
HEADINGS = ("columns:", "units:")  # before the names and units themselves, in comment heads
OTHER_UNITS = ("", "-", "1", "V", "mV")
SHEETS = (".xls", ".xlsx", ".ods")  # endings of spreadsheets, which are no text
MEND = ": correct it, or put # before it"
WRONG_LINES_SHOWN = 5  # of a table, one by one; the others are counted
MOST_COLUMNS = 10_000  # choice: a map of 64 x 64 curves beside each other and more; as many lines at an end of a head

_NUMBER = re.compile(r"[+-]?(\d+(?:[.]\d*)?|[.]\d+)([eEdD][+-]?\d+)?\Z|[+-]?(nan|inf|infinity)\Z", re.IGNORECASE)
_THOUSANDS = {  # by the decimal mark: a number whose digits are grouped, always by the same mark
    ".": re.compile(r"[+-]?[1-9]\d{0,2}([,'’\u00a0\u202f])\d{3}(\1\d{3})*([.]\d*)?\Z"),
    ",": re.compile(r"[+-]?[1-9]\d{0,2}([.'’\u00a0\u202f])\d{3}(\1\d{3})*(,\d*)?\Z"),
}
_GROUPED = re.compile(r"[1-9]\d{0,2},\d{3}\Z")
_THREE = re.compile(r"(?<![\w.])\d{3}(?![\w.])")  # a number like 950 may stand there
_MINUS = re.compile(r"\u2212(?=[.,]?\d)")  # the sign of a number, as typesetters and sheets write it
# Where a program wrote no number: Fortran's overflow, the errors of spreadsheets in several languages, a narrow column.
_FAILED = re.compile(r"(?:\*{2,}|#{2,}|#(?:[A-ZÀ-Ü]+(?:/\d)?[!?]|N/?[AV]\b|GETTING_DATA))\Z")
_FAILED_FIRST = re.compile(r'\s*"?(?:\*{2,}|#{2,}|#(?:[A-ZÀ-Ü]+(?:/\d)?[!?]|N/?[AV]\b|GETTING_DATA))"?\s*[\s;,]')
_NO_WORDS = re.compile(r"(?:nan|inf|[eEdD](?=[-+\d])|[^A-Za-zÀ-ÿ])*\Z", re.IGNORECASE)
_LETTER = re.compile(r"[^\W\d]")
_NUMBERS = re.compile(r"\d{1,9}")
_DIGIT = re.compile(r"\d")
# A time of day, a date and what letters follow on digits ("3rd", "2a") are none of the numbers of a table
_WORD = re.compile(r"[^\W\d]|\d{1,2}:\d\d(?!\d)|\d{1,4}([-/.])\d{1,2}\1\d{1,4}(?!\d|\1)|\d+[^\W\d]")
_ROW = re.compile(r"""\s*["']?[+-]?[.,]?\d""")  # a line that begins with a number

# How much of a file shows how it is written.
TEXT_GAPS = 0.1  # choice: of the rows, that may lack a number
TEXT_BLOCK = 10  # choice: rows without an empty line, behind which one row alone is none of them
# theory: the numbers that loggers write where they read nothing, -999, -9999, ..., or positive ones
NINES = np.array([sign * (10.0**digits - 1) for digits in range(3, 10) for sign in (-1, 1)])
NINES_ROWS = 8  # choice: other numbers of a column, of fewer none is far off


@dataclass(frozen=True)
class Dialect:
    """The way a table is written: the ``separator`` (a key of ``SEPARATORS``), the ``decimal`` mark, which columns
    (from 0) hold ``text``: their cells count as the number 0, and whether the digits before the decimal mark are
    grouped in ``thousands``; ``least``: numbers of a row."""

    separator: str
    decimal: str
    text: frozenset[int] = frozenset()
    thousands: bool = False
    least: int = 3

    def cells(self, line: str) -> list[str]:
        """The cells of a line, without surrounding blanks; a separator at the end of the line ends no empty cell."""
        mark = SEPARATORS[self.separator]
        parts = line.split(mark)
        if '"' in line and mark is not None:
            with contextlib.suppress(csv.Error):
                parts = next(csv.reader([line], delimiter=mark, skipinitialspace=True))
        cells = [cell.strip() for cell in parts]
        return cells[:-1] if len(cells) > 1 and not cells[-1] else cells

    def ends(self, line: str) -> bool:
        """Whether a line ends in the separator: its last cell may be empty."""
        mark = SEPARATORS[self.separator]
        return mark is not None and line.rstrip(" \r\n").endswith(mark)

    def divides(self, line: str) -> bool:
        """Whether the separator stands in a line, or a number may stand alone; quick, for the many lines of which
        another one is right."""
        mark = SEPARATORS[self.separator]
        return mark in line if mark is not None else len(line.split(None, 1)) >= min(self.least, 2)

    def numbers(self, line: str, width: int = 0, gaps: bool = False) -> list[float] | None:
        """The numbers of a line, or None where one of its cells is none; nan for an empty cell.

        ``width``: of the table, where it is known: a line that ends in empty cells has as many. ``gaps``: nan also for
        a cell without a digit, "n.a." or "overload", in a line that begins with a number.
        """
        cells = self.cells(line)
        if self.ends(line) and (len(cells) == width - 1 or len(cells) in self.text):
            cells = [*cells, ""]
        if self.text:
            cells = ["0" if i in self.text else cell for i, cell in enumerate(cells)]
        if len(cells) > 1 and "" in cells and any(cells):
            cells = [cell or "nan" for cell in cells]
        if gaps:
            cells = ["nan" if _FAILED.match(cell) else cell for cell in cells]
        if gaps and (0 in self.text or cells[0] == "nan" or _DIGIT.match(cells[0].lstrip("+-.,"))):
            cells = [cell if _DIGIT.search(cell) or _NUMBER.match(cell) else "nan" for cell in cells]
        if self.thousands:
            matches = [(cell, _THOUSANDS[self.decimal].match(cell)) for cell in cells]
            cells = [cell.replace(match[1], "") if match else cell for cell, match in matches]
        if self.decimal == ",":
            if any("." in cell for cell in cells):
                return None
            cells = [cell.replace(",", ".") for cell in cells]
        if not all(map(_NUMBER.match, cells)):
            return None
        return [float(re.sub("[dD]", "e", cell) if "n" not in cell.lower() else cell) for cell in cells]


@dataclass(frozen=True, eq=False)
class TextTable:
    """A table as read: ``values`` (rows, columns), the ``lines`` they stand in (from 1), ``names`` of the columns.

    ``text``: the cells of the columns (from 0) that hold words; ``head``: the lines before the numbers; ``notes``: the
    comments between them, by their lines; ``remarks``: the lines of words behind the last row. ``failed``: the lines
    with a cell of Fortran's overflow or an error of a sheet. ``contradicted``: by columns, what a row of units says
    against the names above it. ``missing``: by columns, the number that stands for none; ``alone``: the first or last
    row where an empty line parts it from all others, by its line, left out.
    """

    path: Path
    names: tuple[str, ...]
    values: Array
    lines: Array
    dialect: Dialect
    text: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
    head: tuple[str, ...] = ()
    notes: Mapping[int, str] = field(default_factory=dict)
    remarks: Mapping[int, str] = field(default_factory=dict)
    failed: frozenset[int] = frozenset()
    contradicted: Mapping[int, str] = field(default_factory=dict)
    missing: Mapping[int, float] = field(default_factory=dict)
    alone: Mapping[int, str] = field(default_factory=dict)

    def refuse_contradicted(self, index: int) -> None:
        """InputError where the row of units says otherwise than the name of a column."""
        if unit := self.contradicted.get(index):
            raise InputError(
                f"{self.path}: {self.titled(index)} names one unit and the row of units below another, {unit}: correct "
                "one of them, or give the right one by --unit"
            )

    def rows(self, chosen: Array) -> TextTable:
        """The table at ``chosen`` rows alone (a mask or numbers)."""
        text = {i: tuple(np.array(cells)[chosen].tolist()) for i, cells in self.text.items()}
        return replace(self, values=self.values[chosen], lines=self.lines[chosen], text=text)

    def titled(self, index: int) -> str:
        """A column by number and name, for messages."""
        return f'column {index + 1} "{self.names[index]}"'

    @property
    def choice(self) -> str:
        """The columns by number and name, for messages."""
        listed = [f'{i} "{name}"' if name else str(i) for i, name in enumerate(self.names[:SHOWN], start=1)]
        more = len(self.names) - len(listed)
        return f"columns: {', '.join(listed)}" + (f" and {more:,} more" if more else "")

    def listed(self, chosen: Mapping[str, int]) -> str:
        """The ``chosen`` columns by their keys, for messages and records."""
        titles = {key: f"column {i + 1}" + f' "{self.names[i]}"' * bool(self.names[i]) for key, i in chosen.items()}
        return ", ".join(f"{key} = {title}" for key, title in sorted(titles.items()))

    @property
    def left_out(self) -> list[str]:
        """Sentences on the lines of words behind the last row, on rows that stand alone, and on numbers that stand for
        none."""
        told = [f'line {n} stands alone beside an empty line and is left out: "{line.strip()[:60]}"'
                for n, line in self.alone.items()]  # fmt: skip
        told += [f"{self.titled(i)}: {number:g} stands for no number" for i, number in self.missing.items()]
        if not self.remarks:
            return told
        first, last = min(self.remarks), max(self.remarks)
        where = f"line {first} is" if first == last else f"lines {first} to {last} are"
        return [*told, f'{where} behind the last row and left out: "{self.remarks[first].strip()[:60]}"']

    def called(self, name: str, option: str) -> int:
        """The column that the user named or numbered (from 1) by an ``option``."""
        titles = [split_name(title)[0] for title in self.names]
        matches = [i for i, title in enumerate(self.names) if name in (title, titles[i])]
        if len(matches) == 1:
            return matches[0]
        if name.isdigit() and 1 <= int(name) <= len(self.names):
            return int(name) - 1
        hint = did_you_mean(name, titles)
        raise InputError(f'{self.path}: no single column "{name}" for {option}{hint} ({self.choice})')

    def numbers(self, index: int) -> Array:
        """The numbers of a column; InputError where it holds words."""
        if index in self.text:
            rows = zip(self.lines, self.text[index], strict=True)
            line, word = next(((line, word) for line, word in rows if word), (self.lines[0], ""))
            where = f"{self.path}: {self.titled(index)}"
            raise InputError(f'{where} holds text, not numbers: line {line} has "{word[:60]}"')
        return self.values[:, index]


def decoded(content: bytes) -> str:
    """The text in ``content``: UTF-8 or UTF-16, with a mark or without one, else Windows-1252, else Latin-1."""
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return content.decode("utf-16", errors="replace")
    both = ((1, "utf-16-le"), (0, "utf-16-be")) if b"\0" in content else ()
    for first, name in both:  # of most letters one byte is zero, always the same
        if content[first::2].count(0) > len(content) / 4 > 4 * content[1 - first :: 2].count(0):
            return content.decode(name, errors="replace")
    for name in ("utf-8-sig", "cp1252"):
        with contextlib.suppress(UnicodeDecodeError):
            return content.decode(name)
    return content.decode("latin-1")


def read_table(
    path: Path,
    separator: str | None = None,
    decimal: str | None = None,
    least: int = 3,
    is_text: IsText = lambda index, title: False,
    finite: bool = True,
    content: bytes | None = None,
    is_note: Callable[[str], bool] = lambda line: False,
) -> TextTable:
    """The table of at least ``least`` columns of numbers in a text file; what is None is detected.

    ``content``: the bytes of the file, where it lies in another one.

    ``is_text``: whether a column, of its index (from 0) and header cell, holds words, not numbers. ``finite``: refuse
    rows with nan or inf; else a cell that holds a word alone is nan. ``is_note``: whether a line of words between the
    rows is one of the notes, as comments are; the header may come again behind it.
    Raises InputError, a line per mistake, where there is no table or a row differs in its number of cells.
    """
    whole = decoded(read_bytes(path, "table", process.TEXT) if content is None else content)
    check_text(path, whole)
    # The lines without the midst of very many comments before the first other line
    lines_of_file = _lines(path, _MINUS.sub("-", whole))
    comments = next((i for i, (_, line) in enumerate(lines_of_file) if not _is_comment(line)), len(lines_of_file))
    if comments > 2 * MOST_COLUMNS:
        lines_of_file = lines_of_file[:MOST_COLUMNS] + lines_of_file[comments - MOST_COLUMNS :]
    # The first or the last line that begins with a number, where an empty line parts it from a block of others
    # without any between them: a number of rows above, a mean below
    rows = [(n, line) for n, line in lines_of_file if _ROW.match(line)]
    numbers, known = np.array([n for n, _ in rows]), {n for n, _ in lines_of_file}
    alone = {}
    for place, away, block in ((0, 1, numbers[1:]), (-1, -1, numbers[:-1])):
        if block.size >= TEXT_BLOCK and (np.diff(block) == 1).all() and rows[place][0] + away not in known:
            alone[rows[place][0]] = rows[place][1]
    others = [item for item in lines_of_file if item[0] not in alone] if alone else lines_of_file
    dialect, sample = _dialect(path, others, separator, decimal, least, is_text)
    lines, values = _rows(others, dialect, gaps=not finite)
    if decimal is None:
        _refuse_doubtful(path, [(n, line) for n, line in sample if n >= lines[0]], dialect)
    # By columns, a number of nines that stands for none: farther from all others than these are apart
    missing, gone = dict[int, float](), np.zeros(values.shape, dtype=bool)
    for i in [] if finite else np.flatnonzero(np.isin(values, NINES).any(axis=0)).tolist():
        column = values[np.isfinite(values[:, i]), i]
        for number in NINES[np.isin(NINES, column)].tolist():
            rest = column[column != number]
            if rest.size >= NINES_ROWS and np.min(np.abs(rest - number)) > np.ptp(rest):
                missing[i], gone[:, i] = number, values[:, i] == number
    values = np.where(gone, np.nan, values)
    table = _table(path, others, dialect, lines, values, finite, is_note)
    failed = table.failed | set(lines[gone.any(axis=1)].tolist())
    return replace(table, failed=failed, missing=missing, alone=alone)


def _table(
    path: Path,
    content: Lines,
    dialect: Dialect,
    lines: Array,
    values: Array,
    finite: bool,
    is_note: Callable[[str], bool],
) -> TextTable:
    """The table of the ``lines`` that hold ``values``, and what stands before, between and behind them."""
    dialect = replace(dialect, text=frozenset(i for i in dialect.text if i < values.shape[1]))
    body = _from(content, int(lines[0]))
    header = [line for _, line in content[: len(content) - len(body)]]
    notes, remarks, more = dict[int, str](), dict[int, str](), len(body) > lines.size
    rows = set(lines.tolist() if more or finite or dialect.text else ())
    if more:
        # Comments and notes behind the first of the rows, and lines of the header that come again behind a note
        again, known = False, set(header)
        for n, line in body:
            again = n not in rows and (is_note(line) or (again and line in known))
            if again or (n not in rows and _is_comment(line)):
                notes[n] = line
        notes |= _interval_heads(header, [(n, line) for n, line in body if n not in notes], rows, dialect)
        # Lines behind the `last` row, all of which begin with a word, as no row does, and none of the header's.
        last = int(lines[-1])
        behind = {n: line for n, line in body if n > last and not _is_comment(line) and any(dialect.cells(line))}
        begins = [dialect.cells(line)[0] for line in behind.values()]
        words = 0 not in dialect.text and all(_LETTER.match(cell) and not _NUMBER.match(cell) for cell in begins)
        remarks = behind if words and not any(line in header for line in behind.values()) else {}
    if more or finite:
        rest = [item for item in body if item[0] not in notes and item[0] not in remarks]
        bad = set(lines[~np.isfinite(values).all(axis=1)].tolist()) if finite else set()
        _check_rows(path, rest, dialect, values.shape[1], rows - bad, bad)
    names, contradicted = _names(header, dialect, values.shape[1], dialect.ends(body[0][1]))
    missing = set(lines[np.isnan(values).any(axis=1)].tolist())
    failed = {n for n, line in body if n in missing and any(map(_FAILED.match, dialect.cells(line)))}
    cells = [dialect.cells(line) for n, line in body if n in rows] if dialect.text else []
    text = {i: tuple(row[i] if i < len(row) else "" for row in cells) for i in dialect.text}  # "" at the end of a line
    more_of = frozenset(failed), contradicted
    return TextTable(path, names, values, lines, dialect, text, tuple(header), notes, remarks, *more_of)


def _interval_heads(header: list[str], body: Lines, rows: set[int], dialect: Dialect) -> dict[int, str]:
    """The lines of words between the rows that are the head of a further interval, as rheometers write it before each
    of a test: all lines of the ``header`` but for their numbers, and the first number of one of them, 1 there, counts
    the intervals. Curves one behind the other have no such number."""
    first = {_NUMBERS.sub("0", line): _NUMBERS.search(line) for line in header}
    heads, interval, run = dict[int, str](), 1, list[Line]()
    for n, line in body:
        if n not in rows:
            run += [(n, line)] if any(dialect.cells(line)) else []
            continue
        if run:
            interval += 1
            shapes = [(_NUMBERS.sub("0", words), _NUMBERS.search(words)) for _, words in run]
            counts = (
                own is not None and at is not None and (int(own[0]), int(at[0])) == (1, interval)
                for own, at in ((first.get(shape), at) for shape, at in shapes)
            )
            if not all(shape in first for shape, _ in shapes) or not any(counts):
                return {}
            heads.update(run)
            run = []
    return heads


def _from(content: Lines, first: int) -> Lines:
    """The lines from the one numbered ``first`` on."""
    return content[bisect_left(content, (first, "")) :]


def _lines(path: Path, text: str) -> Lines:
    """The lines that are not empty; InputError where a row holds more cells than any table has."""
    lines = text.splitlines()
    if max(map(len, lines), default=0) > MOST_COLUMNS:  # few cells stand in shorter ones
        for i, line in enumerate(lines):
            if len(line) > MOST_COLUMNS and _ROW.match(line):
                marks = max(line.count(mark) for mark in SEPARATORS.values() if mark is not None)
                if marks > MOST_COLUMNS or len(line.split(None, MOST_COLUMNS)) > MOST_COLUMNS:
                    raise InputError(
                        f"{path}: line {i + 1} holds more than {MOST_COLUMNS:,} cells, the most that are read"
                    )
            elif len(line) > AT_ONCE:
                lines[i] = ""  # words that name no columns
    return [(n, line) for n, line in enumerate(lines, start=1) if line and not line.isspace()]


def _refuse_doubtful(path: Path, content: Lines, dialect: Dialect) -> None:
    """Refuse columns that hold both 950 and 1,000, never 1,02: the mark groups thousands, or three decimals follow."""
    if not _THREE.search("\n".join(line for _, line in content)):
        return
    mark = dialect.decimal
    rows = [] if dialect.thousands else [(n, dialect.cells(line)) for n, line in content if not _is_comment(line)]
    for i in range(max((len(cells) for _, cells in rows), default=0)):
        column = [(n, cells[i].lstrip("+-")) for n, cells in rows if len(cells) > i]
        marked = [(n, cell) for n, cell in column if mark in cell]
        whole = [cell for _, cell in column if mark not in cell]
        if marked and any(len(cell) == 3 and cell.isdigit() for cell in whole) and all(
            _GROUPED.match(cell.replace(mark, ",")) for _, cell in marked
        ):  # fmt: skip
            n, cell = marked[0]
            raise InputError(
                f'{path}: line {n}: "{cell}" stands beside "{next(c for c in whole if len(c) == 3)}": say by --decimal '
                f"whether {mark} is the decimal mark, or the other one is and {mark} groups thousands"
            )


def _rows(content: Lines, dialect: Dialect, gaps: bool) -> tuple[Array, Array]:
    """Lines and values of all rows of numbers; ``gaps``: a few with words in place of some too, behind the first."""
    body, values = _begun(content, dialect)
    if values is not None:
        return np.array([n for n, _ in body]), values
    rows = list(_data(body, dialect))
    if gaps:
        more, whole = list(_data(body, dialect, gaps=True)), {n for n, _ in rows}
        text = dict(body)
        other = sum(n not in whole and not any(map(_FAILED.match, dialect.cells(text[n]))) for n, _ in more)
        rows = more if other <= TEXT_GAPS * len(more) else rows
    return np.array([n for n, _ in rows]), np.array([row for _, row in rows])


def _begun(content: Lines, dialect: Dialect) -> tuple[Lines, Array | None]:
    """The lines from the first row of numbers on, and their values where numpy reads them."""
    marked = dialect.decimal == "," and not (dialect.text or dialect.thousands)
    likely = (item for item in content if not (marked and "." in item[1]))
    for first, row in _data(likely, dialect):
        body = _from(content, first)
        return body, _regular(body, dialect, len(row))
    return [], None


def _regular(body: Lines, dialect: Dialect, width: int) -> Array | None:
    """The values by numpy's reader, ten times as fast; None where any line needs a closer look."""
    mark, lines = SEPARATORS[dialect.separator], [line for _, line in body]
    other = "." if dialect.decimal == "," else '"'  # beside a decimal comma a point is no part of a number
    whole = "\n".join(lines)
    if dialect.thousands or '"' in whole or other in whole:
        return None
    if dialect.text and any(len(line.split(mark)) != width for line in lines):
        return None
    numbers = [i for i in range(width) if i not in dialect.text]
    values = np.zeros((len(body), width))
    try:
        parsed = np.loadtxt(
            whole.replace(dialect.decimal, ".").split("\n") if dialect.decimal != "." else lines,
            delimiter=mark, comments=None, usecols=numbers if dialect.text else None, ndmin=2,
        )  # fmt: skip
    except ValueError:
        return None
    if parsed.shape[1] != len(numbers):
        return None
    values[:, numbers] = parsed
    return values


def _with_text(content: Lines, dialect: Dialect, is_text: IsText) -> Dialect:
    """The dialect with the columns of text, by the first line that names one: before any row of numbers."""
    for _, line in content:
        if not dialect.divides(line):
            continue
        cells = _header_cells(line, dialect, 0)
        if _is_comment(line) and cells and cells[0].endswith(":"):  # "# segment: extend" is no header
            cells = cells[1:] if cells[0].lower() in HEADINGS else []
        if len(cells) < dialect.least:
            continue
        if of_words := {i for i, cell in enumerate(cells) if is_text(i, cell)}:
            return replace(dialect, text=frozenset(of_words))
        if all(_NUMBER.match(cell.replace(",", ".")) for cell in cells[: dialect.least]):
            break
    return dialect


def _dialect(
    path: Path, content: Lines, separator: str | None, decimal: str | None, least: int, is_text: IsText
) -> tuple[Dialect, Lines]:
    """The way to read the lines that gives most rows of numbers, by a sample of them, and that."""
    dialects = [Dialect(s, d, least=least) for s in SEPARATORS for d in (".", ",") if (s, d) != ("comma", ",")]
    allowed = [d for d in dialects if separator in (None, d.separator) and decimal in (None, d.decimal)]
    if not allowed:
        raise InputError('separator "comma" and decimal "," exclude each other: say which one the comma is')
    head, rest = content[:LOOKED_AT], content[LOOKED_AT:]
    sample = head + rest[:: max(1, 2 * len(rest) // LOOKED_AT)]
    for lines in (sample, content) if len(content) > len(sample) else (sample,):
        if (dialect := _best(lines, allowed, is_text)) is not None:
            return dialect, sample
    sheet = path.suffix.lower() in SHEETS
    remedy = "save the sheet as CSV" if sheet else "give --separator and --decimal if they are unusual"
    if not any(line.strip() for _, line in content):
        raise InputError(f"{path}: is empty")
    raise InputError(f"{path}: holds no row of at least {least} numbers; {remedy}")


def _best(content: Lines, dialects: list[Dialect], is_text: IsText) -> Dialect | None:
    """The one of the ``dialects``, with columns of words, that gives most rows of numbers; None where none does."""
    whole = "\n".join(line for _, line in content)
    allowed = [d for d in dialects if (SEPARATORS[d.separator] or "") in whole]
    if not allowed:
        return None
    plain = [_with_text(content, dialect, is_text) for dialect in allowed]
    best, unread = _most_rows(content, plain)
    if unread:  # columns of words that nobody names, and grouped digits, are tried only where others leave lines over
        wordy = plain + [_with_words(content, dialect) for dialect in allowed]
        best, unread = _most_rows(content, wordy)
    if unread:
        best, _ = _most_rows(content, [*wordy, *(replace(dialect, thousands=True) for dialect in wordy)])
    return best


def _most_rows(content: Lines, dialects: list[Dialect]) -> tuple[Dialect | None, bool]:
    """The dialect that gives most rows of numbers, None where none gives any; whether it leaves lines behind its first
    row unread."""
    rows = []
    for dialect in dialects:  # all lines behind the first row of numbers where numpy reads them
        body, values = _begun(content, dialect)
        regular = values is not None and np.isfinite(values).all()
        rows.append([n for n, _ in (body if regular else _data(body, dialect))])
    sizes = [len(lines) for lines in rows]
    most = sizes.index(max(sizes))
    if not sizes[most]:
        return None, True
    behind = _from(content, rows[most][0])
    later = len(behind) if len(behind) == sizes[most] else sum(not _is_comment(line) for _, line in behind)
    return dialects[most], later > sizes[most]


def _with_words(content: Lines, dialect: Dialect) -> Dialect:
    """The dialect with those columns as text that hold words, or nothing, in all rows of the later half and a number in
    none, beside enough columns of others."""
    rows = [
        dialect.cells(line) + [""] * dialect.ends(line)
        for _, line in content
        if not _is_comment(line) and dialect.divides(line)
    ]
    widths = [len(cells) for cells in rows if len(cells) > dialect.least]
    width = max(widths, key=widths.count, default=0)
    whole = [cells for cells in rows if len(cells) == width]
    columns = [[cells[i] for cells in whole[len(whole) // 2 :]] for i in range(width)]
    of_words = [i for i, column in enumerate(columns) if any(column)
             and all(not cell or _WORD.match(cell) for cell in column)
             and not any(_NUMBER.match(cells[i].replace(",", ".")) for cells in whole)]  # fmt: skip
    return replace(dialect, text=frozenset(of_words if width - len(of_words) >= dialect.least else ()))


def _data(content: Iterable[Line], dialect: Dialect, gaps: bool = False) -> Iterator[tuple[int, list[float]]]:
    """The rows of enough numbers, all as wide as the first; ``gaps``: behind it also those of fewer."""
    width = 0
    for n, line in content:
        wide = gaps and width > 0
        row = dialect.numbers(line, width, wide) if dialect.divides(line) and not _is_comment(line) else None
        fits = row is not None and len(row) == (width or len(row))
        if wide and row is not None and all(map(math.isnan, row)):  # of units, above a further interval?
            fits = fits and not (_LETTER.search(line) and all(map(_is_unit, dialect.cells(line))))
        if row is not None and fits and (wide or len(row) - sum(map(math.isnan, row)) >= dialect.least):
            width = len(row)
            yield n, row


def _check_rows(path: Path, content: Lines, dialect: Dialect, width: int, good: set[int], bad: set[int]) -> None:
    """Refuse ``bad`` rows, whose numbers are not finite, and lines that are neither ``good`` rows nor comments."""
    numbers = f"{width - len(dialect.text)} numbers" + f" and {len(dialect.text)} words" * bool(dialect.text)
    wrong = []
    for n, line in content:
        if n in bad:
            wrong.append(f'{path}: line {n} must hold finite numbers, got "{line.strip()[:60]}"{MEND}')
        elif n not in good and not _is_comment(line) and any(dialect.cells(line)):
            alone = _LETTER.match(line.strip()) and not dialect.divides(line.strip())
            remedy = ": remove it, or put # before it" if alone else MEND
            wrong.append(f'{path}: line {n} must hold {numbers}, got "{line.strip()[:60]}"{remedy}')
    if wrong:
        raise InputError(some(wrong))


def some(lines: list[str]) -> list[str]:
    """The first of many messages, and how many more there are."""
    more = len(lines) - WRONG_LINES_SHOWN
    return lines if more <= 0 else [*lines[:WRONG_LINES_SHOWN], f"... and {more} more like these"]


def _is_comment(line: str) -> bool:
    """Whether a line is one of words: a row may begin with Fortran's overflow or an error of a sheet."""
    if not line.lstrip().startswith(COMMENTS):
        return False
    if not (match := _FAILED_FIRST.match(line)):
        return True
    rest = re.split(r"[\s;,]+", line[match.end() :].strip())
    return not (any(map(_DIGIT.search, rest)) and all(_FAILED.match(cell) or _NO_WORDS.match(cell) for cell in rest))


def _names(header: list[str], dialect: Dialect, width: int, more: bool) -> tuple[tuple[str, ...], dict[int, str]]:
    """Column names from the last lines before the numbers, a line of units under them taken in, else empty names; the
    units by column that contradict those in the names.

    ``more``: whether the rows end in a separator, behind which the header may name a column that holds nothing.
    """
    lines = [(cells := _header_cells(line, dialect, width)) + [""] * (len(cells) == width - 1 and dialect.ends(line))
             for line in header]  # fmt: skip
    if more and not any(len(cells) == width for cells in lines):
        lines = [cells[:width] if len(cells) == width + 1 else cells for cells in lines]
    of_heads = (line.lstrip(SIGNS).partition(":") for line in header)
    headed = {f"{word.lower()}:": _header_cells(rest, dialect, width) for word, _, rest in of_heads}
    columns, units = (cells if len(cells := headed.get(key, [])) == width else [] for key in HEADINGS)
    titles = [cells for line, cells in zip(header, lines, strict=True) if len(cells) == width and any(cells)
              and not (columns and _is_comment(line)) and not cells[0].lower().startswith(HEADINGS)]  # fmt: skip
    units = units or [split_name(name)[1] for name in columns if titles]
    if not (titles := titles or [columns] * bool(columns)):
        return ("",) * width, {}
    if any(units) and not all(map(_is_unit, titles[-1])):
        titles.append(units)
    last = titles[-1]
    if len(titles) > 1 and all(map(_is_unit, last)):
        units = [unit.strip("[]()") for unit in last]
        named = [split_name(name)[1] for name in titles[-2]]
        against = {
            i: f'"{unit}"' for i, (own, unit) in enumerate(zip(named, units, strict=True))
            if own and unit not in ("", "-") and (unit_power(own) or own) != (unit_power(unit) or unit)
        }  # fmt: skip
        parts = zip(titles[-2], units, named, strict=True)
        return tuple(f"{name} [{unit}]" if unit and not own else name for name, unit, own in parts), against
    return tuple(last), {}


def _header_cells(line: str, dialect: Dialect, width: int) -> list[str]:
    """Cells of a header line, without the comment sign that each may begin with; names may contain single blanks where
    the columns are separated by several, and blanks may part them where the numbers are parted otherwise."""
    line = line.strip().lstrip(SIGNS)
    cells = [line] if dialect.separator == BLANK else dialect.cells(line)
    if dialect.separator == BLANK or (len(cells) == 1 < width):
        wide = re.split(r"\s{2,}|\t", line)
        words = wide if len(wide) == width else re.findall(r"\S+(?:\s+[\[(]\S+[\])])?", line)
        cells = words if dialect.separator == BLANK or len(words) == width else cells
    return [cell.lstrip(SIGNS) if len(cell) > 1 else cell for cell in cells]


def _is_unit(cell: str) -> bool:
    return cell.strip("[]()") in OTHER_UNITS or unit_power(cell.strip("[]()")) is not None


# --------------------------------------------------------------------------------------------------
# How many rows files hold, estimated from their sizes and first lines before they are read.

PIECE = 1 << 16  # choice: bytes read at a time, and of a table to estimate the length of its rows
# Bytes of a row from which on it costs by its length; tuned on tables of 12 to 1000 columns, by `make guards`
BYTES_WIDE = 160.0
BYTES_USUAL = 40.0  # choice: bytes of a row of files without lines, those of microscopes


def rows_of_text(path: Path) -> float:
    """About how many rows the text at ``path``, packed or not, holds, more of wide ones, which take as long.

    0 where it cannot be read, which its reader says, and of pipes, which would be waited for.
    """
    try:
        if not path.is_file():
            return 0.0
        if packed(path):
            with path.open("rb") as file:
                file.seek(-4, 2)
                size = int.from_bytes(file.read(4), "little")  # RFC 1952: of what it unpacks to
            with opened(path, "table") as file:
                return rows_among(size, file.read(PIECE))
        with path.open("rb") as file:
            return rows_among(path.stat().st_size, file.read(PIECE))
    except (InputError, OSError, ValueError):
        return 0.0


def rows_among(size: int, first: bytes) -> float:
    """About how many rows stand in so many bytes, by those that come ``first``."""
    rows = first.count(b"\n") / max(len(first), 1)  # per byte
    return size * (max(rows, 1 / BYTES_WIDE) if rows else 1 / BYTES_USUAL)

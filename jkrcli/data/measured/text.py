"""Measured curves in text tables: columns by name or number, words for segments, several curves in one file."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from ...base.arrays import Array
from ...base.errors import InputError
from ..columns import CONTACT, Quantity, Vocabulary, asked, check_chosen, choice, split_name, words
from ..text_table import TextTable, read_table
from .curve import APPROACH, LEAST_ROWS, QUANTITIES, RETRACT, Curve, Reading, place

NAMES = Vocabulary(CONTACT | {
    "delta": CONTACT["delta"].also("indentation depth"),
    "P": CONTACT["P"].also("normal force"),
    "t": Quantity("time", "time", ("t", "time")),
    "segment": Quantity("segment", "", ("segment", "phase", "direction")),
    "curve": Quantity("curve", "", ("curve", "curve number", "curve_number")),
})  # fmt: skip
SEGMENTS = {
    **dict.fromkeys(("approach", "loading", "load", "extend", "advance", "advancing", "trace", "0"), APPROACH),
    **dict.fromkeys(("retract", "retraction", "unloading", "unload", "withdraw", "receding", "retrace", "1"), RETRACT),
}


def curves(path: Path, reading: Reading) -> Iterator[tuple[Curve | InputError, float | None]]:
    """The curves in the table at ``path`` with the stiffness of their device [N/m]; one that cannot be used comes as
    its error, the others follow.

    Raises InputError where the table as a whole cannot be read.
    """
    table = read_table(path, reading.separator, reading.decimal, 2, _is_text(reading), finite=False)
    chosen = _columns(table, reading)
    values = {key: NAMES.in_si(table, key, i, _unit(table, key, i, reading))
              for key, i in chosen.items() if key in NAMES.numbers}  # fmt: skip
    segments = np.array([SEGMENTS.get(word.lower(), word) for word in table.text[chosen["segment"]]]) \
        if "segment" in chosen else None  # fmt: skip
    for name, rows in _groups(table, chosen):
        part = {key: column[rows] for key, column in values.items()}
        yield _curve(table, name, rows, part, None if segments is None else segments[rows]), reading.stiffness


def _curve(
    table: TextTable, name: str, rows: Array, values: dict[str, Array], segment: Array | None
) -> Curve | InputError:
    try:
        _check(table, name, table.lines[rows], values)
        if "area" in values:
            values["a"] = np.sqrt(values.pop("area") / np.pi)
        a, delta, P, t = (values.get(quantity) for quantity in QUANTITIES)
        return Curve(name, a, delta, P, t, segment, table.path)
    except InputError as error:
        return error


def _is_text(reading: Reading) -> Callable[[int, str], bool]:
    """A function that tells whether a column holds words: by its name, or as told."""
    of_words = NAMES.quantities.keys() - set(NAMES.numbers)
    told = {name for key, name in reading.columns.items() if key in of_words}

    def is_text(index: int, title: str) -> bool:
        return NAMES.key_of(title) in of_words or bool({title, split_name(title)[0], str(index + 1)} & told)

    return is_text


def _columns(table: TextTable, reading: Reading) -> dict[str, int]:
    """Index of the column of every quantity that is there: as told, else by its name."""
    chosen = {key: asked(table, key, name) for key, name in reading.columns.items()}
    for key in NAMES.quantities:
        if key not in chosen and NAMES.named(table, key) and not (key == "area" and "a" in chosen):
            chosen[key] = NAMES.guess(table, key)
    check_chosen(table, chosen)
    if len(chosen.keys() & {"a", "area", "delta", "P"}) < 2:
        found = words(table, chosen) or "none"
        raise InputError(
            f"{table.path}: at least two of contact radius (or area), displacement and load are needed, recognised: "
            f"{found}; say which columns they are, --column P=NAME ({choice(table)})"
        )
    for key in reading.units:
        if key not in chosen:
            raise InputError(f"{table.path}: --unit {key}={reading.units[key]} has no column to belong to: give "
                             f"--column {key}=NAME ({choice(table)})")  # fmt: skip
    return chosen


def _unit(table: TextTable, key: str, index: int, reading: Reading) -> str | None:
    """The unit that the user told; refused where the header names another one."""
    told, held = reading.units.get(key), split_name(table.names[index])[1]
    if told and held and told != held:
        raise InputError(f'{table.path}: column {index + 1} "{table.names[index]}" names its unit: '
                         f"leave out --unit {key}={told}")  # fmt: skip
    return told


def _groups(table: TextTable, chosen: dict[str, int]) -> Iterator[tuple[str, Array]]:
    """Name and rows of each curve, in the order of the file."""
    if "curve" not in chosen:
        yield table.path.stem, np.arange(table.lines.size)
        return
    names, inverse = np.unique(table.text[chosen["curve"]], return_inverse=True)
    order = np.argsort(inverse, kind="stable")
    groups = np.split(order, np.cumsum(np.bincount(inverse))[:-1])
    for rows in sorted(groups, key=lambda rows: int(rows[0])):
        yield str(names[inverse[rows[0]]]), rows


def _check(table: TextTable, name: str, lines: Array, values: dict[str, Array]) -> None:
    """Refuse too few rows, numbers that are not finite, negative areas and radii, time that runs back."""
    where = place(table.path, name)
    if lines.size < LEAST_ROWS:
        there = ", ".join(map(str, lines))
        raise InputError(f"{where}: holds {lines.size} rows (lines {there}), at least {LEAST_ROWS} are needed")
    for key, column in values.items():
        size = key in ("a", "area")
        wrong = ~np.isfinite(column) | ((column < 0) if size else False)
        if wrong.any():
            i = int(np.argmax(wrong))
            rule = "finite and >= 0" if size else "finite"
            raise InputError(f"{where}: line {lines[i]}: {NAMES.meaning(key)} must be {rule}, got {column[i]:g} (SI)")
    back = np.diff(values.get("t", np.zeros(1))) < 0
    if back.any():
        i = int(np.argmax(back)) + 1
        remedy = (
            "; several curves in one file need their column: --column curve=NAME" if name == table.path.stem else ""
        )
        raise InputError(f"{where}: line {lines[i]}: time must not run back, it falls from {values['t'][i - 1]:g} to "
                         f"{values['t'][i]:g} s{remedy}")  # fmt: skip

"""Quantities of the columns of a text table and their units, by the names in its header or as the user says."""

import re
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ..base.arguments import read, reader
from ..base.errors import InputError
from ..base.numerics import Array
from ..base.process import REMEMBERED
from ..base.units import LARGEST_FACTOR, LARGEST_SI
from ..tables import WORDS, quantities, split_name, unit_power
from ..tables.text import TextTable

NO_UNIT = " left out: it ends in no unit of "  # in a sentence on a column
CONTACT = tuple(WORDS["contact"])  # the keys of what every table of a contact may hold
# one of them tells the size of the contact
SIZES = {"a": "contact radius", "area": "contact area", "diameter": "contact diameter"}
EXAMPLES = {"length": "um", "area": "um^2", "load": "mN", "time": "s"}


@dataclass(frozen=True)
class Quantity:
    """A quantity that a column can hold: its ``meaning`` in messages, the ``dimension`` of its numbers, "" where it
    holds words, and the ``names`` of such columns, lower case, without unit."""

    meaning: str
    dimension: str
    names: Sequence[str]


@dataclass(frozen=True)
class Vocabulary:
    """The quantities of a kind of table by their keys; ``numbers``: the keys of those that are no words. A capital A
    alone is an area."""

    quantities: Mapping[str, Quantity]
    numbers: tuple[str, ...]

    def meaning(self, key: str) -> str:
        return self.quantities[key].meaning

    def key_of(self, title: str) -> str | None:
        """The key of a header cell, None where it names none of the quantities."""
        name = split_name(title)[0]
        if name == "A":
            return "area"
        words = _words_of(name.lower().strip())
        return next((key for key, quantity in self.quantities.items() if words.intersection(quantity.names)), None)

    def named(self, table: TextTable, key: str) -> list[int]:
        """Columns whose name is one of those of ``key``."""
        return [i for i, title in enumerate(table.names) if self.key_of(title) == key]

    def guess(self, table: TextTable, key: str) -> int:
        """The one column that is named like ``key``, or the one of several whose unit is one of its dimension."""
        matches = self.named(table, key)
        if len(matches) > 1:
            units, wanted = {i: split_name(table.names[i])[1] for i in matches}, self.quantities[key].dimension
            right = [i for i, unit in units.items() if (unit_power(unit) or ("",))[0] == wanted]
            matches = right if len(right) == 1 and all(units.values()) else matches
        if len(matches) == 1:
            return matches[0]
        reason = "no column is" if not matches else f"{len(matches)} columns are"
        raise InputError(
            f"{table.path}: {reason} recognised as the {self.meaning(key)}: say which, --column {key}=NAME "
            f"({table.choice})"
        )

    def in_si(self, table: TextTable, key: str, index: int, unit: str | None = None) -> Array:
        """The values of a column in SI, by ``unit`` or that of its header: 100 um is exactly 1e-4 m."""
        if unit is None:
            table.refuse_contradicted(index)
        values, dimension = table.numbers(index), self.quantities[key].dimension
        unit = unit or split_name(table.names[index])[1]
        where = f"{table.path}: {table.titled(index)} ({self.meaning(key)})"
        example = EXAMPLES[dimension]
        if not unit:
            raise InputError(f"{where} names no unit: give --unit {key}={example}, or write it into the header")
        parsed = unit_power(unit)
        if parsed is None or parsed[0] != dimension:
            raise InputError(f'{where}: the unit must be one of {dimension}, such as {example}, got "{unit}"')
        power = parsed[1]
        beyond = np.abs(values) > LARGEST_SI
        if beyond.any():
            line, value = table.lines[beyond][0], values[beyond][0]
            raise InputError(
                f"{table.path}: line {line}: {self.meaning(key)} must be up to {LARGEST_SI:g}, got {value:g}"
            )
        return values * 10.0**power if power > 0 else values / 10.0**-power


# The quantities of a kind of table, "measured" or "computed": those of a contact by more names, and others.
VOCABULARIES: dict[str, Vocabulary] = {}
for _kind in ("measured", "computed"):
    _also, _quantities = WORDS[_kind]["also"], {}
    for _key, _entry in quantities(_kind).items():
        _quantities[_key] = Quantity(**_entry | {"names": [*_entry["names"], *_also.get(_key, ())]})
    VOCABULARIES[_kind] = Vocabulary(_quantities, tuple(key for key, one in _quantities.items() if one.dimension))


def with_units(
    table: TextTable, units: Mapping[str, str], keys: Container[str]
) -> tuple[TextTable, dict[str, str], list[str]]:
    """The table with the ``units`` of columns, by name or number, in its header; the units of quantities, which are
    left; and a sentence on each unit of the header that another one takes the place of. ``keys``: of quantities."""
    names, flags = list(table.names), []
    for name, unit in units.items():
        if name in keys:
            continue
        index = table.called(name, f"--unit {name}={unit}")
        names[index] = f"{split_name(table.names[index])[0]} [{unit}]"
        flags += overruled(table, index, unit)
    quantity_units = {name: unit for name, unit in units.items() if name in keys}
    return replace(table, names=tuple(names)), quantity_units, flags


def overruled(table: TextTable, index: int, unit: str) -> list[str]:
    """A flag on a ``unit`` in place of another one of the header; none where they are the same or that has none."""
    header_unit = split_name(table.names[index])[1]
    if header_unit in ("", unit):
        return []
    return [f"{table.titled(index)} read in {unit} as specified, its header says {header_unit}"]


def factors_of(factors: Mapping[str, float]) -> dict[str, float]:
    """The ``factors`` of columns; InputError where one is larger or smaller than units may differ by."""
    numbers = read("factors", reader(Mapping[str, float]), factors)
    for key, number in numbers.items():
        if not 1 / LARGEST_FACTOR <= abs(number) <= LARGEST_FACTOR:
            raise InputError(
                f"--factor {key}: must lie between {1 / LARGEST_FACTOR:g} and {LARGEST_FACTOR:g}, of either sign, got "
                f"{factors[key]}"
            )
    return dict(numbers)


def check_chosen(table: TextTable, chosen: Mapping[str, int]) -> None:
    """Refuse two columns for the size of the contact, and one column for two quantities."""
    if len(sizes := [name for key, name in SIZES.items() if key in chosen]) > 1:
        raise InputError(f"{table.path}: give a column for the {' or for the '.join(sizes[:2])}, not for both")
    if len(set(chosen.values())) < len(chosen):
        raise InputError(f"{table.path}: one column cannot be two quantities, got {table.listed(chosen)}")


@lru_cache(maxsize=REMEMBERED)
def _words_of(name: str) -> frozenset[str]:
    """Words in a column's ``name`` (lower case) that may name its quantity."""
    # The variable in the name of an Abaqus history, "RF:RF2 PI: TOOL-1 N: 1" or "_temp_1 RF2".
    return frozenset(
        {
            name,
            re.split(r"[:\s]", name)[0],
            name.rsplit(":", 1)[-1].strip(),
            *re.findall(r"(?:\A|:)\s*([a-z]+\d?)(?=\s|\Z)", name),
        }
    )


# --------------------------------------------------------------------------------------------------
# Rows of a growing contact whose columns fall here and there: by noise, or because they are in another order.
#
# A radius, displacement or load that is not positive holds no contact: noise does that to the rows near first touch,
# and an outlier to a row by itself.

# What noise does not do to the order of rows.
NOISY_ROWS_FEWEST = 8  # choice: rows; of fewer none can be spared
# rank correlation of a column with the rows; tuned on imported tables, by `make constants`: 10 % noise on 15 rows
# leaves more
NOISY_ROWS_ORDERED = 0.85
# tuned on imported tables, by `make constants`: of the rows, those near first touch that noise may hide, and those
# of outliers
NOISY_ROWS_HIDDEN = 0.1


WINDOW = round(1 / NOISY_ROWS_HIDDEN)  # rows among which outliers alone hide one
DENSE = 2 / WINDOW  # share of hidden rows near first touch, two of a window; noise of the load alone leaves 0.3


def is_within_noise(size: Array, delta: Array, P: Array) -> bool:
    """Whether rows in contact rise on the whole, so that falls of radius (or area), displacement, load are noise.

    Rows that are unloading at the end, repeat a displacement only, or stand in another order are no noise.
    """
    if size.size < NOISY_ROWS_FEWEST:
        return False
    for column in (size, delta, P):  # whose ranks follow the rows, but for the few that lie farthest off: outliers
        ranks, rows = np.argsort(np.argsort(column, kind="stable"), kind="stable"), np.arange(column.size)
        most = column.size - int(NOISY_ROWS_HIDDEN * column.size)
        followed = np.argsort(np.abs(ranks - rows), kind="stable")[:most]
        if not float(np.corrcoef(rows[followed], ranks[followed])[0, 1]) > NOISY_ROWS_ORDERED:
            return False
    hidden = (delta <= 0) | (P <= 0)
    first = near_first_touch(hidden)
    if max(first, hidden[first:].sum()) - 1 >= NOISY_ROWS_HIDDEN * size.size:
        return False
    falls = np.stack([np.diff(column) < 0 for column in (size, delta, P)])
    last = int(np.argmin(np.all(falls, axis=0)[::-1]))  # steps at the end in which all fall: it unloads
    unloads = last > 0 and not falls[:, : falls.shape[1] - last].any()
    return bool(falls.any()) and not unloads


def near_first_touch(hidden: Array) -> int:
    """Number of rows in contact that lie near first touch: up to the last ``hidden`` one, (n,), that stands among
    enough others, of all rows and of those just before it."""
    n, before = np.arange(1, hidden.size + 1), np.concatenate([[0], np.cumsum(hidden)])
    near = np.maximum(n - WINDOW, 0)
    share = np.minimum(before[n] / n, (before[n] - before[near]) / (n - near))
    return int(np.max(np.flatnonzero(hidden & (share >= DENSE)), initial=-1)) + 1

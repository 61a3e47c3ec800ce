"""Segments and curves whose columns stand beside each other in one table: put one under the other.

Columns that name a direction ("Weg hin", "Retract Force (nN)", or a line above the names) are the segments of one
record; columns of the same names, numbered or not ("F1", "d2", "Probe 1" above), are curves of their own.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ...base import SAME, Array, InputError
from ...tables.text_table import TextTable
from ...tables.titles import split_name, unit_power
from .curve import APPROACH, RETRACT
from .instruments import DIRECTIONS, VOLTS

DEFINING = {"a", "area", "diameter", "delta", "P"}  # two of them make a curve
QuantityOf = Callable[[str], str | None]  # the quantity that a header cell names, "a", "delta", "P", "t" ...


@dataclass(frozen=True)
class Sets:
    """Columns beside each other: for the word of each set its columns by their common names; ``shared``: the columns of
    all sets; ``key``: what the words are, "segment" or "curve"."""

    key: str
    columns: Mapping[str, Mapping[str, int]]
    shared: tuple[int, ...]

    def make_curves(self, names: tuple[str, ...], quantity: QuantityOf) -> bool:
        """Whether the sets hold the same names, and these what makes a curve, of segments with the shared columns."""
        first, *others = (list(columns) for columns in self.columns.values())
        shared = [names[i] for i in self.shared] if self.key == "segment" else []
        quantities = {quantity(_direction(title)[1]) for title in [*first, *shared]}
        return bool(others) and all(set(other) == set(first) for other in others) and len(quantities & DEFINING) > 1


def one_under_the_other(table: TextTable, quantity: QuantityOf) -> tuple[TextTable, list[str]]:
    """The table with columns that stand beside each other put one under the other, a column of words "curve" or
    "segment" added, and a sentence on what was done; a table without such columns is returned as it is.

    InputError where the directions do not hold the same columns.
    """
    table, flags = _without_copies(table)
    for sets in (_repeated(table), _numbered(table, quantity)):
        if sets is not None and sets.make_curves(table.names, quantity):
            table, flags = _stacked(table, sets), [*flags, _words(sets)]
            if sets.key == "segment":
                return _in_order_of_time(table, quantity, flags)
            break
    directed = _directed(table)
    if directed is None:
        return table, flags
    if not directed.make_curves(table.names, quantity):
        _refuse_halves(table, directed, quantity)
        return table, flags
    return _in_order_of_time(_stacked(table, directed), quantity, [*flags, _words(directed)])


def _words(sets: Sets) -> str:
    words = ", ".join(sets.columns) if len(sets.columns) < 10 else f"{len(sets.columns)} of them"
    what = "segments of one record" if sets.key == "segment" else "curves"
    return f"{what} beside each other, put one under the other: {words}"


def _refuse_halves(table: TextTable, directed: Sets, quantity: QuantityOf) -> None:
    """Refuse directions that differ in their columns, where one of them makes a curve alone."""
    (one, ins), (other, outs) = directed.columns.items()
    for word, columns in directed.columns.items():
        alone = replace(directed, columns={word: columns, "": columns})
        if alone.make_curves(table.names, quantity):
            wanted = {quantity(title): i for title, i in columns.items()}
            remedy = " ".join(f"--column {key}={i + 1}" for key, i in wanted.items() if key in DEFINING)
            own = [(one, title) for title in ins if title not in outs]
            owner, title = [*own, *((other, title) for title in outs if title not in ins)][0]
            raise InputError(
                f"{table.path}: the columns of approach and retraction differ, only the {owner} has a column "
                f'"{title}": {remedy} takes the {word} alone ({table.choice})'
            )


def _repeated(table: TextTable) -> Sets | None:
    """Sets of columns with the same names, by the words of a line above the names or in their order."""
    known = set(table.names)
    bases = [re.sub(r"\.\d+\Z", "", title) for title in table.names]  # "Force (N).1": a second one of a data frame
    titles = [base if base in known else title for base, title in zip(bases, table.names, strict=True)]
    times, places = Counter(titles), Counter[str]()

    def parts(i: int) -> tuple[str | None, str]:
        title = titles[i]
        if not title or times[title] == 1:
            return None, title
        places[title] += 1
        return str(places[title]), title

    sets = _parted(table, "curve", parts)
    if sets is None or len(sets.columns) < 2:
        return None
    words = _line_above(table, [min(columns.values()) for columns in sets.columns.values()])
    if words and {word.lower() for word in words} <= DIRECTIONS.keys():
        words = [DIRECTIONS[word.lower()] for word in words]
    if len(set(words)) < len(sets.columns):
        return sets
    key = "segment" if set(words) == {APPROACH, RETRACT} else "curve"
    return replace(sets, key=key, columns=dict(zip(words, sets.columns.values(), strict=True)))


def _line_above(table: TextTable, starts: list[int]) -> list[str]:
    """The words of a line of the head that stand over the first columns of the sets and over no other."""
    for line in reversed(table.head):
        cells = table.dialect.cells(line.lstrip("#% "))
        if [i for i, cell in enumerate(cells) if cell] == starts:
            return [cells[i] for i in starts]
    return []


def _numbered(table: TextTable, quantity: QuantityOf) -> Sets | None:
    """Sets of columns by the number at the end of their names."""

    def parts(i: int) -> tuple[str | None, str]:
        name, unit = split_name(table.names[i])
        match = re.match(r"(.*?\D)[\s_#.-]*(\d{1,4})\Z", name[-40:])
        rest = "" if match is None else match[1].rstrip(" _#.-") + (f" [{unit}]" if unit else "")
        return (None if match is None or quantity(rest) is None else match[2]), rest

    sets = _parted(table, "curve", parts)
    return sets if sets and len(sets.columns) > 1 and min(map(len, sets.columns.values())) > 1 else None


def _directed(table: TextTable) -> Sets | None:
    """Sets of columns by the direction among the words of their names."""
    sets = _parted(table, "segment", lambda i: _direction(table.names[i]))
    if sets is None or len(sets.columns) < 2:
        return None
    return replace(sets, columns={kind: sets.columns[kind] for kind in (APPROACH, RETRACT)})


def _parted(table: TextTable, key: str, parts: Callable[[int], tuple[str | None, str]]) -> Sets | None:
    """Sets of columns by the word that is one of the ``parts`` of the name of each, beside what is left of that; None
    where one name comes twice."""
    sets: dict[str, dict[str, int]] = {}
    shared = []
    for i in range(len(table.names)):
        word, rest = (None, "") if i in table.text else parts(i)
        if word is None:
            shared.append(i)
        elif rest in sets.setdefault(word, {}):
            return None
        else:
            sets[word][rest] = i
    return Sets(key, sets, tuple(shared))


def _direction(title: str) -> tuple[str | None, str]:
    """The direction that one of the words of a header cell names, and the cell without that word."""
    name, unit = split_name(title)
    words = re.split(r"[\s_]+", name)
    named = next((word for word in words if word.lower() in DIRECTIONS), None)
    if named is None or len(words) < 2:
        return None, title
    words.remove(named)
    if not unit and len(words) > 1 and (words[-1] in VOLTS or unit_power(words[-1])):
        unit = words.pop()
    return DIRECTIONS[named.lower()], " ".join(words) + (f" [{unit}]" if unit else "")


def _stacked(table: TextTable, sets: Sets) -> TextTable:
    """The table with the sets one under the other, behind the shared columns and before the column of their words."""
    names = list(next(iter(sets.columns.values())))
    text: dict[int, list[str]] = {at: [] for at, i in enumerate(sets.shared) if i in table.text}
    values, lines, words = [], [], []
    for word, columns in sets.columns.items():
        rows = np.flatnonzero(np.isfinite(table.values[:, list(columns.values())]).any(axis=1))
        values.append(table.values[rows][:, [*sets.shared, *(columns[name] for name in names)]])
        lines.append(table.lines[rows])
        words += [word] * rows.size
        for at, column in text.items():
            column += np.array(table.text[sets.shared[at]])[rows].tolist()
    titles = (*(table.names[i] for i in sets.shared), *names, sets.key)
    stacked = {at: tuple(column) for at, column in text.items()} | {len(titles) - 1: tuple(words)}
    return replace(table, names=titles, values=np.column_stack([np.vstack(values), np.zeros(len(words))]),
                   lines=np.concatenate(lines), text=stacked)  # fmt: skip


def _in_order_of_time(table: TextTable, quantity: QuantityOf, flags: list[str]) -> tuple[TextTable, list[str]]:
    """The rows of each direction turned that is not as it was recorded: where both move the same way they stand in the
    order of the position, and the approach is turned if its load falls, else the retraction. A column of time that
    never runs back says that they do not, and counts rows where it does so for both alike."""
    keys = [quantity(title) for title in table.names]
    times = [i for i, key in enumerate(keys) if key == "t"]
    if "delta" not in keys:
        return table, flags
    z, words = table.values[:, keys.index("delta")], np.array(table.text[len(keys) - 1])
    P = table.values[:, keys.index("P")] if "P" in keys else -z
    if times and (np.diff(table.values[:, times[0]]) >= 0).all():
        return table, flags
    curve = np.array(table.text[keys.index("curve")]) if "curve" in keys else np.full(z.size, "")
    order = np.arange(z.size)
    for name in np.unique(curve):
        approach, retract = (np.flatnonzero((words == word) & (curve == name)) for word in (APPROACH, RETRACT))
        if _way(z[approach]) * _way(z[retract]) > 0:
            wrong = approach if _rise(P[approach]) < 0 else retract
            order[wrong] = wrong[::-1]
    moved = order != np.arange(z.size)
    if not moved.any():
        return table, flags
    values = table.values[order]
    values[:, times] = table.values[:, times]
    name = "approach" if words[moved][0] == APPROACH else "retraction"
    return replace(table.rows(order), values=values), [
        *flags,
        f"the rows of the {name} turned: they stand in the order of the position",
    ]


def _without_copies(table: TextTable) -> tuple[TextTable, list[str]]:
    """The table without columns that repeat one before of the same name, number by number: programs write a channel
    once for each of its windows."""
    firsts: dict[str, int] = {}
    copies = []
    for i, title in enumerate(table.names):
        first = firsts.setdefault(re.sub(r"\.\d+\Z", "", title), i)
        if first != i and title and i not in table.text and _agree(table.values[:, first], table.values[:, i]):
            copies.append(i)
    if not copies:
        return table, []
    left = [i for i in range(len(table.names)) if i not in copies]
    text = {left.index(i): cells for i, cells in table.text.items()}
    names = tuple(table.names[i] for i in left)
    flag = f"{len(copies)} columns repeat others of the same names and were left out"
    return replace(table, names=names, values=table.values[:, left], text=text), [flag]


def _agree(one: Array, other: Array) -> bool:
    """Whether columns are the same but for the last digits that were written."""
    known = np.isfinite(one)
    if not known.any() or (known != np.isfinite(other)).any():
        return False
    span = float(np.ptp(one[known]))
    return 0 < span and bool((np.abs(one[known] - other[known]) <= SAME * span).all())


def _rise(column: Array) -> float:
    """How much a column grows from the first tenth of the rows to the last."""
    known = column[np.isfinite(column)]
    few = max(known.size // 10, 1)
    return float(np.median(known[-few:]) - np.median(known[:few])) if known.size else 0.0


def _way(z: Array) -> float:
    """How far the position moves from the first tenth of the rows to the last; 0 where it turns back in between."""
    way = _rise(z)
    return way if way and abs(way) > float(np.ptp(z[np.isfinite(z)])) / 2 else 0.0

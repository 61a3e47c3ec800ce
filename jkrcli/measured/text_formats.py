"""Measured curves in text tables: columns by name or number, words for segments, several curves in one file."""

import itertools
import math
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..base.errors import InputError, counted
from ..base.numerics import SAME, SHOWN, Array
from ..series.vocabulary import CONTACT, EXAMPLES, NO_UNIT, SIZES, VOCABULARIES, check_chosen, overruled, with_units
from ..tables import LONGEST, split_name, unit_power
from ..tables.text import TEXT_GAPS, TextTable, read_table
from . import instruments
from . import instruments as archive
from .curve import (
    APPROACH,
    ARBITRARY,
    AS_DEPTH,
    GAPS,
    LEAST_ROWS,
    NOT_SUBTRACTED,
    OVERRULED,
    QUANTITIES,
    RETRACT,
    TURNED,
    AsRead,
    Curve,
    Reading,
    place,
)
from .instruments import DIRECTIONS, VOLTS

# --------------------------------------------------------------------------------------------------
# Segments and curves whose columns stand beside each other in one table: put one under the other.
#
# Columns that name a direction ("Weg hin", "Retract Force (nN)", or a line above the names) are the segments of one
# record; columns of the same names, numbered or not ("F1", "d2", "Probe 1" above), are curves of their own.

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
    directed = _parted(table, "segment", lambda i: _direction(table.names[i]))
    if directed is None or len(directed.columns) < 2:
        return table, flags
    directed = replace(directed, columns={kind: directed.columns[kind] for kind in (APPROACH, RETRACT)})
    if not directed.make_curves(table.names, quantity):
        # Directions that differ in their columns are refused where one of them makes a curve alone
        (one, ins), (other, outs) = directed.columns.items()
        for word, columns in directed.columns.items():
            alone = replace(directed, columns={word: columns, "": columns})
            if alone.make_curves(table.names, quantity):
                wanted = {quantity(title): i for title, i in columns.items()}
                remedy = " ".join(f"--column {key}={i + 1}" for key, i in wanted.items() if key in DEFINING)
                own = [(one, title) for title in ins if title not in outs]
                owner, title = [*own, *((other, title) for title in outs if title not in ins)][0]
                raise InputError(f"{table.path}: the columns of approach and retraction differ, only the {owner} has a "
                                 f'column "{title}": {remedy} takes the {word} alone ({table.choice})')  # fmt: skip
        return table, flags
    return _in_order_of_time(_stacked(table, directed), quantity, [*flags, _words(directed)])


def _words(sets: Sets) -> str:
    words = ", ".join(sets.columns) if len(sets.columns) < 10 else f"{len(sets.columns)} of them"
    what = "segments of one force curve" if sets.key == "segment" else "curves"
    return f"{what} beside each other, put one under the other: {words}"


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
    # The words of a line of the head that stand over the first columns of the sets and over no other.
    words, starts = list[str](), [min(columns.values()) for columns in sets.columns.values()]
    for line in table.head:
        cells = table.dialect.cells(line.lstrip("#% "))
        if [i for i, cell in enumerate(cells) if cell] == starts:
            words = [cells[i] for i in starts]
    if words and {word.lower() for word in words} <= DIRECTIONS.keys():
        words = [DIRECTIONS[word.lower()] for word in words]
    if len(set(words)) < len(sets.columns):
        return sets
    key = "segment" if set(words) == {APPROACH, RETRACT} else "curve"
    return replace(sets, key=key, columns=dict(zip(words, sets.columns.values(), strict=True)))


def _numbered(table: TextTable, quantity: QuantityOf) -> Sets | None:
    """Sets of columns by the number at the end of their names."""

    def parts(i: int) -> tuple[str | None, str]:
        name, unit = split_name(table.names[i])
        match = re.match(r"(.*?\D)[\s_#.-]*(\d{1,4})\Z", name[-40:])
        rest = "" if match is None else match[1].rstrip(" _#.-") + (f" [{unit}]" if unit else "")
        return (None if match is None or quantity(rest) is None else match[2]), rest

    sets = _parted(table, "curve", parts)
    return sets if sets and len(sets.columns) > 1 and min(map(len, sets.columns.values())) > 1 else None


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
    told = f"the rows of the {name} turned: they stand in the order of the position"
    return replace(table.rows(order), values=values), [*flags, told]


def _without_copies(table: TextTable) -> tuple[TextTable, list[str]]:
    """The table without columns that repeat one before of the same name, number by number: programs write a channel
    once for each of its windows."""
    firsts: dict[str, int] = {}
    copies = []
    for i, title in enumerate(table.names):
        first = firsts.setdefault(re.sub(r"\.\d+\Z", "", title), i)
        if first == i or not title or i in table.text:
            continue
        one, other = table.values[:, first], table.values[:, i]
        known = np.isfinite(one)
        if known.any() and (known == np.isfinite(other)).all():  # the same but for the last digits that were written?
            span = float(np.ptp(one[known]))
            copies += [i] * bool(0 < span and (np.abs(one[known] - other[known]) <= SAME * span).all())
    if not copies:
        return table, []
    left = [i for i in range(len(table.names)) if i not in copies]
    text = {left.index(i): cells for i, cells in table.text.items()}
    names = tuple(table.names[i] for i in left)
    single = "a column repeats another of the same name and was"
    several = f"{len(copies)} columns repeat others of the same names and were"
    repeat = single if len(copies) == 1 else several
    return replace(table, names=names, values=table.values[:, left], text=text), [f"{repeat} left out"]


def _rise(column: Array) -> float:
    """How much a column grows from the first tenth of the rows to the last."""
    known = column[np.isfinite(column)]
    few = max(known.size // 10, 1)
    return float(np.median(known[-few:]) - np.median(known[:few])) if known.size else 0.0


def _way(z: Array) -> float:
    """How far the position moves from the first tenth of the rows to the last; 0 where it turns back in between."""
    way = _rise(z)
    return way if way and abs(way) > float(np.ptp(z[np.isfinite(z)])) / 2 else 0.0


UNITS_OF = {"stiffness": "N/m", "sensitivity": "m/V"}

NAMES = VOCABULARIES["measured"]
BARE = "; or --format afm, if a microscope's program wrote three columns without names"


class UnknownColumnsError(InputError):
    """A table without enough columns of known names: another program may know the file."""


def curves(path: Path, reading: Reading, content: bytes | None = None) -> Iterator[AsRead]:
    """The curves in the table at ``path`` (its ``content``, where that is at hand), or in the tables of a zip archive,
    with the stiffness of their device [N/m]; one that cannot be used comes as its error, the others follow.

    Raises InputError where the table as a whole cannot be read.
    """
    if path.suffix.lower() != ".zip":
        yield from _curves(path, path, path.stem, reading, content)
        return
    inside = archive.tables(path)
    for name, unpacked in zip(archive.titles(inside), archive.each_content(path, inside), strict=True):
        try:
            if isinstance(unpacked, InputError):
                raise unpacked
            yield from _curves(path, path / name, name, reading, unpacked)
        except InputError as error:
            if len(inside) == 1:
                raise
            yield error, None


def _curves(origin: Path, path: Path, stem: str, reading: Reading, content: bytes | None) -> Iterator[AsRead]:
    """The curves of one table, named after ``stem``; ``path`` stands in messages."""
    of_words = NAMES.quantities.keys() - set(NAMES.numbers)
    words_of_user = {name for key, name in reading.columns.items() if key in of_words}

    def is_text(index: int, title: str) -> bool:
        """Whether a column holds words, by its name or the user's choice."""
        return NAMES.key_of(title) in of_words or bool({title, split_name(title)[0], str(index + 1)} & words_of_user)

    table = read_table(
        path, reading.separator, reading.decimal, 2, is_text, finite=False, content=content,
        is_note=lambda line: instruments.segment_of(line) is not None,
    )  # fmt: skip
    as_read, units, unit_flags = with_units(_where(table, reading.where), reading.units, NAMES.numbers)
    # The table with segments and curves beside each other one under the other and flags on it, unless the user names
    # or numbers a column.
    titles = {*as_read.names, *(split_name(title)[0] for title in as_read.names)}
    named = any(name.isdigit() or name in titles for name in reading.columns.values())
    table, layout_flags = (as_read, []) if named else one_under_the_other(as_read, _quantity_of)
    columns, choice_flags = _columns(table, replace(reading, units=units))
    whole, value_flags = columns.in_si()
    segments, segment_flags = _segments(table, columns.chosen.get("segment"), "segment" in reading.columns)
    of_sample = [i for i in table.text if instruments.plain(table.names[i]) == "sample"]
    unread = [table.titled(i) for i in table.text if i not in {*columns.chosen.values(), *of_sample}]
    if unread:
        told = f"of its {len(table.names)} columns {', '.join(unread[:SHOWN])}"
        choice_flags = [*choice_flags, f"{told} {'holds' if len(unread) == 1 else 'hold'} words, which are not read"]
    flags = (*layout_flags, *choice_flags, *value_flags, *unit_flags, *as_read.left_out, *segment_flags)
    at = None if "curve" in columns.chosen else instruments.position_in(table.head)
    in_head = instruments.sample_in(table.head)
    for name, recorded in _groups(table, columns.chosen, stem):
        kept, left_out = _without_gaps(table, recorded, whole)
        rows, turned = _in_time(kept, whole.get("t"), segments)
        values = {key: column[rows] for key, column in whole.items()}
        words = None if segments is None else segments[rows]
        if words is not None and "t" in values:  # which may start anew: run back where a segment ends, nowhere else
            back = np.diff(values["t"]) < 0
            if back.any() and (words[1:] != words[:-1])[back].all():
                del values["t"]
        try:
            _check(place(origin, name), name == table.path.stem, table.lines[rows], values)
            if "area" in values:
                values["a"] = np.sqrt(values.pop("area") / np.pi)
            if "diameter" in values:
                values["a"] = values.pop("diameter") / 2
            a, delta, P, t = map(values.get, QUANTITIES)
            samples = {str(table.text[i][row]) for i in of_sample for row in rows} or {in_head}
            curve = Curve(
                name, a, delta, P, t, words, origin, pixel=at, sample=samples.pop() if len(samples) == 1 else ""
            )
            yield columns.with_sign(curve, (*flags, *left_out, *turned)), columns.stiffness
        except InputError as error:
            yield error, columns.stiffness


def _where(table: TextTable, wanted: Mapping[str, str]) -> TextTable:
    """The table at the rows whose columns, by name or number, hold what is wanted; segments and curves are chosen where
    they are known."""
    for name, value in wanted.items():
        if name in ("segment", "curve"):
            continue
        index = table.called(name, f"--where {name}={value}")
        cells = table.text.get(index) or [f"{number:g}" for number in table.values[:, index]]
        chosen = np.array([cell.lower() == value.lower() for cell in cells])
        if not chosen.any():
            there = ", ".join(list(dict.fromkeys(cells))[:SHOWN])
            raise InputError(f'{table.path}: no row holds "{value}" in {table.titled(index)} (it holds {there} ...)')
        table = table.rows(chosen)
    return table


TEXT_SEGMENTS = 12  # choice: different words of a column, above which they are no segments of one curve


def _segments(table: TextTable, index: int | None, told: bool) -> tuple[Array | None, list[str]]:
    """The segment of every row, by the column ``index`` or else by notes, None where neither names one; a sentence on
    what the words of a column were taken for, where they are others. A column of many different words, or of
    numbers, as that of a phase in degrees, names none unless it is ``told`` to."""
    ignored: list[str] = []
    if index is not None and not told:
        different = set(table.text[index])
        if len(different) > TEXT_SEGMENTS or not any(re.search(r"[^\W\d_]{2}", word) for word in different):
            ignored = [f"{table.titled(index)} holds numbers or more than {TEXT_SEGMENTS} words: it names no segments"]
            index = None
    if index is not None:
        words: list[str] = [*table.text[index]]
    else:  # lines before the rows, "# segment: extend" or "Retract" between them, of which one stands before the first
        notes = [(0, line) for line in table.head] + sorted(table.notes.items())
        marks = [(n, word) for n, line in notes if (word := instruments.segment_of(line))]
        in_words = any(re.match(r"\W*(segment|direction)\W*", line, re.IGNORECASE) for line in table.head)
        if not marks or marks[0][0] > 0 or not (in_words or marks[-1][0] > 0):
            return None, ignored
        words = [marks[i][1] for i in np.searchsorted([n for n, _ in marks], table.lines) - 1]
    if not words:
        return None, ignored
    whole: Iterable[str] = itertools.accumulate(words, lambda above, word: word or above)  # written where they change
    segments = np.array([instruments.SEGMENTS.get(word.lower(), word) for word in whole])
    others = dict.fromkeys(word for word in words if word)
    if index is None or set(others) <= {APPROACH, RETRACT}:
        return segments, ignored
    meant = [f'"{word}" is {instruments.SEGMENTS.get(word.lower(), "neither approach nor retract")}' for word in others]
    more = ", ..." * (len(meant) > SHOWN)
    return segments, [f"segments from {table.titled(index)}: {', '.join(meant[:SHOWN])}{more}"]


def _without_gaps(table: TextTable, rows: Array, values: Mapping[str, Array]) -> tuple[Array, tuple[str, ...]]:
    """The ``rows`` of a curve but those in which a number is missing, and a sentence on these; all of them where such
    rows are many, a column that is not understood, and not all of them name an overflow or an error of a sheet."""
    gaps = np.any([np.isnan(column[rows]) for column in values.values()], axis=0)
    count = int(gaps.sum())
    marked = table.failed.issuperset(table.lines[rows[gaps]].tolist())
    if count == 0 or (count > TEXT_GAPS * rows.size and not marked):
        return rows, ()
    lines = ", ".join(map(str, table.lines[rows[gaps]][:SHOWN])) + ", ..." * (count > SHOWN)
    many = f"{count} of {rows.size:,} rows" if count > 1 else "1 row"
    return rows[~gaps], (f"{many}{GAPS} (line{'s' * (count > 1)} {lines})",)


def _in_time(rows: Array, t: Array | None, segments: Array | None) -> tuple[Array, tuple[str, ...]]:
    """The ``rows`` of a curve, those of a segment turned where its time runs back from end to end, as JPK writes
    retractions, and flags on it."""
    if t is None or segments is None:
        return rows, ()
    runs = np.split(rows, np.flatnonzero(segments[rows][1:] != segments[rows][:-1]) + 1)
    back = [len(run) > 1 and bool((np.diff(t[run]) < 0).all()) for run in runs]
    if len(runs) < 2 or not any(back):
        return rows, ()
    words = ", ".join(dict.fromkeys(str(segments[run[0]]) for run, is_back in zip(runs, back, strict=True) if is_back))
    turned = np.concatenate([run[::-1] if is_back else run for run, is_back in zip(runs, back, strict=True)])
    return turned, (f"the rows of the {words} are reversed: their time decreases",)


def _quantity_of(title: str) -> str | None:
    """The key of the quantity that a header cell names: of prepared tables, else of an instrument's."""
    bent = "P" if instruments.is_deflection(title) else None
    return NAMES.key_of(title) or ("delta" if instruments.position_of(title) is not None else bent)


@dataclass(frozen=True)
class Columns:
    """The quantities of a table, by the index of their ``chosen`` columns; ``in_head``: the constants of the device
    that its head names."""

    table: TextTable
    reading: Reading
    in_head: Mapping[str, float]
    chosen: Mapping[str, int]

    @property
    def position(self) -> instruments.Position | None:
        """The kind of position that the displacement is; None: as prepared."""
        return instruments.position_of(self.table.names[self.chosen["delta"]]) if "delta" in self.chosen else None

    @property
    def stiffness(self) -> float | None:
        """The stiffness [N/m] of the device whose position the displacement is."""
        if self.position is None:
            return self.reading.stiffness
        return self.reading.stiffness or self.in_head.get("stiffness") if self.position.device else None

    @property
    def unit_of_load(self) -> str:
        in_header = split_name(self.table.names[self.chosen["P"]])[1] if "P" in self.chosen else ""
        return self.reading.units.get("P") or in_header

    @property
    def bent(self) -> tuple[str, int] | None:
        """Whether the load's column is a deflection: "length" or "voltage" and its unit's power of ten, by the unit."""
        if self.unit_of_load in instruments.VOLTS:
            return "voltage", instruments.VOLTS[self.unit_of_load]
        parsed = unit_power(self.unit_of_load)
        if parsed is None or parsed[0] != "length" or NAMES.key_of(self.table.names[self.chosen["P"]]) == "P":
            return None  # a force in metres is a mistake
        return parsed

    def in_si(self) -> tuple[dict[str, Array], list[str]]:
        """The values of the quantities that are numbers, and sentences on how they were read."""
        values: dict[str, Array] = {}
        flags: list[str] = []
        for key, index in self.chosen.items():
            if key == "P":
                values[key], flags = self._load(index)
            elif key in NAMES.numbers:
                values[key] = NAMES.in_si(self.table, key, index, self.reading.units.get(key))
            if key in values and key != "delta":
                values[key] = values[key] * self.reading.factors.get(key, 1.0)
            if key in NAMES.numbers and key not in self.reading.units:
                self.table.refuse_contradicted(index)
        if self.reading.sensitivity is not None and (self.bent is None or self.bent[0] != "voltage"):
            load = f"its load is {self.table.titled(self.chosen['P'])}" if "P" in self.chosen else "it holds no load"
            raise InputError(f"{self.table.path}: --sensitivity converts volts to a deflection, and this file holds no "
                             f"volts, {load}: leave it out, or give the unit: --unit P=V")  # fmt: skip
        for key, unit in self.reading.units.items():
            flags += overruled(self.table, self.chosen[key], unit)
        return values, flags + self._on_stiffness()

    def _load(self, index: int) -> tuple[Array, list[str]]:
        """The load [N], and the sentence that says so where it is that of a deflection."""
        table, unit = self.table, self.unit_of_load
        if instruments.is_deflection(table.names[index]) and not unit:  # it may be one of volts, metres or newtons
            name = split_name(table.names[index])[0]
            raise InputError(f"{table.path}: {table.titled(index)} is a deflection and names no unit: give "
                             f'--unit "{name}=nm", or V, or nN, or write it into the header')  # fmt: skip
        if self.bent is None:
            return NAMES.in_si(table, "P", index, self.reading.units.get("P")), []
        factor, words = self._per_deflection(f"{table.titled(index)}", f"a deflection in {unit}")
        return table.numbers(index) * 10.0 ** self.bent[1] * factor, [words]

    def _per_deflection(self, title: str, kind: str) -> tuple[float, str]:
        """The load of a deflection of 1 m or 1 V, and a sentence on the constants in it."""
        wanted = ("sensitivity", "stiffness") if self.bent and self.bent[0] == "voltage" else ("stiffness",)
        known = {name: getattr(self.reading, name) or self.in_head.get(name) for name in wanted}
        options = " and ".join(f"--{name}" for name in wanted if known[name] is None)
        if options and not self.reading.incomplete:
            raise InputError(f"{self.table.path}: {title} is {kind}, no force: give {options}")
        if known["stiffness"] == math.inf:
            none = "and a rigid instrument has none: give its stiffness"
            raise InputError(f"{self.table.path}: {title} is {kind}, {none}")
        factor = math.prod(1.0 if value is None else value for value in known.values())
        if options:
            return factor, f"{title} is {kind}: loads in {ARBITRARY} {options}"
        constants = ", ".join(f"{key} {value:g} {UNITS_OF[key]}{self._error(key)}" for key, value in known.items())
        return factor, f"load from {title}, {kind}, with {constants}"

    def _on_stiffness(self) -> list[str]:
        """A sentence on the stiffness of a device: where it is from, or that it is missing or may be."""
        of_user, of_head = self.reading.stiffness, self.in_head.get("stiffness")
        if self.position is None:
            # A displacement of no telling name beside a deflection, or under a head that names a stiffness, may be.
            if of_user is not None or not {"delta", "P"} <= self.chosen.keys():
                return []
            index = self.chosen["delta"]
            hinted = "stiffness" in self.in_head and index not in NAMES.named(self.table, "delta")
            telling = any(word in instruments.plain(self.table.names[index]) for word in instruments.DEPTHS)
            return [AS_DEPTH] if (self.bent is not None or hinted) and not telling else []
        if not self.position.device:
            return []
        if of_user is None and of_head is None:
            return [NOT_SUBTRACTED] if "P" in self.chosen else []
        if of_user is None:
            error = self._error("stiffness")
            return [f"stiffness {of_head:g} N/m{error} from the header of the file, its deflection is subtracted"]
        if of_head is None or math.isclose(of_head, of_user, rel_tol=1e-6):
            return []
        told = "rigid" if of_user == math.inf else f"{of_user:g} N/m"
        return [f"stiffness {told}{OVERRULED}{of_head:g} N/m"]

    def _error(self, name: str) -> str:
        """The relative standard error of a constant that the head names with one, in words."""
        errors = {} if getattr(self.reading, name) else instruments.constant_errors(self.table.head)
        return f" ± {100 * errors[name]:.3g} %" if name in errors else ""

    def with_sign(self, curve: Curve, flags: tuple[str, ...]) -> Curve:
        """The curve with its displacement toward the specimen by the name of its column, else by its load; as in
        the file where the user turns it; with the ``flags`` and one on that."""
        if curve.delta is None:
            return curve
        reading, sign = self.reading, 1
        if self.position is not None:
            sign, reason = self.position.sign, f"{self.position.noun}, which grows away from the specimen"
            P = None if curve.P is None else curve.P * (-1.0 if "P" in reading.flip else 1.0)
            if sign == 0:
                sign = 1 if P is None or instruments.toward(curve.delta, P) else -1
                reason = f"{self.position.noun}, at whose lower end the load is largest"
            elif sign < 0 and P is not None:
                sign = 1 if instruments.presses_outward(-curve.delta, P) else -1
            turned = f"{TURNED}: {reason}" if sign < 0 else ", sign unchanged"
            if "delta" in reading.flip:
                sign, turned = 1, f"{TURNED} as specified"
            flags = (f"displacement from {self.table.titled(self.chosen['delta'])}{turned}", *flags)
        return replace(curve, delta=sign * curve.delta * reading.factors.get("delta", 1.0), flags=flags)


def _columns(table: TextTable, reading: Reading) -> tuple[Columns, list[str]]:
    """The column of every quantity that is there: the user's, else by its name; flags on the choice."""
    in_head = instruments.constants(table.head)
    chosen = {key: table.called(name, key) for key, name in reading.columns.items()}
    flags: list[str] = []
    stiffness = reading.stiffness or in_head.get("stiffness")
    if "delta" not in chosen and (position := _displacement(table, set(chosen.values()), stiffness)):
        chosen["delta"], why = position
        flags += [why] if why else []
    for key in NAMES.quantities:
        known = SIZES.keys() & chosen.keys() if key in SIZES else key in chosen
        if not known and (named := NAMES.named(table, key)):
            filled = [i for i in named if i in table.text or np.nan_to_num(table.values[:, i]).any()]
            if key not in ("delta", "P"):  # of which a column of zeros is no measurement
                flags += [f"{table.titled(i)} holds zeros alone and is left out" for i in named if i not in filled]
                if not filled:
                    continue
            whole = [i for i in filled if instruments.plain(table.names[i]) in instruments.WHOLE]
            chosen[key] = whole[0] if whole else filled[0] if len(filled) == 1 else NAMES.guess(table, key)
    if "diameter" not in reading.columns and "diameter" in chosen:
        diameters = table.values[:, chosen["diameter"]]
        if np.unique(diameters[np.isfinite(diameters)]).size < 2:
            del chosen["diameter"]  # that of the indenter
    bent = instruments.deflection(table)
    if "P" not in chosen and bent is not None and bent not in chosen.values():
        chosen["P"] = bent
    check_chosen(table, chosen)
    _refuse_incomplete(table, chosen, reading)
    flags += [line for key in CONTACT if key not in chosen for line in _without_unit(table, key)]
    return Columns(table, reading, in_head, chosen), flags


def _without_unit(table: TextTable, key: str) -> list[str]:
    """A sentence on each column that is named like ``key`` but for an ending that is no unit, as in "P_mn"."""
    sentences, quantity = [], NAMES.quantities[key]
    for i, title in enumerate(table.names):
        match = re.match(r"(.+?)\s*[/_]\s*([^/_\s]+)\Z", title[:LONGEST])
        if match and NAMES.key_of(title) is None and NAMES.key_of(match[1]) == key:
            sentences.append(
                f'column {i + 1} "{title}"{NO_UNIT}{quantity.dimension}; if it is the {quantity.meaning}: '
                f"--column {key}={title} --unit {key}={EXAMPLES[quantity.dimension]}"
            )
    return sentences


def _refuse_incomplete(table: TextTable, chosen: Mapping[str, int], reading: Reading) -> None:
    """Refuse words among numbers, too few columns, and what the user says of columns that are not there."""
    for key in chosen.keys() - set(NAMES.numbers):
        if chosen[key] not in table.text:
            raise InputError(f"{table.path}: {table.titled(chosen[key])} would hold words, but numbers stand above "
                             "its title: remove what comes before")  # fmt: skip
    if len(chosen.keys() & {*CONTACT, *SIZES}) < 2:
        there = f"{table.listed(chosen) or 'none'}; say which columns they are, --column P=NAME ({table.choice})"
        question = (
            f"{table.path}: at least two of contact radius (or area), displacement and load are needed, recognised: "
        )
        question += there
        if any(table.names):
            raise UnknownColumnsError(question)
        raise InputError(question + (BARE if len(table.names) == 3 else ""))  # afmformats takes any three for its own
    factors = {key: f"{factor:g}" for key, factor in reading.factors.items()}
    for option, entries in (("unit", reading.units), ("factor", factors)):
        for key in (key for key in entries if key not in chosen):
            raise InputError(f"{table.path}: --{option} {key}={entries[key]} has no column to belong to: give "
                             f"--column {key}=NAME ({table.choice})")  # fmt: skip


def _displacement(table: TextTable, taken: set[int], stiffness: float | None) -> tuple[int, str] | None:
    """The column of a position and, where there was a choice, why it was taken; None: the names of prepared tables."""
    prepared = NAMES.named(table, "delta")
    candidates = [(i, kind) for i, kind in instruments.positions(table) if i not in taken and i not in prepared]
    if not candidates or any(instruments.plain(table.names[i]) == "delta" for i in prepared):
        return None
    device = next((i for i, kind in candidates if kind.device), None)
    tip = prepared[0] if prepared else next((i for i, kind in candidates if not kind.device), None)
    if device is None or tip is None:
        return None if prepared else (candidates[0][0], "")
    if stiffness == math.inf:
        return None if prepared else (tip, "")
    if stiffness is not None:
        return device, f"the piezo position z was taken, not {table.titled(tip)}: its stiffness is known"
    why = f"the position of the tip was taken, not {table.titled(device)}: the stiffness of the instrument is not known"
    return (NAMES.guess(table, "delta") if prepared else tip), why


def _groups(table: TextTable, chosen: Mapping[str, int], stem: str) -> Iterator[tuple[str, Array]]:
    """Name and rows of each curve, in the order of the file; ``stem`` is the name where there is but one."""
    if "curve" not in chosen:
        yield stem, np.arange(table.lines.size)
        return
    names, inverse = np.unique(table.text[chosen["curve"]], return_inverse=True)
    order = np.argsort(inverse, kind="stable")
    groups = np.split(order, np.cumsum(np.bincount(inverse))[:-1])
    for rows in sorted(groups, key=lambda rows: int(rows[0])):
        yield str(names[inverse[rows[0]]]), rows


def _check(where: str, alone: bool, lines: Array, values: dict[str, Array]) -> None:
    """Refuse too few rows, numbers that are not finite, negative areas and radii, time that runs back."""
    if lines.size < LEAST_ROWS:
        there = ", ".join(map(str, lines))
        rows = f"{counted(lines.size, 'row')} (line{'s' * (lines.size != 1)} {there})"
        raise InputError(f"{where}: holds {rows}, at least {LEAST_ROWS} are needed")
    for key, column in values.items():
        size = key in SIZES
        wrong = ~np.isfinite(column) | ((column < 0) if size else False)
        if wrong.any():
            i = int(np.argmax(wrong))
            rule = "finite and >= 0" if size else "finite"
            raise InputError(f"{where}: line {lines[i]}: {NAMES.meaning(key)} must be {rule}, got {column[i]:g} (SI)")
    back = np.diff(values.get("t", np.zeros(1))) < 0
    if back.any():
        i = int(np.argmax(back)) + 1
        remedy = "; several curves in one file need their column: --column curve=NAME" if alone else ""
        raise InputError(f"{where}: line {lines[i]}: time must not run back, it falls from {values['t'][i - 1]:g} to "
                         f"{values['t'][i]:g} s{remedy}")  # fmt: skip

"""Measured curves in text tables: columns by name or number, words for segments, several curves in one file."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...base import SHOWN, Array, InputError
from ..columns import (
    CONTACT,
    Quantity,
    Vocabulary,
    check_chosen,
    choice,
    column_called,
    numbered,
    numbers,
    overruled,
    remarks,
    split_name,
    with_units,
    words,
)
from ..text_table import TUNING, TextTable, read_table, unit_power
from . import archive
from .beside import one_under_the_other
from .curve import (
    APPROACH,
    ARBITRARY,
    AS_DEPTH,
    LEAST_ROWS,
    NOT_SUBTRACTED,
    OVERRULED,
    QUANTITIES,
    RETRACT,
    Curve,
    Reading,
    place,
)
from .instruments import (
    DEFLECTIONS,
    DEPTHS,
    SEGMENTS,
    VOLTS,
    Position,
    constants,
    deflection,
    plain,
    position_of,
    positions,
    segment_of,
    toward,
)

WHOLE = ("seriestime", "series time")  # of a record whose segments have their own time too
UNITS_OF = {"stiffness": "N/m", "sensitivity": "m/V"}

NAMES = Vocabulary(CONTACT | {
    "delta": CONTACT["delta"].also("indentation depth", "déplacement", "deplacement"),
    "P": CONTACT["P"].also(
        "normal force", "axial force", "kraft", "prüfkraft", "standardkraft", "normalkraft", "effort",
        "charge", "force normale"),
    "t": Quantity("time", "time", ("t", "time", "zeit", "prüfzeit", "elapsed time", "temps", *WHOLE)),
    "segment": Quantity("segment", "", (
        "segment", "phase", "direction", "richtung", "branch", "branche", "ast", "zweig", "abschnitt")),
    "curve": Quantity("curve", "", ("curve", "curve number", "curve_number", "cycle", "zyklus")),
})  # fmt: skip
BARE = "; or --format afm, if a microscope's program wrote three columns without names"


class UnknownColumnsError(InputError):
    """A table without enough columns of known names: another program may know the file."""


def curves(
    path: Path, reading: Reading, content: bytes | None = None
) -> Iterator[tuple[Curve | InputError, float | None]]:
    """The curves in the table at ``path`` (its ``content``, where that is at hand), or in the tables of a zip archive,
    with the stiffness of their device [N/m]; one that cannot be used comes as its error, the others follow.

    Raises InputError where the table as a whole cannot be read.
    """
    if path.suffix.lower() != ".zip":
        yield from _curves(path, path, path.stem, reading, content)
        return
    inside = archive.tables(path)
    for name, content in zip(archive.titles(inside), archive.contents(path, inside), strict=True):
        try:
            yield from _curves(path, path / name, name, reading, content)
        except InputError as error:
            if len(inside) == 1:
                raise
            yield error, None


def _curves(
    origin: Path, path: Path, stem: str, reading: Reading, content: bytes | None = None
) -> Iterator[tuple[Curve | InputError, float | None]]:
    """The curves of one table, named after ``stem``; ``path`` stands in messages."""
    table = read_table(
        path, reading.separator, reading.decimal, 2, _is_text(reading), finite=False, content=content,
        is_note=lambda line: segment_of(line) is not None,
    )  # fmt: skip
    as_read, units, unit_flags = with_units(_where(table, reading.where), reading.units, NAMES.numbers)
    reading = replace(reading, units=units)
    table, layout_flags = _put_together(as_read, reading)
    columns = Columns.of(table, reading)
    columns = replace(columns, flags=(*layout_flags, *columns.flags, *unit_flags, *remarks(as_read)))
    segments = None
    if "segment" in columns.chosen:
        columns = replace(columns, flags=(*columns.flags, *_on_segments(table, columns.chosen["segment"])))
    segment_words = table.text[columns.chosen["segment"]] if "segment" in columns.chosen else _noted(table)
    if segment_words:
        segments = np.array([SEGMENTS.get(word.lower(), word) for word in _continued(segment_words)])
    for name, recorded in _groups(table, columns.chosen, stem):
        whole, left_out = _without_gaps(table, recorded, columns.values)
        rows, turned = _in_time(whole, columns.values.get("t"), segments)
        part = {key: column[rows] for key, column in columns.values.items()}
        if segments is not None and _starts_anew(part.get("t"), segments[rows]):
            del part["t"]
        curve = _curve(table, origin, name, rows, part, None if segments is None else segments[rows])
        if isinstance(curve, Curve):
            curve = replace(columns, flags=(*columns.flags, *left_out, *turned)).with_sign(curve, reading)
        yield curve, columns.stiffness


def _where(table: TextTable, wanted: Mapping[str, str]) -> TextTable:
    """The table at the rows whose columns, by name or number, hold what is wanted; segments and curves are chosen where
    they are known."""
    for name, value in wanted.items():
        if name in ("segment", "curve"):
            continue
        index = column_called(table, f"--where {name}={value}", name)
        cells = table.text[index] if index in table.text else [f"{number:g}" for number in table.values[:, index]]
        chosen = np.array([cell.lower() == value.lower() for cell in cells])
        if not chosen.any():
            there = ", ".join(list(dict.fromkeys(cells))[:SHOWN])
            raise InputError(f'{table.path}: no row holds "{value}" in {numbered(table, index)} (it holds {there} ...)')
        table = table.rows(chosen)
    return table


def _on_segments(table: TextTable, index: int) -> list[str]:
    """A sentence on what the words of a column of segments were taken for, where they are others."""
    words = dict.fromkeys(word for word in table.text[index] if word)
    if set(words) <= {APPROACH, RETRACT}:
        return []
    meant = [f'"{word}" is {SEGMENTS.get(word.lower(), "neither approach nor retract")}' for word in words]
    return [f"segments from {numbered(table, index)}: {', '.join(meant[:SHOWN])}" + ", ..." * (len(meant) > SHOWN)]


def _continued(words: Iterable[str]) -> list[str]:
    """The words, for an empty one that of the row above: sheets write some only where they change."""
    filled: list[str] = []
    for word in words:
        filled.append(word or (filled[-1] if filled else ""))
    return filled


def _noted(table: TextTable) -> list[str]:
    """The word of every row by the lines before it, "# segment: extend" or "Retract" between the rows; none where they
    name none for the first row."""
    notes = [(0, line) for line in table.head] + sorted(table.notes.items())
    marks = [(n, word) for n, line in notes if (word := segment_of(line))]
    in_words = any(re.match(r"\W*(segment|direction)\W*", line, re.IGNORECASE) for line in table.head)
    if not marks or marks[0][0] > 0 or not (in_words or marks[-1][0] > 0):
        return []
    lines, words = zip(*marks, strict=True)
    return [words[i] for i in np.searchsorted(lines, table.lines) - 1]


def _without_gaps(table: TextTable, rows: Array, values: Mapping[str, Array]) -> tuple[Array, tuple[str, ...]]:
    """The ``rows`` of a curve but those in which a number is missing, and a sentence on these; all of them where such
    rows are many: a column that is not understood."""
    gaps = np.any([np.isnan(column[rows]) for column in values.values()], axis=0)
    count = int(gaps.sum())
    if not 0 < count <= TUNING.gaps * rows.size:
        return rows, ()
    lines = ", ".join(map(str, table.lines[rows[gaps]][:SHOWN])) + ", ..." * (count > SHOWN)
    return rows[~gaps], (f"{count} row{'s' * (count > 1)} without a number left out (line{'s' * (count > 1)} {lines})",)


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
    return turned, (f"the rows of the {words} turned: their time runs back",)


def _starts_anew(t: Array | None, segment: Array) -> bool:
    """Whether time runs back where one segment ends and the next begins, and nowhere else."""
    if t is None:
        return False
    back = np.diff(t) < 0
    return bool(back.any()) and bool((segment[1:] != segment[:-1])[back].all())


def _put_together(table: TextTable, reading: Reading) -> tuple[TextTable, list[str]]:
    """The table with segments and curves beside each other one under the other and flags on it, unless the user names
    or numbers a column."""
    titles = {*table.names, *(split_name(title)[0] for title in table.names)}
    named = any(name.isdigit() or name in titles for name in reading.columns.values())
    return (table, []) if named else one_under_the_other(table, _quantity_of)


def _quantity_of(title: str) -> str | None:
    """The key of the quantity that a header cell names: of prepared tables, else of an instrument's."""
    bent = "P" if plain(title) in DEFLECTIONS else None
    return NAMES.key_of(title) or ("delta" if position_of(title) is not None else bent)


@dataclass(frozen=True)
class Columns:
    """The quantities of a table: ``values`` in SI by their keys, the index of the ``chosen`` columns, the kind of
    ``position`` that the displacement is (None: as prepared), the ``stiffness`` [N/m] of its device, and ``flags``,
    sentences on how it was read."""

    table: TextTable
    chosen: Mapping[str, int]
    values: Mapping[str, Array]
    position: Position | None
    stiffness: float | None
    flags: tuple[str, ...]

    @classmethod
    def of(cls, table: TextTable, reading: Reading) -> Columns:
        in_head = constants(table.head)
        stiffness = reading.stiffness or in_head.get("stiffness")
        chosen, flags = _columns(table, reading, stiffness)
        position = position_of(table.names[chosen["delta"]]) if "delta" in chosen else None
        values: dict[str, Array] = {}
        for key, index in chosen.items():
            if key not in NAMES.numbers:
                continue
            if key == "P":
                _refuse_unitless(table, index, reading)
            if key == "P" and (power := _deflection_power(table, index, reading)) is not None:
                values[key], flag = _load_of_deflection(table, index, power, reading, in_head)
                flags.append(flag)
            else:
                values[key] = NAMES.in_si(table, key, index, reading.units.get(key))
            if key != "delta":
                values[key] = values[key] * reading.factors.get(key, 1.0)
        _refuse_without_volts(table, chosen, reading)
        flags += [flag for key, unit in reading.units.items() for flag in overruled(table, chosen[key], unit)]
        if position is not None and position.device:
            flags += _on_stiffness(reading, in_head, "P" in chosen)
        elif position is not None:
            stiffness = None
        else:
            stiffness = reading.stiffness
            flags += [AS_DEPTH] if _may_be_the_device(table, chosen, reading, in_head) else []
        return cls(table, chosen, values, position, stiffness, tuple(flags))

    def with_sign(self, curve: Curve, reading: Reading) -> Curve:
        """The curve with its displacement toward the specimen by the name of its column, else by its load; as in
        the file where the user turns it; with a flag."""
        if curve.delta is None:
            return curve
        flags, sign = self.flags, 1
        if self.position is not None:
            index = self.chosen["delta"]
            sign, reason = self.position.sign, f"{self.position.noun}, which grows away from the specimen"
            if sign == 0:
                P = None if curve.P is None else curve.P * (-1.0 if "P" in reading.flip else 1.0)
                sign = 1 if P is None or toward(curve.delta, P) else -1
                reason = f"{self.position.noun}, at whose lower end the load is largest"
            if "delta" in reading.flip:
                sign, turned = 1, ", its sign turned as told"
            else:
                turned = f", its sign turned: {reason}" if sign < 0 else ", its sign as it is"
            flags = (f"displacement from {numbered(self.table, index)}{turned}", *flags)
        return replace(curve, delta=sign * curve.delta * reading.factors.get("delta", 1.0), flags=flags)


def _unit_of_load(table: TextTable, index: int, reading: Reading) -> str:
    return reading.units.get("P") or split_name(table.names[index])[1]


def _deflection_power(table: TextTable, index: int, reading: Reading) -> tuple[str, int] | None:
    """Whether the load's column is a deflection: "length" or "voltage" and its unit's power of ten, by the unit."""
    unit = _unit_of_load(table, index, reading)
    if unit in VOLTS:
        return "voltage", VOLTS[unit]
    parsed = unit_power(unit)
    named = NAMES.key_of(table.names[index]) == "P"  # a force in metres is a mistake
    return parsed if parsed and parsed[0] == "length" and not named else None


def _refuse_unitless(table: TextTable, index: int, reading: Reading) -> None:
    """Refuse a deflection without a unit: it may be one of volts, metres or newtons."""
    if plain(table.names[index]) in DEFLECTIONS and not _unit_of_load(table, index, reading):
        name = split_name(table.names[index])[0]
        raise InputError(f"{table.path}: {numbered(table, index)} is a deflection and names no unit: give "
                         f'--unit "{name}=nm", or V, or nN, or write it into the header')  # fmt: skip


def _refuse_without_volts(table: TextTable, chosen: Mapping[str, int], reading: Reading) -> None:
    """Refuse a sensitivity that nothing is multiplied by."""
    power = _deflection_power(table, chosen["P"], reading) if "P" in chosen else None
    if reading.sensitivity is not None and (power is None or power[0] != "voltage"):
        load = f"its load is {numbered(table, chosen['P'])}" if "P" in chosen else "it holds no load"
        raise InputError(f"{table.path}: --sensitivity makes a deflection of volts, and this file holds none, {load}: "
                         "leave it out, or give the unit: --unit P=V")  # fmt: skip


def _load_of_deflection(
    table: TextTable, index: int, unit: tuple[str, int], reading: Reading, in_head: Mapping[str, float]
) -> tuple[Array, str]:
    """The load [N] of a deflection in metres or volts, and the sentence that says so."""
    wanted = ("sensitivity", "stiffness") if unit[0] == "voltage" else ("stiffness",)
    known = {name: getattr(reading, name) or in_head.get(name) for name in wanted}
    missing = [name for name in wanted if known[name] is None]
    title, kind = numbered(table, index), f"a deflection in {_unit_of_load(table, index, reading)}"
    options = " and ".join(f"--{name}" for name in missing)
    if missing and not reading.incomplete:
        raise InputError(f"{table.path}: {title} is {kind}, no force: give {options}")
    if known["stiffness"] == math.inf:
        raise InputError(f"{table.path}: {title} is {kind}, and a rigid device has none: give its stiffness")
    factor = math.prod(1.0 if value is None else value for value in known.values())
    load = numbers(table, index) * 10.0 ** unit[1] * factor
    if missing:
        return load, f"{title} is {kind}: loads in {ARBITRARY} {options}"
    with_ = ", ".join(f"{key} {value:g} {UNITS_OF[key]}" for key, value in known.items())
    return load, f"load from {title}, {kind}, with {with_}"


def _on_stiffness(reading: Reading, in_head: Mapping[str, float], load: bool) -> list[str]:
    """A sentence on the stiffness of a device: where it is from, or that it is missing."""
    if reading.stiffness is not None:
        of_head = in_head.get("stiffness", reading.stiffness)
        return [] if math.isclose(of_head, reading.stiffness, rel_tol=1e-6) else \
            [f"stiffness {_words(reading.stiffness)}{OVERRULED}{of_head:g} N/m"]  # fmt: skip
    if "stiffness" in in_head:
        return [f"stiffness {in_head['stiffness']:g} N/m from the head of the file, its deflection is subtracted"]
    return [NOT_SUBTRACTED] if load else []


def _may_be_the_device(
    table: TextTable, chosen: Mapping[str, int], reading: Reading, in_head: Mapping[str, float]
) -> bool:
    """Whether a displacement of no telling name stands beside a deflection, or under a head that names a stiffness."""
    if reading.stiffness is not None or not {"delta", "P"} <= chosen.keys():
        return False
    title = plain(table.names[chosen["delta"]])
    bends = _deflection_power(table, chosen["P"], reading) is not None
    known = chosen["delta"] in NAMES.named(table, "delta")
    return (bends or ("stiffness" in in_head and not known)) and not any(word in title for word in DEPTHS)


def _words(stiffness: float) -> str:
    return "rigid" if stiffness == math.inf else f"{stiffness:g} N/m"


def _curve(
    table: TextTable, origin: Path, name: str, rows: Array, values: dict[str, Array], segment: Array | None
) -> Curve | InputError:
    try:
        _check(place(origin, name), name == table.path.stem, table.lines[rows], values)
        if "area" in values:
            values["a"] = np.sqrt(values.pop("area") / np.pi)
        a, delta, P, t = (values.get(quantity) for quantity in QUANTITIES)
        return Curve(name, a, delta, P, t, segment, origin)
    except InputError as error:
        return error


def _is_text(reading: Reading) -> Callable[[int, str], bool]:
    """Whether a column holds words, as a function of its index and title: by its name, or the user's choice."""
    of_words = NAMES.quantities.keys() - set(NAMES.numbers)
    named = {name for key, name in reading.columns.items() if key in of_words}

    def is_text(index: int, title: str) -> bool:
        return NAMES.key_of(title) in of_words or bool({title, split_name(title)[0], str(index + 1)} & named)

    return is_text


def _columns(table: TextTable, reading: Reading, stiffness: float | None) -> tuple[dict[str, int], list[str]]:
    """Index of the column of every quantity that is there: the user's, else by its name; flags on the choice."""
    chosen = {key: column_called(table, key, name) for key, name in reading.columns.items()}
    flags: list[str] = []
    if "delta" not in chosen and (position := _displacement(table, set(chosen.values()), stiffness)):
        chosen["delta"], why = position
        flags += [why] if why else []
    for key in NAMES.quantities:
        if key not in chosen and NAMES.named(table, key) and not (key == "area" and "a" in chosen):
            whole = [i for i in NAMES.named(table, key) if plain(table.names[i]) in WHOLE]
            chosen[key] = whole[0] if whole else NAMES.guess(table, key)
    bent = deflection(table)
    if "P" not in chosen and bent is not None and bent not in chosen.values():
        chosen["P"] = bent
    check_chosen(table, chosen)
    for key in chosen.keys() - set(NAMES.numbers):
        if chosen[key] not in table.text:
            raise InputError(f"{table.path}: {numbered(table, chosen[key])} would hold words, but numbers stand above "
                             "its title: remove what comes before")  # fmt: skip
    if len(chosen.keys() & {"a", "area", "delta", "P"}) < 2:
        recognised = words(table, chosen) or "none"
        question = (
            f"{table.path}: at least two of contact radius (or area), displacement and load are needed, recognised: "
            f"{recognised}; say which columns they are, --column P=NAME ({choice(table)})"
        )
        if any(table.names):
            raise UnknownColumnsError(question)
        raise InputError(question + (BARE if len(table.names) == 3 else ""))  # afmformats takes any three for its own
    flags += [line for key in CONTACT if key not in chosen for line in NAMES.without_unit(table, key)]
    for option, entries in (("unit", reading.units), ("factor", reading.factors)):
        for key in entries:
            if key not in chosen:
                value = entries[key] if option == "unit" else f"{entries[key]:g}"
                raise InputError(f"{table.path}: --{option} {key}={value} has no column to belong to: give "
                                 f"--column {key}=NAME ({choice(table)})")  # fmt: skip
    return chosen, flags


def _displacement(table: TextTable, taken: set[int], stiffness: float | None) -> tuple[int, str] | None:
    """The column of a position and, where there was a choice, why it was taken; None: the names of prepared tables."""
    prepared = NAMES.named(table, "delta")
    candidates = [(i, kind) for i, kind in positions(table) if i not in taken and i not in prepared]
    if not candidates or any(plain(table.names[i]) == "delta" for i in prepared):
        return None
    device = next((i for i, kind in candidates if kind.device), None)
    tip = prepared[0] if prepared else next((i for i, kind in candidates if not kind.device), None)
    if device is None or tip is None:
        return None if prepared else (candidates[0][0], "")
    if stiffness == math.inf:
        return None if prepared else (tip, "")
    if stiffness is not None:
        return device, f"the piezo position z was taken, not {numbered(table, tip)}: its stiffness is known"
    why = f"the position of the tip was taken, not {numbered(table, device)}: the stiffness of the device is not known"
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
        remedy = "; several curves in one file need their column: --column curve=NAME" if alone else ""
        raise InputError(f"{where}: line {lines[i]}: time must not run back, it falls from {values['t'][i - 1]:g} to "
                         f"{values['t'][i]:g} s{remedy}")  # fmt: skip

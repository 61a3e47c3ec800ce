"""One decision for files that are read together: sign of the displacement, constants of the device, units.

Curves of one instrument are written alike. What a single file leaves open, as the direction of a column "z", or lacks,
as the spring constant in its header, all of them settle together; a file that deviates is named.
"""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..base.errors import InputError, counted
from ..tables import split_name
from .curve import NOT_SUBTRACTED, TURNED, Curve, Reading
from .files import usable
from .grids import placed
from .instruments import toward

SHOWN = 5  # choice: names in a sentence
CLEAR = 30.0  # choice: standard deviations of the noise, from which on a load tells on which side the specimen is
MIXED = 0.1  # choice: share of the files that may deviate; of more the files are refused together
LEAST_VOTES = 5  # choice: files that must agree before the sign of a column's name is overruled
UNIT_APART = 300.0  # choice: ratio of the ways of two files beyond which one of their units is taken to be wrong
CONSTANT = re.compile(r"\b(stiffness|sensitivity) ([-+.\de]+) (?:N/m|m/V)")  # in a flag of a curve
WITH_ERROR = re.compile(r"\b(stiffness|sensitivity) \S+ (?:N/m|m/V) ± (\S+) %")  # of a constant in a header
OF_COLUMN = re.compile(r'displacement from column \d+ "([^"]*)"')
AS_OTHERS = "sign as in the other files"


@dataclass(frozen=True)
class Batch:
    """What was read of each path: its curves and lines on what could not be; ``notes`` on what was settled, ``places``:
    by what the curves of each path lie on a grid, "" where they do on none."""

    read: Sequence[tuple[list[Curve], list[str]]]
    notes: tuple[str, ...] = ()
    places: tuple[str, ...] = ()


def read_batch(paths: Sequence[Path], reading: Reading, grid: tuple[int, int] | None = None) -> Batch:
    """The curves at all paths, by one decision on sign, constants and units, those of maps on their grids, of columns
    and rows as specified; InputError, with the remedy, where the files contradict each other."""
    notes = list[str]()
    read = [_with_constants(path, *usable([path], reading), reading, notes) for path in paths]
    curves = [curve for found, _ in read for curve in found]
    signs = {} if "delta" in reading.flip else _signs(curves, notes)
    odd = dict(_odd(curves, "delta", reading)) | dict(_odd(curves, "P", reading))
    settled, places = list[tuple[list[Curve], list[str]]](), list[str]()
    for path, (found, lines) in zip(paths, read, strict=True):
        kept = [_turned(one) if signs.get(id(one)) else one for one in found if id(one) not in odd]
        kept, words = placed(path, kept, grid)
        settled.append((kept, [*lines, *(odd[id(one)] for one in found if id(one) in odd)]))
        places.append(words)
    return Batch(settled, tuple(notes), tuple(places))


def _names(places: Sequence[str]) -> str:
    more = len(places) - SHOWN
    return ", ".join(places[:SHOWN]) + (f" and {more} more" if more > 0 else "")


# ---------------------------------------------------------------------- constants of the device
def header_errors(curves: Sequence[Curve]) -> dict[str, float]:
    """The largest relative standard error of each constant that headers name with one, where all curves are of a device
    with a stiffness, whose loads it changes."""
    found = dict[str, float]()
    if all(one.stiffness not in (None, math.inf) for one in curves):
        for name, size in (pair for one in curves for flag in one.flags for pair in WITH_ERROR.findall(flag)):
            found[name] = max(found.get(name, 0.0), float(size) / 100)
    return found


def constants_apart(curves: Sequence[Curve], sample: Sequence[str]) -> list[str]:
    """The constants of the device that headers name differently in the samples, or within one: errors of different
    cantilevers."""
    found = defaultdict[str, set[float]](set)
    for name, value in (pair for one in curves if sample for flag in one.flags for pair in CONSTANT.findall(flag)):
        found[name].add(float(value))
    return [name for name, values in found.items() if len(values) > 1]


def _with_constants(
    path: Path, curves: list[Curve], lines: list[str], reading: Reading, notes: list[str]
) -> tuple[list[Curve], list[str]]:
    """What was read of a ``path``, files that lack a constant of the device read again with that which all others
    name; InputError where these name different ones."""
    found = defaultdict[str, set[float]](set)
    for name, value in (pair for one in curves for flag in one.flags for pair in CONSTANT.findall(flag)):
        found[name].add(float(value))
    lacking = {str(one.origin) for one in curves if NOT_SUBTRACTED in one.flags}
    refused = {line.split(": ")[0] for line in lines if re.search(r"give --(stiffness|sensitivity)", line)}
    if not found or not path.is_dir() or not (again := sorted(lacking | refused)):
        return curves, lines
    for name, values in found.items():
        if len(values) > 1:
            others = ", ".join(f"{value:g}" for value in sorted(values)[:SHOWN])
            lack = f"{counted(len(again), 'file')} {'lack' if len(again) > 1 else 'lacks'}"
            raise InputError(f"{path}: {lack} the {name} ({_names(again)}), the others name {others}: give --{name}")
    constants: dict[str, Any] = {name: values.pop() for name, values in found.items()}
    more, unread = list[Curve](), list[str]()
    for file in map(Path, again):
        some, left = usable([file], replace(reading, **constants))
        more, unread = more + some, unread + left
    words = ", ".join(f"{name} {value:g}" for name, value in constants.items())
    notes.append(f"{words} of the other files taken for {counted(len(again), 'file')} without: {_names(again)}")
    by_place = {one.where: one for one in more}
    kept = [by_place.pop(one.where, one) for one in curves]
    return [*kept, *by_place.values()], [line for line in lines if line.split(": ")[0] not in refused] + unread


# ---------------------------------------------------------------------- the sign of the displacement
def _signs(curves: Sequence[Curve], notes: list[str]) -> dict[int, bool]:
    """Whether each curve's displacement is to be turned, by its id, so that all of one column have one sign; InputError
    where files contradict each other."""
    groups = defaultdict[str, list[Curve]](list)
    for one in curves:
        if (title := next(filter(None, map(OF_COLUMN.match, one.flags)), None)) and {"delta", "P"} <= set(one.measured):
            groups[split_name(title[1])[0]].append(one)
    turned = dict[int, bool]()
    for name, alike in groups.items():
        read = np.array([-1 if any(TURNED in flag for flag in one.flags) else 1 for one in alike])
        votes = read * np.array([_vote(one) for one in alike])  # of the sign that the column itself has
        counts = {sign: int(np.count_nonzero(votes == sign)) for sign in (1, -1)}
        sign = max(counts, key=lambda each: (counts[each], int(np.count_nonzero(read == each))))
        if counts[sign] < LEAST_VOTES:
            continue  # each as it was read
        if counts[-sign] > max(1, MIXED * counts[sign]):
            others = [one.where for one, vote in zip(alike, votes, strict=True) if vote == -sign]
            ways = ("toward", "away from")[::sign]
            raise InputError(f'"{name}" increases {ways[0]} the specimen in {counts[sign]} files and {ways[1]} it in '
                             f"{len(others)} ({_names(others)}): put these into a folder of their own")  # fmt: skip
        changed = [one for one, each in zip(alike, read, strict=True) if each != sign]
        turned |= {id(one): True for one in changed}
        if changed:
            what = "all files" if len(changed) == len(alike) else _names([one.where for one in changed])
            way = "toward" if sign > 0 else "away from"
            notes.append(f'"{name}" increases {way} the specimen, as {counts[sign]} files show: sign changed in {what}')
    return turned


def _vote(curve: Curve) -> int:
    """1 where the load shows that the device moves toward the specimen as its position grows, -1 away; 0: it shows
    neither, as noise alone does not."""
    z, P = curve.device, curve.load
    noise = float(np.median(np.abs(np.diff(P)))) / 0.954  # theory: of white noise, of differences
    low, way = float(z.min()), float(np.ptp(z))
    ends = (P[z <= low + way / 10], P[z >= low + 9 * way / 10])
    if np.ptp(P) <= CLEAR * noise or not any(end.size > 1 and np.ptp(end) < np.ptp(P) / 10 for end in ends):
        return 0
    return 1 if toward(z, P) else -1


def _turned(curve: Curve) -> Curve:
    """The curve with the other sign of the device's position."""
    delta = -curve.device - (0.0 if curve.stiffness is None else curve.load / curve.stiffness)
    words = f"{TURNED}: {AS_OTHERS}"
    flags = tuple(re.sub(rf"{TURNED}.*|, sign unchanged", f", {AS_OTHERS}" if TURNED in flag else words, flag)
                  if OF_COLUMN.match(flag) else flag for flag in curve.flags)  # fmt: skip
    return replace(curve, delta=delta, flags=flags)


# ---------------------------------------------------------------------- units
def _odd(curves: Sequence[Curve], name: str, reading: Reading) -> Iterator[tuple[int, str]]:
    read = [(one, one.device if name == "delta" and one.P is not None else one.column(name))
            for one in curves if name in one.measured]  # fmt: skip
    spans = {id(one): float(np.ptp(values)) for one, values in read}
    if len(spans) < LEAST_VOTES or name in reading.units:
        return
    usual = float(np.median([*spans.values()]))
    odd = [one for one in curves if usual and spans.get(id(one)) and not
           1 / UNIT_APART < spans[id(one)] / usual < UNIT_APART and (name == "delta" or _vote(one))]  # fmt: skip
    for one in odd if len(odd) <= MIXED * len(spans) else []:
        ratio = spans[id(one)] / usual
        words = f"its {name} spans {ratio:.1g} times that of the other files: is the unit wrong?"
        yield id(one), f"{one.where}: {words} Fit it alone with --unit {name}=UNIT"

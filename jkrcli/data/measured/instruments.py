"""What instruments write: positions with their sign, deflections, words for directions, a spring constant in the
head."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...base import Array
from ...tables.text_table import MOST_COLUMNS, TextTable
from ...tables.titles import LONGEST, WORDS, split_name, unit_power
from .curve import APPROACH, RETRACT

VOLTS = {"V": 0, "mV": -3, "uV": -6}
DIRECTIONS, OTHERS = ({word: way for way in (APPROACH, RETRACT) for word in WORDS[kind][way]}
                      for kind in ("directions", "cells"))  # fmt: skip
SEGMENTS = DIRECTIONS | OTHERS  # of cells and notes
HOLDS, BESIDE = WORDS["notes"]["holds"], WORDS["notes"]["beside"]
DEPTHS, DEFLECTIONS = WORDS["instruments"]["depths"], WORDS["instruments"]["deflections"]
WHOLE = WORDS["measured"]["also"]["t"]  # times of a record whose segments have their own too
ENDS = 0.1  # choice: of a range, what is an end of the way, and up to which a load is free
NUMBER = r"([-+]?[\d.]+(?:[eE][-+]?\d+)?)"


@dataclass(frozen=True)
class Position:
    """A kind of displacement: its ``noun``, its ``sign`` (1 toward the specimen, -1 away from it, 0 either), whether it
    is that of the ``device``, not of the tip, and the ``names`` of such columns, lower case, the better ones first."""

    noun: str
    sign: int
    device: bool
    names: Sequence[str]


POSITIONS = tuple(Position(**entry) for entry in WORDS["positions"])


def plain(title: str) -> str:
    """The name in a header cell, lower case, its words parted by single blanks."""
    return re.sub(r"[\s_.-]+", " ", split_name(title)[0].lower()).strip()


def position_of(title: str) -> Position | None:
    """What kind of displacement a header cell names, beside those of prepared tables."""
    return next((kind for kind in POSITIONS if plain(title) in kind.names), None)


def positions(table: TextTable) -> list[tuple[int, Position]]:
    """Index and kind of the columns that hold a position, those of the device first, the better ones first."""
    titles = [plain(title) for title in table.names]
    lengths = [(unit_power(split_name(title)[1]) or ("", 0))[0] == "length" for title in table.names]

    def best(name: str) -> int:  # of several of a name, as in volts and in nanometres, that of a length
        return next((i for i, title in enumerate(titles) if title == name and lengths[i]), titles.index(name))

    return [(best(name), kind) for kind in POSITIONS for name in kind.names if name in titles]


def deflection(table: TextTable) -> int | None:
    """The column of the cantilever's deflection, as a force rather than in metres, and so rather than in volts; None
    where there is none."""

    def rank(index: int) -> int:
        dimension, _ = unit_power(split_name(table.names[index])[1]) or ("", 0)
        return {"load": 0, "length": 1}.get(dimension, 2)

    return min((i for i, title in enumerate(table.names) if is_deflection(title)), key=rank, default=None)


def is_deflection(title: str) -> bool:
    """Whether a header cell names the deflection of a cantilever."""
    return plain(title) in DEFLECTIONS


def toward(z: Array, P: Array) -> bool:
    """Whether ``z`` grows toward the specimen: where the load is largest it is in the upper half of its range.

    Where most of the loads are nearly as large, as the free rows of a record that turns under tension, the end of the
    way at which the load varies more is that at the specimen.
    """
    high, low, way = P >= P.min() + 0.9 * np.ptp(P), float(z.min()), float(np.ptp(z))
    if np.count_nonzero(high) <= 0.5 * P.size:
        return float(np.median(z[high])) >= low + way / 2
    return float(np.std(P[z >= low + 0.9 * way])) >= float(np.std(P[z <= low + 0.1 * way]))


def presses_outward(z: Array, P: Array) -> bool:
    """Whether a record of one direction presses most where ``z``, positive into the specimen, is least and is free over
    its deepest third: then z counts the other way round."""
    way, whole = float(np.ptp(z)), float(np.ptp(P))
    if abs(float(z[-1] - z[0])) < (1 - ENDS) * way or whole == 0:
        return False
    deep, least = z >= z.max() - way / 3, z <= z.min() + ENDS * way
    free = P[deep]
    return float(np.ptp(free)) < ENDS * whole and float(P[least].max() - np.median(free)) > whole / 2


def segment_of(line: str) -> str | None:
    """The word for a segment in a line of its own, "# segment: retract", "[Retract]" or "Approach data:"."""
    if len(line) > LONGEST:
        return None
    if match := re.match(r"\W*(?:segment(?:[ _]?name)?|direction)\s*[:=]\s*\"?([^\W\d]\w*)", line, re.IGNORECASE):
        return match[1]
    words = re.findall(r"\w+", line.lower())
    named = [word for word in words if word in DIRECTIONS or word in HOLDS]
    others = [word for word in words if word not in named and word not in BESIDE and not word.isdigit()]
    return named[0] if len(named) == 1 and not others and not re.match(r"\s*[-+.\d]", line) else None


def constants(head: tuple[str, ...]) -> Mapping[str, float]:
    """Spring constant "stiffness" [N/m] and "sensitivity" [m/V] that the head of a file names; in the words of JPK and
    Bruker a bare 1 stands for unknown."""
    values: dict[str, float] = {}
    for whole in head[:MOST_COLUMNS]:
        line = re.sub(r"\s+", lambda blank: "\t" if "\t" in blank[0] else " ", whole)
        if len(line) > LONGEST:
            continue
        of_program = line
        if match := re.match(r"\W*(springConstant|sensitivity)\s*:\s*([-+.\deE]+)\s*\Z", line):  # of JPK, always SI
            line = f"{match[1]}: {match[2]} {'N/m' if match[1] == 'springConstant' else 'm/V'}"
        if match := re.match(rf"\W*(Spring Constant|Sens\. DeflSens):\s*(?:V\s+)?{NUMBER}(?:\s*nm/V)?\W*\Z", line):
            line = f"spring constant: {match[2]} N/m" if "Spring" in match[1] else f"sensitivity: {match[2]} nm/V"
        if match := re.match(r"\W*([A-Za-z][A-Za-z ]*?)\s*[:=]\s*([-+.,\deE]+)\s*\Z", line):  # bare: N/m
            line = f"{match[0]} N/m" if plain(match[1]) in WORDS["constants"]["stiffness"] else line
        match = re.match(r'[\W_]*(.*?)\s*[,:=\t;]?\s*[\[(]?([a-zµμ]*[NmV]/[a-zµμ]*[mV])[\])]?[\s:=;,"]+(\S+)', line)
        match = match or re.match(r'[\W_]*(.*?)\s*[:=;,\t]\s*([-+.,\deE]+)\s*([a-zµμ]*[NmV]/[a-zµμ]*[mV])\s*"?\Z', line)
        if not match:
            continue
        name, unit, number = match.groups()
        if "/" in number:
            unit, number = number, unit
        try:
            value = float(number.strip('"').replace(",", "."))
            kind, size = _kind(unit)
        except (ValueError, KeyError):
            continue
        unknown = value == 1 and line != of_program  # what JPK and Bruker write where nothing was calibrated
        if plain(name) in WORDS["constants"].get(kind, ()) and value > 0 and not unknown:
            values.setdefault(kind, value * size)
    return values


def _kind(unit: str) -> tuple[str, float]:
    """What a unit such as nN/nm is one of, "stiffness" or "sensitivity", "" of neither, and its size in SI; KeyError
    where it is none."""
    above, below = unit.split("/")
    powers = []
    for part in (above, below):
        known = unit_power(part)
        powers.append(known[1] if known else VOLTS[part.replace("µ", "u").replace("μ", "u")])
    return {"Nm": "stiffness", "mV": "sensitivity"}.get(above[-1:] + below[-1:], ""), 10.0 ** (powers[0] - powers[1])

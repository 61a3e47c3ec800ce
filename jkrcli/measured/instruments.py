"""What instruments write: positions with their sign, deflections, words for directions, a spring constant in the
head.
"""

import contextlib
import re
import struct
import zipfile
import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import numpy as np

from ..base import process
from ..base.errors import InputError, first_line
from ..base.files import opened
from ..base.numerics import Array
from ..base.process import check_size
from ..tables import LONGEST, WORDS, split_name, unit_power
from ..tables.text import MOST_COLUMNS, PIECE, TextTable
from .curve import APPROACH, RETRACT, Pixel

VOLTS = {"V": 0, "mV": -3, "uV": -6}
DIRECTIONS, OTHERS = ({word: way for way in (APPROACH, RETRACT) for word in WORDS[kind][way]}
                      for kind in ("directions", "cells"))  # fmt: skip
SEGMENTS = DIRECTIONS | OTHERS  # of cells and notes
HOLDS, BESIDE = WORDS["notes"]["holds"], WORDS["notes"]["beside"]
DEPTHS, DEFLECTIONS = WORDS["instruments"]["depths"], WORDS["instruments"]["deflections"]
WHOLE = WORDS["measured"]["also"]["t"]  # times of a record whose segments have their own too
ENDS = 0.1  # choice: of a range, what is an end of the way, and up to which a load is free
NUMBER = r"([-+]?[\d.]+(?:[eE][-+]?\d+)?)"
# A number with its error; and a line for the error of what is named before
WITH_ERROR = re.compile(rf"(?<![\d.]){NUMBER}\s*(?:±|\+/?-)\s*([\d.]+(?:[eE][-+]?\d+)?)\s*(%)?\s*")
OF_ERROR = re.compile(rf"\W*(.*?)[\s_-]*(?:error|uncertainty|std)\s*[:=]\s*{NUMBER}\s*(%|\S+/\S+)\s*\Z", re.IGNORECASE)
# "# x: 1.5 um", "X Position [nm] = 3", and of JPK "# xPosition: 1.2e-06", which is SI
OF_HEAD = re.compile(
    rf"\W*([xy])[ _-]*(position|pos|offset)?\s*(?:[\[(]\s*(\S+?)\s*[\])])?\s*[:=]\s*{NUMBER}\s*(\S*?)\W*\Z",
    re.IGNORECASE)  # fmt: skip
SAMPLE = re.compile(r"\W*sample(?:[ _-]?name)?\s*[:=]\s*(.*?\w.*?)\W*\Z", re.IGNORECASE)


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
    """The name in a header cell, lower case, its words parted by single blanks, without a word on how it was made
    before them, "Raw Height Sensor" or "calibrated height"."""
    name = re.sub(r"[\s_.-]+", " ", split_name(title)[0].lower()).strip()
    return re.sub(r"\A(?:raw|calibrated|smoothed|filtered|corrected)\s(?=\w)", "", name)


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


def constants(head: Sequence[str]) -> Mapping[str, float]:
    """Spring constant "stiffness" [N/m] and "sensitivity" [m/V] that the head of a file names; in the words of JPK and
    Bruker a bare 1 stands for unknown."""
    values: dict[str, float] = {}
    for whole in head[:MOST_COLUMNS]:
        line = WITH_ERROR.sub(r"\1 ", re.sub(r"\s+", lambda blank: "\t" if "\t" in blank[0] else " ", whole))
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
            # What a unit such as nN/nm is one of, "stiffness" or "sensitivity", "" of neither, and its size in SI;
            # KeyError where it is none.
            above, below = unit.split("/")
            powers = []
            for part in (above, below):
                known = unit_power(part)
                powers.append(known[1] if known else VOLTS[part.replace("µ", "u").replace("μ", "u")])
            kind, size = (
                {"Nm": "stiffness", "mV": "sensitivity"}.get(above[-1:] + below[-1:], ""),
                10.0 ** (powers[0] - powers[1]),
            )
        except (ValueError, KeyError):
            continue
        unknown = value == 1 and line != of_program  # what JPK and Bruker write where nothing was calibrated
        if plain(name) in WORDS["constants"].get(kind, ()) and value > 0 and not unknown:
            values.setdefault(kind, value * size)
    return values


def constant_errors(head: Sequence[str]) -> Mapping[str, float]:
    """Relative standard errors of the ``constants`` that the head of a file names: behind the number, "0.30 ± 0.02
    N/m", or on a line of their own, "spring constant error: 5 %"."""
    errors: dict[str, float] = {}
    known = constants(head)
    for line in (line for line in head[:MOST_COLUMNS] if len(line) <= LONGEST):
        if match := WITH_ERROR.search(line):
            errors |= {name: float(match[2]) / (100 if match[3] else float(match[1])) for name in constants([line])}
        elif match := OF_ERROR.match(line):
            name, number, unit = match.groups()
            for kind, names in WORDS["constants"].items():
                size = constants([f"{names[0]}: {number} {unit}"]).get(kind) if unit != "%" else None
                if plain(name) in names and kind in known and (unit == "%" or size):
                    errors[kind] = float(number) / 100 if size is None else size / known[kind]
    return errors


def position_in(head: Sequence[str]) -> Pixel | None:
    """The position that the header of a file names [m], in a grid that is not known yet; None where it names none."""
    found: dict[str, float] = {}
    for line in head[:MOST_COLUMNS]:
        if len(line) <= LONGEST and (match := OF_HEAD.match(line.strip())):
            axis, of_program, unit, number, behind = match.groups()
            known = unit_power(unit or behind or ("m" if of_program else ""))
            if known is not None and known[0] == "length":
                found.setdefault(axis.lower(), float(number) * 10.0 ** known[1])
    return Pixel(0, 0, found["x"], found["y"]) if len(found) == 2 else None


def sample_in(head: Sequence[str]) -> str:
    """The sample that the header of a file names, "# sample: ctrl"; "" where it names none."""
    lines = (SAMPLE.match(line) for line in head[:MOST_COLUMNS] if len(line) <= LONGEST)
    return next((match[1] for match in lines if match), "")


# --------------------------------------------------------------------------------------------------
# Zip archives as instruments write them: their members one by one, proved against their checksums, none unpacked to
# disk.

ENDINGS = (".txt", ".csv", ".tsv", ".dat", ".asc", ".tab")
LONGEST_END = (1 << 16) + 200  # theory: bytes of the records at the end, with the comment that may follow
ENTRY = b"PK\1\2"  # how a member begins in the list of members
PACKED = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # the others unpack without a limit, bzip2 a million times as much
WRONG = (OSError, RuntimeError, EOFError, ValueError, KeyError, struct.error, zipfile.BadZipFile, zlib.error)  # damage


class NoTablesError(InputError):
    """An archive that holds no text table."""


def members(path: Path, size: int | None = None, chosen: Callable[[str], bool] = bool) -> list[zipfile.ZipInfo]:
    """The members of an archive with ``chosen`` names; InputError where it is damaged, would unpack to more than
    ``size`` bytes (None: what is allowed of any file), or holds one of them twice."""
    with opened(path, "zip archive") as whole:  # counted before their list is made
        check_size(path, process.PART * sum(piece.count(ENTRY) for piece in iter(lambda: whole.read(PIECE), b"")))
    with _opened(path) as file:
        listed = file.infolist()
    wanted = [item for item in listed if chosen(item.filename)]
    check_size(path, sum(item.file_size for item in wanted), size)
    # How many the archive says that it holds, at its end (APPNOTE of the format, 4.3.14 and 4.3.16)
    with opened(path, "zip archive") as whole:
        whole.seek(max(0, whole.seek(0, 2) - LONGEST_END))
        end = whole.read()
    at, long = end.rfind(b"PK\5\6"), end.rfind(b"PK\6\6")
    declared = int.from_bytes(end[at + 10 : at + 12] if long < 0 else end[long + 32 : long + 40], "little")
    if len(listed) != declared:
        raise InputError(f"{path}: is damaged: its list holds {len(listed):,} members of {declared:,}")
    name, times = next(iter(Counter(item.filename for item in wanted).most_common(1)), ("", 0))
    if times > 1:
        raise InputError(f"{path}: holds {name} {times} times")
    return wanted


def tables(path: Path) -> list[zipfile.ZipInfo]:
    """The text tables of an archive; InputError where there are none, or as ``members`` does."""
    if inside := members(path, process.TEXT, _is_table):
        return inside
    raise NoTablesError(f"{path}: holds no text table ({', '.join(ENDINGS)})")


def contents(path: Path, chosen: Sequence[zipfile.ZipInfo], most: int | None = None) -> Iterator[bytes]:
    """The contents of members, or ``most`` bytes from their begin, one after the other; InputError where one does not
    hold what its checksum and size say."""
    for content in each_content(path, chosen, most):
        if isinstance(content, InputError):
            raise content
        yield content


def each_content(
    path: Path, chosen: Sequence[zipfile.ZipInfo], most: int | None = None
) -> Iterator[bytes | InputError]:
    """The same, but that of a damaged member comes as its error, and the others follow."""
    with _opened(path) as file:
        for item in chosen:
            content: bytes | InputError
            try:
                content = _unpacked(file, item, most)
            except WRONG as error:
                content = InputError(f"{path}: {item.filename} cannot be unpacked ({first_line(error)})")
            yield content


def titles(chosen: Sequence[zipfile.ZipInfo]) -> list[str]:
    """What tables are called: by their names without folder and ending, unless these are not unique."""
    stems = [PurePosixPath(item.filename).stem for item in chosen]
    whole = [str(PurePosixPath(item.filename).with_suffix("")) for item in chosen]
    return stems if len(set(stems)) == len(stems) else whole


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[zipfile.ZipFile]:
    with opened(path, "zip archive") as whole:
        try:
            file = zipfile.ZipFile(whole)
        except WRONG as error:
            raise InputError(f"{path}: cannot be read as a zip archive ({first_line(error)})") from None
        with file:
            yield file


def _unpacked(file: zipfile.ZipFile, item: zipfile.ZipInfo, most: int | None) -> bytes:
    """The content of a member, no more than the size in its head: read in pieces, else all that it unpacks to would
    come before the cut."""
    if item.compress_type not in PACKED:
        raise NotImplementedError("neither stored nor deflated: pack it anew")
    with file.open(item) as packed:
        if most is not None:
            return packed.read(most)
        content = b"".join(iter(lambda: packed.read(PIECE), b""))
    if len(content) != item.file_size:
        raise EOFError(f"holds {len(content):,} bytes of {item.file_size:,}")
    return content


def _is_table(name: str) -> bool:
    path = PurePosixPath(name)
    hidden = any(part.startswith((".", "__MACOSX")) for part in path.parts)
    return path.suffix.lower() in ENDINGS and not hidden and not name.endswith("/")

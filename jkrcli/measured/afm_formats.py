"""Force curves of force microscopes, read by the optional package afmformats: the one door to it."""

import contextlib
import logging
import math
import re
import struct
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

from ..base import hdf5, process
from ..base.errors import InputError, counted, first_line, installs
from ..base.files import opened, packed, read_bytes
from ..base.numerics import LOOKED_AT, Array
from ..base.process import check_size, check_text
from ..base.units import LARGEST_SI
from ..tables import unit_power
from ..tables.text import BYTES_USUAL, PIECE, rows_among, rows_of_text
from . import instruments
from .curve import APPROACH, ARBITRARY, LEAST_ROWS, RETRACT, AsRead, Curve, Pixel, Reading, place
from .formats import Format, register
from .instruments import toward

# --------------------------------------------------------------------------------------------------
# Force curves and maps of Bruker's Nanoscope (.spm, .000, .pfc): lines of "\key: value", then whole numbers.
#
# A channel ("\*Ciao force image list") holds of each curve the approach and the retraction, both from the turning
# point outward. Its "Z scale" names the volts of a count and the sensitivity, which stands elsewhere in the head
# (Nanoscope 8.10 User Guide, "General Format for CIAO Parameter Objects"). No checksums: a cut is found by the
# declared lengths.

WHAT = "Nanoscope file"
BEGINS, CHANNEL, ENDS = b"\\*Force file list", "Ciao force image list", b"\\*File list end"
BINARY = b"\x1a"  # ends the head of a binary file; exports in text go on with a table
AGAIN = "copy it again from the microscope"
DEFLECTION, SENSOR = "DeflectionError", "ZSensor"
NUMBER = r"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?"

Section = Mapping[str, str]
Item = TypeVar("Item")


def knows(path: Path) -> bool:
    """Whether the file begins and goes on as a binary one of the Nanoscope."""
    if not path.is_file():
        return False
    with opened(path, WHAT) as file:
        return file.read(len(BEGINS)) == BEGINS and BINARY in file.read(process.TEXT)


def nanoscope_curves(path: Path, reading: Reading) -> Iterator[AsRead]:
    """The curves of the file with the spring constant of their lever [N/m]; ``delta`` is the position of the piezo
    toward the specimen."""
    reading.check_known_columns(path)
    content = read_bytes(path, WHAT)
    file = File(path, content)
    check_size(path, len(content) + process.PART * file.count)
    (stiffness, sensitivity), flags = file.calibration(reading)
    per_volt = stiffness * sensitivity
    yield from _wanted(
        path, reading, range(file.count), lambda name, number: (file.curve(name, number, per_volt, flags), stiffness)
    )


def _wanted(
    path: Path, reading: Reading, items: Sequence[Item], read: Callable[[str, Item], tuple[Curve, float]]
) -> Iterator[AsRead]:
    """What is ``read`` of each curve of a file by its name, the file's where it is alone, if it is wanted."""
    for number, item in enumerate(items):
        name = path.stem if len(items) == 1 else str(number)
        if not reading.wants(name):
            yield name, None
            continue
        try:
            curve, stiffness = read(name, item)
            yield curve.multiplied(reading.factors), stiffness
        except InputError as error:
            yield error, None


@dataclass(frozen=True, eq=False)
class File:
    """The parts of a file, from its ``content``: a head of sections, and the counts of channels."""

    path: Path
    content: bytes

    @cached_property
    def sections(self) -> Sequence[tuple[str, Section]]:
        """Title and entries of each section of the head; keys lower case, without the number of a group ("@4:Z
        scale")."""
        head, end, _ = self.content.partition(BINARY)
        if ENDS not in head or not end:
            raise InputError(f"{self.path}: is damaged or cut off: its head does not end: {AGAIN}")
        sections: list[tuple[str, dict[str, str]]] = []
        for line in head.decode("cp1252", errors="replace").splitlines():
            if line.startswith("\\*"):
                sections.append((line[2:].strip(), {}))
            elif match := re.match(r"\\(?:@(?:\d+:)?)?([^:]+):\s*(.*)", line):
                sections[-1][1].setdefault(match[1].strip().lower(), match[2].strip())
        return sections

    @cached_property
    def channels(self) -> Mapping[str, tuple[Section, Array]]:
        """Head and counts (curves, direction, rows) of each channel by its name."""
        channels: dict[str, tuple[Section, Array]] = {}
        for title, section in self.sections:
            if title == CHANNEL:
                channels.setdefault(_name(section), (section, self._counts(section)))
        if not channels:
            raise InputError(f"{self.path}: is a Nanoscope file without force curves (it holds images)")
        if DEFLECTION not in channels:
            raise InputError(f"{self.path}: holds no deflection (channels: {', '.join(channels)})")
        return channels

    @property
    def samples(self) -> tuple[int, tuple[int, int]]:
        """How many rows each direction has room for, and how many of approach and retraction are filled."""
        numbers = [int(word) for word in re.findall(r"\d{1,9}", self._of(CHANNEL).get("samps/line", ""))]
        retrace = re.findall(r"\d{1,9}", self._of("Ciao force list").get("samps/line, retrace", ""))
        if not numbers or min(numbers) < 1:
            raise InputError(f"{self.path}: is damaged: names no rows of its curves (Samps/line): {AGAIN}")
        stride = max(numbers)
        return stride, (numbers[-1], min(int(retrace[0]), stride) if retrace else numbers[-1])

    @property
    def count(self) -> int:
        """How many curves the file holds."""
        return len(self.channels[DEFLECTION][1])

    @cached_property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the map, of a file of one curve 1 and 1."""
        scan = self._of("Ciao scan list")
        if "volume" not in scan.get("operating mode", "").lower() and not self.is_capture:
            return 1, 1
        lines, samples = int(self._number(scan, "lines")), int(self._number(scan, "samps/line"))
        each = re.match(r"\d{1,9}", self._of("Ciao force list").get("force/line", ""))
        columns = int(each[0]) if each and not self.is_capture else 0
        if columns in (0, samples) or samples == 0:
            return lines, samples
        # curves are fewer than the pixels of the image, in as many lines as its aspect leaves, or in a square
        shapes = [(max(round(lines * columns / samples), 1), columns), (columns, columns), (lines, samples)]
        channels = (section for title, section in self.sections if title == CHANNEL and _name(section) == DEFLECTION)
        sizes = [int(self._number(section, "data length")) for section in channels]
        of_counts = [{bytes_each * 2 * self.samples[0] * math.prod(shape) for bytes_each in (2, 4)} for shape in shapes]
        fitting = [shape for shape, known in zip(shapes, of_counts, strict=True) if known & set(sizes)]
        return fitting[0] if fitting else shapes[0]

    @property
    def is_capture(self) -> bool:
        """Whether the file is a capture of curves at the frequency of PeakForce."""
        return self._of("Ciao scan list").get("peakforce capture", "").lower() == "allow"

    def calibration(self, reading: Reading) -> tuple[list[float], tuple[str, ...]]:
        """Spring constant [N/m] and sensitivity [m/V] of the user, else of the file, and flags on their origin."""
        section, _ = self.channels[DEFLECTION]
        spring = re.match(NUMBER, section.get("spring constant", ""))
        per_volt = self._per_volt(section.get("z scale", ""))
        of_file = {"stiffness": float(spring[0]) if spring else 0.0, "sensitivity": per_volt}
        return _calibrated(self.path, reading, of_file)

    def curve(self, name: str, number: int, per_volt: float, calibration: tuple[str, ...]) -> Curve:
        """The curve of one ``number``; ``per_volt`` [N/V]."""
        where = place(self.path, name)
        volts, finer = self._volts(DEFLECTION, number)
        P = volts * per_volt
        if P.size < LEAST_ROWS:
            raise InputError(f"{where}: holds {counted(P.size, 'row')}, at least {LEAST_ROWS} are needed")
        z, t, turn, what = self._motion(number, P)
        flags = (f"displacement from the {what}", *calibration, *finer)
        segment = np.where(np.arange(P.size) < turn, APPROACH, RETRACT)
        return Curve(name, delta=z, P=P, t=t, segment=segment, origin=self.path, flags=flags, pixel=self._pixel(number))

    def _motion(self, number: int, P: Array) -> tuple[Array, Array | None, int, str]:
        """Positions [m] toward the specimen, times [s], the row of the turning point, and what the positions are."""
        if self.is_capture:
            return self._oscillation(P.size)
        section, counts = self.channels[DEFLECTION]
        ramp = section.get("ramp size", "")
        if SENSOR in self.channels:
            z = self._volts(SENSOR, number)[0] * self._per_volt(self.channels[SENSOR][0].get("z scale", ""))
            z, what = z if toward(z, P) else -z, "height sensor"
        else:
            # Positions [m] of a piezo that moves in equal steps, the rows of the file over its range.
            # The ramp is in volts with their sensitivity, "V [Sens. Zsens] (0.0067 V/LSB) 151.48 V", or in nanometres.
            length, unit = _last(ramp)
            size = length * self._per_volt(ramp) if unit == "V" else _metres(length, unit)
            if not _is_size(size):
                raise InputError(f"{self.path}: names no ramp size, and no height sensor was recorded: {SURF_AGAIN}")
            steps = size / counts.shape[2] * np.arange(counts.shape[2])
            z, what = self._in_order(-np.stack([steps, steps])), "ramp of the piezo"
        # times by the speed of the piezo, without pauses, where the file names it
        force, t = self._of("Ciao force list"), None
        size, *speeds = (
            _last(entry)[0] for entry in (ramp, force.get("forward vel.", ""), force.get("reverse vel.", ""))
        )
        if all(map(_is_size, (size, *speeds))):
            steps = np.repeat([size / speed / counts.shape[2] for speed in speeds], self.samples[1])
            t = np.cumsum(steps) - steps[0]
        return z, t, self.samples[1][0], what

    def _oscillation(self, rows: int) -> tuple[Array, Array, int, str]:
        """Of a capture: the drive is a sine of the amplitude of PeakForce, deepest at the distance of synchronisation,
        which counts rows of the microscope's own curve."""
        scan = self._of("Ciao scan list")
        keys = ("peak force amplitude", "pft freq", "sample points", "sync distance qnm")
        numbers = []
        for key in keys:
            if not _is_size(number := self._number(scan, key)):
                raise InputError(f'{self.path}: is damaged or not read: its "{key}" must be positive, got {number:g}')
            numbers.append(number)
        amplitude, frequency, own, at = numbers
        deepest = at * rows / own
        phase = np.arange(rows) - deepest
        z = 1e-9 * amplitude * np.cos(2 * np.pi * phase / rows)
        t = np.arange(rows) / (1e3 * frequency * rows)
        return z, t, round(deepest), f"sine of the drive, {amplitude:g} nm at {frequency:g} kHz"

    def _in_order(self, halves: Array) -> Array:
        """Both directions one after the other as they were recorded, without rows that were not filled."""
        approach, retract = self.samples[1]
        return np.concatenate([halves[0, :approach][::-1], halves[1, :retract]])

    def _counts(self, section: Section) -> Array:
        """The counts of a channel (curves, direction, rows), as whole numbers of two or four bytes."""
        stride, _ = self.samples
        at, size = (int(self._number(section, key)) for key in ("data offset", "data length"))
        if at + size > len(self.content):
            raise InputError(f"{self.path}: is cut off: holds {len(self.content):,} bytes of {at + size:,}: {AGAIN}")
        count = math.prod(self.shape)
        each = 2 * stride * count
        if each == 0 or size not in (2 * each, 4 * each):
            rows = f"{counted(count, 'curve')} of 2 x {stride:,} rows, 2 or 4 bytes each: {SURF_AGAIN}"
            raise InputError(f"{self.path}: is damaged or of a layout that is not read: {size:,} bytes for {rows}")
        return np.frombuffer(self.content, f"<i{size // each}", each, at).reshape(-1, 2, stride)

    def _volts(self, channel: str, number: int) -> tuple[Array, tuple[str, ...]]:
        """The rows of a channel in volts. Some versions write whole counts shifted by a byte into four, which shows in
        their last."""
        section, counts = self.channels[channel]
        match = re.search(rf"\(({NUMBER}) V/LSB\)", section.get("z scale", ""))
        if match is None or not _is_size(float(match[1])):
            raise InputError(f"{self.path}: is damaged: names no scale of its {_name(section)}: {AGAIN}")
        ends = counts[number] & 0xFF
        shifted = counts.itemsize == 4 and bool(np.isin(ends, (0, 0xFF)).all()) and bool(counts[number].any())
        volts = self._in_order(counts[number]) * (float(match[1]) / 256 if shifted else float(match[1]))
        return volts, ("counts of four bytes, shifted by one, were read as such",) if shifted else ()

    def _per_volt(self, entry: str) -> float:
        """The sensitivity [m/V] that an entry names, "V [Sens. Zsens] ..."; some versions leave out its unit, nm/V; 0
        where the head lacks it, or has one of other units."""
        soft = re.search(r"\[(Sens\. [^\]]+)\]", entry)
        name = soft[1].lower() if soft else ""
        value = next((section[name] for _, section in self.sections if name and name in section), "")
        match = re.match(rf"V\s+({NUMBER})\s*(\S*)", value)
        fits = match and _is_size(float(match[1]))
        return _metres(float(match[1]), (match[2] or "nm/V").removesuffix("/V")) if match and fits else 0.0

    def _pixel(self, number: int) -> Pixel | None:
        """The place of a curve in a map, centred on the scan."""
        lines, columns = self.shape
        size, unit = _last(self._of("Ciao scan list").get("scan size", ""))
        unit = unit.replace("~", "u")
        if lines * columns == 1:
            return None
        row, column = divmod(number, columns)
        if unit_power(unit) is None:
            return Pixel(column, row)
        step = _metres(size, unit) / columns
        return Pixel(column, row, step * (column + 0.5 - columns / 2), step * (row + 0.5 - lines / 2))

    def _of(self, title: str) -> Section:
        """The first section of a ``title``; empty where there is none."""
        return next((section for name, section in self.sections if name == title), {})

    def _number(self, section: Section, key: str) -> float:
        match = re.match(NUMBER, section.get(key, ""))
        if match is None or not 0 <= float(match[0]) < 1e15:
            got = section.get(key, "")[:60]
            raise InputError(f'{self.path}: is damaged or not read: its "{key}" must be a number, got "{got}"')
        return float(match[0])


def _calibrated(path: Path, reading: Reading, of_file: Mapping[str, float]) -> tuple[list[float], tuple[str, ...]]:
    """Stiffness [N/m] and sensitivity [m/V] of the user, else those ``of_file``, and flags on their origin."""
    _refuse_rigid(path, reading)
    values, flags = [], []
    for key, told in of_file.items():
        size, unit = {"stiffness": (1.0, "N/m"), "sensitivity": (1e-9, "nm/V")}[key]
        of_user, there = getattr(reading, key), f"{told / size:g} {unit}"
        if of_user is not None:
            value, flag = of_user, f"{key} {of_user / size:g} {unit} as specified, the file says {there}"
        elif _is_size(told):
            value, flag = told, f"{key} {there} of the file"
        elif reading.incomplete:
            value, flag = 1.0, f"the file lacks its {key}: {ARBITRARY} --{key}"
        else:
            raise InputError(f"{path}: names no {key}: give --{key}")
        values.append(value)
        flags.append(flag)
    return values, tuple(flags)


def _refuse_rigid(path: Path, reading: Reading) -> None:
    if reading.stiffness == math.inf:
        raise InputError(f"{path}: is from a force microscope, whose cantilever bends: give its stiffness, not rigid")


def _name(section: Section) -> str:
    """What a channel holds: S [ZSensor] "Height Sensor"."""
    match = re.search(r"\[(\w+)\]", section.get("image data", ""))
    return match[1] if match else "unknown"


def _is_size(number: float) -> bool:
    """Whether a number of the head is one of a size that is measured, and no damage."""
    return 1 / LARGEST_SI < number < LARGEST_SI


def _last(entry: str) -> tuple[float, str]:
    """The last number of an entry, 0 where there is none, and its unit, "" where it has none."""
    match = re.search(rf"({NUMBER})\s*([^\s\d]*)\s*\Z", entry)
    return (float(match[1]), match[2]) if match else (0.0, "")


def _metres(number: float, unit: str) -> float:
    """A length [m]; 0 where the unit is of something else."""
    dimension, power = unit_power(unit) or ("", 0)
    return number * 10.0**power if dimension == "length" else 0.0


# --------------------------------------------------------------------------------------------------
# Force curves and maps of Nanosurf (.nhf), in HDF5: a group of each measurement, in it one of each segment with a
# dataset of each channel, the rows of all curves one after the other, and one beside with the rows of each curve.
#
# Whole numbers over the range of their type stand for values from "signal_calibration_min" to "..._max", the least for
# none. After the maker's reader in its Python package nanosurf (files of version 2), and openers that others published.

SURF, SURF_VERSION, SURF_AGAIN = "Nanosurf file", "nsf_file_version_major", "export it as text"
UNTRIED = "Nanosurf's layout is read as published, not tried on a real file"
HDF5_ENDINGS = (".nhf", ".h5-jpk")
SURF_Z, SURF_DEFLECTION, SURF_TIME = "Position Z", "Deflection", "Time"
SURF_UNITS = {SURF_Z: ("length",), SURF_DEFLECTION: ("volts", "length", "load"), SURF_TIME: ("time",)}
SURF_K, SURF_SENS = "spm_probe_calibration_spring_constant", "spm_probe_calibration_deflection_sensitivity"
SURF_KEYS = (
    "group_type", "segment_name", "rect_axis_size", SURF_K, SURF_SENS, "dataset_block_size_source",
    "dataset_block_size_id", "signal_name", "signal_data_pattern", "signal_calibration_unit", "signal_calibration_min",
    "signal_calibration_max",
)  # fmt: skip
SNAKE = "snake_bottom_left"  # of a map: the first line from left to right, the next one back

Channel = tuple[Any, Mapping[str, Any]]  # a dataset and its attributes
Segment = tuple[str, Mapping[str, Channel], Array]  # word, channels by name, the rows at which curves begin and end


def is_nanosurf(path: Path) -> bool:
    """Whether the file is one of Nanosurf, by its content; InputError where it is JPK's, which is not read."""
    if not path.is_file() or packed(path):
        return False
    with opened(path, SURF) as file:
        if file.read(len(hdf5.SIGNATURE)) != hdf5.SIGNATURE:
            return False
    names = hdf5.names_in(path)
    if path.suffix.lower() == ".h5-jpk" or any(re.fullmatch(r"Measurement_\d+", name) for name in names):
        why = "is a .h5-jpk file, whose force curves JPK has not documented"
        raise InputError(f"{path}: {why}: export it as .jpk-force or text")
    return SURF_VERSION in names or (path.suffix.lower() == ".nhf" and not names)


def nanosurf_curves(path: Path, reading: Reading) -> Iterator[AsRead]:
    """The curves of all spectroscopies of the file with the spring constant of their lever [N/m]; ``delta`` is the
    position of the piezo toward the specimen."""
    reading.check_known_columns(path)
    with hdf5.members_of(path, read_bytes(path, SURF), AGAIN) as (file, members):
        if (version := int(hdf5.attributes_among(file, [SURF_VERSION])[SURF_VERSION])) != 2:
            raise InputError(f"{path}: is a Nanosurf file of version {version}, version 2 is read: {SURF_AGAIN}")
        curves: list[tuple[Mapping[str, Any], Sequence[Segment], int]] = []
        for group in (members.member(file, name) for name in file):
            told = hdf5.attributes_among(group, SURF_KEYS)
            if hasattr(group, "keys") and told.get("group_type") == "spectroscopy":
                segments = list(_segments(path, group, members))
                if len({edges.size for *_, edges in segments}) != 1:
                    raise InputError(f"{path}: is damaged: its segments do not hold as many curves: {AGAIN}")
                curves += [(told, segments, number) for number in range(segments[0][2].size - 1)]
        if not curves:
            raise InputError(f"{path}: is a Nanosurf file without force curves (it holds images)")
        yield from _wanted(path, reading, curves, lambda name, one: _nanosurf_curve(path, name, *one, reading))


def _segments(path: Path, group: Any, members: hdf5.Members) -> Iterator[Segment]:
    for part in (members.member(group, name) for name in group):
        title = str(hdf5.attributes_among(part, SURF_KEYS).get("segment_name", ""))
        if not title or not hasattr(part, "keys"):
            continue
        beside = []
        for name in part:
            with contextlib.suppress(InputError):  # of a type that is not read, as no channel is
                data = members.member(part, name)
                beside += [(data, hdf5.attributes_among(data, SURF_KEYS))] if hasattr(data, "shape") else []
        channels = {told["signal_name"]: (data, told) for data, told in beside if "signal_name" in told}
        if missing := [name for name in (SURF_Z, SURF_DEFLECTION) if name not in channels]:
            raise InputError(f'{path}: its segment "{title}" holds no {missing[0]}: {SURF_AGAIN}')
        block = channels[SURF_Z][1].get("dataset_block_size_source", "")
        blocks = [data[()] for data, told in beside if told.get("dataset_block_size_id") == block]
        counts = np.array(blocks[0] if blocks else [channels[SURF_Z][0].size], dtype=int)
        if counts.min() < 0 or counts.sum() > min(channels[name][0].size for name in SURF_UNITS.keys() & channels):
            raise InputError(f"{path}: is cut off: its curves hold more rows than its channels: {AGAIN}")
        words = re.findall(r"\w+", title.lower())
        ways = [] if set(words) & set(instruments.HOLDS) else [w for w in words if w in instruments.DIRECTIONS]
        yield instruments.DIRECTIONS[ways[0]] if len(ways) == 1 else title, channels, np.cumsum([0, *counts])


def _nanosurf_curve(
    path: Path, name: str, told: Mapping[str, Any], segments: Sequence[Segment], number: int, reading: Reading
) -> tuple[Curve, float]:
    """The curve of one ``number`` in a measurement of which its attributes are ``told``, and its spring constant."""
    columns, dimension = {}, ""
    for channel in SURF_UNITS:
        if all(channel in channels for _, channels, _ in segments):
            parts = [_values(path, channel, channels[channel], *edges[number : number + 2])
                     for _, channels, edges in segments]  # fmt: skip
            columns[channel] = np.concatenate([values for values, _ in parts])
            dimension = parts[0][1] if channel == SURF_DEFLECTION else dimension
    words = np.concatenate([np.full(edges[number + 1] - edges[number], word) for word, _, edges in segments])
    measured = np.isfinite(list(columns.values())).all(axis=0)
    z, signal = columns[SURF_Z][measured], columns[SURF_DEFLECTION][measured]
    if z.size < LEAST_ROWS:
        raise InputError(f"{place(path, name)}: holds {counted(z.size, 'row')}, at least {LEAST_ROWS} are needed")
    k, sensitivity = (float(np.asarray(told.get(key, 0.0)).item()) for key in (SURF_K, SURF_SENS))
    of_file = {"stiffness": k, "sensitivity": sensitivity}
    if dimension != "volts" and not _is_size(sensitivity):  # it is not needed, and another's ratio to it unknown
        if reading.sensitivity is not None:
            raise InputError(f"{path}: {OWN_SENSITIVITY}")
        del of_file["sensitivity"]
    values, flags = _calibrated(path, reading, of_file)
    # of the constants that the file itself multiplied its volts with: how many times as large the user's are
    ratios = [value / told if _is_size(told) else 1.0 for value, told in zip(values, of_file.values(), strict=True)]
    factors = {"volts": values, "length": [values[0], *ratios[1:]], "load": ratios}
    P = math.prod(factors[dimension]) * signal
    t = columns[SURF_TIME][measured] if SURF_TIME in columns else None
    if t is not None and (np.diff(t) < 0).any():
        t, flags = None, (*flags, "its time runs back and was left out")
    delta, flags = z if toward(z, P) else -z, (f"displacement from the {SURF_Z}", *flags, UNTRIED)
    # The place of a curve in a square map; of others the published readers do not agree which side is first.
    pixel, sides = None, [int(side) for side in np.asarray(told.get("rect_axis_size", ())).reshape(-1)]
    pattern, side = segments[0][1][SURF_Z][1].get("signal_data_pattern"), max(sides, default=1)
    if pattern == SNAKE and side != 1 and sides == [side, side] and segments[0][2].size == side**2 + 1:
        row, along = divmod(number, side)
        pixel = Pixel(side - 1 - along if row % 2 else along, row)
    curve = Curve(name, delta=delta, P=P, t=t, segment=words[measured], origin=path, flags=flags, pixel=pixel)
    return curve, values[0]


def _values(path: Path, channel: str, source: Channel, first: int, end: int) -> tuple[Array, str]:
    """Rows of a channel in SI or volts, NaN where nothing was measured, and the dimension."""
    data, told = source
    spelled = re.sub(r".*\((.*)\).*", r"\1", str(told.get("signal_calibration_unit", "")))  # "Volt (V)"
    dimension, power = unit_power(spelled) or ("volts", instruments.VOLTS.get(spelled))
    if power is None or dimension not in SURF_UNITS[channel]:
        raise InputError(f'{path}: its {channel} is in "{spelled}", not a unit of {" or ".join(SURF_UNITS[channel])}: '
                         f"{SURF_AGAIN}")  # fmt: skip
    ends = [told.get(f"signal_calibration_{end}", math.nan) for end in ("min", "max")]
    low, high = (float(np.asarray(end).item()) for end in ends)
    if not _is_size(abs(high - low)) or data.dtype.kind != "i":
        raise InputError(f"{path}: its {channel} lacks its calibration: {SURF_AGAIN}")
    counts, most = data[first:end], float(np.iinfo(data.dtype).max)
    values = low + (counts + most) * ((high - low) / (2 * most))
    return np.where(counts < -most, np.nan, values * 10.0**power), dimension


# --------------------------------------------------------------------------------------------------
# Whether the file of a microscope is whole, before a package reads it that takes what is there for what was written:
# checksums, declared sizes and counts, and what it would unpack to.

INTACT_WHAT = "file of force curves"
INTACT_AGAIN = "export it again"
HEAD, WAVE = 384, 64  # theory: bytes of both heads of Igor's binary wave of version 5, and the first of them
PIXELS = re.compile(rb"\.grid\.[ij]length\s*[=: ]\s*(\d+)(?:\.\d*)?(?:[eE]\+?(\d+))?")  # of the grid of a JPK map


def check(path: Path) -> None:
    """InputError where the file at ``path`` is damaged, cut off, or takes more than is allowed, as far as its format
    lets that be seen."""
    ending = path.suffix.lower()
    if ending == ".zip" or ending.startswith(".jpk"):
        members = instruments.members(path, process.TEXT if ending == ".zip" else None)
        for item, unpacked in zip(members, instruments.contents(path, members), strict=True):  # all of them once
            if item.filename.endswith(".properties"):
                for many, power in PIXELS.findall(unpacked):
                    check_size(path, process.PART * min(int(many[:15]) * 10 ** int(power[:2] or 0), 10**15))
    elif ending == ".ibw":
        # Igor's binary wave of version 5 (its Technical Note 003): heads whose words add up to zero, and sizes
        content = read_bytes(path, INTACT_WHAT)
        order = {b"\5\0": "<", b"\0\5": ">"}.get(content[:2])
        if order is None or len(content) < HEAD:
            raise InputError(f"{path}: is no binary wave of version 5, or cut off: {INTACT_AGAIN}")
        if sum(struct.unpack(f"{order}{HEAD // 2}h", content[:HEAD])) & 0xFFFF:
            raise InputError(f"{path}: is damaged (the checksum of its header is wrong): {INTACT_AGAIN}")
        sizes = struct.unpack_from(f"{order}15l", content, 4)
        there, declared = len(content), WAVE + sum(sizes)
        if min(sizes) < 0 or declared > there:
            raise InputError(f"{path}: is cut off: holds {there:,} bytes of {declared:,}: {INTACT_AGAIN}")
    else:
        content = read_bytes(path, INTACT_WHAT, process.TEXT)
        check_text(path, content.decode("latin-1"))
        if ending == ".tab":
            lines = content.split(b"\n")
            cells = {
                n: line.count(b"\t") + 1 for n, line in enumerate(lines, start=1) if line.strip() and line[:1] != b"#"
            }
            wanted = next(iter(cells.values()), 1)
            if short := [n for n, count in cells.items() if count != wanted]:
                line = f"line {short[0]} holds {cells[short[0]]} cells"
                raise InputError(f"{path}: {line}, not {wanted} as the first: {INTACT_AGAIN}")
            if wanted > 1 and lines[-1]:
                raise InputError(f"{path}: is cut off, its last line does not end: {INTACT_AGAIN}")


HEIGHTS = ("height (measured)", "height (piezo)")  # the better first
SEGMENTS = {0: APPROACH, 1: RETRACT}
LACKS_STIFFNESS = "the file lacks its spring constant: the deflection is not subtracted from the height"
LACKING = "No data found"  # how afmformats begins to say that a column is not there
BASE = ".base-calibration-slot"  # of a JPK file: how a property ends that names the scale which another is based on
OWN_SENSITIVITY = "names its own sensitivity, or needs none: leave --sensitivity out"
PLACE = ("grid index x", "grid index y", "position x", "position y")  # entries on the place of a curve in a map
ENTRIES = ("spring constant", "point count", *PLACE)  # numbers that are read of a data set
IN_NOTE = (b"FMapPointCounter", b"FMapLineCounter", b"XLVDT", b"YLVDT")  # of a wave that is one of a map
# Of a wave of Asylum: the last row of each segment behind the first row of all, and the way of the piezo there (1:
# approach, 0: dwell, -1: retraction).
LAST_ROWS, WAYS = b"Indexes", b"Direction"
MARKED = re.compile(rb"(?:\A|[\r\0])(%s): ?([^\r]*)(?=\r)" % b"|".join((LAST_ROWS, WAYS)))
WORDS_OF_WAYS = {1: APPROACH, 0: "dwell", -1: RETRACT}
COUNTED = re.compile(rb"(?:\A|\r)(%s): ?(-?\d+(?:\.\d*)?(?:e[-+]?\d{1,2})?)(?=\r)" % b"|".join(IN_NOTE))


class UnreadableError(InputError):
    """A file that afmformats does not know, or cannot read."""


def curves(path: Path, reading: Reading) -> Iterator[AsRead]:
    """The curves of a file, over distance, of creep or of relaxation, with their spring constants [N/m]; each is loaded
    when its turn comes.

    ``delta`` is minus the height, which grows away from the specimen, the deflection not yet subtracted; of files that
    hold the position of the tip itself it is minus that, and None stands for the spring constant.
    """
    with _opened_sets(path, reading) as (data_sets, lacks):
        _refuse_rigid(path, reading)
        reading.check_known_columns(path)
        is_alone = len(data_sets) == 1
        data_sets.reverse()
        while data_sets:  # what was read of one goes with it
            data = data_sets.pop()
            name = path.stem if is_alone else str(data.enum)
            if not reading.wants(name):
                yield name, None
                continue
            try:
                with _guarded(place(path, name)):
                    curve = _curve(path, name, data).multiplied(reading.factors)
                    of_tip = _holds(data, "tip position")
                    stiffness = None if of_tip else _stiffness(curve, data, reading)
                if lacks and not of_tip:
                    missing = "--stiffness and --sensitivity" if "sensitivity" in lacks else "--stiffness"
                    curve = replace(curve, flags=(*curve.flags, f"the file lacks {lacks}: {ARBITRARY} {missing}"))
                elif stiffness is None and reading.incomplete and not of_tip:
                    curve = replace(curve, flags=(*curve.flags, f"{LACKS_STIFFNESS}; give --stiffness"))
                yield curve, stiffness
            except InputError as error:
                yield error, None


@contextlib.contextmanager
def _opened_sets(path: Path, reading: Reading) -> Iterator[tuple[list[Any], str]]:
    """The data sets of a file, whose columns are read at their first use; what 1 stands in for, if anything."""
    if path.suffix.lower() != ".h5":
        yield _load(path, reading)
        return
    with hdf5.members_of(path, read_bytes(path, INTACT_WHAT), INTACT_AGAIN) as (file, members):
        if not {"software", "software version"} <= set(file.attrs) or "0" not in file:
            raise UnreadableError(f"{path}: holds no force curves as afmformats exports them")
        if reading.sensitivity is not None:
            raise InputError(f"{path}: {OWN_SENSITIVITY}")
        numbers = sorted(int(name) for name in file if name.isdecimal())
        yield [_Exported(file, members, number) for number in numbers], ""


@dataclass(eq=False)
class _Exported:
    """A data set of an HDF5 file that afmformats exported, which is opened once for all of them: a group of one number,
    ``enum``, with the entries on it and columns that are read once. Read as afmformats itself does, which opens the
    file for each column."""

    file: Any
    members: hdf5.Members
    enum: int
    _raw_data: dict[str, Array] = field(default_factory=dict, init=False)

    @cached_property
    def group(self) -> Any:
        return self.members.member(self.file, str(self.enum))

    @cached_property
    def columns(self) -> list[str]:
        return hdf5.names_of(self.group)

    @cached_property
    def _metadata(self) -> Mapping[str, Any]:
        entries = hdf5.attributes_among(self.group, ENTRIES)
        return {key: float(value) for key, value in entries.items() if not math.isnan(float(value))}

    @property
    def modality(self) -> str:
        return str(hdf5.attributes_among(self.group, ["imaging mode"])["imaging mode"])

    def __contains__(self, name: str) -> bool:
        return name in self.columns

    def __getitem__(self, name: str) -> Array:
        if name not in self._raw_data:
            self._raw_data[name] = self.members.values(self.group, name)
        return self._raw_data[name]


def takes_any_three_columns(path: Path) -> bool:
    """Whether afmformats would read a table of names that no reader knows as three columns without names, of which
    the first is a height: its reader of NT-MDT's exports does so with any numbers."""
    try:
        from afmformats.formats.fmt_ntmdt_txt import detect_txt
    except ImportError:
        return False
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # NumPy's on lines without numbers
        return path.suffix == ".txt" and bool(detect_txt(path))


def _load(path: Path, reading: Reading) -> tuple[list[Any], str]:
    """The data sets of a file, whose columns are read at their first use; what 1 stands in for, if anything."""
    try:
        import afmformats
    except ModuleNotFoundError:
        raise UnreadableError(f"{path}: needs the optional package afmformats: {installs('afm')}") from None
    if not path.is_file():
        read_bytes(path, INTACT_WHAT)  # says what is wrong with it
    if path.suffix in afmformats.supported_extensions:
        check(path)
    for name in ("afmformats", "igor2"):
        if not (logger := logging.getLogger(name)).handlers:
            logger.addHandler(logging.NullHandler())  # an error in one line takes the place of their tracebacks
    stiffness = None if reading.stiffness == math.inf else reading.stiffness
    calibration = {"spring constant": stiffness, "sensitivity": reading.sensitivity}
    override, lacks = {key: value for key, value in calibration.items() if value is not None}, ""
    try:
        try:
            data_sets = _loaded(path)
            if data_sets and reading.sensitivity is not None:
                raise InputError(f"{path}: {OWN_SENSITIVITY}")
        except afmformats.errors.MissingMetaDataError:
            if reading.incomplete:
                lacks = " and ".join(key for key in calibration if key not in override)
                override = dict.fromkeys(calibration, 1.0) | override
            if not override:
                raise
            data_sets = _loaded(path, meta_override=override)
    except afmformats.errors.MissingMetaDataError as error:
        missing = ", ".join(error.meta_keys)
        raise InputError(f"{path}: lacks {missing}: give --stiffness and, if asked for, --sensitivity") from None
    if not data_sets:
        raise InputError(f"{path}: holds no force curve")
    return data_sets, lacks


def _loaded(path: Path, **options: Any) -> list[Any]:
    """The curves that afmformats loads from a file."""
    import afmformats
    from afmformats.formats.fmt_jpk.jpk_reader import ArchiveCache

    if old := ArchiveCache.open_archives.pop(path, None):  # else it goes on to read what was there before
        old.close()
    with _guarded(str(path)):
        try:
            return list(afmformats.load_data(path, **options))
        except afmformats.errors.FileFormatNotSupportedError:
            known = ", ".join(afmformats.supported_extensions)
            raise UnreadableError(f"{path}: is no file of force curves that afmformats reads ({known})") from None


@contextlib.contextmanager
def _guarded(where: str) -> Iterator[None]:
    """A block of work by afmformats, whose readers of damaged files raise anything, much of which is no Exception."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except (InputError, MemoryError, KeyboardInterrupt, SystemExit, GeneratorExit):
        raise
    except BaseException as error:
        if hasattr(error, "meta_keys"):  # what the file lacks, which its caller asks for
            raise
        raise UnreadableError(f"{where}: afmformats cannot read this file ({first_line(error)})") from None


def _curve(path: Path, name: str, data: Any) -> Curve:
    """The curve of one data set: minus the height of the tip, else of the piezo, force, time and segments."""
    where = place(path, name)
    _check_points(where, data)
    height = next((name for name in ("tip position", *HEIGHTS) if _holds(data, name)), None)
    if height is None or not _holds(data, "force"):
        raise InputError(f"{where}: holds no height or no force (columns: {', '.join(data.columns)})")
    delta, P = -_column(where, data, height), _column(where, data, "force")
    if P.size < LEAST_ROWS:
        raise InputError(f"{where}: holds {counted(P.size, 'row')}, at least {LEAST_ROWS} are needed")
    t = _column(where, data, "time") if _holds(data, "time") else None
    flags: tuple[str, ...] = (f"displacement from the {height}",)
    if t is not None and (t[1:] < t[:-1]).any():
        t, flags = None, (*flags, "its time runs back and was left out")
    segment = _marked(path, P.size) if path.suffix == ".ibw" else None
    # Records of other modalities wait between: the motion divides them
    if segment is None and _holds(data, "segment") and data.modality == "force-distance":
        numbers = np.asarray(data["segment"]).astype(int)
        starts = [0, *(np.flatnonzero(numbers[1:] != numbers[:-1]) + 1).tolist()][: numbers.size]
        words = [SEGMENTS.get(one, f"segment {one}") for one in numbers[starts].tolist()]
        segment = np.repeat(words, np.diff([*starts, numbers.size]))
    return Curve(name, delta=delta, P=P, t=t, segment=segment, origin=path, flags=flags, pixel=_pixel(path, data))


def _marked(path: Path, rows: int) -> Array | None:
    """The segment of each row as the note of a wave marks them; None where it does not, or those of another number of
    rows."""
    note = dict(MARKED.findall(read_bytes(path, INTACT_WHAT)))
    try:
        ends, ways = ([float(part) for part in note[key].split(b",") if part.strip()] for key in (LAST_ROWS, WAYS))
        words = [WORDS_OF_WAYS[int(way)] for way in ways[1:]]
    except (KeyError, ValueError, OverflowError):
        return None
    lengths = np.diff([-1.0, *ends[1:-1], rows - 1.0])
    if len(words) != lengths.size or not (ends[0] == 0 and abs(ends[-1] - rows) <= 1 and (lengths >= 0).all()):
        return None
    return np.repeat(words, lengths.astype(int))


def _check_points(where: str, data: Any) -> None:
    """Refuse a data set that does not hold as many points as it says, in any of its segments, before afmformats makes
    up so many times."""
    raw = data._raw_data
    if hasattr(raw, "loaders"):  # of a JPK file
        get, arguments = raw.loaders["force"]
        reader, index = get.__self__, arguments["index"]
        for segment in reader.get_index_segment_numbers(index):
            # Refuse scales of a JPK file that are based on each other in a circle, in which afmformats would stay.
            properties = reader._get_index_segment_properties(index, segment)
            for start in (key for key in properties if key.endswith(BASE)):
                key, known = start, set[str]()
                while key in properties and key not in known:
                    known.add(key)
                    key = f"{key.removesuffix(BASE).rpartition('.')[0]}.{properties[key]}{BASE}"
                if key in known:
                    raise InputError(f"{where}: is damaged: its scale {start.removesuffix(BASE)} is based on itself")
            declared = reader.get_metadata(index, segment).get("point count")
            _check_count(f"{where}: segment {segment}", declared, reader.get_data("force", index, segment))
    elif _holds(data, "force"):
        _check_count(where, _metadata(data, "point count"), data["force"])


def _check_count(where: str, declared: int | None, values: Array) -> None:
    if declared not in (None, len(values)):
        raise InputError(f"{where}: is damaged or cut off: holds {counted(len(values), 'point')} of {declared:,}")


def _metadata(data: Any, name: str) -> Any:
    """An entry of a file on a data set, None without one; the public copy of it would compute all that can be."""
    return data._metadata.get(name)


def _pixel(path: Path, data: Any) -> Pixel | None:
    """The place of a data set in a map, where its file holds it; Igor's in the note of the wave."""
    if path.suffix == ".ibw":
        note = dict(COUNTED.findall(read_bytes(path, INTACT_WHAT)))
        entries: list[Any] = [float(note[key]) if key in note else None for key in IN_NOTE]
    else:
        entries = [_metadata(data, key) for key in PLACE]
    column, row, *place = (float(value) if value is not None and math.isfinite(value) else None for value in entries)
    if column is None or row is None:
        return None
    return Pixel(int(column), int(row), *(place if None not in place else ()))


def _holds(data: Any, name: str) -> bool:
    """Whether a data set has the column: some readers announce columns that their files lack."""
    try:
        return name in data and data[name] is not None
    except BaseException as error:  # of afmformats, whose errors are no Exceptions
        if str(error).startswith(LACKING):
            return False
        raise


def _column(where: str, data: Any, name: str) -> Array:
    values = np.asarray(data[name], dtype=float)
    if not np.isfinite(values).all():
        raise InputError(f"{where}: row {int(np.argmin(np.isfinite(values))) + 1} of its {name} is not finite")
    return values


def _stiffness(curve: Curve, data: Any, reading: Reading) -> float | None:
    """The spring constant [N/m] of the file, or the user's where it has none: loads were computed with it."""
    of_file, of_user = _metadata(data, "spring constant"), cast(Any, reading.stiffness)
    of_file = cast(Any, of_file if _is_size(of_file or 0.0) else None)
    if of_user is None and reading.incomplete and of_file in (None, 1.0):
        return None
    if of_user is None and of_file is None:
        raise InputError(f"{curve.where}: names no spring constant: give --stiffness")
    if None not in (of_file, of_user) and not math.isclose(of_file, of_user, rel_tol=1e-6):
        raise InputError(f"{curve.where}: names a spring constant of {of_file:g} N/m, with which its loads were "
                         f"computed: leave out --stiffness {of_user:g}")  # fmt: skip
    return float(of_user if of_file is None else of_file)


# --------------------------------------------------------------------------------------------------
# How much measured files hold, estimated from their size and first lines before they are read.


def estimate_rows(path: Path) -> float:
    """About how many rows the file at ``path`` holds, more of wide ones, which take as long.

    0 where it cannot be read, which its reader says, and of pipes, which would be waited for.
    """
    try:
        if not path.is_file():
            return 0.0
        if path.suffix.lower() == ".zip":
            inside = instruments.tables(path)
            # each table costs as many rows beside its own as are looked at to see how it is written
            heads = instruments.contents(path, inside, PIECE)
            return sum(rows_among(item.file_size, head) + LOOKED_AT for item, head in zip(inside, heads, strict=True))
        if path.suffix.lower().startswith(".jpk"):
            return sum(item.file_size for item in instruments.members(path)) / BYTES_USUAL
        return rows_of_text(path)
    except (InputError, OSError, ValueError):
        return 0.0


register(Format("Nanoscope", knows, nanoscope_curves))
register(Format("Nanosurf", is_nanosurf, nanosurf_curves))

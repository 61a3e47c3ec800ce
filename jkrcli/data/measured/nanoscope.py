r"""Force curves and maps of Bruker's Nanoscope (.spm, .000, .pfc): lines of "\key: value", then whole numbers.

A channel ("\*Ciao force image list") holds of each curve the approach and the retraction, both from the turning point
outward. Its "Z scale" names the volts of a count and the sensitivity, which stands elsewhere in the head (Nanoscope
8.10 User Guide, "General Format for CIAO Parameter Objects"). No checksums: a cut is found by the declared lengths.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from ...base import LARGEST_SI, Array, InputError, allowance_of, most_text, opened, read_bytes
from ...tables.titles import unit_power
from .curve import APPROACH, ARBITRARY, LEAST_ROWS, RETRACT, AsRead, Curve, Pixel, Reading, place
from .instruments import toward

WHAT = "Nanoscope file"
BEGINS, CHANNEL, ENDS = b"\\*Force file list", "Ciao force image list", b"\\*File list end"
BINARY = b"\x1a"  # ends the head of a binary file; exports in text go on with a table
AGAIN = "copy it again from the microscope"
DEFLECTION, SENSOR = "DeflectionError", "ZSensor"
NUMBER = r"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?"

Section = Mapping[str, str]


def knows(path: Path) -> bool:
    """Whether the file begins and goes on as a binary one of the Nanoscope."""
    if not path.is_file():
        return False
    with opened(path, WHAT) as file:
        return file.read(len(BEGINS)) == BEGINS and BINARY in file.read(most_text())


def curves(path: Path, reading: Reading) -> Iterator[AsRead]:
    """The curves of the file with the spring constant of their lever [N/m]; ``delta`` is the position of the piezo
    toward the specimen."""
    reading.check_known_columns(path)
    with allowance_of(path, fenced=False) as allowed:
        content = read_bytes(path, WHAT)
        allowed.take(len(content))
        file = File(path, content)
        allowed.take(parts=file.count)
    stiffness, sensitivity, flags = file.calibration(reading)
    for number in range(file.count):
        name = path.stem if file.count == 1 else str(number)
        try:
            yield file.curve(name, number, stiffness * sensitivity, flags).multiplied(reading.factors), stiffness
        except InputError as error:
            yield error, None


@dataclass(frozen=True, eq=False)
class File:
    """The parts of a file, from its ``content``: a head of sections, and the counts of channels."""

    path: Path
    content: bytes

    @cached_property
    def sections(self) -> Sequence[tuple[str, Section]]:
        """Title and entries of each section of the head."""
        head, end, _ = self.content.partition(BINARY)
        if ENDS not in head or not end:
            raise InputError(f"{self.path}: is damaged or cut off: its head does not end: {AGAIN}")
        return _sections(head.decode("cp1252", errors="replace"))

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

    @cached_property
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
        sizes = [
            int(self._number(section, "data length"))
            for title, section in self.sections
            if title == CHANNEL and _name(section) == DEFLECTION
        ]
        of_counts = [{bytes_each * 2 * self.samples[0] * math.prod(shape) for bytes_each in (2, 4)} for shape in shapes]
        fitting = [shape for shape, known in zip(shapes, of_counts, strict=True) if known & set(sizes)]
        return fitting[0] if fitting else shapes[0]

    @property
    def is_capture(self) -> bool:
        """Whether the file is a capture of curves at the frequency of PeakForce."""
        return self._of("Ciao scan list").get("peakforce capture", "").lower() == "allow"

    def calibration(self, reading: Reading) -> tuple[float, float, tuple[str, ...]]:
        """Spring constant [N/m] and sensitivity [m/V] of the user, else of the file, and flags on their origin."""
        section, _ = self.channels[DEFLECTION]
        spring = re.match(NUMBER, section.get("spring constant", ""))
        of_file = {
            "stiffness": float(spring[0]) if spring else 0.0,
            "sensitivity": self._per_volt(section.get("z scale", "")),
        }
        if reading.stiffness == math.inf:
            raise InputError(f"{self.path}: is of a force microscope, whose lever bends: give its stiffness, not rigid")
        values, flags = [], []
        for key, size, unit in (("stiffness", 1.0, "N/m"), ("sensitivity", 1e-9, "nm/V")):
            of_user, there = getattr(reading, key), f"{of_file[key] / size:g} {unit}"
            if of_user is not None:
                value, flag = of_user, f"{key} {of_user / size:g} {unit} as told, the file says {there}"
            elif _is_size(of_file[key]):
                value, flag = of_file[key], f"{key} {there} of the file"
            elif reading.incomplete:
                value, flag = 1.0, f"the file lacks its {key}: {ARBITRARY} --{key}"
            else:
                raise InputError(f"{self.path}: names no {key}: give --{key}")
            values.append(value)
            flags.append(flag)
        return values[0], values[1], tuple(flags)

    def curve(self, name: str, number: int, per_volt: float, calibration: tuple[str, ...]) -> Curve:
        """The curve of one ``number``; ``per_volt`` [N/V]."""
        where = place(self.path, name)
        volts, finer = self._volts(DEFLECTION, number)
        P = volts * per_volt
        if P.size < LEAST_ROWS:
            raise InputError(f"{where}: holds {P.size} rows, at least {LEAST_ROWS} are needed")
        z, t, turn, what = self._motion(number, P)
        flags = (f"displacement from the {what}", *calibration, *finer)
        segment = np.where(np.arange(P.size) < turn, APPROACH, RETRACT)
        return Curve(name, delta=z, P=P, t=t, segment=segment, origin=self.path, flags=flags, pixel=self._pixel(number))

    def _motion(self, number: int, P: Array) -> tuple[Array, Array | None, int, str]:
        """Positions [m] toward the specimen, times [s], the row of the turning point, and what the positions are."""
        if self.is_capture:
            return self._oscillation(P.size)
        if SENSOR in self.channels:
            z = self._volts(SENSOR, number)[0] * self._per_volt(self.channels[SENSOR][0].get("z scale", ""))
            z, what = z if toward(z, P) else -z, "height sensor"
        else:
            z, what = self._ramp(), "ramp of the piezo"
        return z, self._times(), self.samples[1][0], what

    def _ramp(self) -> Array:
        """Positions [m] of a piezo that moves in equal steps, the rows of the file over its range."""
        section, counts = self.channels[DEFLECTION]
        size = self._size(section.get("ramp size", ""), "ramp size")
        steps = size / counts.shape[2] * np.arange(counts.shape[2])
        return self._in_order(-np.stack([steps, steps]))

    def _oscillation(self, rows: int) -> tuple[Array, Array, int, str]:
        """Of a capture: the drive is a sine of the amplitude of PeakForce, deepest at the distance of synchronisation,
        which counts rows of the microscope's own curve."""
        scan = self._of("Ciao scan list")
        keys = ("peak force amplitude", "pft freq", "sample points", "sync distance qnm")
        amplitude, frequency, own, at = (self._positive(scan, key) for key in keys)
        deepest = at * rows / own
        phase = np.arange(rows) - deepest
        z = 1e-9 * amplitude * np.cos(2 * np.pi * phase / rows)
        t = np.arange(rows) / (1e3 * frequency * rows)
        return z, t, round(deepest), f"sine of the drive, {amplitude:g} nm at {frequency:g} kHz"

    def _times(self) -> Array | None:
        """Times [s] from the speed of the piezo, without pauses; None where the file names no speed."""
        force, (section, counts) = self._of("Ciao force list"), self.channels[DEFLECTION]
        ramp, *speeds = (
            _last(entry)[0]
            for entry in (section.get("ramp size", ""), force.get("forward vel.", ""), force.get("reverse vel.", ""))
        )
        if not all(map(_is_size, (ramp, *speeds))):
            return None
        steps = np.repeat([ramp / speed / counts.shape[2] for speed in speeds], self.samples[1])
        return np.cumsum(steps) - steps[0]

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
            raise InputError(
                f"{self.path}: is damaged or of a layout that is not read: {size:,} bytes for {count:,} curves of "
                f"2 x {stride:,} rows, 2 or 4 bytes each: export it as text"
            )
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

    def _size(self, entry: str, what: str) -> float:
        """A length [m]: volts with their sensitivity, "V [Sens. Zsens] (0.0067 V/LSB) 151.48 V", or nanometres."""
        number, unit = _last(entry)
        size = number * self._per_volt(entry) if unit == "V" else _metres(number, unit)
        if not _is_size(size):
            raise InputError(f"{self.path}: names no {what}, and no height sensor was recorded: export it as text")
        return size

    def _pixel(self, number: int) -> Pixel | None:
        """The place of a curve in a map, centred on the scan."""
        lines, columns = self.shape
        size, unit = _last(self._of("Ciao scan list").get("scan size", ""))
        unit = unit.replace("~", "u")
        if lines * columns == 1 or unit_power(unit) is None:
            return None
        step = _metres(size, unit) / columns
        row, column = divmod(number, columns)
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

    def _positive(self, section: Section, key: str) -> float:
        """A number by which others are divided."""
        if not _is_size(number := self._number(section, key)):
            raise InputError(f'{self.path}: is damaged or not read: its "{key}" must be positive, got {number:g}')
        return number


def _sections(head: str) -> Sequence[tuple[str, Section]]:
    """Title and entries of each section; keys lower case, without the number of a group ("@4:Z scale")."""
    sections: list[tuple[str, dict[str, str]]] = []
    for line in head.splitlines():
        if line.startswith("\\*"):
            sections.append((line[2:].strip(), {}))
        elif match := re.match(r"\\(?:@(?:\d+:)?)?([^:]+):\s*(.*)", line):
            sections[-1][1].setdefault(match[1].strip().lower(), match[2].strip())
    return sections


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

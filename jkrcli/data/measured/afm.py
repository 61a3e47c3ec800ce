"""Force curves of force microscopes, read by the optional package afmformats: the one door to it."""

from __future__ import annotations

import contextlib
import logging
import math
import re
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from ...base import Array, InputError, allowance_of, first_line, installs, read_bytes
from . import intact
from .curve import APPROACH, ARBITRARY, LEAST_ROWS, RETRACT, AsRead, Curve, Pixel, Reading, place

HEIGHTS = ("height (measured)", "height (piezo)")  # the better first
SEGMENTS = {0: APPROACH, 1: RETRACT}
LACKING = "No data found"  # how afmformats begins to say that a column is not there
BASE = ".base-calibration-slot"  # of a JPK file: how a property ends that names the scale which another is based on
IN_NOTE = (b"FMapPointCounter", b"FMapLineCounter", b"XLVDT", b"YLVDT")  # of a wave that is one of a map
COUNTED = re.compile(rb"(?:\A|\r)(%s): ?(-?\d+(?:\.\d*)?(?:e[-+]?\d{1,2})?)(?=\r)" % b"|".join(IN_NOTE))


class UnreadableError(InputError):
    """A file that afmformats does not know, or cannot read."""


def curves(path: Path, reading: Reading) -> Iterator[AsRead]:
    """The curves of a file, over distance, of creep or of relaxation, with their spring constants [N/m]; each is loaded
    when its turn comes.

    ``delta`` is minus the height, which grows away from the specimen, the deflection not yet subtracted; of files that
    hold the position of the tip itself it is minus that, and None stands for the spring constant.
    """
    data_sets, lacks = _load(path, reading)
    reading.check_known_columns(path)
    for data in data_sets:
        name = path.stem if len(data_sets) == 1 else str(data.enum)
        try:
            with _guarded(place(path, name)):
                as_read = _curve_and_stiffness(path, name, data, reading, lacks)
            yield as_read
        except InputError as error:
            yield error, None


def _curve_and_stiffness(path: Path, name: str, data: Any, reading: Reading, lacks: str) -> tuple[Curve, float | None]:
    """The curve of one data set and its spring constant, with a flag on what 1 stands in for."""
    curve = _curve(path, name, data).multiplied(reading.factors)
    if _holds(data, "tip position"):
        return curve, None
    stiffness = _stiffness(curve, data, reading)
    lack = _lack(lacks, stiffness, reading)
    return replace(curve, flags=(*curve.flags, lack)) if lack else curve, stiffness


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
        from afmformats import errors
    except ModuleNotFoundError:
        raise UnreadableError(f"{path}: needs the optional package afmformats: {installs('afm')}") from None
    if not path.is_file():
        read_bytes(path, intact.WHAT)  # says what is wrong with it
    if path.suffix in afmformats.supported_extensions:
        intact.check(path)
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
                raise InputError(f"{path}: names its own sensitivity, or needs none: leave --sensitivity out")
        except errors.MissingMetaDataError:
            if reading.incomplete:
                lacks = " and ".join(key for key in calibration if key not in override)
                override = dict.fromkeys(calibration, 1.0) | override
            if not override:
                raise
            data_sets = _loaded(path, meta_override=override)
    except errors.MissingMetaDataError as error:
        missing = ", ".join(error.meta_keys)
        raise InputError(f"{path}: lacks {missing}: give --stiffness and, if asked for, --sensitivity") from None
    if not data_sets:
        raise InputError(f"{path}: holds no force curve")
    if reading.stiffness == math.inf:
        raise InputError(f"{path}: is of a force microscope, whose lever bends: give its stiffness, not rigid")
    return data_sets, lacks


def _loaded(path: Path, **options: Any) -> list[Any]:
    """What afmformats loads of a file."""
    import afmformats
    from afmformats import errors
    from afmformats.formats.fmt_jpk.jpk_reader import ArchiveCache

    if old := ArchiveCache.open_archives.pop(path, None):  # else it goes on to read what was there before
        old.close()
    with _guarded(str(path)):
        try:
            return list(afmformats.load_data(path, **options))
        except errors.FileFormatNotSupportedError:
            known = ", ".join(afmformats.supported_extensions)
            raise UnreadableError(f"{path}: is no file of force curves that afmformats reads ({known})") from None


@contextlib.contextmanager
def _guarded(where: str) -> Iterator[None]:
    """A block of work by afmformats, whose readers of damaged files raise anything, much of which is no Exception."""
    from afmformats import errors, meta

    try:
        with allowance_of(where), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except InputError:
        raise
    except (Exception, errors.AFMFileFormatError, meta.MetaDataMissingError) as error:
        raise UnreadableError(f"{where}: afmformats cannot read this file ({first_line(error)})") from None


def _lack(lacks: str, stiffness: float | None, reading: Reading) -> str:
    """What is missing to read an incomplete file, and the remedy; "" where nothing is."""
    if lacks:
        options = "--stiffness and --sensitivity" if "sensitivity" in lacks else "--stiffness"
        return f"the file lacks {lacks}: {ARBITRARY} {options}"
    if stiffness is None and reading.incomplete:
        return "the file lacks its spring constant: the deflection is not subtracted from the height; give --stiffness"
    return ""


def _curve(path: Path, name: str, data: Any) -> Curve:
    """The curve of one data set: minus the height of the tip, else of the piezo, force, time and segments."""
    where = place(path, name)
    _check_points(where, data)
    height = next((name for name in ("tip position", *HEIGHTS) if _holds(data, name)), None)
    if height is None or not _holds(data, "force"):
        raise InputError(f"{where}: holds no height or no force (columns: {', '.join(data.columns)})")
    delta, P = -_column(where, data, height), _column(where, data, "force")
    if P.size < LEAST_ROWS:
        raise InputError(f"{where}: holds {P.size} rows, at least {LEAST_ROWS} are needed")
    t = _column(where, data, "time") if _holds(data, "time") else None
    flags: tuple[str, ...] = (f"displacement from the {height}",)
    if t is not None and (np.diff(t) < 0).any():
        t, flags = None, (*flags, "its time runs back and was left out")
    segment = None
    if _holds(data, "segment") and data.modality == "force-distance":  # others wait between: the motion divides them
        segment = np.array([SEGMENTS.get(int(word), f"segment {word}") for word in data["segment"]])
    return Curve(name, delta=delta, P=P, t=t, segment=segment, origin=path, flags=flags, pixel=_pixel(path, data))


def _check_points(where: str, data: Any) -> None:
    """Refuse a data set that does not hold as many points as it says, in any of its segments, before afmformats makes
    up so many times."""
    raw = data._raw_data
    if hasattr(raw, "loaders"):  # of a JPK file
        get, arguments = raw.loaders["force"]
        reader, index = get.__self__, arguments["index"]
        for segment in reader.get_index_segment_numbers(index):
            _check_scales(where, reader._get_index_segment_properties(index, segment))
            declared = reader.get_metadata(index, segment).get("point count")
            _check_count(f"{where}: segment {segment}", declared, reader.get_data("force", index, segment))
    elif _holds(data, "force"):
        _check_count(where, _metadata(data, "point count"), data["force"])


def _check_count(where: str, declared: int | None, values: Array) -> None:
    if declared not in (None, len(values)):
        raise InputError(f"{where}: is damaged or cut off: holds {len(values):,} points of {declared:,}")


def _check_scales(where: str, properties: Mapping[str, Any]) -> None:
    """Refuse scales of a JPK file that are based on each other in a circle, in which afmformats would stay."""
    for start in (key for key in properties if key.endswith(BASE)):
        key, known = start, set[str]()
        while key in properties and key not in known:
            known.add(key)
            key = f"{key.removesuffix(BASE).rpartition('.')[0]}.{properties[key]}{BASE}"
        if key in known:
            raise InputError(f"{where}: is damaged: its scale {start.removesuffix(BASE)} is based on itself")


def _metadata(data: Any, name: str) -> Any:
    """An entry of a file on a data set, None without one; the public copy of it would compute all that can be."""
    return data._metadata.get(name)


def _pixel(path: Path, data: Any) -> Pixel | None:
    """The place of a data set in a map, where its file holds it; Igor's in the note of the wave."""
    if path.suffix == ".ibw":
        note = dict(COUNTED.findall(read_bytes(path, intact.WHAT)))
        entries: list[Any] = [float(note[key]) if key in note else None for key in IN_NOTE]
    else:
        entries = [_metadata(data, key) for key in ("grid index x", "grid index y", "position x", "position y")]
    if any(value is None or not math.isfinite(value) for value in entries):
        return None
    column, row, x, y = map(float, entries)
    return Pixel(int(column), int(row), x, y)


def _holds(data: Any, name: str) -> bool:
    """Whether a data set has the column: some readers announce columns that their files lack."""
    from afmformats.errors import FileFormatNotSupportedError

    try:
        return name in data and data[name] is not None
    except FileFormatNotSupportedError as error:
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
    if of_user is None and reading.incomplete and of_file in (None, 1.0):
        return None
    if of_user is None and of_file is None:
        raise InputError(f"{curve.where}: names no spring constant: give --stiffness")
    if None not in (of_file, of_user) and not math.isclose(of_file, of_user, rel_tol=1e-6):
        raise InputError(f"{curve.where}: names a spring constant of {of_file:g} N/m, with which its loads were "
                         f"computed: leave out --stiffness {of_user:g}")  # fmt: skip
    return float(of_user if of_file is None else of_file)

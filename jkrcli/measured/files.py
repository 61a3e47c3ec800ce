"""Measured curves, from text tables and from the files of force microscopes."""

import importlib
import math
import pkgutil
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..base.errors import InputError, did_you_mean
from ..base.files import is_ours, packed
from ..base.hdf5 import format_of
from ..base.numerics import SHOWN, Array
from ..base.units import show
from . import afm_formats, formats, instruments, text_formats
from . import instruments as archive
from .curve import APPROACH, ARBITRARY, LEAST_ROWS, SUBTRACTED_TWICE, AsRead, Curve, Reading
from .segmentation import of_its_device, stiffness_of_noise, with_zero_points

for _module in pkgutil.iter_modules([str(Path(__file__).parent)]):
    if _module.name.endswith("_format"):  # of one format, which it registers
        importlib.import_module(f"{__package__}.{_module.name}")

__all__ = ["APPROACH", "Curve", "Reading", "each", "from_columns", "read", "usable"]
# Endings of force microscopes' files. Of .csv and .txt only the user knows: --format afm.
AFM_ENDINGS = (".jpk-force", ".jpk-force-map", ".jpk-qi-data", ".jpk-qi-series", ".ibw", ".h5", ".tab")
MAP_ENDINGS = (".jpk-force-map", ".jpk-qi-data", ".jpk-qi-series", ".h5")
UNIT_WRONG = 10.0  # choice: of the way of a device, by which loads cannot bend it; calibrations err by less
# What lies beside measurements in a folder, and is none.
NOT_MEASURED = (".toml", ".json", ".png", ".svg", ".pdf", ".jpg", ".tif", ".html", ".md", ".py", ".ipynb", ".log")


def read(path: Path, reading: Reading | None = None) -> list[Curve]:
    """All curves in the file at ``path``; InputError, a line per curve, where any of them cannot be used."""
    curves, lines = usable([path], reading or Reading())
    if lines:
        raise InputError(lines)
    return curves


def from_columns(columns: Mapping[str, Any], reading: Reading | None = None) -> Curve:
    """The curve in arrays or the columns of a data frame: by their names as those of a table ("delta_um", "P (nN)"),
    SI where they name no unit; InputError as of a file."""
    arrays = dict[str, Array]()
    for key in columns.keys():  # noqa: SIM118 - of a data frame, too
        # its cells, numbers or words, nan where masked or missing
        values = columns[key]
        cells = np.array(values, dtype=object)
        missing = values.isna() if hasattr(values, "isna") else np.ma.getmaskarray(values) if np.ma.isMA(values) else []
        blank = np.array([cell is None or cell is np.ma.masked for cell in cells.flat], dtype=bool).reshape(cells.shape)
        cells[blank | np.asarray(missing, dtype=bool) if len(missing) else blank] = math.nan
        arrays[str(key)] = cells
    if not arrays:
        raise InputError("data: holds no columns")
    if len({array.shape for array in arrays.values()}) != 1 or next(iter(arrays.values())).ndim != 1:
        raise InputError("data: all columns must be one-dimensional and of one length, got "
                         f"{ {key: array.shape for key, array in arrays.items()} }")  # fmt: skip
    table = zip(*(array.tolist() for array in arrays.values()), strict=True)
    lines = [",".join(arrays), *(",".join(map(str, row)) for row in table)]
    reading = replace(reading or Reading(), separator="comma", decimal=".")
    (curve, stiffness), *others = text_formats.curves(Path("data"), reading, "\n".join(lines).encode())
    if others or not isinstance(curve, Curve):
        raise curve if isinstance(curve, InputError) else InputError("data: holds several curves, one is wanted")
    return _by_convention(curve, reading, stiffness)


def usable(paths: Iterable[Path], reading: Reading) -> tuple[list[Curve], list[str]]:
    """All curves in files, and a line on each that cannot be used: those of a map row by row of its grid, others in
    their order."""
    items = [item for path in paths for item in each(path, reading)]
    lines = [line for item in items if isinstance(item, InputError) for line in item.lines]
    curves = [item for item in items if isinstance(item, Curve)]
    grid = {(at.row, at.column): item for item in curves if (at := item.pixel) is not None}
    return [grid[at] for at in sorted(grid)] if len(grid) == len(curves) else curves, lines


def holds_map(path: Path) -> bool:
    """Whether a path is that of a map, by its name: a folder, or a microscope's file of many curves."""
    registered = (ending for one in formats.FORMATS.values() for ending in one.maps)
    return path.is_dir() or path.name.endswith((*MAP_ENDINGS, *registered))


def files_in(folder: Path) -> list[Path]:
    """The files of a folder that may hold measured curves, by their names, numbers in them as numbers (2 before 10):
    what ``jkr`` wrote, pictures, cases and hidden files are none."""

    def natural(path: Path) -> list[tuple[int, str]]:
        return [(int(part), "") if part.isdecimal() else (-1, part.lower()) for part in re.split(r"(\d+)", path.name)]

    return sorted((path for path in folder.iterdir() if path.is_file() and not path.name.startswith(".")
                   and path.suffix.lower() not in NOT_MEASURED and not is_ours(path)), key=natural)  # fmt: skip


def folders_of(path: Path) -> list[Path]:
    """The folders in a folder that holds no file which may be measured, those of samples; else the path itself."""
    inside = path.is_dir() and not files_in(path)
    found = sorted(one for one in path.iterdir() if one.is_dir() and files_in(one)) if inside else []
    return found or [path]


def _each_in(folder: Path, reading: Reading) -> Iterator[Curve | InputError]:
    """The curves in the files of a folder: one that cannot be read comes as its error, too."""
    found, names = False, list[str]()
    for path in files_in(folder):
        try:
            for item in each(path, reading):
                found = True
                yield item
        except NoSuchCurveError as error:
            names += error.names
        except InputError as error:
            found = True
            yield error
    if found:
        return
    wanted = reading.where.get("curve")
    raise InputError(f"{folder}: the folder holds no measured curves") if wanted is None else (
        NoSuchCurveError(folder, wanted, names))  # fmt: skip


class NoSuchCurveError(InputError):
    """A file or folder at ``path`` that holds curves of other ``names`` than the one that is ``wanted``."""

    def __init__(self, path: Path, wanted: str, names: Sequence[str]) -> None:
        near = f"{did_you_mean(wanted, names)} ({', '.join(names[:SHOWN])})"
        super().__init__(f'{path}: holds no curve "{wanted}"{near}')
        self.names = names


def each(path: Path, reading: Reading | None = None) -> Iterator[Curve | InputError]:
    """The curves in the file at ``path``, or in the files of that folder, one by one, of a microscope's file only the
    one at hand in memory.

    A curve that cannot be used comes as its error and the others follow, and so does a file of a folder; a file that
    cannot be read raises InputError.
    """
    reading = reading or Reading()
    if path.is_dir():
        yield from _each_in(path, reading)
        return
    wanted, names = reading.where.get("curve"), []
    for curve, stiffness in _as_read(path, reading):
        if isinstance(curve, InputError):
            yield curve
            continue
        names.append(curve if isinstance(curve, str) else curve.name)
        if isinstance(curve, str) or not reading.wants(curve.name):
            continue
        try:
            yield _by_convention(_selected(curve, reading), reading, stiffness)
        except InputError as error:
            yield error
    if wanted is not None and wanted not in names:
        raise NoSuchCurveError(path, wanted, names)


def _as_read(path: Path, reading: Reading) -> Iterator[AsRead]:
    """The curves by the reader of the format that registered itself (``formats.py``); of others by that of text or of
    the package for microscopes, by the second where the first fails."""
    # InputError where the file describes a body or holds what was computed.
    if path.suffix == ".toml":
        raise InputError(f"{path}: is a case file, no measurement")
    if path.suffix == ".h5" and path.is_file() and (kind := format_of(path)).startswith("jkr-"):
        raise InputError(f"{path}: was written by jkr ({kind}), is no measurement")
    inner = path.name[: -len(path.suffix)]
    if packed(path) and inner.lower().endswith((*AFM_ENDINGS, *afm_formats.HDF5_ENDINGS, ".zip", ".tar")):
        raise InputError(f"{path}: is a packed {Path(inner).suffix} file: unpack it, gunzip {path.name}")
    if reading.format != "text" and (known := formats.format_of(path)):
        yield from known.curves(path, reading)
    elif packed(path):
        yield from text_formats.curves(path, reading)
    elif reading.format == "text" or (reading.format == "auto" and not path.name.endswith(AFM_ENDINGS)):
        try:
            yield from text_formats.curves(path, reading)
        except (text_formats.UnknownColumnsError, archive.NoTablesError) as error:
            if reading.format == "text" or reading.columns or reading.units:
                raise
            if afm_formats.takes_any_three_columns(path):
                raise
            yield from _instead(afm_formats.curves(path, reading), afm_formats.UnreadableError, error)
    else:
        try:
            yield from afm_formats.curves(path, reading)
        except afm_formats.UnreadableError as error:
            if reading.format == "afm" or path.suffix != ".tab":
                raise
            yield from _instead(text_formats.curves(path, reading), InputError, error)


def _instead(curves: Iterator[AsRead], unknown: type[InputError], error: InputError) -> Iterator[AsRead]:
    """The curves by a second reader; the ``error`` of the first one where that finds the file ``unknown``, too."""
    try:
        yield from curves
    except unknown:
        raise error from None


def _selected(curve: Curve, reading: Reading) -> Curve:
    """The curve at the rows that ``reading`` asks for."""
    if "segment" in reading.where:
        word = reading.where["segment"]
        curve = curve.only(instruments.SEGMENTS.get(word.lower(), word))
    if reading.rows is None:
        return curve
    first, last = reading.rows
    if last - first + 1 < LEAST_ROWS or last > len(curve):
        raise InputError(f"{curve.where}: --rows {first}..{last} must be {LEAST_ROWS} or more of its {len(curve)} rows")
    return curve.rows(np.arange(first - 1, last))


def _by_convention(curve: Curve, reading: Reading, stiffness: float | None) -> Curve:
    """The curve with the signs, offsets and deflection (of a device of ``stiffness`` [N/m]) of ``reading``."""
    columns: dict[str, Any] = {}
    for name in {*reading.flip, *reading.zero}:
        sign, read = -1.0 if name in reading.flip else 1.0, curve.column(name, " to flip or to set to zero")
        columns[name] = sign * read - reading.zero.get(name, 0.0)
    converted = replace(curve, **columns) if columns else curve
    if reading.contact == "estimate":
        converted = with_zero_points(converted)
    if stiffness in (None, math.inf) or converted.delta is None:
        return of_its_device(converted)
    if converted.P is None:
        raise InputError(f"{curve.where}: holds no load: the instrument's deflection P/stiffness cannot be subtracted")
    # The device cannot be bent by much more than its position moves
    way, bent = float(np.ptp(converted.delta)), float(np.ptp(converted.P)) / stiffness
    if bent > UNIT_WRONG * way > 0 and not any(ARBITRARY in flag for flag in converted.flags):
        sizes = f"({stiffness:g} N/m) by {show(bent, 'length', 2)} while it moves by {show(way, 'length', 2)}"
        raise InputError(f"{curve.where}: loads bend the instrument {sizes}: a unit or the stiffness is wrong, give "
                         "--unit delta=um, --unit P=nN or --stiffness")  # fmt: skip
    twice = stiffness_of_noise(converted.delta, converted.P) is not None
    flags = (*converted.flags, SUBTRACTED_TWICE) if twice else converted.flags
    return replace(converted, delta=converted.delta - converted.P / stiffness, stiffness=stiffness, flags=flags)

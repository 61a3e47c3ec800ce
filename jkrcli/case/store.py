"""The series file (HDF5): the one door to h5py. Written atomically, checked on reading."""

from __future__ import annotations

import contextlib
import platform
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from importlib import metadata
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from .. import __version__
from ..base.errors import InputError
from ..base.files import hdf5, is_hdf5
from ..base.units import MOST
from ..base.unknown import Estimate, Unknown
from ..series import COLUMNS, ErrorBudget, PressureTable, RawSeries, Series, Solution, first_of_plateaus

FORMAT, VERSION = "jkr-series", 1
NAMES = {"a": "a", "delta": "delta", "P": "P", "S": "S", "dS": "dS_da"}
UNITS = {"a": "m", "delta": "m", "P": "N", "S": "N/m", "dS": "N/m^2"}
WORDS = {
    "a": "contact radius, undeformed configuration",
    "delta": "displacement of the indenter, into the specimen positive",
    "P": "load, compression positive",
    "S": "slope dP/d(delta) of the nonadhesive contact",
    "dS": "derivative dS/da",
}
PACKAGES = ("numpy", "scipy", "gmsh", "scikit-fem", "h5py")
MAX_ROWS, MAX_CELLS = 10_000_000, 100_000_000  # of a column and of the table of pressures: 80 and 800 MB
MAX_TEXT = 16 << 20  # bytes
CHECKSUMMED = ("v110", "v110")  # the file format whose metadata carry checksums: damage is found, not followed


@dataclass(frozen=True, eq=False)
class Stored:
    """What a series file holds. ``raw`` are the increments as they were computed; ``series()`` filters them."""

    path: Path
    raw: RawSeries
    columns: Mapping[str, np.ndarray]
    errors: Mapping[str, np.ndarray]
    a0: float
    S0: float | None
    budget: ErrorBudget
    method: str
    key: str
    case: str
    command_line: str = ""
    facts: Mapping[str, Any] = field(default_factory=dict)
    timings: Mapping[str, float] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def __repr__(self) -> str:
        a = self.raw.a
        return f"<{type(self).__name__} {self.path}: {a.size} rows by method {self.method}, a to {a[-1]:.4g} m>"

    def series(self, with_slopes: bool = True) -> tuple[Series, int]:
        """The series at increasing radii (first increment of every plateau) and the number of dropped increments.

        ``with_slopes = False`` leaves out S and dS/da where the file has them.
        """
        keep = first_of_plateaus(self.raw.a)
        if not keep.any():
            raise InputError(f"{self.path}: series: no increment is in contact (all a <= 0)")
        slopes = {name: self.columns[name][keep] for name in ("S", "dS") if with_slopes and name in self.columns}
        errors = {name: values[keep] for name, values in self.errors.items()}
        raw = self.raw
        try:
            series = Series(raw.a[keep], raw.delta[keep], raw.P[keep], **slopes, errors=errors, a0=self.a0, S0=self.S0)
        except InputError as error:
            raise InputError(f"{self.path}: {error}") from None
        return series, int(keep.size - keep.sum())


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Kept(Stored):
    """A solution in memory, as its series file would hold it; ``solution``: what ``write`` takes."""

    solution: Solution


def kept(solution: Solution, case: str, key: str, name: str = "solved") -> Kept:
    """``solution`` of the resolved ``case`` (TOML) as if it were read from a file; ``name`` stands in messages."""
    series = solution.series
    raw = solution.raw if solution.raw is not None else RawSeries(series.a, series.delta, series.P)
    present = {column: getattr(solution.raw or series, column, None) for column in COLUMNS}
    return Kept(
        path=Path(name),
        raw=raw,
        columns={column: values for column, values in present.items() if values is not None},
        errors=dict(series.errors) if solution.raw is None else {},
        a0=series.a0,
        S0=series.S0,
        budget=solution.budget,
        method=solution.method,
        key=key,
        case=case,
        facts=solution.facts,
        timings=solution.timings,
        versions=versions(),
        warnings=solution.warnings,
        solution=solution,
    )


def versions() -> dict[str, str]:
    """Versions of jkr, Python and the packages that a result depends on."""
    found = {"jkr": __version__, "python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found


def write(path: Path, solution: Solution, case: str, key: str, command_line: str) -> None:
    """Write ``solution`` of the resolved ``case`` (TOML) to ``path``, whole or not at all."""
    series = solution.series
    rows = solution.raw if solution.raw is not None else series
    with hdf5(path, libver=CHECKSUMMED) as file:
        identity = {"method": solution.method, "problem_key": key, "command_line": command_line}
        _attributes_to(file, {"format": FORMAT, "version": VERSION} | identity)
        file.create_dataset("case", data=_fixed(case))
        group = file.create_group("series")
        group.attrs["a0_m"] = series.a0
        if series.S0 is not None:
            group.attrs["S0_N_per_m"] = series.S0
        for name in COLUMNS:
            _dataset(group, NAMES[name], getattr(rows, name, None), UNITS[name], WORDS[name])
        _write_errors(file.create_group("errors"), solution)
        if solution.pressure is not None:
            contact = file.create_group("contact")
            _dataset(contact, "r", solution.pressure.r, "m", "radii of the contact nodes")
            _dataset(contact, "pressure", solution.pressure.p, "Pa", "contact pressure, one row per increment")
        for name, values in (("facts", solution.facts), ("timings_s", solution.timings), ("versions", versions())):
            _attributes_to(file.create_group(name, track_order=True), values)
        _attributes_to(file.create_group("warnings", track_order=True), dict(enumerate(solution.warnings)))


def _write_errors(group: h5py.Group, solution: Solution) -> None:
    """The budget (a relative error or the reason why it is unknown) and the absolute error of each column."""
    _attributes_to(group, solution.budget.as_dict())
    if solution.raw is None:
        for name, values in solution.series.errors.items():
            _dataset(group, NAMES[name], values, UNITS[name], f"estimated absolute error of {NAMES[name]}")


def _dataset(group: h5py.Group, name: str, values: np.ndarray | None, unit: str, words: str) -> None:
    if values is not None:
        array = np.asarray(values, dtype=float)
        data = group.create_dataset(name, data=array, chunks=True, fletcher32=True, compression="gzip", shuffle=True)
        _attributes_to(data, {"unit": unit, "description": words})


def _attributes_to(item: h5py.Group | h5py.Dataset, values: Mapping[Any, Any]) -> None:
    for name, value in values.items():
        item.attrs[str(name)] = _fixed(str(value)) if isinstance(value, str | Unknown) else value


def _fixed(text: str) -> np.ndarray:
    """A string of fixed length: it lies in checksummed metadata, where HDF5's variable-length strings do not."""
    content = text.encode("utf-8")
    return np.array(content, dtype=h5py.string_dtype("utf-8", max(len(content), 1)))


def read(path: str | Path) -> Stored:
    """Read and check a series file; InputError in one line where it is missing, foreign, truncated or damaged."""
    with _opened(Path(path)) as file:
        return _read(Path(path), file)


def read_pressure(path: str | Path) -> PressureTable | None:
    """The contact pressure of every increment, where the file holds it; InputError where it is damaged."""
    path = Path(path)
    with _opened(path) as file:
        if "contact" not in file:
            return None
        contact = _group(path, file, "contact")
        r = _numbers(path, contact, "r", 1)
        return PressureTable(r, _numbers(path, contact, "pressure", 2, r.size))


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[h5py.File]:
    """An HDF5 file to read from; what the library says of a damaged one becomes an InputError."""
    if not is_hdf5(path, "series file"):
        remedy = ", jkr run makes one from a case" if path.suffix == ".toml" else ""
        raise InputError(f"{path}: is not an HDF5 file{remedy}")
    try:
        with h5py.File(path, "r") as file:
            yield file
    except InputError:
        raise
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, OverflowError, MemoryError) as error:
        reason = "truncated" if "truncated" in str(error) else "damaged"
        raise InputError(f"{path}: the HDF5 file is {reason} and cannot be read; run the case again") from None


def _read(path: Path, file: h5py.File) -> Stored:
    kind, version = _text(file.attrs.get("format", "")), file.attrs.get("version", 0)
    if kind != FORMAT:
        raise InputError(f'{path}: format must be "{FORMAT}", got "{kind}"; was this file written by jkr?')
    if version != VERSION:
        raise InputError(f"{path}: version must be {VERSION}, got {version}; this file needs another release of jkr")
    series = _group(path, file, "series")
    columns = {name: _column(path, series, NAMES[name], UNITS[name], name in ("a", "delta", "P")) for name in COLUMNS}
    present = {name: values for name, values in columns.items() if values is not None}
    sizes = {name: values.size for name, values in present.items()}
    if len(set(sizes.values())) != 1:
        raise InputError(f"{path}: series: all columns must have the same length, got {sizes}")
    errors = _group(path, file, "errors")
    columns_err = {name: _column(path, errors, NAMES[name], UNITS[name], False) for name in COLUMNS}
    return Stored(
        path=path,
        raw=RawSeries(present["a"], present["delta"], present["P"]),
        columns=present,
        errors={
            name: values for name, values in columns_err.items() if values is not None and values.size == sizes["a"]
        },
        a0=_first(path, series, "a0_m") or 0.0,
        S0=_first(path, series, "S0_N_per_m"),
        budget=ErrorBudget(
            *(_estimate(errors.attrs.get(name)) for name in ("discretisation", "truncation", "radius", "smoothing"))
        ),
        method=_text(file.attrs.get("method", "unknown")),
        key=_text(file.attrs.get("problem_key", "")),
        case=_case_of(path, file),
        command_line=_text(file.attrs.get("command_line", "")),
        facts=_attributes(path, file, "facts"),
        timings=_attributes(path, file, "timings_s"),
        versions=_attributes(path, file, "versions"),
        warnings=tuple(map(str, _attributes(path, file, "warnings").values())),
    )


def _group(path: Path, file: h5py.File, name: str) -> h5py.Group:
    if not isinstance(_own(path, file, name), h5py.Group):
        raise InputError(f'{path}: group "{name}" is missing')
    return file[name]


def _own(path: Path, group: h5py.Group, name: str) -> Any:
    """What stands under ``name`` in this very file, None where nothing does: a link may lead to any file there is."""
    if name in group and not isinstance(group.get(name, getlink=True), h5py.HardLink):
        raise InputError(f'{path}: "{_where(group, name)}" is a link, not data of this file')
    return group.get(name)


def _where(group: h5py.Group, name: str) -> str:
    return f"{group.name.strip('/')}/{name}".strip("/")


def _dataset_of(path: Path, group: h5py.Group, name: str) -> h5py.Dataset:
    data, where = _own(path, group, name), _where(group, name)
    if not isinstance(data, h5py.Dataset):
        raise InputError(f'{path}: dataset "{where}" is missing')
    if data.external or data.is_virtual:
        raise InputError(f'{path}: "{where}" lies in another file')
    return data


def _case_of(path: Path, file: h5py.File) -> str:
    data = _dataset_of(path, file, "case")
    if data.shape != () or data.dtype.kind not in "SO" or data.dtype.itemsize > MAX_TEXT:
        raise InputError(f"{path}: case: must be a text of at most {MAX_TEXT >> 20} MiB")
    return _text(data[()])


def _column(path: Path, group: h5py.Group, name: str, unit: str, required: bool) -> np.ndarray | None:
    if name not in group and not required:
        return None
    values = _numbers(path, group, name, 1)
    if (found := _text(group[name].attrs.get("unit", ""))) != unit:
        raise InputError(f'{path}: {_where(group, name)}: unit must be "{unit}", got "{found}"')
    return values


def _numbers(path: Path, group: h5py.Group, name: str, ndim: int, width: int = 1) -> np.ndarray:
    """A column of finite numbers, or with ``ndim`` = 2 a table of them, ``width`` to a row."""
    data, where = _dataset_of(path, group, name), _where(group, name)
    if data.ndim != ndim or data.dtype.kind not in "fiu" or (ndim == 2 and data.shape[1] != width):
        kind = "a column of numbers" if ndim == 1 else f"rows of {width} numbers"
        raise InputError(f"{path}: {where}: must be {kind}, got {data.dtype} of shape {data.shape}")
    most = MAX_ROWS if ndim == 1 else MAX_CELLS // width
    if not 1 <= data.shape[0] <= most:
        raise InputError(f"{path}: {where}: must have 1 to {most} rows, got {data.shape[0]}")
    values = data[()].astype(float)
    wrong = ~(np.abs(values) <= MOST**2)
    if wrong.any():
        row, found = np.argwhere(wrong)[0][0], values[wrong][0]
        rule = f"number up to {MOST**2:g}" if np.isfinite(found) else "finite number"
        raise InputError(f"{path}: {where}: row {row + 1} must be a {rule}, got {found}")
    return values


def _first(path: Path, series: h5py.Group, name: str) -> float | None:
    """An attribute of the series at first touch: a finite number >= 0."""
    if name not in series.attrs:
        return None
    value = float(series.attrs[name])
    if not (np.isfinite(value) and value >= 0):
        raise InputError(f"{path}: series: attribute {name} must be finite and >= 0, got {value}")
    return value


def _estimate(value: Any) -> Estimate:
    if isinstance(value, str | bytes) and value:
        return Unknown(_text(value))
    if value is None or isinstance(value, str | bytes):
        return Unknown("not stated in the file")
    return float(value) if np.isfinite(float(value)) else Unknown(f"stated as {float(value)} in the file")


def _attributes(path: Path, file: h5py.File, name: str) -> dict[str, Any]:
    if not isinstance(_own(path, file, name), h5py.Group):
        return {}
    return {key: _plain(path, f"{name}.{key}", value) for key, value in file[name].attrs.items()}


def _plain(path: Path, where: str, value: Any) -> Any:
    """A Python number or text for what h5py returns."""
    if isinstance(value, str | bytes):
        return _text(value)
    if not (isinstance(value, np.generic) and value.dtype.kind in "biuf"):
        raise InputError(f"{path}: attribute {where} must be a number or a text, got {type(value).__name__}")
    number = value.item()
    return str(number) if isinstance(number, float) and not np.isfinite(number) else number


def _text(value: Any) -> str:
    return value.decode("utf-8") if isinstance(value, bytes) else str(value)

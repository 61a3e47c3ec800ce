"""The series file (HDF5): the one door to h5py. Written atomically, checked on reading."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import metadata
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from . import __version__
from .errors import InputError
from .files import HDF5, atomic, read_bytes
from .series import COLUMNS, ErrorBudget, PressureTable, RawSeries, Series, Solution, first_of_plateaus

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
MAX_ROWS = 10_000_000
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
    with atomic(path) as temporary, h5py.File(temporary, "w", libver=CHECKSUMMED) as file:
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
        item.attrs[str(name)] = _fixed(value) if isinstance(value, str) else value


def _fixed(text: str) -> np.ndarray:
    """A string of fixed length: it lies in checksummed metadata, where HDF5's variable-length strings do not."""
    content = text.encode("utf-8")
    return np.array(content, dtype=h5py.string_dtype("utf-8", max(len(content), 1)))


def read(path: str | Path) -> Stored:
    """Read and check a series file; InputError in one line where it is missing, foreign, truncated or damaged."""
    path = Path(path)
    if not read_bytes(path, "series file").startswith(HDF5):
        raise InputError(f"{path}: is not an HDF5 file")
    try:
        with h5py.File(path, "r") as file:
            return _read(path, file)
    except InputError:
        raise
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, UnicodeDecodeError, MemoryError) as error:
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
        case=_text(_dataset_of(path, file, "case")[()]),
        command_line=_text(file.attrs.get("command_line", "")),
        facts=_attributes(file, "facts"),
        timings=_attributes(file, "timings_s"),
        versions=_attributes(file, "versions"),
        warnings=tuple(map(str, _attributes(file, "warnings").values())),
    )


def read_pressure(path: str | Path) -> PressureTable | None:
    """The contact pressure of every increment, where the file holds it."""
    with h5py.File(path, "r") as file:
        if "contact" not in file:
            return None
        return PressureTable(file["contact/r"][()], file["contact/pressure"][()])


def _group(path: Path, file: h5py.File, name: str) -> h5py.Group:
    if not isinstance(file.get(name), h5py.Group):
        raise InputError(f'{path}: group "{name}" is missing')
    return file[name]


def _dataset_of(path: Path, group: h5py.Group, name: str) -> h5py.Dataset:
    where = f"{group.name.strip('/')}/{name}".strip("/")
    if not isinstance(group.get(name), h5py.Dataset):
        raise InputError(f'{path}: dataset "{where}" is missing')
    return group[name]


def _column(path: Path, group: h5py.Group, name: str, unit: str, required: bool) -> np.ndarray | None:
    if name not in group and not required:
        return None
    data = _dataset_of(path, group, name)
    where = f"{group.name.strip('/')}/{name}"
    if data.ndim != 1 or data.dtype.kind not in "fiu":
        raise InputError(f"{path}: {where}: must be a column of numbers, got {data.dtype} of shape {data.shape}")
    if not 1 <= data.size <= MAX_ROWS:
        raise InputError(f"{path}: {where}: must have 1 to {MAX_ROWS} rows, got {data.size}")
    if (found := _text(data.attrs.get("unit", ""))) != unit:
        raise InputError(f'{path}: {where}: unit must be "{unit}", got "{found}"')
    values = data[()].astype(float)
    if not np.isfinite(values).all():
        i = int(np.argmin(np.isfinite(values)))
        raise InputError(f"{path}: {where}: row {i + 1} must be a finite number, got {values[i]}")
    return values


def _first(path: Path, series: h5py.Group, name: str) -> float | None:
    """An attribute of the series at first touch: a finite number >= 0."""
    if name not in series.attrs:
        return None
    value = float(series.attrs[name])
    if not (np.isfinite(value) and value >= 0):
        raise InputError(f"{path}: series: attribute {name} must be finite and >= 0, got {value}")
    return value


def _estimate(value: Any) -> float | str:
    if value is None:
        return "not stated in the file"
    if isinstance(value, str | bytes):
        return _text(value)
    return float(value) if np.isfinite(float(value)) else f"stated as {float(value)} in the file"


def _attributes(file: h5py.File, name: str) -> dict[str, Any]:
    if not isinstance(file.get(name), h5py.Group):
        return {}
    plain = {key: _plain(value) for key, value in file[name].attrs.items()}
    return {
        key: str(value) if isinstance(value, float) and not np.isfinite(value) else value
        for key, value in plain.items()
    }


def _plain(value: Any) -> Any:
    """A Python number or text for what h5py returns."""
    if isinstance(value, bytes | np.bytes_):
        return _text(value)
    return value.item() if isinstance(value, np.generic) else value


def _text(value: Any) -> str:
    return value.decode("utf-8") if isinstance(value, bytes) else str(value)

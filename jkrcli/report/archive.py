"""Maps as images over their pixels; archives (HDF5) of fits and of the tables of sweeps, checked when they are read."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .. import __version__
from ..base import hdf5
from ..base.errors import InputError, counted
from ..base.files import as_json, read_bytes, write_bytes
from ..base.hdf5 import Dataset, Group, unit_column
from ..base.numerics import LEVEL, Array, half_width
from ..base.units import SI, show
from ..fitting.procedure import Failure
from ..fitting.result import Fit
from ..series import COLUMNS, Solution
from .result import SHOWN, Several
from .tables import accuracy

IMAGES = {  # name: dimension
    "E_star": "modulus",
    "w": "work",
    "contact_point": "length",
    "adhesion_force": "load",
    "quality": "number",
    "status": "number",
}
FITTED, DOUBTFUL, UNUSABLE = "fitted", "doubtful", "unusable"
STATUSES = (UNUSABLE, DOUBTFUL, FITTED)  # by their numbers in an image
LEAST_CURVES = 3  # choice: from which on curves without a grid are drawn together, as they are summed up in a line


def status_of(item: Fit | Failure) -> str:
    """Whether a curve was fitted, and is to be believed."""
    return UNUSABLE if isinstance(item, Failure) else DOUBTFUL if item.flags else FITTED


@dataclass(frozen=True, eq=False)
class Map:
    """``images`` (rows, columns) by their names in ``IMAGES``, SI, NaN where nothing was found; ``x, y`` [m] of their
    columns and rows, the rows and columns that hold no curve left out; their numbers where no ``positions`` are
    known."""

    x: Array
    y: Array
    images: Mapping[str, Array]
    positions: bool = True


def map_of(outcomes: Sequence[Fit | Failure]) -> Map | None:
    """The map that the curves make; None where they were not taken on a grid, or several share a pixel."""
    pixels = [item.pixel for item in outcomes if item.pixel is not None]
    if len(pixels) < 2 or len(pixels) != len(outcomes) or len({(at.column, at.row) for at in pixels}) != len(outcomes):
        return None
    columns, column = np.unique([at.column for at in pixels], return_inverse=True)
    rows, row = np.unique([at.row for at in pixels], return_inverse=True)
    placed = all(at.x is not None and at.y is not None for at in pixels)
    x, y = np.array([(at.x, at.y) if placed else (at.column, at.row) for at in pixels], dtype=float).T
    images = {name: np.full((rows.size, columns.size), np.nan) for name in IMAGES}
    values = [_values(item) for item in outcomes]
    for name, image in images.items():
        image[row, column] = [value[name] for value in values]
    return Map(
        np.array([np.mean(x[column == i]) for i in range(columns.size)]),
        np.array([np.mean(y[row == i]) for i in range(rows.size)]),
        images,
        placed,
    )


def _values(item: Fit | Failure) -> dict[str, float]:
    """The pixel of one curve in each image."""
    if isinstance(item, Failure):
        return dict.fromkeys(IMAGES, np.nan) | {"quality": 0.0, "status": 0.0}
    estimates = {estimate.name: estimate.value for estimate in item.estimates}
    return {
        "E_star": estimates.get("E_star", np.nan),
        "w": estimates.get("w", np.nan),
        "contact_point": estimates.get("delta0", np.nan),
        "adhesion_force": np.nan if item.adhesion is None else item.adhesion,
        "quality": np.nan if item.quality is None else item.quality["quality"],
        "status": float(STATUSES.index(status_of(item))),
    }


def images_of(scan: Map) -> Group:
    """A map in HDF5: each image with its unit, and the positions of columns and rows."""
    status = ", ".join(f"{number} {word}" for number, word in enumerate(STATUSES))
    images = {name: unit_column(image, SI[IMAGES[name]], status if name == "status" else "")
              for name, image in scan.images.items()}  # fmt: skip
    length = "m" if scan.positions else "1"
    return Group({}, {"x": unit_column(scan.x, length), "y": unit_column(scan.y, length), **images})


# --------------------------------------------------------------------------------------------------
# Archives (HDF5) of fits and of the tables of sweeps: written under one digest, checked when they are read back.

FITS, SWEEP_TABLE = FORMATS = ("jkr-fit", "jkr-sweep-table")
ARCHIVE_VERSION = 3  # of the file
READ = (1, 2, ARCHIVE_VERSION)
UNPROTECTED = 1  # the version that may lack a digest
WRITE_AGAIN = "run the command that wrote it again"
DOUBT = f"the archive is of version 1 without a digest: damage may go unnoticed; {WRITE_AGAIN} for full protection"


@dataclass(frozen=True, eq=False)
class Archive:
    """What an archive holds; ``is_protected``: damage to any of it would have been found."""

    path: Path
    format: str
    root: hdf5.Group
    is_protected: bool


def write(path: Path, format: str, attributes: Mapping[str, Any], members: Mapping[str, hdf5.Group]) -> None:
    """Write ``members`` to ``path``, whole or not at all."""
    identity = {"format": np.bytes_(format), "version": ARCHIVE_VERSION, "jkr": __version__}
    write_bytes(path, hdf5.image(hdf5.Group({**identity, **attributes}, members)))


def is_archive(path: Path) -> bool:
    """Whether the file at ``path`` says that it is one; what is damaged beyond reading is none."""
    return path.is_file() and hdf5.format_of(path) in FORMATS


def read(path: Path) -> Archive:
    """The archive at ``path``; InputError in one line where it is damaged or of another release."""
    content = read_bytes(path, "archive")
    root = hdf5.tree_of(path, content, remedy=WRITE_AGAIN)
    kind, version = (str(root.attributes.get(name, "")) for name in ("format", "version"))  # or an array, or none
    if kind not in FORMATS:
        raise InputError(f'{path}: format must be one of {", ".join(FORMATS)}, got "{kind}"')
    if version not in map(str, READ):
        raise InputError(
            f"{path}: version must be {ARCHIVE_VERSION}, got {version}; this file needs another release of jkr"
        )
    is_sealed = version != str(UNPROTECTED) or hdf5.SEAL in root.attributes
    if is_sealed and not hdf5.is_sound(root):
        raise hdf5.unreadable(path, content, " (it does not hold what was written)", WRITE_AGAIN)
    return Archive(path, kind, root, is_sealed)


# ---------------------------------------------------------------------- what it holds
def archive_summary(archive: Archive) -> dict[str, Any]:
    """What an archive holds, for machines: the fits of all curves, or the columns of a table with their ends."""
    attributes = archive.root.attributes
    try:
        identity = {
            "file": str(archive.path),
            "format": archive.format,
            "version": attributes["version"],
            "jkr": attributes["jkr"],
        }
        if archive.format == FITS:
            curves = _group(archive.root, "curves").members
            if "summary" in curves:
                summaries = _stored_values(curves["summary"])
            else:  # of versions 1 and 2, a group for each curve
                summaries = [curve.attributes["summary"] for curve in curves.values()]
            contents = {"body": archive.root.attributes["body"], "curves": [json.loads(one) for one in summaries]}
        else:
            columns = {name: _stored_values(member) for name, member in _group(archive.root, "table").members.items()}
            rows = {len(values) for values in columns.values()}
            if len(rows) != 1:
                raise ValueError("columns of several lengths")
            ends = dict[str, list[Any]]()
            for name, values in columns.items():  # least and greatest number, of words the first that occur, in order
                if isinstance(values, list):
                    ends[name] = sorted(set(values))[:SHOWN]
                else:
                    there = values[np.isfinite(values)]
                    ends[name] = [there.min().item(), there.max().item()] if there.size else []
            contents = {"rows": rows.pop(), "columns": ends}
        listing = identity | contents | {"warnings": [] if archive.is_protected else [DOUBT]}
        archive_words(listing), as_json(listing)  # what cannot be told is none
    except (*hdf5.UNREADABLE, AttributeError, RecursionError):  # a number where a group belongs, and the like
        raise InputError(f"{archive.path}: lacks parts of an archive of format {archive.format}") from None
    return listing


def _group(root: hdf5.Group, name: str) -> hdf5.Group:
    member = root.members[name]
    if not isinstance(member, hdf5.Group):
        raise TypeError(name)
    return member


def _stored_values(member: hdf5.Group | hdf5.Dataset) -> Array | list[str]:
    if not isinstance(member, hdf5.Dataset):
        raise TypeError("a group in place of a column")
    return member.values if isinstance(member.values, np.ndarray) else list(member.values or ())


def archive_words(listing: Mapping[str, Any]) -> list[str]:
    """The ``summary`` of an archive as lines of text."""
    by = f"format {listing['format']} {listing['version']}, jkr {listing['jkr']}"
    if listing["format"] == FITS:
        lines = [f"{counted(len(listing['curves']), 'curve')} fitted to {listing['body']}: {listing['file']} ({by})"]
        for curve in listing["curves"][:SHOWN]:
            at_level = f", ± at {100 * curve['level']:g} %" if "level" in curve else ""
            lines.append(f"  {curve['file']}, {curve['curve']}: {curve['status']}{at_level}")
            for name, estimate in curve.get("estimates", {}).items():
                error, ends = estimate.get("standard_error"), (estimate.get("low"), estimate.get("high"))
                if error is not None:
                    error *= half_width(curve["level"])
                if None not in ends:
                    error = (ends[1] - ends[0]) / 2
                within = "" if error is None else f" ± {error:.2g}"
                lines.append(f"    {name:<12} {estimate['value']:.5g}{within} {estimate['unit']}".rstrip())
        lines += [f"  ... and {len(listing['curves']) - SHOWN:,} more"] * (len(listing["curves"]) > SHOWN)
    else:
        lines = [f"{counted(listing['rows'], 'case')} of a sweep: {listing['file']} ({by})"]
        for name, ends in listing["columns"].items():
            in_words = bool(ends) and isinstance(ends[0], str)
            span = ", ".join(ends) if in_words else " to ".join(f"{end:.6g}" for end in dict.fromkeys(ends))
            lines.append(f"  {name:<40} {span}".rstrip())
    return lines + [f"  warning   {warning}" for warning in listing["warnings"]]


# --------------------------------------------------------------------------------------------------
# Fits in HDF5: one table each of the rows, the fitted curves and the samples of all curves together, and summaries.

UNITS = {"a": "m", "delta": "m", "P": "N", "foot_a": "m", "row": "1", "curve": "1"}


def write_fits(path: Path, outcomes: Sequence[Fit | Failure], body: str, summaries: Sequence[str]) -> None:
    """Write all fits to ``path`` with the ``summaries`` of the curves, JSON each: a curve has its number from 0 in
    order. ``body``: what they were fitted to, in words."""
    fits = [(number, item) for number, item in enumerate(outcomes) if isinstance(item, Fit)]
    tables: dict[str, list[tuple[int, dict[str, Array]]]] = {"data": [], "fitted": [], "bootstrap": []}
    for number, item in fits:
        # Readings, the numbers of their rows from 1, contact radii, and residuals in units of the scatter
        names = ["residuals"] if len(item.residuals) == 1 else [f"residuals_{name}" for name in item.scales]
        residuals = dict(zip(names, item.residuals, strict=True))
        tables["data"].append((number, {**item.data, "row": item.rows + 1, "foot_a": item.a, **residuals}))
        tables["fitted"].append((number, dict(item.line)))
        if item.samples is not None:
            tables["bootstrap"].append((number, dict(zip(item.free, item.samples.T, strict=True))))
    curves: dict[str, Group | Dataset] = {name: _joined(table) for name, table in tables.items() if table}
    curves["summary"] = Dataset(summaries)
    images = {"map": images_of(scan)} if (scan := map_of(outcomes)) else {}
    write(path, FITS, {"body": body}, {"curves": Group({}, curves), **images})


def _joined(tables: Sequence[tuple[int, Mapping[str, Array]]]) -> Group:
    """Tables of several curves as one, with a column of their numbers; NaN where a curve has no such column."""
    sizes = [next(iter(table.values())).size for _, table in tables]
    members = {"curve": unit_column(np.repeat([number for number, _ in tables], sizes), UNITS["curve"])}
    for name in dict.fromkeys(name for _, table in tables for name in table):
        parts = (table[name] if name in table else np.full(size, np.nan)
                 for (_, table), size in zip(tables, sizes, strict=True))  # fmt: skip
        members[name] = unit_column(np.concatenate([*parts]), UNITS.get(name, "1" if "residuals" in name else "SI"))
    return Group({}, members)


# --------------------------------------------------------------------------------------------------
# What files hold, for people and machines: series with their errors, facts and case; archives of fits and sweeps.


@dataclass(frozen=True, eq=False)
class Shown(Several):
    """What each file holds: a series, or the summary of an archive."""

    contents: Sequence[Solution | Mapping[str, Any]]

    def summary(self) -> dict[str, Any]:
        return {"files": [_as_dict(item) if isinstance(item, Solution) else item for item in self.contents]}

    @property
    def parts(self) -> Sequence[Sequence[str]]:
        return [_words(item) if isinstance(item, Solution) else archive_words(item) for item in self.contents]


def _as_dict(solution: Solution) -> dict[str, Any]:
    raw = solution.increments
    return {
        "file": str(solution.record.path),
        "method": solution.method,
        "problem_key": solution.problem.key,
        "surface": solution.problem.surface,
        "command_line": solution.record.command_line,
        "rows": raw.a.size,
        "columns": _columns(solution),
        "range": {"a_m": _ends_of_shown(raw.a), "delta_m": _ends_of_shown(raw.delta), "P_N": _ends_of_shown(raw.P)},
        "level": LEVEL,
        "errors": solution.budget.as_dict(),
        "facts": {name: _plain(value) for name, value in solution.facts.items()},
        "timings_s": dict(solution.timings),
        "versions": dict(solution.record.versions),
        "warnings": list(solution.warnings),
    }


def _words(solution: Solution) -> list[str]:
    raw = solution.increments
    lines = [
        f"{counted(raw.a.size, 'row')} by method {solution.method}, {accuracy(solution.budget.total)}: "
        f"{solution.record.path}",
        f"  columns   {', '.join(_columns(solution))}",
        f"  a         {show(raw.a[0], 'length')} to {show(raw.a[-1], 'length')}",
        f"  delta     {show(raw.delta[0], 'length')} to {show(raw.delta[-1], 'length')}",
        f"  P         {show(raw.P[0], 'load')} to {show(raw.P[-1], 'load')}",
        f"  surface   {solution.problem.surface}",
        f"  written   by: {solution.record.command_line or 'unknown'}",
    ]
    lines += [f"  warning   {warning}" for warning in solution.warnings]
    lines += [f"  error     {name}: {_number(value)}" for name, value in solution.budget.as_dict().items()]
    lines += [f"  fact      {name}: {_number(_plain(value))}" for name, value in solution.facts.items()]
    for name, seconds in solution.timings.items():
        lines.append(f"  time      {name}: {f'{seconds:.3f}' if isinstance(seconds, int | float) else seconds} s CPU")
    lines += [f"  version   {name} {version}" for name, version in solution.record.versions.items()]
    return [*lines, "  case", *(f"    {line}" for line in solution.record.toml.splitlines() if line)]


def _columns(solution: Solution) -> list[str]:
    return [name for name in COLUMNS if getattr(solution.filtered, name) is not None]


def _ends_of_shown(values: Any) -> list[float]:
    return [float(values[0]), float(values[-1])]


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else value


def _number(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)

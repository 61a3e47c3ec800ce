"""Archives (HDF5) of fits and of the tables of sweeps, checked when they are read; what files hold."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import __version__
from ..base import hdf5
from ..base.errors import LEVEL, InputError, accuracy, counted, known
from ..base.files import as_json, read_bytes, write_bytes
from ..base.numerics import Array, half_width
from ..base.units import show
from .result import SHOWN, Several

if TYPE_CHECKING:
    from ..series import Solution

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
# What files hold, for people and machines: series with their errors, facts and case; archives of fits and sweeps.


@dataclass(frozen=True, eq=False)
class Shown(Several):
    """What each file holds: a series, or the summary of an archive."""

    contents: Sequence[Solution | Mapping[str, Any]]

    def summary(self) -> dict[str, Any]:
        return {"files": [item if isinstance(item, Mapping) else _as_dict(item) for item in self.contents]}

    @property
    def parts(self) -> Sequence[Sequence[str]]:
        return [archive_words(item) if isinstance(item, Mapping) else _words(item) for item in self.contents]


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
    lines += [f"  error     {name}: {_number(value)}" for name, value in vars(solution.budget).items() if known(value)]
    lines += [f"  fact      {name}: {_number(_plain(value))}" for name, value in solution.facts.items()]
    for name, seconds in solution.timings.items():
        lines.append(f"  time      {name}: {f'{seconds:.3f}' if isinstance(seconds, int | float) else seconds} s CPU")
    lines += [f"  version   {name} {version}" for name, version in solution.record.versions.items()]
    return [*lines, "  case", *(f"    {line}" for line in solution.record.toml.splitlines() if line)]


def _columns(solution: Solution) -> list[str]:
    from ..series import COLUMNS

    return [name for name in COLUMNS if getattr(solution.filtered, name) is not None]


def _ends_of_shown(values: Any) -> list[float]:
    return [float(values[0]), float(values[-1])]


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else value


def _number(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)

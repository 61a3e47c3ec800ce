"""Archives (HDF5) of fits and of the tables of sweeps: written under one digest, checked when they are read back."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .. import __version__
from ..base import Array, InputError, as_json, hdf5, read_bytes, write_bytes
from .result import SHOWN

FITS, SWEEP_TABLE = FORMATS = ("jkr-fit", "jkr-sweep-table")
VERSION = 3  # of the file
READ = (1, 2, VERSION)
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
    identity = {"format": np.bytes_(format), "version": VERSION, "jkr": __version__}
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
        raise InputError(f"{path}: version must be {VERSION}, got {version}; this file needs another release of jkr")
    is_sealed = version != str(UNPROTECTED) or hdf5.SEAL in root.attributes
    if is_sealed and not hdf5.is_sound(root):
        raise hdf5.unreadable(path, content, " (it does not hold what was written)", WRITE_AGAIN)
    return Archive(path, kind, root, is_sealed)


# ---------------------------------------------------------------------- what it holds
def summary(archive: Archive) -> dict[str, Any]:
    """What an archive holds, for machines: the fits of all curves, or the columns of a table with their ends."""
    attributes = archive.root.attributes
    try:
        identity = {
            "file": str(archive.path),
            "format": archive.format,
            "version": attributes["version"],
            "jkr": attributes["jkr"],
        }
        contents = _fits(archive.root) if archive.format == FITS else _table(archive.root)
        listing = identity | contents | {"warnings": [] if archive.is_protected else [DOUBT]}
        words(listing), as_json(listing)  # what cannot be told is none
    except (*hdf5.UNREADABLE, AttributeError, RecursionError):  # a number where a group belongs, and the like
        raise InputError(f"{archive.path}: does not hold what an archive of format {archive.format} does") from None
    return listing


def _fits(root: hdf5.Group) -> dict[str, Any]:
    curves = _group(root, "curves").members
    if "summary" in curves:
        summaries = _values(curves["summary"])
    else:  # of versions 1 and 2, a group for each curve
        summaries = [curve.attributes["summary"] for curve in curves.values()]
    return {"body": root.attributes["body"], "curves": [json.loads(one) for one in summaries]}


def _table(root: hdf5.Group) -> dict[str, Any]:
    columns = {name: _values(member) for name, member in _group(root, "table").members.items()}
    rows = {len(values) for values in columns.values()}
    if len(rows) != 1:
        raise ValueError("columns of several lengths")
    return {"rows": rows.pop(), "columns": {name: _ends(values) for name, values in columns.items()}}


def _group(root: hdf5.Group, name: str) -> hdf5.Group:
    member = root.members[name]
    if not isinstance(member, hdf5.Group):
        raise TypeError(name)
    return member


def _values(member: hdf5.Group | hdf5.Dataset) -> Array | list[str]:
    if not isinstance(member, hdf5.Dataset):
        raise TypeError("a group in place of a column")
    return member.values if isinstance(member.values, np.ndarray) else list(member.values or ())


def _ends(values: Array | list[str]) -> list[Any]:
    """Least and greatest number of a column; of words the first that occur, in order."""
    if isinstance(values, list):
        return sorted(set(values))[:SHOWN]
    there = values[np.isfinite(values)]
    return [there.min().item(), there.max().item()] if there.size else []


def words(listing: Mapping[str, Any]) -> list[str]:
    """The ``summary`` of an archive as lines of text."""
    by = f"format {listing['format']} {listing['version']}, jkr {listing['jkr']}"
    if listing["format"] == FITS:
        lines = [f"{len(listing['curves']):,} curves fitted to {listing['body']}: {listing['file']} ({by})"]
        lines += [line for curve in listing["curves"][:SHOWN] for line in _curve(curve)]
        lines += [f"  ... and {len(listing['curves']) - SHOWN:,} more"] * (len(listing["curves"]) > SHOWN)
    else:
        lines = [f"{listing['rows']:,} cases of a sweep: {listing['file']} ({by})"]
        lines += [f"  {name:<40} {_span(ends)}".rstrip() for name, ends in listing["columns"].items()]
    return lines + [f"  warning   {warning}" for warning in listing["warnings"]]


def _curve(curve: Mapping[str, Any]) -> list[str]:
    lines = [f"  {curve['file']}, {curve['curve']}: {curve['status']}"]
    for name, estimate in curve.get("estimates", {}).items():
        error = estimate.get("standard_error")
        within = "" if error is None else f" ± {error:.2g}"
        lines.append(f"    {name:<12} {estimate['value']:.5g}{within} {estimate['unit']}".rstrip())
    return lines


def _span(ends: list[Any]) -> str:
    if ends and isinstance(ends[0], str):
        return ", ".join(ends)
    return " to ".join(f"{end:.6g}" for end in dict.fromkeys(ends))

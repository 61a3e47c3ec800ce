"""Whether the file of a microscope is whole, before a package reads it that takes what is there for what was written:
checksums, declared sizes and counts, and what it would unpack to."""

from __future__ import annotations

import re
import struct
from pathlib import Path

from ...base import allowance, hdf5
from ...base.errors import InputError
from ...base.files import read_bytes
from . import archive

WHAT = "file of force curves"
AGAIN = "export it again"
HEAD, WAVE = 384, 64  # bytes: both heads of Igor's binary wave of version 5, and the first of them
PIXELS = re.compile(rb"\.grid\.[ij]length\s*[=: ]\s*(\d+)(?:\.\d*)?(?:[eE]\+?(\d+))?")  # of the grid of a JPK map


def check(path: Path) -> None:
    """InputError where the file at ``path`` is damaged, cut off, or takes more than is allowed, as far as its format
    lets that be seen."""
    ending = path.suffix.lower()
    if ending == ".zip" or ending.startswith(".jpk"):
        _members(path, allowance.TUNING.text if ending == ".zip" else None)
    elif ending == ".h5":
        hdf5.parse(path, read_bytes(path, WHAT), remedy=AGAIN)
    elif ending == ".ibw":
        _wave(path, read_bytes(path, WHAT))
    else:
        with allowance.reading(path) as allowed:
            content = read_bytes(path, WHAT, allowance.TUNING.text)
            allowed.take(rows=content.count(b"\n"))
        if ending == ".tab":
            _export(path, content)


def _members(path: Path, size: int | None) -> None:
    """A zip archive: all of its members are unpacked once."""
    found = archive.members(path, size)
    for item, content in zip(found, archive.contents(path, found), strict=True):
        if item.filename.endswith(".properties"):
            with allowance.reading(path) as allowed:
                allowed.take(parts=sum(int(many[:20]) * 10 ** int(power[:2] or 0) for many, power in PIXELS.findall(content)))


def _wave(path: Path, content: bytes) -> None:
    """Igor's binary wave of version 5 (its Technical Note 003): words of the heads add up to zero, sizes to the file's."""
    order = {b"\5\0": "<", b"\0\5": ">"}.get(content[:2])
    if order is None or len(content) < HEAD:
        raise InputError(f"{path}: is no binary wave of version 5, or cut off: {AGAIN}")
    if sum(struct.unpack(f"{order}{HEAD // 2}h", content[:HEAD])) & 0xFFFF:
        raise InputError(f"{path}: is damaged (the checksum of its head is wrong): {AGAIN}")
    sizes = struct.unpack_from(f"{order}15l", content, 4)
    if min(sizes) < 0 or WAVE + sum(sizes) > len(content):
        raise InputError(f"{path}: is cut off: holds {len(content):,} bytes of {WAVE + sum(sizes):,}: {AGAIN}")


def _export(path: Path, content: bytes) -> None:
    """A table as afmformats exports it: every row has all cells, and ends."""
    lines = content.split(b"\n")
    rows = [(n, line) for n, line in enumerate(lines) if line.strip() and not line.startswith(b"#")]
    titles = next((line for line in reversed(lines[: rows[0][0]]) if line.startswith(b"#")), b"") if rows else b""
    wanted = titles.count(b"\t") + 1
    for n, line in rows:
        if wanted > 1 and (cells := line.count(b"\t") + 1) != wanted:
            raise InputError(f"{path}: line {n + 1} holds {cells} cells of {wanted}: {AGAIN}")
    if wanted > 1 and lines[-1]:
        raise InputError(f"{path}: is cut off, its last line does not end: {AGAIN}")

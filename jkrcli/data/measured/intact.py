"""Whether the file of a microscope is whole, before a package reads it that takes what is there for what was written:
checksums, declared sizes and counts, and what it would unpack to."""

from __future__ import annotations

import re
import struct
from pathlib import Path

from ...base import InputError, allowance_of, most_text, read_bytes, tree_of
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
        _members(path, most_text() if ending == ".zip" else None)
    elif ending == ".h5":
        tree_of(path, read_bytes(path, WHAT), remedy=AGAIN)
    elif ending == ".ibw":
        _wave(path, read_bytes(path, WHAT))
    else:
        with allowance_of(path, fenced=False) as allowed:
            content = read_bytes(path, WHAT, most_text())
            allowed.take_text(content.decode("latin-1"))
        if ending == ".tab":
            _export(path, content)


def _members(path: Path, size: int | None) -> None:
    """A zip archive: all of its members are unpacked once."""
    members = archive.members(path, size)
    for item, content in zip(members, archive.contents(path, members), strict=True):
        if item.filename.endswith(".properties"):
            with allowance_of(path) as allowed:
                for many, power in PIXELS.findall(content):
                    allowed.take(parts=min(int(many[:15]) * 10 ** int(power[:2] or 0), 10**15))


def _wave(path: Path, content: bytes) -> None:
    """Igor's binary wave of version 5 (its Technical Note 003): heads whose words add up to zero, and sizes."""
    order = {b"\5\0": "<", b"\0\5": ">"}.get(content[:2])
    if order is None or len(content) < HEAD:
        raise InputError(f"{path}: is no binary wave of version 5, or cut off: {AGAIN}")
    if sum(struct.unpack(f"{order}{HEAD // 2}h", content[:HEAD])) & 0xFFFF:
        raise InputError(f"{path}: is damaged (the checksum of its head is wrong): {AGAIN}")
    sizes = struct.unpack_from(f"{order}15l", content, 4)
    if min(sizes) < 0 or WAVE + sum(sizes) > len(content):
        raise InputError(f"{path}: is cut off: holds {len(content):,} bytes of {WAVE + sum(sizes):,}: {AGAIN}")


def _export(path: Path, content: bytes) -> None:
    """A table as afmformats exports it: all rows have as many cells, and end."""
    lines = content.split(b"\n")
    cells = {n: line.count(b"\t") + 1 for n, line in enumerate(lines, start=1) if line.strip() and line[:1] != b"#"}
    wanted = next(iter(cells.values()), 1)
    if short := [n for n, count in cells.items() if count != wanted]:
        raise InputError(f"{path}: line {short[0]} holds {cells[short[0]]} cells, not {wanted} as the first: {AGAIN}")
    if wanted > 1 and lines[-1]:
        raise InputError(f"{path}: is cut off, its last line does not end: {AGAIN}")

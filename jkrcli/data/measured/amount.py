"""How much measured files hold, estimated from their size and first lines before they are read."""

from __future__ import annotations

from pathlib import Path

from ...base import LOOKED_AT, InputError, opened, packed
from . import archive

WIDE = 160.0  # bytes, from which on a row costs by its length; tuned on tables of 12 to 1000 columns, by `make guards`
USUAL = 40.0  # choice: bytes of a row of files without lines, those of microscopes


def rows_expected(path: Path) -> float:
    """About how many rows the file at ``path`` holds, more of wide ones, which take as long.

    0 where it cannot be read, which its reader says, and of pipes, which would be waited for.
    """
    try:
        if not path.is_file():
            return 0.0
        if path.suffix.lower() == ".zip":
            inside = archive.tables(path)
            # each table costs as many rows beside its own as are looked at to see how it is written
            heads = archive.contents(path, inside, archive.PIECE)
            return sum(_rows(item.file_size, head) + LOOKED_AT for item, head in zip(inside, heads, strict=True))
        if path.suffix.lower().startswith(".jpk"):
            return sum(item.file_size for item in archive.members(path)) / USUAL
        if packed(path):
            with path.open("rb") as file:
                file.seek(-4, 2)
                size = int.from_bytes(file.read(4), "little")  # RFC 1952: of what it unpacks to
            with opened(path, "table") as file:
                return _rows(size, file.read(archive.PIECE))
        with path.open("rb") as file:
            return _rows(path.stat().st_size, file.read(archive.PIECE))
    except (InputError, OSError, ValueError):
        return 0.0


def _rows(size: int, first: bytes) -> float:
    """About how many rows stand in so many bytes, by those that come ``first``."""
    rows = first.count(b"\n") / max(len(first), 1)  # per byte
    return size * (max(rows, 1 / WIDE) if rows else 1 / USUAL)

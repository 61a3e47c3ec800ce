"""Zip archives as instruments write them: their members one by one, proved against their checksums, none unpacked to
disk."""

from __future__ import annotations

import contextlib
import struct
import zipfile
import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path, PurePosixPath

from ...base import InputError, allowance_of, first_line, most_text, opened

ENDINGS = (".txt", ".csv", ".tsv", ".dat", ".asc", ".tab")
PIECE = 1 << 16  # choice: bytes read at a time, and of a table to estimate the length of its rows
LONGEST_END = (1 << 16) + 200  # bytes of the records at the end, with the comment that may follow
ENTRY = b"PK\1\2"  # how a member begins in the list of members
PACKED = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # the others unpack without a limit, bzip2 a million times as much
WRONG = (OSError, RuntimeError, EOFError, ValueError, KeyError, struct.error, zipfile.BadZipFile, zlib.error)  # damage


class NoTablesError(InputError):
    """An archive that holds no text table."""


def members(path: Path, size: int | None = None, chosen: Callable[[str], bool] = bool) -> list[zipfile.ZipInfo]:
    """The members of an archive with ``chosen`` names; InputError where it is damaged, would unpack to more than
    ``size`` bytes (None: what is allowed of any file), or holds one of them twice."""
    with allowance_of(path, size) as allowed:
        with opened(path, "zip archive") as whole:  # counted before their list is made
            allowed.take(parts=sum(piece.count(ENTRY) for piece in iter(lambda: whole.read(PIECE), b"")))
        with _opened(path) as file:
            listed = file.infolist()
        wanted = [item for item in listed if chosen(item.filename)]
        allowed.take(sum(item.file_size for item in wanted))
    if len(listed) != (declared := _declared(path)):
        raise InputError(f"{path}: is damaged: its list holds {len(listed):,} members of {declared:,}")
    name, times = next(iter(Counter(item.filename for item in wanted).most_common(1)), ("", 0))
    if times > 1:
        raise InputError(f"{path}: holds {name} {times} times")
    return wanted


def tables(path: Path) -> list[zipfile.ZipInfo]:
    """The text tables of an archive; InputError where there are none, or as ``members`` does."""
    if inside := members(path, most_text(), _is_table):
        return inside
    raise NoTablesError(f"{path}: holds no text table ({', '.join(ENDINGS)})")


def contents(path: Path, chosen: Sequence[zipfile.ZipInfo], most: int | None = None) -> Iterator[bytes]:
    """The contents of members, or ``most`` bytes from their begin, one after the other; InputError where one does not
    hold what its checksum and size say."""
    for content in each_content(path, chosen, most):
        if isinstance(content, InputError):
            raise content
        yield content


def each_content(
    path: Path, chosen: Sequence[zipfile.ZipInfo], most: int | None = None
) -> Iterator[bytes | InputError]:
    """The same, but that of a damaged member comes as its error, and the others follow."""
    with _opened(path) as file:
        for item in chosen:
            content: bytes | InputError
            try:
                content = _unpacked(file, item, most)
            except WRONG as error:
                content = InputError(f"{path}: {item.filename} cannot be unpacked ({first_line(error)})")
            yield content


def titles(chosen: Sequence[zipfile.ZipInfo]) -> list[str]:
    """What tables are called: by their names without folder and ending, unless these are not unique."""
    stems = [PurePosixPath(item.filename).stem for item in chosen]
    whole = [str(PurePosixPath(item.filename).with_suffix("")) for item in chosen]
    return stems if len(set(stems)) == len(stems) else whole


def _declared(path: Path) -> int:
    """How many members an archive says that it holds, at its end (APPNOTE of the format, 4.3.14 and 4.3.16)."""
    with opened(path, "zip archive") as whole:
        whole.seek(max(0, whole.seek(0, 2) - LONGEST_END))
        end = whole.read()
    at, long = end.rfind(b"PK\5\6"), end.rfind(b"PK\6\6")
    return int.from_bytes(end[at + 10 : at + 12] if long < 0 else end[long + 32 : long + 40], "little")


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[zipfile.ZipFile]:
    with opened(path, "zip archive") as whole:
        try:
            file = zipfile.ZipFile(whole)
        except WRONG as error:
            raise InputError(f"{path}: cannot be read as a zip archive ({first_line(error)})") from None
        with file:
            yield file


def _unpacked(file: zipfile.ZipFile, item: zipfile.ZipInfo, most: int | None) -> bytes:
    """The content of a member, no more than the size in its head: read in pieces, else all that it unpacks to would
    come before the cut."""
    if item.compress_type not in PACKED:
        raise NotImplementedError("neither stored nor deflated: pack it anew")
    with file.open(item) as packed:
        if most is not None:
            return packed.read(most)
        content = b"".join(iter(lambda: packed.read(PIECE), b""))
    if len(content) != item.file_size:
        raise EOFError(f"holds {len(content):,} bytes of {item.file_size:,}")
    return content


def _is_table(name: str) -> bool:
    path = PurePosixPath(name)
    hidden = any(part.startswith((".", "__MACOSX")) for part in path.parts)
    return path.suffix.lower() in ENDINGS and not hidden and not name.endswith("/")

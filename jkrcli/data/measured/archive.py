"""Zip archives of text tables, as instruments write them: the tables one by one, none unpacked to disk."""

from __future__ import annotations

import zipfile
import zlib
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from ...base.errors import InputError, first_line
from ...base.files import opened

ENDINGS = (".txt", ".csv", ".tsv", ".dat", ".asc", ".tab")
MOST = 1 << 28  # choice: bytes of all tables of an archive together, before anything is unpacked
PIECE = 1 << 16  # choice: bytes unpacked at a time
PACKED = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # the others unpack without a limit, bzip2 a million times as much


class NoTablesError(InputError):
    """An archive that holds no text table."""


@dataclass(frozen=True)
class Tables:
    """The text tables of the archive at ``path``, by the ``names`` of their members: pairs of name and content."""

    path: Path
    names: Sequence[str]

    def __len__(self) -> int:
        return len(self.names)

    def __iter__(self) -> Iterator[tuple[str, bytes]]:
        stems = [PurePosixPath(name).stem for name in self.names]
        unique = len(set(stems)) == len(stems)
        with opened(self.path, "zip archive") as whole, zipfile.ZipFile(whole) as file:
            for member, stem in zip(self.names, stems, strict=True):
                try:
                    content = _unpacked(file, member)
                except (OSError, RuntimeError, NotImplementedError, EOFError, zipfile.BadZipFile, zlib.error) as error:
                    raise InputError(f"{self.path}: {member} cannot be unpacked ({first_line(error)})") from None
                yield stem if unique else str(PurePosixPath(member).with_suffix("")), content


def tables(path: Path) -> Tables:
    """The text tables of an archive; InputError where it is damaged, holds none, or would unpack to too much."""
    try:
        with opened(path, "zip archive") as whole, zipfile.ZipFile(whole) as file:
            members = [item for item in file.infolist() if _is_table(item.filename)]
    except (NotImplementedError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: cannot be read as a zip archive ({first_line(error)})") from None
    if not members:
        raise NoTablesError(f"{path}: holds no text table ({', '.join(ENDINGS)})")
    size = sum(item.file_size for item in members)
    if size > MOST:
        raise InputError(f"{path}: its tables unpack to {size >> 20} MiB, at most {MOST >> 20} MiB are read")
    names = [item.filename for item in members]
    name, times = Counter(names).most_common(1)[0]
    if times > 1:
        raise InputError(f"{path}: holds {name} {times} times")
    return Tables(path, names)


def _unpacked(file: zipfile.ZipFile, member: str) -> bytes:
    """The content of a member, no more than the size that it is said to have: read in pieces, else all that it unpacks
    to would come before the cut."""
    if file.getinfo(member).compress_type not in PACKED:
        raise NotImplementedError("neither stored nor deflated: pack it anew")
    with file.open(member) as packed:
        return b"".join(iter(lambda: packed.read(PIECE), b""))


def _is_table(name: str) -> bool:
    path = PurePosixPath(name)
    hidden = any(part.startswith((".", "__MACOSX")) for part in path.parts)
    return path.suffix.lower() in ENDINGS and not hidden and not name.endswith("/")

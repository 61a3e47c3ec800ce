"""The journal of a sweep: a line per finished case, appended as results come in and readable after any end."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ... import __version__
from ...base import InputError, JkrError, locks
from .plan import FAILED, OK, Row

FORMAT, VERSION = "jkr-sweep-journal", 2  # type and version of the file
HEAD = json.dumps({"format": FORMAT, "version": VERSION, "jkr": __version__}).encode() + b"\n"
ENTRY = [str, str, str, list, float]  # of a line: identity, status, reason, values, CPU seconds; then their digest
MOST_BYTES = 1 << 31  # theory: of all lines, which are read at once: MOST_CELLS numbers of 21 characters


class Journal:
    """Finished cases by their identity (a hash of all that a row depends on), in memory and in the file behind it.

    ``damaged``: numbers of the lines that do not hold what was written; their cases count as not done.
    """

    def __init__(self, path: Path, file: io.FileIO):
        self.path = path
        self.rows: dict[str, Row] = {}
        self.damaged: list[int] = []
        self._file = file
        self._synced = time.monotonic()

    def append(self, identity: str, row: Row) -> None:
        """Keep a finished case; a repeated identity replaces the earlier row."""
        entry = [identity, row.status, row.reason, row.values, round(row.seconds, 6)]
        self._write(_sealed(json.dumps(entry, allow_nan=False).encode()) + b"\n")
        self.rows[identity] = row
        if time.monotonic() - self._synced > 5.0:  # that a power failure may cost; a killed process loses nothing
            self.sync()

    def _write(self, line: bytes) -> None:
        """Append to the file as far as there is room; what is cut off then, the next run takes away."""
        try:
            while line:
                line = line[self._file.write(line) :]
        except OSError as error:
            raise JkrError(f"{self.path}: cannot be written ({error.strerror})") from None

    def sync(self) -> None:
        """Make sure that the file is on the disk."""
        try:
            os.fsync(self._file.fileno())
        except OSError as error:
            raise JkrError(f"{self.path}: cannot be written ({error.strerror})") from None
        self._synced = time.monotonic()

    def forget_failed(self) -> int:
        """Count failed cases as not done; returns how many."""
        wrong = [identity for identity, row in self.rows.items() if row.status == FAILED]
        for identity in wrong:
            del self.rows[identity]
        return len(wrong)

    def read(self) -> None:
        """Take in what earlier runs appended; a last line without its end was being written when they were killed."""
        content = self._file.read()
        if HEAD.startswith(content):
            self._file.seek(0)
            self._write(HEAD)
            return
        whole = content.rfind(b"\n") + 1
        head, *lines = content[:whole].splitlines() or [b""]
        self._check_head(head)
        self._file.truncate(whole)
        self._file.seek(whole)
        for number, line in enumerate(lines, start=2):
            if (entry := _entry(line)) is None:
                self.damaged.append(number)
                continue
            identity, status, reason, values, seconds = entry
            self.rows[identity] = Row(-1, status, reason, tuple(values), seconds)

    def _check_head(self, line: bytes) -> None:
        """Refuse to append to what is no journal of this format."""
        head = _parsed(line)
        if not isinstance(head, dict) or head.get("format") != FORMAT or head.get("version") != VERSION:
            raise InputError(
                f"{self.path}: is no journal of a sweep (line 1 must name the format {FORMAT}, version {VERSION}); "
                "give another folder"
            )


def _sealed(entry: bytes) -> bytes:
    """A list in JSON with the digest of its text as its last item."""
    return entry[:-1] + b', "' + hashlib.sha256(entry).hexdigest()[:16].encode() + b'"]'


def _entry(line: bytes) -> list[Any] | None:
    """The entry of a line; None where the line is not as it was written."""
    entry = line.rpartition(b", ")[0] + b"]"
    values = _parsed(entry) if _sealed(entry) == line else None
    is_sound = isinstance(values, list) and list(map(type, values)) == ENTRY and values[1] in (OK, FAILED)
    return values if is_sound else None


def _parsed(line: bytes) -> Any:
    try:
        return json.loads(line)
    except (ValueError, RecursionError):
        return None


@contextlib.contextmanager
def opened(path: Path) -> Iterator[Journal]:
    """The journal at ``path``, made where there is none; InputError where another process is writing it, or it is none
    that can be read."""
    if path.exists() and not path.is_file():
        raise InputError(f"{path}: is a folder, a device or a pipe, not a journal; give another folder")
    try:
        file = path.open("r+b" if path.exists() else "w+b", buffering=0)
    except OSError as error:
        raise JkrError(f"{path}: cannot be opened ({error.strerror})") from None
    with file:
        if locks.taken(file) is False:
            raise InputError(f"{path}: another jkr sweep is writing there; wait for it, or give another folder")
        if os.fstat(file.fileno()).st_size > MOST_BYTES:
            raise InputError(f"{path}: journal is larger than {MOST_BYTES >> 20} MiB; give another folder")
        journal = Journal(path, file)
        journal.read()
        try:
            yield journal
        finally:
            journal.sync()

"""What reading a foreign file may take: one allowance of bytes, parts, rows and memory, which every reader spends."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from .errors import InputError
from .memory import SHARE, fence, free_memory


@dataclass(frozen=True)
class AllowanceTuning:
    """The most that is read of one file."""

    size: int = 1 << 30  # choice: bytes of a file as it lies there, and of all that it unpacks to
    text: int = 1 << 28  # choice: bytes of tables in text, which take some ten times as much in memory
    parts: int = 500_000  # choice: members, groups, data sets with their chunks and attributes, which take 50 us each
    rows: int = 10_000_000  # choice: lines of text, words in columns
    # choice: bytes of memory of a row of text and of each of its bytes, measured 250 to 530 and 8 to 18 on tables of 2
    # to 400 columns
    parsed: tuple[int, int] = (400, 8)
    copies: int = 4  # choice: of a text in a binary file while it is read
    chunk: int = 4000  # choice: bytes of memory that a library takes for each chunk of a data set, measured
    little: int = 1 << 28  # choice: bytes of memory for which that of the machine is not looked up


TUNING = AllowanceTuning()
LINE_ENDS = "\n\r\v\f\x1c\x1d\x1e\x85\u2028\u2029"  # as ``str.splitlines`` has them
REMEDY = "split it, free memory or raise ulimit -v"
NO_ROOM = re.compile(r"(can't|unable to|cannot|not) allocate|allocation failed", re.IGNORECASE)  # as libraries say it


class Allowance:
    """The allowance of a foreign file at ``path``, ``size`` bytes of it at most, and what is taken of it; InputError in
    one line where that is too much."""

    def __init__(self, path: Path | str, size: int) -> None:
        self.path, self.memory = path, 0
        self.most = {"unpacked bytes": size, "parts": TUNING.parts, "rows": TUNING.rows}
        self.taken = dict.fromkeys(self.most, 0)

    def take(self, size: int = 0, parts: int = 0, rows: int = 0, memory: int = 0) -> None:
        """Count what is about to be read; ``memory``: bytes that it takes beside its own."""
        for name, more in zip(self.most, (size, parts, rows), strict=True):
            self.taken[name] += more
            if self.taken[name] > self.most[name]:
                raise InputError(f"{self.path}: holds {self.taken[name]:,} {name} or more, at most "
                                 f"{self.most[name]:,} are read of one file")  # fmt: skip
        self.memory += size + memory
        if self.memory > TUNING.little and self.memory > (most := SHARE * free_memory() * 2**20):
            raise InputError(f"{self.path}: takes {self.memory / 2**30:.2g} GiB of memory or more to read, "
                             f"{most / 2**30:.2g} GiB may be taken: {REMEDY}")  # fmt: skip

    def take_text(self, text: str) -> None:
        """Count a text that is about to be taken apart into rows."""
        rows = sum(map(text.count, LINE_ENDS)) - text.count("\r\n")
        per_row, per_byte = TUNING.parsed
        self.take(len(text), rows=rows, memory=per_row * rows + per_byte * len(text))


def most_text() -> int:
    """Bytes of tables in text that are read of one file."""
    return TUNING.text


@contextlib.contextmanager
def allowance_of(path: Path | str, size: int | None = None, fenced: bool = True) -> Iterator[Allowance]:
    """The allowance of a block that reads the file at ``path``. One InputError where memory runs out, whatever the
    library raises; ``fenced``: before a library takes more than the largest file and all that it unpacks to, whatever
    a small file declares."""
    try:
        with fence(2 * TUNING.size) if fenced else contextlib.nullcontext():
            yield Allowance(path, TUNING.size if size is None else size)
    except Exception as error:
        if isinstance(error, InputError) or not (isinstance(error, MemoryError) or NO_ROOM.search(str(error))):
            raise
        raise InputError(f"{path}: takes more memory to read than may be taken: {REMEDY}") from None

"""A line of progress for long work: on a terminal only, on stderr, rewritten in place."""

from __future__ import annotations

import sys
import time
from typing import TextIO

EVERY = 0.2  # seconds between two drawings
WIDTH = 24  # characters of the bar
NEAR_FULL = 60  # seconds up to which the time left is given in seconds


class Progress:
    """``label [####----] 120/1000, 3 failed, 2 min left``; silent where ``stream`` is no terminal."""

    def __init__(self, label: str, total: int, stream: TextIO | None = None):
        self.label, self.total, self.done, self.failed = label, total, 0, 0
        self._stream = sys.stderr if stream is None else stream
        self._begin, self._drawn = time.monotonic(), 0.0
        self._shown = self._stream.isatty()

    def step(self, failed: bool) -> None:
        """One item more is finished."""
        self.done += 1
        self.failed += failed
        now = time.monotonic()
        if self._shown and (now - self._drawn >= EVERY or self.done == self.total):
            self._drawn = now
            self._stream.write(f"\r\x1b[K{self.line(now - self._begin)}")
            self._stream.flush()

    def close(self) -> None:
        """Leave the last state on a line of its own."""
        if self._shown and self._drawn:
            self._stream.write("\n")
            self._stream.flush()

    def line(self, seconds: float) -> str:
        """What is shown ``seconds`` after the beginning."""
        filled = WIDTH * self.done // max(self.total, 1)
        parts = [f"{self.label} [{'#' * filled}{'-' * (WIDTH - filled)}] {self.done}/{self.total}"]
        if self.failed:
            parts.append(f"{self.failed} failed")
        if 0 < self.done < self.total:
            parts.append(f"{_words(seconds * (self.total - self.done) / self.done)} left")
        return ", ".join(parts)


def _words(seconds: float) -> str:
    if seconds < NEAR_FULL:
        return f"{seconds:.0f} s"
    minutes = seconds / 60
    return f"{minutes:.0f} min" if minutes < NEAR_FULL else f"{minutes / 60:.1f} h"

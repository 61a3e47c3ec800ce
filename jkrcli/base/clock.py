"""CPU time per named stage of a run, and durations in words."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

SILENCE = 2.0  # choice: CPU seconds without a word
PATIENCE = 3.0  # choice: CPU seconds by its forecast, of a solution beside the requested one


def duration(seconds: float) -> str:
    """A duration in words: ``40 s``, ``12 min``, ``3.4 h``."""
    if seconds < 90:
        return f"{seconds:.2g} s" if seconds < 10 else f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.3g} h"


class StageClock:
    """Adds up CPU seconds of this process per stage: ``with clock("mesh"): ...``; ``clock.seconds`` holds them."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        start = time.process_time()
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + time.process_time() - start

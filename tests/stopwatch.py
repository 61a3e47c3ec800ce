"""CPU seconds of what is tested; bounds are those of an idle core, with room for a machine that others use too."""

import contextlib
import time
from collections.abc import Callable, Iterator

ROOM = 4  # shared caches and cores, first imports


@contextlib.contextmanager
def takes_less_than(seconds: float) -> Iterator[None]:
    """Fails where the block takes ``ROOM`` times as many CPU seconds: what grows without bound takes far more."""
    start = time.process_time()
    yield
    spent = time.process_time() - start
    assert spent < ROOM * seconds, f"{spent:.2g} s of CPU time, on an idle core less than {seconds:g}"


def seconds_of(action: Callable[[], object], times: int = 3) -> float:
    """Least CPU seconds of some runs."""
    found = []
    for _ in range(times):
        start = time.process_time()
        action()
        found.append(time.process_time() - start)
    return min(found)

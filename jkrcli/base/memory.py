"""Memory: what this process may still take, and a fence around what takes more."""

from __future__ import annotations

import contextlib
import math
import threading
from collections.abc import Iterator
from pathlib import Path

SHARE = 0.8  # choice: of the free memory that is planned with; the rest is for what forecasts miss
CGROUP = Path("/sys/fs/cgroup")
_ALONE = threading.RLock()  # limits are those of the whole process


def free_memory() -> float:
    """MiB that this process may still use: the least of what machine, container and shell leave; inf if unknown."""
    return min(_of_machine(), _of_container(), _of_shell())


@contextlib.contextmanager
def fence(most: int) -> Iterator[None]:
    """A block in which what asks for ``most`` bytes more than this process holds meets a MemoryError; nothing is
    limited on systems that cannot."""
    try:
        import resource

        used = _address_space()
    except (ImportError, OSError):
        yield
        return
    with _ALONE:
        soft, hard = resource.getrlimit(resource.RLIMIT_AS)
        limit = used + most if soft == resource.RLIM_INFINITY else min(soft, used + most)
        resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def _address_space() -> int:
    """Bytes of address space of this process."""
    import resource

    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()


def _of_machine() -> float:
    with contextlib.suppress(OSError, ValueError, StopIteration):
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        return next(float(line.split()[1]) for line in lines if line.startswith("MemAvailable:")) / 1024
    return math.inf


def _of_container() -> float:
    with contextlib.suppress(OSError, ValueError):  # "max" where there is no limit
        most, used = (float((CGROUP / name).read_text(encoding="ascii")) for name in ("memory.max", "memory.current"))
        return (most - used) / 2**20
    return math.inf


def _of_shell() -> float:
    """What ``ulimit -v`` leaves; systems without it have no such module."""
    with contextlib.suppress(ImportError, OSError):
        import resource

        most, _ = resource.getrlimit(resource.RLIMIT_AS)
        return math.inf if most == resource.RLIM_INFINITY else (most - _address_space()) / 2**20
    return math.inf

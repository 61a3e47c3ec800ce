"""Locks on open files: they end with their process, and are seen from every container that runs on the same system."""

from __future__ import annotations

from typing import IO, Any


def taken(file: IO[Any], shared: bool = False) -> bool | None:
    """Whether the lock of an open file was taken, to be held until it is closed; False where another process holds it,
    None where the system or the disk has no such locks. Any number may hold it ``shared``."""
    try:
        import fcntl
    except ImportError:  # Windows
        return None
    try:
        fcntl.flock(file, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return None
    return True

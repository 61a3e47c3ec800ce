"""A limit of CPU time on a piece of work, in whatever thread of whatever process it is done."""

from __future__ import annotations

import contextlib
import ctypes
import multiprocessing
import resource
import threading
import time
from collections.abc import Iterator


class TooSlowError(BaseException):
    """Raised where the limit is reached; no ``except Exception`` on the way stops it."""


@contextlib.contextmanager
def cpu_limit(seconds: float, deadly: float = 3.0) -> Iterator[None]:
    """Raise TooSlowError in this thread after so many seconds of its CPU time.

    A call into a library is left when it returns. One that does not return at all ends the process, where that is a
    worker's, after ``deadly`` times the limit: the executor then reports its death.
    """
    thread = threading.get_ident()
    clock, over = time.pthread_getcpuclockid(thread), threading.Event()
    end = time.clock_gettime(clock) + seconds

    def watch() -> None:
        while not over.wait(max(end - time.clock_gettime(clock), 0.05)):
            if time.clock_gettime(clock) >= end:
                ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(TooSlowError))
                return

    watcher = threading.Thread(target=watch, daemon=True)
    with _deadly_limit(deadly * seconds):
        watcher.start()
        try:
            yield
        finally:
            over.set()
            watcher.join()


@contextlib.contextmanager
def _deadly_limit(seconds: float) -> Iterator[None]:
    """A limit of CPU ``seconds`` at which the operating system ends this process, if it is a worker's."""
    if multiprocessing.parent_process() is None:
        yield
        return
    before, most = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (round(time.process_time() + seconds) + 1, most))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_CPU, (before, most))

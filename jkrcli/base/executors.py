"""Work on many items at once: in this process, in local processes, or on a Dask cluster, behind one interface.

    with executor(workers=2) as pool:
        for index, result in completed(pool, function, items, "fits", chunk=50):
            ...                                   # result: what function(items[index]) returned, or its exception

Every process computes with one BLAS thread, so that the numbers do not depend on where an item is worked on. Scripts
that use local processes need the usual guard: if __name__ == "__main__".
"""

from __future__ import annotations

import contextlib
import functools
import multiprocessing
import os
import pickle
import re
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor
from concurrent.futures import wait as wait_for
from multiprocessing.connection import Connection
from typing import Any, TypeVar

from .. import __version__
from .errors import InputError, JkrError, SolveError, first_line
from .progress import Progress

Item = TypeVar("Item")
Result = TypeVar("Result")
ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
AHEAD = 2  # tasks per worker that are handed out before they can be worked on
ADDRESS = re.compile(r"[a-z]+://[^/\s]+:\d+")
CONNECT = 15  # seconds to reach a scheduler


@contextlib.contextmanager
def executor(workers: int | None = None, scheduler: str | None = None) -> Iterator[Executor]:
    """An executor for ``completed``: ``workers`` local processes (default: one per core; 1: this very process), or the
    workers of a running Dask ``scheduler`` ("tcp://host:8786").

    Left by an exception (Ctrl-C is one), work in hand is given up at once and no process stays behind.
    """
    if scheduler is not None:
        if workers is not None:
            raise InputError("--workers: the scheduler knows its own workers; give either --workers or --scheduler")
        opened: _Serial | _Processes | _Cluster = _Cluster(scheduler)
    else:
        count = available_cores() if workers is None else workers
        if count < 1:
            raise InputError(f"--workers: must be >= 1, got {count}")
        opened = _Serial() if count == 1 else _Processes(count)
    try:
        yield opened
    except BaseException:
        opened.abandon()
        raise
    opened.shutdown()


def available_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def completed(
    executor: Executor, function: Callable[[Item], Result], items: Sequence[Item], label: str, chunk: int = 1
) -> Iterator[tuple[int, Result | Exception]]:
    """``(index, function(items[index]))`` of all items as they are finished, in no order; an exception in place of its
    result.

    ``chunk`` items make one task; only a few tasks per worker are handed out at a time. ``function`` is a module's own
    (it is sent by name). An item whose process dies is tried once more, alone, and then reported as a SolveError.
    """
    tasks = deque(range(start, min(start + chunk, len(items))) for start in range(0, len(items), chunk))
    suspects: deque[int] = deque()
    running: dict[Future[list[Result | Exception]], range] = {}

    def hand_out(indices: range) -> None:
        running[executor.submit(run_chunk, __version__, function, [items[i] for i in indices])] = indices

    progress = Progress(label, len(items))
    try:
        while tasks or running or suspects:
            while tasks and not suspects and len(running) < AHEAD * _workers(executor):
                hand_out(tasks.popleft())
            if not running:
                index = suspects.popleft()
                hand_out(range(index, index + 1))
                alone = True
            else:
                alone = False
            for future in wait_for(running, return_when=FIRST_COMPLETED).done:
                indices = running.pop(future)
                results = _results(future, indices, alone)
                if results is None:
                    suspects.extend(indices)
                    continue
                for index, result in zip(indices, results, strict=True):
                    progress.step(isinstance(result, Exception))
                    yield index, result
    finally:
        for future in running:
            future.cancel()
        progress.close()


def _workers(executor: Executor) -> int:
    """How many tasks the executor works on at a time, now."""
    return max(getattr(executor, "workers", 1), 1)


def _results(future: Future[list[Result | Exception]], indices: range, alone: bool) -> list[Result | Exception] | None:
    """What a task returned; None where its process died and nobody knows which of several items it was."""
    try:
        return future.result()
    except CancelledError:
        raise JkrError("the connection to the scheduler was lost; run the same command again to go on") from None
    except Exception as error:
        if not _died(error):
            raise
        if not alone:
            return None
        return [SolveError("the process that worked on it died (out of memory, or a fault in a library)")]


def _died(error: Exception) -> bool:
    return isinstance(error, BrokenExecutor) or type(error).__name__ == "KilledWorker"  # Dask's own


def run_chunk(version: str, function: Callable[[Item], Result], items: list[Item]) -> list[Result | Exception]:
    """Work on the items of one task, where the executor wants it; their exceptions are results."""
    if version != __version__:
        raise JkrError(f"a worker runs jkr {__version__}, this command jkr {version}: install the same release")
    pin_blas()
    return [_outcome(function, item) for item in items]


def _outcome(function: Callable[[Item], Result], item: Item) -> Result | Exception:
    try:
        return function(item)
    except Exception as error:
        return _portable(error)


def _portable(error: Exception) -> Exception:
    """The exception itself where it can be sent between processes, else its message."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return SolveError(f"{type(error).__name__}: {error}")
    return error


@functools.cache
def pin_blas() -> None:
    """One BLAS thread in this process from now on: the same numbers everywhere, and no core is asked for twice."""
    from threadpoolctl import threadpool_limits

    os.environ.update(ONE_THREAD)  # for libraries that are loaded later
    threadpool_limits(1)


class _Serial(Executor):
    """Works on a task when it is submitted, in this process: nothing is started, tracebacks and profiles are whole."""

    workers = 1

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future

    def abandon(self) -> None:
        """Nothing is in hand."""


class _Processes(Executor):
    """Local processes that end with their parent, however it ends, and are started anew when one of them dies."""

    def __init__(self, workers: int):
        self.workers = workers
        self._start()

    def _start(self) -> None:
        """The workers hold the reading end of a pipe on which nothing is written: closed here, they end at once."""
        context = multiprocessing.get_context("spawn")  # forked libraries of numbers and meshes misbehave
        held, self._lifeline = context.Pipe(duplex=False)
        self._pool = ProcessPoolExecutor(self.workers, context, _begin, (held,))

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        try:
            return self._pool.submit(fn, *args, **kwargs)
        except BrokenExecutor:
            self.abandon()
            self._start()
            return self._pool.submit(fn, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        self._pool.shutdown(wait, cancel_futures=cancel_futures)

    def abandon(self) -> None:
        """End the workers, whatever they are doing."""
        self._lifeline.close()
        self._pool.shutdown(wait=True, cancel_futures=True)


def _begin(lifeline: Connection) -> None:
    """First thing in a worker: Ctrl-C is the parent's to handle, and the worker ends when the parent does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.environ.update(ONE_THREAD)
    threading.Thread(target=_end_with, args=(lifeline,), daemon=True).start()


def _end_with(lifeline: Connection) -> None:
    lifeline.poll(None)
    os._exit(1)


class _Cluster(Executor):
    """The workers of a Dask scheduler that the user runs."""

    def __init__(self, address: str):
        if not ADDRESS.fullmatch(address):
            raise InputError(f'--scheduler: must be an address such as tcp://node1:8786, got "{address}"')
        try:
            from distributed import Client
        except ModuleNotFoundError:
            raise InputError(
                '--scheduler: needs the optional package distributed: pip install "jkrcli[cluster]"'
            ) from None
        try:
            self._client = Client(address, timeout=CONNECT, set_as_default=False)
        except (OSError, ValueError) as error:
            raise InputError(f'--scheduler: no Dask scheduler answers at "{address}" ({first_line(error)})') from None
        self._pool = self._client.get_executor(pure=False)

    @property
    def workers(self) -> int:
        """Threads of all workers that have joined up to now."""
        return sum(self._client.nthreads().values())

    @property
    def dashboard(self) -> str:
        """Address of the page that shows what the cluster does."""
        return str(self._client.dashboard_link)

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        return self._pool.submit(fn, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        self._pool.shutdown(wait=wait and not cancel_futures)
        self._client.close()

    def abandon(self) -> None:
        """Cancel what is in hand; the workers are the user's and stay."""
        self.shutdown(wait=False)


def dashboard(executor: Executor) -> str | None:
    """Address of the page that shows what a cluster does; None for local work."""
    return getattr(executor, "dashboard", None)

"""Work on many items at once: in this process, in local processes, or on a Dask cluster, behind one interface.

    with executor(workers=2) as pool:
        for index, result in completed(pool, function, items, "fits", chunk=50):
            ...                                   # result: what function(items[index]) returned, or its exception

Every process computes with one BLAS thread, so that the numbers do not depend on where an item is worked on. Scripts
that use local processes need the usual guard: if __name__ == "__main__".

Why not joblib (1.6 was measured): where item 7 of 20 kills its process, joblib ends the whole call after 4 results and
does not say which item it was, and with its Dask backend it had not ended after 90 s; here 19 results come and a
reason for the one. Its workers go on for as long as their item takes when the parent is killed; here they end at once.
What it would replace, the start of processes, is thirty lines of the standard library's, without 0.3 s of imports.
"""

import contextlib
import math
import os
import pickle
import re
import signal
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future
from concurrent.futures import wait as wait_for
from contextlib import AbstractContextManager
from functools import partial
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from .. import __version__
from .errors import InputError, JkrError, SolveError, first_line, installs
from .process import ONE_THREAD, interrupts_wait, pin_blas

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

Item = TypeVar("Item")
Result = TypeVar("Result")
Outcomes: TypeAlias = list[Result | Exception]
Step: TypeAlias = Callable[[bool], object]  # called as an item is finished: whether it failed
Progress: TypeAlias = Callable[[str, int, float], AbstractContextManager[Step]]  # label, number of items, CPU seconds

# Limits of handing out work; no result depends on them.
POOL_AHEAD = 2  # theory: tasks per worker that are handed out, one in work and the next, so that none ever waits
# Of the process that removes what killed ones leave: a line of Python's on their semaphores tells the user nothing.
QUIET = "ignore:resource_tracker"
POOL_WORTH = 4.0  # choice: CPU seconds of work for each process, which takes half a second to start


@contextlib.contextmanager
def silent(label: str, total: int, seconds: float) -> Iterator[Step]:
    """Progress that nobody is shown."""
    yield lambda failed: None


class Pool(Executor):
    """An executor that works on ``workers`` tasks at a time and shows its ``progress``; ``seconds``: CPU time forecast
    of all its work, infinite where nobody knows it."""

    workers = 1
    seconds = math.inf
    progress: Progress = staticmethod(silent)
    dashboard: str | None = None  # address of the page that shows what a cluster does

    def withdraw(self, tasks: Iterable[Future[Any]]) -> None:
        """Take back those of ``tasks`` that nobody works on yet."""
        for task in tasks:
            task.cancel()

    def abandon(self) -> None:
        """Give up what is in hand, at once."""


@contextlib.contextmanager
def executor(
    workers: int | None = None, scheduler: str | None = None, progress: Progress = silent, seconds: float = math.inf
) -> Iterator[Pool]:
    """A pool for ``completed``: ``workers`` local processes (1: this very process; default: one per core, as far as
    they pay for work of about so many CPU ``seconds``), or the workers of a running Dask ``scheduler``
    ("tcp://host:8786"). ``progress`` gets each list of items, and the ``seconds``.

    Left by an exception (Ctrl-C is one), work in hand is given up at once and no process stays behind.
    """
    if scheduler is not None and workers is not None:
        raise InputError("--workers: the scheduler knows its own workers; give either --workers or --scheduler")
    count = int(max(1, min(available_cores(), seconds / POOL_WORTH))) if workers is None else workers
    if count < 1:
        raise InputError(f"--workers: must be >= 1, got {count}")
    alone = count == 1 or find_spec("_multiprocessing") is None  # a browser starts no processes
    pool = _Cluster(scheduler) if scheduler is not None else _Here() if alone else _Processes(count)
    pool.progress, pool.seconds = progress, seconds
    try:
        yield pool
    except BaseException:
        pool.abandon()
        raise
    pool.shutdown()


def available_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def completed(
    pool: Pool, function: Callable[[Item], Result], items: Sequence[Item], label: str, chunk: int = 1
) -> Iterator[tuple[int, Result | Exception]]:
    """``(index, function(items[index]))`` of all items as they are finished, in no order; an exception in place of its
    result.

    ``chunk`` items make one task; only a few tasks per worker are handed out at a time. ``function`` is a module's own
    (it is sent by name). An item whose process dies is tried once more, alone, and then reported as a SolveError.
    """
    return batches_completed(pool, partial(_each, function), items, label, chunk)


def _each(function: Callable[[Item], Result], items: list[Item]) -> Outcomes[Result]:
    outcomes: Outcomes[Result] = []
    for item in items:
        try:
            outcomes.append(function(item))
        except Exception as error:
            outcomes.append(error)
    return outcomes


def batches_completed(
    pool: Pool, function: Callable[[list[Item]], Outcomes[Result]], items: Sequence[Item], label: str, chunk: int
) -> Iterator[tuple[int, Result | Exception]]:
    """As ``completed``, of a ``function`` that takes all items of a task and gives their outcomes."""
    tasks = deque(range(start, min(start + chunk, len(items))) for start in range(0, len(items), chunk))
    suspects: deque[int] = deque()
    running: dict[Future[Outcomes[Result]], range] = {}

    def hand_out(indices: range) -> None:
        running[pool.submit(run_chunk, __version__, function, [items[i] for i in indices])] = indices

    with pool.progress(label, len(items), pool.seconds) as step:
        try:
            while tasks or running or suspects:
                while tasks and not suspects and len(running) < POOL_AHEAD * pool.workers:
                    hand_out(tasks.popleft())
                if alone := not running:
                    index = suspects.popleft()
                    hand_out(range(index, index + 1))
                for future in wait_for(running, return_when=FIRST_COMPLETED).done:
                    indices = running.pop(future)
                    results = _results(future, alone)
                    if results is None:
                        suspects.extend(indices)
                        continue
                    for index, result in zip(indices, results, strict=True):
                        step(isinstance(result, Exception))
                        yield index, result
        finally:
            pool.withdraw(running)


def _results(future: Future[Outcomes[Result]], alone: bool) -> Outcomes[Result] | None:
    """What a task returned; None where its process died and nobody knows which of several items it was."""
    try:
        return future.result()
    except CancelledError:
        raise JkrError("the connection to the scheduler was lost; run the same command again to go on") from None
    except Exception as error:
        if not (isinstance(error, BrokenExecutor) or type(error).__name__ == "KilledWorker"):  # Dask's own
            raise
        died = SolveError("the process that worked on it died (out of memory, or a fault in a library)")
        return [died] if alone else None


def in_order(
    pool: Pool | None, function: Callable[[Item], Result], items: Sequence[Item], label: str, chunk: int = 1
) -> list[Result]:
    """``function`` of all items (None: in this process, one after the other); the first exception to come is raised."""
    if pool is None:
        return [function(item) for item in items]
    return batches_in_order(pool, partial(_each, function), items, label, chunk)


def batches_in_order(
    pool: Pool | None, function: Callable[[list[Item]], Outcomes[Result]], items: Sequence[Item], label: str, chunk: int
) -> list[Result]:
    """As ``in_order``, of a ``function`` that takes all items of a task and gives their outcomes."""
    outcomes: dict[int, Result | Exception] = {}
    if pool is None:
        for first in range(0, len(items), chunk):
            outcomes |= enumerate(function(list(items[first : first + chunk])), first)
            if any(isinstance(outcome, Exception) for outcome in outcomes.values()):
                break
    for index, outcome in () if pool is None else batches_completed(pool, function, items, label, chunk):
        outcomes[index] = outcome
        if isinstance(outcome, Exception):
            break
    results = list[Result]()
    for index in sorted(outcomes):
        if isinstance(outcome := outcomes[index], Exception):
            raise outcome
        results.append(outcome)
    return results


def run_chunk(version: str, function: Callable[[list[Item]], Outcomes[Result]], items: list[Item]) -> Outcomes[Result]:
    """Work on the items of one task, where the executor wants it; their exceptions are results."""
    if version != __version__:
        raise JkrError(f"a worker runs jkr {__version__}, this command jkr {version}: install the same release")
    pin_blas()
    outcomes = function(items)
    for i, error in enumerate(outcomes):
        if isinstance(error, Exception):  # its message alone where it cannot be sent to a process
            try:
                pickle.loads(pickle.dumps(error))
            except Exception:
                outcomes[i] = SolveError(f"{type(error).__name__}: {error}")
    return outcomes


class _Here(Pool):
    """Works on a task when it is submitted, in this process: nothing is started, tracebacks and profiles are whole."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


class _Processes(Pool):
    """Local processes that end with their parent, however it ends, and are started anew when one of them dies."""

    def __init__(self, workers: int):
        self.workers = workers
        self._start()

    def _start(self) -> None:
        """The workers hold the reading end of a pipe on which nothing is written: closed here, they end at once."""
        if QUIET not in sys.warnoptions:
            sys.warnoptions.append(QUIET)
        import multiprocessing
        from concurrent.futures import ProcessPoolExecutor

        context = multiprocessing.get_context("spawn")  # forked libraries of numbers and meshes misbehave
        reading_end, self._lifeline = context.Pipe(duplex=False)
        self._pool = ProcessPoolExecutor(self.workers, context, _begin, (reading_end,))

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Ctrl-C waits while processes may be started, which inherit that it is blocked: half-started ones end in
        tracebacks."""
        with interrupts_wait():
            try:
                return self._pool.submit(fn, *args, **kwargs)
            except BrokenExecutor:
                self.abandon()
                self._start()
                return self._pool.submit(fn, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        self._pool.shutdown(wait, cancel_futures=cancel_futures)

    def withdraw(self, tasks: Iterable[Future[Any]]) -> None:
        """Leave them alone: the thread that reports the end of a pool's processes fails on tasks that were cancelled by
        hand. The few that were handed out are finished, or given up with the pool."""

    def abandon(self) -> None:
        self._lifeline.close()
        self.shutdown(cancel_futures=True)


def _begin(lifeline: "Connection") -> None:
    """First thing in a worker: Ctrl-C is the parent's to handle (until here it is blocked), and the worker ends when
    the parent does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.environ.update(ONE_THREAD)

    def end_with_parent() -> None:
        lifeline.poll(None)
        os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()


class _Cluster(Pool):
    """The workers of a Dask scheduler that the user runs; they stay when its work is given up."""

    def __init__(self, address: str):
        if not re.fullmatch(r"[a-z]+://[^/\s]+:\d+", address):
            raise InputError(f'--scheduler: must be an address such as tcp://node1:8786, got "{address}"')
        try:
            from distributed import Client
        except ModuleNotFoundError:
            raise InputError(f"--scheduler: needs the optional package distributed: {installs('cluster')}") from None
        try:
            self._client = Client(address, timeout=15, set_as_default=False)  # choice: s, until an address is wrong
        except (OSError, ValueError) as error:
            raise InputError(f'--scheduler: no Dask scheduler answers at "{address}" ({first_line(error)})') from None
        self._pool = self._client.get_executor(pure=False)
        self.dashboard = str(self._client.dashboard_link)

    @property
    def workers(self) -> int:  # type: ignore[override]
        """Threads of all workers that have joined up to now."""
        return max(sum(self._client.nthreads().values()), 1)

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        return self._pool.submit(fn, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        self._pool.shutdown(wait=wait)
        self._client.close()

    def abandon(self) -> None:
        self.shutdown(wait=False)

"""Work on many items: every item once, failures as results, no process left behind."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from jkrcli.base.errors import InputError, JkrError, SolveError, installs
from jkrcli.base.executors import completed, executor, in_order, run_chunk

DEADLINE = 60.0  # seconds to wait for processes on a machine that others use too


def square(x: int) -> int:
    if x == 3:
        raise InputError("three: is not allowed")
    if x == 5:
        raise UnpicklableError(lambda: None)
    return x * x


class UnpicklableError(Exception):
    """Holds what cannot be sent between processes."""


def die_at_seven(x: int) -> int:
    if x == 7:
        os.kill(os.getpid(), signal.SIGKILL)
    return x


def blas_threads(_: int) -> list[int]:
    import scipy.linalg  # noqa: F401 - loads its own BLAS
    from threadpoolctl import threadpool_info

    return [item["num_threads"] for item in threadpool_info() if item["user_api"] == "blas"]


@pytest.mark.parametrize("workers", [1, 2])
def test_every_item_once_and_failures_as_results(workers: int) -> None:
    with executor(workers) as pool:
        found = list(completed(pool, square, list(range(11)), "squares", chunk=3))
    assert sorted(index for index, _ in found) == list(range(11))
    results = dict(found)
    assert [results[i] for i in range(11) if i not in (3, 5)] == [i * i for i in range(11) if i not in (3, 5)]
    assert isinstance(results[3], InputError)
    assert results[3].lines == ("three: is not allowed",)
    assert isinstance(results[5], SolveError)
    assert str(results[5]).startswith("UnpicklableError: ")


@pytest.mark.slow
def test_an_item_that_kills_its_process_is_found_and_the_rest_is_done() -> None:
    with executor(2) as pool:
        results = dict(completed(pool, die_at_seven, list(range(20)), "deaths", chunk=4))
    assert sorted(results) == list(range(20))
    assert isinstance(results[7], SolveError)
    assert str(results[7]) == "the process that worked on it died (out of memory, or a fault in a library)"
    assert all(results[i] == i for i in range(20) if i != 7)


def test_workers_compute_with_one_blas_thread() -> None:
    with executor(2) as pool:
        ((_, threads),) = completed(pool, blas_threads, [0], "threads")
    assert isinstance(threads, list)
    assert set(threads) == {1}


def test_nothing_is_handed_out_far_ahead() -> None:
    """Two tasks per worker: with one that is 2 chunks of 3, started before the first result is taken."""
    begun: list[int] = []
    with executor(1) as pool:
        results = completed(pool, begun.append, list(range(100)), "bounded", chunk=3)
        next(results)
        assert len(begun) == 6
        results.close()
    assert len(begun) == 6


@pytest.mark.parametrize(
    ("workers", "scheduler", "line"),
    [
        (0, None, "--workers: must be >= 1, got 0"),
        (2, "tcp://a:1", "--workers: the scheduler knows its own workers; give either --workers or --scheduler"),
        (None, "node1", '--scheduler: must be an address such as tcp://node1:8786, got "node1"'),
    ],
)
def test_refusals(workers: int | None, scheduler: str | None, line: str) -> None:
    with pytest.raises(InputError) as caught, executor(workers, scheduler):
        pass
    assert caught.value.lines == (line,)


def test_a_missing_distributed_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError) as caught, executor(scheduler="tcp://127.0.0.1:1"):
        pass
    assert caught.value.lines == (f"--scheduler: needs the optional package distributed: {installs('cluster')}",)


def test_workers_of_another_release_are_refused() -> None:
    with pytest.raises(JkrError, match=r"a worker runs jkr .*, this command jkr 0\.0\.1: install the same release"):
        run_chunk("0.0.1", square, [1])


SLEEPERS = """
import os, signal, time
from jkrcli.base.executors import completed, executor

signal.signal(signal.SIGINT, signal.default_int_handler)  # in the background it may be ignored

def sleep(x):
    os.write(1, b"%d\\n" % os.getpid())
    time.sleep(600)

if __name__ == "__main__":
    with executor(2) as pool:
        list(completed(pool, sleep, [1, 2], "sleep"))
"""


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL, signal.SIGTERM])
def test_no_process_outlives_the_command(tmp_path: Path, how: signal.Signals) -> None:
    script = tmp_path / "sleepers.py"
    script.write_text(SLEEPERS)
    with subprocess.Popen(
        [sys.executable, str(script)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as parent:
        watchdog = threading.Timer(DEADLINE, parent.kill)
        watchdog.start()
        workers = [int(parent.stdout.readline()) for _ in range(2)]
        assert len(set(workers)) == 2
        parent.send_signal(how)
        assert parent.wait() == -how or how == signal.SIGINT
        watchdog.cancel()
        end = time.monotonic() + DEADLINE
        while any(map(_runs, workers)) and time.monotonic() < end:
            time.sleep(0.02)
        assert not any(map(_runs, workers))


def _runs(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


GIVEN_UP = """
import threading
import time
from concurrent.futures import ProcessPoolExecutor, wait

from jkrcli.base import executors

shutdown, failures, first = ProcessPoolExecutor.shutdown, [], iter([wait])


def late(pool, *arguments, **named):
    time.sleep(0.3)
    shutdown(pool, *arguments, **named)


def interrupted(*arguments, **named):
    for turn in first:
        return turn(*arguments, **named)
    time.sleep(0.1)  # until two tasks are in work and others wait for them
    raise KeyboardInterrupt


if __name__ == "__main__":
    ProcessPoolExecutor.shutdown, threading.excepthook = late, failures.append
    executors.wait_for, executors.POOL_AHEAD = interrupted, 4  # more than Python itself sends to its processes
    try:
        with executors.executor(2) as pool:
            list(executors.completed(pool, time.sleep, [0.0] + [10.0] * 40, "naps"))
    except KeyboardInterrupt:
        print("given up", failures)
"""


def test_work_is_given_up_in_silence_however_the_threads_take_turns(tmp_path: Path) -> None:
    """Processes that end before their pool is told so are a broken pool, which reports to every task."""
    script = tmp_path / "given_up.py"
    script.write_text(GIVEN_UP)
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=DEADLINE, check=True)
    assert (done.stdout, done.stderr) == ("given up []\n", "")


def test_progress_is_told_of_every_item_and_of_failures() -> None:
    told: list[object] = []

    @contextlib.contextmanager
    def progress(label: str, total: int, seconds: float) -> Iterator[Callable[[bool], None]]:
        told.append((label, total, seconds))
        yield told.append
        told.append("end")

    with executor(1, progress=progress, seconds=0.5) as pool:
        list(completed(pool, square, [1, 3, 2], "squares"))
    assert (told[0], told[-1]) == (("squares", 3, 0.5), "end")
    assert sorted(map(bool, told[1:-1])) == [False, False, True]


def test_results_in_order_and_the_first_exception_is_raised() -> None:
    with executor(1) as pool:
        assert in_order(pool, square, [4, 1, 2], "squares") == in_order(None, square, [4, 1, 2], "") == [16, 1, 4]
        with pytest.raises(InputError, match="three: is not allowed"):
            in_order(pool, square, [1, 3, 5], "squares")


def test_threads_are_no_workers() -> None:
    """gmsh and BLAS settings belong to a process: local work never runs in threads of this one."""
    before = threading.active_count()
    with executor(1) as pool:
        assert dict(completed(pool, abs, [-1], "one")) == {0: 1}
        assert threading.active_count() == before

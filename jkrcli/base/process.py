"""The process as the program ``jkr``: its settings, memory, threads, clock, signals and locks of files.

Modules that some systems lack (``fcntl``, ``resource``) are imported here alone, in functions.
"""

import atexit
import contextlib
import functools
import gc
import math
import os
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from .errors import InputError

# containers made between two looks for cycles; choice: saves an eighth, and leaves ten pictures to wait, not fifty
RARELY = (100_000, 2, 10)
REMEMBERED = 256  # choice: results of one kind that are kept; more only saves time
_begun: list[bool] = []


def begin() -> None:
    """Streams that were closed are there; and, as commands are short, no time goes into what only long processes, or
    people at a prompt, have something of."""
    # Open stdin, stdout and stderr to nothing where the caller closed them: else the next file that is opened gets
    # the number of one, and what a library prints goes into it.
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # it takes the lowest number that is free
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115, PTH123 - to the end
    if not sys.argv[0].endswith("__main__.py"):  # of python -m, which may find this package in the folder at hand
        os.environ["PYTHONSAFEPATH"] = "1"  # processes that are started here take no modules from there either
    os.environ["PYDANTIC_DISABLE_PLUGINS"] = "1"  # cases are read by its own rules, and no package is searched for more
    gc.set_threshold(0)  # never, until the verb is loaded: what modules hold stays
    atexit.register(gc.freeze)  # else all is searched for cycles once more at the end: a quarter of a command's time
    _begun.append(True)


def loaded() -> None:
    """Modules are loaded: what they hold is not searched for cycles, in the program, which is from now on."""
    if runs():
        gc.freeze()
        gc.set_threshold(*RARELY)


def runs() -> bool:
    """Whether this process is the program."""
    return bool(_begun)


# --------------------------------------------------------------------------------------------------
# One BLAS thread: the same numbers on every machine, faster at these sizes, and no core works for two.

# What libraries that are loaded later read from the environment.
ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")


pinned: list[bool] = []  # holds True in a process that began with one thread


@functools.cache
def pin_blas() -> None:
    """One BLAS thread in this process from now on, whatever is loaded already."""
    from threadpoolctl import threadpool_limits

    os.environ.update(ONE_THREAD)
    threadpool_limits(1)


@contextmanager
def one_thread() -> Iterator[None]:
    """Context, or decorator, in which linear algebra works on one thread, whatever the environment says: on small
    matrices and many-column solves more only wait."""
    if pinned:
        yield
    else:
        with _libraries("scipy.linalg" in sys.modules, "cvxopt" in sys.modules).limit(limits=1):
            yield


@functools.cache
def _libraries(*loaded: bool) -> Any:
    """All BLAS libraries, searched once for what is ``loaded`` (it takes milliseconds)."""
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


# --------------------------------------------------------------------------------------------------
# Memory: what this process may still take.

SHARE = 0.8  # choice: of the free memory that is planned with; the rest is for what forecasts miss
CGROUP, MEMINFO = Path("/sys/fs/cgroup"), Path("/proc/meminfo")


def free_memory() -> float:
    """MiB that this process may still use: the least of what machine, container and shell leave; inf if unknown."""
    left = []
    try:
        lines = MEMINFO.read_text(encoding="ascii").splitlines()
        left.append(next(float(line.split()[1]) for line in lines if line.startswith("MemAvailable:")) / 1024)
    except (OSError, ValueError, StopIteration):
        with contextlib.suppress(Exception):  # not on this system either, which is asked itself: slower to load
            import psutil

            try:
                left.append(float(psutil.virtual_memory().available) / 2**20)
            except OSError:  # which reads /proc on Linux
                left.append(float(os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")) / 2**20)
    with contextlib.suppress(OSError, ValueError):  # "max" where there is no limit
        most, used = (float((CGROUP / name).read_text(encoding="ascii")) for name in ("memory.max", "memory.current"))
        left.append((most - used) / 2**20)
    with contextlib.suppress(OSError):
        if (limit := address_space()) < math.inf:
            pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
            left.append((limit - pages * os.sysconf("SC_PAGE_SIZE")) / 2**20)
    return min(left, default=math.inf)


def address_space() -> float:
    """Bytes that ``ulimit -v`` leaves this process; inf without a limit, or on systems that have none."""
    with contextlib.suppress(ImportError):
        import resource

        if (limit := resource.getrlimit(resource.RLIMIT_AS)[0]) != resource.RLIM_INFINITY:
            return limit
    return math.inf


# --------------------------------------------------------------------------------------------------
# CPU time per named stage of a run, and durations in words.

SILENCE = 2.0  # choice: CPU seconds without a word
PATIENCE = 3.0  # choice: CPU seconds by its forecast, of a solution beside the requested one


def duration(seconds: float) -> str:
    """A duration in words: ``40 s``, ``12 min``, ``3.4 h``, ``12 days``, ``3.2 years``."""
    if seconds < 90:
        return f"{seconds:.2g} s" if seconds < 10 else f"{seconds:.0f} s"
    if seconds < 48 * 3600:
        return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.3g} h"
    days = seconds / 86_400
    return f"{days:.3g} days" if days < 730 else f"{_told(days / 365.25)} years"


def memory_words(mib: float) -> str:
    """Memory in words: ``12 MiB``, ``3.4 GiB``, ``596 TiB``."""
    if mib < 1024:
        return f"{mib:.0f} MiB"
    return f"{mib / 2**10:.3g} GiB" if mib < 1000 * 2**10 else f"{_told(mib / 2**20)} TiB"


def _told(number: float) -> str:
    """Three digits; beyond a thousand that it is more."""
    return f"{number:.3g}" if number < 999.5 else "more than 1,000"


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


# --------------------------------------------------------------------------------------------------
# What reading a file may take.

SIZE = 1 << 30  # choice: bytes of a file as it lies there, and of all that it unpacks to
TEXT = 1 << 28  # choice: bytes of tables in text, which take some ten times as much in memory
ROWS = 10_000_000  # choice: lines of text, words in columns
# choice: bytes that a member of an archive, a group or a chunk of a data set counts as, which a library takes, measured
PART = 4000
# choice: bytes of memory of a row of text and of each of its bytes, measured 250 to 530 and 8 to 18 on tables of 2 to
# 400 columns
PER_ROW, PER_BYTE = 400, 8
LITTLE = 1 << 28  # choice: bytes of memory for which that of the machine is not looked up
LINE_ENDS = "\n\r\v\f\x1c\x1d\x1e\x85\u2028\u2029"  # as ``str.splitlines`` has them


def check_size(path: Path | str, size: float, most: int | None = None, memory: float = 0.0) -> None:
    """Refuse beyond the limit of what is read: InputError where what is about to be read of the file at ``path`` has,
    unpacked, more bytes than ``most`` (None: than are read of any file), or takes more ``memory`` than is free."""
    most = SIZE if most is None else most
    if size > most:
        raise InputError(f"{path}: takes {size:,} bytes or more to read, at most {most:,} are read of one file")
    memory = max(size, memory)
    if memory > LITTLE and memory > (free := SHARE * free_memory() * 2**20):
        raise InputError(
            f"{path}: takes {memory / 2**30:.2g} GiB of memory or more to read, {free / 2**30:.2g} GiB may be taken: "
            "split it, free memory or raise ulimit -v"
        )


def check_text(path: Path | str, text: str) -> None:
    """The same of a ``text`` that is about to be taken apart into rows."""
    rows = sum(map(text.count, LINE_ENDS)) - text.count("\r\n")
    if rows > ROWS:
        raise InputError(f"{path}: holds {rows:,} rows or more, at most {ROWS:,} are read of one file")
    check_size(path, len(text), memory=PER_ROW * rows + PER_BYTE * len(text))


# --------------------------------------------------------------------------------------------------
# Locks on open files: they end with their process, and are seen from every container that runs on the same system.


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


# --------------------------------------------------------------------------------------------------
# Signals and other processes.


@contextmanager
def interrupts_wait() -> Iterator[None]:
    """Ctrl-C waits meanwhile, also in processes that are started; where the system can block signals."""
    mask = getattr(signal, "pthread_sigmask", None)  # not on Windows
    before = mask and mask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        if mask:
            mask(signal.SIG_SETMASK, before)


def has_ended(number: int) -> bool:
    """Whether no process of this system has this ``number``; False where none can be asked for, as in a browser."""
    with contextlib.suppress(ImportError):
        import psutil

        return not psutil.pid_exists(number)
    return False

"""What a computation costs: CPU and wall time and peak memory of whole processes, and a yardstick of the machine."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any, TypeVar

import numpy as np
from scipy.sparse import diags_array, eye_array, kron
from scipy.sparse.linalg import splu

from ...base.errors import SolveError

LAUNCHER = """
import resource, subprocess, sys
code = subprocess.call(sys.argv[1:])
usage = resource.getrusage(resource.RUSAGE_CHILDREN)
if code == 0:
    print(usage.ru_utime + usage.ru_stime, usage.ru_maxrss, file=sys.stderr)
sys.exit(code if code >= 0 else 1)
"""

T = TypeVar("T")


@dataclass(frozen=True)
class Cost:
    """CPU seconds (user and system, descendants included), wall seconds, and peak memory [MiB] of the largest."""

    cpu_s: float
    wall_s: float
    memory_mib: float | None = None


def process_cost(command: Sequence[str], folder: Path | None = None, output: Path | None = None) -> Cost:
    """Run ``command`` in ``folder``, its standard output to ``output``; SolveError where it fails.

    A small process in between starts it: the peak memory of a process includes that of the one it was forked from.
    """
    start = time.perf_counter()
    with Path(os.devnull if output is None else output).open("wb") as sink:
        done = subprocess.run([sys.executable, "-S", "-c", LAUNCHER, *command], cwd=folder, stdout=sink,
                              stderr=subprocess.PIPE)  # fmt: skip
    wall = time.perf_counter() - start
    said = done.stderr.decode(errors="replace").splitlines()
    if done.returncode != 0:
        words = " ".join(said[-2:])[-300:]
        raise SolveError(f"{' '.join(command)}: ended with code {done.returncode}: {words}")
    cpu, kilobytes = map(float, said[-1].split())
    return Cost(cpu, wall, kilobytes / 1024)


def timed(function: Callable[[], T]) -> tuple[T, Cost]:
    """What ``function`` returns, and the CPU and wall seconds of the call in this process."""
    wall, cpu = time.perf_counter(), time.process_time()
    result = function()
    return result, Cost(time.process_time() - cpu, time.perf_counter() - wall)


def typical(run: Callable[[], Cost], repeat: int, long: float = 5.0) -> Cost:
    """The median of each figure over ``repeat`` runs, fewer where they take ``long`` [CPU s]."""
    costs = [run()]
    while len(costs) < repeat and sum(cost.cpu_s for cost in costs) < long:
        costs.append(run())
    memory = [cost.memory_mib for cost in costs if cost.memory_mib is not None]
    return Cost(
        median(cost.cpu_s for cost in costs),
        median(cost.wall_s for cost in costs),
        median(memory) if memory else None,
    )


def yardstick(side: int = 250, runs: int = 3) -> float:
    """CPU seconds of a fixed piece of work that has nothing to do with this program, the least of several runs.

    A sparse factorisation of the five-point Laplacian on 250 x 250 points, dense products, a loop of the interpreter.
    """
    line = diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(side, side))
    unit = eye_array(side)
    laplacian = (kron(line, unit) + kron(unit, line)).tocsc()
    dense = np.ones((600, 600))

    def work() -> None:
        splu(laplacian)
        for _ in range(5):
            dense @ dense
        sum(i * i for i in range(1_000_000))

    return min(timed(work)[1].cpu_s for _ in range(runs))


def machine() -> Mapping[str, Any]:
    """Processor, cores and Python of this machine; no names of hosts or users."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "system": platform.system(),
        "python": platform.python_version(),
    }


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()

"""What a call costs, the typical cost of several, and a yardstick of the machine."""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from statistics import median
from typing import Any, TypeVar

import numpy as np
from scipy.sparse import diags_array, eye_array, kron
from scipy.sparse.linalg import splu

from jkrcli.many.studies import Cost

T = TypeVar("T")


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

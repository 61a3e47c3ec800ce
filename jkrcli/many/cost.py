"""What a command costs: CPU and wall time and peak memory of a whole process."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ..base import SolveError

LAUNCHER = """
import resource, subprocess, sys
code = subprocess.call(sys.argv[1:])
usage = resource.getrusage(resource.RUSAGE_CHILDREN)
if code == 0:
    print(usage.ru_utime + usage.ru_stime, usage.ru_maxrss, file=sys.stderr)
sys.exit(code if code >= 0 else 1)
"""


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
    lines = done.stderr.decode(errors="replace").splitlines()
    if done.returncode != 0:
        words = " ".join(lines[-2:])[-300:]
        raise SolveError(f"{' '.join(command)}: ended with code {done.returncode}: {words}")
    cpu, kilobytes = map(float, lines[-1].split())
    return Cost(cpu, wall, kilobytes / 1024)

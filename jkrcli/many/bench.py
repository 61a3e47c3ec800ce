"""Where the time of a run goes: its stages, imports and the whole process, in CPU seconds."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from ..base.errors import SolveError
from ..base.process import StageClock
from ..base.result import Result
from ..case.reading import Case
from ..case.store import solve, write_solution

# --------------------------------------------------------------------------------------------------
# What a command costs: CPU and wall time and peak memory of a whole process.

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


IMPORTS = "import time; t = time.process_time(); import {}; print(time.process_time() - t)"
FEW = 3  # choice: imports and whole processes, which take longer than most runs


@dataclass(frozen=True, eq=False)
class Bench(Result):
    """CPU seconds of each of the ``stages`` of several runs of the case in ``file`` by a ``method``."""

    file: Path
    method: str
    repeat: int
    stages: Mapping[str, Sequence[float]]

    @classmethod
    def of(cls, file: Path, case: Case, method: str, module: str, repeat: int) -> Bench:
        """The stages of the ``case``, whose method stands in ``module``."""
        runs, few = [_once(case, method) for _ in range(repeat)], range(min(repeat, FEW))
        names = dict.fromkeys(key for run in runs for key in run)
        stages = {"import": [_import_seconds(module) for _ in few]}
        stages |= {stage: [run.get(stage, 0.0) for run in runs] for stage in names}
        stages["whole process"] = [_process_seconds(file, method) for _ in few]
        return cls(file, method, repeat, stages)

    def summary(self) -> dict[str, Any]:
        stages = {name: {"min_s": min(each), "median_s": median(each)} for name, each in self.stages.items()}
        return {"case": str(self.file), "method": self.method, "repeat": self.repeat, "stages": stages}

    def words(self) -> list[str]:
        whole, few = median(self.stages["whole process"]), min(self.repeat, FEW)
        return [
            f"{whole:.2f} s CPU by {self.method}: {self.file}; {self.repeat} runs, imports and whole process {few}",
            f"  {'stage':<18}{'min':>9}{'median':>9}",
            *(f"  {stage:<18}{min(each):>9.4f}{median(each):>9.4f}" for stage, each in self.stages.items()),
        ]


def _once(case: Case, name: str) -> dict[str, float]:
    """Stages of one solve in this process, all of them together, and of writing the file."""
    clock = StageClock()
    with clock("solve, total"):
        _, solution = solve(case, name)
    with tempfile.TemporaryDirectory() as folder, clock("write"):
        write_solution(Path(folder) / "series.h5", solution, "jkr bench")
    return {**solution.timings, **clock.seconds}


def _import_seconds(module: str) -> float:
    """CPU seconds to import the command line, the case reader, the file format and the method in a new process."""
    names = f"jkrcli.cli.case_verbs, {module}, skfem, gmsh" if ".fem" in module else f"jkrcli.cli.case_verbs, {module}"
    done = subprocess.run([sys.executable, "-c", IMPORTS.format(names)], capture_output=True, text=True, check=True)
    return float(done.stdout)


def _process_seconds(case: Path, name: str) -> float:
    """CPU seconds of ``jkr run`` as a whole process."""
    with tempfile.TemporaryDirectory() as folder:
        target = str(Path(folder) / "series.h5")
        return process_cost(
            [sys.executable, "-m", "jkrcli", "run", str(case.resolve()), "--method", name, "-o", target]
        ).cpu_s

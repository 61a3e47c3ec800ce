"""Where the time of a run goes: its stages, imports and the whole process, in CPU seconds."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from ..base import StageClock
from ..case import Case, solve, write_solution
from ..report import Result
from .cost import process_cost

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
    names = f"jkrcli.cli.run, {module}, skfem, gmsh" if ".fem" in module else f"jkrcli.cli.run, {module}"
    done = subprocess.run([sys.executable, "-c", IMPORTS.format(names)], capture_output=True, text=True, check=True)
    return float(done.stdout)


def _process_seconds(case: Path, name: str) -> float:
    """CPU seconds of ``jkr run`` as a whole process."""
    with tempfile.TemporaryDirectory() as folder:
        target = str(Path(folder) / "series.h5")
        return process_cost(
            [sys.executable, "-m", "jkrcli", "run", str(case.resolve()), "--method", name, "-o", target]
        ).cpu_s

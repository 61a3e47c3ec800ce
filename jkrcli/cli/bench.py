"""``jkr bench``: where the time of a run goes."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

import click

from ..base import StageClock, printable
from ..case import Case, load_case, store
from ..case.solving import solve
from ..many.cost import process_cost
from ..methods import METHODS
from ..methods.guards import Limits
from .options import limits_options
from .verb import Verb
from .voice import announce, note, present

IMPORTS = "import time; t = time.process_time(); import {}; print(time.process_time() - t)"


@click.command(cls=Verb)
@click.argument("case", type=click.Path(path_type=Path))
@click.option("--method", type=click.Choice(METHODS), help="Method, instead of the case's.")
@click.option("--repeat", type=click.IntRange(1, 1000), default=5, show_default=True, help="Runs.")
@limits_options
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def bench(case: Path, method: str | None, repeat: int, limits: Limits, as_json: bool) -> None:
    """Time the stages of CASE in CPU seconds (one BLAS thread): minimum and median of several runs.

    \b
    jkr bench cases/halfspace.toml
    jkr bench cases/halfspace.toml --method layered --repeat 20
    """
    loaded = load_case(case)
    choice, solution = solve(loaded, method, limits, note)
    announce(f"bench of {repeat} runs", (repeat + min(repeat, 3)) * sum(solution.timings.values()))
    runs = [_once(loaded, choice.name) for _ in range(repeat)]
    stages = {"import": [_import_seconds(type(choice.method).__module__) for _ in range(min(repeat, 3))]}
    stages |= {
        stage: [run.get(stage, 0.0) for run in runs] for stage in dict.fromkeys(key for run in runs for key in run)
    }
    stages["whole process"] = [_process_seconds(case, choice.name) for _ in range(min(repeat, 3))]
    table = {stage: {"min_s": min(seconds), "median_s": median(seconds)} for stage, seconds in stages.items()}
    if as_json:
        click.echo(json.dumps({"case": str(case), "method": choice.name, "repeat": repeat, "stages": table}, indent=2))
        return
    shown, few = printable(str(case)), min(repeat, 3)
    whole = table["whole process"]["median_s"]
    present([
        f"{whole:.2f} s CPU by {choice.name}: {shown}; {repeat} runs, imports and whole process {few}",
        f"  {'stage':<18}{'min':>9}{'median':>9}",
        *(f"  {stage:<18}{figures['min_s']:>9.4f}{figures['median_s']:>9.4f}" for stage, figures in table.items()),
    ])  # fmt: skip


def _once(case: Case, name: str) -> dict[str, float]:
    """Stages of one solve in this process, all of them together, and of writing the file."""
    clock = StageClock()
    with clock("solve, total"):
        _, solution = solve(case, name)
    with tempfile.TemporaryDirectory() as folder, clock("write"):
        store.write(Path(folder) / "series.h5", solution, "jkr bench")
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

"""``jkr run``: a case file to a series file."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import click

from ..adhesion.validity import check, end_of_body, judge, sizes
from ..base.units import reached
from ..base.unknown import Estimate, Unknown, accuracy
from ..beside.sticking import as_told, effect_facts, sticking_effect, sticking_warnings
from ..bodies.problem import Problem
from ..case import Case, load_case, store
from ..case.solving import solve
from ..methods import METHODS
from ..methods.choose import Choice
from ..methods.guards import Limits
from ..report.output import Output
from ..series import Solution
from .options import limits_options
from .output import ONE_FILE, answer, into_file, output_options
from .series import end_of
from .verb import Verb
from .voice import command_line, detail, note, present, warn


@click.command(cls=Verb)
@click.argument("case", type=click.Path(path_type=Path))
@into_file("Series file [default: <case>.h5 here].")
@click.option("--method", type=click.Choice(["auto", *METHODS]), help="Method, instead of the case's.")
@click.option(
    "--tolerance",
    type=float,
    help="Relative error asked of the load at given depth, of any method, instead of the case's.",
)
@limits_options
@output_options(force=ONE_FILE, json="Print the summary as JSON.")
def run(
    case: Path,
    method: str | None,
    tolerance: float | None,
    limits: Limits,
    output: Output,
) -> None:
    """Solve the nonadhesive contact of CASE (TOML) and write load, displacement and contact radius to HDF5.

    The work of adhesion plays no part here: one run serves every w (see: jkr transform).

    \b
    jkr run cases/halfspace.toml
    jkr run my.toml --method layered -o results/my.h5
    jkr run my.toml --method fem --tolerance 1e-3
    """
    start = time.process_time()
    loaded = load_case(case)
    if tolerance is not None:
        loaded = loaded.with_tolerance(tolerance, method or loaded.model.method)
    target = output.series(Path(f"{case.stem}.h5"), [case])
    choice, solution = solve(loaded, method, limits, note)
    for stage, used in solution.timings.items():
        detail(f"{stage}: {used:.3f} s CPU")
    problem = loaded.model.problem()
    effect = sticking_effect(problem, float(solution.series.a[-1]), ())
    solution = replace(solution, facts={**solution.facts, **effect_facts(effect)})
    store.write(target, solution, command_line())
    seconds = time.process_time() - start
    warnings = [
        *missed(tolerance, solution.budget.total), *loaded.remarks, *solution.warnings,
        *_geometry(problem, solution), *sticking_warnings(problem, effect),
    ]  # fmt: skip
    if output.json:
        answer(_as_json(target, choice, solution, warnings, seconds) | {"sticking": as_told(effect)})
    else:
        _print(loaded, target, choice, solution, seconds)
    for warning in warnings:
        warn(warning)


def missed(tolerance: float | None, error: Estimate) -> list[str]:
    """A warning where the ``error`` of a solution is not known to be what was asked for."""
    if tolerance is None or (not isinstance(error, Unknown) and error <= tolerance):
        return []
    words = error.reason if isinstance(error, Unknown) else f"{error:.1e}"
    return [f"--tolerance: {tolerance:g} was asked for, and the error is {words}"]


def _geometry(problem: Problem, solution: Solution) -> list[str]:
    """Warnings that need no work of adhesion: a/R, delta/h, a/L, and too few points to go on with."""
    series = solution.series
    judged = judge(
        a=float(series.a[-1]),
        delta=float(series.delta[-1]),
        w=0.0,
        **sizes(problem),
        L=end_of_body(problem, solution.facts),
        z0=None,
        end_is_cut=problem.specimen.radius is None,
    )
    few = [f"only {len(series)} points: adhesive curves need at least 5"] if len(series) < 5 else []
    return [*check(judged), *few]


def _as_json(
    target: Path, choice: Choice, solution: Solution, warnings: list[str], seconds: float
) -> dict[str, object]:
    return {
        "file": str(target),
        "method": choice.name,
        "reason": choice.reason,
        "surface": solution.problem.surface,
        **end_of(solution.series),
        "errors": solution.budget.as_dict(),
        "warnings": warnings,
        "cpu_s": seconds,
    }


def _print(case: Case, target: Path, choice: Choice, solution: Solution, seconds: float) -> None:
    series = solution.series
    end = reached(series.a[-1], series.delta[-1], series.P[-1])
    present([
        f"{end} in {len(series)} points; {accuracy(solution.budget.total)}",
        f"  body      {case.model.problem().words}",
        f"  method    {choice.name}: {choice.reason}",
    ], last=f"  written   {target} ({seconds:.2f} s CPU)")  # fmt: skip

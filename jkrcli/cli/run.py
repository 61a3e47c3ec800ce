"""``jkr run``: a case file to a series file."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import click

from ..base import check_series_target
from ..beside import effect_facts, sticking_effect
from ..case import load_case, solve, write_solution
from ..methods import METHODS, Limits
from ..report import Output, Solved
from .options import ONE_FILE, into_file, limits_options, output_options
from .verb import verb
from .voice import command_line, detail, give, note


@verb("case")
@into_file("Series file [default: <case>.h5 here].")
@click.option("--method", type=click.Choice(["auto", *METHODS]), help="Method, instead of the case's.")
@click.option("--tolerance", type=float,
              help="Relative error asked of the load at given depth, of any method, instead of the case's."
)  # fmt: skip
@limits_options
@output_options(force=ONE_FILE, json="Print the summary as JSON.")
def run(case: Path, method: str | None, tolerance: float | None, limits: Limits, output: Output) -> None:
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
    target = output.file(Path(f"{case.stem}.h5"), [case], check_series_target)
    choice, solution = solve(loaded, method, limits, note)
    for stage, used in solution.timings.items():
        detail(f"{stage}: {used:.3f} s CPU")
    effect = sticking_effect(solution.problem, float(solution.series.a[-1]), ())
    solution = replace(solution, facts={**solution.facts, **effect_facts(effect)})
    write_solution(target, solution, command_line())
    seconds = time.process_time() - start
    give(Solved(target, solution, choice, effect, seconds, tolerance, loaded.remarks), output.json)

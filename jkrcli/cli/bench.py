"""``jkr bench``: where the time of a run goes."""

from __future__ import annotations

from pathlib import Path

import click

from ..case import load_case, solve
from ..many.bench import FEW, Bench
from ..methods import METHODS, Limits
from .options import json_option, limits_options
from .verb import verb
from .voice import announce, give, note


@verb("case")
@click.option("--method", type=click.Choice(METHODS), help="Method, instead of the case's.")
@click.option("--repeat", type=click.IntRange(1, 1000), default=5, show_default=True, help="Runs.")
@limits_options
@json_option
def bench(case: Path, method: str | None, repeat: int, limits: Limits, as_json: bool) -> None:
    """Time the stages of CASE in CPU seconds (one BLAS thread): minimum and median of several runs.

    \b
    jkr bench cases/halfspace.toml
    jkr bench cases/halfspace.toml --method layered --repeat 20
    """
    loaded = load_case(case)
    choice, solution = solve(loaded, method, limits, note)
    announce(f"bench of {repeat} runs", (repeat + min(repeat, FEW)) * sum(solution.timings.values()))
    give(Bench.of(case, loaded, choice.name, type(choice.method).__module__, repeat), as_json)

"""``jkr study converge``: the same case on a sequence of meshes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

from ..base import InputError, executor
from ..case import load_case, method_of
from ..many.study.converge import converge
from ..methods import FEM
from ..report import PICTURES, Output
from .option_types import WORK
from .options import Parallel, parallel_options
from .output import give, into_folder, output_options
from .verb import verb
from .voice import progress


@verb("case", "converge")
@click.option("--levels", type=click.IntRange(2, 8), default=4, show_default=True, help="Meshes; the last: the case's.")
@click.option("--contact", type=click.Choice(["nested", "incremental"]), help="Instead of the case's.")
@click.option("--w", "work", type=WORK, help="Work of adhesion [default: the case's first].")
@parallel_options
@into_folder("Folder.", default=Path())
@output_options(plots="Write CSV and JSON only.", json="Print as JSON.")
def study_converge(
    case: Path, levels: int, contact: str | None, work: float | None, parallel: Parallel, output: Output
) -> None:
    """Solve CASE by finite elements on meshes whose elements halve from one to the next (Appendix C).

    For each: contact radius and load at the common depth, pull-off force, points kept, time; then the observed order
    and the extrapolated value. Writes <case>-convergence.csv, .json, .png and .svg.

    \b
    jkr study converge cases/thin-layer.toml --levels 5
    jkr study converge cases/halfspace.toml --contact incremental -o results
    """
    loaded = load_case(case)
    w = work if work is not None else next(iter(loaded.model.adhesion.w), None)
    if not w:
        raise InputError(f"{case}: names no work of adhesion > 0: give --w")
    folder = output.folder(Path())
    files = output.files(folder / f"{case.stem}-convergence", (".csv", ".json", *PICTURES), [case])
    method = method_of(loaded.model, "fem")
    assert isinstance(method, FEM)
    if contact is not None:
        method = replace(method, contact=contact)  # type: ignore[arg-type]
    problem = loaded.model.problem()
    with executor(*parallel, progress, method.forecast(problem).seconds) as pool:
        study = converge(problem, method, w, levels, pool=pool)
    files.write(study.columns, study.summary(), files.draw(study.figure))
    give(study, output.json, f"  written   {files}")

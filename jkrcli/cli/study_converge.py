"""``jkr study converge``: the same case on a sequence of meshes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from .. import plots, tables
from ..adhesion import Outside
from ..case import load_case
from ..case.numerics import method_of
from ..errors import InputError
from ..files import check_target, write_text
from ..fem.method import FEM
from ..study.converge import QUANTITIES, Convergence, converge
from ..study.figures import convergence_figure
from ..units import show
from ..words import describe
from .options import WorkOfAdhesion

ENDINGS = (".csv", ".json", ".png", ".svg")
WORDS = {"a": "contact radius", "P": "load", "pull_off": "pull-off force"}


@click.command("converge")
@click.argument("case", type=click.Path(path_type=Path))
@click.option("--levels", type=click.IntRange(2, 8), default=4, show_default=True, help="Meshes; the last: the case's.")
@click.option("--contact", type=click.Choice(["nested", "incremental"]), help="Instead of the case's.")
@click.option("--w", "work", type=WorkOfAdhesion(), help="Work of adhesion [default: the case's first].")
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False), default=Path(), help="Folder.")
@click.option("--force", is_flag=True, help="Replace existing files that jkr did not write.")
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def study_converge(
    case: Path, levels: int, contact: str | None, work: float | None, output: Path, force: bool, as_json: bool
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
    output.mkdir(parents=True, exist_ok=True)
    targets = {ending: output / f"{case.stem}-convergence{ending}" for ending in ENDINGS}
    for target in targets.values():
        check_target(target, force)
    options = loaded.model.mesh.model_dump(exclude_none=True)
    algorithm = contact if contact is not None else loaded.model.contact.algorithm
    found = converge(loaded.model.problem(), FEM(contact=algorithm, **options), w, levels)  # type: ignore[arg-type]
    data = as_dict(found)
    write_text(targets[".csv"], tables.csv(_columns(found)))
    write_text(targets[".json"], tables.as_json(data))
    figure = convergence_figure(found)
    for ending in (".png", ".svg"):
        plots.save(figure, targets[ending])
    if as_json:
        click.echo(tables.as_json(data).rstrip())
    else:
        _print(found)
        click.echo(f"  written   {targets['.csv'].with_suffix('')}{{{','.join(ENDINGS)}}}")

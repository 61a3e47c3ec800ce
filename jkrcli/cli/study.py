"""``jkr study``: a verb for each map, made of its row, and the same case on a sequence of meshes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import click

from ..base import InputError, executor
from ..many.study import MAPS
from ..report import PICTURES, Output
from .options import PAIRS, WORK, Parallel, into_folder, output_options, parallel_options
from .verb import LateGroup, Verb, several, verb
from .voice import give, progress

if TYPE_CHECKING:
    from ..many.study import maps

STUDIES = {f"{name}-map": words for name, words in MAPS.items()} | {
    "converge": "The same case on a sequence of meshes."
}
# Studies of the methods, and the targets of make that run them.
MAKE = {"chart": "chart", "failures": "failures", "figures": "paper", "noise": "noise-study"}


class Studies(LateGroup):
    """The studies: of maps each is made of its row."""

    titles: ClassVar = {"Studies": STUDIES}

    def made(self, name: str) -> click.Command:
        if name == "converge":
            return study_converge
        from ..many.study import maps

        return _command(maps.map_of(name.removesuffix("-map")))

    def unknown(self, name: str) -> str:
        if name in MAKE:
            return f'"{name}" is now run as make {MAKE[name]}'
        return f'unknown study "{name}" (studies: {", ".join(STUDIES)})'


@click.group(cls=Studies)
def study() -> None:
    """Maps and studies over many bodies.

    \b
    jkr study pull-off-map --nu 0.3 --nu 0.499
    """


def _command(row: maps.Map) -> click.Command:
    """The verb of a map: an option for each axis."""

    @parallel_options
    @into_folder("Folder [default: .].", default=Path())
    @output_options(plots="Write the CSV only.", json="Print the table as JSON.")
    def study_map(output: Output, parallel: Parallel, **axes: Any) -> None:
        chosen = {name: value for name, value in axes.items() if value not in (None, ())}
        files = output.files(output.folder(Path()) / f"{row.name}-map", (".csv", *PICTURES))
        with executor(*parallel, progress, row.forecast(**chosen)) as pool:
            result = row.over(pool, **chosen)
        files.write(result.columns, figure=files.draw(result.figure))
        give(result, output.json, f"  written {files}")

    options = several(*(_option(name, axis) for name, axis in row.axes.items()))
    return click.command(f"{row.name}-map", cls=Verb, help=row.help)(options(study_map))


def _option(name: str, axis: maps.Axis) -> Any:
    kind: Any = float if axis.read is None else str
    default = axis.default if axis.several else (axis.default,)
    if isinstance(axis.default, dict):
        kind = PAIRS
        default = [f"{key}={value}" for key, value in axis.default.items()]
    elif isinstance(axis.allowed, tuple):
        kind = click.Choice(axis.allowed)
    shown = axis.shown or ", ".join(map(str, default))
    return click.option(f"--{name}", type=kind, multiple=axis.several, help=f"{axis.help}  [default: {shown}]".strip())


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
    from ..case import load_case, method_of
    from ..many.study import converge
    from ..methods import FEM

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
        study = converge.converge(problem, method, w, levels, pool=pool)
    files.write(study.columns, study.summary(), files.draw(study.figure))
    give(study, output.json, f"  written   {files}")

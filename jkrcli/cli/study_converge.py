"""``jkr study converge``: the same case on a sequence of meshes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..base.errors import InputError
from ..base.executors import executor
from ..base.units import show
from ..base.unknown import Unknown
from ..case import load_case
from ..case.numerics import method_of
from ..many.study.converge import QUANTITIES, Convergence, converge
from ..methods.fem.method import FEM
from ..report import tables
from ..report.output import PICTURES, Output
from .options import WorkType, parallel_options
from .output import answer, into_folder, output_options
from .verb import Verb
from .voice import present, progress, warn

if TYPE_CHECKING:
    from ..report.plots import Figure

WORDS = {"a": "contact radius", "P": "load", "pull_off": "pull-off force"}


@click.command("converge", cls=Verb)
@click.argument("case", type=click.Path(path_type=Path))
@click.option("--levels", type=click.IntRange(2, 8), default=4, show_default=True, help="Meshes; the last: the case's.")
@click.option("--contact", type=click.Choice(["nested", "incremental"]), help="Instead of the case's.")
@click.option("--w", "work", type=WorkType(), help="Work of adhesion [default: the case's first].")
@parallel_options
@into_folder("Folder.", default=Path())
@output_options(plots="Write CSV and JSON only.", json="Print as JSON.")
def study_converge(
    case: Path,
    levels: int,
    contact: str | None,
    work: float | None,
    workers: int | None,
    scheduler: str | None,
    output: Output,
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
    with executor(workers, scheduler, progress, method.forecast(problem).seconds) as pool:
        found = converge(problem, method, w, levels, pool=pool)
    data = as_dict(found)
    files.write(_columns(found), data, files.draw(lambda: _figure(found)))
    if output.json:
        answer(data)
    else:
        present(_words(found), last=f"  written   {files}")
    for level in found.levels:
        if isinstance(level.state.point, Unknown):
            warn(f"elements of {show(level.size, 'length', 3)}: {level.state.point.reason}")


def _figure(found: Convergence) -> Figure:
    from ..many.study.converge_figure import convergence_figure

    return convergence_figure(found)


def as_dict(found: Convergence) -> dict[str, Any]:
    """The study as JSON: the meshes from coarse to fine, the exact values where there are some, the limits."""
    return {
        "format": "jkr-convergence",
        "version": 1,
        "problem": found.problem.words,
        "w_J_per_m2": found.w,
        "depth_m": found.depth,
        "levels": [
            {
                "size_m": level.size,
                "elements": level.elements,
                "unknowns": level.unknowns,
                "a_m": level.state.a,
                "P_N": level.state.P,
                "pull_off": tables.point(level.state.point),
                "points": {"kept": level.kept, "dropped": level.dropped},
                "cpu_s": level.seconds,
            }
            for level in found.levels
        ],
        "exact": {WORDS[name]: found.exact.value(name) for name in QUANTITIES} if found.exact is not None else None,
        "extrapolated": {
            WORDS[name]: {"reason": limit} if isinstance(limit, Unknown) else {"order": limit[0], "value": limit[1]}
            for name, limit in found.extrapolated.items()
        },
        "order": {WORDS[name]: found.order(name) for name in QUANTITIES},
        "errors": {WORDS[name]: found.errors(name) for name in QUANTITIES},
        "time_exponent": found.time_exponent,
    }


def _columns(found: Convergence) -> dict[str, Sequence[Any]]:
    """A row per mesh; the pull-off cell is empty where it lies outside the series."""
    levels = found.levels
    return {
        "size_m": [level.size for level in levels],
        "elements": [level.elements for level in levels],
        "unknowns": [level.unknowns for level in levels],
        "a_m": found.values("a"),
        "P_N": found.values("P"),
        "pull_off_P_N": found.values("pull_off"),
        "points_kept": [level.kept for level in levels],
        "points_dropped": [level.dropped for level in levels],
        "cpu_s": [level.seconds for level in levels],
    }


def _words(found: Convergence) -> list[str]:
    """The finest mesh and its errors, then the orders, then a line per mesh."""
    finest = found.levels[-1]
    errors = {name: found.errors(name) for name in QUANTITIES}
    worst = max((abs(held[-1]) for held in errors.values() if held[-1] is not None), default=None)
    against = "the exact solution" if found.exact is not None else "the extrapolated value or the finest mesh"
    told = "no errors" if worst is None else f"errors within {worst:.1e} of {against}"
    lines = [
        f"elements of {show(finest.size, 'length', 3)}: {told}",
        f"  body      {found.problem.words}",
        f"  at        delta = {show(found.depth, 'length')}, w = {show(found.w, 'work')}",
    ]
    for name in QUANTITIES:
        order, limit = found.order(name), found.extrapolated[name]
        words = f"no order: {order}" if isinstance(order, Unknown) else f"observed order {order:.2f}"
        ends = (
            f"not extrapolated: {limit}"
            if isinstance(limit, Unknown)
            else f"extrapolated {show(limit[1], 'length' if name == 'a' else 'load', 6)}"
        )
        lines.append(f"  {WORDS[name]:<15} {words}; {ends}")
    lines += [
        f"  {'CPU seconds':<15} grow like the number of unknowns to the power {found.time_exponent:.2f}",
        f"  {'size':>10}{'elements':>10}{'a':>12}{'error':>9}{'P':>12}{'error':>9}{'pull-off':>12}{'error':>9}"
        f"{'kept':>6}{'dropped':>8}{'CPU s':>7}",
    ]
    for i, level in enumerate(found.levels):
        cells = "".join(
            _cell(level.state.value(name), errors[name][i], "length" if name == "a" else "load") for name in QUANTITIES
        )
        lines.append(
            f"  {show(level.size, 'length', 3):>10}{level.elements:>10}{cells}{level.kept:>6}{level.dropped:>8}"
            f"{level.seconds:>7.2f}"
        )
    return lines


def _cell(value: float | None, error: float | None, dimension: str) -> str:
    if value is None:
        return f"{'none':>12}{'':>9}"
    return f"{show(value, dimension):>12}" + (f"{'':>9}" if error is None else f"{error:>+9.1e}")

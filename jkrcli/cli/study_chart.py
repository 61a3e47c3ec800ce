"""``jkr study chart``: speed against accuracy, every method on one case."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from ..base.errors import InputError
from ..base.files import check_target, make_folder, write_text
from ..base.table import write_csv
from ..base.unknown import known
from ..bodies.words import describe
from ..case import Case, load_case
from ..many.study.chart import (
    PATIENCE,
    LeftOut,
    Measured,
    automatic,
    beside_front,
    chart,
    chosen_points,
    front,
    settings_of,
)
from ..many.study.chart_measure import machine, yardstick
from ..many.study.chart_peers import Peer, read_peers
from ..many.study.chart_reference import reference_of
from ..methods import METHODS
from ..report import tables
from .options import WorkOfAdhesion
from .voice import warn

ENDINGS = (".csv", ".json", ".png", ".svg")


@dataclass(frozen=True)
class Found:
    """All that the verb reports."""

    case: Case
    w: float
    reference: str
    points: Sequence[Measured]
    left_out: Sequence[LeftOut]
    peers: Sequence[Peer]
    yardstick: float
    auto: str

    @property
    def front(self) -> list[int]:
        return front([_pair(point) for point in self.points])

    @property
    def auto_beside_front(self) -> bool | None:
        """None where the method that "auto" takes was not measured."""
        mine = chosen_points(self.points, self.auto)
        return any(beside_front(_pair(p), [_pair(q) for q in self.points]) for p in mine) if mine else None


def _pair(point: Measured) -> tuple[float, float]:
    return point.whole.cpu_s, point.errors.load


@click.command("chart")
@click.argument("case", type=click.Path(path_type=Path))
@click.option("--methods", multiple=True, type=click.Choice(list(METHODS)), help="Only these [default: all].")
@click.option("--w", "work", type=WorkOfAdhesion(), help="Work of adhesion [default: the case's first].")
@click.option("--repeat", type=click.IntRange(1, 100), default=3, show_default=True, help="Runs; medians are shown.")
@click.option("--patience", type=click.FloatRange(0.1), default=PATIENCE, show_default=True,
              help="Leave out what would take longer [CPU s].")  # fmt: skip
@click.option("--peers", type=click.Path(path_type=Path), help="Stored timings of other programs, to be drawn too.")
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False), default=Path(), help="Folder.")
@click.option("--no-plots", is_flag=True, help="Write CSV and JSON only.")
@click.option("--force", is_flag=True, help="Replace existing files that jkr did not write.")
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def study_chart(
    case: Path,
    methods: tuple[str, ...],
    work: float | None,
    repeat: int,
    patience: float,
    peers: Path | None,
    output: Path,
    no_plots: bool,
    force: bool,
    as_json: bool,
) -> None:
    """Solve CASE by every method and setting: CPU and wall time, memory, and error against the exact solution.

    Whole process (jkr run) and after imports, medians of several runs; errors of P at equal displacement, of the
    adhesive curve and of the pull-off force. Writes <case>-chart.csv, .json, .png and .svg.

    \b
    jkr study chart cases/thin-layer.toml
    jkr study chart cases/halfspace.toml --methods fem --repeat 5 -o results
    """
    loaded = load_case(case)
    w = work if work is not None else next(iter(loaded.model.adhesion.w), None)
    if not w:
        raise InputError(f"{case}: names no work of adhesion > 0: give --w")
    make_folder(output)
    targets = {ending: output / f"{case.stem}-chart{ending}" for ending in (ENDINGS[:2] if no_plots else ENDINGS)}
    for target in targets.values():
        check_target(target, force, [case, *([peers] if peers else [])])
    measure = yardstick()
    theirs = [peer for peer in read_peers(peers, measure) if peer.body == case.stem] if peers else []
    reference = reference_of(loaded.model.problem(), w)
    settings = settings_of(loaded.model, methods)
    with click.progressbar(
        chart(loaded, settings, w, reference, repeat, patience), length=len(settings), label="chart", hidden=as_json
    ) as running:
        results = list(running)
    found = Found(
        loaded,
        w,
        reference.name,
        [point for result in results if not isinstance(result, LeftOut) for point in result],
        [result for result in results if isinstance(result, LeftOut)],
        theirs,
        measure,
        automatic(loaded),
    )
    data = as_dict(found)
    write_csv(targets[".csv"], _columns(found))
    write_text(targets[".json"], tables.as_json(data))
    if not no_plots:
        _draw(found, targets)
    if as_json:
        click.echo(tables.as_json(data).rstrip())
    else:
        _print(found)
        click.echo(f"  written   {targets['.csv'].with_suffix('')}{{{','.join(targets)}}}")
    if found.auto_beside_front is False:
        warn(f'"auto" takes {found.auto}, which is not on or next to the Pareto front')


def _draw(found: Found, targets: dict[str, Path]) -> None:
    from ..many.study.plots_chart import chart_figure
    from ..report import plots

    figure = chart_figure(found.points, found.peers, describe(found.case.model.problem()))
    for ending in ENDINGS[2:]:
        plots.save(figure, targets[ending])


def as_dict(found: Found) -> dict[str, Any]:
    """The chart as JSON."""
    best = found.front
    return {
        "format": "jkr-chart",
        "version": 1,
        "problem": describe(found.case.model.problem()),
        "w_J_per_m2": found.w,
        "reference": found.reference,
        "machine": machine(),
        "yardstick_cpu_s": found.yardstick,
        "auto": {"method": found.auto, "beside_front": found.auto_beside_front},
        "points": [
            {
                "method": point.setting.method,
                "setting": point.setting.words,
                "slopes": point.slopes,
                "unknowns": point.unknowns,
                "whole_process": vars(point.whole),
                "after_imports": vars(point.after_imports),
                "slopes_cpu_s": point.slopes_cpu_s,
                "stated_error": point.stated,
                "errors": vars(point.errors),
                "on_front": i in best,
            }
            for i, point in enumerate(found.points)
        ],
        "left_out": [
            {"method": out.setting.method, "setting": out.setting.words, "reason": out.reason} for out in found.left_out
        ],
        "peers": [
            {
                "peer": f"{peer.name} {peer.version}",
                "settings": peer.settings,
                "unknowns": peer.unknowns,
                "whole_process": vars(peer.whole),
                "after_imports_cpu_s": peer.after_imports_cpu_s,
                "errors": vars(peer.errors),
            }
            for peer in found.peers
        ],
    }


def _columns(found: Found) -> dict[str, list[Any]]:
    rows = [
        {
            "method": point.setting.method,
            "setting": point.setting.words,
            "slopes": point.slopes,
            "unknowns": point.unknowns,
            "whole_cpu_s": point.whole.cpu_s,
            "whole_wall_s": point.whole.wall_s,
            "memory_MiB": point.whole.memory_mib,
            "after_imports_cpu_s": point.after_imports.cpu_s,
            "after_imports_wall_s": point.after_imports.wall_s,
            "slopes_cpu_s": point.slopes_cpu_s,
            "stated_error": known(point.stated),
            "P_error": point.errors.load,
            "curve_error": point.errors.curve,
            "pull_off_error": point.errors.pull_off,
        }
        for point in found.points
    ]
    names = list(rows[0]) if rows else ["method", "setting", "slopes", "unknowns"]
    return {name: [row[name] for row in rows] for name in names}


def _print(found: Found) -> None:
    click.echo(describe(found.case.model.problem()))
    click.echo(f"  against   {found.reference}; * is on the Pareto front of whole-process CPU and error of P")
    click.echo(f"    {'method':<12}{'setting':<32}{'slopes':<9}{'unknowns':>9}{'process':>9}{'solve':>9}{'MiB':>6}"
               f"{'P':>9}{'curve':>9}{'pull-off':>9}")  # fmt: skip
    best = found.front
    for i, point in enumerate(found.points):
        errors = (point.errors.load, point.errors.curve, point.errors.pull_off)
        cells = "".join(f"{'-' if error is None else f'{error:.1e}':>9}" for error in errors)
        click.echo(f"  {'*' if i in best else ' '} {point.setting.method:<12}{point.setting.words:<32}{point.slopes:<9}"
                   f"{point.unknowns or '-':>9}{point.whole.cpu_s:>9.2f}{point.after_imports.cpu_s:>9.4f}"
                   f"{point.whole.memory_mib or 0:>6.0f}{cells}")  # fmt: skip
    for peer in found.peers:
        after, load = peer.after_imports_cpu_s, peer.errors.load
        solve = "-" if after is None else f"{after:.2f}"
        pull_off = "-" if peer.errors.pull_off is None else f"{peer.errors.pull_off:.1e}"
        name = f"{peer.name} {peer.version}, {peer.settings}"
        click.echo(f"    {name:<53}{peer.unknowns:>9}{peer.whole.cpu_s:>9.1f}"
                   f"{solve:>9}{peer.whole.memory_mib or 0:>6.0f}{load:>9.1e}{'':>9}{pull_off:>9}")  # fmt: skip
    for out in found.left_out:
        click.echo(f"    {out.setting.method}, {out.setting.words}: left out, {out.reason}")
    click.echo(f"  auto      takes {found.auto}")

"""``jkr transform``: series files to adhesive curves."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..adhesion.analysis import Analysis, analyse, specification
from ..adhesion.curve import CriticalPoint
from ..base.errors import InputError
from ..base.files import check_target, make_folder, write_text
from ..base.table import write_csv
from ..base.units import show
from ..base.unknown import Estimate, Unknown
from ..case import store
from ..case.store import Stored
from ..report import tables
from ..report.scaling import Scales, own_scales, scales_of
from .options import Scale, WorkOfAdhesion, modulus_factor_option, slopes_option
from .voice import say, warn

ENDINGS = (".csv", ".json", ".png", ".svg")


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--w", "works", multiple=True, type=WorkOfAdhesion(), help='J/m^2 or "35 mJ/m^2" [default: the case\'s].')
@slopes_option
@modulus_factor_option
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False), help="Folder [default: the file's].")
@click.option("--dimensionless", type=click.Choice(["half-space", "thin-layer"]), help="Also in units of Eq. 15, 19.")
@click.option("--scale", "own", multiple=True, type=Scale(), help='Own units: a="1 um", delta=..., P=..., all three.')
@click.option("--no-plots", is_flag=True, help="Write CSV and JSON only.")
@click.option("--force", is_flag=True, help="Replace existing files that jkr did not write.")
@click.option("--json", "as_json", is_flag=True, help="Print the summaries as JSON.")
def transform(
    files: tuple[Path, ...],
    works: tuple[float, ...],
    slopes: str,
    modulus_factor: float,
    output: Path | None,
    dimensionless: str | None,
    own: tuple[tuple[str, float], ...],
    no_plots: bool,
    force: bool,
    as_json: bool,
) -> None:
    """Apply the explicit JKR transformation (Eq. 13) to each FILE for each work of adhesion.

    Writes <stem>-w<J/m^2>.csv, .json, .png and .svg; <stem>-w<J/m^2>-modulus<factor> with --modulus-factor.

    \b
    jkr transform data.h5 --w 50
    jkr transform gel.h5 --w "35 mJ/m^2" --w "40 mJ/m^2" -o results
    """
    if own and dimensionless:
        raise InputError("transform: give either --dimensionless or --scale, got both")
    users = own_scales(dict(own)) if own else None
    jobs = [_Job.of(path, works, output, modulus_factor) for path in files]
    _refuse_equal_targets([target for job in jobs for target in job.targets])
    endings = ENDINGS[:2] if no_plots else ENDINGS
    for job in jobs:
        if output is not None:
            make_folder(output)
        for target in job.targets:
            for ending in endings:
                check_target(target.with_name(target.name + ending), force, files)
    summaries = []
    for job in jobs:
        results = analyse(job.stored, job.works, slopes, modulus_factor)
        for result, target in zip(results, job.targets, strict=True):
            scales = scales_of(result, dimensionless) if dimensionless else users
            summaries.append(_write(result, target, scales, not no_plots))
        if not as_json:
            _print(job, results, endings)
    if as_json:
        click.echo(tables.as_json({"results": summaries}).rstrip())


class _Job:
    """One input file: what it holds, for which works of adhesion, and the names (without ending) of what is written."""

    def __init__(self, stored: Stored, works: tuple[float, ...], folder: Path, modulus_factor: float):
        self.stored = stored
        self.works = works
        ending = "" if modulus_factor == 1 else f"-modulus{modulus_factor:g}"
        self.targets = [folder / f"{stored.path.stem}-w{w:g}{ending}" for w in works]

    @classmethod
    def of(cls, path: Path, works: tuple[float, ...], output: Path | None, modulus_factor: float) -> _Job:
        stored = store.read(path)
        wanted = works or specification(stored).w
        if not wanted:
            raise InputError(f"{path}: its case names no work of adhesion: give --w")
        return cls(stored, wanted, output if output is not None else path.parent, modulus_factor)


def _refuse_equal_targets(targets: list[Path]) -> None:
    seen: set[Path] = set()
    for target in targets:
        if target.resolve() in seen:
            raise InputError(f"{target}.csv: would be written twice; rename a file, or give each its own -o and w once")
        seen.add(target.resolve())


def _write(result: Analysis, target: Path, scales: Scales | None, with_plots: bool) -> dict[str, Any]:
    """Write table, summary and plots of one curve; the figure is drawn before anything is written."""
    columns, summary = tables.curve_columns(result.curve), tables.summary(result)
    if scales is not None:
        columns |= scales.columns(result)
        summary["scales"] = {"name": scales.name, "P_N": scales.P, "delta_m": scales.delta, "a_m": scales.a}
    figure = None
    if with_plots:
        from ..report import plots
        from ..report.plots import curve as plots_curve

        units = plots_curve.physical_units(result.curve) if scales is None else plots_curve.units_of(scales)
        figure = plots_curve.curve_figure(result, units)
    write_csv(target.with_name(target.name + ".csv"), columns)
    write_text(target.with_name(target.name + ".json"), tables.as_json(summary))
    if figure is not None:
        for ending in ENDINGS[2:]:
            plots.save(figure, target.with_name(target.name + ending))
    return summary


def _known(result: Analysis, control: str) -> str:
    """The 90 % half-width of the pull-off force, relative to it."""
    found, point = result.pull_off_errors[control], result.pull_off[control]
    if isinstance(found, Unknown) or not isinstance(point, CriticalPoint) or point.P == 0:
        return "± ?"  # the JSON file says why
    percent = 100 * found["P"] / abs(point.P)
    return f"± {float(f'{percent:.2g}'):g} %"


def _print(job: _Job, results: list[Analysis], endings: tuple[str, ...]) -> None:
    slopes = results[0].curve.slopes
    kept = len(results[0].curve.series)
    say(
        f"{job.stored.path}: {kept} points kept, {results[0].dropped} dropped; slopes {slopes.method} ({slopes.reason})"
    )
    for result, target in zip(results, job.targets, strict=True):
        say(f"  w = {show(result.w, 'work')}")
        for name, point in result.pull_off.items():
            if isinstance(point, CriticalPoint):
                load = f"{show(point.P, 'load')} {_known(result, name)}"
                say(
                    f"    pull-off, {name + ' control:':<22} P = {load:<22} "
                    f"delta = {show(point.delta, 'length'):<12} a = {show(point.a, 'length')}"
                )
            elif result.w > 0:
                say(f"    pull-off, {name + ' control:':<22} not in the series (see the warning)")
        tabor = result.validity.tabor
        if not isinstance(tabor, Unknown):
            say(f"    Tabor number {tabor:.3g}: {result.validity.regime}")
        _print_comparison(result)
        budget = result.budget
        say(
            f"    estimated error: {_estimate(budget.total)} "
            f"(series {_estimate(budget.series)}, slopes {_estimate(budget.smoothing)})"
        )
        say(f"    written {target}{{{','.join(endings)}}}")
    for warning in dict.fromkeys(text for result in results for text in result.warnings):
        warn(f"{job.stored.path}: {warning}")


def _print_comparison(result: Analysis) -> None:
    found = result.comparison
    if found is None:
        return
    parts = [f"P_H(delta) within {found.load:.2e}"]
    if not isinstance(found.pull_off, Unknown):
        parts.append(f"pull-off force {found.pull_off:+.2e}")
    if not isinstance(found.curve, Unknown):
        parts.append(f"curve within {found.curve:.2e} pull-off units")
    say(f"    against the closed form of the same indenter: {', '.join(parts)}")
    if found.parabola is not None:
        say(
            f"    the sphere's own pull-off is {found.parabola:.2%} smaller than the paraboloid's -1.5 pi w R of Eq. 18"
            " (physics, not error)"
        )


def _estimate(value: Estimate) -> str:
    return str(value) if isinstance(value, Unknown) else f"{value:.1e}"

"""``jkr transform``: series files to adhesive curves."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..adhesion.analysis import Analysis, analyse
from ..adhesion.curve import CriticalPoint
from ..adhesion.law import AskedRange
from ..adhesion.sticking import StickingEffect, as_told, effect_on, sticking_warnings
from ..base.errors import InputError
from ..base.units import show
from ..base.unknown import Estimate, Unknown
from ..methods.guards import Limits
from ..report import tables
from ..report.output import PICTURES, Files, Output
from ..report.scaling import Scales, own_scales, scales_of
from .options import ScaleType, WorkType, limits_options, modulus_factor_option, range_options, slopes_option
from .output import answer, into_folder, output_options, refuse_doubles
from .series import attracted, begin_curves, read_series, series_file, works_of
from .voice import say, warn

if TYPE_CHECKING:
    from ..report.plots import Figure


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--w", "works", multiple=True, type=WorkType(), help='J/m^2 or "35 mJ/m^2" [default: the case\'s].')
@range_options
@slopes_option
@modulus_factor_option
@into_folder()
@click.option("--dimensionless", type=click.Choice(["half-space", "thin-layer"]), help="Also in units of Eq. 15, 19.")
@click.option(
    "--scale",
    "own",
    multiple=True,
    type=ScaleType(),
    help='Own units, one a --scale: a="1 um", delta=..., P=..., all three.',
)
@click.option("--together", is_flag=True, help="One picture of all w, <stem>-all-w.png and .svg, instead of one each.")
@limits_options
@output_options(plots="Write CSV and JSON only.", json="Print the summaries as JSON.")
def transform(
    files: tuple[Path, ...],
    works: tuple[float, ...],
    stress: float | None,
    length: float | None,
    slopes: str,
    modulus_factor: float,
    dimensionless: str | None,
    own: tuple[tuple[str, float], ...],
    together: bool,
    limits: Limits,
    output: Output,
) -> None:
    """Apply the explicit JKR transformation (Eq. 13) to each FILE, a case or a series, for each work of adhesion.

    With --stress or --range adhesion of finite range is solved for in its place (a constant tension up to a separation,
    Maugis 1992), on any body but those of finite elements. Writes <stem>-w<J/m^2>.csv, .json, .png and .svg;
    -stress<Pa>, -range<m> and -modulus<factor> are added to the name with these options.

    \b
    jkr transform data.h5 --w "50 mJ/m^2"
    jkr transform gel.h5 --w "35 mJ/m^2" --w "40 mJ/m^2" --together -o results
    """
    if own and dimensionless:
        raise InputError("transform: give either --dimensionless or --scale, got both")
    if together and dimensionless:
        raise InputError("transform: --together needs one unit for all w: give --scale instead of --dimensionless")
    users = own_scales(dict(own)) if own else None
    files = tuple(map(series_file, files))
    held = [read_series(path) for path in files]
    wanted = [works or works_of(solution) for solution in held]
    asked = [AskedRange.of(solution.record, stress, length) for solution in held]
    figures = output.plots and not together
    begin_curves("transform", held, wanted, asked, limits, tables=True, figures=figures)
    suffix = "" if modulus_factor == 1 else f"-modulus{modulus_factor:g}"
    stems = [
        [(output.where or path.parent) / f"{path.stem}-w{w:g}{ranged.suffix}{suffix}" for w in some]
        for path, some, ranged in zip(files, wanted, asked, strict=True)
    ]
    refuse_doubles([stem for some in stems for stem in some], "give each its own -o and w once")
    output.folder(Path())
    endings = (".csv", ".json") if together else (".csv", ".json", *PICTURES)
    targets = [[output.files(stem, endings, files) for stem in some] for some in stems]
    pictures = [
        output.files((output.where or path.parent) / f"{path.stem}-all-w{ranged.suffix}{suffix}", PICTURES, files)
        for path, ranged in zip(files, asked, strict=True)
        if together
    ]
    summaries = []
    for solution, some, ranged, written in zip(held, wanted, asked, targets, strict=True):
        results = analyse(solution, some, slopes, modulus_factor, ranged)
        effect = effect_on(solution.scaled(modulus_factor), some)
        for result, target in zip(results, written, strict=True):
            scales = scales_of(result.problem, result.w, dimensionless) if dimensionless else users
            summaries.append(_write(result, target, scales, figures, effect))
        if together and output.plots:
            picture = pictures.pop(0)
            picture.write(figure=_figure(results, users))
        for warning in sticking_warnings(solution.problem, effect):
            warn(f"{solution.record.path}: {warning}")
        if not output.json:
            _print(results, written)
            if together and output.plots:
                say(f"  all works of adhesion in one picture: {picture}")
    if output.json:
        answer({"results": summaries})


def _write(
    result: Analysis, target: Files, scales: Scales | None, with_plots: bool, effect: StickingEffect | Unknown
) -> dict[str, Any]:
    """Write table, summary and plots of one curve; the figure is drawn before anything is written."""
    columns, summary = tables.curve_columns(result.curve), tables.summary(result) | {"sticking": as_told(effect)}
    if scales is not None:
        columns |= scales.columns(result)
        summary["scales"] = {"name": scales.name, "P_N": scales.P, "delta_m": scales.delta, "a_m": scales.a}
    figure = None
    if with_plots:
        from ..report.plots import curve as plots_curve

        units = plots_curve.physical_units(result.curve) if scales is None else plots_curve.units_of(scales)
        figure = plots_curve.curve_figure(result, units)
    target.write(columns, summary, figure)
    return summary


def _figure(results: list[Analysis], users: Scales | None) -> Figure:
    """One picture of the curves of one body for several works of adhesion."""
    from ..report.plots import curve as plots_curve

    units = plots_curve.physical_units(results[-1].curve) if users is None else plots_curve.units_of(users)
    return plots_curve.curves_figure(results, units)


def _known(result: Analysis, control: str) -> str:
    """The 90 % half-width of the pull-off force, relative to it."""
    found, point = result.pull_off_errors[control], result.pull_off[control]
    if isinstance(found, Unknown) or not isinstance(point, CriticalPoint) or point.P == 0:
        return "± ?"  # the JSON file says why
    percent = 100 * found["P"] / abs(point.P)
    return f"± {float(f'{percent:.2g}'):g} %"


def _print(results: list[Analysis], targets: list[Files]) -> None:
    path, slopes = results[0].path, results[0].curve.slopes
    kept = len(results[0].curve.series)
    say(f"{path}: {kept} points kept, {results[0].dropped} dropped; slopes {slopes.method} ({slopes.reason})")
    for result, target in zip(results, targets, strict=True):
        say(f"  w = {show(result.w, 'work')}{attracted(result)}")
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
            f"(series {_estimate(budget.series)}, slopes {_estimate(budget.smoothing)}); "
            f"between the rows up to {_estimate(result.curve.interpolation_error)} more"
        )
        say(f"    written {target}")
    for warning in dict.fromkeys(text for result in results for text in result.warnings):
        warn(f"{path}: {warning}")


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

"""``jkr transform``: series files to adhesive curves."""

from __future__ import annotations

from pathlib import Path

import click

from ..adhesion import RangeRequest
from ..base import InputError
from ..beside import analyse, effect_on, sticking_warnings
from ..methods import Limits
from ..report import PICTURES, Files, Output, Transformed, as_result, figure_of, scaling
from .options import SCALE, WORK, CurveOptions, curve_options, into_folder, limits_options, output_options
from .series import begin_curves, read_files, works_of
from .verb import verb
from .voice import answer, present, warn


@verb("files...")
@click.option("--w", "works", multiple=True, type=WORK, help='J/m^2 or "35 mJ/m^2" [default: the case\'s].')
@curve_options
@into_folder()
@click.option("--dimensionless", type=click.Choice(["half-space", "thin-layer"]), help="Also in units of Eq. 15, 19.")
@click.option("--scale", "own", multiple=True, type=SCALE,
              help='Own units, one a --scale: a="1 um", delta=..., P=..., all three.')  # fmt: skip
@click.option("--together", is_flag=True, help="One picture of all w, <stem>-all-w.png and .svg, instead of one each.")
@limits_options
@output_options(plots="Write CSV and JSON only.", json="Print the summaries as JSON.")
def transform(
    files: tuple[Path, ...], works: tuple[float, ...], how: CurveOptions, dimensionless: str | None,
    own: tuple[tuple[str, float], ...], together: bool, limits: Limits, output: Output,
) -> None:  # fmt: skip
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
    users = scaling.own_scales(dict(own)) if own else None
    files, solutions = read_files("transform", files)
    wanted = [works or works_of(solution) for solution in solutions]
    ranges = list(map(how.of, solutions))
    figures = output.plots and not together
    begin_curves("transform", solutions, wanted, limits, ranges, tables=True, figures=figures)
    targets, pictures = _files(files, wanted, ranges, how.modulus_factor, together, output)
    summaries, lines, warnings = [], list[list[str]](), list[str]()
    for solution, works, ranged, places, picture in zip(solutions, wanted, ranges, targets, pictures, strict=True):
        effect = effect_on(solution.scaled(how.modulus_factor), works)
        results = list[Transformed]()
        for curve, target in zip(analyse(solution, works, how.slopes, how.modulus_factor, ranged), places, strict=True):
            scales = scaling.scales_of(curve.problem, curve.w, dimensionless) if dimensionless else users
            results.append(as_result(Transformed, curve, scales=scales, effect=effect))
            summaries.append(results[-1].summary())
            target.write(results[-1].columns, summaries[-1], results[-1].figure() if figures else None)
        if picture is not None:
            picture.write(figure=figure_of(results))
        lines += [result.words() for result in results]
        warnings += [f"{solution.record.path}: {text}" for text in sticking_warnings(solution.problem, effect)]
        warnings += [f"{result.path}: {text}" for result in results for text in result.warnings if not output.json]
    if output.json:
        answer({"results": summaries})
    else:
        written = [str(target) for places in targets for target in places]
        more = f" and {len(written) - 1:,} more like it" if len(written) > 1 else ""
        all_w = ", ".join(str(picture) for picture in pictures if picture is not None)
        present(*lines, last=f"  written {written[0]}{more}{all_w and f', all in one picture: {all_w}'}")
    for text in warnings:
        warn(text)


def _files(
    files: tuple[Path, ...], wanted: list[tuple[float, ...]], ranges: list[RangeRequest], modulus_factor: float,
    together: bool, output: Output,
) -> tuple[list[list[Files]], list[Files | None]]:  # fmt: skip
    """For each file what is written of each work of adhesion, and the picture of all of them, if there is to be one;
    InputError before anything is solved, where it cannot be."""
    factor = "" if modulus_factor == 1 else f"-modulus{modulus_factor:g}"
    places = [
        (output.beside(path), works, f"{ranged.suffix}{factor}")
        for path, works, ranged in zip(files, wanted, ranges, strict=True)
    ]
    stems = [begin.with_name(f"{begin.name}-w{w:g}{end}") for begin, works, end in places for w in works]
    endings = (".csv", ".json") if together else (".csv", ".json", *PICTURES)
    each = iter(output.each(stems, endings, files, " and w once"))
    pictures: list[Files | None] = [
        output.files(begin.with_name(f"{begin.name}-all-w{end}"), PICTURES, files)
        if together and output.plots else None for begin, _, end in places
    ]  # fmt: skip
    return [[next(each) for _ in works] for works in wanted], pictures

"""``jkr transform``: series files to adhesive curves."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import click

from ..adhesion import RangeRequest
from ..base import InputError
from ..beside import analyse, effect_on, sticking_warnings
from ..methods import Limits
from ..report import PICTURES, Files, Output, Transformed, as_result, figure_of
from ..report.scaling import own_scales, scales_of
from .option_types import WORK, ScaleType
from .options import CurveOptions, curve_options, limits_options
from .output import answer, into_folder, output_options, refuse_doubles
from .series import begin_curves, read_files, works_of
from .verb import verb
from .voice import present, warn


@verb("files...")
@click.option("--w", "works", multiple=True, type=WORK, help='J/m^2 or "35 mJ/m^2" [default: the case\'s].')
@curve_options
@into_folder()
@click.option("--dimensionless", type=click.Choice(["half-space", "thin-layer"]), help="Also in units of Eq. 15, 19.")
@click.option("--scale", "own", multiple=True, type=ScaleType(),
              help='Own units, one a --scale: a="1 um", delta=..., P=..., all three.')  # fmt: skip
@click.option("--together", is_flag=True, help="One picture of all w, <stem>-all-w.png and .svg, instead of one each.")
@limits_options
@output_options(plots="Write CSV and JSON only.", json="Print the summaries as JSON.")
def transform(
    files: tuple[Path, ...],
    works: tuple[float, ...],
    how: CurveOptions,
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
    files, solutions = read_files("transform", files)
    wanted = [works or works_of(solution) for solution in solutions]
    ranges = list(map(how.of, solutions))
    figures = output.plots and not together
    begin_curves("transform", solutions, wanted, ranges, limits, tables=True, figures=figures)
    plans = _plans(files, wanted, ranges, how.modulus_factor, together, output)
    summaries, lines, written, warnings = [], list[list[str]](), list[str](), list[str]()
    for solution, plan in zip(solutions, plans, strict=True):
        effect = effect_on(solution.scaled(how.modulus_factor), plan.works)
        curves = analyse(solution, plan.works, how.slopes, how.modulus_factor, plan.range)
        results = list[Transformed]()
        for curve, target in zip(curves, plan.targets, strict=True):
            scales = scales_of(curve.problem, curve.w, dimensionless) if dimensionless else users
            result = as_result(Transformed, curve, scales=scales, effect=effect)
            summaries.append(result.summary())
            target.write(result.columns, summaries[-1], result.figure() if figures else None)
            results.append(result)
        if plan.picture is not None:
            plan.picture.write(figure=figure_of(results))
        warnings += [f"{solution.record.path}: {text}" for text in sticking_warnings(solution.problem, effect)]
        lines += [result.words() for result in results]
        written += map(str, plan.targets)
        warnings += [f"{result.path}: {text}" for result in results for text in result.warnings if not output.json]
    if output.json:
        answer({"results": summaries})
    else:
        more = f" and {len(written) - 1:,} more like it" if len(written) > 1 else ""
        pictures = ", ".join(str(plan.picture) for plan in plans if plan.picture is not None)
        present(*lines, last=f"  written {written[0]}{more}{pictures and f', all in one picture: {pictures}'}")
    for text in warnings:
        warn(text)


@dataclass(frozen=True, eq=False)
class _Plan:
    """Curves of one file: its ``works`` of adhesion [J/m^2], their ``range``, what is written for each of the
    works, and the ``picture`` of all of them together, if there is to be one."""

    works: tuple[float, ...]
    range: RangeRequest
    targets: list[Files]
    picture: Files | None


def _plans(
    files: tuple[Path, ...], wanted: list[tuple[float, ...]], ranges: list[RangeRequest], modulus_factor: float,
    together: bool, output: Output,
) -> list[_Plan]:  # fmt: skip
    """What is written for each file; InputError before anything is solved, where it cannot be."""
    factor = "" if modulus_factor == 1 else f"-modulus{modulus_factor:g}"
    begins = [(output.where or path.parent) / path.stem for path in files]
    ends = [f"{ranged.suffix}{factor}" for ranged in ranges]
    stems = [
        [begin.with_name(f"{begin.name}-w{w:g}{end}") for w in works]
        for begin, end, works in zip(begins, ends, wanted, strict=True)
    ]
    refuse_doubles([stem for some in stems for stem in some], "give each its own -o and w once")
    output.folder(Path())
    endings = (".csv", ".json") if together else (".csv", ".json", *PICTURES)
    targets = [[output.files(stem, endings, files) for stem in some] for some in stems]
    pictures: list[Files | None] = [None] * len(files)
    if together and output.plots:
        pictures = [
            output.files(begin.with_name(f"{begin.name}-all-w{end}"), PICTURES, files)
            for begin, end in zip(begins, ends, strict=True)
        ]
    return [_Plan(*each) for each in zip(wanted, ranges, targets, pictures, strict=True)]

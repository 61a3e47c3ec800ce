"""``jkr explore``: one page with sliders."""

from __future__ import annotations

from pathlib import Path

import click

from ..base import InputError, write_text
from ..beside import analyse, seconds_of_page
from ..data import Reading, measured
from ..methods import Limits
from ..report import Output
from ..report.explorer import Explored, page, payload, start_work
from .measured import begin_reading, reading_options
from .options import ONE_FILE, WORK, into_file, limits_options, output_options, slopes_option
from .series import begin_curves, read_series, series_file, warn_of_constant_moduli, without_range
from .verb import verb
from .voice import give


@verb("file [data...]")
@into_file("The page [default: <file>-explore.html].")
@click.option("--w", "work", type=WORK, help="To begin with [default: the case's first].")
@slopes_option
@reading_options
@limits_options
@output_options(force=ONE_FILE, json="Print what was written as JSON.")
def explore(
    file: Path, data: tuple[Path, ...], work: float | None, slopes: str, reading: Reading, limits: Limits,
    output: Output,
) -> None:  # fmt: skip
    """Make one self-contained page with sliders from FILE, a case or a series, with measured DATA (CSV) drawn over the
    curve.

    It works from disk without a network: sliders and number fields for the work of adhesion, a factor to all moduli,
    the machine's stiffness and the data's zero point; stable and unstable branches, pull-off, the commands that give
    the same numbers, a button that saves the curve as CSV.

    \b
    jkr explore data.h5
    jkr explore gel.h5 measured.csv -o gel.html
    """
    if work == 0:
        raise InputError("explore: --w must be > 0 J/m^2 to begin with, got 0")
    if output.where is not None:
        output.file(output.where, [file, *data])
    file = series_file(file)
    target = output.file(file.parent / f"{file.stem}-explore.html", [file, *data])
    solution = read_series(file)
    warn_of_constant_moduli(solution)
    without_range(solution.record, "explore")
    begin_reading("explore", data, limits)
    curves = [curve for path in data for curve in measured.read(path, reading)]
    works = (work,) if work is not None else tuple(w for w in solution.record.w if w > 0)[:1]
    begin_curves("explore", [solution], [works or (1.0,)], limits, beside=seconds_of_page(solution))
    result = analyse(solution, works or (1.0,), slopes)[0]
    if not works:
        result = analyse(solution, (start_work(result.jkr.nonadhesive),), slopes)[0]
    text = page(payload(result, curves, slopes))
    write_text(target, text)
    give(Explored(file, target, result.w, len(result.curve.series), len(curves), sum(map(len, curves))), output.json)

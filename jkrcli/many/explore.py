"""``jkr explore``: one page with sliders."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..adhesion.finite_range import without_range
from ..base.errors import InputError
from ..base.files import write_text
from ..cli import inputs, options, readings
from ..cli.printing import give
from ..methods.protocol import Limits
from ..report.result import Output
from ..resolve.analysis import analyse, seconds_of_page

if TYPE_CHECKING:
    from ..data.curve import Reading


@options.verb("file [data...]")
@options.into_file("The page [default: <file>-explore.html].")
@click.option("--w", "work", type=options.WORK, help="To begin with [default: the case's first].")
@options.slopes_option
@readings.reading_options
@options.limits_options
@options.output_options(force=options.ONE_FILE, json="Print what was written as JSON.")
def explore(
    file: Path, data: tuple[Path, ...], work: float | None, slopes: str, reading: Reading, limits: Limits,
    output: Output,
) -> None:  # fmt: skip
    """Make one self-contained page with sliders from FILE, a case or a solution, with measured DATA (CSV) drawn over
    the curve.

    It works from disk without a network: sliders and number fields for the work of adhesion, a factor to all moduli,
    the machine's stiffness and the data's contact point; stable and unstable branches, pull-off, the commands that give
    the same numbers, a button that saves the curve as CSV.

    \b
    jkr explore data.h5
    jkr explore gel.h5 measured.csv -o gel.html
    """
    from ..data.curve import Reading
    from ..data.measured import read
    from .explorer import Explored, page, payload, start_work

    if work == 0:
        raise InputError("explore: --w must be > 0 J/m^2 to begin with, got 0")
    if output.where is not None:
        output.file(output.where, [file, *data])
    file = inputs.series_file(file)
    target = output.file(file.parent / f"{file.stem}-explore.html", [file, *data])
    solution = inputs.read_series(file)
    inputs.warn_of_constant_moduli(solution)
    without_range(solution.record, "explore")
    if not data and reading != Reading():
        raise InputError("explore: options of reading need measured DATA: leave them out")
    reading.refuse_contact("explore")
    readings.begin_reading("explore", data, limits)
    curves = [curve for path in data for curve in read(path, reading)]
    works = (work,) if work is not None else tuple(w for w in solution.record.w if w > 0)[:1]
    inputs.begin_curves("explore", [solution], [works or (1.0,)], limits, beside=seconds_of_page(solution))
    result = analyse(solution, works or (1.0,), slopes)[0]
    if not works:
        result = analyse(solution, (start_work(result.jkr.nonadhesive),), slopes)[0]
    text = page(payload(result, curves, slopes))
    write_text(target, text)
    give(Explored(file, target, result.w, len(result.curve.series), len(curves), sum(map(len, curves))), output.json)

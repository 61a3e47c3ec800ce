"""Verbs of measured curves but for fits: ``look`` and ``work``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..adhesion.finite_range import without_range
from ..base.errors import InputError, counted
from ..base.files import together, write_text
from ..cli import inputs, options
from ..cli.printing import answer, give, progress
from ..report.result import PICTURES, SHOWN, Output, Results
from ..resolve.analysis import nonadhesive
from . import readings
from .curve import Use

if TYPE_CHECKING:
    from .curve import Reading

# --------------------------------------------------------------------------------------------------
# Verbs of measured files: ``look``, before any body is thought of, and ``work`` along a curve.


@options.verb("files...")
@readings.tip_options
@readings.reading_options
@click.option("--rigid", is_flag=True, help="The specimen is rigid (glass): print the sensitivity of the deflection.")
@options.into_folder()
@options.output_options(plots="Draw nothing.", json="Print everything as JSON.")
def look(files: tuple[Path, ...], flags: inputs.Flags, reading: Reading, output: Output, rigid: bool) -> None:
    """Show what measured FILES hold: the first thing to do with a force curve; no specimen is needed.

    Prints how columns and units were read; of each curve its segments, base line and noise, contact point, jumps,
    adhesion force, and what is wrong with it. With --radius a rough E* and w. Draws <stem>-look.png and .svg;
    of several curves also a page with all of them, small, their grades in a table, and each large, <stem>-look.html, of
    several files curves-look.html.

    \b
    jkr look curve.jpk-force --radius "5 um"
    jkr look probe.csv --flip delta --unit P=nN
    """
    from .report import Look

    if output.where is not None and not output.plots:
        raise InputError("look: --output has no effect with --no-plots: leave one out")
    tip = readings.tip_of("look", flags)
    files = tuple(path if path.name else path.absolute() for path in files)  # "."
    targets = output.each([output.beside(path, "-look") for path in files], PICTURES, files)
    readings.begin_reading("look", files)
    several = files[0] if len(files) == 1 else files[0].with_name("curves")
    curves = output.files(output.beside(several, "-look"), (".html",) if output.plots else (), files)
    results, pictures = [], list[str]()
    with together():
        for path, target in zip(files, targets, strict=True):
            result = Look.at(path, reading, tip, rigid)
            results.append(result)
            if result.records and output.plots:
                target.write(figure=result.figure())
                pictures.append(str(target))
        records = [record for result in results for record in result.records]
        if output.plots and len(records) > 1:
            from .curve_page import page

            write_text(
                curves[".html"],
                page(
                    records, f"{counted(len(records), 'curve')}: {', '.join(map(str, files[:3]))}", len(records) > SHOWN
                ),
            )
            pictures.append(str(curves))
    whole = Results(results, [line for result in results for line in result.warnings], "files")
    if not any(result.records for result in results):
        if output.json:
            answer(whole.summary())
        raise InputError(whole.warnings)
    give(whole, output.json, f"  drawn in {', '.join(pictures)}" if pictures else "")
    if not all(result.records for result in results):  # what could be read is shown, and a script still learns of it
        click.get_current_context().exit(InputError.exit_code)


# --------------------------------------------------------------------------------------------------
# ``jkr work``: the work of adhesion along measured curves.


@options.verb("series measured...")
@click.option("--use", type=options.choice(Use),
              help="Columns from which w is computed [default: the first of these that were measured].")  # fmt: skip
@click.option("--segment", help='Rows of this segment only, "retract".')
@click.option("--noise", multiple=True, type=options.SCALE, help='Standard deviation of a measured quantity, P="2 nN".')
@click.option("--window", type=int, default=11, show_default=True, help="Rows for the speed da/dt: an odd number.")
@options.modulus_factor_option
@options.slopes_option
@readings.reading_options
@options.into_folder()
@click.option("--workers", type=options.WORKERS, default=1, show_default=True, help="Local processes.")
@options.output_options(plots="Write CSV and JSON only.", json="Print the summaries as JSON.")
def work(
    series: Path, measured: tuple[Path, ...], modulus_factor: float, slopes: str, reading: Reading, workers: int,
    output: Output, **chosen: Any,
) -> None:  # fmt: skip
    """The work of adhesion along each MEASURED file, on the body of the SERIES file.

    At each measured point w = S' (delta_H - delta)^2/(4 pi a), the energy release rate of the contact's edge: from a
    and P (needs no zero of the displacement), a and delta, or delta and P. Of raw force curves base line and contact
    point are fitted first, and the rows on which the edge moves are taken. With a time column also the speed da/dt of
    the edge: rate-dependent adhesion, and w0 (1 + (v/v0)^n) through the rows whose crack opens. Tables name their
    columns and units, "a_um, P_mN, t_s"; files of force microscopes (.jpk-force, .jpk-force-map, .ibw, .h5, .tab) are
    read by the optional package afmformats.
    Writes <stem>-work.csv, .json, .png and .svg.

    \b
    jkr work gel.h5 microscope.csv --noise a="2 um" --noise P="5 uN"
    jkr work gel.h5 probe.csv --unit P=mN --flip delta --stiffness "2 kN/m"
    jkr work data.h5 map.jpk-force-map --contact estimate --segment retract
    """
    from ..base.executors import executor
    from .report import Work
    from .work import along_file, evaluation_of

    targets = output.each(
        [output.beside(path, "-work") for path in measured], (".csv", ".json", *PICTURES), (series, *measured)
    )
    series = inputs.series_file(series)
    readings.begin_reading("work", measured, per_row=readings.TABLE_WORK_PER_ROW)
    solution = inputs.read_series(series)
    inputs.warn_of_constant_moduli(solution)
    without_range(solution.record, "work")
    unit = nonadhesive(solution, slopes)
    chosen["noise"] = dict(chosen["noise"])
    evaluation = evaluation_of(solution, unit, reading, modulus_factor, **chosen)
    results = []
    with together():
        for path, target in zip(measured, targets, strict=True):
            with executor(workers, progress=progress) as pool:
                curves, skipped = along_file(path, reading, evaluation, pool)
            result = Work.of(path, curves, skipped, solution, unit, modulus_factor)
            results.append(result)
            target.write(result.columns, result.summary(), target.draw(result.figure))
    warnings = [text for result in results for text in result.warnings]
    give(Results(results, warnings), output.json, f"  written {', '.join(map(str, targets))}")

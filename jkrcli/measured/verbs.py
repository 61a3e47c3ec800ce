"""Verbs of measured curves: ``look``, ``work`` and ``fit``."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..base.errors import LEVEL, InputError, counted
from ..base.files import together, write_text
from ..base.wings import is_offered, offered
from ..cli import inputs, options
from ..cli.printing import answer, give, progress
from ..methods.protocol import Limits
from ..report.result import PICTURES, SHOWN, Output, Results
from . import readings
from .choices import BaseLineName, BranchName, ConfidenceName, Loss, ModelName, SegmentName, Use

if TYPE_CHECKING:
    from .curve import Reading
    from .fits import FitOptions

# --------------------------------------------------------------------------------------------------
# Verbs of measured files: ``look``, before any body is thought of, and ``work`` along a curve.


@options.verb("files...")
@readings.tip_options
@readings.reading_options
@click.option("--rigid", is_flag=True, help="The specimen is rigid (glass): print the sensitivity of the deflection.")
@options.into_folder()
@options.output_options(plots="Draw nothing.", json="Print everything as JSON.")
def look(files: tuple[Path, ...], flags: inputs.Flags, reading: Reading, output: Output, rigid: bool) -> None:
    """Show what measured FILES hold, before any fit and without a specimen.

    The output says how columns and units were read. For each curve it states segments, base line, noise, contact point,
    jumps, adhesion force, and defects; with --radius also a rough E* and w. The pictures are <stem>-look.png and .svg.
    Several curves also give a page with all curves and their grades: <stem>-look.html, or curves-look.html for several
    files.

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
    """Compute the work of adhesion at every point of each MEASURED curve, for the specimen of the solution SERIES.

    At each measured point it is the energy release rate w = S' (delta_H - delta)^2/(4 pi a) of the contact edge. The
    verb uses a and P (independent of the zero of displacement), a and delta, or delta and P. On raw force curves it
    first fits base line and contact point, and then uses the points at which the edge moves. A time column also gives
    the speed da/dt of the edge, and the law w0 (1 + (v/v0)^n) is fitted where contact opens. Tables name their columns
    and units, "a_um, P_mN, t_s". The optional package afmformats reads files of force microscopes (.jpk-force,
    .jpk-force-map, .ibw, .h5, .tab). The results are <stem>-work.csv, .json, .png and .svg.

    \b
    jkr work gel.h5 microscope.csv --noise a="2 um" --noise P="5 uN"
    jkr work gel.h5 probe.csv --unit P=mN --flip delta --stiffness "2 kN/m"
    jkr work data.h5 map.jpk-force-map --contact estimate --segment retract
    """
    from ..adhesion.finite_range import without_range
    from ..base.executors import executor
    from ..resolve.analysis import nonadhesive
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


# --------------------------------------------------------------------------------------------------
# ``jkr fit``: E*, w and the contact point from measured curves.


class NamesType(options.ParsedType):
    """One or several names, separated by commas."""

    name = "NAME,..."

    def parsed(self, text: str) -> Any:
        return tuple(part.strip() for part in text.split(",") if part.strip())


class GridType(options.ParsedType):
    """Columns and rows of a grid."""

    name = "COLUMNSxROWS"

    def parsed(self, text: str) -> Any:
        if not (match := re.fullmatch(r"\s*([1-9]\d{0,4})\s*[x×]\s*([1-9]\d{0,4})\s*", text)):
            raise ValueError(f'must be columns x rows, such as 6x5, got "{text}"')
        return int(match[1]), int(match[2])


# Of laws over time, where a wing fits them.
OVER_TIME: options.Options = offered("options of laws over time") or options.several()

# Of samples, where a wing sums them up.
OF_SAMPLES = (
    click.option("--sample", help="Regular expression that finds the name of the sample in that of each file or curve "
                 "[default: by a line \"# sample: ctrl\" or a column sample, else folders]."),
    click.option("--report", is_flag=True, help="Write a report, <BODY>-report.html and .md, of several files report."),
) if is_offered("samples of a fit") else ()  # fmt: skip

# Of the fit.


ASKED = options.as_one(
    "asked",
    "measured.fits:FitOptions",
    click.option("--free", multiple=True, type=NamesType(),
                 help="Further parameters to fit: P0, compliance, E:LAYER, h:LAYER (thickness), range or stress (of "
                 "adhesion), drift, hysteresis, creep (of the piezo), surface_tension."),
    click.option("--fix", multiple=True, type=options.NAMED,
                 help='Known: w="50 mJ/m^2", delta0=0, modulus=1, E_star="1 MPa".'),
    click.option("--start", multiple=True, type=options.NAMED,
                 help="Starting value, in addition to those estimated from the data."),
    click.option("--bound", multiple=True, type=options.NAMED,
                 help='Bounds, w="10 mJ/m^2..1 J/m^2"; one may be left out. '
                 'Of what is not fitted what is known: range="..10 nm", surface_tension="..30 mN/m".'),
    OVER_TIME,
    click.option("--segment", type=options.choice(SegmentName),
                 help="Directions to fit [default: both; with --law retract]."),
    click.option("--base-line", type=options.choice(BaseLineName), default="straight", show_default=True,
                 help="Of a raw force curve; sine: only models with a wave (interference)."),
    click.option("--branch", type=options.choice(BranchName), default="all", show_default=True,
                 help="compressive: rows under compression only."),
    click.option("--noise", multiple=True, type=options.SCALE,
                 help='Standard deviation of the readings, P="2 nN" [default: from the force curve].'),
    click.option("--loss", type=options.choice(Loss), default="linear",
                 show_default=True, help="Anything but linear is robust against outliers."),
    click.option("--confidence", type=options.choice(ConfidenceName), default="covariance",
                 show_default=True, help="How the intervals are found."),
    click.option("--model", type=options.choice(ModelName), default="jkr", show_default=True,
                 help="Of a raw force curve; auto: the best other models too, where its data favour one."),
    click.option("--alternatives", "--rivals", "rivals", is_flag=True,
                 help="Print what the data of a raw force curve say of each other model."),
    click.option("--plan", is_flag=True, help="Print which further measurement would narrow E* and w most."),
    click.option("--level", type=float, default=LEVEL, show_default=True, help="Of the intervals."),
    click.option("--samples", type=click.IntRange(20, 100_000), default=200, show_default=True,
                 help="Number of bootstrap resamples."),
    click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Seed of the resamples."),
    click.option("--shared", multiple=True, type=NamesType(),
                 help="Fit all force curves together: parameters that they share, such as E_star,w."),
    click.option("--own", multiple=True, type=NamesType(),
                 help="With --shared: those of each force curve, delta0,P0 [default: all other free ones]."),
    click.option("--tip-radius", multiple=True, type=options.LENGTH_ABOVE_0,
                 help="Tip radius of each file or folder, or of all [default: BODY's]."),
    click.option("--surface", type=click.Choice(["sliding", "sticking", "both"]),
                 help="Instead of the case's; both: fit with each and state which one the data favour."),
    click.option("--uncertain", multiple=True, type=options.NAMED,
                 help="Standard deviation of an input: radius=3%, stiffness=10%; but range=1nm is the longest range of "
                 "adhesion."),
    click.option("--grid", type=GridType(), help="Columns and rows of a map whose files lie row by row, 6x5 [default: "
                 "positions in headers, or names]."),
    *OF_SAMPLES,
)  # fmt: skip

# Of the body, of the fit, of the reading, of what is written.
OPTIONS = options.several(
    inputs.body_options,
    ASKED,
    options.slopes_option,
    readings.reading_options,
    options.limits_options,
    options.parallel_options,
    options.into_folder("Folder [default: BODY's]."),
    options.output_options(f"Draw nothing (else up to {SHOWN} curves are drawn).", "Print the summary as JSON."),
)  # fmt: skip


@options.verb("body [measured...]")
@OPTIONS
def fit(
    body: Path, measured: tuple[Path, ...], flags: inputs.Flags, reading: Reading, slopes: str,
    parallel: options.Parallel, limits: Limits, output: Output, asked: FitOptions,
) -> None:  # fmt: skip
    """Fit E*, w and the contact point to each MEASURED curve, with confidence intervals and alternative models.

    BODY is a case or a solution file. If options give the specimen (--radius, --nu, --thickness ...), every given file
    is a measured one. A measured file is a force curve, or a table with at least two of the columns a, delta and P. The
    option --free adds unknowns, such as E:LAYER and h:LAYER. The results are <BODY>-fit.csv, .json, .h5 and pictures;
    if options give the specimen, they are named <FILE>-fit, or fit for several files. The CSV has one row per curve.
    Several curves also give a page to click through them. One folder is read as a map; several folders are compared as
    samples, in samples.csv and samples.png.

    \b
    jkr fit curve.jpk-force --radius "5 um" --nu 0.5
    jkr fit coating.toml probe.csv --free E:skin --bound E:skin="1 MPa..1 GPa"
    """
    from .fits import fit_measured

    fit_measured(body, measured, flags, reading, slopes, parallel, limits, output, asked)

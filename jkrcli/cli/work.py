"""``jkr work``: the work of adhesion along measured curves."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..base.errors import InputError
from ..report.output import PICTURES, Files, Output
from .measured import TUNING, begin_reading, reading_of, reading_options
from .options import WORKERS, ScaleType, modulus_factor_option, slopes_option
from .output import answer, into_folder, output_options, refuse_doubles
from .verb import Verb
from .voice import progress, say, warn

if TYPE_CHECKING:
    from ..base.unknown import Unknown
    from ..data.measured import Reading
    from ..identification.rate.through import LawThrough
    from ..identification.work import Evaluation, WorkAlong

CHUNK = 20  # curves in one task
SHOWN = 10  # curves of a file that are told line by line


@click.command(cls=Verb)
@click.argument("series", type=click.Path(path_type=Path))
@click.argument("measured", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--use", type=click.Choice(["a,P", "a,delta", "delta,P"]),
              help="What w follows from [default: the first of these that was measured].")  # fmt: skip
@click.option("--segment", help='Rows of this segment only, "retract".')
@click.option("--noise", multiple=True, type=ScaleType(), help='Standard deviation of a measured quantity, P="2 nN".')
@click.option("--window", type=int, default=11, show_default=True, help="Rows for the speed da/dt: an odd number.")
@modulus_factor_option
@slopes_option
@reading_options
@into_folder()
@click.option("--workers", type=WORKERS, default=1, show_default=True, help="Local processes.")
@output_options(plots="Write CSV and JSON only.", json="Print the summaries as JSON.")
def work(
    series: Path,
    measured: tuple[Path, ...],
    modulus_factor: float,
    slopes: str,
    workers: int,
    output: Output,
    **options: Any,
) -> None:
    """The work of adhesion along each MEASURED file, on the body of the SERIES file.

    At each measured point w = S' (delta_H - delta)^2/(4 pi a), the energy release rate of the contact's edge: from a
    and P (needs no zero of the displacement), a and delta, or delta and P. Of raw records base line and contact
    point are fitted first, and the rows on which the edge moves are taken. With a time column also the speed da/dt of
    the edge: rate-dependent adhesion, and w0 (1 + (v/v0)^n) through the rows whose edge recedes. Tables name their
    columns and units, "a_um, P_mN, t_s"; files of force microscopes (.jpk-force, .jpk-force-map, .ibw, .h5, .tab) are
    read by the optional package afmformats.
    Writes <stem>-work.csv, .json, .png and .svg.

    \b
    jkr work gel.h5 microscope.csv --noise a="2 um" --noise P="5 uN"
    jkr work gel.h5 probe.csv --unit P=mN --flip delta --stiffness "2 kN/m" --zero delta="-310 um"
    jkr work data.h5 map.jpk-force-map --contact estimate --segment retract
    """
    from ..beside.analysis import adhesive, nonadhesive
    from ..identification.fit.body import body_of
    from ..identification.fit.settings import settings_of
    from ..identification.rate.through import law_along
    from ..identification.work import Evaluation, check_window, typical
    from ..report.rate import through_summary, through_words
    from ..report.work import summary
    from .series import read_series, series_file, without_range

    check_window(options["window"])
    stems = [(output.where or path.parent) / f"{path.stem}-work" for path in measured]
    refuse_doubles(stems, "give each its own -o")
    output.folder(Path())
    series = series_file(series)
    targets = [output.files(stem, (".csv", ".json", *PICTURES), (series, *measured)) for stem in stems]
    begin_reading("work", measured, per_row=TUNING.work_per_row)
    solution = read_series(series)
    without_range(solution.record, "work")
    unit = nonadhesive(solution, slopes)
    reading = reading_of(options)
    use = None if options["use"] is None else tuple(options["use"].split(","))
    body = unit.scaled(modulus_factor)
    fitted, contact = body_of(solution), "as-is" if reading.zero else reading.contact
    settings = settings_of(
        fitted, fix=[("modulus", f"{modulus_factor!r}")], contact=contact, segment=options["segment"]
    )
    own = options["segment"] in (None, "approach", "retract")
    evaluation = Evaluation(body, use, dict(options["noise"]), options["window"], options["segment"],
                            fitted if own else None, settings)  # fmt: skip
    summaries = []
    for path, target in zip(measured, targets, strict=True):
        found, skipped = _curves(path, reading, evaluation, workers)
        curve = adhesive(solution, unit, typical(found), modulus_factor)
        law = law_along(found)
        summaries.append(summary(found, curve, path, skipped) | {"rate_law": through_summary(law)})
        _write(target, found, summaries[-1], law, output.plots)
        if not output.json:
            _print(found)
            if law is not None:
                say(f"  {through_words(law)}")
            say(f"  written {target}")
        _warn(path, found, skipped, summaries[-1]["warnings"])
    if output.json:
        answer({"results": summaries})


def _curves(path: Path, reading: Reading, evaluation: Evaluation, workers: int) -> tuple[list[WorkAlong], list[str]]:
    """The curves of a file that have a work of adhesion, in its order, and why the others have none."""
    from ..base.executors import completed, executor
    from ..data.measured import each
    from ..data.text_table import some

    outcomes: list[Any] = list(each(path, reading))
    rows = [i for i, item in enumerate(outcomes) if not isinstance(item, InputError)]
    with executor(workers, progress=progress, seconds=TUNING.work_per_curve * len(rows)) as pool:
        for i, outcome in completed(pool, evaluation, [outcomes[row] for row in rows], path.name, CHUNK):
            outcomes[rows[i]] = outcome
    skipped: list[str] = []
    for outcome in outcomes:
        if isinstance(outcome, InputError):
            skipped += outcome.lines
        elif isinstance(outcome, Exception):
            raise outcome
    found = [outcome for outcome in outcomes if not isinstance(outcome, Exception)]
    if not found:
        raise InputError(some(skipped))
    return found, skipped


def _write(
    target: Files, found: list[WorkAlong], summary: dict[str, Any], law: LawThrough | Unknown | None, with_plots: bool
) -> None:
    """Table, summary and plots of one file; the figure is drawn before anything is written."""
    from ..report.work import columns

    figure = None
    if with_plots:
        from ..identification.rate.through import LawThrough
        from ..report.plots.work import work_figure

        figure = work_figure(found, law if isinstance(law, LawThrough) else None)
    target.write(columns(found), summary, figure)


def _print(found: list[WorkAlong]) -> None:
    from ..report.work import words

    for item in found[:SHOWN]:
        say("\n    ".join([words(item), *item.curve.flags]))
    if len(found) > SHOWN:
        say(f"  ... and {len(found) - SHOWN} more curves")


def _warn(path: Path, found: list[WorkAlong], skipped: list[str], warnings: list[str]) -> None:
    from ..data.text_table import some
    from ..report.work import flags

    said = [f"skipped: {line}" for line in some(skipped)]
    said += [f"{item.curve.where}: {flag}" for item in found[:SHOWN] for flag in flags(item)]
    for line in [*said, *(f"{path}: {warning}" for warning in warnings)]:
        warn(line)

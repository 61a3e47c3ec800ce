"""``jkr look``: what measured files hold, before any body is thought of."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..base.errors import InputError
from ..report.output import PICTURES, Output
from .measured import begin_reading, reading_of, reading_options
from .output import answer, into_folder, output_options, refuse_doubles
from .verb import Verb
from .voice import say, warn

if TYPE_CHECKING:
    from ..data.measured import Reading
    from ..data.record import ForceCurve

SHOWN = 10  # curves of a file that are told line by line


@click.command(cls=Verb)
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@reading_options
@into_folder()
@output_options(plots="Draw nothing.", json="Print everything as JSON.")
def look(files: tuple[Path, ...], output: Output, **options: Any) -> None:
    """What measured FILES hold: the first thing to do with a force curve. No body is needed.

    Says how columns and units were understood, and finds in every curve approach, pause and retraction, the base line
    with its noise, tilt and waviness, where contact begins and ends, jumps, the largest load and the adhesion force;
    and names what is wrong with a curve: no contact, a wavy base line, a detector at its limit. Where a file lacks its
    spring constant or sensitivity, 1 stands in, and that is said. Draws <stem>-look.png and .svg.

    \b
    jkr look curve.jpk-force
    jkr look probe.csv --flip delta --unit P=nN
    """
    from ..report.look import as_dict

    reading = replace(reading_of(options), incomplete=True)
    stems = [(output.where or path.parent) / f"{path.stem}-look" for path in files]
    refuse_doubles(stems, "give each its own -o")
    output.folder(Path())
    targets = [output.files(stem, PICTURES, files) for stem in stems]
    begin_reading("look", files)
    told, failures = [], []
    for path, target in zip(files, targets, strict=True):
        records, unusable = _records(path, reading)
        failures += unusable
        told.append({"file": str(path), "curves": [as_dict(record) for record in records], "unusable": unusable})
        drawn = output.plots and bool(records)
        if drawn:
            from ..report.plots.record import record_figure

            target.write(figure=record_figure(records))
        if not output.json:
            _print(records)
            if drawn:
                say(f"  drawn in {target}")
    if output.json:
        answer({"files": told})
    if not any(item["curves"] for item in told):
        raise InputError(failures)
    for line in failures:
        warn(line)


def _records(path: Path, reading: Reading) -> tuple[list[ForceCurve], list[str]]:
    """The curves of a file taken apart, and a line on each that cannot be."""
    from ..data.measured import each
    from ..data.record import examine

    records: list[ForceCurve] = []
    unusable: list[str] = []
    try:
        for curve in each(path, reading):
            try:
                if isinstance(curve, InputError):
                    raise curve
                records.append(examine(curve))
            except InputError as error:
                unusable += error.lines
    except InputError as error:
        unusable += error.lines
    return records, unusable


def _print(records: list[ForceCurve]) -> None:
    from ..report.look import words

    for record in records[:SHOWN]:
        for line in words(record):
            say(line)
    if len(records) > SHOWN:
        say(f"  ... and {len(records) - SHOWN} more curves (--json tells all)")

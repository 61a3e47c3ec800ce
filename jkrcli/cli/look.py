"""``jkr look``: what measured files hold, before any body is thought of."""

from __future__ import annotations

from pathlib import Path

import click

from ..base import InputError
from ..data import Reading
from ..report import PICTURES, Output, Results
from .body import Flags, tip_of, tip_options
from .measured import begin_reading, reading_options
from .options import into_folder, output_options
from .verb import verb
from .voice import answer, give


@verb("files...")
@tip_options
@reading_options
@into_folder()
@output_options(plots="Draw nothing.", json="Print everything as JSON.")
def look(files: tuple[Path, ...], flags: Flags, reading: Reading, output: Output) -> None:
    """What measured FILES hold: the first thing to do with a force curve. No body is needed.

    Says how columns and units were understood, and finds in every curve approach, pause and retraction, the base line
    with its noise, tilt and waviness, where contact begins and ends, jumps, the largest load and the adhesion force;
    and names what is wrong with a curve: no contact, a wavy base line, a detector at its limit. A file without
    spring constant or sensitivity is read in arbitrary units, with a warning. A tip (--radius, --shape) gives a rough
    E* and w by the formulas of a half-space. Draws <stem>-look.png and .svg. Exit code 2 where a file could not be
    read, though the others are shown.

    \b
    jkr look curve.jpk-force --radius "5 um"
    jkr look probe.csv --flip delta --unit P=nN
    """
    from ..report import Look

    tip = tip_of("look", flags)
    targets = output.each([output.beside(path, "-look") for path in files], PICTURES, files)
    begin_reading("look", files)
    results, pictures = [], list[str]()
    for path, target in zip(files, targets, strict=True):
        result = Look.at(path, reading, tip)
        results.append(result)
        if result.records and output.plots:
            target.write(figure=result.figure())
            pictures.append(str(target))
    whole = Results(results, [line for result in results for line in result.warnings], "files")
    if not any(result.records for result in results):
        if output.json:
            answer(whole.summary())
        raise InputError(whole.warnings)
    give(whole, output.json, f"  drawn in {', '.join(pictures)}" if pictures else "")
    if not all(result.records for result in results):  # what could be read is shown, and a script still learns of it
        click.get_current_context().exit(InputError.exit_code)

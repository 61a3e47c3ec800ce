"""``jkr export``: an adhesive contact as the law of another program."""

from __future__ import annotations

from pathlib import Path

import click

from ..base import InputError, together, write_text
from ..beside import analyse
from ..methods import Limits
from ..report import Output
from .options import WORK, into_folder, limits_options, output_options, slopes_option
from .series import begin_curves, body_and_work
from .verb import verb
from .voice import give


@verb("file")
@click.option("--dem", is_flag=True, help="For particle codes: a C header and a table of load and radius over overlap.")
@click.option("--w", "work", type=WORK, help='J/m^2 or "35 mJ/m^2" [default: the case\'s first].')
@slopes_option
@limits_options
@into_folder()
@output_options(json="Print the summary as JSON.")
def export(file: Path, dem: bool, work: float | None, slopes: str, limits: Limits, output: Output) -> None:
    """Write the adhesive contact of FILE, a case or a series, as a law that another program can use.

    With --dem: force and contact radius over the overlap of two particles on the stable branch, the state after first
    touch, and where contact is lost under displacement and under load control. Writes <stem>-dem.h (C99: table,
    function, test vectors and a check that compiles alone) and <stem>-dem.csv; says what JKR of a half-space would do.

    \b
    jkr export coating.h5 --dem --w "50 mJ/m^2"
    """
    if not dem:
        raise InputError("export: say for what: --dem, for particle codes (LAMMPS, LIGGGHTS, Lethe)")
    output.folder(Path())
    file, solution, w = body_and_work("export", file, work)
    if w == 0:
        raise InputError(f"{file}: a contact without adhesion needs no table of what holds it: give --w")
    targets = output.files(output.folder(file.parent) / f"{file.stem}-dem", (".h", ".csv"), [file])
    begin_curves("export", [solution], [(w,)], limits)
    from ..report import Exported

    law = Exported.of(analyse(solution, [w], slopes)[0])
    with together():
        write_text(targets[".h"], law.header)
        targets.write(law.columns)
    give(law, output.json, f"  written    {targets}")

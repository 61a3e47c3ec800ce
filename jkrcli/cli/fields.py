"""``jkr fields``: displacement and stress in the body at one state."""

from __future__ import annotations

from pathlib import Path
from typing import cast

import click

from ..base import atomic, together
from ..beside import analyse
from ..case import Case
from ..report import COMPONENTS, PICTURES, Fields, Output
from .mesh import MARKS
from .options import State, into_folder, output_options, state_options
from .series import body_and_work
from .verb import verb
from .voice import give


@verb("file")
@state_options
@click.option("--component", type=click.Choice(COMPONENTS), default="zz", show_default=True,
              help="Stress in the picture; the .vtu holds all.")  # fmt: skip
@into_folder()
@output_options(plots="Write .vtu and .csv only.", json="Print the summary as JSON.")
def fields(file: Path, state: State, component: str, output: Output) -> None:
    """Displacement and stress in the body of FILE, a case or a series, at one state of adhesive contact, by finite
    elements.

    The field of the nonadhesive contact and of the flat punch of the same radius, superposed, on a mesh graded towards
    the contact's edge, whatever method wrote the series. Writes <stem>-fields.vtu (ParaView), .csv (tractions on the
    surface, every interface and the base, with their estimated error), .png and .svg.

    \b
    jkr fields data.h5 --a "5 um"
    jkr fields coating.h5 --load "-10 uN" --w "40 mJ/m^2" --component rr
    """
    state.refuse_wrong("fields")
    output.folder(Path())
    file, solution, w = body_and_work("fields", file, state.work)
    targets = output.files(output.folder(file.parent) / f"{file.stem}-fields", (".vtu", ".csv", *PICTURES), [file])
    from ..case import fem_of

    method = fem_of(cast(Case, solution.record.case).model)
    result = Fields.of(analyse(solution, [w])[0], method, a=state.radius, load=state.load, component=component)
    figure = targets.draw(result.figure)
    with together():
        with atomic(targets[".vtu"]) as temporary:
            result.write_vtu(temporary, MARKS[".vtu"])
        targets.write(result.columns, figure=figure)
    give(result, output.json, f"  written      {targets}")

"""``jkr compare``: two results of the same problem."""

from __future__ import annotations

from pathlib import Path

import click

from ..base import InputError
from ..report import PICTURES, Compared, Output
from .measured import begin_reading
from .options import NumberRange, output_options
from .series import read_files
from .verb import verb
from .voice import give

COLUMNS = ("P", "a", "S", "dS")


@verb("first second")
@click.option("--rtol", type=NumberRange(min=0), default=1e-3, show_default=True, help="Largest relative difference.")
@click.option("--column", "columns", multiple=True, type=click.Choice(COLUMNS), help="What counts [default: P].")
@click.option("--overlap", type=NumberRange(0, 1), default=0.9, show_default=True, help="Least common range.")
@click.option("--plot", type=click.Path(path_type=Path), help="Draw the differences (.png or .svg).")
@output_options(force="Replace an existing plot that jkr did not write.", json="Print as JSON.")
@click.pass_context
def compare(
    ctx: click.Context, first: Path, second: Path, rtol: float, columns: tuple[str, ...], overlap: float,
    plot: Path | None, output: Output,
) -> None:  # fmt: skip
    """Compare two series files (P and a at equal displacement, S and S' at equal radius), or two CSV curves.

    Exit code 1 where a column that counts differs by more than --rtol (CSV curves: every shared column counts).

    \b
    jkr compare fem.h5 layered.h5 --rtol 1e-3
    jkr compare today.h5 yesterday.h5 --rtol 1e-12 --column P --column a
    """
    if plot is not None:
        if plot.suffix not in PICTURES:
            raise InputError(f"--plot: must end in .png or .svg, got {plot}")
        output.file(plot, [first, second])
    files = first, second
    if first.suffix == ".csv":
        begin_reading("compare", files)
    result = Compared.of(files, lambda: read_files("compare", files)[1], rtol, columns, overlap)
    give(result, output.json)
    if plot is not None:
        from ..report import plots

        plots.save(result.figure(), [plot])
    ctx.exit(0 if result.agree else 1)

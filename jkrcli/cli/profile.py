"""``jkr profile``: contact pressure and surface shape at one state."""

from __future__ import annotations

from pathlib import Path

import click

from ..adhesion import AskedRange
from ..base import InputError
from ..beside import profile_columns, radius_under
from ..methods import Limits
from ..report import PICTURES, Output, Profile
from .options import LengthType, LoadType, WorkType, limits_options, range_options
from .output import give, into_folder, output_options
from .series import begin_curves, first_work, read_series, series_file
from .verb import Verb


@click.command(cls=Verb)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--a", "radius", type=LengthType(), help='Contact radius, "2 um".')
@click.option("--load", type=LoadType(), help='Load, "-3 mN" (stable branch), compression positive.')
@click.option("--w", "work", type=WorkType(), help="Work of adhesion; 0: nonadhesive [default: the case's first].")
@range_options
@limits_options
@into_folder()
@output_options(json="Print the summary as JSON.")
def profile(
    file: Path,
    radius: float | None,
    load: float | None,
    work: float | None,
    stress: float | None,
    length: float | None,
    limits: Limits,
    output: Output,
) -> None:
    """Pressure p(r) inside and surface displacement and gap around the contact of FILE, a case or a series, at one
    state.

    The state is solved exactly on the laterally unbounded body of the file's case, whatever method wrote the series.
    Without slip it is solved by finite elements, with a column for the shear. With --stress or --range the
    surfaces attract each other around the contact, and the body is that of the file, cylinders too.
    Writes <stem>-profile.csv, .png and .svg.

    \b
    jkr profile data.h5 --a "5 um"
    jkr profile data.h5 --load "-10 uN" --w "50 mJ/m^2"
    """
    if (radius is None) == (load is None):
        raise InputError("profile: give exactly one of --a and --load")
    output.folder(Path())
    file = series_file(file)
    solution = read_series(file)
    w = first_work(solution) if work is None else work
    asked = AskedRange.of(solution.record, stress, length)
    stem = output.folder(file.parent) / f"{file.stem}-profile{asked.suffix}"
    targets = output.files(stem, (".csv", *PICTURES), [file])
    if radius is None:
        assert load is not None
        begin_curves("profile", [solution], [(w,)], [asked], limits)
        radius = radius_under(solution, load, w, asked)
    result = Profile(file, radius, w, profile_columns(solution, radius, w, asked))
    targets.write(result.columns, figure=result.figure())
    give(result, output.json, f"  written {targets}")

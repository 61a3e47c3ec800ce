"""``jkr profile``: contact pressure and surface shape at one state."""

from __future__ import annotations

from pathlib import Path

from ..beside import profile_columns, radius_under
from ..methods import Limits
from ..report import PICTURES, Output, Profile
from .options import RangeOptions, State, into_folder, limits_options, output_options, range_options, state_options
from .series import begin_curves, body_and_work
from .verb import verb
from .voice import give


@verb("file")
@state_options
@range_options
@limits_options
@into_folder()
@output_options(json="Print the summary as JSON.")
def profile(file: Path, state: State, attraction: RangeOptions, limits: Limits, output: Output) -> None:
    """Pressure p(r) inside and surface displacement and gap around the contact of FILE, a case or a series, at one
    state.

    The state is solved on the body of the file's case, whatever method wrote the series; the surface of a cylinder is
    shown to half-way to its side. Without slip it is solved by finite elements, with a column for the shear. With
    --stress or --range the surfaces attract each other around the contact.
    Writes <stem>-profile.csv, .png and .svg.

    \b
    jkr profile data.h5 --a "5 um"
    jkr profile data.h5 --load "-10 uN" --w "50 mJ/m^2"
    """
    state.refuse_wrong("profile")
    output.folder(Path())
    file, solution, w = body_and_work("profile", file, state.work, ranged=True)
    ranged, radius = attraction.of(solution), state.radius
    stem = output.folder(file.parent) / f"{file.stem}-profile{ranged.suffix}"
    targets = output.files(stem, (".csv", *PICTURES), [file])
    if radius is None:
        assert state.load is not None
        begin_curves("profile", [solution], [(w,)], limits, [ranged])
        radius = radius_under(solution, state.load, w, ranged)
    result = Profile(file, radius, w, profile_columns(solution, radius, w, ranged))
    targets.write(result.columns, figure=result.figure())
    give(result, output.json, f"  written {targets}")

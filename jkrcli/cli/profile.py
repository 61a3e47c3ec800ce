"""``jkr profile``: contact pressure and surface shape at one state."""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from ..adhesion.analysis import analyse
from ..adhesion.stability import stable_radius
from ..base.errors import InputError
from ..base.units import show
from ..bodies.problem import Problem
from ..methods.layered.fields import profile as solve_profile
from ..methods.layered.layered import unbounded
from ..report.output import PICTURES, Output
from ..report.plots.body import profile_figure
from .options import LengthType, LoadType, WorkType
from .output import into_folder, output_options
from .series import read_series
from .voice import say


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--a", "radius", type=LengthType(), help='Contact radius, "2 um".')
@click.option("--load", type=LoadType(), help='Load, "-3 mN" (stable branch), compression positive.')
@click.option("--w", "work", type=WorkType(), help="Work of adhesion; 0: nonadhesive [default: the case's first].")
@into_folder()
@output_options()
def profile(file: Path, radius: float | None, load: float | None, work: float | None, output: Output) -> None:
    """Pressure p(r) inside and surface displacement and gap around the contact of a series FILE, at one state.

    The state is solved exactly on the laterally unbounded body of the file's case, whatever method wrote the series.
    Writes <stem>-profile.csv, .png and .svg.

    \b
    jkr profile data.h5 --a "5 um"
    jkr profile data.h5 --load "-10 mN" --w 50
    """
    if (radius is None) == (load is None):
        raise InputError("profile: give exactly one of --a and --load")
    solution = read_series(file)
    w = work if work is not None else (solution.record.w or (0.0,))[0]
    targets = output.files(output.folder(file.parent) / f"{file.stem}-profile", (".csv", *PICTURES), [file])
    if radius is None:
        assert load is not None
        radius = stable_radius(analyse(solution, [w])[0].curve, load)
    columns = _columns(unbounded(solution.problem), radius, w)
    targets.write(columns, figure=profile_figure(columns, radius, w))
    say(f"{file}: a = {show(radius, 'length')}, w = {show(w, 'work')}")
    say(f"  written {targets}")


def _columns(problem: Problem, a: float, w: float, points: int = 200) -> dict[str, np.ndarray]:
    """Pressure, displacement and gap at radii that crowd on both sides of the edge, out to 3 a; none at the edge."""
    inside = a * np.sin(np.linspace(0, np.pi / 2, points + 2)[1:-1])
    outside = a * (1 + 2 * np.linspace(0, 1, points + 1)[1:] ** 2)
    outside = outside[outside <= problem.indenter.r_max]
    r = np.concatenate([inside, outside])
    found = solve_profile(problem, a, w, inside, r)
    return {
        "r_m": r,
        "pressure_Pa": np.concatenate([found.pressure, 0 * outside]),
        "displacement_m": found.displacement,
        "gap_m": found.gap,
    }

"""``jkr profile``: contact pressure and surface shape at one state."""

from __future__ import annotations

from pathlib import Path
from typing import cast

import click
import numpy as np

from ..adhesion.law import AskedRange, Range
from ..adhesion.stability import stable_radius
from ..base.errors import InputError
from ..base.units import show
from ..beside.analysis import analyse
from ..bodies.problem import Problem
from ..case import Case
from ..methods.guards import Limits
from ..methods.layered.fields import profile as solve_profile
from ..methods.layered.layered import unbounded
from ..report.output import PICTURES, Output
from ..report.plots.body import profile_figure
from ..series import Solution
from .options import LengthType, LoadType, WorkType, limits_options, range_options
from .output import into_folder, output_options
from .series import begin_curves, first_work, read_series, series_file
from .verb import Verb
from .voice import say


@click.command(cls=Verb)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--a", "radius", type=LengthType(), help='Contact radius, "2 um".')
@click.option("--load", type=LoadType(), help='Load, "-3 mN" (stable branch), compression positive.')
@click.option("--w", "work", type=WorkType(), help="Work of adhesion; 0: nonadhesive [default: the case's first].")
@range_options
@limits_options
@into_folder()
@output_options()
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
    Of surfaces that stick it is solved by finite elements, with a column for the shear. With --stress or --range the
    surfaces attract each other around the contact, and the body is that of the file, cylinders too.
    Writes <stem>-profile.csv, .png and .svg.

    \b
    jkr profile data.h5 --a "5 um"
    jkr profile data.h5 --load "-10 uN" --w "50 mJ/m^2"
    """
    if (radius is None) == (load is None):
        raise InputError("profile: give exactly one of --a and --load")
    file = series_file(file)
    solution = read_series(file)
    w = first_work(solution) if work is None else work
    asked = AskedRange.of(solution.record, stress, length)
    stem = output.folder(file.parent) / f"{file.stem}-profile{asked.suffix}"
    targets = output.files(stem, (".csv", *PICTURES), [file])
    if radius is None:
        assert load is not None
        begin_curves("profile", [solution], [(w,)], [asked], limits)
        curve = analyse(solution, [w], asked=asked)[0].curve
        radius = curve.point(stable_radius(curve, load)).a
    columns = _attracted(solution, radius, asked.law(w)) if asked else _of_jkr(solution, radius, w)
    targets.write(columns, figure=profile_figure(columns, radius, w))
    say(f"{file}: a = {show(radius, 'length')}, w = {show(w, 'work')}")
    say(f"  written {targets}")


def _of_jkr(solution: Solution, a: float, w: float) -> dict[str, np.ndarray]:
    return _stuck(solution, a, w) if solution.problem.sticks else _columns(unbounded(solution.problem), a, w)


def _attracted(solution: Solution, a: float, law: Range) -> dict[str, np.ndarray]:
    """Pressure, displacement and gap out to 3 c under a tension of finite range; the tension is a negative pressure."""
    from ..adhesion.finite_range import FiniteRangeBody
    from ..methods.integral.annulus import attracted_surface

    held = FiniteRangeBody.of(solution).body
    problem, s = held.problem, 2 * law.stress / held.problem.E_star
    if not 0 < a <= solution.series.a[-1] * (1 + 1e-9):
        end = show(float(solution.series.a[-1]), "length")
        raise InputError(f"profile: the contact radius must lie between 0 and {end}, got {show(a, 'length')}")
    attraction = held.attraction(min(3 * held.reach(a, s, law.length), held.limit))
    inside = a * np.sin(np.linspace(0, np.pi / 2, 202)[1:-1])
    outside = a + (attraction.reach - a) * np.linspace(0, 1, 202)[1:-1] ** 2
    r = np.concatenate([inside, outside])
    found = attracted_surface(attraction, a, law.stress, law.length, r, held.scale)
    displacement = found.rims.delta[0] - problem.indenter.f(r) + found.gap
    if problem.indenter.material is not None:
        displacement -= problem.E_star / problem.indenter.material.E_star * found.own
    return {"r_m": r, "pressure_Pa": found.pressure, "displacement_m": displacement, "gap_m": found.gap}


def _stuck(solution: Solution, a: float, w: float) -> dict[str, np.ndarray]:
    """Pressure and shear at the nodes inside, displacement and gap at the vertices from the edge out to 3 a; outwards
    positive."""
    from ..case.numerics import fem_of
    from ..methods.fem.state import contact_state

    curve = analyse(solution, [w])[0].curve
    delta, _ = (float(value) for value in curve.at(np.array(a)))
    state = contact_state(fem_of(cast(Case, solution.record.case).model), solution.problem, a, delta)
    points, line = state.grid.points, state.lines["surface"]
    beyond = np.flatnonzero((np.abs(points[:, 1]) <= 1e-12 * a) & (a <= points[:, 0]) & (points[:, 0] <= 3 * a))
    beyond = beyond[np.argsort(points[beyond, 0], kind="stable")]
    inside = line.r < a * (1 - 1e-9)
    r, none = np.concatenate([line.r[inside], points[beyond, 0]]), np.zeros(beyond.size)
    f, lower = solution.problem.indenter.f(r), -state.displacement[beyond, 1]
    displacement = np.concatenate([(delta - f)[: -none.size], lower])
    return {
        "r_m": r,
        "pressure_Pa": np.concatenate([-line.zz[inside], none]),
        "shear_Pa": np.concatenate([line.rz[inside], none]),
        "displacement_m": displacement,
        "gap_m": np.where(r < a, 0.0, f - delta + displacement),
    }


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

"""``jkr fields``: displacement and stress in the body at one state."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import click
import numpy as np

from ..adhesion.stability import stable_radius
from ..base.errors import InputError
from ..base.files import atomic, together
from ..base.units import show
from ..beside.analysis import analyse
from ..case import Case
from ..report.output import PICTURES, Files, Output
from .mesh import MARKS
from .options import LengthType, LoadType, WorkType
from .output import answer, into_folder, output_options
from .series import first_work, read_series, series_file, without_range
from .verb import Verb
from .voice import present

if TYPE_CHECKING:
    from ..bodies.problem import Problem
    from ..methods.fem.state import ContactState


@click.command(cls=Verb)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--a", "radius", type=LengthType(), help='Contact radius, "2 um".')
@click.option("--load", type=LoadType(), help='Load, "-3 mN" (stable branch), compression positive.')
@click.option("--w", "work", type=WorkType(), help="Work of adhesion; 0: nonadhesive [default: the case's first].")
@click.option("--component", type=click.Choice(["zz", "rr", "tt", "rz", "mises"]), default="zz", show_default=True,
              help="Stress in the picture; the .vtu holds all.")  # fmt: skip
@into_folder()
@output_options(plots="Write .vtu and .csv only.", json="Print the summary as JSON.")
def fields(
    file: Path,
    radius: float | None,
    load: float | None,
    work: float | None,
    component: str,
    output: Output,
) -> None:
    """Displacement and stress in the body of FILE, a case or a series, at one state of adhesive contact, by finite
    elements.

    The field of the nonadhesive contact and of the flat punch of the same radius, superposed, on a mesh graded towards
    the contact's edge, whatever method wrote the series. Writes <stem>-fields.vtu (ParaView), .csv (tractions on the
    surface, every interface and the base, with their estimated error), .png and .svg.

    \b
    jkr fields data.h5 --a "5 um"
    jkr fields coating.h5 --load "-10 uN" --w "40 mJ/m^2" --component rr
    """
    if (radius is None) == (load is None):
        raise InputError("fields: give exactly one of --a and --load")
    file = series_file(file)
    solution = read_series(file)
    without_range(solution.record, "fields")
    w = first_work(solution) if work is None else work
    targets = output.files(output.folder(file.parent) / f"{file.stem}-fields", (".vtu", ".csv", *PICTURES), [file])
    from ..case.numerics import fem_of
    from ..methods.fem.state import contact_state

    result = analyse(solution, [w])[0]
    if radius is None:
        assert load is not None
        radius = stable_radius(result.curve, load)
    delta, P = (float(value) for value in result.curve.at(np.array(radius)))
    P = P if load is None else load  # but for round-off
    method = fem_of(cast(Case, solution.record.case).model)
    problem = result.problem
    state = contact_state(method, problem, radius, delta, _surface(problem, radius, w))
    figure = None
    if output.plots:
        from ..report.plots.body import contact_zone_figure

        figure = contact_zone_figure(state, problem.indenter, w, component)
    with together():
        _write_vtu(state, targets[".vtu"])
        targets.write(tractions(state), figure=figure)
    summary = _summary(file, w, P, state)
    if output.json:
        answer(summary)
    else:
        _print(file, w, state, summary, targets)


def _surface(problem: Problem, a: float, w: float) -> Callable[[np.ndarray], np.ndarray] | None:
    """What an elastic indenter leaves of the displacement on a layered body, from the pressures of method layered; None
    where it is rigid, or acts by the modulus alone."""
    from ..methods.layered.fields import profile

    if problem.indenter.material is None or problem.specimen.is_half_space:
        return None
    return lambda r: profile(problem, a, w, r_surface=r).displacement


def _write_vtu(state: ContactState, target: Path) -> None:
    from ..methods.fem.mesh import write_vtu

    flat = np.zeros(len(state.displacement))
    data = {"displacement_m": np.column_stack([state.displacement, flat])}
    data |= {f"sigma_{name}_Pa": values for name, values in zip(("rr", "tt", "zz", "rz"), state.stress, strict=True)}
    with atomic(target) as temporary:
        write_vtu(state.grid, temporary, data | {"von_mises_Pa": state.mises})
        with temporary.open("a") as file:
            file.write(MARKS[".vtu"])


def tractions(state: ContactState) -> dict[str, np.ndarray]:
    """Columns of the CSV file: one row for each point of each line."""
    lines = state.lines.items()
    columns = {
        "line": np.concatenate([np.full(line.r.size, name) for name, line in lines]),
        "depth_m": np.concatenate([np.full(line.r.size, line.depth) for _, line in lines]),
    }
    names = {"r": "r_m", "zz": "sigma_zz_Pa", "rz": "sigma_rz_Pa"}
    names |= {"zz_error": "sigma_zz_err_Pa", "rz_error": "sigma_rz_err_Pa", "area": "ring_area_m2"}
    return columns | {
        column: np.concatenate([getattr(line, key) for _, line in lines]) for key, column in names.items()
    }


def _summary(file: Path, w: float, P: float, state: ContactState) -> dict[str, Any]:
    return {
        "file": str(file),
        "a_m": state.a,
        "w_J_per_m2": w,
        "delta_m": state.delta,
        "P_N": state.P,
        "P_series_N": P,
        "difference": abs(state.P - P) / state.lines["surface"].size,
        "elements": len(state.grid.cells),
        "lines": {
            name: {"depth_m": line.depth, "load_N": line.load, "imbalance": state.imbalance[name],
                   "error": state.error[name]}
            for name, line in state.lines.items()
        },
    }  # fmt: skip


def _print(file: Path, w: float, state: ContactState, summary: dict[str, Any], written: Files) -> None:
    end = f"P = {show(state.P, 'load')}, a = {show(state.a, 'length')}, delta = {show(state.delta, 'length')}"
    lines = [f"{end}, w = {show(w, 'work')}: {file}"]
    lines.append(
        f"  load         of the series {show(summary['P_series_N'], 'load')}: "
        f"{summary['difference']:.0e} of the forces in the contact apart; {summary['elements']} elements"
    )
    for name, line in summary["lines"].items():
        lines.append(
            f"  {name:<12} carries {show(line['load_N'], 'load'):<10} (balance within {abs(line['imbalance']):.0e}); "
            f"tractions good to {line['error']:.0e} on average"
        )
    present(lines, last=f"  written      {written}")

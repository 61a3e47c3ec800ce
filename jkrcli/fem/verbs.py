"""Verbs of finite elements: ``mesh`` and ``fields``."""

from __future__ import annotations

from pathlib import Path

import click

from .. import __version__
from ..base.errors import InputError
from ..base.files import atomic, together
from ..cli import inputs, options
from ..cli.printing import announce, give
from ..methods.protocol import Limits
from ..report.result import PICTURES, Output

# --------------------------------------------------------------------------------------------------
# ``jkr mesh``: the finite-element mesh of a case, for other programs and for the eye.

# What tells jkr that it wrote a file, where the format keeps comments.
MARKS = {".msh": f"$Comments\njkr {__version__}\n$EndComments\n", ".vtu": f"\n<!-- jkr {__version__} -->\n"}


@options.verb("case")
@options.into_folder("Folder.", default=".", show_default=True)
@options.limits_options
@options.output_options(json="Print the summary as JSON.")
def mesh(case: Path, limits: Limits, output: Output) -> None:
    """Mesh CASE as method fem would and write <stem>-mesh.msh (gmsh), .vtu (ParaView) and .png.

    \b
    jkr mesh cases/halfspace.toml
    """
    from ..case.models import load_case, method_of
    from .mesh import write_msh, write_vtu
    from .report import Meshed
    from .solver import FEM

    model = load_case(case).model
    problem = model.problem()
    targets = output.files(output.folder(Path()) / f"{case.stem}-mesh", (*MARKS, ".png"), [case])
    method = method_of(model, "fem")
    assert isinstance(method, FEM)
    options.begin("method fem on this mesh", method.forecast(problem), limits)
    result = Meshed(case, method.mesh(problem), method.reach(problem))
    with together():
        for ending, write in ((".msh", write_msh), (".vtu", write_vtu)):
            with atomic(targets[ending]) as temporary:
                write(result.mesh, temporary)
                with temporary.open("a") as file:
                    file.write(MARKS[ending])
        targets.write(figure=result.figure())
    give(result, output.json, f"  written   {targets}")


# --------------------------------------------------------------------------------------------------
# ``jkr fields``: displacement and stress in the body at one state.

COMPONENTS = ("zz", "rr", "tt", "rz", "mises")


@options.verb("file")
@options.state_options
@click.option("--component", type=click.Choice(COMPONENTS),
              help="Stress in the picture [default: zz]; the .vtu holds all.")  # fmt: skip
@options.into_folder()
@options.output_options(plots="Write .vtu and .csv only.", json="Print the summary as JSON.")
def fields(file: Path, state: options.State, component: str | None, output: Output) -> None:
    """Compute displacement and stress in the specimen of FILE, a case or a solution, at one state of adhesive contact,
    by finite elements.

    The adhesive field is the sum of nonadhesive contact and a flat punch of the same radius. The mesh is graded
    towards the contact edge. The results are <stem>-fields.vtu (ParaView), .csv (tractions on the surface, every
    interface and the base, with their errors), .png and .svg.

    \b
    jkr fields data.h5 --a "5 um"
    jkr fields coating.h5 --load "-10 uN" --w "40 mJ/m^2" --component rr
    """
    state.refuse_wrong("fields")
    if component is not None and not output.plots:
        raise InputError("fields: --component has no effect with --no-plots, it says what is drawn: leave one out")
    output.folder(Path())
    file, solution, w = inputs.body_and_work("fields", file, state.work)
    targets = output.files(output.folder(file.parent) / f"{file.stem}-fields", (".vtu", ".csv", *PICTURES), [file])
    from ..resolve.analysis import analyse
    from .fields import seconds_of_state
    from .report import Fields, method_for

    announce("fields by finite elements", seconds_of_state(solution.problem))
    curve, component = analyse(solution, [w])[0], component or "zz"
    result = Fields.of(curve, method_for(solution), a=state.radius, load=state.load, component=component)
    figure = targets.draw(result.figure)
    with together():
        with atomic(targets[".vtu"]) as temporary:
            result.write_vtu(temporary, MARKS[".vtu"])
        targets.write(result.columns, figure=figure)
    give(result, output.json, f"  written      {targets}")

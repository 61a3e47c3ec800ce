"""``jkr mesh``: the finite-element mesh of a case, for other programs and for the eye."""

from __future__ import annotations

from pathlib import Path

from .. import __version__
from ..base import atomic, together
from ..case import fem_of, load_case
from ..methods import Limits, write_msh, write_vtu
from ..report import Meshed, Output
from .options import begin, into_folder, limits_options, output_options
from .verb import verb
from .voice import give

# What tells jkr that it wrote a file, where the format keeps comments.
MARKS = {".msh": f"$Comments\njkr {__version__}\n$EndComments\n", ".vtu": f"\n<!-- jkr {__version__} -->\n"}


@verb("case")
@into_folder("Folder.", default=".", show_default=True)
@limits_options
@output_options(json="Print the summary as JSON.")
def mesh(case: Path, limits: Limits, output: Output) -> None:
    """Mesh CASE as method fem would and write <stem>-mesh.msh (gmsh), .vtu (ParaView) and .png.

    \b
    jkr mesh cases/halfspace.toml
    """
    model = load_case(case).model
    problem = model.problem()
    targets = output.files(output.folder(Path()) / f"{case.stem}-mesh", (*MARKS, ".png"), [case])
    method = fem_of(model)
    begin("method fem on this mesh", method.forecast(problem), limits)
    result = Meshed(case, method.mesh(problem), method.reach(problem))
    with together():
        for ending, write in ((".msh", write_msh), (".vtu", write_vtu)):
            with atomic(targets[ending]) as temporary:
                write(result.mesh, temporary)
                with temporary.open("a") as file:
                    file.write(MARKS[ending])
        targets.write(figure=result.figure())
    give(result, output.json, f"  written   {targets}")

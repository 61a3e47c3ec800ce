"""``jkr mesh``: the finite-element mesh of a case, for other programs and for the eye."""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from .. import __version__
from ..base import atomic, show, together
from ..case import load_case
from ..case.numerics import fem_of
from ..methods.fem.mesh import write_msh, write_vtu
from ..methods.guards import Limits
from ..report.output import Output
from ..report.plots.body import mesh_figure
from .options import begin, limits_options
from .output import into_folder, output_options
from .verb import Verb
from .voice import present

# What tells jkr that it wrote a file, where the format keeps comments.
MARKS = {".msh": f"$Comments\njkr {__version__}\n$EndComments\n", ".vtu": f"\n<!-- jkr {__version__} -->\n"}


@click.command(cls=Verb)
@click.argument("case", type=click.Path(path_type=Path))
@into_folder("Folder.", default=".", show_default=True)
@limits_options
@output_options()
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
    grid, reach = method.mesh(problem), method.reach(problem)
    with together():
        for ending, write in ((".msh", write_msh), (".vtu", write_vtu)):
            with atomic(targets[ending]) as temporary:
                write(grid, temporary)
                with temporary.open("a") as file:
                    file.write(MARKS[ending])
        targets.write(figure=mesh_figure(grid, reach))
    quality = grid.quality()
    touched = int(np.sum(grid.surface_radii() <= reach))
    present([
        f"{len(grid.cells)} {grid.element}s, {len(grid.points)} vertices: {case}",
        f"  body      r <= {show(grid.width, 'length')}, depth {show(grid.depth, 'length')}; "
        f"{touched} surface vertices within the expected contact of {show(reach, 'length')}",
        f"  quality   {quality.min():.3f} to {quality.max():.3f}, median {np.median(quality):.3f} (1 is best)",
    ], last=f"  written   {targets}")  # fmt: skip

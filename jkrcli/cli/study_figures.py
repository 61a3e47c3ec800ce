"""``jkr study figures``: the paper's result figures from the shipped cases."""

from __future__ import annotations

from pathlib import Path

import click

from ..base.files import check_target, make_folder
from ..data.foreign import read_measured
from ..many.study.figures import FIGURES
from ..report import plots
from .options import Length

ENDINGS = (".png", ".svg")


@click.command("figures")
@click.option("--cases", type=click.Path(path_type=Path, file_okay=False), default=Path("cases"), show_default=True,
              help="Folder with halfspace.toml, thin-layer.toml and gel.toml.")  # fmt: skip
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False), default=Path(), help="Folder.")
@click.option("--only", "names", multiple=True, type=click.Choice(list(FIGURES)), help="This figure [default: all].")
@click.option("--measured", type=click.Path(path_type=Path), help="Points for fig8: displacement and load, with units.")
@click.option("--shift", type=Length(), default=0.0, help="Added to the measured displacements (unknown zero).")
@click.option("--force", is_flag=True, help="Replace existing files that jkr did not write.")
def study_figures(
    cases: Path, output: Path, names: tuple[str, ...], measured: Path | None, shift: float, force: bool
) -> None:
    """Compute and draw the figures of the paper: half-space, thin layer, gel, and the influence of the mesh.

    Writes fig5, fig7, fig8, fig10 as .png and .svg. Numerical curves are by finite elements; lines are exact.

    \b
    jkr study figures -o results/figures
    jkr study figures --only fig8 --measured points.csv --shift "12 um"
    """
    points = None if measured is None else read_measured(measured, shift)
    wanted = names or tuple(FIGURES)
    make_folder(output)
    for name in wanted:
        for ending in ENDINGS:
            check_target(output / f"{name}{ending}", force)
    for name in wanted:
        figure = FIGURES[name](cases, points)
        for ending in ENDINGS:
            plots.save(figure, output / f"{name}{ending}")
        click.echo(f"written {output / name}{{{','.join(ENDINGS)}}}")

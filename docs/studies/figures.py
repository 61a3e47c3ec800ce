"""The paper's result figures (5, 7, 8 and 10) computed anew, each with the exact solution in it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from jkrcli.adhesion.curve import AdhesiveCurve, transform
from jkrcli.adhesion.slopes.choice import slopes
from jkrcli.adhesion.slopes.result import Slopes
from jkrcli.base.arrays import Array
from jkrcli.base.errors import InputError
from jkrcli.base.units import scale, show
from jkrcli.bodies.problem import Loading, Problem
from jkrcli.case import load_case
from jkrcli.case.numerics import method_of
from jkrcli.data.measured import read
from jkrcli.formulas import half_space, thin_layer
from jkrcli.many.study.converge import converge
from jkrcli.many.study.converge_figure import COLORS, curves_panel, radius_panel
from jkrcli.methods.fem.method import FEM
from jkrcli.methods.layered.layered import Layered
from jkrcli.report import PICTURES
from jkrcli.report.plots import Figure
from jkrcli.report.plots.looks import BLACK, BLUE, GREEN, ORANGE, pretty
from jkrcli.report.plots.study import Line, Panel, panels_figure
from jkrcli.report.scaling import Scales, scales_of
from jkrcli.series import Series

from .command import call, output_of, parser_of, quantity

Measured = tuple[Array, Array]  # displacement [m], load [N]
UNNAMED = "_nolegend_"  # label of a line that the legend leaves out
Drawn = tuple[str, str, str, Array, tuple[Measured, Measured]]  # label, style, colour, radii [m], without and with w


@dataclass(frozen=True, eq=False)
class Solved:
    """A case by finite elements and exactly (``layered``), both transformed for any w."""

    problem: Problem
    works: tuple[float, ...]
    method: FEM
    series: Series
    slopes: Slopes
    exact_series: Series

    @classmethod
    def of(cls, path: Path) -> Solved:
        """The case at ``path`` in the layout of the paper's meshes: uniform elements over the contact."""
        model = load_case(path).model
        if not model.adhesion.w:
            raise InputError(f"{path}: adhesion.w: is required for a figure")
        problem, method = model.problem(), method_of(model, "fem")
        assert isinstance(method, FEM)
        method = replace(method, layout="zones", estimate_error=False)
        series = method(problem).series
        to_the_end = Loading("radius", float(series.a[-1]), 200)
        exact = Layered()(replace(problem, loading=to_the_end)).series
        return cls(problem, model.adhesion.w, method, series, slopes(series), exact)

    def numerical(self, w: float) -> AdhesiveCurve:
        return transform(self.series, self.slopes, w)

    def exact(self, w: float) -> AdhesiveCurve:
        return transform(self.exact_series, slopes(self.exact_series, "exact"), w)


def half_space_figure(case: Path) -> Figure:
    """Fig. 5: load over displacement and radius over load in the units of Eq. 15, against Hertz and JKR."""
    solved = Solved.of(case)
    problem, w = solved.problem, solved.works[0]
    scales, exact = scales_of(problem, w, "half-space"), solved.exact(w)
    a, R = np.linspace(0, solved.series.a[-1], 400), problem.indenter.tip_radius
    assert R is not None
    hertz, jkr = half_space.hertz(a, problem.E_star, R), half_space.jkr(a, problem.E_star, R, w)
    shape = type(problem.indenter).__name__.lower()
    references: list[Drawn] = [
        ("Hertz and JKR (paraboloid)", "-", BLACK, a, (hertz, jkr)),
        (f"exact ({shape})", ":", GREEN, exact.a, _pairs(exact)),
    ]
    return panels_figure(_two_panels(solved, w, scales, references))


def thin_layer_figure(case: Path) -> Figure:
    """Fig. 7: the same in the units of Eq. 19, against the leading order (Eqs. 20, 21) and the exact layer."""
    solved = Solved.of(case)
    w = solved.works[0]
    scales, exact = scales_of(solved.problem, w, "thin-layer"), solved.exact(w)
    a_bar = np.linspace(0, solved.series.a[-1] / scales.a, 400)
    delta_bar, P_bar = thin_layer.thin_layer_dimensionless(a_bar)
    leading = (a_bar**2 * scales.delta, a_bar**4 * scales.P), (delta_bar * scales.delta, P_bar * scales.P)
    references: list[Drawn] = [
        ("leading order (Eqs. 20, 21)", "--", GREEN, a_bar * scales.a, leading),
        ("exact layer", "-", BLACK, exact.a, _pairs(exact)),
    ]
    return panels_figure(_two_panels(solved, w, scales, references))


def gel_figure(case: Path, measured: Measured | None = None) -> Figure:
    """Fig. 8: load over displacement for every w of the case, whole and near pull-off, and the ``measured`` points."""
    solved = Solved.of(case)
    curves = [solved.numerical(w) for w in solved.works]
    delta_unit, delta_name = scale(float(np.max(np.abs(curves[0].delta))), "length")
    P_unit, P_name = scale(float(np.max(np.abs(curves[0].P))), "load")
    lines = [Line(solved.series.delta / delta_unit, solved.series.P / P_unit, "nonadhesive", "--", BLACK)]
    lowest = [0.0, 0.0]
    for curve, color in zip(curves, COLORS, strict=False):
        exact = solved.exact(curve.w)
        delta, P = exact.delta / delta_unit, exact.P / P_unit
        words = f"w = {pretty(show(curve.w, 'work'))}"
        lines.append(Line(curve.delta / delta_unit, curve.P / P_unit, words, "o", color))
        lines.append(Line(delta, P, UNNAMED if lowest[1] else "exact layer", "-", color))
        lowest = [min(lowest[0], float(delta.min())), min(lowest[1], float(P.min()))]
    if measured is not None:
        lines.append(Line(measured[0] / delta_unit, measured[1] / P_unit, "measured", "x", BLACK))
    whole = Panel(f"displacement δ ({pretty(delta_name)})", f"load P ({pretty(P_name)})", lines)
    unnamed = [replace(line, label=UNNAMED) for line in lines]
    near = replace(
        whole, lines=unnamed, xlim=(1.1 * lowest[0], -2 * lowest[0]), ylim=(1.3 * lowest[1], -1.3 * lowest[1])
    )
    return panels_figure([whole, near])


def mesh_figure(cases: Sequence[Path]) -> Figure:
    """Fig. 10: for each case the node-based contact radius over the element size, and the adhesive curves."""
    studies = []
    for case in cases:
        model = load_case(case).model
        method = method_of(model, "fem")
        assert isinstance(method, FEM)
        paper = replace(method, layout="zones", contact="incremental")
        studies.append(converge(model.problem(), paper, model.adhesion.w[0], 5))
    panels = [panel for study in studies for panel in (radius_panel(study), curves_panel(study))]
    titles = [case.stem for case in cases for _ in range(2)]
    return panels_figure([replace(panel, title=title) for panel, title in zip(panels, titles, strict=True)])


FIGURES: dict[str, Callable[[Path, Measured | None], Figure]] = {
    "fig5": lambda folder, _: half_space_figure(folder / "halfspace.toml"),
    "fig7": lambda folder, _: thin_layer_figure(folder / "thin-layer.toml"),
    "fig8": lambda folder, measured: gel_figure(folder / "gel.toml", measured),
    "fig10": lambda folder, _: mesh_figure([folder / "halfspace.toml", folder / "thin-layer.toml"]),
}


def _pairs(curve: AdhesiveCurve) -> tuple[Measured, Measured]:
    """Displacement and load without and with adhesion."""
    return (curve.series.delta, curve.series.P), (curve.delta, curve.P)


def _two_panels(solved: Solved, w: float, scales: Scales, references: Sequence[Drawn]) -> list[Panel]:
    """Load over displacement and radius over load: the numbers as points, the references as lines."""
    load, radius = [], []

    def add(delta: Array, P: Array, a: Array, *look: str) -> None:
        load.append(Line(delta / scales.delta, P / scales.P, *look))
        radius.append(Line(P / scales.P, a / scales.a, *look))

    curve = solved.numerical(w)
    add(solved.series.delta, solved.series.P, curve.a, "finite elements", "o", BLUE)
    add(curve.delta, curve.P, curve.a, "adhesive, from finite elements", "o", ORANGE)
    for words, style, color, a, pairs in references:
        for (delta, P), name in zip(pairs, (words, UNNAMED), strict=True):
            add(delta, P, a, name, style, color)
    labels = scales.labels
    return [Panel(labels[0], labels[1], load), Panel(labels[1], labels[2], radius)]


def main(words: Sequence[str] | None = None) -> int:
    """Compute and draw the figures of the paper: half-space, thin layer, gel, and the influence of the mesh.

    Writes fig5, fig7, fig8, fig10 as .png and .svg. Numerical curves are by finite elements; lines are exact.
    """
    parser = parser_of(str(main.__doc__), parallel=False)
    parser.add_argument("--cases", type=Path, default=Path("cases"), help="folder of the cases [default: cases]")
    parser.add_argument("--only", action="append", choices=list(FIGURES), help="this figure")
    parser.add_argument("--measured", type=Path, help="points for fig8: displacement and load, with units")
    parser.add_argument("--shift", type=quantity("length"), default=0.0, help="added to the measured displacements")
    given = parser.parse_args(words)
    curves = [] if given.measured is None else read(given.measured)
    points = next(((curve.depth + given.shift, curve.load) for curve in curves), None)
    output = output_of(given)
    files = {name: output.files(given.output / name, PICTURES) for name in given.only or FIGURES}
    for name, file in files.items():
        file.write(figure=FIGURES[name](given.cases, points))
        print(f"written {file}")
    return 0


if __name__ == "__main__":
    sys.exit(call(main))

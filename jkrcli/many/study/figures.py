"""The paper's result figures (5, 7, 8 and 10) computed anew, each with the exact solution in it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...adhesion.curve import AdhesiveCurve, transform
from ...adhesion.slopes.choice import slopes
from ...adhesion.slopes.result import Slopes
from ...base.arrays import Array
from ...base.errors import InputError
from ...base.units import scale, show
from ...bodies.materials import Elastic
from ...bodies.problem import Loading, Problem
from ...case import load_case
from ...case.numerics import method_of
from ...data.foreign import read_measured
from ...formulas import half_space, thin_layer
from ...formulas.scales import scales_half_space, scales_thin_layer
from ...methods.fem.method import FEM
from ...methods.layered.layered import Layered
from ...report.output import PICTURES
from ...report.plots import BLACK, BLUE, GREEN, ORANGE, pretty
from ...report.plots.study import UNNAMED, Figure, Line, Panel, panels_figure
from ...series import Series
from .command import call, output_of, parser_of, quantity
from .converge import Convergence, converge

COLORS = (ORANGE, BLUE, GREEN, "#CC79A7", "#56B4E9", "#E69F00", "#F0E442")
Measured = tuple[Array, Array]  # displacement [m], load [N]


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
    problem, w, R = solved.problem, solved.works[0], _tip_radius(solved.problem, case)
    units = scales_half_space(R, problem.E_star, w)
    a = np.linspace(0, solved.series.a[-1], 400)
    hertz, jkr = half_space.hertz(a, problem.E_star, R), half_space.jkr(a, problem.E_star, R, w)
    references = [("Hertz and JKR (paraboloid)", "-", BLACK, a, hertz, jkr)]
    exact = solved.exact(w)
    pairs = (exact.series.delta, exact.series.P), (exact.delta, exact.P)
    references.append((f"exact ({type(problem.indenter).__name__.lower()})", ":", GREEN, exact.a, *pairs))
    labels = ("δ / δ₀  (Eq. 15)", "P / (π w R)", "a / a₀  (Eq. 15)")
    return panels_figure(_two_panels(solved, w, units, labels, references))


def thin_layer_figure(case: Path) -> Figure:
    """Fig. 7: the same in the units of Eq. 19, against the leading order (Eqs. 20, 21) and the exact layer."""
    solved = Solved.of(case)
    problem, w, R = solved.problem, solved.works[0], _tip_radius(solved.problem, case)
    material = problem.specimen.materials[0]
    if not problem.specimen.layers or not isinstance(material, Elastic) or material.nu >= 0.5:
        raise InputError(f"{case}: specimen: Fig. 7 needs a homogeneous layer with nu < 0.5 (Eq. 22)")
    K = thin_layer.foundation_modulus(material.E, material.nu, problem.specimen.top_thickness)
    P_unit, delta_unit, a_unit = scales_thin_layer(R, K, w)
    a_bar = np.linspace(0, solved.series.a[-1] / a_unit, 400)
    delta_bar, P_bar = thin_layer.thin_layer_dimensionless(a_bar)
    leading = (
        (a_bar**2 * delta_unit, a_bar**4 * P_unit),
        (delta_bar * delta_unit, P_bar * P_unit),
    )
    exact = solved.exact(w)
    references = [
        ("leading order (Eqs. 20, 21)", "--", GREEN, a_bar * a_unit, *leading),
        ("exact layer", "-", BLACK, exact.a, (exact.series.delta, exact.series.P), (exact.delta, exact.P)),
    ]
    labels = ("δ / √(2w/K)", "P / (2 π w R)", "a / (8 w R²/K)^¼")
    return panels_figure(_two_panels(solved, w, (P_unit, delta_unit, a_unit), labels, references))


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
    return panels_figure([replace(panel, title=title) for panel, title in zip(panels, _doubled(cases), strict=True)])


def convergence_figure(study: Convergence) -> Figure:
    """Contact radius over element size, adhesive curves, errors, and what the meshes cost."""
    return panels_figure([radius_panel(study), curves_panel(study), errors_panel(study), cost_panel(study)])


FIGURES: dict[str, Callable[[Path, Measured | None], Figure]] = {
    "fig5": lambda folder, _: half_space_figure(folder / "halfspace.toml"),
    "fig7": lambda folder, _: thin_layer_figure(folder / "thin-layer.toml"),
    "fig8": lambda folder, measured: gel_figure(folder / "gel.toml", measured),
    "fig10": lambda folder, _: mesh_figure([folder / "halfspace.toml", folder / "thin-layer.toml"]),
}


# ---------------------------------------------------------------------- panels
def radius_panel(study: Convergence) -> Panel:
    """Contact radius at the depth of the study over the element size."""
    unit, name = scale(study.levels[-1].state.a, "length")
    sizes, label = _sizes(study)
    lines = [Line(sizes, np.array(study.values("a"), dtype=float) / unit, "finite elements", "o-", ORANGE)]
    if study.exact is not None:
        lines.append(Line(sizes, np.full(sizes.size, study.exact.a / unit), "exact", "--", BLACK))
    return Panel(label, f"contact radius a ({pretty(name)})", lines, logs="x")


def curves_panel(study: Convergence) -> Panel:
    """Adhesive load over displacement of every mesh."""
    held = [(level, level.state.curve) for level in study.levels if level.state.curve is not None]
    if not held:
        raise InputError("convergence: no mesh is fine enough for an adhesive curve: give finer meshes")
    finest = held[-1][1]
    delta_unit, delta_name = scale(float(np.max(np.abs(finest.delta))), "length")
    P_unit, P_name = scale(float(np.max(np.abs(finest.P))), "load")
    lines = [
        Line(
            curve.delta / delta_unit, curve.P / P_unit, f"elements {pretty(show(level.size, 'length', 3))}", "o", color
        )
        for (level, curve), color in zip(held, COLORS * len(held), strict=False)
    ]
    if study.exact is not None and study.exact.curve is not None:
        exact = study.exact.curve
        lines.append(Line(exact.delta / delta_unit, exact.P / P_unit, "exact", "-", BLACK))
    return Panel(f"displacement δ ({pretty(delta_name)})", f"load P ({pretty(P_name)})", lines)


def errors_panel(study: Convergence) -> Panel:
    """Relative errors over the element size."""
    sizes, label = _sizes(study)
    lines = []
    for name, words, color in (("a", "a", ORANGE), ("P", "P", BLUE), ("pull_off", "pull-off force", GREEN)):
        errors = study.errors(name)
        there = np.array([error not in (None, 0.0) for error in errors])
        if there.any():
            values = np.abs(np.array([error for error in errors if error not in (None, 0.0)], dtype=float))
            lines.append(Line(sizes[there], values, words, "o-", color))
    against = "the exact value" if study.exact is not None else "the extrapolated value"
    return Panel(label, f"difference to {against}", lines, logs="xy")


def cost_panel(study: Convergence) -> Panel:
    """Points kept and unknowns over the element size."""
    sizes, label = _sizes(study)
    kept = np.array([level.kept for level in study.levels], dtype=float)
    unknowns = np.array([level.unknowns for level in study.levels], dtype=float)
    lines = [Line(sizes, kept, "points kept", "o-", ORANGE), Line(sizes, unknowns, "unknowns", "s--", BLUE)]
    return Panel(label, "number", lines, logs="xy")


def _two_panels(
    solved: Solved,
    w: float,
    units: tuple[float, float, float],
    labels: tuple[str, str, str],
    references: Sequence[tuple[str, str, str, Array, Measured, Measured]],
) -> list[Panel]:
    """Load over displacement and radius over load: the numbers as points, the references as lines."""
    P_unit, delta_unit, a_unit = units
    curve = solved.numerical(w)
    load, radius = [], []
    for (delta, P), words, color in (
        ((solved.series.delta, solved.series.P), "finite elements", BLUE),
        ((curve.delta, curve.P), "adhesive, from finite elements", ORANGE),
    ):
        load.append(Line(delta / delta_unit, P / P_unit, words, "o", color))
        radius.append(Line(P / P_unit, curve.a / a_unit, words, "o", color))
    for words, style, color, a, *pairs in references:
        for (delta, P), name in zip(pairs, (words, UNNAMED), strict=True):
            load.append(Line(delta / delta_unit, P / P_unit, name, style, color))
            radius.append(Line(P / P_unit, a / a_unit, name, style, color))
    return [Panel(labels[0], labels[1], load), Panel(labels[1], labels[2], radius)]


def _sizes(study: Convergence) -> tuple[Array, str]:
    sizes = np.array([level.size for level in study.levels])
    unit, name = scale(float(sizes[0]), "length")
    return sizes / unit, f"element size at the contact edge ({pretty(name)})"


def _tip_radius(problem: Problem, case: Path) -> float:
    R = problem.indenter.tip_radius
    if R is None:
        raise InputError(f"{case}: indenter: this figure needs a tip radius (sphere or paraboloid)")
    return R


def _doubled(cases: Sequence[Path]) -> list[str]:
    return [case.stem for case in cases for _ in range(2)]


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
    points = None if given.measured is None else read_measured(given.measured, given.shift)
    output = output_of(given)
    files = {name: output.files(given.output / name, PICTURES) for name in given.only or FIGURES}
    for name, file in files.items():
        file.write(figure=FIGURES[name](given.cases, points))
        print(f"written {file}")
    return 0


if __name__ == "__main__":
    sys.exit(call(main))

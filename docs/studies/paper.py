"""The paper by its own method: figures 5, 7, 8 and 10, and a table of its numbers beside ours and the exact ones.

Uniform linear quadrilaterals, increments of depth, radii of the outermost node in contact, the paper's filter, splines
and cross-validation (its Sec. 3, Fig. 2, App. B): the cases of ``cases/paper``.
"""

from __future__ import annotations

import itertools
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from jkrcli import formulas
from jkrcli.adhesion.curve import AdhesiveCurve, CriticalPoint, transform
from jkrcli.adhesion.rules import slopes_function
from jkrcli.base.errors import InputError, Unknown
from jkrcli.base.numerics import Array
from jkrcli.base.units import scale, show
from jkrcli.bodies.problem import Loading, Problem
from jkrcli.case.models import load_case, method_of
from jkrcli.fem.solver import FEM
from jkrcli.many.figures import Line, Panel, panels_figure
from jkrcli.many.studies import COLORS, converge, curves_panel, radius_panel
from jkrcli.measured.files import read
from jkrcli.methods.layered.solver import Layered
from jkrcli.report.plots import BLACK, BLUE, GREEN, ORANGE, Figure, pretty
from jkrcli.report.result import PICTURES
from jkrcli.report.tables import Scales, scales_of
from jkrcli.resolve.analysis import Analysis, analyse
from jkrcli.series import Series, Solution

from .command import call, output_of, parser_of, quantity

Measured = tuple[Array, Array]  # displacement [m], load [N]
PAPERS = "loocv-kept"  # the rule of the paper's examples
DEFAULT = "default"  # what ``jkr transform`` does without --slopes
RULES_SHOWN = (PAPERS, "loocv", "gcv", DEFAULT)
SIZES = {"half-space": 5e-7, "thin-layer": 2e-8, "gel": 7.2e-6}  # of linear elements with as many vertices [m]
Z0 = 0.3e-9  # the paper's interatomic distance [m]
UNNAMED = "_nolegend_"  # label of a line that the legend leaves out
Drawn = tuple[str, str, str, Array, tuple[Measured, Measured]]  # label, style, colour, radii [m], without and with w


@dataclass(frozen=True, eq=False)
class Solved:
    """A case by its own finite elements and exactly (``layered``), both transformed for any w."""

    name: str
    problem: Problem
    works: tuple[float, ...]
    solution: Solution
    seconds: float
    exact_series: Series

    @classmethod
    def of(cls, path: Path, reduced: bool = False) -> Solved:
        """Solve the case at ``path``; ``reduced``: with elements integrated at one point, as the paper's CAX4R."""
        model = load_case(path).model
        if not model.adhesion.w:
            raise InputError(f"{path}: adhesion.w: is required for a figure")
        problem, method = model.problem(), method_of(model, "fem")
        assert isinstance(method, FEM)
        name = path.stem
        if reduced:
            method, name = (
                replace(method, order=1, integration="reduced", element_size=SIZES[path.stem]),
                f"{name}, CAX4R",
            )
        start = time.process_time()
        solution = method(problem)
        seconds = time.process_time() - start
        to_the_end = Loading("radius", float(solution.series.a[-1]), 200)
        exact = Layered()(replace(problem, loading=to_the_end)).series
        return cls(name, problem, model.adhesion.w, solution, seconds, exact)

    @property
    def series(self) -> Series:
        """The nonadhesive solution after the paper's filter."""
        return self.solution.filtered

    def numerical(self, w: float, rule: str = PAPERS) -> AdhesiveCurve:
        return transform(self.series, slopes_function(rule)(self.series), w)

    def exact(self, w: float) -> AdhesiveCurve:
        return transform(self.exact_series, slopes_function("exact")(self.exact_series), w)

    def analysed(self, w: float, rule: str) -> Analysis:
        """What ``jkr transform`` makes of the increments by the ``rule``."""
        return analyse(self.solution, [w], "auto" if rule == DEFAULT else rule)[0]


def half_space_figure(solved: Solved) -> Figure:
    """Fig. 5: load over displacement and radius over load in the units of Eq. 15, against Hertz and JKR."""
    problem, w = solved.problem, solved.works[0]
    scales, exact = scales_of(problem, w, "half-space"), solved.exact(w)
    a, R = np.linspace(0, solved.series.a[-1], 400), problem.indenter.tip_radius
    assert R is not None
    hertz, jkr = formulas.hertz(a, problem.E_star, R), formulas.jkr(a, problem.E_star, R, w)
    shape = type(problem.indenter).__name__.lower()
    references: list[Drawn] = [
        ("Hertz and JKR (paraboloid)", "-", BLACK, a, (hertz, jkr)),
        (f"exact ({shape})", ":", GREEN, exact.a, _pairs(exact)),
    ]
    return panels_figure(_two_panels(solved, w, scales, references))


def thin_layer_figure(solved: Solved) -> Figure:
    """Fig. 7: the same in the units of Eq. 19, against the leading order (Eqs. 20, 21) and the exact layer."""
    w = solved.works[0]
    scales, exact = scales_of(solved.problem, w, "thin-layer"), solved.exact(w)
    a_bar = np.linspace(0, solved.series.a[-1] / scales.a, 400)
    delta_bar, P_bar = formulas.thin_layer_dimensionless(a_bar)
    leading = (a_bar**2 * scales.delta, a_bar**4 * scales.P), (delta_bar * scales.delta, P_bar * scales.P)
    references: list[Drawn] = [
        ("leading order (Eqs. 20, 21)", "--", GREEN, a_bar * scales.a, leading),
        ("exact layer", "-", BLACK, exact.a, _pairs(exact)),
    ]
    return panels_figure(_two_panels(solved, w, scales, references))


def gel_figure(solved: Solved, measured: Measured | None = None) -> Figure:
    """Fig. 8: load over displacement for every w of the case, whole and near pull-off, and the ``measured`` points."""
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
        lines.append(Line(delta, P, UNNAMED, "-", color))
        lowest = [min(lowest[0], float(delta.min())), min(lowest[1], float(P.min()))]
    nowhere = np.array([np.nan])
    lines.append(Line(nowhere, nowhere, "exact layer, in the colour of w", "-", "0.5"))
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
        studies.append(converge(model.problem(), method, model.adhesion.w[0], 5, "loocv"))
    panels = [panel for study in studies for panel in (radius_panel(study), curves_panel(study))]
    titles = [case.stem.replace("thin-layer", "thin layer") for case in cases for _ in range(2)]
    return panels_figure([replace(panel, title=title) for panel, title in zip(panels, titles, strict=True)])


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
    add(curve.delta, curve.P, curve.a, "adhesive, by the paper's method", "o", ORANGE)
    for words, style, color, a, pairs in references:
        for (delta, P), name in zip(pairs, (words, UNNAMED), strict=True):
            add(delta, P, a, name, style, color)
    labels = scales.labels
    return [Panel(labels[0], labels[1], load), Panel(labels[1], labels[2], radius)]


# ---------------------------------------------------------------------- the table
@dataclass(frozen=True)
class Row:
    """The pull-off force [N] of a case under load control by one rule for slopes, and the exact one; ``error`` and
    ``stated``: its relative error, and that which the rule states; ``reason``: why there is no force."""

    case: str
    w: float
    rule: str
    kept: int
    increments: int
    force: float | None
    exact: float
    stated: float | None
    reason: str = ""

    @property
    def error(self) -> float | None:
        return None if self.force is None else self.force / self.exact - 1


def table(solved: Solved) -> Iterator[Row]:
    """Pull-off by the paper's method, S kept or re-evaluated, by GCV, and by the default of ``jkr transform``."""
    for w in solved.works:
        exact = solved.exact(w).pull_off(0.0)
        assert isinstance(exact, CriticalPoint)
        for rule in RULES_SHOWN:
            counts = len(solved.series), solved.solution.increments.a.size
            try:
                result = solved.analysed(w, rule)
                point, half_widths = result.pull_off["load"], result.pull_off_errors.get("load")
            except InputError as error:
                yield Row(solved.name, w, rule, *counts, None, exact.P, None, error.lines[0])
                continue
            if not isinstance(point, CriticalPoint):
                yield Row(solved.name, w, rule, *counts, None, exact.P, None, point.reason)
                continue
            stated = None
            if half_widths is not None and not isinstance(half_widths, Unknown):
                stated = half_widths["P"] / abs(point.P)
            yield Row(solved.name, w, rule, *counts, point.P, exact.P, stated)


def numbers(solved: Mapping[str, Solved]) -> list[tuple[str, str, str]]:
    """What the paper prints, its number, and ours."""
    rows = []
    for name, section, tabor, cells in (("half-space", "4.1", 639, 414_599), ("thin-layer", "4.2", 471, 75_000)):
        one = solved.get(f"{name}-full-mesh") or solved.get(name)
        if one is None:
            continue
        R = one.problem.indenter.tip_radius
        assert R is not None
        ours = formulas.tabor(R, one.works[0], one.problem.E_star, Z0)
        rows.append((f"Tabor number, Sec. {section}", f"{tabor}", f"{ours:.0f}"))
        rows.append((f"elements, Sec. {section}", f"{cells:,}", f"{one.solution.facts['elements']:,}"))
        rows.append((f"increments, Sec. {section}", "100", str(one.solution.increments.a.size)))
    return rows


def words_of(rows: Sequence[Row]) -> Iterator[str]:
    """The table as lines: a case and a w each, with the error of every rule, and the stated one of the default."""
    yield (
        f"{'case':<24}{'w':>12}{'radii':>9}{'exact':>11}"
        + "".join(f"{rule:>13}" for rule in RULES_SHOWN)
        + f"{'stated':>9}"
    )
    for (case, w), group in itertools.groupby(rows, lambda row: (row.case, row.w)):
        each = list(group)
        shown = "".join(f"{'none' if row.error is None else f'{round(row.error, 4) + 0.0:+.2%}':>13}" for row in each)
        stated = next((f"{row.stated:.2%}" for row in each if row.rule == DEFAULT and row.stated is not None), "-")
        kept = f"{each[0].kept}/{each[0].increments}"
        yield f"{case:<24}{show(w, 'work'):>12}{kept:>9}{show(each[0].exact, 'load'):>11}{shown}{stated:>9}"


FIGURES = ("fig5", "fig7", "fig8", "fig10")


def main(words: Sequence[str] | None = None) -> int:
    """Compute the paper's cases by the paper's method: figures 5, 7, 8 and 10, and a table of its numbers.

    Writes fig5, fig7, fig8, fig10 as .png and .svg, and paper.csv: pull-off forces by the paper's splines (S kept, S
    re-evaluated, GCV) and by the default of jkr transform, beside the exact ones. Points are by finite elements, lines
    are exact. "CAX4R" are the same meshes of linear quadrilaterals integrated at one point. The measured points of
    Fig. 8 belong to its Ref. 73 and are not shipped: give yours by --measured.
    """
    parser = parser_of(str(main.__doc__), parallel=False)
    parser.add_argument("--cases", type=Path, default=Path("cases/paper"), help="their folder [default: cases/paper]")
    parser.add_argument("--only", action="append", choices=FIGURES, help="this figure, and no table")
    parser.add_argument("--full-mesh", action="store_true", help="Sec. 4.1 on its 400,000 elements too")
    parser.add_argument("--measured", type=Path, help="points for fig8: displacement and load, with units")
    parser.add_argument("--shift", type=quantity("length"), default=0.0, help="added to the measured displacements")
    given = parser.parse_args(words)
    curves = [] if given.measured is None else read(given.measured)
    points = next(((curve.depth + given.shift, curve.load) for curve in curves), None)
    output, cases, wanted = output_of(given), given.cases, given.only or FIGURES
    files = {name: output.files(given.output / name, PICTURES) for name in wanted} if output.plots else {}
    written = None if given.only else output.files(given.output / "paper", (".csv",))

    solved = dict[str, Solved]()
    names = {"fig5": "half-space", "fig7": "thin-layer", "fig8": "gel"}
    first = [names[name] for name in wanted if name in names]
    for name in [*first, *(["half-space-full-mesh"] if given.full_mesh else [])]:
        if name.endswith("full-mesh"):
            print("  half-space-full-mesh: 400,000 elements, about 35 s of CPU time and 5 GiB", flush=True)
        solved[name] = Solved.of(cases / f"{name}.toml")
        print(
            f"  {name}: {solved[name].solution.facts['elements']:,} elements, {solved[name].seconds:.1f} s CPU",
            flush=True,
        )

    for name, file in files.items():
        if name == "fig5":
            file.write(figure=half_space_figure(solved.get("half-space-full-mesh") or solved["half-space"]))
        elif name == "fig7":
            file.write(figure=thin_layer_figure(solved["thin-layer"]))
        elif name == "fig8":
            file.write(figure=gel_figure(solved["gel"], points))
        else:
            file.write(figure=mesh_figure([cases / "half-space.toml", cases / "thin-layer.toml"]))
        print(f"written {file}", flush=True)
    if written is not None:
        reduced = [Solved.of(cases / f"{name}.toml", reduced=True) for name in names.values()]
        rows = [row for one in (*solved.values(), *reduced) for row in table(one)]
        columns = ("case", "w", "rule", "kept", "increments", "force", "exact", "error", "stated", "reason")
        written.write({name: [getattr(row, name) for row in rows] for name in columns})
        print(*words_of(rows), sep="\n")
        print(*(f"{what:<24}paper {theirs:>9}   here {ours:>9}" for what, theirs, ours in numbers(solved)), sep="\n")
        print(f"written {written}")
    return 0


if __name__ == "__main__":
    sys.exit(call(main))

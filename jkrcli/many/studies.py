"""Studies of accuracy and cost: convergence over meshes, and where the time of a run goes."""

from __future__ import annotations

import itertools
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from ..adhesion.curve import AdhesiveCurve, CriticalPoint, transform
from ..base.errors import Estimate, InputError, SolveError, Unknown
from ..base.executors import Pool, in_order
from ..base.numerics import Array
from ..base.process import StageClock
from ..base.registry import Result
from ..base.units import show
from ..bodies.problem import Problem
from ..case.models import Case
from ..case.store import solve, write_solution
from ..methods.layered.solver import Layered
from ..report import tables
from ..report.plots import BLACK, BLUE, GREEN, ORANGE, axis_of
from ..report.result import Figure
from ..series import RawSeries, Series, Solution
from .figures import Line, Panel, panels_figure

# --------------------------------------------------------------------------------------------------
# What a sequence of meshes tells: values on each, errors, observed orders, limits.

# The sequence of meshes, and what differences between them mean something.
MESHES_RATIO = 2.0  # theory: of element sizes from mesh to mesh, which halve
MESHES_COARSEST_SPACING = 0.49  # theory: below the limit of the mesher, half
MESHES_STEEPEST_GROWTH = 0.59  # theory: below the limit of the mesher, 0.6
MESHES_ROUND_OFF = 1e-12  # theory: some thousand times machine epsilon, relative


WORDS = {"a": "contact radius", "P": "load", "pull_off": "pull-off force"}
DIMENSIONS = {"a": "length", "P": "load", "pull_off": "load"}


@dataclass(frozen=True, eq=False)
class State:
    """What is compared at the depth of the study: contact radius ``a`` [m], load ``P`` [N], and the pull-off under load
    control on the ``curve``, which is unknown where the series has too few points for slopes."""

    a: float
    P: float
    curve: AdhesiveCurve | Unknown

    @cached_property
    def point(self) -> CriticalPoint | Unknown:
        return self.curve if isinstance(self.curve, Unknown) else self.curve.pull_off(0.0)

    @property
    def values(self) -> dict[str, float | None]:
        """The quantities by name, a [m], P and the pull-off force [N]; None where that lies outside the series."""
        return {"a": self.a, "P": self.P, "pull_off": None if isinstance(self.point, Unknown) else self.point.P}


@dataclass(frozen=True, eq=False)
class ConvergenceLevel:
    """One mesh: ``size``: of the elements at the edge of the largest contact [m]; ``seconds``: CPU of the solve."""

    size: float
    state: State
    elements: int
    unknowns: int
    kept: int
    dropped: int
    seconds: float

    @property
    def cells(self) -> dict[str, Any]:
        """What table and summary say alike of the mesh."""
        state = self.state
        return {"size_m": self.size, "elements": self.elements, "unknowns": self.unknowns, "a_m": state.a,
                "P_N": state.P}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Convergence(Result):
    """A study of meshes from coarse to fine, all judged at ``depth`` [m]; ``exact``: of the wide body, if any."""

    problem: Problem
    w: float
    depth: float
    levels: tuple[ConvergenceLevel, ...]
    exact: State | None

    def values(self, quantity: str) -> list[float | None]:
        return [level.state.values[quantity] for level in self.levels]

    @cached_property
    def extrapolated(self) -> dict[str, tuple[float, float] | Unknown]:
        """Order and limit of Richardson's extrapolation, from the three finest meshes; else the reason."""
        return {quantity: richardson(self.values(quantity)) for quantity in WORDS}

    def order(self, quantity: str) -> Estimate:
        """Observed order: the slope of the errors over the sizes in logarithms, where an exact value is known; else
        the one of Richardson's extrapolation; else the reason why there is none."""
        limit = self.extrapolated[quantity]
        if self.exact is None:
            return limit if isinstance(limit, Unknown) else limit[0]
        pairs = [(level.size, abs(error)) for level, error in zip(self.levels, self.errors(quantity), strict=True)
                 if error is not None and abs(error) > MESHES_ROUND_OFF]  # fmt: skip
        if len(pairs) < 3:
            return Unknown("needs three meshes with an error above round-off")
        sizes, errors = np.log(np.array(pairs)).T
        return float(np.polyfit(sizes, errors, 1)[0])

    @property
    def time_exponent(self) -> float:
        """Slope of CPU seconds over unknowns in logarithms."""
        unknowns, seconds = np.log([(level.unknowns, level.seconds) for level in self.levels]).T
        return float(np.polyfit(unknowns, seconds, 1)[0])

    def errors(self, quantity: str) -> list[float | None]:
        """Relative differences of each mesh to the exact value, or else to the extrapolated one, or to the finest."""
        values, reference = self.values(quantity), self.reference(quantity)
        return [None if value is None or reference is None else value / reference - 1 for value in values]

    def reference(self, quantity: str) -> float | None:
        if self.exact is not None:
            return self.exact.values[quantity]
        limit = self.extrapolated[quantity]
        return self.values(quantity)[-1] if isinstance(limit, Unknown) else limit[1]

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        """A row per mesh; the pull-off cell is empty where it lies outside the series."""
        return tables.transpose_rows([
            level.cells | {"pull_off_P_N": level.state.values["pull_off"], "points_kept": level.kept,
                           "points_dropped": level.dropped, "cpu_s": level.seconds}
            for level in self.levels
        ])  # fmt: skip

    def summary(self) -> dict[str, Any]:
        """The meshes from coarse to fine, the exact values where there are some, the limits."""
        return {
            "format": "jkr-convergence",
            "version": 1,
            "problem": self.problem.words,
            "w_J_per_m2": self.w,
            "depth_m": self.depth,
            "levels": [
                level.cells | {"pull_off": tables.point(level.state.point),
                               "points": {"kept": level.kept, "dropped": level.dropped}, "cpu_s": level.seconds}
                for level in self.levels
            ],
            "exact": None if self.exact is None else {WORDS[name]: x for name, x in self.exact.values.items()},
            "extrapolated": {
                WORDS[name]: {"reason": limit} if isinstance(limit, Unknown) else {"order": limit[0], "value": limit[1]}
                for name, limit in self.extrapolated.items()
            },
            "order": {words: self.order(name) for name, words in WORDS.items()},
            "errors": {words: self.errors(name) for name, words in WORDS.items()},
            "time_exponent": self.time_exponent,
        }  # fmt: skip

    def words(self) -> list[str]:
        against = "the exact solution" if self.exact is not None else "the extrapolated value or the finest mesh"
        finest = [abs(error) for name in WORDS if (error := self.errors(name)[-1]) is not None]
        verdict = f"errors within {max(finest):.1e} of {against}" if finest else "no errors"
        orders = []
        for name in WORDS:
            order, limit = self.order(name), self.extrapolated[name]
            observed = f"no order: {order}" if isinstance(order, Unknown) else f"observed order {order:.2f}"
            if isinstance(limit, Unknown):
                told = f"not extrapolated: {limit}"
            else:
                told = f"extrapolated {show(limit[1], DIMENSIONS[name], 6)}"
            orders.append(f"  {WORDS[name]:<15} {observed}; {told}")
        rows = []
        for i, level in enumerate(self.levels):
            cells = ""
            for name in WORDS:
                value, error = self.values(name)[i], self.errors(name)[i]
                cells += f"{'none' if value is None else show(value, DIMENSIONS[name]):>12}"
                cells += f"{'':>9}" if error is None else f"{error:>+9.1e}"
            size = show(level.size, "length", 3)
            rows.append(
                f"  {size:>10}{level.elements:>10}{cells}{level.kept:>6}{level.dropped:>8}{level.seconds:>7.2f}"
            )
        return [
            f"elements of {show(self.levels[-1].size, 'length', 3)}: {verdict}",
            f"  body      {self.problem.words}",
            f"  at        delta = {show(self.depth, 'length')}, w = {show(self.w, 'work')}",
            *orders,
            f"  {'CPU seconds':<15} grow like the number of unknowns to the power {self.time_exponent:.2f}",
            f"  {'size':>10}{'elements':>10}{'a':>12}{'error':>9}{'P':>12}{'error':>9}{'pull-off':>12}{'error':>9}"
            f"{'kept':>6}{'dropped':>8}{'CPU s':>7}",
            *rows,
        ]

    @property
    def warnings(self) -> list[str]:
        points = ((show(level.size, "length", 3), level.state.point) for level in self.levels)
        return [f"elements of {size}: {point.reason}" for size, point in points if isinstance(point, Unknown)]

    def figure(self) -> Figure:
        return panels_figure([radius_panel(self), curves_panel(self), errors_panel(self), cost_panel(self)])


def richardson(values: Sequence[float | None]) -> tuple[float, float] | Unknown:
    """Observed order and limit of values on meshes that halve their sizes, from the last three; else why not."""
    last = values[-3:]
    if len(last) < 3 or any(value is None for value in last):
        return Unknown("needs three meshes with a value")
    first, second = (b - a for a, b in itertools.pairwise(last))  # type: ignore[operator]
    if abs(second) <= MESHES_ROUND_OFF * abs(last[-1]) or first / second <= 1:  # type: ignore[arg-type]
        return Unknown("the differences do not shrink from mesh to mesh")
    order = math.log(first / second) / math.log(MESHES_RATIO)
    return order, last[-1] + second / (MESHES_RATIO**order - 1)


# --------------------------------------------------------------------------------------------------
# Mesh convergence of a case (Appendix C): the same loading on a sequence of meshes with halved element sizes.


def converge(
    problem: Problem, method: Any, w: float, count: int, slopes_name: str = "auto", pool: Pool | None = None
) -> Convergence:
    """Solve ``problem`` on ``count`` meshes, the finest being that of ``method``, and transform for ``w`` [J/m^2].

    ``pool``: works on the meshes (default: this process).
    """
    method = replace(method, estimate_error=False, tolerance=None)
    factors = [MESHES_RATIO**k for k in reversed(range(count))]
    methods = [coarser(method, problem, factor) for factor in factors]
    meshes = in_order(pool, partial(_timed, problem), methods, "meshes")
    depth = min(float(solution.increments.delta[-1]) for solution, _, _ in meshes)
    largest = float(meshes[-1][0].series.a[-1])
    levels = []
    for solution, radii, seconds in meshes:
        series, facts = solution.series, solution.facts
        state = _state(solution.increments, series, slopes_name, w, depth)
        size = facts["elements"], facts["unknowns"], len(series), facts["dropped"]
        levels.append(ConvergenceLevel(spacing_at(radii, largest), state, *size, seconds))
    # The exact solution of the wide body down to depth; None where the body ends sideways
    loading = replace(problem.loading, to="depth", maximum=depth, points=200, spacing="radius", values=())
    same_depth = replace(problem, loading=loading)
    layered = Layered()
    if layered.refusal(same_depth) is not None:
        exact = None
    else:
        series = layered(same_depth).series
        exact = _state(series, series, "exact", w, depth)
    return Convergence(problem, w, depth, tuple(levels), exact)


def _timed(problem: Problem, method: Any) -> tuple[Solution, Array, float]:
    """A solution, its mesh's surface radii [m] and the CPU seconds it took."""
    start = time.thread_time()  # of this mesh alone, whatever else the process works on
    run, solution = method.solve(problem)
    return solution, run.level.model.system.grid.surface_radii(), time.thread_time() - start


def coarser(method: Any, problem: Problem, factor: float) -> Any:
    """The method with every element ``factor`` times as large, as far as the mesher's limits let it."""
    if factor == 1:
        return method
    growth = min(factor * method.growth_of_sizes, MESHES_STEEPEST_GROWTH)
    if method.layout == "scaled":
        spacing = factor * method.spacing
        if spacing > MESHES_COARSEST_SPACING:
            raise InputError(
                f"levels: the coarsest mesh would have mesh.spacing = {spacing:g}, at most "
                f"{MESHES_COARSEST_SPACING:g} is possible: take fewer levels or a finer mesh in the case"
            )
        return replace(method, spacing=spacing, growth=growth)
    zones = tuple(factor * size for size in method.zone_sizes)
    size = method.element_size if method.element_size is not None else edge_size(method, problem, 0.0)
    return replace(method, element_size=factor * size, zone_sizes=zones, growth=growth)


def edge_size(method: Any, problem: Problem, a: float) -> float:
    """Distance between the surface vertices on either side of the radius ``a`` [m] in the method's mesh."""
    return spacing_at(method.mesh(problem).surface_radii(), a)


def spacing_at(radii: Array, a: float) -> float:
    """Distance between the neighbours of ``a`` among ``radii`` [m]."""
    k = int(np.clip(np.searchsorted(radii, a), 1, radii.size - 1))
    return float(radii[k] - radii[k - 1])


def _state(rows: RawSeries | Series, series: Series, slopes_name: str, w: float, depth: float) -> State:
    """The state at ``depth`` [m]: load and radius (of increments that of a node) between ``rows`` in logarithms, and
    the adhesive curve of the ``series``, or why a mesh is too coarse for one."""
    at = math.log(depth * (1 + MESHES_ROUND_OFF))
    touching = rows.a > 0
    x = np.log(rows.delta[touching])
    load, radius = (math.exp(np.interp(at, x, np.log(column[touching]))) for column in (rows.P, rows.a))
    try:
        return State(radius, load, transform(series, slopes_name, w))
    except InputError as error:
        return State(radius, load, Unknown(error.lines[0]))


# --------------------------------------------------------------------------------------------------
# The figure of a convergence study: radius, curves, errors and cost over the number of unknowns.

UNKNOWNS = "unknowns"
COLORS = (ORANGE, BLUE, GREEN, "#CC79A7", "#56B4E9", "#E69F00", "#F0E442")


def radius_panel(study: Convergence) -> Panel:
    """Contact radius at the depth of the study over the number of unknowns."""
    unit, label = axis_of("a", study.levels[-1].state.a)
    unknowns = _unknowns(study)
    lines = [Line(unknowns, np.array(study.values("a"), dtype=float) / unit, "finite elements", "o-", ORANGE)]
    if study.exact is not None:
        lines.append(Line(unknowns, np.full(unknowns.size, study.exact.a / unit), "exact", "--", BLACK))
    return Panel(UNKNOWNS, label, lines, logs="x")


def curves_panel(study: Convergence) -> Panel:
    """Adhesive load over displacement of every mesh."""
    curves = [(level, level.state.curve) for level in study.levels if not isinstance(level.state.curve, Unknown)]
    if not curves:
        raise InputError("convergence: no mesh is fine enough for an adhesive curve: give finer meshes")
    finest = curves[-1][1]
    (delta_unit, delta_label), (P_unit, P_label) = axis_of("delta", finest.delta), axis_of("P", finest.P)
    lines = [
        Line(curve.delta / delta_unit, curve.P / P_unit, f"{level.unknowns:,} unknowns", "o", color)
        for (level, curve), color in zip(curves, COLORS * len(curves), strict=False)
    ]
    if study.exact is not None and not isinstance(study.exact.curve, Unknown):
        exact = study.exact.curve
        lines.append(Line(exact.delta / delta_unit, exact.P / P_unit, "exact", "-", BLACK))
    return Panel(delta_label, P_label, lines)


def errors_panel(study: Convergence) -> Panel:
    """Relative errors over the number of unknowns."""
    unknowns = _unknowns(study)
    lines = []
    for name, words, color in (("a", "a", ORANGE), ("P", "P", BLUE), ("pull_off", "pull-off force", GREEN)):
        shown = [(n, 100 * abs(error)) for n, error in zip(unknowns, study.errors(name), strict=True) if error]
        if shown:
            x, y = np.array(shown).T
            lines.append(Line(x, y, words, "o-", color))
    against = "the exact value" if study.exact is not None else "the extrapolated value"
    return Panel(UNKNOWNS, f"difference to {against} (%)", lines, logs="xy")


def cost_panel(study: Convergence) -> Panel:
    """Points kept and CPU seconds over the number of unknowns."""
    unknowns = _unknowns(study)
    counts = np.array([level.kept for level in study.levels], dtype=float)
    seconds = np.array([level.seconds for level in study.levels])
    points, time = Line(unknowns, counts, "points kept", "o-", ORANGE), Line(unknowns, seconds, "CPU time", "s--", BLUE)
    return Panel(UNKNOWNS, "points kept", [points], logs="xy", right=("CPU time (s)", time))


def _unknowns(study: Convergence) -> Array:
    """The axis of the study: it grows from mesh to mesh, while coarse meshes may share their largest element."""
    return np.array([level.unknowns for level in study.levels], dtype=float)


# --------------------------------------------------------------------------------------------------
# Where the time of a run goes: its stages, imports and the whole process, in CPU seconds.

# --------------------------------------------------------------------------------------------------
# What a command costs: CPU and wall time and peak memory of a whole process.

LAUNCHER = """
import os, subprocess, sys
code = subprocess.call(sys.argv[1:])
try:
    import resource
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
except ImportError:
    peak = "nan"
if code == 0:
    print(os.times().children_user + os.times().children_system, peak, file=sys.stderr)
sys.exit(code if code >= 0 else 1)
"""


@dataclass(frozen=True)
class Cost:
    """CPU seconds (user and system, descendants included), wall seconds, and peak memory [MiB] of the largest."""

    cpu_s: float
    wall_s: float
    memory_mib: float | None = None


def process_cost(command: Sequence[str], folder: Path | None = None, output: Path | None = None) -> Cost:
    """Run ``command`` in ``folder``, its standard output to ``output``; SolveError where it fails.

    A small process in between starts it: the peak memory of a process includes that of the one it was forked from.
    """
    start = time.perf_counter()
    with Path(os.devnull if output is None else output).open("wb") as sink:
        done = subprocess.run([sys.executable, "-S", "-c", LAUNCHER, *command], cwd=folder, stdout=sink,
                              stderr=subprocess.PIPE)  # fmt: skip
    wall = time.perf_counter() - start
    lines = done.stderr.decode(errors="replace").splitlines()
    if done.returncode != 0:
        words = " ".join(lines[-2:])[-300:]
        raise SolveError(f"{' '.join(command)}: ended with code {done.returncode}: {words}")
    cpu, kilobytes = map(float, lines[-1].split())
    return Cost(cpu, wall, None if math.isnan(kilobytes) else kilobytes / 1024)


IMPORTS = "import time; t = time.process_time(); import {}; print(time.process_time() - t)"
FEW = 3  # choice: imports and whole processes, which take longer than most runs


@dataclass(frozen=True, eq=False)
class Bench(Result):
    """CPU seconds of each of the ``stages`` of several runs of the case in ``file`` by a ``method``."""

    file: Path
    method: str
    repeat: int
    stages: Mapping[str, Sequence[float]]

    @classmethod
    def of(cls, file: Path, case: Case, method: str, module: str, repeat: int) -> Bench:
        """The stages of the ``case``, whose method stands in ``module``."""
        stages: dict[str, list[float]] = {"import": []}
        with tempfile.TemporaryDirectory() as folder:
            target, runs = Path(folder) / "series.h5", list[dict[str, float]]()
            for _ in range(repeat):  # solved in this process, all stages together, and written
                clock = StageClock()
                with clock("solve, total"):
                    _, solution = solve(case, method)
                with clock("write"):
                    write_solution(target, solution, "jkr bench")
                runs.append({**solution.timings, **clock.seconds})
            names = dict.fromkeys(key for run in runs for key in run)
            stages |= {stage: [run.get(stage, 0.0) for run in runs] for stage in names}

            # Imports of the command line, the case reader, the file format and the method, and all of `jkr run`, each
            # in a new process.
            needed = f"jkrcli.cli.case_verbs, {module}" + ", skfem, gmsh" * (".fem" in module)
            imports = [sys.executable, "-c", IMPORTS.format(needed)]
            command = [sys.executable, "-m", "jkrcli", "run", str(file.resolve()), "--method", method, "-o"]
            few = range(min(repeat, FEW))
            stages["import"] = [
                float(subprocess.run(imports, capture_output=True, text=True, check=True).stdout) for _ in few
            ]
            stages["whole process"] = [process_cost([*command, str(Path(folder) / f"{k}.h5")]).cpu_s for k in few]
        return cls(file, method, repeat, stages)

    def summary(self) -> dict[str, Any]:
        stages = {name: {"min_s": min(each), "median_s": median(each)} for name, each in self.stages.items()}
        return {"case": str(self.file), "method": self.method, "repeat": self.repeat, "stages": stages}

    def words(self) -> list[str]:
        whole, few = median(self.stages["whole process"]), min(self.repeat, FEW)
        return [
            f"{whole:.2f} s CPU by {self.method}: {self.file}; {self.repeat} runs, imports and whole process {few}",
            f"  {'stage':<18}{'min':>9}{'median':>9}",
            *(f"  {stage:<18}{min(each):>9.4f}{median(each):>9.4f}" for stage, each in self.stages.items()),
        ]

"""Mesh convergence of a case (Appendix C): the same loading on a sequence of meshes with halved element sizes."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from ...adhesion.curve import AdhesiveCurve, CriticalPoint, transform
from ...adhesion.slopes.choice import slopes
from ...base.arrays import Array
from ...base.errors import InputError
from ...base.executors import Pool, in_order
from ...base.unknown import Estimate, Unknown
from ...bodies.problem import Problem
from ...methods.fem.method import FEM
from ...methods.layered.layered import Layered
from ...series import Series, Solution

QUANTITIES = ("a", "P", "pull_off")


@dataclass(frozen=True)
class MeshesTuning:
    """The sequence of meshes, and what differences between them mean something."""

    ratio: float = 2.0  # choice: between the element sizes of neighbouring meshes
    coarsest_spacing: float = 0.49  # choice: limit of the mesher
    steepest_growth: float = 0.59  # choice: limit of the mesher
    round_off: float = 1e-12  # theory: some thousand times machine epsilon, relative


TUNING = MeshesTuning()


@dataclass(frozen=True, eq=False)
class State:
    """What is compared at the depth of the study: contact radius [m], load [N], pull-off under load control.

    ``curve``: None where the series has too few points for slopes; ``point`` then says so.
    """

    a: float
    P: float
    point: CriticalPoint | Unknown
    curve: AdhesiveCurve | None

    def value(self, quantity: str) -> float | None:
        """The quantity, a [m], P [N] or the pull-off force [N]; None where the pull-off lies outside the series."""
        if quantity == "pull_off":
            return self.point.P if isinstance(self.point, CriticalPoint) else None
        return float(getattr(self, quantity))


@dataclass(frozen=True, eq=False)
class Level:
    """One mesh: ``size``: of the elements at the edge of the largest contact [m]; ``seconds``: CPU of the solve."""

    size: float
    state: State
    elements: int
    unknowns: int
    kept: int
    dropped: int
    seconds: float


@dataclass(frozen=True, eq=False)
class Convergence:
    """Meshes from coarse to fine, all judged at ``depth`` [m]; ``exact``: of the wide body, None for a finite one."""

    problem: Problem
    w: float
    depth: float
    levels: tuple[Level, ...]
    exact: State | None

    def values(self, quantity: str) -> list[float | None]:
        return [level.state.value(quantity) for level in self.levels]

    @cached_property
    def extrapolated(self) -> dict[str, tuple[float, float] | Unknown]:
        """Order and limit of Richardson's extrapolation, from the three finest meshes; else the reason."""
        return {quantity: richardson(self.values(quantity)) for quantity in QUANTITIES}

    def order(self, quantity: str) -> Estimate:
        """Observed order: the slope of the errors over the sizes in logarithms, where an exact value is known; else
        the one of Richardson's extrapolation; else the reason why there is none."""
        limit = self.extrapolated[quantity]
        if self.exact is None:
            return limit if isinstance(limit, Unknown) else limit[0]
        pairs = [(level.size, abs(error)) for level, error in zip(self.levels, self.errors(quantity), strict=True)
                 if error is not None and abs(error) > TUNING.round_off]  # fmt: skip
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
        reference = self.reference(quantity)
        return [
            None if value is None or reference is None else value / reference - 1 for value in self.values(quantity)
        ]

    def reference(self, quantity: str) -> float | None:
        if self.exact is not None:
            return self.exact.value(quantity)
        limit = self.extrapolated[quantity]
        return self.values(quantity)[-1] if isinstance(limit, Unknown) else limit[1]


def converge(
    problem: Problem, method: FEM, w: float, count: int, slopes_name: str = "auto", pool: Pool | None = None
) -> Convergence:
    """Solve ``problem`` on ``count`` meshes, the finest being that of ``method``, and transform for ``w`` [J/m^2].

    ``pool``: works on the meshes (default: this process).
    """
    if count < 2:
        raise InputError(f"levels: must be >= 2 meshes, got {count}")
    method = replace(method, estimate_error=False, tolerance=None)
    factors = [TUNING.ratio**k for k in reversed(range(count))]
    methods = [coarser(method, problem, factor) for factor in factors]
    meshes = in_order(pool, partial(_timed, problem), methods, "meshes")
    depth = min(float(_increments(mesh.solution)[1][-1]) for mesh in meshes)
    largest = float(meshes[-1].solution.series.a[-1])
    levels = []
    for mesh in meshes:
        solution, facts = mesh.solution, mesh.solution.facts
        state = _state(*_increments(solution), _adhesive(solution.series, w, slopes_name), depth)
        levels.append(Level(spacing_at(mesh.radii, largest), state, facts["elements"], facts["unknowns"],
                            len(solution.series), facts["dropped"], mesh.seconds))  # fmt: skip
    return Convergence(problem, w, depth, tuple(levels), _exact(problem, w, depth))


@dataclass(frozen=True, eq=False)
class Timed:
    """A solution, its mesh's surface ``radii`` [m] and the CPU ``seconds`` it took."""

    solution: Solution
    radii: Array
    seconds: float


def _timed(problem: Problem, method: FEM) -> Timed:
    start = time.thread_time()  # of this mesh alone, whatever else the process works on
    run, solution = method.solve(problem)
    return Timed(solution, run.level.model.system.grid.surface_radii(), time.thread_time() - start)


def coarser(method: FEM, problem: Problem, factor: float) -> FEM:
    """The method with every element ``factor`` times as large, as far as the mesher's limits let it."""
    if factor == 1:
        return method
    growth = min(factor * method.growth_of_sizes, TUNING.steepest_growth)
    if method.layout == "scaled":
        spacing = factor * method.spacing
        if spacing > TUNING.coarsest_spacing:
            raise InputError(
                f"levels: the coarsest mesh would have mesh.spacing = {spacing:g}, at most "
                f"{TUNING.coarsest_spacing:g} is possible: take fewer levels or a finer mesh in the case"
            )
        return replace(method, spacing=spacing, growth=growth)
    zones = tuple(factor * size for size in method.zone_sizes)
    size = method.element_size if method.element_size is not None else edge_size(method, problem, 0.0)
    return replace(method, element_size=factor * size, zone_sizes=zones, growth=growth)  # type: ignore[arg-type]


def richardson(values: Sequence[float | None]) -> tuple[float, float] | Unknown:
    """Observed order and limit of values on meshes that halve their sizes, from the last three; else why not."""
    last = values[-3:]
    if len(last) < 3 or any(value is None for value in last):
        return Unknown("needs three meshes with a value")
    first, second = (b - a for a, b in itertools.pairwise(last))  # type: ignore[operator]
    if abs(second) <= TUNING.round_off * abs(last[-1]) or first / second <= 1:  # type: ignore[arg-type]
        return Unknown("the differences do not shrink from mesh to mesh")
    order = math.log(first / second) / math.log(TUNING.ratio)
    return order, last[-1] + second / (TUNING.ratio**order - 1)


def edge_size(method: FEM, problem: Problem, a: float) -> float:
    """Distance between the surface vertices on either side of the radius ``a`` [m] in the method's mesh."""
    return spacing_at(method.mesh(problem).surface_radii(), a)


def spacing_at(radii: Array, a: float) -> float:
    """Distance between the neighbours of ``a`` among ``radii`` [m]."""
    k = int(np.clip(np.searchsorted(radii, a), 1, radii.size - 1))
    return float(radii[k] - radii[k - 1])


def _increments(solution: Solution) -> tuple[Array, Array, Array]:
    """Columns a, delta, P in the order of loading: every increment where there are some."""
    rows = solution.raw if solution.raw is not None else solution.series
    return rows.a, rows.delta, rows.P


def _state(a: Array, delta: Array, P: Array, curve: AdhesiveCurve | Unknown, depth: float) -> State:
    """The state at ``depth`` [m]: load and radius (of increments that of a node) between rows in logarithms."""
    at = math.log(depth * (1 + TUNING.round_off))
    touching = a > 0
    x = np.log(delta[touching])
    load = math.exp(np.interp(at, x, np.log(P[touching])))
    radius = math.exp(np.interp(at, x, np.log(a[touching])))
    if isinstance(curve, Unknown):
        return State(radius, load, curve, None)
    return State(radius, load, curve.pull_off(0.0), curve)


def _adhesive(series: Series, w: float, slopes_name: str) -> AdhesiveCurve | Unknown:
    """The adhesive curve, or why a mesh is too coarse for one."""
    try:
        return transform(series, slopes(series, slopes_name), w)
    except InputError as error:
        return Unknown(error.lines[0])


def _exact(problem: Problem, w: float, depth: float) -> State | None:
    """The exact solution of the wide body down to ``depth``; None where the body ends sideways."""
    loading = replace(problem.loading, to="depth", maximum=depth, points=200, spacing="radius", values=())
    asked = replace(problem, loading=loading)
    method = Layered()
    if method.refusal(asked) is not None:
        return None
    series = method(asked).series
    return _state(series.a, series.delta, series.P, _adhesive(series, w, "exact"), depth)
